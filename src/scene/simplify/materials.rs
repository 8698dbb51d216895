//! Materials whose images are factors in truth, or are not seen.

use super::images;
use crate::math::primaries::WorkingSpace;
use crate::scene::{
    AlphaMode, Effect, Image, ImageUse, LeftOut, Material, MaterialId, NormalTexture, Pixels,
    Scene, Texture, decoded,
};
use glam::{BVec4A, Vec4};
use std::collections::HashMap;

const RGB: BVec4A = BVec4A::new(true, true, true, false);
const RGBA: BVec4A = BVec4A::new(true, true, true, true);
const R: BVec4A = BVec4A::new(true, false, false, false);
const G: BVec4A = BVec4A::new(false, true, false, false);
const B: BVec4A = BVec4A::new(false, false, true, false);
const GB: BVec4A = BVec4A::new(false, true, true, false);
const A: BVec4A = BVec4A::new(false, false, false, true);

const BY_FACTOR: &str = "the factor of the image is 0";
const FOLDED: &str = "the image is the same everywhere and becomes a factor";
const ALL_METAL: &str = "not seen on a surface that is all metal";
const ALL_GLASS: &str = "not seen on a surface that is all glass";
const UNLIT: &str = "not seen on an unlit surface";

/// One material on its way.
struct Folding<'a> {
    images: &'a [Image],
    answers: &'a mut images::Answers,
    left_out: &'a mut Vec<LeftOut>,
    name: String,
    /// Some mesh with the material has vertices that are not opaque.
    vertex_alpha: bool,
    /// Of the scene's colours.
    space: WorkingSpace,
}

