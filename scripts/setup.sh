#!/usr/bin/env bash
# Prepares a machine for building Sundog: system packages, Rust, and the native libraries in .native/.
#
# What is there already is left alone, so this is cheap to run before every build. Everything fetched is pinned by hash
# and kept in the cache folder (XDG_CACHE_HOME or ~/.cache, under sundog/); a second clone fetches nothing.
#
# The environment can point elsewhere, with the same meaning as for build.rs:
#   EMBREE_DIR     a folder with include/embree4 and lib, or "system" for the distribution's own Embree (4.3 or newer)
#   OCIO_DIR       a folder with include/OpenColorIO and lib
#   LIBCLANG_PATH  the folder of libclang.so
#   OIDN_DIR       a folder with Open Image Denoise in lib, which the program opens when --denoise is asked for
#   SUNDOG_DEBIAN_MIRROR  the Debian mirror for Embree's headers, where apt's own sources name none

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

native="$project_root/.native"

# Embree's public headers. The library itself is 4.4.0; Debian has headers of 4.3.3, whose structures are the same (the
# program checks version and sizes when it starts).
embree_headers_name="libembree-dev_4.3.3+dfsg-1_amd64.deb"
embree_headers_path="pool/main/e/embree/$embree_headers_name"
embree_headers_hash=674a8b3d1a00612f46730da29f4cc146267b4917bbf0242113d0568429e78726
embree_wheel="embreex-4.4.0.post1-cp311-cp311-manylinux_2_27_x86_64.manylinux_2_28_x86_64.whl"
ocio_wheel="opencolorio-2.6.0-cp311-cp311-manylinux_2_27_x86_64.manylinux_2_28_x86_64.whl"
ocio_source="opencolorio-2.6.0.tar.gz"
ocio_version=2.6.0
libclang_wheel="libclang-18.1.1-py2.py3-none-manylinux2010_x86_64.whl"
denoiser_wheel="pyoidn-2.5.1.0-py3-none-manylinux2014_x86_64.whl"

rustup_version=1.28.2
rustup_hash=20a06e644b0d9bd2fbdbfd52d42540bdde820ea7df86e92e533c073da0cdd43c
rust_toolchain=1.95.0

# --- system packages ------------------------------------------------------------------------------------------------

# True if the C++ compiler works, standard headers included.
compiler_works() {
    have c++ && have cc && echo '#include <memory>' | c++ -std=c++17 -x c++ -fsyntax-only - 2>/dev/null
}

install_system_packages() {
    local missing=()
    compiler_works || missing+=(g++)
    have make || missing+=(make)
    # The native pieces need no downloads tool where they are in place already.
    if ! native_is_complete; then
        host_python >/dev/null || missing+=(python3 python3-pip)
        [ -s /etc/ssl/certs/ca-certificates.crt ] || missing+=(ca-certificates)
    fi
    find_cargo >/dev/null || have curl || missing+=(curl ca-certificates)
    [ "${#missing[@]}" -eq 0 ] || install_packages "to build Sundog" "${missing[@]}"
    compiler_works || fail "the C++ compiler cannot compile a file that includes <memory>: repair the g++ installation, then run this again."
}

# --- Rust -----------------------------------------------------------------------------------------------------------

find_cargo() {
    local candidate
    for candidate in cargo "${CARGO_HOME:-${HOME:-/root}/.cargo}/bin/cargo"; do
        if have "$candidate"; then
            command -v "$candidate"
            return 0
        fi
    done
    return 1
}

# The version of a cargo, as 1.95.0.
cargo_version() { (cd "$project_root" && "$1" --version 2>/dev/null) | awk '{ print $2; exit }'; }

# True if version $1 is at least version $2.
at_least() { [ "$(printf '%s\n%s\n' "$2" "$1" | sort -V | head -n 1)" = "$2" ]; }

