//! What a scene's parts are when some effects are left out.

use super::detect::kind_of_glass;
use super::sets;
use crate::scene::graph::node::{diffuse, principled, subsurface};
use crate::scene::graph::{
    Graph, Input, Node, NodeKind, Opacity, ShaderRules, SimpleBsdf, Slot, SocketKind,
};
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

/// A material without the effects that a set lacks: images leave their factors, patterns a grey of 0.5, opacity is 1, glass is opaque, metal a dielectric
/// of its colour, and a dielectric does not reflect. What calls for no more than the set has stays as it is.
pub fn without_effects(material: &Material, set: EnumSet<Effect>) -> Material {
    let mut m = material.clone();
    m.medium = m
        .medium
        .filter(|medium| medium.effect().is_some_and(|effect| set.contains(effect)));
    if !set.contains(Effect::NestedDielectrics) {
        m.priority = None;
    }
    for slot in Slot::ALL {
        if !set.contains(slot.effect()) {
            // One at a time: what is left has other places in the list afterwards.
            while let Some((_, node, socket)) = textured(&m.graph, slot) {
                m.graph.whiten(node, socket);
            }
        }
    }
    m.graph.make_grey(|texture| !set.contains(texture.effect()));
    let alpha = match m.summary().opacity {
        Opacity::Full => sets::ALL,
        Opacity::Clip { .. } => EnumSet::only(Effect::AlphaClip),
        Opacity::Blend { .. } => EnumSet::only(Effect::AlphaBlend),
    };
    if set.is_disjoint(alpha) {
        m.graph.make_opaque();
    }
    let mut surfaces = m.summary().principled.into_iter();
    if !set.contains(Effect::NormalMaps) {
        m.graph.normal = None;
    }
    for node in &mut m.graph.nodes {
        let sockets = node.kind.sockets().iter();
        // Nodes of values that ask for a normal are no normal maps.
        let is_shader = node.kind.outputs().first().map(|o| o.0) == Some(SocketKind::Shader);
        for (input, socket) in node.inputs.iter_mut().zip(sockets) {
            let is_normal = is_shader && socket.name.ends_with("Normal");
            if is_normal && !set.contains(Effect::NormalMaps) {
                *input = Input::None;
            }
        }
        if matches!(node.kind, NodeKind::DiffuseBsdf { .. })
            && !set.contains(Effect::DiffuseRoughness)
        {
            node.inputs[diffuse::ROUGHNESS] = Input::float(0.0);
        }
        if !set.contains(Effect::Anisotropy)
            && let Some((socket, _)) = node.anisotropy_sockets()
        {
            node.inputs[socket] = Input::float(0.0);
        }
        if let NodeKind::Bsdf(bsdf) = node.kind
            && !set.contains(node.simple_effect(bsdf))
        {
            let mut instead = Node::new(NodeKind::DiffuseBsdf {
                rules: ShaderRules::default(),
            })
            .with(diffuse::COLOR, 0.0);
            if let SimpleBsdf::Subsurface(_) = bsdf {
                instead.inputs[diffuse::COLOR] = node.inputs[subsurface::COLOR];
                instead.inputs[diffuse::NORMAL] = node.inputs[subsurface::NORMAL];
            }
            *node = instead;
        }
        if !set.contains(Effect::ThinFilm)
            && let Some(socket) = node.film_socket()
        {
            node.inputs[socket] = Input::float(0.0);
        }
        let NodeKind::PrincipledBsdf { walk, .. } = &mut node.kind else {
            continue;
        };
        let effect_below = match walk {
            Some(_) => Effect::Subsurface,
            None => Effect::DiffuseTransmission,
        };
        if !set.contains(Effect::Subsurface) {
            *walk = None;
        }
        let mut without = |socket: usize| node.inputs[socket] = Input::float(0.0);
        if let Some(p) = surfaces.next()
            && p.transmission.1 > 0.0
            && !set.contains(kind_of_glass(&p))
        {
            without(principled::TRANSMISSION_WEIGHT);
        }
        if !set.contains(Effect::Dispersion) {
            without(principled::DISPERSION);
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
        if !set.contains(effect_below) {
            without(principled::SUBSURFACE_WEIGHT);
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
#[path = "../../tests/unit/effects/without.rs"]
mod tests;
