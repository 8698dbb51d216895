//! Light that node trees compute.

use crate::scene::RayKind;
use glam::{Vec2, Vec3};

/// A point of a light as its node tree sees it: glTF's axes, relative to the world's origin.
#[derive(Clone, Copy, Debug)]
pub struct ShinePoint {
    /// Where it is; of light from all around, the direction to it.
    pub position: Vec3,
    /// The side that shines.
    pub normal: Vec3,
    /// Toward the one who looks, unit length.
    pub incoming: Vec3,
    /// Where on the light.
    pub uv: Vec2,
    /// From the one who looks; the greatest number at infinity.
    pub distance: f32,
    /// Who looks.
    pub ray: LookingRay,
}

impl ShinePoint {
    /// Of light from all around.
    pub fn around(direction: Vec3, ray: LookingRay) -> Self {
        Self {
            position: direction,
            normal: -direction,
            incoming: -direction,
            uv: Vec2::ZERO,
            distance: f32::MAX,
            ray,
        }
    }
}

/// The ray that looks at a light, as Cycles' Light Path node tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LookingRay {
    /// The bit of its kind ([`crate::scene::RayKind::bit`]).
    pub kind: u32,
    /// "Ray Depth": Cycles counts the way to a light as one.
    pub depth: u32,
}

impl LookingRay {
    /// Of a ray that is met by a lamp, after so many bounces before where it left: to lamps it is of no kind.
    pub fn to_lamp(kind: RayKind, bounces: u32) -> Self {
        Self::sampling(bounces + u32::from(kind != RayKind::Camera))
    }

    /// Of light sampling after so many bounces: it is of no kind, for all that a surface scatters is taken together.
    pub fn sampling(bounces: u32) -> Self {
        Self {
            kind: 0,
            depth: bounces + 1,
        }
    }
}

/// What computes a light's radiance, or the factor of it.
pub trait LightProgram: std::fmt::Debug + Send + Sync {
    /// At a point of the light.
    fn emitted(&self, at: &ShinePoint) -> Vec3;
}
