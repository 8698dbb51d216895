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

# pip download with checked hashes into a folder, for CPython 3.11 on x86-64 whatever Python runs pip.
fetch_wheels() { # REQUIREMENTS FOLDER
    quietly "$(host_python)" -m pip --disable-pip-version-check --retries 2 download --quiet --no-deps --require-hashes \
        --only-binary=:all: --platform manylinux_2_28_x86_64 --platform manylinux_2_27_x86_64 \
        --platform manylinux_2_17_x86_64 --platform manylinux2014_x86_64 --platform manylinux2010_x86_64 \
        --python-version 3.11 --implementation cp --abi cp311 --abi abi3 --abi none \
        -r "$1" -d "$2"
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
