//! `sundog cost`: what a picture costs.

mod effects;
mod files;
mod text;

use super::flags::{EXIT_INTERRUPTED, EXIT_OK};
use super::parser::Parsed;
use super::progress::Reporter;
use super::scene_file::{self, SceneFile};
use super::{Failure, interrupt, settings};
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
}

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(parsed: Parsed) -> Result<u8, Failure> {
    interrupt::listen().map_err(Failure::new)?;
    let reporter = Reporter::new(parsed.switch("quiet"), parsed.switch("json"));
    let files = files::Files::new(parsed)?;
    let file = scene_file::load(parsed)?;
    reporter.say(&format!(
        "{}: {}",
        file.path.display(),
        scene_file::summary(&file.scene)
    ));
    reporter.diagnostics(&file.diagnostics);
    if parsed.switch("strict") {
        scene_file::demand_exact(&file.path, &file.diagnostics)?;
    }
    let wanted = settings::of(parsed, &file.path, &file.scene)?;
    let settings = RenderSettings {
        samples: parsed.integer("samples").unwrap_or(wanted.samples),
        // What is asked about, not when the probe ends.
        time_limit: None,
        ..wanted
    };
    settings::check_memory(&settings)?;
    let question = Question {
        parsed,
        file,
        settings,
        reporter,
        files,
    };
    if !parsed.switch("effects") {
        return Err(Failure::usage("nothing is asked; give --effects"));
    }
    effects::run(&question)?;
    Ok(EXIT_OK)
}

impl Question<'_> {
    fn failure(&self, error: &dyn std::fmt::Display) -> Failure {
        self.reporter.end();
        Failure::new(format!("{}: {error}", self.file.path.display()))
    }

    fn interrupted(&self) -> Failure {
        self.reporter.end();
        Failure {
            code: EXIT_INTERRUPTED,
            message: format!(
                "{}: interrupted before there was an answer; nothing was written",
                self.file.path.display()
            ),
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
