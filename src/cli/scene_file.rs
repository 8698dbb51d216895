//! Loading a scene as the flags say; shared by all commands that read one.

use super::args::{self, Import, Loading, RenderOptions};
use super::progress::Reporter;
use super::{Failure, console};
use crate::import::{self, AnimationTime, ImportOptions};
use crate::math::words::counted;
use crate::render::memory;
use crate::scene::{Diagnostics, Environment, LeftOut, Scene, Verdict, Visibility, simplify};
use crate::world;
use glam::{DMat3, DVec3};
use std::path::{Path, PathBuf};

/// A scene, where it came from, and what did not come through.
pub struct SceneFile {
    /// The file.
    pub path: PathBuf,
    /// What is in it and changes the picture, and the environment from the flags.
    pub scene: Scene,
    /// The names of the file's variants.
    pub variants: Vec<String>,
    /// What else is in it.
    pub left_out: Vec<LeftOut>,
    /// Messages of the importer.
    pub diagnostics: Diagnostics,
}

/// Loads the scene that the flags name, without what changes nothing.
pub fn load(path: &Path, options: &RenderOptions) -> Result<SceneFile, Failure> {
    let mut file = load_all(path, &options.loading.import, &options.environment)?;
    file.left_out = simplify(&mut file.scene);
    Ok(file)
}

/// Loads all of the scene that the flags name.
pub fn load_all(
    path: &Path,
    import: &Import,
    environment: &args::Environment,
) -> Result<SceneFile, Failure> {
    let options = ImportOptions {
        light_units: import.light_units,
        transmission: import.transmission,
        cycles: import.cycles,
        scene: import.scene_name.clone(),
        variant: (!import.variant.is_empty()).then(|| import.variant.join(",")),
        without_world: environment.is_given()?,
        allow_outside: import.allow_outside,
        image_bytes: import.max_memory,
        animation: import.animation_time()?,
        scatter: import.gltf_scatter,
        grid_memory: Some(import.max_memory.unwrap_or_else(memory::free)),
    };
    let mut imported =
        import::load(path, &options).map_err(|error| Failure::new(error.to_string()))?;
    world::displace(&mut imported.scene, &mut imported.diagnostics);
    let mut file = SceneFile {
        path: path.into(),
        scene: imported.scene,
        variants: imported.variants,
        left_out: Vec::new(),
        diagnostics: imported.diagnostics,
    };
    environment.light(&mut file, import.max_memory)?;
    file.complete();
    Ok(file)
}

impl SceneFile {
    /// A camera for a scene that has none, and a word on one in which nothing shines: what other programs
    /// write need have neither.
    fn complete(&mut self) {
        let (scene, diagnostics) = (&mut self.scene, &mut self.diagnostics);
        if scene.cameras.is_empty()
            && let Some(camera) = scene.framed()
        {
            scene.cameras.push(camera);
            diagnostics.report(
                "no-camera",
                Verdict::Approximated,
                "no camera in the file",
                "",
                "seen from in front, so that all is in the picture (from Blender: export it with \"Cameras\" ticked)",
            );
        }
        if !scene.shines() {
            diagnostics.report(
                "no-light",
                Verdict::Exact,
                "no light, shining surface or world in the file",
                "",
                "the picture is black; --environment FILE or --environment-color 1,1,1 lights it (from Blender: export it with \"Punctual Lights\" ticked)",
            );
        }
    }
}

impl Import {
    /// The time at which an animation poses the file, if the flags name one.
    fn animation_time(&self) -> Result<Option<AnimationTime>, Failure> {
        let frame = self.frame.filter(|_| self.seconds.is_none());
        let seconds = self.seconds.or(frame.map(|frame| frame.seconds));
        if self.animation.is_some() && seconds.is_none() {
            return Err(Failure::usage(
                "--animation needs a time; give --frame NUMBER or --seconds TIME",
            ));
        }
        Ok(seconds.map(|seconds| AnimationTime {
            name: self.animation.clone(),
            seconds,
            frame: frame.and_then(|frame| frame.number),
        }))
    }
}

