//! What programs ask of a point's neighbourhood, by rays: ambient occlusion, the Bevel node, and edges.

use super::asking::Around;
use super::geometry::unit_or_zero;
use super::place::{HitPoint, between};
use super::view::{from_blender, to_blender};
use crate::effects::General;
use crate::ffi::embree::Hit;
use crate::math::float::{self, BoundedPoint};
use crate::sampler::{Dimension, Sampler};
use crate::scene::graph::function::PlaceInput;
use crate::shading::program::{Met, Openness, Place};
use glam::Vec3;

/// A ray that looks for its own object passes no more surfaces.
const MOST_SURFACES: u32 = 64;

/// How often the Bevel node's rays go along the normal, and along each tangent.
const SHARES: [f32; 3] = [0.5, 0.25, 0.25];

/// The kernel of the Bevel node: the cubic one, (R − r)³ of a radius R.
mod bevel {
    use std::f32::consts::PI;

    /// Its density at a distance.
    pub fn density(radius: f32, r: f32) -> f32 {
        let x = (1.0 - r / radius).max(0.0);
        10.0 / (PI * radius * radius) * (x * x * x)
    }

    /// The distance, of a radius of 1, within which a share of it lies: 10x² − 20x³ + 15x⁴ − 4x⁵, or 1 − y⁴(5 − 4y) for y = 1 − x. By Newton's
    /// steps from the end that is nearer, where a root of the share is nearly straight.
    pub fn radius(share: f32) -> f32 {
        let near = share < 0.5;
        let rest = 1.0 - share;
        let mut x = if near {
            let x = (0.1 * share).sqrt();
            x * (1.0 + x)
        } else {
            let y = (0.2 * rest).max(0.0).sqrt().sqrt();
            1.0 - y * (1.0 + 0.25 * y)
        };
        for _ in 0..3 {
            let y = 1.0 - x;
            let off = if near {
                x * x * (10.0 + x * (-20.0 + x * (15.0 - 4.0 * x))) - share
            } else {
                rest - y * y * (y * y) * (5.0 - 4.0 * y)
            };
            // The slope is nothing at both ends alone, where the start is the root.
            let slope = 20.0 * x * (y * y * y);
            x -= off / slope.max(f32::MIN_POSITIVE);
            x = x.clamp(0.0, 1.0);
        }
        x
    }
}

#[cfg(test)]
#[path = "../../tests/unit/world/neighbourhood.rs"]
mod tests;

/// Two unit vectors that make a right-handed frame with a normal, in Blender's axes: those that Cycles takes.
pub(super) fn across(n: Vec3) -> [Vec3; 2] {
    let first = if n.x != n.y || n.x != n.z {
        Vec3::new(n.z - n.y, n.x - n.z, n.y - n.x)
    } else {
        Vec3::new(n.z - n.y, n.x + n.z, -n.y - n.x)
    };
    let first = first.normalize_or_zero();
    [first, n.cross(first)]
}

/// Two random numbers for one of some samples of a path: points of one sequence that all paths of the pixel share, as in
/// Cycles. What becomes of the mean of few (a Bevel brings it to unit length) hangs on how they lie.
fn spread((sampler, bounce): (Sampler, u32), (sample, of): (u32, u8)) -> [f32; 2] {
    let part = sampler.of_pixel().part(sample, of.into());
    part.pair(Dimension::Opacity, bounce).to_array()
}

/// Where a ray starts that leaves a surface in a direction.
fn origin_towards((point, outside): (BoundedPoint, Vec3), direction: Vec3) -> Vec3 {
    let is_inside = outside.dot(direction) < 0.0;
    float::ray_origin(point, if is_inside { -outside } else { outside })
}

