//! What a scene *is*, independent of file format and of rendering.
//!
//! Conventions: metres, Y up, right-handed (as in glTF); colours linear Rec.709; radiometric units
//! (watts). Transforms are f64 and map object space to world space (`world_from_object`).

pub mod area;
mod camera;
mod catchers;
pub mod coincident;
mod diagnostics;
mod duplicate_triangles;
mod effect;
mod fast_gi;
mod fingerprint;
mod flat;
mod flatten;
pub mod graph;
mod grid;
mod inventory;
mod left_out;
mod links;
mod material;
mod medium;
mod metallic_roughness;
mod motion;
mod nesting;
mod own_space;
mod settings;
mod simplify;
mod strands;
pub mod tangents;
pub mod texel;
pub mod validate;
mod vertex_normals;
mod visibility;
mod whole;

pub use crate::ffi::scratch::keep_mapped_below;
pub use crate::ffi::values::{Place, Values};
pub use camera::{Aperture, Camera, Projection, SphericalStereo, Window};
pub use diagnostics::{Diagnostic, Diagnostics, Subject, Verdict};
pub use effect::Effect;
pub use fast_gi::{FastGi, FastGiMethod};
pub use fingerprint::fingerprint;
pub use grid::{Grid, Grids, Interpolation, LEAF_POINTS, NoMemory};
pub use inventory::{BoundsInfo, Inventory};
pub use left_out::LeftOut;
pub use links::{LightGrouping, Links};
pub use material::{
    ImageAlpha, ImageUse, Material, Sampler, Texture, TextureFilter, UvTransform, Wrap,
};
pub use medium::{Medium, Phase, Scatterer};
pub use metallic_roughness::{
    AlphaMode, Anisotropy, Coat, CoatNormal, DiffuseTransmission, Iridescence, MetallicRoughness,
    NormalTexture, Sheen,
};
pub use motion::{CameraMotion, MOST_STEPS, MeshStep, Shutter};
pub use settings::{ColorManagement, RenderDefaults};
pub use simplify::simplify;
pub use strands::{StrandShape, Strands};
pub use texel::decoded;

pub use visibility::{RayKind, Visibility};
pub use whole::Bounds;

use glam::{DAffine3, DMat3};
use std::sync::Arc;

/// Index into [`Scene::meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MeshId(pub u32);
/// Index into [`Scene::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);
/// Index into [`Scene::images`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ImageId(pub u32);

/// Everything that a file says about a scene; what importers make and the renderer reads.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The file's own account of the program that wrote it (glTF `asset.generator`).
    pub generator: Option<String>,
    /// Triangle meshes, each with one material; shared by instances.
    pub meshes: Vec<Mesh>,
    /// Placed meshes.
    pub instances: Vec<Instance>,
    /// Materials; a mesh names one.
    pub materials: Vec<Material>,
    /// Images that textures refer to, in their own precision.
    pub images: Vec<Image>,
    /// Punctual lights (with a size where the file gives one).
    pub lights: Vec<Light>,
    /// Light from all around, at infinity.
    pub environment: Option<Environment>,
    /// Openings through which that is looked for.
    pub portals: Vec<Portal>,
    /// What fills all space.
    pub medium: Option<Medium>,
    /// Cameras in file order; may be empty.
    pub cameras: Vec<Camera>,
    /// Light groups with a pass each, by their names.
    pub light_groups: Vec<String>,
    /// How the shutter lets light through while things move.
    pub shutter: Shutter,
    /// How the file wishes to be shown.
    pub color_management: ColorManagement,
    /// How the file wishes to be rendered.
    pub render: RenderDefaults,
    /// What stands for indirect light, if anything does.
    pub fast_gi: Option<FastGi>,
    /// Passes of its own, in which materials and the world tell values (Blender's AOVs) …
    pub aovs: Vec<Aov>,
    /// … and what the world tells.
    pub world_aovs: Option<Box<graph::Graph>>,
}

/// A pass of the scene's own.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Aov {
    /// What it is called.
    pub name: String,
    /// It has colours with an alpha, or else numbers.
    pub is_color: bool,
}

impl Aov {
    /// Blender's names of its channels, a letter each.
    pub fn channels(&self) -> &'static str {
        if self.is_color { "RGBA" } else { "X" }
    }

    /// Floats of a pixel of some of them.
    pub fn floats(all: &[Self]) -> usize {
        all.iter().map(|aov| aov.channels().len()).sum()
    }
}

