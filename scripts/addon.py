#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Packs the Blender add-on with the program: dist/sundog-VERSION-linux-x64.zip, for `make addon`.

    addon.py [--program FILE] [--out FOLDER]

A Blender extension: the files of blender_addon/sundog, the program in bin/ (stripped, its rpath without the folders of
this machine), the libraries that it loads beyond those of every system in lib/, and the licences of all of it. The same
input gives the same file, byte for byte. Refuses a program or library that needs a newer glibc than 2.34.
"""

import argparse
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
import zipfile

from elf import Elf

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ADDON = os.path.join(ROOT, "blender_addon", "sundog")
# Newest symbol versions of the system's own libraries that a package may need: glibc 2.34 (Rocky 9, Ubuntu 22.04, Debian
# 12 …), and for the C++ library GCC 11, which those have at least.
NEWEST = {"GLIBC": (2, 34), "GLIBCXX": (3, 4, 29), "CXXABI": (1, 3, 13), "GCC": (11, 0)}
# What every system that Blender runs on has. Never shipped: an older libstdc++ than the system's own is no service.
SYSTEM = re.compile(r"(ld-linux-x86-64|lib(c|m|dl|rt|pthread|util|gcc_s|stdc\+\+))\.so\.\d+$")
RPATH = ["$ORIGIN", "$ORIGIN/lib", "$ORIGIN/../lib"]
LEFT_OUT = re.compile(r"(^|/)(__pycache__|tests|bin|lib|licences|\..*)(/|$)|\.(pyc|pyo|orig|rej|blend1)$|~$")


class Failure(Exception):
    """What keeps the package from being made, in a sentence."""


def run(*command, cwd=ROOT):
    try:
        done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    except OSError as error:
        raise Failure(f"{command[0]} cannot be started ({error.strerror}): run `make setup`") from error
    if done.returncode:
        raise Failure(f"`{' '.join(command[:4])}` failed: {(done.stderr or done.stdout).strip()}")
    return done.stdout


def read(path):
    with open(path, "rb") as file:
        return file.read()


def crate_version():
    found = re.search(r'^version *= *"([^"]+)"', read(os.path.join(ROOT, "Cargo.toml")).decode(), re.MULTILINE)
    if not found:
        raise Failure("Cargo.toml names no version")
    return found[1]


def check_versions(name, elf):
    """Refuses what would not start on the oldest system that is promised."""
    for version in sorted(elf.versions()):
        kind, _, number = version.partition("_")
        numbers = re.fullmatch(r"\d+(\.\d+)*", number)
        if kind in NEWEST and (not numbers or tuple(map(int, number.split("."))) > NEWEST[kind]):
            allowed = f"{kind}_{'.'.join(map(str, NEWEST[kind]))}"
            raise Failure(f"{name} needs {version} and may need {allowed} at most: build it on an older system (Debian 12)")


def libraries(program):
    """The shared libraries that the program loads and a system need not have: name -> path."""
    found = {}
    for line in run("ldd", program).splitlines():
        parts = re.fullmatch(r"\s*(\S+) => (.+?)(?: \(0x[0-9a-f]+\))?", line)
        if not parts or SYSTEM.search(os.path.basename(parts[1])):
            continue
        if not os.path.isfile(parts[2]):
            raise Failure(f"{program} asks for {parts[1]}, which is not there: run `make build`")
        found[parts[1]] = parts[2]
    return found


def packed_program(path):
    """The program as it is handed on: stripped, and with no folder of this machine in its rpath."""
    with tempfile.TemporaryDirectory() as folder:
        stripped = os.path.join(folder, "sundog")
        run("strip", "--strip-all", "-o", stripped, path)
        elf = Elf(read(stripped), path)
    elf.cut_rpath(RPATH)
    check_versions(path, elf)
    return bytes(elf.data)


def packed_library(name, path):
    elf = Elf(read(path), path)
    check_versions(path, elf)
    for folder in elf.rpath():
        if not folder.startswith("$ORIGIN"):
            raise Failure(f"{path} has the rpath {folder}, which other machines don't have: take the libraries of `make setup`")
    return bytes(elf.data)


def addon_files():
    """The add-on's own files: name in the package -> content."""
    files = {}
    for folder, _, names in os.walk(ADDON):
        for name in names:
            path = os.path.join(folder, name)
            inside = os.path.relpath(path, ADDON)
            if not LEFT_OUT.search(inside):
                files[inside] = read(path)
    manifest = files.get("blender_manifest.toml")
    if manifest is None:
        raise Failure("blender_addon/sundog/blender_manifest.toml is missing")
    files["blender_manifest.toml"] = stamped(manifest.decode()).encode()
    return files


def stamped(manifest):
    """The manifest with the program's version: Cargo.toml is its one source."""
    text, count = re.subn(r'(?m)^version *=.*$', f'version = "{crate_version()}"', manifest)
    if count != 1:
        raise Failure("blender_addon/sundog/blender_manifest.toml needs one line that begins with `version =`")
    return text


