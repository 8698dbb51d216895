//! A fuzzer: random scenes and parameters at the edges through all kernels, damaged files through all importers.
//!
//! An input is a tree of JSON, so that one rule makes any of them smaller ([`shrink`]): a scene ([`recipe`] draws
//! it, [`build`] makes it), or a file and what damages it ([`files`], of [`document`]). [`check`] says what is wrong with one.
//! `tests/fuzz/main.rs` runs for as long as it is asked; what it finds is kept in `tests/fuzz/found/`, which a test replays.

mod build;
pub mod corpus;
pub mod document;
mod dull;
mod equal;
mod files;
mod kinds;
mod recipe;
mod rng;
pub mod seeds;
mod shrink;
mod verdict;

pub use equal::{Compared, draw as draw_for_kernels, kernels};
pub use files::{damaged, import, kept_name};
pub use kinds::is_of_colors;
pub use shrink::shrink;

use serde_json::Value;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A random input: every third is a damaged file.
pub fn draw(seed: u64) -> Value {
    let mut rng = rng::Rng::new(seed);
    if rng.chance(1.0 / 3.0) {
        files::draw(&mut rng)
    } else {
        recipe::draw(&mut rng)
    }
}

/// What is wrong with an input, in one sentence; nothing if all is well.
pub fn check(input: &Value) -> Option<String> {
    let run = || match input.get("file") {
        Some(_) => files::check(input),
        None => verdict::scene(input),
    };
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(verdict) => verdict,
        Err(panic) => {
            let text = panic
                .downcast_ref::<String>()
                .cloned()
                .or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
            Some(format!("panic, {}", text.unwrap_or_default()))
        }
    }
}

/// The kind of a finding, by which a smaller input is known to show the same: its words before a number or a colon.
pub fn kind(finding: &str) -> String {
    finding
        .split(|c: char| c.is_ascii_digit() || c == ':')
        .next()
        .unwrap_or_default()
        .chars()
        .take(60)
        .collect()
}
