//! Bad input: one clear sentence or a diagnostic, never a panic, never a hang, never much memory.

use std::path::Path;

use proptest::prelude::*;
use serde_json::{Value, json};
use sundog::import::{self, ImportOptions};
use sundog::scene::{MaterialId, Phase, Scene, Verdict};

use super::kit::*;

/// A file that uses most of what the importer knows, to be damaged.
fn rich() -> Builder {
    let mut file = Builder::square();
    let texture =
        file.png_texture(image::RgbaImage::from_pixel(3, 2, image::Rgba([1, 2, 3, 4])).into());
    let bytes: Vec<u8> = [0.0f32, 0.0, 1.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let (at, with) = (file.view(&[2]), file.view(&bytes));
    let offsets = file.push(
        "accessors",
        json!({ "componentType": FLOAT, "type": "VEC3", "count": 4, "sparse": {
            "count": 1,
            "indices": { "bufferView": at, "componentType": UNSIGNED_BYTE },
            "values": { "bufferView": with }
        } }),
    );
    let joints = file.accessor("VEC4", UNSIGNED_BYTE, false, 4, &[0; 16]);
    let weights = file.accessor("VEC4", UNSIGNED_BYTE, true, 4, &[255, 0, 0, 0].repeat(4));
    let translations = file.floats("VEC3", &[0.0; 9]);
    let colors = file.accessor("VEC3", UNSIGNED_SHORT, true, 4, &[7; 24]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([{ "POSITION": offsets, "NORMAL": offsets }]);
    primitive["attributes"]["JOINTS_0"] = json!(joints);
    primitive["attributes"]["WEIGHTS_0"] = json!(weights);
    primitive["attributes"]["COLOR_0"] = json!(colors);
    file.json["meshes"][0]["weights"] = json!([0.5]);
    file.json["skins"] = json!([{ "joints": [2] }]);
    file.json["samplers"] = json!([{ "wrapS": 33071 }]);
    file.json["textures"][texture]["sampler"] = json!(0);
    file.json["materials"][0] = json!({
        "name": "all",
        "alphaMode": "MASK",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
            "baseColorTexture": { "index": texture, "extensions": { "KHR_texture_transform": { "offset": [0.1, 0.2], "rotation": 0.3 } } }
        },
        "normalTexture": { "index": texture, "scale": 0.5 },
        "emissiveFactor": [0.5, 0.25, 1.0],
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 8.0 },
            "KHR_materials_ior": { "ior": 1.33 },
            "KHR_materials_specular": { "specularFactor": 0.7 },
            "KHR_materials_transmission": { "transmissionFactor": 0.9, "transmissionTexture": { "index": texture } },
            "KHR_materials_volume": { "thicknessFactor": 0.1, "attenuationDistance": 1.0 },
            "KHR_materials_sheen": { "sheenColorFactor": [1.0, 1.0, 1.0] }
        }
    });
    file.json["cameras"] = json!([
        { "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } },
        { "type": "orthographic", "orthographic": { "xmag": 3.0, "ymag": 2.0, "znear": 0.0, "zfar": 9.0 } }
    ]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "intensity": 5.0, "range": 3.0, "spot": { "outerConeAngle": 0.5 }, "extensions": { "SUNDOG_light": { "radius": 0.1 } } }
    ] } });
    file.json["nodes"] = json!([
        { "mesh": 0, "children": [1, 3] },
        { "mesh": 0, "matrix": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.2, 0.5, 1.0],
          "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translations } } } },
        { "mesh": 0, "skin": 0, "rotation": [0.0, 0.0, 0.0, 1.0], "scale": [1.0, 2.0, 3.0] },
        { "camera": 0, "children": [4] },
        { "camera": 1, "extensions": { "KHR_lights_punctual": { "light": 0 } } }
    ]);
    file.json["scenes"] = json!([{ "nodes": [0, 2] }]);
    file.json["animations"] = json!([{}]);
    file
}

