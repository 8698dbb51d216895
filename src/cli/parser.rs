//! From the table of flags to clap's commands, and from clap's matches to values.

use super::flags::{Argument, COMMANDS, Command, EXAMPLES, Kind, PROGRAM_DOC};
use super::values::{Value, parse};
use crate::film::Passes;
use crate::render::{EffectChoice, Filter, Region};
use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The whole command line as clap sees it.
pub fn program(version: &'static str) -> clap::Command {
    let mut examples = String::from("Examples:\n");
    for (command, doc) in EXAMPLES {
        examples.push_str(&format!("  {command}\n      {doc}\n"));
    }
    clap::Command::new("sundog")
        .about(PROGRAM_DOC)
        .version(version)
        .subcommand_required(true)
        .arg_required_else_help(true)
        .disable_help_subcommand(true)
        .after_help(examples)
        .subcommands(COMMANDS.iter().map(|command| build(command)))
}

fn build(command: &'static Command) -> clap::Command {
    let mut result = clap::Command::new(command.name)
        .about(command.doc)
        .disable_help_subcommand(true);
    if !command.details.is_empty() {
        result = result.long_about(format!("{}\n\n{}", command.doc, command.details));
    }
    for group in command.groups {
        for argument in group.arguments {
            result = result.arg(build_argument(argument).help_heading(group.heading));
        }
    }
    if !command.commands.is_empty() {
        result = result
            .subcommand_required(true)
            .arg_required_else_help(true);
    }
    result.subcommands(command.commands.iter().map(build))
}

fn build_argument(argument: &'static Argument) -> Arg {
    let mut arg = Arg::new(argument.name)
        .help(argument.doc)
        .required(argument.required);
    if !argument.details.is_empty() {
        arg = arg.long_help(format!("{} {}", argument.doc, argument.details));
    }
    if !argument.positional {
        arg = arg.long(argument.name);
    }
    if let Some(short) = argument.short {
        arg = arg.short(short);
    }
    if argument.kind == Kind::Switch {
        return arg.action(ArgAction::SetTrue);
    }
    arg = arg
        .action(if argument.repeats {
            ArgAction::Append
        } else {
            ArgAction::Set
        })
        .value_name(argument.placeholder)
        .value_parser(KindParser(argument));
    if let Kind::Number { min, .. } = argument.kind
        && min < 0.0
    {
        arg = arg.allow_negative_numbers(true);
    }
    if let Some(default) = argument.default {
        arg = arg.default_value(default);
    }
    arg
}

