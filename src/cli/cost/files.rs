//! Where the answer goes: `--output FILE.json`, `--output FILE.csv`, `--report FILE.html`.

use crate::cli::Failure;
use crate::cli::args::Cost;
use crate::cli::report_file::{check_page, write_text};
use crate::output;
use crate::report::{Page, Settings, Table};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Files that were asked for, each of which can be written.
pub struct Files {
    numbers: Vec<(PathBuf, Form)>,
    page: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq)]
enum Form {
    Json,
    Csv,
}

fn ends_in(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

impl Files {
    /// By the flags.
    pub fn new(args: &Cost) -> Result<Self, Failure> {
        let mut numbers = Vec::new();
        for path in args.output.iter().cloned() {
            let form = match () {
                () if ends_in(&path, "json") => Form::Json,
                () if ends_in(&path, "csv") => Form::Csv,
                () => {
                    return Err(Failure::usage(format!(
                        "--output {} must end in .json or .csv",
                        path.display()
                    )));
                }
            };
            output::check_writable(&path)?;
            numbers.push((path, form));
        }
        let page = args.report.clone();
        check_page("report", page.as_deref(), "html")?;
        Ok(Self { numbers, page })
    }

    /// Whether a page is wanted.
    pub fn page(&self) -> bool {
        self.page.is_some()
    }

    /// Writes them; `page` is asked for if there is a file for it. Gives their names.
    pub fn write(
        &self,
        answer: &impl Serialize,
        table: &Table,
        page: impl FnOnce() -> Result<Page, Failure>,
    ) -> Result<Vec<String>, Failure> {
        let mut names = Vec::new();
        for (path, form) in &self.numbers {
            let text = match form {
                Form::Csv => table.csv(),
                Form::Json => serde_json::to_string_pretty(answer).map_err(|error| {
                    Failure::new(format!("cannot write {}: {error}", path.display()))
                })?,
            };
            write(path, &text, &mut names)?;
        }
        if let Some(path) = &self.page {
            let html = page()?.html().map_err(|error| {
                Failure::new(format!("cannot write {}: {error}", path.display()))
            })?;
            write(path, &html, &mut names)?;
        }
        Ok(names)
    }
}

fn write(path: &Path, text: &str, names: &mut Vec<String>) -> Result<(), Failure> {
    write_text(path, text)?;
    names.push(path.display().to_string());
    Ok(())
}

/// How the picture that is asked about is rendered.
pub fn settings(question: &super::Question) -> Settings {
    let value = serde_json::to_value(&question.settings).unwrap_or_default();
    let rows = value.as_object().into_iter().flatten();
    Settings {
        title: "Settings".into(),
        note: String::new(),
        columns: vec![question.file.path.display().to_string()],
        rows: rows
            .filter(|(_, value)| !value.is_null())
            .map(|(name, value)| {
                let text = value
                    .as_str()
                    .map_or_else(|| value.to_string(), str::to_owned);
                (name.replace('_', " "), vec![text])
            })
            .collect(),
    }
}
