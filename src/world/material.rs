//! Materials with their textures and tables prepared.

use super::Options;
use super::texture::{PreparedTexture, Raster};
use crate::effects;
use crate::scene::{AlphaMode, ImageUse, Material, Scene, Texture};
use crate::shading::tables::Rows;
use crate::shading::{Dielectrics, Principled, ggx};
use glam::{Vec2, Vec3, Vec4};
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

/// A material ready for rays.
#[derive(Debug)]
pub struct PreparedMaterial {
    base: Principled,
    alpha: f32,
    alpha_mode: AlphaMode,
    /// Emitted radiance before textures.
    pub emission: Vec3,
    /// The scattering part is missing: only emission.
    pub unlit: bool,
    /// Light can pass beside it.
    pub translucent: bool,
    /// Somewhere it is glass.
    lets_through: bool,
    /// Back faces can be hidden.
    pub single_sided: bool,
    /// Tables of its dielectric.
    pub dielectrics: Arc<Dielectrics>,
    base_color_texture: Option<PreparedTexture>,
    metallic_roughness_texture: Option<PreparedTexture>,
    emission_texture: Option<PreparedTexture>,
    specular_texture: Option<PreparedTexture>,
    specular_color_texture: Option<PreparedTexture>,
    transmission_texture: Option<PreparedTexture>,
    /// Normal map and its scale.
    pub normal_texture: Option<(PreparedTexture, f32)>,
}

/// Gives the texture coordinates of a set.
pub trait Coordinates {
    /// Coordinates of a set; (0, 0) where the mesh has none.
    fn uv(&self, set: u32) -> Vec2;
}

/// Makes each raster once.
#[derive(Default)]
pub struct Preparer {
    rasters: HashMap<u32, Arc<Raster>>,
    /// Surfaces may be made rougher than their materials say.
    roughens: bool,
}

/// Bits of the index and of the specular factor, whether a texture varies that, whether the coat and the solid are read, and
/// for which roughnesses.
type Key = (u32, u32, bool, (bool, bool), Rows);

/// So many tables are kept for the next world.
const KEPT: usize = 64;

/// Tables for a material. They take milliseconds to make and depend on nothing else, so that a program that renders one
/// scene after the other makes them once.
fn tables_of(key: Key, make: impl FnOnce() -> Dielectrics) -> Arc<Dielectrics> {
    static TABLES: Mutex<BTreeMap<Key, Arc<Dielectrics>>> = Mutex::new(BTreeMap::new());
    let locked = || TABLES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(tables) = locked().get(&key) {
        return tables.clone();
    }
    // Not while others wait.
    let tables = Arc::new(make());
    let mut kept = locked();
    if kept.len() >= KEPT {
        kept.clear();
    }
    kept.insert(key, tables.clone());
    tables
}

impl Preparer {
    /// `roughens`: surfaces may be made rougher than their materials say.
    pub fn new(roughens: bool) -> Self {
        Self {
            roughens,
            ..Self::default()
        }
    }

    /// Whether the tables of a material's coat and of its solid are read: smooth surfaces need none, nor does what is covered
    /// by metal or glass everywhere (textures scale the factors down).
    fn tables_needed(&self, m: &Material) -> (bool, bool) {
        let rough = self.roughens || m.roughness * m.roughness > ggx::SMOOTH_ALPHA;
        if !rough || m.is_metal_everywhere() || m.unlit {
            return (false, false);
        }
        (
            !m.is_glass_everywhere() && m.specular > 0.0 && m.ior != 1.0,
            m.transmission > 0.0 && !m.thin_walled,
        )
    }

    /// The rows of those tables that are read. Images of floats may hold more than 1.
    fn rows_needed(&self, m: &Material) -> Rows {
        let textured = m.metallic_roughness_texture.is_some();
        Rows::between(
            if textured { 0.0 } else { m.roughness },
            if textured || self.roughens {
                1.0
            } else {
                m.roughness
            },
        )
    }

