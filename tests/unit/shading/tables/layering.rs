use super::super::LutCoordinate;
use super::*;
use crate::shading::fresnel;

/// What a layer leaves to the base, for an index.
fn left((roughness, cos): (f32, f32), ior: f32) -> f32 {
    let f0 = fresnel::f0_from_ior(ior);
    let average = f0 + (1.0 - f0) * fresnel::average_blend(ior, f0);
    let all = (roughness > 0.0).then(|| Reflection::at(LutCoordinate::new(cos, roughness)));
    let reflectances = [f0, average].map(Vec3::splat);
    1.0 - {
        let index = (ior, ShaderRules::Before53);
        layer_albedo((cos, roughness), index, reflectances, all.as_ref()).x
    }
}

/// Cycles 5.2.3 has the weight of the base in its pass of diffuse colours: of a white Principled BSDF of index 1.5 by roughness and
/// cosine, without noise.
#[test]
fn layers_leave_to_the_base_what_cycles_leaves_to_it() {
    let cycles: [(f32, f32, f32); 35] = [
        (0.0, 1.0, 0.96000),
        (0.0, 0.5, 0.91024),
        (0.0, 0.2, 0.66292),
        (0.0, 0.1, 0.41972),
        (0.0, 0.0667, 0.31601),
        (0.0, 0.0333, 0.15809),
        (0.0, 0.01, 0.04788),
        (0.1, 1.0, 0.96000),
        (0.1, 0.5, 0.91018),
        (0.1, 0.2, 0.66605),
        (0.1, 0.1, 0.43864),
        (0.1, 0.0667, 0.34882),
        (0.1, 0.0333, 0.28836),
        (0.1, 0.01, 0.20881),
        (0.2, 1.0, 0.96004),
        (0.2, 0.5, 0.91033),
        (0.2, 0.2, 0.69015),
        (0.2, 0.1, 0.54102),
        (0.2, 0.0667, 0.49580),
        (0.2, 0.0333, 0.47509),
        (0.2, 0.01, 0.41984),
        (0.5, 1.0, 0.96261),
        (0.5, 0.5, 0.93081),
        (0.5, 0.2, 0.85659),
        (0.5, 0.1, 0.81664),
        (0.5, 0.0667, 0.80138),
        (0.5, 0.0333, 0.78975),
        (0.5, 0.01, 0.77935),
        (1.0, 1.0, 0.98621),
        (1.0, 0.5, 0.97582),
        (1.0, 0.2, 0.95504),
        (1.0, 0.1, 0.93945),
        (1.0, 0.0667, 0.93218),
        (1.0, 0.0333, 0.92259),
        (1.0, 0.01, 0.91298),
    ];
    for (roughness, cos, expected) in cycles {
        let found = left((roughness, cos), 1.5);
        // Cycles integrated its tables by random numbers.
        assert!(
            (found - expected).abs() < 1e-3,
            "{roughness} {cos}: {found} {expected}"
        );
    }
}

/// Cycles 5.3.0 has 1 less it in the light of a black surface under a coat of index 1.5, by roughness and cosine, without noise.
#[test]
fn coats_take_from_what_shines_below_what_cycles_5_3_takes() {
    let cycles: [(f32, f32, f32); 35] = [
        (0.0, 1.0, 0.04000),
        (0.0, 0.8, 0.04401),
        (0.0, 0.5, 0.08925),
        (0.0, 0.25, 0.26459),
        (0.0, 0.1, 0.57143),
        (0.0, 0.03, 0.84095),
        (0.0, 0.01, 0.94328),
        (0.2, 1.0, 0.04002),
        (0.2, 0.8, 0.04431),
        (0.2, 0.5, 0.08958),
        (0.2, 0.25, 0.25387),
        (0.2, 0.1, 0.49190),
        (0.2, 0.03, 0.60892),
        (0.2, 0.01, 0.61961),
        (0.5, 1.0, 0.04055),
        (0.5, 0.8, 0.04652),
        (0.5, 0.5, 0.07968),
        (0.5, 0.25, 0.14824),
        (0.5, 0.1, 0.20414),
        (0.5, 0.03, 0.22249),
        (0.5, 0.01, 0.22464),
        (0.8, 1.0, 0.04135),
        (0.8, 0.8, 0.04556),
        (0.8, 0.5, 0.05948),
        (0.8, 0.25, 0.08257),
        (0.8, 0.1, 0.10232),
        (0.8, 0.03, 0.11202),
        (0.8, 0.01, 0.11463),
        (1.0, 1.0, 0.04133),
        (1.0, 0.8, 0.04375),
        (1.0, 0.5, 0.05125),
        (1.0, 0.25, 0.06472),
        (1.0, 0.1, 0.07872),
        (1.0, 0.03, 0.08746),
        (1.0, 0.01, 0.09027),
    ];
    let f0 = Vec3::splat(fresnel::f0_from_ior(1.5));
    for (roughness, cos, expected) in cycles {
        let index = (1.5, ShaderRules::Since53);
        let found = layer_albedo((cos, roughness), index, [f0, f0], None).x;
        assert!(
            (found - expected).abs() < 1e-3,
            "{roughness} {cos}: {found} {expected}"
        );
    }
}

