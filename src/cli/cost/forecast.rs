//! `sundog cost SCENE`: error and time ahead, after a short probe.

use super::{Question, Unseen};
use crate::cli::text::{self, interval, percent, time};
use crate::cli::{Failure, console};
use crate::cost::{self, Probe};
use crate::math::words::counted;
use crate::render::{Expected, Forecast, Known, RenderSettings, Row};
use crate::report::{Axis, Cell, Column, Page, Plot, Point, Section, Series, Table};
use serde::Serialize;
use serde_json::json;
use std::time::Duration;

/// Where `--probe` does not say otherwise.
const DEFAULT_PROBE: Duration = Duration::from_secs(4);
/// Points of the curve of a forecast.
const POINTS: i32 = 48;
/// The curve goes so far beyond the last pass.
const AHEAD: f64 = 4096.0;

#[derive(Serialize)]
struct Answer<'a> {
    event: &'static str,
    scene: String,
    settings: &'a RenderSettings,
    probe: &'a Probe,
    /// The exponent p of error² ∝ samples^-p now.
    exponent: Expected,
    seconds_per_sample: Expected,
    rays_per_sample: f64,
    table: Vec<Row>,
    answers: Vec<Reply>,
}

/// What was asked, and what is expected.
#[derive(Serialize)]
#[serde(tag = "question", rename_all = "snake_case")]
enum Reply {
    /// `--error`.
    Error(Row),
    /// `--time`.
    Time { seconds: f64, error: Expected },
    /// `--samples`.
    Samples {
        samples: u32,
        seconds: Expected,
        error: Expected,
    },
}

/// Probes, and tells what follows.
pub fn run(question: &Question) -> Result<(), Failure> {
    let probe = cost::probe(
        &question.file.scene,
        &question.settings,
        question.probe(DEFAULT_PROBE),
        &Unseen,
    )
    .map_err(|error| question.failure(error))?;
    let Some(forecast) = &probe.forecast else {
        return Err(nothing(question, &probe));
    };
    let replies = replies(question, forecast);
    let answer = Answer {
        event: "forecast",
        scene: question.file.path.display().to_string(),
        settings: &question.settings,
        probe: &probe,
        exponent: forecast.exponent(),
        seconds_per_sample: forecast.seconds_per_sample(),
        rays_per_sample: forecast.rays_per_sample(),
        table: forecast.table(),
        answers: replies,
    };
    let table = table(&answer.table);
    let written = question.files.write(&answer, &table, || {
        Ok(page(question, &answer, forecast, &table))
    })?;
    question.reporter.tell(&answer);
    if !question.args.reporting.json {
        console::output(&format!(
            "{}\n\n{}",
            headline(question, &answer),
            text::table(&table)
        ));
        for reply in &answer.answers {
            console::output(&format!("{}\n", sentence(reply)));
        }
    }
    for name in written {
        question.reporter.say(&format!("{name} written"));
        question
            .reporter
            .tell(&json!({ "event": "written", "file": name }));
    }
    Ok(())
}

/// Why there is no forecast.
fn nothing(question: &Question, probe: &Probe) -> Failure {
    let path = question.file.path.display();
    Failure::new(if probe.exact {
        format!(
            "{path}: the picture has no noise, so that there is no error to forecast; one sample is enough"
        )
    } else {
        format!(
            "{path}: the probe came to {} samples a pixel in {}, too few to estimate an error; give a longer --probe or a smaller --width",
            probe.passes.last().map_or(0.0, |pass| pass.samples),
            time(probe.seconds)
        )
    })
}

fn replies(question: &Question, forecast: &Forecast) -> Vec<Reply> {
    let mut replies = Vec::new();
    if let Some(goal) = question.args.question.error {
        replies.push(Reply::Error(forecast.row(goal)));
    }
    if let Some(limit) = question.args.question.time {
        let seconds = limit.as_secs_f64();
        replies.push(Reply::Time {
            seconds,
            error: forecast.error_after(seconds),
        });
    }
    let samples = question.settings.samples;
    if question.args.question.samples.is_some() || replies.is_empty() {
        replies.push(Reply::Samples {
            samples,
            seconds: forecast.seconds_at(f64::from(samples)),
            error: forecast.error_at(f64::from(samples)),
        });
    }
    replies
}

