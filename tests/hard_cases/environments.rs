//! Environments of hard images; the cases stand in the group of the lights.

use super::kit::{self, Bench, Mean};
use super::lights::{Z, square};
use super::{Effort, Finding};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use sundog::import::load_environment;
use sundog::light::environment::Environment;
use sundog::light::program::LookingRay;
use sundog::render::RenderError;
use sundog::scene::{Pixels, Scene};

/// The integral of an environment of ones but for one texel, by its bilinear interpolation: a tent of ±1 texel in longitude
/// and latitude; rows of directions are weighted by their solid angle (8 points of the midpoint rule a texel and axis).
fn with_a_hot_texel(size: [usize; 2], hot: f64, row: usize) -> f64 {
    let [width, height] = size.map(|s| s as f64);
    let steps = 64;
    let (mut tent, step) = (0.0, 1.0 / f64::from(steps));
    for i in -steps..steps {
        let t = (f64::from(i) + 0.5) * step;
        let polar = (row as f64 + 0.5 + t) / height * std::f64::consts::PI;
        tent += (1.0 - t.abs()) * polar.sin() * step;
    }
    let cell = std::f64::consts::TAU / width * std::f64::consts::PI / height;
    4.0 * std::f64::consts::PI + (hot - 1.0) * tent * cell
}

/// Sampled light is the integral.
///
/// # Errors
/// None.
pub fn images(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let draws = effort.of(4_000u32, 100_000, 1_000_000);
    let largest = effort.of([2048, 1024], [4096, 2048], [16384, 8192]);
    let mut findings = Vec::new();
    for (size, hot) in [
        ([1, 1], 1.0f32),
        ([2, 1], 1e8),
        ([512, 256], 1e8),
        (largest, 1e8),
    ] {
        let [width, height] = size;
        let mut texels = vec![Vec3::ONE; width * height];
        let row = height * 3 / 5;
        texels[row * width + width / 3] = Vec3::splat(hot);
        let found = Environment::image(width, height, texels, Vec3::ONE, &DMat3::IDENTITY);
        let mut mean = Mean::default();
        let mut unlike = 0f64;
        for i in 0..draws {
            let d = found.sample(square(11, i));
            mean.add(f64::from(found.emitted(d.wi, LookingRay::sampling(0)).x) / f64::from(d.pdf));
            // Directions on the border of two cells may be told to the other one.
            unlike += f64::from(u8::from(
                (found.pdf_li(found.le(d.wi, LookingRay::sampling(0)).on) / d.pdf - 1.0).abs()
                    > 1e-3,
            ));
        }
        // Tents that reach over a pole are cut there: only where there are at least three rows is the integral this.
        let exact = if height > 2 {
            with_a_hot_texel(size, f64::from(hot), row)
        } else if width == 1 {
            4.0 * std::f64::consts::PI
        } else {
            2.0 * std::f64::consts::PI * (1.0 + f64::from(hot))
        };
        let name = format!("{width}x{height}, one of {hot:e}");
        findings.push(Finding::at_most(
            format!("{name}: z of the integral"),
            Z,
            mean.z(exact, 1e-6 * exact),
        ));
        findings.push(Finding::at_most(
            format!("{name}: share of directions in another cell"),
            0.01,
            unlike / f64::from(draws),
        ));
    }
    let black = Environment::image(
        64,
        32,
        vec![Vec3::ZERO; 64 * 32],
        Vec3::ONE,
        &DMat3::IDENTITY,
    );
    let wrong = (0..draws).filter(|&i| {
        let d = black.sample(square(12, i));
        !(d.wi.is_finite()
            && d.pdf.is_finite()
            && d.pdf > 0.0
            && black.emitted(d.wi, LookingRay::sampling(0)) == Vec3::ZERO)
    });
    findings.push(Finding::none(
        "directions of a black image that are wrong",
        wrong.count() as u64,
    ));
    Ok(findings)
}

/// By way of a file, as users do: an EXR with what no light can be, over a white floor.
pub fn values(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let hard = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -1.0,
        -0.0,
        0.0,
        1e-40,
        1.0,
    ];
    // What docs/gltf.md promises: nothing for what is negative or no number, the largest finite value for infinity.
    let kept = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1e-40, 1.0];
    let failed =
        |error: &dyn std::fmt::Display| RenderError::Setting(format!("the test's file: {error}"));
    let folder = tempfile::tempdir().map_err(|error| failed(&error))?;
    let file = folder.path().join("hard.exr");
    exr::prelude::write_rgb_file(&file, 16, 8, |x, y| {
        let value = hard[(x + 3 * y) % hard.len()];
        (value, value, value)
    })
    .map_err(|error| failed(&error))?;

    let mut scene = Scene {
        cameras: vec![kit::camera(DVec3::new(0.0, 1.0, 3.0), 1.2)],
        ..Scene::default()
    };
    let floor = kit::quad([-2.0, 0.0, 2.0], [4.0, 0.0, 0.0], [0.0, 0.0, -4.0]);
    kit::place(
        &mut scene,
        floor,
        kit::diffuse([1.0; 3]),
        &[DAffine3::IDENTITY],
    );
    load_environment(&mut scene, &file, 1.0, 0.0).map_err(|error| failed(&error))?;
    let mut wrong = 0;
    if let Some(Pixels::F32(values)) = scene.images.first().map(|image| &image.pixels) {
        for (i, texel) in values.chunks_exact(3).enumerate() {
            let expected = kept[(i % 16 + 3 * (i / 16)) % kept.len()];
            wrong += u64::from(texel.iter().any(|&v| v != expected));
        }
    } else {
        wrong = u64::MAX;
    }
    let mut bench = Bench::default();
    bench.render(&scene, &kit::small(effort.of(8, 64, 256), 2))?;
    Ok(bench.with(vec![Finding::none(
        "texels that are not what they should be",
        wrong,
    )]))
}