/// At the points of the tables a mirror has its own reflectance; an index of 1 reflects nothing.
#[test]
fn a_mirror_reflects_as_its_interface_does_at_the_tables_points() {
    for point in 1..15u8 {
        let z = f32::from(point * point) / 225.0;
        let ior = (1.0 + z) / (1.0 - z);
        for column in 1..=15u8 {
            let cos = f32::from(column) / 15.0;
            for index in [ior, 1.0 / ior] {
                let found = left((0.0, cos), index);
                let exact = 1.0 - fresnel::dielectric(cos, ior).reflectance;
                // Where the reflectance of a high index falls below that at normal incidence, the facets keep to that.
                let exact = exact.min(1.0 - fresnel::f0_from_ior(ior));
                assert!((found - exact).abs() < 1e-5, "{ior} {cos}: {found} {exact}");
            }
        }
    }
    for (roughness, cos) in [(0.0, 1.0), (0.0, 0.5), (0.7, 0.3), (1.0, 0.0)] {
        assert_eq!(left((roughness, cos), 1.0), 1.0);
    }
}

/// Where light comes from the denser side the layer leaves no more than it does not reflect, whatever its tint.
#[test]
fn layers_of_an_index_below_one_leave_what_total_reflection_does_not_keep() {
    for ior in [fresnel::LEAST_IOR, 0.5, 0.8, 0.99] {
        for roughness in [0.0, 0.1, 0.5, 1.0f32] {
            for cos in [0.05, 0.3, 0.7, 1.0f32] {
                for tint in [0.0, 1.0] {
                    let true_f0 = fresnel::f0_from_ior(ior);
                    let f0 = tint * true_f0;
                    let average = f0 + (1.0 - f0) * fresnel::average_blend(ior, true_f0);
                    let all = (roughness > 0.0)
                        .then(|| Reflection::at(LutCoordinate::new(cos, roughness)));
                    let both = [f0, average].map(Vec3::splat);
                    let view = (cos, roughness);
                    let found = albedo_below_one(view, ior, both, all.as_ref()).x;
                    // All of it by many facets, in equal steps.
                    let exact = reflected(view, |c| {
                        f0 + (1.0 - f0) * smooth_blend(c, ior).clamp(0.0, 1.0)
                    });
                    let gain = all.map_or(1.0, |all| all.compensation(both[1]).x);
                    assert!(
                        (found - exact * gain).abs() < 1e-2,
                        "{ior} {roughness} {cos} {tint}: {found} {}",
                        exact * gain
                    );
                    let as_cycles =
                        layer_albedo(view, (ior, ShaderRules::Since53), both, all.as_ref()).x;
                    // Cycles' never leaves less, but for its coarse tables.
                    assert!(
                        found > as_cycles - 1e-2,
                        "{ior} {roughness} {cos}: {as_cycles}"
                    );
                }
            }
        }
    }
}

/// The albedo of facets with a reflectance, by visible normals in equal steps.
fn reflected((cos, roughness): (f32, f32), reflectance: impl Fn(f32) -> f32) -> f32 {
    if roughness == 0.0 {
        return reflectance(cos);
    }
    let (alpha, n) = (f64::from(roughness).powi(2), 400);
    let (cos, sin) = (f64::from(cos), (1.0 - f64::from(cos).powi(2)).sqrt());
    let mut sum = 0.0;
    for i in 0..n {
        // Slopes of length α·√(x/(1 − x)) have each as much of the distribution.
        let x = (f64::from(i) + 0.5) / f64::from(n);
        let length = alpha * (x / (1.0 - x)).sqrt();
        let z = 1.0 / (1.0 + length * length).sqrt();
        for j in 0..n {
            let toward =
                length * (std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(n)).cos();
            let facet = (cos + sin * toward) * z;
            let scattered = 2.0 * facet * z - cos;
            if facet > 0.0 && scattered > 0.0 {
                let masking = masking(scattered, cos, alpha);
                sum += (1.0 + sin / cos * toward) * masking * f64::from(reflectance(facet as f32));
            }
        }
    }
    (sum / f64::from(n * n)) as f32
}

/// Smith's height-correlated masking and shadowing of two directions.
fn masking(scattered: f64, cos: f64, alpha: f64) -> f64 {
    let lambda = |cos: f64| {
        let tan2 = (1.0 - cos * cos).max(0.0) / (cos * cos);
        0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
    };
    1.0 / (1.0 + lambda(cos) + lambda(scattered))
}
