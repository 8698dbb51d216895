//! UsdLux: what lamps say, before they are placed.

use std::f64::consts::PI;

use super::blackbody;
use super::source::{Source, View};
use crate::scene::{Diagnostics, Verdict};

/// A lamp in its own space, in the stage's units.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    pub name: String,
    /// Path of its prim, for messages.
    pub path: String,
    pub shape: Shape,
    /// Linear colour with the temperature's.
    pub color: [f64; 3],
    /// Intensity and exposure.
    pub strength: f64,
    /// It is the same light whatever the size.
    pub normalize: bool,
    pub shaping: Shaping,
    /// Objects cast shadows in its light.
    pub shadows: bool,
    /// What Blender's own lamps have other than UsdLux says.
    pub of_blender: bool,
}

/// What shines.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    /// A sphere.
    Sphere { radius: f64, point: bool },
    /// A rectangle.
    Rect { width: f64, height: f64 },
    /// A disk.
    Disk { radius: f64 },
    /// The side of a cylinder along X.
    Cylinder { radius: f64, length: f64 },
    /// Parallel light; the angle is the sun's diameter, radians.
    Distant { angle: f64 },
    /// Light from all around.
    Dome(Dome),
}

/// Light from all around.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Dome {
    /// Where the image is, and how the file calls it.
    pub image: Option<(String, String)>,
    /// The pole of the image is the stage's or Z, and not the light's own Y.
    pub pole: Pole,
}

/// The pole of a dome's image, in the light's own space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Pole {
    /// Y.
    #[default]
    Y,
    /// Z.
    Z,
    /// The stage's up axis.
    Scene,
}

/// UsdLuxShapingAPI.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shaping {
    /// Half the cone's angle, radians, and how much of it the edge takes; without a cone, none.
    pub cone: Option<(f64, f64)>,
    /// Exponent of the cosine to the axis.
    pub focus: f64,
}

/// Kinds of lights that are read.
const KINDS: [&str; 7] = [
    "SphereLight",
    "RectLight",
    "DiskLight",
    "CylinderLight",
    "DistantLight",
    "DomeLight",
    "DomeLight_1",
];
/// Kinds that are none of ours.
const OTHERS: [&str; 4] = ["GeometryLight", "PluginLight", "LightFilter", "MeshLight"];

/// Whether a prim is a light.
pub(super) fn is_light(prim: &View, kind: &str) -> bool {
    KINDS.contains(&kind)
        || OTHERS.contains(&kind)
        || (!matches!(kind, "Camera" | "Mesh")
            && kind.ends_with("Light")
            && prim.has("inputs:intensity"))
}

/// Reads a light; `None` (with a diagnostic) for a kind that is not rendered.
pub(super) fn load(
    prim: &View,
    kind: &str,
    name: &str,
    source: &Source,
    diagnostics: &mut Diagnostics,
) -> Option<Lamp> {
    let path = prim.path().to_string();
    // Before 21.02 their attributes had no namespace.
    let value = |name: &str| prim.value_of(&[&format!("inputs:{name}"), name]);
    let number = |name: &str, fallback: f64| {
        let value = value(name).as_ref().and_then(super::value::number);
        value.filter(|v| v.is_finite()).unwrap_or(fallback)
    };
    let truth = |name: &str| value(name).as_ref().and_then(super::value::truth);
    let of_blender = super::blender_version(source).is_some();
    let (shape, intensity) = match kind {
        "SphereLight" => {
            let radius = number("radius", 0.5).max(0.0);
            let point = prim.truth("treatAsPoint") == Some(true);
            (
                Shape::Sphere {
                    radius,
                    point: point || radius == 0.0,
                },
                1.0,
            )
        }
        "RectLight" => {
            let (width, height) = (number("width", 1.0), number("height", 1.0));
            (Shape::Rect { width, height }, 1.0)
        }
        "DiskLight" => (
            Shape::Disk {
                radius: number("radius", 0.5),
            },
            1.0,
        ),
        "CylinderLight" => {
            let (radius, length) = (number("radius", 0.5), number("length", 1.0));
            (Shape::Cylinder { radius, length }, 1.0)
        }
        "DistantLight" => {
            let angle = number("angle", 0.53).to_radians().clamp(0.0, PI);
            (Shape::Distant { angle }, 50_000.0)
        }
        "DomeLight" | "DomeLight_1" => (Shape::Dome(dome(prim, kind, diagnostics)), 1.0),
        _ => {
            diagnostics.report(
                "light-kind",
                Verdict::Lost,
                format!("lights of the kind {kind}"),
                path,
                "left out",
            );
            return None;
        }
    };
    report_textures(prim, &shape, diagnostics);
    report_rest(prim, diagnostics);
    let color = value("color").as_ref().and_then(super::value::vector::<3>);
    let mut color = color.unwrap_or([1.0; 3]);
    if truth("enableColorTemperature") == Some(true)
        && let Some(kelvin) = value("colorTemperature")
            .as_ref()
            .and_then(super::value::number)
    {
        let warm = blackbody::rec709(kelvin);
        color = [0, 1, 2].map(|i| color[i] * warm[i]);
    }
    let shaping = shaping(prim, diagnostics);
    if matches!(shape, Shape::Cylinder { .. }) && shaping != Shaping::default() {
        diagnostics.report(
            "light-shaping",
            Verdict::Lost,
            "cones of cylinder lights",
            &*path,
            "they shine to all sides",
        );
    }
    Some(Lamp {
        name: name.into(),
        path,
        shape,
        color: color.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 }),
        strength: (number("intensity", intensity) * number("exposure", 0.0).exp2()).max(0.0),
        normalize: truth("normalize") == Some(true),
        shaping,
        shadows: value("shadow:enable")
            .as_ref()
            .and_then(super::value::truth)
            != Some(false),
        of_blender,
    })
}

