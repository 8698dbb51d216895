//! What a render was, in words.

use super::outputs::Outputs;
use super::progress::Reporter;
use super::scene_file::count;
use super::{Failure, console};
use crate::denoise::{Report, Shift};
use crate::math::words::{counted, estimated};
use crate::output::Metadata;
use crate::render::{Rendering, Statistics};
use serde::Serialize;
use serde_json::json;

/// What a render was, in one line.
fn end_line(
    (width, height): (u32, u32),
    statistics: &Statistics,
    seen_error: Option<f64>,
    denoised: Option<&Report>,
) -> String {
    // A denoised picture has another error, which is told only where its halves were looked at.
    let of = denoised.map_or("", |_| " of the noisy picture");
    let seconds = statistics.trace.as_secs_f64();
    let mut line = format!(
        "{width} × {height} pixels, {} a pixel, {} to prepare, {} to trace, {:.2} Mray/s",
        counted(samples(statistics), "sample", "samples"),
        console::clock(statistics.prepare.as_secs_f64()),
        console::clock(seconds),
        if seconds > 0.0 {
            statistics.rays as f64 / seconds / 1e6
        } else {
            0.0
        },
    );
    if let Some(error) = &statistics.error {
        line.push_str(&format!(
            ", error{of} {}",
            estimated(error.error, error.low, error.high)
        ));
    }
    if let Some(flip) = seen_error {
        line.push_str(&format!(", as shown FLIP{of} {flip:.4}"));
    }
    if let Some(clamped) = statistics.clamped {
        line.push_str(&format!(
            "; clamping took away {:.2} % of the light (direct {:.2} %, indirect {:.2} %)",
            100.0 * (clamped.direct + clamped.indirect),
            100.0 * clamped.direct,
            100.0 * clamped.indirect
        ));
    }
    if let Some(report) = denoised {
        let time = console::clock(report.time.as_secs_f64());
        let shift = report.shift.as_ref();
        let shift = shift.map_or("brightness shift unknown".into(), Shift::words);
        line.push_str(&format!("; denoised in {time}, {shift}"));
        if let Some(error) = &report.error {
            line.push_str(&format!(", {}", error.words()));
            // The clock or a person may have ended it since.
            if error.samples < statistics.mean_samples {
                line.push_str(&format!(" after {:.0} samples", error.samples));
            }
        }
    }
    if statistics.non_finite > 0 {
        line.push_str(&format!(
            "; not finite: {}",
            count(statistics.non_finite, "sample")
        ));
    }
    line
}

/// Tells that all is written, and what it was.
pub fn tell_end(
    size: (u32, u32),
    rendering: &Rendering,
    denoised: Option<&Report>,
    outputs: &Outputs,
    reporter: &Reporter,
) -> Result<(), Failure> {
    let statistics = &rendering.statistics;
    let seen_error = outputs.seen_error(rendering)?;
    reporter.say(&end_line(size, statistics, seen_error, denoised));
    reporter.tell(
        &json!({ "event": "finished", "statistics": statistics, "seen_error": seen_error, "denoised": denoised, "written": outputs.names() }),
    );
    Ok(())
}

/// What each picture says about how it was made: the versions, and what is added.
pub fn metadata<const N: usize>(statistics: &Statistics, entries: [(&str, String); N]) -> Metadata {
    let versions = super::versions().into_iter();
    let versions = versions.map(|(name, version)| match name {
        // The one that traced, which is not always this program's own.
        "Embree" => (
            name,
            super::embree_named(&statistics.embree, statistics.instruction_set),
        ),
        _ => (name, version),
    });
    let versions =
        versions.map(|(name, version)| (format!("version/{}", name.to_lowercase()), version));
    let entries = entries
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value));
    versions
        .chain(entries)
        .map(|(name, value)| (format!("sundog/{name}"), value))
        .collect()
}

/// `alpha, suns`, or `none`.
pub fn listed(names: &[String]) -> String {
    if names.is_empty() {
        "none".into()
    } else {
        names.join(", ")
    }
}

/// A value as JSON.
pub fn as_json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

/// Samples a pixel: the mean, and the smallest number where they differ.
fn samples(statistics: &Statistics) -> String {
    let (least, mean) = (statistics.samples, statistics.mean_samples);
    if f64::from(least) == mean {
        least.to_string()
    } else {
        format!("{mean:.1} (at least {least})")
    }
}
