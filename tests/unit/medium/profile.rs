use super::*;

/// Even in the first, and by the golden ratio in the second.
fn numbers(n: u32) -> impl Iterator<Item = Vec2> {
    (0..n).map(move |s| {
        let turned = f64::from(s) * 0.618_033_988_749_894_8;
        Vec2::new((s as f32 + 0.5) / n as f32, turned.fract() as f32)
    })
}

#[test]
fn the_density_has_the_integral_one() {
    let profile = Profile::new(Vec3::new(0.5, 0.1, 0.0));
    let steps = 400_000;
    let width = 16.0 * 0.5 / steps as f32;
    let sum: glam::DVec3 = (0..steps)
        .map(|i| (profile.density((i as f32 + 0.5) * width) * width).as_dvec3())
        .sum();
    // The midpoint rule's error is width²/24 times a slope below 1/d².
    assert!(
        (sum.x - 1.0).abs() < 1e-5 && (sum.y - 1.0).abs() < 1e-5,
        "{sum}"
    );
    assert_eq!(sum.z, 0.0);
    assert_eq!(profile.density(2.0).y, 0.0);
}

#[test]
fn distances_are_drawn_by_the_density() {
    let d = 0.3f32;
    let profile = Profile::new(Vec3::new(0.0, d, 0.0));
    for i in 0..=1000 {
        let u = (i as f32 / 1000.0).min(crate::math::float::ONE_MINUS_EPSILON);
        let (distance, reach) = profile.draw(u);
        let x = f64::from(distance / d);
        let within = 1.0 - 0.25 * (-x).exp() - 0.75 * (-x / 3.0).exp();
        // 1 − 0.9964 u is rounded to 6e-8, and what lies beyond 16 lengths is 0.0036.
        assert!(
            (within - f64::from(u * WITHIN)).abs() < 1e-6,
            "{u}: {within}"
        );
        assert!(distance <= reach && reach == 16.0 * d);
    }
    // Each channel has its share of the numbers.
    let profile = Profile::new(Vec3::new(1.0, 0.0, 0.01));
    assert_eq!(profile.draw(0.49).1, 16.0);
    assert_eq!(profile.draw(0.51).1, 0.16);
}

/// On a plane all that enters comes out, and as far away as the profile says: rays across the normal find nothing there, and
/// those along it count for all.
#[test]
fn a_plane_gives_back_what_enters() {
    let profile = Profile::new(Vec3::new(0.02, 0.05, 0.01));
    let normal = Vec3::new(0.2, -0.5, 0.7).normalize();
    let n = 1 << 15;
    let (mut sum, mut far) = (glam::DVec3::ZERO, 0.0f64);
    for u in numbers(n) {
        let probe = Probe::new(profile, Vec3::ONE, normal, u);
        let along = (Vec3::ONE - probe.origin).dot(normal) / probe.direction.dot(normal);
        if !(0.0..=probe.far).contains(&along) {
            continue;
        }
        let weight = probe.weight(along, normal).as_dvec3();
        sum += weight;
        far += weight.y * f64::from((probe.origin + probe.direction * along).distance(Vec3::ONE));
    }
    let mean = sum / f64::from(n);
    assert!(
        (mean - glam::DVec3::ONE).abs().max_element() < 0.01,
        "{mean}"
    );
    // ∫ x (e^(−x) + e^(−x/3))/4 dx = 5/2, up to 16 lengths 2.43.
    let beyond = |a: f64| (16.0 * a + a * a) * (-16.0 / a).exp();
    let expected = 0.05 * (2.5 - (beyond(1.0) + beyond(3.0)) / 4.0) / f64::from(WITHIN);
    let far = far / sum.y;
    assert!((far / expected - 1.0).abs() < 0.01, "{far} {expected}");
}

/// Faces that one kind of ray sees from the side are found by another.
#[test]
fn each_axis_finds_what_faces_it() {
    let profile = Profile::new(Vec3::splat(0.1));
    let (x, y) = across(Vec3::Z);
    assert!(x.dot(y).abs() < 1e-6 && x.z == 0.0 && y.z == 0.0);
    for (u, axis, often) in [(0.25, Vec3::Z, 0.5), (0.6, x, 0.25), (0.9, y, 0.25)] {
        let probe = Probe::new(profile, Vec3::ZERO, Vec3::Z, Vec2::new(0.5, u));
        assert!((probe.direction + axis).length() < 1e-6);
        // In the plane of the disc the distance is the drawn one: what is left is one over how often.
        let weight = probe.weight(0.5 * probe.far, axis);
        assert!(
            (weight - 1.0 / often).abs().max_element() < 1e-4,
            "{weight}"
        );
        let aside = probe.axes[1].0;
        assert_eq!(probe.weight(0.5 * probe.far, aside).max_element(), 0.0);
    }
}
