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
