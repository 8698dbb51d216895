//! One material model: Blender's Principled BSDF and glTF's metallic-roughness are cases of it.

use super::ImageId;

/// A surface material. Scalars multiply their textures.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Linear base colour.
    pub base_color: [f32; 3],
    /// RGB, sRGB-encoded in 8- and 16-bit files; alpha in A.
    pub base_color_texture: Option<Texture>,
    /// Opacity 0..=1.
    pub alpha: f32,
    /// How opacity is used.
    pub alpha_mode: AlphaMode,
    /// 0 (dielectric) to 1 (metal).
    pub metallic: f32,
    /// Perceptual roughness: α = roughness².
    pub roughness: f32,
    /// Roughness in G, metallic in B; linear.
    pub metallic_roughness_texture: Option<Texture>,
    /// Tangent-space normals.
    pub normal_texture: Option<NormalTexture>,
    /// Emitted radiance, strength included, W·sr⁻¹·m⁻².
    pub emission: [f32; 3],
    /// RGB, sRGB-encoded in 8- and 16-bit files.
    pub emission_texture: Option<Texture>,
    /// Index of refraction of the dielectric.
    pub ior: f32,
    /// Scales the dielectric's reflectance at normal incidence (KHR_materials_specular
    /// `specularFactor`; Blender's specular IOR level is half of it).
    pub specular: f32,
    /// Factor in A.
    pub specular_texture: Option<Texture>,
    /// Tints the dielectric's reflectance at normal incidence.
    pub specular_color: [f32; 3],
    /// RGB, sRGB-encoded in 8- and 16-bit files.
    pub specular_color_texture: Option<Texture>,
    /// Share of light that goes through instead of being scattered diffusely, 0..=1.
    pub transmission: f32,
    /// Factor in R.
    pub transmission_texture: Option<Texture>,
    /// Transmission without refraction, as through a thin sheet (glTF without a volume);
    /// otherwise the surface bounds a solid.
    pub thin_walled: bool,
    /// What the file says; see `Scene` users for what culling does.
    pub double_sided: bool,
    /// Shows its base colour without light (KHR_materials_unlit).
    pub unlit: bool,
}

impl Default for Material {
    /// glTF's default material: white, metallic 1, roughness 1 (specification 3.9.6).
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 3],
            base_color_texture: None,
            alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            emission: [0.0; 3],
            emission_texture: None,
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: [1.0; 3],
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            thin_walled: true,
            double_sided: false,
            unlit: false,
        }
    }
}

impl Material {
    /// Whether it emits.
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&e| e > 0.0)
            || (self.unlit && self.base_color.iter().any(|&c| c > 0.0))
    }

    /// Whether all of it is metal: a texture scales the factor down.
    pub fn is_metal_everywhere(&self) -> bool {
        self.metallic >= 1.0 && self.metallic_roughness_texture.is_none()
    }

    /// Whether all of it below metal is glass.
    pub fn is_glass_everywhere(&self) -> bool {
        self.transmission >= 1.0 && self.transmission_texture.is_none()
    }

    /// All textures but the normal map.
    pub fn textures_mut(&mut self) -> [&mut Option<Texture>; 6] {
        [
            &mut self.base_color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.emission_texture,
            &mut self.specular_texture,
            &mut self.specular_color_texture,
            &mut self.transmission_texture,
        ]
    }
}

/// How opacity is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Visible where alpha ≥ cutoff, otherwise a hole.
    Mask {
        /// Threshold.
        cutoff: f32,
    },
    /// The share alpha of light meets the surface, the rest passes straight on.
    Blend,
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

/// A normal map and its strength.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalTexture {
    /// The image: RGB 0..=1 stands for -1..=1 (+Y up, OpenGL's convention).
    pub texture: Texture,
    /// Scales x and y before normalisation.
    pub scale: f32,
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
    /// Between texels, colours count as much as they are opaque, and where there is no opacity there is no colour: what stands
    /// in the file where it is transparent has no influence.
    pub weighted: bool,
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
}

/// Between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TextureFilter {
    /// Bilinear.
    #[default]
    Linear,
    /// The nearest texel.
    Nearest,
}

/// What an image's values mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageUse {
    /// Colour: 8- and 16-bit values are sRGB-encoded.
    Color,
    /// Numbers: taken as they are.
    Data,
}
