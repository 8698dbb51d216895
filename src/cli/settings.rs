//! The settings of a render from the flags and the scene; shared by all commands that render.

use super::Failure;
use super::args::{Machine, RenderOptions, Size};
use crate::render::{
    Ablation, BounceLimits, Filter, InstructionSet, LightShares, RenderSettings, Sequences,
    picture_size,
};
use crate::scene::{Camera, Scene};
use std::path::Path;

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
                volume: bounces.bounces_volume,
                transparent: bounces.bounces_transparent,
            },
            clamp_direct: transport.clamp_direct as f32,
            clamp_indirect: transport.clamp_indirect as f32,
            light_shares: match transport {
                t if t.even_lights => LightShares::Even,
                t if t.tree_lights => LightShares::AsTree,
                _ => LightShares::ByPlace,
            },
            filter_glossy: transport.filter_glossy as f32,
            transparent_film: size.transparent || scene.render.transparent == Some(true),
            transparent_glass: size
                .transparent_glass
                .or(scene.render.transparent_glass)
                .map(|roughness| roughness as f32),
            film_exposure: film_exposure.map_or(defaults.film_exposure, |factor| factor as f32),
            caustics: transport.caustics,
            region: size.region,
            camera,
            seed: machine.seed,
            sequences: match machine.sequences {
                1 => Sequences::One {
                    planned: machine.planned_samples,
                },
                _ => Sequences::Two,
            },
            threads: machine.threads.map(|threads| threads as usize),
            instruction_set: machine.instruction_set()?,
            filter: size.filter(scene),
            light_sampling: studies.light_sampling,
            light_samples: studies.light_samples,
            branches: studies.branches,
            roulette: studies.roulette,
            ablation: Ablation {
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
            .and_then(|camera| Some(camera.aspect()? / camera.pixel_aspect(&scene.render)));
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
