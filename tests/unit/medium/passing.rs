use super::*;
use crate::math::frame::Frame;

fn of(distance: f32) -> Passing {
    Passing::new(Vec3::ONE, Vec3::ONE + Vec3::new(0.0, 0.6, 0.8) * distance).expect("two points")
}

#[test]
fn directions_have_their_density() {
    // Bins of equal probability by the angle: u = 1 - (1 - theta/pi)^2.
    const BINS: usize = 32;
    const DRAWN: u32 = 1 << 16;
    let passing = of(3.0);
    let mut counts = [0u32; BINS];
    for i in 0..DRAWN {
        // A regular line of u.x has no noise: the bins' counts are right within two.
        let u = Vec2::new(
            (i as f32 + 0.5) / DRAWN as f32,
            (i as f32 * 0.618_034).fract(),
        );
        let direction = passing.sample(u);
        assert!((direction.length() - 1.0).abs() < 1e-6);
        let angle = passing
            .axis()
            .cross(direction)
            .length()
            .atan2(passing.axis().dot(direction));
        let below = 1.0 - (1.0 - f64::from(angle) / std::f64::consts::PI).powi(2);
        counts[((below * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    let each = DRAWN / BINS as u32;
    for (bin, count) in counts.into_iter().enumerate() {
        assert!(count.abs_diff(each) <= 2, "bin {bin}: {count} of {each}");
    }
}

#[test]
fn densities_sum_to_one() {
    let passing = of(0.5);
    let frame = Frame::from_normal(passing.axis());
    const STEPS: u32 = 4096;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let angle = (f64::from(i) + 0.5) * std::f64::consts::PI / f64::from(STEPS);
        let (sin, cos) = angle.sin_cos();
        let direction = frame.to_world(Vec3::new(sin as f32, 0.0, cos as f32));
        sum += f64::from(passing.density(direction)) * sin * std::f64::consts::TAU;
    }
    // The midpoint rule is exact for what is linear in the angle; the rest is f32's rounding.
    let sum = sum * std::f64::consts::PI / f64::from(STEPS);
    assert!((sum - 1.0).abs() < 1e-5, "{sum}");
}

#[test]
fn the_axis_has_its_limits() {
    let passing = Passing::new(Vec3::ZERO, Vec3::Z).expect("two points");
    assert_eq!(passing.density(Vec3::Z), f32::INFINITY);
    let behind = 1.0 / (PI * PI * PI);
    assert!((passing.density(-Vec3::Z) - behind).abs() < 1e-6 * behind);
    assert_eq!(Passing::new(Vec3::X, Vec3::X), None);
}