install_rust() {
    local wanted cargo version
    wanted=$(sed -n 's/^rust-version *= *"\(.*\)"/\1/p' "$project_root/Cargo.toml" | head -n 1)
    wanted=${wanted:-$rust_toolchain}
    if cargo=$(find_cargo); then
        version=$(cargo_version "$cargo")
        [ -n "$version" ] || fail "$cargo is there but 'cargo --version' fails: repair the Rust installation (or remove it, and the set-up fetches one)."
        at_least "$version" "$wanted" ||
            fail "Sundog needs Rust $wanted or newer and $cargo is $version: run 'rustup update stable', or remove the old Rust from PATH and the set-up fetches one."
        return 0
    fi
    local installer="$downloads/rustup-init-$rustup_version"
    if ! has_hash "$installer" "$rustup_hash"; then
        say "fetching the Rust installer"
        quietly curl --proto '=https' --tlsv1.2 --fail --silent --show-error --location --connect-timeout 20 \
            --output "$installer.part" \
            "https://static.rust-lang.org/rustup/archive/$rustup_version/x86_64-unknown-linux-gnu/rustup-init" ||
            fail "there is no cargo, and Rust's installer could not be fetched: install Rust $wanted or newer (see rust-lang.org), then run this again."
        has_hash "$installer.part" "$rustup_hash" ||
            fail "Rust's installer as fetched has the wrong hash, so it was not run: install Rust $wanted or newer yourself, then run this again."
        mv "$installer.part" "$installer"
    fi
    chmod +x "$installer"
    say "installing Rust $rust_toolchain"
    quietly "$installer" -y --no-modify-path --profile minimal --component rustfmt --component clippy \
        --default-toolchain "$rust_toolchain" ||
        fail "Rust's installer failed: install Rust $wanted or newer (see rust-lang.org), then run this again."
}

# --- native libraries -----------------------------------------------------------------------------------------------

# Names everything that decides what is in .native/, so that a new pin makes a new one. The number stands for the way of
# unpacking: count it up when unpack_native changes.
native_stamp() {
    { cat "$scripts/pins/native.txt" "$scripts/pins/opencolorio-source.txt" && echo "$embree_headers_hash unpacked 1"; } |
        sha256sum | cut -d ' ' -f 1
}

native_is_complete() { [ "$(cat "$native/stamp" 2>/dev/null)" = "$(native_stamp)" ]; }

# True if the environment names every native piece, so that .native/ isn't needed.
everything_elsewhere() { [ -n "${EMBREE_DIR:-}" ] && [ -n "${OCIO_DIR:-}" ] && [ -n "${LIBCLANG_PATH:-}" ]; }

hash_of() { # PACKAGE PINS: the pinned hash
    sed -n "s/^$1==.*--hash=sha256:\([0-9a-f]*\).*/\1/p" "$2"
}

fetch_native() {
    local pins="$scripts/pins/native.txt"
    if ! has_hash "$downloads/$embree_wheel" "$(hash_of embreex "$pins")" ||
        ! has_hash "$downloads/$ocio_wheel" "$(hash_of opencolorio "$pins")" ||
        ! has_hash "$downloads/$libclang_wheel" "$(hash_of libclang "$pins")"; then
        say "fetching Embree 4.4.0, OpenColorIO $ocio_version and libclang (46 MB)"
        fetch_wheels "$pins" "$downloads" ||
            fail "Embree, OpenColorIO and libclang could not be fetched from PyPI with their pinned hashes: check the network (and pip's settings), then run this again."
    fi

    pins="$scripts/pins/opencolorio-source.txt"
    if ! has_hash "$downloads/$ocio_source" "$(hash_of opencolorio "$pins")"; then
        say "fetching OpenColorIO's headers (14 MB)"
        # pip asks a source package's build system for metadata before it keeps the download, and OpenColorIO's would
        # fetch CMake and more for that. A stand-in for setuptools answers instead, so nothing of the package is run.
        local stand_in
        stand_in=$(mktemp -d)
        mkdir "$stand_in/setuptools"
        : >"$stand_in/setuptools/__init__.py"
        cat >"$stand_in/setuptools/build_meta.py" <<PYTHON
import os

def get_requires_for_build_wheel(config_settings=None):
    return []

def prepare_metadata_for_build_wheel(directory, config_settings=None):
    name = "opencolorio-$ocio_version.dist-info"
    os.makedirs(os.path.join(directory, name), exist_ok=True)
    with open(os.path.join(directory, name, "METADATA"), "w") as file:
        file.write("Metadata-Version: 2.1\nName: opencolorio\nVersion: $ocio_version\n")
    return name
PYTHON
        local status=0
        PYTHONPATH="$stand_in" quietly "$(host_python)" -m pip --disable-pip-version-check --retries 2 download --quiet --no-deps \
            --require-hashes --no-build-isolation --no-binary :all: -r "$pins" -d "$downloads" || status=$?
        rm -r "$stand_in"
        [ "$status" -eq 0 ] ||
            fail "OpenColorIO's source package (for its headers) could not be fetched from PyPI with its pinned hash: check the network, then run this again."
    fi

    local headers="$downloads/$embree_headers_name"
    if ! has_hash "$headers" "$embree_headers_hash"; then
        say "fetching Embree's headers"
        [ -x /usr/lib/apt/apt-helper ] ||
            fail "Embree's headers come as a Debian package and $(distribution) has no apt: set EMBREE_DIR to a folder with include/embree4 and lib, then run this again."
        local mirror
        mirror=$(debian_mirror)
        if [ -z "$mirror" ]; then
            install_packages "to find a Debian mirror" python-apt-common
            mirror=$(debian_mirror)
        fi
        [ -n "$mirror" ] ||
            fail "Embree's headers come from a Debian mirror and apt's sources name none: set SUNDOG_DEBIAN_MIRROR to a mirror's address, then run this again."
        # Fetched to a folder of its own, then moved: apt drops its rights and needs a place that it may write to.
        rm -f "$headers.part"
        quietly /usr/lib/apt/apt-helper -o APT::Sandbox::User=root download-file "$mirror/$embree_headers_path" "$headers.part" \
            "SHA256:$embree_headers_hash" ||
            fail "Embree's headers ($embree_headers_name) could not be fetched from the Debian mirror $mirror with their pinned hash: check the network, or set SUNDOG_DEBIAN_MIRROR to another mirror."
        mv "$headers.part" "$headers"
    fi
}

