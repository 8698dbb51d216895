use super::*;
use crate::math::warp::grid;
use glam::DQuat;
use std::f32::consts::PI;

/// Irradiance at `from` on a surface with a normal, by the light's own sampling.
fn irradiance(light: &Area, from: Vec3, normal: Vec3) -> f64 {
    let n = 384;
    let mut sum = 0f64;
    for u in grid(n) {
        if let Some(s) = light.sample(from, u) {
            assert!((s.direction.wi.length() - 1.0).abs() < 1e-5);
            sum += f64::from(s.arriving.x * s.direction.wi.dot(normal).max(0.0));
        }
    }
    sum / f64::from(n * n)
}

/// Lambert's formula for a polygon: E = L/2 Σ angle · (unit normal of the edge's plane) · n, wholly above the horizon.
fn polygon(corners: &[DVec3], from: DVec3, normal: DVec3) -> f64 {
    let unit: Vec<DVec3> = corners.iter().map(|c| (*c - from).normalize()).collect();
    let edges = (0..unit.len()).map(|i| {
        let (p, q) = (unit[i], unit[(i + 1) % unit.len()]);
        let angle = 2.0 * ((p - q).length() * 0.5).asin();
        p.cross(q).normalize().dot(normal) * angle
    });
    edges.sum::<f64>().abs() * 0.5
}

fn placements() -> Vec<(&'static str, DAffine3)> {
    let turned = DAffine3::from_rotation_translation(
        DQuat::from_rotation_x(0.4) * DQuat::from_rotation_z(0.3),
        DVec3::new(0.3, -0.2, 2.0),
    );
    let sheared = DAffine3::from_scale(DVec3::new(1.0, 2.0, 0.7))
        * DAffine3::from_rotation_z(0.6)
        * DAffine3::from_scale(DVec3::new(1.5, 1.0, 1.0));
    vec![
        ("plain", DAffine3::from_translation(DVec3::Z * 2.0)),
        ("turned", turned),
        (
            "scaled",
            turned * DAffine3::from_scale(DVec3::new(0.3, 2.0, 5.0)),
        ),
        (
            "mirrored",
            turned * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
        ),
        ("sheared", turned * sheared),
    ]
}

/// Rectangles, scaled, mirrored and sheared, from near and far, against Lambert's formula.
#[test]
fn rectangles_have_their_form_factor() {
    for (name, place) in placements() {
        let light = Area::new(&place, [1.0, 0.6], false, Vec3::splat(PI), true, PI).unwrap();
        let corners = [(-0.5, -0.3), (0.5, -0.3), (0.5, 0.3), (-0.5, 0.3)]
            .map(|(x, y)| place.transform_point3(DVec3::new(x, y, 0.0)));
        let m = place.matrix3;
        let radiance = 1.0 / (m.x_axis.cross(m.y_axis).length() * 0.6);
        for (from, normal) in [
            (DVec3::ZERO, DVec3::Z),
            (DVec3::new(1.0, 0.5, 1.2), DVec3::new(-0.5, 0.0, 1.0)),
            (DVec3::new(0.0, 0.0, -100.0), DVec3::Z),
            (
                place.transform_point3(DVec3::new(0.1, 0.1, -0.01)),
                light.normal.as_dvec3() * -1.0,
            ),
        ] {
            let normal = normal.normalize();
            let exact = radiance * polygon(&corners, from, normal);
            let found = irradiance(&light, from.as_vec3(), normal.as_vec3());
            assert!(
                (found / exact - 1.0).abs() < 3e-3,
                "{name} {from}: {found} {exact}"
            );
        }
        // Nothing behind it.
        let behind = place.transform_point3(DVec3::new(0.0, 0.0, 0.5)).as_vec3();
        assert!(light.sample(behind, Vec2::splat(0.4)).is_none(), "{name}");
    }
}

/// A disc of radius r, parallel to the surface at the height h over its axis: E = πL r²/(r² + h²); ellipses by the
/// integral of cos²/d² over a fine grid.
#[test]
fn discs_and_ellipses_have_their_form_factor() {
    let disc = |h: f64| {
        let place = DAffine3::from_translation(DVec3::Z * h);
        Area::new(&place, [2.0, 2.0], true, Vec3::splat(PI * PI), true, PI).unwrap()
    };
    for h in [0.05, 0.7, 2.0, 50.0] {
        let found = irradiance(&disc(h), Vec3::ZERO, Vec3::Z);
        let exact = std::f64::consts::PI / (1.0 + h * h);
        assert!((found / exact - 1.0).abs() < 4e-3, "{h}: {found} {exact}");
    }
    for (name, place) in placements() {
        let light = Area::new(&place, [1.0, 0.6], true, Vec3::splat(PI), true, PI).unwrap();
        let m = place.matrix3;
        let area = m.x_axis.cross(m.y_axis).length() * 0.6 * std::f64::consts::FRAC_PI_4;
        let radiance = 1.0 / area;
        for from in [DVec3::ZERO, DVec3::new(0.4, 0.1, 1.3)] {
            let n = 2000;
            let element = m.x_axis.cross(m.y_axis) * (0.6 / f64::from(n * n));
            let mut exact = 0.0;
            for i in 0..n {
                for j in 0..n {
                    let p = DVec3::new(f64::from(i) + 0.5, f64::from(j) + 0.5, 0.0) / f64::from(n)
                        - DVec3::new(0.5, 0.5, 0.0);
                    if p.length_squared() <= 0.25 {
                        let d = place.transform_point3(p * DVec3::new(1.0, 0.6, 1.0)) - from;
                        exact += radiance * d.z * d.dot(element).abs() / d.length_squared().powi(2);
                    }
                }
            }
            let found = irradiance(&light, from.as_vec3(), Vec3::Z);
            assert!(
                (found / exact - 1.0).abs() < 4e-3,
                "{name} {from}: {found} {exact}"
            );
        }
    }
}

