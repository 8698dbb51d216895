# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves while the shutter is open: matrices and vertices at the times at which Cycles asks for them.

As in Cycles, lamps stand still, and so do materials, the world, focus and clip planes.
"""

import math

import bpy
import numpy

from . import geometry
from .verdicts import LOST, Finding

# As many as Cycles has: Embree takes no more.
MOST_STEPS = 129

# Entries of a shutter's curve.
CURVE = 256


def is_on(scene, view_layer):
    """Whether Cycles would blur."""
    return scene.render.use_motion_blur and view_layer.use_motion_blur


def steps(shown, parent=None):
    """At how many times Cycles looks where an object is; 0 where it is not blurred."""
    count = 1
    for thing in (shown, parent):
        settings = getattr(thing, "cycles", None)
        if settings is not None and hasattr(settings, "use_motion_blur"):
            if not settings.use_motion_blur:
                return 0
            count = max(count, settings.motion_steps)
    return min((2 << (count - 1)) + 1, MOST_STEPS)


def times(count):
    """Those times, from −1 where the shutter opens to 1 where it closes."""
    return [2 * step / (count - 1) - 1 for step in range(count)]


def _deforms(shown, parent, scene):
    for thing in (shown, parent):
        settings = getattr(thing, "cycles", None)
        if settings is not None and not getattr(settings, "use_deform_motion", True):
            return False
    return shown.original.is_deform_modified(scene, "RENDER")


class Deformation:
    """A mesh at some times: `steps` of positions and normals (of vertices or of corners, as the mesh has them; None where it
    has none), None for the middle one, which is the mesh itself."""

    def __init__(self, mesh, count):
        self.domain = mesh.normals_domain
        self.middle = geometry.step_of(mesh, self.domain)
        self.steps = [None] * count
        self.changes = False
        self.moves = False

    def add(self, mesh, step):
        """Takes note of a step."""
        found = geometry.step_of(mesh, self.domain)
        if [len(a) for a in found if a is not None] != [len(a) for a in self.middle if a is not None]:
            self.changes = True
            return
        self.steps[step] = found
        self.moves = self.moves or not numpy.array_equal(found[0], self.middle[0])

    def whole(self):
        """The steps, if there is a motion that can be told."""
        missing = any(found is None for step, found in enumerate(self.steps) if step != len(self.steps) // 2)
        return self.steps if self.moves and not self.changes and not missing else None


class Motion:
    """One shutter's motion. `move(frame, subframe)` brings the depsgraph to a time."""

    def __init__(self, depsgraph, scene, move, still=False):
        """`still`: nothing is blurred; it is looked where things are a frame before and after."""
        self.still = still
        self.depsgraph, self.scene, self.move = depsgraph, scene, move
        render, cycles = scene.render, getattr(scene, "cycles", None)
        self.frame = scene.frame_current + scene.frame_subframe
        self.length = 2.0 if still else render.motion_blur_shutter
        position = getattr(render, "motion_blur_position", None) or getattr(cycles, "motion_blur_position", "CENTER")
        self.middle = self.frame + (not still) * {"START": 0.5, "END": -0.5}.get(position, 0.0) * self.length
        self._matrices = {}
        self._meshes = {}
        self._camera = {}
        self._window = None
        # The one of the frame: markers may change it on the way.
        self._eye = scene.camera.original

    def _go(self, time):
        self.move(math.floor(time), time - math.floor(time))

    def _instances(self):
        for instance in self.depsgraph.object_instances:
            if instance.show_self and instance.object.type == "MESH":
                yield instance, instance.parent if instance.is_instance else None

    def record(self, window):
        """Looks at all times, and leaves the depsgraph in the middle. `window(camera)`: edges of the picture."""
        if self.middle != self.frame:
            self._go(self.middle)
        wanted = set()
        for instance, parent in self._instances():
            count = self._steps(instance.object, parent)
            if not count:
                continue
            wanted.update(times(count))
            self._matrices[_key(instance)] = [None] * count
            name = instance.object.name_full
            if name not in self._meshes and _deforms(instance.object, parent, self.scene):
                with geometry.readable(instance.object) as mesh:
                    self._meshes[name] = Deformation(mesh, count)
        camera = self._shown_camera()
        count = self._steps(camera)
        self._camera = dict.fromkeys(times(count)) if count else {}
        wanted.update(self._camera)
        self._window = {0.0: window(camera)}
        for time in sorted(wanted):
            if time == 0:
                continue
            self._go(self.middle + time * self.length / 2)
            self._look(time)
            if abs(time) == 1:
                self._window[time] = window(self._shown_camera())
        self._go(self.middle)
        self._look(0.0)

    def _steps(self, shown, parent=None):
        return 3 if self.still else steps(shown, parent)

    def _shown_camera(self):
        return self._eye.evaluated_get(self.depsgraph)

    def _look(self, time):
        """Takes note of where everything is."""
        seen = set()
        for instance, _ in self._instances():
            matrices = self._matrices.get(_key(instance))
            if matrices is not None and (step := _step(time, len(matrices))) is not None:
                matrices[step] = numpy.array(instance.matrix_world, float)
            name = instance.object.name_full
            deformation = self._meshes.get(name)
            if deformation is None or name in seen or time == 0:
                continue
            seen.add(name)
            if (step := _step(time, len(deformation.steps))) is not None:
                with geometry.readable(instance.object) as mesh:
                    deformation.add(mesh, step)
        if time in self._camera:
            self._camera[time] = numpy.array(self._shown_camera().matrix_world, float)

    def of(self, instance):
        """The matrices of an instance at its times; None where it stands still."""
        found = self._matrices.get(_key(instance))
        if found is None:
            return None
        middle = found[len(found) // 2]
        if middle is None:
            return None
        # What is not there at a time is where it is in the middle, as in Cycles.
        found = [middle if matrix is None or not numpy.isfinite(matrix).all() else matrix for matrix in found]
        return None if all(numpy.array_equal(matrix, middle) for matrix in found) else found

    def of_mesh(self, shown, findings):
        """The steps of an object's mesh; None where it keeps its shape."""
        found = self._meshes.get(shown.name_full)
        if found is None:
            return None
        if found.changes:
            words = "its vertices are not blurred: their number changes while the shutter is open"
            findings.append(Finding(LOST, words, "motion-blur"))
        return found.whole()

    def of_camera(self, unscaled, as_node, perspective):
        """SUNDOG_camera's `motion`; None where it stands still."""
        result = {}
        matrices = [unscaled(matrix) for _, matrix in sorted(self._camera.items()) if matrix is not None]
        if matrices and not all(numpy.array_equal(matrix, matrices[0]) for matrix in matrices):
            result["matrices"] = [as_node(matrix) for matrix in matrices]
        here = self._window[0.0]
        zoom = [(w[1] - w[0]) / (here[1] - here[0]) for w in (self._window.get(time, here) for time in (-1, 1))]
        # As Cycles: in perspective alone.
        if perspective and zoom != [1.0, 1.0]:
            result["zoom"] = zoom
        return result or None

    def shutter(self):
        """SUNDOG_scene's `shutter`."""
        if self.still:
            # From 5.3 on the pass holds no more how the world moves.
            return {"still": True, "objects_alone": bpy.app.version >= (5, 3, 0)}
        result = {}
        mapping = self.scene.render.motion_blur_shutter_curve
        mapping.initialize()
        curve = mapping.curves[0]
        values = [max(float(mapping.evaluate(curve, i / (CURVE - 1))), 0.0) for i in range(CURVE)]
        if any(value != values[0] for value in values):
            result["curve"] = values
        cycles = getattr(self.scene, "cycles", None)
        if getattr(cycles, "rolling_shutter_type", "NONE") == "TOP":
            result["rolling"] = float(cycles.rolling_shutter_duration)
        return result

    def restore(self):
        """Brings the depsgraph back to the frame."""
        self._go(self.frame)


def _key(instance):
    parent = instance.parent.name_full if instance.is_instance and instance.parent else None
    return instance.object.name_full, parent, tuple(instance.persistent_id) if instance.is_instance else None


def _step(time, count):
    """The number of a time among so many; None if it is none of them."""
    place = (time + 1) / 2 * (count - 1)
    return round(place) if place == round(place) else None