/// A triangle mesh with one material (a glTF primitive).
///
/// Optional attributes have the length of `positions` where they are given.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name of the mesh in the file (for messages).
    pub name: String,
    /// Vertex positions, object space, metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit vertex normals; `None` means flat shading.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Unit tangents with the sign of the bitangent in `w` (glTF's convention).
    /// Given by the file or computed by MikkTSpace where the material has a normal map.
    pub tangents: Option<Vec<[f32; 4]>>,
    /// The set of texture coordinates that tangents were computed from; none where the file gave them.
    pub tangent_set: Option<u32>,
    /// Directions around the mesh's Z axis by its generated coordinates, of any length, between vertices linear. They turn as
    /// normals do.
    pub radial: Option<Vec<[f32; 3]>>,
    /// Its own texture coordinates ("Generated") by vertex, where those are others than its texture space gives.
    pub generated: Option<Vec<[f32; 3]>>,
    /// Texture coordinate sets (TEXCOORD_0, TEXCOORD_1, …), glTF's convention: v grows downwards.
    pub uvs: Vec<Vec<[f32; 2]>>,
    /// Linear vertex colour with alpha (COLOR_0); multiplies base colour and alpha.
    pub colors: Option<Vec<[f32; 4]>>,
    /// What shader graphs ask for beside these, by its numbers; RGBA or XYZ.
    pub attributes: Vec<Vec<[f32; 4]>>,
    /// Where the mesh lies in its own texture coordinates ("Generated").
    pub texture_space: TextureSpace,
    /// The vertices at equal steps of time while the shutter is open; empty where they stand still.
    pub motion: Vec<MeshStep>,
    /// Corner indices, each below `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
    /// The material of all triangles; `None` is the file format's default material.
    pub material: Option<MaterialId>,
    /// What the file calls that material, which may be one with others of other names.
    pub material_label: MaterialLabel,
    /// What it is a part of, if its vertices are to be displaced together with those of other parts.
    pub part: Option<Part>,
    /// Grids of what fills it, in its own (Blender's) axes.
    pub grids: Option<Arc<Grids>>,
    /// It is made of strands or points; then `triangles` stand for their segments.
    pub strands: Option<Strands>,
}

impl Mesh {
    /// Its vertices become these of its vertices, with all that they have; corners stay as they are.
    pub fn take_vertices(&mut self, of: &[u32]) {
        fn take<T: Copy>(values: &mut Vec<T>, of: &[u32]) {
            *values = of.iter().map(|&i| values[i as usize]).collect();
        }
        take(&mut self.positions, of);
        for step in &mut self.motion {
            take(&mut step.positions, of);
        }
        let normals = self.motion.iter_mut().map(|step| &mut step.normals);
        let vectors = normals.chain([&mut self.normals, &mut self.radial, &mut self.generated]);
        vectors.flatten().for_each(|values| take(values, of));
        self.uvs.iter_mut().for_each(|values| take(values, of));
        let attributes = self.attributes.iter_mut();
        let others = attributes.chain(&mut self.tangents).chain(&mut self.colors);
        others.for_each(|values| take(values, of));
        if let Some(strands) = &mut self.strands {
            take(&mut strands.radii, of);
            take(&mut strands.normals, of);
        }
    }
}

/// What passes tell of a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialLabel {
    /// Its name; none where there is no material.
    pub name: Option<Arc<str>>,
    /// Its pass index.
    pub index: f32,
}

/// A part of a mesh that is to be displaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Parts of one mesh have one number.
    pub whole: u32,
    /// The attribute of vertices that tells them apart: the lower and the upper 16 bits of a number, and how they are shaded
    /// (0: flat; 1: by the vertices' normals; 2 and 3: smooth and flat by the corners' normals).
    pub vertices: u32,
    /// The attribute after it holds the vertices' normals: those of a flat mesh, by which it is displaced.
    pub with_normals: bool,
}

/// A box in a mesh's own (Blender's) axes, across which its "Generated" coordinates go from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureSpace {
    /// Its middle.
    pub location: [f32; 3],
    /// Half of its extents.
    pub size: [f32; 3],
}

impl TextureSpace {
    /// The coordinates of a point of the mesh's own space.
    pub fn generated(&self, point: glam::Vec3) -> glam::Vec3 {
        let (location, size) = (glam::Vec3::from(self.location), glam::Vec3::from(self.size));
        let size = glam::Vec3::select(size.cmpeq(glam::Vec3::ZERO), glam::Vec3::ONE, size);
        (point - location + size) / (size * 2.0)
    }

