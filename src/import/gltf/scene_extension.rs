//! SUNDOG_scene: what the file wishes of the render and of the display.

use std::path::Path;

use super::extensions::report_properties;
use super::schema::SundogScene;
use crate::math::primaries::WorkingSpace;
use crate::scene::{ColorManagement, Diagnostics, RenderDefaults, Scene, Verdict};

/// Puts the extension's values into the scene. A file that it names lies beside the scene's, at `path`.
pub(super) fn apply(
    extension: &SundogScene,
    path: &Path,
    scene: &mut Scene,
    diagnostics: &mut Diagnostics,
) {
    let mut unknown = |properties: &_| {
        report_properties("SUNDOG_scene", properties, "scene", diagnostics);
    };
    unknown(&extension.unknown);
    if let Some(colors) = &extension.color_management {
        unknown(&colors.unknown);
        let given = |text: &Option<String>| text.clone().filter(|text| !text.is_empty());
        scene.color_management = ColorManagement {
            config: given(&colors.config).map(|config| {
                if config.starts_with("ocio://") {
                    config.into()
                } else {
                    // An absolute name stays what it is.
                    path.parent().unwrap_or(Path::new("")).join(config)
                }
            }),
            display: given(&colors.display),
            view: given(&colors.view),
            look: given(&colors.look),
            exposure: colors.exposure,
            gamma: colors.gamma,
            working_space: WorkingSpace::default(),
        };
    }
    if let Some(render) = &extension.render {
        unknown(&render.unknown);
        scene.render = RenderDefaults {
            width: render.width,
            height: render.height,
            filter_width: render.filter_width,
            transparent: render.transparent,
            film_exposure: render.film_exposure,
        };
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
