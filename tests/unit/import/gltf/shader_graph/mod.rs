use crate::import::{self, ImportOptions};
use crate::nodes::VoronoiHash;
use crate::scene::graph::function::ProceduralTexture;
use crate::scene::graph::{Function, Input, NodeKind, ShaderRules};
use crate::scene::{Diagnostics, Scene};
use serde_json::{Value, json};

/// A triangle with a node tree.
fn load(graph: Value) -> (Scene, Diagnostics) {
    load_as(graph, &ImportOptions::default())
}

fn load_as(graph: Value, options: &ImportOptions) -> (Scene, Diagnostics) {
    let positions: Vec<u8> = [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.bin"), positions).unwrap();
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["SUNDOG_shader_graph"],
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"name": "m", "extensions": {"SUNDOG_shader_graph": graph}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "p.bin"}]
    });
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    let loaded = import::load(&path, options).unwrap();
    (loaded.scene, loaded.diagnostics)
}

fn kinds(scene: &Scene) -> Vec<&NodeKind> {
    scene.materials[0]
        .graph
        .nodes
        .iter()
        .map(|n| &n.kind)
        .collect()
}

#[test]
fn trees_become_graphs() {
    let (scene, diagnostics) = load(json!({
        "blender": [5, 2, 3],
        "nodes": [
            {"type": "ShaderNodeTexCoord"},
            {"type": "ShaderNodeMapping", "properties": {"vector_type": "POINT"},
                "inputs": {"Vector": {"node": 0, "output": "Generated"}, "Scale": [2, 2, 2]}},
            {"type": "ShaderNodeBsdfDiffuse",
                "inputs": {"Color": {"node": 1, "output": "Vector"}, "Roughness": 0.5}},
            {"type": "ShaderNodeBsdfTransparent", "inputs": {"Color": [1, 1, 1, 1]}},
            {"type": "ShaderNodeMixShader", "inputs": {"Fac": 0.25,
                "Shader": {"node": 2, "output": "BSDF"}, "Shader_001": {"node": 3, "output": "BSDF"}}}
        ],
        "surface": {"node": 4, "output": "Shader"}
    }));
    assert!(diagnostics.iter().all(|d| d.code != "shader-graph"));
    let kinds = kinds(&scene);
    assert!(matches!(kinds[0], NodeKind::Function(Function::Place(_))));
    assert!(matches!(kinds[1], NodeKind::Function(Function::Mapping(_))));
    let rules = ShaderRules::Before53;
    assert!(kinds.contains(&&NodeKind::DiffuseBsdf { rules }));
    assert_eq!(kinds.last(), Some(&&NodeKind::MixShader));
}

/// The Voronoi Texture's hash in a tree that this version made, and that is loaded as another.
fn hash(blender: Value, cycles: Option<&str>) -> VoronoiHash {
    let options = ImportOptions {
        cycles: cycles.map(|version| version.parse().unwrap()),
        ..Default::default()
    };
    let graph = json!({
        "blender": blender,
        "nodes": [
            {"type": "ShaderNodeTexVoronoi", "properties": {"voronoi_dimensions": "3D",
                "feature": "F1", "distance": "EUCLIDEAN", "normalize": false}},
            {"type": "ShaderNodeEmission", "inputs": {"Color": {"node": 0, "output": "Color"}}}
        ],
        "surface": {"node": 1, "output": "Emission"}
    });
    let (scene, _) = load_as(graph, &options);
    let found = kinds(&scene).into_iter().find_map(|kind| match kind {
        NodeKind::Function(Function::Texture(ProceduralTexture::Voronoi { settings, .. })) => {
            Some(settings.hash)
        }
        _ => None,
    });
    found.unwrap()
}

#[test]
fn the_version_decides_where_versions_differ() {
    assert_eq!(hash(json!([4, 5, 15]), None), VoronoiHash::Lookup3);
    assert_eq!(hash(json!([5, 0, 1]), None), VoronoiHash::Pcg);
    assert_eq!(hash(json!([5, 2, 3]), Some("4.5")), VoronoiHash::Lookup3);
    assert_eq!(hash(json!([4, 5, 15]), Some("5.2.3")), VoronoiHash::Pcg);
}

