//! Numbers of all seeds together: means and spreads, slopes, times to equal error.

use super::{Between, Errors, PowerLaw, TimeRatio, time_ratio, time_to};
use crate::report::number;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// One picture's errors.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// Which run it belongs to.
    pub seed: u64,
    /// Samples a pixel.
    pub samples: u32,
    /// Seconds of path tracing.
    pub seconds: f64,
    /// How far it is off.
    #[serde(flatten)]
    pub errors: Errors,
}

/// A measure, and how it is shown.
pub struct Measure {
    /// In JSON and CSV.
    pub key: &'static str,
    /// In tables and plots.
    pub name: &'static str,
    /// `%` or nothing.
    pub unit: &'static str,
    /// What it is.
    pub doc: &'static str,
    /// The number that is averaged over seeds.
    value: fn(&Errors) -> Option<f64>,
    /// From that mean to the measure.
    shown: fn(f64) -> f64,
    /// What goes to 0 as the picture converges.
    pub error: fn(f64) -> f64,
}

fn same(value: f64) -> f64 {
    value
}

/// All measures, in the order in which they are told.
pub const MEASURES: [Measure; 8] = [
    Measure {
        key: "rmse",
        name: "RMSE",
        unit: "",
        doc: "root of the mean of (x - r)²; of several seeds the root of the mean square",
        value: |errors| Some(errors.mse),
        shown: f64::sqrt,
        error: same,
    },
    Measure {
        key: "rel_mse",
        name: "relMSE",
        unit: "",
        doc: "mean of (x - r)² / (r² + 0.01)",
        value: |errors| Some(errors.rel_mse),
        shown: same,
        error: same,
    },
    Measure {
        key: "error_percent",
        name: "error",
        unit: "%",
        doc: "√relMSE in percent",
        value: |errors| Some(errors.rel_mse),
        shown: |mean| 100.0 * mean.sqrt(),
        error: same,
    },
    Measure {
        key: "mape",
        name: "MAPE",
        unit: "",
        doc: "mean of |x - r| / (|r| + 0.01)",
        value: |errors| Some(errors.mape),
        shown: same,
        error: same,
    },
    Measure {
        key: "smape",
        name: "SMAPE",
        unit: "",
        doc: "mean of 2 |x - r| / (|x| + |r| + 0.02)",
        value: |errors| Some(errors.smape),
        shown: same,
        error: same,
    },
    Measure {
        key: "ssim",
        name: "SSIM",
        unit: "",
        doc: "structural similarity of what one sees after the view",
        value: |errors| errors.ssim,
        shown: same,
        error: |value| 1.0 - value,
    },
    Measure {
        key: "flip",
        name: "FLIP",
        unit: "",
        doc: "mean of LDR-FLIP of what one sees after the view",
        value: |errors| Some(errors.flip),
        shown: same,
        error: same,
    },
    Measure {
        key: "hdr_flip",
        name: "HDR-FLIP",
        unit: "",
        doc: "mean of HDR-FLIP of linear light",
        value: |errors| errors.hdr_flip,
        shown: same,
        error: same,
    },
];

/// The measure whose equal values are compared.
pub const MAIN: &str = "error_percent";

/// A measure over the seeds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Spread {
    /// Its mean (of mean squares where it is a root of one).
    pub mean: f64,
    /// Standard deviation over the seeds; none of a single one.
    pub deviation: Option<f64>,
}

/// All seeds with one number of samples.
#[derive(Clone, Debug, Serialize)]
pub struct SampleRow {
    /// Samples a pixel.
    pub samples: u32,
    /// How many seeds.
    pub seeds: usize,
    /// Mean seconds.
    pub seconds: f64,
    /// Each measure by its key; none where it cannot be told (noise below the reference's, black references, tiny pictures).
    #[serde(flatten)]
    pub measures: BTreeMap<&'static str, Option<Spread>>,
    /// Seconds × MSE: does not depend on the time for independent samples.
    pub seconds_times_mse: f64,
    /// Seconds × relMSE.
    pub seconds_times_rel_mse: f64,
}

