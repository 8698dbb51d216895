//! glTF's metallic-roughness material with its extensions, and the shader graph that says the same.

mod builder;

use super::graph::{Distribution, Graph, Node, ShaderRules, TangentKind};
use super::{Material, Medium, Texture};

/// A material as glTF's core and its extensions describe it. Scalars multiply their textures.
#[derive(Clone, Debug, PartialEq)]
pub struct MetallicRoughness {
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
    /// Where it is not `None`, the alpha of the specular colour's texture times this is the glossiness, and the roughness is 1
    /// less that (KHR_materials_pbrSpecularGlossiness).
    pub glossiness: Option<f32>,
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
    /// 20 over the Abbe number (KHR_materials_dispersion); 0: the index is the same for all wavelengths.
    pub dispersion: f32,
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
    /// A Glossy BSDF of the base colour and the roughness, and nothing else (SUNDOG_material).
    pub glossy: Option<Distribution>,
    /// A shader of one lobe, and nothing else (SUNDOG_material).
    pub simple: Option<Box<Node>>,
    /// Colour of the light that passes straight on where the opacity is below 1 (SUNDOG_material).
    pub transparent_color: [f32; 3],
    /// Roughness of the diffuse base (SUNDOG_material).
    pub diffuse_roughness: f32,
    /// The specular colour tints the edges of metals (SUNDOG_material).
    pub edge_tint: bool,
    /// Highlights that are longer one way.
    pub anisotropy: Option<Anisotropy>,
    /// A clear coat.
    pub coat: Option<Box<Coat>>,
    /// A layer of fibres.
    pub sheen: Option<Box<Sheen>>,
    /// Thickness in nanometres and index of a thin film (SUNDOG_material).
    pub thin_film: Option<[f32; 2]>,
    /// A thin film (KHR_materials_iridescence).
    pub iridescence: Option<Box<Iridescence>>,
    /// Light that is scattered through the surface.
    pub diffuse_transmission: Option<Box<DiffuseTransmission>>,
    /// What the file says; see `Scene` users for what culling does.
    pub double_sided: bool,
    /// Shows its base colour without light (KHR_materials_unlit).
    pub unlit: bool,
    /// What fills the meshes.
    pub medium: Option<Medium>,
    /// Among solids that overlap (SUNDOG_material).
    pub priority: Option<i32>,
    /// Whose version it follows (Sundog's add-on).
    pub rules: ShaderRules,
}

impl Default for MetallicRoughness {
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
            glossiness: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            emission: [0.0; 3],
            emission_texture: None,
            ior: 1.5,
            dispersion: 0.0,
            specular: 1.0,
            specular_texture: None,
            specular_color: [1.0; 3],
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            thin_walled: true,
            rules: ShaderRules::default(),
            glossy: None,
            simple: None,
            transparent_color: [1.0; 3],
            diffuse_roughness: 0.0,
            edge_tint: false,
            anisotropy: None,
            coat: None,
            sheen: None,
            thin_film: None,
            iridescence: None,
            diffuse_transmission: None,
            double_sided: false,
            unlit: false,
            medium: None,
            priority: None,
        }
    }
}

impl MetallicRoughness {
    /// The material, of a graph instead of its own where there is one.
    pub fn with_graph(self, graph: Option<Graph>) -> Material {
        match graph {
            None => self.into(),
            Some(graph) => Material {
                name: self.name,
                graph,
                double_sided: self.double_sided,
                medium: self.medium,
                priority: self.priority,
            },
        }
    }

