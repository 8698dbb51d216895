use super::*;
use std::io::Read;

fn map(width: u32, values: &[f32], log: bool) -> HeatMap {
    HeatMap {
        name: "error".into(),
        width,
        height: values.len() as u32 / width,
        values: values.to_vec(),
        log,
        ..HeatMap::default()
    }
}

/// What the page's script does.
fn decoded(codes: &Codes, count: usize) -> Vec<f64> {
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(&codes.bytes[..])
        .read_to_end(&mut bytes)
        .unwrap();
    let mut code = 0u16;
    (0..count)
        .map(|index| {
            code = code.wrapping_add(u16::from_be_bytes([bytes[index], bytes[count + index]]));
            let share = f64::from(code.wrapping_sub(1)) / 65533.0;
            let value = codes.low + share * (codes.high - codes.low);
            match code {
                u16::MAX => f64::NAN,
                0 => 0.0,
                _ if codes.log => 10f64.powf(value),
                _ => value,
            }
        })
        .collect()
}

#[test]
fn numbers_come_back() {
    let counts: Vec<f32> = (0..4096).map(|i| ((i * 37) % 1000) as f32).collect();
    let shown = map(64, &counts, false).shown().unwrap();
    for (value, decoded) in counts.iter().zip(decoded(&shown.codes, counts.len())) {
        assert!((f64::from(*value) - decoded).abs() < 1e-9);
    }
    // On a logarithmic scale a step of the codes over ten decades is 10/65533 decades, half of it 1.8e-4.
    let errors: Vec<f32> = (0..=1000)
        .map(|i| 10f32.powf(i as f32 / 100.0 - 7.0))
        .collect();
    let shown = map(1001, &errors, true).shown().unwrap();
    for (value, decoded) in errors.iter().zip(decoded(&shown.codes, errors.len())) {
        assert!((decoded / f64::from(*value) - 1.0).abs() < 2e-4);
    }
}

#[test]
fn what_is_not_finite_is_counted_and_zero_stays_zero() {
    let shown = map(2, &[f32::NAN, 0.0, f32::INFINITY, 2.0], true)
        .shown()
        .unwrap();
    assert_eq!(shown.not_finite, 2);
    let values = decoded(&shown.codes, 4);
    assert!(values[0].is_nan() && values[2].is_nan());
    assert_eq!(values[1], 0.0);
    assert!((values[3] - 2.0).abs() < 1e-3);
    for nothing in [[f32::NAN; 4], [0.0; 4]] {
        assert!(map(2, &nothing, true).shown().is_ok());
        assert!(map(2, &nothing, false).shown().is_ok());
    }
}

#[test]
fn sizes_must_fit() {
    let mut wrong = map(2, &[1.0; 4], false);
    wrong.height = 3;
    let message = wrong.shown().unwrap_err().to_string();
    assert!(
        message.contains("4 numbers do not make 2 × 3 pixels"),
        "{message}"
    );
}

#[test]
fn the_scale_is_a_round_number() {
    for (value, expected) in [
        (0.0, 1e-6),
        (0.03, 0.05),
        (0.05, 0.05),
        (0.051, 0.1),
        (1.0, 1.0),
        (1.2, 2.0),
        (700.0, 1000.0),
    ] {
        assert!(
            (round_up(value) / expected - 1.0).abs() < 1e-9,
            "{value}: {}",
            round_up(value)
        );
    }
}

#[test]
fn colours_stand_for_numbers() {
    let mut values: Vec<f32> = (0..100).map(|index| index as f32 / 99.0).collect();
    values[50] = f32::NAN;
    let map = map(100, &values, false).with_round_end();
    assert_eq!(map.brightest, Some(1.0));
    let picture = map.picture_with_scale().unwrap();
    assert_eq!((picture.width, picture.height), (100, 1 + SCALE_ROWS));
    // The ends of matplotlib's magma.
    let ends = [[0, 0, 4], [252, 253, 191]];
    assert_eq!(picture.rgb[0..3], ends[0]);
    assert_eq!(picture.rgb[3 * 99..3 * 100], ends[1]);
    assert_eq!(picture.rgb[3 * 50..3 * 51], NOT_FINITE);
    // The bar below shows the same colours from one side to the other, and the numbers stand below it.
    let bar = 3 * 100 * 3;
    assert_eq!(picture.rgb[bar..bar + 3], ends[0]);
    assert_eq!(picture.rgb[bar + 297..bar + 300], ends[1]);
    let below = &picture.rgb[3 * 100 * (1 + 2 + BAR_ROWS as usize)..];
    assert!(below.iter().filter(|value| **value > 128).count() > 30);
}
