//! Fibres among other lobes.

use crate::sampler::{Dimension, Sequence};
use crate::shading::bsdf::{Bsdf, Changes, Scattering};
use crate::shading::closure::{AllFeatures, Chiang, Fibre, Hair, Lobe, Normals};
use glam::{Vec2, Vec3};

const FLAT: Normals = Normals {
    geometric: Vec3::Z,
    curved: Vec3::Z,
    smooth: Vec3::Z,
    shading: Vec3::Z,
};

fn wo() -> Vec3 {
    Vec3::new(0.3, 0.4, 0.8).normalize()
}

fn hair(transmits: bool, color: f32) -> Lobe {
    let frame = (Vec3::Z, Vec3::X);
    let roughness = Vec2::new(0.4, 0.6);
    let lobe = Hair::new(Vec3::splat(color), frame, wo(), (0.0, roughness), transmits);
    Lobe::Hair(lobe.unwrap())
}

fn chiang(masked: bool) -> Lobe {
    let fibre = Fibre {
        absorption: Vec3::new(0.1, 0.2, 0.4),
        roughness: Vec2::splat(0.5),
        first: 1.0,
        tilt: 0.0,
        ior: 1.55,
    };
    let place = (Vec3::X, Vec3::Z, 0.0);
    Lobe::Chiang(Chiang::new(Vec3::ONE, &fibre, place, wo(), (0.0, masked)))
}

fn mixed(lobes: &[Lobe]) -> Bsdf<AllFeatures> {
    let mut bsdf = Bsdf::new(FLAT, wo(), false, Changes::NONE);
    for lobe in lobes {
        bsdf.add(*lobe, Vec3::ONE);
    }
    bsdf.finish();
    bsdf
}

/// Passes have all of a fibre's light among reflections, and what a Hair BSDF lets through among that, whichever side it is on.
#[test]
fn passes_ask_lobes_and_not_sides() {
    let above = Vec3::new(0.1, -0.5, 0.7).normalize();
    for wi in [above, -above] {
        assert_eq!(mixed(&[chiang(false)]).through(wi), Vec3::ZERO);
        assert_eq!(mixed(&[hair(true, 0.5)]).through(wi), Vec3::ONE);
        assert_eq!(
            mixed(&[hair(false, 0.5), chiang(false)]).through(wi),
            Vec3::ZERO
        );
    }
    let both = mixed(&[hair(true, 0.5), chiang(false)]);
    let [let_through, all] =
        [hair(true, 0.5), chiang(false)].map(|lobe| mixed(&[lobe]).evaluate(-above).value);
    let expected = let_through / (let_through + all);
    assert!((both.through(-above) - expected).abs().max_element() < 1e-6);
}

/// Directions to all sides are drawn, and what they did to the path is the lobe's way, not the side.
#[test]
fn no_direction_is_lost_for_its_side() {
    let bsdf = mixed(&[chiang(false)]);
    let mut found = [[0u32; 2]; 2];
    let sequence = Sequence::new(2);
    for s in 0..1 << 12 {
        let u = sequence.sampler(0, 0, s).triple(Dimension::Bsdf, 0);
        let sample = bsdf.sample(u).unwrap();
        assert_eq!(sample.beyond, sample.wi.z < 0.0);
        let through = sample.scattering == Scattering::Transmission;
        found[usize::from(through)][usize::from(sample.beyond)] += 1;
        // Each direction is worth what is evaluated there.
        let again = bsdf.evaluate(sample.wi);
        assert!((again.pdf / sample.pdf - 1.0).abs() < 2e-3);
    }
    assert!(found.iter().flatten().all(|&count| count > 0), "{found:?}");
}

/// What light samples have of fibres beside others is never less than nothing.
#[test]
fn masked_fibres_have_no_light_below_nothing() {
    let masked = chiang(true);
    let bsdf = mixed(&[masked, hair(false, 0.3)]);
    for k in 0..200 {
        let (z, turn) = (k as f32 / 100.0 - 0.995, 0.7 * k as f32);
        let across = (1.0 - z * z).sqrt();
        let wi = Vec3::new(across * turn.cos(), across * turn.sin(), z);
        let value = bsdf.evaluate_sampled(wi);
        assert!(
            value.value.min_element() >= 0.0 && value.pdf >= 0.0,
            "{value:?}"
        );
    }
}