    /// The box around some points, as Blender's own automatic one.
    pub fn around(points: &[[f32; 3]]) -> Self {
        let points = || points.iter().map(|p| glam::Vec3::from(*p));
        let low = points().fold(glam::Vec3::INFINITY, glam::Vec3::min);
        let high = points().fold(glam::Vec3::NEG_INFINITY, glam::Vec3::max);
        Self {
            location: (0.5 * (low + high)).to_array(),
            size: (0.5 * (high - low)).to_array(),
        }
    }
}

impl Default for TextureSpace {
    /// From −1 to 1, as that of Blender's new cube.
    fn default() -> Self {
        Self {
            location: [0.0; 3],
            size: [1.0; 3],
        }
    }
}

/// What Blender's Object Info node says of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectInfo {
    /// Its colour and opacity in the viewport.
    pub color: [f32; 4],
    /// Its pass index.
    pub index: f32,
    /// A number of its own, 0 to 1.
    pub random: f32,
    /// Name of the topmost of its parents; its own where the file says none.
    pub asset: Option<Arc<str>>,
    /// What it belongs to.
    pub links: Links,
    /// What else shader graphs ask of it, by their numbers.
    pub values: Arc<[[f32; 4]]>,
    /// Blender's Shadow Terminator, Shading Offset: 0 to 1.
    pub shading_offset: f32,
    /// How far what stands for indirect light sees from here, metres; 0 for as far as from elsewhere.
    pub reach: f32,
    /// Blender has a mesh for it alone, though others have an equal one and the file shares it.
    pub own_mesh: bool,
}

impl Default for ObjectInfo {
    fn default() -> Self {
        Self {
            color: [1.0; 4],
            index: 0.0,
            random: 0.0,
            asset: None,
            links: Links::default(),
            values: Arc::default(),
            shading_offset: 0.0,
            reach: 0.0,
            own_mesh: false,
        }
    }
}

/// A mesh placed in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Name of the node that places it (for messages and object masks).
    pub name: String,
    /// Which mesh.
    pub mesh: MeshId,
    /// Object space to world space.
    pub world_from_object: DAffine3,
    /// The same at equal steps of time while the shutter is open; empty where it stands still.
    pub motion: Vec<DAffine3>,
    /// Which rays see it.
    pub visibility: Visibility,
    /// Where the camera sees it the picture is empty.
    pub holdout: bool,
    /// What shader graphs may ask about it.
    pub info: ObjectInfo,
}

/// A decoded image. Rows from top to bottom, pixels interleaved.
#[derive(Clone, Debug)]
pub struct Image {
    /// File name or the name inside the scene file (for messages).
    pub name: String,
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// 1 to 4 interleaved channels: grey, grey + alpha, RGB, RGBA.
    pub channels: u32,
    /// The values in the precision of the file.
    pub pixels: Pixels,
}

/// Pixel values in the precision of the file: `width * height * channels` of them. A copy shares them.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// 8 bits, 0..=255 stands for 0..=1.
    U8(Arc<Values<u8>>),
    /// 16 bits, 0..=65535 stands for 0..=1.
    U16(Arc<Values<u16>>),
    /// Linear floats.
    F32(Arc<Values<f32>>),
}

impl From<Vec<u8>> for Pixels {
    fn from(values: Vec<u8>) -> Self {
        Self::U8(Arc::new(values.into()))
    }
}

impl From<Vec<u16>> for Pixels {
    fn from(values: Vec<u16>) -> Self {
        Self::U16(Arc::new(values.into()))
    }
}

impl From<Vec<f32>> for Pixels {
    fn from(values: Vec<f32>) -> Self {
        Self::F32(Arc::new(values.into()))
    }
}

/// A light that is not geometry.
#[derive(Clone, Debug)]
pub struct Light {
    /// Name of the node or light in the file.
    pub name: String,
    /// Linear colour; multiplies the strength.
    pub color: [f32; 3],
    /// Kind, strength and size.
    pub kind: LightKind,
    /// Light space to world space; the light looks down its -Z axis.
    pub world_from_light: DAffine3,
    /// Which rays see it. Without [`RayKind::Shadow`] it shines through everything.
    pub visibility: Visibility,
    /// Paths with more bounces do not see it.
    pub max_bounces: u32,
    /// Whether scattered rays find it, as mirrors need; otherwise light samples alone do (Cycles' "Multiple Importance").
    pub is_hit: bool,
    /// What it belongs to.
    pub links: Links,
    /// A node tree that emits: its light is what this one is multiplied with.
    pub graph: Option<Box<graph::Graph>>,
}

