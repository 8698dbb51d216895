//! RMSE, relMSE, luminance ratio and FLIP.

use super::{Encoding, MeasureError, Picture};
use crate::math::LUMINANCE;
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, flip};
use serde::Serialize;

/// Keeps relMSE finite where the reference is black. The project's goals are stated with this offset.
const REL_MSE_OFFSET: f64 = 0.01;

/// How far picture `a` is from the reference `b`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What the numbers of both pictures mean.
    pub encoding: Encoding,
    /// Root of the mean over pixels and channels of (a - b)².
    pub rmse: f64,
    /// Mean over pixels and channels of (a - b)² / (b² + 0.01).
    pub rel_mse: f64,
    /// Largest |a - b|.
    pub largest: f64,
    /// Where it is: column and row.
    pub largest_at: (u32, u32),
    /// Mean luminance of `a` (of display values where the pictures hold these).
    pub mean_luminance_a: f64,
    /// Mean luminance of `b`.
    pub mean_luminance_b: f64,
    /// Mean luminance of `a` over that of `b`; none if the reference is black.
    pub luminance_ratio: Option<f64>,
    /// Mean of LDR-FLIP (Andersson et al. 2020) at 67 pixels a degree.
    pub flip: f64,
    /// Pixels of `a` in which a number is not finite.
    pub non_finite_a: u64,
    /// Pixels of `b` in which a number is not finite.
    pub non_finite_b: u64,
    /// Pixels that are finite in both; all numbers but the sizes are about these.
    pub compared: u64,
}

/// Measures how far `a` is from the reference `b`. Pixels that are not finite in both are left out
/// (for FLIP they are black in both).
///
/// # Errors
/// The pictures differ in size or in what their numbers mean, or no pixel is finite in both.
pub fn difference(a: &Picture, b: &Picture) -> Result<Difference, MeasureError> {
    super::check_alike(a, b)?;
    let finite = |pixel: &[f32; 3]| pixel.iter().all(|value| value.is_finite());
    let (mut squares, mut relative_squares) = (0.0, 0.0);
    let (mut luminance_a, mut luminance_b) = (0.0, 0.0);
    let (mut largest, mut largest_index) = (0.0, 0);
    let (mut non_finite_a, mut non_finite_b, mut compared) = (0, 0, 0u64);
    for (index, (pixel_a, pixel_b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        let (finite_a, finite_b) = (finite(pixel_a), finite(pixel_b));
        non_finite_a += u64::from(!finite_a);
        non_finite_b += u64::from(!finite_b);
        if !finite_a || !finite_b {
            continue;
        }
        compared += 1;
        for channel in 0..3 {
            let (value_a, value_b) = (f64::from(pixel_a[channel]), f64::from(pixel_b[channel]));
            let error = value_a - value_b;
            squares += error * error;
            relative_squares += error * error / (value_b * value_b + REL_MSE_OFFSET);
            luminance_a += LUMINANCE[channel] * value_a;
            luminance_b += LUMINANCE[channel] * value_b;
            if error.abs() > largest {
                (largest, largest_index) = (error.abs(), index);
            }
        }
    }
    if compared == 0 {
        return Err(MeasureError::NothingFinite);
    }
    let pixels = compared as f64;
    let (mean_luminance_a, mean_luminance_b) = (luminance_a / pixels, luminance_b / pixels);
    let width = a.width as usize;
    Ok(Difference {
        width: a.width,
        height: a.height,
        encoding: a.encoding,
        rmse: (squares / (3.0 * pixels)).sqrt(),
        rel_mse: relative_squares / (3.0 * pixels),
        largest,
        largest_at: (
            (largest_index % width) as u32,
            (largest_index / width) as u32,
        ),
        mean_luminance_a,
        mean_luminance_b,
        luminance_ratio: (mean_luminance_b != 0.0).then(|| mean_luminance_a / mean_luminance_b),
        flip: mean_flip(a, b),
        non_finite_a,
        non_finite_b,
        compared,
    })
}

/// Mean FLIP of what one would see.
fn mean_flip(a: &Picture, b: &Picture) -> f64 {
    let (mut bytes_a, mut bytes_b) = (Vec::new(), Vec::new());
    for (pixel_a, pixel_b) in a.pixels.iter().zip(&b.pixels) {
        let finite = pixel_a.iter().chain(pixel_b).all(|value| value.is_finite());
        for channel in 0..3 {
            bytes_a.push(if finite {
                display_byte(pixel_a[channel], a.encoding)
            } else {
                0
            });
            bytes_b.push(if finite {
                display_byte(pixel_b[channel], b.encoding)
            } else {
                0
            });
        }
    }
    let test = FlipImageRgb8::with_data(a.width, a.height, &bytes_a);
    let reference = FlipImageRgb8::with_data(b.width, b.height, &bytes_b);
    let map = flip(reference, test, DEFAULT_PIXELS_PER_DEGREE).to_vec();
    map.iter().map(|value| f64::from(*value)).sum::<f64>() / map.len() as f64
}

/// The code value of 8 bits with which a number is shown: linear light is clipped to 0..1 and gets
/// the sRGB curve (IEC 61966-2-1), display values are what they are.
fn display_byte(value: f32, encoding: Encoding) -> u8 {
    let value = value.clamp(0.0, 1.0);
    let display = match encoding {
        Encoding::Display => value,
        Encoding::Linear if value <= 0.003_130_8 => value * 12.92,
        Encoding::Linear => 1.055 * value.powf(1.0 / 2.4) - 0.055,
    };
    (display * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32, pixels: &[[f32; 3]]) -> Picture {
        Picture {
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
        // (0.2126 + 2 · 0.7152 + 3 · 0.0722 + 0.5 · 0.2126) / 2
        assert!((d.mean_luminance_a - (1.8596 + 0.1063) / 2.0).abs() < 1e-12);
        assert!((d.mean_luminance_b - 0.5).abs() < 1e-12);
        assert!((d.luminance_ratio.unwrap() - 1.9659).abs() < 1e-12);
        assert_eq!((d.largest, d.largest_at), (2.0, (0, 0)));
        assert_eq!((d.compared, d.non_finite_a, d.non_finite_b), (2, 0, 0));
    }

    #[test]
    fn the_same_picture_differs_in_nothing() {
        let a = picture(3, 2, &[[0.2, 0.4, 0.8]; 6]);
        let d = difference(&a, &a).unwrap();
        assert_eq!((d.rmse, d.rel_mse, d.largest, d.flip), (0.0, 0.0, 0.0, 0.0));
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
        let shown = Picture {
            encoding: Encoding::Display,
            ..a.clone()
        };
        assert!(matches!(
            difference(&a, &shown),
            Err(MeasureError::DifferentEncodings)
        ));
    }

    #[test]
    fn code_values() {
        assert_eq!(display_byte(0.5, Encoding::Display), 128);
        // sRGB of linear 0.18 is 0.46136, times 255: 117.65.
        assert_eq!(display_byte(0.18, Encoding::Linear), 118);
        assert_eq!(display_byte(-1.0, Encoding::Linear), 0);
        assert_eq!(display_byte(7.0, Encoding::Linear), 255);
    }
}
