//! Light below a surface by how much of it comes out at which distance: the profile of Christensen and Burley, *Approximate
//! Reflectance Profiles for Efficient Subsurface Scattering*, 2015. Where it comes out is found by rays along one of three
//! axes through a disc about the point of entry (King, Kulla, Conty and Fajardo, *BSSRDF Importance Sampling*, 2013).
//!
//! What is estimated is Cycles' sum over these rays, which is none over areas: places count by the profile's density over
//! distances at their true distance, divided by the density at the ray's distance from the axis. On a plane both are the same.

use crate::math::Frame;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Beyond so many of its lengths a profile is nothing, as in Cycles.
const REACH: f32 = 16.0;
/// The share of it that lies within: 1 − e^(−16)/4 − 3 e^(−16/3)/4.
const WITHIN: f32 = 0.996_379;
/// How often rays go along the normal, and along each axis across it.
const ALONG: f32 = 0.5;
const ACROSS: f32 = 0.25;

/// How much light comes out at which distance, by channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// d of the paper, metres; 0: the channel has none.
    lengths: Vec3,
    /// How many channels have some.
    channels: f32,
}

impl Profile {
    /// By the lengths of the channels, metres.
    pub fn new(lengths: Vec3) -> Self {
        let there = lengths.cmpgt(Vec3::ZERO);
        Self {
            lengths,
            channels: there.bitmask().count_ones() as f32,
        }
    }

    /// 1/m: what comes out at a distance, all about. Its integral is 1.
    pub fn density(&self, distance: f32) -> Vec3 {
        let there =
            self.lengths.cmpgt(Vec3::ZERO) & (self.lengths * REACH).cmpgt(Vec3::splat(distance));
        let lengths = Vec3::select(there, self.lengths, Vec3::ONE);
        // e^(−r/d) is the cube of e^(−r/3d).
        let third = (-distance / (3.0 * lengths)).exp();
        let sum = third * third * third + third;
        Vec3::select(there, sum / (4.0 * WITHIN * lengths), Vec3::ZERO)
    }

    fn mean_density(&self, distance: f32) -> f32 {
        self.density(distance).element_sum() / self.channels
    }

    /// A distance by the density of one of the channels, and how far that reaches.
    fn draw(&self, u: f32) -> (f32, f32) {
        let mut left = u * self.channels;
        let mut length = 0.0;
        for channel in self.lengths.to_array() {
            if channel > 0.0 {
                length = channel;
                if left < 1.0 {
                    break;
                }
                left -= 1.0;
            }
        }
        // The share 1 − s³/4 − 3s/4 lies within −3 ln s lengths: s³ + 3s = 4v is sinh 3t = 2v with s = 2 sinh t.
        let beyond = 1.0 - left.clamp(0.0, 1.0) * WITHIN;
        let s = 2.0 * (inverse_sinh(2.0 * beyond) / 3.0).sinh();
        let distance = (-3.0 * s.ln()).clamp(0.0, REACH);
        (distance * length, REACH * length)
    }
}

/// Of what is positive, without cancellation. The library's own asks for `hypotf` of glibc 2.35, which older systems don't have.
fn inverse_sinh(x: f32) -> f32 {
    (x + x * x / (1.0 + (1.0 + x * x).sqrt())).ln_1p()
}

/// A ray through the disc: where it meets the object, light comes out.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Where it starts.
    pub origin: Vec3,
    /// Where to, a unit vector.
    pub direction: Vec3,
    /// How far.
    pub far: f32,
    profile: Profile,
    point: Vec3,
    /// Its own axis first, each with how often rays go along it.
    axes: [(Vec3, f32); 3],
    /// Of the distance from its axis.
    density: f32,
}

impl Probe {
    /// By two numbers in 0..1, for light that enters at a point with a unit normal.
    pub fn new(profile: Profile, point: Vec3, normal: Vec3, u: Vec2) -> Self {
        let (x, y) = across(normal);
        let (normal, x, y) = ((normal, ALONG), (x, ACROSS), (y, ACROSS));
        let (axes, before) = if u.y < ALONG {
            ([normal, x, y], 0.0)
        } else if u.y < ALONG + ACROSS {
            ([x, normal, y], ALONG)
        } else {
            ([y, x, normal], ALONG + ACROSS)
        };
        let [(axis, often), (first, _), (second, _)] = axes;
        let (sin, cos) = (TAU * (u.y - before) / often).sin_cos();
        let (distance, reach) = profile.draw(u.x);
        let height = (reach * reach - distance * distance).max(0.0).sqrt();
        Self {
            origin: point + axis * height + (first * cos + second * sin) * distance,
            direction: -axis,
            far: 2.0 * height,
            profile,
            point,
            axes,
            density: profile.mean_density(distance),
        }
    }

    /// What a place so far along the ray, where the object has this unit normal, counts: the three axes together by the power
    /// heuristic of what each would find there.
    pub fn weight(&self, along: f32, normal: Vec3) -> Vec3 {
        let finds = self
            .axes
            .map(|(axis, often)| often * axis.dot(normal).abs());
        let squares: f32 = finds.iter().map(|f| f * f).sum();
        let there = self.origin + self.direction * along;
        let share = finds[0] / (squares * self.density);
        if share.is_finite() {
            self.profile.density(there.distance(self.point)) * share
        } else {
            Vec3::ZERO
        }
    }
}

/// Two axes across a normal. How places are weighed depends on them: they are those of Cycles, across the diagonal of
/// Blender's axes, which is (1, 1, −1) in glTF's.
fn across(normal: Vec3) -> (Vec3, Vec3) {
    let x = Vec3::new(1.0, 1.0, -1.0).cross(normal);
    match x.try_normalize() {
        Some(x) => (x, normal.cross(x)),
        None => {
            let frame = Frame::from_normal(normal);
            (frame.x, frame.y)
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/medium/profile.rs"]
mod tests;
