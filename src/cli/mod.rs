//! The command line: the only room that prints.

mod args;
mod black;
mod checkpoint;
mod clashes;
mod color;
mod compare;
mod console;
mod converge;
mod cost;
mod denoise;
mod effect_lines;
mod exit;
mod frames;
mod info;
mod interrupt;
mod merge;
mod out_of_memory;
mod outputs;
mod processor;
mod progress;
mod render;
mod replay;
mod report_file;
mod scene_file;
mod selftest;
mod settings;
mod summary;
mod view;

pub use interrupt::leave;
pub use out_of_memory::used_up as memory_used_up;

use args::{Command, Program, program, sentence};
use clap::error::ErrorKind;
use clap::{ArgMatches, CommandFactory, FromArgMatches};
use exit::{EXIT_ERROR, EXIT_OK, EXIT_USAGE};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Why a command did not do what was asked: one sentence and the exit code.
#[derive(Debug)]
pub struct Failure {
    /// What the process returns.
    pub code: u8,
    /// One sentence: file, object, way out.
    pub message: String,
}

impl Failure {
    /// It could not be done.
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            code: EXIT_ERROR,
            message: message.into(),
        }
    }

    /// It could not be understood.
    pub fn usage(message: impl Into<String>) -> Self {
        Self {
            code: EXIT_USAGE,
            message: message.into(),
        }
    }
}

/// Errors of other rooms that are one sentence.
macro_rules! failures {
    ($($error:ty),*) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::new(error.to_string())
            }
        }
    )*};
}

failures!(
    crate::color::ColorError,
    crate::measure::MeasureError,
    crate::render::StateError,
    crate::render::memory::NotEnoughMemory,
    crate::report::ReportError
);

impl From<crate::output::OutputError> for Failure {
    fn from(error: crate::output::OutputError) -> Self {
        let code = match error {
            crate::output::OutputError::UnknownFormat { .. } => EXIT_USAGE,
            _ => EXIT_ERROR,
        };
        Self {
            code,
            message: error.to_string(),
        }
    }
}

static STARTED: OnceLock<Instant> = OnceLock::new();

/// Time since the program was started.
pub fn since_start() -> Duration {
    STARTED.get_or_init(Instant::now).elapsed()
}

/// Runs the program with the process's own arguments; gives what the process returns.
pub fn main() -> u8 {
    since_start();
    if !processor::suffices() {
        return EXIT_ERROR;
    }
    let code = run();
    match console::lost() {
        Some(reason) if code == EXIT_OK => {
            console::message(&format!(
                "sundog: cannot write to the standard output: {reason}"
            ));
            EXIT_ERROR
        }
        _ => code,
    }
}

fn run() -> u8 {
    // Only help shows presets, which are all arguments made anew.
    let matches = Program::command().try_get_matches();
    let matches = matches.or_else(|error| match error.kind() {
        ErrorKind::DisplayHelp => program().try_get_matches(),
        _ => Err(error),
    });
    let parsed = matches.and_then(|matches| {
        let program = Program::from_arg_matches(&matches)?;
        Ok((matches, program.command))
    });
    let (matches, command) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return answer(&error),
    };
    // All commands: what is half written must not stay.
    let by_signal = !matches!(
        command,
        Command::Render(_) | Command::Cost(_) | Command::Converge(_)
    );
    if let Err(reason) = interrupt::listen(by_signal) {
        console::message(&format!("sundog: {reason}"));
        return EXIT_ERROR;
    }
    let mut innermost = &matches;
    while let Some((_, matches)) = innermost.subcommand() {
        innermost = matches;
    }
    let json = matches!(innermost.try_get_one("json"), Ok(Some(true)));
    if json {
        out_of_memory::tell_json();
    }
    out_of_memory::listen_to_threads();
    if let Err(failure) = start_threads(&command) {
        console::message(&format!("sundog: {}", failure.message));
        return failure.code;
    }
    match perform(&command, innermost) {
        Ok(code) => code,
        Err(failure) => {
            if json {
                console::json_line(
                    &serde_json::json!({ "event": "error", "message": failure.message }),
                );
            }
            console::message(&format!("sundog: {}", failure.message));
            failure.code
        }
    }
}

