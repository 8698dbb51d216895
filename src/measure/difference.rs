//! RMSE, relMSE, MAPE, SMAPE, luminance ratio; SSIM and FLIP of what one sees.

use super::flip::{self, Exposures};
use super::{Encoding, MeasureError, Picture, ssim};
use crate::math::LUMINANCE;
use rayon::prelude::*;
use serde::Serialize;

/// Keeps relMSE finite where the reference is black. The project's goals are stated with this offset.
const REL_MSE_OFFSET: f64 = 0.01;

/// Keeps MAPE and SMAPE finite, as the image viewers tev (its "Relative Absolute Error") and JERI of Disney Research
/// ("MAPE", "SMAPE") have it.
const PERCENTAGE_OFFSET: f64 = 0.01;

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
    /// Mean over pixels and channels of (a - b)² / (b² + 0.01): the relative MSE that Rousselle et al. 2011 ("Adaptive
    /// Sampling and Reconstruction using Greedy Error Minimization") introduced.
    pub rel_mse: f64,
    /// Mean over pixels and channels of |a - b| / (|b| + 0.01): MAPE as tev and JERI have it. A share: 0.02 is 2 %.
    pub mape: f64,
    /// Mean over pixels and channels of 2 |a - b| / (|a| + |b| + 0.02): SMAPE as JERI has it, 0..=2. (Vogels et al. 2018,
    /// "Denoising with Kernel Prediction and Asymmetric Loss Functions", train with half of it and the offset 0.01.)
    pub smape: f64,
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
    /// Mean structural similarity of display values (see [`super::ssim`]); none if a side has less than 11 pixels.
    pub ssim: Option<f64>,
    /// Mean of LDR-FLIP at 67 pixels a degree, of display values taken as sRGB (see [`super::flip`]).
    pub flip: f64,
    /// Mean of HDR-FLIP at 67 pixels a degree, tone mapped by ACES; none of display values and of a black reference.
    pub hdr_flip: Option<f64>,
    /// Its exposures, by the reference.
    pub hdr_flip_exposures: Option<Exposures>,
    /// Pixels of `a` in which a number is not finite.
    pub non_finite_a: u64,
    /// Pixels of `b` in which a number is not finite.
    pub non_finite_b: u64,
    /// Pixels that are finite in both; all numbers but the sizes are about these.
    pub compared: u64,
}

/// Measures how far `a` is from the reference `b`, with linear light shown by the sRGB curve. Pixels that are not finite in
/// both are left out (for SSIM and FLIP they are black in both).
///
/// # Errors
/// The pictures differ in size or in what their numbers mean, or no pixel is finite in both.
pub fn difference(a: &Picture, b: &Picture) -> Result<Difference, MeasureError> {
    difference_as_shown(a, b, &a.shown(), &b.shown())
}

/// As [`difference`], with the display values that one sees of each.
///
/// # Errors
/// As [`difference`]; `shown_a` and `shown_b` must have the size of the pictures.
pub fn difference_as_shown(
    a: &Picture,
    b: &Picture,
    shown_a: &Picture,
    shown_b: &Picture,
) -> Result<Difference, MeasureError> {
    let mut difference = by_numbers(a, b)?;
    super::check_sizes(a, shown_a)?;
    super::check_sizes(b, shown_b)?;
    let (width, height) = (a.width as usize, a.height as usize);
    let pictures = [a, b, shown_a, shown_b];
    difference.ssim = ssim::ssim(width, height, &|at| display_values(pictures, at));
    difference.flip = mean(&flip_map(pictures));
    if a.encoding == Encoding::Linear {
        let light = |at: usize| {
            if both_finite(a, b, at) {
                [b.pixels[at], a.pixels[at]]
            } else {
                [[0.0; 3]; 2]
            }
        };
        let exposures = Exposures::of((0..width * height).map(|at| light(at)[0]));
        difference.hdr_flip =
            exposures.map(|exposures| mean(&flip::hdr(width, height, exposures, &light)));
        difference.hdr_flip_exposures = exposures;
    }
    Ok(difference)
}

/// LDR-FLIP of each pixel, for the pictures and the display values that one sees of them, all of one size.
pub fn flip_map(pictures: [&Picture; 4]) -> Vec<f32> {
    let (width, height) = (pictures[0].width as usize, pictures[0].height as usize);
    // FLIP asks for each pixel more than once.
    let [test, reference] = [0, 1].map(|which| -> Vec<[f32; 3]> {
        (0..width * height)
            .into_par_iter()
            .map(|at| display_values(pictures, at)[which].map(srgb_to_linear))
            .collect()
    });
    flip::ldr(width, height, &|at| [reference[at], test[at]])
}