    fn texture(
        &mut self,
        scene: &Scene,
        texture: Option<&Texture>,
        usage: ImageUse,
    ) -> Option<PreparedTexture> {
        let texture = texture?;
        let image = scene.images.get(texture.image.0 as usize)?;
        let raster = self
            .rasters
            .entry(texture.image.0)
            .or_insert_with(|| Arc::new(Raster::new(image)));
        let space = scene.color_management.working_space;
        Some(PreparedTexture::new(texture, raster.clone(), usage, space))
    }

    /// Prepares a material; `vertex_alpha` if some mesh with it has transparent vertex colours.
    pub fn material(
        &mut self,
        scene: &Scene,
        m: &Material,
        vertex_alpha: bool,
    ) -> PreparedMaterial {
        let needs = self.tables_needed(m);
        let textured = needs.0 && m.specular_texture.is_some();
        let rows = self.rows_needed(m);
        let key = (m.ior.to_bits(), m.specular.to_bits(), textured, needs, rows);
        let dielectrics = tables_of(key, || {
            Dielectrics::needed(m.ior, m.specular, textured, needs, rows)
        });
        let base_color = Vec3::from(m.base_color);
        PreparedMaterial {
            base: Principled {
                base_color,
                metallic: m.metallic,
                roughness: m.roughness,
                ior: m.ior,
                specular: m.specular,
                specular_color: Vec3::from(m.specular_color),
                transmission: m.transmission,
                thin_walled: m.thin_walled,
                ..Principled::default()
            },
            alpha: m.alpha,
            alpha_mode: m.alpha_mode,
            emission: if m.unlit {
                base_color
            } else {
                Vec3::from(m.emission)
            },
            unlit: m.unlit,
            translucent: effects::is_translucent(m, vertex_alpha),
            lets_through: m.transmission > 0.0 && !m.unlit && !m.is_metal_everywhere(),
            single_sided: !m.double_sided,
            dielectrics,
            base_color_texture: self.texture(scene, m.base_color_texture.as_ref(), ImageUse::Color),
            metallic_roughness_texture: self.texture(
                scene,
                m.metallic_roughness_texture.as_ref(),
                ImageUse::Data,
            ),
            emission_texture: self.texture(scene, m.emission_texture.as_ref(), ImageUse::Color),
            specular_texture: self.texture(scene, m.specular_texture.as_ref(), ImageUse::Data),
            specular_color_texture: self.texture(
                scene,
                m.specular_color_texture.as_ref(),
                ImageUse::Color,
            ),
            transmission_texture: self.texture(
                scene,
                m.transmission_texture.as_ref(),
                ImageUse::Data,
            ),
            normal_texture: m
                .normal_texture
                .as_ref()
                .filter(|n| n.scale != 0.0)
                .and_then(|n| {
                    Some((
                        self.texture(scene, Some(&n.texture), ImageUse::Data)?,
                        n.scale,
                    ))
                }),
        }
    }
}

#[inline]
fn read(texture: &Option<PreparedTexture>, at: &impl Coordinates) -> Option<Vec4> {
    texture.as_ref().map(|t| t.read(at.uv(t.uv_set)))
}

/// The colour of what is reflected: files of floats may hold negative ones, which count as 0, as in Cycles. What is not a
/// number stays so, and is counted where it arises.
#[inline]
fn reflected(texel: Vec4) -> Vec3 {
    let color = texel.truncate();
    Vec3::select(color.cmplt(Vec3::ZERO), Vec3::ZERO, color)
}

impl PreparedMaterial {
    /// Whether no ray gets through, nor beside it. By value, so that it is the same with the effects that are called for and
    /// with all: below metal there is no glass.
    pub fn is_opaque(&self) -> bool {
        !self.translucent && !self.lets_through
    }

    /// Whether rays are refracted by it into a solid somewhere.
    pub fn bounds_a_solid(&self) -> bool {
        self.lets_through && !self.base.thin_walled
    }

