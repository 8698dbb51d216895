//! Materials, and how images lie on surfaces.

use super::graph::{Graph, Summary};
use super::{ImageId, Medium};

/// A surface material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// What it is.
    pub graph: Graph,
    /// What the file says; see `Scene` users for what culling does.
    pub double_sided: bool,
    /// What fills the meshes that have it, if something does.
    pub medium: Option<Medium>,
    /// Of several solids in one place that of the highest priority is there; none takes no part in that.
    pub priority: Option<i32>,
}

impl Default for Material {
    /// glTF's default material: white, metallic 1, roughness 1 (specification 3.9.6).
    fn default() -> Self {
        super::MetallicRoughness::default().into()
    }
}

impl Material {
    /// Whether it emits.
    pub fn emits(&self) -> bool {
        self.summary().emits()
    }

    /// Says what it is where all vertices are opaque.
    pub fn summary(&self) -> Summary {
        self.graph.summary(false)
    }
}

/// A reference to an image and how it lies on the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The image.
    pub image: ImageId,
    /// Index into `Mesh::uvs`; a mesh without that set uses (0, 0).
    pub uv_set: u32,
    /// KHR_texture_transform, applied to the coordinates first.
    pub transform: UvTransform,
    /// Wrapping and filtering.
    pub sampler: Sampler,
}

/// All of the image, by the first set of coordinates.
impl From<ImageId> for Texture {
    fn from(image: ImageId) -> Self {
        Self {
            image,
            uv_set: 0,
            transform: UvTransform::default(),
            sampler: Sampler::default(),
        }
    }
}

/// KHR_texture_transform: uv' = offset + R(rotation) · scale · uv.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Added last.
    pub offset: [f32; 2],
    /// Counter-clockwise, radians, in the extension's own convention.
    pub rotation: f32,
    /// Applied first.
    pub scale: [f32; 2],
}

impl UvTransform {
    /// Whether all its numbers are.
    pub fn is_finite(&self) -> bool {
        let mut numbers = self
            .offset
            .iter()
            .chain(&self.scale)
            .chain([&self.rotation]);
        numbers.all(|n| n.is_finite())
    }
}

impl Default for UvTransform {
    fn default() -> Self {
        Self {
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
        }
    }
}

/// glTF's sampler, as far as a path tracer has use for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Sampler {
    /// Outside 0..1 along u.
    pub wrap_u: Wrap,
    /// Outside 0..1 along v.
    pub wrap_v: Wrap,
    /// Between texels.
    pub filter: TextureFilter,
    /// What opacity does to the colours.
    pub alpha: ImageAlpha,
}

/// What an image's opacity does to its colours, by Blender's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ImageAlpha {
    /// Nothing: both are taken as they stand, as glTF has it.
    #[default]
    ChannelPacked,
    /// Opacity is 1, whatever the file says.
    None,
    /// Colours are multiplied with it before interpolation: what stands in the file where it is transparent has no influence.
    Straight {
        /// Colours are divided by it again after interpolation.
        divided: bool,
    },
    /// As `Straight`, but the file's colours are multiplied already.
    Premultiplied {
        /// Colours are divided by it after interpolation.
        divided: bool,
    },
}

impl ImageAlpha {
    /// Colours that count as much as they are opaque.
    pub const WEIGHTED: Self = Self::Straight { divided: true };

    /// What becomes of the texels: those that give the same ones are one mode.
    pub fn of_texels(self) -> Self {
        match self {
            Self::Straight { .. } => Self::Straight { divided: false },
            Self::None => Self::None,
            Self::ChannelPacked | Self::Premultiplied { .. } => Self::ChannelPacked,
        }
    }

    /// Whether texels are multiplied before they are interpolated.
    pub fn multiplies(self) -> bool {
        matches!(self, Self::Straight { .. })
    }

    /// Whether what is interpolated is divided by its opacity.
    pub fn divides(self) -> bool {
        matches!(
            self,
            Self::Straight { divided: true } | Self::Premultiplied { divided: true }
        )
    }
}

/// What lies outside the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored.
    Mirror,
    /// The border texel.
    Clamp,
    /// Nothing: transparent black. In Blender it is so along both directions.
    Clip,
}

/// Between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TextureFilter {
    /// Bilinear, of encoded colours before they are decoded, as in Cycles.
    #[default]
    Linear,
    /// Bilinear, of colours that are decoded, as glTF has it (specification 3.9.2).
    LinearLight,
    /// The nearest texel.
    Nearest,
    /// Cubic B-splines, which smooth: 4 × 4 texels.
    Cubic,
}

/// What an image's values mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageUse {
    /// Colour: 8- and 16-bit values are sRGB-encoded.
    Color,
    /// Colour of which floats are sRGB-encoded, too.
    Codes,
    /// Numbers: taken as they are.
    Data,
}
