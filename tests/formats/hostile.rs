//! Files that lie, reach out of their folder or ask for more than they are: each is told or refused.

use std::path::Path;

use glam::{DAffine3, DVec3};
use serde_json::json;
use sundog::import::{self, ImportOptions};
use sundog::scene::{LightKind, Pixels, Verdict};

use super::kit::*;

// --- numbers ---

#[test]
fn whole_numbers_may_have_a_fraction_of_zero() {
    let mut file = Builder::square();
    let text = serde_json::to_string(&file.json).unwrap();
    let with_floats = text
        .replace("\"nodes\":[0]", "\"nodes\":[0.0]")
        .replace("\"mesh\":0", "\"children\":[1.0],\"mesh\":0.0")
        .replace("\"count\":4", "\"count\":4.0")
        .replace("\"componentType\":5126", "\"componentType\":5126.0");
    assert_ne!(text, with_floats);
    file.json = serde_json::from_str(&with_floats).unwrap();
    file.push("nodes", json!({ "name": "child" }));
    let imported = file.load();
    assert_eq!(imported.scene.instances.len(), 1);
    assert_eq!(imported.scene.meshes[0].triangles.len(), 2);
    // A half is no number of an object.
    file.json["nodes"][0]["mesh"] = json!(0.5);
    assert!(file.error().contains("nodes[0]"));
}

#[test]
fn indices_above_32_bits_are_not_cut() {
    let beyond = 1u64 << 32;
    for (place, value) in [
        ("/meshes/0/primitives/0/attributes/POSITION", beyond),
        ("/meshes/0/primitives/0/indices", beyond + 4),
        ("/meshes/0/primitives/0/material", beyond),
        ("/meshes/0/primitives/0/mode", beyond + 4),
        ("/accessors/0/bufferView", beyond),
        ("/accessors/0/componentType", beyond + 5126),
        ("/bufferViews/0/buffer", beyond),
        ("/nodes/0/mesh", beyond),
        ("/scenes/0/nodes/0", beyond),
    ] {
        let mut file = Builder::square();
        if let Some(slot) = file.json.pointer_mut(place) {
            *slot = json!(value);
        } else {
            let (parent, key) = place.rsplit_once('/').unwrap();
            file.json.pointer_mut(parent).unwrap()[key] = json!(value);
        }
        let error = file.error();
        assert!(
            error.contains(&value.to_string()) || error.contains("does not exist"),
            "{place}: {error}"
        );
    }
}

// --- files elsewhere ---

/// A triangle whose buffer is a file with this address.
fn with_buffer(folder: &Path, uri: &str) -> std::path::PathBuf {
    let mut file = Builder::triangle();
    file.json["buffers"] = json!([{ "byteLength": 36, "uri": uri }]);
    let path = folder.join("scene.gltf");
    std::fs::write(&path, file.json.to_string()).unwrap();
    path
}

#[test]
fn files_outside_of_the_scenes_folder_are_refused_unless_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("scene");
    std::fs::create_dir_all(inner.join("parts")).unwrap();
    let data = &Builder::triangle().binary[..];
    let outside = folder.path().join("outside.bin");
    std::fs::write(&outside, data).unwrap();
    std::fs::write(inner.join("parts/inside.bin"), data).unwrap();
    std::os::unix::fs::symlink(&outside, inner.join("link.bin")).unwrap();
    std::os::unix::fs::symlink(folder.path(), inner.join("up")).unwrap();
    std::os::unix::fs::symlink("parts/inside.bin", inner.join("near.bin")).unwrap();

    for uri in [
        "parts/inside.bin",
        "./parts/../parts/inside.bin",
        "near.bin",
    ] {
        let path = with_buffer(&inner, uri);
        import::load(&path, &ImportOptions::default())
            .unwrap_or_else(|error| panic!("{uri}: {error}"));
    }
    let absolute = outside.display().to_string();
    for uri in [
        absolute.as_str(),
        "../outside.bin",
        "%2e%2e/outside.bin",
        "parts/../../outside.bin",
        "link.bin",
        "up/outside.bin",
    ] {
        let path = with_buffer(&inner, uri);
        let error = import::load(&path, &ImportOptions::default()).unwrap_err();
        let error = error.to_string();
        assert!(
            error.contains("buffer 0") && error.contains("--allow-outside"),
            "{uri}: {error}"
        );
        let allowed = ImportOptions {
            allow_outside: true,
            ..ImportOptions::default()
        };
        import::load(&path, &allowed).unwrap_or_else(|error| panic!("{uri}: {error}"));
    }
    // What is not there is not told apart from what is.
    for uri in ["/proc/self/environ", "/proc/self/nothing", "../nothing"] {
        let path = with_buffer(&inner, uri);
        let error = import::load(&path, &ImportOptions::default()).unwrap_err();
        assert!(error.to_string().contains("--allow-outside"), "{error}");
    }
}

