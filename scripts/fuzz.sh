#!/bin/sh
# Runs the fuzzer (tests/fuzz/fuzzer) for as long as asked: scripts/fuzz.sh [MINUTES] [FIRST SEED]
#
# What fails is made smaller and kept in tests/fuzz/found, which `make test` replays: mend it, give the file a name that says what it
# is, and commit both. The process may take 6 GiB; one that dies (by that limit, or by an input that takes two minutes) is
# named by its seed, and the next goes on behind it.
set -eu
cd "$(dirname "$0")/.."
minutes=${1:-60}
seed=${2:-$(date +%s)}
cargo build --release --example fuzz
ulimit -v $((6 * 1024 * 1024))
current=$(mktemp)
trap 'rm -f "$current"' EXIT
end=$(($(date +%s) + minutes * 60))
failed=0
while left=$((end - $(date +%s))); [ "$left" -gt 0 ]; do
    code=0
    ./target/release/examples/fuzz --minutes "$(awk "BEGIN { print $left / 60 }")" --seed "$seed" --current "$current" || code=$?
    [ "$code" -eq 0 ] || failed=1
    [ "$code" -gt 1 ] || break
    seed=$(cat "$current")
    echo "seed $seed ended the process with code $code; its input: ./target/release/examples/fuzz --show $seed"
    seed=$((seed + 1))
done
exit "$failed"
