//! What the first surfaces tell passes of the scene's own (Blender's AOVs), and how they move.
//!
//! As in Cycles (kernel/svm/aov.h, kernel/film/data_passes.h): values are not weighted, and each surface is heard that the
//! ray of the camera meets up to the first of which enough is there (by Cycles' "Alpha Threshold" of passes). A fainter one lets the ray through as often as
//! Cycles chooses its transparency among its closures; the others have a motion, as has the world. A way of its own, so that path loops
//! know nothing of it.

use super::PathSettings;
use super::path::{KernelBsdf, is_enough};
use crate::camera::CameraRay;
use crate::effects::General;
use crate::math::average;
use crate::math::float::{RAY_START, ray_origin};
use crate::sampler::{Dimension, Sampler};
use crate::world::{Asking, RayKind, Scratch, Sender, Surface, Wanted, World};
use glam::{Vec2, Vec3};

/// Sums of motion vectors: to before, from after, and how many there are.
pub const VECTOR_SUMS: usize = 5;
/// Surfaces that a ray passes at the most.
pub(super) const MOST_PASSED: u32 = 1024;

/// Adds what a ray of the camera is told to the sums of its pixel; the rays that it took.
pub fn add_aovs(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    ray: &CameraRay,
    (sums, vectors): (&mut [f64], Option<&mut [f64; VECTOR_SUMS]>),
) -> u32 {
    let (mut origin, mut span) = (ray.origin, (ray.near, ray.far));
    let direction = ray.direction;
    let mut sender = Sender {
        time: ray.time,
        near: ray.near,
        ..RayKind::Camera.into()
    };
    for passed in 0..settings.transparent_left(0).min(MOST_PASSED) {
        let Some(hit) = world.first((origin, direction, span), &sender) else {
            world.add_aovs_around(direction, sums);
            if let Some(moves) = world.vectors_around(direction) {
                add_vectors(vectors, || moves);
            }
            return passed + 1;
        };
        let asking = Asking::of(&sender, direction, &hit);
        let (passes, rest) = world.add_aovs(&hit, asking, sums);
        if is_enough(settings, passes) {
            add_vectors(vectors, || world.vectors(&hit));
            return passed + 1;
        }
        let mut scratch = Scratch::default();
        let mut surface =
            world.surface::<General>(&hit, (origin, asking), Wanted::Lobes, &mut scratch);
        let share = average(passes);
        let others = rest * scattered(settings, direction, &mut surface);
        let drawn = sampler.triple_behind(Dimension::Bsdf, 0, passed).z;
        if drawn * (share + others) >= share {
            return passed + 1;
        }
        sender.walked += hit.distance;
        origin = ray_origin(surface.point, -surface.normals.geometric);
        span = (RAY_START, f32::INFINITY);
    }
    MOST_PASSED
}

/// Adds a motion, and that there is one.
fn add_vectors(sums: Option<&mut [f64; VECTOR_SUMS]>, moves: impl FnOnce() -> [Vec2; 2]) {
    if let Some(sums) = sums {
        let [before, after] = moves();
        let all = [before.x, before.y, after.x, after.y, 1.0];
        let sums = sums.iter_mut().zip(all);
        sums.for_each(|(sum, value)| *sum += f64::from(value));
    }
}

/// How much a surface scatters of what does not pass straight on, as Cycles weighs closures when it chooses one.
fn scattered(settings: &PathSettings, direction: Vec3, surface: &mut Surface) -> f32 {
    if surface.is_unlit() {
        return 0.0;
    }
    let changes = settings.changes::<General>(f32::INFINITY, RayKind::Camera, false);
    let mut bsdf = KernelBsdf::<General>::new(surface.normals, -direction, surface.inside, changes);
    match &mut surface.mixed {
        Some(mixed) => mixed.add_to(&mut bsdf, surface.normals.smooth),
        None => {
            let frame = (surface.normals.shading, None);
            bsdf.add_principled(1.0, surface.principled(), surface.dielectrics, frame);
        }
    }
    bsdf.finish();
    average(bsdf.albedo())
}
