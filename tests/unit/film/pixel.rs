use super::*;

/// Of independent samples the estimate has the expectation of the true variance: 1/12 of a uniform number,
/// over n. 20 000 pixels of three channels; its standard deviation is √2 of itself each, so 5 σ of the mean
/// are 3 % of it.
#[test]
fn the_variance_has_the_right_expectation() {
    use crate::sampler::hashed;
    for n in [64u32, 65] {
        let mut sum = 0.0;
        let pixels = 20_000;
        for p in 0..pixels {
            let mut pixel = Pixel::default();
            for s in 0..n {
                let v = Vec3::new(hashed(1, p, s), hashed(2, p, s), hashed(3, p, s));
                assert_eq!(pixel.variance().is_some(), s > 1);
                pixel.add(s % 2 == 1, v, &FirstHit::default());
            }
            sum += pixel.variance().unwrap().element_sum() / f64::from(3 * pixels);
        }
        let expected = 1.0 / 12.0 / f64::from(n);
        assert!((sum / expected - 1.0).abs() < 0.03, "{n}: {sum} {expected}");
    }
}

#[test]
fn parts_join_to_the_whole() {
    let sample = |n: u32| Vec3::new(0.1, 1e-3, 7.0) * (n * n) as f32;
    let of = |range: std::ops::Range<u32>| {
        let mut pixel = Pixel::default();
        for n in range {
            let first = FirstHit {
                albedo: Vec3::splat(0.3),
                transparent: n % 3 == 0,
                ..FirstHit::default()
            };
            pixel.add(n % 2 == 1, sample(n), &first);
        }
        pixel
    };
    let (whole, mut joined) = (of(0..23), of(11..23));
    joined.join(&of(0..11));
    assert_eq!(joined.mean(), whole.mean());
    assert_eq!(joined.albedo, whole.albedo);
    assert_eq!((joined.transparent, joined.samples), (8, 23));
    let (a, b) = (joined.variance().unwrap(), whole.variance().unwrap());
    assert!((a - b).length() <= 1e-12 * b.length());
}
