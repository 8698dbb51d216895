//! Small stages, written here: what becomes of them.

use std::path::{Path, PathBuf};

use glam::DVec3;
use sundog::import::{self, AnimationTime, ImportError, ImportOptions, Imported};
use sundog::scene::{LightKind, Projection, Verdict};

/// A folder with files in it.
pub struct Stage {
    folder: tempfile::TempDir,
}

impl Stage {
    /// With a root layer: Y up, metres.
    pub fn new(body: &str) -> Self {
        Self::with(&format!(
            "#usda 1.0\n(\n    upAxis = \"Y\"\n    metersPerUnit = 1\n)\n{body}"
        ))
    }

    pub fn with(text: &str) -> Self {
        let stage = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        stage.file("root.usda", text.as_bytes());
        stage
    }

    pub fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    pub fn try_load(&self, options: &ImportOptions) -> Result<Imported, ImportError> {
        import::load(&self.path(), options)
    }

    pub fn path(&self) -> PathBuf {
        self.folder.path().join("root.usda")
    }

    pub fn load(&self) -> Imported {
        self.try_load(&ImportOptions::default()).unwrap()
    }
}

/// A unit square in the XY plane.
pub const SQUARE: &str = r#"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
"#;

pub fn told(imported: &Imported, code: &str) -> Option<Verdict> {
    let mut all = imported.diagnostics.iter();
    all.find(|d| d.code == code).map(|d| d.verdict)
}

pub fn places(imported: &Imported) -> Vec<DVec3> {
    let instances = imported.scene.instances.iter();
    instances.map(|i| i.world_from_object.translation).collect()
}

#[test]
fn the_up_axis_and_the_unit_are_the_files() {
    let body = format!(
        "def Mesh \"m\" {{ double3 xformOp:translate = (100, 200, 300)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n{SQUARE} }}"
    );
    let body = body.replace("{ double3", "{\n double3");
    let stage = Stage::with(&format!(
        "#usda 1.0\n(\n upAxis = \"Z\"\n metersPerUnit = 0.01\n)\n{body}\n"
    ));
    let at = places(&stage.load())[0];
    assert!((at - DVec3::new(1.0, 3.0, -2.0)).length() < 1e-12, "{at}");
}

#[test]
fn transforms_stack_reset_and_invert() {
    let stage = Stage::new(&format!(
        r#"def Xform "a" {{
    double3 xformOp:translate = (1, 0, 0)
    float xformOp:rotateY = 90
    double3 xformOp:translate:pivot = (0, 0, 5)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:translate:pivot", "xformOp:rotateY", "!invert!xformOp:translate:pivot"]
    def Mesh "turned" {{
{SQUARE}    }}
    def Mesh "free" {{
        double3 xformOp:translate = (0, 7, 0)
        uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate"]
{SQUARE}    }}
}}"#
    ));
    let at = places(&stage.load());
    // (0, 0, -5) turned about Y by 90° is (-5, 0, 0).
    assert!(
        (at[0] - DVec3::new(-4.0, 0.0, 5.0)).length() < 1e-12,
        "{at:?}"
    );
    assert_eq!(at[1], DVec3::new(0.0, 7.0, 0.0));
}

#[test]
fn what_is_hidden_inactive_or_for_tools_is_not_placed() {
    let stage = Stage::new(&format!(
        r#"def Xform "hidden" {{
    token visibility = "invisible"
    def Mesh "m" {{
{SQUARE}    }}
}}
def Mesh "off" (
    active = false
)
{{
{SQUARE}}}
over "over"
{{
    def Mesh "m" {{
{SQUARE}    }}
}}
class Mesh "class" {{
{SQUARE}}}
def Mesh "guide" {{
    uniform token purpose = "guide"
{SQUARE}}}
def Mesh "seen" {{
    uniform token purpose = "render"
{SQUARE}}}"#
    ));
    let imported = stage.load();
    assert_eq!(imported.scene.instances.len(), 1);
    assert_eq!(imported.scene.instances[0].name, "seen");
    assert_eq!(told(&imported, "usd-purpose"), Some(Verdict::Exact));
}

