//! The settings of a render from the flags and the scene; shared by all commands that render.

use super::Failure;
use super::flags::MAX_SAMPLES;
use super::info::PREPARED_BYTES_A_TRIANGLE;
use super::memory;
use super::parser::Parsed;
use crate::film::Passes;
use crate::film::apart::PixelApart;
use crate::film::pixel::Pixel;
use crate::render::{
    BounceLimits, Caustics, Filter, InstructionSet, LightSampling, Naive, RenderSettings,
};
use crate::scene::{Camera, Projection, Scene, Window};
use std::path::Path;

/// Pixels of the longer side where the user gives no size.
const LONGER_SIDE: u32 = 1280;

/// The settings of the flags, and of the scene where no flag says otherwise. A flag that the command does not
/// have counts as not given.
///
/// # Errors
/// A flag does not fit the scene.
pub fn of(parsed: Parsed, path: &Path, scene: &Scene) -> Result<RenderSettings, Failure> {
    let defaults = RenderSettings::default();
    let camera = match parsed.text("camera") {
        Some(wanted) => Some(choose_camera(path, &scene.cameras, wanted)?),
        None => None,
    };
    let aspect = scene
        .cameras
        .get(camera.unwrap_or(0))
        .and_then(|camera| Some(aspect(camera)? / camera.pixel_aspect(&scene.render)));
    let (width, height) = match (parsed.integer("width"), parsed.integer("height")) {
        // What the file wishes is a size as a whole: half of it would be of the wrong aspect.
        (None, None) => picture_size(aspect, scene.render.width, scene.render.height),
        (width, height) => picture_size(aspect, width, height),
    };
    let time_limit = parsed.duration("time");
    let open_ended = ["time", "error", "pixel-error"]
        .iter()
        .any(|name| parsed.given(name));
    let (first_sample, samples) = match (parsed.range("sample-range"), parsed.integer("samples")) {
        (Some(_), _) if parsed.given("samples") => {
            return Err(Failure::usage(
                "--sample-range says itself how many samples there are; leave --samples out",
            ));
        }
        (Some(_), _) if parsed.given("pixel-error") => {
            return Err(Failure::usage(
                "--pixel-error decides sample by sample how far to go, which parts of a render can't; leave it or --sample-range out",
            ));
        }
        (Some((from, to)), _) => (from, to - from),
        (None, Some(samples)) if parsed.given("samples") || !open_ended => (0, samples),
        (None, _) => (0, MAX_SAMPLES as u32),
    };
    let region = parsed.region("region");
    if let Some(region) = region
        && (region.x1 > width || region.y1 > height)
    {
        return Err(Failure::usage(format!(
            "--region ends at {}, {}, outside of the picture of {width} × {height} pixels",
            region.x1, region.y1
        )));
    }
    let number = |name: &str, default: f32| parsed.number(name).map_or(default, |n| n as f32);
    Ok(RenderSettings {
        width,
        height,
        samples,
        first_sample,
        time_limit,
        time_spent: super::since_start(),
        bounces: parsed.integer("bounces").unwrap_or(defaults.bounces),
        bounce_limits: BounceLimits {
            diffuse: parsed.integer("bounces-diffuse"),
            glossy: parsed.integer("bounces-glossy"),
            transmission: parsed.integer("bounces-transmission"),
            transparent: parsed.integer("bounces-transparent"),
        },
        clamp_direct: number("clamp-direct", defaults.clamp_direct),
        clamp_indirect: number("clamp-indirect", defaults.clamp_indirect),
        filter_glossy: number("filter-glossy", defaults.filter_glossy),
        transparent_film: parsed.switch("transparent") || scene.render.transparent == Some(true),
        film_exposure: match scene.render.film_exposure {
            Some(factor) if !parsed.given("film-exposure") => factor as f32,
            _ => number("film-exposure", defaults.film_exposure),
        },
        caustics: caustics(parsed),
        passes: parsed.passes("passes").unwrap_or(defaults.passes),
        error_target: parsed.share("error").unwrap_or(defaults.error_target),
        pixel_error_target: parsed
            .share("pixel-error")
            .unwrap_or(defaults.pixel_error_target),
        region,
        camera,
        seed: parsed.integer("seed").unwrap_or(defaults.seed),
        threads: parsed.integer("threads").map(|threads| threads as usize),
        instruction_set: instruction_set(parsed)?,
        filter: filter(parsed, scene),
        effects: parsed.effects("effects").unwrap_or(defaults.effects),
        light_sampling: match parsed.choice("light-sampling") {
            "nee" => LightSampling::Nee,
            "bsdf" => LightSampling::Bsdf,
            "hemisphere" => LightSampling::Hemisphere,
            _ => LightSampling::Mis,
        },
        light_samples: parsed
            .integer("light-samples")
            .unwrap_or(defaults.light_samples),
        roulette: parsed.roulette("roulette").unwrap_or(defaults.roulette),
        naive: naive(parsed),
        cull_backfaces: parsed.switch("backface-culling"),
    })
}

