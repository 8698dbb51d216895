//! Sums and mixes of shaders: the leaves below them with their weights, and what lets light pass straight on.

use super::compile::{Compiler, ONE, Source, ZERO, root};
use super::{Opacity, Operand};
use crate::scene::graph::node::{mix_shader, ray_portal, transparent};
use crate::scene::graph::{Blend, Graph, Link, MathOperation, NodeKind};
use glam::Vec4;

impl<S: Source> Compiler<'_, S> {
    /// The factor of a Mix Shader, 0 to 1.
    fn factor(&mut self, at: usize) -> Operand {
        let input = self.graph.nodes[at].inputs[mix_shader::FACTOR];
        let factor = self.input(at, mix_shader::FACTOR);
        let is_share = input.link().is_some_and(|link| {
            matches!(
                self.graph.node(link).kind,
                NodeKind::Math { clamp: true, .. }
                    | NodeKind::Math {
                        operation: MathOperation::LessThan | MathOperation::GreaterThan,
                        ..
                    }
            )
        });
        match factor {
            Operand::Constant(value) => Operand::Constant(value.clamp(Vec4::ZERO, Vec4::ONE)),
            _ if is_share => factor,
            _ => self.number(factor, true),
        }
    }

    /// The shaders under a link that are no sums or mixes, each once, with their weights.
    pub(super) fn leaves(&mut self, root: Option<Link>) -> Vec<(usize, Operand)> {
        let Some(root) = root else {
            return Vec::new();
        };
        let mut weights: Vec<Option<Operand>> = vec![None; root.node as usize + 1];
        weights[root.node as usize] = Some(ONE);
        let mut leaves = Vec::new();
        for at in (0..weights.len()).rev() {
            let Some(weight) = weights[at] else {
                continue;
            };
            let shares = match self.graph.nodes[at].kind {
                NodeKind::AddShader => [weight; 2],
                NodeKind::MixShader => {
                    let factor = self.factor(at);
                    let rest = self.math(MathOperation::Subtract, ONE, factor);
                    [rest, factor].map(|share| self.math(MathOperation::Multiply, weight, share))
                }
                _ => {
                    leaves.push((at, weight));
                    continue;
                }
            };
            // Both have their shaders in their last two sockets.
            let inputs = &self.graph.nodes[at].inputs;
            let sides = [inputs.len() - 2, inputs.len() - 1].map(|socket| inputs[socket].link());
            for (side, share) in sides.into_iter().zip(shares) {
                if let Some(link) = side
                    && share != ZERO
                {
                    let before = weights[link.node as usize].unwrap_or(ZERO);
                    weights[link.node as usize] =
                        Some(self.math(MathOperation::Add, before, share));
                }
            }
        }
        leaves.reverse();
        leaves
    }

    /// The leaves that are not transparent, with their shares of what does not pass straight on.
    pub(super) fn body(&mut self) -> Vec<(usize, Operand)> {
        let leaves = self.leaves(self.graph.body());
        let all = leaves.len();
        let Sorted { clear, rest, .. } = self.sorted(leaves);
        if rest.len() == all {
            return rest;
        }
        let sum = self.remainder(&clear, &rest);
        rest.into_iter()
            .map(|(at, weight)| (at, self.math(MathOperation::Divide, weight, sum)))
            .collect()
    }

    fn sorted(&self, leaves: Vec<(usize, Operand)>) -> Sorted {
        let kind = |(at, _): &(usize, Operand)| &self.graph.nodes[*at].kind;
        let is_clear = |leaf: &_| *kind(leaf) == NodeKind::TransparentBsdf;
        let is_holdout = |leaf: &_| *kind(leaf) == NodeKind::Holdout;
        let (clear, rest): (Vec<_>, Vec<_>) = leaves.into_iter().partition(is_clear);
        let (holdouts, rest) = rest.into_iter().partition(is_holdout);
        Sorted {
            clear,
            holdouts,
            rest,
        }
    }

    fn sum(&mut self, leaves: &[(usize, Operand)]) -> Operand {
        leaves.iter().fold(ZERO, |sum, (_, weight)| {
            self.math(MathOperation::Add, sum, *weight)
        })
    }

    /// The sum of the colours of leaves, each by its share.
    fn colors(&mut self, leaves: Vec<(usize, Operand)>, socket: usize) -> Operand {
        leaves.into_iter().fold(ZERO, |sum, (at, weight)| {
            let color = self.input(at, socket);
            let part = self.blend(Blend::Multiply, color, weight);
            self.blend(Blend::Add, sum, part)
        })
    }

    /// The share of the surface that does not let light pass straight on, by its leaves that do and those that do not. What
    /// [`Self::body`] weighs is divided by it.
    fn rest(&mut self, clear: &[(usize, Operand)], rest: &[(usize, Operand)]) -> Operand {
        let Some((at, clear_is_b, _)) = self.graph.transparency() else {
            return self.remainder(clear, rest);
        };
        let factor = self.factor(at);
        let share = if clear_is_b {
            self.math(MathOperation::Subtract, ONE, factor)
        } else {
            factor
        };
        // Below it more may be clear.
        let leaves = self.leaves(self.graph.body());
        let all = leaves.len();
        let Sorted { clear, rest, .. } = self.sorted(leaves);
        if rest.len() == all {
            return share;
        }
        let below = self.remainder(&clear, &rest);
        self.math(MathOperation::Multiply, share, below)
    }

    /// What is left of 1 by what is clear: so much stops rays that pass by chance. Where sums make more of both than 1, paths
    /// decide for themselves by all that does not pass.
    fn remainder(&mut self, clear: &[(usize, Operand)], rest: &[(usize, Operand)]) -> Operand {
        if self.graph.adds_transparency() {
            return self.sum(rest);
        }
        let clear = self.sum(clear);
        self.math(MathOperation::Subtract, ONE, clear)
    }
}