#[test]
fn references_payloads_sublayers_and_variants_compose() {
    let stage = Stage::with(&format!(
        r#"#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
    subLayers = [@./under.usda@]
)
def "referenced" (
    references = @./part.usda@
)
{{
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def "paid" (
    payload = @./part.usda@</part>
)
{{
}}
def Xform "choice" (
    variants = {{
        string shape = "one"
    }}
    prepend variantSets = "shape"
)
{{
    variantSet "shape" = {{
        "none" {{
        }}
        "one" {{
            def Mesh "only" {{
{SQUARE}            }}
        }}
        "two" {{
            def Mesh "first" {{
{SQUARE}            }}
            def Mesh "second" {{
{SQUARE}            }}
        }}
    }}
}}
"#
    ));
    stage.file(
        "part.usda",
        format!("#usda 1.0\n(\n defaultPrim = \"part\"\n)\ndef Xform \"part\" {{\n def Mesh \"m\" {{\n{SQUARE} }}\n}}\n").as_bytes(),
    );
    stage.file(
        "under.usda",
        format!("#usda 1.0\ndef Mesh \"sub\" {{\n{SQUARE}}}\n").as_bytes(),
    );
    let imported = stage.load();
    assert_eq!(imported.scene.instances.len(), 4);
    // The same mesh of the same file is there once.
    assert_eq!(imported.scene.meshes.len(), 3);
    assert_eq!(imported.variants, ["shape=none", "shape=one", "shape=two"]);
    let count = |variant: &str| {
        let options = ImportOptions {
            variant: Some(variant.into()),
            ..ImportOptions::default()
        };
        stage.try_load(&options).map(|i| i.scene.instances.len())
    };
    assert_eq!(count("shape=none").unwrap(), 3);
    assert_eq!(count("two").unwrap(), 5);
    let error = count("shape=three").unwrap_err().to_string();
    assert!(error.contains("shape=one"), "{error}");
}

#[test]
fn a_missing_layer_is_told_and_a_circle_ends() {
    let stage = Stage::new(
        "def \"a\" (\n references = @./missing.usda@\n)\n{\n}\ndef \"b\" (\n references = </b>\n)\n{\n}\n",
    );
    let imported = stage.load();
    assert_eq!(told(&imported, "usd-composition"), Some(Verdict::Lost));
}

#[test]
fn instances_share_their_meshes() {
    let mut body = format!(
        "class Xform \"proto\" {{\n def Mesh \"m\" {{\n double3 xformOp:translate = (0, 1, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n{SQUARE} }}\n}}\n"
    );
    for i in 0..5 {
        body += &format!(
            "def Xform \"i{i}\" (\n instanceable = true\n inherits = </proto>\n)\n{{\n double3 xformOp:translate = ({i}, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n"
        );
    }
    let imported = Stage::new(&body).load();
    assert_eq!(imported.scene.meshes.len(), 1);
    let at = places(&imported);
    assert_eq!(at.len(), 5);
    assert_eq!(at[3], DVec3::new(3.0, 1.0, 0.0));
}

/// `Outer` has an instance in it, and is an instance itself.
#[test]
fn instances_in_instances_are_there() {
    let stage = Stage::new(&format!(
        r#"class Xform "proto" {{
    def Mesh "m" {{
{SQUARE}    }}
}}
class Xform "outer" {{
    def Xform "in" (
        instanceable = true
        inherits = </proto>
    )
    {{
        double3 xformOp:translate = (0, 1, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
}}
def Xform "a" (
    instanceable = true
    inherits = </outer>
)
{{
}}
def Xform "b" (
    instanceable = true
    inherits = </outer>
)
{{
    double3 xformOp:translate = (5, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
"#
    ));
    let imported = stage.load();
    assert_eq!(places(&imported), [DVec3::Y, DVec3::new(5.0, 1.0, 0.0)]);
    assert_eq!(imported.scene.meshes.len(), 1);
}

#[test]
fn point_instancers_place_turn_scale_and_hide() {
    let stage = Stage::new(&format!(
        r#"def PointInstancer "points" {{
    rel prototypes = [</points/a>, </points/b>]
    int[] protoIndices = [0, 1, 0, 0]
    point3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)]
    quath[] orientations = [(1, 0, 0, 0), (0.7071, 0, 0, 0.7071), (1, 0, 0, 0), (1, 0, 0, 0)]
    float3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1), (1, 1, 1)]
    int64[] invisibleIds = [2]
    def Mesh "a" {{
{SQUARE}    }}
    def Xform "b" {{
        double3 xformOp:translate = (1, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Mesh "m" {{
{SQUARE}        }}
    }}
}}"#
    ));
    let at = places(&stage.load());
    assert_eq!(at.len(), 3);
    // Moved by (1, 0, 0) first, which is twice as far along Y then.
    assert!(
        (at[1] - DVec3::new(1.0, 2.0, 0.0)).length() < 1e-3,
        "{at:?}"
    );
    assert_eq!(at[2].x, 3.0);
}