fn caustics(parsed: Parsed) -> Caustics {
    let kept = parsed.choice("caustics");
    Caustics {
        reflective: !matches!(kept, "refractive" | "none"),
        refractive: !matches!(kept, "reflective" | "none"),
    }
}

/// Asks for instructions where no flag does: farms that start the program through Blender can't give flags.
const INSTRUCTION_SET: &str = "SUNDOG_INSTRUCTION_SET";

/// The instructions that the flag asks for, else the environment.
fn instruction_set(parsed: Parsed) -> Result<Option<InstructionSet>, Failure> {
    let asked = match InstructionSet::named(parsed.choice("instruction-set")) {
        Some(set) => Some(set),
        None => instruction_set_of_environment().map_err(Failure::usage)?,
    };
    // Told before the scene is prepared, which takes its time.
    InstructionSet::or_default(asked).map_err(|error| Failure::new(error.to_string()))?;
    Ok(asked)
}

/// The instructions that the environment asks for.
pub fn instruction_set_of_environment() -> Result<Option<InstructionSet>, String> {
    let Some(value) = std::env::var_os(INSTRUCTION_SET).filter(|value| !value.is_empty()) else {
        return Ok(None);
    };
    let value = value.to_string_lossy();
    let named = InstructionSet::named(&value).map(Some);
    named.ok_or_else(|| {
        let names = InstructionSet::ALL.map(InstructionSet::name).join(" or ");
        let value = value.escape_debug();
        format!("{INSTRUCTION_SET} cannot be '{value}': expected {names}")
    })
}

fn naive(parsed: Parsed) -> Naive {
    let parts = parsed.choices("naive");
    Naive {
        offsets: parts.contains(&"offsets"),
        edges: parts.contains(&"edges"),
        origin: parts.contains(&"origin"),
        terminator: parts.contains(&"terminator"),
    }
}

/// The flag's filter; else the default's shape with the width that the scene wishes.
fn filter(parsed: Parsed, scene: &Scene) -> Filter {
    let default = Filter::default();
    let by_flag = parsed.filter("filter").unwrap_or(default);
    match scene.render.filter_width {
        Some(width) if !parsed.given("filter") => Filter {
            width: width as f32,
            ..default
        },
        _ => by_flag,
    }
}

/// A camera by name, or by number from 0 if none has that name.
fn choose_camera(path: &Path, cameras: &[Camera], wanted: &str) -> Result<usize, Failure> {
    let by_name = cameras.iter().position(|camera| camera.name == wanted);
    let by_number = || wanted.parse().ok().filter(|index| *index < cameras.len());
    by_name.or_else(by_number).ok_or_else(|| {
        let file = path.display();
        if cameras.is_empty() {
            return Failure::new(format!(
                "{file} has no cameras; export it with \"Cameras\" ticked"
            ));
        }
        let names: Vec<_> = cameras
            .iter()
            .enumerate()
            .map(|(i, c)| format!("{i} \"{}\"", c.name))
            .collect();
        Failure::new(format!(
            "{file} has no camera \"{wanted}\"; it has {}",
            names.join(", ")
        ))
    })
}