impl args::Environment {
    /// Whether the flags light the scene, instead of what the file has for it.
    fn is_given(&self) -> Result<bool, Failure> {
        let lit = match (&self.environment, self.environment_color) {
            (Some(_), Some(_)) => {
                return Err(Failure::usage(
                    "--environment and --environment-color exclude each other; give one of them",
                ));
            }
            (None, None) => false,
            _ => true,
        };
        let strength = self.environment_strength.map(|_| "strength");
        match strength.or(self.environment_rotation.map(|_| "rotation")) {
            Some(name) if !lit => Err(Failure::usage(format!(
                "--environment-{name} needs an environment; give --environment FILE or --environment-color R,G,B"
            ))),
            _ => Ok(lit),
        }
    }

    /// Lights the scene of a file, if that is asked for.
    fn light(&self, file: &mut SceneFile, most_bytes: Option<u64>) -> Result<(), Failure> {
        let strength = self.environment_strength.unwrap_or(1.0) as f32;
        let rotation_degrees = self.environment_rotation.unwrap_or(0.0) as f32;
        let scene = &mut file.scene;
        if let Some(path) = &self.environment {
            let diagnostics = import::load_environment_within(
                scene,
                path,
                (strength, rotation_degrees),
                most_bytes,
            )
            .map_err(|error| Failure::new(error.to_string()))?;
            file.diagnostics.append(diagnostics);
        } else if let Some(color) = self.environment_color {
            let mut radiance = color.map(|component| component * strength);
            if let Some(matrix) = scene.color_management.working_space.matrix_from_rec709() {
                let there = matrix * DVec3::from(radiance.map(f64::from));
                radiance = there.as_vec3().to_array();
            }
            scene.environment = Some(Environment {
                image: None,
                radiance,
                rotation: DMat3::IDENTITY,
                visibility: Visibility::ALL,
                links: Default::default(),
                graph: None,
            });
        }
        Ok(())
    }
}

/// Tells what is in a scene and what is not as in its file.
///
/// # Errors
/// With `--strict`: anything did not come through exactly.
pub fn introduce(flags: &Loading, file: &SceneFile, reporter: &Reporter) -> Result<(), Failure> {
    reporter.say(&format!(
        "{}: {}",
        file.path.display(),
        summary(&file.scene)
    ));
    reporter.diagnostics(&file.diagnostics);
    if flags.strict {
        demand_exact(&file.path, &file.diagnostics)?;
    }
    Ok(())
}

/// For `--strict`: fails if anything did not come through exactly.
fn demand_exact(path: &Path, diagnostics: &Diagnostics) -> Result<(), Failure> {
    let inexact: Vec<_> = diagnostics
        .iter()
        .filter(|d| d.verdict != Verdict::Exact)
        .collect();
    let Some(first) = inexact.first() else {
        return Ok(());
    };
    let more = match inexact.len() - 1 {
        0 => String::new(),
        1 => " (and 1 more)".to_owned(),
        count => format!(" (and {count} more)"),
    };
    Err(Failure::new(format!(
        "{}: --strict demands that everything comes through exactly: {first}{more}",
        path.display()
    )))
}

/// What is in a scene, in one line.
pub fn summary(scene: &Scene) -> String {
    format!(
        "{} in {}, {}, {}, {}",
        count(scene.placed_triangles(), "triangle"),
        count(scene.instances.len() as u64, "instance"),
        count(scene.materials.len() as u64, "material"),
        count(scene.lights.len() as u64, "light"),
        count(scene.cameras.len() as u64, "camera"),
    )
}

/// `1 light`, `2 lights`.
pub fn count(number: u64, thing: &str) -> String {
    counted(console::grouped(number), thing, &format!("{thing}s"))
}
