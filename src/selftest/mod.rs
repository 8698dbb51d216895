//! Hard cases: where renderers fail at the edges of floating point. Each has a known answer, analytic or an invariance.
//! `sundog selftest` runs those of this room on the user's machine: a second or less each, and all that depends on it.
//! `tests/hard_cases.rs` runs them with more work, and the others. docs/hard-cases.md says of each what goes wrong without
//! care, what is done about it, and where its bound comes from.
//!
//! A group of cases is a file; a case renders or calls what it is about and returns its findings. The fuzzer (`tests/fuzz`) and
//! other tests make their scenes with [`kit`].

pub mod kit;
pub mod light_leaks;
mod materials;
pub mod media;
pub mod place;
pub mod still_life;
mod strands;
mod sums;
mod tally;

pub use tally::Tally;

use crate::render::RenderError;
use serde::Serialize;
use std::time::{Duration, Instant};

/// How much work a case may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effort {
    /// A second or less: what `sundog selftest` does.
    Quick,
    /// Some seconds: what `make test` does.
    Thorough,
    /// Minutes: what is measured for the documentation.
    Long,
}

impl Effort {
    /// The one of three that belongs to this effort.
    pub fn of<T>(self, quick: T, thorough: T, long: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Thorough => thorough,
            Self::Long => long,
        }
    }
}

/// A hard case.
pub struct Case {
    /// Its name, as on the command line and in the documentation: words with hyphens.
    pub name: &'static str,
    /// What is hard and what has to hold, in one sentence.
    pub about: &'static str,
    /// Finds it out.
    pub run: fn(Effort) -> Result<Vec<Finding>, RenderError>,
}

/// Cases of one kind.
pub struct Group {
    /// Its name.
    pub name: &'static str,
    /// Its cases.
    pub cases: &'static [Case],
}

/// All cases.
pub static GROUPS: &[Group] = &[
    Group {
        name: "place and scale",
        cases: place::CASES,
    },
    Group {
        name: "self-intersection and gaps",
        cases: light_leaks::CASES,
    },
    Group {
        name: "materials",
        cases: materials::CASES,
    },
    Group {
        name: "media",
        cases: media::CASES,
    },
    Group {
        name: "strands",
        cases: strands::CASES,
    },
    Group {
        name: "sampling and sums",
        cases: sums::CASES,
    },
];

/// A number that a case has found, beside what it should be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was measured, with its unit if it has one.
    pub quantity: String,
    /// What it should be.
    pub expected: f64,
    /// What it is.
    pub found: f64,
    /// How far it may be from that.
    pub bound: f64,
    /// Where it was found, if that is worth telling.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub place: String,
}

impl Finding {
    /// `found` may be as far as `bound` from `expected`.
    pub fn new(quantity: impl Into<String>, expected: f64, found: f64, bound: f64) -> Self {
        Self {
            quantity: quantity.into(),
            expected,
            found,
            bound,
            place: String::new(),
        }
    }

    /// Nothing of the kind may be there.
    pub fn none(quantity: impl Into<String>, found: u64) -> Self {
        Self::new(quantity, 0.0, found as f64, 0.0)
    }

    /// A number that is not negative may be as large as the bound.
    pub fn at_most(quantity: impl Into<String>, bound: f64, found: f64) -> Self {
        Self::new(quantity, 0.0, found, bound)
    }

    /// The same, and where it was found.
    pub fn at(self, place: String) -> Self {
        Self { place, ..self }
    }

    /// Whether it is what it should be. NaN never is.
    pub fn holds(&self) -> bool {
        (self.found - self.expected).abs() <= self.bound
    }
}

/// What has come of a case.
#[derive(Debug)]
pub struct Outcome {
    /// What it found, or why it could not.
    pub findings: Result<Vec<Finding>, RenderError>,
    /// How long it took.
    pub time: Duration,
}

impl Outcome {
    /// Whether all is as it should be.
    pub fn holds(&self) -> bool {
        let all =
            |findings: &Vec<Finding>| !findings.is_empty() && findings.iter().all(Finding::holds);
        self.findings.as_ref().is_ok_and(all)
    }
}

impl Case {
    /// Runs it.
    pub fn outcome(&self, effort: Effort) -> Outcome {
        let begun = Instant::now();
        Outcome {
            findings: (self.run)(effort),
            time: begun.elapsed(),
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/selftest/mod.rs"]
mod tests;
