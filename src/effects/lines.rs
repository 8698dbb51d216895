//! What is found of effects, in lines of a name and a text.

use super::{Cause, Finding, State, Thing};
use crate::math::words::bytes;
use crate::scene::LeftOut;

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

/// Why something in the file need not be rendered.
pub fn left_out(entry: &LeftOut) -> String {
    let mut text = match entry.effect {
        None => entry.to_string(),
        Some(effect) => format!("{effect}: {entry}"),
    };
    if entry.bytes > 0 {
        text.push_str(&format!(" ({})", bytes(entry.bytes)));
    }
    text
}

/// A line for each effect that is called for or unsupported, and one for each reason why others are not.
pub fn findings(findings: &[Finding]) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
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
            State::Needed => lines.push(("effect", line())),
            State::Unsupported => lines.push(("lacking", line())),
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
        lines.push(("not needed", format!("{}: {reason}", effects.join(", "))));
    }
    lines
}
