//! Which materials of USD are shown, and what MaterialX' nodes become.

use sundog::import::{ImportOptions, Imported};
use sundog::render::{RenderSettings, Silent, render};
use sundog::scene::Verdict;
use sundog::scene::graph::node::principled;
use sundog::scene::graph::{Input, NodeKind};

use super::usd::{SQUARE, Stage, told};

/// A surface that shines in what a node gives.
fn shining(nodes: &str) -> Stage {
    Stage::new(&format!(
        r#"def Mesh "m" {{
    rel material:binding = </paint>
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (
        interpolation = "vertex"
    )
{SQUARE}}}
def Camera "front" {{
    uniform token projection = "orthographic"
    float horizontalAperture = 4
    float verticalAperture = 4
    double3 xformOp:translate = (0.5, 0.5, 5)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def Material "paint" {{
    token outputs:mtlx:surface.connect = </paint/s.outputs:out>
    def Shader "s" {{
        uniform token info:id = "ND_surface_unlit"
        float inputs:emission = 1
        color3f inputs:emission_color.connect = </paint/n.outputs:out>
        token outputs:out
    }}
    {nodes}
}}"#
    ))
}

/// The colours of the four quarters of the square's middle, 0.1 from it, each by a filter that ends inside of the square: top left, top right, bottom left, bottom right.
fn quarters(nodes: &str) -> [[f32; 3]; 4] {
    let imported = shining(nodes).load();
    assert_eq!(told(&imported, "usd-node"), None, "{nodes}");
    let settings = RenderSettings {
        width: 2,
        height: 2,
        samples: 64,
        bounces: 1,
        ..RenderSettings::default()
    };
    let picture = render(&imported.scene, &settings, &Silent).unwrap().picture;
    let pixels: Vec<[f32; 3]> = picture.layers[0]
        .data
        .chunks(4)
        .map(|c| [c[0], c[1], c[2]])
        .collect();
    pixels.try_into().unwrap()
}

fn node(id: &str, inputs: &str) -> String {
    format!(
        "def Shader \"n\" {{\n uniform token info:id = \"{id}\"\n {inputs}\n color3f outputs:out\n }}"
    )
}

#[test]
fn ramps_and_splits_go_across_the_coordinates() {
    let ends = "color3f inputs:valuel = (1, 0, 0)\n color3f inputs:valuer = (0, 0, 1)";
    let [left, right, ..] = quarters(&node(
        "ND_splitlr_color3",
        &format!("{ends}\n float inputs:center = 0.5"),
    ));
    assert!(left[0] > 0.8 && right[2] > 0.8, "{left:?} {right:?}");
    let [left, right, ..] = quarters(&node("ND_ramplr_color3", ends));
    assert!(
        (left[0] - 0.6).abs() < 0.02 && (right[0] - 0.4).abs() < 0.02,
        "{left:?} {right:?}"
    );
    let ends = "color3f inputs:valuet = (1, 0, 0)\n color3f inputs:valueb = (0, 0, 1)";
    let [top, _, bottom, _] = quarters(&node("ND_ramptb_color3", ends));
    assert!(
        (top[0] - 0.6).abs() < 0.02 && (bottom[0] - 0.4).abs() < 0.02,
        "{top:?} {bottom:?}"
    );
}

/// What each node makes of two numbers, by its formula in MaterialX' specification.
#[test]
fn colours_are_adjusted_and_blended_as_specified() {
    let fg_bg = "color3f inputs:fg = (0.25, 0.5, 0.75)\n color3f inputs:bg = (0.5, 0.25, 0.125)";
    for (id, inputs, expected) in [
        ("ND_plus_color3", fg_bg, [0.75, 0.75, 0.875]),
        ("ND_minus_color3", fg_bg, [0.25, -0.25, -0.625]),
        ("ND_difference_color3", fg_bg, [0.25, 0.25, 0.625]),
        ("ND_screen_color3", fg_bg, [0.625, 0.625, 0.78125]),
        ("ND_dodge_color3", fg_bg, [0.5 / 0.75, 0.5, 0.5]),
        (
            "ND_contrast_color3",
            "color3f inputs:in = (0.5, 0.25, 0.75)\n color3f inputs:amount = (2, 2, 2)",
            [0.5, 0.0, 1.0],
        ),
        (
            "ND_hsvadjust_color3",
            "color3f inputs:in = (1, 0, 0)\n vector3f inputs:amount = (0.3333333, 1, 0.5)",
            [0.0, 0.5, 0.0],
        ),
        (
            "ND_switch_color3",
            "color3f inputs:in1 = (1, 1, 1)\n color3f inputs:in2 = (0.1, 0.2, 0.3)\n float inputs:which = 1",
            [0.1, 0.2, 0.3],
        ),
    ] {
        for found in quarters(&node(id, inputs)) {
            for (value, expected) in found.iter().zip(expected) {
                // Nothing shines with less than nothing.
                assert!(
                    (value - f32::max(expected, 0.0)).abs() < 1e-3,
                    "{id}: {found:?}"
                );
            }
        }
    }
}

