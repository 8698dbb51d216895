use super::*;
use crate::math::warp::grid;

fn lamp(radius: f32) -> Lamp {
    Lamp {
        center: Vec3::new(0.0, 0.0, 5.0),
        radius,
        soft_falloff: false,
        intensity: Vec3::splat(10.0),
        cone: None,
    }
}

/// The irradiance on a surface that faces a lamp is I/d² for every radius.
#[test]
fn irradiance_does_not_depend_on_the_radius() {
    for radius in [0.0f32, 1e-6, 1e-3, 0.5, 2.0, 4.5] {
        let lamp = lamp(radius);
        let n = 64;
        let mut sum = 0f64;
        for u in grid(n) {
            let s = lamp.sample(Vec3::ZERO, None, u).unwrap();
            sum += f64::from(s.arriving.x * s.direction.wi.z);
        }
        let irradiance = sum / f64::from(n * n);
        assert!(
            (irradiance / 0.4 - 1.0).abs() < 1e-3,
            "{radius}: {irradiance}"
        );
    }
}

/// A disc that faces the point: E = L π r²/(r² + d²) (Howell, *Configuration Factors*, B-11), with L = I/πr².
#[test]
fn the_irradiance_of_a_disc_is_that_of_its_form_factor() {
    for radius in [1e-3f32, 0.5, 5.0, 50.0] {
        let lamp = Lamp {
            soft_falloff: true,
            ..lamp(radius)
        };
        let n = 256;
        let mut sum = 0f64;
        for u in grid(n) {
            let s = lamp.sample(Vec3::ZERO, Some(Vec3::Z), u).unwrap();
            let wi = s.direction.wi;
            let hit = lamp
                .le(Vec3::ZERO, Vec3::ZERO, wi)
                .unwrap_or_else(|| panic!("{radius}: {:?}", s.direction));
            let pdf = lamp.pdf_li(Vec3::ZERO, Some(Vec3::Z), wi, hit.on);
            assert!((pdf / s.direction.pdf - 1.0).abs() < 1e-4);
            assert!((hit.distance / s.distance - 1.0).abs() < 1e-5);
            let by_radiance = hit.radiance.x / pdf;
            assert!((s.arriving.x / by_radiance - 1.0).abs() < 1e-4);
            sum += f64::from(s.arriving.x * s.direction.wi.z);
        }
        let found = sum / f64::from(n * n);
        let exact = 10.0 / (f64::from(radius).powi(2) + 25.0);
        assert!(
            (found / exact - 1.0).abs() < 1e-3,
            "{radius}: {found} {exact}"
        );
    }
}

/// What a ray meets of a lamp is the same, and met once, however often the ray begins anew at faces that it passes.
#[test]
fn a_lamp_is_met_once_along_a_ray_that_begins_anew() {
    for soft_falloff in [false, true] {
        let lamp = Lamp {
            soft_falloff,
            ..lamp(2.0)
        };
        let mut met = 0;
        for u in grid(32) {
            let wi = warp::cone_about(Vec3::Z, u, 0.2);
            let whole = lamp.le(Vec3::ZERO, Vec3::ZERO, wi);
            let stops = [0.0, 1.5, 2.9, 3.6, 4.4, 5.5, 8.0, f32::INFINITY];
            let pieces = stops.windows(2).filter_map(|ends| {
                let hit = lamp.le(Vec3::ZERO, wi * ends[0], wi)?;
                let distance = hit.distance + ends[0];
                (distance <= ends[1]).then_some((distance, hit))
            });
            let pieces: Vec<_> = pieces.collect();
            assert_eq!(pieces.len(), usize::from(whole.is_some()), "{wi}");
            if let (Some(whole), Some((distance, piece))) = (whole, pieces.first()) {
                assert!((distance / whole.distance - 1.0).abs() < 1e-5);
                assert_eq!((piece.on, piece.radiance), (whole.on, whole.radiance));
                met += 1;
            }
        }
        assert!((100..1000).contains(&met), "{met}");
    }
}

/// Inside, light comes from everywhere: irradiance πL.
#[test]
fn a_sphere_shines_inwards() {
    let lamp = lamp(8.0);
    let radiance = 10.0 / (std::f64::consts::PI * 64.0);
    for normal in [None, Some(Vec3::Z)] {
        let n = 128;
        let mut sum = 0f64;
        for u in grid(n) {
            let s = lamp.sample(Vec3::ZERO, normal, u).unwrap();
            let wi = s.direction.wi;
            let hit = lamp.le(Vec3::ZERO, Vec3::ZERO, wi).unwrap();
            let pdf = lamp.pdf_li(Vec3::ZERO, normal, wi, hit.on);
            assert!((pdf / s.direction.pdf - 1.0).abs() < 1e-4);
            let on = s.direction.wi * s.distance - lamp.center;
            assert!((on.length() / 8.0 - 1.0).abs() < 1e-5);
            sum += f64::from(s.arriving.x * s.direction.wi.z.max(0.0));
        }
        let found = sum / f64::from(n * n);
        assert!(
            (found / (std::f64::consts::PI * radiance) - 1.0).abs() < 5e-3,
            "{found}"
        );
    }
}

#[test]
fn a_far_sphere_is_hit_at_the_right_distance() {
    for distance in [10f32, 1e3, 1e5, 1e7] {
        let lamp = Lamp {
            center: Vec3::new(0.0, 0.0, distance),
            radius: 1.0,
            ..lamp(1.0)
        };
        let hit = lamp.hit(Vec3::new(0.3, 0.2, 0.0), Vec3::Z).unwrap();
        let exact = f64::from(distance) - (1.0 - 0.13f64).sqrt();
        assert!(
            (f64::from(hit) - exact).abs() < 2.0 * f64::from(f32::EPSILON) * f64::from(distance)
        );
        assert!(lamp.hit(Vec3::new(1.1, 0.0, 0.0), Vec3::Z).is_none());
    }
}

#[test]
fn the_spot_blend_is_smooth_from_edge_to_plateau() {
    let half: f32 = 0.5;
    let cone = Cone {
        light_from_world: Mat3::IDENTITY,
        axis: Vec3::NEG_Z,
        one_minus_cos: 1.0 - half.cos(),
        steepness: 1.0 / ((1.0 - half.cos()) * 0.2),
    };
    let out = |angle: f32| Vec3::new(angle.sin(), 0.0, -angle.cos());
    assert_eq!(cone.attenuation(out(0.51)), 0.0);
    assert_eq!(cone.attenuation(out(0.1)), 1.0);
    let edge = cone.attenuation(out(0.48));
    assert!(edge > 0.0 && edge < 1.0);
    assert_eq!(
        Cone {
            steepness: f32::INFINITY,
            ..cone
        }
        .attenuation(out(0.49)),
        1.0
    );
}
