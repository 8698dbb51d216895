//! Each feature of glTF that the importer knows, in a file made for it.

use std::f64::consts::PI;

use approx::assert_relative_eq;
use glam::{DAffine3, DQuat, DVec3};
use serde_json::json;
use sundog::import::{self, ImportOptions, LightUnits, Transmission};
use sundog::scene::{
    AlphaMode, Effect, LightKind, Medium, Pixels, Projection, Scene, TextureFilter, UvTransform,
    Verdict, Wrap,
};

use super::kit::*;

fn instance_transform(file: &Builder) -> DAffine3 {
    file.load().scene.instances[0].world_from_object
}

// --- containers ---

#[test]
fn a_triangle_from_a_glb() {
    let imported = Builder::triangle().load();
    let mesh = &imported.scene.meshes[0];
    assert_eq!(
        mesh.positions,
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    );
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert!(
        mesh.normals.is_none(),
        "no normals in the file means flat shading"
    );
    assert!(mesh.material.is_none(), "glTF's default material");
    assert_eq!(imported.scene.instances.len(), 1);
    assert!(imported.diagnostics.is_empty());
}

#[test]
fn files_beside_the_scene_with_percent_encoded_names() {
    let (folder, path) = place("scene.gltf");
    let mut file = Builder::square();
    let pixels = image::RgbImage::from_pixel(2, 2, image::Rgb([10, 20, 30]));
    std::fs::write(folder.path().join("wood & glue.png"), png(pixels.into())).unwrap();
    std::fs::write(folder.path().join("größe 1.bin"), &file.binary).unwrap();
    file.json["buffers"] =
        json!([{ "byteLength": file.binary.len(), "uri": "gr%C3%B6%C3%9Fe%201.bin" }]);
    file.json["images"] = json!([{ "uri": "wood%20%26%20glue.png" }]);
    file.json["textures"] = json!([{ "source": 0 }]);
    file.json["materials"][0]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": 0 } });
    std::fs::write(&path, file.json.to_string()).unwrap();
    let scene = import::load(&path, &ImportOptions::default())
        .unwrap()
        .scene;
    assert_eq!(scene.meshes[0].triangles.len(), 2);
    let image = &scene.images[0];
    assert_eq!((image.width, image.height, image.channels), (2, 2, 3));
    assert!(matches!(&image.pixels, Pixels::U8(v) if v[..] == [10, 20, 30].repeat(4)));
}

#[test]
fn data_uris_hold_buffers_and_images() {
    use base64::Engine as _;
    let (_folder, path) = place("scene.gltf");
    let mut file = Builder::square();
    let encode = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
    let uri = format!(
        "data:application/gltf-buffer;base64,{}",
        encode(&file.binary)
    );
    let pixels = image::GrayImage::from_pixel(3, 1, image::Luma([77]));
    file.json["buffers"] = json!([{ "byteLength": file.binary.len(), "uri": uri }]);
    file.json["images"] =
        json!([{ "uri": format!("data:image/png;base64,{}", encode(&png(pixels.into()))) }]);
    file.json["textures"] = json!([{ "source": 0 }]);
    file.json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    file.json["materials"][0]["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    // A byte-order mark, as some editors write it.
    std::fs::write(&path, format!("\u{feff}{}", file.json)).unwrap();
    let scene = import::load(&path, &ImportOptions::default())
        .unwrap()
        .scene;
    assert_eq!(scene.meshes[0].triangles.len(), 2);
    assert_eq!((scene.images[0].width, scene.images[0].channels), (3, 1));
}

// --- nodes ---

#[test]
fn transforms_keep_f64_precision_along_the_hierarchy() {
    let mut file = Builder::triangle();
    file.json["nodes"] = json!([
        { "translation": [12_345_678.901_234_5, 0.0, 0.0], "children": [1] },
        { "rotation": [0.0, 0.0, 0.382_683_432_365_089_8, 0.923_879_532_511_286_7], "scale": [2.0, 3.0, 4.0], "children": [2] },
        { "mesh": 0, "matrix": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.125, 0.25, 0.5, 1.0] }
    ]);
    let turn = DQuat::from_rotation_z(PI / 4.0);
    let expected =
        DAffine3::from_scale_rotation_translation(
            DVec3::ONE,
            DQuat::IDENTITY,
            DVec3::X * 12_345_678.901_234_5,
        ) * DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 3.0, 4.0), turn, DVec3::ZERO)
            * DAffine3::from_translation(DVec3::new(0.125, 0.25, 0.5));
    let found = instance_transform(&file);
    assert!(
        (found.translation - expected.translation).length() < 1e-8,
        "f32 would be off by a metre"
    );
    assert!(found.abs_diff_eq(expected, 1e-8));
}

#[test]
fn quaternions_are_normalised() {
    let mut file = Builder::triangle();
    file.json["nodes"][0]["rotation"] = json!([0.0, 0.0, 2.0, 2.0]);
    let turned = instance_transform(&file).transform_vector3(DVec3::X);
    assert!(turned.abs_diff_eq(DVec3::Y, 1e-15));
}

#[test]
fn only_the_scene_asked_for_is_loaded() {
    let mut file = Builder::triangle();
    file.json["nodes"] = json!([{ "name": "a", "mesh": 0 }, { "name": "b", "mesh": 0 }, { "name": "lost", "mesh": 0 }]);
    file.json["scenes"] =
        json!([{ "name": "first", "nodes": [0] }, { "name": "second", "nodes": [1, 0] }]);
    let names = |scene: &Scene| {
        scene
            .instances
            .iter()
            .map(|i| i.name.clone())
            .collect::<Vec<_>>()
    };
    file.json["scene"] = json!(1);
    assert_eq!(names(&file.load().scene), ["b", "a"]);
    let pick = |name: &str| ImportOptions {
        scene: Some(name.into()),
        ..ImportOptions::default()
    };
    assert_eq!(names(&file.load_with(&pick("first")).unwrap().scene), ["a"]);
    assert_eq!(
        names(&file.load_with(&pick("1")).unwrap().scene),
        ["b", "a"]
    );
    let error = file.load_with(&pick("third")).unwrap_err().to_string();
    assert!(error.contains("first, second"), "{error}");
    file.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(
        names(&file.load().scene),
        ["a"],
        "without a default the first"
    );
    file.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(names(&file.load().scene), ["a", "b", "lost"]);
}

