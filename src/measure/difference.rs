//! RMSE, relMSE, MAPE, SMAPE, luminance ratio; SSIM and FLIP of what one sees.

use super::flip::{self, Exposures};
use super::{Encoding, MeasureError, RgbImage, ssim};
use crate::math::float::REL_MSE_OFFSET;
use crate::math::words::grouped;
use crate::math::{LUMINANCE, srgb};
use crate::report::{self, HeatMap};
use rayon::prelude::*;
use serde::Serialize;

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

impl Difference {
    /// The error as it is usually told: √relMSE in percent.
    pub fn error_percent(&self) -> f64 {
        100.0 * self.rel_mse.sqrt()
    }
}

/// Measures how far `a` is from the reference `b`, with linear light shown by the sRGB curve. Pixels that are not finite in
/// both are left out (for SSIM and FLIP they are black in both).
///
/// # Errors
/// The pictures differ in size or in what their numbers mean, or no pixel is finite in both.
pub fn difference(a: &RgbImage, b: &RgbImage) -> Result<Difference, MeasureError> {
    difference_as_shown(a, b, &a.shown(), &b.shown())
}

/// As [`difference`], with the display values that one sees of each.
///
/// # Errors
/// As [`difference`]; `shown_a` and `shown_b` must have the size of the pictures.
pub fn difference_as_shown(
    a: &RgbImage,
    b: &RgbImage,
    shown_a: &RgbImage,
    shown_b: &RgbImage,
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
pub fn flip_map(pictures: [&RgbImage; 4]) -> Vec<f32> {
    let (width, height) = (pictures[0].width as usize, pictures[0].height as usize);
    // FLIP asks for each pixel more than once.
    let [test, reference] = [0, 1].map(|which| -> Vec<[f32; 3]> {
        (0..width * height)
            .into_par_iter()
            .map(|at| display_values(pictures, at)[which].map(srgb::decode))
            .collect()
    });
    flip::ldr(width, height, &|at| [reference[at], test[at]])
}

/// What one sees of a pixel of both pictures; black if it is not finite in one of them.
fn display_values([a, b, shown_a, shown_b]: [&RgbImage; 4], at: usize) -> [[f32; 3]; 2] {
    if both_finite(a, b, at) && both_finite(shown_a, shown_b, at) {
        [shown_a.pixels[at], shown_b.pixels[at]]
            .map(|pixel| pixel.map(|value| value.clamp(0.0, 1.0)))
    } else {
        [[0.0; 3]; 2]
    }
}

/// The mean over the channels of |a - b| for each pixel, up to a round number that at most 0.1 % of the pixels exceed.
///
/// # Errors
/// The pictures differ in size or in what their numbers mean.
pub fn difference_map(a: &RgbImage, b: &RgbImage) -> Result<HeatMap, MeasureError> {
    super::check_alike(a, b)?;
    let distance = |(pixel_a, pixel_b): (&[f32; 3], &[f32; 3])| {
        let distances = pixel_a.iter().zip(pixel_b);
        let sum: f64 = distances
            .map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs())
            .sum();
        (sum / 3.0) as f32
    };
    let map = HeatMap {
        name: "difference".into(),
        width: a.width,
        height: a.height,
        values: a.pixels.iter().zip(&b.pixels).map(distance).collect(),
        ..HeatMap::default()
    };
    Ok(map.with_round_end())
}

/// The error of each pixel: the root of the mean over the channels of (a - b)² / (b² + 0.01). Not a number where one of the
/// pictures is not finite.
///
/// # Errors
/// The pictures differ in size or in what their numbers mean.
pub fn error_map(a: &RgbImage, b: &RgbImage) -> Result<Vec<f32>, MeasureError> {
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
fn by_numbers(a: &RgbImage, b: &RgbImage) -> Result<Difference, MeasureError> {
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

fn both_finite(a: &RgbImage, b: &RgbImage, at: usize) -> bool {
    finite(&a.pixels[at]) && finite(&b.pixels[at])
}

fn mean(map: &[f32]) -> f64 {
    map.iter().map(|value| f64::from(*value)).sum::<f64>() / map.len() as f64
}

impl RgbImage {
    /// Display values as codes of 8 bits, for a page.
    pub fn as_codes(&self, name: impl Into<String>) -> report::PageImage {
        let code = |value: &f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
        report::PageImage {
            name: name.into(),
            width: self.width,
            height: self.height,
            rgb: self.pixels.iter().flatten().map(code).collect(),
        }
    }

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
                    .map(|pixel| pixel.map(srgb::encode))
                    .collect(),
                ..*self
            },
        }
    }
}

impl Difference {
    /// The lines of `sundog compare`, with what one sees of the pictures in words.
    pub fn text(&self, seen: &str) -> String {
        let d = self;
        let ratio = match d.luminance_ratio {
            Some(ratio) => format!(
                "{ratio:.6} ({:.6} / {:.6})",
                d.mean_luminance_a, d.mean_luminance_b
            ),
            None => format!("none, the reference is black ({:.6})", d.mean_luminance_a),
        };
        let given = |value: Option<f64>, none: &str| {
            value.map_or_else(|| none.to_owned(), |value| format!("{value:.6}"))
        };
        let hdr = match (d.encoding, d.hdr_flip_exposures) {
            (Encoding::Display, _) => "none, display values have no exposures".to_owned(),
            (_, None) => "none, the reference is black".to_owned(),
            (_, Some(exposures)) => format!(
                "{} ({} exposures from {:+.2} to {:+.2} stops)",
                given(d.hdr_flip, ""),
                exposures.count,
                exposures.start,
                exposures.stop
            ),
        };
        let mut text = format!(
            "RMSE             {:.6e}\nrelMSE           {:.6e} (error {:.3} %)\nMAPE             {:.6e}\nSMAPE            {:.6e}\nmean luminance   {ratio}\nlargest          {:.6e} at {}, {}\nSSIM             {}\nFLIP             {:.6}\nHDR-FLIP         {hdr}\nseen             {}\n",
            d.rmse,
            d.rel_mse,
            d.error_percent(),
            d.mape,
            d.smape,
            d.largest,
            d.largest_at.0,
            d.largest_at.1,
            given(d.ssim, "none, a side has less than 11 pixels"),
            d.flip,
            seen,
        );
        if d.non_finite_a + d.non_finite_b > 0 {
            text.push_str(&format!(
                "not finite       {} and {} pixels, left out of {}\n",
                grouped(d.non_finite_a),
                grouped(d.non_finite_b),
                grouped(u64::from(d.width) * u64::from(d.height))
            ));
        }
        text
    }
}
