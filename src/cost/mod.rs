//! What a picture costs: probes that tell time and error ahead, and what each effect takes and gives.

mod adaptive;
mod change;
mod clock;
mod effects;
mod forecast;
mod price;
mod probe;
mod study_report;
mod variants;

pub use adaptive::Evened;
pub use change::Share;
pub use clock::{Clock, processor_seconds};
pub use effects::{EffectCost, Study, measured_settings, study};
pub use forecast::{ForecastQuery, ForecastReport};
pub use price::Price;
pub use probe::{Probe, probe};
pub use variants::{Variant, Worth, variants};

use crate::render::{Region, RenderError, RenderSettings};

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum CostError {
    /// A picture could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The observer said stop.
    #[error("interrupted")]
    Cancelled,
}

/// The settings of a picture of which the longer side has not more than so many pixels.
pub fn reduced(settings: &RenderSettings, longer_side: u32) -> RenderSettings {
    let longest = settings.width.max(settings.height);
    if longest <= longer_side {
        return settings.clone();
    }
    let factor = f64::from(longer_side) / f64::from(longest);
    let side = |pixels: u32| ((f64::from(pixels) * factor).round() as u32).max(1);
    let (width, height) = (side(settings.width), side(settings.height));
    let part = |from: u32, to: u32, most: u32| {
        let start = ((f64::from(from) * factor) as u32).min(most - 1);
        (start, side(to).clamp(start + 1, most))
    };
    let region = settings.region.map(|region| {
        let (x0, x1) = part(region.x0, region.x1, width);
        let (y0, y1) = part(region.y0, region.y1, height);
        Region { x0, y0, x1, y1 }
    });
    RenderSettings {
        width,
        height,
        region,
        ..settings.clone()
    }
}

/// Pixels that are rendered.
pub fn pixels(settings: &RenderSettings) -> f64 {
    let region = settings.region();
    f64::from(region.width()) * f64::from(region.height())
}

#[cfg(test)]
#[path = "../../tests/unit/cost/mod.rs"]
mod tests;
