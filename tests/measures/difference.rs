//! Differences of pictures by hand.

use sundog::measure::{
    Encoding, MeasureError, RgbImage, difference, difference_as_shown, error_map,
};

fn picture(width: u32, height: u32, pixels: &[[f32; 3]]) -> RgbImage {
    RgbImage {
        width,
        height,
        pixels: pixels.to_vec(),
        encoding: Encoding::Linear,
    }
}

#[test]
fn numbers_computed_by_hand() {
    let a = picture(2, 1, &[[1.0, 2.0, 3.0], [0.5, 0.0, 0.0]]);
    let b = picture(2, 1, &[[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]]);
    let d = difference(&a, &b).unwrap();
    // (0² + 1² + 2² + 0.5²) / 6 = 5.25 / 6
    assert!((d.rmse - (5.25f64 / 6.0).sqrt()).abs() < 1e-12);
    // (1 + 4) / 1.01 + 0.25 / 0.01 = 4.9504950… + 25, over 6
    assert!((d.rel_mse - (5.0 / 1.01 + 25.0) / 6.0).abs() < 1e-12);
    // |1| / 1.01 + |2| / 1.01 + 0.5 / 0.01, and 2 · 1 / 3.02 + 2 · 2 / 4.02 + 2 · 0.5 / 0.52.
    assert!((d.mape - (3.0 / 1.01 + 50.0) / 6.0).abs() < 1e-12);
    assert!((d.smape - (2.0 / 3.02 + 4.0 / 4.02 + 1.0 / 0.52) / 6.0).abs() < 1e-12);
    assert_eq!(d.ssim, None);
    // (0.2126 + 2 · 0.7152 + 3 · 0.0722 + 0.5 · 0.2126) / 2
    assert!((d.mean_luminance_a - (1.8596 + 0.1063) / 2.0).abs() < 1e-12);
    assert!((d.mean_luminance_b - 0.5).abs() < 1e-12);
    assert!((d.luminance_ratio.unwrap() - 1.9659).abs() < 1e-12);
    assert_eq!((d.largest, d.largest_at), (2.0, (0, 0)));
    assert_eq!((d.compared, d.non_finite_a, d.non_finite_b), (2, 0, 0));
}

#[test]
fn errors_of_pixels_make_the_error_of_the_picture() {
    let a = picture(3, 1, &[[1.0, 2.0, 3.0], [0.5, 0.0, 0.0], [f32::NAN; 3]]);
    let b = picture(3, 1, &[[1.0, 1.0, 1.0], [0.0; 3], [0.0; 3]]);
    let map = error_map(&a, &b).unwrap();
    assert!((f64::from(map[0]) - (5.0 / 1.01 / 3.0f64).sqrt()).abs() < 1e-6);
    assert!(map[2].is_nan());
    let mean = map[..2]
        .iter()
        .map(|error| f64::from(error * error))
        .sum::<f64>()
        / 2.0;
    assert!((mean / difference(&a, &b).unwrap().rel_mse - 1.0).abs() < 1e-6);
}

#[test]
fn the_same_picture_differs_in_nothing() {
    let a = picture(3, 2, &[[0.2, 0.4, 0.8]; 6]);
    let d = difference(&a, &a).unwrap();
    assert_eq!((d.rmse, d.rel_mse, d.largest, d.flip), (0.0, 0.0, 0.0, 0.0));
    assert_eq!((d.mape, d.smape, d.hdr_flip), (0.0, 0.0, Some(0.0)));
    assert_eq!(d.luminance_ratio, Some(1.0));
}

#[test]
fn pixels_that_are_not_finite_are_counted_and_left_out() {
    let a = picture(
        3,
        1,
        &[[f32::NAN, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]],
    );
    let b = picture(
        3,
        1,
        &[[0.0, 0.0, 0.0], [0.0, f32::INFINITY, 0.0], [1.0, 1.0, 1.0]],
    );
    let d = difference(&a, &b).unwrap();
    assert_eq!((d.compared, d.non_finite_a, d.non_finite_b), (1, 1, 1));
    assert_eq!(d.rmse, 1.0);
    assert!((d.luminance_ratio.unwrap() - 2.0).abs() < 1e-12);
    assert!(d.flip.is_finite());
    let nothing = picture(3, 1, &[[f32::NAN; 3]; 3]);
    assert!(matches!(
        difference(&nothing, &b),
        Err(MeasureError::NothingFinite)
    ));
}

#[test]
fn flip_sees_what_one_sees() {
    let black = picture(32, 32, &[[0.0; 3]; 1024]);
    let white = picture(32, 32, &[[1.0; 3]; 1024]);
    // Andersson et al. 2020, "FLIP: A difference evaluator for alternating images": white and black
    // are 100 apart in HyAB, 100^0.7 = 25.12; the largest, green and blue, 41.28. Beyond 0.4 of
    // that the error grows from 0.95 to 1: 0.95 + 0.05 (25.12 - 16.51) / (41.28 - 16.51) = 0.9674.
    let d = difference(&white, &black).unwrap();
    assert!((d.flip - 0.9674).abs() < 1e-3, "{}", d.flip);
    // Above 1 there is nothing more to see.
    let brighter = picture(32, 32, &[[5.0; 3]; 1024]);
    assert_eq!(difference(&brighter, &white).unwrap().flip, 0.0);
}

#[test]
fn sizes_and_encodings_must_agree() {
    let a = picture(2, 1, &[[0.0; 3]; 2]);
    let b = picture(1, 2, &[[0.0; 3]; 2]);
    assert!(matches!(
        difference(&a, &b),
        Err(MeasureError::DifferentSizes { .. })
    ));
    let shown = RgbImage {
        encoding: Encoding::Display,
        ..a.clone()
    };
    assert!(matches!(
        difference(&a, &shown),
        Err(MeasureError::DifferentEncodings)
    ));
}

#[test]
fn display_values() {
    // sRGB of linear 0.18 is 0.46136.
    let shown = picture(1, 1, &[[0.18, -1.0, 7.0]]).shown();
    assert_eq!(shown.encoding, Encoding::Display);
    assert!((shown.pixels[0][0] - 0.461_36).abs() < 1e-5);
    assert_eq!(shown.pixels[0][1], 0.0);
    assert!((shown.pixels[0][2] - 1.0).abs() < 1e-6);
    assert_eq!(shown.shown(), shown);
}

#[test]
fn what_one_sees_is_of_the_pictures_shown() {
    // Half and full light, which a view may show alike.
    let a = picture(20, 20, &[[0.5; 3]; 400]);
    let b = picture(20, 20, &[[1.0; 3]; 400]);
    let seen = difference(&a, &b).unwrap();
    let alike = difference_as_shown(&a, &b, &b.shown(), &b.shown()).unwrap();
    assert!(seen.flip > 0.1 && seen.ssim.unwrap() < 1.0);
    assert!(alike.flip == 0.0 && (alike.ssim.unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(seen.hdr_flip, alike.hdr_flip);
    assert_eq!(seen.rmse, alike.rmse);
    // Display values have no exposures.
    let d = difference(&a.shown(), &b.shown()).unwrap();
    assert_eq!((d.hdr_flip, d.hdr_flip_exposures), (None, None));
    assert!((d.flip - seen.flip).abs() < 1e-6);
    let small = picture(1, 1, &[[0.0; 3]]);
    assert!(matches!(
        difference_as_shown(&a, &b, &small, &small),
        Err(MeasureError::DifferentSizes { .. })
    ));
}
