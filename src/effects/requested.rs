//! What a render asks for beyond the scene.

use crate::scene::Effect;

/// What of the settings of a render is an effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RequestedSettings {
    /// The camera that renders, by its number.
    pub camera: usize,
    /// Passes that keep light apart, follow paths for denoisers, or tell objects.
    pub light_passes: bool,
    /// Passes of the ray through each pixel's middle.
    pub position_passes: bool,
    /// The pass of times.
    pub cost_pass: bool,
    /// Samples where the error is.
    pub adaptive: bool,
    /// A limit of contributions.
    pub clamping: bool,
    /// Rougher facets behind blurring bounces.
    pub filter_glossy: bool,
    /// A world that is no part of the picture.
    pub transparent_film: bool,
    /// A limit of transparent surfaces.
    pub transparent_limit: bool,
    /// No back faces.
    pub backface_culling: bool,
}

impl RequestedSettings {
    /// The effects of the settings, which of them are asked for, and by what.
    pub fn settings(&self) -> [(Effect, bool, &'static str); 9] {
        [
            (
                Effect::LightPasses,
                self.light_passes,
                "--passes, --denoise",
            ),
            (Effect::PositionPasses, self.position_passes, "--passes"),
            (Effect::CostPass, self.cost_pass, "--passes"),
            (
                Effect::AdaptiveSampling,
                self.adaptive,
                "--pixel-error, --noise-threshold",
            ),
            (
                Effect::Clamping,
                self.clamping,
                "--clamp-direct, --clamp-indirect",
            ),
            (Effect::FilterGlossy, self.filter_glossy, "--filter-glossy"),
            (
                Effect::TransparentFilm,
                self.transparent_film,
                "--transparent",
            ),
            (
                Effect::TransparentLimit,
                self.transparent_limit,
                "--bounces-transparent",
            ),
            (
                Effect::BackfaceCulling,
                self.backface_culling,
                "--backface-culling",
            ),
        ]
    }
}
