//! `sundog cost`: what a picture costs.

mod effects;
mod files;
mod forecast;

use super::flags::{EXIT_INTERRUPTED, EXIT_OK};
use super::parser::Parsed;
use super::progress::Reporter;
use super::scene_file::{self, SceneFile};
use super::view::View;
use super::{Failure, interrupt, settings};
use crate::cost::CostError;
use crate::render::{Event, Observer, RenderSettings};
use std::time::Duration;

/// What all parts of the command work with.
struct Question<'a> {
    parsed: Parsed<'a>,
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
pub fn run(parsed: Parsed) -> Result<u8, Failure> {
    if parsed.given("pixel-error") && !parsed.switch("effects") {
        return Err(Failure::usage(
            "--pixel-error asks what adaptive sampling gives, which --effects measures; add it, or ask for the time to an --error",
        ));
    }
    let reporter = Reporter::new(parsed.switch("quiet"), parsed.switch("json"));
    let files = files::Files::new(parsed)?;
    let file = scene_file::load(parsed)?;
    scene_file::introduce(parsed, &file, &reporter)?;
    let wanted = settings::of(parsed, &file.path, &file.scene)?;
    let settings = RenderSettings {
        samples: parsed.integer("samples").unwrap_or(wanted.samples),
        // What is asked about, not when the probe ends.
        time_limit: None,
        ..wanted
    };
    settings::check_memory(&settings, &file.scene)?;
    let shows = files.page() && parsed.switch("effects");
    let wishes = &file.scene.color_management;
    let view = shows.then(|| View::new(parsed, wishes, &|warning| reporter.warn(warning)));
    let question = Question {
        view: view.transpose()?,
        parsed,
        file,
        settings,
        reporter,
        files,
    };
    if parsed.switch("effects") {
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
        self.parsed.duration("probe").unwrap_or(default)
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
