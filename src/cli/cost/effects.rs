//! `sundog cost SCENE --effects`: what each effect costs and gives.

use super::{Question, Unseen};
use crate::cli::text::{self, percent, time};
use crate::cli::view::View;
use crate::cli::{Failure, console};
use crate::cost::{self, Clock, CostError, EffectCost, Study, Worth};
use crate::math::words::counted;
use crate::measure::{self, Encoding};
use crate::render::{RenderSettings, render};
use crate::report::{
    Axis, Cell, Column, Line, Page, Picture, Plot, Point, Section, Series, Slider, Table,
};
use serde::Serialize;
use serde_json::json;
use std::time::Duration;

/// Of each picture, where `--probe` does not say otherwise.
const DEFAULT_PROBE: Duration = Duration::from_secs(1);
/// Samples of the picture that tells how many samples the others may have.
const PILOT_SAMPLES: u32 = 8;

#[derive(Serialize)]
struct Answer<'a> {
    event: &'static str,
    scene: String,
    settings: &'a RenderSettings,
    #[serde(flatten)]
    study: &'a Study,
}

/// Measures, and tells it.
pub fn run(question: &Question) -> Result<(), Failure> {
    let measured = measured_settings(question)?;
    let variants = cost::variants(&question.file.scene, &measured);
    let rounds = question.args.question.rounds;
    let study = cost::study(
        &question.file.scene,
        &question.settings,
        &measured,
        &variants,
        rounds,
        &Unseen,
        &|done, of, name| {
            let what = if name.is_empty() {
                "the full picture".to_owned()
            } else {
                format!("without {name}")
            };
            question.reporter.step(done, of, &what);
            question
                .reporter
                .tell(&json!({ "event": "measuring", "done": done, "of": of, "without": name }));
        },
    )
    .map_err(|error| question.failure(error))?;
    question.reporter.end();
    let answer = Answer {
        event: "effects",
        scene: question.file.path.display().to_string(),
        settings: &question.settings,
        study: &study,
    };
    let table = table(&study);
    let written = question
        .files
        .write(&answer, &table, || page(question, &study, &table))?;
    question.reporter.tell(&answer);
    if !question.args.reporting.json {
        console::output(&format!("{}\n\n{}", headline(&study), text::table(&table)));
    }
    for name in written {
        question.reporter.say(&format!("{name} written"));
        question
            .reporter
            .tell(&json!({ "event": "written", "file": name }));
    }
    Ok(())
}

/// A small picture with as many samples as fit into the time of one.
fn measured_settings(question: &Question) -> Result<RenderSettings, Failure> {
    let side = question.args.question.side;
    let small = RenderSettings {
        // All samples of all pixels; what adaptive sampling does is measured apart.
        error_target: 0.0,
        pixel_error_target: 0.0,
        ..cost::reduced(&question.settings, side)
    };
    let pilot = RenderSettings {
        samples: PILOT_SAMPLES.min(small.samples),
        ..small.clone()
    };
    let clock = Clock::new(&Unseen);
    let pilot = render(&question.file.scene, &pilot, &clock)
        .map_err(|error| question.failure(error.into()))?;
    if crate::cli::interrupt::interrupted() {
        return Err(question.failure(CostError::Cancelled));
    }
    let statistics = &pilot.statistics;
    let seconds = clock.seconds(statistics.trace, statistics.threads);
    let a_sample = seconds / f64::from(statistics.samples.max(1));
    // `as` saturates; powers of two are where the points of a pixel are most even.
    let fit = (question.probe(DEFAULT_PROBE).as_secs_f64() / a_sample) as u32;
    let samples = 1 << fit.clamp(PILOT_SAMPLES, 1 << 20).ilog2();
    Ok(RenderSettings {
        samples: samples.min(small.samples),
        ..small
    })
}

/// What all of it is about.
fn headline(study: &Study) -> String {
    format!(
        "{} × {} pixels with {}: about {} ({} Mrays, {:.0} ns each), noise {}.\n{}{}",
        study.size[0],
        study.size[1],
        counted(study.samples, "sample", "samples"),
        time(study.full.seconds),
        console::grouped((study.full.rays / 1e6).round() as u64),
        study.full.nanoseconds_per_ray,
        percent(study.noise),
        how(study),
        evened(study),
    )
}

fn how(study: &Study) -> String {
    format!(
        "Measured at {} × {} with {} samples in {} rounds; times and rays are scaled to the full picture, times are processor time over the threads.",
        study.measured_size[0], study.measured_size[1], study.measured_samples, study.rounds
    )
}

/// `0.52 % (0.4–0.6)`, or that it drowns in noise.
fn change(effect: &EffectCost) -> String {
    let share = effect.change;
    if effect.evened.is_some() {
        "noise alone".into()
    } else if share.high == 0.0 {
        "nothing".into()
    } else if share.is_found() {
        format!(
            "{} (± {})",
            percent(share.value),
            percent(0.5 * (share.high - share.low))
        )
    } else if effect.worth == Worth::Noise {
        "noise alone".into()
    } else {
        format!("below {}", percent(share.high))
    }
}

fn per_second(effect: &EffectCost) -> Cell {
    match effect.error_removed_per_second {
        _ if effect.worth == Worth::Picture && !effect.change.is_found() => Cell::shown(0.0, "0"),
        _ if effect.error_removed <= 0.0 => Cell::shown(0.0, "none"),
        Some(rate) => Cell::shown(100.0 * rate, percent(rate)),
        None => match effect.error_removed_per_second_at_least {
            Some(rate) => Cell::shown(100.0 * rate, format!("above {}", percent(rate))),
            None => Cell::shown(f64::INFINITY, "free"),
        },
    }
}

