//! Files become a scene plus diagnostics.
//!
//! [`load`] reads a scene file, [`load_environment`] adds an environment image to a scene. Neither
//! panics, hangs or takes memory out of proportion on any input; a file that cannot be read is one
//! [`ImportError`] that names the file, the object and the way out. What can be read but not carried
//! over exactly is a [`Diagnostics`] message.

mod budget;
mod error;
mod gltf;
mod guard;
mod ies;
mod image;
mod usd;
mod vdb;

pub use error::ImportError;
pub use image::{ExrLayer, ImageFailure, colors, decode_colors, decode_image, read_exr};

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use crate::math::primaries::WorkingSpace;
use crate::math::words::counted;
use crate::nodes::CyclesVersion;
use crate::scene::{
    self, Diagnostics, Effect, Environment, Image, ImageId, Pixels, Scene, Verdict, Visibility,
};

/// Choices that a scene file leaves open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// What the file's light intensities mean.
    pub light_units: LightUnits,
    /// What transmission without a volume means.
    pub transmission: Transmission,
    /// The glTF scene to load, by name or index; `None` is the file's default scene.
    pub scene: Option<String>,
    /// The variant whose materials are shown, by name; `None` is the file's default materials.
    pub variant: Option<String>,
    /// Leaves out the light from all around that the file has: another takes its place.
    pub without_world: bool,
    /// The version of Cycles that node trees are rendered as; `None` is the one that each was made with.
    pub cycles: Option<CyclesVersion>,
    /// Reads files, too, that the scene names and that do not lie in its folder (or below it).
    pub allow_outside: bool,
    /// The images of a scene together take no more memory than so many bytes: the largest lie in scratch files.
    pub image_bytes: Option<u64>,
    /// The time at which an animation of the file poses it; `None` is the pose that the file has without.
    pub animation: Option<AnimationTime>,
    /// Reads glTF's KHR_materials_volume_scatter, a draft.
    pub scatter: bool,
    /// What the grids of volumes may take, bytes; `None` is no limit.
    pub grid_memory: Option<u64>,
}

/// A time of an animation.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationTime {
    /// Its name or number; `None` is the first.
    pub name: Option<String>,
    /// Since it began.
    pub seconds: f64,
    /// The frame, if that is what was asked for: USD counts time in them.
    pub frame: Option<f64>,
}

/// What the light intensities of a glTF file mean, named as in Blender's exporter.
///
/// `Auto` decides between `Standard` and `Unitless` by who wrote the file and by how bright its numbers make it.
///
/// For a lamp of `P` watts (point and spot) or `E` W/m² (sun) Blender 4.5 writes
/// (`io_scene_gltf2/blender/exp/lights.py`), and we undo:
///
/// | mode | point and spot | sun |
/// | --- | --- | --- |
/// | `Standard` | `683 · P / 4π` cd | `683 · E` lx |
/// | `Unitless` | `P / 4π` | `E` |
/// | `Raw` | `P` | `E` |
///
/// A spot is written as a point of the same power: the cone only cuts, it does not concentrate.
/// Cycles gives a lamp of `P` watts the radiant intensity `P / 4π`, so that the intensities of the
/// scene are W/sr and W/m² in all three modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightUnits {
    /// By what wrote the file, and by plausibility: most programs write other numbers than the extension says.
    #[default]
    Auto,
    /// Photometric, as KHR_lights_punctual has it; 683 lm are a watt.
    Standard,
    /// Blender's "Unitless" (COMPAT).
    Unitless,
    /// Blender's "Raw (Deprecated)".
    Raw,
}

/// What KHR_materials_transmission means where KHR_materials_volume gives no thickness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transmission {
    /// Solid in files by Blender's exporter (as Cycles shows the same material), thin otherwise.
    #[default]
    Auto,
    /// The surface bounds a solid and refracts.
    Solid,
    /// The surface is a thin sheet, as the extension says.
    Thin,
}

/// A scene and what could not be carried over into it.
#[derive(Clone, Debug, Default)]
pub struct Imported {
    /// The scene, clean in the sense of [`scene::validate::clean`].
    pub scene: Scene,
    /// The names of the file's variants.
    pub variants: Vec<String>,
    /// What was approximated or lost, and conventions that were chosen.
    pub diagnostics: Diagnostics,
}

/// Reads a scene file: USD by its ending or content, otherwise glTF (`.glb` or `.gltf`, told apart by content).
///
/// # Errors
/// The file or one that it names cannot be read, is malformed, or demands what Sundog cannot do.
pub fn load(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let mut imported = if usd::is_usd(path) {
        usd::load(path, options)?
    } else {
        gltf::load(path, options)?
    };
    scene::validate::clean(&mut imported.scene, &mut imported.diagnostics);
    Ok(imported)
}

/// Whether a file is read as USD.
pub fn is_usd(path: &Path) -> bool {
    usd::is_usd(path)
}

/// What is to be done about a file that a repository has in name only.
fn pointer(bytes: &[u8]) -> Option<&'static str> {
    let found = bytes.starts_with(b"version https://git-lfs.github.com/spec");
    found.then_some("a Git LFS pointer: run \"git lfs pull\" where it lies")
}

