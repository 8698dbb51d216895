# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves while the shutter is open: matrices, vertices and keys of strands at the times at which Cycles asks for them.

As in Cycles, lamps stand still, and so do materials, the world, focus and clip planes.
"""

import math

import bpy
import numpy

from . import geometry, strands
from .verdicts import LOST, Finding

# Kinds of objects whose places and shapes are looked at.
MOVING = {"MESH", "CURVES", "POINTCLOUD"}

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

    # How far a vertex must be elsewhere to move.
    least = 0.0

    def __init__(self, mesh, count):
        self.read(mesh)
        self.steps = [None] * count
        self.changes = False
        self.moves = False

    def read(self, mesh):
        """Takes note of how the mesh is in the middle."""
        self.domain = mesh.normals_domain
        self.middle = geometry.step_of(mesh, self.domain)

    def step_of(self, mesh):
        """Positions and normals as they are now."""
        return geometry.step_of(mesh, self.domain)

    def add(self, mesh, step):
        """Takes note of a step."""
        found = self.step_of(mesh)
        if [len(a) for a in found if a is not None] != [len(a) for a in self.middle if a is not None]:
            self.changes = True
            return
        self.steps[step] = found
        if self.least:
            self.moves = self.moves or bool((numpy.linalg.norm(found[0] - self.middle[0], axis=1) > self.least).any())
        else:
            self.moves = self.moves or not numpy.array_equal(found[0], self.middle[0])

    def whole(self):
        """The steps, if there is a motion that can be told."""
        missing = any(found is None for step, found in enumerate(self.steps) if step != len(self.steps) // 2)
        return self.steps if self.moves and not self.changes and not missing else None


class Bending(Deformation):
    """As Deformation, of an object's strands or points."""

    def __init__(self, shown, count, kind, depsgraph):
        self.kind, self.depsgraph = kind, depsgraph
        self.least = strands.MOVES_FROM if kind == "HAIR" else 0.0
        super().__init__(shown, count)

    def read(self, mesh):
        self.middle = self.step_of(mesh)

    def step_of(self, mesh):
        return strands.keys_of(mesh, self.kind, self.depsgraph), None


class Motion:
    """One shutter's motion. `move(frame, subframe)` brings the depsgraph to a time."""

    def __init__(self, depsgraph, scene, move, still=False, with_hair=True):
        """`still`: nothing is blurred; it is looked where things are a frame before and after. `with_hair`: hair is shown."""
        self.still, self.with_hair = still, with_hair
        self.depsgraph, self.scene, self.move = depsgraph, scene, move
        render, cycles = scene.render, getattr(scene, "cycles", None)
        self.frame = scene.frame_current + scene.frame_subframe
        self.length = 2.0 if still else render.motion_blur_shutter
        position = getattr(render, "motion_blur_position", None) or getattr(cycles, "motion_blur_position", "CENTER")
        self.middle = self.frame + (not still) * {"START": 0.5, "END": -0.5}.get(position, 0.0) * self.length
        self._matrices = {}
        # By names and kinds.
        self._meshes = {}
        self._camera = {}
        self._window = None
        # The one of the frame: markers may change it on the way.
        self._eye = scene.camera.original

    def _go(self, time):
        self.move(math.floor(time), time - math.floor(time))

    def _instances(self):
        for instance in self.depsgraph.object_instances:
            if instance.object.type in MOVING and (instance.show_self or instance.show_particles):
                yield instance, instance.parent if instance.is_instance else None

    def _shapes(self, instance):
        """What an instance shows that may change its shape: (key, object, kind), the kind as in `strands.of_object`."""
        shown = instance.object
        if instance.show_self:
            yield (shown.name_full, shown.type), shown, shown.type
        hairy = strands.hairy(instance, self.depsgraph) if self.with_hair else None
        if hairy is not None:
            yield (hairy.name_full, "HAIR"), hairy, "HAIR"

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
            for key, shown, kind in self._shapes(instance):
                if key not in self._meshes and _deforms(shown, parent, self.scene):
                    self._meshes[key] = self._shape(shown, kind, count)
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

    def _shape(self, shown, kind, count):
        """How something changes its shape; None if what it is made of cannot be told, which its own export says."""
        if kind == "MESH":
            with geometry.readable(shown) as mesh:
                return Deformation(mesh, count)
        try:
            return Bending(shown, count, kind, self.depsgraph)
        except geometry.GeometryError:
            return None

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
            for key, shown, kind in self._shapes(instance) if time != 0 else ():
                shape = self._meshes.get(key)
                if shape is None or key in seen:
                    continue
                seen.add(key)
                if (step := _step(time, len(shape.steps))) is not None:
                    self._add(shape, shown, kind, step)
        if time in self._camera:
            self._camera[time] = numpy.array(self._shown_camera().matrix_world, float)

    @staticmethod
    def _add(shape, shown, kind, step):
        if kind == "MESH":
            with geometry.readable(shown) as mesh:
                shape.add(mesh, step)
            return
        try:
            shape.add(shown, step)
        except geometry.GeometryError:
            # Keys that are no places are none.
            shape.changes = True

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
        found = self._meshes.get((shown.name_full, "MESH"))
        if found is None:
            return None
        if found.changes:
            words = "its vertices are not blurred: their number changes while the shutter is open"
            findings.append(Finding(LOST, words, "motion-blur"))
        return found.whole()

    def of_strands(self, shown, kind, parts, findings):
        """Lets the strands of an object move (`kind` as in strands.of_object); adds to findings what stands still."""
        if kind != "HAIR" and self._by_velocity(shown, parts):
            return
        found = self._meshes.get((shown.name_full, kind))
        steps = None if found is None else found.whole()
        if found is not None and found.changes:
            words = "its strands are not blurred: the number of their keys changes while the shutter is open"
            findings.append(Finding(LOST, words, "motion-blur"))
        if steps is None:
            return
        ends = numpy.cumsum([len(part.positions) for part in parts])
        for part, end in zip(parts, ends):
            own = slice(end - len(part.positions), end)
            part.steps = [None if step is None else step[0][own] for step in steps]

    def _by_velocity(self, shown, parts):
        """Lets what has an attribute of velocities move by these, as in Cycles; whether it has one."""
        if not self._steps(shown):
            return False
        frames = self.scene.render.fps / self.scene.render.fps_base
        has = False
        for part in parts:
            velocity = part.velocity()
            if velocity is not None:
                way = velocity * numpy.float32(0.5 * self.length / frames)
                part.steps, has = [part.positions - way, None, part.positions + way], True
        return has

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