    /// All textures but the normal map.
    pub fn textures_mut(&mut self) -> Vec<&mut Option<Texture>> {
        let mut all = vec![
            &mut self.base_color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.emission_texture,
            &mut self.specular_texture,
            &mut self.specular_color_texture,
            &mut self.transmission_texture,
        ];
        if let Some(Anisotropy::Gltf { texture, .. }) = &mut self.anisotropy {
            all.push(texture);
        }
        if let Some(coat) = &mut self.coat {
            all.extend([&mut coat.texture, &mut coat.roughness_texture]);
        }
        if let Some(sheen) = &mut self.sheen {
            all.extend([&mut sheen.color_texture, &mut sheen.roughness_texture]);
        }
        if let Some(film) = &mut self.iridescence {
            all.extend([&mut film.texture, &mut film.thickness_texture]);
        }
        if let Some(through) = &mut self.diffuse_transmission {
            all.extend([&mut through.texture, &mut through.color_texture]);
        }
        all
    }

    /// The highest set of texture coordinates of its textures but the normal map.
    pub fn highest_uv_set(&mut self) -> Option<u32> {
        let textures = self.textures_mut().into_iter();
        textures.filter_map(|t| Some(t.as_ref()?.uv_set)).max()
    }
}

/// A clear coat (KHR_materials_clearcoat; index and tint by SUNDOG_material).
#[derive(Clone, Debug, PartialEq)]
pub struct Coat {
    /// Its share.
    pub weight: f32,
    /// Factor in R.
    pub texture: Option<Texture>,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Factor in G.
    pub roughness_texture: Option<Texture>,
    /// Index of refraction.
    pub ior: f32,
    /// Colour.
    pub tint: [f32; 3],
    /// Its normals.
    pub normal: CoatNormal,
}

/// Normals of a coat.
#[derive(Clone, Debug, PartialEq)]
pub enum CoatNormal {
    /// Those of what it lies on, with their map (Blender's).
    OfBase,
    /// The surface's own (glTF's).
    Smooth,
    /// A map.
    Map(NormalTexture),
}

/// A layer of fibres (KHR_materials_sheen; the weight is in the colour).
#[derive(Clone, Debug, PartialEq)]
pub struct Sheen {
    /// Its colour.
    pub color: [f32; 3],
    /// RGB, sRGB-encoded in 8- and 16-bit files.
    pub color_texture: Option<Texture>,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Factor in A.
    pub roughness_texture: Option<Texture>,
}

/// A thin film (KHR_materials_iridescence).
#[derive(Clone, Debug, PartialEq)]
pub struct Iridescence {
    /// Its share: the rest of the surface has none.
    pub factor: f32,
    /// Factor in R.
    pub texture: Option<Texture>,
    /// Index of refraction.
    pub ior: f32,
    /// Nanometres where the texture is 0, and where it is 1 or there is none.
    pub thickness: [f32; 2],
    /// From the one to the other in G.
    pub thickness_texture: Option<Texture>,
}

/// Light that is scattered through the surface (KHR_materials_diffuse_transmission).
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseTransmission {
    /// Its share of what is diffuse.
    pub factor: f32,
    /// Factor in A.
    pub texture: Option<Texture>,
    /// Its colour.
    pub color: [f32; 3],
    /// RGB, sRGB-encoded in 8- and 16-bit files.
    pub color_texture: Option<Texture>,
}

/// Highlights that are longer one way.
#[derive(Clone, Debug, PartialEq)]
pub enum Anisotropy {
    /// KHR_materials_anisotropy: along the tangent α grows to 1 by the square of the strength.
    Gltf {
        /// 0..=1.
        strength: f32,
        /// Counter-clockwise from the tangent, radians.
        rotation: f32,
        /// Direction in tangent space in R and G, strength in B.
        texture: Option<Texture>,
    },
    /// Blender's own numbers (SUNDOG_material).
    Blender {
        /// Of a Principled BSDF 0..=1, of a Glossy BSDF -1..=1.
        strength: f32,
        /// Turns.
        rotation: f32,
        /// What the tangent follows.
        tangent: TangentKind,
        /// The set of texture coordinates, if it follows those.
        uv_set: u32,
    },
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

/// A normal map and its strength.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalTexture {
    /// The image: RGB 0..=1 stands for -1..=1 (+Y up, OpenGL's convention).
    pub texture: Texture,
    /// Scales x and y before normalisation.
    pub scale: f32,
}
