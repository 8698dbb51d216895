#!/usr/bin/env bash
# Writes NOTICES.md anew: run it when the dependencies in Cargo.toml or the pins in scripts/pins/ change.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
cd "$project_root"

cat >NOTICES.md.new <<'TEXT'
# Notices

Sundog itself is under MIT OR Apache-2.0 (`LICENSE-MIT`, `LICENSE-APACHE`), at your choice; `blender_addon/` is under
GPL-3.0-or-later (`blender_addon/LICENSE`). This repository holds no other project's files. What `make setup` fetches stays
on your machine; who hands a built Sundog on hands these on too, with their licences: the package of `make addon` has them all,
in `licences/`.

## Libraries that the program loads
`make setup` puts their licence texts into `.native/licences/`.

| library | version | licence | comes from |
| --- | --- | --- | --- |
| Embree | 4.4.0 (headers 4.3.3) | Apache-2.0 | PyPI's `embreex` 4.4.0.post1 (MIT; only the library in it is used); Debian's `libembree-dev` for the headers |
| oneTBB | as in that package | Apache-2.0 | the same |
| OpenColorIO | 2.6.0 | BSD-3-Clause; parts in `OpenColorIO-THIRD-PARTY.md` | PyPI's `opencolorio` 2.6.0 |
| inside OpenColorIO: Imath, yaml-cpp, expat, pystring, minizip-ng, zlib, sampleicc | as in that package | BSD-3-Clause, MIT, MIT, BSD-3-Clause, Zlib, Zlib, the ICC's licence | the same |
| Open Image Denoise with its weights; opened with `--denoise` alone | 2.5.1 | Apache-2.0 | PyPI's `pyoidn` 2.5.1.0 (MIT; only the libraries in it are used), into `.native/oidn/`; or an installed Blender's |
| inside it: oneTBB, oneDNN | as in that package | Apache-2.0 | the same |

## Tools of building and testing, no part of the program
| tool | licence | used for |
| --- | --- | --- |
| libclang 18.1.1 (PyPI's `libclang`) | Apache-2.0 WITH LLVM-exception | bindgen reads the headers with it |
| Blender as a Python module (PyPI's `bpy` 4.5.15 and 5.2.3; 4.2.23, 5.0.1, 5.1.2 and 5.3.0 for `make test-long`) and what it asks for | GPL-3.0-or-later, and its own | exports the scenes of `scenes/` and renders the tests' reference pictures, as a process of its own |
| Chromium (Debian's package), playwright, greenlet and pillow (PyPI) | BSD-3-Clause and others; Apache-2.0, MIT, MIT-CMU | opens reports in tests |
| Python 3.11 (Debian 12's packages), where the system has none | PSF-2.0 | runs `bpy` |

## Crates
Everything in the program, and what writes code for it at compile time. The texts come with each crate's source
(`~/.cargo/registry/src/`).

| crate | licence |
| --- | --- |
TEXT
cargo tree --locked -e normal --prefix none --target x86_64-unknown-linux-gnu -f '{p}|{l}' |
    sed 's/ (\*)$//; s/ v[0-9][^|]*|/|/; s|/| OR |g' | sort -u | grep -v '^sundog|' |
    awk -F '|' '{ printf "| %s | %s |\n", $1, $2 }' >>NOTICES.md.new
mv NOTICES.md.new NOTICES.md
