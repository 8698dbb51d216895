#!/usr/bin/env bash
# For developers: runs commands in a clean Debian with nothing but `make`, on a clean clone of the last commit.
#
#     sudo scripts/test-clean.sh [--archive] SUITE [COMMAND]
#                                     SUITE bookworm or trixie; COMMAND 'make demo && make test' by default
#
# With --archive the files of the last commit are unpacked from an archive, as somebody has them who downloads one: there is no
# folder .git. The clean system has no git either way.
#
# Needs root and debootstrap. The base system is made once under SUNDOG_CLEAN_DIR (/var/tmp/sundog-clean) and copied for
# each run; the cache folder is the clean system's own, so everything is fetched. Rust comes from this machine, read-only,
# and the crates are fetched; so what is not tried is the fetching of Rust itself.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

from=clone
if [ "${1:-}" = --archive ]; then
    from=archive
    shift
fi
suite=${1:?the suite, bookworm or trixie}
command=${2:-make demo && make test}
place=${SUNDOG_CLEAN_DIR:-/var/tmp/sundog-clean}
base="$place/$suite"
root="$place/$suite-run"
rust_home=${RUSTUP_HOME:-$HOME/.rustup}
cargo_home=${CARGO_HOME:-$HOME/.cargo}

[ "$(id -u)" -eq 0 ] || fail "this needs root, to mount and change root."
[ -d "$base/etc" ] || debootstrap --variant=minbase "$suite" "$base"

release() {
    local folder
    for folder in proc dev root/.rustup root/.cargo/bin; do
        mountpoint -q "$root/$folder" && umount "$root/$folder"
    done
    return 0
}
trap release EXIT
release
rm -rf --one-file-system "$root"
cp -a "$base" "$root"
mkdir -p "$root/root/.rustup" "$root/root/.cargo/bin"
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
mount --bind -o ro "$rust_home" "$root/root/.rustup"
mount --bind -o ro "$cargo_home/bin" "$root/root/.cargo/bin"
cp /etc/resolv.conf "$root/etc/resolv.conf"
# Certificates that this machine's network asks for.
mkdir -p "$root/usr/local/share/ca-certificates"
cp /usr/local/share/ca-certificates/*.crt "$root/usr/local/share/ca-certificates/" 2>/dev/null || true

if [ "$from" = archive ]; then
    mkdir "$root/root/sundog"
    git -C "$project_root" archive HEAD | tar -x -C "$root/root/sundog"
else
    git clone --quiet --no-hardlinks "$project_root" "$root/root/sundog"
fi
inside() { chroot "$root" env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin TERM=dumb LANG=C.UTF-8 "$@"; }
inside sh -c 'apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends make >/dev/null 2>&1'
say "in a clean $suite: $command"
start=$SECONDS
status=0
inside bash -c "cd /root/sundog && $command" || status=$?
say "$suite: '$command' ended with $status after $((SECONDS - start)) s"
exit "$status"