#[test]
fn values_of_every_interpolation_reach_their_corners() {
    let stage = Stage::new(
        r#"def Mesh "m" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    int[] faceVertexCounts = [3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (
        interpolation = "faceVarying"
    )
    int[] primvars:st:indices = [0, 1, 2, 0, 2, 3]
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] (
        interpolation = "uniform"
    )
    uniform token orientation = "leftHanded"
}"#,
    );
    let imported = stage.load();
    let mesh = &imported.scene.meshes[0];
    let colors = mesh.colors.as_ref().unwrap();
    // Two colours meet at the diagonal: its points are there twice.
    assert_eq!(mesh.positions.len(), 6);
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        for corner in triangle {
            let expected = if face == 0 {
                [1.0, 0.0, 0.0, 1.0]
            } else {
                [0.0, 1.0, 0.0, 1.0]
            };
            assert_eq!(colors[*corner as usize], expected);
        }
    }
    // Seen clockwise from the front, so the other way round here.
    assert_eq!(
        mesh.positions[mesh.triangles[0][0] as usize],
        [1.0, 1.0, 0.0]
    );
}

#[test]
fn subsets_have_materials_of_their_own_and_stronger_bindings_win() {
    let stage = Stage::new(&format!(
        r#"def Xform "all" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{{
    rel material:binding = </red>
    def Mesh "m" {{
        int[] faceVertexCounts = [3, 3]
        int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        uniform token subdivisionScheme = "none"
        def GeomSubset "part" (
            prepend apiSchemas = ["MaterialBindingAPI"]
        )
        {{
            uniform token elementType = "face"
            uniform token familyName = "materialBind"
            int[] indices = [1]
            rel material:binding = </green>
        }}
    }}
}}
def Xform "strong" {{
    rel material:binding = </green> (
        bindMaterialAs = "strongerThanDescendants"
    )
    def Mesh "m" {{
        rel material:binding = </red>
{SQUARE}    }}
}}
{}{}"#,
        material("red", "color3f inputs:diffuseColor = (1, 0, 0)"),
        material("green", "color3f inputs:diffuseColor = (0, 1, 0)"),
    ));
    let scene = stage.load().scene;
    let name = |mesh: usize| {
        let material = scene.meshes[mesh].material.unwrap();
        scene.materials[material.0 as usize].name.clone()
    };
    assert_eq!([name(0), name(1), name(2)], ["red", "green", "green"]);
    assert_eq!(scene.meshes[1].triangles.len(), 1);
}

fn material(name: &str, inputs: &str) -> String {
    format!(
        r#"
def Material "{name}" {{
    token outputs:surface.connect = </{name}/s.outputs:surface>
    def Shader "s" {{
        uniform token info:id = "UsdPreviewSurface"
        {inputs}
        token outputs:surface
    }}
}}
"#
    )
}

