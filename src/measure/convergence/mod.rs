//! Error against time: measures against a reference whose own noise is taken out, fits and times to equal error.

mod page;
mod peers;
mod study;

pub use page::Looks;
pub use peers::{Peer, PeerPicture};
pub use study::{Curve, Measured, Study};

use super::{Difference, Encoding, MeasureError, RgbImage, difference_as_shown};
use crate::math::float::REL_MSE_OFFSET;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What pictures are measured against.
pub struct Reference {
    /// What is taken for the truth.
    pub picture: RgbImage,
    /// What one sees of it.
    pub shown: RgbImage,
    /// The independent halves whose mean it is; none if there is a single picture.
    halves: Option<[RgbImage; 2]>,
}

/// Reads linear light of a given size.
///
/// # Errors
/// The file holds something else, or cannot be read.
pub fn load_light(path: &Path, size: (u32, u32)) -> Result<RgbImage, MeasureError> {
    let picture = super::load(path, None)?;
    let unfit = |reason: String| MeasureError::Unfit {
        path: path.display().to_string(),
        reason,
    };
    if picture.encoding != Encoding::Linear {
        return Err(unfit(
            "holds display values; errors are measured of linear light, which an EXR file keeps"
                .into(),
        ));
    }
    if (picture.width, picture.height) != size {
        return Err(unfit(format!(
            "has {} × {} pixels, but the scene is rendered with {} × {}; give --width and --height, or another picture",
            picture.width, picture.height, size.0, size.1
        )));
    }
    Ok(picture)
}

/// How far a picture is from a reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Mean of (x - r)², the reference's noise taken out if it has halves: it may then come out below 0, by noise.
    pub mse: f64,
    /// The same of (x - r)² / (r² + 0.01).
    pub rel_mse: f64,
    /// As in [`Difference`]; the reference's noise is in these.
    pub mape: f64,
    /// As in [`Difference`].
    pub smape: f64,
    /// As in [`Difference`].
    pub ssim: Option<f64>,
    /// As in [`Difference`].
    pub flip: f64,
    /// As in [`Difference`].
    pub hdr_flip: Option<f64>,
    /// Pixels that are not finite in the picture or in the reference, left out.
    pub non_finite: u64,
}

impl Reference {
    /// A single picture.
    pub fn single(picture: RgbImage, shown: RgbImage) -> Self {
        Self {
            picture,
            shown,
            halves: None,
        }
    }

    /// Of one file, or of two whose noise is independent; `show` says what one sees.
    ///
    /// # Errors
    /// A file cannot be read or is none of that size, or `show` fails.
    pub fn read<E: From<MeasureError>>(
        paths: &[PathBuf],
        size: (u32, u32),
        show: impl FnOnce(&RgbImage) -> Result<RgbImage, E>,
    ) -> Result<Self, E> {
        match paths {
            [a, b] => Self::halves([load_light(a, size)?, load_light(b, size)?], show),
            paths => {
                let path = paths.first().ok_or(MeasureError::NothingFinite)?;
                let picture = load_light(path, size)?;
                Ok(Self::single(picture.clone(), show(&picture)?))
            }
        }
    }

    /// Two pictures with independent noise; `show` says what one sees of their mean.
    ///
    /// # Errors
    /// They differ in size or in what their numbers mean, or `show` fails.
    pub fn halves<E: From<MeasureError>>(
        halves: [RgbImage; 2],
        show: impl FnOnce(&RgbImage) -> Result<RgbImage, E>,
    ) -> Result<Self, E> {
        super::check_alike(&halves[0], &halves[1])?;
        let pixels = halves[0]
            .pixels
            .iter()
            .zip(&halves[1].pixels)
            .map(|(a, b)| {
                std::array::from_fn(|c| (0.5 * (f64::from(a[c]) + f64::from(b[c]))) as f32)
            })
            .collect();
        let picture = RgbImage {
            pixels,
            ..halves[0]
        };
        Ok(Self {
            shown: show(&picture)?,
            picture,
            halves: Some(halves),
        })
    }

    /// The relMSE that the reference has itself, by the difference of its halves: E[(a - b)² / 4] is the variance of their
    /// mean. None of a single picture.
    pub fn own_rel_mse(&self) -> Option<f64> {
        let [a, b] = self.halves.as_ref()?;
        let (sum, count) = self.sum(|index, c, r| {
            let half = 0.5 * (f64::from(a.pixels[index][c]) - f64::from(b.pixels[index][c]));
            half * half / (r * r + REL_MSE_OFFSET)
        });
        (count > 0.0).then(|| sum / count)
    }