fn dome(prim: &View, kind: &str, diagnostics: &mut Diagnostics) -> Dome {
    let format = prim.value_of(&["inputs:texture:format", "texture:format"]);
    let format = format.as_ref().and_then(super::value::word);
    if let Some(format) = format.filter(|f| !matches!(&**f, "automatic" | "latlong")) {
        diagnostics.report(
            "dome-format",
            Verdict::Approximated,
            format!("dome lights with an image of the format \"{format}\""),
            prim.path().to_string(),
            "read as one of latitudes and longitudes",
        );
    }
    let pole = match prim.word("poleAxis").as_deref() {
        Some("Z") => Pole::Z,
        Some("Y") => Pole::Y,
        Some("scene") => Pole::Scene,
        _ if kind == "DomeLight_1" => Pole::Scene,
        _ => Pole::Y,
    };
    let image = prim.asset("inputs:texture:file");
    Dome {
        image: image.or_else(|| prim.asset("texture:file")),
        pole,
    }
}

fn shaping(prim: &View, diagnostics: &mut Diagnostics) -> Shaping {
    let number = |name: &str| {
        let names = [format!("inputs:shaping:{name}"), format!("shaping:{name}")];
        let value = prim.value_of(&[&names[0], &names[1]]);
        value
            .as_ref()
            .and_then(super::value::number)
            .filter(|v| v.is_finite())
    };
    let half = number("cone:angle").unwrap_or(180.0).to_radians();
    let softness = number("cone:softness").unwrap_or(0.0).clamp(0.0, 1.0);
    let ies = ["inputs:shaping:ies:file", "shaping:ies:file"];
    if ies.iter().any(|name| prim.asset(name).is_some()) {
        diagnostics.report(
            "light-ies",
            Verdict::Lost,
            "IES profiles of lights",
            prim.path().to_string(),
            "the lights shine the same in all directions of theirs",
        );
    }
    Shaping {
        cone: (half < PI).then(|| (half.max(0.0), softness)),
        focus: number("focus").unwrap_or(0.0).max(0.0),
    }
}

fn report_textures(prim: &View, shape: &Shape, diagnostics: &mut Diagnostics) {
    let textured = !matches!(shape, Shape::Dome(_));
    if textured && prim.asset("inputs:texture:file").is_some() {
        diagnostics.report(
            "light-texture",
            Verdict::Lost,
            "images on area lights",
            prim.path().to_string(),
            "they shine in their colour",
        );
    }
}

/// What a light says, but is not rendered.
fn report_rest(prim: &View, diagnostics: &mut Diagnostics) {
    for name in ["diffuse", "specular"] {
        if prim
            .number(&format!("inputs:{name}"))
            .is_some_and(|v| v != 1.0)
        {
            diagnostics.report(
                "light-parts",
                Verdict::Lost,
                format!("lights with a multiplier for {name} reflections"),
                prim.path().to_string(),
                "they light all alike",
            );
        }
    }
    let linked = |what: &str| {
        let root = format!("collection:{what}:includeRoot");
        let includes = format!("collection:{what}:includes");
        prim.truth(&root) == Some(false) || !prim.targets(&includes).is_empty()
    };
    for (what, does) in [("lightLink", "light"), ("shadowLink", "cast shadows of")] {
        if linked(what) {
            diagnostics.report(
                "light-linking",
                Verdict::Lost,
                format!("lights that {does} some objects only ({what})"),
                prim.path().to_string(),
                format!("they {does} all objects"),
            );
        }
    }
    if !prim.targets("light:filters").is_empty() {
        diagnostics.report(
            "light-filter",
            Verdict::Lost,
            "filters of lights",
            prim.path().to_string(),
            "left out",
        );
    }
}