/// Leaves by what they do to rays.
struct Sorted {
    /// They let light pass.
    clear: Vec<(usize, Operand)>,
    /// The picture is empty there.
    holdouts: Vec<(usize, Operand)>,
    /// They scatter or shine.
    rest: Vec<(usize, Operand)>,
}

pub(super) fn opacity(graph: &Graph, source: &mut impl Source) -> Option<Opacity> {
    let asks = |at: usize| {
        matches!(
            graph.nodes[at].kind,
            NodeKind::TransparentBsdf | NodeKind::Holdout
        )
    };
    if !(0..graph.nodes.len()).any(asks) {
        return None;
    }
    let mut heights = 0;
    let mut compiler = Compiler::new(graph, source, &mut heights);
    let leaves = compiler.leaves(graph.surface);
    let Sorted {
        clear,
        holdouts,
        rest,
    } = compiler.sorted(leaves);
    let is_portal = |(at, _): &&(usize, Operand)| graph.nodes[*at].kind.is_portal();
    let portals: Vec<_> = rest.iter().filter(is_portal).copied().collect();
    let rest = compiler.rest(&clear, &rest);
    let transmittance = compiler.colors(clear, transparent::COLOR);
    let mut transmittance = root(transmittance);
    let mut rest = root(rest);
    let portal = (!portals.is_empty()).then(|| compiler.colors(portals, ray_portal::COLOR));
    let mut portal = portal.map(root);
    let holdout = (!holdouts.is_empty()).then(|| compiler.sum(&holdouts));
    let mut holdout = holdout.map(root);
    let mut roots = vec![&mut transmittance, &mut rest];
    roots.extend(&mut portal);
    roots.extend(&mut holdout);
    let program = compiler.finish(&mut roots);
    Some(Opacity {
        program,
        transmittance,
        rest,
        portal,
        holdout,
    })
}
