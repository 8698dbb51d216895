use super::*;

#[test]
fn cosine_hemisphere_has_the_moments_of_its_density() {
    let n = 256;
    let (mut z, mut xx) = (0f64, 0f64);
    for u in grid(n) {
        let d = cosine_hemisphere(u);
        z += f64::from(d.z);
        xx += f64::from(d.x * d.x);
    }
    let count = (n * n) as f64;
    // E[cosθ] = 2/3 and E[x²] = 1/4 under cosθ/π.
    // The midpoint rule errs by O(h^1.5) at the square root on the rim.
    let bound = 2.0 * (n as f64).powf(-1.5);
    assert!((z / count - 2.0 / 3.0).abs() < bound);
    assert!((xx / count - 0.25).abs() < bound);
}

#[test]
fn cones_of_all_sizes_stay_inside_and_keep_their_mean() {
    for one_minus_cos in [1e-14f32, 1e-8, 1e-3, 0.5, 1.0, 2.0] {
        let n = 128;
        let mut sum = 0f64;
        for u in grid(n) {
            let d = cone(u, one_minus_cos);
            assert!(
                (d.length() - 1.0).abs() < 1e-6,
                "{one_minus_cos}: {}",
                d.length()
            );
            // 1 − cos from the sine, which keeps it for tiny cones.
            let sin2 = f64::from(d.x) * f64::from(d.x) + f64::from(d.y) * f64::from(d.y);
            sum += if d.z > 0.0 {
                sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt())
            } else {
                1.0 - f64::from(d.z)
            };
        }
        let mean = sum / (n * n) as f64;
        let expected = f64::from(one_minus_cos) * 0.5;
        assert!(
            (mean / expected - 1.0).abs() < 1e-3,
            "{one_minus_cos}: {mean} {expected}"
        );
    }
}

#[test]
fn the_triangle_map_is_uniform() {
    let n = 256;
    let mut sum = glam::DVec2::ZERO;
    let mut square = 0f64;
    for u in grid(n) {
        let b = triangle(u);
        assert!(b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0);
        sum += b.as_dvec2();
        square += f64::from(b.x * b.x);
    }
    let count = (n * n) as f64;
    assert!((sum / count - glam::DVec2::splat(1.0 / 3.0)).length() < 1e-4);
    // E[u²] = 1/6 over the unit triangle.
    assert!((square / count - 1.0 / 6.0).abs() < 1e-4);
}
