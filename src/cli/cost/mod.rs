//! `sundog cost`: what a picture costs.

mod effects;
mod files;
mod forecast;

use super::args::Cost;
use super::exit::{EXIT_INTERRUPTED, EXIT_OK};
use super::progress::Reporter;
use super::scene_file::{self, SceneFile};
use super::view::View;
use super::{Failure, interrupt};
use crate::cost::CostError;
use crate::render::{Event, Observer, RenderSettings, memory};
use std::time::Duration;

/// What all parts of the command work with.
struct Question<'a> {
    args: &'a Cost,
    file: SceneFile,
    /// The picture that is asked about.
    settings: RenderSettings,
    reporter: Reporter,
    files: files::Files,
    /// How a page shows pictures; there if one with pictures is wanted.
    view: Option<View>,
}

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(args: &Cost) -> Result<u8, Failure> {
    let asked = &args.question;
    if asked.pixel_error.is_some() && !asked.effects {
        return Err(Failure::usage(
            "--pixel-error asks what adaptive sampling gives, which --effects measures; add it, or ask for the time to an --error",
        ));
    }
    let reporter = Reporter::new(&args.reporting);
    let files = files::Files::new(args)?;
    let file = scene_file::load(&args.scene, &args.options)?;
    scene_file::introduce(&args.options.loading, &file, &reporter)?;
    let wanted = args.options.settings(&file.path, &file.scene)?;
    let settings = RenderSettings {
        samples: asked.samples.unwrap_or(wanted.samples),
        // What is asked about, not when the probe ends: `time` is no limit here.
        error_target: asked.error.unwrap_or(0.0),
        pixel_error_target: asked.pixel_error.unwrap_or(0.0),
        passes: args.passes.passes,
        ..wanted
    };
    memory::check_render(&settings, &file.scene)?;
    let shows = files.page() && asked.effects;
    let wishes = &file.scene.color_management;
    let view = shows.then(|| View::seen_by(&args.seen, wishes, &|warning| reporter.warn(warning)));
    let question = Question {
        view: view.transpose()?,
        args,
        file,
        settings,
        reporter,
        files,
    };
    if asked.effects {
        effects::run(&question)?;
    } else {
        forecast::run(&question)?;
    }
    Ok(EXIT_OK)
}

impl Question<'_> {
    fn failure(&self, error: CostError) -> Failure {
        self.reporter.end();
        let path = self.file.path.display();
        match error {
            CostError::Render(error) => Failure::new(format!("{path}: {error}")),
            CostError::Cancelled => Failure {
                code: EXIT_INTERRUPTED,
                message: format!(
                    "{path}: interrupted before there was an answer; nothing was written"
                ),
            },
        }
    }

    /// `--probe`, or how long is rendered without it.
    fn probe(&self, default: Duration) -> Duration {
        self.args.question.probe.unwrap_or(default)
    }
}

/// Watches pictures that nobody looks at.
struct Unseen;

impl Observer for Unseen {
    fn event(&self, _: &Event) {}
    fn cancelled(&self) -> bool {
        interrupt::interrupted()
    }
}
