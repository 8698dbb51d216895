//! Graphs without what changes nothing: constants are folded, branches that are not seen are gone.

use super::function::bump;
use super::node::{LAYERS, glass, glossy, math, metallic, mix, mix_shader, normal_map, principled};
use super::{
    Blend, Facts, Function, Graph, Input, Lane, Legal, Link, MathOperation, Node, NodeKind, Range,
    SimpleBsdf, SocketKind, Unit,
};

/// Folds what is the same everywhere, and takes out what is not seen, as far as the facts say.
///
/// By value and bit for bit: what is left gives the same numbers, linked ones of Principled BSDFs brought into the ranges of their sockets. A surface that is not there at all keeps what it would be.
pub fn fold(graph: &mut Graph, facts: &mut impl Facts) {
    // What images leave when they go: their factors.
    let factors = graph.results(&mut Unit {
        vertex_alpha: false,
    });
    let taken = graph.taken();
    let mut results: Vec<Range> = Vec::with_capacity(graph.nodes.len());
    let mut instead: Vec<Option<Input>> = vec![None; graph.nodes.len()];
    for at in 0..graph.nodes.len() {
        let sockets = graph.nodes[at].kind.sockets();
        for (place, socket) in sockets.iter().enumerate() {
            let mut input = graph.nodes[at].inputs[place];
            let was_linked = input.link().is_some();
            if let Input::Link(link) = input {
                let other = instead[link.node as usize].unwrap_or(input);
                // Sockets of values do not take the surface's own normal by themselves, and make other numbers of a colour than of a normal.
                let is_value = matches!(
                    socket.kind,
                    SocketKind::Float | SocketKind::Color | SocketKind::Vector
                );
                let of_bump = is_bump(&graph.node(link).kind);
                if !is_value || other != Input::None && !of_bump {
                    input = other;
                }
            }
            if matches!(
                socket.kind,
                SocketKind::Float | SocketKind::Color | SocketKind::Vector
            ) && let Some(value) = graph.range_of(&results, input, socket.kind).constant()
            {
                // Its parameters are prepared; what other shaders read is bounded at each hit, and numbers in sockets are since the import.
                let is_prepared =
                    was_linked && matches!(graph.nodes[at].kind, NodeKind::PrincipledBsdf { .. });
                // Light may be less than nothing, as in Cycles.
                let legal = match place == principled::EMISSION_COLOR {
                    true => Legal::ANY,
                    false => socket.legal,
                };
                let bounded = value.map(|number| legal.nearest(number));
                input = Input::Value(if is_prepared { bounded } else { value });
            }
            let before = std::mem::replace(&mut graph.nodes[at].inputs[place], input);
            // What says how a surface is not there stays, so that one can say why.
            if graph.nodes[at].kind == NodeKind::MixShader && leads_to_nothing(graph, at) {
                graph.nodes[at].inputs[place] = before;
            }
        }
        if let NodeKind::PrincipledBsdf { edge_tint, .. } = graph.nodes[at].kind {
            cut_hidden(graph, (at, edge_tint), &results, &factors);
        }
        cut_normal(graph, at, &factors);
        cut_tangent(graph, at);
        cut_layers(graph, at);
        instead[at] = replacement(graph, at, facts);
        let result = graph.result((&results, &taken), at, facts);
        results.push(result);
    }
    for root in graph.roots() {
        if let Some(input) = root.and_then(|link| instead[link.node as usize]) {
            *root = input.link();
        }
    }
    graph.prune();
}

/// Sockets of a Principled BSDF that are not seen below metal or glass lose their links, unless a value there may not be
/// finite: that times nothing is not nothing.
fn cut_hidden(
    graph: &mut Graph,
    (at, edge_tint): (usize, bool),
    results: &[Range],
    factors: &[Range],
) {
    use principled::{METALLIC, SPECULAR_IOR_LEVEL, SPECULAR_TINT, TRANSMISSION_WEIGHT};
    let range = |graph: &Graph, socket: usize| {
        let kind = principled::SOCKETS[socket].kind;
        graph.range_of(results, graph.nodes[at].inputs[socket], kind)
    };
    let cut = |graph: &mut Graph, socket: usize| {
        let input = graph.nodes[at].inputs[socket];
        if input.link().is_some() && range(graph, socket).is_finite() {
            let kind = principled::SOCKETS[socket].kind;
            let factor = graph.range_of(factors, input, kind).high.truncate();
            graph.nodes[at].inputs[socket] = Input::Value(factor.to_array());
        }
    };
    let (least, most) = (
        |graph: &Graph, socket| range(graph, socket).number().0,
        |graph: &Graph, socket| range(graph, socket).number().1,
    );
    if least(graph, METALLIC) >= 1.0 {
        for socket in [SPECULAR_IOR_LEVEL, TRANSMISSION_WEIGHT] {
            cut(graph, socket);
        }
        if !edge_tint {
            cut(graph, SPECULAR_TINT);
        }
        return;
    }
    if least(graph, TRANSMISSION_WEIGHT) >= 1.0 {
        cut(graph, SPECULAR_IOR_LEVEL);
    }
    // Glass is tinted by it whatever the strength.
    if most(graph, SPECULAR_IOR_LEVEL) <= 0.0
        && most(graph, TRANSMISSION_WEIGHT) <= 0.0
        && !(edge_tint && most(graph, METALLIC) > 0.0)
    {
        cut(graph, SPECULAR_TINT);
    }
}

