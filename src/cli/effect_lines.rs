//! What `sundog info` says of effects, in lines.

use super::console;
use crate::effects::{Finding, lines};
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

/// A line for each reason why something in the file need not be rendered.
pub fn left_out_lines(left_out: &[LeftOut], page: &mut Page) {
    for text in left_out.iter().map(lines::left_out) {
        page.line("left out", text);
    }
}

/// A line for each effect that is called for or unsupported, and one for each reason why others are not.
pub fn effect_lines(findings: &[Finding], page: &mut Page) {
    for (name, text) in lines::findings(findings) {
        page.line(name, text);
    }
}

#[cfg(test)]
#[path = "../../tests/unit/cli/effect_lines.rs"]
mod tests;
