//! What a study of the effects says, in words, as a table and as a page.

use super::{EffectCost, Study, Worth};
use crate::math::words::{counted, duration, grouped, percent};
use crate::render::RenderSettings;
use crate::report::{
    Axis, Cell, Column, Line, Page, PageImage, Plot, Point, Section, Series, Settings, Slider,
    Table,
};
use std::path::Path;

impl Study {
    /// What all of it is about.
    pub fn headline(&self) -> String {
        format!(
            "{} × {} pixels with {}: about {} ({} Mrays, {:.0} ns each), noise {}.\n{}{}",
            self.size[0],
            self.size[1],
            counted(self.samples, "sample", "samples"),
            duration(self.full.seconds),
            grouped((self.full.rays / 1e6).round() as u64),
            self.full.nanoseconds_per_ray,
            percent(self.noise),
            self.how(),
            evened(self),
        )
    }

    fn how(&self) -> String {
        format!(
            "Measured at {} × {} with {} samples in {} rounds; times and rays are scaled to the full picture, times are processor time over the threads.",
            self.measured_size[0], self.measured_size[1], self.measured_samples, self.rounds
        )
    }

    /// A row for each effect.
    pub fn table(&self) -> Table {
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
            note: self.how(),
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
            rows: self.effects.iter().map(row).collect(),
        }
    }

    /// The full picture and those without something, as `show` shows them by name and light.
    ///
    /// # Errors
    /// `show` fails.
    pub fn shown<E>(
        &self,
        show: impl Fn(String, &[f32]) -> Result<PageImage, E>,
    ) -> Result<Vec<PageImage>, E> {
        let without = |effect: &EffectCost| format!("without {}", effect.effect);
        std::iter::once("the full picture".to_owned())
            .chain(self.effects.iter().map(without))
            .zip(&self.pictures)
            .map(|(name, light)| show(name, light))
            .collect()
    }

    /// The page; `shown` are the pictures as a display shows them, and `view` says how.
    pub fn page(
        &self,
        scene: &Path,
        settings: &RenderSettings,
        shown: Vec<PageImage>,
        view: &str,
    ) -> Page {
        let name = scene.file_name().unwrap_or_default();
        let settings = serde_json::to_value(settings).unwrap_or_default();
        Page {
            title: format!("What the effects of {} cost", name.to_string_lossy()),
            subtitle: self.headline().replace('\n', " "),
            sections: vec![
                Section::Table(self.table()),
                Section::Curves(self.plot()),
                Section::Slider(Slider {
                    title: "With and without".into(),
                    note: format!(
                        "Means over the rounds, at the size that was measured. Shown by: {view}."
                    ),
                    pictures: shown,
                }),
                Section::Settings(Settings::of(scene.display().to_string(), &settings)),
            ],
        }
    }

    fn plot(&self) -> Plot {
        let found =
            |effect: &&EffectCost| effect.worth == Worth::Picture && effect.change.is_found();
        let point = |effect: &EffectCost| {
            Point::new(effect.price.milliseconds, 100.0 * effect.change.value)
                .spread(100.0 * effect.change.low, 100.0 * effect.change.high)
                .labelled(effect.effect.clone())
        };
        Plot {
            title: "Cost and worth".into(),
            note:
                "Up and to the left: much changed for little time. An effect left of 0 saves time."
                    .into(),
            x: Axis::linear("time that it costs", "ms"),
            y: Axis::log("change of the picture", "%"),
            series: vec![Series {
                name: "effects".into(),
                line: Line::None,
                points: self.effects.iter().filter(found).map(point).collect(),
            }],
        }
    }
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
        duration(effect.price.milliseconds / 1000.0),
        duration(0.5 * (high - low) / 1000.0)
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
