//! What is forecast, against what comes true: by counted work, not by the clock.

use super::*;
use std::path::Path;
use std::sync::Mutex;
use sundog::film::Bands;
use sundog::render::{Event, Forecast, Known, Observer, Passed};

/// Keeps what is known after each pass.
#[derive(Default)]
struct Passes(Mutex<Vec<Known>>);

impl Observer for Passes {
    fn event(&self, _: &Event) {}
    fn cancelled(&self) -> bool {
        false
    }
    fn whole_pass(&self, _: &dyn Bands, passed: &Passed) {
        // A ray is a second here: the test machine's clock has no say.
        let seconds = passed.rays as f64;
        let known = Known::from(passed);
        self.0.lock().unwrap().push(Known { seconds, ..known });
    }
    fn keeps_picture(&self) -> bool {
        false
    }
}

/// A forecast at so many samples of what there would be at so many, and what there was.
#[derive(Debug)]
struct Outcome {
    from: f64,
    to: f64,
    /// Error of the forecast over that of the render.
    error: f64,
    /// Rays until that error, forecast over traced.
    rays: f64,
    /// The interval held the error.
    held: bool,
}

fn outcomes(scene: &Scene, settings: &RenderSettings, probes: &[f64]) -> Vec<Outcome> {
    let passes = Passes::default();
    render(scene, settings, &passes).unwrap();
    let known = passes.0.into_inner().unwrap();
    for k in &known {
        println!(
            "{} samples: {:.4} ({:.4} to {:.4})",
            k.samples, k.error, k.low, k.high
        );
    }
    let mut list = Vec::new();
    for &from in probes {
        let so_far: Vec<_> = known
            .iter()
            .copied()
            .filter(|k| k.samples <= from)
            .collect();
        let forecast = Forecast::of(&so_far).unwrap();
        for later in &known {
            let factor = later.samples / from;
            if ![4.0, 16.0, 64.0].contains(&factor) {
                continue;
            }
            let ahead = forecast.error_at(later.samples);
            list.push(Outcome {
                from,
                to: later.samples,
                error: ahead.expected / later.error,
                rays: forecast.seconds_to(later.error).expected / later.seconds,
                held: ahead.low <= later.error && later.error <= ahead.high,
            });
        }
    }
    list
}

fn show(name: &str, outcomes: &[Outcome]) -> String {
    let mut text = String::new();
    for o in outcomes {
        text += &format!(
            "{name}: {} -> {} samples: error {:.2}, rays {:.2} of what was measured{}\n",
            o.from,
            o.to,
            o.error,
            o.rays,
            if o.held {
                ""
            } else {
                ", outside of the interval"
            }
        );
    }
    text
}

/// Seeds, and how many forecasts of theirs an interval of 95 % may miss. Those of a seed and a scene hang together: of 12 such
/// pairs three or more are missed once in 50 times, so that up to two pairs, 4 forecasts, are no fault. The seeds are fixed.
const SEEDS: u32 = 4;
const MOST_MISSED: usize = 4;

/// From 64 samples on, the error after 4 and 16 times as many is forecast: the intervals hold it, and where light is found easily
/// the forecasts of several seeds have it in their geometric mean, to 25 %. A single one is up to 1.6 times off.
#[test]
fn errors_are_forecast() {
    let mut told = String::new();
    let mut missed = 0;
    let mut scenes = gallery();
    scenes.truncate(2);
    scenes.push(("fireflies", super::accuracy::fireflies()));
    for (name, scene) in scenes {
        let mut logarithms = 0.0;
        for seed in 1..=SEEDS {
            let settings = RenderSettings {
                width: 48,
                height: 36,
                seed,
                ..small(1024, 5)
            };
            let outcomes = outcomes(&scene, &settings, &[64.0]);
            assert_eq!(outcomes.len(), 2);
            missed += outcomes.iter().filter(|o| !o.held).count();
            logarithms += outcomes.iter().map(|o| o.error.ln()).sum::<f64>();
            told += &show(name, &outcomes);
        }
        let mean = (logarithms / f64::from(2 * SEEDS)).exp();
        told += &format!("{name}: {mean:.2} in the mean\n");
        assert!((mean - 1.0).abs() < 0.25 || name == "fireflies", "{told}");
    }
    println!("{told}");
    assert!(missed <= MOST_MISSED, "{missed} missed\n{told}");
}

/// The same for the scenes of the benchmark (`make bench` makes them; `SUNDOG_SCENES` is their folder; `SUNDOG_SIDE` is the
/// width, `SUNDOG_SAMPLES` the most samples), from
/// 32 and 64 samples up to 64 times as many. Takes a quarter of an hour:
/// `cargo test --release --test sundog-tests -- --ignored --nocapture forecasts_of_the_benchmark`.
#[test]
#[ignore = "needs the scenes of the benchmark, and time"]
fn forecasts_of_the_benchmark() {
    let folder = std::env::var("SUNDOG_SCENES").expect("SUNDOG_SCENES is the folder of the scenes");
    let folder = Path::new(&folder);
    let number = |name: &str, default: u32| {
        let text = std::env::var(name).ok();
        text.map_or(default, |text| text.parse().unwrap())
    };
    let (side, samples) = (number("SUNDOG_SIDE", 48), number("SUNDOG_SAMPLES", 4096));
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
        .collect();
    files.sort();
    let (mut errors, mut rays, mut held, mut all) = (0, 0, 0, 0);
    for path in files {
        let text = std::fs::read_to_string(&path).unwrap();
        let about: serde_json::Value = serde_json::from_str(&text).unwrap();
        let scene_file = folder.join(about["scene"].as_str().unwrap());
        let mut scene = sundog::import::load(&scene_file, &Default::default())
            .unwrap()
            .scene;
        let number = |name: &str| about[name].as_f64().unwrap();
        if let Some(sky) = about["environment"].as_str() {
            let (strength, turn) = ("environment_strength", "environment_rotation");
            sundog::import::load_environment(
                &mut scene,
                &folder.join(sky),
                number(strength) as f32,
                number(turn) as f32,
            )
            .unwrap();
        }
        let settings = RenderSettings {
            width: side,
            height: (f64::from(side) * number("height") / number("width")) as u32,
            samples,
            bounces: number("bounces") as u32,
            passes: sundog::film::Passes::COMBINED,
            ..RenderSettings::default()
        };
        let outcomes = outcomes(&scene, &settings, &[32.0, 64.0]);
        print!(
            "{}",
            show(&path.file_stem().unwrap().to_string_lossy(), &outcomes)
        );
        all += outcomes.len();
        errors += outcomes
            .iter()
            .filter(|o| (o.error - 1.0).abs() <= 0.25)
            .count();
        rays += outcomes
            .iter()
            .filter(|o| (o.rays - 1.0).abs() <= 0.25)
            .count();
        held += outcomes.iter().filter(|o| o.held).count();
    }
    println!(
        "of {all}: {errors} errors and {rays} numbers of rays within 25 %, {held} intervals held"
    );
}