#[test]
fn worlds_and_colour_configurations_outside_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("scene");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(folder.path().join("config.ocio"), "").unwrap();
    std::fs::write(
        folder.path().join("world.png"),
        png(image::RgbImage::new(2, 1).into()),
    )
    .unwrap();
    let mut file = Builder::triangle();
    let data = file.binary.clone();
    file.json["buffers"] = json!([{ "byteLength": data.len(), "uri": "data.bin" }]);
    std::fs::write(inner.join("data.bin"), data).unwrap();
    let path = inner.join("scene.gltf");
    let load = |extension: serde_json::Value, allow_outside: bool| {
        let mut file = file.clone();
        file.json["scenes"][0]["extensions"] = json!({ "SUNDOG_scene": extension });
        std::fs::write(&path, file.json.to_string()).unwrap();
        let options = ImportOptions {
            allow_outside,
            ..ImportOptions::default()
        };
        import::load(&path, &options)
    };
    let world = json!({ "world": { "image": "../world.png" } });
    assert!(
        load(world.clone(), false)
            .unwrap_err()
            .to_string()
            .contains("--allow-outside")
    );
    assert!(load(world, true).unwrap().scene.environment.is_some());
    let config = json!({ "color_management": { "config": "../config.ocio" } });
    let imported = load(config.clone(), false).unwrap();
    assert_eq!(imported.scene.color_management.config, None);
    assert_eq!(codes(&imported), ["outside-config"]);
    let imported = load(config, true).unwrap();
    assert!(imported.scene.color_management.config.is_some());
    assert!(codes(&imported).is_empty());
}

// --- images ---

#[test]
fn one_image_under_many_names_is_one_image() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = Builder::square();
    std::fs::write(
        folder.path().join("big.png"),
        png(image::RgbImage::from_pixel(64, 64, image::Rgb([9, 8, 7])).into()),
    )
    .unwrap();
    std::fs::write(folder.path().join("data.bin"), &file.binary).unwrap();
    file.json["buffers"] = json!([{ "byteLength": file.binary.len(), "uri": "data.bin" }]);
    // The same bytes by sixty names, and by views of one place in the buffer.
    for i in 0..60 {
        let image = file.push(
            "images",
            json!({ "uri": format!("{}big.png", "./".repeat(i)) }),
        );
        let texture = file.push("textures", json!({ "source": image }));
        file.push(
            "materials",
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }),
        );
        let mut primitive = file.json["meshes"][0]["primitives"][0].clone();
        primitive["material"] = json!(i + 1);
        file.json["meshes"][0]["primitives"]
            .as_array_mut()
            .unwrap()
            .push(primitive);
    }
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, file.json.to_string()).unwrap();
    let imported = import::load(&path, &ImportOptions::default()).unwrap();
    assert_eq!(imported.scene.images.len(), 1);

    let mut file = Builder::square();
    file.png_texture(image::RgbImage::from_pixel(4, 4, image::Rgb([9, 8, 7])).into());
    let view = file.json["images"][0]["bufferView"].as_u64().unwrap() as usize;
    let same = file.json["bufferViews"][view].clone();
    let again = file.push("bufferViews", same);
    let image = file.push(
        "images",
        json!({ "bufferView": again, "mimeType": "image/png" }),
    );
    let other = file.push("textures", json!({ "source": image }));
    file.json["materials"][0] = json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "emissiveTexture": { "index": other }, "emissiveFactor": [1.0, 1.0, 1.0]
    });
    assert_eq!(file.load().scene.images.len(), 1);
}

