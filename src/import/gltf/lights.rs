//! KHR_lights_punctual, with the units undone, and SUNDOG_light.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DAffine3, DVec3};

use super::container::Document;
use super::extensions::report_property;
use super::schema::{LightJson, SpotJson, SundogLight};
use crate::import::{ImportOptions, LightUnits};
use crate::scene::{
    AreaShape, Diagnostics, Effect, Light, LightKind, Mesh, Portal, Scene, Verdict, Visibility,
};

/// Lumens a watt of Blender's exporter (`PBR_WATTS_TO_LUMENS`): 555 nm light, as in the definition
/// of the candela.
pub(super) const LUMENS_PER_WATT: f64 = 683.0;

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
    // glTF has no light of less than nothing; Blender has.
    if sundog.strength.is_none() && (strength < 0.0 || color.iter().any(|&c| c < 0.0)) {
        diagnostics.report(
            "bad-light",
            Verdict::Lost,
            "light with a negative color or intensity",
            name,
            "left out",
        );
        return None;
    }
    // Negative radii stay so, for `scene::validate` to find.
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
    // The strength of an Emission node is 1 unless somebody changes it. (Measured with 4.5.15; 5.2.3 writes the sun's own.)
    let without_own = (light.intensity - LUMENS_PER_WATT).abs() < 1e-3;
    if light.kind == "directional"
        && without_own
        && sundog.strength.is_none()
        && document
            .blender_version()
            .is_some_and(|version| version < 5)
    {
        diagnostics.report(
            "sun-with-nodes",
            Verdict::Approximated,
            "sun of 683 lx, which is what Blender's exporter writes for any sun with nodes",
            &name,
            "it shines with 1 W/m²; Sundog's own export has its strength",
        );
    }
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
        is_hit: sundog.mis.unwrap_or(true),
        links: sundog.links.links(),
        graph: None,
    })
}

/// What a node's `SUNDOG_light` is that shines with nothing of its own.
pub(super) const PORTAL: &str = "portal";

/// The portal of a node; `None` (with a diagnostic) for what is none.
pub(super) fn load_portal(
    light: &SundogLight,
    node: &str,
    world_from_portal: DAffine3,
    diagnostics: &mut Diagnostics,
) -> Option<Portal> {
    let name = light.name.clone().unwrap_or_else(|| node.into());
    let size = light.size.unwrap_or([1.0; 2]).map(|side| side as f32);
    let shape = match light.shape.as_deref() {
        None | Some("rectangle") => Some(AreaShape::Rectangle),
        Some("ellipse") => Some(AreaShape::Ellipse),
        Some(_) => None,
    };
    let is_sound = size.iter().all(|side| side.is_finite() && *side > 0.0);
    let shape = shape.filter(|_| is_sound && world_from_portal.is_finite());
    if shape.is_none() {
        diagnostics.report(
            "portal",
            Verdict::Exact,
            "portals of no size or of an unknown shape",
            &name,
            "left out: they change the noise alone",
        );
    }
    Some(Portal {
        name,
        shape: shape?,
        size,
        world_from_portal,
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
            diagnostics.report_effect(
                Effect::AreaLights,
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
        is_hit: light.mis.unwrap_or(true),
        links: light.links.links(),
        graph: None,
    })
}

/// Strength in W/sr or W/m² as the units of the file have it.
fn by_intensity(light: &LightJson, options: &ImportOptions) -> f32 {
    let strength = match (options.light_units, light.kind.as_str()) {
        (LightUnits::Standard, _) => light.intensity / LUMENS_PER_WATT,
        (LightUnits::Raw, "point" | "spot") => light.intensity / (4.0 * PI),
        // What `choose_units` leaves or divides.
        (LightUnits::Raw | LightUnits::Unitless | LightUnits::Auto, _) => light.intensity,
    };
    strength as f32
}

/// A lamp whose units the file leaves open: its index in the scene, and its number in the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenUnits {
    light: usize,
    intensity: f64,
}

