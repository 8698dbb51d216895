# shellcheck shell=bash
# Shared by the set-up scripts: messages, places, the package manager and pip. Sourced, never run.

set -euo pipefail

project_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck disable=SC2034
scripts="$project_root/scripts"
# Everything that is fetched lives in the user's cache folder, so that a second clone fetches nothing.
cache="${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/sundog"
downloads="$cache/downloads"
# Rust is taken from PATH, else from where its installer puts it.
PATH="$PATH:${CARGO_HOME:-${HOME:-/root}/.cargo}/bin"

say() { printf 'set-up: %s\n' "$*"; }

# One clear sentence, then stop.
fail() {
    printf 'set-up: %s\n' "$*" >&2
    exit 1
}

# Runs a command quietly; its output is shown only if it fails.
quietly() {
    local log status=0
    log=$(mktemp)
    "$@" >"$log" 2>&1 || status=$?
    if [ "$status" -ne 0 ]; then
        grep -v 'WARNING: Retrying' "$log" | tail -n 5 | sed 's/^/    /' >&2 || true
    fi
    rm -f "$log"
    return "$status"
}

require_supported_machine() {
    [ "$(uname -s)" = Linux ] ||
        fail "Sundog's set-up works on Linux only and this is $(uname -s); set EMBREE_DIR, OCIO_DIR and LIBCLANG_PATH to your own libraries and run 'cargo build --release'."
    [ "$(uname -m)" = x86_64 ] ||
        fail "the pinned Embree, OpenColorIO and libclang are for x86_64 and this machine is $(uname -m); set EMBREE_DIR, OCIO_DIR and LIBCLANG_PATH to your own libraries and run 'cargo build --release'."
}

# Name and version of the distribution, as one line for messages.
distribution() {
    # shellcheck disable=SC1091
    (. /etc/os-release 2>/dev/null && printf '%s' "${PRETTY_NAME:-unknown Linux}") || printf 'unknown Linux'
}

have() { command -v "$1" >/dev/null 2>&1; }

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    else
        sudo "$@"
    fi
}

# install_packages REASON PACKAGE...: installs Debian packages, or says in one sentence what keeps it from doing so.
install_packages() {
    local reason=$1
    shift
    have apt-get ||
        fail "$(distribution) has no apt-get, so install what Debian calls '$*' ($reason) with your own package manager and run this again."
    if [ "$(id -u)" -ne 0 ]; then
        have sudo || fail "the packages '$*' are missing ($reason) and there is no sudo: run 'apt-get install $*' as root, then this again."
        say "sudo is needed to install: $*"
    else
        say "installing system packages: $*"
    fi
    local options=(-y -qq --no-install-recommends -o DPkg::Lock::Timeout=300)
    # The lists may be there and fresh enough: the (slow) update runs only when they are not.
    if ! quietly as_root env DEBIAN_FRONTEND=noninteractive apt-get install "${options[@]}" "$@" 2>/dev/null; then
        quietly as_root apt-get update -qq ||
            fail "apt-get update failed, so the packages '$*' ($reason) could not be installed: check the network and apt's sources, then run this again."
        quietly as_root env DEBIAN_FRONTEND=noninteractive apt-get install "${options[@]}" "$@" ||
            fail "apt-get could not install '$*' ($reason) on $(distribution): install them by hand, then run this again."
    fi
}

# The first Python 3 on this system that has pip; what runs it doesn't matter, since wheels are only downloaded with it.
host_python() {
    local candidate
    for candidate in python3 /usr/bin/python3; do
        if have "$candidate" && "$candidate" -m pip --version >/dev/null 2>&1; then
            printf '%s' "$candidate"
            return 0
        fi
    done
    return 1
}

# wheels_of PYTHON_VERSION: sets wheel_options, what pip is told so that it takes wheels for that CPython on x86-64, whatever
# Python runs pip. (A wheel's own word on Python's version is not asked: the pins name the wheels by hash.)
wheels_of() {
    wheel_options=(--quiet --no-deps --require-hashes --only-binary=:all: --ignore-requires-python
        --platform manylinux_2_28_x86_64 --platform manylinux_2_27_x86_64
        --platform manylinux_2_17_x86_64 --platform manylinux2014_x86_64 --platform manylinux2010_x86_64
        --python-version "$1" --implementation cp --abi "cp${1/./}" --abi abi3 --abi none)
}

# pip download with checked hashes into a folder, for CPython 3.11.
fetch_wheels() { # REQUIREMENTS FOLDER
    wheels_of 3.11
    quietly "$(host_python)" -m pip --disable-pip-version-check --retries 2 download "${wheel_options[@]}" -r "$1" -d "$2"
}