/// A renderer's pictures.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// The renderer.
    pub name: String,
    /// What its pictures are measured against.
    pub reference: String,
    /// How far that reference lies from the common one, where it is another one.
    pub reference_apart: Option<Between>,
    /// Every picture.
    pub points: Vec<Measured>,
    /// By samples.
    pub rows: Vec<SampleRow>,
    /// Fitted error against time, by the key of the measure.
    pub slopes: BTreeMap<&'static str, PowerLaw>,
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Standard deviation by n - 1; none of a single value.
fn deviation(values: &[f64]) -> Option<f64> {
    let middle = mean(values.iter().copied());
    let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

impl Measure {
    fn spread(&self, points: &[&Measured]) -> Option<Spread> {
        let values: Vec<f64> = points
            .iter()
            .map(|point| (self.value)(&point.errors))
            .collect::<Option<_>>()?;
        let middle = (self.shown)(mean(values.iter().copied()));
        let shown: Vec<f64> = values.into_iter().map(self.shown).collect();
        middle.is_finite().then(|| Spread {
            mean: middle,
            deviation: deviation(&shown).filter(|deviation| deviation.is_finite()),
        })
    }

    /// The law of the mean error over the seeds, with the slope's standard error from the seeds' own slopes where there are
    /// two or more (the pictures of one run share samples, so that their residuals are not independent).
    fn law(&self, points: &[Measured], rows: &[SampleRow]) -> Option<PowerLaw> {
        let together = PowerLaw::fit(rows.iter().filter_map(|row| {
            let spread = (*row.measures.get(self.key)?)?;
            Some((row.seconds, (self.error)(spread.mean)))
        }))?;
        let mut seeds: Vec<u64> = points.iter().map(|point| point.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        let slopes: Vec<f64> = seeds
            .iter()
            .filter_map(|seed| {
                PowerLaw::fit(
                    points
                        .iter()
                        .filter(|p| p.seed == *seed)
                        .filter_map(|point| {
                            let value = (self.value)(&point.errors)?;
                            Some((point.seconds, (self.error)((self.shown)(value))))
                        }),
                )
            })
            .map(|law| law.slope)
            .collect();
        let by_seeds = deviation(&slopes).map(|deviation| deviation / (slopes.len() as f64).sqrt());
        Some(PowerLaw {
            slope_error: by_seeds.or(together.slope_error),
            ..together
        })
    }
}

impl Curve {
    /// Of all its pictures, measured against a reference.
    pub fn new(name: String, reference: String, points: Vec<Measured>) -> Self {
        let mut by_samples: BTreeMap<u32, Vec<&Measured>> = BTreeMap::new();
        for point in &points {
            by_samples.entry(point.samples).or_default().push(point);
        }
        let rows: Vec<SampleRow> = by_samples
            .into_iter()
            .map(|(samples, points)| {
                let of =
                    |value: fn(&Measured) -> f64| mean(points.iter().map(|point| value(point)));
                let seconds = of(|point| point.seconds);
                SampleRow {
                    samples,
                    seeds: points.len(),
                    seconds,
                    measures: MEASURES
                        .iter()
                        .map(|measure| (measure.key, measure.spread(&points)))
                        .collect(),
                    seconds_times_mse: seconds * of(|point| point.errors.mse),
                    seconds_times_rel_mse: seconds * of(|point| point.errors.rel_mse),
                }
            })
            .collect();
        let slopes = MEASURES
            .iter()
            .filter_map(|measure| Some((measure.key, measure.law(&points, &rows)?)))
            .collect();
        Self {
            name,
            reference,
            reference_apart: None,
            points,
            rows,
            slopes,
        }
    }

    /// Mean seconds and mean of a measure.
    pub fn against_time(&self, measure: &Measure) -> Vec<(f64, f64)> {
        self.rows
            .iter()
            .filter_map(|row| {
                let spread = (*row.measures.get(measure.key)?)?;
                let error = (measure.error)(spread.mean);
                (error > 0.0).then_some((row.seconds, error))
            })
            .collect()
    }
}

/// Time to equal error of another renderer.
#[derive(Clone, Debug, Serialize)]
pub struct Against {
    /// The other one.
    pub renderer: String,
    /// Over all errors that both reach.
    pub overall: Option<TimeRatio>,
    /// Standard error of the logarithm of that ratio: by leaving out each seed once (jackknife). None where a renderer has a
    /// single seed.
    pub ratio_error: Option<f64>,
    /// At some errors.
    pub at: Vec<EqualError>,
}

/// When both renderers reach an error.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EqualError {
    /// In percent.
    pub error_percent: f64,
    /// Seconds of this renderer.
    pub seconds: f64,
    /// Of the other one.
    pub their_seconds: f64,
    /// Theirs over this one's.
    pub ratio: f64,
}

/// All that was found.
#[derive(Debug, Serialize)]
pub struct Study {
    /// The file.
    pub scene: String,
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What is seen for SSIM and FLIP.
    pub view: String,
    /// How this renderer's pictures are rendered.
    pub settings: serde_json::Value,
    /// How many trace paths.
    pub threads: usize,
    /// Of Sundog.
    pub version: String,
    /// What is taken for the truth, in words.
    pub reference: String,
    /// This renderer first.
    pub renderers: Vec<Curve>,
    /// The others against it; filled in by [`Study::compare`].
    pub against: Vec<Against>,
}

pub(super) fn main_measure() -> &'static Measure {
    let is_main = |measure: &&Measure| measure.key == MAIN;
    MEASURES.iter().find(is_main).unwrap_or(&MEASURES[0])
}

impl Study {
    /// Compares all other renderers with the first one.
    pub fn compare(&mut self) {
        let measure = main_measure();
        let Some((ours, others)) = self.renderers.split_first() else {
            return;
        };
        let against = |theirs: &Curve| Against {
            ratio_error: ratio_error(ours, theirs),
            ..compared(
                &theirs.name,
                &ours.against_time(measure),
                &theirs.against_time(measure),
            )
        };
        self.against = others.iter().map(against).collect();
    }