impl<'a> Folding<'a> {
    fn image(&self, texture: &Texture) -> Option<&'a Image> {
        self.images.get(texture.image.0 as usize)
    }

    fn tell(&mut self, effect: Effect, why: &'static str) {
        LeftOut::add(self.left_out, effect, why, &self.name, 0);
    }

    /// Takes a texture away, unless a value of it is not finite: that times nothing is not nothing.
    fn drop(&mut self, slot: &mut Option<Texture>, effect: Effect, why: &'static str) {
        let Some(texture) = slot.as_ref() else {
            return;
        };
        if self.image(texture).is_some_and(images::is_finite) {
            *slot = None;
            self.tell(effect, why);
        }
    }

    /// The value that a texture has everywhere in some channels, as look-ups give it: interpolating what is the same gives
    /// the same bits.
    fn constant(
        &mut self,
        slot: Option<&Texture>,
        usage: ImageUse,
        channels: BVec4A,
    ) -> Option<Vec4> {
        let texture = slot?;
        let (id, image) = (texture.image, self.image(texture)?);
        // Weighted by opacity, colours are rounded once more, and there are none where there is no opacity.
        if texture.sampler.weighted && self.answers.least_alpha(id, image) != Some(1.0) {
            return None;
        }
        let value = self.answers.constant(id, image, channels)?;
        let value = if image.pixels.is_encoded(usage) {
            let linear = decoded(value);
            match self.space.matrix_from_rec709() {
                None => linear,
                Some(matrix) => (matrix.as_mat3() * linear.truncate()).extend(linear.w),
            }
        } else {
            value
        };
        // Files of floats may hold what no factor may be.
        let legal = value.cmpge(Vec4::ZERO) & value.cmple(Vec4::ONE);
        (legal | !channels).all().then_some(value)
    }

    /// Folds the colours of a texture into a factor.
    fn fold_color(&mut self, slot: &mut Option<Texture>, factor: &mut [f32; 3], effect: Effect) {
        if let Some(value) = self.constant(slot.as_ref(), ImageUse::Color, RGB) {
            multiply(factor, value);
            *slot = None;
            self.tell(effect, FOLDED);
        }
    }

    /// Folds one channel of a texture into a factor.
    fn fold_channel(
        &mut self,
        slot: &mut Option<Texture>,
        factor: &mut f32,
        (channel, index): (BVec4A, usize),
        effect: Effect,
    ) {
        if let Some(value) = self.constant(slot.as_ref(), ImageUse::Data, channel) {
            *factor *= value[index];
            *slot = None;
            self.tell(effect, FOLDED);
        }
    }

    fn normal_map(&mut self, m: &mut Material) {
        let Some(normal) = &m.normal_texture else {
            return;
        };
        let why = if normal.scale == 0.0 {
            "the strength of the map is 0"
        } else if self.is_flat(normal) {
            "the map is flat everywhere"
        } else {
            return;
        };
        m.normal_texture = None;
        self.tell(Effect::NormalMaps, why);
    }

    /// Whether a normal map is flat as far as its bits can say: 0 lies between two codes, and half a step of 8 bits is 0.22°.
    fn is_flat(&self, normal: &NormalTexture) -> bool {
        let Some(image) = self.image(&normal.texture) else {
            return false;
        };
        let half_step = match image.pixels {
            Pixels::U8(_) => 0.5 / 255.0,
            Pixels::U16(_) => 0.5 / 65_535.0,
            Pixels::F32(_) => 0.0,
        };
        // A strength above 1 makes the half step larger than what the bits leave open. The slack is for its rounding.
        let most = half_step * (1.0 + 1e-3);
        let flat = |t: Vec4| (t.x - 0.5).abs() <= most && (t.y - 0.5).abs() <= most && t.z > 0.75;
        normal.scale.abs() <= 1.0 && images::is_whole(image) && image.texels().all(flat)
    }

    /// Makes a material opaque whose opacity is 1 wherever it is asked for.
    fn opacity(&mut self, m: &mut Material) {
        let effect = match m.alpha_mode {
            AlphaMode::Opaque => return,
            AlphaMode::Mask { .. } => Effect::AlphaClip,
            AlphaMode::Blend => Effect::AlphaBlend,
        };
        if self.vertex_alpha {
            return;
        }
        let least = match &m.base_color_texture {
            None => Some(1.0),
            Some(texture) => {
                let image = self.image(texture);
                image.and_then(|image| self.answers.least_alpha(texture.image, image))
            }
        };
        let Some(least) = least else {
            return;
        };
        let why = match m.alpha_mode {
            // Three interpolations and two products of numbers up to 1, each of at most two roundings.
            AlphaMode::Mask { cutoff } if m.alpha * least - 10.0 * f32::EPSILON >= cutoff => {
                "opacity is above the threshold everywhere"
            }
            AlphaMode::Mask { cutoff } if m.alpha * least >= 1.0 && cutoff <= 1.0 => {
                "opacity is above the threshold everywhere"
            }
            AlphaMode::Blend if m.alpha >= 1.0 && least >= 1.0 => "opacity is 1 everywhere",
            _ => return,
        };
        m.alpha_mode = AlphaMode::Opaque;
        self.tell(effect, why);
    }

    fn base_color(&mut self, m: &mut Material) {
        self.opacity(m);
        let slot = &mut m.base_color_texture;
        if m.alpha_mode != AlphaMode::Opaque {
            if let Some(value) = self.constant(slot.as_ref(), ImageUse::Color, RGBA) {
                multiply(&mut m.base_color, value);
                m.alpha *= value.w;
                *slot = None;
                self.tell(Effect::BaseColorTexture, FOLDED);
                self.opacity(m);
            }
        } else if m.base_color == [0.0; 3] {
            self.drop(slot, Effect::BaseColorTexture, BY_FACTOR);
        } else {
            self.fold_color(slot, &mut m.base_color, Effect::BaseColorTexture);
        }
    }

    fn emission(&mut self, m: &mut Material) {
        let effect = Effect::EmissionTexture;
        if m.emission == [0.0; 3] {
            self.drop(&mut m.emission_texture, effect, BY_FACTOR);
        } else {
            self.fold_color(&mut m.emission_texture, &mut m.emission, effect);
        }
    }

    fn metal_and_roughness(&mut self, m: &mut Material) {
        let effect = Effect::MetallicRoughnessTexture;
        let slot = &mut m.metallic_roughness_texture;
        let needed = match (m.roughness > 0.0, m.metallic > 0.0) {
            (false, false) => return self.drop(slot, effect, BY_FACTOR),
            (true, false) => G,
            (false, true) => B,
            (true, true) => GB,
        };
        if !slot
            .as_ref()
            .and_then(|texture| self.image(texture))
            .is_some_and(images::is_finite)
        {
            return;
        }
        if let Some(value) = self.constant(slot.as_ref(), ImageUse::Data, needed) {
            // Of 0 it stays 0.
            m.roughness *= value.y;
            m.metallic *= value.z;
            *slot = None;
            self.tell(effect, FOLDED);
        }
    }

    fn transmission(&mut self, m: &mut Material) {
        let effect = Effect::TransmissionTexture;
        let slot = &mut m.transmission_texture;
        if m.transmission == 0.0 {
            self.drop(slot, effect, BY_FACTOR);
        } else {
            self.fold_channel(slot, &mut m.transmission, (R, 0), effect);
        }
    }

    fn specular(&mut self, m: &mut Material) {
        let effect = Effect::SpecularTexture;
        let slot = &mut m.specular_texture;
        if m.specular == 0.0 {
            self.drop(slot, effect, BY_FACTOR);
        } else {
            self.fold_channel(slot, &mut m.specular, (A, 3), effect);
        }
        let effect = Effect::SpecularColorTexture;
        let slot = &mut m.specular_color_texture;
        // Glass is tinted by it whatever the strength.
        let seen = m.specular > 0.0 || m.transmission > 0.0;
        if m.specular_color == [0.0; 3] || !seen {
            self.drop(slot, effect, BY_FACTOR);
        } else {
            self.fold_color(slot, &mut m.specular_color, effect);
        }
    }

    /// Images of what is below the metal, or of what no light falls on.
    fn hidden(&mut self, m: &mut Material, why: &'static str) {
        self.drop(&mut m.specular_texture, Effect::SpecularTexture, why);
        let tint = &mut m.specular_color_texture;
        self.drop(tint, Effect::SpecularColorTexture, why);
        let transmission = &mut m.transmission_texture;
        self.drop(transmission, Effect::TransmissionTexture, why);
    }

    fn material(&mut self, m: &mut Material) {
        self.base_color(m);
        self.normal_map(m);
        if m.unlit {
            let metal = &mut m.metallic_roughness_texture;
            self.drop(metal, Effect::MetallicRoughnessTexture, UNLIT);
            self.drop(&mut m.emission_texture, Effect::EmissionTexture, UNLIT);
            return self.hidden(m, UNLIT);
        }
        self.emission(m);
        self.metal_and_roughness(m);
        if m.is_metal_everywhere() {
            return self.hidden(m, ALL_METAL);
        }
        self.transmission(m);
        if m.is_glass_everywhere() {
            self.drop(&mut m.specular_texture, Effect::SpecularTexture, ALL_GLASS);
        }
        self.specular(m);
    }
}

