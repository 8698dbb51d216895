use super::*;

#[test]
fn the_interval_is_about_the_estimate_and_flip_is_1_at_most() {
    let error = HalvesError::new(0.05, 64.0);
    assert!(error.low < error.flip && error.flip < error.between_halves);
    assert!((error.low * error.high / (error.flip * error.flip) - 1.0).abs() < 1e-12);
    assert_eq!(HalvesError::new(1.0, 8.0).high, 1.0);
    let none = HalvesError::new(0.0, 8.0);
    assert_eq!((none.flip, none.low, none.high), (0.0, 0.0, 0.0));
    assert!(
        error.words().contains("0.0425 (0.0317 to 0.0570)"),
        "{}",
        error.words()
    );
}
