# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a picture of Sundog's differs from Cycles', and the page that tells it."""

import collections
import time

LUMINANCE_BOUND = 0.01
RELMSE_BOUND = 1e-3

# What was found by looking into a scene, where the verdicts alone do not say it. Beginning of the name -> reason.
FOUND = {
    "IORTestGrid": "noise of a few pixels: with 1536 samples it agrees, 0.9997 ± 0.0014 and 1.9e-04 ± 2e-04",
    "lit-veach-mis": "noise of a few pixels: with 1536 samples 1.006 ± 0.031, too noisy to tell, and 9.4e-05 ± 6e-05",
}


def agrees(told):
    """Whether both bounds hold, each with two standard errors granted to the noise."""
    return (abs(told["luminance"] - 1) <= LUMINANCE_BOUND + 2 * told["luminance_error"]
            and told["relmse"] <= RELMSE_BOUND + 2 * told["relmse_error"])


def is_quiet(told):
    """Whether the noise is small enough for agreement to mean something."""
    return told["luminance_error"] <= LUMINANCE_BOUND / 2 and told["relmse_error"] <= RELMSE_BOUND


def of(name, told):
    """The reason in one line."""
    if told["black"]:
        return "black in Cycles"
    found = [text for start, text in FOUND.items() if name.startswith(start)]
    said = collections.Counter()
    inexact = [entry for entry in told["verdicts"] if entry["verdict"] != "exact"]
    # What the program says repeats what the add-on foresaw, if it foresaw anything.
    foreseen = [entry for entry in inexact if entry["kind"] != "program"]
    for entry in foreseen or inexact:
        for detail in entry["detail"].split("; "):
            said[f"{entry['kind']}: {detail}"] += 1
    if agrees(told) and not is_quiet(told):
        return "no difference beyond the noise, which is too large to tell more"
    if agrees(told) and not found:
        return "agrees" + (f" ({len(said)} kinds of approximation named)" if said else "")
    if not found and not said:
        return "**unexplained**"
    return "; ".join(found + [f"{text} ({n})" if n > 1 else text for text, n in said.most_common(4)])


def page(rows, results, given, version):
    """docs/notes/cycles-parity.md."""
    rendered = [told for told in results if not told.get("problem")]
    good = sum(1 for told in rendered if agrees(told) and is_quiet(told))
    noisy = sum(1 for told in rendered if agrees(told) and not is_quiet(told))
    return "\n".join([
        "# Parity with Cycles on scenes of others",
        "",
        "Made by `tests/parity/parity.py`; the reasons that the add-on's verdicts do not give are in `tests/parity/reasons.py`.",
        "",
        f"- {time.strftime('%Y-%m-%d', time.gmtime())}, Blender {version}, imported by Blender, rendered through the add-on and with Cycles (CPU,"
        f" unbiased settings, the same bounces), {given.pixels} pixels, 2 × {given.samples} samples each.",
        "- Scenes that bring no light stand in an environment picture (`studio_small_05`, CC0); all but the `lit-` and `trap-` ones are framed alike.",
        "- Verdicts: how many materials, lights, worlds and cameras are exact / approximated / lost by the add-on's own words.",
        "- luminance: Sundog's mean over Cycles' ± its standard error. relMSE with the noise of both cancelled (it can be below 0) ± its",
        "  standard error. FLIP (LDR, \"Standard\" view) of the means, noise included.",
        f"- {good} of {len(rendered)} agree: luminance within 1 % and relMSE below 1e-3, each but for two standard errors. {noisy} more are"
        " too noisy to tell (a standard error above 0.5 % or 1e-3).",
        "",
        "| scene | verdicts | luminance | relMSE | FLIP | what differs, and why |",
        "| --- | --- | --- | --- | --- | --- |",
        *rows,
        "",
    ])