#[test]
fn shared_meshes_are_shared_and_primitives_come_apart() {
    let mut file = Builder::triangle();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    file.json["materials"] = json!([{}, {}]);
    let mut with_material = primitive.clone();
    with_material["material"] = json!(1);
    file.json["meshes"][0]["primitives"] = json!([primitive, with_material]);
    file.json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "scale": [-1.0, 1.0, 1.0] }]);
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    let scene = file.load().scene;
    assert_eq!((scene.meshes.len(), scene.instances.len()), (2, 4));
    let meshes: Vec<u32> = scene.instances.iter().map(|i| i.mesh.0).collect();
    assert_eq!(meshes, [0, 1, 0, 1]);
    assert!(
        scene.instances[2].world_from_object.matrix3.determinant() < 0.0,
        "mirrored objects stay"
    );
    assert_eq!(scene.materials.len(), 1, "material 0 is not used");
    assert_eq!(scene.meshes[1].material.unwrap().0, 0);
}

#[test]
fn gpu_instancing_places_copies() {
    let mut file = Builder::triangle();
    let translations = file.floats("VEC3", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    // Quaternions as normalised shorts: 90° about z, then none.
    let half = (0.5f64.sqrt() * 32767.0).round() as i16;
    let bytes: Vec<u8> = [0, 0, half, half, 0, 0, 0, 32767]
        .iter()
        .flat_map(|v: &i16| v.to_le_bytes())
        .collect();
    let rotations = file.accessor("VEC4", SHORT, true, 2, &bytes);
    file.json["nodes"][0]["translation"] = json!([100.0, 0.0, 0.0]);
    file.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translations, "ROTATION": rotations, "_ID": 0 } } });
    let imported = file.load();
    let instances = &imported.scene.instances;
    assert_eq!(instances.len(), 2);
    assert_eq!(imported.scene.meshes.len(), 1);
    let at = |i: usize, p: DVec3| instances[i].world_from_object.transform_point3(p);
    assert!(at(0, DVec3::X).abs_diff_eq(DVec3::new(101.0, 3.0, 3.0), 1e-9));
    assert!(at(1, DVec3::X).abs_diff_eq(DVec3::new(105.0, 5.0, 6.0), 1e-9));
    assert!(imported.diagnostics.is_empty());
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
        json!(file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"]);
    assert!(
        file.error()
            .contains("its attributes have 2 and 3 elements")
    );
}

#[test]
fn invisible_nodes_hide_their_children() {
    let mut file = Builder::triangle();
    file.json["nodes"] = json!([
        { "children": [1], "extensions": { "KHR_node_visibility": { "visible": false } } },
        { "mesh": 0 },
        { "mesh": 0, "extensions": { "KHR_node_visibility": { "visible": true } } }
    ]);
    file.json["scenes"][0]["nodes"] = json!([0, 2]);
    let imported = file.load();
    assert_eq!(imported.scene.instances.len(), 1);
    assert_eq!(imported.scene.instances[0].name, "node 2");
}

// --- accessors and meshes ---

#[test]
fn index_types_and_primitive_modes() {
    for (component, bytes) in [
        (UNSIGNED_BYTE, vec![2, 1, 0]),
        (
            UNSIGNED_SHORT,
            [2u16, 1, 0].iter().flat_map(|i| i.to_le_bytes()).collect(),
        ),
        (
            UNSIGNED_INT,
            [2u32, 1, 0].iter().flat_map(|i| i.to_le_bytes()).collect(),
        ),
    ] {
        let mut file = Builder::triangle();
        let indices = file.accessor("SCALAR", component, false, 3, &bytes);
        file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        assert_eq!(file.load().scene.meshes[0].triangles, [[2, 1, 0]]);
    }
    let mut file = Builder::square();
    let strip = file.accessor("SCALAR", UNSIGNED_BYTE, false, 4, &[0, 1, 3, 2]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(strip);
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
    assert_eq!(
        file.load().scene.meshes[0].triangles,
        [[0, 1, 3], [1, 2, 3]]
    );
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(6);
    file.json["meshes"][0]["primitives"][0]
        .as_object_mut()
        .unwrap()
        .remove("indices");
    assert_eq!(
        file.load().scene.meshes[0].triangles,
        [[1, 2, 0], [2, 3, 0]]
    );
}

#[test]
fn quantised_interleaved_attributes() {
    let mut file = Builder::triangle();
    // Position i16 ×3 (not normalised), padding, normal i8 ×3 normalised, padding; stride 12.
    let mut bytes = Vec::new();
    for (position, normal) in [
        ([-300i16, 0, 7], [0i8, 0, 127]),
        ([300, 0, 7], [0, 0, 127]),
        ([0, 500, 7], [0, -128, 0]),
    ] {
        bytes.extend(position.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0, 0]);
        bytes.extend(normal.map(|v| v as u8));
        bytes.push(0);
    }
    let view = file.view(&bytes);
    file.json["bufferViews"][view]["byteStride"] = json!(12);
    let positions = file.push(
        "accessors",
        json!({ "bufferView": view, "componentType": SHORT, "type": "VEC3", "count": 3 }),
    );
    let normals = file.push(
        "accessors",
        json!({ "bufferView": view, "byteOffset": 8, "componentType": BYTE, "type": "VEC3", "count": 3, "normalized": true }),
    );
    let uvs = file.accessor(
        "VEC2",
        UNSIGNED_SHORT,
        true,
        3,
        &[0, 0, 255, 255, 0, 128, 0, 0, 255, 255, 0, 0],
    );
    file.json["meshes"][0]["primitives"][0]["attributes"] =
        json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs });
    file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let imported = file.load();
    let mesh = &imported.scene.meshes[0];
    assert_eq!(
        mesh.positions,
        [[-300.0, 0.0, 7.0], [300.0, 0.0, 7.0], [0.0, 500.0, 7.0]]
    );
    assert_eq!(
        mesh.normals.as_deref().unwrap(),
        [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    );
    assert_eq!(
        mesh.uvs[0],
        [[0.0, 1.0], [32768.0 / 65535.0, 0.0], [1.0, 0.0]]
    );
    assert!(imported.diagnostics.is_empty());
}

#[test]
fn sparse_accessors_with_and_without_a_base() {
    let mut file = Builder::triangle();
    let base = file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
        .as_u64()
        .unwrap() as usize;
    let at = file.view(&[1, 0, 2, 0]);
    let with: Vec<u8> = [9.0f32, 0.0, 0.0, 0.0, 8.0, 0.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let with = file.view(&with);
    let sparse = json!({
        "count": 2,
        "indices": { "bufferView": at, "componentType": UNSIGNED_SHORT },
        "values": { "bufferView": with }
    });
    file.json["accessors"][base]["sparse"] = sparse;
    let expected = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 8.0, 0.0]];
    assert_eq!(file.load().scene.meshes[0].positions, expected);
    // Without a buffer view the base is all zeros, which the first vertex is anyway.
    file.json["accessors"][base]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    assert_eq!(file.load().scene.meshes[0].positions, expected);
}

