//! Animations: what a node's pose is between keys, by each interpolation.

use super::kit::Builder;
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use sundog::import::{AnimationTime, ImportOptions, Imported};

/// A square whose node is moved by samplers of (path, interpolation, times, values).
fn moving(samplers: &[(&str, &str, &[f32], Vec<f32>)]) -> Builder {
    let mut file = Builder::square();
    let (mut channels, mut written) = (Vec::<Value>::new(), Vec::<Value>::new());
    for (number, (path, interpolation, times, values)) in samplers.iter().enumerate() {
        let kind = match *path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let (input, output) = (file.floats("SCALAR", times), file.floats(kind, values));
        written.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
        channels.push(json!({ "sampler": number, "target": { "node": 0, "path": path } }));
    }
    file.json["animations"] = json!([{ "name": "go", "channels": channels, "samplers": written }]);
    file
}

fn at(file: &Builder, seconds: f64) -> Imported {
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

fn node(imported: &Imported) -> glam::DAffine3 {
    imported.scene.instances[0].world_from_object
}

/// Hermite's interpolation is exact for polynomials of the third degree, whatever the keys' distances: glTF's CUBICSPLINE has
/// tangents a second, before and after each key.
#[test]
fn cubic_splines_follow_a_cubic_exactly() {
    let curve = |t: f64| DVec3::new(t * t * t - 2.0 * t, 0.5 * t * t + 1.0, 3.0 - t);
    let slope = |t: f64| DVec3::new(3.0 * t * t - 2.0, t, -1.0);
    let times = [0.25f32, 1.0, 3.0];
    let values: Vec<f32> = times
        .iter()
        .flat_map(|&t| {
            let t = f64::from(t);
            [slope(t), curve(t), slope(t)].map(|v| v.as_vec3().to_array())
        })
        .flatten()
        .collect();
    let file = moving(&[("translation", "CUBICSPLINE", &times, values)]);
    for seconds in [0.25, 0.3, 0.9, 1.0, 1.7, 2.5, 3.0] {
        let found = node(&at(&file, seconds)).translation;
        // Keys and tangents of some units are f32.
        assert!(found.distance(curve(seconds)) < 1e-5, "{seconds}: {found}");
    }
    // Before the first key and after the last one it stands still.
    for (seconds, end) in [(-1.0, 0.25), (0.0, 0.25), (9.0, 3.0)] {
        let found = node(&at(&file, seconds)).translation;
        assert!(found.distance(curve(end)) < 1e-5, "{seconds}: {found}");
    }
}

/// A tangent that leaves a key counts only after it, and one that comes to it only before it.
#[test]
fn tangents_on_both_sides_of_a_key_are_their_own() {
    let (times, still) = ([0.0f32, 1.0, 2.0], [0.0f32; 3]);
    let mut values = Vec::new();
    for (before, after) in [(9.0, 0.0), (0.0, 8.0), (0.0, 9.0)] {
        values.extend([[before, 0.0, 0.0], still, [after, 0.0, 0.0]].concat());
    }
    let file = moving(&[("translation", "CUBICSPLINE", &times, values)]);
    let x = |seconds: f64| node(&at(&file, seconds)).translation.x;
    assert!(x(0.5).abs() < 1e-12);
    // span · (t³ − 2t² + t) · 8 at the half.
    assert!((x(1.5) - 1.0).abs() < 1e-12, "{}", x(1.5));
}

/// Turns are normalised after they are interpolated by their numbers; scales and weights of shapes come the same way.
#[test]
fn turns_scales_and_weights_are_splined() {
    let (a, b) = (DQuat::from_rotation_x(0.4), DQuat::from_rotation_y(1.2));
    let four = |q: DQuat| q.as_quat().to_array();
    let turns = [[0.0; 4], four(a), [0.0; 4], [0.0; 4], four(b), [0.0; 4]].concat();
    let scales = [[0.0; 3], [1.0; 3], [2.0; 3], [2.0; 3], [3.0; 3], [0.0; 3]].concat();
    // Two shapes at two keys: each key has both tangents before, both values, and both tangents after.
    let weights = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.0];
    let mut file = moving(&[
        ("rotation", "CUBICSPLINE", &[0.0, 2.0], turns),
        ("scale", "CUBICSPLINE", &[0.0, 1.0], scales),
        ("weights", "CUBICSPLINE", &[0.0, 1.0], weights),
    ]);
    let up = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let aside = file.floats("VEC3", &[1.0, 0.0, 0.0].repeat(4));
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": up }, { "POSITION": aside }]);
    let imported = at(&file, 0.5);
    // A quarter of the turn: 2t³ − 3t² + 1 = 27/32.
    let turn =
        DQuat::from_vec4((glam::DVec4::from(a) * 27.0 + glam::DVec4::from(b) * 5.0).normalize());
    // A half of the scale, with tangents of 2 on both sides, which cancel.
    let expected =
        glam::DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), turn, DVec3::ZERO);
    let found = node(&imported);
    assert!(
        found.abs_diff_eq(expected, 1e-6),
        "{found} instead of {expected}"
    );
    // A half of both weights: half of the first shape, and three quarters of the second.
    let corner = imported.scene.meshes[0].positions[0];
    assert_eq!(corner, [0.75, 0.0, 0.5]);
}

#[test]
fn steps_and_lines_are_what_they_are_called() {
    let values = || vec![0.0, 0.0, 0.0, 4.0, 0.0, 0.0];
    for (interpolation, expected) in [("STEP", 0.0), ("LINEAR", 3.0)] {
        let file = moving(&[("translation", interpolation, &[0.0, 1.0], values())]);
        let x = node(&at(&file, 0.75)).translation.x;
        assert!((x - expected).abs() < 1e-12, "{interpolation}: {x}");
    }
}

/// A spline with as many values as a line would have is told, and nothing is guessed.
#[test]
fn a_spline_without_tangents_is_an_error() {
    let values = vec![0.0; 6];
    let file = moving(&[("translation", "CUBICSPLINE", &[0.0, 1.0], values)]);
    let options = ImportOptions {
        animation: Some(AnimationTime {
            name: Some("go".into()),
            seconds: 0.5,
            frame: None,
        }),
        ..ImportOptions::default()
    };
    let error = file.load_with(&options).unwrap_err().to_string();
    assert!(
        error.contains("2 times, and 6 numbers for translation"),
        "{error}"
    );
}
