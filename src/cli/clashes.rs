//! No file is written over one that is read, and no two over each other: told before any work, by the flags of all commands.

use super::Failure;
use crate::import;
use crate::output::{same_file, same_place};
use clap::ArgMatches;
use std::path::{Path, PathBuf};

/// Arguments (clap's ids of them) that name files to be read.
const READ: &[&str] = &[
    "SCENE",
    "PART",
    "A",
    "B",
    "IN",
    "environment",
    "ocio",
    "reference",
];
/// Arguments that name files to be written. (The state of a render is both, and replaced by a later one of its own.)
const WRITTEN: &[&str] = &[
    "output",
    "OUT",
    "checkpoint",
    "difference_map",
    "report",
    "csv",
];
/// What `sundog converge` writes into a folder.
const IN_FOLDER: &[&str] = &["converge.html", "converge.json", "converge.csv"];

/// A file and the argument that names it.
struct Named {
    argument: &'static str,
    path: PathBuf,
}

impl Named {
    fn by(matches: &ArgMatches, arguments: &[&'static str]) -> Vec<Self> {
        let mut all = Vec::new();
        for &argument in arguments {
            let values = matches.try_get_raw(argument).ok().flatten();
            for path in values.into_iter().flatten().map(PathBuf::from) {
                all.push(Self { argument, path });
            }
        }
        all
    }

    /// As the user has written it.
    fn spelled(&self) -> String {
        let path = self.path.display();
        if self.argument.starts_with(char::is_uppercase) {
            path.to_string()
        } else {
            format!("--{} {path}", self.argument.replace('_', "-"))
        }
    }
}

/// Refuses what would be written over something that is read, or over something else that is written.
///
/// # Errors
/// There is such a thing.
pub fn refuse(matches: &ArgMatches) -> Result<(), Failure> {
    let mut written = Named::by(matches, WRITTEN);
    let folders: Vec<PathBuf> = written
        .iter()
        .filter(|named| named.path.is_dir())
        .map(|named| named.path.clone())
        .collect();
    for folder in folders {
        written.extend(IN_FOLDER.iter().map(|name| Named {
            argument: "output",
            path: folder.join(name),
        }));
    }
    for (index, one) in written.iter().enumerate() {
        for other in &written[..index] {
            if one.argument == other.argument && one.path == other.path {
                return Err(Failure::usage(format!("{} is given twice", one.spelled())));
            }
            if same_place(&one.path, &other.path) {
                return Err(Failure::usage(format!(
                    "{} and {} are the same file; give each a name of its own",
                    other.spelled(),
                    one.spelled()
                )));
            }
        }
    }
    let is_over = |output: &Named, input: &Path| {
        same_place(&output.path, input) || same_file(&output.path, input)
    };
    for input in Named::by(matches, READ) {
        if let Some(output) = written.iter().find(|output| is_over(output, &input.path)) {
            return Err(Failure::usage(format!(
                "{} would replace {}, which is read; give another name",
                output.spelled(),
                input.spelled()
            )));
        }
    }
    // What is not there is not read either, and the scene need not be opened for it.
    written.retain(|output| output.path.is_file());
    let scene = matches.try_get_one::<PathBuf>("SCENE").ok().flatten();
    let Some(scene) = scene.filter(|_| !written.is_empty()) else {
        return Ok(());
    };
    for input in import::named_files(scene) {
        if let Some(output) = written.iter().find(|output| is_over(output, &input)) {
            return Err(Failure::usage(format!(
                "{} would replace {}, which the scene {} needs; give another name",
                output.spelled(),
                input.display(),
                scene.display()
            )));
        }
    }
    Ok(())
}
