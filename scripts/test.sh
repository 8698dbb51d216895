#!/usr/bin/env bash
# All checks, after scripts/setup.sh: format, lints, documentation tests, tests. Ends with "N passed, N failed, N skipped",
# added up from the summaries of the test programs.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
cd "$project_root"

# The tests render with Blender's Cycles for comparison and export the scenes with Blender; its colours are compared in 5.0
# too, and the add-on runs in the oldest and the newest Blender that it supports.
for version in 4.5.15 5.0.1 4.2.23; do
    "$scripts/setup-bpy.sh" "$version"
done
export SUNDOG_BPY_PYTHON="${SUNDOG_BPY_PYTHON:-$cache/bpy-4.5.15/bin/python}"

for tool in fmt clippy; do
    cargo "$tool" --version >/dev/null 2>&1 ||
        fail "cargo $tool is needed for the tests: run 'rustup component add rustfmt clippy'."
done

say "format"
cargo fmt --check || fail "the format differs from rustfmt's (above): run 'cargo fmt'."
say "lints"
cargo clippy --quiet --all-targets --locked -- -D warnings || fail "clippy has something to say (above): follow it."
say "tests"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
status=0
{
    # --no-fail-fast: one run tells all that fails.
    cargo test --locked --no-fail-fast --doc &&
        cargo test --locked --no-fail-fast --lib --bins --tests
} 2>&1 | tee "$log" || status=$?
sed -n 's/^test result: .*\. \([0-9]*\) passed; \([0-9]*\) failed; \([0-9]*\) ignored;.*/\1 \2 \3/p' "$log" |
    awk '{ passed += $1; failed += $2; skipped += $3 } END { printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped }'
exit "$status"