/// What every scene from the importer promises, however it came to be.
fn check(scene: &Scene) {
    let finite3 = |v: &[f32; 3]| v.iter().all(|c| c.is_finite());
    for mesh in &scene.meshes {
        let count = mesh.positions.len();
        assert!(mesh.positions.iter().all(finite3));
        assert!(
            mesh.triangles
                .iter()
                .flatten()
                .all(|&i| (i as usize) < count)
        );
        assert!(
            mesh.material
                .is_none_or(|m| (m.0 as usize) < scene.materials.len())
        );
        if mesh.triangles.is_empty() {
            continue;
        }
        for normal in mesh.normals.iter().flatten() {
            assert!(
                (normal.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-3,
                "{normal:?}"
            );
        }
        for [x, y, z, w] in mesh.tangents.iter().flatten() {
            let square = x * x + y * y + z * z;
            // Those that are made of damaged coordinates may be none.
            assert!((square - 1.0).abs() < 1e-3 || square == 0.0 && mesh.tangent_set.is_some());
            assert!(w.abs() == 1.0);
        }
        assert!(mesh.normals.as_ref().is_none_or(|n| n.len() == count));
        assert!(mesh.tangents.as_ref().is_none_or(|t| t.len() == count));
        assert!(
            mesh.uvs
                .iter()
                .all(|set| set.len() == count && set.iter().flatten().all(|c| c.is_finite()))
        );
        assert!(
            mesh.colors
                .as_ref()
                .is_none_or(|c| c.len() == count && c.iter().flatten().all(|v| *v >= 0.0))
        );
    }
    for instance in &scene.instances {
        let m = instance.world_from_object;
        assert!(m.is_finite() && m.matrix3.determinant() != 0.0);
        assert!(!scene.meshes[instance.mesh.0 as usize].triangles.is_empty());
    }
    for material in &scene.materials {
        let m = standard(material);
        let unit = [m.alpha, m.metallic, m.roughness, m.transmission];
        assert!(
            unit.iter()
                .chain(&m.base_color)
                .all(|v| (0.0..=1.0).contains(v))
        );
        assert!(m.emission.iter().all(|v| v.is_finite() && *v >= 0.0));
        assert!(m.specular.is_finite() && m.specular >= 0.0);
        assert!(m.ior == 0.0 || m.ior >= 1.0);
        for texture in material.graph.textures() {
            assert!((texture.image.0 as usize) < scene.images.len());
        }
    }
    for light in &scene.lights {
        assert!(light.world_from_light.is_finite() && light.color.iter().all(|c| c.is_finite()));
    }
    for image in &scene.images {
        assert!(image.width > 0 && image.height > 0);
    }
}

#[test]
fn the_rich_file_is_whole() {
    let imported = rich().load();
    check(&imported.scene);
    assert_eq!(imported.scene.instances.len(), 5);
    assert_eq!(
        (imported.scene.lights.len(), imported.scene.cameras.len()),
        (1, 2)
    );
    let mut told = codes(&imported);
    told.sort_unstable();
    assert_eq!(
        told,
        [
            "animation",
            "charlie-sheen",
            "light-range",
            "light-units",
            "skin",
            "spot-edge",
        ]
    );
    assert_eq!(
        found(&imported, "charlie-sheen")[0].feature,
        "KHR_materials_sheen"
    );
}

// --- files ---

#[test]
fn missing_files_are_named() {
    let load = |path: &Path| {
        import::load(path, &ImportOptions::default())
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        load(Path::new("/nowhere/at all.glb")),
        "cannot read /nowhere/at all.glb: there is no such file"
    );
    let (folder, path) = place("scene.gltf");
    assert!(load(folder.path()).contains("it is a folder"));
    let mut file = Builder::triangle();
    file.json["buffers"] = json!([{ "byteLength": 36, "uri": "gone.bin" }]);
    std::fs::write(&path, file.json.to_string()).unwrap();
    let error = load(&path);
    assert!(
        error.contains("buffer 0")
            && error.contains("gone.bin")
            && error.contains("there is no such file"),
        "{error}"
    );
    file.json["buffers"] = json!([{ "byteLength": 36, "uri": "https://example.org/a.bin" }]);
    std::fs::write(&path, file.json.to_string()).unwrap();
    assert!(load(&path).contains("https://example.org/a.bin"));
    let mut file = Builder::square();
    file.json["images"] = json!([{ "name": "oak", "uri": "oak.png" }]);
    file.json["textures"] = json!([{ "source": 0 }]);
    file.json["materials"][0]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": 0 }, "baseColorFactor": [0.5, 0.25, 0.125, 1.0] });
    file.json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    file.json["materials"][0]["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    // A texture is not the scene: the factor alone is used, but for light that it was to give.
    let mut remote = file.clone();
    remote.json["images"][0]["uri"] = json!("https://example.org/oak.png");
    let told = found(&remote.load(), "image-lost")[0].to_string();
    assert!(told.contains("https://example.org/oak.png"), "{told}");
    let imported = file.load();
    let lost = &found(&imported, "image-lost")[0];
    assert_eq!(lost.verdict, Verdict::Lost);
    assert!(
        lost.feature.contains("oak.png") && lost.feature.contains("there is no such file"),
        "{lost}"
    );
    assert_eq!(lost.objects, ["image 0 (\"oak\")"]);
    let material = standard(&imported.scene.materials[0]);
    assert_eq!(material.base_color, [0.5, 0.25, 0.125]);
    assert!(material.base_color_texture.is_none() && material.emission_texture.is_none());
    assert_eq!(material.emission, [0.0; 3]);
}

#[test]
fn what_lacks_something_is_named_in_the_json() {
    let mut file = Builder::triangle();
    file.json["meshes"][0]["primitives"] = json!([{ "mode": 4 }]);
    let error = file.error();
    assert!(
        error.contains("meshes[0].primitives[0]")
            && error.contains("\"tri\"")
            && error.contains("attributes"),
        "{error}"
    );
}

#[test]
fn degenerate_coordinates_give_tangents_without_a_complaint() {
    let mut file = Builder::square();
    let texture =
        file.png_texture(image::RgbImage::from_pixel(1, 1, image::Rgb([128, 128, 255])).into());
    file.json["materials"][0]["normalTexture"] = json!({ "index": texture });
    let uvs = file.floats("VEC2", &[0.5; 8]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    assert!(file.load().diagnostics.is_empty());
}

#[test]
fn what_is_not_gltf_is_refused() {
    let error = |bytes: &[u8]| {
        load_bytes(bytes, &ImportOptions::default())
            .unwrap_err()
            .to_string()
    };
    assert!(error(b"").contains("empty"));
    assert!(error(b"\x89PNG\r\n\x1a\n").contains("neither GLB nor JSON"));
    assert!(error(b"{\"asset\":{\"version\":\"1.0\"}}").contains("version is 1.0"));
    assert!(error(b"{}").contains("asset.version"));
    let newer = b"{\"asset\":{\"version\":\"2.0\",\"minVersion\":\"2.1\"}}";
    assert!(error(newer).contains("asks for glTF 2.1"));
    assert!(
        error("[".repeat(1 << 16).as_bytes()).contains("neither GLB nor JSON"),
        "deep nesting"
    );
    assert!(error(b"glTF\x01\0\0\0\x14\0\0\0").contains("version is 1"));
    let mut file = Builder::triangle();
    file.json["nodes"][0]["mesh"] = json!(-1);
    assert!(file.error().contains("nodes[0]"), "the place is named");
}

#[test]
fn a_file_cut_off_anywhere_is_an_error() {
    let whole = rich().glb();
    for length in (0..whole.len()).step_by(7) {
        let result = load_bytes(&whole[..length], &ImportOptions::default());
        assert!(result.is_err(), "cut to {length} of {}", whole.len());
    }
}

#[test]
fn buffers_shorter_than_said() {
    let mut file = Builder::triangle();
    let (folder, path) = place("scene.gltf");
    std::fs::write(folder.path().join("a.bin"), &file.binary[..20]).unwrap();
    file.json["buffers"] = json!([{ "byteLength": 36, "uri": "a.bin" }]);
    std::fs::write(&path, file.json.to_string()).unwrap();
    let error = import::load(&path, &ImportOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("buffer 0: it should have 36 bytes but has 20"),
        "{error}"
    );
}

// --- structure ---

#[test]
fn cycles_and_shared_children_are_errors() {
    let mut file = Builder::triangle();
    file.json["nodes"] = json!([{ "name": "snake", "children": [0], "mesh": 0 }]);
    assert!(
        file.error()
            .contains("node \"snake\": it has two parents or is its own ancestor")
    );
    file.json["nodes"] = json!([{ "children": [1, 1] }, { "mesh": 0 }]);
    assert!(file.error().contains("two parents"));
    // A ladder of shared children would be walked 2⁶⁴ times.
    let rungs: Vec<Value> = (0..64)
        .map(|i| json!({ "children": [i + 1, i + 1] }))
        .chain([json!({ "mesh": 0 })])
        .collect();
    file.json["nodes"] = json!(rungs);
    assert!(file.error().contains("two parents"));
}

#[test]
fn references_to_nothing_are_errors_that_name_the_user() {
    let cases: [(&str, Value, &str); 9] = [
        ("/scenes/0/nodes", json!([7]), "node 7"),
        ("/scene", json!(3), "scene 3"),
        ("/nodes/0/mesh", json!(9), "does not exist"),
        ("/nodes/0/camera", json!(9), "camera 9"),
        (
            "/nodes/0/extensions",
            json!({ "KHR_lights_punctual": { "light": 2 } }),
            "light 2",
        ),
        ("/meshes/0/primitives/0/material", json!(5), "material 5"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(50),
            "accessor 50",
        ),
        ("/meshes/0/primitives/0/indices", json!(51), "accessor 51"),
        (
            "/materials/0/normalTexture",
            json!({ "index": 4 }),
            "texture 4",
        ),
    ];
    for (place, value, expected) in cases {
        let mut file = Builder::square();
        let (parent, key) = place.rsplit_once('/').unwrap();
        file.json.pointer_mut(parent).unwrap()[key] = value;
        let error = file.error();
        assert!(error.contains(expected), "{place}: {error}");
    }
}

#[test]
fn lying_accessors_are_errors() {
    let cases: [(&str, Value, &str); 8] = [
        ("count", json!(u64::MAX), "reach beyond"),
        ("count", json!(4), "reach beyond"),
        ("byteOffset", json!(8), "reach beyond"),
        ("byteOffset", json!(u64::MAX), "begins beyond"),
        ("bufferView", json!(77), "no buffer view 77"),
        ("componentType", json!(5124), "unknown type"),
        ("type", json!("VEC2"), "2 components where 3"),
        ("type", json!("VEC5"), "unknown type"),
    ];
    for (key, value, expected) in cases {
        let mut file = Builder::triangle();
        file.json["accessors"][0][key] = value.clone();
        let error = file.error();
        assert!(
            error.contains(expected) && error.contains("mesh \"tri\""),
            "{key} = {value}: {error}"
        );
    }
    for (key, value, expected) in [
        ("byteOffset", json!(u64::MAX), "beyond the end"),
        ("byteLength", json!(u64::MAX), "beyond the end"),
        ("byteStride", json!(4), "stride"),
        ("byteStride", json!(u64::MAX), "reach beyond"),
        ("buffer", json!(3), "no buffer 3"),
    ] {
        let mut file = Builder::triangle();
        file.json["bufferViews"][0][key] = value.clone();
        let error = file.error();
        assert!(error.contains(expected), "{key} = {value}: {error}");
    }
}

#[test]
fn huge_counts_in_a_small_file_are_refused_before_memory_is_asked_for() {
    let mut file = Builder::triangle();
    // Zero-filled accessors take no bytes in the file.
    file.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    file.json["accessors"][0]["count"] = json!(u32::MAX);
    assert!(file.error().contains("out of proportion"));
    file.json["accessors"][0]["count"] = json!(u64::MAX);
    assert!(file.error().contains("out of proportion"));
    // Many small ones add up.
    file.json["accessors"][0]["count"] = json!(100_000);
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    file.json["meshes"][0]["primitives"] = json!(vec![primitive; 1000]);
    assert!(file.error().contains("out of proportion"));
}

// --- values ---

#[test]
fn bad_numbers_in_geometry_are_dropped_or_repaired_and_counted() {
    let mut file = Builder::empty();
    let nan = f32::NAN;
    let positions = file.floats(
        "VEC3",
        &[
            0.0,
            0.0,
            0.0,
            1.0,
            0.0,
            0.0,
            0.0,
            1.0,
            0.0,
            nan,
            0.0,
            0.0,
            2.0,
            0.0,
            0.0,
            f32::INFINITY,
            0.0,
            0.0,
        ],
    );
    let normals = file.floats(
        "VEC3",
        &[
            0.0, 0.0, 0.0, 0.0, 0.0, 5.0, nan, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0,
            1.0,
        ],
    );
    let uvs = file.floats(
        "VEC2",
        &[nan, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    let colors = file.floats("VEC3", &[-1.0; 18]);
    // Whole; not finite; without area twice; beyond the vertices.
    let indices = file.accessor(
        "SCALAR",
        UNSIGNED_BYTE,
        false,
        15,
        &[0, 1, 2, 0, 1, 3, 0, 1, 4, 1, 1, 2, 0, 1, 200],
    );
    file.json["meshes"] = json!([{ "name": "bad", "primitives": [{
        "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs, "COLOR_0": colors }, "indices": indices
    }] }]);
    file.json["nodes"] = json!([{ "mesh": 0 }]);
    file.json["scenes"] = json!([{ "nodes": [0] }]);
    let imported = file.load();
    check(&imported.scene);
    let mesh = &imported.scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(
        mesh.normals.as_ref().unwrap()[..3],
        [[0.0, 0.0, 1.0]; 3],
        "recomputed, and made unit"
    );
    assert_eq!(
        codes(&imported),
        [
            "bad-indices",
            "bad-normals",
            "bad-uvs",
            "bad-colours",
            "non-finite-positions",
            "degenerate-triangles"
        ]
    );
    assert_eq!(
        found(&imported, "degenerate-triangles")[0].to_string(),
        "2 triangles without area (bad): left out"
    );
}

/// In files by Blender a normal of zero counts as such, between the others; what is not finite is made of the faces everywhere.
#[test]
fn zero_normals_are_cycles_own_in_files_by_blender() {
    for (generator, middle, told) in [
        ("Khronos glTF Blender I/O v4.5.48", f32::NAN, true),
        ("Khronos glTF Blender I/O v4.5.48", 0.0, false),
        ("another", 0.0, true),
    ] {
        let mut file = Builder::triangle();
        let normals = file.floats("VEC3", &[0.0, 1.0, 0.0, middle, 0.0, 0.0, 0.0, 1.0, 0.0]);
        file.json["asset"]["generator"] = json!(generator);
        file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals.into();
        let imported = file.load();
        let normals = imported.scene.meshes[0].normals.as_ref().unwrap();
        let expected = if told { [0.0, 0.0, 1.0] } else { [0.0; 3] };
        assert_eq!(normals[1], expected, "{generator}, {middle}");
        assert_eq!(
            codes(&imported).contains(&"bad-normals"),
            told,
            "{generator}, {middle}"
        );
    }
}

#[test]
fn bad_transforms_cameras_and_lights_are_left_out_by_name() {
    let mut file = Builder::triangle();
    file.json["cameras"] = json!([
        { "type": "perspective", "perspective": { "yfov": -1.0, "znear": 0.1 } },
        { "type": "orthographic", "orthographic": { "xmag": 0.0, "ymag": 1.0, "znear": 0.0, "zfar": 1.0 } },
        { "type": "perspective", "perspective": { "yfov": 1.0, "znear": 5.0, "zfar": 1.0 } }
    ]);
    file.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": -5.0 }] } });
    file.json["nodes"] = json!([
        { "name": "flat", "mesh": 0, "scale": [1.0, 0.0, 1.0] },
        { "name": "sheared to a line", "mesh": 0, "matrix": [1.0, 1.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0] },
        { "name": "huge", "mesh": 0, "scale": [1e16, 1e16, 1e16], "children": [7] },
        { "name": "tiny but whole", "mesh": 0, "scale": [1e-20, 1e-20, 1e-20] },
        { "name": "narrow", "camera": 0 }, { "camera": 1 }, { "camera": 2 },
        { "name": "beyond", "mesh": 0, "scale": [1e300, 1e300, 1e300], "extensions": { "KHR_lights_punctual": { "light": 0 } } }
    ]);
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4, 5, 6]);
    let imported = file.load();
    let names: Vec<&str> = imported
        .scene
        .instances
        .iter()
        .map(|i| i.name.as_str())
        .collect();
    assert_eq!(names, ["huge", "tiny but whole"]);
    assert_eq!(imported.scene.cameras.len(), 1);
    assert_eq!(
        (
            imported.scene.cameras[0].clip_near,
            imported.scene.cameras[0].clip_far
        ),
        (0.0, f64::INFINITY)
    );
    assert!(imported.scene.lights.is_empty());
    assert_eq!(
        found(&imported, "singular-transform")[0].objects,
        ["flat", "sheared to a line"]
    );
    assert_eq!(found(&imported, "bad-transform")[0].objects, ["beyond"]);
    assert_eq!(found(&imported, "bad-camera")[0].count, 2);
    assert_eq!(found(&imported, "bad-light")[0].objects, ["beyond"]);
    assert_eq!(
        found(&imported, "bad-clipping")[0].verdict,
        Verdict::Approximated
    );
}

#[test]
fn material_numbers_are_brought_into_range() {
    let mut file = Builder::square();
    file.json["materials"][0] = json!({
        "name": "wild",
        "pbrMetallicRoughness": { "baseColorFactor": [2.0, -1.0, 0.5, 3.0], "metallicFactor": 7.0, "roughnessFactor": -2.0 },
        "emissiveFactor": [-1.0, 0.0, 0.0],
        "extensions": { "KHR_materials_ior": { "ior": 0.5 } }
    });
    let imported = file.load();
    check(&imported.scene);
    let material = standard(&imported.scene.materials[0]);
    assert_eq!(material.base_color, [1.0, 0.0, 0.5]);
    assert_eq!(material.ior, 1.0);
    assert_eq!(found(&imported, "material-range")[0].objects, ["wild"]);
}

#[test]
fn numbers_of_volumes_are_brought_into_range() {
    let mut file = Builder::square();
    file.json["materials"][0] = json!({
        "name": "wild",
        "extensions": { "SUNDOG_material": { "volume": {
            "absorption": [-1.0, 1e38, 0.5],
            "scatterers": [{ "coefficient": [0.1, 0.2, 0.3], "anisotropy": 7.0 }],
        } } }
    });
    let imported = file.load();
    let medium = imported.scene.materials[0].medium.as_ref().unwrap();
    assert_eq!(medium.absorption, [0.0, 1e30, 0.5]);
    assert_eq!(medium.scatterers[0].phase, Phase::HenyeyGreenstein(0.999));
    assert_eq!(found(&imported, "volume-range")[0].objects, ["wild"]);
    let thick = json!({ "thicknessFactor": 1.0, "attenuationDistance": 0.0, "attenuationColor": [1.0, 0.0, 0.5] });
    file.json["materials"][0]["extensions"] = json!({ "KHR_materials_volume": thick, "KHR_materials_transmission": { "transmissionFactor": 1.0 } });
    let imported = file.load();
    let medium = imported.scene.materials[0].medium.as_ref().unwrap();
    assert_eq!(medium.absorption, [0.0, 1e30, 1e30]);
}

#[test]
fn clean_up_copes_with_scenes_from_anywhere() {
    let mut scene = rich().load().scene;
    scene.instances[0].mesh.0 = 999;
    scene.meshes[0].material = Some(MaterialId(999));
    scene.meshes[1].normals.as_mut().unwrap().pop();
    let mut material = standard(&scene.materials[0]);
    material.base_color_texture.as_mut().unwrap().image.0 = 999;
    let normal = material.normal_texture.as_mut().unwrap();
    normal.texture.transform.offset[0] = f32::NAN;
    scene.materials[0] = material.into();
    let mut diagnostics = sundog::scene::Diagnostics::default();
    sundog::scene::validate::clean(&mut scene, &mut diagnostics);
    check(&scene);
    let codes: Vec<&str> = diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(
        codes,
        [
            "bad-texture",
            "bad-material",
            "bad-attributes",
            "bad-instance"
        ]
    );
}

// --- images inside scenes ---

#[test]
fn broken_and_absurd_images_are_lost_and_named() {
    let with_image = |bytes: &[u8]| {
        let mut file = Builder::square();
        let view = file.view(bytes);
        file.json["images"] =
            json!([{ "name": "oak", "bufferView": view, "mimeType": "image/png" }]);
        file.json["textures"] = json!([{ "source": 0 }]);
        file.json["materials"][0]["pbrMetallicRoughness"] =
            json!({ "baseColorTexture": { "index": 0 } });
        let imported = file.load();
        assert!(imported.scene.images.is_empty());
        assert!(
            standard(&imported.scene.materials[0])
                .base_color_texture
                .is_none()
        );
        found(&imported, "image-lost")[0].to_string()
    };
    let whole = png(image::RgbImage::from_pixel(64, 64, image::Rgb([5, 6, 7])).into());
    assert!(with_image(&whole[..whole.len() / 2]).contains("image \"oak\""));
    assert!(with_image(b"not an image").contains("image of an unknown kind"));
    // 60000 × 60000 pixels in a header of a few bytes.
    let mut header = whole[..33].to_vec();
    header[16..20].copy_from_slice(&60_000u32.to_be_bytes());
    header[20..24].copy_from_slice(&60_000u32.to_be_bytes());
    let crc = crc32(&header[12..29]);
    header[29..33].copy_from_slice(&crc.to_be_bytes());
    header.extend(&whole[33..]);
    assert!(
        with_image(&header).contains("60000 × 60000"),
        "{}",
        with_image(&header)
    );
}

/// The checksum of PNG chunks (PNG specification, annex D).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| {
            if c & 1 == 1 {
                0xEDB8_8320 ^ (c >> 1)
            } else {
                c >> 1
            }
        })
    })
}

