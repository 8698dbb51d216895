# SPDX-License-Identifier: GPL-3.0-or-later
"""What goes wrong gives one report that names it; Blender lives on and renders the next time."""

import os
import unittest
from unittest import mock

import bpy
import numpy

from engine_kit import HEIGHT, WIDTH, EngineTest, engine, quiet
from sundog import preferences
from sundog.export import geometry
from sundog.process import Folder, ProgramError

FRAME = "passes=[dict(name='Combined', channels='RGBA', offset=0)]"


class Programs(EngineTest):
    """The program is missing, is something else, crashes, ends, or lies."""

    def test_missing(self):
        os.environ["SUNDOG_PROGRAM"] = "/nowhere/sundog"
        self.fails("/nowhere/sundog", "does not exist", "preferences")
        self.still_renders()

    def test_not_executable(self):
        path = os.path.join(self.folder, "data")
        with open(path, "w", encoding="ascii"):
            pass
        os.environ["SUNDOG_PROGRAM"] = path
        self.fails(path, "not executable")
        self.still_renders()

    def test_another_program(self):
        os.environ["SUNDOG_PROGRAM"] = "/bin/true"
        self.fails("/bin/true", "no sundog program")
        self.still_renders()

    def test_for_another_machine(self):
        path = os.path.join(self.folder, "data")
        with open(path, "wb") as file:
            file.write(b"\0" * 100)
        os.chmod(path, 0o755)
        os.environ["SUNDOG_PROGRAM"] = path
        self.fails(path, "cannot be started")
        self.still_renders()

    def test_crash_in_the_middle_of_a_line(self):
        self.stand_in(
            "sys.stderr.write('something is rotten\\n'); sys.stderr.flush()\n"
            "sys.stdout.write('{\"event\":\"progr'); sys.stdout.flush()\n"
            "os.kill(os.getpid(), signal.SIGSEGV)"
        )
        self.fails("crashed", "SIGSEGV", "something is rotten")
        self.still_renders()

    def test_crash_after_some_picture(self):
        self.stand_in(
            "folder = sys.argv[sys.argv.index('--frames') + 1]\n"
            f"open(os.path.join(folder, 'f.raw'), 'wb').write(b'\\0\\0\\x80\\x3f' * {WIDTH * HEIGHT * 4})\n"
            f"tell(event='frame', file='f.raw', width={WIDTH}, height={HEIGHT}, region=[0, 0, {WIDTH}, {HEIGHT}],\n"
            f"     samples=1, final=False, {FRAME})\n"
            "os.kill(os.getpid(), signal.SIGKILL)"
        )
        self.fails("crashed", "SIGKILL")
        self.still_renders()

    def test_error_event(self):
        self.stand_in("tell(event='error', message='scene.gltf: the moon is missing')\nsys.exit(1)")
        self.fails("scene.gltf: the moon is missing")
        self.still_renders()

    def test_exit_code_without_an_event(self):
        self.stand_in("sys.stderr.write('no more paper\\n')\nsys.exit(3)")
        self.fails("exit code 3", "no more paper")
        self.still_renders()

    def test_no_picture(self):
        self.stand_in("tell(event='finished', statistics={}, written=[])")
        self.fails("without a picture")
        self.still_renders()

    def test_noise_on_the_standard_output(self):
        self.stand_in("print('Hello'); print('[1, 2]'); print('{\"no\": \"event\"}'); print('\\udcff' * 10 if False else '')\nsys.exit(4)")
        self.fails("exit code 4")
        self.still_renders()

    def test_a_frame_that_is_too_short_or_not_there(self):
        for write in ("open(os.path.join(folder, 'f.raw'), 'wb').write(b'abcd')", "pass"):
            self.stand_in(
                f"folder = sys.argv[sys.argv.index('--frames') + 1]\n{write}\n"
                f"tell(event='frame', file='f.raw', width={WIDTH}, height={HEIGHT}, region=[0, 0, {WIDTH}, {HEIGHT}],\n"
                f"     samples=1, final=True, {FRAME})"
            )
            self.fails("broken frame")
        self.still_renders()

    def test_the_preferences_button_finds_it_out(self):
        with quiet():
            self.assertEqual(bpy.ops.sundog.test_program(), {"FINISHED"})
            self.stand_in("sys.exit(5)")
            with self.assertRaisesRegex(RuntimeError, "exit code 5"):
                bpy.ops.sundog.test_program()
            os.environ["SUNDOG_PROGRAM"] = "/nowhere/sundog"
            with self.assertRaisesRegex(RuntimeError, "does not exist"):
                bpy.ops.sundog.test_program()


