//! Documentation made from the commands: `docs/cli.md`, the list for programs, examples, exit codes.

use super::program;
use super::values::{Color, Sample};
use super::values::{Number, Preset, Roulette, SampleRange, Whole, alternatives};
use crate::cli::exit::EXIT_CODES;
use crate::film::{Passes, passes};
use crate::output::tev;
use crate::render::{EffectChoice, Filter, Region};
use clap::{Arg, ArgAction, Command};
use serde_json::{Value, json};
use std::any::TypeId;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

/// They stand at the end of the help and of the page, a command and what it does in each line.
const EXAMPLES: &str = include_str!("examples.md");

/// The end of the help.
pub fn examples() -> String {
    let mut text = String::from("Examples:\n");
    for (command, doc) in EXAMPLES.lines().filter_map(|line| line.split_once("`: ")) {
        let command = command.trim_start_matches("- `");
        let _ = writeln!(text, "  {command}\n      {doc}");
    }
    text
}

/// The first paragraph of a help, and the rest of it. (clap takes the stop from the end of the first.)
fn doc_and_details(short: Option<String>, long: Option<String>) -> (String, String) {
    let doc = format!("{}.", short.unwrap_or_default());
    let details = long.and_then(|long| Some(long.split_once("\n\n")?.1.to_owned()));
    (doc, details.unwrap_or_default())
}

fn about(command: &Command) -> (String, String) {
    let text = |text: Option<&clap::builder::StyledStr>| text.map(ToString::to_string);
    doc_and_details(text(command.get_about()), text(command.get_long_about()))
}

fn help(arg: &Arg) -> (String, String) {
    let mut short = arg.get_help().map(ToString::to_string);
    let mut long = arg.get_long_help().map(ToString::to_string);
    if let Some(Preset(value)) = arg.get::<Preset>() {
        let end = format!("[default: {value}]");
        for text in [&mut short, &mut long].into_iter().flatten() {
            *text = text.trim_end_matches(&end).trim_end().to_owned();
        }
    }
    doc_and_details(short, long)
}

/// Headings in their order, each with its arguments.
fn groups(command: &Command) -> Vec<(&str, Vec<&Arg>)> {
    let mut groups: Vec<(&str, Vec<&Arg>)> = Vec::new();
    for arg in command.get_arguments() {
        let heading = arg.get_help_heading().unwrap_or_default();
        match groups.iter_mut().find(|(known, _)| *known == heading) {
            Some((_, args)) => args.push(arg),
            None => groups.push((heading, vec![arg])),
        }
    }
    groups
}

fn is_switch(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::SetTrue)
}

/// What stands for the value; empty for a switch.
fn placeholder(arg: &Arg) -> &str {
    let names = arg.get_value_names().filter(|_| !is_switch(arg));
    names
        .and_then(|names| names.first())
        .map_or("", |name| name)
}

/// The long name; of a positional argument, its name in messages.
fn name(arg: &Arg) -> &str {
    arg.get_long().unwrap_or(arg.get_id().as_str())
}

fn default(arg: &Arg) -> Option<String> {
    let value = arg.get_default_values().first();
    let value = value.map(|value| value.to_string_lossy().into_owned());
    let preset = arg.get::<Preset>().map(|Preset(value)| (*value).to_owned());
    value.filter(|_| !is_switch(arg)).or(preset)
}

/// The words that an argument takes, each with what it means.
fn choices(arg: &Arg) -> Vec<(String, String)> {
    let words = arg.get_possible_values().into_iter();
    let words = words.map(|word| {
        let meaning = word.get_help().map(ToString::to_string);
        (word.get_name().to_owned(), meaning.unwrap_or_default())
    });
    words.collect()
}

/// What kind of value an argument takes, with its range.
fn kind(arg: &Arg) -> Value {
    if is_switch(arg) {
        return json!({ "type": "switch" });
    }
    if let Some(Whole(range)) = arg.get::<Whole>() {
        return json!({ "type": "integer", "min": range.start(), "max": range.end() });
    }
    if let Some(Number(range)) = arg.get::<Number>() {
        return json!({ "type": "number", "min": range.start(), "max": range.end() });
    }
    let words = choices(arg);
    if !words.is_empty() {
        let word = |(name, doc)| json!({ "name": name, "doc": doc });
        let words: Vec<Value> = words.into_iter().map(word).collect();
        return json!({ "type": "choice", "choices": words });
    }
    let of = arg.get_value_parser().type_id();
    let kinds = [
        (TypeId::of::<PathBuf>(), "path"),
        (TypeId::of::<Duration>(), "duration"),
        (TypeId::of::<f64>(), "share"),
        (TypeId::of::<Color>(), "color"),
        (TypeId::of::<Filter>(), "filter"),
        (TypeId::of::<EffectChoice>(), "effects"),
        (TypeId::of::<Passes>(), "passes"),
        (TypeId::of::<Roulette>(), "roulette"),
        (TypeId::of::<Region>(), "region"),
        (TypeId::of::<Sample>(), "sample"),
        (TypeId::of::<SampleRange>(), "range"),
    ];
    if of == TypeId::of::<tev::Address>() {
        return json!({ "type": "address", "port": tev::PORT });
    }
    let kind = kinds.iter().find(|(id, _)| of == *id);
    json!({ "type": kind.map_or("text", |(_, kind)| kind) })
}

