//! `sundog merge`: parts of a render become one picture.

use super::args::Merge;
use super::checkpoint::Checkpoint;
use super::exit::EXIT_OK;
use super::outputs::Outputs;
use super::progress::Reporter;
use super::{Failure, denoise, summary};
use crate::render::{self, Saved, memory};
use std::time::Duration;

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(args: &Merge) -> Result<u8, Failure> {
    let reporter = Reporter::new(&args.reporting);
    if args.output.is_empty() && args.checkpoint.is_none() {
        return Err(Failure::usage(
            "nothing says where the picture goes; give --output FILE (or --checkpoint FILE)",
        ));
    }
    let files = Outputs::files(&args.output)?;
    let denoiser = denoise::find(&args.denoising, None, &reporter)?;
    let checkpoint = Checkpoint::new(args.checkpoint.as_deref(), Duration::ZERO)?;
    let free = memory::free();
    // One by one: only two of them are in memory.
    let parts = args.part.iter().map(|path| {
        let part = Saved::read_within(path, free)?;
        Ok((path.display().to_string(), part))
    });
    let merged = render::merge(parts)?;
    let header = merged.header();
    if let Some(denoiser) = &denoiser {
        let fits = denoiser.check_parts(&header.passes);
        fits.map_err(|error| Failure::new(error.to_string()))?;
    }
    let outputs = Outputs::new(
        files,
        &args.exr,
        &args.view,
        &header.color_management,
        &reporter,
    )?;
    if let Some(checkpoint) = &checkpoint {
        checkpoint.write(&merged.state(), true, &reporter);
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
    let mut rendering = merged.rendering();
    let mut denoised = Ok(None);
    if let Some(denoiser) = &denoiser {
        denoised = denoise::apply(&args.denoising, denoiser, &mut rendering, &reporter);
    }
    let report = denoised.as_ref().ok().and_then(Option::as_ref);
    let statistics = &rendering.statistics;
    let mut metadata = summary::metadata(
        statistics,
        [
            ("scene-hash", header.scene.clone()),
            ("samples", statistics.samples.to_string()),
            ("sample-ranges", summary::as_json(&header.ranges)),
            ("settings", summary::as_json(&header.settings)),
            ("statistics", summary::as_json(statistics)),
        ],
    );
    denoise::tell_in(&mut metadata, report);
    outputs.write(&rendering.picture, &metadata, &reporter)?;
    // A state that could not be kept takes nothing from the picture.
    if let Some(checkpoint) = &checkpoint {
        checkpoint
            .finish()
            .map_err(|failure| outputs.are_there(failure))?;
    }
    let size = (header.region.width(), header.region.height());
    summary::tell_end(size, &rendering, report, &outputs, &reporter)?;
    denoised.map_err(|failure| outputs.are_there(failure))?;
    Ok(EXIT_OK)
}
