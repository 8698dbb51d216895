//! SUNDOG_scene: what the file wishes of the render and of the display.

use std::path::{Path, PathBuf};

use super::container::{Document, inside};
use super::extensions::report_properties;
use super::schema::{FastGiJson, SundogScene};
use crate::color::SearchPlaces;
use crate::math::primaries::WorkingSpace;
use crate::scene::{
    Aov, ColorManagement, Diagnostics, FastGi, FastGiMethod, RenderDefaults, Scene, Shutter,
    Verdict,
};

/// More passes of its own has no scene.
const MOST_AOVS: usize = 256;

/// Puts the extension's values into the scene. A file that it names lies beside the scene's, at `path`.
pub(super) fn apply(
    extension: &SundogScene,
    (path, allow_outside): (&Path, bool),
    scene: &mut Scene,
    diagnostics: &mut Diagnostics,
) {
    let unknown = |properties: &_, diagnostics: &mut Diagnostics| {
        report_properties("SUNDOG_scene", properties, "scene", diagnostics);
    };
    unknown(&extension.unknown, diagnostics);
    if let Some(colors) = &extension.color_management {
        unknown(&colors.unknown, diagnostics);
        let given = |text: &Option<String>| text.clone().filter(|text| !text.is_empty());
        scene.color_management = ColorManagement {
            config: given(&colors.config)
                .and_then(|name| find_config(&name, (path, allow_outside), diagnostics)),
            display: given(&colors.display),
            view: given(&colors.view),
            look: given(&colors.look),
            exposure: colors.exposure,
            gamma: colors.gamma,
            working_space: WorkingSpace::default(),
        };
    }
    if let Some(render) = &extension.render {
        unknown(&render.unknown, diagnostics);
        scene.render = RenderDefaults {
            width: render.width,
            height: render.height,
            filter_width: render.filter_width,
            transparent: render.transparent,
            transparent_glass: render
                .transparent_glass
                .filter(|roughness| (0.0..=1.0).contains(roughness)),
            film_exposure: render.film_exposure,
        };
    }
    scene.light_groups.clone_from(&extension.light_groups);
    if let Some(shutter) = &extension.shutter {
        unknown(&shutter.unknown, diagnostics);
        scene.shutter = Shutter {
            curve: shutter.curve.clone(),
            rolling: shutter.rolling,
            still: shutter.still,
            objects_alone: shutter.objects_alone,
        };
    }
    if let Some(gi) = &extension.fast_gi {
        unknown(&gi.unknown, diagnostics);
        scene.fast_gi = fast_gi(gi, diagnostics);
    }
    if let Some(limit) = &extension.texture_limit {
        unknown(&limit.unknown, diagnostics);
    }
    for aov in &extension.aovs {
        unknown(&aov.unknown, diagnostics);
    }
    if let Some(name) = &extension.working_space {
        let known = WorkingSpace::ALL.into_iter().find(|s| s.name() == name);
        if known.is_none() {
            diagnostics.report(
                "working-space",
                Verdict::Lost,
                format!("the working space \"{name}\""),
                "scene",
                "its colours are taken as linear Rec.709: Sundog knows Linear Rec.709, Linear Rec.2020 and ACEScg",
            );
        }
        scene.color_management.working_space = known.unwrap_or_default();
    }
}

/// What stands for indirect light, if it is something that is known and changes anything.
fn fast_gi(gi: &FastGiJson, diagnostics: &mut Diagnostics) -> Option<FastGi> {
    let method = match gi.method.as_str() {
        // As in Cycles, none and a factor of 0 are off.
        "replace" if gi.bounces == 0 => return None,
        "replace" => Some(FastGiMethod::Replace {
            bounces: gi.bounces,
        }),
        "add" => Some(FastGiMethod::Add),
        _ => None,
    };
    let is_number = |value: f32| value.is_finite() && value >= 0.0;
    let Some(method) = method.filter(|_| is_number(gi.factor) && is_number(gi.distance)) else {
        diagnostics.report(
            "fast-gi",
            Verdict::Lost,
            "an unknown kind of fast GI",
            "scene",
            "all bounces are traced",
        );
        return None;
    };
    (gi.factor > 0.0).then_some(FastGi {
        method,
        factor: gi.factor,
        distance: gi.distance,
    })
}

/// The passes of the scene's own; of two with one name the first.
pub(super) fn aovs(extension: Option<&SundogScene>) -> Vec<Aov> {
    let mut all: Vec<Aov> = Vec::new();
    for aov in extension.iter().flat_map(|extension| &extension.aovs) {
        if all.len() < MOST_AOVS && all.iter().all(|known| known.name != aov.name) {
            all.push(Aov {
                name: aov.name.clone(),
                is_color: aov.kind == "COLOR",
            });
        }
    }
    all
}

/// The space that a file's colours are in, before it is known which of its scenes is shown.
pub(super) fn working_space(document: &Document) -> WorkingSpace {
    let mut extensions = document.graph.scenes.iter().map(|s| &s.extensions);
    let name = extensions.find_map(|e| e.sundog.as_ref()?.working_space.as_deref());
    let known = |name: &str| WorkingSpace::ALL.into_iter().find(|s| s.name() == name);
    name.and_then(known).unwrap_or_default()
}

/// The configuration that a scene names. One that lies elsewhere counts only if this machine uses it anyway, as does that of
/// the Blender which exported the scene here.
fn find_config(
    name: &str,
    (path, allow_outside): (&Path, bool),
    diagnostics: &mut Diagnostics,
) -> Option<PathBuf> {
    if name.starts_with("ocio://") {
        return Some(name.into());
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    match inside(folder, Path::new(name), allow_outside) {
        Ok(config) => Some(config),
        Err(config) if SearchPlaces::of_this_process().has(&config) => Some(config),
        Err(_) => {
            diagnostics.report(
                "outside-config",
                Verdict::Lost,
                "colour configuration outside of the scene's folder",
                name,
                "the usual search takes its place; --ocio names another, --allow-outside reads this one",
            );
            None
        }
    }
}
