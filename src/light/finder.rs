//! Which lamps a ray meets, where they are many.

use super::kinds::Light;
use crate::ffi::embree::{self, CommittedScene, Device, EmbreeError, Ray, TriangleMesh};
use glam::Vec3;
use std::sync::Arc;

/// Lamps with a size in Embree. They are a scene of their own, as rays go through them.
pub struct Finder {
    scene: CommittedScene,
    /// By the number of the geometry, then of the primitive: the light.
    lights: [Vec<u32>; 2],
    /// The longest way inside of a lamp's sphere.
    widest: f32,
}

/// Share by which lamps are larger for Embree: the exact test follows. 2⁻¹⁶ covers the roundings of its
/// intersections, which at the edge of a quadrilateral are a few units in the last place of its corners.
const LARGER: f32 = 1.0 / 65_536.0;

impl Finder {
    /// For the lights with these numbers.
    ///
    /// # Errors
    /// If Embree fails.
    pub fn new(lights: &[Light], sized: &[u32], device: &Device) -> Result<Self, EmbreeError> {
        let (mut spheres, mut of_sphere) = (Vec::new(), Vec::new());
        let (mut corners, mut triangles, mut of_triangle) = (Vec::new(), Vec::new(), Vec::new());
        for &number in sized {
            match lights[number as usize].plain() {
                Light::Lamp(lamp) => {
                    // A disc that turns with the point is inside of its sphere.
                    let c = lamp.center;
                    let rounding = c.abs().max_element() * 4.0 * f32::EPSILON;
                    spheres.push([c.x, c.y, c.z, lamp.radius * (1.0 + LARGER) + rounding]);
                    of_sphere.push(number);
                }
                Light::Area(area) => {
                    let first = corners.len() as u32;
                    corners.extend(area.corners(LARGER).map(|c| c.to_array()));
                    triangles.push([first, first + 1, first + 2]);
                    triangles.push([first, first + 2, first + 3]);
                    of_triangle.extend([number; 2]);
                }
                // Surfaces are met among themselves, and what is at infinity where a ray meets nothing.
                Light::Triangle(_)
                | Light::Rectangle(_)
                | Light::Sun(_)
                | Light::Environment(_)
                | Light::Computed(_) => {}
            }
        }
        let widest = spheres.iter().map(|s| 2.0 * s[3]).fold(0.0, f32::max);
        let mut scene = embree::Scene::new(device, true)?;
        // The geometries have the numbers 0, 1, … in the order in which they are added.
        let mut lights = [Vec::new(), Vec::new()];
        if !spheres.is_empty() {
            let id = scene.add_spheres(&spheres)?;
            lights[id as usize] = of_sphere;
        }
        if !triangles.is_empty() {
            let mesh = Arc::new(TriangleMesh::new(corners, triangles)?);
            let id = scene.add_triangles(&mesh, true, u32::MAX)?;
            lights[id as usize] = of_triangle;
        }
        Ok(Self {
            scene: scene.commit()?,
            lights,
            widest,
        })
    }

    /// Lights that a ray may meet, in their order.
    pub fn along(&self, origin: Vec3, wi: Vec3, far: f32) -> Vec<u32> {
        let ray = Ray {
            origin: origin.to_array(),
            direction: wi.to_array(),
            near: 0.0,
            // A ray from inside of a sphere may meet its disc and end before it leaves the sphere.
            far: far.max(self.widest),
            mask: u32::MAX,
            time: 0.0,
        };
        let mut met = Vec::new();
        self.scene.intersect_filtered(&ray, |hit| {
            met.push(self.lights[hit.geometry as usize][hit.primitive as usize]);
            false
        });
        // Embree asks in any order, perhaps twice (both sides of a sphere, both triangles of an edge).
        met.sort_unstable();
        met.dedup();
        met
    }
}