    /// The same in words.
    pub fn own_error(&self) -> String {
        match self.own_rel_mse() {
            Some(own) => format!(
                "; its own error is about {:.3} %, which is taken out of RMSE and relMSE",
                100.0 * own.sqrt()
            ),
            None => "; its own noise is not known and counts as error".into(),
        }
    }

    /// How far another reference lies from this one.
    ///
    /// # Errors
    /// The references differ in size or nothing is finite.
    pub fn between(&self, other: &Self) -> Result<Between, MeasureError> {
        super::check_alike(&self.picture, &other.picture)?;
        let at = |picture: &RgbImage, i: usize, c: usize| f64::from(picture.pixels[i][c]);
        let term = |i: usize, c: usize, r: f64| {
            let product = match (&self.halves, &other.halves) {
                (Some([a, b]), Some([x, y])) => {
                    (at(x, i, c) - at(a, i, c)) * (at(y, i, c) - at(b, i, c))
                }
                _ => (at(&other.picture, i, c) - r).powi(2),
            };
            product / (r * r + REL_MSE_OFFSET)
        };
        let (sum, count) = self.sum(term);
        let (squares, _) = self.sum(|i, c, r| term(i, c, r).powi(2));
        if count == 0.0 {
            return Err(MeasureError::NothingFinite);
        }
        let mean = sum / count;
        // The channels of a pixel share their paths: at worst there are as many independent terms as pixels.
        let variance = (squares / count - mean * mean).max(0.0);
        Ok(Between {
            rel_mse: mean,
            standard_error: (variance / (count / 3.0)).sqrt(),
            without_noise: self.halves.is_some() && other.halves.is_some(),
        })
    }

    /// The sum over the values that are finite, and their number.
    fn sum(&self, term: impl Fn(usize, usize, f64) -> f64) -> (f64, f64) {
        let (mut sum, mut count) = (0.0, 0.0);
        for (index, pixel) in self.picture.pixels.iter().enumerate() {
            let terms: [f64; 3] = std::array::from_fn(|c| term(index, c, f64::from(pixel[c])));
            if terms.iter().all(|term| term.is_finite()) {
                sum += terms.iter().sum::<f64>();
                count += 3.0;
            }
        }
        (sum, count)
    }

    /// Measures a picture. With halves a and b, (x - a)(x - b) takes the place of (x - r)²: its expectation is the square of
    /// what x is off the truth, because the noise of a and of b is independent of each other's and of x's.
    ///
    /// # Errors
    /// As [`super::difference`].
    pub fn errors(&self, picture: &RgbImage, shown: &RgbImage) -> Result<Errors, MeasureError> {
        let d: Difference = difference_as_shown(picture, &self.picture, shown, &self.shown)?;
        let (mut mse, mut rel_mse) = (d.rmse * d.rmse, d.rel_mse);
        if let Some([a, b]) = &self.halves {
            let product = |index: usize, c: usize| {
                let x = f64::from(picture.pixels[index][c]);
                (x - f64::from(a.pixels[index][c])) * (x - f64::from(b.pixels[index][c]))
            };
            let (sum, count) = self.sum(|index, c, _| product(index, c));
            mse = sum / count;
            let (sum, count) = self.sum(|index, c, r| product(index, c) / (r * r + REL_MSE_OFFSET));
            rel_mse = sum / count;
        }
        Ok(Errors {
            mse,
            rel_mse,
            mape: d.mape,
            smape: d.smape,
            ssim: d.ssim,
            flip: d.flip,
            hdr_flip: d.hdr_flip,
            non_finite: u64::from(d.width) * u64::from(d.height) - d.compared,
        })
    }
}

/// How far two renderers' references lie apart: their bias against each other, if their noise is taken out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Between {
    /// relMSE of the one against the other; by noise it may be below 0.
    pub rel_mse: f64,
    /// What noise may add to it or take away: one standard error, if pixels are independent.
    pub standard_error: f64,
    /// Whether both references have halves, so that their noise is not in it.
    pub without_noise: bool,
}

impl std::fmt::Display for Between {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let noise = if self.without_noise {
            "their noise taken out"
        } else {
            "their noise included"
        };
        write!(
            f,
            "its reference is {:.3} % off from the common one ({noise}: relMSE {:.2e} ± {:.1e})",
            100.0 * self.rel_mse.max(0.0).sqrt(),
            self.rel_mse,
            self.standard_error
        )
    }
}

