//! Where the origin of the world is: positions are f32 about it.

use crate::math::float::UNIT_ROUNDOFF;
use crate::math::motion;
use crate::scene::{Camera, Instance, LightKind, Projection, Scene};
use glam::{DAffine3, DVec3};

/// The origin, and what all that can be seen is in where the camera is far away from it.
pub struct Origin {
    /// Subtracted from all positions.
    pub at: DVec3,
    /// Middle (relative to `at`) and radius.
    pub distant: Option<(DVec3, f64)>,
}

/// Middle and radius of all that has a place; `None` where there is nothing.
pub type Extent = Option<(DVec3, f64)>;

/// Middle and radius of all that has a place in a scene. A medium of all space is everywhere: no camera is far from it, and
/// rays go through it from the camera on.
pub fn extent(scene: &Scene) -> Extent {
    bounds(scene)
        .filter(|_| scene.medium.is_none())
        .map(|(low, high)| ((low + high) * 0.5, (high - low).length() * 0.5))
}

/// Whether a camera is far away from all there is.
pub fn is_far(extent: Extent, camera: &Camera) -> bool {
    let eye = camera.world_from_camera.translation;
    let panorama = camera.projection.is_panorama();
    extent.is_some_and(|(middle, radius)| !panorama && (eye - middle).length() > FAR * radius)
}

/// Whether positions about an origin are good enough for a camera that is not far away. Rounded to f32 they are within u·d of
/// where they are, with d the camera's distance from the origin; that is at most a sixteenth of what a pixel sees at the near
/// plane, of a picture that has 4096.
pub fn is_good(origin: DVec3, camera: &Camera) -> bool {
    const PIXELS: f64 = 4096.0;
    let moved = (camera.world_from_camera.translation - origin).length();
    let pixel = match camera.projection {
        Projection::Perspective { vertical_fov, .. } => {
            2.0 * (0.5 * vertical_fov).tan() * camera.clip_near / PIXELS
        }
        Projection::Orthographic { half_height, .. } => 2.0 * half_height / PIXELS,
        Projection::Equirectangular { .. } | Projection::Panorama { .. } => {
            std::f64::consts::PI * camera.clip_near / PIXELS
        }
    };
    moved * f64::from(UNIT_ROUNDOFF) <= pixel / 16.0
}

/// A camera that is more radii than this from the middle of a scene is far away. From nearer by, positions about the
/// camera are good to 17 u = 1e-6 of the radius: a 500th of a pixel of a picture of the whole that has 1000.
const FAR: f64 = 16.0;

impl Origin {
    /// None.
    pub const NAIVE: Self = Self {
        at: DVec3::ZERO,
        distant: None,
    };

    /// The camera is where precision matters, as floats are densest about it; from far away it is the scene.
    pub fn new(scene: &Scene, camera: &Camera) -> Self {
        let extent = extent(scene);
        match extent.filter(|_| is_far(extent, camera)) {
            // A little more than the radius: vertices are rounded to f32.
            Some((middle, radius)) => Self {
                at: middle,
                distant: Some((DVec3::ZERO, radius * (1.0 + 1e-6))),
            },
            None => Self {
                at: camera.world_from_camera.translation,
                distant: None,
            },
        }
    }
}

/// Corners of the box about all that has a place; `None` where there is nothing.
fn bounds(scene: &Scene) -> Option<(DVec3, DVec3)> {
    let boxes: Vec<Option<(DVec3, DVec3)>> = scene.meshes.iter().map(mesh_bounds).collect();
    let placed = scene.instances.iter().filter_map(|instance| {
        let (low, high) = boxes[instance.mesh.0 as usize]?;
        let corner = |i: u32| {
            let pick = |axis: usize| {
                if i >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let at = |place: DAffine3| (0..8).map(move |i| place.transform_point3(corner(i)));
        Some(hull(places(instance).into_iter().flat_map(at)))
    });
    let lights = scene.lights.iter().filter_map(|light| {
        let m = &light.world_from_light.matrix3;
        let reach = match light.kind {
            LightKind::Sun { .. } => return None,
            LightKind::Point { radius, .. } | LightKind::Spot { radius, .. } => {
                DVec3::splat(f64::from(radius))
            }
            LightKind::Area { size: [x, y], .. } => {
                m.x_axis.abs() * f64::from(x) + m.y_axis.abs() * f64::from(y)
            }
        };
        let at = light.world_from_light.translation;
        Some((at - reach, at + reach))
    });
    let join = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
    placed.chain(lights).reduce(join)
}

/// Where an object is: if it moves, at some of all times.
fn places(instance: &Instance) -> Vec<DAffine3> {
    const TIMES: u16 = 64;
    if instance.motion.is_empty() {
        return vec![instance.world_from_object];
    }
    let parts = motion::decompose(&instance.motion);
    let time = |i| f32::from(i) / f32::from(TIMES);
    (0..=TIMES).map(|i| motion::at(&parts, time(i))).collect()
}

fn hull(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    })
}

fn mesh_bounds(mesh: &crate::scene::Mesh) -> Option<(DVec3, DVec3)> {
    let corner = |&[x, y, z]: &[f32; 3]| DVec3::new(f64::from(x), f64::from(y), f64::from(z));
    let used = !mesh.triangles.is_empty() && !mesh.positions.is_empty();
    let steps = mesh.motion.iter().flat_map(|step| &step.positions);
    used.then(|| hull(mesh.positions.iter().chain(steps).map(corner)))
}

#[cfg(test)]
#[path = "../../tests/unit/world/origin.rs"]
mod tests;
