//! Files of reports: pages, tables of numbers and plots.

use super::Failure;
use crate::output;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What a file holds, by the end of its name.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Json,
    Csv,
    Html,
    Svg,
    Png,
}

impl Kind {
    /// By the end of a file's name.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "json" => Self::Json,
            "csv" => Self::Csv,
            "html" => Self::Html,
            "svg" => Self::Svg,
            "png" => Self::Png,
            _ => return None,
        })
    }
}

/// Checks the file that a flag names: its name must end so, and it must be one that can be written.
pub fn check_page(flag: &str, path: Option<&Path>, extension: &str) -> Result<(), Failure> {
    let Some(path) = path else {
        return Ok(());
    };
    if !path
        .extension()
        .is_some_and(|given| given.eq_ignore_ascii_case(extension))
    {
        return Err(Failure::usage(format!(
            "--{flag} {} must end in .{extension}",
            path.display()
        )));
    }
    Ok(output::check_writable(path)?)
}

/// Files that were asked for, each of which can be written, and those that are.
#[derive(Default)]
pub struct ReportFiles {
    /// What is asked for.
    pub files: Vec<(PathBuf, Kind)>,
    /// What is written.
    pub written: Vec<String>,
}

impl ReportFiles {
    /// Asks for one more.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&mut self, path: &Path, kind: Kind) -> Result<(), Failure> {
        output::check_writable(path)?;
        self.files.push((path.to_path_buf(), kind));
        Ok(())
    }

    /// Whether a file of this kind is asked for.
    pub fn any(&self, kind: Kind) -> bool {
        self.files.iter().any(|(_, other)| *other == kind)
    }

    /// Writes all that is asked for, of which `content` gives each kind.
    ///
    /// # Errors
    /// There is no content, or it cannot be written.
    pub fn write(
        &mut self,
        content: impl Fn(Kind) -> Result<Vec<u8>, Failure>,
    ) -> Result<(), Failure> {
        for (path, kind) in self.files.clone() {
            self.put(&path, &content(kind)?)?;
        }
        Ok(())
    }

    /// Writes one file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn put(&mut self, path: &Path, content: &[u8]) -> Result<(), Failure> {
        output::atomic_write(path, |file| file.write_all(content))?;
        self.written.push(path.display().to_string());
        Ok(())
    }
}

/// JSON for people and programs.
///
/// # Errors
/// It cannot be told in JSON.
pub fn pretty(value: &impl Serialize) -> Result<Vec<u8>, Failure> {
    serde_json::to_vec_pretty(value)
        .map_err(|error| Failure::new(format!("cannot write JSON: {error}")))
}