/// Values of MaterialX' own definitions: its graphs, and its noise (from OSL) computed by hand at these points.
#[test]
fn places_and_patterns_are_materialxs() {
    let at = "float3 inputs:position = (1.3, 2.6, 3.4)";
    for (id, inputs, expected) in [
        (
            "ND_swizzle_color3_color3",
            "color3f inputs:in = (0.1, 0.2, 0.3)\n string inputs:channels = \"bg1\"",
            [0.3, 0.2, 1.0],
        ),
        ("ND_noise3d_float", at, [0.444_195; 3]),
        ("ND_fractal3d_float", at, [0.611_686; 3]),
        (
            "ND_noise2d_float",
            "float2 inputs:texcoord = (0.3, 0.7)\n float inputs:amplitude = 2\n float inputs:pivot = 0.5",
            [0.581_487; 3],
        ),
        // The camera looks at the square from in front.
        ("ND_facingratio_float", "", [1.0; 3]),
        ("ND_facingratio_float", "bool inputs:invert = 1", [0.0; 3]),
        ("ND_viewdirection_vector3", "", [0.0, 0.0, -1.0]),
        (
            "ND_normal_vector3",
            "string inputs:space = \"world\"",
            [0.0, 0.0, 1.0],
        ),
        ("ND_normal_vector3", "", [0.0, 0.0, 1.0]),
    ] {
        for found in quarters(&node(id, inputs)) {
            for (value, expected) in found.iter().zip(expected) {
                assert!((value - expected).abs() < 1e-3, "{id}: {found:?}");
            }
        }
    }
    for space in ["object", "world"] {
        let inputs = format!("string inputs:space = \"{space}\"");
        let [top, right, bottom, _] = quarters(&node("ND_position_vector3", &inputs));
        assert!(
            (top[0] - 0.4).abs() < 0.02 && (right[0] - 0.6).abs() < 0.02,
            "{top:?}"
        );
        assert!(
            (top[1] - 0.6).abs() < 0.02 && (bottom[1] - 0.4).abs() < 0.02,
            "{top:?}"
        );
        assert!(top[2].abs() < 1e-3, "{top:?}");
    }
    let [top, right, bottom, last] = quarters(&node(
        "ND_checkerboard_color3",
        "float2 inputs:uvtiling = (2, 2)",
    ));
    // The filter of a pixel reaches a little into the other quarters.
    let (white, black) = (top[0].min(last[0]), right[0].max(bottom[0]));
    assert!(white > 0.7 && black < 0.3, "{white} {black}");
    let [top, _, bottom, _] = quarters(&node(
        "ND_ramp4_color3",
        "color3f inputs:valuetl = (1, 0, 0)",
    ));
    assert!((top[0] - 0.24).abs() < 0.02 && (bottom[0] - 0.36).abs() < 0.02);
}