/// Where the files would be that a scene file names: its buffers, images and layers. None for a file that cannot be read.
pub fn named_files(path: &Path) -> Vec<std::path::PathBuf> {
    if usd::is_usd(path) {
        return usd::named_files(path);
    }
    gltf::named_files(path)
}

/// Reads an equirectangular image (EXR, Radiance HDR: linear Rec.709; also PNG, JPEG, WebP, taken as sRGB) and
/// makes it the scene's environment, in place of any that was there.
///
/// `strength` scales the image to radiance in W·sr⁻¹·m⁻²; `rotation_degrees` turns it about the
/// up axis in the sense of the Z rotation of Blender's Mapping node.
///
/// # Errors
/// The file cannot be read or decoded, or a number is not finite.
pub fn load_environment(
    scene: &mut Scene,
    path: &Path,
    strength: f32,
    rotation_degrees: f32,
) -> Result<Diagnostics, ImportError> {
    load_environment_within(scene, path, (strength, rotation_degrees), None)
}

/// The same, where all images of the scene may take so many bytes of memory: beyond that the environment lies in a scratch file.
///
/// # Errors
/// As [`load_environment`].
pub fn load_environment_within(
    scene: &mut Scene,
    path: &Path,
    (strength, rotation_degrees): (f32, f32),
    most_bytes: Option<u64>,
) -> Result<Diagnostics, ImportError> {
    let file = path.display().to_string();
    if !(strength.is_finite() && strength >= 0.0) {
        return Err(ImportError::malformed(
            &file,
            "environment",
            "its strength must be a finite number of at least 0",
        ));
    }
    if !rotation_degrees.is_finite() {
        return Err(ImportError::malformed(
            &file,
            "environment",
            "its rotation must be a finite number",
        ));
    }
    let bytes = error::read_file(path)?;
    let mut diagnostics = Diagnostics::default();
    if let Some(old) = scene.environment.take()
        && let Some(id) = old.image
        && id.0 as usize + 1 == scene.images.len()
    {
        scene.images.pop();
    }
    let taking = Taking {
        space: scene.color_management.working_space,
        floats_are_in_it: false,
        most_bytes: left_for_images(&scene.images, most_bytes),
    };
    let image = environment_image(&bytes, &file, &file, &taking, &mut diagnostics)?;
    let id = ImageId(u32::try_from(scene.images.len()).unwrap_or(u32::MAX));
    scene.images.push(image);
    scene.environment = Some(Environment {
        image: Some(id),
        radiance: [strength; 3],
        rotation: Environment::turned_about_up(rotation_degrees.to_radians()),
        visibility: Visibility::ALL,
        links: Default::default(),
        graph: None,
    });
    Ok(diagnostics)
}

/// What is left of the memory that all images of a scene may take.
fn left_for_images(images: &[Image], most: Option<u64>) -> Option<u64> {
    let taken: u64 = images.iter().map(|i| i.pixels.bytes_in_memory()).sum();
    Some(most?.saturating_sub(taken))
}

/// How an environment's image is read.
struct Taking {
    /// The scene's.
    space: WorkingSpace,
    /// Images of floats are in it already; all others are in Rec.709.
    floats_are_in_it: bool,
    /// Memory that it may take.
    most_bytes: Option<u64>,
}

/// An equirectangular image as linear RGB of the scene's space, without values that light cannot have. `file` is for errors,
/// `name` the image's own.
fn environment_image(
    bytes: &[u8],
    file: &str,
    name: &str,
    taking: &Taking,
    diagnostics: &mut Diagnostics,
) -> Result<Image, ImportError> {
    let limit = budget::Budget::for_image(bytes.len());
    if let Some(most) = taking.most_bytes {
        scene::keep_mapped_below(most);
    }
    let mut image = image::decode_linear_rgb(bytes, name, &limit, taking.most_bytes)
        .map_err(|failure| ImportError::image(file, "environment image", failure))?;
    if image.pixels.are_in_file() {
        image::tell_in_file(&image, diagnostics);
    }
    let of_floats = matches!(image::sniff(bytes), image::Format::Exr | image::Format::Hdr);
    if let (Some(matrix), Pixels::F32(values)) =
        (taking.space.matrix_from_rec709(), &mut image.pixels)
        && !(of_floats && taking.floats_are_in_it)
    {
        let (pixels, _) = Arc::make_mut(values).as_chunks_mut::<3>();
        for pixel in pixels {
            *pixel = (matrix * DVec3::from(pixel.map(f64::from)))
                .as_vec3()
                .to_array();
        }
    }
    if let Pixels::F32(values) = &mut image.pixels {
        let replaced = image::make_radiance(&mut Arc::make_mut(values)[..]);
        if replaced > 0 {
            diagnostics.report_effect(
                Effect::ImageEnvironment,
                "environment-values",
                Verdict::Approximated,
                format!(
                    "{} of the environment negative or not finite",
                    counted(replaced, "texel", "texels")
                ),
                name,
                "negative and not-a-number values count as 0, infinite ones as the largest finite value of the image",
            );
        }
    }
    Ok(image)
}
