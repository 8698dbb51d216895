# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives Blender's window as a user would; see run.sh. Every check prints a line that begins with "GUI:"."""

import math
import os
import subprocess
import time
import traceback

import bpy

SHOTS = "/session/shots"
MODULE = "bl_ext.user_default.sundog"
ESCAPE_BOUND = 0.5

events = []
failures = []


def say(text):
    print("GUI:", text, flush=True)


def check(holds, what):
    say(("ok: " if holds else "FAILED: ") + what)
    if not holds:
        failures.append(what)


def shot(name):
    """Saves what the screen shows; gives the file."""
    path = os.path.join(SHOTS, name + ".png")
    subprocess.run(["import", "-window", "root", path], check=True)
    return path


def difference(a, b):
    """Pixels in which two screenshots differ by more than an eighth."""
    done = subprocess.run(["compare", "-metric", "AE", "-fuzz", "12%", a, b, "null:"], capture_output=True, text=True, check=False)
    return float(done.stderr.split()[0])


def key(name):
    """Presses a key over Blender's window, which must have the focus: no window manager gives it back to it."""
    found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "Blender"], capture_output=True, text=True, check=False)
    for window in found.stdout.split()[:1]:
        subprocess.run(["xdotool", "windowfocus", window], check=False)
    subprocess.run(["xdotool", "key", name], check=True)


def point_at(x, y):
    subprocess.run(["xdotool", "mousemove", str(x), str(y)], check=True)


def note(kind):
    def handler(*_):
        events.append((kind, time.perf_counter()))
    return handler


def happened(kind, since):
    return next((at for name, at in events if name == kind and at >= since), None)


def until(condition, limit):
    """Waits, in steps of a twentieth of a second; the generator's value is what the condition gave."""
    begun = time.perf_counter()
    while time.perf_counter() - begun < limit:
        value = condition()
        if value:
            return value
        yield 0.05
    return None


def build_scene():
    """Something to look at: lamps of three kinds, a glossy ball on a floor, text."""
    for item in list(bpy.data.objects):
        if item.type != "CAMERA":
            bpy.data.objects.remove(item)
    bpy.ops.mesh.primitive_plane_add(size=20)
    bpy.ops.mesh.primitive_uv_sphere_add(location=(0, 0, 1), segments=64, ring_count=32)
    bpy.ops.object.shade_smooth()
    gold = bpy.data.materials.new("gold")
    gold.use_nodes = True
    shader = gold.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (1.0, 0.7, 0.2, 1)
    shader.inputs["Metallic"].default_value = 1
    shader.inputs["Roughness"].default_value = 0.2
    bpy.context.object.data.materials.append(gold)
    bpy.ops.object.text_add(location=(1.4, -1.5, 0.02), rotation=(math.pi / 2, 0, 0.8))
    bpy.context.object.data.body = "Sundog"
    bpy.context.object.data.extrude = 0.05
    bpy.ops.object.light_add(type="AREA", location=(-3, -2, 4), rotation=(0.5, -0.6, 0))
    bpy.context.object.data.energy = 300
    bpy.context.object.data.size = 2
    bpy.ops.object.light_add(type="SPOT", location=(3, 2, 5), rotation=(-0.4, 0.5, 0))
    bpy.context.object.data.energy = 400
    bpy.ops.object.light_add(type="POINT", location=(4, -4, 2))
    bpy.context.object.data.energy = 100


def properties(tab):
    for area in bpy.context.window_manager.windows[0].screen.areas:
        if area.type == "PROPERTIES":
            area.spaces.active.context = tab


def settled(seconds=1.0):
    """Long enough for the window to be drawn (llvmpipe is slow)."""
    yield seconds


def render_result_pixels():
    path = "/session/result.exr"
    bpy.context.scene.render.image_settings.file_format = "OPEN_EXR"
    bpy.data.images["Render Result"].save_render(path)
    image = bpy.data.images.load(path)
    pixels = list(image.pixels)
    bpy.data.images.remove(image)
    return pixels


def effects_panel(window):
    """The list of effects after a check of the scene, and a click on one of its buttons, which selects what calls for an effect."""
    with bpy.context.temp_override(window=window):
        bpy.ops.sundog.check_scene()
        bpy.ops.object.select_all(action="DESELECT")
    properties("RENDER")
    area = next(a for a in window.screen.areas if a.type == "PROPERTIES")
    # The filter shows this panel alone, and opens it.
    area.spaces.active.search_filter = "Effects"
    yield from settled(2)
    shot("4-effects")
    top, right = window.height - (area.y + area.height), area.x + area.width

    def selected():
        return sorted(o.name for o in bpy.context.view_layer.objects if o.select_get())

    # The buttons stand below each other at the right edge; where exactly depends on the font and the theme.
    for x in range(right - 24, right - 64, -10):
        for y in range(top + 60, top + 400, 8):
            point_at(x, y)
            subprocess.run(["xdotool", "click", "1"], check=True)
            yield 0.15
            if selected():
                break
        if selected():
            break
    yield from settled()
    shot("4-effects-selected")
    check(bool(selected()), f"a click in the list of effects selects what calls for one ({', '.join(selected())})")
    area.spaces.active.search_filter = ""


