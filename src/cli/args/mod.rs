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
mod tests {
    use super::*;
    use clap::FromArgMatches;

    fn parsed(arguments: &[&str]) -> Result<Command, clap::Error> {
        let all = std::iter::once("sundog").chain(arguments.iter().copied());
        let matches = program().try_get_matches_from(all)?;
        Ok(Program::from_arg_matches(&matches)?.command)
    }

    fn render(more: &[&str]) -> Render {
        match parsed(&[&["render", "a.glb", "-o", "b.exr"], more].concat()) {
            Ok(Command::Render(render)) => *render,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn clap_accepts_the_commands() {
        program().debug_assert();
    }

    #[test]
    fn what_the_scene_may_decide_is_known_to_be_given_or_not() {
        let without = render(&[]);
        assert_eq!(without.effort.samples, None);
        assert_eq!(without.options.size.filter, None);
        assert_eq!(without.options.size.film_exposure, None);
        assert_eq!(without.view.seen.exposure, None);
        assert_eq!(render(&["--samples=256"]).effort.samples, Some(256));
    }

    /// What help shows as a default is a value, and for renders the library's own.
    #[test]
    fn presets_are_what_holds_without_the_flag() {
        fn presets(command: &clap::Command, check: &mut dyn FnMut(&str, &clap::Arg, &str)) {
            for arg in command.get_arguments() {
                if let Some(Preset(value)) = arg.get::<Preset>() {
                    check(command.get_name(), arg, value);
                }
            }
            for inner in command.get_subcommands() {
                presets(inner, check);
            }
        }
        let mut seen = 0;
        presets(&program(), &mut |_, arg, value| {
            let text = format!("--{}={value}", arg.get_long().unwrap());
            let command = clap::Command::new("x").arg(arg.clone());
            command.try_get_matches_from(["x", &text]).unwrap();
            seen += 1;
        });
        assert!(seen > 10);
        let settings = crate::render::RenderSettings::default();
        let given = render(&[
            "--samples=256",
            "--film-exposure=1",
            "--filter=blackman-harris:1.5",
        ]);
        assert_eq!(given.effort.samples, Some(settings.samples));
        assert_eq!(
            given.options.size.film_exposure,
            Some(f64::from(settings.film_exposure))
        );
        assert_eq!(given.options.size.filter, Some(settings.filter));
    }

    #[test]
    fn errors_are_one_line() {
        for (arguments, expected) in [
            (
                &["render", "a", "-o", "b", "--width", "0"][..],
                "--width cannot be '0': expected a whole number from 1 to 65536",
            ),
            (
                &["render", "a", "-o", "b", "--exposure", "x"],
                "--exposure cannot be 'x': expected a number from -32 to 32",
            ),
            (
                &["render", "a", "-o", "b", "--exr-type=double"],
                "--exr-type cannot be 'double': expected float or half",
            ),
            (
                &["render", "a", "-o", ""],
                "a value is required for '--output <FILE>' but none was supplied",
            ),
            (
                &["render", "a", "--exr-type"],
                "--exr-type cannot be '': expected float or half",
            ),
            (
                &["completions", "tcsh"],
                "SHELL cannot be 'tcsh': expected bash, elvish, fish, powershell or zsh",
            ),
            (
                &["render"],
                "the following required arguments were not provided: <SCENE>",
            ),
            (
                &["render", "a", "-o", "b", "--sample", "3"],
                "unexpected argument '--sample' found; a similar argument exists: '--samples'",
            ),
            (
                &["rendr"],
                "unrecognized subcommand 'rendr'; a similar subcommand exists: 'render'",
            ),
        ] {
            assert_eq!(sentence(&parsed(arguments).unwrap_err()), expected);
        }
    }

    #[test]
    fn negative_numbers_are_values() {
        let given = render(&["--exposure", "-1.5", "--environment-rotation", "-90"]);
        assert_eq!(given.view.seen.exposure, Some(-1.5));
        assert_eq!(given.options.environment.environment_rotation, Some(-90.0));
    }
}
