//! UsdRender: what a stage says of the picture.

use openusd::sdf::Path;

use super::source::{Source, View};
use super::value;
use crate::scene::{Camera, Diagnostics, RenderDefaults, Verdict};

/// Prims of the kinds RenderSettings and RenderProduct, in the order of the stage.
pub(super) struct Found<'a> {
    pub source: &'a Source,
    pub prims: &'a [Path],
}

/// Takes what is said of the picture. Its camera becomes the first one; `paths` are those of the cameras.
pub(super) fn apply(
    found: &Found,
    (paths, cameras): (&[String], &mut Vec<Camera>),
    render: &mut RenderDefaults,
    diagnostics: &mut Diagnostics,
) {
    // What a product says overrides the settings that name it.
    let mut wanted = None;
    let mut sharp = None;
    for prim in found.chosen(diagnostics) {
        if let Some([width, height]) = prim.vector::<2>("resolution") {
            let pixels = |v: f64| (1.0..=65536.0).contains(&v).then_some(v as u32);
            render.width = pixels(width).or(render.width);
            render.height = pixels(height).or(render.height);
        }
        wanted = prim.targets("camera").into_iter().next().or(wanted);
        sharp = prim.truth("disableDepthOfField").or(sharp);
        report_rest(&prim, diagnostics);
    }
    if sharp == Some(true) {
        cameras.iter_mut().for_each(|camera| camera.aperture = None);
    }
    let Some(wanted) = wanted.map(|path| path.to_string()) else {
        return;
    };
    match paths.iter().position(|path| *path == wanted) {
        Some(place) => cameras[..=place].rotate_right(1),
        None => tell(
            diagnostics,
            "camera of the render settings that is not there",
            &wanted,
            "the first camera of the stage is used",
        ),
    }
}

impl<'a> Found<'a> {
    /// The settings, and the product of theirs that overrides them.
    fn chosen(&self, diagnostics: &mut Diagnostics) -> Vec<View<'a>> {
        let named = self.source.metadata("renderSettingsPrimPath");
        let named = named.as_ref().and_then(value::word);
        let of_kind = |kind: &'static str| {
            let views = self.prims.iter().map(|path| self.source.view(path));
            views.filter(move |prim| prim.kind() == kind)
        };
        let all: Vec<View> = of_kind("RenderSettings").collect();
        let is_named = |prim: &View| Some(prim.path().to_string()) == named;
        let place = all.iter().position(is_named);
        match (&named, all.as_slice()) {
            (Some(named), _) if place.is_none() => tell(
                diagnostics,
                "render settings of the stage that are not there",
                named,
                "the first ones of the stage count, if there are some",
            ),
            (None, [_, others @ ..]) => {
                for other in others {
                    tell(
                        diagnostics,
                        "second and further render settings",
                        &other.path().to_string(),
                        "the first ones count, as the stage names none",
                    );
                }
            }
            _ => {}
        }
        let settings = all.into_iter().nth(place.unwrap_or(0));
        let mut products = match &settings {
            Some(settings) => {
                let targets = settings.targets("products");
                let there = targets.iter().filter(|path| self.prims.contains(path));
                there.map(|path| self.source.view(path)).collect()
            }
            None => of_kind("RenderProduct").collect::<Vec<View>>(),
        };
        for other in products.drain(1.min(products.len())..) {
            tell(
                diagnostics,
                "second and further products of a render",
                &other.path().to_string(),
                "the first one is rendered",
            );
        }
        settings.into_iter().chain(products).collect()
    }
}

/// What settings or a product say and that is not read.
fn report_rest(prim: &View, diagnostics: &mut Diagnostics) {
    let path = prim.path().to_string();
    let mut lost = |what: &str, instead: &str| tell(diagnostics, what, &path, instead);
    if prim
        .number("pixelAspectRatio")
        .is_some_and(|ratio| ratio != 1.0)
    {
        lost("pixels that are not square", "they are square");
    }
    let window = prim.vector::<4>("dataWindowNDC");
    if window.is_some_and(|window| window != [0.0, 0.0, 1.0, 1.0]) {
        lost(
            "parts of the picture (dataWindowNDC)",
            "all of it is rendered",
        );
    }
    let policy = prim.word("aspectRatioConformPolicy");
    if policy.is_some_and(|policy| policy != "expandAperture") {
        lost(
            "other ways to fit a camera into the picture (aspectRatioConformPolicy)",
            "the camera's picture is shown whole",
        );
    }
    let words = |name: &str| {
        prim.value(name)
            .as_ref()
            .map(value::words)
            .unwrap_or_default()
    };
    let ours = |purpose: &String| matches!(&**purpose, "default" | "render");
    if !words("includedPurposes").iter().all(ours) {
        lost(
            "purposes that the picture includes",
            "those for all and for the render are in it",
        );
    }
    let bindings = words("materialBindingPurposes");
    let full = |purpose: &String| matches!(&**purpose, "full" | "");
    if !bindings.is_empty() && !bindings.first().is_some_and(full) {
        lost(
            "purposes of materials that the picture asks for",
            "those for the full render come first",
        );
    }
    if prim
        .word("productType")
        .is_some_and(|kind| kind != "raster")
    {
        lost(
            "products of a render that are no raster",
            "a picture is rendered",
        );
    }
}

fn tell(diagnostics: &mut Diagnostics, what: &str, path: &str, instead: &str) {
    diagnostics.report("usd-render-settings", Verdict::Lost, what, path, instead);
}
