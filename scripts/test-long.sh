#!/usr/bin/env bash
# What takes too long for each change, after scripts/setup.sh, with the same assertions: the Rust tests in modules named `long`; the add-on
# and its package in the Blenders that scripts/test.sh leaves out; colours and layers as those show them; and the pictures' comparison
# with Cycles of 4.5 LTS.
# Ends with "N passed, N failed, N skipped".

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
cd "$project_root"

# The oldest that the add-on supports, and those before and after the LTS version of scripts/test.sh.
bpy_versions=(4.2.23 4.5.15 5.0.1 5.1.2 5.3.0)
unset SUNDOG_BPY_PYTHON
export SUNDOG_LONG_TESTS=1
latest=5.2.3
for version in "${bpy_versions[@]}" "$latest"; do
    "$scripts/setup-bpy.sh" "$version"
done

log=$(mktemp)
trap 'rm -f "$log"' EXIT
program="$project_root/target/debug/sundog"
long_tests() {
    local result=0 version python package=() modules=()
    # The program with them; `cargo build` would compile the library once more, with other features of what it needs.
    cargo test --locked --no-run --tests || return 1
    say "long tests"
    cargo test --locked --no-fail-fast --tests -- --ignored ::long:: || result=$?
    for version in "${bpy_versions[@]}"; do
        python="$cache/bpy-$version/bin/python"
        # scripts/test.sh has the package in 4.5.15.
        [ "$version" = 4.5.15 ] || package+=(--bpy "$python")
        say "the add-on in Blender $version"
        SUNDOG_PROGRAM="$program" "$python" tests/addon/run.py || result=$?
    done
    say "long tests of the add-on in Blender $latest"
    mapfile -t modules < <(grep -l '@kit.long' tests/addon/test_*.py | sed 's|.*/||; s|[.]py$||')
    SUNDOG_PROGRAM="$program" "$cache/bpy-$latest/bin/python" tests/addon/run.py "${modules[@]}" || result=$?
    say "the package in them"
    "$cache/bpy-4.5.15/bin/python" tests/addon/test_package.py --sundog "$program" "${package[@]}" || result=$?
    for version in 5.0.1 5.1.2 5.3.0; do
        say "colours and layers in Blender $version"
        SUNDOG_BPY_PYTHON="$cache/bpy-$version/bin/python" \
            cargo test --locked --test sundog-tests -- color:: blender_layers:: || result=$?
    done
    say "pictures beside Cycles of Blender 4.5.15"
    SUNDOG_BPY_PYTHON="$cache/bpy-4.5.15/bin/python" cargo test --locked --test sundog-tests -- pictures:: || result=$?
    return "$result"
}
status=0
long_tests 2>&1 | tee "$log" || status=$?
sum_of_tests "$log"
exit "$status"
