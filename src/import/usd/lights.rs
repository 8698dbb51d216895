//! UsdLux: what lamps say, before they are placed.

use std::f64::consts::PI;
use std::sync::Arc;

use super::domes::Layout;
use super::linking::Linked;
use super::source::{Source, View};
use super::{blackbody, ies};
use crate::nodes::ies::IesProfile;
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
    /// What each direction is multiplied by.
    pub ies: Option<Arc<IesProfile>>,
    /// The image on a rectangle: where it is, and how the file calls it.
    pub image: Option<(String, String)>,
    /// What it is for.
    pub linked: Linked,
    /// What Blender's own lamps have other than UsdLux says.
    pub of_blender: bool,
}

/// A version of Blender that wrote a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Blender {
    pub major: u32,
    minor: u32,
    /// Not a release: branches of others are among these, whose lamps have units of their own.
    alpha: bool,
}

impl Blender {
    /// By the words that its exporter leaves in a stage.
    pub(super) fn told(doc: &str) -> Option<Self> {
        let version = doc.split("Blender v").nth(1)?;
        let mut numbers = version.split(|c: char| !c.is_ascii_digit());
        Some(Self {
            major: numbers.next()?.parse().ok()?,
            minor: numbers.next().and_then(|n| n.parse().ok()).unwrap_or(0),
            alpha: version.contains("Alpha"),
        })
    }

    /// Whether its lamps are as old ones: releases of before 4.1, of which some of 4.0 say whether they are normalized.
    fn is_old(self, normalize: Option<bool>) -> bool {
        (self.major, self.minor) < (4, 1) && !self.alpha && normalize.is_none()
    }
}

/// What lamps of before Blender 4.1 say, as those of later ones say it.
///
/// They have a hundredth of a lamp's watts, a sun's strength as it is, no sun's angle, and a disk's diameter as its radius.
fn modern(shape: &mut Shape, strength: &mut f64, normalize: &mut bool) {
    match shape {
        Shape::Dome(_) => {}
        Shape::Distant { .. } => *strength *= 0.25,
        _ => {
            *strength *= 100.0 / PI;
            *normalize = true;
        }
    }
    if let Shape::Disk { radius } = shape {
        *radius *= 0.5;
    }
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
    pub layout: Layout,
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
    let blender = super::blender_version(source);
    let of_blender = blender.is_some();
    let (mut shape, intensity) = match kind {
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
            // Half an angle is what Blender writes, where it writes one.
            let unsaid = if of_blender { 0.265 } else { 0.53 };
            let angle = number("angle", unsaid).to_radians().clamp(0.0, PI);
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
    let image = image(prim, &shape, diagnostics);
    report_rest(prim, diagnostics);
    let color = value("color").as_ref().and_then(super::value::vector::<3>);
    let mut color = color.unwrap_or([1.0; 3]);
    if truth("enableColorTemperature") == Some(true) {
        let kelvin = value("colorTemperature");
        let kelvin = kelvin.as_ref().and_then(super::value::number);
        // Blender says so of all of its lamps, and gives a temperature to those alone that have one.
        let kelvin = kelvin.or((!of_blender).then_some(6500.0));
        let warm = kelvin.map_or([1.0; 3], blackbody::rec709);
        color = [0, 1, 2].map(|i| color[i] * warm[i]);
    }
    let shaping = shaping(prim);
    let ies = profile(prim, source, diagnostics);
    let shaped = shaping != Shaping::default() || ies.is_some();
    if matches!(shape, Shape::Cylinder { .. }) && shaped {
        diagnostics.report(
            "light-shaping",
            Verdict::Lost,
            "cones and IES profiles of cylinder lights",
            &*path,
            "they shine to all sides",
        );
    }
    let mut strength = (number("intensity", intensity) * number("exposure", 0.0).exp2()).max(0.0);
    let said = truth("normalize");
    let mut normalize = said == Some(true);
    if blender.is_some_and(|version| version.is_old(said)) {
        modern(&mut shape, &mut strength, &mut normalize);
    }
    Some(Lamp {
        name: name.into(),
        path,
        shape,
        color: color.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 }),
        strength,
        normalize,
        shaping,
        ies,
        image,
        linked: Linked::of(prim, source, diagnostics),
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
    let layout = format.as_deref().map(|format| (format, Layout::of(format)));
    if let Some((format, layout)) = layout.filter(|(_, l)| *l != Some(Layout::LatLong)) {
        diagnostics.report(
            "dome-format",
            Verdict::Approximated,
            format!("dome lights with an image of the format \"{format}\""),
            prim.path().to_string(),
            match layout {
                Some(_) => {
                    "drawn anew as one of latitudes and longitudes, with as many texels around"
                }
                None => "read as one of latitudes and longitudes",
            },
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
        layout: layout.and_then(|(_, layout)| layout).unwrap_or_default(),
    }
}

fn shaping(prim: &View) -> Shaping {
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
    Shaping {
        cone: (half < PI).then(|| (half.max(0.0), softness)),
        focus: number("focus").unwrap_or(0.0).max(0.0),
    }
}

/// The profile of a light's IES file.
fn profile(prim: &View, source: &Source, diagnostics: &mut Diagnostics) -> Option<Arc<IesProfile>> {
    let of = |name: &str| {
        [
            format!("inputs:shaping:ies:{name}"),
            format!("shaping:ies:{name}"),
        ]
    };
    let (place, called) = of("file").iter().find_map(|name| prim.asset(name))?;
    let value = |name: &str| {
        let names = of(name);
        prim.value_of(&[&names[0], &names[1]])
    };
    let scale = value("angleScale").as_ref().and_then(super::value::number);
    let scale = scale.filter(|scale| scale.is_finite()).unwrap_or(0.0);
    let normalize = value("normalize").as_ref().and_then(super::value::truth) == Some(true);
    let profile = source
        .files
        .read(&place)
        .and_then(|bytes| ies::profile(&bytes, normalize, scale));
    match profile {
        Ok(profile) => Some(Arc::new(profile)),
        Err(reason) => {
            diagnostics.report(
                "light-ies",
                Verdict::Lost,
                format!("IES profile \"{called}\" that cannot be read ({reason})"),
                prim.path().to_string(),
                "the light shines the same in all directions of its own",
            );
            None
        }
    }
}

/// The image on a rectangle. On other shapes UsdLux has none.
fn image(prim: &View, shape: &Shape, diagnostics: &mut Diagnostics) -> Option<(String, String)> {
    if matches!(shape, Shape::Dome(_)) {
        return None;
    }
    let image = prim.asset("inputs:texture:file");
    let image = image.or_else(|| prim.asset("texture:file"))?;
    if matches!(shape, Shape::Rect { .. }) {
        return Some(image);
    }
    diagnostics.report(
        "light-texture",
        Verdict::Lost,
        "images on lights that are no rectangles",
        prim.path().to_string(),
        "they shine in their colour",
    );
    None
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
    let tint = prim.value_of(&["inputs:shaping:focusTint", "shaping:focusTint"]);
    let tint = tint.as_ref().and_then(super::value::vector::<3>);
    if shaping(prim).focus > 0.0 && tint.is_some_and(|tint| tint != [0.0; 3]) {
        diagnostics.report(
            "light-shaping",
            Verdict::Lost,
            "tints of light beside its focus (focusTint)",
            prim.path().to_string(),
            "the light has its own colour everywhere",
        );
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

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/lights.rs"]
mod tests;