impl OpenUnits {
    /// Of the light that will have this index, if its strength hangs on units that nobody has said.
    pub(super) fn of(light: usize, json: &LightJson, options: &ImportOptions) -> Option<Self> {
        let said = json.extensions.sundog.as_ref();
        let open = options.light_units == LightUnits::Auto
            && said.and_then(|s| s.strength).is_none()
            && json.intensity.is_finite()
            && json.intensity > 0.0;
        open.then_some(Self {
            light,
            intensity: json.intensity,
        })
    }
}

/// Between the two readings lies a factor of 683. A picture is well exposed where a few W/m² fall on what is seen; from
/// 3 W/m² the root of that factor, 26, leads to the border: 0.115 W/m², which are 78 lx.
const LEAST_LUX: f64 = 78.0;
/// Blender's exporter writes "Standard" unless it is told otherwise: lamps of a few watts are to stay so.
const LEAST_LUX_OF_BLENDER: f64 = 20.0;
/// Programs that write their renderer's numbers, of which 1 to 10 are usual, write lux by accident only.
const LEAST_LUX_OF_UNITLESS: f64 = 1000.0;
/// So near to the border (as a factor) either may be meant.
const DOUBT: f64 = 4.0;

/// Programs (in lower case, as part of their name) that write numbers without units.
const UNITLESS: [&str; 9] = [
    "three.js",
    "three.gltfexporter",
    "playcanvas",
    "babylon",
    "maya2gltf",
    "sketchfab",
    "unitygltf",
    "cinema 4d",
    "godot",
];

/// The illuminance from which a program's numbers are taken as photometric, and why.
fn least_lux(generator: &str) -> (f64, &'static str) {
    let generator = generator.to_lowercase();
    // The lighting modes came with Blender 3.6.
    let modes = generator
        .split_once("khronos gltf blender i/o v")
        .and_then(|(_, version)| {
            let mut numbers = version.split(|c: char| !c.is_ascii_digit());
            let mut next = || numbers.next()?.parse::<u32>().ok();
            Some((next()?, next()?))
        })
        .is_some_and(|version| version >= (3, 6));
    if modes {
        (
            LEAST_LUX_OF_BLENDER,
            "Blender's exporter writes lux and candela unless it is told otherwise",
        )
    } else if UNITLESS.iter().any(|name| generator.contains(name)) {
        (
            LEAST_LUX_OF_UNITLESS,
            "the program that wrote the file is known for numbers without units",
        )
    } else {
        (
            LEAST_LUX,
            "the program that wrote the file is not known for either",
        )
    }
}

/// Decides what the numbers of a file's lamps mean, and says so.
pub(super) fn choose_units(open: &[OpenUnits], scene: &mut Scene, diagnostics: &mut Diagnostics) {
    if open.is_empty() {
        return;
    }
    let lux = illuminance(open, scene);
    let (least, why) = least_lux(scene.generator.as_deref().unwrap_or_default());
    // A sun of fewer lux would be less than what is left of it at dusk, beside lamps that are to be seen.
    let suns = open.iter().filter(|lamp| {
        let light = scene.lights.get(lamp.light);
        light.is_some_and(|light| matches!(light.kind, LightKind::Sun { .. }))
    });
    let brightest_sun = suns.map(|lamp| lamp.intensity).fold(0.0, f64::max);
    let weak_sun = lux >= least && brightest_sun > 0.0 && brightest_sun < least;
    let (factor, read, other) = if lux >= least && !weak_sun {
        let factor = LUMENS_PER_WATT.recip();
        (factor, "as lux and candela (\"standard\")", "unitless")
    } else {
        (1.0, "as W/m² and W/sr (\"unitless\")", "standard")
    };
    let doubtful = (lux / least).ln().abs() < DOUBT.ln() || weak_sun;
    let why = if weak_sun {
        "its brightest sun would be weaker than dusk"
    } else {
        why
    };
    let (verdict, doubt) = if doubtful {
        (Verdict::Approximated, ", though the other may be meant")
    } else {
        (Verdict::Exact, "")
    };
    let digits = |value: f64| match value {
        v if v >= 100.0 => format!("{v:.0}"),
        v if v >= 0.1 => format!("{v:.1}"),
        v => format!("{v:.1e}"),
    };
    let instead = format!(
        "read {read}{doubt}: in lux they light the objects with {}, which would be {} W/m²; {why}; --light-units {other} decides otherwise",
        digits(lux),
        digits(lux / LUMENS_PER_WATT),
    );
    for lamp in open {
        let Some(light) = scene.lights.get_mut(lamp.light) else {
            continue;
        };
        diagnostics.report(
            "light-units",
            verdict,
            "intensities of lamps",
            &light.name,
            &instead,
        );
        if let LightKind::Point { intensity, .. }
        | LightKind::Spot { intensity, .. }
        | LightKind::Sun {
            irradiance: intensity,
            ..
        } = &mut light.kind
        {
            *intensity = (lamp.intensity * factor) as f32;
        }
    }
}

