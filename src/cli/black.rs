//! A picture that shows as black, and why that may be.

use super::outputs;
use super::parser::Parsed;
use super::scene_file::SceneFile;
use crate::render::Rendering;

/// What the user said that bears on it.
pub struct Asked {
    /// Stops that brighten the picture where it is shown, if they were given.
    exposure: Option<f64>,
    /// What the intensities of lamps were to mean.
    light_units: String,
}

impl Asked {
    /// By the flags.
    pub fn of(parsed: Parsed) -> Self {
        Self {
            exposure: parsed
                .number("exposure")
                .filter(|_| parsed.given("exposure")),
            light_units: parsed.choice("light-units").to_owned(),
        }
    }
}

/// Linear light that sRGB shows as 1 of 255: its curve begins with a slope of 12.92 (IEC 61966-2-1).
const ONE_OF_255: f64 = 1.0 / (255.0 * 12.92);

/// A sentence with the probable cause and the way out, if the mean of the picture shows as black. Of a picture that was not
/// kept (only frames were asked for) nothing is known: who reads them sees it.
pub fn warning(rendering: &Rendering, file: &SceneFile, asked: &Asked) -> Option<String> {
    if rendering.picture.layers.is_empty() {
        return None;
    }
    let stops = asked.exposure.or(file.scene.color_management.exposure);
    let mean = brightness(rendering) * stops.unwrap_or(0.0).exp2();
    if mean >= ONE_OF_255 {
        return None;
    }
    let how = if mean > 0.0 {
        format!("the picture is as good as black (its mean is {mean:.1e})")
    } else {
        "the picture is black".to_owned()
    };
    Some(format!("{how}: {}", cause(mean, rendering, file, asked)))
}

/// So many pixels at most the reconstruction filter adds to a side of the picture, at both ends.
const BORDER: f64 = 8.0;

/// Mean over the pixels of the brightest channel.
fn brightness(rendering: &Rendering) -> f64 {
    let light = outputs::light(&rendering.picture);
    let brightest = |pixel: &[f32; 3]| pixel.iter().copied().fold(0.0, f32::max);
    let sum: f64 = light
        .pixels
        .iter()
        .map(brightest)
        .filter(|value| value.is_finite())
        .map(f64::from)
        .sum();
    sum / light.pixels.len().max(1) as f64
}

fn cause(mean: f64, rendering: &Rendering, file: &SceneFile, asked: &Asked) -> String {
    let scene = &file.scene;
    let statistics = &rendering.statistics;
    // Pixels that get light from samples beyond the picture's edge make it some wider to the rays.
    let [width, height] =
        [rendering.picture.width, rendering.picture.height].map(|side| f64::from(side) + BORDER);
    let pixels = width * height;
    if !scene.shines() {
        "nothing in the scene shines; light it with --environment FILE or --environment-color 1,1,1"
            .into()
    } else if mean == 0.0 && statistics.rays as f64 <= pixels * statistics.mean_samples {
        // A ray that meets something is followed by others, or brings light.
        "the camera sees nothing; --camera chooses another, and --environment-color 1,1,1 shows a background".into()
    } else if scene.lights.is_empty() {
        "what shines does not reach what the camera sees; --environment-color 1,1,1 lights it, --exposure brightens it".into()
    } else {
        let units = match asked.light_units.as_str() {
            "unitless" => "",
            _ => " (--light-units unitless takes lux for W/m², 683 times as bright)",
        };
        format!(
            "its lamps are too weak or do not reach what the camera sees; brighten it with --exposure, or say what their numbers mean with --light-units{units}"
        )
    }
}