/// Small files that ask for much: each as name and bytes.
fn greedy_files() -> Vec<(&'static str, Vec<u8>)> {
    let mut files = Vec::new();
    let mut zeros = Builder::triangle();
    zeros.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    zeros.json["accessors"][0]["count"] = json!(u32::MAX);
    files.push(("zeros.glb", zeros.glb()));
    zeros.json["accessors"][0]["count"] = json!(200_000);
    let primitive = zeros.json["meshes"][0]["primitives"][0].clone();
    zeros.json["meshes"][0]["primitives"] = json!(vec![primitive; 20_000]);
    files.push(("many-zeros.glb", zeros.glb()));
    let mut instances = Builder::triangle();
    let copies = instances.push(
        "accessors",
        json!({ "componentType": FLOAT, "type": "VEC3", "count": u32::MAX }),
    );
    instances.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": copies } } });
    files.push(("instances.glb", instances.glb()));
    let mut png = png(image::RgbImage::from_pixel(64, 64, image::Rgb([5, 6, 7])).into());
    png[16..20].copy_from_slice(&16_000u32.to_be_bytes());
    png[20..24].copy_from_slice(&16_000u32.to_be_bytes());
    let crc = crc32(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    files.push(("wide.png", png));
    files.push((
        "wide.hdr",
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16000 +X 16000\n".to_vec(),
    ));
    let mut jpeg = std::io::Cursor::new(Vec::new());
    let pixels = image::DynamicImage::from(image::RgbImage::new(16, 16));
    pixels
        .write_to(&mut jpeg, image::ImageFormat::Jpeg)
        .unwrap();
    let mut jpeg = jpeg.into_inner();
    // The frame header: marker, length, precision, height, width.
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0x3e, 0x80, 0x3e, 0x80]);
    files.push(("wide.jpg", jpeg));
    let mut exr = super::images::small_exr();
    // Both windows end at x = y = 15999.
    let mut at = 0;
    while let Some(found) = exr[at..].windows(6).position(|w| w == b"box2i\0") {
        at += found + 6;
        for corner in [12, 16] {
            exr[at + corner..at + corner + 4].copy_from_slice(&15_999i32.to_le_bytes());
        }
    }
    files.push(("wide.exr", exr));
    files
}

