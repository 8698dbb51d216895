//! Choices between what differs by thirty powers of ten, and points at the end of the sequence.

use super::{Case, Effort, Finding};
use glam::{DMat3, Vec2, Vec3};
use std::collections::BTreeSet;
use sundog::light::environment;
use sundog::light::estimate::{Angle, LightBounds};
use sundog::light::program::LookingRay;
use sundog::light::tree::{Tree, WIDTH};
use sundog::render::{MAX_LIGHT_SAMPLES, RenderError};
use sundog::sampler::{Dimension, REPLICATES, Sampler, Sequence, hashed};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "wide-distributions",
        about: "Lights and texels whose weights span 1e30: probabilities add up to 1, nothing of weight 0 is drawn, and densities are those with which is drawn.",
        run: wide_distributions,
    },
    Case {
        name: "end-of-the-sequence",
        about: "The last samples of a pixel, number 2^32 − 1 and those before it, with as many light samples as can be: points that are as even as the first ones.",
        run: end_of_the_sequence,
    },
];

/// Intensities 1e-15 … 1e15 in a row, some without any.
fn wide_lights(count: u32) -> Vec<LightBounds> {
    let light = |i: u32| {
        let at = Vec3::new(10.0 * hashed(1, i, 0), 10.0 * hashed(1, i, 1), 0.0);
        LightBounds {
            min: at,
            max: at,
            intensity: if i % 7 == 3 {
                0.0
            } else {
                10f32.powf(30.0 * hashed(1, i, 2) - 15.0)
            },
            axis: Vec3::Z,
            normals: Angle::ALL,
            cos_emission: 1.0,
            two_sided: false,
            front: None,
        }
    };
    (0..count).map(light).collect()
}

fn wide_distributions(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let draws: u32 = effort.of(1 << 16, 1 << 20, 1 << 22);
    let count = 1000;
    let lights = wide_lights(count);
    let tree = Tree::new(&lights);
    let place = (Vec3::new(3.0, 4.0, 1.0), None);
    let (first, _) = tree.look(place);
    let sum: f64 = (0..count)
        .map(|i| f64::from(tree.probability(&first, place, i)))
        .sum();
    let (mut without_weight, mut other_probability, mut nothing) = (0, 0, 0);
    for i in 0..draws {
        // The last number below 1 and the first are among them.
        let u = (i as f32 / (draws - 1) as f32).min(sundog::math::float::ONE_MINUS_EPSILON);
        match tree.sample(&first, place, u) {
            None => nothing += 1,
            Some(choice) => {
                without_weight += u64::from(lights[choice.emitter as usize].intensity == 0.0);
                let p = tree.probability(&first, place, choice.emitter);
                other_probability += u64::from(p.to_bits() != choice.probability.to_bits());
            }
        }
    }
    let mut findings = vec![
        // Each turn has shares that sum to 1 within γ(WIDTH + 4), and a product.
        Finding::new(
            "sum of the lights' probabilities",
            1.0,
            sum,
            gamma((WIDTH as u32 + 5) * tree.depth() as u32),
        ),
        Finding::none("lights of no intensity drawn", without_weight),
        Finding::none("draws of no light", nothing),
        Finding::none(
            "probabilities other than those drawn with",
            other_probability,
        ),
    ];
    findings.extend(wide_texels(draws));
    Ok(findings)
}

/// γ(n) = n u / (1 − n u), u = 2^-24.
fn gamma(n: u32) -> f64 {
    let nu = f64::from(n) * f64::from(f32::EPSILON) / 2.0;
    nu / (1.0 - nu)
}

