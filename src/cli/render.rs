//! `sundog render`: a scene file becomes pictures.

use super::args::{MAX_SAMPLES, Render, RenderEffort};
use super::checkpoint::Checkpoint;
use super::exit::{EXIT_INTERRUPTED, EXIT_OK};
use super::frames::{Watcher, locked};
use super::outputs::Outputs;
use super::progress::Reporter;
use super::scene_file::{self, SceneFile};
use super::{Failure, black, denoise, replay, summary};
use crate::effects::EffectReport;
use crate::math::primaries::WorkingSpace;
use crate::math::words::counted;
use crate::output::tev::Viewer;
use crate::output::{Frames, Metadata};
use crate::render::{
    NoiseThreshold, Observer, RenderSettings, Session, Statistics, Stop, labels, left_out, memory,
};
use crate::scene::{Scene, coincident, fingerprint};
use serde_json::json;
use std::path::Path;
use std::sync::Mutex;
use std::time::Duration;

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(args: &Render) -> Result<u8, Failure> {
    if let Some(place) = args.files.replay {
        return replay::run(args, place);
    }
    let reporter = Reporter::new(&args.reporting);
    check_goals(args)?;
    let asked = &args.files;
    let files = Outputs::files(&asked.output)?;
    let checkpoint = Checkpoint::new(
        args.effort.checkpoint.as_deref(),
        args.effort.checkpoint_interval,
    )?;
    let denoiser = denoise::find(&args.denoising, args.options.machine.threads, &reporter)?;
    let saved = checkpoint.as_ref().map_or(Ok(None), Checkpoint::read)?;
    let mut imported = scene_file::load(&asked.scene, &args.options)?;
    args.passes.light_groups.choose(&mut imported.scene);
    let (path, scene) = (&imported.path, &imported.scene);
    let mut outputs = Outputs::new(
        files,
        &args.exr,
        &args.view,
        &scene.color_management,
        &reporter,
    )?;
    scene_file::introduce(&args.options.loading, &imported, &reporter)?;
    let mut settings = args.settings(path, scene)?;
    if let Some(denoiser) = &denoiser {
        settings.passes = denoiser.settings().passes(settings.passes);
        let groups = crate::film::group_layers(&scene.light_groups);
        let layers: Vec<_> = settings.passes.layers().chain(groups).collect();
        denoise::check_passes(denoiser, layers.iter().map(|layer| layer.0.as_str()))?;
    }
    // What goes nowhere but to a checkpoint is denoised when it is joined.
    let is_seen = !outputs.files.is_empty() || asked.frames.is_some() || asked.tev.is_some();
    outputs.denoiser = denoiser.filter(|_| is_seen);
    if settings.denoised_target > 0.0 {
        outputs.judge(&args.view, &scene.color_management, &reporter)?;
    }
    memory::check_render(&settings, scene)?;
    let region = settings.region();
    let frames = asked.frames.as_ref().map(|folder| {
        let corners = [region.x0, region.y0, region.x1, region.y1];
        Frames::new(folder, (settings.width, settings.height), corners)
    });
    let coincident = coincident::find(scene);
    let report = EffectReport::of(
        (scene, &coincident),
        &settings.requested(),
        &imported.left_out,
        &imported.diagnostics,
    );
    tell_left_out(&left_out(report.called_for, &settings), &reporter);
    reporter.tell(
        &json!({ "event": "scene", "file": path.display().to_string(), "settings": settings }),
    );
    reporter.tell(
        &json!({ "event": "effects", "effects": report.findings, "left_out": imported.left_out }),
    );

    let viewer = open_viewer(args, &imported, &outputs, &settings, &reporter);
    let watcher = Watcher {
        reporter: &reporter,
        frames: frames.as_ref(),
        viewer: viewer.as_ref(),
        checkpoint: checkpoint.as_ref(),
        outputs: &outputs,
        denoised: Mutex::default(),
    };
    if let Some(saved) = &saved {
        reporter.say(&format!(
            "going on from {} a pixel",
            scene_file::count(saved.samples().into(), "sample")
        ));
    }
    let session = Session::new(scene, settings.clone());
    let rendering = session
        .with_coincident(coincident)
        .resume(saved.as_ref(), &watcher);
    reporter.end();
    let mut rendering =
        rendering.map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    let statistics = rendering.statistics.clone();
    let mut cancelled = statistics.stop == Stop::Cancelled;
    if cancelled && statistics.rays == 0 {
        reporter.tell(&json!({ "event": "finished", "statistics": statistics, "written": [] }));
        return Err(Failure {
            code: EXIT_INTERRUPTED,
            message: format!(
                "{}: interrupted before the first sample; nothing was written",
                path.display()
            ),
        });
    }
    for warning in statistics.warnings() {
        reporter.warn(&warning);
    }
    let hash = rendering.scene_hash.get_or_init(|| fingerprint(scene));
    let mut metadata = metadata(path, hash, &settings, &statistics);
    let mut denoised = Ok(None);
    match &outputs.denoiser {
        Some(_) if cancelled => reporter.warn(denoise::INTERRUPTED),
        Some(denoiser) => {
            denoised = denoise::apply(&args.denoising, denoiser, &mut rendering, &reporter);
            if let Ok(Some(report)) = &mut denoised {
                report.error = *locked(&watcher.denoised);
            }
            cancelled = watcher.cancelled();
        }
        None => {}
    }
    let report = denoised.as_ref().ok().and_then(Option::as_ref);
    denoise::tell_in(&mut metadata, report);
    metadata.extend(labels::manifests(scene, settings.passes));
    if outputs.denoiser.is_some() {
        watcher.write_frame(&rendering.picture, statistics.samples, true);
    }
    outputs.write(&rendering.picture, &metadata, &reporter)?;
    if let Some(viewer) = &viewer {
        viewer.finish(&rendering.picture, &|warning| reporter.warn(warning));
    }
    if let Some(warning) = black::warning(&rendering, &imported, args) {
        reporter.warn(&warning);
    }
    let size = (region.width(), region.height());
    summary::tell_end(size, &rendering, report, &outputs, &reporter)?;
    // The picture is there: a frame or a state that could not be written takes nothing from it.
    let frames = frames.as_ref().map_or(Ok(()), Frames::finish);
    let frames = frames.map_err(Failure::from);
    let state = checkpoint.as_ref().map_or(Ok(()), Checkpoint::finish);
    let denoised = denoised.map(|_| ());
    (denoised.and(frames).and(state)).map_err(|failure| outputs.are_there(failure))?;
    if cancelled {
        let file = checkpoint.as_ref().map(Checkpoint::name);
        return Err(interrupted(&outputs, file, statistics.samples));
    }
    Ok(EXIT_OK)
}

