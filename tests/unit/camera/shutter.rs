use super::*;
use crate::sampler::Sequence;

fn shares() -> impl Iterator<Item = f32> {
    (0..10_000).map(|i| (i as f32 + 0.5) / 10_000.0)
}

/// The shares of times in some equal parts.
fn histogram<const N: usize>(shutter: &Shutter) -> [f64; N] {
    let mut counts = [0.0; N];
    for share in shares() {
        let time = shutter.time(share, (0, 1));
        assert!((0.0..=1.0).contains(&time), "{time}");
        counts[((time * N as f32) as usize).min(N - 1)] += 1e-4;
    }
    counts
}

#[test]
fn a_shutter_without_a_curve_is_open_evenly() {
    for curve in [vec![], vec![0.5; 7], vec![0.0; 7]] {
        let shutter = Shutter::new(&curve, None, None);
        assert!(shares().all(|share| shutter.time(share, (3, 9)) == share));
    }
}

#[test]
fn times_are_as_frequent_as_the_curve_is_high() {
    // Up and down again: of a triangle's area the quarters have 1, 3, 3 and 1 eighths.
    let shares = histogram::<4>(&Shutter::new(&[0.0, 1.0, 0.0], None, None));
    for (share, eighths) in shares.into_iter().zip([1.0, 3.0, 3.0, 1.0]) {
        assert!((share - eighths / 8.0).abs() < 1e-3, "{shares:?}");
    }
    // Ever more: (2i + 1) / 25 in the fifth number i.
    let shares = histogram::<5>(&Shutter::new(&[0.0, 1.0], None, None));
    for (i, share) in shares.into_iter().enumerate() {
        let expected = (2 * i + 1) as f64 / 25.0;
        assert!((share - expected).abs() < 1e-3, "{shares:?}");
    }
    // Shut in the second half.
    let shares = histogram::<2>(&Shutter::new(&[1.0, 1.0, 0.0, 0.0, 0.0], None, None));
    assert!(shares[0] > 0.995, "{shares:?}");
}

#[test]
fn a_rolling_shutter_takes_the_rows_one_after_another() {
    let rolling = |share| Shutter::new(&[], Some(share), None);
    // All at once for each row.
    let at_once = rolling(0.0);
    for row in 0..10 {
        let time = at_once.time(0.3, (row, 10));
        assert!((time - (row + 1) as f32 / 10.0).abs() < 1e-6, "{time}");
    }
    // Each for a fifth of the time; the last one to the end.
    let slow = rolling(0.2);
    for row in 0..10 {
        let [first, last] = [0.0, 1.0].map(|share| slow.time(share, (row, 10)));
        assert!((last - first - 0.2).abs() < 1e-6);
        assert!(
            (last - (0.2 + 0.08 * (row + 1) as f32)).abs() < 1e-6,
            "{last}"
        );
    }
    // For all of it, it does not roll.
    assert!(shares().all(|share| (rolling(1.0).time(share, (3, 9)) - share).abs() < 1e-6));
}

#[test]
fn the_camera_is_where_it_is_at_the_time_of_the_ray() {
    use crate::camera::Span;
    use glam::{DAffine3, Vec3};
    let span = Span::between([-1.0, 1.0], [-1.0, 1.0]);
    let place = |x: f64| DAffine3::from_translation(DVec3::X * x);
    let moving = MovingCamera {
        lens: Lens::Perspective(span),
        aperture: None,
        steps: motion::decompose(&[place(0.0), place(2.0)]),
        zoom: [0.5, 3.0],
        origin: DVec3::ZERO,
        clip: (0.1, 100.0),
        distant: None,
        eye: None,
    };
    for (time, x, tangent) in [
        (0.0, 0.0, 0.5),
        (0.25, 0.5, 0.75),
        (0.5, 1.0, 1.0),
        (0.75, 1.5, 2.0),
        (1.0, 2.0, 3.0),
    ] {
        let ray = moving.at(time).ray(Vec2::X);
        assert!(ray.origin.abs_diff_eq(Vec3::X * x, 1e-6), "{}", ray.origin);
        let slope = ray.direction.x / -ray.direction.z;
        assert!((slope - tangent).abs() < 1e-6, "{slope}");
    }
    let still = moving.at(0.5);
    let shutter = Shutter::new(&[], None, Some(moving));
    let make = still.ray_maker();
    for sample in 0..64 {
        let sampler = Sequence::new(1).sampler(3, 4, sample);
        let ray = shutter.ray((&still, make), (Vec2::ZERO, (0, 1)), &sampler);
        assert_eq!(ray.time, sampler.single(Dimension::Time, 0));
        assert!((ray.origin.x - 2.0 * ray.time).abs() < 1e-6);
    }
}
