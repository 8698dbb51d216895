//! What the ray through a pixel's middle meets: depth, position and indices, and other passes of data on request.

use super::PathSettings;
use super::aovs::MOST_PASSED;
use super::path::{HeldOut, Tinted, is_enough, tinted};
use crate::camera::CameraRay;
use crate::effects::General;
use crate::film::objects::FirstObject;
use crate::film::pixel::CenterSample;
use crate::math::average;
use crate::math::float::RAY_START;
use crate::sampler::{Dimension, Sampler, hashed};
use crate::world::{Asking, Hit, Passage, RayKind, Scratch, Sender, Wanted, World};
use glam::{Vec2, Vec3};

/// Tells the numbers of fog on the way from those of opacity.
const FOG: u32 = 0x_0f06_0da7;

/// The surface that it meets.
#[derive(Clone, Copy, Debug)]
pub struct Center {
    /// Shading normal.
    pub normal: Vec3,
    /// First texture coordinates.
    pub uv: Vec2,
    /// Its object, all of the sample.
    pub object: FirstObject,
}

/// What a ray of the camera meets.
pub fn center(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    ray: &CameraRay,
) -> Option<Center> {
    let (origin, hit) = first_hit(world, settings, sampler, ray)?;
    let sender = Sender {
        near: ray.near,
        time: ray.time,
        ..RayKind::Camera.into()
    };
    let mut scratch = Scratch::default();
    let asking = Asking::of(&sender, ray.direction, &hit);
    let surface = world.surface::<General>(&hit, (origin, asking), Wanted::Lobes, &mut scratch);
    Some(Center {
        normal: surface.normals.shading,
        uv: world.texture_coordinates(&hit),
        object: FirstObject {
            number: hit.object(),
            weight: 1.0,
            there: 1.0,
            distance: world.camera.distance(surface.point.point),
            ..FirstObject::default()
        },
    })
}

/// What a ray of the camera meets, as in Cycles (kernel/film/data_passes.h): the first surface of which enough is there, or a fainter
/// one where the ray stops. A holdout counts as nothing, one that lets light pass as a whole surface.
fn first_hit(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    ray: &CameraRay,
) -> Option<(Vec3, Hit)> {
    let mut passed_last = None;
    let (mut origin, mut span) = (ray.origin, (ray.near, ray.far));
    let mut sender = Sender {
        time: ray.time,
        near: ray.near,
        ..RayKind::Camera.into()
    };
    let (mut within, mut passage) = (world.media_at_camera(), Passage::default());
    for passed in 0..MOST_PASSED {
        let numbers = (sampler, 0);
        let hit = world.intersect::<General>(origin, ray.direction, span, sender, numbers)?;
        if world.is_holdout(&hit) {
            let asking = Asking::of(&sender, ray.direction, &hit);
            let tint = world.tint(&hit, asking);
            let passes = tint.is_some_and(|(passes, _)| passes != Vec3::ZERO);
            return if passes {
                Some((origin, hit))
            } else {
                passed_last
            };
        }
        if world.has_priorities() {
            let inside = (&within, &mut passage);
            let is_there = world.interface(inside, (&hit, ray.direction), 0.0);
            if is_there.is_none() {
                world.cross(&mut within, &hit, ray.direction);
                sender.walked += hit.distance;
                origin = world.straight_on(&hit, ray.direction).0;
                span = (RAY_START, f32::INFINITY);
                continue;
            }
        }
        if !world.is_tinted() {
            return Some((origin, hit));
        }
        let asking = Asking::of(&sender, ray.direction, &hit);
        let numbers = sampler.triple_behind(Dimension::Bsdf, 0, passed);
        match tinted::<General>(world, &hit, (origin, asking), (numbers, HeldOut::Share)) {
            Tinted::Passes(passing) if !is_enough(settings, passing.passes) => {
                passed_last = Some((origin, hit));
                sender.walked += hit.distance;
                (origin, span) = (passing.onward, (RAY_START, f32::INFINITY));
            }
            _ => return Some((origin, hit)),
        }
    }
    None
}

/// Whether the ray comes to a place, by chance: in Cycles a path that fog has scattered tells no data of surfaces.
fn comes_through(world: &World, sampler: &Sampler, ray: &CameraRay, place: Vec3) -> bool {
    if !world.has_fog() {
        return true;
    }
    let sender = Sender {
        time: ray.time,
        near: ray.near,
        ..RayKind::Camera.into()
    };
    let key = sampler.key(Dimension::Opacity, 0);
    let way = (ray.origin, ray.direction);
    let share = world.media_before(&world.media_at_camera(), way, Some(place), (&sender, key));
    // Its first sample knows of no light: three quarters of the choice is a half, and one what the way leaves.
    share == Vec3::ONE || hashed(key, FOG, 0) < 0.375 + 0.25 * average(share)
}

/// The same as passes tell of it, and its object's number.
pub fn meet(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    ray: &CameraRay,
) -> (CenterSample, Option<u32>) {
    let met = first_hit(world, settings, sampler, ray)
        .map(|(origin, hit)| (origin + ray.direction * hit.distance, hit))
        .filter(|(point, _)| comes_through(world, sampler, ray, *point));
    met.map_or((CenterSample::default(), None), |(point, hit)| {
        let center = CenterSample {
            depth: world.camera.depth(point),
            position: (world.origin + point.as_dvec3()).as_vec3(),
        };
        (center, Some(hit.object()))
    })
}
