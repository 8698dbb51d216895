#!/usr/bin/env bash
# Makes Blender available as a Python module, as a virtual environment in the cache folder:
#
#     scripts/setup-bpy.sh [VERSION]      VERSION 4.5.15 (the default), 5.3.0, 5.2.3, 5.1.2, 5.0.1 or 4.2.23
#
# The environment is then <cache>/bpy-VERSION/bin/python. bpy needs Python 3.11, from 5.1 on Python 3.13; where the system has
# none, a Debian's packages of it are unpacked into the cache folder and nothing is installed. SUNDOG_BPY_PYTHON names another
# Python that can import bpy; then there is nothing to do.

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
case $version in
4.* | 5.0.*) python_version=3.11 ;;
*) python_version=3.13 ;;
esac

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

stamp() { sha256sum "$pins" | cut -d ' ' -f 1; }

is_complete() {
    [ "$(cat "$venv/stamp" 2>/dev/null)" = "$(stamp)" ] && works_as_python "$venv/bin/python" "$python_version"
}

require_supported_machine
is_complete && exit 0
lock_cache
is_complete && exit 0
install_runtime_libraries
python=$(python_of "$python_version")

say "fetching Blender $version as a Python module (bpy, 400 MB) into $venv"
new="$venv.new"
rm -rf "$new"
"$python" -m venv --without-pip "$new" ||
    fail "$python cannot make a virtual environment in $new: see the message above."
install_wheels "$python_version" "$pins" "$new" ||
    fail "bpy $version could not be fetched from PyPI with its pinned hashes: check the network and the room in $cache (2 GB), then run this again."
quietly "$new/bin/python" -c 'import bpy' ||
    fail "bpy $version is there but cannot be imported on $(distribution): see the message above."
stamp >"$new/stamp"
rm -rf "$venv"
mv "$new" "$venv"
say "bpy $version is ready"
