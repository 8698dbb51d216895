#!/usr/bin/env bash
# All checks, after scripts/setup.sh: format, lints, documentation tests, tests. Ends with "N passed, N failed, N skipped",
# added up from the summaries of the test programs.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
cd "$project_root"

# The tests render with the Cycles of Blender 5.2 LTS for comparison, export the scenes with it, and run the add-on in it. What Blender's
# own glTF exporter writes is read from 4.5 LTS; colours and the package are compared with both. scripts/test-long.sh runs the add-on in
# 4.5 LTS and the other versions.
bpy_version=5.2.3
for version in 4.5.15 "$bpy_version"; do
    "$scripts/setup-bpy.sh" "$version"
done
"$scripts/setup-tevclient.sh"
# What the measures are compared with.
"$scripts/setup-measures.sh"
# What opens reports.
"$scripts/setup-browser.sh"
# One Blender that is named stands for all.
bpy_python=${SUNDOG_BPY_PYTHON:-$cache/bpy-$bpy_version/bin/python}

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
    local result=0 process part running=()
    # --no-fail-fast: one run tells all that fails. Documentation comes last: cargo builds the library, which it needs, beside
    # the library's tests, not before them.
    cargo test --locked --no-fail-fast --tests || result=$?
    cargo test --locked --no-fail-fast --doc || result=$?
    # The add-on's own tests run inside of Blender, with the program that cargo has just built; beside the reports. What they
    # say comes one after the other.
    {
        say "the add-on in $("$bpy_python" -c 'import bpy; print("Blender", bpy.app.version_string)')"
        SUNDOG_PROGRAM="$project_root/target/debug/sundog" "$bpy_python" tests/addon/run.py
    } >"$logs/addon" 2>&1 &
    running+=("$!")
    {
        say "reports in Chromium"
        "$cache/browser/bin/python" tests/report/run.py
    } >"$logs/reports" 2>&1 &
    running+=("$!")
    for process in "${running[@]}"; do
        wait "$process" || result=$?
    done
    for part in addon reports; do
        cat "$logs/$part"
    done
    return "$result"
}
all_tests 2>&1 | tee "$log" || status=$?
sum_of_tests "$log"
exit "$status"
