//! `sundog cost`: what a picture costs.

use super::args::Cost;
use super::exit::{EXIT_INTERRUPTED, EXIT_OK};
use super::progress::Reporter;
use super::report_file::{Kind, ReportFiles, check_page, pretty};
use super::scene_file::{self, SceneFile};
use super::view::View;
use super::{Failure, console, interrupt};
use crate::cost::{self, CostError, ForecastQuery, ForecastReport, Study};
use crate::measure::{self, Encoding};
use crate::render::{Event, Observer, RenderSettings, memory};
use crate::report::{Page, Table};
use serde::Serialize;
use serde_json::json;
use std::time::Duration;

/// How long a forecast's probe renders, where `--probe` does not say otherwise.
const FORECAST_PROBE: Duration = Duration::from_secs(4);
/// The same of each picture with or without an effect.
const EFFECT_PROBE: Duration = Duration::from_secs(1);

/// What all parts of the command work with.
struct Question<'a> {
    args: &'a Cost,
    file: SceneFile,
    /// The picture that is asked about.
    settings: RenderSettings,
    reporter: Reporter,
    files: ReportFiles,
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
    let files = files(args)?;
    let mut file = scene_file::load(&args.scene, &args.options)?;
    args.passes.light_groups.choose(&mut file.scene);
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
    let question = Question {
        args,
        file,
        settings,
        reporter,
        files,
    };
    if asked.effects {
        effects(question)?;
    } else {
        forecast(question)?;
    }
    Ok(EXIT_OK)
}

/// The files that `--output` and `--report` name.
fn files(args: &Cost) -> Result<ReportFiles, Failure> {
    let mut files = ReportFiles::default();
    for path in &args.output {
        match Kind::of(path) {
            Some(kind @ (Kind::Json | Kind::Csv)) => files.add(path, kind)?,
            _ => {
                return Err(Failure::usage(format!(
                    "--output {} must end in .json or .csv",
                    path.display()
                )));
            }
        }
    }
    let page = args.report.as_deref();
    check_page("report", page, "html")?;
    if let Some(path) = page {
        files.add(path, Kind::Html)?;
    }
    Ok(files)
}

/// Error and time ahead, after a short probe.
fn forecast(question: Question) -> Result<(), Failure> {
    let (wanted, scene) = (&question.args.question, &question.file.scene);
    let time = wanted.probe.unwrap_or(FORECAST_PROBE);
    let probe = cost::probe(scene, &question.settings, time, &Unseen)
        .map_err(|error| question.failure(error))?;
    let settings = question.settings.clone();
    let asked = ForecastQuery {
        error: wanted.error,
        seconds: wanted.time.map(|time| time.as_secs_f64()),
        samples: wanted.samples,
    };
    let path = question.file.path.clone();
    let answer = ForecastReport::new(&path, &settings, &probe, asked)
        .ok_or_else(|| Failure::new(format!("{}: {}", path.display(), probe.lacking())))?;
    let sentences = answer.sentences();
    question.tell(
        &answer,
        &answer.headline(),
        &answer.table(),
        &sentences,
        || Ok(answer.page()),
    )
}

#[derive(Serialize)]
struct EffectsAnswer<'a> {
    event: &'static str,
    scene: String,
    settings: &'a RenderSettings,
    #[serde(flatten)]
    study: &'a Study,
}

/// What each effect costs and gives.
fn effects(question: Question) -> Result<(), Failure> {
    let (wanted, scene) = (&question.args.question, &question.file.scene);
    let shows = question.files.any(Kind::Html);
    let warn = |warning: &str| question.reporter.warn(warning);
    let view = shows.then(|| View::seen_by(&question.args.seen, &scene.color_management, &warn));
    let view = view.transpose()?;
    let time = wanted.probe.unwrap_or(EFFECT_PROBE);
    let measured = cost::measured_settings(scene, &question.settings, wanted.side, time, &Unseen)
        .map_err(|error| question.failure(error))?;
    let variants = cost::variants(scene, &measured);
    let step = |done: usize, of: usize, name: &str| {
        let what = match name {
            "" => "the full picture".to_owned(),
            name => format!("without {name}"),
        };
        question.reporter.step(done, of, &what);
        question
            .reporter
            .tell(&json!({ "event": "measuring", "done": done, "of": of, "without": name }));
    };
    let settings = question.settings.clone();
    let study = cost::study(
        scene,
        &settings,
        &measured,
        &variants,
        wanted.rounds,
        &Unseen,
        &step,
    )
    .map_err(|error| question.failure(error))?;
    question.reporter.end();
    let path = question.file.path.clone();
    let answer = EffectsAnswer {
        event: "effects",
        scene: path.display().to_string(),
        settings: &settings,
        study: &study,
    };
    let page = || {
        let Some(view) = &view else {
            return Ok(study.page(&path, &settings, Vec::new(), ""));
        };
        let [width, height] = study.measured_region;
        let shown = study.shown(|name, light| -> Result<_, Failure> {
            let light = measure::RgbImage {
                width,
                height,
                pixels: light.as_chunks().0.to_vec(),
                encoding: Encoding::Linear,
            };
            Ok(view.seen(&light)?.as_codes(name))
        })?;
        Ok(study.page(&path, &settings, shown, &view.summary()))
    };
    question.tell(&answer, &study.headline(), &study.table(), &[], page)
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

    /// Writes and prints what was found.
    fn tell(
        mut self,
        answer: &impl Serialize,
        headline: &str,
        table: &Table,
        sentences: &[String],
        page: impl Fn() -> Result<Page, Failure>,
    ) -> Result<(), Failure> {
        self.files.write(|kind| match kind {
            Kind::Csv => Ok(table.csv().into_bytes()),
            Kind::Html => Ok(page()?.html()?.into_bytes()),
            _ => pretty(answer),
        })?;
        self.reporter.tell(answer);
        if !self.args.reporting.json {
            console::output(&format!("{headline}\n\n{}", table.text()));
            for sentence in sentences {
                console::output(&format!("{sentence}\n"));
            }
        }
        for name in self.files.written {
            self.reporter.say(&format!("{name} written"));
            self.reporter
                .tell(&json!({ "event": "written", "file": name }));
        }
        Ok(())
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
