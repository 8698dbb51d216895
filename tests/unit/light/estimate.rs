use super::*;
use crate::sampler::hashed;

/// The short form for hemispheres is the formula's.
#[test]
fn hemispheres_have_the_same_orientation() {
    for k in 0..=100 {
        let normals = Angle::from_radians(FRAC_PI_2 * k as f32 / 100.0);
        // Next to no emission beyond a hemisphere.
        let (short, long) = (orientation(normals, 0.0), orientation(normals, 1e-30));
        assert!((short - long).abs() < 1e-5, "{normals:?}: {short} {long}");
    }
}

/// Of something small the estimate is what arrives, of something large no less than what arrives from any point of it; in whatever
/// lane it stands.
#[test]
fn estimates_are_what_arrives_at_most() {
    for k in 0..2000u32 {
        let r = |j: u32| hashed(j, k, 31);
        let v = |j: u32| Vec3::new(r(j), r(j + 1), r(j + 2)) - 0.5;
        let (center, axis, normal) = (v(0) * 20.0, v(3).normalize(), v(6).normalize());
        let half = if k % 2 == 0 {
            Vec3::ZERO
        } else {
            (v(9) * 4.0).abs()
        };
        let (two_sided, round) = (k % 3 == 0, k % 5 == 0);
        let bounds = LightBounds {
            min: center - half,
            max: center + half,
            intensity: 1.0 + r(12),
            axis,
            normals: if round { Angle::ALL } else { Angle::ZERO },
            cos_emission: 0.0,
            two_sided,
            front: None,
        };
        let dark = LightBounds {
            intensity: 0.0,
            ..bounds
        };
        let mut lanes = [dark; LANES];
        let lane = k as usize % LANES;
        lanes[lane] = bounds;
        let point = v(13) * 20.0;
        let estimates = Candidates::new(&lanes)
            .importance(point, Some(normal))
            .to_array();
        let sent = |on: Vec3| {
            let to = (on - point).as_dvec3();
            let wi = to.normalize();
            let cos = match -axis.as_dvec3().dot(wi) {
                _ if round => 1.0,
                cos if two_sided => cos.abs(),
                cos => cos,
            };
            let received = normal.as_dvec3().dot(wi);
            (cos > 0.0 && received > 0.0).then_some(cos * received)
        };
        for (other, &estimate) in estimates.iter().enumerate() {
            assert!(other == lane || estimate == 0.0);
        }
        let d2 = f64::from(center.distance_squared(point));
        let most = f64::from(bounds.intensity) / d2;
        if half == Vec3::ZERO {
            // Cosines and what is left of them are good to the margin.
            let expected = most * sent(center).unwrap_or(0.0);
            let error = (f64::from(estimates[lane]) - expected).abs();
            assert!(
                error <= 3.0 * f64::from(ANGLE_MARGIN) * most,
                "{k} {expected} {}",
                estimates[lane]
            );
        } else if d2 > f64::from(half.length_squared()) {
            for j in 0..8 {
                let on = center + half * (Vec3::new(r(20 + j), r(30 + j), r(40 + j)) * 2.0 - 1.0);
                let least = most * sent(on).unwrap_or(0.0);
                assert!(
                    f64::from(estimates[lane]) >= least * (1.0 - f64::from(ANGLE_MARGIN)),
                    "{k}"
                );
            }
        }
    }
}

#[test]
fn what_is_wholly_behind_a_normal_is_told_from_what_is_in_part() {
    let bounds = LightBounds {
        min: Vec3::new(-1.0, -1.0, -3.0),
        max: Vec3::new(1.0, 1.0, -3.0),
        intensity: 1.0,
        axis: Vec3::Z,
        normals: Angle::ALL,
        cos_emission: 0.0,
        two_sided: false,
        front: None,
    };
    // Half of the diagonal is √2, at a distance of 3: up to 25.2° above the plane.
    for (degrees, behind) in [(0.0, true), (64.0, true), (65.0, false), (180.0, false)] {
        let (sine, cosine) = f32::sin_cos(f32::to_radians(degrees));
        let normal = Vec3::new(sine, 0.0, cosine);
        assert_eq!(
            bounds.ball().is_behind(Vec3::ZERO, normal),
            behind,
            "{degrees}"
        );
    }
}

/// A number falls to the share that its place on the line of all of them says, and what is left of it is its place in that; crumbs of
/// rounding fall to the last one that is more than nothing.
#[test]
fn numbers_fall_to_shares() {
    let mut shares = [[0.0; LANES]; 2];
    (shares[0][1], shares[0][6], shares[1][2]) = (0.25, 0.5, 0.25);
    let last = LANES + 2;
    for (u, at, rest) in [
        (0.0, 1, 0.0),
        (0.125, 1, 0.5),
        (0.25, 6, 0.0),
        (0.5, 6, 0.5),
        (0.75, last, 0.0),
        (0.9375, last, 0.75),
    ] {
        assert_eq!(draw(&shares, u), Some((at, rest)), "{u}");
    }
    assert_eq!(draw(&shares, 1.0), Some((last, 1.0 - f64::EPSILON / 2.0)));
    assert_eq!(draw(&[[0.0; LANES]], 0.5), None);
}
