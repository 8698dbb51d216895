#!/usr/bin/env bash
# Says by what flags rustc builds for the running processor: those of x86-64-v3 where it has what they stand for (AVX2, BMI2, FMA …),
# else none. `make build` takes them; packages, which run on every processor, do not.
#     cpu-flags.sh [FILE]    FILE in place of /proc/cpuinfo
set -euo pipefail
needed="avx avx2 bmi1 bmi2 f16c fma abm movbe"
found=" $(sed -n 's/^flags[[:space:]]*: //p;' "${1:-/proc/cpuinfo}" 2>/dev/null | head -n 1) "
for flag in $needed; do
    case $found in
        *" $flag "*) ;;
        *) exit 0 ;;
    esac
done
echo "-C target-cpu=x86-64-v3"
