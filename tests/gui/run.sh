#!/usr/bin/env bash
# The add-on in a real window: Debian 13's Blender (4.3) under Xvfb, in a folder of its own. Installs the .zip as the
# preferences do, presses F12, Esc and the panels' buttons by xdotool, and leaves screenshots and a log to look at.
#
#     make addon && sudo tests/gui/run.sh [SCREENSHOTS]      SCREENSHOTS: a folder, out/gui by default
#
# Needs root and debootstrap (2 GB, made once under SUNDOG_GUI_DIR, /var/tmp/sundog-gui). Not part of `make test`: it takes
# minutes and a window system. Fails if one of the checks in session.py does.

# shellcheck source=../../scripts/lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/../../scripts/lib.sh"

here="$project_root/tests/gui"
shots=${1:-$project_root/out/gui}
place=${SUNDOG_GUI_DIR:-/var/tmp/sundog-gui}
root="$place/trixie"

[ "$(id -u)" -eq 0 ] || fail "this needs root, to mount and change root."
package=$(find "$project_root/dist" -name 'sundog-*-linux-x64.zip' 2>/dev/null | head -n 1)
[ -n "$package" ] || fail "there is no dist/sundog-*-linux-x64.zip: run 'make addon' first."

release() {
    local folder
    for folder in tmp/.X11-unix dev proc; do
        mountpoint -q "$root/$folder" && umount -l "$root/$folder"
    done
    return 0
}
trap release EXIT

if [ ! -e "$root/ready" ]; then
    have debootstrap || fail "debootstrap is needed: install it with apt."
    say "making a Debian 13 with Blender in $root"
    [ -d "$root/etc" ] || debootstrap --variant=minbase trixie "$root" >"$place.log" 2>&1 ||
        fail "debootstrap failed, see $place.log"
    cp /etc/resolv.conf "$root/etc/resolv.conf"
    mkdir -p "$root/usr/local/share/ca-certificates"
    cp /usr/local/share/ca-certificates/*.crt "$root/usr/local/share/ca-certificates/" 2>/dev/null || true
    chroot "$root" sh -c 'apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq \
        --no-install-recommends blender python3-numpy xvfb xauth imagemagick xdotool libgl1-mesa-dri procps' >>"$place.log" 2>&1 ||
        fail "Blender could not be installed in $root, see $place.log"
    touch "$root/ready"
fi
mkdir -p "$root/proc" "$root/dev" "$shots"
mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
mountpoint -q "$root/dev" || mount --bind /dev "$root/dev"

rm -rf "$root/session"
mkdir -p "$root/session/shots"
cp "$package" "$root/session/addon.zip"
cp "$here/session.sh" "$here/session.py" "$root/session/"
status=0
chroot "$root" env -i HOME=/session/home PATH=/usr/local/bin:/usr/bin:/bin LANG=C.UTF-8 LIBGL_ALWAYS_SOFTWARE=1 \
    bash /session/session.sh || status=$?
cp "$root"/session/shots/* "$root/session/log.txt" "$shots/" 2>/dev/null || true
say "screenshots and log are in $shots"
exit "$status"