def session():
    for kind in ("render_init", "render_complete", "render_cancel"):
        getattr(bpy.app.handlers, kind).append(note(kind))
    preferences = bpy.context.preferences
    preferences.view.render_display_type = "AREA"
    # The splash screen stands over everything until a click beside it.
    point_at(300, 800)
    subprocess.run(["xdotool", "click", "1"], check=True)
    yield from settled()
    scene = bpy.context.scene
    build_scene()

    # Install as the preferences' "Install from Disk" does.
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window):
        bpy.ops.extensions.package_install_files(filepath="/session/addon.zip", repo="user_default", enable_on_install=True)
    # The installation runs as a job of the window.
    yield from until(lambda: MODULE in preferences.addons, 60)
    check(MODULE in preferences.addons, "the .zip installs and is enabled")
    preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "Sundog"
    with bpy.context.temp_override(window=window):
        bpy.ops.screen.userpref_show("INVOKE_DEFAULT")
        bpy.ops.preferences.addon_expand(module=MODULE)
    yield from settled(2)
    other = bpy.context.window_manager.windows[-1]
    with bpy.context.temp_override(window=other):
        bpy.ops.sundog.test_program()
    yield from settled(2)
    shot("1-preferences")
    with bpy.context.temp_override(window=other):
        bpy.ops.wm.window_close()

    scene.render.engine = "SUNDOG"
    check(scene.render.engine == "SUNDOG", "the engine can be chosen")
    for tab in ("RENDER", "OUTPUT", "VIEW_LAYER"):
        properties(tab)
        yield from settled()
        shot(f"2-panels-{tab.lower()}")
    for kind in ("LIGHT", "CAMERA", "MESH"):
        chosen = bpy.data.objects["Sphere"] if kind == "MESH" else next(o for o in bpy.data.objects if o.type == kind)
        for item in bpy.context.view_layer.objects:
            item.select_set(item is chosen)
        bpy.context.view_layer.objects.active = chosen
        properties("OBJECT")
        # The tabs follow the active object when the window is drawn again.
        yield from settled()
        properties("DATA" if kind != "MESH" else "MATERIAL")
        yield from settled()
        shot(f"3-panels-{kind.lower()}")
    properties("WORLD")
    yield from settled()
    shot("3-panels-world")

    yield from effects_panel(window)

    # F12, watch it refine, Esc.
    properties("RENDER")
    scene.render.resolution_x, scene.render.resolution_y = 1280, 720
    scene.sundog.samples = 100000
    point_at(500, 400)
    pressed = time.perf_counter()
    key("F12")
    began = yield from until(lambda: happened("render_init", pressed), 20)
    check(began is not None, "F12 starts a render")
    yield 1.5
    early = shot("5-f12-early")
    yield 8
    late = shot("6-f12-later")
    changed = difference(early, late)
    check(changed > 2000, f"the picture refines ({changed:.0f} pixels of the screen changed)")
    check(happened("render_complete", pressed) is None, "it is still rendering")
    point_at(500, 400)
    pressed = time.perf_counter()
    key("Escape")
    ended = yield from until(lambda: happened("render_cancel", pressed) or happened("render_complete", pressed), 20)
    took = (ended - pressed) if ended else math.inf
    check(took <= ESCAPE_BOUND, f"Esc ends it after {took:.2f} s (bound {ESCAPE_BOUND} s)")
    yield from settled(1.5)
    after = shot("7-after-escape")
    kept = render_result_pixels()
    check(sum(kept) / len(kept) > 0.05, f"the picture is kept (mean {sum(kept) / len(kept):.3f})")
    check(difference(late, after) < 400_000, "the window still shows it")
    left = subprocess.run(["pgrep", "-x", "sundog"], capture_output=True, text=True, check=False).stdout.split()
    check(not left, "no process of the program is left")

    # To the end.
    scene.sundog.samples = 16
    pressed = time.perf_counter()
    key("F12")
    ended = yield from until(lambda: happened("render_complete", pressed), 120)
    check(ended is not None, "a render of 16 samples comes to its end")
    yield from settled(1.5)
    shot("8-complete")

    # A program that crashes.
    addon = preferences.addons[MODULE].preferences
    with open("/session/crash.sh", "w") as file:
        file.write("#!/bin/sh\necho 'the last words' >&2\nkill -SEGV $$\n")
    os.chmod("/session/crash.sh", 0o755)
    addon.program = "/session/crash.sh"
    pressed = time.perf_counter()
    key("F12")
    yield from until(lambda: happened("render_complete", pressed) or happened("render_cancel", pressed), 30)
    yield from settled(2)
    shot("9-crash")
    addon.program = ""
    pressed = time.perf_counter()
    key("F12")
    ended = yield from until(lambda: happened("render_complete", pressed), 120)
    check(ended is not None, "Blender lives on after the program's crash, and renders again")

    # Beside Cycles.
    scene.render.resolution_percentage = 25
    with bpy.context.temp_override(window=window):
        bpy.ops.sundog.compare("INVOKE_DEFAULT")
    found = yield from until(lambda: any("Difference" in i.name for i in bpy.data.images), 300)
    check(bool(found), "the comparison with Cycles shows its pictures")
    yield from settled(2)
    shot("10-compare")


def run():
    state = {"steps": session()}

    def step():
        try:
            return next(state["steps"])
        except StopIteration:
            pass
        except Exception:
            failures.append("exception")
            say("FAILED: " + traceback.format_exc().replace("\n", " | "))
            try:
                shot("failed")
            except Exception as error:
                say(str(error))
        say(f"all done, {len(failures)} failed")
        # Not quit_blender: it may ask whether to save.
        os._exit(3 if failures else 0)

    bpy.app.timers.register(step, first_interval=3)


run()
