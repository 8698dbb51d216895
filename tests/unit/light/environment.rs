use super::*;

const ANY: LookingRay = LookingRay { kind: 0, depth: 0 };
use crate::math::warp::grid;

fn gradient(width: usize, height: usize) -> Vec<Vec3> {
    (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            let sun = if (x, y) == (5, 3) { 1e6 } else { 0.0 };
            Vec3::new(0.1 + x as f32, (height - y) as f32, 1.0) + sun
        })
        .collect()
}

fn turned() -> DMat3 {
    DMat3::from_rotation_z(1.0) * DMat3::from_rotation_x(0.7)
}

#[test]
fn directions_and_coordinates_are_inverse_and_blenders() {
    for (u, cos) in [(0.1f32, 0.5f32), (0.6, -0.8), (0.99, 0.0)] {
        let at = Environment::coordinates(Environment::direction(u, cos));
        assert!((at.x - u).abs() < 1e-5 && (at.y - cos.acos() / PI).abs() < 1e-5);
    }
    // Blender: +X is the image's middle, +Y (glTF -Z) a quarter to the left of it.
    assert!((Environment::coordinates(Vec3::X).x - 0.5).abs() < 1e-6);
    assert!((Environment::coordinates(Vec3::NEG_Z).x - 0.25).abs() < 1e-6);
    assert!(Environment::coordinates(Vec3::Y).y < 1e-6);
}

/// Blender's Mapping node takes +X to +Y with a Z rotation of 90°, and up to −Y with an X rotation of 90°.
#[test]
fn rotations_are_by_blenders_axes() {
    let quarter = std::f64::consts::FRAC_PI_2;
    // Columns of red 0, 1, 2, …, rows of green.
    let texels: Vec<Vec3> = (0..32)
        .map(|i| Vec3::new((i % 8) as f32, (i / 8) as f32, 1.0))
        .collect();
    let at = |rotation: DMat3, d: Vec3| {
        let env = Environment::image(8, 4, texels.clone(), Vec3::ONE, &rotation);
        let plain = Environment::image(8, 4, texels.clone(), Vec3::ONE, &DMat3::IDENTITY);
        (env, plain, d)
    };
    for (rotation, from, to) in [
        (DMat3::from_rotation_z(quarter), Vec3::X, Vec3::NEG_Z),
        (DMat3::from_rotation_x(quarter), Vec3::Y, Vec3::Z),
        (DMat3::from_rotation_y(quarter), Vec3::X, Vec3::NEG_Y),
    ] {
        let (env, plain, d) = at(rotation, from);
        let (found, wanted) = (env.emitted(d, ANY), plain.emitted(to, ANY));
        assert!((found - wanted).length() < 1e-4, "{found} {wanted}");
    }
}

/// Sampling by the table and uniform sampling integrate the same; the estimate's weights are bounded.
#[test]
fn samples_integrate_the_image_and_agree_with_their_density() {
    for (w, h) in [(64usize, 32usize), (1, 1), (7, 5)] {
        let env = Environment::image(w, h, gradient(w, h), Vec3::splat(0.5), &turned());
        let n = 512;
        let mut by_table = 0f64;
        let mut uniform = 0f64;
        let mut agree = 0usize;
        for u in grid(n) {
            let s = env.sample(u);
            assert!(s.pdf > 0.0);
            let hit = env.le(s.wi, ANY);
            assert_eq!(hit.radiance, env.emitted(s.wi, ANY));
            // At cell borders rounding may name the neighbour; elsewhere the densities agree.
            agree += usize::from((env.pdf_li(hit.on) / s.pdf - 1.0).abs() < 1e-3);
            by_table += f64::from(env.emitted(s.wi, ANY).y / s.pdf);
            uniform += f64::from(env.emitted(crate::math::warp::sphere(u), ANY).y)
                * 4.0
                * std::f64::consts::PI;
        }
        let count = f64::from(n * n);
        assert!(agree as f64 > 0.99 * count, "{w}x{h}: {agree}");
        assert!(
            (by_table / uniform - 1.0).abs() < 2e-2,
            "{w}x{h}: {} {}",
            by_table / count,
            uniform / count
        );
        let mean = f64::from(env.mean().y) * 4.0 * std::f64::consts::PI;
        assert!((by_table / count / mean - 1.0).abs() < 0.1, "{w}x{h}");
    }
}

/// As by looking at all sums, be they flat, steep or beyond 1 by rounding; at steps, beside them and anywhere.
#[test]
fn a_guide_finds_what_a_bisection_finds() {
    let flat: Vec<f64> = (0..=100).map(|i| f64::from(i) / 100.0).collect();
    let mut steep = vec![0.0; 51];
    steep.extend([1e-9, 0.5, 0.5, 0.5]);
    steep.extend([1.0; 50]);
    steep.truncate(101);
    let rows = [flat, steep];
    let all: Vec<f32> = rows.iter().flatten().map(|&sum| sum as f32).collect();
    let (guide, wide) = (Guide::new(&all, 101), Guide::new(&rows[1], 101));
    let near = |u: f32| [u.next_down().max(0.0), u, u.next_up()];
    let numbers = (0..1024).flat_map(|i| near(i as f32 / 1024.0));
    let cells = (0..100).flat_map(|i| near(i as f32 / 100.0));
    let last = crate::math::float::ONE_MINUS_EPSILON;
    for u in numbers.chain(cells).chain([1e-9, last]) {
        for row in 0..2 {
            let sums = &all[row * 101..][..101];
            let expected = sums.partition_point(|&sum| sum <= u);
            assert_eq!(guide.count(row, sums, u), expected, "{row} {u}");
        }
        let expected = rows[1].partition_point(|&sum| sum <= f64::from(u));
        assert_eq!(wide.count(0, &rows[1], u), expected, "{u}");
    }
}

#[test]
fn black_images_and_single_texels_are_sampled_without_harm() {
    for texels in [vec![Vec3::ZERO; 32], vec![Vec3::splat(1e30); 32]] {
        let env = Environment::image(8, 4, texels, Vec3::ONE, &DMat3::IDENTITY);
        for u in [0.0, 0.5, crate::math::float::ONE_MINUS_EPSILON] {
            let s = env.sample(Vec2::splat(u));
            assert!(s.pdf > 0.0 && s.pdf.is_finite() && (s.wi.length() - 1.0).abs() < 1e-5);
        }
    }
}
