use base64::Engine;

use crate::import::{ImportOptions, load};

/// A triangle whose vertices hang on the joint that is node 2, which stands below node 1.
fn skinned(nodes_of_scene: &str, extension: &str) -> crate::import::Imported {
    let mut bytes = Vec::new();
    for corner in [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        bytes.extend(corner.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes.extend([0u8; 12]);
    for weights in [[1f32, 0.0, 0.0, 0.0]; 3] {
        bytes.extend(weights.iter().flat_map(|v| v.to_le_bytes()));
    }
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["FB_ngon_encoding"],
        "scene": 0, "scenes": [{{"nodes": [{nodes_of_scene}]}}],
        "nodes": [{{"name": "body", "mesh": 0, "skin": 0}},
                  {{"translation": [3, 0, 0], "children": [2]}}, {{"translation": [0, 5, 0]}}],
        "skins": [{{"joints": [2]}}],
        "meshes": [{{"primitives": [{{{extension} "attributes": {{"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}}}]}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}},
            {{"bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC4"}},
            {{"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC4"}}],
        "bufferViews": [
            {{"buffer": 0, "byteOffset": 0, "byteLength": 36}},
            {{"buffer": 0, "byteOffset": 36, "byteLength": 12}},
            {{"buffer": 0, "byteOffset": 48, "byteLength": 48}}],
        "buffers": [{{"byteLength": 96, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("skin.gltf");
    std::fs::write(&path, text).unwrap();
    load(&path, &ImportOptions::default()).unwrap()
}

fn codes(imported: &crate::import::Imported) -> Vec<&'static str> {
    imported.diagnostics.iter().map(|d| d.code).collect()
}

#[test]
fn joints_that_are_not_in_the_scene_stand_where_the_file_has_them() {
    let whole = skinned("0, 1", "");
    let without = skinned("0", "");
    let place = |imported: &crate::import::Imported| {
        let instance = &imported.scene.instances[0];
        let mesh = &imported.scene.meshes[instance.mesh.0 as usize];
        let first = glam::DVec3::from(mesh.positions[0].map(f64::from));
        instance.world_from_object.transform_point3(first)
    };
    assert_eq!(place(&whole), glam::DVec3::new(3.0, 5.0, 0.0));
    assert_eq!(place(&without), place(&whole));
    assert!(!codes(&whole).contains(&"skin-joints"));
    assert!(codes(&without).contains(&"skin-joints"));
}

#[test]
fn how_triangles_were_polygons_changes_no_picture() {
    let imported = skinned("0, 1", r#""extensions": {"FB_ngon_encoding": {}},"#);
    assert!(codes(&imported).contains(&"metadata"));
    assert!(!codes(&imported).contains(&"unknown-extension"));
}
