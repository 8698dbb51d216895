//! What a scene's parts are when some effects are left out.

use super::detect::kind_of_glass;
use super::mask::{self, Mask, has};
use super::table::row;
use crate::scene::{AlphaMode, Effect, Environment, Light, Material};

/// Whether a light of this kind is kept.
pub fn keeps(set: Mask, light: &Light) -> bool {
    keeps_effect(set, light.kind.effect())
}

/// Whether light from all around of this kind is kept.
pub fn keeps_environment(set: Mask, environment: &Environment) -> bool {
    keeps_effect(set, environment.effect())
}

fn keeps_effect(set: Mask, effect: Effect) -> bool {
    has(set, row(effect).bit)
}

/// A material without the effects that a set lacks: images leave their factors, opacity is 1, glass is opaque, metal a dielectric
/// of its colour, and a dielectric does not reflect. What calls for no more than the set has stays as it is.
pub fn kept(material: &Material, set: Mask) -> Material {
    let mut m = material.clone();
    let textures = [
        (mask::BASE_COLOR_TEXTURE, &mut m.base_color_texture),
        (
            mask::METALLIC_ROUGHNESS_TEXTURE,
            &mut m.metallic_roughness_texture,
        ),
        (mask::EMISSION_TEXTURE, &mut m.emission_texture),
        (mask::SPECULAR_TEXTURE, &mut m.specular_texture),
        (mask::SPECULAR_COLOR_TEXTURE, &mut m.specular_color_texture),
        (mask::TRANSMISSION_TEXTURE, &mut m.transmission_texture),
    ];
    for (effect, texture) in textures {
        if !has(set, effect) {
            *texture = None;
        }
    }
    if !has(set, mask::NORMAL_MAPS) {
        m.normal_texture = None;
    }
    let alpha = match m.alpha_mode {
        AlphaMode::Opaque => mask::ALL,
        AlphaMode::Mask { .. } => mask::ALPHA_CLIP,
        AlphaMode::Blend => mask::ALPHA_BLEND,
    };
    if !has(set, alpha) {
        m.alpha_mode = AlphaMode::Opaque;
    }
    if m.transmission > 0.0 && !keeps_effect(set, kind_of_glass(&m)) {
        m.transmission = 0.0;
    }
    if !has(set, mask::METAL) {
        m.metallic = 0.0;
    }
    if !has(set, mask::GLOSS) {
        m.specular = 0.0;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_gone_and_the_rest_stays() {
        let glass = Material {
            transmission: 1.0,
            thin_walled: false,
            roughness: 0.2,
            metallic: 0.5,
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            ..Material::default()
        };
        let same = |a: &Material, b: &Material| format!("{a:?}") == format!("{b:?}");
        assert!(same(&kept(&glass, mask::ALL), &glass));
        let less = kept(&glass, mask::ALL & !mask::ROUGH_GLASS & !mask::ALPHA_CLIP);
        assert_eq!(less.transmission, 0.0);
        assert_eq!(less.alpha_mode, AlphaMode::Opaque);
        assert_eq!((less.metallic, less.specular), (0.5, 1.0));
        assert!(same(&kept(&glass, mask::ALL & !mask::CLEAR_GLASS), &glass));
        let plain = kept(&glass, 0);
        assert_eq!((plain.metallic, plain.specular), (0.0, 0.0));
    }
}