#[test]
fn a_missing_texture_is_told_and_shows_its_fallback() {
    let stage = Stage::new(&format!(
        "def Mesh \"m\" {{\n rel material:binding = </paint>\n{SQUARE}}}\n{}",
        material("paint", "color3f inputs:diffuseColor.connect = </paint/t.outputs:rgb>").replace(
            "def Shader \"s\"",
            "def Shader \"t\" {\n uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @./none.png@\n float4 inputs:fallback = (0.25, 0.5, 0.75, 1)\n}\n def Shader \"s\""
        )
    ));
    let imported = stage.load();
    assert_eq!(told(&imported, "image-lost"), Some(Verdict::Lost));
    let color = format!("{:?}", imported.scene.materials[0].graph);
    assert!(color.contains("[0.25, 0.5, 0.75]"), "{color}");
}

#[test]
fn networks_in_a_circle_end() {
    let stage = Stage::new(&format!(
        "def Mesh \"m\" {{\n rel material:binding = </paint>\n{SQUARE}}}\n{}",
        material("paint", "color3f inputs:diffuseColor.connect = </paint/a.outputs:out>").replace(
            "def Shader \"s\"",
            "def Shader \"a\" {\n uniform token info:id = \"ND_add_color3\"\n color3f inputs:in1.connect = </paint/a.outputs:out>\n color3f outputs:out\n}\n def Shader \"s\""
        )
    ));
    assert_eq!(stage.load().scene.materials.len(), 1);
}

#[test]
fn lamps_and_cameras_are_in_the_stages_units() {
    let stage = Stage::with(
        r#"#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 0.01
)
def SphereLight "bulb" {
    float inputs:radius = 10
    float inputs:intensity = 5
    float inputs:exposure = 1
}
def DistantLight "sun" {
    float inputs:intensity = 3
    float inputs:angle = 0
}
def Camera "film" {
    float focalLength = 50
    float horizontalAperture = 36
    float verticalAperture = 24
    float2 clippingRange = (10, 1000)
    float fStop = 2
    float focusDistance = 200
}
def RenderSettings "settings" {
    rel camera = </film>
    int2 resolution = (300, 200)
}
"#,
    );
    let scene = stage.load().scene;
    let LightKind::Point {
        intensity, radius, ..
    } = scene.lights[0].kind
    else {
        panic!("{:?}", scene.lights[0].kind);
    };
    // A radiance of 10 from a sphere of 10 cm.
    assert!((intensity - 10.0 * std::f32::consts::PI * 0.01).abs() < 1e-5);
    assert!((radius - 0.1).abs() < 1e-7);
    assert_eq!(
        scene.lights[1].kind,
        LightKind::Sun {
            irradiance: 3.0,
            angle: 0.0
        }
    );
    let camera = &scene.cameras[0];
    let Projection::Perspective { vertical_fov, .. } = camera.projection else {
        panic!()
    };
    assert!((vertical_fov - 2.0 * (0.24f64).atan()).abs() < 1e-12);
    assert!((camera.clip_near - 0.1).abs() < 1e-12);
    let lens = camera.aperture.unwrap();
    // 50 mm at f/2 has a radius of 12.5 mm.
    assert!((lens.radius - 0.0125).abs() < 1e-12 && (lens.focus_distance - 2.0).abs() < 1e-12);
    assert_eq!(
        (scene.render.width, scene.render.height),
        (Some(300), Some(200))
    );
}