#[test]
fn vertex_colours_of_every_kind() {
    type Case = (&'static str, u32, bool, Vec<u8>, [f32; 4]);
    let cases: [Case; 5] = [
        (
            "VEC3",
            FLOAT,
            false,
            [0.25f32, 0.5, 0.75]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect(),
            [0.25, 0.5, 0.75, 1.0],
        ),
        (
            "VEC4",
            FLOAT,
            false,
            [0.25f32, 0.5, 0.75, 0.5]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect(),
            [0.25, 0.5, 0.75, 0.5],
        ),
        (
            "VEC4",
            UNSIGNED_BYTE,
            true,
            vec![255, 0, 51, 102],
            [1.0, 0.0, 0.2, 0.4],
        ),
        (
            "VEC4",
            UNSIGNED_SHORT,
            true,
            vec![255, 255, 0, 0, 51, 51, 102, 102],
            [1.0, 0.0, 0.2, 0.4],
        ),
        (
            "VEC4",
            UNSIGNED_BYTE,
            false,
            vec![255, 0, 51, 102],
            [1.0, 0.0, 0.2, 0.4],
        ),
    ];
    for (kind, component, normalized, bytes, expected) in cases {
        let mut file = Builder::triangle();
        let colors = file.accessor(kind, component, normalized, 3, &bytes.repeat(3));
        file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        let scene = file.load().scene;
        for color in scene.meshes[0].colors.as_ref().unwrap() {
            for (found, expected) in color.iter().zip(expected) {
                assert_relative_eq!(*found, expected, epsilon = 1e-7);
            }
        }
    }
}

#[test]
fn primitives_that_share_a_vertex_buffer_keep_their_own_part() {
    let mut file = Builder::square();
    let one = file.accessor("SCALAR", UNSIGNED_BYTE, false, 3, &[3, 1, 2]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(one);
    let mesh = file.load().scene.meshes[0].clone();
    assert_eq!(
        mesh.positions,
        [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    );
    assert_eq!(mesh.triangles, [[2, 0, 1]]);
    assert_eq!(mesh.uvs[0], [[1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
}

#[test]
fn tangents_come_only_with_normal_maps_and_on_their_uv_set() {
    let mut file = Builder::square();
    assert!(file.load().scene.meshes[0].tangents.is_none());
    // The second set runs along y instead of x.
    let turned = file.floats("VEC2", &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(turned);
    let texture =
        file.png_texture(image::RgbImage::from_pixel(1, 1, image::Rgb([128, 128, 255])).into());
    file.json["materials"][0]["normalTexture"] = json!({ "index": texture, "scale": 0.5 });
    let tangents = |file: &Builder| file.load().scene.meshes[0].tangents.clone().unwrap();
    assert_eq!(tangents(&file), [[1.0, 0.0, 0.0, 1.0]; 4]);
    let scene = file.load().scene;
    assert_eq!(
        standard(&scene.materials[0])
            .normal_texture
            .as_ref()
            .unwrap()
            .scale,
        0.5
    );
    file.json["materials"][0]["normalTexture"]["texCoord"] = json!(1);
    assert_eq!(tangents(&file), [[0.0, 1.0, 0.0, 1.0]; 4]);
    // KHR_texture_transform overrides the set.
    file.json["materials"][0]["normalTexture"]["extensions"] =
        json!({ "KHR_texture_transform": { "texCoord": 0 } });
    assert_eq!(tangents(&file), [[1.0, 0.0, 0.0, 1.0]; 4]);
    // What the file gives is used as it is.
    let given = file.floats("VEC4", &[0.6, 0.8, 0.0, -1.0].repeat(4));
    file.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(given);
    assert_eq!(tangents(&file), [[0.6, 0.8, 0.0, -1.0]; 4]);
    // But not without normals, by the specification.
    file.json["meshes"][0]["primitives"][0]["attributes"]
        .as_object_mut()
        .unwrap()
        .remove("NORMAL");
    assert_eq!(tangents(&file), [[1.0, 0.0, 0.0, 1.0]; 4]);
    // A set that the mesh has not.
    file.json["materials"][0]["normalTexture"] = json!({ "index": texture, "texCoord": 5 });
    let imported = file.load();
    assert!(imported.scene.meshes[0].tangents.is_none());
    assert_eq!(codes(&imported), ["normal-map-without-uv"]);
}

// --- deformation ---

#[test]
fn morph_targets_take_their_weights_from_node_or_mesh() {
    let mut file = Builder::triangle();
    let offsets = file.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let more = file.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": offsets }, { "POSITION": more }]);
    assert_eq!(
        file.load().scene.meshes[0].positions[0],
        [0.0; 3],
        "weights are 0 by default"
    );
    file.json["meshes"][0]["weights"] = json!([0.5]);
    assert_eq!(file.load().scene.meshes[0].positions[0], [0.0, 0.0, 1.0]);
    file.json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "weights": [0.25, 3.0] }]);
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    let scene = file.load().scene;
    assert_eq!(scene.meshes.len(), 2);
    assert_eq!(scene.meshes[0].positions[0], [0.0, 0.0, 1.0]);
    assert_eq!(scene.meshes[1].positions[0], [3.0, 0.0, 0.5]);
}

#[test]
fn skinned_meshes_follow_their_joints_and_not_their_node() {
    let mut file = Builder::triangle();
    let joints = file.accessor(
        "VEC4",
        UNSIGNED_BYTE,
        false,
        3,
        &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0],
    );
    let weights = file.accessor(
        "VEC4",
        UNSIGNED_BYTE,
        true,
        3,
        &[255, 0, 0, 0, 255, 0, 0, 0, 51, 204, 0, 0],
    );
    let mut binds = Vec::new();
    for x in [0.0, -1.0] {
        binds.extend([
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, 0.0, 0.0, 1.0,
        ]);
    }
    let binds = file.floats("MAT4", &binds);
    file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    file.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": binds }]);
    file.json["nodes"] = json!([
        { "name": "body", "mesh": 0, "skin": 0, "translation": [1000.0, 0.0, 0.0] },
        { "name": "root", "translation": [0.0, 0.0, 1.0e7], "children": [2] },
        { "name": "tip", "translation": [1.0, 0.0, 0.125] }
    ]);
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    let scene = file.load().scene;
    let world = |i: usize| {
        let p = scene.meshes[0].positions[i].map(f64::from);
        scene.instances[0]
            .world_from_object
            .transform_point3(p.into())
    };
    assert_eq!(world(0), DVec3::new(0.0, 0.0, 1.0e7));
    assert_eq!(world(1), DVec3::new(1.0, 0.0, 1.0e7 + 0.125));
    assert!(
        world(2).abs_diff_eq(DVec3::new(0.0, 1.0, 1.0e7 + 0.1), 1e-7),
        "{}",
        world(2)
    );
    file.json["nodes"][1]["children"] = json!([]);
    let told = file.load().diagnostics;
    assert!(told.iter().any(|d| d.code == "skin-joints"));
}

// --- materials ---

#[test]
fn a_material_with_everything() {
    let mut file = Builder::square();
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"].clone();
    let texture =
        file.png_texture(image::RgbaImage::from_pixel(1, 1, image::Rgba([1, 2, 3, 4])).into());
    file.json["samplers"] =
        json!([{ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987 }]);
    file.json["textures"][texture]["sampler"] = json!(0);
    let map = |set: u32| json!({ "index": texture, "texCoord": set });
    file.json["materials"][0] = json!({
        "name": "all",
        "doubleSided": true,
        "alphaMode": "MASK",
        "alphaCutoff": 0.25,
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
            "baseColorTexture": {
                "index": texture,
                "extensions": { "KHR_texture_transform": { "offset": [0.1, 0.2], "rotation": 0.3, "scale": [2.0, 3.0], "texCoord": 1 } }
            },
            "metallicFactor": 0.5,
            "roughnessFactor": 0.6,
            "metallicRoughnessTexture": map(0)
        },
        "emissiveFactor": [0.5, 0.25, 1.0],
        "emissiveTexture": map(1),
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 8.0 },
            "KHR_materials_ior": { "ior": 1.33 },
            "KHR_materials_specular": {
                "specularFactor": 0.7,
                "specularTexture": map(0),
                "specularColorFactor": [2.0, 1.0, 0.5],
                "specularColorTexture": map(1)
            },
            "KHR_materials_transmission": { "transmissionFactor": 0.9, "transmissionTexture": map(0) },
            "KHR_materials_volume": { "thicknessFactor": 0.1 }
        }
    });
    let imported = file.load();
    assert!(
        imported.diagnostics.is_empty(),
        "{:?}",
        imported.diagnostics
    );
    assert_eq!(
        imported.scene.images.len(),
        1,
        "one image, however often it is used"
    );
    let m = &standard(&imported.scene.materials[0]);
    assert_eq!(
        (m.name.as_str(), m.double_sided, m.unlit, m.thin_walled),
        ("all", true, false, false)
    );
    assert_eq!(m.alpha_mode, AlphaMode::Mask { cutoff: 0.25 });
    assert_eq!(
        (m.base_color, m.alpha, m.metallic, m.roughness),
        ([0.1, 0.2, 0.3], 0.4, 0.5, 0.6)
    );
    assert_eq!(m.emission, [4.0, 2.0, 8.0]);
    assert_eq!(
        (m.ior, m.specular, m.specular_color, m.transmission),
        (1.33, 0.7, [2.0, 1.0, 0.5], 0.9)
    );
    let base = m.base_color_texture.as_ref().unwrap();
    assert_eq!(base.uv_set, 1);
    assert_eq!(
        base.transform,
        UvTransform {
            offset: [0.1, 0.2],
            rotation: 0.3,
            scale: [2.0, 3.0]
        }
    );
    assert_eq!(
        (base.sampler.wrap_u, base.sampler.wrap_v),
        (Wrap::Clamp, Wrap::Mirror)
    );
    assert_eq!(base.sampler.filter, TextureFilter::Nearest);
    let sets = [
        &m.metallic_roughness_texture,
        &m.emission_texture,
        &m.specular_texture,
        &m.specular_color_texture,
        &m.transmission_texture,
    ];
    assert_eq!(sets.map(|t| t.as_ref().unwrap().uv_set), [0, 1, 0, 1, 0]);
}