fn sentence(reply: &Reply) -> String {
    match reply {
        Reply::Error(row) => format!(
            "{} needs {}",
            percent(row.error),
            interval(row.seconds, time)
        ),
        Reply::Time { seconds, error } => {
            format!("in {}: {}", time(*seconds), interval(*error, percent))
        }
        Reply::Samples {
            samples,
            seconds,
            error,
        } => format!(
            "{}: {} in {}",
            counted(samples, "sample", "samples"),
            interval(*error, percent),
            interval(*seconds, time)
        ),
    }
}

fn headline(question: &Question, answer: &Answer) -> String {
    let (settings, probe) = (&question.settings, answer.probe);
    let mut text = format!(
        "{} × {} pixels, probed for {}",
        settings.width,
        settings.height,
        time(probe.seconds)
    );
    if probe.size != [settings.width, settings.height] {
        text.push_str(&format!(
            ", at {} × {} and scaled, as that gave too few samples",
            probe.size[0], probe.size[1]
        ));
    }
    if let Some(pass) = probe.passes.last() {
        text.push_str(&format!(
            ": {:.0} samples, error {} ({} to {}), {} a sample",
            pass.samples,
            percent(pass.error),
            percent(pass.low),
            percent(pass.high),
            time(answer.seconds_per_sample.expected)
        ));
    }
    text
}

fn table(rows: &[Row]) -> Table {
    let row = |row: &Row| {
        vec![
            Cell::shown(100.0 * row.error, percent(row.error)),
            Cell::shown(
                row.samples.expected,
                console::grouped(row.samples.expected.round() as u64),
            ),
            Cell::shown(
                row.seconds.expected,
                time(row.seconds.expected) + if row.reached { " (reached)" } else { "" },
            ),
            Cell::shown(row.seconds.low, time(row.seconds.low)),
            Cell::shown(row.seconds.high, time(row.seconds.high)),
            Cell::shown(
                row.rays.expected / 1e6,
                console::grouped((row.rays.expected / 1e6).round() as u64),
            ),
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
        rows: rows.iter().map(row).collect(),
    }
}

fn measured(pass: &Known) -> Point {
    Point::new(pass.seconds, 100.0 * pass.error)
        .spread(100.0 * pass.low, 100.0 * pass.high)
        .labelled(counted(pass.samples, "sample", "samples"))
}

/// Measured passes, and the curve ahead with its interval.
fn plot(answer: &Answer, forecast: &Forecast) -> Plot {
    let last = forecast.last().samples;
    let ahead = (0..=POINTS)
        .map(|i| {
            let samples = last * AHEAD.powf(f64::from(i) / f64::from(POINTS));
            let error = forecast.error_at(samples);
            Point::new(
                forecast.seconds_at(samples).expected,
                100.0 * error.expected,
            )
            .spread(100.0 * error.low, 100.0 * error.high)
            .labelled(format!("{samples:.0} samples"))
        })
        .collect();
    let known = answer.probe.passes.iter().filter(|pass| pass.error > 0.0);
    Plot {
        title: "Error against time".into(),
        note: "The probe's passes with the intervals of their estimates, and the forecast with its own.".into(),
        x: Axis::log("time", "s"),
        y: Axis::log("error", "%"),
        series: vec![
            Series::new("measured", known.map(measured).collect()),
            Series::fitted("forecast", ahead),
        ],
    }
}

fn page(question: &Question, answer: &Answer, forecast: &Forecast, table: &Table) -> Page {
    let name = question.file.path.file_name().unwrap_or_default();
    Page {
        title: format!("What {} costs", name.to_string_lossy()),
        subtitle: headline(question, answer),
        sections: vec![
            Section::Curves(plot(answer, forecast)),
            Section::Table(table.clone()),
            Section::Text {
                title: "Answers".into(),
                paragraphs: answer.answers.iter().map(sentence).collect(),
            },
            Section::Settings(super::files::settings(question)),
        ],
    }
}