class Places(EngineTest):
    """Folders that cannot be written to."""

    def test_cache_folder(self):
        # Not for root either: a file in the place of a folder, and a file system that takes nothing.
        blocked = os.path.join(self.folder, "file")
        with open(blocked, "w", encoding="ascii"):
            pass
        for place in (os.path.join(blocked, "cache"), "/proc/cache"):
            with mock.patch.object(preferences.Defaults, "cache_folder", place):
                self.fails(place, "preferences")
        self.still_renders()

    def test_temporary_folder(self):
        with self.assertRaisesRegex(ProgramError, "/proc.*Temporary Files"):
            Folder("/proc")

    def test_output_folder(self):
        # Blender's own business, and it says so; the engine is none the worse for it.
        self.scene.render.filepath = "/proc/nowhere/picture"
        with quiet():
            try:
                bpy.ops.render.render(write_still=True)
            except RuntimeError:
                pass
        self.still_renders()


class Scenes(EngineTest):
    """Scenes that cannot be rendered as they are."""

    def test_no_camera(self):
        self.scene.camera = None
        self.fails("camera")
        self.scene.camera = bpy.data.objects["Camera"]
        self.still_renders()

    def test_a_camera_that_is_another_object(self):
        # As in Cycles, which looks through it with 50 mm.
        target = bpy.data.objects.new("empty", None)
        self.scene.collection.objects.link(target)
        target.matrix_world = bpy.data.objects["Camera"].matrix_world
        self.scene.camera = target
        self.still_renders()

    def test_an_empty_mesh(self):
        bpy.data.objects["Cube"].data.clear_geometry()
        self.still_renders()

    def test_a_mesh_that_is_too_large(self):
        with mock.patch.object(geometry, "MOST_CORNERS", 8):
            self.still_renders()
        lost = [v for v in engine.last_verdicts() if v["verdict"] == "lost" and v["name"] == "Cube"]
        self.assertEqual(len(lost), 1)
        self.assertIn("left out", lost[0]["detail"])

    def test_places_that_are_absurd(self):
        mesh = bpy.data.objects["Cube"].data
        for value in (1e30, 3e38, float("inf"), float("nan")):
            mesh.vertices[0].co = (value, value, -value)
            picture = self.render("absurd")["ViewLayer.Combined"]
            self.assertTrue(numpy.isfinite(picture).all(), value)
        mesh.vertices[0].co = (-1, -1, -1)
        self.still_renders()

    def test_a_mistake_in_the_add_on_is_told(self):
        with mock.patch.object(engine.export, "write_scene", side_effect=ZeroDivisionError("seven")), mock.patch("traceback.print_exc"):
            self.fails("please report", "ZeroDivisionError: seven")
        with mock.patch.object(engine.export, "write_scene", side_effect=MemoryError):
            self.fails("memory")
        self.still_renders()

    def test_an_animation_ends_at_the_first_frame_that_fails(self):
        self.scene.frame_start, self.scene.frame_end = 1, 3
        self.stand_in(f"open({os.path.join(self.folder, 'count')!r}, 'a').write('x')\nsys.exit(6)")
        self.scene.render.filepath = os.path.join(self.folder, "frame_####")
        with quiet(), self.assertRaises(RuntimeError):
            bpy.ops.render.render(animation=True)
        with open(os.path.join(self.folder, "count"), encoding="ascii") as file:
            self.assertEqual(file.read(), "x")
        self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("frame_")], [])


if __name__ == "__main__":
    unittest.main()
