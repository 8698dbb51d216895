//! Place and scale: wherever a scene stands, however large it is, it looks the same.

use super::kit::{Bench, camera, differing, diffuse, place, quad, rel_mse, small, sphere};
use super::still_life::{Lit, Similarity, light, looking, still_life};
use super::{Case, Effort, Finding};
use crate::render::{BounceLimits, RenderError, RenderSettings};
use crate::scene::{LightKind, Scene};
use glam::{DAffine3, DQuat, DVec3};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "moved",
        about: "A scene with lamps of all kinds, a lens, glass and instances, moved by 1e3, 1e5 and 1e7 metres: the same picture.",
        run: moved,
    },
    Case {
        name: "scaled",
        about: "The same scene from a millionth to a million times its size: the same picture.",
        run: scaled,
    },
    Case {
        name: "scaled-by-powers-of-two",
        about: "The same scene scaled by 2^-20, 2^-10, 2^10 and 2^20: the same bits, as nothing rounds differently.",
        run: scaled_by_powers_of_two,
    },
    Case {
        name: "small-on-a-huge-ground",
        about: "A ball of a millimetre on a ground of 20 000 km: the ground and the shadow look as on a ground of 2 cm.",
        run: small_on_a_huge_ground,
    },
];

/// What the issue allows: the pictures have the same samples, so that they differ by the few paths alone that a
/// rounding sends another way.
const LARGEST_REL_MSE: f64 = 1e-4;

/// Settings of a small picture.
pub fn settings(effort: Effort) -> RenderSettings {
    small(effort.of(4, 64, 256), 6)
}

/// Compares pictures of scenes with that of the first.
pub fn same(
    original: &Scene,
    others: impl IntoIterator<Item = (String, Scene)>,
    settings: &RenderSettings,
) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let reference = bench.render(original, settings)?.picture;
    let mut findings = Vec::new();
    for (name, scene) in others {
        let picture = bench.render(&scene, settings)?.picture;
        let found = rel_mse(&picture, &reference);
        findings.push(Finding::at_most(
            format!("relMSE {name}"),
            LARGEST_REL_MSE,
            found,
        ));
    }
    Ok(bench.with(findings))
}

fn moved(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let scene = still_life(Lit::ByAll);
    let others = [1e3, 1e5, 1e7].map(|distance| {
        let shift = DVec3::new(0.8, -0.36, 0.48) * distance;
        let by = Similarity {
            shift,
            ..Similarity::NONE
        };
        (format!("moved by {distance:.0e} m"), by.of(&scene))
    });
    same(&scene, others, &settings(effort))
}

fn scaled(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let scene = still_life(Lit::ByAll);
    let scales: &[f64] = effort.of(
        &[1e-6, 1e6],
        &[1e-6, 1e-3, 1e3, 1e6],
        &[
            1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6,
        ],
    );
    let others = scales.iter().map(|&scale| {
        let by = Similarity {
            scale,
            ..Similarity::NONE
        };
        (format!("scaled by {scale:.0e}"), by.of(&scene))
    });
    same(&scene, others, &settings(effort))
}

fn scaled_by_powers_of_two(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let (scene, settings, mut bench) = (still_life(Lit::ByAll), settings(effort), Bench::default());
    let reference = bench.render(&scene, &settings)?.picture;
    let mut findings = Vec::new();
    for power in [-20, -10, 10, 20] {
        let by = Similarity {
            scale: 2f64.powi(power),
            ..Similarity::NONE
        };
        let picture = bench.render(&by.of(&scene), &settings)?.picture;
        let name = format!("pixels that differ, scaled by 2^{power}");
        findings.push(Finding::none(name, differing(&picture, &reference)));
    }
    Ok(bench.with(findings))
}

/// Nothing that is drawn about a normal is in the picture.
pub fn without_diffuse_bounces(effort: Effort) -> RenderSettings {
    RenderSettings {
        bounce_limits: BounceLimits {
            diffuse: Some(0),
            ..BounceLimits::default()
        },
        ..settings(effort)
    }
}

/// A ball of a millimetre lit by a point and by the sun, on a square ground; the camera is at its own height.
fn ball_on_a_ground(half: f32) -> Scene {
    let mut scene = Scene::default();
    let ground = quad(
        [-half, 0.0, half],
        [2.0 * half, 0.0, 0.0],
        [0.0, 0.0, -2.0 * half],
    );
    place(&mut scene, ground, diffuse([0.6; 3]), &[DAffine3::IDENTITY]);
    let ball = DAffine3::from_scale_rotation_translation(
        DVec3::splat(1e-3),
        DQuat::IDENTITY,
        DVec3::new(0.2e-3, 0.9e-3, -0.1e-3),
    );
    place(
        &mut scene,
        sphere(16, 0.0, true),
        diffuse([0.5, 0.3, 0.2]),
        &[ball],
    );
    let point = LightKind::Point {
        intensity: 1e-4,
        radius: 0.0,
        soft_falloff: false,
    };
    let sun = LightKind::Sun {
        irradiance: 2.0,
        angle: 0.0,
    };
    scene.lights = vec![
        light(point, DVec3::new(-4e-3, 5e-3, 3e-3), DVec3::ZERO),
        light(sun, DVec3::new(2.0, 4.0, 1.0), DVec3::ZERO),
    ];
    let eye = DVec3::new(0.7e-3, 3.1e-3, 5.3e-3);
    let mut view = camera(eye, 0.6);
    view.world_from_camera = looking(eye, DVec3::ZERO);
    scene.cameras.push(view);
    scene
}

fn small_on_a_huge_ground(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let others = [1e3f32, 1e7].map(|half| {
        (
            format!("on a ground of ±{half:.0e} m"),
            ball_on_a_ground(half),
        )
    });
    same(
        &ball_on_a_ground(1e-2),
        others,
        &without_diffuse_bounces(effort),
    )
}