#[test]
fn radiance_pictures_may_name_their_program() {
    let mut file = b"#?RGBE\n# written by hand\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    file.extend([128, 64, 32, 129, 128, 64, 32, 130]);
    let image = import::decode_image(&file, "hdr").unwrap();
    let Pixels::F32(values) = &image.pixels else {
        panic!()
    };
    // Mantissa / 256 · 2^(exponent − 128).
    assert_eq!(values[..], [1.0, 0.5, 0.25, 2.0, 1.0, 0.5]);
}

// --- what contradicts the format, and is repaired ---

/// Diagnostics of a file: code and verdict.
fn told(imported: &import::Imported) -> Vec<(&'static str, Verdict)> {
    let list = imported.diagnostics.iter();
    list.map(|d| (d.code, d.verdict)).collect()
}

#[test]
fn a_texture_on_a_mesh_without_its_coordinates_is_told() {
    let mut file = Builder::square();
    let texture = file.png_texture(image::RgbImage::from_pixel(2, 2, image::Rgb([1, 2, 3])).into());
    let textured = |set: u32| json!({ "name": "paint", "pbrMetallicRoughness": { "baseColorTexture": { "index": texture, "texCoord": set } } });
    file.json["materials"][0] = textured(0);
    assert!(told(&file.load()).is_empty());
    file.json["materials"][0] = textured(1);
    let imported = file.load();
    assert_eq!(
        told(&imported),
        [("texture-without-uv", Verdict::Approximated)]
    );
    assert_eq!(
        imported.diagnostics.iter().next().unwrap().to_string(),
        "texture on meshes without texture coordinate set 1 (tri): its texel at (0, 0) is shown everywhere, as viewers of glTF do"
    );
}

#[test]
fn rotations_and_matrices_that_are_none_are_repaired_and_told() {
    let mut file = Builder::triangle();
    file.json["nodes"] = json!([
        { "name": "short", "mesh": 0, "rotation": [0.0, 0.0, 0.5, 0.0] },
        { "name": "none", "mesh": 0, "rotation": [0.0, 0.0, 0.0, 0.0] },
        { "name": "rounded", "mesh": 0, "rotation": [0.0, 0.0, 0.707, 0.707] },
        { "name": "projected", "mesh": 0, "matrix": [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 2] }
    ]);
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let imported = file.load();
    assert_eq!(
        told(&imported),
        [
            ("rotation-length", Verdict::Approximated),
            ("matrix-row", Verdict::Approximated)
        ]
    );
    assert_eq!(
        found(&imported, "rotation-length")[0].objects,
        ["short", "none"]
    );
    let place = |i: usize| imported.scene.instances[i].world_from_object;
    // Half a turn about z, no turn, and a move.
    assert!(place(0).matrix3.x_axis.abs_diff_eq(DVec3::NEG_X, 1e-15));
    assert_eq!(place(1), DAffine3::IDENTITY);
    assert_eq!(
        place(3),
        DAffine3::from_translation(DVec3::new(3.0, 0.0, 0.0))
    );
}

#[test]
fn cones_of_spots_turned_inside_out_are_told() {
    let mut file = Builder::triangle();
    let spot = |inner: f64, outer: f64| json!({ "type": "spot", "spot": { "innerConeAngle": inner, "outerConeAngle": outer } });
    // The last one is a half-space by f32.
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        spot(0.6, 0.5), spot(0.0, 3.0), spot(0.5, 0.5), spot(1.570_796_37, 1.570_796_37)
    ] } });
    let nodes = (0..4).map(|i| {
        json!({ "name": format!("spot {i}"), "extensions": { "KHR_lights_punctual": { "light": i } } })
    });
    file.json["nodes"] = json!(nodes.collect::<Vec<_>>());
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let imported = file.load();
    assert_eq!(
        found(&imported, "spot-cone")[0].objects,
        ["spot 0", "spot 1"]
    );
    let LightKind::Spot {
        half_angle, blend, ..
    } = imported.scene.lights[0].kind
    else {
        panic!()
    };
    assert_eq!((half_angle, blend), (0.5, 0.0));
}

