# SPDX-License-Identifier: GPL-3.0-or-later
"""What was found, for reading: as rows for the panel and as Markdown."""

from .. import records
from ..command import border

RELMSE = "the mean over pixels and channels of (a - b)² / (b² + 0.01), with b Cycles' picture. It contains the noise of both"
TIMES = (
    "Sundog's times are the add-on's and the program's own. Cycles' are those that it writes into its picture's header, to a"
    " hundredth of a second: synchronization (of the scene, its structures for ray tracing included) and rendering."
)


def rendered_pixels(render):
    """(x0, y0, x1, y1) of what is rendered."""
    return border(render)


def seconds(value):
    """A time, or a dash where there is none of its own."""
    return "—" if value is None else f"{value:.2f} s"


def _listed(samples):
    """Those of each view layer, where they differ."""
    return str(samples[0]) if len(set(samples)) == 1 else " + ".join(map(str, samples))


def rows(found):
    """(label, Sundog's, Cycles') for what each engine has."""
    sundog, cycles = found["engines"]["Sundog"], found["engines"]["Cycles"]
    linear = found["linear"]
    return [
        ("Export / synchronization", seconds(sundog["export"]), seconds(cycles["export"])),
        ("Scene preparation", seconds(sundog["prepare"]), "in the above" if cycles["prepare"] is None else seconds(cycles["prepare"])),
        ("Rendering", seconds(sundog["render"]), seconds(cycles["render"])),
        ("Whole call", seconds(sundog["whole_call"]), seconds(cycles["whole_call"])),
        ("Samples a pixel", _listed(sundog["samples"]), _listed(cycles["samples"]) + (" at most" if found["adaptive"] else "")),
        ("ns per pixel sample", *("—" if side["ns_per_sample"] is None else f"{side['ns_per_sample']:.0f}" for side in (sundog, cycles))),
        ("Mean luminance", f"{linear['mean_luminance_a']:.5f}", f"{linear['mean_luminance_b']:.5f}"),
    ]


def differences(found):
    """(label, value) for what is between the pictures."""
    linear, shown = found["linear"], found["shown"]
    ratio = linear["luminance_ratio"]
    result = [
        ("Mean luminance ratio", "none: Cycles' picture is black" if ratio is None else f"{ratio:.5f}"),
        ("relMSE, noise of both included", f"{linear['rel_mse']:.5g}"),
        ("FLIP, Standard view", f"{linear['flip']:.4f}"),
        (f"FLIP, this scene's view ({found['view'][1]})", f"{shown['flip']:.4f}"),
    ]
    error = found["engines"]["Sundog"]["error"]
    if error is not None:
        low, middle, high = (f"{error[key] ** 2:.5g}" for key in ("low", "error", "high"))
        result.insert(2, ("Sundog's own part of it (estimated)", f"{middle} ({low} to {high})"))
    lost = linear["non_finite_a"] + linear["non_finite_b"]
    if lost:
        result.append(("Pixels that are not finite, left out", f"{linear['non_finite_a']} and {linear['non_finite_b']}"))
    return result


def _escaped(text):
    return str(text).replace("|", "\\|")


def _table(head, lines):
    yield "| " + " | ".join(map(_escaped, head)) + " |"
    yield "| --- " * len(head) + "|"
    for line in lines:
        yield "| " + " | ".join(map(_escaped, line)) + " |"


def markdown(found):
    """comparison.md."""
    width, height = found["size"]
    settings = (
        "matched: the same samples, bounces, seed, filter, clamping and filter glossy; Cycles on the CPU, without noise threshold, denoising and light threshold"
        if found["matched"]
        else "Cycles as the file has it" + (", denoised" if found["denoised"] else "") + (", with a noise threshold" if found["adaptive"] else "")
    )
    lines = [
        "# Sundog and Cycles",
        "",
        f"- {found['file'] or 'a file that is not saved'}, scene \"{found['scene']}\", frame {found['frame']}, {width} × {height} pixels,"
        f" view {found['view'][1]} ({found['view'][0]}{', look ' + found['view'][2] if found['view'][2] not in ('', 'None') else ''})",
        f"- Sundog {found['engines']['Sundog']['version']}, Cycles of Blender {found['engines']['Cycles']['version']}, {found['threads']} threads",
        f"- Settings {settings}",
        "",
        *_table(("", "Sundog", "Cycles"), rows(found)),
        "",
        TIMES,
        "",
        *_table(("Sundog against Cycles", ""), differences(found)),
        "",
        f"relMSE is {RELMSE}: two pictures that converge to the same one differ by it until they have.",
        "difference.png shows where the linear pictures differ, difference-view.png where those that one sees do.",
        "",
        "## Not exact in Sundog's picture",
        "",
    ]
    groups = [f"- {line}" for line in records.verdict_lines(found["verdicts"])]
    return "\n".join([*lines, *(groups or ["Nothing: all is exact."]), ""])
