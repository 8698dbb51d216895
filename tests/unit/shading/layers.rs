use super::*;

/// An index for which the tables of layers have points: they are exact at multiples of 1/15 of the cosine.
const IOR: f32 = 1.380_952_4;

fn coat(weight: f32, tint: Vec3) -> Layers {
    let coat = Coat {
        weight,
        roughness: 0.0,
        ior: IOR,
        tint,
        normal: Vec3::Z,
    };
    Layers {
        coat: Some(coat),
        fibres: None,
        rules: ShaderRules::Before53,
    }
}

/// A smooth coat keeps its Fresnel reflectance, and colours the rest by the way in it.
#[test]
fn light_from_below_a_coat_is_what_fresnel_leaves() {
    let tint = Vec3::new(1.0, 0.5, 0.25);
    // Roundings of numbers below 1: the place in the tables has two digits less.
    let tolerance = 64.0 * f32::EPSILON;
    for (weight, cos) in [
        (1.0f32, 1.0f32),
        (0.5, 1.0),
        (1.0, 0.6),
        (1.0, 0.2),
        (2.3, 0.8),
    ] {
        let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let reflected = fresnel::dielectric(cos, IOR).reflectance;
        let left = 1.0 - weight * reflected;
        let clear = coat(weight, Vec3::ONE).transmittance(Vec3::Z, wo);
        assert!(
            (clear - Vec3::splat(left)).abs().max_element() <= tolerance,
            "{clear} {left}"
        );
        let way = 1.0 / (1.0 - (1.0 - cos * cos) / (IOR * IOR)).sqrt();
        let colored = coat(weight, tint).transmittance(Vec3::Z, wo);
        // Cycles bounds the weight from below alone: what is left is never less than nothing.
        let expected = Vec3::ONE.lerp(tint.powf(way), weight).max(Vec3::ZERO) * left;
        assert!(
            (colored - expected).abs().max_element() <= 4.0 * tolerance,
            "{colored} {expected}"
        );
    }
    let nothing = Layers::default().transmittance(Vec3::Z, Vec3::Z);
    assert_eq!(nothing, Vec3::ONE);
}

/// From 5.3 on a coat that covers a part lets the rest's light by: what is covered gives the coat's light, and its own through it.
#[test]
fn coats_since_5_3_cover_a_part() {
    let tint = Vec3::new(1.0, 0.5, 0.25);
    for (weight, expected) in [
        (1.0, tint * 0.75),
        (0.4, Vec3::splat(0.6) + tint * 0.75 * 0.4),
        (3.0, (Vec3::splat(-2.0) + tint * 0.75 * 3.0).max(Vec3::ZERO)),
    ] {
        let mut layers = coat(weight, tint);
        layers.rules = ShaderRules::Since53;
        if let Some(coat) = &mut layers.coat {
            // A quarter is reflected straight on.
            coat.ior = 3.0;
        }
        let found = layers.transmittance(Vec3::Z, Vec3::Z);
        // The tables have 32 points.
        assert!(
            (found - expected).abs().max_element() < 1e-3,
            "{weight}: {found} {expected}"
        );
    }
}

/// A coat that is seen from behind has no light of its own, but what lies below is as dark as below one that is seen along it.
#[test]
fn coats_from_behind_darken_as_grazing_ones() {
    let seen = |normal: Vec3, cos: f32| {
        let mut layers = coat(1.0, Vec3::ONE);
        layers.coat = layers.coat.map(|coat| Coat {
            roughness: 0.5,
            normal,
            ..coat
        });
        let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        layers.transmittance(Vec3::Z, wo).x
    };
    let grazing = seen(Vec3::Z, 1e-5);
    assert!(grazing < 0.9, "{grazing}");
    let behind = seen(-Vec3::Z, 1.0);
    assert!((behind - grazing).abs() < 1e-3, "{behind} {grazing}");
}

/// Fibres keep their albedo.
#[test]
fn light_from_below_fibres_is_what_their_albedo_leaves() {
    let fibres = Fibres {
        weight: 0.8,
        roughness: 0.5,
        tint: Vec3::new(0.2, 1.0, 0.5),
    };
    let layers = Layers {
        coat: None,
        fibres: Some(fibres),
        rules: ShaderRules::Before53,
    };
    let wo = Vec3::new(0.8, 0.0, 0.6);
    let albedo = Sheen::new(fibres.tint * fibres.weight, 0.5, Vec3::Z, wo)
        .map_or(Vec3::ZERO, |lobe| lobe.albedo());
    assert!(albedo.max_element() > 0.01);
    let left = layers.transmittance(Vec3::Z, wo);
    assert_eq!(left, Vec3::splat(1.0 - albedo.max_element()));
}
