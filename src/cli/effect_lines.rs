//! What `sundog info` says of effects, in lines.

use super::console;
use crate::effects::{Cause, Finding, State, Thing};
use crate::scene::LeftOut;

/// Lines of a name and a text.
#[derive(Default)]
pub struct Page(String);

impl Page {
    /// Adds one.
    pub fn line(&mut self, name: &str, text: String) {
        let text = console::one_line(&text);
        self.0.push_str(&format!("{name:<13} {text}\n"));
    }

    /// Adds the lines of another.
    pub fn append(&mut self, other: &Self) {
        self.0.push_str(&other.0);
    }

    /// All of it.
    pub fn text(&self) -> &str {
        &self.0
    }
}

/// Names that a line shows; JSON has more.
const SHOWN: usize = 4;

fn cause(cause: &Cause) -> String {
    match (cause.kind, &cause.object) {
        (Thing::Material, Some(object)) => format!("{} (on {object})", cause.name),
        _ => cause.name.clone(),
    }
}

fn causes(finding: &Finding) -> String {
    let shown: Vec<_> = finding.because_of.iter().take(SHOWN).map(cause).collect();
    let more = finding.count.saturating_sub(shown.len());
    let names = shown.join(", ");
    if more == 0 {
        names
    } else {
        format!("{names} and {more} more")
    }
}

/// A line for each reason why something in the file need not be rendered.
pub fn left_out_lines(left_out: &[LeftOut], page: &mut Page) {
    for entry in left_out {
        let mut text = match entry.effect {
            None => entry.to_string(),
            Some(effect) => format!("{effect}: {entry}"),
        };
        if entry.bytes > 0 {
            text.push_str(&format!(" ({})", console::bytes(entry.bytes)));
        }
        page.line("left out", text);
    }
}

/// A line for each effect that is called for or unsupported, and one for each reason why others are not.
pub fn effect_lines(findings: &[Finding], page: &mut Page) {
    for finding in findings {
        let line = || {
            format!(
                "{} ({}): {}",
                finding.effect,
                finding.about,
                causes(finding)
            )
        };
        match finding.state {
            State::Needed => page.line("effect", line()),
            State::Unsupported => page.line("lacking", line()),
            State::LeftOut => {}
        }
    }
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for finding in findings.iter().filter(|f| f.state == State::LeftOut) {
        for reason in &finding.reasons {
            match reasons.iter_mut().find(|(known, _)| known == reason) {
                Some((_, effects)) => effects.push(finding.effect.id()),
                None => reasons.push((reason, vec![finding.effect.id()])),
            }
        }
    }
    for (reason, effects) in reasons {
        page.line("not needed", format!("{}: {reason}", effects.join(", ")));
    }
}

#[cfg(test)]
#[path = "../../tests/unit/cli/effect_lines.rs"]
mod tests;