/// So many placed meshes are asked at most, evenly over the list; and so many lamps.
const ASKED: usize = 512;

/// How brightly the lamps' numbers, taken as lux and candela, light the scene: the median over its objects, each taken at
/// its middle as far away as that and half its diagonal, without shadows and angles.
fn illuminance(open: &[OpenUnits], scene: &Scene) -> f64 {
    let step = scene.instances.len().div_ceil(ASKED).max(1);
    let mut levels: Vec<f64> = scene
        .instances
        .iter()
        .step_by(step)
        .filter_map(|instance| {
            let (middle, radius) = ball(scene.meshes.get(instance.mesh.0 as usize)?)?;
            let place = instance.world_from_object;
            let scale = place.matrix3.determinant().abs().cbrt();
            let at = place.transform_point3(middle);
            let level = level_at(open, scene, at, radius * scale);
            level.is_finite().then_some(level)
        })
        .collect();
    if levels.is_empty() {
        // Nothing to light: what falls on a surface at a metre.
        return open.iter().map(|lamp| lamp.intensity).sum();
    }
    let half = levels.len() / 2;
    *levels.select_nth_unstable_by(half, f64::total_cmp).1
}

fn level_at(open: &[OpenUnits], scene: &Scene, at: DVec3, radius: f64) -> f64 {
    let lights = open.iter().take(ASKED).filter_map(|lamp| {
        let light = scene.lights.get(lamp.light)?;
        Some(match light.kind {
            LightKind::Sun { .. } => lamp.intensity,
            _ => {
                let from = light.world_from_light.translation;
                lamp.intensity / (from.distance_squared(at) + radius * radius)
            }
        })
    });
    lights.sum()
}

/// Middle and half the diagonal of a mesh's box.
fn ball(mesh: &Mesh) -> Option<(DVec3, f64)> {
    let mut points = mesh
        .positions
        .iter()
        .map(|p| DVec3::from(p.map(f64::from)))
        .filter(|p| p.is_finite());
    let first = points.next()?;
    let (low, high) = points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    Some((0.5 * (low + high), 0.5 * low.distance(high)))
}

/// A colour whose brightest channel is 1, and what it is multiplied with.
fn color_and_strength(strength: [f32; 3]) -> ([f32; 3], f32) {
    let brightest = strength.into_iter().map(f32::abs).fold(0.0, f32::max);
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
        diagnostics.report_effect(
            Effect::SpotLights,
            "spot-cone",
            Verdict::Approximated,
            "spot light with an impossible cone, or an inner one wider than the outer",
            name,
            "the nearest possible angles are used",
        );
    }
    if document.blender_version().is_none() && blend > 0.0 && sundog.blend.is_none() {
        diagnostics.report_effect(
            Effect::SpotLights,
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
