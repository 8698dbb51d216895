//! The settings of a render from the flags and the scene; shared by all commands that render.

use super::args::{MAX_SIDE, Machine, RenderOptions, Size};
use super::info::PREPARED_BYTES_A_TRIANGLE;
use super::{Failure, memory};
use crate::film::Passes;
use crate::film::apart::PixelApart;
use crate::film::pixel::Pixel;
use crate::render::{BounceLimits, Filter, InstructionSet, Naive, RenderSettings};
use crate::scene::{Camera, Projection, Scene, Window};
use std::path::Path;

/// Pixels of the longer side where the user gives no size.
const LONGER_SIDE: u32 = 1280;

impl RenderOptions {
    /// The settings of the flags, and of the scene (read from `path`) where no flag says otherwise. How many samples there are,
    /// their effects and their passes are for each command to say.
    ///
    /// # Errors
    /// A flag does not fit the scene.
    pub fn settings(&self, path: &Path, scene: &Scene) -> Result<RenderSettings, Failure> {
        let Self {
            machine,
            size,
            bounces,
            transport,
            studies,
            ..
        } = self;
        let naive = |part: &str| studies.naive.contains(&part);
        let (camera, width, height) = size.of_camera(path, scene)?;
        let film_exposure = size.film_exposure.or(scene.render.film_exposure);
        let defaults = RenderSettings::default();
        Ok(RenderSettings {
            width,
            height,
            time_spent: super::since_start(),
            bounces: bounces.bounces,
            bounce_limits: BounceLimits {
                diffuse: bounces.bounces_diffuse,
                glossy: bounces.bounces_glossy,
                transmission: bounces.bounces_transmission,
                transparent: bounces.bounces_transparent,
            },
            clamp_direct: transport.clamp_direct as f32,
            clamp_indirect: transport.clamp_indirect as f32,
            filter_glossy: transport.filter_glossy as f32,
            transparent_film: size.transparent || scene.render.transparent == Some(true),
            film_exposure: film_exposure.map_or(defaults.film_exposure, |factor| factor as f32),
            caustics: transport.caustics,
            region: size.region,
            camera,
            seed: machine.seed,
            threads: machine.threads.map(|threads| threads as usize),
            instruction_set: machine.instruction_set()?,
            filter: size.filter(scene),
            light_sampling: studies.light_sampling,
            light_samples: studies.light_samples,
            roulette: studies.roulette,
            naive: Naive {
                offsets: naive("offsets"),
                edges: naive("edges"),
                origin: naive("origin"),
                terminator: naive("terminator"),
            },
            cull_backfaces: transport.backface_culling,
            ..defaults
        })
    }
}

impl Size {
    /// Number of the camera if one was chosen, width and height.
    fn of_camera(&self, path: &Path, scene: &Scene) -> Result<(Option<usize>, u32, u32), Failure> {
        let wanted = self.camera.as_deref();
        let camera = wanted.map(|wanted| choose_camera(path, &scene.cameras, wanted));
        let camera = camera.transpose()?;
        let aspect = scene
            .cameras
            .get(camera.unwrap_or(0))
            .and_then(|camera| Some(aspect(camera)? / camera.pixel_aspect(&scene.render)));
        let (width, height) = match (self.width, self.height) {
            // What the file wishes is a size as a whole: half of it would be of the wrong aspect.
            (None, None) => picture_size(aspect, scene.render.width, scene.render.height),
            (width, height) => picture_size(aspect, width, height),
        };
        if let Some(region) = self.region
            && (region.x1 > width || region.y1 > height)
        {
            return Err(Failure::usage(format!(
                "--region ends at {}, {}, outside of the picture of {width} × {height} pixels",
                region.x1, region.y1
            )));
        }
        Ok((camera, width, height))
    }

    /// The flag's filter; else the default's shape with the width that the scene wishes.
    fn filter(&self, scene: &Scene) -> Filter {
        let default = Filter::default();
        let width = scene.render.filter_width;
        self.filter.unwrap_or(Filter {
            width: width.map_or(default.width, |width| width as f32),
            ..default
        })
    }
}

/// Asks for instructions where no flag does: farms that start the program through Blender can't give flags.
const INSTRUCTION_SET: &str = "SUNDOG_INSTRUCTION_SET";

impl Machine {
    /// The instructions that the flag asks for, else the environment.
    fn instruction_set(&self) -> Result<Option<InstructionSet>, Failure> {
        let wanted = match self.instruction_set {
            Some(set) => Some(set),
            None => instruction_set_of_environment().map_err(Failure::usage)?,
        };
        // Told before the scene is prepared, which takes its time.
        InstructionSet::or_default(wanted).map_err(|error| Failure::new(error.to_string()))?;
        Ok(wanted)
    }
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
    let side = |pixels: f64| (pixels.round() as u32).clamp(1, MAX_SIDE);
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