# Unpacks the cached downloads into .native.new, then puts it in the place of .native.
unpack_native() {
    local new="$native.new" unpacked="$native.new/unpacked" python
    say "unpacking the native libraries into .native/"
    python=$(host_python)
    rm -rf "$new"
    mkdir -p "$new/include" "$new/lib" "$new/libclang" "$new/licences" "$unpacked"
    "$python" - "$unpacked" "$downloads/$embree_wheel" "$downloads/$ocio_wheel" "$downloads/$libclang_wheel" <<'PYTHON'
import sys, zipfile
target, *wheels = sys.argv[1:]
for wheel in wheels:
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(target, [
            name for name in archive.namelist()
            if name.startswith("embreex.libs/") or name.endswith(("/libOpenColorIO.so", "/libclang.so"))
            or ".dist-info/licen" in name.lower()
        ])
PYTHON
    # Embree's file names carry a hash that is in its soname too: they stay as they are, a link gives the usual name.
    mv "$unpacked"/embreex.libs/lib* "$new/lib/"
    ln -s "$(basename "$(ls "$new"/lib/libembree4-*.so.4)")" "$new/lib/libembree4.so"
    mv "$unpacked/PyOpenColorIO/libOpenColorIO.so" "$new/lib/"
    mv "$unpacked/libclang-18.1.1.data/platlib/clang/native/libclang.so" "$new/libclang/"
    chmod 755 "$new"/lib/*.so* "$new/libclang/libclang.so"
    mv "$unpacked"/*.dist-info "$new/licences/"

    dpkg-deb --fsys-tarfile "$downloads/$embree_headers_name" | tar -x -C "$unpacked" ./usr/include ./usr/share/doc/libembree-dev/copyright
    mv "$unpacked/usr/include/embree4" "$new/include/"
    mv "$unpacked/usr/share/doc/libembree-dev/copyright" "$new/licences/embree-headers"

    tar -x -z -f "$downloads/$ocio_source" -C "$unpacked" --strip-components=1 --wildcards '*/include/OpenColorIO/*' '*/LICENSE' '*/THIRD-PARTY.md'
    mv "$unpacked/include/OpenColorIO" "$new/include/"
    mv "$unpacked/LICENSE" "$new/licences/OpenColorIO-LICENSE"
    mv "$unpacked/THIRD-PARTY.md" "$new/licences/OpenColorIO-THIRD-PARTY.md"
    # What OpenColorIO's CMake would write; the namespace is the one in the library's symbols.
    local major minor patch
    IFS=. read -r major minor patch <<<"$ocio_version"
    sed -e "s/@OCIO_NAMESPACE@/OpenColorIO_v${major}_$minor/g" \
        -e "s/@OpenColorIO_VERSION@/$ocio_version/g" -e "s/@OpenColorIO_VERSION_RELEASE_TYPE@//g" \
        -e "s/@OpenColorIO_VERSION_MAJOR@/$major/g" -e "s/@OpenColorIO_VERSION_MINOR@/$minor/g" \
        -e "s/@OpenColorIO_VERSION_PATCH@/$patch/g" \
        "$new/include/OpenColorIO/OpenColorABI.h.in" >"$new/include/OpenColorIO/OpenColorABI.h"
    rm "$new/include/OpenColorIO/OpenColorABI.h.in"

    rm -r "$unpacked"
    native_stamp >"$new/stamp"
    rm -rf "$native"
    mv "$new" "$native"
}

