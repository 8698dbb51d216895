//! Documentation made from the table of flags: `docs/cli.md`, the machine-readable list, the man page.

use super::flags::{
    Argument, COMMANDS, Command, EXAMPLES, EXIT_CODES, ExitCode, Kind, PROGRAM_DOC,
};
use super::values::alternatives;
use serde::Serialize;
use std::fmt::Write;

#[derive(Serialize)]
struct Listing {
    program: &'static str,
    version: &'static str,
    doc: &'static str,
    commands: &'static [&'static Command],
    exit_codes: &'static [ExitCode],
}

/// The whole table, for programs.
pub fn listing() -> impl Serialize {
    Listing {
        program: "sundog",
        version: env!("CARGO_PKG_VERSION"),
        doc: PROGRAM_DOC,
        commands: COMMANDS,
        exit_codes: EXIT_CODES,
    }
}

/// The text of `docs/cli.md`.
pub fn markdown() -> String {
    let mut page = String::from("# The command line\n\n");
    page.push_str(
        "<!-- Made by `sundog flags --markdown` from src/cli/flags.rs; don't edit. -->\n\n",
    );
    let _ = writeln!(page, "{PROGRAM_DOC}\n");
    for command in COMMANDS {
        write_command(&mut page, "sundog", command, 2);
    }
    page.push_str("## Exit codes\n\n| code | when |\n| --- | --- |\n");
    for exit in EXIT_CODES {
        let _ = writeln!(page, "| {} | {} |", exit.code, cell(exit.doc));
    }
    page.push_str("\n## Examples\n\n");
    for (command, doc) in EXAMPLES {
        let _ = writeln!(page, "- `{command}`: {doc}");
    }
    page
}

fn write_command(page: &mut String, parent: &str, command: &Command, level: usize) {
    let name = format!("{parent} {}", command.name);
    let _ = writeln!(page, "{} {name}\n\n{}", "#".repeat(level), command.doc);
    if !command.details.is_empty() {
        let _ = writeln!(page, "\n{}", command.details);
    }
    page.push('\n');
    if command.commands.is_empty() {
        let mut usage = name.clone();
        for argument in command
            .groups
            .iter()
            .flat_map(|group| group.arguments)
            .filter(|a| a.required)
        {
            usage.push(' ');
            usage.push_str(&spelling(argument));
        }
        let _ = writeln!(page, "    {usage} [FLAGS]\n");
    }
    for group in command.groups {
        let _ = writeln!(
            page,
            "| {} | default | what it does |\n| --- | --- | --- |",
            group.heading
        );
        for argument in group.arguments {
            let mut doc = argument.doc.to_owned();
            for part in [range(&argument.kind), argument.details.to_owned()] {
                if !part.is_empty() {
                    doc.push(' ');
                    doc.push_str(&part);
                }
            }
            let default = argument
                .default
                .map(|default| format!("`{default}`"))
                .unwrap_or_default();
            let _ = writeln!(
                page,
                "| `{}` | {default} | {} |",
                cell(&spelling(argument)),
                cell(&doc)
            );
        }
        page.push('\n');
    }
    for inner in command.commands {
        write_command(page, &name, inner, level + 1);
    }
}

fn spelling(argument: &Argument) -> String {
    if argument.positional {
        return argument.placeholder.to_owned();
    }
    let mut text = argument
        .short
        .map(|short| format!("-{short}, "))
        .unwrap_or_default();
    let _ = write!(text, "--{}", argument.name);
    if !argument.placeholder.is_empty() {
        let _ = write!(text, " {}", argument.placeholder);
    }
    text
}

/// The values that an argument takes, as a sentence; empty if its doc has said it.
fn range(kind: &Kind) -> String {
    match kind {
        Kind::Integer { min, max } => format!("From {min} to {max}."),
        Kind::Number { min, max } => format!("From {min} to {max}."),
        Kind::Choice { choices }
            if choices
                .iter()
                .all(|choice| choice.doc.len() > choice.name.len() + 3) =>
        {
            let all: Vec<_> = choices
                .iter()
                .map(|choice| format!("`{}` ({})", choice.name, choice.doc))
                .collect();
            format!("{}.", all.join(", "))
        }
        Kind::Choice { choices } => {
            let all: Vec<_> = choices
                .iter()
                .map(|choice| format!("`{}`", choice.name))
                .collect();
            format!("One of {}.", alternatives(all.iter().map(String::as_str)))
        }
        _ => String::new(),
    }
}

/// A bar would end a table's cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    /// `docs/cli.md` says what the program does; `sundog flags --markdown > docs/cli.md` renews it.
    #[test]
    fn the_page_is_current() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/cli.md");
        let written = std::fs::read_to_string(path).unwrap();
        assert!(
            written == super::markdown(),
            "docs/cli.md is not current: run `cargo run -- flags --markdown > docs/cli.md`"
        );
    }
}