/// `230 ms (± 12 ms)`.
fn price(effect: &EffectCost) -> String {
    let [low, high] = effect.price.milliseconds_interval;
    format!(
        "{} (± {})",
        time(effect.price.milliseconds / 1000.0),
        time(0.5 * (high - low) / 1000.0)
    )
}

/// What adaptive sampling comes to; empty where it is not asked for.
fn evened(study: &Study) -> String {
    let of = |effect: &EffectCost| {
        let evened = effect.evened?;
        let sooner = effect.time_to_equal_noise.map_or(String::new(), |ratio| {
            format!("; without it the same takes {ratio:.2} times as long")
        });
        Some(format!(
            "\nAdaptive sampling at {}: {:.0} samples a pixel leave {} in the worst tile (a twentieth of the width) instead of {}{sooner}.",
            percent(evened.tolerance),
            evened.samples,
            percent(evened.worst_tile),
            percent(evened.worst_tile_without),
        ))
    };
    study.effects.iter().find_map(of).unwrap_or_default()
}

fn table(study: &Study) -> Table {
    let row = |effect: &EffectCost| {
        let [low, high] = effect.time_ratios;
        vec![
            Cell::text(&effect.effect),
            Cell::shown(effect.price.milliseconds, price(effect)),
            Cell::shown(
                effect.time_ratio,
                format!("{:.2} ({low:.2}–{high:.2})", effect.time_ratio),
            ),
            Cell::shown(100.0 * effect.change.value, change(effect)),
            Cell::shown(100.0 * effect.noise_without, percent(effect.noise_without)),
            per_second(effect),
            Cell::shown(
                (effect.rays_ratio - 1.0) * effect.without.rays / 1e6,
                format!("{:+.1} %", 100.0 * (effect.rays_ratio - 1.0)),
            ),
            Cell::shown(
                effect.without.nanoseconds_per_ray,
                format!("{:.0}", effect.without.nanoseconds_per_ray),
            ),
        ]
    };
    Table {
        title: "What each effect costs and gives".into(),
        note: how(study),
        columns: vec![
            Column::new("effect"),
            Column::explained(
                "costs (ms)",
                "milliseconds of the full picture that it takes: with it less without it, and the half width of the 95 % interval by the scatter of all times",
            ),
            Column::explained(
                "time with / without",
                "ratio of the medians, and the smallest and largest of a round",
            ),
            Column::explained(
                "changes the picture (%)",
                "√relMSE of the picture without it against the full one, the noise of both taken out",
            ),
            Column::explained(
                "noise without (%)",
                "√relMSE by chance of the picture without it at all samples",
            ),
            Column::explained(
                "error removed a second (%)",
                "the change for a second of its cost; of a technique, the noise that it takes away (adaptive sampling: of the worst tile); above: the cost may be nothing, and this is for the most that it may be",
            ),
            Column::explained("rays (M)", "millions of rays that it takes"),
            Column::explained("ns a ray without", "nanoseconds a ray without it"),
        ],
        rows: study.effects.iter().map(row).collect(),
    }
}

fn page(question: &Question, study: &Study, table: &Table) -> Result<Page, Failure> {
    let name = question.file.path.file_name().unwrap_or_default();
    let points = study
        .effects
        .iter()
        .filter(|effect| effect.worth == Worth::Picture && effect.change.is_found())
        .map(|effect| {
            Point::new(effect.price.milliseconds, 100.0 * effect.change.value)
                .spread(100.0 * effect.change.low, 100.0 * effect.change.high)
                .labelled(effect.effect.clone())
        })
        .collect();
    let plot = Plot {
        title: "Cost and worth".into(),
        note: "Up and to the left: much changed for little time. An effect left of 0 saves time."
            .into(),
        x: Axis::linear("time that it costs", "ms"),
        y: Axis::log("change of the picture", "%"),
        series: vec![Series {
            name: "effects".into(),
            line: Line::None,
            points,
        }],
    };
    let mut sections = vec![Section::Table(table.clone()), Section::Curves(plot)];
    if let Some(view) = &question.view {
        sections.push(slider(view, study)?);
    }
    sections.push(Section::Settings(super::files::settings(question)));
    Ok(Page {
        title: format!("What the effects of {} cost", name.to_string_lossy()),
        subtitle: headline(study).replace('\n', " "),
        sections,
    })
}

/// The full picture and those without something, as a display shows them.
fn slider(view: &View, study: &Study) -> Result<Section, Failure> {
    let names = std::iter::once("the full picture".to_owned()).chain(
        study
            .effects
            .iter()
            .map(|effect| format!("without {}", effect.effect)),
    );
    let [width, height] = study.measured_region;
    let pictures: Result<Vec<Picture>, Failure> = names
        .zip(&study.pictures)
        .map(|(name, values)| {
            let light = measure::Picture {
                width,
                height,
                pixels: values.as_chunks().0.to_vec(),
                encoding: Encoding::Linear,
            };
            let shown = view.seen(&light)?;
            let code = |value: &f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
            Ok(Picture {
                name,
                width,
                height,
                rgb: shown.pixels.iter().flatten().map(code).collect(),
            })
        })
        .collect();
    Ok(Section::Slider(Slider {
        title: "With and without".into(),
        note: format!(
            "Means over the rounds, at the size that was measured. Shown by: {}.",
            view.summary()
        ),
        pictures: pictures?,
    }))
}