/// Blender's exporter writes a specular level above 1/2 into the colour; it is the factor that says what Blender means.
#[test]
fn a_specular_color_above_one_is_a_specular_factor() {
    let mut file = Builder::square();
    let read = |file: &mut Builder, specular: serde_json::Value| {
        file.json["materials"][0] = json!({ "extensions": { "KHR_materials_specular": specular } });
        let m = &standard(&file.load().scene.materials[0]);
        (m.specular, m.specular_color)
    };
    let above = json!({ "specularColorFactor": [1.6, 1.2, 0.8] });
    assert_eq!(read(&mut file, above), (1.6, [1.0, 1.2 / 1.6, 0.8 / 1.6]));
    let with_factor = json!({ "specularFactor": 0.5, "specularColorFactor": [1.6, 1.2, 0.8] });
    assert_eq!(read(&mut file, with_factor), (0.5, [1.6, 1.2, 0.8]));
}

#[test]
fn materials_without_anything_are_gltfs_default() {
    let mut file = Builder::square();
    file.json["materials"][0] =
        json!({ "alphaMode": "BLEND", "extensions": { "KHR_materials_unlit": {} } });
    let scene = file.load().scene;
    let m = &standard(&scene.materials[0]);
    assert_eq!(
        (m.base_color, m.metallic, m.roughness, m.ior),
        ([1.0; 3], 1.0, 1.0, 1.5)
    );
    assert_eq!(
        (m.alpha_mode, m.unlit, m.double_sided),
        (AlphaMode::Blend, true, false)
    );
    file.json["materials"][0] = json!({ "alphaMode": "MASK" });
    assert_eq!(
        standard(&file.load().scene.materials[0]).alpha_mode,
        AlphaMode::Mask { cutoff: 0.5 }
    );
}

