//! Where rays start that leave surfaces.

use crate::effects::Features;
use crate::integrator::settings::PathSettings;
use crate::world::{Hit, Surface, World};
use glam::Vec3;

/// How far rays start off surfaces in toy renderers, metres.
const NAIVE_OFFSET: f32 = 1e-4;

/// Where a ray starts that leaves a surface; `None` where the surface is in its way.
#[inline]
pub(in crate::integrator) fn spawn_ray<E: Features>(
    world: &World,
    settings: &PathSettings,
    (hit, surface): (&Hit, &Surface),
    direction: Vec3,
    beyond: bool,
) -> Option<Vec3> {
    naive::<E>(settings, surface, direction)
        .or_else(|| world.ray_origin::<E>(hit, surface, direction, beyond))
}

/// The same of a ray to a light.
#[inline]
pub(in crate::integrator) fn spawn_light_ray<E: Features>(
    world: &World,
    settings: &PathSettings,
    (hit, surface): (&Hit, &Surface),
    direction: Vec3,
    beyond: bool,
) -> Option<Vec3> {
    naive::<E>(settings, surface, direction)
        .or_else(|| world.light_ray_origin::<E>(hit, surface, direction, beyond))
}

/// Where toy renderers start it, if that is asked for.
#[inline(always)]
fn naive<E: Features>(settings: &PathSettings, surface: &Surface, direction: Vec3) -> Option<Vec3> {
    (E::EVERYTHING && settings.naive_offsets).then(|| {
        let normal = surface.normals.geometric;
        surface.point.point + normal * NAIVE_OFFSET.copysign(direction.dot(normal))
    })
}
