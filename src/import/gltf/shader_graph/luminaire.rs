//! Nodes of lamps: IES textures and Light Falloff.

use super::{Reader, Refusal, Stop};
use crate::nodes::ies::{Beyond, IesProfile};
use crate::scene::graph::function::{PlaceInput, Space, Transformed};
use crate::scene::graph::{Function, Input, Node, NodeKind};
use serde::Deserialize;
use std::sync::Arc;

/// The property `ies`.
#[derive(Debug, Deserialize)]
struct IesJson {
    around: Vec<f32>,
    down: Vec<f32>,
    strengths: Vec<f32>,
}

impl Reader<'_, '_, '_> {
    pub(super) fn ies(&mut self, at: usize) -> Result<Input, Stop> {
        let node = &self.source.nodes[at];
        let table = node.properties.get("ies").map(IesJson::deserialize);
        let Some(Ok(json)) = table else {
            return Err(Refusal::of(node, "without a table").into());
        };
        let profile = IesProfile {
            around: json.around,
            down: json.down,
            strengths: json.strengths,
            beyond: Beyond::of(self.version),
        };
        if !profile.is_sane() {
            return Err(Refusal::of(node, "with a table of no meaning").into());
        }
        let is_linked = node.inputs.contains_key("Vector");
        let link = self.add(
            at,
            NodeKind::Function(Function::Ies(Arc::new(profile))),
            &[],
        );
        if !is_linked {
            // The way from the lamp, in its own axes, turned as normals are.
            let place = NodeKind::Function(Function::Place(PlaceInput::Incoming));
            let way = self.graph.nodes.len() as u32 - 1;
            let ies = self.graph.nodes.swap_remove(way as usize);
            let incoming = self.graph.add(Node::new(place));
            let turned = NodeKind::Function(Function::VectorTransform {
                what: Transformed::Normal,
                from: Space::World,
                to: Space::Object,
            });
            let turned = self.graph.add(Node::new(turned).with(0, incoming));
            return Ok(self.graph.add(ies.with(0, turned)).into());
        }
        Ok(link.into())
    }

    pub(super) fn falloff(&mut self, at: usize, output: &str) -> Input {
        let power = match output {
            "Linear" => 1,
            "Constant" => 2,
            _ => 0,
        };
        let kind = NodeKind::Function(Function::LightFalloff { power });
        self.add(at, kind, &[]).into()
    }
}
