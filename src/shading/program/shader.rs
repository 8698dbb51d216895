//! The shaders of a graph, with the registers that their sockets are read from.

use super::compile::{Compiler, ONE, Source, ZERO, root};
use super::{
    CoatRoots, Evaluation, LayerRoots, Operand, Operation, Place, Root, Shader, Weighted, reflected,
};
use crate::math::primaries::WorkingSpace;
use crate::scene::graph::node::{diffuse, glossy, principled};
use crate::scene::graph::{
    Graph, Input, Lane, Node, NodeKind, ShaderRules, SimpleBsdf, SocketKind, TangentKind,
};
use crate::shading::Principled;
use crate::shading::thin_film::Film;
use glam::Vec3;
use std::cell::RefCell;

/// Whose version a shader follows.
fn rules_of(node: &Node) -> ShaderRules {
    match node.kind {
        NodeKind::PrincipledBsdf { rules, .. } | NodeKind::DiffuseBsdf { rules } => rules,
        _ => ShaderRules::default(),
    }
}

/// The numbers of a Principled BSDF; those of linked sockets are read at hits.
fn principled_numbers(graph: &Graph, at: usize, space: WorkingSpace) -> Principled {
    let node = &graph.nodes[at];
    let color = |socket: usize| match node.inputs[socket] {
        Input::Value(value) => Vec3::from(value),
        _ => Vec3::from(principled::SOCKETS[socket].default),
    };
    Principled {
        base_color: color(principled::BASE_COLOR),
        metallic: color(principled::METALLIC).x,
        roughness: color(principled::ROUGHNESS).x,
        ior: color(principled::IOR).x,
        dispersion: color(principled::DISPERSION).x,
        specular: 2.0 * color(principled::SPECULAR_IOR_LEVEL).x,
        specular_color: color(principled::SPECULAR_TINT),
        transmission: color(principled::TRANSMISSION_WEIGHT).x,
        thin_walled: matches!(
            node.kind,
            NodeKind::PrincipledBsdf {
                thin_wall: true,
                ..
            }
        ),
        edge_tint: matches!(
            node.kind,
            NodeKind::PrincipledBsdf {
                edge_tint: true,
                ..
            }
        ),
        film: Film {
            thickness: color(principled::THIN_FILM_THICKNESS).x,
            ior: color(principled::THIN_FILM_IOR).x,
            space,
        },
        pane: matches!(node.kind, NodeKind::PrincipledBsdf { pane: true, .. }),
        subsurface: color(principled::SUBSURFACE_WEIGHT).x,
        subsurface_anisotropy: color(principled::SUBSURFACE_ANISOTROPY).x,
        subsurface_color: color(principled::SUBSURFACE_COLOR),
        below: match node.kind {
            NodeKind::PrincipledBsdf { walk, .. } => walk,
            _ => None,
        },
        subsurface_radius: color(principled::SUBSURFACE_RADIUS),
        subsurface_scale: color(principled::SUBSURFACE_SCALE).x,
        skin_ior: color(principled::SUBSURFACE_IOR).x,
        rules: rules_of(node),
        once: matches!(node.kind, NodeKind::PrincipledBsdf { once: true, .. }),
        diffuse_roughness: color(principled::DIFFUSE_ROUGHNESS).x,
        anisotropy: color(principled::ANISOTROPIC).x,
        anisotropy_rotation: color(principled::ANISOTROPIC_ROTATION).x,
    }
}

/// Sockets that are read at hits, metallic first: what it hides is not read.
const READ: [usize; 19] = [
    principled::METALLIC,
    principled::BASE_COLOR,
    principled::ROUGHNESS,
    principled::ANISOTROPIC,
    principled::ANISOTROPIC_ROTATION,
    principled::IOR,
    principled::DISPERSION,
    principled::SPECULAR_IOR_LEVEL,
    principled::SPECULAR_TINT,
    principled::TRANSMISSION_WEIGHT,
    principled::DIFFUSE_ROUGHNESS,
    principled::SUBSURFACE_WEIGHT,
    principled::SUBSURFACE_ANISOTROPY,
    principled::SUBSURFACE_COLOR,
    principled::SUBSURFACE_RADIUS,
    principled::SUBSURFACE_SCALE,
    principled::SUBSURFACE_IOR,
    principled::THIN_FILM_THICKNESS,
    principled::THIN_FILM_IOR,
];