#[test]
fn transmission_is_solid_or_thin_by_generator_volume_and_option() {
    let mut file = Builder::square();
    let transmission = json!({ "KHR_materials_transmission": { "transmissionFactor": 1.0 } });
    file.json["materials"][0] = json!({ "extensions": transmission });
    let thin = |file: &Builder, transmission| {
        let options = ImportOptions {
            transmission,
            ..ImportOptions::default()
        };
        standard(&file.load_with(&options).unwrap().scene.materials[0]).thin_walled
    };
    assert!(thin(&file, Transmission::Auto));
    assert!(!thin(&file, Transmission::Solid));
    file.json["asset"]["generator"] = json!(BLENDER_4_5);
    assert!(!thin(&file, Transmission::Auto));
    assert!(thin(&file, Transmission::Thin));
    assert_eq!(codes(&file.load()), ["solid-transmission"]);
    file.json["asset"]["generator"] = json!("Other");
    let volume = json!({ "thicknessFactor": 0.5, "attenuationDistance": 2.0, "attenuationColor": [1.0, 0.5, 0.5] });
    file.json["materials"][0]["extensions"]["KHR_materials_volume"] = volume;
    assert!(!thin(&file, Transmission::Auto));
    let imported = file.load();
    assert!(imported.diagnostics.is_empty());
    let medium = imported.scene.materials[0].medium.clone().unwrap();
    let half = std::f32::consts::LN_2 / 2.0;
    assert_eq!(medium.absorption[0], 0.0);
    assert!(
        (medium.absorption[1] / half - 1.0).abs() < 1e-6,
        "{medium:?}"
    );
    for (key, value) in [
        ("attenuationColor", json!([1.0, 1.0, 1.0])),
        ("thicknessFactor", json!(0.0)),
    ] {
        let mut clear = file.clone();
        clear.json["materials"][0]["extensions"]["KHR_materials_volume"][key] = value;
        let imported = clear.load();
        assert!(imported.diagnostics.is_empty(), "no effect by value");
        let medium = imported.scene.materials[0].medium.as_ref();
        assert_eq!(medium.and_then(Medium::effect), None);
    }
}

/// A draft, behind a switch: what is taken on the way is scattered as far as the colour says.
#[test]
fn solids_scatter_by_the_draft_where_it_is_asked_for() {
    let mut file = Builder::square();
    file.json["materials"][0] = json!({ "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 1.0 },
        "KHR_materials_volume": { "thicknessFactor": 0.5, "attenuationDistance": 2.0, "attenuationColor": [0.5, 0.5, 0.5] },
        "KHR_materials_volume_scatter": { "multiscatterColorFactor": [1.0, 0.5, 0.0], "scatterAnisotropy": 0.3 }
    } });
    let imported = file.load();
    assert_eq!(codes(&imported), ["unsupported-material"]);
    let medium = imported.scene.materials[0].medium.clone().unwrap();
    assert!(medium.scatterers.is_empty());
    let options = ImportOptions {
        scatter: true,
        ..ImportOptions::default()
    };
    let scatters = |file: &Builder| {
        let imported = file.load_with(&options).unwrap();
        assert!(imported.diagnostics.is_empty());
        imported.scene.materials[0].medium.clone().unwrap()
    };
    let found = scatters(&file);
    let [scatterer] = &found.scatterers[..] else {
        panic!("{found:?}");
    };
    assert_eq!(scatterer.phase, sundog::scene::Phase::HenyeyGreenstein(0.3));
    let extinction = std::f32::consts::LN_2 / 2.0;
    for channel in 0..3 {
        let sum = found.absorption[channel] + scatterer.coefficient[channel];
        assert!((sum / extinction - 1.0).abs() < 1e-6, "{found:?}");
    }
    // White scatters all, black nothing, and the middle what d'Eon's equation 53.7 says: s = 0.2971 for 0.5.
    let albedo = scatterer.coefficient.map(|c| c / extinction);
    let s2 = 0.297_1_f32.powi(2);
    let known = [1.0, (1.0 - s2) / (1.0 - 0.3 * s2), 0.0];
    for (found, known) in albedo.into_iter().zip(known) {
        assert!((found - known).abs() < 2e-3, "{albedo:?}");
    }
    let scatter = &mut file.json["materials"][0]["extensions"]["KHR_materials_volume_scatter"];
    *scatter = json!({ "multiscatterColor": [1.0, 0.5, 0.0], "scatterAnisotropy": 0.3 });
    assert_eq!(scatters(&file), found, "as drafts before had it");
}

#[test]
fn meshes_without_a_material_look_as_in_the_blender_that_wrote_them() {
    let mut file = Builder::triangle();
    file.json["asset"]["generator"] = json!(BLENDER_4_5);
    let imported = file.load();
    let id = imported.scene.meshes[0].material.unwrap().0;
    let m = &standard(&imported.scene.materials[id as usize]);
    assert_eq!(
        (m.base_color, m.metallic, m.roughness, m.specular),
        ([0.8; 3], 0.0, 1.0, 0.0)
    );
    assert_eq!(codes(&imported), ["no-material"]);
    assert_eq!(found(&imported, "no-material")[0].verdict, Verdict::Exact);
    file.json["asset"]["generator"] = json!("Khronos glTF Blender I/O v5.0.21");
    let imported = file.load();
    let m = &standard(&imported.scene.materials[0]);
    assert_eq!(
        (m.base_color, m.metallic, m.roughness, m.specular),
        ([0.8; 3], 0.0, 0.5, 1.0)
    );
}

#[test]
fn unsupported_material_extensions_are_named_once_and_only_if_they_do_something() {
    let idle = json!({
        "KHR_materials_dispersion": { "dispersion": 0.0 },
        "KHR_materials_iridescence": {},
        "KHR_materials_diffuse_transmission": { "diffuseTransmissionColorFactor": [1.0, 0.0, 0.0] }
    });
    let mut file = Builder::square();
    file.json["materials"] =
        json!([{ "name": "a", "extensions": idle }, { "name": "b", "extensions": idle }]);
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    let mut second = primitive.clone();
    second["material"] = json!(1);
    file.json["meshes"][0]["primitives"] = json!([primitive, second]);
    assert!(file.load().diagnostics.is_empty());
    for material in [0, 1] {
        let extensions = &mut file.json["materials"][material]["extensions"];
        extensions["KHR_materials_dispersion"]["dispersion"] = json!(0.1);
        extensions["KHR_materials_subsurface"] = json!({});
        extensions["ACME_glitter"] = json!({});
    }
    let imported = file.load();
    assert_eq!(imported.diagnostics.iter().count(), 2);
    for message in imported.diagnostics.iter() {
        assert_eq!(
            (message.count, message.verdict),
            (2, Verdict::Lost),
            "{message}"
        );
        assert_eq!(message.objects, ["material \"a\"", "material \"b\""]);
    }
    let effects = imported.diagnostics.iter().filter_map(|m| m.effect);
    assert_eq!(
        effects.collect::<enumset::EnumSet<_>>(),
        enumset::EnumSet::only(Effect::Subsurface)
    );
    let unknown = found(&imported, "unknown-extension");
    assert_eq!(unknown.len(), 1);
    assert_eq!(
        (unknown[0].feature.as_str(), unknown[0].effect),
        ("ACME_glitter", None)
    );
    // Demanded material extensions do not stop the import.
    file.json["extensionsRequired"] = json!(["KHR_materials_dispersion"]);
    assert_eq!(file.load().diagnostics.iter().count(), 2);
}

