//! EXT_lights_ies: lamps by photometric files.

use glam::DAffine3;
use serde::Deserialize;
use std::sync::Arc;

use super::container::Document;
use super::lights::LUMENS_PER_WATT;
use super::words;
use crate::import::{ImportError, ies};
use crate::nodes::ies::IesProfile;
use crate::scene::graph::function::{PlaceInput, Space, Transformed};
use crate::scene::graph::node::emission;
use crate::scene::graph::{Function, Graph, Node, NodeKind};
use crate::scene::{Diagnostics, Light, LightKind, Links, Verdict, Visibility};

pub(super) const NAME: &str = "EXT_lights_ies";

/// What a node says.
#[derive(Debug, Deserialize)]
pub(super) struct IesJson {
    light: usize,
    #[serde(default = "super::schema::one")]
    multiplier: f64,
    #[serde(default = "white")]
    color: [f32; 3],
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

/// A profile of the file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct ProfileJson {
    uri: Option<String>,
    buffer_view: Option<usize>,
}

/// The lamp of a node; `None` (with a diagnostic) where its profile cannot be had.
pub(super) fn load(
    document: &Document,
    json: &IesJson,
    (name, world_from_light): (&str, DAffine3),
    diagnostics: &mut Diagnostics,
) -> Result<Option<Light>, ImportError> {
    let object = format!("node \"{name}\"");
    let broken = |problem: String| ImportError::malformed(&document.file, &object, problem);
    let place = format!("/extensions/{NAME}/lights/{}", json.light);
    let profile = document.value.pointer(&place).ok_or_else(|| {
        broken(format!(
            "it uses light profile {}, which does not exist",
            json.light
        ))
    })?;
    let profile = ProfileJson::deserialize(profile)
        .map_err(|e| broken(format!("its {NAME} cannot be read: {}", words::plain(&e))))?;
    let mut lose = |why: String| {
        let told = format!("light profile that cannot be read ({why})");
        diagnostics.report("light-ies", Verdict::Lost, told, name, "it does not shine");
    };
    let bytes = match (&profile.uri, profile.buffer_view) {
        (Some(uri), _) => match document.resolve(uri, &object) {
            Ok(bytes) => bytes,
            Err(ImportError::MissingPart { needed, reason, .. }) => {
                lose(format!("{needed}: {reason}"));
                return Ok(None);
            }
            Err(error) => return Err(error),
        },
        (None, Some(view)) => document.view(view).map_err(broken)?.0.to_vec(),
        (None, None) => {
            lose("it has neither a file nor a buffer view".into());
            return Ok(None);
        }
    };
    let luminaire = match ies::parse(&bytes) {
        Ok(luminaire) => luminaire,
        Err(why) => {
            lose(why);
            return Ok(None);
        }
    };
    let (verdict, instead) = if luminaire.is_of_another_type {
        let instead = "it shines evenly: profiles of type C alone are read in full".to_owned();
        (Verdict::Approximated, instead)
    } else {
        let lumens = luminaire.mean * json.multiplier * 4.0 * std::f64::consts::PI;
        let instead = format!(
            "its candela, {lumens:.0} lm in all, are divided by 683 lm/W as physics has it"
        );
        (Verdict::Exact, instead)
    };
    let feature = "lamp with a photometric profile";
    diagnostics.report("light-ies", verdict, feature, name, instead);
    Ok(Some(Light {
        name: name.into(),
        color: json.color.map(|c| c.clamp(0.0, 1.0)),
        kind: LightKind::Point {
            intensity: (json.multiplier / LUMENS_PER_WATT) as f32,
            radius: 0.0,
            soft_falloff: false,
        },
        world_from_light,
        visibility: Visibility::ALL,
        max_bounces: Light::MAX_BOUNCES,
        is_hit: true,
        links: Links::default(),
        graph: Some(Box::new(shining(luminaire.candela))),
    }))
}

/// The node tree of a lamp that shines by a profile.
fn shining(profile: IesProfile) -> Graph {
    let mut graph = Graph::default();
    let place = NodeKind::Function(Function::Place(PlaceInput::Incoming));
    let incoming = graph.add(Node::new(place));
    let turned = NodeKind::Function(Function::VectorTransform {
        what: Transformed::Normal,
        from: Space::World,
        to: Space::Object,
    });
    let turned = graph.add(Node::new(turned).with(0, incoming));
    let ies = NodeKind::Function(Function::Ies(Arc::new(profile)));
    let ies = graph.add(Node::new(ies).with(0, turned));
    let shines = Node::new(NodeKind::Emission)
        .with(emission::COLOR, [1.0; 3])
        .with(emission::STRENGTH, ies);
    graph.surface = Some(graph.add(shines));
    graph
}
