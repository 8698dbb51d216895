//! `sundog converge`: error against time, of this renderer and of others.

mod against;
mod files;
mod page;
mod renders;
mod summary;

use super::args::Converge;
use super::exit::EXIT_OK;
use super::progress::Reporter;
use super::view::View;
use super::{Failure, console, scene_file};
use crate::film::Passes;
use crate::math::words::counted;
use crate::measure::convergence::Reference;
use crate::measure::{self, Encoding, MeasureError, Picture};
use crate::render::{RenderSettings, memory};
use crate::scene::Scene;
use against::Peer;
use files::Files;
use renders::{Shot, Shots};
use serde_json::json;
use std::path::Path;
use summary::{Answer, Curve, Measured};

/// A reference has so many times the samples of the longest run, in each of its halves.
const REFERENCE_FACTOR: u32 = 4;
/// The seeds of the reference's halves lie so far from those of the runs.
const REFERENCE_SEED: u32 = 0x8000_0000;

/// A reference, and what there is to say of it.
struct Truth {
    reference: Reference,
    words: String,
}

/// A picture that the page shows.
struct Shown {
    name: String,
    picture: Picture,
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
}

/// All that a page needs beyond the numbers.
struct Looks {
    shown: Vec<Shown>,
    /// FLIP of the last picture of each renderer against its reference, by pixel.
    flip: Vec<(String, Vec<f32>)>,
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
        .map(|folder| against::read(folder))
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect();
    let imported = scene_file::load(&args.scene, &args.options)?;
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
    let work = Work {
        args,
        path,
        scene,
        settings,
        view,
        reporter: &reporter,
        files,
    };
    // What a folder lacks is told before hours are spent.
    for peer in &peers {
        peer.check(work.size())?;
    }
    let answer = work.measure(&peers)?;
    let names = work.files.names();
    reporter.tell(&json!({ "event": "finished", "answer": answer, "written": names }));
    if !args.reporting.json {
        console::output(&answer.table());
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

fn in_file(path: &Path, error: &MeasureError) -> Failure {
    Failure::new(format!("{}: {error}", path.display()))
}

/// An EXR of the given size as linear light.
fn load(path: &Path, size: (u32, u32)) -> Result<Picture, Failure> {
    let picture = measure::load(path, None)?;
    if picture.encoding != Encoding::Linear {
        return Err(Failure::new(format!(
            "{} holds display values; errors are measured of linear light, which an EXR file keeps",
            path.display()
        )));
    }
    if (picture.width, picture.height) != size {
        return Err(Failure::new(format!(
            "{} has {} × {} pixels, but the scene is rendered with {} × {}; give --width and --height, or another picture",
            path.display(),
            picture.width,
            picture.height,
            size.0,
            size.1
        )));
    }
    Ok(picture)
}

/// A reference of one file, or of two whose noise is independent.
fn from_files(
    paths: &[impl AsRef<Path>],
    size: (u32, u32),
    view: &View,
) -> Result<Reference, Failure> {
    let mut pictures = paths
        .iter()
        .map(|path| load(path.as_ref(), size))
        .collect::<Result<Vec<_>, _>>()?;
    match (pictures.pop(), pictures.pop(), pictures.pop()) {
        (Some(one), None, _) => {
            let shown = view.seen(&one)?;
            Ok(Reference::single(one, shown))
        }
        (Some(b), Some(a), None) => Reference::halves([a, b], |mean| view.seen(mean)),
        _ => Err(Failure::usage(
            "a reference is one picture, or two with independent noise",
        )),
    }
}

/// How far a reference itself is off, in words.
fn own_error(reference: &Reference) -> String {
    match reference.own_rel_mse() {
        Some(own) => format!(
            "; its own error is about {:.3} %, which is taken out of RMSE and relMSE",
            100.0 * own.sqrt()
        ),
        None => "; its own noise is not known and counts as error".into(),
    }
}

impl Work<'_> {
    fn size(&self) -> (u32, u32) {
        let region = self.settings.region();
        (region.width(), region.height())
    }

    fn measure(&self, peers: &[Peer]) -> Result<Answer, Failure> {
        let seeds = self.args.effort.seeds;
        check_seeds(self.settings.seed, seeds)?;
        let truth = self.truth()?;
        self.reporter.say(&format!("reference: {}", truth.words));
        let mut looks = Looks {
            shown: Vec::new(),
            flip: Vec::new(),
        };
        let mut curves = vec![self.own_curve(seeds, &truth, &mut looks)?];
        for peer in peers {
            let name =
                against::distinct(&peer.name, curves.iter().map(|curve| curve.name.as_str()));
            curves.push(self.peer_curve(peer, name, &truth, &mut looks)?);
        }
        looks.shown.push(Shown {
            name: "reference".into(),
            picture: truth.reference.shown.clone(),
        });
        let (view, words) = (self.view.summary(), &truth.words);
        let answer = Answer::new(self.path, self.size(), view, &self.settings, words, curves);
        self.files.write(&answer, &looks)?;
        Ok(answer)
    }

    fn truth(&self) -> Result<Truth, Failure> {
        let given = &self.args.reference;
        if !given.is_empty() {
            let reference = from_files(given, self.size(), &self.view)?;
            let names: Vec<_> = given
                .iter()
                .map(|path| path.display().to_string())
                .collect();
            let words = format!("{}{}", names.join(" and "), own_error(&reference));
            return Ok(Truth { reference, words });
        }
        let samples = self
            .args
            .effort
            .reference_samples
            .unwrap_or_else(|| self.settings.samples.saturating_mul(REFERENCE_FACTOR));
        let half = |number: u32| -> Result<Picture, Failure> {
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
            own_error(&reference)
        );
        Ok(Truth { reference, words })
    }

    /// Measures one picture; what one sees of it goes to `looks` under a name.
    fn measured(
        &self,
        truth: &Truth,
        seed: u64,
        shot: &Shot,
        looks: Option<(&mut Looks, String)>,
    ) -> Result<Measured, Failure> {
        let shown = self.view.seen(&shot.picture)?;
        let errors = truth.reference.errors(&shot.picture, &shown)?;
        if let Some((looks, name)) = looks {
            looks.shown.push(Shown {
                name,
                picture: shown,
            });
        }
        Ok(Measured {
            seed,
            samples: shot.samples,
            seconds: shot.seconds,
            errors,
        })
    }

    fn tell(&self, renderer: &str, point: &Measured) {
        self.reporter
            .tell(&json!({ "event": "measured", "renderer": renderer, "point": point }));
    }

    fn own_curve(&self, seeds: u32, truth: &Truth, looks: &mut Looks) -> Result<Curve, Failure> {
        let name = self.args.effort.name.clone();
        let mut points = Vec::new();
        for seed in self.settings.seed..self.settings.seed + seeds {
            self.reporter.say(&format!(
                "seed {seed}, {} a pixel",
                counted(self.settings.samples, "sample", "samples")
            ));
            let settings = RenderSettings {
                seed,
                ..self.settings.clone()
            };
            let Shots { shots } =
                renders::doubling(self.scene, self.path, &settings, self.reporter)?;
            let last = shots.len().saturating_sub(1);
            for (index, shot) in shots.iter().enumerate() {
                let space = self.scene.color_management.working_space;
                self.files.keep(&name, seed, shot, space)?;
                // The page shows the first and the last picture of the first run.
                let shown = seed == self.settings.seed && (index == 0 || index == last);
                let look = shown.then(|| {
                    (
                        &mut *looks,
                        format!("{name}, {}", counted(shot.samples, "sample", "samples")),
                    )
                });
                let point = self.measured(truth, u64::from(seed), shot, look)?;
                if shown && index == last {
                    looks.add_flip(truth, &name);
                }
                self.tell(&name, &point);
                points.push(point);
            }
        }
        self.files.keep_times(&name)?;
        Ok(Curve::new(name, truth.words.clone(), points))
    }

    /// A peer's curve, against its own reference if its folder has one and the user names none.
    fn peer_curve(
        &self,
        peer: &Peer,
        name: String,
        common: &Truth,
        looks: &mut Looks,
    ) -> Result<Curve, Failure> {
        let own;
        let truth = if peer.reference.is_empty() || !self.args.reference.is_empty() {
            common
        } else {
            let reference = from_files(&peer.reference, self.size(), &self.view)?;
            let words = format!("its own, from its folder{}", own_error(&reference));
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
                picture: load(&entry.path, self.size())?,
            };
            let shown = Some(entry.samples) == longest && Some(entry.seed) == first_seed;
            let look = shown.then(|| {
                (
                    &mut *looks,
                    format!("{name}, {}", counted(entry.samples, "sample", "samples")),
                )
            });
            let point = self
                .measured(truth, entry.seed, &shot, look)
                .map_err(|failure| Failure {
                    message: format!("{}: {}", entry.path.display(), failure.message),
                    ..failure
                })?;
            if shown {
                looks.add_flip(truth, &name);
            }
            self.tell(&name, &point);
            points.push(point);
        }
        let mut curve = Curve::new(name, truth.words.clone(), points);
        if !std::ptr::eq(truth, common) {
            let between = common.reference.between(&truth.reference);
            curve.reference_apart = Some(between.map_err(|error| in_file(&peer.folder, &error))?);
        }
        Ok(curve)
    }
}

impl Looks {
    /// FLIP of each pixel of the picture that came last.
    fn add_flip(&mut self, truth: &Truth, name: &str) {
        if let Some(last) = self.shown.last() {
            let (shown, reference) = (&last.picture, &truth.reference.shown);
            let map = measure::flip_map([shown, reference, shown, reference]);
            self.flip.push((name.to_owned(), map));
        }
    }
}