/// A power law: error = factor × time^slope.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerLaw {
    /// Error at a time of 1.
    pub factor: f64,
    /// -0.5 for independent samples.
    pub slope: f64,
    /// Standard error of the slope; none of two points.
    pub slope_error: Option<f64>,
}

/// The slope with its standard error.
impl std::fmt::Display for PowerLaw {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:+.3}", self.slope)?;
        match self.slope_error {
            Some(error) => write!(f, " ± {error:.3}"),
            None => Ok(()),
        }
    }
}

impl PowerLaw {
    /// Least squares of log error against log time; points that are not positive are left out. None of less than two times.
    pub fn fit(points: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let logs: Vec<(f64, f64)> = points
            .into_iter()
            .filter(|(x, y)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite())
            .map(|(x, y)| (x.ln(), y.ln()))
            .collect();
        let count = logs.len() as f64;
        let mean_x = logs.iter().map(|(x, _)| x).sum::<f64>() / count;
        let mean_y = logs.iter().map(|(_, y)| y).sum::<f64>() / count;
        let square: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
        // Times that differ in their last bits alone say nothing about a slope.
        if logs.len() < 2 || square <= count * (1e-12 * (1.0 + mean_x.abs())).powi(2) {
            return None;
        }
        let slope = logs
            .iter()
            .map(|(x, y)| (x - mean_x) * (y - mean_y))
            .sum::<f64>()
            / square;
        let rest: f64 = logs
            .iter()
            .map(|(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2))
            .sum();
        Some(Self {
            factor: (mean_y - slope * mean_x).exp(),
            slope,
            slope_error: (logs.len() > 2).then(|| (rest / (count - 2.0) / square).sqrt()),
        })
    }

    /// The error at a time.
    pub fn at(&self, time: f64) -> f64 {
        self.factor * time.powf(self.slope)
    }
}

/// When a curve of (time, error) first comes down to an error, by log-log interpolation; none if it begins below or never
/// gets there: nothing is extrapolated.
pub fn time_to(curve: &[(f64, f64)], error: f64) -> Option<f64> {
    let (first, _) = (curve.first()?, curve.last()?);
    if first.1 < error {
        return None;
    }
    if first.1 == error {
        return Some(first.0);
    }
    curve.windows(2).find_map(|pair| {
        let [(t0, e0), (t1, e1)] = [pair[0], pair[1]];
        (e1 <= error && e0 > error).then(|| {
            let share = (e0.ln() - error.ln()) / (e0.ln() - e1.ln());
            (t0.ln() + share * (t1.ln() - t0.ln())).exp()
        })
    })
}

/// How much longer one curve takes than another one to equal error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeRatio {
    /// The errors that both curves reach, from here …
    pub highest_error: f64,
    /// … to here.
    pub lowest_error: f64,
    /// Time of the second curve over that of the first one: geometric mean over the errors between, evenly in the logarithm.
    pub ratio: f64,
    /// The least of the ratios between.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

/// Compares times to equal error; none if no error is reached by both.
pub fn time_ratio(ours: &[(f64, f64)], theirs: &[(f64, f64)]) -> Option<TimeRatio> {
    const STEPS: u32 = 64;
    let lowest = |curve: &[(f64, f64)]| curve.iter().map(|p| p.1).reduce(f64::min);
    let highest_error = ours.first()?.1.min(theirs.first()?.1);
    let lowest_error = lowest(ours)?.max(lowest(theirs)?);
    if lowest_error >= highest_error || lowest_error <= 0.0 {
        return None;
    }
    let ratios: Vec<f64> = (0..=STEPS)
        .filter_map(|step| {
            let share = f64::from(step) / f64::from(STEPS);
            // The ends exactly, where rounding would fall beside a curve.
            let error = match step {
                0 => highest_error,
                STEPS => lowest_error,
                _ => highest_error.powf(1.0 - share) * lowest_error.powf(share),
            };
            Some(time_to(theirs, error)? / time_to(ours, error)?)
        })
        .collect();
    let mean = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64;
    Some(TimeRatio {
        highest_error,
        lowest_error,
        ratio: mean.exp(),
        least: ratios.iter().copied().reduce(f64::min)?,
        greatest: ratios.iter().copied().reduce(f64::max)?,
    })
}
