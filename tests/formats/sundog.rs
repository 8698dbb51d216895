//! Sundog's own extensions: lights, worlds, objects.

use super::kit::*;
use ::sundog::import::ImportOptions;
use ::sundog::math::primaries::WorkingSpace;
use ::sundog::scene::{AreaShape, Light, LightKind, RayKind, Visibility};
use base64::Engine as _;
use serde_json::json;

/// A file with one node that a light stands on.
fn with_light(light: serde_json::Value) -> Builder {
    let mut file = Builder::triangle();
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    file.json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    file
}

#[test]
fn strength_wins_over_colour_intensity_and_units() {
    let file = with_light(json!({
        "type": "spot", "color": [1, 0, 0], "intensity": 683.0, "spot": { "outerConeAngle": 0.5 },
        "extensions": { "SUNDOG_light": {
            "strength": [2, 4, 1], "radius": 0.5, "soft_falloff": true, "half_angle": 1.25, "blend": 0.75,
            "visibility": { "camera": false, "shadow": false, "glossy": true }, "max_bounces": 3, "mis": false
        } }
    }));
    let imported = file.load();
    assert!(imported.diagnostics.is_empty(), "{:?}", codes(&imported));
    let light = &imported.scene.lights[0];
    assert_eq!(light.color, [0.5, 1.0, 0.25]);
    assert_eq!(
        light.kind,
        LightKind::Spot {
            intensity: 4.0,
            radius: 0.5,
            soft_falloff: true,
            half_angle: 1.25,
            blend: 0.75
        }
    );
    assert_eq!(
        light.visibility,
        Visibility::ALL
            .without(RayKind::Camera)
            .without(RayKind::Shadow)
    );
    assert_eq!(light.max_bounces, 3);
    let plain = with_light(json!({ "type": "point" })).load();
    let light = &plain.scene.lights[0];
    assert_eq!(
        (light.visibility, light.max_bounces),
        (Visibility::ALL, Light::MAX_BOUNCES)
    );
}

/// Blender's lamps may have less than nothing to give; those of glTF itself may not.
#[test]
fn negative_lights_are_for_blender() {
    let taking = with_light(
        json!({ "type": "point", "extensions": { "SUNDOG_light": { "strength": [-2, 0, 1] } } }),
    );
    let light = &taking.load().scene.lights[0];
    assert_eq!(
        (light.color, light.kind.strength()),
        ([-1.0, 0.0, 0.5], 2.0)
    );
    for wrong in [
        json!({ "type": "point", "intensity": -1 }),
        json!({ "type": "point", "color": [1, -1, 1] }),
    ] {
        let imported = with_light(wrong).load();
        assert!(imported.scene.lights.is_empty());
        assert_eq!(codes(&imported), ["bad-light"]);
    }
}

#[test]
fn area_lights_stand_on_nodes() {
    let mut file = Builder::triangle();
    file.json["nodes"] = json!([
        { "name": "node", "mesh": 0 },
        { "name": "lamp", "scale": [2, 1, -1], "extensions": { "SUNDOG_light": {
            "type": "area", "shape": "ellipse", "size": [0.5, 2], "power": 10, "strength": [1, 0.5, 0], "spread": 1.5,
            "normalize": false } } },
        { "name": "plain", "extensions": { "SUNDOG_light": { "type": "area" } } },
        { "name": "round", "extensions": { "SUNDOG_light": { "type": "area", "shape": "torus" } } },
        { "name": "beam", "extensions": { "SUNDOG_light": { "type": "laser" } } },
        { "name": "negative", "extensions": { "SUNDOG_light": { "type": "area", "size": [-1, 1] } } },
        { "name": "flat", "scale": [0, 1, 1], "extensions": { "SUNDOG_light": { "type": "area", "power": 1 } } },
        { "name": "huge", "scale": [1e15, 1, 1], "extensions": { "SUNDOG_light": { "type": "area", "size": [1e9, 1] } } }
    ]);
    file.json["scenes"] = json!([{ "nodes": [0, 1, 2, 3, 4, 5, 6, 7] }]);
    let imported = file.load();
    assert_eq!(
        codes(&imported),
        [
            "light-shape",
            "light-kind",
            "bad-light",
            "flat-light",
            "out-of-reach"
        ]
    );
    let [lamp, plain] = &imported.scene.lights[..] else {
        panic!("{:?}", imported.scene.lights)
    };
    assert_eq!(
        lamp.kind,
        LightKind::Area {
            shape: AreaShape::Ellipse,
            size: [0.5, 2.0],
            power: 10.0,
            normalize: false,
            spread: 1.5
        }
    );
    assert_eq!(lamp.color, [1.0, 0.5, 0.0]);
    assert_eq!(
        plain.kind,
        LightKind::Area {
            shape: AreaShape::Rectangle,
            size: [1.0; 2],
            power: 0.0,
            normalize: true,
            spread: std::f32::consts::PI
        }
    );
}