#[test]
fn what_is_not_evaluated_is_named_and_the_flat_material_counts() {
    for node in [
        json!({"type": "ShaderNodeScript"}),
        json!({"type": "ShaderNodeMath", "properties": {"operation": "GUESS"}}),
        json!({"type": "ShaderNodeValToRGB", "properties": {}}),
        json!({"type": "ShaderNodeValToRGB",
            "properties": {"color_ramp": {"interpolation": "LINEAR", "table": []}}}),
        json!({"type": "ShaderNodeRGBCurve",
            "properties": {"curves": {"min_x": 0, "max_x": 1, "table": [["stop"]]}}}),
        json!({"type": "ShaderNodeNormal"}),
        json!({"type": "ShaderNodeTexImage"}),
    ] {
        let (scene, diagnostics) = load(json!({
            "nodes": [node, {"type": "ShaderNodeEmission",
                "inputs": {"Color": {"node": 0, "output": "Color"}}}],
            "surface": {"node": 1, "output": "Emission"}
        }));
        let told = diagnostics
            .iter()
            .find(|d| d.code == "shader-graph")
            .unwrap();
        assert!(
            told.feature.contains(node["type"].as_str().unwrap()),
            "{told:?}"
        );
        assert!(matches!(
            kinds(&scene).last(),
            Some(NodeKind::PrincipledBsdf { .. })
        ));
    }
}

/// Of trees that grow by doubling, no way through them is walked twice.
#[test]
fn ten_thousand_nodes_are_read_in_bounded_time() {
    let begun = std::time::Instant::now();
    let mut nodes = vec![json!({"type": "ShaderNodeTexCoord"})];
    for at in 0..10_000 {
        let output = if at == 0 { "Generated" } else { "Value" };
        let before = json!({"node": at, "output": output});
        nodes.push(
            json!({"type": "ShaderNodeMath", "properties": {"operation": "SUBTRACT"},
            "inputs": {"Value": before, "Value_001": before}}),
        );
    }
    nodes.push(json!({"type": "ShaderNodeEmission",
        "inputs": {"Strength": {"node": 10_000, "output": "Value"}}}));
    let last = nodes.len() - 1;
    let (scene, diagnostics) = load(json!({
        "blender": [5, 2, 3], "nodes": nodes, "surface": {"node": last, "output": "Emission"}
    }));
    assert!(diagnostics.iter().all(|d| d.code != "shader-graph"));
    assert_eq!(scene.materials[0].graph.nodes.len(), 10_002);
    // A fraction of a second; what is not linear in the nodes takes minutes.
    assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
}

#[test]
fn circles_of_links_are_cut() {
    let math = |from: usize| {
        json!({"type": "ShaderNodeMath", "properties": {"operation": "ADD"},
            "inputs": {"Value": {"node": from, "output": "Value"}, "Value_001": 2}})
    };
    let (scene, _) = load(json!({
        "nodes": [math(2), math(0), math(1), {"type": "ShaderNodeEmission",
            "inputs": {"Strength": {"node": 2, "output": "Value"}}}],
        "surface": {"node": 3, "output": "Emission"}
    }));
    assert!(scene.materials[0].emits());
}

#[test]
fn numbers_beyond_floats_do_not_get_into_the_scene() {
    let (scene, diagnostics) = load(json!({
        "nodes": [
            {"type": "ShaderNodeMath", "properties": {"operation": "ADD"},
                "inputs": {"Value": 1e300, "Value_001": -1e300}},
            {"type": "ShaderNodeBsdfDiffuse",
                "inputs": {"Color": [1e39, -1e39, 0, 1], "Roughness": {"node": 0, "output": "Value"}}}
        ],
        "surface": {"node": 1, "output": "BSDF"}
    }));
    let inputs = scene.materials[0]
        .graph
        .nodes
        .iter()
        .flat_map(|n| &n.inputs);
    for input in inputs {
        if let Input::Value(numbers) = input {
            assert!(numbers.iter().all(|n| n.is_finite()), "{numbers:?}");
        }
    }
    assert!(diagnostics.iter().next().is_some());
}