fn perform(command: &Command, matches: &ArgMatches) -> Result<u8, Failure> {
    clashes::refuse(matches)?;
    match command {
        Command::Render(args) => render::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Info(args) => info::run(args),
        Command::Cost(args) => cost::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Converge(args) => converge::run(args),
        Command::Color(command) => color::run(command),
        Command::SelfTest(args) => selftest::run(args),
        Command::Flags(args) => list_flags(args),
        Command::Completions(args) => {
            complete(args.shell);
            Ok(EXIT_OK)
        }
    }
}

/// Starts the threads that all rooms share, for the commands that work: where the system has none left, their first user
/// would panic.
fn start_threads(command: &Command) -> Result<(), Failure> {
    if matches!(command, Command::Flags(_) | Command::Completions(_)) {
        return Ok(());
    }
    let started = rayon::ThreadPoolBuilder::new().build_global();
    started.map_err(|error| {
        Failure::new(format!(
            "no threads could be started, as there is not enough memory or the user has too many of them ({error})"
        ))
    })
}

/// What clap has to say: help and version as they are, errors as one sentence.
fn answer(error: &clap::Error) -> u8 {
    match error.kind() {
        ErrorKind::DisplayHelp => {
            console::output(&error.render().to_string());
            EXIT_OK
        }
        ErrorKind::DisplayVersion => {
            for (name, version) in versions() {
                console::output(&format!("{name} {version}\n"));
            }
            EXIT_OK
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            console::page(error.render().to_string().trim_end());
            EXIT_USAGE
        }
        _ => {
            let message = format!("{} (`sundog --help` tells more)", sentence(error));
            // Nothing has been parsed, but a program that reads JSON should find it there.
            if std::env::args_os().any(|argument| argument == "--json") {
                console::json_line(&serde_json::json!({ "event": "error", "message": message }));
            }
            console::message(&format!("sundog: {message}"));
            EXIT_USAGE
        }
    }
}

/// Names and versions of what the program is made of, as they are when it runs. Asking checks that the
/// libraries are those that the program was built for; what is wrong stands in brackets then.
pub fn versions() -> Vec<(&'static str, String)> {
    let embree = settings::instruction_set_of_environment().and_then(|asked| {
        let device = crate::ffi::embree::Device::new(Some(1), asked);
        let named = |device: crate::ffi::embree::Device| {
            embree_named(&device.version().to_string(), device.instructions())
        };
        device.map(named).map_err(|error| error.to_string())
    });
    let color = crate::color::library_version();
    vec![
        ("Sundog", env!("CARGO_PKG_VERSION").to_owned()),
        (
            "Embree",
            embree.unwrap_or_else(|error| format!("({error})")),
        ),
        (
            "OpenColorIO",
            color.unwrap_or_else(|error| format!("({error})")),
        ),
    ]
}

/// As it is told with each picture: instructions decide the last bits just as the version may.
pub fn embree_named(version: &str, instructions: crate::render::InstructionSet) -> String {
    format!("{version} ({instructions})")
}

fn list_flags(args: &args::Flags) -> Result<u8, Failure> {
    if args.markdown {
        console::output(&args::pages::markdown());
    } else if args.man {
        let mut page = Vec::new();
        clap_mangen::Man::new(program())
            .render(&mut page)
            .map_err(|error| Failure::new(format!("cannot make the manual page: {error}")))?;
        console::output(&String::from_utf8_lossy(&page));
    } else {
        console::json_document(&args::pages::listing());
    }
    Ok(EXIT_OK)
}

fn complete(shell: clap_complete::Shell) {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut program(), "sundog", &mut script);
    console::output(&String::from_utf8_lossy(&script));
}
