use super::super::estimate::{Angle, Front, LEAST_SHARE};
use super::*;
use crate::sampler::hashed;

/// Small balls and squares, these to one side or to both.
fn emitters(n: u32) -> Vec<LightBounds> {
    let emitter = |i: u32| {
        let r = |k: u32| hashed(k, i, 17);
        let center = Vec3::new(r(1), r(2), r(3)) * 20.0 - 10.0;
        let axis = Vec3::AXES[i as usize % 3] * if r(4) < 0.5 { -1.0 } else { 1.0 };
        let (ball, two_sided) = (i.is_multiple_of(5), i.is_multiple_of(2));
        let half = if ball {
            Vec3::splat(0.5)
        } else {
            (Vec3::ONE - axis.abs()) * 0.5
        };
        LightBounds {
            min: center - half,
            max: center + half,
            intensity: r(7) * 10.0 + 0.01,
            axis,
            normals: if ball { Angle::ALL } else { Angle::ZERO },
            cos_emission: 0.0,
            two_sided,
            front: (!ball && !two_sided).then(|| Front {
                normal: axis,
                offset: axis.dot(center),
            }),
        }
    };
    (0..n).map(emitter).collect()
}

fn places() -> impl Iterator<Item = (Vec3, Option<Vec3>)> {
    (0..200).map(|k| {
        let r = |j: u32| hashed(j, k, 99);
        let point = Vec3::new(r(1), r(2), r(3)) * 30.0 - 15.0;
        let normal = (Vec3::new(r(4), r(5), r(6)) - 0.5).normalize();
        (point, (k % 4 > 0).then_some(normal))
    })
}

/// Shares of numbers that are drawn are the probabilities told, and these sum to 1.
#[test]
fn emitters_are_drawn_as_often_as_told() {
    for count in [1, 2, 7, FEW as u32] {
        let sampler = LightSampler::new(emitters(count));
        assert!(matches!(sampler, LightSampler::Few(..)));
        for place in places() {
            let pmf = sampler.pmf(place.0, place.1, false);
            let told: Vec<f32> = (0..count)
                .map(|i| sampler.probability(&pmf, place, i))
                .collect();
            let n = 4096;
            let mut drawn = vec![0u32; count as usize];
            for k in 0..n {
                let u = (k as f32 + 0.5) / n as f32;
                match sampler.sample(&pmf, place, u) {
                    Some(choice) => {
                        assert_eq!(choice.probability, told[choice.emitter as usize]);
                        drawn[choice.emitter as usize] += 1;
                    }
                    None => assert!(told.iter().all(|&p| p == 0.0)),
                }
            }
            let sum: f32 = told.iter().sum();
            assert!(sum == 0.0 || (sum - 1.0).abs() < 1e-6, "{sum}");
            for (drawn, told) in drawn.iter().zip(told) {
                // A step of the numbers at either end.
                assert!(
                    (*drawn as f32 - told * n as f32).abs() <= 1.01,
                    "{drawn} {told}"
                );
            }
        }
    }
}

/// No emitter that can light a point has probability 0, by sampled points of emitters that see the point.
#[test]
fn what_can_arrive_can_be_drawn() {
    let lights = emitters(FEW as u32);
    let sampler = LightSampler::new(lights.clone());
    let mut dark = 0;
    for (k, (point, normal)) in places().enumerate() {
        let pmf = sampler.pmf(point, normal, true);
        for (i, light) in lights.iter().enumerate() {
            let probability = sampler.probability(&pmf, (point, normal), i as u32);
            dark += u32::from(probability == 0.0);
            let r = |j: u32| hashed(j, k as u32, 7 + i as u32);
            let weight = Vec3::new(r(1), r(2), r(3));
            let wi = light.min + (light.max - light.min) * weight - point;
            let toward = -light.axis.dot(wi);
            let emits = light.two_sided || light.normals == Angle::ALL || toward > 1e-4;
            if emits && normal.is_none_or(|n| n.dot(wi) > 1e-4) {
                assert!(probability >= LEAST_SHARE, "{k} {i}");
            }
        }
    }
    // A quarter at the least: half of those with one side, and half of what is below horizons.
    assert!(dark > 200 * FEW as u32 / 4, "{dark}");
}

#[test]
fn more_are_for_the_tree_and_none_is_none() {
    let place = (Vec3::ZERO, None);
    let many = LightSampler::new(emitters(FEW as u32 + 1));
    assert!(matches!(many, LightSampler::Many(_)));
    let pmf = many.pmf(place.0, place.1, false);
    let choice = many.sample(&pmf, place, 0.3).unwrap();
    let told = many.probability(&pmf, place, choice.emitter);
    assert!((choice.probability / told - 1.0).abs() < 1e-6);
    let none = LightSampler::new(Vec::new());
    assert!(none.is_empty());
    let pmf = none.pmf(place.0, place.1, true);
    assert!(none.sample(&pmf, place, 0.5).is_none());
}

/// However strong the other one is, even if it is infinite, a light that may shine is drawn once in 1024 times.
#[test]
fn no_light_starves_beside_a_stronger_one() {
    for stronger in [1e4, 1e8, 1e30, f32::INFINITY] {
        let mut lights = emitters(11);
        let (mut strong, weak) = (lights[0], lights[10]);
        strong.intensity = stronger;
        lights = vec![strong, weak];
        let sampler = LightSampler::new(lights);
        let place = (Vec3::ZERO, None);
        let pmf = sampler.pmf(place.0, place.1, true);
        let p = sampler.probability(&pmf, place, 1);
        assert!((LEAST_SHARE..2.0 * LEAST_SHARE).contains(&p), "{p}");
        assert_eq!(sampler.sample(&pmf, place, 1.0 - 1e-4).unwrap().emitter, 1);
    }
}