    /// What the material says at a point.
    #[inline]
    pub fn parameters(&self, at: &impl Coordinates, vertex_color: Vec4) -> Principled {
        let mut p = self.base;
        p.base_color *= vertex_color.truncate();
        if let Some(t) = read(&self.base_color_texture, at) {
            p.base_color *= reflected(t);
        }
        if let Some(t) = read(&self.metallic_roughness_texture, at) {
            p.roughness *= t.y;
            p.metallic *= t.z;
        }
        if let Some(t) = read(&self.specular_texture, at) {
            p.specular *= t.w;
        }
        if let Some(t) = read(&self.specular_color_texture, at) {
            p.specular_color *= reflected(t);
        }
        if let Some(t) = read(&self.transmission_texture, at) {
            p.transmission *= t.x;
        }
        p
    }

    /// What the material says where it has no textures.
    #[inline]
    pub fn constant_parameters(&self) -> Principled {
        self.base
    }

    /// Sets of texture coordinates that its textures read.
    pub fn uv_sets(&self) -> usize {
        let normal = self.normal_texture.as_ref().map(|(texture, _)| texture);
        let textures = [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.emission_texture,
            &self.specular_texture,
            &self.specular_color_texture,
            &self.transmission_texture,
        ];
        let read = textures.into_iter().flatten().chain(normal);
        // Where there are no tangents, those of the first set take their place.
        let bumps = usize::from(normal.is_some());
        read.fold(bumps, |sets, texture| sets.max(texture.uv_set as usize + 1))
    }

    /// Whether [`Self::emitted`] looks at the place.
    pub fn emission_varies(&self) -> bool {
        self.unlit || self.emission_texture.is_some()
    }

    /// Emitted radiance at a point.
    #[inline]
    pub fn emitted(&self, at: &impl Coordinates, vertex_color: Vec4) -> Vec3 {
        if self.emission == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let mut e = self.emission;
        let texture = if self.unlit {
            &self.base_color_texture
        } else {
            &self.emission_texture
        };
        if let Some(t) = read(texture, at) {
            e *= t.truncate();
        }
        if self.unlit {
            e *= vertex_color.truncate();
        }
        e
    }

    /// Opacity at a point, 0..=1; cut-outs are 0 or 1.
    #[inline]
    pub fn opacity(&self, at: &impl Coordinates, vertex_color: Vec4) -> f32 {
        let alpha = || {
            let texture = read(&self.base_color_texture, at).map_or(1.0, |t| t.w);
            (self.alpha * vertex_color.w * texture).clamp(0.0, 1.0)
        };
        match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f32::from(alpha() >= cutoff),
            AlphaMode::Blend => alpha(),
        }
    }
}

/// The materials of a scene, and at last the one of meshes without any.
pub fn prepare(scene: &Scene, options: &Options) -> Vec<Arc<PreparedMaterial>> {
    let mut is_placed = vec![false; scene.meshes.len()];
    for instance in &scene.instances {
        is_placed[instance.mesh.0 as usize] = true;
    }
    let mut vertex_alpha = vec![false; scene.materials.len() + 1];
    let placed = scene.meshes.iter().zip(&is_placed).filter(|(_, p)| **p);
    for (mesh, _) in placed.filter(|_| effects::has(options.effects, effects::VERTEX_COLORS)) {
        let default = scene.materials.len();
        let slot = mesh.material.map_or(default, |m| m.0 as usize);
        if let (Some(colors), Some(v)) = (&mesh.colors, vertex_alpha.get_mut(slot)) {
            *v |= colors.iter().any(|c| c[3] < 1.0);
        }
    }
    let mut preparer = Preparer::new(options.roughens);
    let fallback = Material::default();
    let materials = scene.materials.iter().chain([&fallback]);
    materials
        .zip(&vertex_alpha)
        .map(|(m, &a)| preparer.material(scene, &effects::kept(m, options.effects), a))
        .map(Arc::new)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_below_zero_reflect_nothing() {
        let below = reflected(Vec4::new(-0.25, 0.5, -0.0, -1.0));
        assert_eq!(below, Vec3::new(0.0, 0.5, 0.0));
        assert!(reflected(Vec4::new(f32::NAN, 2.0, 0.0, 1.0)).x.is_nan());
    }
}