/// A layer that is not there has no images.
fn cut_layers(graph: &mut Graph, at: usize) {
    let node = &mut graph.nodes[at];
    if !matches!(node.kind, NodeKind::PrincipledBsdf { .. }) {
        return;
    }
    for (weight, others) in LAYERS {
        if node.inputs[weight] == Input::float(0.0) {
            for &socket in others {
                let fresh = principled::SOCKETS[socket];
                node.inputs[socket] = match fresh.kind {
                    SocketKind::Normal => Input::None,
                    _ => Input::Value(fresh.default),
                };
            }
        }
    }
}

/// Without anisotropy a tangent changes nothing.
fn cut_tangent(graph: &mut Graph, at: usize) {
    let node = &mut graph.nodes[at];
    let [tangent, rotation] = match node.kind {
        NodeKind::PrincipledBsdf { .. } => [principled::TANGENT, principled::ANISOTROPIC_ROTATION],
        NodeKind::GlossyBsdf { .. } => [glossy::TANGENT, glossy::ROTATION],
        NodeKind::Bsdf(SimpleBsdf::Glass { .. }) => [glass::TANGENT, glass::ROTATION],
        NodeKind::Bsdf(SimpleBsdf::Metallic { .. }) => [metallic::TANGENT, metallic::ROTATION],
        _ => return,
    };
    if !node.is_anisotropic() {
        node.inputs[tangent] = Input::None;
        node.inputs[rotation] = Input::float(0.0);
    }
}

/// What can stand in the place of a node, bit for bit.
fn replacement(graph: &Graph, at: usize, facts: &mut impl Facts) -> Option<Input> {
    let Node { kind, inputs } = &graph.nodes[at];
    let is = |socket: usize, value: f32| inputs[socket] == Input::float(value);
    // Of the same kind: a number is not a colour.
    let alias = |socket: usize| match inputs[socket] {
        Input::Link(link) => {
            let color = matches!(kind, NodeKind::MixColor { .. });
            let same = match graph.gives(link) {
                (SocketKind::Color, _) => color,
                (SocketKind::Float, Lane::One(_)) => !color,
                _ => false,
            };
            same.then_some(inputs[socket])
        }
        _ => None,
    };
    match kind {
        NodeKind::Math {
            operation: MathOperation::Multiply,
            clamp: false,
        } if is(math::A, 1.0) => alias(math::B),
        NodeKind::Math {
            operation: MathOperation::Multiply,
            clamp: false,
        } if is(math::B, 1.0) => alias(math::A),
        NodeKind::MixColor { .. } if is(mix::FACTOR, 0.0) => alias(mix::A),
        NodeKind::MixColor { blend } if is(mix::FACTOR, 1.0) => match blend {
            Blend::Mix => alias(mix::B),
            Blend::Multiply if is(mix::A, 1.0) => alias(mix::B),
            Blend::Multiply if is(mix::B, 1.0) => alias(mix::A),
            _ => None,
        },
        NodeKind::NormalMap { .. } => is_flat(graph, at, facts).then_some(Input::None),
        // What raises nothing is passed by.
        _ if raises_nothing(&graph.nodes[at]) => Some(inputs[bump::NORMAL]),
        NodeKind::MixShader if leads_to_nothing(graph, at) => None,
        NodeKind::MixShader if is(mix_shader::FACTOR, 0.0) => Some(inputs[mix_shader::A]),
        NodeKind::MixShader if is(mix_shader::FACTOR, 1.0) => Some(inputs[mix_shader::B]),
        _ => None,
    }
}

fn is_bump(kind: &NodeKind) -> bool {
    matches!(kind, NodeKind::Function(Function::Bump { .. }))
}

/// Whether it is a Bump whose height is the same everywhere.
fn raises_nothing(node: &Node) -> bool {
    is_bump(&node.kind) && node.inputs[bump::HEIGHT].link().is_none()
}

/// A Bump that raises nothing loses a normal that is made of numbers alone, as in Cycles: its socket has no link then, and the surface's
/// own normal counts. `as_written`: results where images may be anything, as Cycles does not look at them.
fn cut_normal(graph: &mut Graph, at: usize, as_written: &[Range]) {
    if !raises_nothing(&graph.nodes[at]) {
        return;
    }
    let normal = graph.nodes[at].inputs[bump::NORMAL];
    let normal = graph.range_of(as_written, normal, SocketKind::Vector);
    if normal.constant().is_some() {
        graph.nodes[at].inputs[bump::NORMAL] = Input::None;
    }
}

/// Whether all of a Mix Shader is its transparent side.
fn leads_to_nothing(graph: &Graph, at: usize) -> bool {
    let inputs = &graph.nodes[at].inputs;
    let side = match inputs[mix_shader::FACTOR] {
        Input::Value([0.0, ..]) => mix_shader::A,
        Input::Value([1.0, ..]) => mix_shader::B,
        _ => return false,
    };
    let shader = inputs[side].link().map(|link| &graph.node(link).kind);
    shader == Some(&NodeKind::TransparentBsdf)
}

fn is_flat(graph: &Graph, at: usize, facts: &mut impl Facts) -> bool {
    let inputs = &graph.nodes[at].inputs;
    let Input::Value([strength, ..]) = inputs[normal_map::STRENGTH] else {
        return false;
    };
    match inputs[normal_map::COLOR] {
        _ if strength == 0.0 => true,
        Input::Link(link @ Link { output: 0, .. }) => graph
            .node(link)
            .texture()
            .is_some_and(|texture| facts.is_flat(texture, strength)),
        _ => false,
    }
}
