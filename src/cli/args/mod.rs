//! What the command line takes: each command is a struct whose fields are its flags, from which clap derives the parser and its
//! help. `docs/cli.md`, the list for programs, the man page and completions come from the same ([`pages`]).

mod commands;
mod groups;
pub mod pages;
mod values;
#[rustfmt::skip] // Tables.
mod words;

pub use commands::*;
pub use groups::*;
pub use values::{MAX_SAMPLES, Sample};

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::error::Error;
use values::{Preset, alternatives};

/// The whole command line as clap sees it.
pub fn program() -> clap::Command {
    with_presets(Program::command())
}

/// Help shows what holds without a flag, also where the scene may have a say.
fn with_presets(command: clap::Command) -> clap::Command {
    let shown = |arg: clap::Arg| {
        let Some(Preset(value)) = arg.get::<Preset>().cloned() else {
            return arg;
        };
        let short = arg.get_help().cloned().unwrap_or_default();
        match arg.get_long_help().cloned() {
            Some(long) => arg.long_help(format!("{long}\n\n[default: {value}]")),
            None => arg.long_help(format!("{short}\n\n[default: {value}]")),
        }
        .help(format!("{short} [default: {value}]"))
    };
    command.mut_args(shown).mut_subcommands(with_presets)
}

/// clap's error as one sentence.
pub fn sentence(error: &clap::Error) -> String {
    cannot_be(error).unwrap_or_else(|| clauses(&error.render().to_string()))
}

/// `--width cannot be '0': expected a whole number from 1 to 65536`, if it is about a value.
fn cannot_be(error: &clap::Error) -> Option<String> {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    // `--width <PIXELS>`, `<SCENE>` or `[PART]...`.
    let argument = text(ContextKind::InvalidArg)?.split(' ').next()?;
    let argument = argument.trim_matches(['<', '>', '[', ']', '.']);
    let value = text(ContextKind::InvalidValue)?;
    let expected = match (error.kind(), error.get(ContextKind::ValidValue)) {
        (ErrorKind::InvalidValue, Some(ContextValue::Strings(words))) if !words.is_empty() => {
            format!("expected {}", alternatives(words))
        }
        (ErrorKind::ValueValidation, _) => error.source()?.to_string(),
        _ => return None,
    };
    Some(format!("{argument} cannot be '{value}': {expected}"))
}

/// clap's texts are paragraphs: what is wrong, tips, usage, where to find help. The first two say something, and their lines are
/// clauses of one sentence.
fn clauses(text: &str) -> String {
    let mut result = String::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with("Usage:") || line.starts_with("For more information") {
            break;
        }
        let line = line.strip_prefix("error: ").unwrap_or(line);
        let line = line.strip_prefix("tip: ").unwrap_or(line);
        if line.is_empty() || line.starts_with("[possible values") {
            continue;
        }
        if !result.is_empty() {
            let follows = result.ends_with(':') || line.starts_with('<');
            result.push_str(if follows { " " } else { "; " });
        }
        result.push_str(line);
    }
    result
}

#[cfg(test)]
#[path = "../../../tests/unit/cli/args/mod.rs"]
mod tests;
