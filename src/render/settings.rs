//! What a user can set.

use super::noise_threshold::NoiseThreshold;
use crate::effects::RequestedSettings;
use crate::film::objects::Mist;
use crate::film::{Pass, Passes};
pub use crate::sampler::Sequences;
pub use crate::world::{Ablation, InstructionSet, LightShares};
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use std::time::Duration;

/// Most light samples at a surface: the samples of a picture times these have numbers of 64 bits.
pub const MAX_LIGHT_SAMPLES: u32 = 64;
/// Most paths that go on from one first vertex.
pub const MAX_BRANCHES: u32 = 64;

/// How far ambient occlusion looks in a new world of Blender's, metres.
const AO_DISTANCE: f32 = 10.0;

/// Blender's threshold in a new file.
const ALPHA_THRESHOLD: f32 = 0.5;

fn is_blenders_threshold(threshold: &f32) -> bool {
    *threshold == ALPHA_THRESHOLD
}

fn is_blenders_distance(distance: &f32) -> bool {
    *distance == AO_DISTANCE
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// Settings of a render.
#[derive(Clone, Debug, Serialize)]
pub struct RenderSettings {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples a pixel; with a target for each pixel, at most.
    pub samples: u32,
    /// Number of the first of them: what others have taken before, or take elsewhere.
    pub first_sample: u32,
    /// End after this long, output included …
    pub time_limit: Option<Duration>,
    /// … of which so much was over when the render was called.
    #[serde(skip)]
    pub time_spent: Duration,
    /// Indirect bounces (0: direct light only), as Cycles counts "Max Bounces".
    pub bounces: u32,
    /// Limits for bounces of one kind, within `bounces`.
    pub bounce_limits: BounceLimits,
    /// Greatest value of one contribution of direct light, as Cycles' "Clamp Direct"; 0 for no limit.
    pub clamp_direct: f32,
    /// The same for indirect light.
    pub clamp_indirect: f32,
    /// How light samples are shared out. Clamped pictures depend on it.
    pub light_shares: LightShares,
    /// Cycles' "Filter Glossy": makes facets rougher behind blurring bounces; 0 for off.
    pub filter_glossy: f32,
    /// The world is no part of the picture where the camera looks straight at it (or through alpha).
    pub transparent_film: bool,
    /// The world is no part of it either where glass up to this roughness is before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transparent_glass: Option<f32>,
    /// Factor on all light of the picture, as Cycles' film exposure.
    pub film_exposure: f32,
    /// Which caustics paths may make.
    pub caustics: Caustics,
    /// Which passes are made.
    pub passes: Passes,
    /// Blender's mist, for the pass of its name.
    #[serde(skip_serializing_if = "Mist::is_default")]
    pub mist: Mist,
    /// How far the pass of ambient occlusion looks, metres.
    #[serde(skip_serializing_if = "is_blenders_distance")]
    pub ao_distance: f32,
    /// How much of a surface has to be there for passes of data (depth, position, indices, normals, texture coordinates, motion) to
    /// stop at it.
    #[serde(skip_serializing_if = "is_blenders_threshold")]
    pub alpha_threshold: f32,
    /// Passes of data (normals, texture coordinates, mist, Cryptomatte) are of the ray through each pixel's middle alone, as depths,
    /// positions and indices ever are.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub center_passes: bool,
    /// Stop when the estimated error of the picture is below this (0.02 is 2 %); 0 for no such target.
    pub error_target: f64,
    /// Take samples where the error is larger than this, and stop when it is nowhere; 0 for no such target.
    pub pixel_error_target: f64,
    /// Stop when what the observer says of the denoised picture is below this; 0 for no such target.
    #[serde(skip_serializing_if = "is_zero")]
    pub denoised_target: f64,
    /// Stop pixels as Cycles' noise threshold does; `None` for all samples everywhere. Not beside a target for each pixel.
    pub noise_threshold: Option<NoiseThreshold>,
    /// The part of the picture that is rendered; `None` for all of it.
    pub region: Option<Region>,
    /// Index into `Scene::cameras`; `None` takes the first.
    pub camera: Option<usize>,
    /// Selects another independent random sequence.
    pub seed: u32,
    /// How many sequences the samples of a pixel are of.
    #[serde(skip_serializing_if = "Sequences::are_two")]
    pub sequences: Sequences,
    /// Threads; `None` uses all.
    pub threads: Option<usize>,
    /// Instructions by which rays meet surfaces; `None` takes AVX2 where the processor has it. The last bits depend on it.
    pub instruction_set: Option<InstructionSet>,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Which effects the kernel is made for.
    pub effects: EffectChoice,
    /// Which sampling techniques find lights (for tests and studies; `Mis` is the one to use).
    pub light_sampling: LightSampling,
    /// Light samples at the surface that the camera sees; one at all others. For studies.
    pub light_samples: u32,
    /// Paths that go on from the first vertex of each sample, of which the mean counts; `None`: what suits the scene.
    pub branches: Option<u32>,
    /// From which bounce on paths may end by Russian roulette; `None` for none. For studies.
    pub roulette: Option<u32>,
    /// What keeps pictures stable and is left out. For studies.
    #[serde(rename = "naive")]
    pub ablation: Ablation,
    /// Hide the back faces of single-sided materials, as glTF's rasterisers do (Cycles shows them).
    pub cull_backfaces: bool,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 256,
            first_sample: 0,
            time_limit: None,
            time_spent: Duration::ZERO,
            bounces: 12,
            bounce_limits: BounceLimits::default(),
            light_shares: LightShares::ByPlace,
            clamp_direct: 0.0,
            clamp_indirect: 0.0,
            filter_glossy: 0.0,
            transparent_film: false,
            transparent_glass: None,
            film_exposure: 1.0,
            caustics: Caustics::default(),
            passes: Passes::default(),
            mist: Mist::default(),
            ao_distance: AO_DISTANCE,
            alpha_threshold: ALPHA_THRESHOLD,
            center_passes: false,
            error_target: 0.0,
            pixel_error_target: 0.0,
            denoised_target: 0.0,
            noise_threshold: None,
            region: None,
            camera: None,
            seed: 0,
            sequences: Sequences::default(),
            threads: None,
            instruction_set: None,
            filter: Filter::default(),
            effects: EffectChoice::Auto,
            light_sampling: LightSampling::Mis,
            light_samples: 1,
            branches: None,
            roulette: Some(2),
            ablation: Ablation::default(),
            cull_backfaces: false,
        }
    }
}

