//! What a render was, in words.

use super::console;
use crate::film::error::ErrorEstimate;
use crate::render::Statistics;

/// What a render was, in one line.
pub fn end_line(
    (width, height): (u32, u32),
    statistics: &Statistics,
    seen_error: Option<f64>,
) -> String {
    let seconds = statistics.trace.as_secs_f64();
    let mut line = format!(
        "{width} × {height} pixels, {} samples a pixel, {} to prepare, {} to trace, {:.2} Mray/s",
        samples(statistics),
        console::clock(statistics.prepare.as_secs_f64()),
        console::clock(seconds),
        if seconds > 0.0 {
            statistics.rays as f64 / seconds / 1e6
        } else {
            0.0
        },
    );
    if let Some(error) = &statistics.error {
        line.push_str(&format!(", error {}", percent(error)));
    }
    if let Some(flip) = seen_error {
        line.push_str(&format!(", as shown FLIP {flip:.4}"));
    }
    if let Some(clamped) = statistics.clamped {
        line.push_str(&format!(
            "; clamping took away {:.2} % of the light (direct {:.2} %, indirect {:.2} %)",
            100.0 * (clamped.direct + clamped.indirect),
            100.0 * clamped.direct,
            100.0 * clamped.indirect
        ));
    }
    line
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

/// `2.1 % (1.9 to 2.4 %)`.
pub fn percent(error: &ErrorEstimate) -> String {
    let figures = |share: f64| {
        let percent = 100.0 * share;
        // Three figures, as many decimals as that takes.
        let decimals = if percent > 0.0 {
            (2 - percent.log10().floor() as i32).clamp(0, 9) as usize
        } else {
            0
        };
        format!("{percent:.decimals$}")
    };
    format!(
        "{} % ({} to {} %)",
        figures(error.error),
        figures(error.low),
        figures(error.high)
    )
}
