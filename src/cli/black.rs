//! A picture that shows as black, and why that may be.

use super::args::Render;
use super::outputs;
use super::scene_file::SceneFile;
use crate::import::LightUnits;
use crate::render::Rendering;

/// Linear light that sRGB shows as 1 of 255: its curve begins with a slope of 12.92 (IEC 61966-2-1).
const ONE_OF_255: f64 = 1.0 / (255.0 * 12.92);

/// A sentence with the probable cause and the way out, if the mean of the picture shows as black. Of a picture that was not
/// kept (only frames were asked for) nothing is known: who reads them sees it.
pub fn warning(rendering: &Rendering, file: &SceneFile, args: &Render) -> Option<String> {
    if rendering.picture.layers.is_empty() {
        return None;
    }
    let stops = args.view.seen.exposure;
    let stops = stops.or(file.scene.color_management.exposure);
    let mean = brightness(rendering) * stops.unwrap_or(0.0).exp2();
    if mean >= ONE_OF_255 {
        return None;
    }
    let how = if mean > 0.0 {
        format!("the picture is as good as black (its mean is {mean:.1e})")
    } else {
        "the picture is black".to_owned()
    };
    Some(format!(
        "{how}: {}",
        cause(
            mean,
            rendering,
            file,
            args.options.loading.import.light_units
        )
    ))
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

fn cause(mean: f64, rendering: &Rendering, file: &SceneFile, light_units: LightUnits) -> String {
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
    } else if crate::import::is_usd(&file.path) {
        // USD says what its numbers mean.
        "its lamps are too weak or do not reach what the camera sees; brighten it with --exposure"
            .into()
    } else {
        let units = match light_units {
            LightUnits::Unitless => "",
            _ => " (--light-units unitless takes lux for W/m², 683 times as bright)",
        };
        format!(
            "its lamps are too weak or do not reach what the camera sees; brighten it with --exposure, or say what their numbers mean with --light-units{units}"
        )
    }
}