/// What MaterialX 1.39.5's own code says of noises (tests/unit/nodes/materialx.rs has it), and its graphs of what is made of other nodes.
#[test]
fn noises_of_several_numbers_and_nodes_made_of_others_are_materialxs() {
    let flat = "float2 inputs:texcoord = (-1.6, 2.45)";
    let deep = "float3 inputs:position = (-1.6, 2.45, 7.9)";
    let near = "float3 inputs:position = (0.3, 0.7, 0.2)";
    let with = |place: &str, more: &str| format!("{place}\n {more}");
    let layers =
        "color4f inputs:fg = (0.25, 0.5, 0.1, 0.5)\n color4f inputs:bg = (0.5, 0.25, 0.125, 0.25)";
    let jitter = "float inputs:jitter = 0.8";
    let mut wrong = Vec::new();
    let octaves = "float inputs:lacunarity = 2.1\n float inputs:diminish = 0.6";
    for (id, inputs, expected) in [
        ("ND_noise2d_color3", with(flat, "float inputs:pivot = 1"), [0.337_748, 1.219_156, 1.274_071]),
        ("ND_noise3d_vector3", with(deep, "float inputs:pivot = 1"), [1.165_911, 1.049_369, 0.836_021]),
        ("ND_noise3d_color4", with(deep, "float inputs:pivot = 1"), [1.165_911, 1.049_369, 0.836_021]),
        ("ND_fractal3d_color3", with(near, octaves), [0.473_277, -0.318_488, 0.456_499]),
        ("ND_cellnoise2d_float", flat.to_owned(), [0.562_888; 3]),
        ("ND_cellnoise3d_float", near.to_owned(), [0.611_068; 3]),
        ("ND_worleynoise2d_float", with(flat, jitter), [0.505_864; 3]),
        ("ND_worleynoise2d_vector3", with(flat, jitter), [0.505_864, 0.852_551, 1.054_507]),
        ("ND_worleynoise3d_vector3", with(near, &format!("{jitter}\n int inputs:style = 1")), [0.111_573, 0.325_1, 0.339_947]),
        ("ND_unifiednoise3d_float", with(near, "int inputs:type = 1"), [0.611_068; 3]),
        ("ND_unifiednoise2d_float", with(flat, &format!("{jitter}\n int inputs:type = 2\n float inputs:outmax = 0.5")), [0.252_932; 3]),
        // 0.0735 is 301 of 4096: in the cell (301, 5).
        (
            "ND_randomfloat_float",
            "float inputs:in = 0.0735\n int inputs:seed = 5\n float inputs:max = 2".to_owned(),
            [1.745_02; 3],
        ),
        ("ND_randomcolor_integer", "int inputs:in = 7\n float inputs:saturationlow = 0\n float inputs:saturationhigh = 0\n float inputs:brightnesslow = 0.5\n float inputs:brightnesshigh = 0.5".to_owned(), [0.5; 3]),
        ("ND_safepower_color3FA", "color3f inputs:in1 = (0.36, -0.5, 0.25)\n float inputs:in2 = 0.5".to_owned(), [0.6, 0.0, 0.5]),
        ("ND_distance_vector3", "float3 inputs:in1 = (1, 2, 3)\n float3 inputs:in2 = (1, 2.3, 3.4)".to_owned(), [0.5; 3]),
        ("ND_trianglewave_float", "float inputs:in = -1.3".to_owned(), [0.3; 3]),
        ("ND_reflect_vector3", "float3 inputs:in = (0.6, 0.2, -0.8)".to_owned(), [0.6, 0.2, 0.8]),
        ("ND_colorcorrect_color3", "color3f inputs:in = (0.25, 0.25, 0.25)\n float inputs:gamma = 2\n float inputs:lift = 0.1\n float inputs:gain = 0.5\n float inputs:exposure = 1".to_owned(), [0.55; 3]),
        ("ND_range_float", "float inputs:in = 0.25\n float inputs:gamma = 2\n float inputs:outlow = 1\n float inputs:outhigh = 2".to_owned(), [1.5; 3]),
        ("ND_sqrt_vector3", "float3 inputs:in = (0.25, 0.04, 1)".to_owned(), [0.5, 0.2, 1.0]),
        ("ND_overlay_color3", "color3f inputs:fg = (0.25, 0.5, 0.75)\n color3f inputs:bg = (0.25, 0.5, 0.75)".to_owned(), [0.125, 0.5, 0.875]),
        ("ND_over_color4", layers.to_owned(), [0.5, 0.625, 0.1625]),
        ("ND_matte_color4", layers.to_owned(), [0.375, 0.375, 0.1125]),
        ("ND_in_color4", layers.to_owned(), [0.0625, 0.125, 0.025]),
        ("ND_out_color4", layers.to_owned(), [0.1875, 0.375, 0.075]),
        ("ND_mask_color4", layers.to_owned(), [0.25, 0.125, 0.0625]),
        ("ND_logical_xor", "bool inputs:in1 = 1\n bool inputs:in2 = 0".to_owned(), [1.0; 3]),
        ("ND_logical_and", "bool inputs:in1 = 1\n bool inputs:in2 = 0".to_owned(), [0.0; 3]),
        ("ND_circle_float", "float2 inputs:texcoord = (0.3, 0.3)\n float inputs:radius = 0.4".to_owned(), [0.0; 3]),
    ] {
        let found = quarters(&node(id, &inputs))[0];
        let pairs = found.iter().zip(expected);
        if pairs.into_iter().any(|(a, b)| (a - b).abs() > 1e-3) {
            wrong.push(format!("{id}: {found:?} and not {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A temperature that other nodes say gives the light of the same temperature as a number.
#[test]
fn black_bodies_of_connected_temperatures_shine_as_those_of_numbers() {
    for kelvin in [1000, 1700, 3000, 6500, 20_000, 40_000] {
        // A number that is not known before the place is: none of the coordinate, and the rest.
        let nodes = format!(
            "{}
def Shader \"u\" {{\n uniform token info:id = \"ND_texcoord_vector2\"\n float2 outputs:out\n }}
def Shader \"e\" {{\n uniform token info:id = \"ND_extract_vector2\"\n float2 inputs:in.connect = </paint/u.outputs:out>\n float outputs:out\n }}
def Shader \"z\" {{\n uniform token info:id = \"ND_multiply_float\"\n float inputs:in1.connect = </paint/e.outputs:out>\n float inputs:in2 = 0.000001\n float outputs:out\n }}
def Shader \"k\" {{\n uniform token info:id = \"ND_add_float\"\n float inputs:in1.connect = </paint/z.outputs:out>\n float inputs:in2 = {kelvin}\n float outputs:out\n }}",
            node("ND_blackbody", "float inputs:temperature.connect = </paint/k.outputs:out>")
        );
        let number = format!("float inputs:temperature = {kelvin}");
        let (found, expected) = (
            quarters(&nodes)[0],
            quarters(&node("ND_blackbody", &number))[0],
        );
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 2e-3 * expected.max(1.0),
                "{kelvin}: {found} {expected}"
            );
        }
    }
}

#[test]
fn surfaces_are_mixed_and_inputs_that_are_not_read_named() {
    let surface = |name: &str, inputs: &str| {
        format!(
            "def Shader \"{name}\" {{\n uniform token info:id = \"ND_open_pbr_surface_surfaceshader\"\n {inputs}\n token outputs:out\n }}\n"
        )
    };
    let gltf = "def Shader \"g\" {\n uniform token info:id = \"ND_gltf_pbr_surfaceshader\"\n float inputs:metallic = 0.25\n token outputs:out\n }\n";
    let plain = surface(
        "a",
        "float inputs:transmission_weight = 0\n float inputs:transmission_depth = 2",
    );
    let deep = surface(
        "b",
        "float inputs:transmission_weight = 1\n float inputs:transmission_depth = 2",
    );
    let load = |nodes: &str, of: [&str; 2]| {
        let [fg, bg] = of;
        Stage::new(&format!(
            r#"def Mesh "m" {{
    rel material:binding = </paint>
{SQUARE}}}
def Material "paint" {{
    token outputs:mtlx:surface.connect = </paint/s.outputs:out>
    def Shader "s" {{
        uniform token info:id = "ND_mix_surfaceshader"
        token inputs:fg.connect = </paint/{fg}.outputs:out>
        token inputs:bg.connect = </paint/{bg}.outputs:out>
        float inputs:mix = 0.25
        token outputs:out
    }}
    {nodes}
}}"#
        ))
        .load()
    };
    let imported = load(&format!("{gltf}{plain}"), ["g", "a"]);
    assert_eq!(told(&imported, "usd-node"), None);
    assert_eq!(told(&imported, "usd-input"), None);
    let graph = &imported.scene.materials[0].graph;
    let mut kinds = graph.nodes.iter().map(|node| &node.kind);
    assert!(kinds.any(|kind| matches!(kind, NodeKind::MixShader)));
    let principled = graph
        .nodes
        .iter()
        .filter(|node| matches!(node.kind, NodeKind::PrincipledBsdf { .. }))
        .map(|node| node.inputs[principled::METALLIC]);
    assert!(principled.into_iter().any(|m| m == Input::float(0.25)));
    let imported = load(&format!("{gltf}{deep}"), ["g", "b"]);
    assert_eq!(told(&imported, "usd-input"), Some(Verdict::Lost));
    let circle = load("", ["s", "s"]);
    assert!(circle.scene.materials.len() == 1);
}

/// Blender's exporter writes these on every surface: they are what the surface has anyhow.
#[test]
fn a_surfaces_own_directions_need_no_nodes() {
    let node = |name: &str, id: &str, inputs: &str| {
        format!(
            "def Shader \"{name}\" {{\n uniform token info:id = \"{id}\"\n {inputs}\n float3 outputs:out\n }}\n"
        )
    };
    let world = "string inputs:space = \"world\"";
    let nodes = [
        node("n", "ND_normal_vector3", world),
        node(
            "nn",
            "ND_normalize_vector3",
            "float3 inputs:in.connect = </paint/n.outputs:out>",
        ),
        node("t", "ND_tangent_vector3", world),
        node(
            "tt",
            "ND_rotate3d_vector3",
            "float3 inputs:in.connect = </paint/t.outputs:out>\n float inputs:amount = 0",
        ),
        node(
            "s",
            "ND_open_pbr_surface_surfaceshader",
            "float inputs:specular_roughness_anisotropy = 0.5\n float3 inputs:geometry_normal.connect = </paint/nn.outputs:out>\n float3 inputs:geometry_tangent.connect = </paint/tt.outputs:out>",
        ),
    ];
    let imported = Stage::new(&format!(
        "def Mesh \"m\" {{\n rel material:binding = </paint>\n{SQUARE}}}\ndef Material \"paint\" {{\n token outputs:mtlx:surface.connect = </paint/s.outputs:out>\n{}}}",
        nodes.concat()
    ))
    .load();
    assert_eq!(told(&imported, "usd-input"), None);
    let mut nodes = imported.scene.materials[0].graph.nodes.iter();
    let surface = nodes.rfind(|node| matches!(node.kind, NodeKind::PrincipledBsdf { .. }));
    let normal = surface.unwrap().inputs[principled::NORMAL];
    assert!(!matches!(normal, Input::Link(_)), "{normal:?}");
}

/// What only another renderer knows stands back behind what is known, and is told where there is nothing else.
#[test]
fn the_first_material_with_a_known_surface_is_shown() {
    let stage = |preview: &str| -> Imported {
        let body = format!(
            r#"def Mesh "m" {{
    rel material:binding:full = </theirs>
    {preview}
{SQUARE}}}
def Material "theirs" {{
    token outputs:ri:surface.connect = </theirs/s.outputs:out>
    def Shader "s" {{
        uniform token info:id = "PxrSurface"
        token outputs:out
    }}
}}
def Material "ours" {{
    token outputs:surface.connect = </ours/s.outputs:surface>
    def Shader "s" {{
        uniform token info:id = "UsdPreviewSurface"
        token outputs:surface
    }}
}}"#
        );
        Stage::new(&body)
            .try_load(&ImportOptions::default())
            .unwrap()
    };
    let both = stage("rel material:binding:preview = </ours>");
    assert_eq!(told(&both, "usd-material"), None);
    assert_eq!(both.scene.materials[0].name, "ours");
    assert_eq!(told(&stage(""), "usd-material"), Some(Verdict::Lost));
}