/// The tangent of an anisotropic shader. Without a link it is the radial one, as in Cycles.
fn tangent_of<S: Source>(compiler: &mut Compiler<'_, S>, at: usize, socket: usize) -> Option<Root> {
    let node = &compiler.graph.nodes[at];
    if node.is_anisotropic_about_z() {
        let operation = Operation::Tangent {
            kind: TangentKind::Radial,
            direction: ONE,
        };
        return Some(root(Operand::Register(compiler.emit(operation), Lane::Rgb)));
    }
    node.is_anisotropic()
        .then(|| root(compiler.input(at, socket)))
}

/// A shader that is nothing but a lobe.
fn simple<S: Source>(compiler: &mut Compiler<'_, S>, at: usize, bsdf: SimpleBsdf) -> Shader {
    let node = &compiler.graph.nodes[at];
    let tangent = node
        .anisotropy_sockets()
        .and_then(|(_, socket)| tangent_of(compiler, at, socket));
    let (mut sockets, mut normal) = (Vec::new(), None);
    for (number, (socket, input)) in bsdf.sockets().iter().zip(&node.inputs).enumerate() {
        let is_direction = socket.kind == SocketKind::Normal;
        let is_normal = is_direction && socket.name == "Normal";
        // The tangents of anisotropic lobes are apart, those of fibres are sockets as others are.
        let stands_apart = is_direction && !is_normal && !matches!(bsdf, SimpleBsdf::Hair { .. });
        if stands_apart || is_direction && *input == Input::None {
            sockets.push(root(ZERO));
            continue;
        }
        let value = root(compiler.input(at, number));
        if is_normal {
            normal = Some(value);
        }
        sockets.push(value);
    }
    Shader::Simple {
        bsdf,
        sockets,
        normal,
        tangent,
    }
}

/// What lies over a Principled BSDF.
pub(super) fn layers<S: Source>(
    compiler: &mut Compiler<'_, S>,
    at: usize,
) -> Option<Box<LayerRoots>> {
    use principled::{
        COAT_IOR, COAT_NORMAL, COAT_ROUGHNESS, COAT_TINT, COAT_WEIGHT, SHEEN_ROUGHNESS, SHEEN_TINT,
        SHEEN_WEIGHT,
    };
    let node = &compiler.graph.nodes[at];
    let (inputs, rules) = (&node.inputs, rules_of(node));
    let is_there = |weight: usize| inputs[weight] != Input::float(0.0);
    let (coated, has_fibres) = (is_there(COAT_WEIGHT), is_there(SHEEN_WEIGHT));
    let mut value = |socket: usize| root(compiler.input(at, socket));
    let normal = (inputs[COAT_NORMAL] != Input::None).then(|| value(COAT_NORMAL));
    let coat = coated.then(|| CoatRoots {
        weight: value(COAT_WEIGHT),
        roughness: value(COAT_ROUGHNESS),
        ior: value(COAT_IOR),
        tint: value(COAT_TINT),
        normal,
    });
    let fibres = has_fibres.then(|| [SHEEN_WEIGHT, SHEEN_ROUGHNESS, SHEEN_TINT].map(&mut value));
    (coated || has_fibres).then(|| {
        Box::new(LayerRoots {
            coat,
            fibres,
            rules,
        })
    })
}

/// A shader of a graph; `None` of nodes that scatter nothing.
pub(super) fn shader<S: Source>(
    compiler: &mut Compiler<'_, S>,
    at: usize,
    space: WorkingSpace,
) -> Option<Shader> {
    let node = &compiler.graph.nodes[at];
    if let NodeKind::Bsdf(bsdf) = node.kind {
        return Some(simple(compiler, at, bsdf));
    }
    let tangent = match node.kind {
        NodeKind::PrincipledBsdf { .. } => tangent_of(compiler, at, principled::TANGENT),
        NodeKind::GlossyBsdf { .. } => tangent_of(compiler, at, glossy::TANGENT),
        _ => None,
    };
    let (graph, compiler) = (compiler.graph, RefCell::new(compiler));
    let value = |socket: usize| root(compiler.borrow_mut().input(at, socket));
    let vector = |socket: usize| (node.inputs[socket] != Input::None).then(|| value(socket));
    Some(match node.kind {
        NodeKind::PrincipledBsdf { .. } => {
            let normal = vector(principled::NORMAL);
            let linked = READ
                .into_iter()
                .filter(|&socket| node.inputs[socket].link().is_some())
                .map(|socket| (socket, value(socket)))
                .collect();
            let base = principled_numbers(graph, at, space);
            let layers = layers(&mut compiler.borrow_mut(), at);
            Shader::Principled {
                base,
                linked,
                normal,
                tangent,
                layers,
            }
        }
        NodeKind::DiffuseBsdf { rules } => Shader::Diffuse {
            rules,
            normal: vector(diffuse::NORMAL),
            color: value(diffuse::COLOR),
            roughness: value(diffuse::ROUGHNESS),
        },
        NodeKind::GlossyBsdf { distribution } => Shader::Glossy {
            distribution,
            normal: vector(glossy::NORMAL),
            tangent,
            color: value(glossy::COLOR),
            roughness: value(glossy::ROUGHNESS),
            anisotropy: value(glossy::ANISOTROPY),
            rotation: value(glossy::ROTATION),
        },
        _ => return None,
    })
}

