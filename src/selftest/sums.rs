//! Sums over samples: without drift, in any order, and each pixel for itself.

use super::kit::{Bench, camera, colors, small};
use super::{Case, Effort, Finding};
use crate::film::pixel::{FirstHit, Pixel};
use crate::render::{RenderError, RenderSettings};
use crate::sampler::hashed;
use crate::scene::{Environment, Image, ImageId, Scene, Visibility};
use glam::{DMat3, DVec3, Vec3};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "many-samples",
        about: "2^24 samples a pixel, each 0.1: their sum in f32 stalls at 2^21 (where half an ulp is 0.125), their mean must stay 0.1.",
        run: many_samples,
    },
    Case {
        name: "order-of-samples",
        about: "Samples from 1e-12 to 1e12 in any order and in parts give the same bits.",
        run: order_of_samples,
    },
    Case {
        name: "firefly",
        about: "A texel of 1e30 in the world: pixels that do not see it keep their bits, that which does has the mean of its samples, and no other goes without samples of the adaptive kind.",
        run: firefly,
    },
];

/// Each rounding of f64 loses 2^-53 of the sum and the rest keeps it: the bound is f32's last rounding of the value.
fn many_samples(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples: u32 = effort.of(1 << 22, 1 << 24, 1 << 24);
    let mut pixel = Pixel::default();
    for number in 0..samples {
        pixel.add(number % 2 == 1, Vec3::splat(0.1), &FirstHit::default());
    }
    let (value, mean) = (f64::from(0.1f32), pixel.mean().x);
    Ok(vec![
        Finding::new("mean radiance", value, mean, value * f64::EPSILON),
        Finding::at_most(
            "estimated variance of the mean",
            (value * f64::EPSILON).powi(2),
            pixel.variance().map_or(f64::NAN, |v| v.max_element()),
        ),
    ])
}

fn order_of_samples(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples: u32 = effort.of(1 << 12, 1 << 16, 1 << 20);
    let value = |number: u32| Vec3::splat(10f32.powf(24.0 * hashed(1, number, 0) - 12.0));
    let sum = |numbers: &mut dyn Iterator<Item = u32>| {
        let mut pixel = Pixel::default();
        numbers.for_each(|number| pixel.add(number % 2 == 1, value(number), &FirstHit::default()));
        pixel
    };
    let forward = sum(&mut (0..samples));
    let backward = sum(&mut (0..samples).rev());
    let mut joined = sum(&mut (samples / 3..samples));
    joined.join(&sum(&mut (0..samples / 3)));
    let differs = |other: Pixel| u64::from(other.mean().as_vec3() != forward.mean().as_vec3());
    Ok(vec![
        Finding::none("sums that differ backwards", differs(backward)),
        Finding::none("sums that differ in parts", differs(joined)),
    ])
}

/// A world of radiance 1 with one texel of another.
fn world_with_a_texel(value: f32) -> Scene {
    let (width, height) = (256, 128);
    let mut texels = vec![1f32; 3 * width * height];
    // Ahead of the camera, a little aside.
    let at = 3 * (height / 2 * width + width / 4 + 3);
    texels[at..at + 3].fill(value);
    Scene {
        cameras: vec![camera(DVec3::ZERO, 1.0)],
        images: vec![Image {
            name: "world".into(),
            width: width as u32,
            height: height as u32,
            channels: 3,
            pixels: texels.into(),
        }],
        environment: Some(Environment {
            image: Some(ImageId(0)),
            radiance: [1.0; 3],
            rotation: DMat3::IDENTITY,
            visibility: Visibility::ALL,
            links: Default::default(),
            graph: None,
        }),
        ..Scene::default()
    }
}

fn firefly(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = RenderSettings {
        pixel_error_target: 0.01,
        ..small(effort.of(64, 256, 1024), 2)
    };
    let (plain, bright) = (world_with_a_texel(1.0), world_with_a_texel(1e30));
    let without = bench.render(&plain, &settings)?;
    let with = bench.render(&bright, &settings)?;
    let (mut near, mut changed, mut wrong) = (0u64, 0, 0);
    for (a, b) in colors(&without.picture).zip(colors(&with.picture)) {
        let sees = b[0] > 1e20;
        near += u64::from(sees);
        changed += u64::from(!sees && a != b);
        wrong += u64::from(!b.iter().all(|c| c.is_finite() && *c <= 1e30));
    }
    Ok(bench.with(vec![
        // Two texels by two, of 2π/256, in pixels of at least 0.75/24: no wider than 1.6; and 1.5 more to each side
        // by the filter: at most 6 by 6 pixels.
        Finding::at_most("pixels that see the texel", 36.0, near as f64),
        Finding::none("pictures in which none does", u64::from(near == 0)),
        Finding::none("other pixels that changed", changed),
        Finding::none("pixels above the texel or not finite", wrong),
        Finding::new(
            "least samples of a pixel",
            f64::from(without.statistics.samples),
            f64::from(with.statistics.samples),
            0.0,
        ),
    ]))
}
