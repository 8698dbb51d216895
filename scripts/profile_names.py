#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Makes a profile outlive changes of the program, for scripts/profile.sh: text profile of llvm-profdata to text profile.

    profile_names.py IN OUT

A function that is used in one part of the program alone (rustc compiles in four, "codegen units") has the part's number in its name.
A change elsewhere may move it, so that each function of ours gets the counts in all parts, and without one.

What is seldom run is left out: the compiler takes it for neither hot nor cold, so that a scene of another kind than those that were counted
has no worse code than without a profile.
"""

import collections
import re
import sys

PARTS = 4
# Of all counts, what is kept has more than this share each.
KEPT = 1e-6
OURS = re.compile(r"(?:(sundog\.[0-9a-f]+-cgu)\.\d+;)?(_ZN.*)", re.DOTALL)


def functions(text):
    """The lines that say what kind of profile it is, and (name, the rest) of each function."""
    head = re.match(r"(?:[#:].*\n)*", text)[0]
    return head, [block.split("\n", 1) for block in text[len(head) :].strip("\n").split("\n\n")]


def counters(rest):
    lines = rest.split("\n")
    at = lines.index("# Counter Values:") + 1
    many = int(lines[lines.index("# Num Counters:") + 1])
    return [int(line) for line in lines[at : at + many]]


def main():
    source, target = sys.argv[1:]
    with open(source, encoding="utf-8") as file:
        head, found = functions(file.read())
    counted = [(name, rest, sum(counters(rest))) for name, rest in found]
    least = KEPT * sum(count for _, _, count in counted)
    # Those of the library: the program has a function or two.
    units = collections.Counter(m[1] for name, _, _ in counted if (m := OURS.fullmatch(name)) and m[1])
    unit = units.most_common(1)[0][0]
    kept = 0
    with open(target, "w", encoding="utf-8") as file:
        file.write(head)
        for name, rest, count in counted:
            if count < least:
                continue
            kept += 1
            ours = OURS.fullmatch(name)
            names = [name]
            if ours and (ours[1] == unit or "6sundog" in name):
                names = [ours[2], *(f"{unit}.{part};{ours[2]}" for part in range(PARTS))]
            for each in names:
                file.write(f"{each}\n{rest}\n\n")
    print(f"{kept} of {len(counted)} functions have more than {KEPT} of the counts each")


if __name__ == "__main__":
    main()
