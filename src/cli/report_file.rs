//! Files of reports: pages and tables of numbers.

use super::Failure;
use crate::output;
use crate::report::ReportError;
use std::io::Write;
use std::path::Path;

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        Failure::new(error.to_string())
    }
}

/// Makes sure that the name of the file that a flag names ends as it must, and that it can be written.
pub fn check_page(flag: &str, path: Option<&Path>, extension: &str) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
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

/// Writes a page or a table.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(output::write_beside(path, |file| {
        file.write_all(text.as_bytes())
    })?)
}
