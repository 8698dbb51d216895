use super::*;

#[test]
fn the_curve_goes_there_and_back() {
    for value in [0.0, 0.001, 0.003, 0.2, 0.9, 1.0] {
        assert!((decode(encode(value)) - value).abs() < 1e-6);
    }
}
