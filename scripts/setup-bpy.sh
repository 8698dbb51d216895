#!/usr/bin/env bash
# Makes Blender available as a Python module, as a virtual environment in the cache folder:
#
#     scripts/setup-bpy.sh [VERSION]      VERSION 4.5.15 (the default), 5.0.1 or 4.2.23
#
# The environment is then <cache>/bpy-VERSION/bin/python. bpy needs Python 3.11; where the system has none, Debian 12's
# packages of it are unpacked into the cache folder and nothing is installed. SUNDOG_BPY_PYTHON names another Python that
# can import bpy; then there is nothing to do.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

version=${1:-4.5.15}
pins="$scripts/pins/bpy-$version.txt"
[ -f "$pins" ] || fail "there are no pinned hashes for bpy $version: the versions known are $(cd "$scripts/pins" && echo bpy-*.txt | sed 's/bpy-//g; s/\.txt//g')."

if [ -n "${SUNDOG_BPY_PYTHON:-}" ]; then
    "$SUNDOG_BPY_PYTHON" -c 'import bpy' >/dev/null 2>&1 ||
        fail "SUNDOG_BPY_PYTHON is $SUNDOG_BPY_PYTHON and that cannot import bpy: correct the variable, or unset it and the set-up fetches bpy."
    exit 0
fi

venv="$cache/bpy-$version"
portable="$cache/python-3.11"

# Shared libraries that bpy loads, each with the package it comes in on Debian and Ubuntu.
install_runtime_libraries() {
    local known missing=() soname package
    known=$({ ldconfig -p || /sbin/ldconfig -p; } 2>/dev/null)
    while read -r soname package; do
        grep -q -F "$soname " <<<"$known" || missing+=("$package")
    done <<'LIBRARIES'
libGL.so.1 libgl1
libICE.so.6 libice6
libSM.so.6 libsm6
libX11.so.6 libx11-6
libXext.so.6 libxext6
libXfixes.so.3 libxfixes3
libXi.so.6 libxi6
libXrender.so.1 libxrender1
libxkbcommon.so.0 libxkbcommon0
LIBRARIES
    host_python >/dev/null || missing+=(python3 python3-pip)
    [ -s /etc/ssl/certs/ca-certificates.crt ] || missing+=(ca-certificates)
    [ "${#missing[@]}" -eq 0 ] || install_packages "to run Blender as a Python module" "${missing[@]}"
}

works_as_python() {
    "$1" -c 'import sys, ctypes, json, venv, zlib; sys.exit(sys.version_info[:2] != (3, 11))' >/dev/null 2>&1
}

# Prints a Python 3.11, or nothing.
find_python() {
    local candidate
    for candidate in /usr/bin/python3.11 python3.11 python3 "$portable/usr/bin/python3.11"; do
        if works_as_python "$candidate"; then
            command -v "$candidate"
            return 0
        fi
    done
    return 1
}

# Unpacks Debian 12's Python 3.11 into the cache folder. apt fetches it with a source list, state and cache of its own, so
# that the system's stay as they are, and checks it against Debian's signing keys.
unpack_python() {
    local mirror keyring=/usr/share/keyrings/debian-archive-keyring.gpg new="$portable.new" package
    have apt-get ||
        fail "bpy needs Python 3.11, and $(distribution) has neither that nor apt to fetch it with: install Python 3.11 (python3.11 on PATH), then run this again."
    [ -s "$keyring" ] || install_packages "to check Debian's Python 3.11" debian-archive-keyring
    mirror=$(debian_mirror)
    if [ -z "$mirror" ]; then
        install_packages "to find a Debian mirror" python-apt-common
        mirror=$(debian_mirror)
    fi
    [ -n "$mirror" ] ||
        fail "bpy needs Python 3.11, which $(distribution) has not, and apt's sources name no Debian mirror to fetch it from: set SUNDOG_DEBIAN_MIRROR to a mirror's address, or install Python 3.11."
    say "fetching Python 3.11 from Debian 12 (for bpy; nothing is installed)"
    rm -rf "$new"
    mkdir -p "$new/apt/lists/partial" "$new/apt/cache/archives/partial" "$new/apt/packages"
    printf 'deb [signed-by=%s] %s bookworm main\n' "$keyring" "$mirror" >"$new/apt/sources.list"
    local options=(-qq -o "Dir::Etc::SourceList=$new/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null
        -o "Dir::State::Lists=$new/apt/lists" -o "Dir::Cache=$new/apt/cache" -o APT::Sandbox::User=root
        -o Acquire::Languages=none -o APT::Architecture=amd64 -o APT::Architectures::=amd64)
    quietly apt-get "${options[@]}" update ||
        fail "Debian 12's package list could not be fetched from $mirror (Python 3.11 for bpy comes from there): check the network, or install Python 3.11."
    (cd "$new/apt/packages" && quietly apt-get "${options[@]}" download \
        python3.11-minimal libpython3.11-minimal libpython3.11-stdlib) ||
        fail "Debian 12's Python 3.11 could not be fetched from $mirror: check the network, or install Python 3.11."
    for package in "$new"/apt/packages/*.deb; do
        dpkg-deb -x "$package" "$new"
    done
    rm -rf "$new/apt" "$portable"
    mv "$new" "$portable"
    works_as_python "$portable/usr/bin/python3.11" ||
        fail "Debian 12's Python 3.11 does not run on $(distribution): install Python 3.11 (python3.11 on PATH), then run this again."
}

stamp() { sha256sum "$pins" | cut -d ' ' -f 1; }

is_complete() {
    [ "$(cat "$venv/stamp" 2>/dev/null)" = "$(stamp)" ] && works_as_python "$venv/bin/python"
}

require_supported_machine
is_complete && exit 0
lock_cache
is_complete && exit 0
install_runtime_libraries
python=$(find_python) || { unpack_python && python=$(find_python); }

say "fetching Blender $version as a Python module (bpy, 400 MB) into $venv"
new="$venv.new"
rm -rf "$new"
"$python" -m venv --without-pip "$new" ||
    fail "$python cannot make a virtual environment in $new: see the message above."
quietly "$(host_python)" -m pip --disable-pip-version-check --retries 2 --python "$new/bin/python" install --quiet --no-deps \
    --no-compile --no-cache-dir --require-hashes --only-binary=:all: -r "$pins" ||
    fail "bpy $version could not be fetched from PyPI with its pinned hashes: check the network and the room in $cache (2 GB), then run this again."
quietly "$new/bin/python" -c 'import bpy' ||
    fail "bpy $version is there but cannot be imported on $(distribution): see the message above."
stamp >"$new/stamp"
rm -rf "$venv"
mv "$new" "$venv"
say "bpy $version is ready"
