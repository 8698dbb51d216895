//! What a scene's parts are when some effects are left out.

use super::detect::kind_of_glass;
use super::sets;
use crate::scene::graph::node::{diffuse, principled};
use crate::scene::graph::{Graph, Input, NodeKind, Opacity, Slot};
use crate::scene::{Effect, Environment, Light, Material};
use enumset::EnumSet;

/// Whether a light of this kind is kept.
pub fn keeps(set: EnumSet<Effect>, light: &Light) -> bool {
    set.contains(light.kind.effect())
}

/// Whether light from all around of this kind is kept.
pub fn keeps_environment(set: EnumSet<Effect>, environment: &Environment) -> bool {
    set.contains(environment.effect())
}

/// A material without the effects that a set lacks: images leave their factors, opacity is 1, glass is opaque, metal a dielectric
/// of its colour, and a dielectric does not reflect. What calls for no more than the set has stays as it is.
pub fn without_effects(material: &Material, set: EnumSet<Effect>) -> Material {
    let mut m = material.clone();
    for slot in Slot::ALL {
        if !set.contains(slot.effect()) {
            // One at a time: what is left has other places in the list afterwards.
            while let Some((_, node, socket)) = textured(&m.graph, slot) {
                m.graph.whiten(node, socket);
            }
        }
    }
    let alpha = match m.summary().opacity {
        Opacity::Full => sets::ALL,
        Opacity::Clip { .. } => EnumSet::only(Effect::AlphaClip),
        Opacity::Blend { .. } => EnumSet::only(Effect::AlphaBlend),
    };
    if set.is_disjoint(alpha) {
        m.graph.make_opaque();
    }
    let mut surfaces = m.summary().principled.into_iter();
    for node in &mut m.graph.nodes {
        let sockets = node.kind.sockets().iter();
        for (input, socket) in node.inputs.iter_mut().zip(sockets) {
            if socket.name.ends_with("Normal") && !set.contains(Effect::NormalMaps) {
                *input = Input::None;
            }
        }
        if node.kind == NodeKind::DiffuseBsdf && !set.contains(Effect::DiffuseRoughness) {
            node.inputs[diffuse::ROUGHNESS] = Input::float(0.0);
        }
        if !set.contains(Effect::Anisotropy)
            && let Some((socket, _)) = node.anisotropy_sockets()
        {
            node.inputs[socket] = Input::float(0.0);
        }
        if !matches!(node.kind, NodeKind::PrincipledBsdf { .. }) {
            continue;
        }
        let mut without = |socket: usize| node.inputs[socket] = Input::float(0.0);
        if let Some(p) = surfaces.next()
            && p.transmission.1 > 0.0
            && !set.contains(kind_of_glass(&p))
        {
            without(principled::TRANSMISSION_WEIGHT);
        }
        if !set.contains(Effect::DiffuseRoughness) {
            without(principled::DIFFUSE_ROUGHNESS);
        }
        if !set.contains(Effect::Coat) {
            without(principled::COAT_WEIGHT);
        }
        if !set.contains(Effect::Sheen) {
            without(principled::SHEEN_WEIGHT);
        }
        if !set.contains(Effect::Metal) {
            without(principled::METALLIC);
        }
        if !set.contains(Effect::Gloss) {
            without(principled::SPECULAR_IOR_LEVEL);
        }
    }
    m.graph.prune();
    m
}

/// A socket of a slot that has images.
fn textured(graph: &Graph, slot: Slot) -> Option<(Slot, usize, usize)> {
    graph.slots().into_iter().find(|&(of, node, socket)| {
        let input = graph.nodes[node].inputs[socket];
        of == slot && graph.textures_behind(input).next().is_some()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::sets;
    use crate::scene::{AlphaMode, ImageId, MetallicRoughness};

    #[test]
    fn what_is_left_out_is_gone_and_the_rest_stays() {
        let glass = Material::from(MetallicRoughness {
            transmission: 1.0,
            thin_walled: false,
            roughness: 0.2,
            metallic: 0.5,
            alpha: 0.2,
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            ..MetallicRoughness::default()
        });
        assert_eq!(without_effects(&glass, sets::ALL), glass);
        let less =
            without_effects(&glass, sets::ALL - Effect::RoughGlass - Effect::AlphaClip).summary();
        let p = less.principled[0];
        assert_eq!(p.transmission.1, 0.0);
        assert_eq!(less.opacity, Opacity::Full);
        assert_eq!((p.metallic.1, p.specular.1), (0.5, 1.0));
        assert_eq!(
            without_effects(&glass, sets::ALL - Effect::ClearGlass),
            glass
        );
        let p = without_effects(&glass, EnumSet::empty())
            .summary()
            .principled[0];
        assert_eq!((p.metallic.1, p.specular.1), (0.0, 0.0));
    }

    #[test]
    fn images_leave_their_factors_and_stay_where_they_are_called_for() {
        let image = Some(ImageId(0).into());
        let m = Material::from(MetallicRoughness {
            base_color: [0.5, 0.25, 1.0],
            base_color_texture: image.clone(),
            metallic: 0.75,
            metallic_roughness_texture: image,
            ..MetallicRoughness::default()
        });
        let plain = without_effects(&m, sets::ALL - Effect::MetallicRoughnessTexture);
        assert!(plain.graph.has_texture(Slot::BaseColor));
        assert!(!plain.graph.has_texture(Slot::MetallicRoughness));
        let p = plain.summary().principled[0];
        assert_eq!((p.metallic, p.roughness), ((0.75, 0.75), (1.0, 1.0)));
        let plain = without_effects(&m, sets::ALL - sets::TEXTURES);
        assert_eq!(plain.graph.textures().count(), 0);
        let base = plain.summary().principled[0].base_color;
        assert_eq!(base.to_array(), [0.5, 0.25, 1.0]);
    }
}