#[test]
fn vertex_colours_do_not_make_light() {
    let colored = |factor: [f64; 3], generator: &str, unlit: bool| {
        let mut file = Builder::square();
        let colors = file.floats("VEC3", &[1.5, 0.5, 1.0].repeat(4));
        file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        file.json["asset"]["generator"] = json!(generator);
        let mut base = factor.to_vec();
        base.push(1.0);
        file.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorFactor": base });
        if unlit {
            file.json["materials"][0]["extensions"] = json!({ "KHR_materials_unlit": {} });
        }
        let imported = file.load();
        let color = imported.scene.meshes[0].colors.as_ref().unwrap()[0];
        (color, codes(&imported))
    };
    let told = vec!["bright-vertex-colours"];
    assert_eq!(
        colored([1.0; 3], "x", false),
        ([1.0, 0.5, 1.0, 1.0], told.clone())
    );
    // What becomes less than white with its material stays.
    assert_eq!(
        colored([0.5; 3], "x", false),
        ([1.5, 0.5, 1.0, 1.0], vec![])
    );
    assert_eq!(
        colored([0.8, 1.0, 1.0], "x", false),
        ([1.25, 0.5, 1.0, 1.0], told)
    );
    // Cycles shows what is brighter, and so does what is unlit.
    let addon = "Sundog add-on for Blender 5.2.3";
    assert_eq!(colored([1.0; 3], addon, false).0[0], 1.5);
    assert_eq!(colored([1.0; 3], "x", true).0[0], 1.5);
}

#[test]
fn weights_of_skins_that_do_not_sum_to_1_are_told() {
    let skinned = |weights: [f32; 4]| {
        let mut file = Builder::triangle();
        let joints = file.accessor("VEC4", UNSIGNED_BYTE, false, 3, &[0; 12]);
        let weights = file.floats("VEC4", &weights.repeat(3));
        let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
        attributes["JOINTS_0"] = json!(joints);
        attributes["WEIGHTS_0"] = json!(weights);
        file.json["skins"] = json!([{ "joints": [1] }]);
        file.json["nodes"] = json!([{ "mesh": 0, "skin": 0 }, { "translation": [0, 2, 0] }]);
        file.json["scenes"][0]["nodes"] = json!([0, 1]);
        let imported = file.load();
        let place = imported.scene.instances[0].world_from_object;
        let corner = imported.scene.meshes[0].positions[1].map(f64::from);
        assert_eq!(
            place.transform_point3(corner.into()),
            DVec3::new(1.0, 2.0, 0.0)
        );
        found(&imported, "skin-weights")
            .iter()
            .map(|d| d.feature.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(skinned([1.0, 0.0, 0.0, 0.0]), [""; 0]);
    assert_eq!(skinned([0.249, 0.25, 0.25, 0.25]), [""; 0], "rounding");
    assert_eq!(
        skinned([0.5, 0.0, 0.0, 0.0]),
        ["weights of a skin that do not sum to 1"]
    );
    assert_eq!(skinned([0.0; 4]), ["vertices of a skin without weights"]);
}

// --- flat and tiny objects ---

#[test]
fn what_is_pressed_flat_keeps_its_area() {
    let mut file = Builder::square();
    let turn = [0.0, 0.0, (0.5f64).sqrt(), (0.5f64).sqrt()];
    file.json["nodes"] = json!([
        { "name": "plane", "mesh": 0, "scale": [2.0, 3.0, 0.0], "rotation": turn, "translation": [5.0, 0.0, 1e6] },
        { "name": "again", "mesh": 0, "scale": [2.0, 3.0, 0.0], "rotation": turn },
        { "name": "mirrored", "mesh": 0, "scale": [-1.0, 1.0, 0.0] },
        { "name": "line", "mesh": 0, "scale": [1.0, 0.0, 1.0] },
        { "name": "point", "mesh": 0, "scale": [0.0, 0.0, 0.0] }
    ]);
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
    let imported = file.load();
    let names: Vec<_> = imported
        .scene
        .instances
        .iter()
        .map(|i| i.name.as_str())
        .collect();
    assert_eq!(names, ["plane", "again", "mirrored"]);
    assert_eq!(
        found(&imported, "singular-transform")[0].objects,
        ["line", "point"]
    );
    // The same shape is one mesh.
    assert_eq!(
        imported.scene.instances[0].mesh,
        imported.scene.instances[1].mesh
    );
    for (number, normal, area) in [(0, 1.0, 6.0), (2, -1.0, 1.0)] {
        let instance = &imported.scene.instances[number];
        let mesh = &imported.scene.meshes[instance.mesh.0 as usize];
        assert!(mesh.normals.is_none(), "those of the plane");
        let sum: DVec3 = mesh
            .triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|i| {
                    let corner = mesh.positions[i as usize].map(f64::from);
                    instance.world_from_object.transform_point3(corner.into())
                });
                (b - a).cross(c - a) / 2.0
            })
            .sum();
        assert!(
            sum.abs_diff_eq(DVec3::new(0.0, 0.0, normal * area), 1e-5),
            "{sum}"
        );
    }
}

