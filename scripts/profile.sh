#!/usr/bin/env bash
# Makes the profile that `make build` and `make addon` compile with, scripts/profile/sundog.profdata.gz: builds a program that counts how
# often each part of it runs, renders with it, and joins the counts. Twenty minutes on two processors. Functions that change lose their
# part of it until it is made anew; nothing else depends on it.
#
# llvm-profdata must be of rustc's LLVM: LLVM_PROFDATA names it, else `rustup component add llvm-tools` brings it, or Debian 13's llvm-22.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
cd "$project_root"

version=$(rustc -vV | sed -n 's/^LLVM version: \([0-9]*\).*/\1/p')
sysroot=$(rustc --print sysroot)
for tool in "${LLVM_PROFDATA:-}" "$sysroot/lib/rustlib/x86_64-unknown-linux-gnu/bin/llvm-profdata" "llvm-profdata-$version" llvm-profdata; do
    "$tool" --version 2>/dev/null | grep -q "LLVM version $version\." && break
    tool=
done
[ -n "$tool" ] || fail "llvm-profdata of LLVM $version is needed: run 'rustup component add llvm-tools', or name it in LLVM_PROFDATA."
for bpy in 4.5.15 5.2.3; do
    "$scripts/setup-bpy.sh" "$bpy"
done
python="$cache/bpy-5.2.3/bin/python"
work="$project_root/target/profile"
rm -rf "$work/counts"
mkdir -p "$work/counts"

say "building a program that counts"
# Nothing inlined before, as in profile-flags.sh: counts are of functions as they are then.
CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS="$("$scripts/cpu-flags.sh") -C profile-generate=$work/counts -C llvm-args=-disable-preinline" \
    cargo build --release --locked --target-dir "$work"
# The program ends at once, without what the counts are written by.
cc -shared -fPIC -x c -o "$work/exit.so" - <<<'void exit(int); void _exit(int code) { exit(code); }'
program="$work/sundog"
printf '#!/bin/sh\nLD_PRELOAD="%s" exec "%s" "$@"\n' "$work/exit.so" "$work/release/sundog" >"$program"
chmod +x "$program"

# counts NAME COMMAND...: threads would lose counts to each other, so that each runs on one processor.
counts() {
    local name=$1
    shift
    say "counting: $name"
    SUNDOG_PROGRAM="$program" LLVM_PROFILE_FILE="$work/counts/$name-%m.profraw" taskset -c "$processor" "$@" >"$work/$name.log" 2>&1 ||
        say "$name did not pass all of its checks: $(tail -n 1 "$work/$name.log")"
}

gallery() {
    local scene arguments
    for scene in "$work"/scenes/*.json; do
        for arguments in "--samples 32" "--samples 16 --exr-layers all" "--samples 64 --noise-threshold 0.05 --denoise"; do
            # shellcheck disable=SC2086
            python3 scripts/render_scene.py "$scene" --program "$program" -o "$work/picture.exr" --pixels 12000 $arguments
        done
    done
}
export -f gallery
export work program

# What artists make of nodes, and what the gallery has none of. NAME:SHARE, in hundredths of all counts: how long each happens to take
# says nothing of what people render.
random=(sheet:5 ball:10 shader:10 volume:4 displacement:4)
compared=(lobes:12 hair:4 subsurface:4 volumes:5 motion:3 data_passes:3 worlds:4 images:10)
(
    processor=0
    "$cache/bpy-4.5.15/bin/python" scenes/build.py all "$work/scenes" >/dev/null
    counts gallery bash -euc gallery
    for kind in "${random[@]%:*}"; do
        counts "$kind" "$python" tests/addon/parity_random.py "$kind" --first 5000 --count 60 --samples 64 --folder "$work/random"
    done
) &
(
    processor=$(($(nproc) > 1))
    for kind in "${compared[@]%:*}"; do
        counts "$kind" "$python" tests/addon/run.py "test_parity_$kind"
    done
) &
wait
inputs=()
for share in gallery:22 "${random[@]}" "${compared[@]}"; do
    name=${share%:*}
    "$tool" merge --sparse -o "$work/$name.profdata" "$work/counts/$name"-*.profraw
    total=$("$tool" show --detailed-summary "$work/$name.profdata" | sed -n 's/^Total count: //p')
    # Of 10^14 counts in all, so that weights of what counts most are whole numbers above 10.
    inputs+=("--weighted-input=$((${share#*:} * 1000000000000 / total)),$work/$name.profdata")
done
"$tool" merge --text -o "$work/all.txt" "${inputs[@]}"
python3 "$scripts/profile_names.py" "$work/all.txt" "$work/kept.txt"
"$tool" merge --sparse -o "$work/kept.profdata" "$work/kept.txt"
gzip -9nc "$work/kept.profdata" >"$scripts/profile/sundog.profdata.gz.new"
mv "$scripts/profile/sundog.profdata.gz.new" "$scripts/profile/sundog.profdata.gz"
rustc --version >"$scripts/profile/rustc.txt"
say "the profile is in scripts/profile/: $(stat -c %s "$scripts/profile/sundog.profdata.gz") bytes"