/// What paths do behind a diffuse reflection, as Cycles' switches of the same names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Caustics {
    /// They are reflected by metals, coats and glass.
    pub reflective: bool,
    /// They go through glass.
    pub refractive: bool,
}

impl Default for Caustics {
    fn default() -> Self {
        Self {
            reflective: true,
            refractive: true,
        }
    }
}

/// Most bounces of each kind on a path, as Cycles counts them; `None` for no limit but that of all
/// bounces together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BounceLimits {
    /// Diffuse reflections.
    pub diffuse: Option<u32>,
    /// Glossy reflections, mirrors included.
    pub glossy: Option<u32>,
    /// Passages through glass.
    pub transmission: Option<u32>,
    /// Scatterings by volumes.
    pub volume: Option<u32>,
    /// Surfaces passed by their opacity, which are not bounces.
    pub transparent: Option<u32>,
}

/// A rectangle of pixels of the full picture, origin at the top left; the ends are not included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Region {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// Column after the last.
    pub x1: u32,
    /// Row after the last.
    pub y1: u32,
}

impl Region {
    /// All of a picture.
    pub fn full(width: u32, height: u32) -> Self {
        Self {
            x0: 0,
            y0: 0,
            x1: width,
            y1: height,
        }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.x1 - self.x0
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.y1 - self.y0
    }
}

impl RenderSettings {
    /// What of them is an effect.
    pub fn requested(&self) -> RequestedSettings {
        RequestedSettings {
            camera: self.camera.unwrap_or(0),
            light_passes: self.passes.need_light_passes()
                || self.passes.need_features()
                || self.passes.need_objects()
                || self.passes.has(Pass::Aov)
                || self.passes.has(Pass::Vector),
            position_passes: self.passes.need_middle() || self.center_passes,
            cost_pass: self.passes.has(Pass::Cost),
            adaptive: self.pixel_error_target > 0.0 || self.noise_threshold.is_some(),
            clamping: self.clamp_direct > 0.0 || self.clamp_indirect > 0.0,
            filter_glossy: self.filter_glossy > 0.0,
            transparent_film: self.transparent_film,
            transparent_limit: self.bounce_limits.transparent.is_some(),
            backface_culling: self.cull_backfaces,
        }
    }

    /// The part of the picture that is rendered.
    pub fn region(&self) -> Region {
        self.region
            .unwrap_or_else(|| Region::full(self.width, self.height))
    }
}

/// A pixel filter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Filter {
    /// Shape.
    pub kind: FilterKind,
    /// Blender's filter width in pixels (ignored by the box, which is one pixel wide); what it
    /// means for each shape is said in `film::filter`.
    pub width: f32,
}