/// Makes sure that the picture goes somewhere.
fn check_goals(args: &Render) -> Result<(), Failure> {
    let asked = &args.files;
    if asked.output.is_empty() && asked.frames.is_none() && args.effort.checkpoint.is_none() {
        return Err(Failure::usage(
            "nothing says where the picture goes; give --output FILE (or --frames FOLDER, or --checkpoint FILE)",
        ));
    }
    if let Some(folder) = &asked.frames {
        if !args.reporting.json {
            return Err(Failure::usage(
                "--frames tells its files by lines of JSON; give --json as well",
            ));
        }
        Frames::check(folder)?;
    }
    Ok(())
}

/// The viewer that `--tev` names.
fn open_viewer(
    args: &Render,
    imported: &SceneFile,
    outputs: &Outputs,
    settings: &RenderSettings,
    reporter: &Reporter,
) -> Option<Viewer> {
    let address = args.files.tev.as_ref()?;
    let space = imported.scene.color_management.working_space;
    if space != WorkingSpace::default() {
        reporter.warn(&format!(
            "tev shows numbers as linear Rec.709, and those of this scene are in {space}: its colours are not those of the picture"
        ));
    }
    let region = settings.region();
    let size = (region.width(), region.height());
    let title = outputs.title(&imported.path);
    // Passes of the scene's own are none of the viewer's.
    let groups = crate::film::group_layers(&imported.scene.light_groups);
    let layers: Vec<_> = settings.passes.layers().chain(groups).collect();
    Some(Viewer::open(&address.0, &title, size, &layers))
}

