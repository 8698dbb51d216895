# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of worlds beside Cycles: seen by the camera, and lighting a matte, a glossy and a mirroring ball."""

import itertools
import math
import os
import subprocess
import unittest

import bpy
import export_kit as kit
import numpy
from sundog.export import images

WIDTH, HEIGHT = 48, 32
NEW = bpy.app.version >= (5, 0, 0)
# Sky textures that have a sun.
SUNNY = ("SINGLE_SCATTERING", "MULTIPLE_SCATTERING") if NEW else ("NISHITA",)


def rendered(path, samples, seed):
    """The program's picture."""
    picture = f"{path}.{seed}.exr"
    command = [kit.program(), "render", path, "-o", picture, "--width", str(WIDTH), "--height", str(HEIGHT), "--quiet", "--allow-outside"]
    command += ["--samples", str(samples), "--filter", "box", "--exr-layers", "combined", "--seed", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(done.stderr)
    return kit.exr_pixels(picture)


class Nodes(kit.ExportTest):
    """Node trees of something that shines."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        self.wrong = []
        # Whose node tree it is.
        self.owner = None
        cycles = self.scene.cycles
        kit.unbiased(cycles)
        cycles.max_bounces = 4

    def node(self, kind, inputs=None, **settings):
        """A node; of inputs that are outputs links are made."""
        tree = self.owner.node_tree
        made = tree.nodes.new(f"ShaderNode{kind}")
        for key, value in settings.items():
            setattr(made, key, value)
        for key, value in (inputs or {}).items():
            socket = made.inputs[key] if isinstance(key, int) else next(s for s in made.inputs if key in (s.identifier, s.name) and s.enabled)
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, socket)
            else:
                socket.default_value = value
        return made

    def out(self, kind, output, inputs=None, **settings):
        """An output of a new node."""
        made = self.node(kind, inputs, **settings)
        return next(s for s in made.outputs if output in (s.identifier, s.name) and s.enabled)

    def compare(self, name, samples=128, mean=0.01, error=1e-3, thing=("world", "world"), graph_of=lambda found: found.scene()["world"]):
        """Renders the scene by both, twice, so that the noise of the one and of the other cancels."""
        render = self.scene.render
        render.resolution_x, render.resolution_y = WIDTH, HEIGHT
        found = self.export()
        verdict = found.verdict(*thing)
        ours, theirs = [], []
        for seed in (0, 1):
            self.scene.cycles.seed = seed
            theirs.append(kit.cycles_pixels(WIDTH, HEIGHT, samples))
            ours.append(rendered(found.path, samples, seed))
        a, b = sum(ours) / 2, sum(theirs) / 2
        by_mean = abs(a.mean() - b.mean()) / max(abs(b).mean(), 1e-3)
        by_pixel = float(((ours[0] - theirs[0]) * (ours[1] - theirs[1]) / (b**2 + 0.01)).mean())
        is_graph = "shader_graph" in graph_of(found)
        bad = by_mean > mean or by_pixel > error or verdict["verdict"] != "exact" or not is_graph
        words = f"{name}: mean {a.mean():.4f} against {b.mean():.4f} ({by_mean:.2%}), relMSE {by_pixel:.1e}, {verdict['verdict']} {verdict['detail']}"
        print(("MISS " if bad else "ok   ") + words, flush=True)
        if bad:
            if os.environ.get("KEEP"):
                numpy.save(os.path.join(os.environ["KEEP"], f"{name}.npy"), numpy.stack([a, b]))
            self.wrong.append(words)
        return found

    def tearDown(self):
        self.assertFalse(self.wrong, "\n" + "\n".join(self.wrong))
        super().tearDown()

    def positive(self, vector):
        """A colour of a vector that may be negative."""
        return self.out("VectorMath", "Vector", {0: vector, 1: (0.5, 0.5, 0.5), 2: (0.6, 0.6, 0.6)}, operation="MULTIPLY_ADD")


class Worlds(Nodes):
    """What both programs show."""

    def setUp(self):
        super().setUp()
        self.camera.location, self.camera.rotation_euler = (0, -6, 0.6), (math.radians(87), 0, 0)
        self.camera.data.lens, self.camera.data.sensor_width = 30, 36
        kinds = {
            "matte": {"Base_Color": (0.8, 0.7, 0.6, 1), "Specular_IOR_Level": 0.0, "Roughness": 1.0},
            "glossy": {"Base_Color": (0.9, 0.9, 0.9, 1), "Metallic": 1.0, "Roughness": 0.4},
            "mirror": {"Base_Color": (0.9, 0.9, 0.9, 1), "Metallic": 1.0, "Roughness": 0.0},
        }
        for number, (name, inputs) in enumerate(kinds.items()):
            bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.8, location=(1.8 * (number - 1), 0, 0))
            ball = bpy.context.object
            ball.data.shade_smooth()
            ball.data.materials.append(kit.material(name, **inputs))

    def remove(self, *names):
        """The balls of these materials."""
        for ball in [o for o in bpy.data.objects if o.type == "MESH" and o.data.materials[0].name in names]:
            bpy.data.objects.remove(ball)

    def tree(self):
        """An empty node tree of a new world: (tree, the output's surface)."""
        for before in list(bpy.data.worlds):
            bpy.data.worlds.remove(before)
        world = self.owner = self.scene.world = bpy.data.worlds.new("world")
        world.use_nodes = True
        world.node_tree.nodes.clear()
        return world.node_tree, world.node_tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"]

    def shown(self, color, strength=1.0):
        """A Background of a colour is the world."""
        background = self.out("Background", "Background", {"Color": color, "Strength": strength})
        tree = self.scene.world.node_tree
        tree.links.new(background, next(n for n in tree.nodes if n.type == "OUTPUT_WORLD").inputs["Surface"])

    @kit.long
    def test_coordinates(self):
        """What is known of a direction."""
        for output in ("Generated", "Normal", "Object", "Camera", "Reflection"):
            self.tree()
            self.shown(self.positive(self.out("TexCoord", output)))
            self.compare(f"coordinates {output}")
        for output in ("Position", "Normal", "True Normal", "Incoming"):
            self.tree()
            self.shown(self.positive(self.out("NewGeometry", output)))
            self.compare(f"geometry {output}")
        self.tree()
        other = bpy.data.objects.new("other", None)
        other.location, other.rotation_euler, other.scale = (0.3, 0.2, -0.1), (0.3, 0.5, 0.9), (2, 1, 0.5)
        self.scene.collection.objects.link(other)
        self.shown(self.positive(self.out("TexCoord", "Object", object=other)))
        self.compare("coordinates of another object")
        self.tree()
        turned = self.out("VectorTransform", "Vector", {"Vector": self.out("TexCoord", "Generated")}, vector_type="VECTOR", convert_from="WORLD", convert_to="CAMERA")
        self.shown(self.positive(turned))
        self.compare("vector transform")

    def test_shaders(self):
        """Backgrounds mixed and added, and what sees which."""
        def two(first, second):
            return [self.out("Background", "Background", {"Color": c, "Strength": s}) for c, s in (first, second)]

        red, blue = ((1, 0.1, 0.1, 1), 2.0), ((0.1, 0.2, 1, 1), 1.0)
        for name in ("Is Camera Ray", "mix", "add", "emission", "Is Glossy Ray", "Ray Depth"):
            if name == "Is Glossy Ray":
                # Light sampling tells no kinds of rays apart; how that is weighed against rays that do is each program's own.
                self.remove("matte", "glossy")
            _, surface = self.tree()
            a, b = two(red, blue)
            if name == "add":
                made = self.out("AddShader", "Shader", {0: a, 1: b})
            elif name == "emission":
                made = self.out("Emission", "Emission", {"Color": self.positive(self.out("TexCoord", "Generated")), "Strength": 2.0})
            elif name == "mix":
                up = self.out("SeparateXYZ", "Z", {"Vector": self.out("TexCoord", "Generated")})
                made = self.out("MixShader", "Shader", {0: up, 1: a, 2: b})
            else:
                path = self.out("LightPath", name)
                if name == "Ray Depth":
                    path = self.out("Math", "Value", {0: path, 1: 0.4}, operation="MULTIPLY")
                made = self.out("MixShader", "Shader", {0: path, 1: a, 2: b})
            self.scene.world.node_tree.links.new(made, surface)
            self.compare(name)

    def picture(self):
        """A picture with coloured stripes and a bright spot."""
        rows, columns = numpy.meshgrid((numpy.arange(64) + 0.5) / 64, (numpy.arange(128) + 0.5) / 128, indexing="ij")
        values = numpy.stack([columns, rows, 0.5 + 0.5 * numpy.sin(6 * math.pi * columns)], axis=-1)
        values[10:13, 30:33] = 60
        path = os.path.join(self.folder, "sky.exr")
        images.write_exr(path, values)
        return bpy.data.images.load(path)

    @kit.long
    def test_pictures(self):
        """Environment textures beyond a plain one."""
        for projection in ("EQUIRECTANGULAR", "MIRROR_BALL"):
            for interpolation in ("Linear", "Closest"):
                self.tree()
                place = self.out("TexCoord", "Generated")
                moved = self.out("Mapping", "Vector", {"Vector": place, "Location": (0.2, 0, 0.1), "Rotation": (0.3, 0.2, 1), "Scale": (1, 1.5, 0.8)})
                shown = self.out("TexEnvironment", "Color", {"Vector": moved}, image=self.picture(), projection=projection, interpolation=interpolation)
                self.shown(shown, 0.7)
                self.compare(f"picture {projection} {interpolation}", samples=256)
        self.tree()
        first = self.out("TexEnvironment", "Color", image=self.picture())
        self.shown(self.out("Gamma", "Color", {"Color": first, "Gamma": 0.8}))
        self.compare("picture without coordinates, through Gamma", samples=256)

    def test_pictures_of_codes(self):
        """A plain one of eight bits whose texels differ: between them Cycles takes the mean of the codes. It was 38 % too bright."""
        self.tree()
        dots = bpy.data.images.new("dots", 64, 32)
        values = numpy.ones((32, 64, 4), numpy.float32)
        values[..., :3] = numpy.random.default_rng(3).integers(0, 2, (32, 64, 1))
        dots.pixels.foreach_set(values.ravel())
        dots.filepath_raw, dots.file_format = os.path.join(self.folder, "dots.png"), "PNG"
        dots.save()
        self.shown(self.out("TexEnvironment", "Color", image=bpy.data.images.load(dots.filepath_raw)))
        self.compare("picture of codes")

    def test_plain_pictures_between_texels(self):
        """A plain one of floats, by splines and by the nearest texel: all were linear (relMSE 0.16 and 2.1)."""
        dots = numpy.random.default_rng(4).integers(0, 2, (4, 8, 1)) * numpy.ones(3)
        path = os.path.join(self.folder, "dots.exr")
        images.write_exr(path, dots)
        for interpolation in ("Cubic", "Smart", "Closest"):
            self.tree()
            self.shown(self.out("TexEnvironment", "Color", image=bpy.data.images.load(path), interpolation=interpolation))
            self.compare(interpolation)

    def test_plain_pictures_that_no_plain_file_holds(self):
        """Floats with alpha, floats of another transfer function, and integers of 16 bits. (They were 24 to 162 % too bright.)"""
        dice = numpy.random.default_rng(5)
        values = dice.random((4, 8, 4))
        values[..., 3] = 0.3 + 0.7 * values[..., 3]
        alpha, opaque, deep = (os.path.join(self.folder, name) for name in ("alpha.exr", "opaque.exr", "deep.png"))
        images.write_exr(alpha, values * [1.6, 1.6, 1.6, 1])
        images.write_exr(opaque, values[..., :3] * 0.9)
        images.write_png(deep, (values * 65535).astype(numpy.uint16))
        for path, space in ((alpha, "Linear Rec.709"), (opaque, "sRGB"), (opaque, "AgX Base sRGB"), (deep, "sRGB"), (deep, "Non-Color")):
            self.tree()
            image = bpy.data.images.load(path)
            image.colorspace_settings.name = space
            self.shown(self.out("TexEnvironment", "Color", image=image))
            self.compare(f"{os.path.basename(path)} {space}")

    def test_missing_pictures(self):
        """They are pink, alone and among other nodes."""
        missing = os.path.join(self.folder, "missing.exr")
        images.write_exr(missing, numpy.ones((4, 8, 3)))
        lost = bpy.data.images.load(missing)
        os.remove(missing)
        lost.reload()
        for name, image in (("missing", lost), ("none", None)):
            self.tree()
            self.shown(self.out("TexEnvironment", "Color", image=image), 0.5)
            self.compare(f"picture: {name}", graph_of=lambda found: ["shader_graph"])
            self.tree()
            shown = self.out("TexEnvironment", "Color", image=image)
            up = self.out("TexCoord", "Generated")
            self.shown(self.out("VectorMath", "Vector", {0: shown, 1: self.positive(up)}, operation="MULTIPLY"))
            self.compare(f"picture among nodes: {name}")

    @kit.long
    def test_textures(self):
        """Procedural ones, ramps and a bright spot that light sampling has to find."""
        self.tree()
        noise = self.out("TexNoise", "Fac", {"Scale": 4.0})
        ramp = self.node("ValToRGB", {"Fac": noise})
        ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[0].color = 0.4, (0.1, 0.2, 0.5, 1)
        ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.6, (1, 0.9, 0.7, 1)
        self.shown(ramp.outputs["Color"])
        self.compare("noise and ramp")
        self.tree()
        self.shown(self.out("TexVoronoi", "Color", {"Scale": 3.0}))
        self.compare("cells")
        self.tree()
        self.shown(self.out("TexGradient", "Color", {"Vector": self.out("TexCoord", "Generated")}, gradient_type="SPHERICAL"), 3.0)
        self.compare("gradient")
        self.tree()
        self.shown(self.out("TexChecker", "Color", {"Scale": 4.0}))
        self.compare("checker")
        self.tree()
        along = self.out("VectorMath", "Value", {0: self.out("TexCoord", "Generated"), 1: (0.36, -0.48, 0.8)}, operation="DOT_PRODUCT")
        spot = self.out("Math", "Value", {0: along, 1: 0.9985}, operation="GREATER_THAN")
        self.shown((1, 0.8, 0.6, 1), self.out("Math", "Value", {0: spot, 1: 500.0, 2: 0.2}, operation="MULTIPLY_ADD"))
        self.compare("bright spot", samples=512)
        self.tree()
        self.shown(self.out("Blackbody", "Color", {"Temperature": 3000.0}), self.out("TexWave", "Fac", {"Scale": 2.0}))
        self.compare("black body by a wave")

    def test_skies(self):
        """All models, with a sun and without."""
        kinds = ["PREETHAM", "HOSEK_WILKIE", *SUNNY]
        for kind in kinds:
            self.tree()
            settings = {"sky_type": kind}
            if kind in ("PREETHAM", "HOSEK_WILKIE"):
                settings["sun_direction"] = (0.3, -0.5, 0.6)
            else:
                settings.update(sun_disc=False, sun_elevation=0.5, sun_rotation=2.5)
            self.shown(self.out("TexSky", "Color", **settings), 0.5)
            self.compare(f"sky {kind} without a sun", samples=256)

    def compare_suns(self, kinds, suns):
        """The sun's disc on what is matte and what is glossy; in the mirror it would be found by chance alone."""
        self.remove("mirror")
        for kind, (elevation, size, strength) in itertools.product(kinds, suns):
            self.tree()
            settings = {"sky_type": kind, "sun_disc": True, "sun_elevation": elevation, "sun_rotation": 2.5, "sun_size": size}
            self.shown(self.out("TexSky", "Color", **settings), strength)
            self.compare(f"sun of {kind}, {size} across, {elevation} up", samples=256)

    def test_some_suns(self):
        """A high one and one that is cut by the horizon."""
        self.compare_suns(SUNNY[-1:], ((0.5, 0.02, 0.1), (-0.004, 0.02, 1.0)))

    @kit.long
    def test_suns(self):
        """All kinds, with one that is a point and one that is large."""
        self.compare_suns(SUNNY, ((0.5, 0.02, 0.1), (0.5, 0.0, 1.0), (0.004, 0.02, 1.0), (-0.004, 0.02, 1.0), (1.3, 0.3, 0.001)))

    def test_sun_that_the_camera_does_not_see(self):
        """A mix of a sky and a plain background."""
        self.remove("mirror")
        settings = {"sky_type": SUNNY[-1], "sun_disc": True, "sun_elevation": 0.004, "sun_rotation": 2.5, "sun_size": 0.02}
        _, surface = self.tree()
        sky = self.out("Background", "Background", {"Color": self.out("TexSky", "Color", **settings), "Strength": 0.2})
        plain = self.out("Background", "Background", {"Color": (0.3, 0.4, 0.5, 1), "Strength": 1.0})
        mixed = self.out("MixShader", "Shader", {0: self.out("LightPath", "Is Camera Ray"), 1: sky, 2: plain})
        self.scene.world.node_tree.links.new(mixed, surface)
        self.compare("sky that the camera does not see", samples=256)

    @kit.long
    def test_discs(self):
        """The disc itself, pixel by pixel."""
        self.remove("matte", "glossy", "mirror")
        self.camera.rotation_euler = (math.radians(90), 0, 0)
        data = self.camera.data
        for kind in SUNNY:
            for elevation, size, altitude in ((0.004, 0.02, 100.0), (0.0, 0.02, 0.0), (0.3, 0.009512, 100.0), (0.02, 0.3, 5000.0), (-0.1, 0.3, 0.0)):
                self.tree()
                data.angle = 1.3 * size
                self.camera.rotation_euler[0] = math.pi / 2 + elevation
                # Toward +Y, where the camera looks.
                settings = {"sky_type": kind, "sun_disc": True, "sun_elevation": elevation, "sun_rotation": 0.0, "sun_size": size, "altitude": altitude}
                self.shown(self.out("TexSky", "Color", **settings), 0.001)
                self.compare(f"disc of {kind}, {size} across, {elevation} up, {altitude} above the sea", samples=256)

    @kit.long
    def test_panorama(self):
        """The whole of a sky and of the sun's disc in it, texel by texel."""
        data = self.camera.data
        data.type = "PANO"
        (data if hasattr(data, "panorama_type") else data.cycles).panorama_type = "EQUIRECTANGULAR"
        self.remove("matte", "glossy", "mirror")
        kind = SUNNY[-1]
        for elevation in (0.02, 0.8, 1.5):
            self.tree()
            self.shown(self.out("TexSky", "Color", sky_type=kind, sun_elevation=elevation, sun_rotation=1.0, sun_size=0.3, sun_intensity=0.05), 0.5)
            self.compare(f"panorama, sun at {elevation}", samples=512)


class Lights(Nodes):
    """Lamps with nodes, on a floor and a glossy ball."""

    def setUp(self):
        super().setUp()
        self.scene.world = bpy.data.worlds.new("world")
        self.scene.world.use_nodes = True
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
        floor = kit.plane("floor", 8)
        floor.materials.append(kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), Specular_IOR_Level=0.0, Roughness=1.0))
        self.link("floor", floor)
        bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.5, location=(1.2, 0.4, 0.5))
        bpy.context.object.data.shade_smooth()
        bpy.context.object.data.materials.append(kit.material("glossy", Base_Color=(0.9, 0.9, 0.9, 1), Metallic=1.0, Roughness=0.3))
        data = self.camera.data
        data.type, data.ortho_scale = "ORTHO", 6

    def lamp(self, kind, **settings):
        """A new lamp's tree, with what it emits: (tree, the Emission)."""
        if "lamp" in bpy.data.objects:
            bpy.data.objects.remove(bpy.data.objects["lamp"])
        light = bpy.data.lights.new("lamp", kind)
        light.energy = 4 if kind == "SUN" else 200
        for key, value in settings.items():
            setattr(light, key, value)
        light.use_nodes = True
        made = bpy.data.objects.new("lamp", light)
        made.location, made.rotation_euler, made.scale = (-0.3, -0.2, 1.6), (0.35, -0.2, 0.4), (1.2, 0.8, 1)
        self.scene.collection.objects.link(made)
        self.owner = light
        light.node_tree.nodes.clear()
        output = self.node("OutputLight")
        emission = self.node("Emission")
        light.node_tree.links.new(emission.outputs[0], output.inputs["Surface"])
        return emission

    def feed(self, emission, color=None, strength=None):
        """Links what an Emission takes."""
        for name, value in (("Color", color), ("Strength", strength)):
            if value is not None:
                self.owner.node_tree.links.new(value, emission.inputs[name])

    def compare_lamp(self, name, **limits):
        """As `compare`, of the lamp."""
        self.compare(name, thing=("light", "lamp"), graph_of=lambda found: found.light("lamp"), **limits)

    KINDS = (
        ("POINT", {"shadow_soft_size": 0.0}),
        ("POINT", {"shadow_soft_size": 0.4, "use_soft_falloff": False}),
        ("AREA", {"shape": "RECTANGLE", "size": 1.4, "size_y": 0.7}),
        ("SUN", {"angle": 0.6}),
    )

    @kit.long
    def test_coordinates(self):
        """What a lamp knows of its points."""
        for kind, settings in self.KINDS:
            for node, output in (("TexCoord", "Normal"), ("TexCoord", "UV"), ("TexCoord", "Object"), ("NewGeometry", "Incoming"), ("NewGeometry", "Parametric"), ("NewGeometry", "Position")):
                if output == "UV" and settings.get("shadow_soft_size") == 0.0:
                    continue
                emission = self.lamp(kind, **settings)
                # Stripes, so that turned or mirrored axes are seen.
                value = self.out("VectorMath", "Vector", {0: self.out(node, output), 1: (5.0, 4.0, 3.0)}, operation="MULTIPLY")
                self.feed(emission, self.positive(self.out("VectorMath", "Vector", {0: value}, operation="SINE")))
                self.compare_lamp(f"{kind} {output} {sorted(settings.values(), key=str)}")

    def test_falloff(self):
        """Light Falloff and the length of the ray."""
        for kind, settings in self.KINDS[1:]:
            for output, smooth in (("Quadratic", 2.0), ("Linear", 0.0), ("Constant", 0.5)):
                emission = self.lamp(kind, **settings)
                self.feed(emission, strength=self.out("LightFalloff", output, {"Strength": 0.7, "Smooth": smooth}))
                self.compare_lamp(f"falloff {kind} {output} {smooth}")
        emission = self.lamp("POINT", shadow_soft_size=0.1)
        length = self.out("LightPath", "Ray Length")
        ramp = self.node("ValToRGB", {"Fac": self.out("Math", "Value", {0: length, 1: 0.3}, operation="MULTIPLY")})
        self.feed(emission, ramp.outputs["Color"])
        self.compare_lamp("ramp by the ray's length")
        emission = self.lamp("AREA", size=1.0)
        path = self.out("LightPath", "Is Diffuse Ray")
        self.feed(emission, strength=self.out("Math", "Value", {0: path, 1: 0.5}, operation="ADD"))
        self.compare_lamp("kinds of rays")

    @kit.long
    def test_falloff_of_meshes(self):
        """A plane that shines by Light Falloff, and its light on a floor; the camera sees it through tinted glass."""
        bpy.ops.mesh.primitive_plane_add(size=1, location=(-0.5, 0, 2), rotation=(0.6, 0, 0))
        shining = bpy.data.materials.new("shining")
        bpy.context.object.data.materials.append(shining)
        shining.use_nodes = True
        tree = shining.node_tree
        bpy.ops.mesh.primitive_plane_add(size=0.8, location=(-0.4, -0.1, 3))
        tint = bpy.data.materials.new("tint")
        bpy.context.object.data.materials.append(tint)
        tint.use_nodes = True
        tint.node_tree.nodes.clear()
        clear, out = (tint.node_tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfTransparent", "OutputMaterial"))
        clear.inputs["Color"].default_value = (0.9, 0.7, 0.5, 1)
        tint.node_tree.links.new(clear.outputs[0], out.inputs["Surface"])
        self.camera.data.clip_start = 1.5
        for output in ("Quadratic", "Linear", "Constant"):
            with self.subTest(output=output):
                tree.nodes.clear()
                emission, falloff = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "LightFalloff"))
                falloff.inputs["Strength"].default_value, falloff.inputs["Smooth"].default_value = 5, 0.5
                tree.links.new(falloff.outputs[output], emission.inputs["Strength"])
                tree.links.new(emission.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
                of_shining = {"thing": ("material", "shining"), "graph_of": lambda found: " ".join(found.material("shining")["extensions"])}
                self.compare(f"shining plane, {output}", samples=512, **of_shining)

    @kit.long
    def test_spots(self):
        """Points, spheres and discs, with soft edges and turned about."""
        for radius, soft in ((0.0, False), (0.3, False), (0.3, True)):
            emission = self.lamp("SPOT", shadow_soft_size=radius, use_soft_falloff=soft, spot_size=1.3, spot_blend=0.3)
            value = self.out("VectorMath", "Vector", {0: self.out("NewGeometry", "Incoming"), 1: (5.0, 4.0, 3.0)}, operation="MULTIPLY")
            self.feed(emission, self.positive(self.out("VectorMath", "Vector", {0: value}, operation="SINE")))
            self.compare_lamp(f"spot of radius {radius}, {'soft' if soft else 'sharp'}", samples=512)

    @kit.long
    def test_areas(self):
        """Rectangles and ellipses with a spread."""
        for shape in ("RECTANGLE", "ELLIPSE"):
            for spread in (math.pi, 1.5, 0.5):
                emission = self.lamp("AREA", shape=shape, size=1.4, size_y=0.7, spread=spread)
                value = self.out("VectorMath", "Vector", {0: self.out("TexCoord", "UV"), 1: (5.0, 4.0, 3.0)}, operation="MULTIPLY")
                self.feed(emission, self.positive(self.out("VectorMath", "Vector", {0: value}, operation="SINE")))
                self.compare_lamp(f"area {shape}, spread {spread:.1f}", samples=512)

    def profile(self, kind, around, down, words=None):
        """An IES Texture's output, of a made-up file of a photometric type."""
        if words is None:
            rows = [[1000 * math.cos(math.radians(d)) ** 2 + 300 * math.cos(math.radians(a)) ** 2 + 100 for d in down] for a in around]
            numbers = [f"1 1000 1.0 {len(down)} {len(around)} {kind} 2 0 0 0", "1 1 10"]
            numbers += [" ".join(f"{v:g}" for v in row) for row in (down, around, *rows)]
            words = "\n".join(["IESNA:LM-63-1995", "[TEST] made up", "TILT=NONE", *numbers, ""])
        text = bpy.data.texts.new("profile")
        text.write(words)
        return self.out("TexIES", "Fac", {"Strength": 0.02}, mode="INTERNAL", ies=text)

    @kit.long
    def test_ies(self):
        """Luminaires on lamps of all kinds, files of all kinds, and none."""
        lamps = (*self.KINDS[:3], ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 1.3}), ("SPOT", {"shadow_soft_size": 0.3, "spot_size": 1.3}))
        for kind, settings in lamps:
            emission = self.lamp(kind, **settings)
            self.feed(emission, strength=self.profile(1, (0,), range(0, 100, 10)))
            self.compare_lamp(f"ies {kind} {sorted(settings.values(), key=str)}", samples=512)
        files = {
            "all around": (1, range(0, 361, 30), range(0, 100, 10)),
            "half around": (1, range(0, 181, 30), range(0, 181, 20)),
            "a quarter": (1, range(0, 91, 30), range(0, 100, 10)),
            "type B": (2, range(0, 91, 15), range(0, 91, 15)),
            "type A": (3, range(-90, 91, 15), range(-90, 91, 15)),
            "broken": (1, (), (), "no numbers"),
        }
        for name, file in files.items():
            emission = self.lamp("POINT", shadow_soft_size=0.0)
            self.feed(emission, strength=self.profile(*file))
            # A broken one is a constant.
            self.compare(f"ies {name}", thing=("light", "lamp"), graph_of=lambda found: found.light("lamp") if name != "broken" else ["shader_graph"])


if __name__ == "__main__":
    unittest.main()
