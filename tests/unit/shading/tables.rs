use super::quadrature::{LENGTH_NODES, gauss_legendre, lambda};
use super::*;
use crate::shading::ggx;
use std::f64::consts::PI;

/// GGX's albedo by another route: over directions of light, closer together toward grazing
/// ones, in f64.
fn albedo_over_light(cos: f64, alpha: f64) -> f64 {
    let sin = (1.0 - cos * cos).sqrt();
    let (nz, np) = (1000, 200);
    let mut sum = 0.0;
    for i in 0..nz {
        let root = (i as f64 + 0.5) / nz as f64;
        let z = root * root;
        let s = (1.0 - z * z).sqrt();
        for j in 0..np {
            // Half the turn, by symmetry.
            let phi = PI * (j as f64 + 0.5) / np as f64;
            let (hx, hy, hz) = (sin + s * phi.cos(), s * phi.sin(), cos + z);
            let slope2 = (hx * hx + hy * hy) / (hz * hz * alpha * alpha);
            let cos_h2 = hz * hz / (hx * hx + hy * hy + hz * hz);
            let d = 1.0 / (PI * alpha * alpha * (cos_h2 * (1.0 + slope2)).powi(2));
            sum += 2.0 * root * d / (4.0 * cos * (1.0 + lambda(cos, alpha) + lambda(z, alpha)));
        }
    }
    sum * 2.0 * PI / f64::from(nz * np)
}

/// Within a cell the table is linear where the albedo bends: E'' ≤ 12 in the roughness makes
/// 12/8·(1/39)² = 1e-3; at most as much for the cosine.
#[test]
fn albedo_agrees_with_the_integral_over_directions_of_light() {
    for (cos, roughness) in [
        (0.8f32, 1.0f32),
        (0.3, 0.7),
        (0.05, 0.5),
        (0.5, 0.45),
        (0.97, 0.9),
    ] {
        let exact = albedo_over_light(f64::from(cos), f64::from(roughness * roughness));
        let found = f64::from(Reflection::at(LutCoordinate::new(cos, roughness)).directional);
        assert!(
            (found - exact).abs() < 2e-3,
            "{cos} {roughness}: {found} {exact}"
        );
    }
    assert!((Reflection::at(LutCoordinate::new(0.5, 0.0)).directional - 1.0).abs() < 1e-5);
}

/// The quadrature itself, without the table between: the midpoint rule has steps of 0.016 in
/// angle and facets tilt by α ≥ 0.2, so its error is below (0.016/0.2)²/24 = 3e-4.
#[test]
fn the_quadrature_agrees_with_the_integral_over_directions_of_light() {
    for (cos, alpha) in [
        (0.8, 1.0),
        (0.3, 0.49),
        (0.05, 0.25),
        (1.0, 0.3),
        (0.6, 0.2),
    ] {
        let exact = albedo_over_light(cos, alpha);
        let found = Quadrature::get()
            .reflection(&View::new(cos, alpha), |_| 0.0)
            .0;
        assert!(
            (found - exact).abs() < 4e-4,
            "{cos} {alpha}: {found} {exact}"
        );
    }
}

/// ∫ x^k dx = 1/(k + 1) for k up to 2n − 1.
#[test]
fn the_nodes_integrate_polynomials() {
    let nodes = gauss_legendre::<LENGTH_NODES>();
    for k in 0..2 * LENGTH_NODES as i32 {
        let sum: f64 = nodes.iter().map(|(x, weight)| weight * x.powi(k)).sum();
        assert!((sum - 1.0 / f64::from(k + 1)).abs() < 1e-14, "{k}: {sum}");
    }
}

/// The same from outside for indices that are not near 1, at rows of the grid and between them.
#[test]
fn grazing_views_from_outside_agree_with_the_integral() {
    for ior in [0.6f32, 1.1, 1.2, 1.33, 1.5, 2.4] {
        let solid = Solid::new(ior, Rows::ALL, Estimate::Exact);
        let interface = Interface::new(ior, ior, Estimate::Exact);
        for roughness in [0.1f32, 0.3, 0.57, 0.8, 0.98, 1.0] {
            for step in 0..60 {
                let cos = 1e-5f32.powf(step as f32 / 60.0) * 0.1;
                let view = View::new(f64::from(cos), f64::from(roughness * roughness));
                let exact = Quadrature::get().both(&view, &interface);
                let found = f64::from(solid.both(LutCoordinate::new(cos, roughness), false));
                assert!(
                    (exact / found - 1.0).abs() < 5e-3,
                    "{ior} {roughness} {cos}: {found} {exact}"
                );
            }
        }
    }
}

