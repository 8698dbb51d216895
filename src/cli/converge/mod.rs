//! `sundog converge`: error against time, of this renderer and of others.

mod files;
mod renders;

use super::args::Converge;
use super::exit::EXIT_OK;
use super::progress::Reporter;
use super::view::View;
use super::{Failure, console, scene_file};
use crate::film::Passes;
use crate::math::words::counted;
use crate::measure::convergence::{Curve, Looks, Measured, Peer, Reference, Study, load_light};
use crate::measure::{MeasureError, RgbImage};
use crate::render::{RenderSettings, memory};
use crate::scene::LightGrouping;
use crate::scene::Scene;
use files::Files;
use renders::Shot;
use serde_json::json;
use std::path::{Path, PathBuf};

/// A reference has so many times the samples of the longest run, in each of its halves.
const REFERENCE_FACTOR: u32 = 4;
/// The seeds of the reference's halves lie so far from those of the runs.
const REFERENCE_SEED: u32 = 0x8000_0000;

/// A reference, and what there is to say of it.
struct Truth {
    reference: Reference,
    words: String,
}

/// Whether the page shows a picture.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Look {
    No,
    Yes,
    /// With the FLIP of its pixels.
    WithFlip,
}

/// What all steps need.
struct Work<'a> {
    args: &'a Converge,
    path: &'a Path,
    scene: &'a Scene,
    settings: RenderSettings,
    view: View,
    reporter: &'a Reporter,
    files: Files,
    looks: Looks,
}

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(args: &Converge) -> Result<u8, Failure> {
    let reporter = Reporter::new(&args.reporting);
    let files = Files::new(args)?;
    let peers: Vec<Peer> = args
        .against
        .iter()
        .map(|folder| Peer::read_all(folder))
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect();
    let mut imported = scene_file::load(&args.scene, &args.options)?;
    LightGrouping::None.choose(&mut imported.scene);
    let (path, scene) = (&imported.path, &imported.scene);
    let view = View::seen_by(&args.seen, &scene.color_management, &|warning| {
        reporter.warn(warning)
    })?;
    scene_file::introduce(&args.options.loading, &imported, &reporter)?;
    let settings = RenderSettings {
        samples: args.effort.samples,
        effects: args.effects.effects.clone(),
        passes: Passes::COMBINED,
        ..args.options.settings(path, scene)?
    };
    memory::check_render(&settings, scene)?;
    let mut work = Work {
        args,
        path,
        scene,
        settings,
        view,
        reporter: &reporter,
        files,
        looks: Looks::default(),
    };
    // What a folder lacks is told before hours are spent.
    for peer in &peers {
        let pictures = peer.pictures.iter().map(|picture| &picture.path);
        for path in pictures.chain(&peer.reference) {
            load_light(path, work.size())?;
        }
    }
    let answer = work.measure(&peers)?;
    let names = work.files.report.written;
    reporter.tell(&json!({ "event": "finished", "answer": answer, "written": names }));
    if !args.reporting.json {
        console::output(&answer.text());
        for name in names {
            reporter.say(&format!("{name} written"));
        }
    }
    Ok(EXIT_OK)
}

/// Runs and references must not share a seed, or their noise would be the same.
fn check_seeds(first: u32, count: u32) -> Result<(), Failure> {
    match first.checked_add(count) {
        Some(end) if end <= REFERENCE_SEED => Ok(()),
        _ => Err(Failure::usage(format!(
            "--seed {first} leaves no room for {count} seeds below {REFERENCE_SEED}, where those of the reference begin"
        ))),
    }
}

