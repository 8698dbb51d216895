//! Faces in one plane that lie on each other: what light is left.

use super::{EffectChoice, RenderSettings, mean, run, small};
use glam::{DAffine3, DQuat, DVec3};
use sundog::effects;
use sundog::scene::{Effect, Scene};
use sundog::selftest::kit::{camera, constant_environment, diffuse, place, quad};

const ALBEDO: f64 = 0.75;

/// Two sheets in one place that fill the picture, under a sky of 1 all around.
pub fn sheets(turn: f64) -> Scene {
    many_sheets(turn, 2)
}

/// So many of them.
fn many_sheets(turn: f64, count: usize) -> Scene {
    let mut scene = Scene {
        generator: Some("Sundog add-on for Blender".into()),
        environment: constant_environment(1.0),
        cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 0.8)],
        ..Scene::default()
    };
    let turned = DAffine3::from_quat(DQuat::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), turn));
    for _ in 0..count {
        let sheet = quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
        place(&mut scene, sheet, diffuse([ALBEDO as f32; 3]), &[turned]);
    }
    scene
}

/// Across an axis all rays meet the other sheet. Of turned ones all do whose point lies on the wrong side of the plane: half of those
/// that the camera sees; of those that were met on another sheet, and stay on their side in one of two cases, a quarter. So of
/// radiances r there and r' here r' = a (3/4 + r'/4) and r = a (1/2 + r'/2). Without the effect none does.
#[test]
fn sheets_in_one_place_are_black_or_half_as_bright() {
    let alone = |turn: f64, settings: &RenderSettings| {
        let lit = RenderSettings {
            effects: EffectChoice::List(effects::names(effects::ALL - Effect::CoincidentFaces)),
            ..settings.clone()
        };
        mean(&run(&sheets(turn), &lit))
    };
    let met = 0.75 * ALBEDO / (1.0 - 0.25 * ALBEDO);
    for (bounces, turned) in [(0, 0.5 * ALBEDO), (400, 0.5 * ALBEDO * (1.0 + met))] {
        let settings = small(64, bounces);
        assert_eq!(mean(&run(&sheets(0.0), &settings)), 0.0);
        assert!((alone(0.0, &settings) / ALBEDO - 1.0).abs() < 1e-3);
        assert!((alone(0.3, &settings) / ALBEDO - 1.0).abs() < 1e-3);
        // 32 x 24 pixels of 64 paths: each is between 0 and 1, so that five deviations are below 0.5 · 5 / √49152.
        let found = mean(&run(&sheets(0.3), &settings));
        assert!((found - turned).abs() < 0.012, "{found}, not {turned}");
    }
}

/// However many there are: they are met together, and the first in the order of the scene is gone on from.
#[test]
fn sheets_upon_sheets_take_no_more() {
    let settings = small(16, 4);
    for turn in [0.0, 0.3] {
        let [two, many] = [2, 60].map(|count| run(&many_sheets(turn, count), &settings));
        let (two, many) = (mean(&two), mean(&many));
        // What is seen is the last of them, so that other numbers decide.
        assert!((two - many).abs() < 0.024, "{two}, {many}");
        assert_eq!(two == 0.0, turn == 0.0);
        assert_eq!(many == 0.0, turn == 0.0);
    }
}
