# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the experiments share: renders and their errors, references, contact sheets, plots, and the page that they go to."""

import base64
import json
import math
import os
import resource
import statistics
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tests", "pictures"))

import bpy  # noqa: E402
import compare  # noqa: E402
import numpy as np  # noqa: E402

# The code that decides what a converged picture looks like: references are made anew when it changes.
PHYSICS = ("math", "scene", "import", "effects", "shading", "light", "medium", "camera", "world", "integrator", "film/filter.rs")
TILE = 32
# A picture in the documentation is at most so large, in bytes.
LARGEST_PICTURE = 60_000


class Bench:
    """The program, the built scenes, and where things go."""

    def __init__(self, program, folder, quick):
        self.program, self.folder, self.quick = program, folder, quick
        os.makedirs(folder, exist_ok=True)
        self.flags = {flag["name"] for flag in render_flags(program)}
        self.overheads = {}

    def build(self, names):
        missing = [name for name in names if not os.path.exists(os.path.join(self.folder, f"{name}.glb"))]
        if missing:
            compare.build_scenes(missing, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def settings(self, name):
        with open(self.path(f"{name}.json")) as file:
            return json.load(file)

    def sundog(self, name, size, samples, seed, *more, path=None):
        """Renders a scene; gives the program's own statistics, with `seconds` and the `picture`."""
        path = path or self.path("experiment.exr")
        # Flags that are given again win, so that `more` has the last word.
        command = compare.sundog_command(self.program, self.folder, name, path, size, samples, seed)
        command = [flag for flag in command if flag.split("=")[0] not in {other.split("=")[0] for other in more}]
        said, cpu = timed([*command, "--json", *more], f"Sundog's picture of {name}")
        for line in reversed(said.splitlines()):
            event = json.loads(line)
            if event.get("event") == "finished":
                told = event["statistics"]
                wall = seconds_of(told["trace"])
                return {**told, "wall": wall, "cpu": cpu, "picture": compare.read_exr(path), "path": path}
        raise compare.Failure(f"Sundog did not say that {name} is finished")

    def cycles(self, name, size, samples, seed, *more, path=None):
        """Renders a scene with Cycles, without what biases it."""
        path = path or self.path("experiment-cycles.exr")
        said, cpu = timed(
            [sys.executable, os.path.join(compare.SCRIPTS, "render_cycles.py"), self.path(f"{name}.blend"), path, "--samples",
             str(samples), "--seed", str(seed), "--width", str(size[0]), "--height", str(size[1]), *more], f"Cycles' picture of {name}")
        told = json.loads(said.strip().splitlines()[-1])
        if told["seconds"] is None:
            raise compare.Failure(f"Cycles' log of {name} does not say when it began and ended")
        return {"wall": told["seconds"], "cpu": cpu, "picture": compare.read_exr(path), "path": path}

    def overhead(self, program, name):
        """Processor seconds that a program takes beside path tracing: those of a picture of a single pixel or of a few."""
        if (program, name) not in self.overheads:
            if program == "cycles":
                runs = [self.cycles(name, (16, 9), 1, 1) for _ in range(2)]
            else:
                runs = [self.sundog(name, (1280, 720), 1, 1, "--region=0,0,1,1") for _ in range(3)]
            self.overheads[program, name] = min(run["cpu"] for run in runs)
        return self.overheads[program, name]

    def references(self, name, size, samples, *more, peer=0):
        """Two independent pictures of the truth: both Sundog's, or (with `peer` samples of its own) one of them Cycles'."""
        cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
        about = f"{name} {size} {samples} {more} {peer} {bpy.app.version_string if peer else ''}"
        key = compare.digest(about.encode(), *physics(), *compare.inputs(name, self.folder))
        kept = os.path.join(cache, "sundog", "references", f"experiment-{key}")
        paths = [os.path.join(kept, "a.exr"), os.path.join(kept, "b.exr")]
        os.makedirs(kept, exist_ok=True)
        for index, path in enumerate(paths):
            if os.path.exists(path):
                continue
            unfinished = f"{path[:-4]}.{os.getpid()}.exr"
            if peer and index == 0:
                self.cycles(name, size, peer, 900, path=unfinished)
            else:
                self.sundog(name, size, samples, 901 + index, *more, path=unfinished)
            os.replace(unfinished, path)
        return [compare.read_exr(path) for path in paths]


def timed(command, what):
    """What a program says, and the processor seconds that it took, all threads together."""
    used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    before = used()
    said = compare.run(command, what)
    return said, used() - before


def render_flags(program):
    listing = json.loads(compare.run([program, "flags", "--json"], "the list of flags"))
    render = next(command for command in listing["commands"] if command["name"] == "render")
    return [argument for group in render["groups"] for argument in group["arguments"]]


def physics():
    """The bytes of the program that a converged picture depends on."""
    for part in PHYSICS:
        part = os.path.join(ROOT, "src", part)
        inside = [os.path.join(folder, file) for folder, _, files in os.walk(part) for file in files]
        for path in sorted(inside) or [part]:
            with open(path, "rb") as source:
                yield source.read()


def seconds_of(duration):
    """A duration as the program writes it: seconds, or {"secs", "nanos"}."""
    if isinstance(duration, dict):
        return duration["secs"] + duration["nanos"] * 1e-9
    return float(duration)


# ---- Errors ----


def error_map(x, a, b):
    """An estimate of the relative square error of each pixel.

    a and b are independent pictures of the truth r. (x - a)(x - b) has the expectation (x - r)^2 whatever their noise is, so
    neither needs to be free of it. If x and b are of one program and a of another one that differs from it in some pixels,
    the expectation is still that of the noise of x alone (and the same if x is of the other program).
    """
    r = (a + b) / 2.0
    return ((x - a) * (x - b) / (r * r + 0.01)).mean(axis=2)


def root(square):
    """The error in percent of a mean square; estimates of very small ones may come out below 0."""
    return 100.0 * math.sqrt(max(square, 0.0))


def worst_tile(errors):
    """The error in percent of the worst of the tiles, 20 of which are as wide as the picture, but no larger than TILE."""
    height, width = errors.shape
    side = min(TILE, width // 20)
    tiles = [errors[y:y + side, x:x + side].mean() for y in range(0, height - side + 1, side) for x in range(0, width - side + 1, side)]
    return root(max(tiles))


def needed(rows, measure, wanted):
    """The processor seconds in which rows of rising numbers of samples come down to an error: between two of them the logarithms of
    both are a straight line, beyond them the error falls with the root of time."""
    points = sorted((getattr(row, measure), row.seconds) for row in rows)
    if wanted <= points[0][0]:
        return points[0][1] * (points[0][0] / wanted) ** 2
    if wanted >= points[-1][0]:
        return points[-1][1] * (points[-1][0] / wanted) ** 2
    errors, seconds = zip(*points)
    return float(np.exp(np.interp(np.log(wanted), np.log(errors), np.log(seconds))))


class Row:
    """One setting of an experiment: several renders with different seeds."""

    def __init__(self, label, renders, references, size, samples, overhead):
        maps = [error_map(render["picture"], *references) for render in renders]
        truth = (references[0] + references[1]).mean() / 2.0
        self.label = label
        self.picture = renders[0]["picture"]
        self.map = np.mean(maps, axis=0)
        self.wall = statistics.median(render["wall"] for render in renders)
        self.seconds = max(statistics.median(render["cpu"] for render in renders) - overhead, 1e-3)
        self.samples = statistics.mean(render.get("mean_samples") or samples for render in renders)
        taken = size[0] * size[1] * self.samples
        self.ns = self.seconds / taken * 1e9
        self.rays = statistics.mean(render["rays"] for render in renders) / taken if "rays" in renders[0] else None
        self.square = statistics.mean(each.mean() for each in maps)
        self.error = root(self.square)
        self.worst = worst_tile(self.map)
        # Set where there is something to compare with.
        self.sooner = self.worst_sooner = None
        self.light = statistics.mean(render["picture"].mean() for render in renders) / truth

    def numbers(self):
        names = ("label", "samples", "wall", "seconds", "ns", "rays", "error", "worst", "light")
        return {name: getattr(self, name) for name in names}


def percent(value):
    return f"{value:.1f} %" if value >= 10.0 else f"{value:.2f} %"


def figure(value):
    """Three digits, without an exponent."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    return f"{value:.{max(0, 2 - math.floor(math.log10(abs(value))))}f}"


COLUMNS = {
    "samples": ("samples a pixel", lambda row, _: f"{row.samples:.0f}" if row.samples >= 10 else figure(row.samples)),
    "wall": ("seconds", lambda row, _: figure(row.wall)),
    "seconds": ("processor seconds", lambda row, _: figure(row.seconds)),
    "ns": ("processor ns a sample", lambda row, _: f"{row.ns:.0f}"),
    "rays": ("rays a sample", lambda row, _: "" if row.rays is None else figure(row.rays)),
    "error": ("error", lambda row, _: percent(row.error)),
    "worst": ("error of the worst tile", lambda row, _: percent(row.worst)),
    "worst-sooner": ("times sooner for the worst tile", lambda row, _: figure(row.worst_sooner) if row.worst_sooner else ""),
    "sooner": ("times sooner for the picture", lambda row, _: figure(row.sooner) if row.sooner else ""),
    "light": ("light there", lambda row, _: f"{100.0 * row.light:.1f} %"),
    # For the same error the first row needs so many times this one's time: errors fall with the root of time.
    "gain": ("speed at equal error", lambda row, rows: figure(rows[0].square * rows[0].seconds / max(row.square * row.seconds, 1e-30))),
}


def table(head, rows, columns):
    lines = ["| " + " | ".join([head, *(COLUMNS[name][0] for name in columns)]) + " |", "| --- " + "| ---: " * len(columns) + "|"]
    for row in rows:
        lines.append("| " + " | ".join([row.label, *(COLUMNS[name][1](row, rows) for name in columns)]) + " |")
    return "\n".join(lines)


# ---- Pictures ----


def write_exr(path, pixels):
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("sheet", width, height, alpha=False, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba[::-1].ravel())
    image.filepath_raw = path
    image.file_format = "OPEN_EXR"
    image.save()
    bpy.data.images.remove(image)


def sheet(pictures, across, gap=4):
    """Pictures of one size side by side, in rows, on white."""
    height, width = pictures[0].shape[:2]
    down = -(-len(pictures) // across)
    whole = np.full((down * (height + gap) - gap, across * (width + gap) - gap, 3), 1e3)
    for index, picture in enumerate(pictures):
        y, x = (index // across) * (height + gap), (index % across) * (width + gap)
        whole[y:y + height, x:x + width] = picture
    return whole


def write_jpeg(bench, path, pixels, view="Standard", exposure=0.0):
    """As good a JPEG as the documentation has room for."""
    linear = bench.path("sheet.exr")
    write_exr(linear, pixels)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    for quality in (90, 80, 70, 60, 50, 40, 30, 20):
        compare.run([bench.program, "color", "apply", linear, path, f"--view={view}", f"--exposure={exposure}",
                     f"--quality={quality}"], f"the picture {path}")
        if os.path.getsize(path) < LARGEST_PICTURE:
            return
    raise compare.Failure(f"{path} stays above {LARGEST_PICTURE} bytes")


def heat(errors, most):
    """Errors from 0 (black) to `most` (white) by way of red and yellow, as linear colours."""
    t = np.clip(np.sqrt(np.maximum(errors, 0.0)) / most, 0.0, 1.0)[..., None] * 3.0
    return np.clip(t - np.array([0.0, 1.0, 2.0]), 0.0, 1.0) ** 2.2


def blurred(errors):
    """Means over squares of 8 pixels: single estimates are too noisy to look at."""
    height, width = errors.shape
    whole = errors[:height // 8 * 8, :width // 8 * 8]
    small = whole.reshape(height // 8, 8, width // 8, 8).mean(axis=(1, 3))
    return np.kron(small, np.ones((8, 8)))


# ---- Plots ----

INK = ("#3b6fd4", "#d1495b", "#2a9d6f", "#b07c10", "#7d4fb3", "#4a4a4a")


def ticks(low, high):
    """1, 2 and 5 of each decade within bounds."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [m * 10.0 ** d for d in decades for m in (1, 2, 5) if low <= m * 10.0 ** d <= high]


def plot(title, x_name, y_name, series):
    """A log-log plot as SVG; `series` are (name, [(x, y, label)])."""
    points = [(x, y) for _, line in series for x, y, _ in line if x > 0.0 and y > 0.0]
    (left, right), (low, high) = ((min(v) / 1.3, max(v) * 1.3) for v in zip(*points))
    width, height, margin = 720, 420, (64, 40, 20, 56)
    across = lambda x: margin[0] + (math.log(x / left) / math.log(right / left)) * (width - margin[0] - margin[2])
    down = lambda y: height - margin[3] - (math.log(y / low) / math.log(high / low)) * (height - margin[1] - margin[3])
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
           f'<title>{title}</title><rect width="{width}" height="{height}" fill="#ffffff"/>',
           f'<text x="{margin[0]}" y="22" font-size="14" font-weight="bold">{title}</text>']
    for x in ticks(left, right):
        out.append(f'<path d="M{across(x):.1f} {margin[1]}V{height - margin[3]}" stroke="#e4e4e4"/>'
                   f'<text x="{across(x):.1f}" y="{height - margin[3] + 18}" text-anchor="middle">{x:g}</text>')
    for y in ticks(low, high):
        out.append(f'<path d="M{margin[0]} {down(y):.1f}H{width - margin[2]}" stroke="#e4e4e4"/>'
                   f'<text x="{margin[0] - 8}" y="{down(y) + 4:.1f}" text-anchor="end">{y:g}</text>')
    out.append(f'<text x="{(margin[0] + width - margin[2]) / 2:.0f}" y="{height - 12}" text-anchor="middle">{x_name}</text>'
               f'<text transform="translate(16 {(height - margin[3] + margin[1]) / 2:.0f}) rotate(-90)" text-anchor="middle">{y_name}</text>')
    for index, (name, line) in enumerate(series):
        ink = INK[index % len(INK)]
        line = [(across(x), down(y), label) for x, y, label in line if x > 0.0 and y > 0.0]
        out.append(f'<path d="M{" L".join(f"{x:.1f} {y:.1f}" for x, y, _ in line)}" fill="none" stroke="{ink}" stroke-width="2"/>')
        for x, y, label in line:
            out.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{ink}"/>'
                       f'<text x="{x + 6:.1f}" y="{y - 6:.1f}" fill="{ink}">{label}</text>')
        if len(series) > 1:
            out.append(f'<text x="{width - margin[2]}" y="{margin[1] + 16 + 16 * index}" text-anchor="end" fill="{ink}">{name}</text>')
    return "\n".join([*out, "</svg>", ""])


# ---- Pages ----


def data_url(path, kind):
    with open(path, "rb") as file:
        return f"data:{kind};base64,{base64.b64encode(file.read()).decode()}"


def insert(page, name, text, by="scripts/experiments.py"):
    """Puts an experiment's text between its markers; the page must have them."""
    begin, end = f"<!-- {name}: made by {by} -->", f"<!-- end of {name} -->"
    with open(page) as file:
        before, rest = file.read().split(begin, 1)
    after = rest.split(end, 1)[1]
    beside = page + ".new"
    with open(beside, "w") as file:
        file.write(f"{before}{begin}\n{text}\n{end}{after}")
    os.replace(beside, page)