/// What is told of a render that was interrupted and kept its picture, or its state.
fn interrupted(outputs: &Outputs, checkpoint: Option<String>, samples: u32) -> Failure {
    let written = match (outputs.files.is_empty(), checkpoint) {
        (false, _) => outputs.names().join(", "),
        (true, Some(checkpoint)) => checkpoint,
        (true, None) => "the last frame".to_owned(),
    };
    let samples = counted(
        samples,
        "sample a pixel there was",
        "samples a pixel there were",
    );
    Failure {
        code: EXIT_INTERRUPTED,
        message: format!("interrupted; {written} written with the {samples}"),
    }
}

impl Render {
    /// The settings of the flags, and of the scene where no flag says otherwise.
    ///
    /// # Errors
    /// A flag does not fit the scene, or another one.
    pub fn settings(&self, path: &Path, scene: &Scene) -> Result<RenderSettings, Failure> {
        let (first_sample, samples) = self.effort.samples()?;
        let options = self.options.settings(path, scene)?;
        Ok(RenderSettings {
            samples,
            first_sample,
            sequences: options.sequences.planned_for(first_sample + samples),
            time_limit: self.effort.time,
            error_target: self.effort.error.unwrap_or(0.0),
            pixel_error_target: self.effort.pixel_error.unwrap_or(0.0),
            denoised_target: self.effort.denoised_error.unwrap_or(0.0),
            noise_threshold: self.effort.noise_threshold(),
            passes: self.passes.passes,
            mist: self.passes.mist,
            center_passes: self.passes.centre_passes,
            ao_distance: self.passes.ao_distance as f32,
            alpha_threshold: self.passes.alpha_threshold as f32,
            effects: self.effects.effects.clone(),
            ..options
        })
    }
}

impl RenderEffort {
    /// When pixels stop, if they do so by Cycles' rule.
    fn noise_threshold(&self) -> Option<NoiseThreshold> {
        self.noise_threshold.map(|threshold| NoiseThreshold {
            threshold,
            min_samples: self.min_samples.unwrap_or(0),
        })
    }

    /// Number of the first sample, and how many there are.
    fn samples(&self) -> Result<(u32, u32), Failure> {
        let by_pixel = self.pixel_error.is_some() || self.noise_threshold.is_some();
        let by_error = self.error.is_some() || self.denoised_error.is_some();
        let open_ended = self.time.is_some() || by_error || by_pixel;
        match (&self.sample_range, self.samples) {
            (Some(_), Some(_)) => Err(Failure::usage(
                "--sample-range says itself how many samples there are; leave --samples out",
            )),
            (Some(_), None) if by_pixel => {
                let flag = match self.pixel_error {
                    Some(_) => "--pixel-error",
                    None => "--noise-threshold",
                };
                Err(Failure::usage(format!(
                    "{flag} decides sample by sample how far to go, which parts of a render can't; leave it or --sample-range out"
                )))
            }
            (Some(range), None) => Ok((range.start, range.end - range.start)),
            (None, Some(samples)) => Ok((0, samples)),
            (None, None) if open_ended => Ok((0, MAX_SAMPLES)),
            (None, None) => Ok((0, RenderSettings::default().samples)),
        }
    }
}

/// Tells which effects the scene calls for that the user's list leaves out.
fn tell_left_out(names: &[String], reporter: &Reporter) {
    if !names.is_empty() {
        reporter.warn(&format!(
            "the scene calls for {}, which --effects leaves out",
            names.join(", ")
        ));
    }
}

/// What a picture says about how it was made.
fn metadata(
    path: &Path,
    hash: &str,
    settings: &RenderSettings,
    statistics: &Statistics,
) -> Metadata {
    let name = path.file_name();
    let name = name.map(|name| name.to_string_lossy().into_owned());
    let date = humantime::format_rfc3339_seconds(std::time::SystemTime::now());
    let seconds = |time: Duration| format!("{:.3}", time.as_secs_f64());
    summary::metadata(
        statistics,
        [
            ("scene", name.unwrap_or_default()),
            ("scene-hash", hash.to_owned()),
            ("date", date.to_string()),
            ("samples", statistics.samples.to_string()),
            ("seconds/prepare", seconds(statistics.prepare)),
            ("seconds/trace", seconds(statistics.trace)),
            ("non-finite", statistics.non_finite.to_string()),
            ("effects", summary::listed(&statistics.effects)),
            ("effects/left-out", summary::listed(&statistics.left_out)),
            ("settings", summary::as_json(settings)),
            ("statistics", summary::as_json(statistics)),
        ],
    )
}