impl Default for Filter {
    /// Cycles' default.
    fn default() -> Self {
        Self {
            kind: FilterKind::BlackmanHarris,
            width: 1.5,
        }
    }
}

/// Filter shapes, as in Cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FilterKind {
    /// Every point of the pixel counts the same.
    Box,
    /// A Gaussian cut at the width.
    Gauss,
    /// Blackman-Harris window.
    BlackmanHarris,
}

/// Which effects the kernel is made for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EffectChoice {
    /// Those that the scene calls for.
    Auto,
    /// All that there are.
    All,
    /// These, by name; what the scene calls for beyond them is left out.
    List(Vec<String>),
}

/// Techniques that find light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LightSampling {
    /// Next-event estimation and BSDF sampling, weighted by multiple importance sampling.
    Mis,
    /// Next-event estimation alone wherever it can find the light.
    Nee,
    /// BSDF sampling alone wherever it can find the light.
    Bsdf,
    /// Light is met by chance alone wherever it can be: directions are drawn uniformly from the hemisphere
    /// (where light passes through, the sphere), whatever the BSDF.
    Hemisphere,
}

impl FromStr for Region {
    type Err = String;

    /// `X0,Y0,X1,Y1`; an error says what was expected.
    fn from_str(text: &str) -> Result<Self, String> {
        let region = text
            .split(',')
            .map(|part| part.trim().parse().ok())
            .collect::<Option<Vec<u32>>>()
            .and_then(|numbers| <[u32; 4]>::try_from(numbers).ok())
            .map(|[x0, y0, x1, y1]| Region { x0, y0, x1, y1 });
        region
            .filter(|region| region.x0 < region.x1 && region.y0 < region.y1)
            .ok_or_else(|| {
                "expected four whole numbers X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1".into()
            })
    }
}

/// Widest filter in pixels; Cycles allows 10 as well.
const MAX_FILTER_WIDTH: f32 = 10.0;
impl FromStr for Filter {
    type Err = String;

    /// `blackman-harris`, `gauss` or `box`, with `:WIDTH` in pixels after the first two; an error says what was expected.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, width) = match text.split_once(':') {
            Some((name, width)) => (name, Some(width)),
            None => (text, None),
        };
        let kind = match name {
            "blackman-harris" => FilterKind::BlackmanHarris,
            "gauss" => FilterKind::Gauss,
            "box" => FilterKind::Box,
            _ => return Err("expected blackman-harris, gauss or box".into()),
        };
        let width = match (kind, width) {
            (FilterKind::Box, Some(_)) => {
                return Err("the box filter is one pixel wide and takes no width".into());
            }
            (FilterKind::Box, None) => 1.0,
            (_, None) => Filter::default().width,
            (_, Some(width)) => width
                .parse()
                .ok()
                .filter(|width| *width >= 0.01 && *width <= MAX_FILTER_WIDTH)
                .ok_or_else(|| {
                    format!(
                        "expected a width from 0.01 to {MAX_FILTER_WIDTH} pixels after the colon"
                    )
                })?,
        };
        Ok(Filter { kind, width })
    }
}

impl FromStr for EffectChoice {
    type Err = String;

    /// `auto`, `all`, or names of effects with commas between them; an error says what was expected.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(EffectChoice::Auto),
            "all" => Ok(EffectChoice::All),
            _ => {
                let names: Vec<String> =
                    text.split(',').map(|name| name.trim().to_owned()).collect();
                if names.iter().any(String::is_empty) {
                    return Err(
                        "expected auto, all, or names of effects with commas between them".into(),
                    );
                }
                Ok(EffectChoice::List(names))
            }
        }
    }
}

/// Largest side of a picture in pixels.
pub const MAX_SIDE: u32 = 65_536;
/// Pixels of the longer side where the user gives no size.
const LONGER_SIDE: u32 = 1280;

/// What the user leaves open follows from the aspect (16:9 where the camera has none).
pub fn picture_size(aspect: Option<f64>, width: Option<u32>, height: Option<u32>) -> (u32, u32) {
    let default = RenderSettings::default();
    let aspect = aspect.unwrap_or(f64::from(default.width) / f64::from(default.height));
    // `as` saturates, and one pixel is the least.
    let side = |pixels: f64| (pixels.round() as u32).clamp(1, MAX_SIDE);
    match (width, height) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, side(f64::from(width) / aspect)),
        (None, Some(height)) => (side(f64::from(height) * aspect), height),
        (None, None) if aspect >= 1.0 => (LONGER_SIDE, side(f64::from(LONGER_SIDE) / aspect)),
        (None, None) => (side(f64::from(LONGER_SIDE) * aspect), LONGER_SIDE),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/render/settings.rs"]
mod tests;