# install_wheels PYTHON_VERSION PINS VENV: pip install with checked hashes into the packages of a virtual environment. pip runs
# in the host's Python, since Debian 12's does not run in Python 3.13; its temporary files stay on the same disk.
install_wheels() {
    local temporary="$3/temporary" status=0
    wheels_of "$1"
    mkdir "$temporary"
    TMPDIR="$temporary" PIP_ROOT_USER_ACTION=ignore quietly "$(host_python)" -m pip --disable-pip-version-check --retries 2 install "${wheel_options[@]}" \
        --no-compile --no-cache-dir --target "$3/lib/python$1/site-packages" -r "$2" || status=$?
    rm -rf "$temporary"
    return "$status"
}

# True if the file is there and has the hash.
has_hash() { # FILE SHA256
    [ -f "$1" ] && printf '%s  %s\n' "$2" "$1" | sha256sum --check --status
}

# Holds other set-ups (of other clones) back while this one writes to the cache.
lock_cache() {
    mkdir -p "$downloads" 2>/dev/null ||
        fail "the cache folder $cache cannot be made: set XDG_CACHE_HOME to a folder that you may write to."
    if have flock; then
        exec 9>"$cache/lock"
        flock 9
    fi
}

# The base address of a Debian mirror: SUNDOG_DEBIAN_MIRROR, else the one that this system's apt uses, else (Ubuntu) the
# one in python-apt's table of distributions. Empty if there is none.
debian_mirror() {
    local mirror=${SUNDOG_DEBIAN_MIRROR:-}
    if [ -z "$mirror" ]; then
        # (awk reads to the end: were it to stop early, apt-get would fail on the closed pipe.)
        # shellcheck disable=SC2016
        mirror=$(apt-get indextargets --format '$(REPO_URI) $(COMPONENT) $(CREATED_BY)' 2>/dev/null |
            awk '$2 == "main" && $3 == "Packages" && $1 ~ /\/debian\/?$/ && !found++ { print $1 }')
    fi
    if [ -z "$mirror" ]; then
        mirror=$(sed -n 's/^BaseURI: *//p' /usr/share/python-apt/templates/Debian.info 2>/dev/null | head -n 1)
    fi
    printf '%s' "${mirror%/}"
}

# The Pythons that the pinned wheels are for: the system's, else a Debian's unpacked into the cache folder.
portable_python() { printf '%s' "$cache/python-$1/usr/bin/python$1"; }

works_as_python() { # COMMAND VERSION
    "$1" -c 'import sys, ctypes, json, venv, zlib; sys.exit("%d.%d" % sys.version_info[:2] != sys.argv[1])' "$2" >/dev/null 2>&1
}

# Prints a Python of that version, or nothing.
find_python() { # VERSION
    local candidate
    for candidate in "/usr/bin/python$1" "python$1" python3 "$(portable_python "$1")"; do
        if works_as_python "$candidate" "$1"; then
            command -v "$candidate"
            return 0
        fi
    done
    return 1
}