/// A number between 0 and 1; what is not a number stays so.
#[inline]
fn share(value: f32) -> f32 {
    value.clamp(0.0, 1.0)
}

/// The sockets of a Principled BSDF at a place. Below metal nothing is read that is not seen.
#[inline]
pub fn parameters<P: Place>(
    base: &Principled,
    linked: &[(usize, Root)],
    at: &mut Evaluation<'_, P>,
) -> Principled {
    let mut p = *base;
    for (socket, root) in linked {
        match *socket {
            principled::METALLIC => p.metallic = share(at.number(root)),
            principled::BASE_COLOR => p.base_color = reflected(at.color(root)),
            principled::ROUGHNESS => p.roughness = share(at.number(root)),
            principled::ANISOTROPIC => p.anisotropy = share(at.number(root)),
            principled::ANISOTROPIC_ROTATION => p.anisotropy_rotation = at.number(root),
            principled::SPECULAR_TINT if p.edge_tint => {
                p.specular_color = reflected(at.color(root));
            }
            principled::THIN_FILM_THICKNESS => p.film.thickness = at.number(root),
            principled::THIN_FILM_IOR => p.film.ior = at.number(root).max(1e-5),
            _ if p.metallic >= 1.0 => {}
            principled::IOR => p.ior = at.number(root).max(1e-4),
            principled::DISPERSION => p.dispersion = at.number(root).clamp(0.0, 1e4),
            principled::SPECULAR_IOR_LEVEL => p.specular = 2.0 * at.number(root).max(0.0),
            principled::SPECULAR_TINT => p.specular_color = reflected(at.color(root)),
            principled::TRANSMISSION_WEIGHT => p.transmission = share(at.number(root)),
            principled::DIFFUSE_ROUGHNESS => p.diffuse_roughness = share(at.number(root)),
            principled::SUBSURFACE_WEIGHT => p.subsurface = share(at.number(root)),
            principled::SUBSURFACE_ANISOTROPY => p.subsurface_anisotropy = at.number(root),
            principled::SUBSURFACE_COLOR => p.subsurface_color = reflected(at.color(root)),
            principled::SUBSURFACE_RADIUS => p.subsurface_radius = at.color(root),
            principled::SUBSURFACE_SCALE => p.subsurface_scale = at.number(root),
            principled::SUBSURFACE_IOR => p.skin_ior = at.number(root),
            _ => {}
        }
    }
    p
}

/// What the program has to compute for a shader.
pub(super) fn roots_of(weighted: &mut Weighted) -> Vec<&mut Root> {
    let Weighted { weight, shader } = weighted;
    let mut roots = vec![weight];
    match shader {
        Shader::Principled {
            linked,
            normal,
            tangent,
            layers,
            ..
        } => {
            roots.extend(linked.iter_mut().map(|(_, root)| root));
            roots.extend(normal.iter_mut().chain(tangent));
            roots.extend(layers.iter_mut().flat_map(|layers| layers.roots()));
        }
        Shader::Diffuse {
            color,
            roughness,
            normal,
            rules: _,
        } => {
            roots.extend([color, roughness]);
            roots.extend(normal);
        }
        Shader::Simple {
            sockets,
            normal,
            tangent,
            ..
        } => roots.extend(sockets.iter_mut().chain(normal).chain(tangent)),
        Shader::Glossy {
            color,
            roughness,
            anisotropy,
            rotation,
            normal,
            tangent,
            ..
        } => {
            roots.extend([color, roughness, anisotropy, rotation]);
            roots.extend(normal.iter_mut().chain(tangent));
        }
    }
    roots
}