/// What one sees of a pixel of both pictures; black if it is not finite in one of them.
fn display_values([a, b, shown_a, shown_b]: [&Picture; 4], at: usize) -> [[f32; 3]; 2] {
    if both_finite(a, b, at) && both_finite(shown_a, shown_b, at) {
        [shown_a.pixels[at], shown_b.pixels[at]]
            .map(|pixel| pixel.map(|value| value.clamp(0.0, 1.0)))
    } else {
        [[0.0; 3]; 2]
    }
}

/// The error of each pixel: the root of the mean over the channels of (a - b)² / (b² + 0.01). Not a number where one of the
/// pictures is not finite.
///
/// # Errors
/// The pictures differ in size or in what their numbers mean.
pub fn error_map(a: &Picture, b: &Picture) -> Result<Vec<f32>, MeasureError> {
    super::check_alike(a, b)?;
    let error = |(pixel_a, pixel_b): (&[f32; 3], &[f32; 3])| {
        if !finite(pixel_a) || !finite(pixel_b) {
            return f32::NAN;
        }
        let squares = pixel_a.iter().zip(pixel_b).map(|(a, b)| {
            let (a, b) = (f64::from(*a), f64::from(*b));
            (a - b) * (a - b) / (b * b + REL_MSE_OFFSET)
        });
        (squares.sum::<f64>() / 3.0).sqrt() as f32
    };
    Ok(a.pixels.iter().zip(&b.pixels).map(error).collect())
}

/// The difference without what one sees, which is still to be filled in.
fn by_numbers(a: &Picture, b: &Picture) -> Result<Difference, MeasureError> {
    super::check_alike(a, b)?;
    let (mut squares, mut relative_squares) = (0.0, 0.0);
    let (mut shares, mut symmetric_shares) = (0.0, 0.0);
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
            shares += error.abs() / (value_b.abs() + PERCENTAGE_OFFSET);
            symmetric_shares +=
                2.0 * error.abs() / (value_a.abs() + value_b.abs() + 2.0 * PERCENTAGE_OFFSET);
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
        mape: shares / (3.0 * pixels),
        smape: symmetric_shares / (3.0 * pixels),
        largest,
        largest_at: (
            (largest_index % width) as u32,
            (largest_index / width) as u32,
        ),
        mean_luminance_a,
        mean_luminance_b,
        luminance_ratio: (mean_luminance_b != 0.0).then(|| mean_luminance_a / mean_luminance_b),
        ssim: None,
        flip: 0.0,
        hdr_flip: None,
        hdr_flip_exposures: None,
        non_finite_a,
        non_finite_b,
        compared,
    })
}

fn finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|value| value.is_finite())
}

fn both_finite(a: &Picture, b: &Picture, at: usize) -> bool {
    finite(&a.pixels[at]) && finite(&b.pixels[at])
}

fn mean(map: &[f32]) -> f64 {
    map.iter().map(|value| f64::from(*value)).sum::<f64>() / map.len() as f64
}

impl Picture {
    /// What one sees without a view: linear light is clipped to 0..=1 and gets the sRGB curve (IEC 61966-2-1), which is
    /// Blender's view "Standard" on an sRGB display; display values are what they are.
    pub fn shown(&self) -> Self {
        match self.encoding {
            Encoding::Display => self.clone(),
            Encoding::Linear => Self {
                encoding: Encoding::Display,
                pixels: self
                    .pixels
                    .iter()
                    .map(|pixel| pixel.map(linear_to_srgb))
                    .collect(),
                ..*self
            },
        }
    }
}

fn linear_to_srgb(value: f32) -> f32 {
    let value = value.clamp(0.0, 1.0);
    if value <= 0.003_130_8 {
        value * 12.92
    } else {
        1.055 * value.powf(1.0 / 2.4) - 0.055
    }
}

fn srgb_to_linear(value: f32) -> f32 {
    if value <= 0.040_45 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
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
    fn display_values() {
        // sRGB of linear 0.18 is 0.46136.
        let shown = picture(1, 1, &[[0.18, -1.0, 7.0]]).shown();
        assert_eq!(shown.encoding, Encoding::Display);
        assert!((shown.pixels[0][0] - 0.461_36).abs() < 1e-5);
        assert_eq!(shown.pixels[0][1], 0.0);
        assert!((shown.pixels[0][2] - 1.0).abs() < 1e-6);
        assert_eq!(shown.shown(), shown);
        for value in [0.0, 0.001, 0.003, 0.2, 0.9, 1.0] {
            assert!((srgb_to_linear(linear_to_srgb(value)) - value).abs() < 1e-6);
        }
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
}
