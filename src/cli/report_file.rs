//! Files of reports: pages and tables of numbers.

use super::Failure;
use super::parser::Parsed;
use crate::output;
use crate::report::ReportError;
use std::io::Write;
use std::path::Path;

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        Failure::new(error.to_string())
    }
}

/// The file that a flag names, if its name ends as it must and it can be written.
pub fn page_path<'a>(
    parsed: Parsed<'a>,
    flag: &str,
    extension: &str,
) -> Result<Option<&'a Path>, Failure> {
    let Some(path) = parsed.path(flag) else {
        return Ok(None);
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
    output::check_writable(path)?;
    Ok(Some(path))
}

/// Writes a page or a table.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(output::write_beside(path, |file| {
        file.write_all(text.as_bytes())
    })?)
}
