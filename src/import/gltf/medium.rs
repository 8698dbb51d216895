//! What fills meshes and all space, as SUNDOG_material and SUNDOG_scene say it.

use serde::Deserialize;
use serde_json::{Map, Value};

use super::extensions::report_property;
use crate::scene::{Diagnostics, Medium, Phase, Scatterer};

/// What fills a mesh or all space: coefficients by metre.
#[derive(Debug, Default, Deserialize)]
pub(super) struct MediumJson {
    #[serde(default)]
    pub absorption: [f32; 3],
    #[serde(default)]
    pub emission: [f32; 3],
    #[serde(default)]
    pub scatterers: Vec<ScattererJson>,
    /// A node tree for what varies, as in SUNDOG_shader_graph.
    pub graph: Option<Value>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// What scatters in it.
#[derive(Debug, Deserialize)]
pub(super) struct ScattererJson {
    pub coefficient: [f32; 3],
    #[serde(default)]
    pub phase: PhaseJson,
    #[serde(default)]
    pub anisotropy: f32,
    #[serde(default)]
    pub alpha: f32,
    pub ior: Option<f32>,
    pub backscatter: Option<f32>,
    pub diameter: Option<f32>,
}

/// Where to.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum PhaseJson {
    #[default]
    HenyeyGreenstein,
    Rayleigh,
    Draine,
    FournierForand,
    Mie,
}

/// What fills a mesh or all space.
pub(super) fn read(json: &MediumJson, owner: &str, diagnostics: &mut Diagnostics) -> Medium {
    for name in json.unknown.keys() {
        let name = format!("volume.{name}");
        report_property(diagnostics, "SUNDOG_material", &name, owner);
    }
    let scatterer = |s: &ScattererJson| Scatterer {
        coefficient: s.coefficient,
        phase: match s.phase {
            PhaseJson::HenyeyGreenstein => Phase::HenyeyGreenstein(s.anisotropy),
            PhaseJson::Rayleigh => Phase::Rayleigh,
            PhaseJson::Draine => Phase::Draine {
                anisotropy: s.anisotropy,
                alpha: s.alpha,
            },
            // Blender's defaults.
            PhaseJson::FournierForand => Phase::FournierForand {
                ior: s.ior.unwrap_or(1.33),
                backscatter: s.backscatter.unwrap_or(0.1),
            },
            PhaseJson::Mie => Phase::Mie(s.diameter.unwrap_or(20.0)),
        },
    };
    Medium {
        absorption: json.absorption,
        emission: json.emission,
        scatterers: json.scatterers.iter().map(scatterer).collect(),
        varying: None,
    }
}