#[test]
fn other_features_are_named() {
    let mut file = Builder::square();
    let texture = file.png_texture(image::GrayImage::from_pixel(1, 1, image::Luma([255])).into());
    file.json["materials"][0]["occlusionTexture"] = json!({ "index": texture });
    file.json["animations"] = json!([{ "name": "spin", "channels": [], "samplers": [] }]);
    file.json["extensions"] =
        json!({ "KHR_materials_variants": { "variants": [{ "name": "red" }] } });
    file.json["nodes"][0]["extensions"] = json!({ "ACME_physics": { "mass": 3 } });
    file.json["nodes"][0]["extras"] = json!("any value is allowed here");
    file.json["materials"][0]["extras"] = json!([1, 2]);
    file.json["asset"]["extras"] = json!(5);
    let imported = file.load();
    assert_eq!(
        codes(&imported),
        ["unknown-extension", "variants", "animation", "occlusion"]
    );
    assert!(
        imported.scene.images.is_empty(),
        "an image that only occlusion uses is not decoded"
    );
}

// --- required extensions and fallbacks ---

#[test]
fn extensions_that_move_the_data_are_one_clear_error() {
    for (extension, remedy) in [
        ("KHR_accessor_float64", "export it from there"),
        ("ACME_everything_else", "without it"),
    ] {
        let mut file = Builder::triangle();
        file.json["extensionsRequired"] = json!([extension]);
        let error = file.error();
        assert!(
            error.contains(extension) && error.contains(remedy) && error.contains("test.glb"),
            "{error}"
        );
        assert!(!error.contains('\n'));
    }
}

#[test]
fn fallbacks_are_used_and_told() {
    let mut file = Builder::square();
    file.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression", "MSFT_texture_dds"]);
    file.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } });
    let texture = file.png_texture(image::GrayImage::from_pixel(1, 1, image::Luma([255])).into());
    file.json["textures"][texture]["extensions"] = json!({ "MSFT_texture_dds": { "source": 99 } });
    file.json["materials"][0]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": texture } });
    let imported = file.load();
    assert_eq!(
        codes(&imported),
        ["texture-fallback", "compression-fallback"]
    );
    assert_eq!(imported.scene.images.len(), 1);
    assert_eq!(imported.scene.meshes[0].triangles.len(), 2);
    // Without a fallback the texture is lost, and the mesh is an error.
    file.json["textures"][texture]
        .as_object_mut()
        .unwrap()
        .remove("source");
    let imported = file.load();
    assert_eq!(codes(&imported), ["texture-kind", "compression-fallback"]);
    assert!(
        standard(&imported.scene.materials[0])
            .base_color_texture
            .is_none()
    );
    let positions = file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
        .as_u64()
        .unwrap() as usize;
    file.json["accessors"][positions]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    assert!(file.error().contains("Draco"));
}

#[test]
fn webp_is_preferred_and_unreadable_kinds_are_left_out() {
    let mut file = Builder::square();
    let texture = file.png_texture(image::GrayImage::from_pixel(1, 1, image::Luma([255])).into());
    let mut webp = std::io::Cursor::new(Vec::new());
    image::DynamicImage::from(image::RgbImage::from_pixel(5, 4, image::Rgb([9, 8, 7])))
        .write_to(&mut webp, image::ImageFormat::WebP)
        .unwrap();
    let view = file.view(&webp.into_inner());
    let image = file.push(
        "images",
        json!({ "bufferView": view, "mimeType": "image/webp" }),
    );
    file.json["textures"][texture]["extensions"] =
        json!({ "EXT_texture_webp": { "source": image } });
    file.json["materials"][0]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": texture } });
    let imported = file.load();
    assert!(imported.diagnostics.is_empty());
    assert_eq!(
        (
            imported.scene.images[0].width,
            imported.scene.images[0].height
        ),
        (5, 4)
    );
    let view = file.view(b"\xabKTX 11\xbb\r\n\x1a\n and so on");
    file.json["images"][image]["bufferView"] = json!(view);
    let imported = file.load();
    assert_eq!(codes(&imported), ["image-kind"]);
    assert!(
        standard(&imported.scene.materials[0])
            .base_color_texture
            .is_none()
    );
}

// --- lights and cameras ---