/// MaterialX counts lengths in the stage's units; Blender writes metres whatever the unit.
#[test]
fn lengths_below_the_surface_are_in_the_stages_unit() {
    for (doc, unit, metres) in [
        ("", "0.01", 0.05),
        ("", "1", 5.0),
        ("Blender v5.2.3", "0.01", 5.0),
    ] {
        let stage = Stage::with(&format!(
            r#"#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = {unit}
    doc = "{doc}"
)
def Mesh "m" {{
    rel material:binding = </wax>
{SQUARE}}}
def Material "wax" {{
    token outputs:mtlx:surface.connect = </wax/s.outputs:out>
    def Shader "s" {{
        uniform token info:id = "ND_open_pbr_surface_surfaceshader"
        float inputs:subsurface_weight = 1
        float inputs:subsurface_radius = 5
        token outputs:out
    }}
}}"#
        ));
        let imported = stage.load();
        let graph = &imported.scene.materials[0].graph;
        let scale = graph.nodes.iter().find_map(|node| {
            let principled = matches!(node.kind, NodeKind::PrincipledBsdf { .. });
            principled.then(|| node.inputs[principled::SUBSURFACE_SCALE])
        });
        let Some(Input::Value([scale, ..])) = scale else {
            panic!("{scale:?}")
        };
        assert!(
            (f64::from(scale) - metres).abs() < 1e-6,
            "{doc} {unit}: {scale}"
        );
    }
}