fn multiply(factor: &mut [f32; 3], value: Vec4) {
    for (factor, value) in factor.iter_mut().zip(value.to_array()) {
        *factor *= value;
    }
}

/// Makes factors of images that are the same everywhere, and takes away what is not seen.
pub fn fold(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let mut vertex_alpha = vec![false; scene.materials.len()];
    for mesh in &scene.meshes {
        let translucent = mesh.colors.iter().flatten().any(|c| c[3] != 1.0);
        if let Some(id) = mesh.material.filter(|_| translucent)
            && let Some(has) = vertex_alpha.get_mut(id.0 as usize)
        {
            *has = true;
        }
    }
    let mut answers = images::Answers::default();
    for (material, &vertex_alpha) in scene.materials.iter_mut().zip(&vertex_alpha) {
        let mut folding = Folding {
            images: &scene.images,
            answers: &mut answers,
            left_out,
            name: material.name.clone(),
            vertex_alpha,
            space: scene.color_management.working_space,
        };
        folding.material(material);
    }
}

/// Makes one of materials that differ in nothing but their names.
pub fn join(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let mut known: HashMap<String, u32> = HashMap::new();
    let mut firsts = Vec::with_capacity(scene.materials.len());
    for (number, material) in scene.materials.iter().enumerate() {
        let number = number as u32;
        let nameless = Material {
            name: String::new(),
            ..material.clone()
        };
        // The shortest decimals that tell a float from all others: the same text, the same bits.
        let first = *known.entry(format!("{nameless:?}")).or_insert(number);
        if first != number {
            let why = "materials identical to others";
            LeftOut::add(left_out, None, why, &material.name, 0);
        }
        firsts.push(MaterialId(first));
    }
    for id in scene
        .meshes
        .iter_mut()
        .filter_map(|mesh| mesh.material.as_mut())
    {
        if let Some(&first) = firsts.get(id.0 as usize) {
            *id = first;
        }
    }
    // What is left over has been told.
    super::unused::forget_materials(scene, &firsts);
}
