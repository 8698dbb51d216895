//! How strongly a surface emits, guessed from its shaders alone: by that Cycles decides what gets light samples.

use super::node::{emission, mix_shader, principled};
use super::{Graph, Input, NodeKind};
use glam::Vec3;

impl Graph {
    /// The guess: colours and strengths that nodes compute count as 1, and as one half the factors of mixes.
    pub fn emission_estimate(&self) -> Vec3 {
        let Some(surface) = self.surface else {
            return Vec3::ZERO;
        };
        let value = |input: Input, otherwise: f32| match input {
            Input::Value(value) => Vec3::from(value),
            _ => Vec3::splat(otherwise),
        };
        // Shaders stand before what they are part of.
        let mut parts = vec![Vec3::ZERO; surface.node as usize + 1];
        for at in 0..parts.len() {
            let inputs = &self.nodes[at].inputs;
            let part = |input: Input| {
                let link = input.link();
                link.map_or(Vec3::ZERO, |link| parts[link.node as usize])
            };
            let last_two = || [2, 1].map(|from_end| part(inputs[inputs.len() - from_end]));
            parts[at] = match self.nodes[at].kind {
                NodeKind::Emission => {
                    value(inputs[emission::COLOR], 1.0) * value(inputs[emission::STRENGTH], 1.0)
                }
                NodeKind::PrincipledBsdf { .. } => {
                    value(inputs[principled::EMISSION_COLOR], 1.0)
                        * value(inputs[principled::EMISSION_STRENGTH], 1.0)
                }
                NodeKind::AddShader => {
                    let [a, b] = last_two();
                    a + b
                }
                NodeKind::MixShader => {
                    let [a, b] = last_two();
                    let factor = value(inputs[mix_shader::FACTOR], 0.5);
                    a.lerp(b, factor.x.clamp(0.0, 1.0))
                }
                _ => Vec3::ZERO,
            };
        }
        parts[surface.node as usize]
    }
}