/// The same of a world of texels.
fn wide_texels(draws: u32) -> Vec<Finding> {
    let (width, height) = (64, 32);
    let texel = |i: u32| {
        // Whole rows without light, too.
        if (i / 64).is_multiple_of(5) {
            0.0
        } else {
            10f32.powf(30.0 * hashed(2, i, 0) - 15.0)
        }
    };
    let texels: Vec<Vec3> = (0..width * height).map(|i| Vec3::splat(texel(i))).collect();
    let world = environment::Environment::image(
        width as usize,
        height as usize,
        texels,
        Vec3::ONE,
        &DMat3::IDENTITY,
    );
    let (mut bad, mut far) = (0u64, 0f64);
    for i in 0..draws {
        let u = Vec2::new(hashed(3, i, 0), hashed(3, i, 1));
        let drawn = world.sample(u);
        bad += u64::from(!(drawn.pdf > 0.0 && drawn.pdf.is_finite() && drawn.wi.is_finite()));
        // Back from the direction, but at the edge of a cell, where either is right.
        let back = world.pdf_li(world.le(drawn.wi, LookingRay::sampling(0)).on);
        if back.to_bits() != drawn.pdf.to_bits() {
            far += 1.0;
        }
    }
    // A direction is off by some roundings, a few 1e-7; the edges of the cells within that of it are passed by
    // chance: 64 columns of u and 32 rows of an angle, 4 ulp of 2^-24 to each side of each.
    let crossing = (64.0 + 32.0) * 2.0 * 4.0 / 16_777_216.0 * f64::from(draws);
    vec![
        Finding::none(
            "texels drawn with a density of 0 or that is not finite",
            bad,
        ),
        Finding::at_most(
            "directions whose density is another cell's",
            crossing + 4.0 * crossing.sqrt(),
            far,
        ),
    ]
}

/// Points of a block of 2^10 that fall into an interval that has one already, over all shapes of intervals that
/// have one each: a (0,2)-sequence has none (Niederreiter 1987; Burley 2020, §2).
fn crowded(points: &[Vec2]) -> u64 {
    let digits = points.len().ilog2();
    let mut crowded = 0;
    for across in 0..=digits {
        let (columns, rows) = ((1u32 << across) as f32, (1u32 << (digits - across)) as f32);
        let cells = points
            .iter()
            .map(|p| ((p.x * columns) as u32, (p.y * rows) as u32));
        crowded += points.len() - cells.collect::<BTreeSet<_>>().len();
    }
    crowded as u64
}

fn end_of_the_sequence(_: Effort) -> Result<Vec<Finding>, RenderError> {
    let sequence = Sequence::new(3);
    let block = |from: u32, of: &dyn Fn(Sampler) -> Vec<Sampler>| -> Vec<Vec2> {
        let numbers = (0..1024 * REPLICATES).filter(|n| (from + n) % REPLICATES == 1);
        let samplers = numbers.flat_map(|n| of(sequence.sampler(65_535, 65_535, from + n)));
        samplers
            .map(|sampler| sampler.pair(Dimension::Light, 1024))
            .collect()
    };
    let last = u32::MAX - (1024 * REPLICATES - 1);
    let parts = |sampler: Sampler| -> Vec<Sampler> {
        (0..MAX_LIGHT_SAMPLES)
            .map(|part| sampler.part(part, MAX_LIGHT_SAMPLES))
            .collect()
    };
    let (first, end) = (
        block(0, &|sampler| vec![sampler]),
        block(last, &|sampler| vec![sampler]),
    );
    let parted = block(last, &parts);
    let same = first.iter().filter(|p| end.contains(p)).count() as u64;
    let out = |p: &&Vec2| !(p.min_element() >= 0.0 && p.max_element() < 1.0);
    Ok(vec![
        Finding::none("points of the first block that crowd", crowded(&first)),
        Finding::none("points of the last block that crowd", crowded(&end)),
        Finding::none(
            "light samples of the last block that crowd",
            crowded(&parted),
        ),
        // Of 2^20 pairs, each the same with a chance of 2^-48.
        Finding::none("points of both blocks", same),
        Finding::none(
            "points outside of the square",
            parted.iter().filter(out).count() as u64,
        ),
    ])
}
