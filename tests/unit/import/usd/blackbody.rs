use super::*;

/// `UsdLux.BlackbodyTemperatureAsRgb` of usd-core 26.11, a spline through the same curve.
#[test]
fn colours_are_those_of_usd() {
    for (kelvin, theirs) in [
        (2000.0, [2.520_566_2, 0.646_888_3, 0.020_404]),
        (3000.0, [1.771_028_4, 0.844_293_5, 0.272_031_8]),
        (4000.0, [1.414_028_2, 0.924_039_1, 0.533_307_8]),
        (6500.0, [1.043_333_4, 0.983_624_5, 1.034_613_3]),
        (10_000.0, [0.871_841_3, 0.994_687_9, 1.429_995_9]),
    ] {
        let ours = rec709(kelvin);
        for (a, b) in ours.iter().zip(theirs) {
            // The fit of the observer is good to about 1 %.
            assert!(
                (a - b).abs() < 0.02 * b.max(1.0),
                "{kelvin} K: {ours:?} {theirs:?}"
            );
        }
    }
}

#[test]
fn all_have_the_luminance_1() {
    for kelvin in [f64::NAN, -5.0, 0.0, 1000.0, 5000.0, 1e9] {
        let [r, g, b] = rec709(kelvin);
        assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 1.0).abs() < 1e-12);
    }
}
