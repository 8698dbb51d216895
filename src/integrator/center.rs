//! What passes of data hold of the ray through a pixel's middle.

use super::path::first_hit;
use crate::camera::CameraRay;
use crate::effects::General;
use crate::film::objects::FirstObject;
use crate::sampler::Sampler;
use crate::world::{Asking, RayKind, Sender, World};
use glam::{Vec2, Vec3};

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
pub fn center(world: &World, sampler: &Sampler, ray: &CameraRay) -> Option<Center> {
    let hit = first_hit(world, sampler, ray)?;
    let sender = Sender {
        near: ray.near,
        time: ray.time,
        ..RayKind::Camera.into()
    };
    let mut moment = None;
    let asking = Asking::of(&sender, ray.direction, &hit);
    let surface = world.surface::<General>(&hit, ray.origin, asking, &mut moment);
    Some(Center {
        normal: surface.normals.shading,
        uv: world.texture_coordinates(&hit),
        object: FirstObject {
            number: hit.object(),
            weight: 1.0,
            distance: world.camera.distance(surface.point.point),
        },
    })
}