impl HitPoint<'_> {
    /// Where a ray meets its object, so often at most.
    fn local_hits<'b>(
        &'b self,
        around: &'b dyn Around,
        (origin, direction, [near, far]): (Vec3, Vec3, [f32; 2]),
        most: usize,
    ) -> impl Iterator<Item = Hit> + 'b {
        let mut from = near;
        let mut left = MOST_SURFACES;
        std::iter::from_fn(move || {
            while left > 0 {
                left -= 1;
                let (hit, is_own) = around.meets(
                    (origin, direction, [from, far], self.asking.time),
                    self.entry,
                )?;
                from = hit.distance.next_up();
                if is_own {
                    return Some(hit);
                }
            }
            None
        })
        .take(most)
    }

    /// The share of rays about a normal that meet nothing within a distance.
    pub(super) fn open_share(&self, normal: Vec3, distance: f32, rays: Openness) -> f32 {
        let (Some(around), true) = (self.around, distance > 0.0 && rays.samples > 0) else {
            return 1.0;
        };
        let numbers = self.asking.past.numbers();
        let normal = from_blender(normal);
        let (tangent, across) = normal.any_orthonormal_pair();
        let point = self
            .entry
            .point::<General>(self.mesh, self.triangle, self.u, self.v);
        let outside = self.geometric_normal();
        let mut open = 0u32;
        for sample in 0..u32::from(rays.samples) {
            let [turn, share] = spread(numbers, (sample, rays.samples));
            let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
            let radius = share.sqrt();
            let up = (1.0 - share).max(0.0).sqrt();
            let direction = (tangent * cos + across * sin) * radius + normal * up;
            let origin = origin_towards((point, outside), direction);
            let shut = if rays.only_local {
                let ray = (origin, direction, [0.0, distance]);
                self.local_hits(around, ray, 1).next().is_some()
            } else {
                around.is_shut(origin, direction, (distance, self.asking.time))
            };
            open += u32::from(!shut);
        }
        open as f32 / f32::from(rays.samples)
    }

    /// The Bevel node's normal, in Blender's axes.
    pub(super) fn beveled_normal(&self, radius: f32, samples: u8) -> Vec3 {
        let own = to_blender(self.side(self.outer_normal()));
        let Some(around) = self.around else {
            return own;
        };
        if radius <= 0.0 || samples == 0 || self.asking.past.blurry {
            return own;
        }
        let numbers = self.asking.past.numbers();
        let point = self.in_world();
        let geometric = self.geometric_normal();
        let geometric = self.side(geometric);
        let [tangent, across] = across(to_blender(geometric)).map(from_blender);
        let frames = [
            [geometric, tangent, across],
            [tangent, geometric, across],
            [across, tangent, geometric],
        ];
        let mut sum = Vec3::ZERO;
        for sample in 0..u32::from(samples) {
            let [mut axis, share] = spread(numbers, (sample, samples));
            // Half of the rays along the normal, a quarter along each tangent (King, Kulla, Conty and Fajardo, *BSSRDF Importance
            // Sampling*, 2013).
            let which = if axis < 0.5 {
                axis *= 2.0;
                0
            } else if axis < 0.75 {
                axis = (axis - 0.5) * 4.0;
                1
            } else {
                axis = (axis - 0.75) * 4.0;
                2
            };
            let [along, first, second] = frames[which];
            let (sin, cos) = (axis * std::f32::consts::TAU).sin_cos();
            let beside = bevel::radius(share) * radius;
            let height = (radius * radius - beside * beside).max(0.0).sqrt();
            let origin = point + along * height + (first * cos + second * sin) * beside;
            let ray = (origin, -along, [0.0, 2.0 * height]);
            for hit in self.local_hits(around, ray, 16) {
                let (face, smooth) = around.normals(&hit);
                let at = origin - along * hit.distance;
                let weights = [geometric, tangent, across].map(|axis| axis.dot(face).abs());
                // The power heuristic over the axes.
                let densities = [0, 1, 2].map(|axis| weights[axis] * SHARES[axis]);
                let all: f32 = densities.iter().map(|d| d * d).sum();
                let weight = densities[which] / all.max(f32::MIN_POSITIVE);
                let far = bevel::density(radius, at.distance(point));
                sum +=
                    smooth * (weight * far / bevel::density(radius, beside).max(f32::MIN_POSITIVE));
            }
        }
        let mean = unit_or_zero(sum);
        if mean == Vec3::ZERO {
            own
        } else {
            to_blender(self.side(mean))
        }
    }

    /// What a ray meets from a place on, in Blender's axes. It does not meet the triangle that it starts on.
    pub(super) fn met_along(
        &self,
        (from, direction, length): (Vec3, Vec3, f32),
        only_local: bool,
    ) -> Option<Met> {
        let around = self.around?;
        let here = self.input(PlaceInput::Position).truncate();
        let along = from_blender(direction);
        let is_sane = from.is_finite() && along.is_finite() && length > 0.0;
        if !is_sane || along == Vec3::ZERO {
            return None;
        }
        let origin = if from == here {
            let outside = self.geometric_normal();
            let point = self
                .entry
                .point::<General>(self.mesh, self.triangle, self.u, self.v);
            origin_towards((point, outside), along)
        } else {
            self.in_world() + from_blender(from - here)
        };
        let ray = (origin, along, [0.0, length]);
        let (hit, is_own) = if only_local {
            (self.local_hits(around, ray, 1).next()?, true)
        } else {
            around.meets((origin, along, ray.2, self.asking.time), self.entry)?
        };
        let (face, smooth) = around.normals(&hit);
        let normal = if face.dot(along) > 0.0 {
            -smooth
        } else {
            smooth
        };
        Some(Met {
            is_own,
            distance: hit.distance,
            normal: to_blender(normal),
        })
    }

    /// Whether an edge of the triangle is within a width.
    pub(super) fn is_near_edge(&self, width: f32, pixels: bool) -> bool {
        let mut width = 0.5 * width;
        if pixels {
            // What a pixel is wide across the surface, projected to the viewer, by the tangents that Cycles takes.
            let normal = self.geometric_normal();
            let n = to_blender(self.side(normal));
            let view = to_blender(self.asking.direction).normalize_or_zero();
            let pixel = self.pixel();
            let seen = across(n).map(|t| (t - view * t.dot(view)).length() * pixel);
            width *= 0.5 * (seen[0] + seen[1]);
        }
        let corners = self.entry.world_corners(self.mesh, self.triangle);
        let p = between(corners, self.u, self.v);
        (0..3).any(|i| {
            let (at, before) = (corners[i], corners[(i + 2) % 3]);
            let edge = at - before;
            let across = edge.cross(p - at).length_squared();
            across < edge.length_squared() * (width * width)
        })
    }
}