# --- licences -------------------------------------------------------------------------------------------------------

LICENCE = re.compile(r"(LICEN[CS]E|COPYING|COPYRIGHT|NOTICE|UNLICENSE)", re.IGNORECASE)


def native_licences(shipped):
    """The texts that `make setup` keeps of the native libraries."""
    folder = os.path.join(ROOT, ".native", "licences")
    files = {}
    for base, _, names in os.walk(folder):
        for name in names:
            inside = os.path.relpath(os.path.join(base, name), folder)
            # libclang takes part in the build alone.
            if not inside.startswith("libclang"):
                files[f"licences/{inside}"] = read(os.path.join(base, name))
    if not files:
        raise Failure(f"the licences of {', '.join(sorted(shipped))} are not in .native/licences: run `make setup`, or build with its libraries")
    return files


def licence_texts(folder):
    """The licences in a crate's package: (file, text). Where it has no file of them: those at the heads of its C++ headers."""
    paths = [os.path.join(base, name) for base, _, names in os.walk(folder) for name in sorted(names)]
    texts = [(path, read(path)) for path in paths if LICENCE.match(os.path.basename(path)) and not path.endswith(".rs")]
    if not texts:
        heads = ((path, re.search(rb"/\*.*?\*/", read(path), re.DOTALL)) for path in paths if path.endswith(".h"))
        texts = [(path, head[0]) for path, head in heads if head and b"Redistribution and use" in head[0]]
    return [(os.path.relpath(path, folder), text.decode(errors="replace").strip()) for path, text in sorted(texts)]


def crate_licences():
    """One text with the licences of all crates in the program; equal texts stand there once."""
    linked = set()
    for line in run("cargo", "tree", "--locked", "-e", "normal", "--prefix", "none", "--target", "x86_64-unknown-linux-gnu", "-f", "{p}").splitlines():
        parts = line.split()
        linked.add((parts[0], parts[1].removeprefix("v")))
    metadata = json.loads(run("cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", "x86_64-unknown-linux-gnu"))
    texts, bare = {}, []
    for package in metadata["packages"]:
        if (package["name"], package["version"]) not in linked or package["source"] is None:
            continue
        folder = os.path.dirname(package["manifest_path"])
        title = f"{package['name']} {package['version']} ({package['license']})"
        found = licence_texts(folder)
        if not found:
            authors = ", ".join(package["authors"]) or "its authors"
            bare.append(f"{title}, {package['repository'] or 'crates.io'}, by {authors}")
        for path, text in found:
            texts.setdefault(text, []).append(f"{title}: {path}")
    parts = ["Licences of the Rust crates that the program contains. Equal texts stand here once.\n"]
    if bare:
        parts.append("Crates whose packages hold no text of their licence (see LICENSE-APACHE and LICENSE-MIT for its words):\n" + "\n".join(sorted(bare)) + "\n")
    for text, titles in sorted(texts.items(), key=lambda item: sorted(item[1])):
        parts.append("\n".join(sorted(titles)) + "\n\n" + text + "\n")
    return ("\n" + "-" * 100 + "\n\n").join(parts).encode()


def licences(shipped):
    files = native_licences(shipped)
    files["licences/crates.txt"] = crate_licences()
    for name in ("LICENSE-MIT", "LICENSE-APACHE", "NOTICES.md"):
        files[name] = read(os.path.join(ROOT, name))
    files["LICENSE"] = read(os.path.join(ROOT, "blender_addon", "LICENSE"))
    return files


# --- the package ----------------------------------------------------------------------------------------------------

def package(program):
    """All files of the package: name -> (content, executable)."""
    shipped = libraries(program)
    plain = {**addon_files(), **licences(shipped)}
    plain.update({f"lib/{name}": packed_library(name, path) for name, path in shipped.items()})
    files = {name: (content, False) for name, content in plain.items()}
    files["bin/sundog"] = (packed_program(program), True)
    return files


def write_zip(path, files):
    """Sorted, with one fixed time and fixed permissions."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            content, executable = files[name]
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.create_system = 3
            entry.external_attr = (0o100755 if executable else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=os.path.join(ROOT, "target", "release", "sundog"))
    parser.add_argument("--out", default=os.path.join(ROOT, "dist"))
    given = parser.parse_args()
    try:
        if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
            raise Failure(f"the package is for Linux on x86-64, and this is {platform.system()} on {platform.machine()}")
        os.makedirs(given.out, exist_ok=True)
        path = os.path.join(given.out, f"sundog-{crate_version()}-linux-x64.zip")
        write_zip(path + ".new", package(given.program))
        os.replace(path + ".new", path)
    except (Failure, OSError, ValueError) as error:
        sys.exit(f"addon: {error}")
    print(f"{os.path.relpath(path)}: {os.path.getsize(path) / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
