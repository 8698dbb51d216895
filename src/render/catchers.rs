//! Paths that meet shadow catchers: once more, in a world of the catchers alone.

use super::{EffectChoice, RenderSettings};
use crate::camera::RayMaker;
use crate::effects::{self, Effect};
use crate::film::catchers::{Caught, Split};
use crate::integrator::Kernel;
use crate::scene::Scene;
use crate::world::World;
use glam::Vec3;

/// Whether a picture of a scene has shadow catchers.
pub fn has_catchers(scene: &Scene, settings: &RenderSettings) -> bool {
    scene.has_catchers()
        && match &settings.effects {
            EffectChoice::Auto | EffectChoice::All => true,
            // A list that can't be read is told when the scene is prepared.
            EffectChoice::List(list) => {
                effects::parse(list).is_ok_and(|set| set.contains(Effect::ShadowCatcher))
            }
        }
}

/// The catchers alone, ready for paths.
pub struct CatcherWorld {
    /// In Embree.
    pub world: World,
    /// For that world.
    pub kernel: Kernel,
}

/// The same, as threads share it.
pub struct CatcherJob<'a> {
    /// In Embree.
    pub world: &'a World,
    /// For that world.
    pub kernel: Kernel,
    /// Of its camera.
    pub camera_ray: RayMaker,
}

impl<'a> CatcherJob<'a> {
    /// For paths that begin now.
    pub fn new(made: &'a CatcherWorld) -> Self {
        Self {
            world: &made.world,
            kernel: made.kernel,
            camera_ray: made.world.camera.ray_maker(),
        }
    }
}

/// A path that has met a catcher, with what it finds in a world of catchers alone and what the world shines behind.
pub fn caught(split: Split, alone: Vec3, behind: Vec3) -> Caught {
    Caught {
        split,
        alone: split.throughput * alone,
        behind: split.throughput * behind,
    }
}