impl Work<'_> {
    fn size(&self) -> (u32, u32) {
        let region = self.settings.region();
        (region.width(), region.height())
    }

    fn measure(&mut self, peers: &[Peer]) -> Result<Study, Failure> {
        let seeds = self.args.effort.seeds;
        check_seeds(self.settings.seed, seeds)?;
        let truth = self.truth()?;
        self.reporter.say(&format!("reference: {}", truth.words));
        let mut curves = vec![self.own_curve(seeds, &truth)?];
        for peer in peers {
            let names = curves.iter().map(|curve| curve.name.as_str());
            let name = Peer::distinct_name(&peer.name, names);
            curves.push(self.peer_curve(peer, name, &truth)?);
        }
        self.looks.add("reference", truth.reference.shown.clone());
        let (width, height) = self.size();
        let threads = self.settings.threads;
        let mut study = Study {
            scene: self.path.display().to_string(),
            width,
            height,
            view: self.view.summary(),
            settings: serde_json::to_value(&self.settings).unwrap_or_default(),
            threads: threads
                .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into)),
            version: env!("CARGO_PKG_VERSION").into(),
            reference: truth.words,
            renderers: curves,
            against: Vec::new(),
        };
        study.compare();
        self.files.write(&study, &self.looks)?;
        Ok(study)
    }

    fn read(&self, paths: &[PathBuf]) -> Result<Reference, Failure> {
        Reference::read(paths, self.size(), |picture| self.view.seen(picture))
    }

    fn truth(&self) -> Result<Truth, Failure> {
        let given = &self.args.reference;
        if !given.is_empty() {
            if given.len() > 2 {
                return Err(Failure::usage(
                    "a reference is one picture, or two with independent noise",
                ));
            }
            let reference = self.read(given)?;
            let names: Vec<_> = given
                .iter()
                .map(|path| path.display().to_string())
                .collect();
            let words = format!("{}{}", names.join(" and "), reference.own_error());
            return Ok(Truth { reference, words });
        }
        let samples = self
            .args
            .effort
            .reference_samples
            .unwrap_or_else(|| self.settings.samples.saturating_mul(REFERENCE_FACTOR));
        let half = |number: u32| -> Result<RgbImage, Failure> {
            self.reporter.say(&format!(
                "half {} of the reference, {samples} samples a pixel",
                number + 1
            ));
            let settings = RenderSettings {
                samples,
                seed: REFERENCE_SEED + number,
                ..self.settings.clone()
            };
            renders::last(self.scene, self.path, &settings, self.reporter)
        };
        let reference = Reference::halves([half(0)?, half(1)?], |mean| self.view.seen(mean))?;
        let words = format!(
            "by Sundog, two halves of {samples} samples a pixel each with the seeds {REFERENCE_SEED} and {}{}",
            REFERENCE_SEED + 1,
            reference.own_error()
        );
        Ok(Truth { reference, words })
    }

    /// Measures one picture of a renderer and tells it; what one sees of it goes to the page where that is wished.
    fn measured(
        &mut self,
        name: &str,
        truth: &Truth,
        seed: u64,
        shot: &Shot,
        look: Look,
    ) -> Result<Measured, Failure> {
        let shown = self.view.seen(&shot.picture)?;
        let point = Measured {
            seed,
            samples: shot.samples,
            seconds: shot.seconds,
            errors: truth.reference.errors(&shot.picture, &shown)?,
        };
        if look == Look::WithFlip {
            self.looks.add_flip(name, &shown, &truth.reference);
        }
        if look != Look::No {
            let samples = counted(shot.samples, "sample", "samples");
            self.looks.add(format!("{name}, {samples}"), shown);
        }
        self.reporter
            .tell(&json!({ "event": "measured", "renderer": name, "point": point }));
        Ok(point)
    }

    fn own_curve(&mut self, seeds: u32, truth: &Truth) -> Result<Curve, Failure> {
        let name = self.args.effort.name.clone();
        let mut points = Vec::new();
        let space = self.scene.color_management.working_space;
        for seed in self.settings.seed..self.settings.seed + seeds {
            self.reporter.say(&format!(
                "seed {seed}, {} a pixel",
                counted(self.settings.samples, "sample", "samples")
            ));
            let settings = RenderSettings {
                seed,
                ..self.settings.clone()
            };
            let shots = renders::doubling(self.scene, self.path, &settings, self.reporter)?;
            let last = shots.len().saturating_sub(1);
            for (index, shot) in shots.iter().enumerate() {
                self.files.keep(&name, seed, shot, space)?;
                // The page shows the first and the last picture of the first run.
                let look = match index {
                    _ if seed != self.settings.seed => Look::No,
                    index if index == last => Look::WithFlip,
                    0 => Look::Yes,
                    _ => Look::No,
                };
                points.push(self.measured(&name, truth, u64::from(seed), shot, look)?);
            }
        }
        self.files.keep_times(&name)?;
        Ok(Curve::new(name, truth.words.clone(), points))
    }

    /// A peer's curve, against its own reference if its folder has one and the user names none.
    fn peer_curve(&mut self, peer: &Peer, name: String, common: &Truth) -> Result<Curve, Failure> {
        let own;
        let truth = if peer.reference.is_empty() || !self.args.reference.is_empty() {
            common
        } else {
            let reference = self.read(&peer.reference)?;
            let words = format!("its own, from its folder{}", reference.own_error());
            own = Truth { reference, words };
            &own
        };
        let mut points = Vec::new();
        let longest = peer.pictures.iter().map(|picture| picture.samples).max();
        let first_seed = peer.pictures.first().map(|picture| picture.seed);
        for entry in &peer.pictures {
            let shot = Shot {
                samples: entry.samples,
                seconds: entry.seconds,
                picture: load_light(&entry.path, self.size())?,
            };
            let shown = Some(entry.samples) == longest && Some(entry.seed) == first_seed;
            let look = if shown { Look::WithFlip } else { Look::No };
            let point = self
                .measured(&name, truth, entry.seed, &shot, look)
                .map_err(|failure| Failure {
                    message: format!("{}: {}", entry.path.display(), failure.message),
                    ..failure
                })?;
            points.push(point);
        }
        let mut curve = Curve::new(name, truth.words.clone(), points);
        if !std::ptr::eq(truth, common) {
            let between = common.reference.between(&truth.reference);
            let in_folder =
                |error: MeasureError| Failure::new(format!("{}: {error}", peer.folder.display()));
            curve.reference_apart = Some(between.map_err(in_folder)?);
        }
        Ok(curve)
    }
}