    /// A line for every picture.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "renderer,seed,samples,seconds,mse,rel_mse,error_percent,mape,smape,ssim,flip,hdr_flip,non_finite\n",
        );
        let number = |value: Option<f64>| {
            value
                .filter(|v| v.is_finite())
                .map_or_else(String::new, |v| v.to_string())
        };
        for curve in &self.renderers {
            let name = format!("\"{}\"", curve.name.replace('"', "\"\""));
            for point in &curve.points {
                let e = &point.errors;
                text += &format!(
                    "{name},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                    point.seed,
                    point.samples,
                    point.seconds,
                    e.mse,
                    e.rel_mse,
                    number(Some(100.0 * e.rel_mse.sqrt())),
                    e.mape,
                    e.smape,
                    number(e.ssim),
                    e.flip,
                    number(e.hdr_flip),
                    e.non_finite
                );
            }
        }
        debug_assert_eq!(MEASURES.len(), 8, "a new measure is a new column");
        text
    }
}

/// A number with its spread, of which two digits say enough.
impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&number(self.mean))?;
        match self.deviation {
            Some(deviation) => write!(f, " ± {}", two_digits(deviation)),
            None => Ok(()),
        }
    }
}

fn two_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let power = value.abs().log10().floor() as i32;
    match power {
        -4..=0 => format!("{value:.*}", (1 - power) as usize),
        1..=3 => format!("{value:.0}"),
        _ => format!("{value:.1e}"),
    }
}

impl Against {
    /// What the ratio says.
    pub fn sentence(&self) -> String {
        match self.overall {
            Some(ratio) => format!(
                "{} takes {:.3} times as long to the same error{} ({:.3} to {:.3} times, between {:.3} % and {:.3} %)",
                self.renderer,
                ratio.ratio,
                self.ratio_error
                    .map(|error| format!(", give or take a factor of {:.2}", error.exp()))
                    .unwrap_or_default(),
                ratio.least,
                ratio.greatest,
                ratio.highest_error,
                ratio.lowest_error
            ),
            None => format!("{} and this renderer reach no common error", self.renderer),
        }
    }
}

/// Times at 64, 32, 16, 8 … percent and at the ends of what both reach.
fn compared(name: &str, ours: &[(f64, f64)], theirs: &[(f64, f64)]) -> Against {
    let overall = time_ratio(ours, theirs);
    let mut errors = Vec::new();
    if let Some(range) = overall {
        let inside = |error: &f64| (range.lowest_error..=range.highest_error).contains(error);
        errors.extend(
            (-10..=10)
                .rev()
                .map(|power| 2f64.powi(power))
                .filter(inside),
        );
    }
    let at = errors
        .into_iter()
        .filter_map(|error_percent| {
            let seconds = time_to(ours, error_percent)?;
            let their_seconds = time_to(theirs, error_percent)?;
            Some(EqualError {
                error_percent,
                seconds,
                their_seconds,
                ratio: their_seconds / seconds,
            })
        })
        .collect();
    Against {
        renderer: name.into(),
        overall,
        ratio_error: None,
        at,
    }
}

/// The jackknife's standard error of the log ratio of times: the two renderers' seeds are independent, so that their
/// variances add up.
fn ratio_error(ours: &Curve, theirs: &Curve) -> Option<f64> {
    let measure = main_measure();
    let log_ratio = |ours: &Curve, theirs: &Curve| -> Option<f64> {
        let ratio = time_ratio(&ours.against_time(measure), &theirs.against_time(measure))?;
        Some(ratio.ratio.ln())
    };
    let of_ours = jackknife(ours, |without| log_ratio(without, theirs))?;
    let of_theirs = jackknife(theirs, |without| log_ratio(ours, without))?;
    Some((of_ours + of_theirs).sqrt())
}

/// The variance of a statistic of a curve's seeds: (n - 1) / n times the sum of squares about the mean of what it is without
/// each of them (Efron and Stein 1981).
fn jackknife(curve: &Curve, statistic: impl Fn(&Curve) -> Option<f64>) -> Option<f64> {
    let seeds: BTreeSet<u64> = curve.points.iter().map(|point| point.seed).collect();
    if seeds.len() < 2 {
        return None;
    }
    let values: Vec<f64> = seeds
        .iter()
        .map(|seed| {
            let others = curve.points.iter().filter(|point| point.seed != *seed);
            let without = Curve::new(String::new(), String::new(), others.cloned().collect());
            statistic(&without)
        })
        .collect::<Option<_>>()?;
    let count = values.len() as f64;
    let middle = mean(values.iter().copied());
    let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
    Some((count - 1.0) / count * squares)
}

#[cfg(test)]
#[path = "../../../tests/unit/measure/convergence/study.rs"]
mod tests;
