//! What the extension `SUNDOG_shader_graph` holds.

use crate::nodes::CyclesVersion;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::HashMap;

/// The extension of a material.
#[derive(Debug, Deserialize)]
pub(super) struct ShaderGraphJson {
    /// The version of Blender whose nodes these are.
    #[serde(default)]
    pub(super) blender: Vec<u16>,
    #[serde(default)]
    pub(super) nodes: Vec<NodeJson>,
    pub(super) surface: Option<Reference>,
    pub(super) volume: Option<Reference>,
    pub(super) displacement: Option<Reference>,
    #[serde(default)]
    pub(super) displacement_method: Option<String>,
    #[serde(default)]
    pub(super) pass_index: f32,
    /// What is told to passes of the scene's own.
    #[serde(default)]
    pub(super) aovs: Vec<AovJson>,
}

/// A value for a pass of the scene's own.
#[derive(Debug, Deserialize)]
pub(super) struct AovJson {
    pub(super) name: String,
    #[serde(flatten)]
    pub(super) value: Reference,
}

#[derive(Debug, Deserialize)]
pub(super) struct NodeJson {
    #[serde(rename = "type")]
    pub(super) kind: String,
    #[serde(default)]
    pub(super) properties: Map<String, Value>,
    #[serde(default)]
    pub(super) inputs: HashMap<String, SocketJson>,
}

/// What stands in a socket.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum SocketJson {
    Link(Reference),
    Number(f32),
    Switch(bool),
    Numbers(Vec<f32>),
}

/// An output of a node before.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Hash)]
pub(super) struct Reference {
    pub(super) node: usize,
    pub(super) output: String,
}

impl ShaderGraphJson {
    pub(super) fn version(&self) -> CyclesVersion {
        match *self.blender {
            [major, minor, ..] => CyclesVersion::new(major, minor),
            _ => CyclesVersion::LATEST,
        }
    }

    /// The number after the last attribute that its nodes read.
    pub(super) fn attributes(&self) -> u32 {
        let named = |value: &Value| {
            let number = value.as_str()?.strip_prefix("_SUNDOG_")?;
            Some(number.parse::<u32>().ok()?.saturating_add(1))
        };
        let of_node = |node: &NodeJson| {
            let values = node.properties.get("values").and_then(Value::as_object);
            let values = values.into_iter().flat_map(|values| values.values());
            let values = values.filter_map(|value| named(value.get("attribute")?));
            let own = node.properties.get("attribute").and_then(named);
            values.chain(own).max().unwrap_or(0)
        };
        self.nodes.iter().map(of_node).max().unwrap_or(0)
    }
}
