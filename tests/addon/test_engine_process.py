# SPDX-License-Identifier: GPL-3.0-or-later
"""The child process: events, Esc, ends good and bad; the cache folder."""

import json
import os
import subprocess
import sys
import tempfile
import time
import unittest
from unittest import mock

import bpy

import export_kit
from engine_kit import EngineTest, children, engine
from sundog import cache, process
from sundog.process import PATIENCE, ProgramError, Run

# No test waits for so long: it is the way out of a hang.
FOREVER = 60


class Runs(unittest.TestCase):
    """`Run` with stand-ins for the program."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.addCleanup(self.no_children)

    def no_children(self):
        """Waits for what is waited for in threads."""
        deadline = time.monotonic() + FOREVER
        while process._running and time.monotonic() < deadline:
            time.sleep(0.01)
        self.assertEqual(children(), [])

    def stand_in(self, body):
        """The command line of a Python program."""
        path = os.path.join(self.folder, "program")
        with open(path, "w", encoding="utf-8") as file:
            file.write(f"import json, os, signal, sys, time\ndef tell(**event):\n    print(json.dumps(event), flush=True)\n{body}\n")
        return [sys.executable, "-S", path]

    def all_events(self, run):
        """Reads to the end."""
        events, deadline = [], time.monotonic() + FOREVER
        while not run.ended and time.monotonic() < deadline:
            event = run.next(0.1)
            if event is not None:
                events.append(event)
        return events

    def until(self, run, kind):
        """Reads until an event of a kind."""
        deadline = time.monotonic() + FOREVER
        while time.monotonic() < deadline:
            event = run.next(0.1)
            if event is not None and event["event"] == kind:
                return event
        self.fail(f"no {kind}")

    def test_events_in_their_order(self):
        with Run(self.stand_in("for i in range(500): tell(event='progress', samples=i)")) as run:
            events = self.all_events(run)
            run.check()
        self.assertEqual([event["samples"] for event in events], list(range(500)))

    def test_much_on_the_standard_error_does_not_block(self):
        with Run(self.stand_in("sys.stderr.write('x' * 99 + '\\n' * 1) or [sys.stderr.write('y' * 99 + '\\n') for _ in range(5000)]\ntell(event='finished')")) as run:
            self.assertEqual(len(self.all_events(run)), 1)
            run.check()

    def test_an_interrupt_gets_the_last_frame(self):
        # Waited for, not handled: a handler that prints while a print has not returned is refused by Python, and on a busy
        # machine the interrupt comes as soon as that.
        body = (
            "signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])\ntell(event='prepared')\n"
            "signal.sigwait([signal.SIGINT])\ntell(event='progress')\ntell(event='frame', final=True)\ntime.sleep(60)"
        )
        with Run(self.stand_in(body)) as run:
            self.until(run, "prepared")
            run.interrupt()
            rest = list(run.rest(FOREVER))
        self.assertEqual([event["event"] for event in rest], ["progress", "frame"])

    def test_a_program_that_does_not_listen_is_killed_in_time(self):
        body = "signal.signal(signal.SIGINT, signal.SIG_IGN)\ntell(event='prepared')\nwhile True: time.sleep(1)"
        with Run(self.stand_in(body)) as run:
            self.until(run, "prepared")
            begun = time.monotonic()
            run.interrupt()
            self.assertEqual(list(run.rest(PATIENCE)), [])
            run.leave()
            # Not by the program's own minute.
            self.assertLess(time.monotonic() - begun, FOREVER)
        # The promise is half a second from Esc, which tests/gui measures; what is over is for the poll before it and the copying.
        self.assertLessEqual(PATIENCE + engine.POLL, 0.4)

    def test_a_chatterbox_is_cut_off(self):
        body = "signal.signal(signal.SIGINT, signal.SIG_IGN)\nwhile True: tell(event='progress')"
        with Run(self.stand_in(body)) as run:
            self.until(run, "progress")
            run.interrupt()
            begun = time.monotonic()
            for _ in run.rest(0.1):
                pass
            self.assertLess(time.monotonic() - begun, FOREVER)

    def test_grandchildren_end_too(self):
        mark = os.path.join(self.folder, "grandchild")
        body = (
            "import subprocess\n"
            f"p = subprocess.Popen([sys.executable, '-S', '-c', 'import time; time.sleep(60)'])\n"
            f"open({mark!r}, 'w').write(str(p.pid))\ntell(event='prepared')\ntime.sleep(60)"
        )
        with Run(self.stand_in(body)) as run:
            self.until(run, "prepared")
        with open(mark, encoding="ascii") as file:
            number = int(file.read())
        deadline = time.monotonic() + FOREVER
        while _lives(number) and time.monotonic() < deadline:
            time.sleep(0.01)
        self.assertFalse(_lives(number))

    def test_a_group_of_its_own(self):
        with Run(self.stand_in("tell(event='group', group=os.getpgid(0), me=os.getpid())\ntime.sleep(60)")) as run:
            told = self.until(run, "group")
        self.assertEqual(told["group"], told["me"])
        self.assertNotEqual(told["group"], os.getpgid(0))

    def test_ends_that_are_not_good(self):
        for body, words in (
            ("os.kill(os.getpid(), signal.SIGABRT)", "SIGABRT.*without a word"),
            ("sys.exit(9)", "exit code 9"),
            ("tell(event='error', message='no such file')\nsys.exit(1)", "^no such file$"),
            ("print('half a li', end='', flush=True)\nos.kill(os.getpid(), signal.SIGSEGV)", "SIGSEGV.*half a li"),
        ):
            with self.assertRaisesRegex(ProgramError, words), Run(self.stand_in(body)) as run:
                self.all_events(run)
                run.check()

    def test_one_that_closes_its_output_but_lives_is_killed(self):
        with Run(self.stand_in("os.close(1)\ntime.sleep(60)")) as run:
            self.assertEqual(self.all_events(run), [])
            with self.assertRaisesRegex(ProgramError, "SIGKILL"):
                run.check()

    def test_what_runs_ends_with_blender(self):
        """A Blender that leaves while rendering takes the program and the folder along."""
        script = (
            f"import sys, os; sys.path.insert(0, {os.path.join(export_kit.PROJECT, 'blender_addon', 'sundog')!r})\n"
            "import importlib.util\n"
            f"spec = importlib.util.spec_from_file_location('process', {process.__file__!r})\n"
            "process = importlib.util.module_from_spec(spec); spec.loader.exec_module(process)\n"
            f"folder = process.Folder({self.folder!r})\n"
            "run = process.Run([sys.executable, '-S', '-c', 'import time; time.sleep(60)'])\n"
            "print(run._child.pid, folder.path, flush=True)\n"
        )
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=FOREVER, check=True)
        number, path = done.stdout.split()
        self.assertFalse(_lives(int(number)))
        self.assertFalse(os.path.exists(path))


def _lives(number):
    try:
        with open(f"/proc/{number}/stat", encoding="ascii") as file:
            return file.read().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


class Esc(EngineTest):
    """Cancelling a render of the true program, by the engine's own way."""

    def stop_when(self, condition):
        """Presses Esc in the moment that the condition holds. (Blender's own `test_break` cannot be replaced.)"""
        patch = mock.patch.object(engine.SundogRenderEngine, "stopped", lambda _: condition())
        patch.start()
        self.addCleanup(patch.stop)

    def stop_after_a_frame(self):
        """Presses Esc when the first frame is shown; returns the list of all frames' samples."""
        shown = []
        before = engine._Screen.show

        def show(screen, event, *rest):
            shown.append(event["samples"])
            before(screen, event, *rest)

        patch = mock.patch.object(engine._Screen, "show", show)
        patch.start()
        self.addCleanup(patch.stop)
        self.stop_when(lambda: bool(shown))
        return shown

    def test_keeps_what_there_is(self):
        self.scene.sundog.samples = 1 << 20
        shown = self.stop_after_a_frame()
        picture = self.render()["ViewLayer.Combined"]
        self.assertTrue(picture.any())
        self.assertLess(engine.last_statistics()["stopped"], FOREVER)
        self.assertGreater(shown[-1], 0)

    def test_of_a_large_frame_only_the_picture_is_taken(self):
        self.scene.sundog.samples = 1 << 20
        self.scene.view_layers[0].use_pass_normal = True
        frames = self.stop_after_a_frame()
        for most, has_normals in ((1 << 30, True), (0, False)):
            frames.clear()
            # However slow the machine: here the last frame comes.
            with mock.patch.object(engine, "MOST_AFTER_ESC", most), mock.patch.object(engine, "PATIENCE", FOREVER):
                shown = self.render()
            self.assertTrue(shown["ViewLayer.Combined"].any())
            self.assertEqual(shown["ViewLayer.Normal"].any(), has_normals)

    def test_before_anything_is_there(self):
        self.stop_when(lambda: True)
        self.assertFalse(self.render()["ViewLayer.Combined"].any())

    def test_while_the_world_is_baked(self):
        tree = self.scene.world.node_tree
        sky = tree.nodes.new("ShaderNodeTexSky")
        sky.sun_elevation = 0.2 + int.from_bytes(os.urandom(2), "little") / 65536
        tree.links.new(sky.outputs["Color"], tree.nodes["Background"].inputs["Color"])
        said = []
        before = engine._LayerRender.say

        def say(job, text):
            said.append(text)
            before(job, text)

        self.stop_when(lambda: sum("baking" in text for text in said) > 3)
        with mock.patch.object(engine._LayerRender, "say", say):
            self.assertFalse(self.render()["ViewLayer.Combined"].any())
        self.assertNotIn("command", engine.last_statistics())

    def test_while_the_program_loads(self):
        self.stand_in("signal.signal(signal.SIGINT, signal.SIG_IGN)\ntime.sleep(3600)")
        asked = []

        def later():
            # Not at once: the first time is before the program is started.
            if "command" in engine.last_statistics():
                asked.append(True)
            return len(asked) > 10

        self.stop_when(later)
        self.assertFalse(self.render()["ViewLayer.Combined"].any())
        self.assertLess(engine.last_statistics()["stopped"], FOREVER)


