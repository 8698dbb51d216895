use super::*;

fn labels(axis: &Axis, values: &[f64], most: usize) -> Vec<String> {
    let range = Range::of(axis, values.iter().copied());
    let labels = range.labels(most);
    for (at, label) in &labels {
        assert!(
            (-1e-9..=1.0 + 1e-9).contains(at),
            "{label} is outside of {range:?}"
        );
    }
    let labels: Vec<_> = labels.into_iter().map(|(_, label)| label).collect();
    assert!(labels.len() <= most + 1, "{labels:?}");
    labels
}

#[test]
fn log_axes_have_round_numbers() {
    let log = Axis::log("time", "s");
    assert_eq!(labels(&log, &[0.1, 100.0], 6), ["0.1", "1", "10", "100"]);
    assert_eq!(labels(&log, &[1.0, 40.0], 8), ["1", "2", "5", "10", "20"]);
    assert_eq!(labels(&log, &[3.0, 4.0], 8), ["2", "3", "4", "5", "6", "7"]);
    assert_eq!(
        labels(&log, &[1e-12, 1.0], 5),
        ["10⁻¹²", "10⁻⁹", "10⁻⁶", "0.001", "1"]
    );
    assert_eq!(labels(&log, &[1e-8, 1e300], 4).len(), 4);
    assert_eq!(tick_label(5e-4), "5·10⁻⁴");
    assert_eq!(tick_label(-2.5e6), "−2.5·10⁶");
    assert_eq!(tick_label(0.1 + 0.2), "0.3");
}

#[test]
fn log_positions_are_even_by_decade() {
    let range = Range::of(&Axis::log("", ""), [1.0, 10.0, 100.0].into_iter());
    let [a, b, c] = [1.0, 10.0, 100.0].map(|value| range.position(value));
    assert!((b - 0.5).abs() < 1e-12 && (b - a - (c - b)).abs() < 1e-12);
    assert!((a - MARGIN / (1.0 + 2.0 * MARGIN)).abs() < 1e-12);
}

#[test]
fn light_ticks_stand_between_decades() {
    let range = Range::of(&Axis::log("", ""), [1.0, 1e4].into_iter());
    let light = range.key_points(plotters::coord::ranged1d::LightPoints::new(5, 50));
    // 1 to 9 in four decades and 1e4; the margin of 0.12 decades below 1 has 0.8 and 0.9, that above 1e4 none.
    assert_eq!(light.len(), 4 * 9 + 1 + 2);
    assert_eq!(range.labels(5).len(), 5);
}

#[test]
fn linear_axes() {
    let linear = Axis::linear("bounces", "");
    assert_eq!(
        labels(&linear, &[0.0, 5.0], 6),
        ["0", "1", "2", "3", "4", "5"]
    );
    assert_eq!(labels(&linear, &[0.3, 0.1], 3), ["0", "0.2"]);
    assert_eq!(
        labels(&linear, &[-1.0, 1.0], 5),
        ["−1", "−0.5", "0", "0.5", "1"]
    );
}

#[test]
fn one_value_and_none_and_what_is_not_finite() {
    for axis in [Axis::linear("", ""), Axis::log("", "")] {
        for values in [
            &[][..],
            &[7.0],
            &[f64::NAN, f64::INFINITY],
            &[f64::NAN, 3.0],
            &[1e-300],
            &[1e300],
            &[0.0],
            &[-1.0, -2.0],
        ] {
            let range = Range::of(&axis, values.iter().copied());
            assert!(range.low < range.high, "{values:?}");
            assert!(range.low.is_finite() && range.high.is_finite());
            assert!(!range.labels(6).is_empty(), "{axis:?} {values:?}");
        }
    }
}