/// The evil files are read by this test run once more, by itself, with three GiB of address space: each
/// of them asks for more.
#[cfg(unix)]
#[test]
fn greedy_files_are_refused_within_little_memory() {
    const FOLDER: &str = "SUNDOG_GREEDY_FOLDER";
    if let Some(folder) = std::env::var_os(FOLDER) {
        for (name, _) in greedy_files() {
            let path = Path::new(&folder).join(name);
            let error = if name.ends_with(".glb") {
                import::load(&path, &ImportOptions::default()).unwrap_err()
            } else {
                import::load_environment(&mut Scene::default(), &path, 1.0, 0.0).unwrap_err()
            };
            println!("{error}");
        }
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let files = greedy_files();
    for (name, bytes) in &files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let output = std::process::Command::new("sh")
        .args(["-c", "ulimit -v 3145728 && exec \"$0\" \"$@\""])
        .arg(std::env::current_exe().unwrap())
        .args([
            "formats::broken::greedy_files_are_refused_within_little_memory",
            "--exact",
            "--nocapture",
        ])
        .env(FOLDER, folder.path())
        .output()
        .unwrap();
    let text = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(output.status.success(), "{text}");
    for (name, _) in &files {
        assert!(
            text.lines().any(|line| line.contains(name)),
            "no error about {name} in:\n{text}"
        );
    }
}

#[test]
fn tangents_of_a_heap_of_degenerate_triangles_come_in_time() {
    // 30 000 triangles between four corners, most of them without area or on top of each other.
    let mut file = Builder::square();
    let corners: Vec<u8> = (0..90_000u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 29) as u8 % 4)
        .collect();
    let indices = file.accessor("SCALAR", UNSIGNED_BYTE, false, corners.len(), &corners);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let texture =
        file.png_texture(image::RgbImage::from_pixel(1, 1, image::Rgb([128, 128, 255])).into());
    file.json["materials"][0]["normalTexture"] = json!({ "index": texture });
    let imported = file.load();
    check(&imported.scene);
    assert!(imported.scene.meshes[0].tangents.is_some());
}

