//! Surfaces that light passes beside, and that emit.

use super::*;

/// A sheet that fills the camera's view, is there to a share, and emits.
fn sheet(alpha: f32, emission: f32) -> Scene {
    let mut scene = Scene::default();
    let sign = MetallicRoughness {
        alpha,
        alpha_mode: AlphaMode::Blend,
        emission: [emission; 3],
        ..diffuse([0.0; 3])
    };
    let wall = quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
    place(&mut scene, wall, sign, &[DAffine3::IDENTITY]);
    scene.cameras.push(camera(DVec3::new(0.0, 0.0, 2.0), 0.5));
    scene
}

/// What is faint and emits strongly gives each ray its share, whether the ray passes it or not: nothing is noisy.
#[test]
fn a_faint_sign_has_no_noise() {
    for transparent in [None, Some(4)] {
        let mut settings = small(1, 2);
        settings.bounce_limits.transparent = transparent;
        let shown = colors(&run(&sheet(0.01, 150.0), &settings));
        for color in shown.into_iter().flatten() {
            assert!((color - 1.5).abs() < 1e-5, "{color}");
        }
    }
}

/// Its light on others, and what is seen through it, are what they are in a room of opaque surfaces as bright.
#[test]
fn a_faint_sign_lights_as_a_dim_one() {
    let lit = |alpha: f32, emission: f32| {
        let mut scene = sheet(alpha, emission);
        scene.instances[0].world_from_object =
            DAffine3::from_translation(DVec3::new(0.0, 0.0, 3.0));
        let wall = quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
        place(&mut scene, wall, diffuse([0.8; 3]), &[DAffine3::IDENTITY]);
        estimate(&scene, &small(16, 1), 0..24)
    };
    let ((faint, a), (dim, b)) = (lit(0.02, 50.0), lit(1.0, 1.0));
    let error = (a + b).sqrt();
    assert!((faint - dim).abs() < 4.7 * error, "{faint} {dim} ± {error}");
    assert!(error < 0.005 * dim, "{error}");
}
