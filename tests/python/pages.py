# SPDX-License-Identifier: MIT OR Apache-2.0
"""Checks README.md, docs/guide.md and docs/sundog-and-cycles.md: short sentences, links that lead somewhere, and commands that run as written.

    pages.py SUNDOG FOLDER      the program, and an empty folder in which the commands run

Commands stand in fenced blocks of `sh`, one a line. They run in order in FOLDER, which has a small scene.glb, sky.exr and cycles.exr.
"""

import json
import os
import re
import struct
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGES = ("README.md", "docs/guide.md")
MOST_WORDS = 30
# What is not run here, and why. A target of the Makefile has to be there.
NOT_RUN = {
    "make demo": "it sets a machine up, builds and renders for a minute; scripts/test-clean.sh can run it on clean systems",
    "make test": "this test is a part of it",
    "make build": "it builds the release program; make demo begins with it",
    "make addon": "it builds the release program; tests/addon/test_package.py tests what it packs",
    "blender -b scene.blend -E SUNDOG -f 1": "it needs a Blender with the extension; tests/addon/test_package.py renders so with Blender as a module",
}


def read(page):
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        return file.read()


def blocks(text):
    """The text without its fenced blocks, and the blocks as pairs of language and content."""
    found = []
    rest = re.sub(r"^```(\w*)\n(.*?)^```$", lambda match: found.append(match.groups()) or "", text, flags=re.M | re.S)
    return rest, found