#[test]
fn links_that_go_nowhere_or_onwards_are_none() {
    let (scene, _) = load(json!({
        "nodes": [
            {"type": "ShaderNodeMath", "properties": {"operation": "ADD"},
                "inputs": {"Value": {"node": 0, "output": "Value"}, "Value_001": {"node": 9, "output": "Value"}}},
            {"type": "ShaderNodeEmission", "inputs": {"Strength": {"node": 0, "output": "Value"}}}
        ],
        "surface": {"node": 1, "output": "Emission"}
    }));
    assert!(scene.materials[0].emits());
}

/// A file with a world and a lamp of node trees.
fn load_shining(world: &Value, lamp: &Value) -> (Scene, Diagnostics) {
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["SUNDOG_scene", "SUNDOG_light", "KHR_lights_punctual"],
        "scene": 0,
        "scenes": [{"nodes": [0], "extensions": {"SUNDOG_scene": {
            "world": {"color": [0.5, 0.5, 0.5], "shader_graph": world, "sampling": {"resolution": 256}}}}}],
        "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "name": "lamp",
            "extensions": {"SUNDOG_light": {"strength": [1, 1, 1], "shader_graph": lamp}}}]}}
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    let loaded = import::load(&path, &Default::default()).unwrap();
    (loaded.scene, loaded.diagnostics)
}

/// An Emission or a Background of an output of a node.
fn shining(node: &Value, output: &str, shader: &str, socket: &str) -> Value {
    json!({
        "nodes": [node, {"type": format!("ShaderNode{shader}"), "inputs": {socket: {"node": 0, "output": output}}}],
        "surface": {"node": 1, "output": shader}
    })
}

#[test]
fn worlds_and_lamps_have_the_trees_of_the_file() {
    let noise = json!({"type": "ShaderNodeTexNoise", "properties": {"noise_dimensions": "3D", "noise_type": "FBM"}});
    let ies = json!({"type": "ShaderNodeTexIES", "properties": {"ies": {
        "around": [0.0, 6.3], "down": [0.0, 1.0], "strengths": [1, 2, 1, 2]}}});
    let (scene, diagnostics) = load_shining(
        &shining(&noise, "Color", "Background", "Color"),
        &shining(&ies, "Fac", "Emission", "Strength"),
    );
    assert_eq!(diagnostics.iter().count(), 0, "{diagnostics:?}");
    let environment = scene.environment.unwrap();
    assert_eq!(environment.radiance, [1.0; 3]);
    let world = environment.graph.unwrap();
    assert_eq!(world.resolution, 256);
    assert!(matches!(
        world.graph.nodes.last().unwrap().kind,
        NodeKind::Emission
    ));
    let lamp = scene.lights[0].graph.as_ref().unwrap();
    let is_ies =
        |n: &crate::scene::graph::Node| matches!(n.kind, NodeKind::Function(Function::Ies(_)));
    let ies = lamp.nodes.iter().find(|n| is_ies(n)).unwrap();
    // Nothing is linked: it is seen along the way from the lamp.
    let way = &lamp.node(ies.inputs[0].link().unwrap()).kind;
    assert!(matches!(
        way,
        NodeKind::Function(Function::VectorTransform { .. })
    ));
}

#[test]
fn worlds_and_lamps_with_nodes_that_are_not_evaluated_are_told() {
    let (scene, diagnostics) = load_shining(
        &shining(
            &json!({"type": "ShaderNodeOfTomorrow"}),
            "Color",
            "Background",
            "Color",
        ),
        &shining(
            &json!({"type": "ShaderNodeTexIES"}),
            "Fac",
            "Emission",
            "Strength",
        ),
    );
    assert_eq!(scene.environment.unwrap().radiance, [0.5; 3]);
    assert!(scene.lights[0].graph.is_none());
    let told: Vec<_> = diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(told, ["shader-graph"; 2]);
}
