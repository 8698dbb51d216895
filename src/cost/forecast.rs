//! What a probe says of the picture: error and time ahead, for JSON, in words, as a table and as a page.

use super::Probe;
use crate::math::words::{counted, duration, grouped, percent};
use crate::render::{Expected, Forecast, ForecastRow, Known, RenderSettings};
use crate::report::{Axis, Cell, Column, Page, Plot, Point, Section, Series, Settings, Table};
use serde::Serialize;
use std::path::Path;

/// Points of the curve of a forecast.
const POINTS: i32 = 48;
/// The curve goes so far beyond the last pass.
const AHEAD: f64 = 4096.0;

/// What is asked; without anything, the samples of the settings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForecastQuery {
    /// When this error is reached.
    pub error: Option<f64>,
    /// What error there is after so many seconds.
    pub seconds: Option<f64>,
    /// Error and time of so many samples.
    pub samples: Option<u32>,
}

/// What was asked, and what is expected.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "question", rename_all = "snake_case")]
enum Reply {
    Error(ForecastRow),
    Time {
        seconds: f64,
        error: Expected,
    },
    Samples {
        samples: u32,
        seconds: Expected,
        error: Expected,
    },
}

/// A forecast with its answers.
#[derive(Debug, Serialize)]
pub struct ForecastReport<'a> {
    event: &'static str,
    scene: String,
    settings: &'a RenderSettings,
    probe: &'a Probe,
    /// The exponent p of error² ∝ samples^-p now.
    exponent: Expected,
    seconds_per_sample: Expected,
    rays_per_sample: f64,
    table: Vec<ForecastRow>,
    answers: Vec<Reply>,
    #[serde(skip)]
    forecast: &'a Forecast,
}

impl Probe {
    /// Why there is no forecast.
    pub fn lacking(&self) -> String {
        if self.exact {
            return "the picture has no noise, so that there is no error to forecast; one sample is enough".into();
        }
        format!(
            "the probe came to {} samples a pixel in {}, too few to estimate an error; give a longer --probe or a smaller --width",
            self.passes.last().map_or(0.0, |pass| pass.samples),
            duration(self.seconds)
        )
    }
}

impl<'a> ForecastReport<'a> {
    /// The answers to what is asked; none if there is no forecast.
    pub fn new(
        scene: &Path,
        settings: &'a RenderSettings,
        probe: &'a Probe,
        asked: ForecastQuery,
    ) -> Option<Self> {
        let forecast = probe.forecast.as_ref()?;
        Some(Self {
            event: "forecast",
            scene: scene.display().to_string(),
            settings,
            probe,
            exponent: forecast.exponent(),
            seconds_per_sample: forecast.seconds_per_sample(),
            rays_per_sample: forecast.rays_per_sample(),
            table: forecast.table(),
            answers: replies(settings, forecast, asked),
            forecast,
        })
    }

    /// What was probed, and what came of it.
    pub fn headline(&self) -> String {
        let (settings, probe) = (self.settings, self.probe);
        let mut text = format!(
            "{} × {} pixels, probed for {}",
            settings.width,
            settings.height,
            duration(probe.seconds)
        );
        if probe.size != [settings.width, settings.height] {
            text += &format!(
                ", at {} × {} and scaled, as that gave too few samples",
                probe.size[0], probe.size[1]
            );
        }
        if let Some(pass) = probe.passes.last() {
            text += &format!(
                ": {:.0} samples, error {} ({} to {}), {} a sample",
                pass.samples,
                percent(pass.error),
                percent(pass.low),
                percent(pass.high),
                duration(self.seconds_per_sample.expected)
            );
        }
        text
    }

    /// A sentence for each answer.
    pub fn sentences(&self) -> Vec<String> {
        let sentence = |reply: &Reply| match reply {
            Reply::Error(row) => {
                let seconds = row.seconds.words(duration);
                format!("{} needs {seconds}", percent(row.error))
            }
            Reply::Time { seconds, error } => {
                format!("in {}: {}", duration(*seconds), error.words(percent))
            }
            Reply::Samples {
                samples,
                seconds,
                error,
            } => format!(
                "{}: {} in {}",
                counted(samples, "sample", "samples"),
                error.words(percent),
                seconds.words(duration)
            ),
        };
        self.answers.iter().map(sentence).collect()
    }