#[test]
fn a_cube_pressed_flat_has_no_slivers() {
    // By an angle at which nothing is exact.
    let mut file = Builder::empty();
    let corners: Vec<f32> = (0..8)
        .flat_map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| b as f32))
        .collect();
    let positions = file.floats("VEC3", &corners);
    let quads = [
        [0, 1, 3, 2],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 3, 7, 5],
    ];
    let indices: Vec<u8> = quads
        .iter()
        .flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d])
        .collect();
    let indices = file.accessor("SCALAR", UNSIGNED_BYTE, false, 36, &indices);
    file.json["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": positions }, "indices": indices }] }]);
    let half = 0.3f64;
    let axis = [0.48f64, 0.6, 0.64].map(|c| c * half.sin());
    file.json["nodes"] = json!([{ "mesh": 0, "scale": [1, 1, 0], "rotation": [axis[0], axis[1], axis[2], half.cos()] }]);
    file.json["scenes"] = json!([{ "nodes": [0] }]);
    let imported = file.load();
    let mesh = &imported.scene.meshes[imported.scene.instances[0].mesh.0 as usize];
    assert_eq!(mesh.triangles.len(), 4);
}

#[test]
fn what_is_too_small_for_f32_is_told() {
    let mut file = Builder::triangle();
    file.json["nodes"] = json!([{ "name": "speck", "mesh": 0, "scale": [1e-19, 1e-19, 1e-19] },
        { "name": "bulb", "extensions": { "KHR_lights_punctual": { "light": 0 } } }]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "point", "extensions": { "SUNDOG_light": { "radius": 1e-21, "strength": [1, 1, 1] } } }
    ] } });
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    let imported = file.load();
    assert_eq!(found(&imported, "too-small")[0].objects, ["speck"]);
    assert_eq!(found(&imported, "tiny-lamp")[0].objects, ["bulb"]);
    assert!(matches!(
        imported.scene.lights[0].kind,
        LightKind::Point { radius: 0.0, .. }
    ));
}

// --- many ---

#[test]
fn many_nodes_and_features_are_read_one_by_one() {
    let mut file = Builder::triangle();
    // A chain, at whose end the mesh hangs: deeper than any stack of calls.
    let depth = 20_000;
    let nodes: Vec<_> = (0..depth)
        .map(|i| match i + 1 {
            next if next < depth => {
                json!({ "children": [next], "extensions": { format!("EXT_{i}"): {} } })
            }
            _ => json!({ "mesh": 0 }),
        })
        .collect();
    file.json["nodes"] = json!(nodes);
    let imported = file.load();
    assert_eq!(imported.scene.instances.len(), 1);
    assert_eq!(found(&imported, "unknown-extension").len(), depth - 1);
}