#[test]
fn frames_are_time_codes() {
    let stage = Stage::with(&format!(
        "#usda 1.0\n(\n upAxis = \"Y\"\n metersPerUnit = 1\n startTimeCode = 1\n endTimeCode = 11\n timeCodesPerSecond = 10\n)\ndef Mesh \"m\" {{\n double3 xformOp:translate.timeSamples = {{\n 1: (1, 0, 0),\n 11: (11, 0, 0),\n }}\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n{SQUARE}}}\n"
    ));
    let at = |time: Option<(f64, Option<f64>)>| {
        let animation = time.map(|(seconds, frame)| AnimationTime {
            name: None,
            seconds,
            frame,
        });
        let options = ImportOptions {
            animation,
            ..ImportOptions::default()
        };
        places(&stage.try_load(&options).unwrap())[0].x
    };
    assert_eq!(at(None), 1.0);
    assert_eq!(at(Some((0.25, Some(6.0)))), 6.0);
    assert_eq!(at(Some((0.5, None))), 5.0);
}

#[test]
fn damage_is_one_sentence() {
    for text in [
        "",
        "#usda 1.0\ndef Mesh \"m\" {",
        "#usda 1.0\n\u{0}",
        "PXR-USDC",
        "#usda 9.0\n",
    ] {
        let stage = Stage::with(text);
        let error = stage
            .try_load(&ImportOptions::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("root.usda") && error.lines().count() == 1,
            "{error}"
        );
    }
    let deep = format!("#usda 1.0\n{}", "def \"a\" {\n".repeat(100_000));
    let error = Stage::with(&deep)
        .try_load(&ImportOptions::default())
        .unwrap_err();
    assert!(error.to_string().contains("nested"), "{error}");
    let missing = import::load(Path::new("/nowhere/none.usdc"), &ImportOptions::default());
    assert!(
        missing
            .unwrap_err()
            .to_string()
            .contains("there is no such file")
    );
}

#[test]
fn meshes_that_contradict_themselves_do_no_harm() {
    for body in [
        "int[] faceVertexCounts = [4, 2147483647, -5]\n int[] faceVertexIndices = [0, 1, 2, 900]\n point3f[] points = [(0, 0, 0)]",
        "int[] faceVertexCounts = [3]\n int[] faceVertexIndices = []\n point3f[] points = [(nan, inf, 0)]",
        "int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 0, 0]\n point3f[] points = [(0, 0, 0)]\n uniform token subdivisionScheme = \"catmullClark\"\n int[] holeIndices = [-1, 7]\n int[] creaseIndices = [0, 900]\n int[] creaseLengths = [2]\n float[] creaseSharpnesses = [3]",
        "int[] faceVertexCounts = [3]",
    ] {
        let _ = Stage::new(&format!("def Mesh \"m\" {{\n {body}\n}}")).load();
    }
}

#[test]
fn what_lies_outside_of_the_folder_is_refused() {
    let stage = Stage::new("def \"a\" (\n references = @/etc/passwd@\n)\n{\n}\n");
    let error = stage.try_load(&ImportOptions::default()).unwrap_err();
    assert!(matches!(error, ImportError::Outside { .. }), "{error}");
}

#[test]
fn a_package_is_read_and_a_packed_one_refused() {
    use std::io::Write;
    use zip::write::SimpleFileOptions;
    let root = "#usda 1.0\n(\n upAxis = \"Y\"\n metersPerUnit = 1\n)\ndef \"a\" (\n references = @part.usda@\n)\n{\n}\n";
    let part = format!("#usda 1.0\n(\n defaultPrim = \"p\"\n)\ndef Mesh \"p\" {{\n{SQUARE}}}\n");
    let pack = |method| {
        let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(method);
        for (name, text) in [("root.usda", root), ("part.usda", &part)] {
            archive.start_file(name, options).unwrap();
            archive.write_all(text.as_bytes()).unwrap();
        }
        archive.finish().unwrap().into_inner()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.usdz");
    std::fs::write(&path, pack(zip::CompressionMethod::Stored)).unwrap();
    let imported = import::load(&path, &ImportOptions::default()).unwrap();
    assert_eq!(imported.scene.instances.len(), 1);
    std::fs::write(&path, pack(zip::CompressionMethod::Deflated)).unwrap();
    let error = import::load(&path, &ImportOptions::default()).unwrap_err();
    assert!(error.to_string().contains("compressed"), "{error}");
}
