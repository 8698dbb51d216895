#!/usr/bin/env bash
# Says by what flags rustc learns which parts of the program are hot (docs/setup.md, "A profile of renders"). None where the profile is of
# another rustc, whose names for functions differ, or where the path holds a space, at which cargo would cut the flags.
#     profile-flags.sh [RUSTC]    RUSTC in place of rustc
set -euo pipefail
scripts=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$scripts")
profile=$root/target/sundog.profdata
case $root in *[[:space:]]*) exit 0 ;; esac
[ "$("${1:-rustc}" --version 2>/dev/null)" = "$(cat "$scripts/profile/rustc.txt")" ] || exit 0
if ! cmp -s <(gzip -dc "$scripts/profile/sundog.profdata.gz") "$profile"; then
    mkdir -p "$root/target"
    new=$profile.$$
    gzip -dc "$scripts/profile/sundog.profdata.gz" >"$new"
    mv "$new" "$profile"
fi
# Functions that changed since the profile was made have none; that is no news. But another version of a library in Cargo.toml, or other features
# of one, give all functions other names, and the whole profile is lost (8 to 13 % more instructions): scripts/profile.sh makes another.
# What is inlined before the counts are looked up depends on how rustc deals functions out to the parts that it compiles, so that a change in one would lose the counts of others: nothing is.
echo "-C profile-use=$profile -C llvm-args=-no-pgo-warn-mismatch -C llvm-args=-disable-preinline"
