use super::*;
use proptest::prelude::*;

#[test]
fn what_f64_would_lose_is_kept() {
    let mut sum = ColorSum::default();
    for value in [1e20, 3.0, 1e-12, -1e20] {
        sum.add(Vec3::splat(value));
    }
    let expected = 3.0 + f64::from(1e-12f32);
    assert!((sum.total().x / expected - 1.0).abs() < 1e-12, "{sum:?}");
}

proptest! {
    /// Any order and any division into parts give the same f32.
    #[test]
    fn order_and_parts_do_not_matter(
        values in prop::collection::vec(
            (0.0f32..10.0, -30i32..30).prop_map(|(m, e)| m * 2f32.powi(e)), 2..200),
        cut in any::<prop::sample::Index>(),
    ) {
        let sum = |values: &mut dyn Iterator<Item = f32>| {
            let mut sums = (ColorSum::default(), FixedSum::default());
            values.for_each(|v| {
                sums.0.add(Vec3::splat(v));
                sums.1.add(Vec3::splat(v.min(1.0)));
            });
            sums
        };
        let forward = sum(&mut values.iter().copied());
        let backward = sum(&mut values.iter().rev().copied());
        let (mut joined, tail) = {
            let cut = cut.index(values.len());
            (sum(&mut values[cut..].iter().copied()), sum(&mut values[..cut].iter().copied()))
        };
        joined.0.join(&tail.0);
        joined.1.join(&tail.1);
        for other in [backward, joined] {
            prop_assert_eq!(forward.0.total().as_vec3(), other.0.total().as_vec3());
            prop_assert_eq!(forward.1, other.1);
        }
    }
}