# Unpacks a Debian's Python (3.11 of Debian 12, 3.13 of Debian 13) into the cache folder. apt fetches it with a source list,
# state and cache of its own, so that the system's stay as they are, and checks it against Debian's signing keys.
#
# Debian 13's asks for a newer C library than Debian 12 and Ubuntu 24.04 have, so that comes along with what Python's modules
# load, and the command python3.13 is then a script that starts the Python through that library's own loader. It hands its own
# name on: so sys.executable is the script, children start by it, and it can be in a virtual environment. Nothing is in the
# environment (LD_LIBRARY_PATH), so that other programs started from there keep the system's libraries.
unpack_python() { # VERSION
    local version=$1 mirror keyring=/usr/share/keyrings/debian-archive-keyring.gpg place="$cache/python-$1" new package debian suite
    local packages=("python$1-minimal" "libpython$1-minimal" "libpython$1-stdlib")
    new="$place.new"
    case $version in
    3.11) debian='Debian 12' suite=bookworm ;;
    3.13)
        debian='Debian 13' suite=trixie
        packages+=(libc6 libgcc-s1 libstdc++6 zlib1g libexpat1 libffi8 libssl3t64 libzstd1 liblzma5 libbz2-1.0 libsqlite3-0 libuuid1)
        ;;
    esac
    have apt-get ||
        fail "Python $version is needed, and $(distribution) has neither that nor apt to fetch it with: install Python $version (python$version on PATH), then run this again."
    [ -s "$keyring" ] || install_packages "to check Debian's Python $version" debian-archive-keyring
    mirror=$(debian_mirror)
    if [ -z "$mirror" ]; then
        install_packages "to find a Debian mirror" python-apt-common
        mirror=$(debian_mirror)
    fi
    [ -n "$mirror" ] ||
        fail "Python $version is needed, which $(distribution) has not, and apt's sources name no Debian mirror to fetch it from: set SUNDOG_DEBIAN_MIRROR to a mirror's address, or install Python $version."
    say "fetching Python $version from $debian (nothing is installed)" >&2
    rm -rf "$new"
    mkdir -p "$new/apt/lists/partial" "$new/apt/cache/archives/partial" "$new/apt/packages"
    printf 'deb [signed-by=%s] %s %s main\n' "$keyring" "$mirror" "$suite" >"$new/apt/sources.list"
    local options=(-qq -o "Dir::Etc::SourceList=$new/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null
        -o "Dir::State::Lists=$new/apt/lists" -o "Dir::Cache=$new/apt/cache" -o APT::Sandbox::User=root
        -o Acquire::Languages=none -o APT::Architecture=amd64 -o APT::Architectures::=amd64)
    quietly apt-get "${options[@]}" update ||
        fail "$debian's package list could not be fetched from $mirror (Python $version comes from there): check the network, or install Python $version."
    (cd "$new/apt/packages" && quietly apt-get "${options[@]}" download "${packages[@]}") ||
        fail "$debian's Python $version could not be fetched from $mirror: check the network, or install Python $version."
    for package in "$new"/apt/packages/*.deb; do
        dpkg-deb -x "$package" "$new"
    done
    rm -rf "$new/apt"
    if [ -e "$new/usr/lib64/ld-linux-x86-64.so.2" ]; then
        mv "$new/usr/bin/python$version" "$new/usr/bin/python$version-itself"
        {
            printf '#!/bin/sh\n'
            # shellcheck disable=SC2016
            printf 'exec %q --library-path %q --argv0 "$0" %q "$@"\n' "$place/usr/lib/x86_64-linux-gnu/ld-linux-x86-64.so.2" \
                "$place/usr/lib/x86_64-linux-gnu" "$place/usr/bin/python$version-itself"
        } >"$new/usr/bin/python$version"
        chmod +x "$new/usr/bin/python$version"
    fi
    rm -rf "$place"
    mv "$new" "$place"
    works_as_python "$(portable_python "$version")" "$version" ||
        fail "$debian's Python $version does not run on $(distribution): install Python $version (python$version on PATH), then run this again."
}

# Prints a Python of that version, which is fetched if there is none.
python_of() { # VERSION
    find_python "$1" && return 0
    unpack_python "$1" >&2
    find_python "$1"
}

# pinned_venv VENV PINS IMPORTS WHAT ROOM: makes a virtual environment of Python 3.11 with the packages that the file PINS
# names, unless it is there already; IMPORTS is a line of Python that must work in it.
pinned_venv() {
    local venv=$1 pins=$2 imports=$3 what=$4 room=$5 new="$1.new" stamp python
    stamp=$(sha256sum "$pins" | cut -d ' ' -f 1)
    venv_is_complete() { [ "$(cat "$venv/stamp" 2>/dev/null)" = "$stamp" ] && works_as_python "$venv/bin/python" 3.11; }
    venv_is_complete && return 0
    lock_cache
    venv_is_complete && return 0
    host_python >/dev/null || install_packages "to fetch packages from PyPI" python3 python3-pip ca-certificates
    python=$(python_of 3.11)
    say "fetching $what into $venv"
    rm -rf "$new"
    "$python" -m venv --without-pip "$new" ||
        fail "$python cannot make a virtual environment in $new: see the message above."
    quietly "$(host_python)" -m pip --disable-pip-version-check --retries 2 --python "$new/bin/python" install --quiet --no-deps \
        --no-compile --no-cache-dir --require-hashes --only-binary=:all: -r "$pins" ||
        fail "$what could not be fetched from PyPI with the pinned hashes: check the network and the room in $cache ($room), then run this again."
    quietly "$new/bin/python" -c "$imports" ||
        fail "$what is there but cannot be imported on $(distribution): see the message above."
    echo "$stamp" >"$new/stamp"
    rm -rf "$venv"
    mv "$new" "$venv"
}

# Adds up the summaries of the test programs in a log: "N passed, N failed, N skipped".
sum_of_tests() { # LOG
    sed -n 's/^test result: .*\. \([0-9]*\) passed; \([0-9]*\) failed; \([0-9]*\) ignored;.*/\1 \2 \3/p' "$1" |
        awk '{ passed += $1; failed += $2; skipped += $3 } END { printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped }'
}
