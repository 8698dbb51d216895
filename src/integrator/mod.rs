//! The path loop, generic over the effects compiled into it.

mod accumulator;
mod aovs;
mod center;
mod direct;
mod path;
mod record;
mod settings;

pub use aovs::{VECTOR_SUMS, add_aovs};
pub use center::{Center, center, meet};
pub use path::{Path, behind, trace, trace_with_passes};
pub use record::{End, Fault, Lit, Record, Recorder, Scattered, Scattering, Step, first_fault};
pub use settings::{Branches, PathSettings};

pub use crate::shading::bsdf::MOST_LOBES;

use crate::camera::CameraRay;
use crate::effects::{Box, ENVIRONMENT, Effect, Features, General, LAMPS, Matte, Opaque, PATHS};
use crate::film::features::PathFeatures;
use crate::film::light_passes::PathPasses;
use crate::sampler::Sampler;
use crate::world::World;
use enumset::{EnumSet, enum_set};

/// A kernel: the path loop for a set of effects.
pub type Kernel = fn(&World, &PathSettings, &Sampler, &CameraRay) -> Path;

/// A kernel that keeps the light apart for passes.
pub type PassKernel = fn(&World, &PathSettings, &Sampler, &CameraRay, &mut PathPasses) -> Path;

/// The one for all scenes.
pub const WITH_PASSES: PassKernel = trace_with_passes::<General, PathPasses>;

/// A kernel that tells denoisers what surfaces are like.
pub type FeatureKernel = fn(&World, &PathSettings, &Sampler, &CameraRay, &mut PathFeatures) -> Path;

/// The kernels for a set of effects: their radiance has the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Kernels {
    /// Of pictures without passes.
    pub plain: Kernel,
    /// Of those that are denoised.
    pub with_features: FeatureKernel,
}

impl Kernels {
    const fn of<E: Features>() -> Self {
        Self {
            plain: trace::<E>,
            with_features: trace_with_passes::<E, PathFeatures>,
        }
    }
}

/// A kernel that tells each step.
pub type RecordingKernel = fn(&World, &PathSettings, &Sampler, &CameraRay, &mut Recorder) -> Path;

/// The one for all scenes: its radiance has the bits of every other kernel that has what a scene calls for.
pub const RECORDING: RecordingKernel = trace_with_passes::<General, Recorder>;

/// The one that has everything.
pub const GENERAL: (EnumSet<Effect>, Kernels) = (PATHS, Kernels::of::<General>());

const BOX: EnumSet<Effect> = enum_set!(Effect::MeshLights);
const MATTE: EnumSet<Effect> = enum_set!(
    LAMPS
        | Effect::MeshLights
        | Effect::Suns
        | ENVIRONMENT
        | Effect::SmoothNormals
        | Effect::Instances
);
const OPAQUE: EnumSet<Effect> =
    enum_set!(MATTE | Effect::Metal | Effect::Gloss | Effect::DiffuseRoughness);

/// The kernels there are, smallest first. State and code of the effects that a kernel lacks are
/// not in it. Each saves at least 2 % of the instructions on scenes that call for no more: what saves less is a branch in the
/// general one (textures, cut-outs, normal maps and glass beside facets: 0.4 to 1.5 %; docs/notes/effects.md has the table).
pub const KERNELS: [(EnumSet<Effect>, Kernels); 4] = [
    (BOX, Kernels::of::<Box>()),
    (MATTE, Kernels::of::<Matte>()),
    (OPAQUE, Kernels::of::<Opaque>()),
    GENERAL,
];

/// The smallest kernel that has all the effects of a set, as far as they are the path loop's.
pub fn kernel_for(effects: EnumSet<Effect>) -> (EnumSet<Effect>, Kernels) {
    let effects = effects & PATHS;
    KERNELS
        .into_iter()
        .find(|(has, _)| has.is_superset(effects))
        .unwrap_or(GENERAL)
}

#[cfg(test)]
#[path = "../../tests/unit/integrator/mod.rs"]
mod tests;
