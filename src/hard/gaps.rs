//! Self-intersection and gaps: rays leave the surface on which they start and no closed surface lets one through.

use super::kit::{camera, diffuse, place, prepared, quad};
use super::{Case, Effort, Finding};
use crate::effects::Mask;
use crate::ffi::embree::Hit;
use crate::math::{Frame, float, warp};
use crate::render::RenderError;
use crate::sampler::hashed;
use crate::scene::{RayKind, Scene};
use crate::world::World;
use glam::{DAffine3, DVec3, Vec2, Vec3};

/// The cases.
pub const CASES: &[Case] = &[Case {
    name: "planes-through-the-camera",
    about: "Walls in the planes x = 0, y = 0 and z = 0 of the camera, whose points have no rounding error: rays that leave them meet nothing.",
    run: planes_through_the_camera,
}];

/// No effects: the queries alone.
const PLAIN: Mask = 0;
const FOREVER: (f32, f32) = (float::RAY_START, f32::INFINITY);

fn meet(world: &World, origin: Vec3, direction: Vec3) -> Option<Hit> {
    world.intersect::<PLAIN>(origin, direction, FOREVER, RayKind::Diffuse, 0)
}

fn planes_through_the_camera(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let rays: u32 = effort.of(10_000, 1_000_000, 10_000_000);
    let mut findings = Vec::new();
    for axis in 0..3 {
        let (u, v) = (Vec3::AXES[(axis + 1) % 3], Vec3::AXES[(axis + 2) % 3]);
        let wall = quad(
            (u * 1.0 - v * 2.5).to_array(),
            (u * 3.0).to_array(),
            (v * 5.0).to_array(),
        );
        let mut scene = Scene::default();
        place(&mut scene, wall, diffuse([0.5; 3]), &[DAffine3::IDENTITY]);
        scene.cameras.push(camera(DVec3::ZERO, 1.0));
        let world = prepared(&scene)?;
        let (mut met, mut again) = (0u64, 0);
        for i in 0..rays {
            let number = |d: u32| hashed(d, i, 5);
            let to = u * (1.1 + 2.8 * number(0)) + v * (4.8 * number(1) - 2.4);
            let from = to + warp::sphere(Vec2::new(number(2), number(3))) * 2.0;
            let Some(hit) = meet(&world, from, to - from) else {
                continue;
            };
            met += 1;
            let surface = world.surface::<PLAIN>(&hit, from, to - from);
            let n = surface.normals.geometric;
            let direction = Frame::from_normal(n)
                .to_world(warp::cosine_hemisphere(Vec2::new(number(4), number(5))));
            let origin = float::ray_origin(surface.point, n, direction);
            again += u64::from(meet(&world, origin, direction).is_some());
        }
        let name = ["x", "y", "z"][axis];
        // From within the plane itself it is not met: one direction in 2^23.
        findings.push(Finding::new(
            format!("rays that met the plane {name} = 0"),
            f64::from(rays),
            met as f64,
            f64::from(rays) * 1e-3,
        ));
        findings.push(Finding::none(
            format!("rays from the plane {name} = 0 that met it again"),
            again,
        ));
    }
    Ok(findings)
}
