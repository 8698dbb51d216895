use super::*;

/// `UsdLux.BlackbodyTemperatureAsRgb` of usd-core 26.11, on and between the values of the table.
#[test]
fn colours_are_those_of_usd() {
    for (kelvin, theirs) in [
        (900.0, [4.305_504_3, 0.118_358_3, 0.0]),
        (1250.0, [3.688_244_1, 0.302_033_1, 0.0]),
        (1800.0, [2.734_544_0, 0.585_126_5, 0.002_126_7]),
        (2000.0, [2.520_566_2, 0.646_888_3, 0.020_404]),
        (2856.0, [1.845_253_8, 0.826_112, 0.233_570_1]),
        (4000.0, [1.414_028_2, 0.924_039_1, 0.533_307_8]),
        (6504.0, [1.043_017_3, 0.983_658_5, 1.035_206_7]),
        (7777.0, [0.958_578_6, 0.991_070_3, 1.210_425_3]),
        (11_000.0, [0.871_841_3, 0.994_687_9, 1.429_995_9]),
    ] {
        let ours = rec709(kelvin);
        for (a, b) in ours.iter().zip(theirs) {
            // Six digits of the table, and single precision there.
            assert!((a - b).abs() < 1e-5, "{kelvin} K: {ours:?} {theirs:?}");
        }
    }
}

/// Green and blue of the curve go a little below 0 between the first values: what is cut there is all that is amiss.
#[test]
fn all_have_the_luminance_1() {
    for kelvin in [f64::NAN, -5.0, 0.0, 2500.0, 5000.0, 1e9] {
        let [r, g, b] = rec709(kelvin);
        assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 1.0).abs() < 1e-12);
    }
}
