use super::*;

/// Shares of the Bevel node's kernel and the distances within which they lie are inverse to each other.
#[test]
fn distances_hold_their_share() {
    let within = |x: f64| x * x * (10.0 + x * (-20.0 + x * (15.0 - 4.0 * x)));
    for k in 0..=100_000 {
        let share = k as f32 / 100_000.0;
        let x = bevel::radius(share);
        // By the bracket: the slope goes to nothing at the end.
        let [below, above] = [x - 2e-6, x + 2e-6].map(|x| within(f64::from(x).clamp(0.0, 1.0)));
        assert!(
            below - 1e-7 <= f64::from(share) && f64::from(share) <= above + 1e-7,
            "{share} {x} {below} {above}"
        );
    }
    assert_eq!([0.0, 1.0].map(bevel::radius), [0.0, 1.0]);
}