# With EMBREE_DIR=system: the distribution's own Embree, where it is new enough (Debian 13, Ubuntu 24.04).
set_up_system_embree() {
    [ "${EMBREE_DIR:-}" = system ] || return 0
    [ -f /usr/include/embree4/rtcore.h ] || [ -f /usr/local/include/embree4/rtcore.h ] ||
        install_packages "because EMBREE_DIR is 'system'" libembree-dev
    [ -f /usr/include/embree4/rtcore.h ] || [ -f /usr/local/include/embree4/rtcore.h ] ||
        fail "EMBREE_DIR is 'system' and $(distribution) has no Embree 4: unset EMBREE_DIR, and the set-up fetches Embree 4.4.0."
}

# The crates that Cargo.lock names; cargo checks their hashes and keeps them in its own cache.
fetch_crates() {
    local cargo
    cargo=$(find_cargo)
    (cd "$project_root" && quietly "$cargo" fetch --locked --target x86_64-unknown-linux-gnu) ||
        fail "the crates that Cargo.lock names could not be fetched: check the network (the message above says more), then run this again."
}

set_up_native() {
    if native_is_complete || everything_elsewhere; then
        return 0
    fi
    lock_cache
    # Another set-up may have done the work while this one waited.
    native_is_complete && return 0
    fetch_native
    unpack_native
}

# --- the denoiser ---------------------------------------------------------------------------------------------------

# In .native/oidn, with a stamp of its own: nothing is built with it, and all but --denoise works without it.
denoiser_is_complete() { [ "$(cat "$native/oidn/stamp" 2>/dev/null)" = "$(denoiser_stamp)" ]; }

# The number stands for the way of unpacking.
denoiser_stamp() { { cat "$scripts/pins/denoiser.txt" && echo "unpacked 1"; } | sha256sum | cut -d ' ' -f 1; }

set_up_denoiser() {
    if [ -n "${OIDN_DIR:-}" ] || denoiser_is_complete; then
        return 0
    fi
    lock_cache
    denoiser_is_complete && return 0
    local pins="$scripts/pins/denoiser.txt"
    if ! host_python >/dev/null; then
        say "there is no Python 3 with pip to fetch Open Image Denoise with: all but --denoise works; install python3-pip and run 'make setup' again for that."
        return 0
    fi
    if ! has_hash "$downloads/$denoiser_wheel" "$(hash_of pyoidn "$pins")"; then
        say "fetching Open Image Denoise 2.5.1 (88 MB)"
        if ! fetch_wheels "$pins" "$downloads"; then
            say "Open Image Denoise could not be fetched from PyPI with its pinned hash: all but --denoise works; run 'make setup' again for that."
            return 0
        fi
    fi
    unpack_denoiser
}

# The processor's part alone: those for graphics cards are not opened. Its libraries find each other in ../lib.
unpack_denoiser() {
    local new="$native/oidn.new"
    say "unpacking Open Image Denoise into .native/oidn/"
    rm -rf "$new"
    mkdir -p "$new/lib" "$new/licences"
    "$(host_python)" - "$new" "$downloads/$denoiser_wheel" <<'PYTHON'
import os, re, sys, zipfile
target, wheel = sys.argv[1:]
wanted = re.compile(r"/(libOpenImageDenoise\.so\.2|libOpenImageDenoise_(core|device_cpu)\.so\.[0-9.]+|libtbb\.so\.12)$")
with zipfile.ZipFile(wheel) as archive:
    for name in archive.namelist():
        licence = ".dist-info/licenses/" in name
        if licence or wanted.search(name):
            folder = "licences" if licence else "lib"
            with open(os.path.join(target, folder, os.path.basename(name)), "wb") as file:
                file.write(archive.read(name))
PYTHON
    chmod 755 "$new"/lib/*.so*
    denoiser_stamp >"$new/stamp"
    rm -rf "$native/oidn"
    mv "$new" "$native/oidn"
}

require_supported_machine
install_system_packages
lock_cache
install_rust
set_up_system_embree
set_up_native
set_up_denoiser
fetch_crates
say "ready"
