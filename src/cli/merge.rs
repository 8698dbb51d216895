//! `sundog merge`: parts of a render become one picture.

use super::checkpoint::Checkpoint;
use super::flags::EXIT_OK;
use super::outputs::Outputs;
use super::parser::Parsed;
use super::progress::Reporter;
use super::{Failure, summary};
use crate::output::Metadata;
use crate::render::{self, Saved};
use serde_json::json;

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(parsed: Parsed) -> Result<u8, Failure> {
    let reporter = Reporter::new(parsed.switch("quiet"), parsed.switch("json"));
    if !parsed.given("output") && !parsed.given("checkpoint") {
        return Err(Failure::usage(
            "nothing says where the picture goes; give --output FILE (or --checkpoint FILE)",
        ));
    }
    let files = Outputs::files(parsed)?;
    let checkpoint = Checkpoint::new(parsed)?;
    // One by one: only two of them are in memory.
    let parts = parsed.paths("PART").into_iter().map(|path| {
        let part = Saved::read(&path)?;
        Ok((path.display().to_string(), part))
    });
    let merged = render::merge(parts)?;
    let header = merged.header();
    let outputs = Outputs::new(files, parsed, &header.color_management, &reporter)?;
    if let Some(checkpoint) = &checkpoint {
        checkpoint.write(&merged.state());
        checkpoint.finish()?;
    }
    if header.ranges.len() > 1 {
        let ranges: Vec<_> = header
            .ranges
            .iter()
            .map(|(a, b)| format!("{a}..{b}"))
            .collect();
        reporter.warn(&format!(
            "the samples have gaps ({}): a valid picture, but not that of one render",
            ranges.join(", ")
        ));
    }
    let rendering = merged.rendering();
    let statistics = &rendering.statistics;
    let mut metadata: Metadata = super::versions()
        .into_iter()
        .map(|(name, version)| (format!("sundog/version/{}", name.to_lowercase()), version))
        .collect();
    let mut add = |name: &str, value: String| metadata.push((format!("sundog/{name}"), value));
    add("scene-hash", header.scene.clone());
    add("samples", statistics.samples.to_string());
    add(
        "sample-ranges",
        serde_json::to_string(&header.ranges).unwrap_or_default(),
    );
    add(
        "settings",
        serde_json::to_string(&header.settings).unwrap_or_default(),
    );
    add(
        "statistics",
        serde_json::to_string(statistics).unwrap_or_default(),
    );
    outputs.write(&rendering.picture, &metadata, &reporter)?;
    let size = (header.region.width(), header.region.height());
    let seen_error = outputs.seen_error(&rendering)?;
    reporter.say(&summary::end_line(size, statistics, seen_error));
    reporter.tell(
        &json!({ "event": "finished", "statistics": statistics, "seen_error": seen_error, "written": outputs.names() }),
    );
    Ok(EXIT_OK)
}
