#!/usr/bin/env bash
# All checks, after scripts/setup.sh: format, lints, documentation tests, tests. Ends with "N passed, N failed, N skipped",
# added up from the summaries of the test programs.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
cd "$project_root"

# The tests render with the Cycles of Blender 5.2 LTS for comparison and export the scenes with it; what Blender's own glTF
# exporter writes is read from 4.5 LTS. The add-on runs in both, the colours are compared with both. scripts/test-long.sh has the other
# versions.
bpy_versions=(4.5.15 5.2.3)
for version in "${bpy_versions[@]}"; do
    "$scripts/setup-bpy.sh" "$version"
done
"$scripts/setup-tevclient.sh"
# What the measures are compared with.
"$scripts/setup-measures.sh"
# What opens reports.
"$scripts/setup-browser.sh"
# One Blender that is named stands for all.
[ -z "${SUNDOG_BPY_PYTHON:-}" ] || bpy_versions=(named)

for tool in fmt clippy; do
    cargo "$tool" --version >/dev/null 2>&1 ||
        fail "cargo $tool is needed for the tests: run 'rustup component add rustfmt clippy'."
done

say "format"
cargo fmt --check || fail "the format differs from rustfmt's (above): run 'cargo fmt'."
say "lints"
cargo clippy --quiet --all-targets --locked -- -D warnings || fail "clippy has something to say (above): follow it."
say "tests"
logs=$(mktemp -d)
log=$logs/all
trap 'rm -rf "$logs"' EXIT
status=0
all_tests() {
    local result=0 python version process part running=()
    # --no-fail-fast: one run tells all that fails.
    {
        cargo test --locked --no-fail-fast --doc &&
            cargo test --locked --no-fail-fast --lib --bins --tests
    } || result=$?
    # The add-on's own tests run inside of Blender, with the program that cargo has just built; the versions side by side, as each
    # uses one processor most of the time, and what they say one after the other.
    for version in "${bpy_versions[@]}"; do
        python="$cache/bpy-$version/bin/python"
        [ "$version" != named ] || python=$SUNDOG_BPY_PYTHON
        {
            say "the add-on in $("$python" -c 'import bpy; print("Blender", bpy.app.version_string)')"
            SUNDOG_PROGRAM="$project_root/target/debug/sundog" "$python" tests/addon/run.py
        } >"$logs/$version" 2>&1 &
        running+=("$!")
    done
    {
        say "reports in Chromium"
        "$cache/browser/bin/python" tests/report/run.py
    } >"$logs/reports" 2>&1 &
    running+=("$!")
    for process in "${running[@]}"; do
        wait "$process" || result=$?
    done
    for part in "${bpy_versions[@]}" reports; do
        cat "$logs/$part"
    done
    return "$result"
}
all_tests 2>&1 | tee "$log" || status=$?
sum_of_tests "$log"
exit "$status"