def sentences(text):
    """Each sentence of a page, and the line that begins its paragraph. Items of lists, cells of tables and headings end one."""
    text, _ = blocks(text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    paragraphs, last = [], None
    for line in text.splitlines():
        bare = line.strip()
        if not bare or bare.startswith("#") or bare.startswith("|"):
            paragraphs += [cell for cell in bare.strip("#|").split("|") if bare]
            last = None
        elif last is None or re.match(r"([-*]|\d+\.) ", bare):
            paragraphs.append(re.sub(r"^([-*]|\d+\.) ", "", bare))
            last = len(paragraphs) - 1
        else:
            paragraphs[last] += " " + bare
    for paragraph in paragraphs:
        yield from re.split(r"(?<=[.!?])[)*\"]*\s+", paragraph)


def words(sentence):
    return [word for word in sentence.split() if re.search(r"\w", word)]


def long_sentences(page):
    for sentence in sentences(read(page)):
        count = len(words(sentence))
        if count > MOST_WORDS:
            yield f"{page}: {count} words, {MOST_WORDS} are the most: {sentence}"


def commands(page):
    """The commands of a page in order. What looks like a block of code has to be fenced, so that none is missed."""
    text, found = blocks(read(page))
    assert not re.search(r"^    \S", re.sub(r"^(?:[-*]|\d+\.) .*\n(?: +.*\n)*", "", text, flags=re.M), re.M), f"{page}: a block of code is indented, not fenced"
    for language, content in found:
        assert language in ("sh", "text"), f"{page}: a block is {language!r}; only sh (commands, which are run) and text are known"
        if language == "sh":
            for line in content.replace("\\\n", " ").splitlines():
                line = re.sub(r"(^|\s+)#.*$", "", line).strip()
                if line:
                    yield re.sub(r"\s+", " ", line)


def dead_links(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", read(page)):
        path = os.path.join(ROOT, os.path.dirname(page), link.split("#")[0])
        if "://" not in link and not link.startswith("#") and not os.path.exists(path):
            yield f"{page}: {link} leads nowhere"


def what_renders():
    """The README's table has each effect that docs/effects.md calls lacking as not rendered, and none that is rendered."""
    table = read("README.md").split("## What renders, and what does not")[1].split("\n\n")[1]
    not_rendered = {item.strip() for row in table.splitlines() for item in re.split("[,;]", row.strip("|").split("|")[-1])}
    rows = [row.strip("|").split("|") for row in read("docs/effects.md").split("<!-- table -->")[1].split("<!-- end -->")[0].strip().splitlines()[2:]]
    assert len(rows) > 40, rows
    for effect, lacks in ((row[0].strip(), "not in the program yet" in row[3]) for row in rows):
        name = effect.replace("-", " ")
        if lacks != (name in not_rendered):
            yield f"README.md: {name} {'is not among' if lacks else 'is among'} what is not rendered, other than in docs/effects.md"


def write_scene(path):
    """A gold plate over a floor and a lamp, from above, in a picture of 32 × 24 pixels."""
    corners = [(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)]
    binary = b"".join(struct.pack("<3f", *corner) for corner in corners) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    down = [-(0.5**0.5), 0, 0, 0.5**0.5]
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual", "SUNDOG_scene"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"name": "Lamp", "type": "point", "intensity": 500.0}]}},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2, 3], "extensions": {"SUNDOG_scene": {"render": {"width": 32, "height": 24}}}}],
        "nodes": [
            {"name": "Floor", "mesh": 0},
            {"name": "Plate", "mesh": 1, "translation": [0, 0.2, 0], "scale": [0.4, 0.4, 0.4]},
            {"name": "Camera", "camera": 0, "translation": [0, 3, 0], "rotation": down},
            {"name": "Lamp", "translation": [0.5, 2, 0.5], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "materials": [
            {"name": "Paint", "pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.5, 0.4, 1], "metallicFactor": 0}},
            {"name": "Gold", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.8, 0.3, 1], "metallicFactor": 1, "roughnessFactor": 0.3}},
        ],
        "meshes": [{"name": name, "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": index}]} for index, name in enumerate(("Floor", "Plate"))],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4s2I", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def run(command, folder, program):
    """What is wrong with a command, or nothing."""
    environment = dict(os.environ, PATH=os.path.dirname(program) + os.pathsep + os.environ["PATH"])
    try:
        done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        return "took more than 120 seconds"
    return f"ended with code {done.returncode}: {done.stderr.strip()}" if done.returncode else None


def check_commands(folder, program):
    write_scene(os.path.join(folder, "scene.glb"))
    for name, size in (("cycles.exr", (32, 24)), ("sky.exr", (32, 16))):
        failure = run(f"sundog render scene.glb -o {name} --samples 4 --seed 7 --width {size[0]} --height {size[1]}", folder, program)
        assert failure is None, failure
    makefile, used, ran = read("Makefile"), set(), 0
    for page in PAGES:
        for command in commands(page):
            used.add(command)
            if command.startswith("make "):
                target = command.split()[1]
                if not re.search(rf"^{re.escape(target)}:", makefile, re.M):
                    yield f"{page}: the Makefile has no target {target}"
            if command not in NOT_RUN:
                ran += 1
                failure = run(command, folder, program)
                if failure:
                    yield f"{page}: {command}: {failure}"
    for command in set(NOT_RUN) - used:
        yield f"{command} is excepted, and no page has it"
    if ran < 8:
        yield f"only {ran} commands were found and run"
    print(f"{ran} commands ran")


def check_the_checks():
    """The checks find what they are for."""
    long = "word " * (MOST_WORDS + 1)
    assert [len(words(sentence)) for sentence in sentences(f"# Head\n\nShort. {long}\n- {long}")] == [1, 1, MOST_WORDS + 1, MOST_WORDS + 1]
    assert list(sentences("| a b | `c` |\n\nOne [two](x.md). Three!")) == [" a b ", " `c` ", "One two.", "Three!"]
    assert blocks("a\n```sh\nls # x\n```\nb\n")[1] == [("sh", "ls # x\n")]


def main():
    program, folder = (os.path.abspath(path) for path in sys.argv[1:3])
    check_the_checks()
    wrong = [finding for page in (*PAGES, "docs/sundog-and-cycles.md") for finding in long_sentences(page)]
    folders = ["README.md", "ARCHITECTURE.md", "scenes/README.md", "blender_addon/README.md"]
    for where in ("docs", "docs/notes"):
        folders += [f"{where}/{name}" for name in sorted(os.listdir(os.path.join(ROOT, where))) if name.endswith(".md")]
    wrong += [finding for page in folders for finding in dead_links(page)]
    wrong += what_renders()
    wrong += check_commands(folder, program)
    print("\n".join(wrong) or "the pages hold")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