fn lights(kind: serde_json::Value) -> Builder {
    let mut file = Builder::triangle();
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [kind] } });
    file.json["nodes"][0] =
        json!({ "name": "lamp", "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    file
}

#[test]
fn light_units_give_back_blenders_watts() {
    // A lamp of 100 W: W/sr = 100 / 4π in all modes, and the sun's W/m² as they are.
    let watts = 100.0;
    let per_steradian = (watts / (4.0 * PI)) as f32;
    for (units, point, sun) in [
        (
            LightUnits::Standard,
            watts / (4.0 * PI) * 683.0,
            3.0 * 683.0,
        ),
        (LightUnits::Unitless, watts / (4.0 * PI), 3.0),
        (LightUnits::Raw, watts, 3.0),
    ] {
        let options = ImportOptions {
            light_units: units,
            ..ImportOptions::default()
        };
        let load = |file: Builder| file.load_with(&options).unwrap().scene.lights[0].clone();
        let light = load(lights(
            json!({ "type": "point", "intensity": point, "color": [1.0, 0.5, 0.25] }),
        ));
        assert_eq!(
            (light.name.as_str(), light.color),
            ("lamp", [1.0, 0.5, 0.25])
        );
        assert!(
            matches!(light.kind, LightKind::Point { intensity, radius: 0.0, .. } if (intensity / per_steradian - 1.0).abs() < 1e-6)
        );
        let light = load(lights(
            json!({ "type": "spot", "intensity": point, "spot": {} }),
        ));
        assert!(
            matches!(light.kind, LightKind::Spot { intensity, .. } if (intensity / per_steradian - 1.0).abs() < 1e-6)
        );
        let light = load(lights(json!({ "type": "directional", "intensity": sun })));
        assert!(
            matches!(light.kind, LightKind::Sun { irradiance, angle: 0.0 } if (irradiance / 3.0 - 1.0).abs() < 1e-6)
        );
    }
}

#[test]
fn units_of_lamps_follow_from_the_program_and_the_numbers() {
    const BLENDER_3_5: &str = "Khronos glTF Blender I/O v3.5.30";
    // A lamp at three metres from the triangle, or a sun: whether the numbers are lux, and whether that is in doubt.
    for (generator, kind, intensity, photometric, doubt) in [
        (BLENDER_4_5, "directional", 3.0 * 683.0, true, false),
        (BLENDER_4_5, "directional", 3.0, false, false),
        (
            BLENDER_4_5,
            "point",
            100.0 * 683.0 / (4.0 * PI),
            true,
            false,
        ),
        (BLENDER_4_5, "point", 10.0 * 683.0 / (4.0 * PI), true, true),
        (BLENDER_4_5, "point", 10.0 / (4.0 * PI), false, false),
        (BLENDER_4_5, "point", 1000.0 / (4.0 * PI), false, true),
        (BLENDER_3_5, "directional", 1.0, false, false),
        ("THREE.GLTFExporter r160", "directional", 5.0, false, false),
        ("THREE.GLTFExporter r160", "spot", 900.0, false, false),
        (
            "THREE.GLTFExporter r160",
            "directional",
            100_000.0,
            true,
            false,
        ),
        ("babylon.js glTF exporter", "directional", 3.0, false, false),
        ("Something else", "directional", 2.0, false, false),
        ("Something else", "directional", 100_000.0, true, false),
        ("Something else", "directional", 120.0, true, true),
        ("", "directional", 60.0, false, true),
    ] {
        let mut file = lights(json!({ "type": kind, "intensity": intensity, "spot": {} }));
        file.json["asset"]["generator"] = json!(generator);
        file.json["nodes"][0]["translation"] = json!([0.0, 0.0, 3.0]);
        let node = file.push("nodes", json!({ "mesh": 0 }));
        file.json["scenes"][0]["nodes"] = json!([0, node]);
        let imported = file.load();
        let strength = match imported.scene.lights[0].kind {
            LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. } => intensity,
            LightKind::Sun { irradiance, .. } => irradiance,
            LightKind::Area { .. } => panic!("glTF has none"),
        };
        let meant = if photometric {
            intensity / 683.0
        } else {
            intensity
        } as f32;
        assert_relative_eq!(strength, meant, max_relative = 1e-6);
        let told = found(&imported, "light-units");
        assert_eq!(told.len(), 1);
        let verdict = if doubt {
            Verdict::Approximated
        } else {
            Verdict::Exact
        };
        let case = format!("{generator}, {kind} {intensity}: {}", told[0]);
        assert_eq!(told[0].verdict, verdict, "{case}");
        let other = if photometric { "unitless" } else { "standard" };
        assert!(case.contains(&format!("--light-units {other}")), "{case}");
    }
    // What Sundog's own extension says needs no choice, and neither does what the user says.
    let said = json!({ "type": "point", "extensions": { "SUNDOG_light": { "strength": [2.0, 2.0, 2.0] } } });
    assert!(lights(said).load().diagnostics.is_empty());
}

#[test]
fn spot_cones_give_back_blenders_size_and_blend() {
    let options = ImportOptions {
        light_units: LightUnits::Standard,
        ..ImportOptions::default()
    };
    for (size, blend) in [(1.2f64, 0.15f64), (PI, 1.0), (0.5, 0.0)] {
        let (outer, inner) = (size / 2.0, size / 2.0 * (1.0 - blend));
        let mut file = lights(
            json!({ "type": "spot", "spot": { "outerConeAngle": outer, "innerConeAngle": inner } }),
        );
        file.json["asset"]["generator"] = json!(BLENDER_4_5);
        let imported = file.load_with(&options).unwrap();
        assert!(imported.diagnostics.is_empty());
        let LightKind::Spot {
            half_angle,
            blend: found,
            ..
        } = imported.scene.lights[0].kind
        else {
            panic!()
        };
        assert_relative_eq!(half_angle, outer as f32, epsilon = 1e-6);
        assert_relative_eq!(found, blend as f32, epsilon = 1e-6);
        file.json["asset"]["generator"] = json!("Other");
        assert_eq!(
            codes(&file.load_with(&options).unwrap()),
            if blend > 0.0 {
                vec!["spot-edge"]
            } else {
                vec![]
            }
        );
    }
}

#[test]
fn sundog_light_gives_lights_a_size() {
    let size = |kind: &str, extension| {
        lights(json!({ "type": kind, "extensions": { "SUNDOG_light": extension } })).load()
    };
    let imported = size("point", json!({ "radius": 0.25 }));
    assert_eq!(codes(&imported), ["light-units"]);
    assert!(matches!(
        imported.scene.lights[0].kind,
        LightKind::Point { radius: 0.25, .. }
    ));
    assert!(matches!(
        size("spot", json!({ "radius": 0.5 })).scene.lights[0].kind,
        LightKind::Spot { radius: 0.5, .. }
    ));
    assert!(matches!(
        size("directional", json!({ "angle": 0.125 })).scene.lights[0].kind,
        LightKind::Sun { angle: 0.125, .. }
    ));
}

#[test]
fn what_lights_cannot_do_is_named() {
    let imported =
        lights(json!({ "type": "point", "range": 10.0, "extensions": { "ACME_gobo": {} } })).load();
    assert_eq!(
        codes(&imported),
        ["unknown-extension", "light-range", "light-units"]
    );
    let imported = lights(json!({ "type": "area" })).load();
    assert_eq!(codes(&imported), ["light-kind"]);
    assert!(imported.scene.lights.is_empty());
}