fn argument(arg: &Arg) -> Value {
    let (doc, details) = help(arg);
    let mut listed = json!({
        "name": name(arg),
        "short": arg.get_short(),
        "positional": arg.is_positional(),
        "placeholder": placeholder(arg),
        "required": arg.is_required_set(),
        "repeats": matches!(arg.get_action(), ArgAction::Append),
        "default": default(arg),
        "doc": doc,
        "details": details,
    });
    if let (Some(listed), Value::Object(kind)) = (listed.as_object_mut(), kind(arg)) {
        listed.extend(kind);
    }
    listed
}

fn command(command: &Command) -> Value {
    let (doc, details) = about(command);
    let group = |(heading, args): (&str, Vec<&Arg>)| {
        let arguments: Vec<Value> = args.into_iter().map(argument).collect();
        json!({ "heading": heading, "arguments": arguments })
    };
    let groups: Vec<Value> = groups(command).into_iter().map(group).collect();
    let commands: Vec<Value> = command.get_subcommands().map(self::command).collect();
    json!({
        "name": command.get_name(),
        "doc": doc,
        "details": details,
        "groups": groups,
        "commands": commands,
    })
}

/// All commands and flags, for programs.
pub fn listing() -> Value {
    let program = program();
    let exit_code = |(code, doc): &(u8, &str)| json!({ "code": code, "doc": doc });
    json!({
        "program": "sundog",
        "version": env!("CARGO_PKG_VERSION"),
        "doc": about(&program).0,
        "commands": program.get_subcommands().map(command).collect::<Vec<_>>(),
        "exit_codes": EXIT_CODES.iter().map(exit_code).collect::<Vec<_>>(),
    })
}

/// The text of `docs/cli.md`.
pub fn markdown() -> String {
    let program = program();
    let mut page = format!(
        "# The command line\n\n<!-- Made by `sundog flags --markdown` from src/cli/args/; don't edit. -->\n\n{}\n\n",
        about(&program).0
    );
    for command in program.get_subcommands() {
        write_command(&mut page, "sundog", command, 2);
    }
    page.push_str("## Exit codes\n\n| code | when |\n| --- | --- |\n");
    for (code, doc) in EXIT_CODES {
        let _ = writeln!(page, "| {code} | {} |", cell(doc));
    }
    page.push_str(concat!("\n", include_str!("passes.md")));
    for (_, name, channels, doc) in &passes::TABLE {
        let _ = writeln!(page, "| `{name}` | {channels} | {doc} |");
    }
    page.push_str(concat!("\n", include_str!("events.md")));
    page + "\n## Examples\n\n" + EXAMPLES
}

fn write_command(page: &mut String, parent: &str, command: &Command, level: usize) {
    let name = format!("{parent} {}", command.get_name());
    let (doc, details) = about(command);
    let _ = writeln!(page, "{} {name}\n\n{doc}", "#".repeat(level));
    if !details.is_empty() {
        let _ = writeln!(page, "\n{details}");
    }
    page.push('\n');
    if !command.has_subcommands() {
        let required = command.get_arguments().filter(|arg| arg.is_required_set());
        let usage: String = required.map(|arg| format!(" {}", spelling(arg))).collect();
        let _ = writeln!(page, "    {name}{usage} [FLAGS]\n");
    }
    for (heading, args) in groups(command) {
        let _ = writeln!(
            page,
            "| {heading} | default | what it does |\n| --- | --- | --- |"
        );
        for arg in args {
            let (doc, details) = help(arg);
            let all = [doc, range(arg), details];
            let all = all.iter().filter(|part| !part.is_empty());
            let all: Vec<&str> = all.map(String::as_str).collect();
            let default = default(arg).map(|default| format!("`{default}`"));
            let _ = writeln!(
                page,
                "| `{}` | {} | {} |",
                cell(&spelling(arg)),
                default.unwrap_or_default(),
                cell(&all.join(" "))
            );
        }
        page.push('\n');
    }
    for inner in command.get_subcommands() {
        write_command(page, &name, inner, level + 1);
    }
}

fn spelling(arg: &Arg) -> String {
    let placeholder = placeholder(arg);
    if arg.is_positional() {
        return placeholder.to_owned();
    }
    let short = arg.get_short().map(|short| format!("-{short}, "));
    let flag = format!("{}--{}", short.unwrap_or_default(), name(arg));
    format!("{flag} {placeholder}").trim_end().to_owned()
}

/// The values that an argument takes, as a sentence; empty if its doc has said it.
fn range(arg: &Arg) -> String {
    if let Some(Whole(range)) = arg.get::<Whole>() {
        return format!("From {} to {}.", range.start(), range.end());
    }
    if let Some(Number(range)) = arg.get::<Number>() {
        return format!("From {} to {}.", range.start(), range.end());
    }
    let words = if is_switch(arg) {
        Vec::new()
    } else {
        choices(arg)
    };
    if words.is_empty() {
        return String::new();
    }
    if words.iter().all(|(name, doc)| doc.len() > name.len() + 3) {
        let word = |(name, doc): &(String, String)| format!("`{name}` ({doc})");
        format!("{}.", words.iter().map(word).collect::<Vec<_>>().join(", "))
    } else {
        let names: Vec<String> = words.iter().map(|(name, _)| format!("`{name}`")).collect();
        format!("One of {}.", alternatives(&names))
    }
}

/// A bar would end a table's cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[cfg(test)]
#[path = "../../../tests/unit/cli/args/pages.rs"]
mod tests;