// --- random damage ---

/// Replaces the `pick`-th value of a JSON tree.
fn mutate(value: &mut Value, pick: &mut usize, with: &Value) -> bool {
    if *pick == 0 {
        *value = with.clone();
        return true;
    }
    *pick -= 1;
    match value {
        Value::Array(items) => items.iter_mut().any(|item| mutate(item, pick, with)),
        Value::Object(fields) => fields
            .iter_mut()
            .any(|(_, field)| mutate(field, pick, with)),
        _ => false,
    }
}

fn strange_value() -> impl Strategy<Value = Value> {
    prop_oneof![
        Just(Value::Null),
        Just(json!(true)),
        Just(json!([])),
        Just(json!({})),
        Just(json!("")),
        Just(json!("../../etc/passwd")),
        Just(json!("data:;base64,////")),
        Just(json!(1e308)),
        Just(json!(-1e-320)),
        Just(json!([1e308, 1e308, 1e308])),
        Just(json!([0, 0, 0, 0])),
        any::<u64>().prop_map(|n| json!(n)),
        any::<i64>().prop_map(|n| json!(n)),
        (0u64..40).prop_map(|n| json!(n)),
        (5120u64..5127).prop_map(|n| json!(n)),
        any::<f32>().prop_map(|n| json!(n)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(20), ..ProptestConfig::default() })]

    #[test]
    fn damaged_bytes_never_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12)) {
        let mut bytes = rich().glb();
        for (place, byte) in changes {
            let at = place.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(imported) = load_bytes(&bytes, &ImportOptions::default()) {
            check(&imported.scene);
        }
    }

    #[test]
    fn damaged_json_never_panics(changes in prop::collection::vec((any::<prop::sample::Index>(), strange_value()), 1..4)) {
        let mut file = rich();
        for (place, with) in changes {
            let mut pick = place.index(500);
            mutate(&mut file.json, &mut pick, &with);
        }
        if file.json.is_object()
            && let Ok(imported) = load_bytes(&whole_glb(&file), &ImportOptions::default())
        {
            check(&imported.scene);
        }
    }

    #[test]
    fn damaged_numbers_in_buffers_never_panic(values in prop::collection::vec((any::<prop::sample::Index>(), any::<u32>()), 1..8)) {
        let mut file = rich();
        let words = file.binary.len() / 4;
        for (place, bits) in values {
            let at = place.index(words) * 4;
            file.binary[at..at + 4].copy_from_slice(&bits.to_le_bytes());
        }
        if let Ok(imported) = file.load_with(&ImportOptions::default()) {
            check(&imported.scene);
        }
    }
}

/// As [`Builder::glb`], with the buffer's entry only if the damage left room for it.
fn whole_glb(file: &Builder) -> Vec<u8> {
    let mut json = file.json.clone();
    json["buffers"] = json!([{ "byteLength": file.binary.len() }]);
    glb(&serde_json::to_vec(&json).unwrap(), &file.binary)
}