impl Light {
    /// Cycles' "Max Bounces" of a new light, and ours where the file says nothing.
    pub const MAX_BOUNCES: u32 = 1024;
}

/// Kinds of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// A sphere that emits the same radiance everywhere (a point where `radius` is 0).
    Point {
        /// Radiant intensity, W/sr.
        intensity: f32,
        /// Metres.
        radius: f32,
        /// A disc that faces what it shines on instead of a sphere.
        soft_falloff: bool,
    },
    /// A point light inside a cone about -Z.
    Spot {
        /// Radiant intensity on the axis, W/sr.
        intensity: f32,
        /// Metres.
        radius: f32,
        /// A disc that faces what it shines on instead of a sphere.
        soft_falloff: bool,
        /// Half the opening angle of the cone, radians, 0..=π/2.
        half_angle: f32,
        /// Blender's blend: 0 is a hard edge, 1 fades from the axis on.
        blend: f32,
    },
    /// Parallel light along -Z from a disc of the given angular diameter.
    Sun {
        /// Irradiance on a surface that faces the sun, W/m².
        irradiance: f32,
        /// Angular diameter, radians (0: exactly parallel).
        angle: f32,
    },
    /// A flat light in the XY plane about the origin that shines along -Z.
    Area {
        /// Its outline.
        shape: AreaShape,
        /// Full extents along X and Y before the transform, metres.
        size: [f32; 2],
        /// Watts that it sends into its half-space; if not `normalize`, π times its radiance.
        power: f32,
        /// The radiance is what makes `power` of the area in world space.
        normalize: bool,
        /// Full angle about -Z within which it shines, radians, 0..=π (Cycles' "Spread").
        spread: f32,
    },
}

impl LightKind {
    /// The number that its light is in proportion to, each kind in its own unit.
    pub fn strength(&self) -> f32 {
        match *self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
            Self::Sun { irradiance, .. } => irradiance,
            Self::Area { power, .. } => power,
        }
    }

    /// The effect that a light of this kind is.
    pub fn effect(&self) -> Effect {
        match self {
            Self::Point { .. } => Effect::PointLights,
            Self::Spot { .. } => Effect::SpotLights,
            Self::Area { .. } => Effect::AreaLights,
            Self::Sun { .. } => Effect::Suns,
        }
    }
}

/// Outlines of area lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaShape {
    /// All of the extents.
    Rectangle,
    /// The ellipse that touches their middles.
    Ellipse,
}

/// Light from infinitely far away in all directions.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Equirectangular linear image, or `None` for a constant.
    ///
    /// The image's middle column lies in the direction that Blender's world mapping gives it: see
    /// `light::environment` for the formula.
    pub image: Option<ImageId>,
    /// Radiance (times the image where there is one), W·sr⁻¹·m⁻².
    pub radiance: [f32; 3],
    /// Takes a direction of the world to that of the image, both by Blender's axes (Z up): orthonormal.
    pub rotation: DMat3,
    /// Which rays see it.
    pub visibility: Visibility,
    /// What it belongs to.
    pub links: Links,
    /// A node tree in the image's place.
    pub graph: Option<Box<WorldGraph>>,
}

/// An opening in the XY plane about its origin through which the environment shines along -Z: a hint for light sampling, which
/// changes the noise alone (Cycles' "Portal").
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// Name of the node in the file.
    pub name: String,
    /// Its outline.
    pub shape: AreaShape,
    /// Full extents along X and Y before the transform, metres.
    pub size: [f32; 2],
    /// Its own space to world space.
    pub world_from_portal: DAffine3,
}

/// The node tree of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldGraph {
    /// What it is: its surface emits.
    pub graph: graph::Graph,
    /// Columns of the table by which light sampling finds it; 0 leaves it to the images and suns in it, as in Cycles.
    pub resolution: u32,
}

impl Environment {
    /// The same radiance from all around, W·sr⁻¹·m⁻², seen by all rays.
    pub fn constant(radiance: [f32; 3]) -> Self {
        Self {
            image: None,
            radiance,
            rotation: DMat3::IDENTITY,
            visibility: Visibility::ALL,
            links: Links::default(),
            graph: None,
        }
    }

    /// The effect that light from all around of this kind is.
    pub fn effect(&self) -> Effect {
        if self.image.is_some() || self.graph.is_some() {
            Effect::ImageEnvironment
        } else {
            Effect::ConstantEnvironment
        }
    }

    /// The rotation of Blender's Mapping node about its Z axis, the up axis.
    pub fn turned_about_up(radians: f32) -> DMat3 {
        DMat3::from_rotation_z(f64::from(radians))
    }
}
