//! Documentation made from the table of flags: `docs/cli.md`, the machine-readable list, the man page.

use super::flags::{
    Argument, COMMANDS, Command, EXAMPLES, EXIT_CODES, ExitCode, Kind, PROGRAM_DOC,
};
use super::values::alternatives;
use crate::film::passes;
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
    page.push_str(PASSES);
    for (_, name, channels, doc) in &passes::TABLE {
        let _ = writeln!(page, "| `{name}` | {channels} | {doc} |");
    }
    page.push_str(AFTER_PASSES);
    page.push_str(EVENTS);
    page.push_str("\n## Examples\n\n");
    for (command, doc) in EXAMPLES {
        let _ = writeln!(page, "- `{command}`: {doc}");
    }
    page
}

/// What stands before the table of passes …
const PASSES: &str = r#"
## Passes

What `--passes` chooses among, in EXR files and in the last frame, by Blender's names and with Cycles' meanings:

| pass | channels | what it holds |
| --- | --- | --- |
"#;

/// … and behind it.
const AFTER_PASSES: &str = r#"
The parts are the whole, to the accuracy of the floats:

    Combined = (DiffDir + DiffInd) · DiffCol + (GlossDir + GlossInd) · GlossCol + (TransDir + TransInd) · TransCol + Emit + Env

(with `--transparent`, and where holdouts are, without Env). As in Cycles, what the first surface does to a path decides which
of them its light belongs to; surfaces passed by their opacity don't count. A path whose light is kept apart takes some more
time: a render without these passes pays nothing for them.
"#;

/// What programs that run `sundog render --json` read.
const EVENTS: &str = r#"
## Events

`sundog render --json` writes one JSON object a line to the standard output, with its kind in `event`. Unknown kinds and keys
are to be passed over.

| event | when | keys |
| --- | --- | --- |
| `diagnostic` | after loading, for each thing that is not as in the file | `verdict`, what, where, what is done instead |
| `scene` | the scene is loaded | `file`, `settings` |
| `effects` | the scene is loaded | `effects` and `left_out` as in `sundog info --json` (docs/effects.md) |
| `preparing` | a million triangles or more shine: it takes long until `prepared`, and no `--time` ends it | `shining`, `seconds` (about) |
| `prepared` | the first samples begin | `seconds`, `triangles`, `effects` |
| `progress` | five times a second, and at the end | `samples`, `of`, `fraction`, `seconds`, `rays`, `remaining` (seconds, or null), `error` (see below, or null) |
| `frame` | with `--frames`: a file lies in the folder | see below |
| `written` | a file of `--output` is there | `file` |
| `warning` | something should be known | `message` |
| `finished` | all is written | `statistics`, `written`, `seen_error` (FLIP of what one sees, estimated; null without .png or .jpg, and where --time leaves none for it) |
| `error` | the command failed (or was interrupted); also a sentence on the standard error | `message` |

**Error** is an estimate of √relMSE of the picture so far (relMSE as in `sundog compare`, against the picture that the same
settings would converge to), as `error`, with `low` and `high` between which it lies in 95 of 100 renders. Even and odd samples
belong to two sequences that are randomised independently, and the difference of their two pictures tells how far their mean is
off: [accuracy.md](accuracy.md). It knows nothing of light so rare that no sample has found it yet, nor of bias (clamping, filter glossy).

**Frames.** `--frames FOLDER` writes the picture so far into a folder that exists already: 0.1 s after every pixel has its first
sample, then at intervals that grow by half each time up to 5 s, and once more at the end, whatever ended the render. Each frame
has a name of its own; it is written beside and renamed before its line is printed:

    {"event":"frame","file":"frame-000003.raw","width":1280,"height":720,"region":[0,0,1280,720],
     "samples":7,"final":false,"passes":[{"name":"Combined","channels":"RGBA","offset":0}]}

The file holds the region's pixels (x1 − x0 columns, y1 − y0 rows; the origin of `region` is the top left of the full picture of
`width` × `height`) as little-endian 32-bit floats: the passes one after the other, each from its `offset` in bytes, channels
interleaved, rows from bottom to top, associated alpha. Frames before the last one have only `Combined`. The reader removes what
it has read; while two frames lie unread, no more are written but the last one. If a frame cannot be written, a `warning` says
so once, and only the last one is tried again; if that fails, too, the files of `--output` are written, and the exit code is 1.

**Ctrl-C** (SIGINT), and SIGTERM likewise: before `prepared` the process ends at once. Afterwards the render stops, the last
frame and the files of `--output` are written, and the exit code is 130. A second one ends the process at once. With `--json` the
same happens when nobody reads the standard output any more, and with `--frames` when the process that started this one has
ended.

**Biased settings.** `--clamp-direct`, `--clamp-indirect` and `--filter-glossy` change what the picture converges to; all are off
unless given. `statistics.clamped` tells the shares of the mean luminance that clamping took away (`direct`, `indirect`). What
`--filter-glossy` changes cannot be told without a second render: it is named in `settings` alone.
"#;

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
