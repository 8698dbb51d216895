//! KHR_lights_punctual, with the units undone, and SUNDOG_light.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DAffine3;

use super::container::Document;
use super::extensions::report_property;
use super::schema::{LightJson, SpotJson, SundogLight};
use crate::import::{ImportOptions, LightUnits};
use crate::scene::{AreaShape, Diagnostics, Light, LightKind, Verdict, Visibility};

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
    let fallback = SundogLight::default();
    let sundog = light.extensions.sundog.as_ref().unwrap_or(&fallback);
    let (color, strength) = match sundog.strength {
        Some(strength) => color_and_strength(strength),
        None => (light.color, by_intensity(light, options)),
    };
    // Negative ones stay so, for `scene::validate` to find.
    let radius = sundog.radius.unwrap_or(0.0) as f32;
    let kind = match light.kind.as_str() {
        "point" => LightKind::Point {
            intensity: strength,
            radius,
            soft_falloff: sundog.soft_falloff,
        },
        "spot" => {
            let (half_angle, blend) = cone(document, light, sundog, &name, diagnostics);
            LightKind::Spot {
                intensity: strength,
                radius,
                soft_falloff: sundog.soft_falloff,
                half_angle: half_angle as f32,
                blend: blend as f32,
            }
        }
        "directional" => LightKind::Sun {
            irradiance: strength,
            angle: sundog.angle.unwrap_or(0.0).min(PI) as f32,
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
    let visibility = rays(sundog, &name, diagnostics);
    Some(Light {
        name,
        color,
        kind,
        world_from_light,
        visibility,
        max_bounces: sundog.max_bounces.unwrap_or(Light::MAX_BOUNCES),
    })
}

/// The area light of a node; `None` (with a diagnostic) for what is none.
pub(super) fn load_area(
    light: &SundogLight,
    node: &str,
    world_from_light: DAffine3,
    diagnostics: &mut Diagnostics,
) -> Option<Light> {
    let name = light.name.clone().unwrap_or_else(|| node.into());
    let shape = match (light.kind.as_deref(), light.shape.as_deref()) {
        (Some("area"), None | Some("rectangle")) => AreaShape::Rectangle,
        (Some("area"), Some("ellipse")) => AreaShape::Ellipse,
        (Some("area"), Some(other)) => {
            diagnostics.report(
                "light-shape",
                Verdict::Lost,
                format!("area lights of the shape \"{other}\""),
                name,
                "left out",
            );
            return None;
        }
        (kind, _) => {
            diagnostics.report(
                "light-kind",
                Verdict::Lost,
                format!(
                    "SUNDOG_light of kind \"{}\" on a node",
                    kind.unwrap_or_default()
                ),
                name,
                "left out",
            );
            return None;
        }
    };
    let visibility = rays(light, &name, diagnostics);
    Some(Light {
        color: light.strength.unwrap_or([1.0; 3]),
        kind: LightKind::Area {
            shape,
            size: light.size.unwrap_or([1.0; 2]).map(|s| s as f32),
            power: light.power.unwrap_or(0.0) as f32,
            normalize: light.normalize.unwrap_or(true),
            spread: light.spread.unwrap_or(PI).min(PI) as f32,
        },
        name,
        world_from_light,
        visibility,
        max_bounces: light.max_bounces.unwrap_or(Light::MAX_BOUNCES),
    })
}

/// Strength in W/sr or W/m² as the units of the file have it.
fn by_intensity(light: &LightJson, options: &ImportOptions) -> f32 {
    let strength = match (options.light_units, light.kind.as_str()) {
        (LightUnits::Standard, _) => light.intensity / LUMENS_PER_WATT,
        (LightUnits::Raw, "point" | "spot") => light.intensity / (4.0 * PI),
        (LightUnits::Raw | LightUnits::Unitless, _) => light.intensity,
    };
    strength as f32
}

/// A colour whose brightest channel is 1, and what it is multiplied with.
fn color_and_strength(strength: [f32; 3]) -> ([f32; 3], f32) {
    let brightest = strength[0].max(strength[1]).max(strength[2]);
    if brightest > 0.0 && strength.iter().all(|s| s.is_finite()) {
        (strength.map(|s| s / brightest), brightest)
    } else {
        // Black, or something for `scene::validate` to find.
        (strength, 1.0)
    }
}

/// Half angle and blend of a spot.
fn cone(
    document: &Document,
    light: &LightJson,
    sundog: &SundogLight,
    name: &str,
    diagnostics: &mut Diagnostics,
) -> (f64, f64) {
    let fallback = SpotJson::default();
    let spot = light.spot.as_ref().unwrap_or(&fallback);
    let outer = spot.outer_cone_angle.clamp(0.0, FRAC_PI_2);
    let inner = spot.inner_cone_angle.clamp(0.0, outer);
    let blend = if outer > 0.0 {
        1.0 - inner / outer
    } else {
        0.0
    };
    // Those of SUNDOG_light may be wider, and stand in the place of these.
    // A half-space's in f32 is a little wider than one.
    let moved = |from: f64, to: f64| (from - to).abs() > 4.0 * f64::from(f32::EPSILON);
    if (moved(spot.outer_cone_angle, outer) || moved(spot.inner_cone_angle, inner))
        && (sundog.half_angle.is_none() || sundog.blend.is_none())
    {
        diagnostics.report(
            "spot-cone",
            Verdict::Approximated,
            "spot light with an impossible cone, or an inner one wider than the outer",
            name,
            "the nearest possible angles are used",
        );
    }
    if document.blender_version().is_none() && blend > 0.0 && sundog.blend.is_none() {
        diagnostics.report(
            "spot-edge",
            Verdict::Approximated,
            "soft edge of spot lights",
            name,
            "fades as Blender's spots do between the same two cones",
        );
    }
    (
        sundog.half_angle.map_or(outer, |a| a.min(PI)),
        sundog.blend.map_or(blend, |b| b.min(1.0)),
    )
}

/// The ray visibility; also names what is not known.
fn rays(light: &SundogLight, name: &str, diagnostics: &mut Diagnostics) -> Visibility {
    for property in light.unknown.keys() {
        report_property(diagnostics, "SUNDOG_light", property, name);
    }
    light.visibility.visibility(|kind| {
        report_property(
            diagnostics,
            "SUNDOG_light",
            &format!("visibility.{kind}"),
            name,
        );
    })
}