/// Width over height that a camera is meant for.
fn aspect(camera: &Camera) -> Option<f64> {
    let by_projection = match camera.projection {
        Projection::Perspective { aspect, .. } => aspect,
        Projection::Orthographic {
            half_width,
            half_height,
        } => Some(half_width / half_height),
        Projection::Equirectangular {
            longitude: [left, right],
            latitude: [bottom, top],
        } => return Some(((right - left) / (top - bottom)).abs()),
    };
    camera
        .window
        .as_ref()
        .map(Window::aspect)
        .or(by_projection)
        .filter(|aspect| aspect.is_finite() && *aspect > 0.0)
}

/// What the user leaves open follows from the aspect (16:9 where the camera has none).
fn picture_size(aspect: Option<f64>, width: Option<u32>, height: Option<u32>) -> (u32, u32) {
    let default = RenderSettings::default();
    let aspect = aspect.unwrap_or(f64::from(default.width) / f64::from(default.height));
    // `as` saturates, and one pixel is the least.
    let side = |pixels: f64| (pixels.round() as u32).clamp(1, super::flags::MAX_SIDE as u32);
    match (width, height) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, side(f64::from(width) / aspect)),
        (None, Some(height)) => (side(f64::from(height) * aspect), height),
        (None, None) if aspect >= 1.0 => (LONGER_SIDE, side(f64::from(LONGER_SIDE) / aspect)),
        (None, None) => (side(f64::from(LONGER_SIDE) * aspect), LONGER_SIDE),
    }
}

/// Bytes that a pixel takes: its sums, and its floats in the finished picture and, for a moment, in the writer.
fn bytes_a_pixel(passes: Passes) -> u64 {
    let apart = if passes.need_light_apart() {
        size_of::<PixelApart>()
    } else {
        0
    };
    let estimate = 6 * size_of::<f32>();
    (size_of::<Pixel>() + apart + estimate + 2 * size_of::<f32>() * passes.floats()) as u64
}

/// Refuses a picture of a scene for which there is not enough memory, where the system says how much there is. (The scene
/// itself has been loaded already.)
pub fn check_memory(settings: &RenderSettings, scene: &Scene) -> Result<(), Failure> {
    let (width, height) = (settings.region().width(), settings.region().height());
    let triangles = scene.meshes.iter().map(|mesh| mesh.triangles.len() as u64);
    let prepared = triangles.sum::<u64>() * PREPARED_BYTES_A_TRIANGLE;
    let picture = u64::from(width) * u64::from(height) * bytes_a_pixel(settings.passes);
    let what = if picture >= prepared {
        format!("a picture of {width} × {height} pixels")
    } else {
        format!("a picture of {width} × {height} pixels of this scene")
    };
    let way_out = if picture >= prepared {
        "choose a smaller --width and --height"
    } else {
        "make the scene simpler, or allow more"
    };
    memory::check(picture + prepared, &what, way_out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_follows_the_camera() {
        assert_eq!(picture_size(Some(2.0), None, None), (1280, 640));
        assert_eq!(picture_size(Some(0.5), None, None), (640, 1280));
        assert_eq!(picture_size(None, None, None), (1280, 720));
        assert_eq!(picture_size(Some(2.0), Some(100), None), (100, 50));
        assert_eq!(picture_size(Some(2.0), None, Some(100)), (200, 100));
        assert_eq!(picture_size(Some(2.0), Some(7), Some(9)), (7, 9));
        assert_eq!(picture_size(Some(1e9), None, None), (1280, 1));
        assert_eq!(picture_size(Some(1e-9), Some(10), None), (10, 65_536));
    }
}