/// The spread moves light towards the normal, but keeps the power: ∫ E over a plane below is the
/// power, whatever the spread; here over the sphere of directions from the far field.
#[test]
fn spread_keeps_the_power() {
    for spread in [0.02f32, 0.5, 1.5, 2.5, 3.1, PI] {
        let light = Area::new(
            &DAffine3::IDENTITY,
            [1.0, 1.0],
            false,
            Vec3::splat(20.0),
            true,
            spread,
        )
        .unwrap();
        // Intensity I(θ) = L(θ) cosθ A; the power is 2π ∫ I sinθ dθ.
        let n = 20_000;
        let end = f64::from(spread) * 0.5;
        let power: f64 = (0..n)
            .map(|i| {
                let angle = (f64::from(i) + 0.5) / f64::from(n) * end;
                let l = f64::from(light.radiance.x * light.share(angle.tan() as f32));
                l * angle.cos() * angle.sin()
            })
            .sum::<f64>()
            * std::f64::consts::TAU
            * end
            / f64::from(n);
        assert!((power / 20.0 - 1.0).abs() < 1e-3, "{spread}: {power}");
    }
    // Parallel light: 20 W over one square metre.
    let beam = Area::new(
        &DAffine3::IDENTITY,
        [1.0; 2],
        false,
        Vec3::splat(20.0),
        true,
        0.0,
    )
    .unwrap();
    let s = beam
        .sample(Vec3::new(0.3, -0.4, -7.0), Vec2::splat(0.5))
        .unwrap();
    assert!(s.delta && (s.arriving.x - 20.0).abs() < 1e-4 && s.distance == 7.0);
    assert!(
        beam.sample(Vec3::new(0.6, 0.0, -7.0), Vec2::splat(0.5))
            .is_none()
    );
}

/// What light sampling finds a ray finds too, with the same radiance, distance and density.
#[test]
fn rays_meet_what_is_sampled() {
    for (name, place) in placements() {
        for (ellipse, spread) in [(false, PI), (true, PI), (false, 1.0), (true, 0.3)] {
            let light = Area::new(&place, [1.0, 0.6], ellipse, Vec3::ONE, false, spread).unwrap();
            for from in [
                Vec3::new(0.1, 0.05, 0.0),
                Vec3::new(0.3, -0.1, 1.8),
                Vec3::new(0.2, 0.3, -60.0),
            ] {
                let (mut met, mut drawn) = (0, 0);
                for u in grid(40) {
                    let Some(s) = light.sample(from, u) else {
                        continue;
                    };
                    drawn += 1;
                    // Rounding may put a point of the edge outside.
                    let Some(hit) = light.le(from, s.direction.wi) else {
                        continue;
                    };
                    met += 1;
                    let same = |a: f32, b: f32| (a / b - 1.0).abs() < 2e-3;
                    assert!(same(hit.distance, s.distance), "{name} {hit:?} {s:?}");
                    assert!(
                        same(light.pdf_li(from, hit.on), s.direction.pdf),
                        "{name} {ellipse} {spread} {from} {hit:?} {s:?}"
                    );
                    assert!(
                        (hit.radiance.x - s.arriving.x * s.direction.pdf).abs()
                            < 2e-3 * light.intensity().x,
                        "{name} {hit:?} {s:?}"
                    );
                }
                assert!(met * 100 >= drawn * 99, "{name} {met} of {drawn}");
            }
        }
    }
}

/// Densities integrate to the share of the square that gives samples: uniform directions from the point meet
/// the light with a mean density of that share.
#[test]
fn densities_integrate_to_one() {
    for (name, place) in placements() {
        for ellipse in [false, true] {
            let light = Area::new(&place, [1.0, 0.6], ellipse, Vec3::ONE, true, PI).unwrap();
            for from in [Vec3::new(0.2, 0.0, 1.3), Vec3::new(-1.0, 0.4, 0.0)] {
                let n = 1000;
                let integral: f64 = grid(n)
                    .filter_map(|u| light.le(from, warp::sphere(u)))
                    .map(|hit| f64::from(light.pdf_li(from, hit.on)))
                    .map(|pdf| pdf * 4.0 * std::f64::consts::PI)
                    .sum::<f64>()
                    / f64::from(n * n);
                let drawn = grid(200)
                    .filter(|&u| light.sample(from, u).is_some())
                    .count() as f64
                    / 40_000.0;
                assert!(
                    (integral - drawn).abs() < 0.02,
                    "{name} {ellipse}: {integral} {drawn}"
                );
            }
        }
    }
}

#[test]
fn lights_without_an_area_are_none() {
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    for (place, size) in [(flat, [1.0, 1.0]), (DAffine3::IDENTITY, [0.0, 1.0])] {
        assert!(Area::new(&place, size, false, Vec3::ONE, true, PI).is_none());
    }
}

#[test]
fn a_light_is_behind_a_normal_with_all_of_its_corners() {
    let place = DAffine3::from_translation(DVec3::new(0.0, 0.0, -3.0));
    let light = Area::new(&place, [2.0, 2.0], false, Vec3::ONE, true, PI).unwrap();
    // A corner is √2 from the middle, at a distance of 3: up to 25.2° above the plane.
    for (degrees, behind) in [(0.0f32, true), (64.0, true), (65.0, false), (180.0, false)] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let normal = Vec3::new(sine, 0.0, cosine);
        assert_eq!(light.is_behind(Vec3::ZERO, normal), behind, "{degrees}");
    }
}
