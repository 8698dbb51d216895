//! Area lights in the plane of a face, such as a lamp in its ceiling: which of the two is nearer is rounding's to decide. Cycles' shadow
//! rays end at a distance that is rounded in one way, and meet the face at one that Embree rounds in another.
//!
//! How often which is less hangs on the numbers. Of a lamp at a height of 7.42 a floor at 0 has 0.46 of the light and most walls 0.2;
//! so both are computed as there: in the file's own coordinates, and in the order of Blender's axes.

use crate::scene::coincident::OnFaces;
use glam::Vec3;
use std::collections::BTreeMap;

/// An area light with the faces in its plane; in Blender's axes.
pub(super) struct Lamp {
    axis: usize,
    /// Where the plane is on its axis.
    coordinate: f32,
    is_rectangle: bool,
    /// By entry and triangle.
    faces: BTreeMap<(u32, u32), [Vec3; 3]>,
}

/// Blender's x, y, z of a point in glTF's axes.
fn in_blender(p: Vec3) -> Vec3 {
    Vec3::new(p.x, -p.z, p.y)
}

/// 1/x as Embree has it: what a processor estimates, and one step of Newton's method, which ends below the exact value. The estimate's bits
/// differ between processors. Here it is the quotient rounded to steps that leave on average what an AMD EPYC's estimate does.
fn reciprocal(x: f32) -> f32 {
    // Of 2^23 in a binade.
    const STEP: u32 = 3 << 10;
    const MANTISSA: u32 = (1 << 23) - 1;
    let bits = x.recip().to_bits();
    let mantissa = (bits & MANTISSA).div_ceil(STEP) * STEP;
    let estimate = f32::from_bits((bits & !MANTISSA) + mantissa - STEP / 2);
    estimate.mul_add((-x).mul_add(estimate, 1.0), estimate)
}

/// A shadow ray to a point of a lamp, rounded as in Cycles.
pub(super) struct LampRay {
    from: Vec3,
    direction: Vec3,
    distance: f32,
}

impl Lamp {
    /// `entry` tells the entry of an instance.
    pub fn new(on: &OnFaces, is_rectangle: bool, entry: impl Fn(u32) -> u32) -> Self {
        let (axis, coordinate) = (on.plane.axis, on.plane.coordinate());
        let faces = on.faces.iter().map(|(&(instance, triangle), corners)| {
            ((entry(instance), triangle), corners.map(in_blender))
        });
        Self {
            axis: [0, 2, 1][axis],
            coordinate: if axis == 2 { -coordinate } else { coordinate },
            is_rectangle,
            faces: faces.collect(),
        }
    }

    /// The ray between two points of the file's space.
    pub fn ray(&self, from: Vec3, target: Vec3) -> LampRay {
        let (from, mut target) = (in_blender(from), in_blender(target));
        let axis = self.axis;
        target[axis] = if self.is_rectangle {
            // Points of rectangles are drawn in a frame around who is lit.
            from[axis] + (self.coordinate - from[axis])
        } else {
            self.coordinate
        };
        let way = target - from;
        let distance = way.length();
        LampRay {
            from,
            direction: way / distance,
            distance,
        }
    }

    /// Whether a face is met before the lamp; `None` for what is not in its plane.
    pub fn is_shut_by(&self, face: (u32, u32), ray: &LampRay) -> Option<bool> {
        let corners = self.faces.get(&face)?;
        Some(ray.distance_to(*corners, self.axis) <= ray.distance)
    }
}

impl LampRay {
    /// Distance to the plane of a triangle across an axis, as Embree's robust test rounds it: of the triangle's normal, from edges between
    /// corners that are relative to the ray's origin, the one component that is not zero.
    fn distance_to(&self, corners: [Vec3; 3], axis: usize) -> f32 {
        let [a, b, c] = corners.map(|corner| corner - self.from);
        let edges = [c - a, a - b, b - c];
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let cross = |first: Vec3, second: Vec3| {
            let product = first[j] * second[i];
            (product.abs(), first[i].mul_add(second[j], -product))
        };
        // Of two ways to compute it, the one that cancels less.
        let (first, second) = (cross(edges[0], edges[1]), cross(edges[1], edges[2]));
        let normal = if first.0 < second.0 {
            first.1
        } else {
            second.1
        };
        let toward = normal * self.direction[axis];
        (2.0 * (normal * a[axis])) * reciprocal(2.0 * toward)
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/world/lids/lamps.rs"]
mod tests;
