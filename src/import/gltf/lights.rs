//! KHR_lights_punctual, with the units undone.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DAffine3;

use super::container::Document;
use super::schema::LightJson;
use crate::import::{ImportOptions, LightUnits};
use crate::scene::{Diagnostics, Light, LightKind, Verdict};

/// Lumens a watt of Blender's exporter (`PBR_WATTS_TO_LUMENS`): 555 nm light, as in the definition
/// of the candela.
const LUMENS_PER_WATT: f64 = 683.0;

/// The light of a node; `None` (with a diagnostic) for a kind that does not exist.
pub(super) fn load_light(
    document: &Document,
    light: &LightJson,
    name: String,
    world_from_light: DAffine3,
    options: &ImportOptions,
    diagnostics: &mut Diagnostics,
) -> Option<Light> {
    let per_steradian = match options.light_units {
        LightUnits::Standard => light.intensity / LUMENS_PER_WATT,
        LightUnits::Unitless => light.intensity,
        LightUnits::Raw => light.intensity / (4.0 * PI),
    };
    let per_area = match options.light_units {
        LightUnits::Standard => light.intensity / LUMENS_PER_WATT,
        LightUnits::Unitless | LightUnits::Raw => light.intensity,
    };
    let size = light.extensions.sundog.as_ref();
    let radius = size.and_then(|s| s.radius).unwrap_or(0.0).max(0.0) as f32;
    let angle = size.and_then(|s| s.angle).unwrap_or(0.0).clamp(0.0, PI) as f32;
    let kind = match light.kind.as_str() {
        "point" => LightKind::Point {
            intensity: per_steradian as f32,
            radius,
        },
        "spot" => {
            let fallback = Default::default();
            let spot = light.spot.as_ref().unwrap_or(&fallback);
            let outer = spot.outer_cone_angle.clamp(0.0, FRAC_PI_2);
            let inner = spot.inner_cone_angle.clamp(0.0, outer);
            let blend = if outer > 0.0 {
                1.0 - inner / outer
            } else {
                0.0
            };
            if document.blender_version().is_none() && blend > 0.0 {
                diagnostics.report(
                    "spot-edge",
                    Verdict::Approximated,
                    "soft edge of spot lights",
                    &name,
                    "fades as Blender's spots do between the same two cones",
                );
            }
            LightKind::Spot {
                intensity: per_steradian as f32,
                radius,
                half_angle: outer as f32,
                blend: blend as f32,
            }
        }
        "directional" => LightKind::Sun {
            irradiance: per_area as f32,
            angle,
        },
        other => {
            diagnostics.report(
                "light-kind",
                Verdict::Lost,
                format!("lights of kind \"{other}\""),
                name,
                "left out",
            );
            return None;
        }
    };
    if light.range.is_some_and(f64::is_finite) {
        diagnostics.report(
            "light-range",
            Verdict::Approximated,
            "range of lights",
            &name,
            "light falls off with the square of the distance and reaches everywhere, as in Cycles",
        );
    }
    Some(Light {
        name,
        color: light.color,
        kind,
        world_from_light,
    })
}