#[test]
fn cameras_perspective_and_orthographic() {
    let mut file = Builder::triangle();
    file.json["cameras"] = json!([
        { "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } },
        { "type": "perspective", "perspective": { "yfov": 0.7, "aspectRatio": 1.5, "znear": 0.1, "zfar": 50.0 } },
        { "type": "orthographic", "name": "plan", "orthographic": { "xmag": 3.0, "ymag": 2.0, "znear": 0.0, "zfar": 9.0 } }
    ]);
    file.json["nodes"] = json!([
        { "name": "one", "camera": 0 },
        { "name": "two", "camera": 1, "translation": [1.0, 2.0, 3.0] },
        { "camera": 2 }
    ]);
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let imported = file.load();
    assert!(imported.diagnostics.is_empty());
    let cameras = &imported.scene.cameras;
    let names: Vec<&str> = cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["one", "two", "plan"]);
    assert_eq!(
        cameras[0].projection,
        Projection::Perspective {
            vertical_fov: 0.7,
            aspect: None
        }
    );
    assert_eq!(
        (cameras[0].clip_near, cameras[0].clip_far),
        (0.1, f64::INFINITY)
    );
    assert_eq!(
        cameras[1].projection,
        Projection::Perspective {
            vertical_fov: 0.7,
            aspect: Some(1.5)
        }
    );
    assert_eq!(cameras[1].clip_far, 50.0);
    assert_eq!(
        cameras[1].world_from_camera.translation,
        DVec3::new(1.0, 2.0, 3.0)
    );
    assert_eq!(
        cameras[2].projection,
        Projection::Orthographic {
            half_width: 3.0,
            half_height: 2.0
        }
    );
}

// --- Sundog's own extensions ---

fn camera_with(extension: serde_json::Value) -> sundog::import::Imported {
    let mut file = Builder::triangle();
    file.json["cameras"] = json!([{
        "type": "perspective",
        "perspective": { "yfov": 1.0, "znear": 0.1, "zfar": 100.0 },
        "extensions": { "SUNDOG_camera": extension }
    }]);
    file.json["nodes"] = json!([{ "mesh": 0 }, { "name": "eye", "camera": 0 }]);
    file.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    file.load()
}

#[test]
fn a_camera_has_a_window_clip_planes_an_aperture_and_a_panorama() {
    let imported = camera_with(json!({
        "window": [-1.0, 3, -0.5, 0.5],
        "clip": [2, 50.0],
        "aperture": { "radius": 0.1, "blades": 5, "rotation": 0.3, "ratio": 2.0, "focus_distance": 4.0 }
    }));
    assert!(imported.diagnostics.is_empty());
    let camera = &imported.scene.cameras[0];
    let window = camera.window.unwrap();
    assert_eq!((window.left, window.right), (-1.0, 3.0));
    assert_eq!((window.bottom, window.top), (-0.5, 0.5));
    assert_eq!((camera.clip_near, camera.clip_far), (2.0, 50.0));
    let aperture = camera.aperture.unwrap();
    assert_eq!((aperture.radius, aperture.blades), (0.1, 5));
    assert_eq!((aperture.rotation, aperture.ratio), (0.3, 2.0));
    assert_eq!(aperture.focus_distance, 4.0);

    let imported =
        camera_with(json!({ "panorama": { "type": "equirectangular", "longitude": [-1, 2.0] } }));
    assert!(imported.diagnostics.is_empty());
    assert_eq!(
        imported.scene.cameras[0].projection,
        Projection::Equirectangular {
            longitude: [-1.0, 2.0],
            latitude: [-PI / 2.0, PI / 2.0],
        }
    );
}

#[test]
fn impossible_and_unknown_things_of_a_camera_are_told_and_left_out() {
    for (extension, code) in [
        (json!({ "window": [1, -1, 0, 1] }), "bad-window"),
        (json!({ "clip": [5, 1] }), "bad-clipping"),
        (
            json!({ "aperture": { "radius": -1, "focus_distance": 1 } }),
            "bad-aperture",
        ),
        (
            json!({ "aperture": { "radius": 1, "focus_distance": 0 } }),
            "bad-aperture",
        ),
        (
            json!({ "panorama": { "type": "fisheye" } }),
            "panorama-kind",
        ),
        (json!({ "windov": [1] }), "unknown-property"),
    ] {
        let imported = camera_with(extension.clone());
        assert!(
            has(&imported, code),
            "{extension}: {:?}",
            imported.diagnostics
        );
        let camera = &imported.scene.cameras[0];
        assert!(
            camera.window.is_none() && camera.aperture.is_none(),
            "{extension}"
        );
        assert!(matches!(camera.projection, Projection::Perspective { .. }));
    }
    // No opening at all is a pinhole, and nothing to speak of.
    let imported = camera_with(json!({ "aperture": { "radius": 0, "focus_distance": 1 } }));
    assert!(imported.diagnostics.is_empty() && imported.scene.cameras[0].aperture.is_none());
}

fn has(imported: &sundog::import::Imported, code: &str) -> bool {
    imported.diagnostics.iter().any(|d| d.code == code)
}

#[test]
fn a_scene_says_how_it_wants_to_be_rendered_and_shown() {
    let mut file = Builder::triangle();
    file.json["scenes"][0]["extensions"] = json!({ "SUNDOG_scene": {
        "color_management": { "display": "sRGB", "view": "AgX", "look": "None", "exposure": 1, "gamma": 2.0, "config": "c.ocio" },
        "render": { "width": 320, "height": 200, "filter_width": 2.5, "transparent": true, "film_exposure": 0.5 }
    } });
    let imported = file.load();
    assert!(imported.diagnostics.is_empty());
    let shown = &imported.scene.color_management;
    assert_eq!(shown.display.as_deref(), Some("sRGB"));
    assert_eq!(shown.view.as_deref(), Some("AgX"));
    assert_eq!(shown.look.as_deref(), Some("None"));
    assert_eq!((shown.exposure, shown.gamma), (Some(1.0), Some(2.0)));
    assert!(shown.config.as_ref().unwrap().ends_with("c.ocio"));
    let render = imported.scene.render;
    assert_eq!((render.width, render.height), (Some(320), Some(200)));
    assert_eq!(
        (render.filter_width, render.transparent),
        (Some(2.5), Some(true))
    );
    assert_eq!(render.film_exposure, Some(0.5));
}

#[test]
fn a_material_of_blender_goes_beyond_gltf() {
    let mut file = Builder::square();
    file.json["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.5, 0.0, 1.0] },
        "extensions": {
            "KHR_materials_specular": { "specularFactor": 1.0 },
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "SUNDOG_material": { "base_color": [1.5, 0.5, 0.0], "specular": 1.8, "thin_walled": false,
                "thin_film": { "thickness": 1 }, "subsurface": {} }
        }
    }]);
    let imported = file.load();
    let material = standard(&imported.scene.materials[0]);
    assert_eq!(material.base_color, [1.5, 0.5, 0.0]);
    assert_eq!(material.specular, 1.8);
    assert!(!material.thin_walled);
    let told: Vec<_> = imported.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(told, ["unsupported-material"]);
    assert_eq!(material.thin_film, Some([1.0, 1.33]));
}
