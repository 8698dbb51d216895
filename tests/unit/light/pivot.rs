use super::*;
use crate::light::estimate::{Angle, Front};

fn bounds() -> LightBounds {
    LightBounds {
        min: Vec3::ZERO,
        max: Vec3::ZERO,
        intensity: 1.0,
        axis: -Vec3::Y,
        normals: Angle::ZERO,
        cos_emission: 0.0,
        two_sided: false,
        front: None,
    }
}

fn is_near(found: Option<Pivot>, known: (f32, f32)) -> bool {
    found.is_some_and(|pivot| {
        (pivot.lit.0 - known.0).abs() < 1e-5 && (pivot.lit.1 - known.1).abs() < 1e-5
    })
}

#[test]
fn what_faces_down_lights_what_is_below() {
    let lamp = LightBounds {
        front: Some(Front {
            normal: -Vec3::Y,
            offset: 0.0,
        }),
        ..bounds()
    };
    let down = (Vec3::new(3.0, 2.0, 0.0), -Vec3::Y);
    assert!(is_near(lamp.pivot(down, 5.0), (2.0, 5.0)));
    let up = (Vec3::new(3.0, -2.0, 0.0), Vec3::Y);
    assert!(is_near(lamp.pivot(up, 5.0), (0.0, 2.0)));
    // From behind it and away, with a cone, too.
    let away = (Vec3::new(0.0, 2.0, 0.0), Vec3::Y);
    assert_eq!(lamp.pivot(away, 5.0), None);
    let cone = LightBounds {
        cos_emission: 0.5,
        ..lamp
    };
    assert_eq!(cone.pivot(away, 5.0), None);
    let above = (Vec3::new(3.0, 1.0, 0.0), Vec3::X);
    assert_eq!(lamp.pivot(above, 5.0), None);
    let endless = lamp.pivot(down, f32::INFINITY);
    assert_eq!(endless.map(|pivot| pivot.lit.1), Some(f32::INFINITY));
}

#[test]
fn a_spot_lights_its_cone() {
    let angle = 0.25 * std::f32::consts::PI;
    let spot = LightBounds {
        normals: Angle {
            sin: angle.sin(),
            cos: angle.cos(),
        },
        cos_emission: 1.0,
        ..bounds()
    };
    // At a depth of 2 the cone is 4 wide.
    let across = (Vec3::new(-5.0, -2.0, 0.0), Vec3::X);
    assert!(is_near(spot.pivot(across, 20.0), (3.0, 7.0)));
    assert!(is_near(spot.pivot(across, 6.0), (3.0, 6.0)));
    assert_eq!(spot.pivot(across, 2.0), None);
    // The other nappe is none of its.
    let above = (Vec3::new(-5.0, 2.0, 0.0), Vec3::X);
    assert_eq!(spot.pivot(above, 20.0), None);
    let endless = (Vec3::new(1.0, 0.0, 0.0), -Vec3::Y);
    let found = spot.pivot(endless, f32::INFINITY);
    assert!(found.is_some_and(|p| (p.lit.0 - 1.0).abs() < 1e-5 && p.lit.1 == f32::INFINITY));
    // A wider one is bounded from further behind.
    let wide = LightBounds {
        min: Vec3::splat(-0.1),
        max: Vec3::splat(0.1),
        ..spot
    };
    let found = wide.pivot(across, 20.0).map(|pivot| pivot.lit);
    assert!(found.is_some_and(|lit| lit.0 < 3.0 && lit.1 > 7.0 && lit.0 > 2.5));
}