class Cache(unittest.TestCase):
    """The folder stays small and loses what was not used for longest."""

    def test_tidy(self):
        with tempfile.TemporaryDirectory() as folder:
            now = time.time()
            for age in range(10):
                path = os.path.join(folder, f"{age}")
                with open(path, "wb") as file:
                    file.write(b"x" * 100)
                os.utime(path, (now, now - cache.YOUNG * (age + 0.5)))
            keep = {os.path.realpath(os.path.join(folder, "9"))}
            self.assertEqual(cache.tidy(folder, 500, keep, now), 5)
            self.assertEqual(sorted(os.listdir(folder)), ["0", "1", "2", "3", "9"])
            # Young files stay whatever the limit: another Blender may be about to read them.
            cache.tidy(folder, 0, (), now)
            self.assertEqual(os.listdir(folder), ["0"])

    def test_what_a_scene_uses(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.gltf")
            world = {"extensions": {"SUNDOG_scene": {"world": {"image": "sky%20blue.exr"}}}}
            document = {"buffers": [{"uri": "../a/b.bin"}], "images": [{"uri": "data:x"}, {"bufferView": 0}], "scenes": [world]}
            top = os.path.realpath(os.path.dirname(folder))
            expected = {os.path.join(top, "a", "b.bin"), os.path.join(os.path.realpath(folder), "sky blue.exr")}
            self.assertEqual(cache.used_by(path, document), expected)


class SecondRender(EngineTest):
    """What did not change is not exported again."""

    def test_a_moved_camera_exports_no_geometry(self):
        # Other tests may have left the same meshes in the cache.
        mesh = bpy.data.objects["Cube"].data
        mesh.vertices[0].co.x = -1.0 - int.from_bytes(os.urandom(2), "little") / 1e6
        self.render()
        self.assertGreater(engine.last_statistics()["changed_geometry"], 0)
        self.scene.camera.location.x += 1
        self.render()
        self.assertEqual(engine.last_statistics()["changed_geometry"], 0)


if __name__ == "__main__":
    unittest.main()
