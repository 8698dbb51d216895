//! MaterialX: its standard surfaces as Blender's Principled BSDF.

use super::network::{Found, Network, Term};
use super::preview::{each, seen_through};
use super::source::View;
use super::{materialx_nodes, materialx_surfaces};
use crate::nodes::math::Math;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::node::{emission, principled};
use crate::scene::graph::{
    Input, Link, Node, NodeKind, ShaderRules, Subsurface, TangentKind, WalkMethod,
};

/// The names by which a surface calls the inputs of a Principled BSDF, and its own fallbacks.
struct Names {
    base_weight: (&'static str, f32),
    base_color: &'static str,
    metallic: &'static str,
    diffuse_roughness: &'static str,
    specular_weight: &'static str,
    specular_color: &'static str,
    roughness: (&'static str, f32),
    ior: &'static str,
    anisotropy: &'static str,
    transmission: &'static str,
    transmission_color: &'static str,
    subsurface: &'static str,
    subsurface_color: &'static str,
    subsurface_anisotropy: &'static str,
    coat: &'static str,
    coat_color: &'static str,
    coat_roughness: (&'static str, f32),
    coat_ior: (&'static str, f32),
    coat_normal: &'static str,
    sheen: &'static str,
    sheen_color: &'static str,
    sheen_roughness: (&'static str, f32),
    emission: (&'static str, f32),
    emission_color: (&'static str, f32),
    opacity: &'static str,
    thin_walled: &'static str,
    normal: &'static str,
    film_thickness: (&'static str, f32),
    film_ior: (&'static str, f32),
    film_weight: Option<&'static str>,
}

/// OpenPBR 1.1.
const OPEN_PBR: Names = Names {
    base_weight: ("base_weight", 1.0),
    base_color: "base_color",
    metallic: "base_metalness",
    diffuse_roughness: "base_diffuse_roughness",
    specular_weight: "specular_weight",
    specular_color: "specular_color",
    roughness: ("specular_roughness", 0.3),
    ior: "specular_ior",
    anisotropy: "specular_roughness_anisotropy",
    transmission: "transmission_weight",
    transmission_color: "transmission_color",
    subsurface: "subsurface_weight",
    subsurface_color: "subsurface_color",
    subsurface_anisotropy: "subsurface_scatter_anisotropy",
    coat: "coat_weight",
    coat_color: "coat_color",
    coat_roughness: ("coat_roughness", 0.0),
    coat_ior: ("coat_ior", 1.6),
    coat_normal: "geometry_coat_normal",
    sheen: "fuzz_weight",
    sheen_color: "fuzz_color",
    sheen_roughness: ("fuzz_roughness", 0.5),
    emission: ("emission_luminance", 0.0),
    emission_color: ("emission_color", 1.0),
    opacity: "geometry_opacity",
    thin_walled: "geometry_thin_walled",
    normal: "geometry_normal",
    film_thickness: ("thin_film_thickness", 0.5),
    film_ior: ("thin_film_ior", 1.4),
    film_weight: Some("thin_film_weight"),
};

/// Standard Surface 1.0.1.
const STANDARD: Names = Names {
    base_weight: ("base", 1.0),
    base_color: "base_color",
    metallic: "metalness",
    diffuse_roughness: "diffuse_roughness",
    specular_weight: "specular",
    specular_color: "specular_color",
    roughness: ("specular_roughness", 0.2),
    ior: "specular_IOR",
    anisotropy: "specular_anisotropy",
    transmission: "transmission",
    transmission_color: "transmission_color",
    subsurface: "subsurface",
    subsurface_color: "subsurface_color",
    subsurface_anisotropy: "subsurface_anisotropy",
    coat: "coat",
    coat_color: "coat_color",
    coat_roughness: ("coat_roughness", 0.1),
    coat_ior: ("coat_IOR", 1.5),
    coat_normal: "coat_normal",
    sheen: "sheen",
    sheen_color: "sheen_color",
    sheen_roughness: ("sheen_roughness", 0.3),
    emission: ("emission", 0.0),
    emission_color: ("emission_color", 1.0),
    opacity: "opacity",
    thin_walled: "thin_walled",
    normal: "normal",
    film_thickness: ("thin_film_thickness", 0.0),
    film_ior: ("thin_film_IOR", 1.5),
    film_weight: None,
};

/// The graph of a surface; `None` (and a word) for one of another kind.
pub(super) fn surface(network: &mut Network, shader: &View, id: &str) -> Option<Link> {
    let names = match id {
        "ND_open_pbr_surface_surfaceshader" => &OPEN_PBR,
        "ND_standard_surface_surfaceshader" => &STANDARD,
        "ND_surface_unlit" => return Some(unlit(network, shader)),
        _ => {
            let _ = node(network, shader, id, "out");
            network.complete = false;
            network.report(
                "usd-node",
                crate::scene::Verdict::Lost,
                match id {
                    "" => "surface shader without a name".to_owned(),
                    id => format!("surface shader {id}"),
                },
                "another surface of the material is used, or none",
            );
            return None;
        }
    };
    Some(principled_of(network, shader, names))
}

fn unlit(network: &mut Network, shader: &View) -> Link {
    let strength = network.input_or(shader, "emission", Term::number(1.0));
    let color = network.input_or(shader, "emission_color", Term::color([1.0; 3]));
    let opacity = network.input_or(shader, "opacity", Term::number(1.0));
    let shining = Node::new(NodeKind::Emission)
        .with(emission::COLOR, color.rgb)
        .with(emission::STRENGTH, strength.rgb);
    let shining = network.graph.add(shining);
    seen_through(&mut network.graph, shining, opacity.rgb)
}

fn product(network: &mut Network, a: Term, b: Term) -> Term {
    if a.is(1.0) {
        b
    } else if b.is(1.0) {
        a
    } else {
        each(network, (Math::Multiply, VectorMath::Multiply), &[a, b])
    }
}

fn principled_of(network: &mut Network, shader: &View, names: &Names) -> Link {
    let zero = Term::number(0.0);
    let one = Term::number(1.0);
    let white = Term::color([1.0; 3]);
    let named = |network: &mut Network, (name, fallback): (&str, f32)| {
        network.input_or(shader, name, Term::number(fallback))
    };
    let weight = named(network, names.base_weight);
    let base = network.input_or(shader, names.base_color, Term::color([0.8; 3]));
    let mut base = product(network, weight, base);
    let metallic = network.input_or(shader, names.metallic, zero);
    let specular = network.input_or(shader, names.specular_weight, one);
    let level = product(network, specular, Term::number(0.5));
    let transmission = network.input_or(shader, names.transmission, zero);
    if !transmission.is(0.0) {
        // What goes through has a colour of its own; in a Principled BSDF it is that of the base.
        let through = network.input_or(shader, names.transmission_color, white);
        if through != base {
            base = blend(network, base, through, transmission);
        }
    }
    let subsurface = network.input_or(shader, names.subsurface, zero);
    let thin_wall = network.plain(shader, names.thin_walled) == Some(1.0);
    let walk = (!subsurface.is(0.0) && !thin_wall).then_some(Subsurface {
        method: WalkMethod::RandomWalk,
        never_backward: false,
        diffuse_behind_diffuse: false,
    });
    let mut node = Node::new(NodeKind::PrincipledBsdf {
        thin_wall,
        pane: thin_wall,
        edge_tint: true,
        once: false,
        walk,
        rules: ShaderRules::default(),
    });
    if !subsurface.is(0.0) {
        let color = network.input_or(shader, names.subsurface_color, Term::color([0.8; 3]));
        if color != base {
            base = blend(network, base, color, subsurface);
        }
        node = node
            .with(principled::SUBSURFACE_WEIGHT, subsurface.rgb)
            .with(principled::SUBSURFACE_COLOR, base.rgb);
        let (scale, radius) = radius(network, shader, names);
        let turned = network.input_or(shader, names.subsurface_anisotropy, zero);
        node = node
            .with(principled::SUBSURFACE_SCALE, scale.rgb)
            .with(principled::SUBSURFACE_RADIUS, radius.rgb)
            .with(principled::SUBSURFACE_ANISOTROPY, turned.rgb);
    }
    node = node
        .with(principled::BASE_COLOR, base.rgb)
        .with(principled::METALLIC, metallic.rgb)
        .with(principled::SPECULAR_IOR_LEVEL, level.rgb)
        .with(principled::TRANSMISSION_WEIGHT, transmission.rgb);
    let plain: [(usize, (&str, f32)); 9] = [
        (principled::ROUGHNESS, names.roughness),
        (principled::IOR, (names.ior, 1.5)),
        (
            principled::DIFFUSE_ROUGHNESS,
            (names.diffuse_roughness, 0.0),
        ),
        (principled::ANISOTROPIC, (names.anisotropy, 0.0)),
        (principled::COAT_WEIGHT, (names.coat, 0.0)),
        (principled::COAT_ROUGHNESS, names.coat_roughness),
        (principled::COAT_IOR, names.coat_ior),
        (principled::SHEEN_WEIGHT, (names.sheen, 0.0)),
        (principled::SHEEN_ROUGHNESS, names.sheen_roughness),
    ];
    for (socket, name) in plain {
        let term = named(network, name);
        node = node.with(socket, term.rgb);
    }
    let colors = [
        (principled::SPECULAR_TINT, names.specular_color),
        (principled::COAT_TINT, names.coat_color),
        (principled::SHEEN_TINT, names.sheen_color),
    ];
    for (socket, name) in colors {
        let term = network.input_or(shader, name, white);
        node = node.with(socket, term.rgb);
    }
    node = film(network, shader, names, node);
    let shines = named(network, names.emission);
    let color = named(network, names.emission_color);
    node = node
        .with(principled::EMISSION_COLOR, color.rgb)
        .with(principled::EMISSION_STRENGTH, shines.rgb);
    for (socket, name) in [
        (principled::NORMAL, names.normal),
        (principled::COAT_NORMAL, names.coat_normal),
    ] {
        if let Some(normal) = materialx_surfaces::normal(network, shader, name) {
            node = node.with(socket, normal);
        }
    }
    if node.inputs[principled::ANISOTROPIC] != Input::float(0.0) {
        let tangent = Node::new(NodeKind::Tangent {
            kind: TangentKind::Uv,
        });
        let tangent = network.graph.add(tangent);
        materialx_nodes::follow_uvs(network);
        node = node.with(principled::TANGENT, tangent);
    }
    report_unread(network, shader, &node);
    let opacity = network.input_or(shader, names.opacity, one);
    let shader = network.graph.add(node);
    seen_through(&mut network.graph, shader, opacity.rgb)
}

/// Names the inputs that are not read, where what they belong to is there.
fn report_unread(network: &mut Network, shader: &View, node: &Node) {
    let there = |socket: usize| node.inputs[socket] != Input::float(0.0);
    let mut inputs: Vec<(&str, f32)> = Vec::new();
    if there(principled::TRANSMISSION_WEIGHT) {
        inputs.extend([
            ("transmission_depth", 0.0),
            ("transmission_scatter", 0.0),
            ("transmission_dispersion", 0.0),
            ("transmission_dispersion_scale", 0.0),
            ("transmission_extra_roughness", 0.0),
        ]);
    }
    if there(principled::COAT_WEIGHT) {
        // Without a word OpenPBR's coat darkens what is below; a Principled BSDF's never does.
        inputs.extend([
            ("coat_darkening", 0.0),
            ("coat_affect_color", 0.0),
            ("coat_affect_roughness", 0.0),
            ("coat_anisotropy", 0.0),
            ("coat_roughness_anisotropy", 0.0),
        ]);
    }
    if there(principled::ANISOTROPIC) {
        inputs.extend([
            ("specular_rotation", 0.0),
            ("tangent", f32::NAN),
            ("geometry_tangent", f32::NAN),
        ]);
    }
    materialx_surfaces::report_unread(network, shader, &inputs);
}

/// The first, by so much the second.
fn blend(network: &mut Network, first: Term, second: Term, factor: Term) -> Term {
    if factor.is(1.0) {
        return second;
    }
    materialx_nodes::mixed(network, second, first, factor)
}

/// How far light goes below the surface: a length in metres and its share of each colour.
fn radius(network: &mut Network, shader: &View, names: &Names) -> (Term, Term) {
    let (length, share, white) = if names.film_weight.is_some() {
        let radius = Term::color([1.0, 0.5, 0.25]);
        ("subsurface_radius", "subsurface_radius_scale", radius)
    } else {
        (
            "subsurface_scale",
            "subsurface_radius",
            Term::color([1.0; 3]),
        )
    };
    let scale = network.input_or(shader, length, Term::number(1.0));
    let radius = network.input_or(shader, share, white);
    let unit = Term::number(metres(network));
    (product(network, scale, unit), radius)
}

/// Metres of a length in a material: it counts the stage's units. Blender writes metres into stages of all units.
fn metres(network: &Network) -> f32 {
    let source = network
        .source
        .filter(|source| super::blender_version(source).is_none());
    source.map_or(1.0, |source| source.meters_per_unit() as f32)
}

/// A thin film: its thickness in nanometres.
fn film(network: &mut Network, shader: &View, names: &Names, node: Node) -> Node {
    let (name, fallback) = names.film_thickness;
    let thickness = network.input_or(shader, name, Term::number(fallback));
    let thickness = match names.film_weight {
        // OpenPBR counts in micrometres, and has a weight; half a film is one of half the thickness.
        Some(weight) => {
            let weight = network.input_or(shader, weight, Term::number(0.0));
            if weight.is(0.0) {
                return node;
            }
            let thickness = product(network, thickness, Term::number(1000.0));
            product(network, thickness, weight)
        }
        None => thickness,
    };
    let (name, fallback) = names.film_ior;
    let ior = network.input_or(shader, name, Term::number(fallback));
    node.with(principled::THIN_FILM_THICKNESS, thickness.rgb)
        .with(principled::THIN_FILM_IOR, ior.rgb)
}

/// What a node of MaterialX gives.
pub(super) fn node(network: &mut Network, shader: &View, id: &str, output: &str) -> Option<Term> {
    let name = id.strip_prefix("ND_")?;
    if let Some(preview) = name.strip_prefix("Usd") {
        let preview = preview.split('_').next().unwrap_or_default();
        let id = match preview {
            "PrimvarReader" => name.to_owned(),
            other => format!("Usd{other}"),
        };
        return super::preview::node(network, shader, &id, output);
    }
    materialx_nodes::node(network, shader, name, output)
}

/// Whether an input is connected to a node.
pub(super) fn is_connected(network: &mut Network, shader: &View, input: &str) -> bool {
    matches!(network.find(shader, input), Found::Node(..))
}
