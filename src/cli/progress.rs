//! What a render tells, as a bar for people or as lines of JSON for programs.

use super::args::Reporting;
use super::{console, interrupt};
use crate::math::words::{duration, estimated, percent};
use crate::render::{Event, ForecastRow, Observer};
use crate::scene::{Diagnostics, Verdict};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use serde_json::json;
use std::sync::atomic::{AtomicBool, Ordering};

/// Steps of the bar.
const STEPS: u64 = 10_000;

/// Whether the bar stands on the terminal.
static BAR_STANDS: AtomicBool = AtomicBool::new(false);

/// Empties the line of the bar, for the case that the process must go at once: the bar itself may be in the hands of a
/// thread that waits.
pub fn take_bar_off() {
    if BAR_STANDS.load(Ordering::Relaxed) {
        console::empty_line();
    }
}

/// Shows the bar if somebody watches.
fn show(bar: &ProgressBar) {
    if console::watched() {
        bar.set_draw_target(ProgressDrawTarget::stderr());
        BAR_STANDS.store(true, Ordering::Relaxed);
    }
}

/// Tells what happens.
pub enum Reporter {
    /// Words on the standard error, with a bar if somebody watches.
    People(ProgressBar),
    /// Objects on the standard output.
    Programs,
    /// Nobody listens.
    Nobody,
}

impl Reporter {
    /// By the flags.
    pub fn new(flags: &Reporting) -> Self {
        if flags.json {
            return Self::Programs;
        }
        if flags.quiet {
            return Self::Nobody;
        }
        let bar = ProgressBar::hidden();
        bar.set_length(STEPS);
        if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} % · {msg}") {
            bar.set_style(style);
        }
        Self::People(bar)
    }

    /// A sentence for people.
    pub fn say(&self, text: &str) {
        if let Self::People(bar) = self {
            bar.suspend(|| console::message(text));
        }
    }

    /// A sentence that both people and programs should have.
    pub fn warn(&self, text: &str) {
        match self {
            Self::People(_) => self.say(&format!("warning: {text}")),
            Self::Programs => self.tell(&json!({ "event": "warning", "message": text })),
            Self::Nobody => {}
        }
    }

    /// An object for programs. A program that has gone away would not hear of the end: then this is it.
    pub fn tell(&self, event: &impl Serialize) {
        if let Self::Programs = self
            && !console::json_line(event)
        {
            interrupt::nobody_watches();
        }
    }

    /// All messages of the importer, each once.
    pub fn diagnostics(&self, diagnostics: &Diagnostics) {
        #[derive(Serialize)]
        struct Line<'a> {
            event: &'static str,
            #[serde(flatten)]
            diagnostic: &'a crate::scene::Diagnostic,
        }
        for diagnostic in diagnostics.iter() {
            self.say(&format!(
                "{}: {}",
                verdict_word(diagnostic.verdict),
                diagnostic.introduced()
            ));
            self.tell(&Line {
                event: "diagnostic",
                diagnostic,
            });
        }
    }

    /// A piece of work of several is about to begin.
    pub fn step(&self, done: usize, of: usize, what: &str) {
        let Self::People(bar) = self else { return };
        show(bar);
        bar.set_position(STEPS * done as u64 / of.max(1) as u64);
        bar.set_message(console::one_line(what).into_owned());
    }

    /// Takes the bar away.
    pub fn end(&self) {
        if let Self::People(bar) = self {
            bar.finish_and_clear();
            BAR_STANDS.store(false, Ordering::Relaxed);
        }
    }
}

/// How a verdict is introduced.
pub fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Exact => "note",
        Verdict::Approximated => "approximated",
        Verdict::Lost => "left out",
    }
}

/// `error 8.0 % in 3.0 s (2.7 s to 3.4 s), 4.0 % in …`: what is ahead.
fn foretold(table: &[ForecastRow]) -> String {
    let rows: Vec<String> = table
        .iter()
        .filter(|row| !row.reached)
        .map(|row| {
            let error = percent(row.error);
            format!("{error} in {}", row.seconds.words(duration))
        })
        .collect();
    format!("forecast: error {}", rows.join(", "))
}

impl Observer for Reporter {
    fn event(&self, event: &Event) {
        self.tell(event);
        let Self::People(bar) = self else { return };
        match event {
            Event::Prepared { .. } => show(bar),
            Event::Progress {
                samples,
                of,
                fraction,
                seconds,
                rays,
                remaining,
                error,
                to_goal,
            } => {
                bar.set_position((fraction.clamp(0.0, 1.0) * STEPS as f64) as u64);
                let mut line = format!("{samples}/{of} samples");
                if *seconds > 0.0 {
                    line.push_str(&format!(" · {:.2} Mray/s", *rays as f64 / seconds / 1e6));
                }
                if let Some(error) = error {
                    line.push_str(&format!(" · error {}", estimated(error.error, error.low, error.high)));
                }
                if let Some(left) = to_goal {
                    line.push_str(&format!(" · goal in {}", left.words(duration)));
                } else if let Some(remaining) = remaining {
                    line.push_str(&format!(" · {} left", console::clock(*remaining)));
                }
                bar.set_message(line);
            }
            Event::Forecast { table, .. } => self.say(&foretold(table)),
            Event::Preparing { shining, seconds } => self.say(&format!(
                "preparing {} triangles that shine: this may take {}, before the first sample and whatever --time says",
                console::grouped(*shining),
                console::clock(*seconds)
            )),
        }
    }

    fn cancelled(&self) -> bool {
        interrupt::interrupted()
    }
}