/// Between the points, near 1, against the integral itself: within the error that is allowed for from outside. From inside the
/// albedo falls with the cosine, the fourth power of the columns' root, of which the 17th cell is linear within 12/8/17² =
/// 0.5 %, and about as steeply with the roughness: 20/8·(1/39/0.28)² = 2 % between its rows. Together 3 % from a cosine of 1e-3 on.
#[test]
fn grazing_columns_agree_with_the_integral() {
    for ior in [1.0003f32, 1.003, 1.03] {
        let solid = Solid::new(ior, Rows::ALL, Estimate::Exact);
        for inside in [false, true] {
            let eta = if inside { 1.0 / ior } else { ior };
            let interface = Interface::new(eta, ior, Estimate::Exact);
            let (least, bound) = if inside {
                (1e-3f32, 0.03)
            } else {
                (1e-4, 5e-3)
            };
            for roughness in [0.1f32, 0.3, 0.57, 0.98] {
                for step in 0..30 {
                    let cos =
                        least.powf(step as f32 / 30.0) * 0.1f32.powf(1.0 - step as f32 / 30.0);
                    let view = View::new(f64::from(cos), f64::from(roughness * roughness));
                    let exact = Quadrature::get().both(&view, &interface);
                    let found = f64::from(solid.both(LutCoordinate::new(cos, roughness), inside));
                    assert!(
                        (exact / found - 1.0).abs() < bound,
                        "{ior} {inside} {roughness} {cos}: {found} {exact}"
                    );
                }
            }
        }
    }
}

/// What Cycles 5.2.3 divides by: a white plane of glass seen from within, with GGX over the same with Multiscatter GGX, at nodes of
/// its table. Between rows and columns of ours within 1 %.
#[test]
fn inside_the_table_is_cycles() {
    for (z, cos, roughness, cycles) in [
        (7u8, 2u8, 10u8, 0.798_7f32),
        (7, 4, 10, 0.732_9),
        (7, 8, 10, 0.699_2),
        (7, 1, 15, 0.732_4),
        (7, 2, 15, 0.622_9),
        (12, 2, 10, 0.847_4),
        (3, 3, 8, 0.639_8),
    ] {
        let [z, cos, roughness] = [z, cos, roughness].map(|k| f32::from(k) / 15.0);
        let ior = (1.0 + z * z) / (1.0 - z * z);
        let found = Solid::new(ior, Rows::ALL, Estimate::Cycles)
            .both(LutCoordinate::new(cos, roughness), true);
        assert!(
            (found / cycles - 1.0).abs() < 0.01,
            "{ior} {cos} {roughness}: {found} {cycles}"
        );
    }
}

#[test]
fn columns_are_the_inverse_of_places() {
    for row in 0..ROUGHNESSES {
        let roughness = row as f32 / (ROUGHNESSES - 1) as f32;
        for column in 0..COSINES {
            let place = LutCoordinate::new(column_cosine(column, row_alpha(row)) as f32, roughness);
            let x = (place.index % COSINES) as f32 + place.along;
            // The axis has a slope of up to 1/α, and f32 resolves cosθ near 1 to 6e-8 of that.
            assert!((x - column as f32).abs() < 0.01, "{row} {column}: {x}");
        }
    }
}

/// Tables of some rows alone have the bits of those of all of them, wherever they are read.
#[test]
fn some_rows_read_as_all_of_them() {
    let solids = [1.4, 1.03].map(|ior| (ior, Solid::new(ior, Rows::ALL, Estimate::Exact)));
    for (least, greatest) in [
        (0.5, 0.5),
        (0.0, 0.1),
        (0.3, 1.0),
        (1.0, 1.0),
        (20.0 / 39.0, 20.0 / 39.0),
    ] {
        let rows = Rows::between(least, greatest);
        let few_solids = solids
            .each_ref()
            .map(|(ior, all)| (all, Solid::new(*ior, rows, Estimate::Exact)));
        for k in 0..=8u8 {
            let roughness = mix(least, greatest, f32::from(k) / 8.0);
            for cos in [0.0, 0.01, 0.3, 1.0] {
                let place = LutCoordinate::new(cos, roughness);
                for (inside, (all, few)) in [false, true]
                    .into_iter()
                    .flat_map(|i| few_solids.iter().map(move |s| (i, s)))
                {
                    assert_eq!(all.both(place, inside), few.both(place, inside));
                }
            }
        }
    }
}

#[test]
fn refraction_obeys_snell() {
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let f = fresnel::dielectric(0.8, 1.5);
    let wi = refract(wo, Vec3::Z, f.cos_t, 1.5);
    assert!((wi.length() - 1.0).abs() < 1e-6 && (wi.x + 0.4).abs() < 1e-6 && wi.z < 0.0);
    // Masking in f64 is the kernel's.
    let v = Vec3::new(0.0, 0.8, 0.6);
    assert!(
        (lambda(f64::from(v.z), 0.3) - f64::from(ggx::lambda(v, &ggx::Alpha::isotropic(0.3))))
            .abs()
            < 1e-6
    );
}
