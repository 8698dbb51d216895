//! Graphs of any making become fit for evaluation: links that go somewhere, numbers that make sense.

use super::node::{math, mix, normal_map};
use super::{Blend, Graph, Input, Legal, MathOperation, Node, NodeKind, SocketKind};

/// What was wrong with a graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Numbers outside of their legal range.
    pub numbers: bool,
    /// Textures without an image, or with a transform that is not finite.
    pub textures: bool,
    /// Links that go nowhere, backwards, or to what gives something else.
    pub links: bool,
}

impl Graph {
    /// Mends what has no meaning, for a scene with so many images.
    pub fn clean(&mut self, images: usize) -> Faults {
        let links = self.mend_links();
        let textures = self.cut_textures(images);
        let numbers = self.bound_numbers();
        if links || textures {
            self.prune();
        }
        Faults {
            numbers,
            textures,
            links,
        }
    }

    fn mend_links(&mut self) -> bool {
        let mut broken = false;
        for at in 0..self.nodes.len() {
            let (before, rest) = self.nodes.split_at_mut(at);
            let node = &mut rest[0];
            let fresh = Node::new(node.kind.clone());
            if node.inputs.len() != fresh.inputs.len() {
                (node.inputs, broken) = (fresh.inputs, true);
                continue;
            }
            let sockets = node.kind.sockets().iter().zip(fresh.inputs);
            for (input, (socket, default)) in node.inputs.iter_mut().zip(sockets) {
                let wants_shader = socket.kind == SocketKind::Shader;
                let good = match *input {
                    Input::None => default == Input::None,
                    Input::Value(_) => !wants_shader,
                    Input::Link(link) => before
                        .get(link.node as usize)
                        .and_then(|n| n.kind.outputs().get(usize::from(link.output)))
                        .is_some_and(|(kind, _)| (*kind == SocketKind::Shader) == wants_shader),
                };
                if !good {
                    (*input, broken) = (default, true);
                }
            }
        }
        let nodes = std::mem::take(&mut self.nodes);
        for root in self.roots() {
            let there = |link: &super::Link| {
                let node = nodes.get(link.node as usize);
                node.is_some_and(|n| usize::from(link.output) < n.kind.outputs().len())
            };
            broken |= root.take_if(|link| !there(link)).is_some();
        }
        self.nodes = nodes;
        broken
    }

    /// Images that cannot be read are white, and normal maps of them are none.
    fn cut_textures(&mut self, images: usize) -> bool {
        let mut cut = vec![false; self.nodes.len()];
        for (at, node) in self.nodes.iter().enumerate() {
            cut[at] = match (&node.kind, node.texture()) {
                (NodeKind::NormalMap { .. }, _) => node.inputs[normal_map::COLOR]
                    .link()
                    .is_some_and(|link| cut[link.node as usize]),
                (_, Some(texture)) => {
                    texture.image.0 as usize >= images || !texture.transform.is_finite()
                }
                _ => false,
            };
        }
        for node in &mut self.nodes {
            let sockets = node.kind.sockets();
            for (input, socket) in node.inputs.iter_mut().zip(sockets) {
                if input.link().is_some_and(|link| cut[link.node as usize]) {
                    *input = match socket.kind {
                        SocketKind::Normal | SocketKind::Coordinates => Input::None,
                        _ => Input::float(1.0),
                    };
                }
            }
        }
        cut.contains(&true)
    }

    /// Brings numbers into the ranges of their sockets. A factor of a product has the range of what takes the product.
    fn bound_numbers(&mut self) -> bool {
        let mut changed = false;
        let mut inherited: Vec<Option<Legal>> = vec![None; self.nodes.len()];
        for at in (0..self.nodes.len()).rev() {
            let node = &mut self.nodes[at];
            let of_result = inherited[at].unwrap_or(Legal::ANY);
            for (place, socket) in node.kind.sockets().iter().enumerate() {
                let legal = match (&node.kind, place) {
                    (
                        NodeKind::Math {
                            operation: MathOperation::LessThan,
                            ..
                        },
                        math::B,
                    ) => Legal {
                        otherwise: 0.5,
                        ..Legal::ANY
                    },
                    (
                        NodeKind::Math {
                            operation: MathOperation::Multiply | MathOperation::LessThan,
                            ..
                        },
                        _,
                    ) => of_result,
                    (
                        NodeKind::MixColor {
                            blend: Blend::Multiply,
                        },
                        mix::A | mix::B,
                    ) => of_result,
                    _ => socket.legal,
                };
                match &mut node.inputs[place] {
                    Input::Value(values) => {
                        for value in values {
                            let nearest = legal.nearest(*value);
                            changed |= nearest != *value;
                            *value = nearest;
                        }
                    }
                    Input::Link(link) => {
                        inherited[link.node as usize].get_or_insert(legal);
                    }
                    Input::None => {}
                }
            }
        }
        changed
    }
}