/// A Radiance picture of 4 × 2 pixels, all (1, ½, ¼).
fn picture() -> String {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    for _ in 0..8 {
        bytes.extend([128, 64, 32, 129]);
    }
    let code = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!("data:application/octet-stream;base64,{code}")
}

#[test]
fn the_world_is_a_colour_or_a_turned_image() {
    let mut file = Builder::triangle();
    let mut world = |value: serde_json::Value| {
        file.json["scenes"][0]["extensions"] = json!({ "SUNDOG_scene": { "world": value } });
        file.load()
    };
    let imported = world(json!({ "color": [0.5, 1, 2], "visibility": { "camera": false } }));
    assert!(imported.diagnostics.is_empty());
    let environment = imported.scene.environment.unwrap();
    assert_eq!(environment.radiance, [0.5, 1.0, 2.0]);
    assert!(environment.image.is_none() && !environment.visibility.sees(RayKind::Camera));

    let imported = world(json!({ "image": picture(), "rotation": [0, -1, 0, 1, 0, 0, 0, 0, 1] }));
    assert!(imported.diagnostics.is_empty(), "{:?}", codes(&imported));
    let environment = imported.scene.environment.unwrap();
    assert_eq!(environment.radiance, [1.0; 3]);
    let image = &imported.scene.images[environment.image.unwrap().0 as usize];
    assert_eq!((image.width, image.height), (4, 2));
    // By rows: X becomes Y.
    assert_eq!(environment.rotation * glam::DVec3::X, glam::DVec3::Y);

    assert!(
        world(json!({}))
            .scene
            .environment
            .is_none_or(|e| e.radiance == [0.0; 3])
    );
    let imported = world(json!({ "rotation": [2, 0, 0, 0, 1, 0, 0, 0, 1], "fog": 1 }));
    assert_eq!(codes(&imported), ["unknown-property", "world-rotation"]);
}

#[test]
fn colours_are_numbers_of_the_working_space() {
    let mut file = Builder::triangle();
    let mut scene = |space: serde_json::Value, color: serde_json::Value| {
        file.json["scenes"][0]["extensions"] = json!({ "SUNDOG_scene": {
            "working_space": space, "world": { "color": color, "image": picture() } } });
        file.load()
    };
    let mut imported = scene(json!("ACEScg"), json!([0.5, 1, 2]));
    assert!(imported.diagnostics.is_empty(), "{:?}", codes(&imported));
    let space = imported.scene.color_management.working_space;
    assert_eq!(space, WorkingSpace::AcesCg);
    // Factors and floats of the file stay as they are.
    let environment = imported.scene.environment.clone().unwrap();
    assert_eq!(environment.radiance, [0.5, 1.0, 2.0]);
    let first = |scene: &::sundog::scene::Scene, id: u32| {
        scene.images[id as usize].texels().next().unwrap()
    };
    let texel = first(&imported.scene, environment.image.unwrap().0);
    assert_eq!(texel.truncate(), glam::Vec3::new(1.0, 0.5, 0.25));
    // What stands outside of it is linear Rec.709.
    let folder = tempfile::tempdir().unwrap();
    let sky = folder.path().join("sky.hdr");
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".to_vec();
    bytes.extend([128, 64, 32, 129]);
    std::fs::write(&sky, bytes).unwrap();
    ::sundog::import::load_environment(&mut imported.scene, &sky, 1.0, 0.0).unwrap();
    let id = imported.scene.environment.as_ref().unwrap().image.unwrap();
    let there = space.matrix_from_rec709().unwrap() * glam::DVec3::new(1.0, 0.5, 0.25);
    let texel = first(&imported.scene, id.0).truncate();
    assert_eq!(texel, there.as_vec3());

    let imported = scene(json!("Linear Nowhere"), json!([1, 1, 1]));
    assert_eq!(codes(&imported), ["working-space"]);
    assert_eq!(
        imported.scene.color_management.working_space,
        WorkingSpace::Rec709
    );
}

#[test]
fn the_world_may_have_a_sun() {
    let mut file = Builder::triangle();
    let mut world = |sun: serde_json::Value| {
        file.json["scenes"][0]["extensions"] = json!({ "SUNDOG_scene": { "world": {
            "color": [0, 0, 0], "visibility": { "glossy": false }, "sun": sun } } });
        file.load_with(&ImportOptions::default())
    };
    let sun = json!({ "direction": [0, -2, 2], "angle": 0.01, "strength": [3, 2, 1], "moon": 1 });
    let imported = world(sun).unwrap();
    assert_eq!(codes(&imported), ["unknown-property"]);
    let light = &imported.scene.lights[0];
    let (irradiance, angle) = (1.0, 0.01);
    assert_eq!(light.kind, LightKind::Sun { irradiance, angle });
    assert_eq!(light.color, [3.0, 2.0, 1.0]);
    assert!(light.visibility.sees(RayKind::Camera) && !light.visibility.sees(RayKind::Glossy));
    let toward = light
        .world_from_light
        .transform_vector3(glam::DVec3::Z)
        .normalize();
    let wanted = glam::DVec3::new(0.0, 1.0, 1.0).normalize();
    assert!((toward - wanted).length() < 1e-12, "{toward}");
    for broken in [
        json!({ "direction": [0, 0, 0], "angle": 0.01, "strength": [1, 1, 1] }),
        json!({ "direction": [0, 0, 1], "angle": -1, "strength": [1, 1, 1] }),
        json!({ "direction": [0, 0, 1], "angle": 0.1 }),
    ] {
        assert!(world(broken).is_err());
    }
}

