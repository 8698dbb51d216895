//! Extensions that few files have: lamps by photometric files, light by the faces of a cube, animations of anything, points
//! and lines, and what changes no picture.

use super::kit::{Builder, UNSIGNED_BYTE, codes, found, load_bytes, place, png};
use serde_json::{Value, json};
use sundog::effects::{Effect, EffectReport};
use sundog::import::{AnimationTime, ImportOptions, Imported, load};
use sundog::render::{RenderSettings, Silent, render};
use sundog::scene::{LightKind, Projection, Scene, StrandShape, Verdict};
use sundog::selftest::kit::{camera, colors, diffuse, quad};

fn posed(file: &Builder, seconds: f64) -> Imported {
    let options = ImportOptions {
        animation: Some(AnimationTime {
            name: None,
            seconds,
            frame: None,
        }),
        ..ImportOptions::default()
    };
    file.load_with(&options).unwrap()
}

/// Gives a file an animation of channels (pointer, kind of accessor, interpolation, values at 0 s and at 2 s).
fn animate(file: &mut Builder, channels: &[(&str, &str, &str, &[f32])]) {
    let times = file.floats("SCALAR", &[0.0, 2.0]);
    let (mut targets, mut samplers) = (Vec::new(), Vec::new());
    for (number, (pointer, kind, interpolation, values)) in channels.iter().enumerate() {
        let output = file.floats(kind, values);
        samplers.push(json!({ "input": times, "output": output, "interpolation": interpolation }));
        targets.push(json!({ "sampler": number, "target": {
            "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } } }));
    }
    file.json["animations"] = json!([{ "channels": targets, "samplers": samplers }]);
    file.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    file.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
}

#[test]
fn pointers_move_materials_lamps_cameras_and_textures() {
    let mut file = Builder::square();
    let texture = file.png_texture(
        image::RgbImage::from_fn(2, 2, |x, _| image::Rgb([80 * x as u8, 0, 0])).into(),
    );
    file.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorTexture": {
        "index": texture, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } } });
    file.json["extensions"]["KHR_lights_punctual"]["lights"] =
        json!([{ "type": "point", "intensity": 1 }]);
    file.json["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]);
    let lamp = json!({ "camera": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    file.push("nodes", lamp);
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    let base = "/materials/0/pbrMetallicRoughness";
    let offset = format!("{base}/baseColorTexture/extensions/KHR_texture_transform/offset");
    let color = format!("{base}/baseColorFactor");
    animate(
        &mut file,
        &[
            (
                &color,
                "VEC4",
                "LINEAR",
                &[0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 1.0],
            ),
            (&offset, "VEC2", "LINEAR", &[0.0, 0.0, 1.0, 0.5]),
            (
                &format!("{base}/roughnessFactor"),
                "SCALAR",
                "STEP",
                &[0.25, 0.75],
            ),
            (
                "/extensions/KHR_lights_punctual/lights/0/intensity",
                "SCALAR",
                "LINEAR",
                &[2.0, 6.0],
            ),
            (
                "/cameras/0/perspective/yfov",
                "SCALAR",
                "LINEAR",
                &[0.5, 1.5],
            ),
            (
                "/nodes/1/translation",
                "VEC3",
                "LINEAR",
                &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0],
            ),
        ],
    );
    let imported = posed(&file, 1.0);
    assert!(found(&imported, "animation-channel").is_empty());
    let m = super::kit::standard(&imported.scene.materials[0]);
    assert_eq!((m.base_color, m.roughness), ([0.5, 0.25, 0.0], 0.25));
    let texture = m.base_color_texture.unwrap();
    assert_eq!(texture.transform.offset, [0.5, 0.25]);
    assert_eq!(texture.transform.scale, [2.0, 2.0]);
    let light = &imported.scene.lights[0];
    assert!(matches!(light.kind, LightKind::Point { intensity, .. } if intensity == 4.0));
    assert_eq!(light.world_from_light.translation.x, 2.0);
    let Projection::Perspective { vertical_fov, .. } = imported.scene.cameras[0].projection else {
        panic!("a perspective camera");
    };
    assert!((vertical_fov - 1.0).abs() < 1e-6);
}

#[test]
fn pointers_hide_nodes_and_stop_at_what_is_not_there() {
    let mut file = Builder::square();
    file.json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": {} });
    let visible = "/nodes/0/extensions/KHR_node_visibility/visible";
    animate(
        &mut file,
        &[
            (visible, "SCALAR", "STEP", &[1.0, 0.0]),
            ("/materials/7/emissiveFactor", "VEC3", "STEP", &[1.0; 6]),
            ("/accessors/0/count", "SCALAR", "STEP", &[1.0, 2.0]),
        ],
    );
    let shown = posed(&file, 0.0);
    assert_eq!(shown.scene.instances.len(), 1);
    assert_eq!(found(&shown, "animation-channel").len(), 2);
    assert!(posed(&file, 2.0).scene.instances.is_empty());
    // What cannot be is told, and the file is as it was.
    animate(
        &mut file,
        &[("/nodes/0/mesh", "SCALAR", "STEP", &[0.5, 0.5])],
    );
    let imported = posed(&file, 1.0);
    assert_eq!(imported.scene.instances.len(), 1);
    assert_eq!(found(&imported, "animation-channel").len(), 1);
}

/// A floor below the origin at a distance, seen from between.
fn floor_below(distance: f32) -> Scene {
    let mut scene = Scene {
        cameras: vec![camera(glam::DVec3::ZERO, 0.02)],
        ..Scene::default()
    };
    let white = diffuse([1.0; 3]);
    // The camera and the lamp look along −Z.
    let floor = quad([-9.0, -9.0, -distance], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    sundog::selftest::kit::place(&mut scene, floor, white, &[glam::DAffine3::IDENTITY]);
    scene
}

const PROFILE: &str =
    "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 40\n0 45 90\n0\n1366 683 0\n";

#[test]
fn a_lamp_by_its_profile_lights_a_floor_as_its_candela_say() {
    let mut file = Builder::empty();
    let view = file.view(PROFILE.as_bytes());
    file.json["extensions"]["EXT_lights_ies"]["lights"] =
        json!([{ "bufferView": view, "mimeType": "application/x-ies-lm-63" }]);
    file.json["nodes"] = json!([{ "name": "lamp", "extensions": { "EXT_lights_ies":
        { "light": 0, "multiplier": 3.0, "color": [1.0, 0.5, 0.25] } } }]);
    file.json["scenes"] = json!([{ "nodes": [0] }]);
    let imported = file.load();
    assert_eq!(codes(&imported), ["light-ies"]);
    let mut scene = floor_below(2.0);
    scene.lights = imported.scene.lights;
    let settings = RenderSettings {
        width: 4,
        height: 4,
        samples: 64,
        bounces: 0,
        threads: Some(2),
        ..RenderSettings::default()
    };
    let picture = render(&scene, &settings, &Silent).unwrap().picture;
    // 1366 · 3 / 683 W/sr at 2 m on a white floor: 6/4 W/m², over π.
    let expected = [1.0, 0.5, 0.25].map(|c| c * 1.5 / std::f64::consts::PI);
    for pixel in colors(&picture) {
        for (found, expected) in pixel.iter().zip(expected) {
            // Pixels are within 0.01 radians of the axis, where the curve through the values is flat to its square.
            assert!(
                (found / expected - 1.0).abs() < 2e-3,
                "{found} for {expected}"
            );
        }
    }
}

#[test]
fn profiles_that_cannot_be_read_are_told() {
    let mut file = Builder::triangle();
    file.json["extensions"]["EXT_lights_ies"]["lights"] =
        json!([{ "uri": "data:application/x-ies-lm-63,TILT=NONE" }, { "uri": "none.ies" }]);
    for light in 0..2 {
        file.json["nodes"][0]["extensions"] = json!({ "EXT_lights_ies": { "light": light } });
        let imported = file.load();
        assert!(imported.scene.lights.is_empty());
        assert_eq!(found(&imported, "light-ies")[0].verdict, Verdict::Lost);
    }
    file.json["nodes"][0]["extensions"] = json!({ "EXT_lights_ies": { "light": 2 } });
    assert!(file.error().contains("light profile 2"));
}

#[test]
fn the_faces_of_a_cube_light_the_scene() {
    let mut file = Builder::triangle();
    let face = |code: u8| png(image::RgbImage::from_pixel(4, 4, image::Rgb([code; 3])).into());
    let faces: Vec<usize> = [255u8, 0, 0, 0, 188, 0]
        .into_iter()
        .map(|code| {
            let view = file.view(&face(code));
            file.push(
                "images",
                json!({ "bufferView": view, "mimeType": "image/png" }),
            )
        })
        .collect();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    file.json["extensions"]["EXT_lights_image_based"]["lights"] = json!([{
        "intensity": 2.0, "specularImageSize": 4, "specularImages": [faces],
        "irradianceCoefficients": [[1, 1, 1]], "rotation": [0.0, half, 0.0, half] }]);
    file.json["scenes"][0]["extensions"] = json!({ "EXT_lights_image_based": { "light": 0 } });
    let imported = file.load();
    assert_eq!(codes(&imported), ["image-based-light"]);
    let look = |imported: &Imported, direction: glam::DVec3| {
        let turn = glam::DQuat::from_rotation_arc(-glam::DVec3::Z, direction);
        let mut seen = camera(glam::DVec3::splat(50.0), 0.01);
        seen.world_from_camera.matrix3 = glam::DMat3::from_quat(turn);
        let scene = Scene {
            cameras: vec![seen],
            ..imported.scene.clone()
        };
        let settings = RenderSettings {
            width: 1,
            height: 1,
            samples: 4,
            threads: Some(1),
            ..RenderSettings::default()
        };
        let picture = render(&scene, &settings, &Silent).unwrap().picture;
        colors(&picture).next().unwrap()[0]
    };
    // A quarter about Y takes +X to −Z, and +Z to +X. 188 is 0.503 of light.
    let at = |direction| look(&imported, direction);
    assert!((at(-glam::DVec3::Z) - 2.0).abs() < 1e-5);
    assert!((at(glam::DVec3::X) - 1.0056).abs() < 1e-3);
    assert!(at(-glam::DVec3::X).abs() < 1e-6);
    // Without its images the mean is left.
    file.json["images"][faces[3]] = json!({ "uri": "none.png" });
    let imported = file.load();
    assert_eq!(
        found(&imported, "image-based-light")[0].verdict,
        Verdict::Lost
    );
    let mean = 2.0 * 0.5 / f64::from(std::f32::consts::PI).sqrt();
    assert!((look(&imported, glam::DVec3::Y) - mean).abs() < 1e-4);
}

#[test]
fn points_and_lines_have_a_size_by_that_of_the_scene() {
    let mut file = Builder::triangle();
    let colors = file.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["COLOR_0"] = json!(colors);
    file.json["nodes"][0]["scale"] = json!([10, 10, 10]);
    for (mode, triangles) in [(0, 3 * 80), (1, 28), (2, 3 * 28), (3, 2 * 28)] {
        file.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let imported = file.load();
        let (scene, told) = (&imported.scene, found(&imported, "not-triangles"));
        assert_eq!(scene.meshes[0].triangles.len(), triangles);
        assert_eq!((told.len(), told[0].verdict), (1, Verdict::Approximated));
        // The mesh is √2 across: a point is a 400th of that, a line an 800th.
        let low = scene.meshes[0]
            .positions
            .iter()
            .map(|p| p[2])
            .fold(0.0, f32::min);
        let radius = 2f32.sqrt() / if mode == 0 { 800.0 } else { 1600.0 };
        assert!((-low / radius - 1.0).abs() < 1e-4, "{low} for {radius}");
        // They show their colour without any light.
        assert!(scene.materials[0].graph.is_unlit());
        assert_eq!(scene.meshes[0].material.map(|id| id.0), Some(0));
    }
    // With normals they are lit.
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let imported = file.load();
    assert_eq!(imported.scene.meshes[0].material, None);
}

/// Five vertices: a curve of three, and one of two.
fn strands(shape: &str) -> Builder {
    let mut file = Builder::triangle();
    let places: Vec<f32> = (0..5).flat_map(|i| [i as f32, 0.0, 0.5]).collect();
    let positions = file.floats("VEC3", &places);
    let radii = file.floats("SCALAR", &[0.2, 0.1, 0.0, f32::NAN, 0.3]);
    let points = shape == "points";
    let indices: &[u8] = if points { &[4, 0] } else { &[0, 1, 1, 2, 3, 4] };
    let indices = file.accessor("SCALAR", UNSIGNED_BYTE, false, indices.len(), indices);
    file.json["meshes"][0]["primitives"][0] = json!({
        "mode": if points { 0 } else { 1 },
        "attributes": { "POSITION": positions, "_RADIUS": radii },
        "indices": indices,
        "extensions": { "SUNDOG_mesh": { "strands": { "shape": shape, "radius": "_RADIUS", "steps": 3 } } }
    });
    file
}

#[test]
fn lines_and_points_with_a_radius_are_strands() {
    for (name, shape) in [
        ("ribbon", StrandShape::Ribbon(3)),
        ("round", StrandShape::Round),
        ("round-linear", StrandShape::RoundLinear),
    ] {
        let imported = strands(name).load();
        let mesh = &imported.scene.meshes[0];
        let found = mesh.strands.as_ref().unwrap();
        assert_eq!(found.shape, shape);
        // What is no radius is none; the segments are corners that go there and back.
        assert_eq!(found.radii, [0.2, 0.1, 0.0, 0.0, 0.3]);
        assert_eq!(mesh.triangles, [[0, 1, 0], [1, 2, 1], [3, 4, 3]]);
        // They are lit, and no size is made up for them.
        assert!(codes(&imported).is_empty(), "{:?}", codes(&imported));
        assert_eq!(mesh.material, None);
        let called_for = EffectReport::detect(&imported.scene).called_for;
        assert!(called_for.contains(Effect::Strands));
    }
    let mut file = strands("round");
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(5));
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let mesh = file.load().scene.meshes.remove(0);
    assert_eq!(mesh.strands.unwrap().normals, [[0.0, 0.0, 1.0]; 5]);
    assert_eq!(mesh.normals, None);
    let imported = strands("points").load();
    let mesh = &imported.scene.meshes[0];
    let found = mesh.strands.as_ref().unwrap();
    assert_eq!(found.shape, StrandShape::Points);
    assert_eq!(mesh.triangles, [[4; 3], [0; 3]]);
}

#[test]
fn broken_strands_are_refused_in_a_sentence() {
    let broken = |change: &dyn Fn(&mut Value)| {
        let mut file = strands("ribbon");
        change(&mut file.json["meshes"][0]["primitives"][0]);
        file.error()
    };
    let shape = |shape: &'static str| {
        move |p: &mut Value| {
            p["extensions"]["SUNDOG_mesh"]["strands"]["shape"] = json!(shape);
        }
    };
    assert!(broken(&shape("points")).contains("shape of points"));
    assert!(broken(&shape("wires")).contains("SUNDOG_mesh cannot be read"));
    let none = broken(&|p| p["extensions"]["SUNDOG_mesh"]["strands"]["radius"] = json!("_R"));
    assert!(none.contains("strands have no radius"), "{none}");
    let triangles = broken(&|p| p["mode"] = json!(4));
    assert!(triangles.contains("drawn as triangles"), "{triangles}");
    let other = broken(&|p| p["attributes"]["_RADIUS"] = json!(0));
    assert!(other.contains("mesh \"tri\""), "{other}");
}

#[test]
fn what_changes_no_picture_may_be_demanded() {
    let mut file = Builder::triangle();
    for name in ["KHR_physics_rigid_bodies", "EXT_mesh_features", "OMI_seat"] {
        file.json["extensionsRequired"] = json!([name]);
        file.json["nodes"][0]["extensions"] = json!({ name: {} });
        let imported = file.load();
        assert_eq!(codes(&imported), ["metadata"]);
        assert_eq!(found(&imported, "metadata")[0].verdict, Verdict::Exact);
    }
    file.json["extensionsRequired"] = json!(["KHR_texture_procedurals"]);
    assert!(file.error().contains("KHR_texture_procedurals"));
}

#[test]
fn images_of_kinds_that_are_not_read_may_be_demanded() {
    let mut file = Builder::square();
    let avif = file.view(b"\0\0\0\x1cftypavif\0\0\0\0avifmif1");
    file.json["images"] = json!([{ "bufferView": avif, "mimeType": "image/avif" }]);
    file.json["textures"] = json!([{ "extensions": { "EXT_texture_avif": { "source": 0 } } }]);
    file.json["materials"][0]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": 0 } });
    file.json["extensionsRequired"] = json!(["EXT_texture_avif"]);
    let imported = file.load();
    assert_eq!(codes(&imported), ["texture-kind"]);
    assert_eq!(found(&imported, "texture-kind")[0].verdict, Verdict::Lost);
}

#[test]
fn a_file_in_another_case_is_hinted_at() {
    let (folder, path) = place("scene.gltf");
    std::fs::write(folder.path().join("Mesh.BIN"), [0u8; 4]).unwrap();
    let scene = |uri: &str| -> Value {
        json!({ "asset": { "version": "2.0" }, "buffers": [{ "uri": uri, "byteLength": 4 }] })
    };
    let error = |uri: &str| {
        std::fs::write(&path, scene(uri).to_string()).unwrap();
        load(&path, &ImportOptions::default())
            .unwrap_err()
            .to_string()
    };
    assert!(error("mesh.bin").contains("there is \"Mesh.BIN\""));
    assert!(!error("other.bin").contains("there is \""));
    std::fs::write(
        folder.path().join("other.bin"),
        "version https://git-lfs.github.com/spec/v1\noid sha256:0\n",
    )
    .unwrap();
    assert!(error("other.bin").contains("git lfs pull"));
}

#[test]
fn what_is_no_scene_is_named() {
    let told = |bytes: &[u8]| {
        load_bytes(bytes, &ImportOptions::default())
            .unwrap_err()
            .to_string()
    };
    assert!(told(b"<!DOCTYPE html><title>404</title>").contains("web page"));
    assert!(told(b"version https://git-lfs.github.com/spec/v1").contains("git lfs pull"));
    let mut file = Builder::square();
    file.json["nodes"][0]["translation"] = json!([1, 2]);
    let told = file.error();
    let words = "nodes[0] of \"node\": there is a list of 2 where a list of 3 belongs";
    assert!(told.contains(words), "{told}");
    let mut file = Builder::square();
    file.json["materials"][0]["pbrMetallicRoughness"] = json!({ "roughnessFactor": "rough" });
    let told = file.error();
    assert!(
        told.contains("the text \"rough\" where a number belongs"),
        "{told}"
    );
    assert!(told.contains("\"paint\""), "{told}");
}

#[test]
fn corners_that_do_not_exist_are_told() {
    let mut file = Builder::triangle();
    let indices = file.accessor("SCALAR", super::kit::UNSIGNED_BYTE, false, 3, &[0, 1, 9]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let imported = file.load();
    assert_eq!(found(&imported, "empty-mesh")[0].verdict, Verdict::Lost);
}

/// Khronos' TextureLinearInterpolationTest: between black and white lies half of the light, except where the file is made of
/// what Cycles renders, which interpolates the codes.
#[test]
fn between_texels_light_is_mixed_as_the_file_has_it() {
    let mut file = Builder::square();
    let texture = file
        .png_texture(image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([255 * x as u8; 3])).into());
    file.json["materials"][0] = json!({
        "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } });
    let middle = |file: &Builder| {
        let mut scene = file.load().scene;
        let mut seen = camera(glam::DVec3::new(0.5, 0.5, 1.0), 1e-3);
        seen.clip_near = 0.0;
        scene.cameras = vec![seen];
        let settings = RenderSettings {
            width: 1,
            height: 1,
            samples: 4,
            threads: Some(1),
            ..RenderSettings::default()
        };
        let picture = render(&scene, &settings, &Silent).unwrap().picture;
        colors(&picture).next().unwrap()[1]
    };
    // A thousandth of the square is a five-hundredth of the way between the texels.
    let other = middle(&file);
    assert!((other - 0.5).abs() < 4e-3, "{other}");
    file.json["asset"]["generator"] = json!(super::kit::BLENDER_4_5);
    let blender = middle(&file);
    assert!((blender - 0.214).abs() < 4e-3, "{blender}");
}

/// Blender's exporter writes powers of lamps as numbers, if it is told to ("Raw"), for which suns of a few lux stand beside lamps of
/// a hundred candela.
#[test]
fn a_sun_weaker_than_dusk_says_that_numbers_are_no_lux() {
    let mut file = Builder::triangle();
    file.json["asset"]["generator"] = json!("Khronos glTF Blender I/O v5.2.41");
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([
        { "type": "directional", "intensity": 3 }, { "type": "point", "intensity": 100 }]);
    for light in 0..2 {
        let lamp = json!({ "extensions": { "KHR_lights_punctual": { "light": light } } });
        file.push("nodes", lamp);
    }
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let imported = file.load();
    assert!(
        matches!(imported.scene.lights[0].kind, LightKind::Sun { irradiance, .. } if irradiance == 3.0)
    );
    assert_eq!(
        found(&imported, "light-units")[0].verdict,
        Verdict::Approximated
    );
    // As the exporter writes it by default, the same scene is read in lux.
    let lights = &mut file.json["extensions"]["KHR_lights_punctual"]["lights"];
    (lights[0]["intensity"], lights[1]["intensity"]) = (json!(2049), json!(5435.141));
    let imported = file.load();
    assert!(
        matches!(imported.scene.lights[0].kind, LightKind::Sun { irradiance, .. } if irradiance == 3.0)
    );
}