#[derive(Clone)]
struct KindParser(&'static Argument);

impl TypedValueParser for KindParser {
    type Value = Value;

    fn parse_ref(
        &self,
        _: &clap::Command,
        _: Option<&Arg>,
        text: &OsStr,
    ) -> Result<Value, clap::Error> {
        parse(&self.0.kind, text).map_err(|expected| {
            let dashes = if self.0.positional { "" } else { "--" };
            clap::Error::raw(
                ErrorKind::ValueValidation,
                format!(
                    "{dashes}{} cannot be '{}': {expected}",
                    self.0.name,
                    text.to_string_lossy()
                ),
            )
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        match self.0.kind {
            Kind::Choice { choices } => {
                Some(Box::new(choices.iter().map(|choice| {
                    PossibleValue::new(choice.name).help(choice.doc)
                })))
            }
            _ => None,
        }
    }
}

/// clap's error as one sentence.
pub fn sentence(error: &clap::Error) -> String {
    let text = error.render().to_string();
    // clap's texts are paragraphs: what is wrong, tips, usage, where to find help. The first two
    // say something, and their lines are clauses of one sentence.
    let mut clauses = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with("Usage:") || line.starts_with("For more information") {
            break;
        }
        let line = line.strip_prefix("error: ").unwrap_or(line);
        let line = line.strip_prefix("tip: ").unwrap_or(line);
        if !line.is_empty() && !line.starts_with("[possible values") {
            clauses.push(line);
        }
    }
    let mut result = String::new();
    for clause in clauses {
        if !result.is_empty() {
            result.push_str(if result.ends_with(':') || clause.starts_with('<') {
                " "
            } else {
                "; "
            });
        }
        result.push_str(clause);
    }
    result
}

/// Access to parsed arguments by the names of the table. A name that the command's table does not
/// have counts as not given.
#[derive(Clone, Copy)]
pub struct Parsed<'a>(pub &'a ArgMatches);

impl<'a> Parsed<'a> {
    fn value(&self, name: &str) -> Option<&'a Value> {
        self.0.try_get_one::<Value>(name).ok().flatten()
    }

    /// Whether the user gave it, rather than its default.
    pub fn given(&self, name: &str) -> bool {
        self.0.try_contains_id(name).is_ok()
            && self.0.value_source(name) == Some(clap::parser::ValueSource::CommandLine)
    }

    /// A switch.
    pub fn switch(&self, name: &str) -> bool {
        self.0
            .try_get_one::<bool>(name)
            .ok()
            .flatten()
            .copied()
            .unwrap_or(false)
    }

    /// A text.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        match self.value(name)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// A file.
    pub fn path(&self, name: &str) -> Option<&'a Path> {
        match self.value(name)? {
            Value::Path(path) => Some(path),
            _ => None,
        }
    }

    /// All values of an argument that repeats.
    fn all(&self, name: &str) -> impl Iterator<Item = &'a Value> {
        let values = self.0.try_get_many::<Value>(name).ok().flatten();
        values.into_iter().flatten()
    }

    /// All files of an argument that repeats.
    pub fn paths(&self, name: &str) -> Vec<PathBuf> {
        let path = |value: &Value| match value {
            Value::Path(path) => Some(path.clone()),
            _ => None,
        };
        self.all(name).filter_map(path).collect()
    }

    /// All texts of an argument that repeats.
    pub fn texts(&self, name: &str) -> Vec<&'a str> {
        let text = |value: &'a Value| match value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        };
        self.all(name).filter_map(text).collect()
    }

    /// All words of a choice that repeats.
    pub fn choices(&self, name: &str) -> Vec<&'static str> {
        let word = |value: &'a Value| match value {
            Value::Choice(choice) => Some(*choice),
            _ => None,
        };
        self.all(name).filter_map(word).collect()
    }

    /// A whole number that fits `u32` (as the table's ranges do).
    pub fn integer(&self, name: &str) -> Option<u32> {
        match self.value(name)? {
            Value::Integer(number) => u32::try_from(*number).ok(),
            _ => None,
        }
    }

    /// A number.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.value(name)? {
            Value::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// A length of time.
    pub fn duration(&self, name: &str) -> Option<Duration> {
        match self.value(name)? {
            Value::Duration(duration) => Some(*duration),
            _ => None,
        }
    }

    /// A colour.
    pub fn color(&self, name: &str) -> Option<[f32; 3]> {
        match self.value(name)? {
            Value::Color(color) => Some(*color),
            _ => None,
        }
    }

    /// A pixel filter.
    pub fn filter(&self, name: &str) -> Option<Filter> {
        match self.value(name)? {
            Value::Filter(filter) => Some(*filter),
            _ => None,
        }
    }

    /// Effects.
    pub fn effects(&self, name: &str) -> Option<EffectChoice> {
        match self.value(name)? {
            Value::Effects(effects) => Some(effects.clone()),
            _ => None,
        }
    }

    /// A sample of a pixel: column, row, number.
    pub fn sample(&self, name: &str) -> Option<(u32, u32, u32)> {
        match self.value(name)? {
            Value::Sample(x, y, sample) => Some((*x, *y, *sample)),
            _ => None,
        }
    }

    /// From, and the one after the last.
    pub fn range(&self, name: &str) -> Option<(u32, u32)> {
        match self.value(name)? {
            Value::Range(from, to) => Some((*from, *to)),
            _ => None,
        }
    }

    /// A share.
    pub fn share(&self, name: &str) -> Option<f64> {
        match self.value(name)? {
            Value::Share(share) => Some(*share),
            _ => None,
        }
    }

    /// Passes.
    pub fn passes(&self, name: &str) -> Option<Passes> {
        match self.value(name)? {
            Value::Passes(passes) => Some(*passes),
            _ => None,
        }
    }

    /// When Russian roulette begins; `None` for never.
    pub fn roulette(&self, name: &str) -> Option<Option<u32>> {
        match self.value(name)? {
            Value::Roulette(bounce) => Some(*bounce),
            _ => None,
        }
    }

    /// A rectangle of pixels.
    pub fn region(&self, name: &str) -> Option<Region> {
        match self.value(name)? {
            Value::Region(region) => Some(*region),
            _ => None,
        }
    }

    /// One of a few words; empty where the command has no such argument.
    pub fn choice(&self, name: &str) -> &'static str {
        match self.value(name) {
            Some(Value::Choice(choice)) => choice,
            _ => "",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{LightSampling, RenderSettings};

    #[test]
    fn clap_accepts_the_table() {
        program("1").debug_assert();
    }

    #[test]
    fn defaults_of_the_table_are_those_of_the_renderer() {
        let matches = program("1").get_matches_from(["sundog", "render", "a.glb", "-o", "b.exr"]);
        let (_, matches) = matches.subcommand().unwrap();
        let parsed = Parsed(matches);
        let settings = RenderSettings::default();
        assert_eq!(parsed.integer("samples"), Some(settings.samples));
        assert_eq!(parsed.duration("time"), settings.time_limit);
        assert_eq!(parsed.integer("bounces"), Some(settings.bounces));
        assert_eq!(
            parsed.integer("bounces-diffuse"),
            settings.bounce_limits.diffuse
        );
        assert_eq!(
            parsed.number("clamp-direct"),
            Some(f64::from(settings.clamp_direct))
        );
        assert_eq!(
            parsed.number("clamp-indirect"),
            Some(f64::from(settings.clamp_indirect))
        );
        assert_eq!(
            parsed.number("filter-glossy"),
            Some(f64::from(settings.filter_glossy))
        );
        assert_eq!(
            parsed.number("film-exposure"),
            Some(f64::from(settings.film_exposure))
        );
        assert_eq!(parsed.choice("caustics"), "all");
        assert_eq!(settings.caustics, crate::render::Caustics::default());
        assert_eq!(parsed.integer("seed"), Some(settings.seed));
        assert_eq!(parsed.filter("filter"), Some(settings.filter));
        assert_eq!(parsed.effects("effects"), Some(settings.effects));
        assert_eq!(parsed.passes("passes"), Some(settings.passes));
        let target = |name| parsed.share(name).unwrap_or(0.0);
        assert_eq!(target("error"), settings.error_target);
        assert_eq!(target("pixel-error"), settings.pixel_error_target);
        assert_eq!(parsed.choice("light-sampling"), "mis");
        assert_eq!(settings.light_sampling, LightSampling::Mis);
        assert_eq!(
            parsed.integer("light-samples"),
            Some(settings.light_samples)
        );
        assert_eq!(parsed.roulette("roulette"), Some(settings.roulette));
        assert_eq!(parsed.switch("backface-culling"), settings.cull_backfaces);
        assert!(!parsed.given("samples"));
    }

    fn error_of(arguments: &[&str]) -> String {
        let all = std::iter::once("sundog").chain(arguments.iter().copied());
        sentence(&program("1").try_get_matches_from(all).unwrap_err())
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
            assert_eq!(error_of(arguments), expected);
        }
    }

    #[test]
    fn negative_numbers_are_values() {
        let matches = program("1").get_matches_from([
            "sundog",
            "render",
            "a",
            "-o",
            "b",
            "--exposure",
            "-1.5",
            "--environment-rotation",
            "-90",
        ]);
        let (_, matches) = matches.subcommand().unwrap();
        assert_eq!(Parsed(matches).number("exposure"), Some(-1.5));
        assert_eq!(Parsed(matches).number("environment-rotation"), Some(-90.0));
    }
}
