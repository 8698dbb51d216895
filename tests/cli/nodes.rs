//! Node trees as `sundog info` and `sundog cost --effects` tell of them.

use super::{Folder, scene};
use serde_json::{Value, json};

/// The scene with a node tree: a colour that may be that of noise, and a roughness that is a sum of constants.
fn patterned(color: Value) -> Folder {
    let mut document = scene();
    document["extensionsUsed"] = json!(["SUNDOG_shader_graph"]);
    document["materials"] = json!([{"name": "Wood", "extensions": {"SUNDOG_shader_graph": {
        "blender": [5, 2, 3],
        "nodes": [
            {"type": "ShaderNodeTexCoord"},
            {"type": "ShaderNodeTexNoise",
                "properties": {"noise_dimensions": "3D", "noise_type": "FBM", "normalize": true},
                "inputs": {"Vector": {"node": 0, "output": "Object"}}},
            {"type": "ShaderNodeMath", "properties": {"operation": "ADD", "use_clamp": false},
                "inputs": {"Value": 0.25, "Value_001": 0.25}},
            {"type": "ShaderNodeBsdfDiffuse", "inputs": {
                "Color": color, "Roughness": {"node": 2, "output": "Value"}}}
        ],
        "surface": {"node": 3, "output": "BSDF"}
    }}}]);
    let meshes = document["meshes"].as_array_mut().unwrap();
    for primitive in meshes
        .iter_mut()
        .flat_map(|m| m["primitives"].as_array_mut().unwrap())
    {
        primitive["material"] = json!(0);
    }
    let folder = Folder::new();
    folder.write("scene.gltf", document.to_string());
    folder
}

#[test]
fn info_names_the_nodes_that_hits_evaluate_and_counts_the_folded() {
    let folder = patterned(json!({"node": 1, "output": "Color"}));
    let page = folder.works(&["info", "scene.gltf"]);
    let line = "\"Wood\" at hits: Noise Texture, Texture Coordinate; folded: 1";
    assert!(page.contains(line), "{page}");
    let document: Value =
        serde_json::from_str(&folder.works(&["info", "scene.gltf", "--json"])).unwrap();
    assert_eq!(
        document["nodes"],
        json!([{"material": "Wood", "evaluated": {"Noise Texture": 1, "Texture Coordinate": 1}, "folded": 1}])
    );
}

#[test]
fn a_picture_without_patterns_is_the_one_of_grey() {
    let render = |folder: &Folder, effects: &str| {
        folder.works(&[
            "render",
            "scene.gltf",
            "-o",
            "a.png",
            "--width",
            "24",
            "--samples",
            "8",
            "--effects",
            effects,
        ]);
        image::open(folder.path("a.png")).unwrap().into_rgb8()
    };
    let noise = patterned(json!({"node": 1, "output": "Color"}));
    let grey = patterned(json!([0.5, 0.5, 0.5, 1.0]));
    let without = "point-lights,diffuse-roughness";
    assert_ne!(render(&noise, "auto"), render(&grey, "auto"));
    assert!(render(&noise, without) == render(&grey, "auto"));
    let cost = noise.works(&[
        "cost",
        "scene.gltf",
        "--effects",
        "--width",
        "24",
        "--samples",
        "4",
    ]);
    assert!(cost.contains("noise-texture"), "{cost}");
}
