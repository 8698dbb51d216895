//! MaterialX: surfaces other than its two standard ones, and what is not read of those.

use openusd::sdf::Path;

use super::network::{Found, Network, Term};
use super::preview::{each, principled, seen_through};
use super::source::View;
use crate::nodes::math::Math;
use crate::nodes::vector_math::VectorMath;
use crate::scene::Verdict;
use crate::scene::graph::node::{mix_shader, principled};
use crate::scene::graph::{Input, Link, Node, NodeKind};

/// Surfaces in surfaces: more are a circle.
const DEEPEST: usize = 16;

/// The graph of a surface of any kind that is read, so many levels deep in others.
pub(super) fn any(network: &mut Network, shader: &View, depth: usize) -> Option<Link> {
    let id = shader.word("info:id").unwrap_or_default();
    match &*id {
        "UsdPreviewSurface" | "ND_UsdPreviewSurface_surfaceshader" => {
            Some(super::preview::surface(network, shader))
        }
        "ND_gltf_pbr_surfaceshader" => Some(gltf(network, shader)),
        "ND_mix_surfaceshader" if depth < DEEPEST => mixed(network, shader, depth),
        _ => super::materialx::surface(network, shader, &id),
    }
}

/// Two surfaces, by so much the first.
fn mixed(network: &mut Network, shader: &View, depth: usize) -> Option<Link> {
    let mut of = |name: &str| {
        let Found::Node(path, _) = network.find(shader, name) else {
            network.complete = false;
            network.report(
                "usd-node",
                Verdict::Lost,
                "mixed surfaces of which one is missing".into(),
                "another surface of the material is used, or none",
            );
            return None;
        };
        let inner = network.source?.view(&path);
        any(network, &inner, depth + 1)
    };
    let (first, second) = (of("fg")?, of("bg")?);
    let share = network.input_or(shader, "mix", Term::number(0.0));
    let node = Node::new(NodeKind::MixShader)
        .with(mix_shader::FACTOR, share.rgb)
        .with(mix_shader::A, second)
        .with(mix_shader::B, first);
    Some(network.graph.add(node))
}

/// glTF's surface, as MaterialX has it.
fn gltf(network: &mut Network, shader: &View) -> Link {
    let number = |network: &mut Network, name: &str, fallback: f32| {
        network.input_or(shader, name, Term::number(fallback))
    };
    let white = Term::color([1.0; 3]);
    let mut node = principled();
    for (socket, name, fallback) in [
        (principled::METALLIC, "metallic", 1.0),
        (principled::ROUGHNESS, "roughness", 1.0),
        (principled::IOR, "ior", 1.5),
        (principled::TRANSMISSION_WEIGHT, "transmission", 0.0),
        (principled::COAT_WEIGHT, "clearcoat", 0.0),
        (principled::COAT_ROUGHNESS, "clearcoat_roughness", 0.0),
        (principled::SHEEN_ROUGHNESS, "sheen_roughness", 0.0),
        (principled::EMISSION_STRENGTH, "emissive_strength", 1.0),
    ] {
        let term = number(network, name, fallback);
        node = node.with(socket, term.rgb);
    }
    let black = Term::color([0.0; 3]);
    let sheen = network.input_or(shader, "sheen_color", black);
    for (socket, name, fallback) in [
        (principled::BASE_COLOR, "base_color", white),
        (principled::SPECULAR_TINT, "specular_color", white),
        (principled::EMISSION_COLOR, "emissive", black),
    ] {
        let term = network.input_or(shader, name, fallback);
        node = node.with(socket, term.rgb);
    }
    let multiply = (Math::Multiply, VectorMath::Multiply);
    let specular = number(network, "specular", 1.0);
    let level = each(network, multiply, &[specular, Term::number(0.5)]);
    node = node
        .with(principled::SPECULAR_IOR_LEVEL, level.rgb)
        .with(principled::SHEEN_TINT, sheen.rgb)
        .with(
            principled::SHEEN_WEIGHT,
            if sheen.is(0.0) { 0.0 } else { 1.0 },
        );
    let film = number(network, "iridescence", 0.0);
    if !film.is(0.0) {
        // Half a film is one of half the thickness, as of OpenPBR.
        let thickness = number(network, "iridescence_thickness", 100.0);
        let thickness = each(network, multiply, &[thickness, film]);
        let ior = number(network, "iridescence_ior", 1.3);
        node = node
            .with(principled::THIN_FILM_THICKNESS, thickness.rgb)
            .with(principled::THIN_FILM_IOR, ior.rgb);
    }
    for (socket, name) in [
        (principled::NORMAL, "normal"),
        (principled::COAT_NORMAL, "clearcoat_normal"),
    ] {
        if let Some(normal) = normal(network, shader, name) {
            node = node.with(socket, normal);
        }
    }
    report_unread(
        network,
        shader,
        &[
            ("thickness", 0.0),
            ("attenuation_distance", f32::INFINITY),
            ("anisotropy_strength", 0.0),
        ],
    );
    let opacity = number(network, "alpha", 1.0).rgb;
    let opacity = match network.plain(shader, "alpha_mode") {
        Some(1.0) => {
            let cutoff = number(network, "alpha_cutoff", 0.5);
            let hole = network.math(Math::LessThan, &[opacity, cutoff.rgb]);
            network.math(Math::Subtract, &[Input::float(1.0), hole])
        }
        Some(2.0) => opacity,
        _ => Input::float(1.0),
    };
    let shader = network.graph.add(node);
    seen_through(&mut network.graph, shader, opacity)
}

/// The node at an input of a surface, behind such as leave a direction what it is; and its name.
fn direction(network: &mut Network, shader: &View, input: &str) -> Option<(Path, String, String)> {
    let source = network.source?;
    let mut at = network.find(shader, input);
    for _ in 0..DEEPEST {
        let Found::Node(path, output) = at else {
            return None;
        };
        let node = source.view(&path);
        let id = node.word("info:id").unwrap_or_default();
        let same = match &*id {
            "ND_normalize_vector3" => true,
            "ND_rotate3d_vector3" => network.plain(&node, "amount").unwrap_or(0.0) == 0.0,
            _ => false,
        };
        if !same {
            return Some((path, output, id));
        }
        at = network.find(&node, "in");
    }
    None
}

/// The normal that a surface is given, in Blender's axes; none where it is the surface's own.
pub(super) fn normal(network: &mut Network, shader: &View, name: &str) -> Option<Link> {
    let (path, output, id) = direction(network, shader, name)?;
    if id == "ND_normal_vector3" {
        return None;
    }
    let normal = network.node(&path, &output)?.rgb.link()?;
    // A normal map is in Blender's axes already.
    if id.starts_with("ND_normalmap") {
        return Some(normal);
    }
    Some(super::materialx_places::in_blender(network, normal))
}

/// Names inputs that a surface has and that are not read, where they are not what they are without a word.
pub(super) fn report_unread(network: &mut Network, shader: &View, inputs: &[(&str, f32)]) {
    for (name, without) in inputs {
        let counts = match network.find(shader, name) {
            Found::Nothing => false,
            Found::Value(value) => Term::of(&value).is_some_and(|term| !term.is(*without)),
            // Tangents follow the coordinates anyhow.
            Found::Node(..) => {
                direction(network, shader, name).is_none_or(|(_, _, id)| id != "ND_tangent_vector3")
            }
        };
        if counts {
            network.report(
                "usd-input",
                Verdict::Lost,
                format!("input {name} of a MaterialX surface"),
                "it is as if the material did not have it",
            );
        }
    }
}
