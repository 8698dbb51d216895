//! The path loop, generic over the effects compiled into it.

mod accumulator;
mod direct;
mod path;
mod record;
mod settings;

pub use path::{Path, meet, trace, trace_apart};
pub use record::{End, Fault, Lit, Record, Recorder, Scattered, Scattering, Step, first_fault};
pub use settings::PathSettings;

use crate::camera::CameraRay;
use crate::effects::{
    Box, ENVIRONMENT, GLOSS, General, INSTANCES, LAMPS, MESH_LIGHTS, METAL, Mask, Matte, Opaque,
    PATHS, SMOOTH_NORMALS, SUNS,
};
use crate::film::apart::PathApart;
use crate::sampler::Sampler;
use crate::world::World;

/// A kernel: the path loop for a set of effects.
pub type Kernel = fn(&World, &PathSettings, &Sampler, &CameraRay) -> Path;

/// A kernel that keeps the light apart for passes.
pub type ApartKernel = fn(&World, &PathSettings, &Sampler, &CameraRay, &mut PathApart) -> Path;

/// The one for all scenes.
pub const APART: ApartKernel = trace_apart::<General, PathApart>;

/// A kernel that tells each step.
pub type RecordingKernel = fn(&World, &PathSettings, &Sampler, &CameraRay, &mut Recorder) -> Path;

/// The one for all scenes: its radiance has the bits of every other kernel that has what a scene calls for.
pub const RECORDING: RecordingKernel = trace_apart::<General, Recorder>;

/// The one that has everything.
pub const GENERAL: (Mask, Kernel) = (PATHS, trace::<General>);

const LIGHTS: Mask = LAMPS | MESH_LIGHTS | SUNS | ENVIRONMENT;
const MATTE: Mask = LIGHTS | SMOOTH_NORMALS | INSTANCES;

/// The kernels there are, smallest first. State and code of the effects that a kernel lacks are
/// not in it. Each saves at least 2 % of the instructions on scenes that call for no more: what saves less is a branch in the
/// general one (textures, cut-outs, normal maps and glass beside facets: 0.4 to 1.5 %; docs/notes/effects.md has the table).
pub const KERNELS: [(Mask, Kernel); 4] = [
    (MESH_LIGHTS, trace::<Box>),
    (MATTE, trace::<Matte>),
    (MATTE | METAL | GLOSS, trace::<Opaque>),
    GENERAL,
];

/// The smallest kernel that has all the effects of a set, as far as they are the path loop's.
pub fn kernel_for(effects: Mask) -> (Mask, Kernel) {
    let effects = effects & PATHS;
    KERNELS
        .into_iter()
        .find(|(mask, _)| mask & effects == effects)
        .unwrap_or(GENERAL)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{COMPILED, TRANSMISSION};

    #[test]
    fn every_set_has_a_kernel_and_the_smallest_is_taken() {
        for subset in 0u32..1 << COMPILED.len() {
            let units = COMPILED.iter().enumerate();
            let units = units.filter(|(i, _)| subset >> i & 1 == 1);
            let set = units.fold(0, |set, (_, (unit, _))| set | unit);
            let (mask, _) = kernel_for(set);
            assert_eq!(mask & set, set);
        }
        assert_eq!(kernel_for(MESH_LIGHTS).0, MESH_LIGHTS);
        assert_eq!(kernel_for(SUNS).0, MATTE);
        assert_eq!(kernel_for(SUNS | GLOSS).0, MATTE | METAL | GLOSS);
        assert_eq!(kernel_for(TRANSMISSION).0, PATHS);
    }
}