    /// Time, samples and rays of round errors.
    pub fn table(&self) -> Table {
        let count = |value: f64, number: f64| Cell::shown(value, grouped(number.round() as u64));
        let time = |seconds: f64, note: &str| Cell::shown(seconds, duration(seconds) + note);
        let row = |row: &ForecastRow| {
            let (samples, millions) = (row.samples.expected, row.rays.expected / 1e6);
            vec![
                Cell::shown(100.0 * row.error, percent(row.error)),
                count(samples, samples),
                time(
                    row.seconds.expected,
                    if row.reached { " (reached)" } else { "" },
                ),
                time(row.seconds.low, ""),
                time(row.seconds.high, ""),
                count(millions, millions),
            ]
        };
        Table {
            title: "Error and time".into(),
            note: "Times are of tracing alone; the interval holds the time in 95 of 100 renders."
                .into(),
            columns: vec![
                Column::explained("error (%)", "√relMSE"),
                Column::new("samples"),
                Column::new("time (s)"),
                Column::explained("from (s)", "lower end of the 95 % interval"),
                Column::explained("to (s)", "upper end"),
                Column::new("rays (M)"),
            ],
            rows: self.table.iter().map(row).collect(),
        }
    }

    /// Measured passes, and the curve ahead with its interval.
    fn plot(&self) -> Plot {
        let last = self.forecast.last().samples;
        let ahead = (0..=POINTS).map(|i| {
            let samples = last * AHEAD.powf(f64::from(i) / f64::from(POINTS));
            let error = self.forecast.error_at(samples);
            let seconds = self.forecast.seconds_at(samples).expected;
            Point::new(seconds, 100.0 * error.expected)
                .spread(100.0 * error.low, 100.0 * error.high)
                .labelled(format!("{samples:.0} samples"))
        });
        let measured = |pass: &Known| {
            Point::new(pass.seconds, 100.0 * pass.error)
                .spread(100.0 * pass.low, 100.0 * pass.high)
                .labelled(counted(pass.samples, "sample", "samples"))
        };
        let known = self.probe.passes.iter().filter(|pass| pass.error > 0.0);
        Plot {
            title: "Error against time".into(),
            note: "The probe's passes with the intervals of their estimates, and the forecast with its own.".into(),
            x: Axis::log("time", "s"),
            y: Axis::log("error", "%"),
            series: vec![
                Series::new("measured", known.map(measured).collect()),
                Series::fitted("forecast", ahead.collect()),
            ],
        }
    }

    /// The page.
    pub fn page(&self) -> Page {
        let name = Path::new(&self.scene).file_name().unwrap_or_default();
        let settings = serde_json::to_value(self.settings).unwrap_or_default();
        Page {
            title: format!("What {} costs", name.to_string_lossy()),
            subtitle: self.headline(),
            sections: vec![
                Section::Curves(self.plot()),
                Section::Table(self.table()),
                Section::Text {
                    title: "Answers".into(),
                    paragraphs: self.sentences(),
                },
                Section::Settings(Settings::of(&self.scene, &settings)),
            ],
        }
    }
}

fn replies(settings: &RenderSettings, forecast: &Forecast, asked: ForecastQuery) -> Vec<Reply> {
    let error = asked.error.map(|goal| Reply::Error(forecast.row(goal)));
    let time = asked.seconds.map(|seconds| Reply::Time {
        seconds,
        error: forecast.error_after(seconds),
    });
    let mut replies: Vec<Reply> = error.into_iter().chain(time).collect();
    let samples = asked
        .samples
        .or(replies.is_empty().then_some(settings.samples));
    replies.extend(samples.map(|samples| Reply::Samples {
        samples,
        seconds: forecast.seconds_at(f64::from(samples)),
        error: forecast.error_at(f64::from(samples)),
    }));
    replies
}