#[test]
fn another_environment_takes_the_worlds_place_without_looking_at_it() {
    let mut file = Builder::triangle();
    file.json["scenes"][0]["extensions"] =
        json!({ "SUNDOG_scene": { "world": { "image": "missing.exr" } } });
    assert!(file.load_with(&ImportOptions::default()).is_err());
    let options = ImportOptions {
        without_world: true,
        ..ImportOptions::default()
    };
    assert!(
        file.load_with(&options)
            .unwrap()
            .scene
            .environment
            .is_none()
    );
}

#[test]
fn objects_say_which_rays_see_them() {
    let mut file = Builder::triangle();
    file.json["nodes"][0]["extensions"] = json!({ "SUNDOG_object": {
        "visibility": { "diffuse": false, "moon": false }, "holdout": true, "shadow_catcher": true } });
    let imported = file.load();
    assert_eq!(codes(&imported), ["unknown-property"]);
    let instance = &imported.scene.instances[0];
    assert_eq!(
        instance.visibility,
        Visibility::ALL.without(RayKind::Diffuse)
    );
    assert!(instance.holdout && instance.is_catcher());
}

#[test]
fn panoramas_have_an_eye_of_spherical_stereo() {
    let mut file = Builder::triangle();
    file.json["nodes"][0]["camera"] = json!(0);
    file.json["cameras"] = json!([{ "type": "perspective",
        "perspective": { "yfov": 1, "znear": 0.1 },
        "extensions": { "SUNDOG_camera": { "panorama": { "type": "mirror_ball",
            "stereo": { "offset": -0.25, "pole_merge": [0.5, 1], "moon": 1 } } } } }]);
    let imported = file.load();
    assert_eq!(codes(&imported), ["unknown-property"]);
    let stereo = imported.scene.cameras[0].stereo.unwrap();
    assert_eq!(stereo.offset, -0.25);
    assert!(stereo.convergence.is_infinite() && stereo.is_sane());
    assert_eq!(stereo.pole_merge, Some([0.5, 1.0]));
}

#[test]
fn motions_are_steps_of_nodes_meshes_and_cameras() {
    let matrix = |x: f64| json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 0, 1]);
    let mut file = Builder::triangle();
    let moved = file.floats("VEC3", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["_POSITION_1"] = json!(moved);
    primitive["extensions"] = json!({ "SUNDOG_mesh": {
        "motion": [{ "position": "POSITION" }, { "position": "_POSITION_1" }] } });
    file.json["nodes"][0]["extensions"] =
        json!({ "SUNDOG_object": { "motion": [matrix(-1.0), matrix(0.0), matrix(2.0)] } });
    file.json["nodes"][0]["camera"] = json!(0);
    file.json["cameras"] = json!([{ "type": "perspective",
        "perspective": { "yfov": 1, "znear": 0.1 },
        "extensions": { "SUNDOG_camera": { "motion": {
            "matrices": [matrix(0.0), matrix(4.0)], "zoom": [0.5, 2] } } } }]);
    file.json["scenes"][0]["extensions"] =
        json!({ "SUNDOG_scene": { "shutter": { "curve": [0, 1, 0.5], "rolling": 0.25 } } });
    let imported = file.load();
    assert!(imported.diagnostics.is_empty(), "{:?}", codes(&imported));
    let scene = imported.scene;
    assert_eq!(scene.shutter.curve, [0.0, 1.0, 0.5]);
    assert_eq!(scene.shutter.rolling, Some(0.25));
    let steps = &scene.instances[0].motion;
    assert_eq!(steps.len(), 3);
    assert_eq!(steps[2].translation.x, 2.0);
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.motion.len(), 2);
    assert_eq!(mesh.motion[0].positions, mesh.positions);
    assert_eq!(mesh.motion[1].positions[1], [2.0, 0.0, 0.0]);
    let motion = scene.cameras[0].motion.as_ref().unwrap();
    assert_eq!(motion.steps[1].translation.x, 4.0);
    assert_eq!(motion.zoom, [0.5, 2.0]);
    // A step without positions is no mesh.
    let step = json!([{ "position": "POSITION" }, { "position": "_NOWHERE" }]);
    file.json["meshes"][0]["primitives"][0]["extensions"]["SUNDOG_mesh"]["motion"] = step;
    assert!(file.load_with(&ImportOptions::default()).is_err());
}
