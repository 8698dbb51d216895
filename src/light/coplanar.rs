//! Area lights that lie in one plane and on each other, in files from Blender.
//!
//! A ray of Cycles goes on from a lamp just behind its distance, so that it does not find a second one there: light sampling counts
//! on both lamps, and the share that rays would find of the second one is lost. Which of them is the first, and whether the other is that near,
//! is a matter of rounding: distances are computed here as there.

use crate::scene;
use glam::{DVec3, Vec3};

/// The plane of an area light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal of its bright side.
    normal: Vec3,
    /// How far along that it is, from the origin of the file.
    height: f32,
    /// The world's origin along that.
    origin: f32,
}

/// Planes whose heights differ by more units in the last place of the largest coordinate have nothing in common: rays find both.
const SAME: f32 = 8.0 * f32::EPSILON;

/// A product as Cycles adds it up, by the order of Blender's axes.
#[inline]
fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.z * b.z + a.y * b.y
}

impl Plane {
    /// Of an area light of a file.
    pub fn of(light: &scene::Light, origin: DVec3) -> Option<Self> {
        let place = &light.world_from_light;
        let axis = place.matrix3.z_axis.as_vec3();
        let normal = -axis * (1.0 / dot(axis, axis).sqrt());
        let is_area = matches!(light.kind, scene::LightKind::Area { .. });
        (is_area && normal.is_finite()).then(|| Self {
            normal,
            height: dot(place.translation.as_vec3(), normal),
            origin: dot(origin.as_vec3(), normal),
        })
    }

    fn is_near(&self, other: &Self) -> bool {
        let reach = self.height.abs().max(other.height.abs()).max(1.0) * SAME;
        self.normal.dot(other.normal) > 1.0 - 1e-6 && (self.height - other.height).abs() <= reach
    }

    /// Along a ray, rounded as in Cycles.
    #[inline]
    fn distance(&self, origin: Vec3, direction: Vec3) -> f32 {
        -((dot(origin, self.normal) + self.origin) - self.height) / dot(direction, self.normal)
    }
}

/// Which lamps lie in one plane.
#[derive(Debug)]
pub struct Coplanar {
    /// By the number of a lamp its plane, and the other lamps in it.
    lamps: Vec<Option<(Plane, Vec<u32>)>>,
}

impl Coplanar {
    /// By the planes of lamps; `None` if no two have one in common.
    pub fn new(planes: &[Option<Plane>]) -> Option<Self> {
        let others = |own: &Plane, number: usize| {
            let in_it = |other: &Option<Plane>| other.is_some_and(|other| own.is_near(&other));
            let all = (0..planes.len()).filter(|&i| i != number && in_it(&planes[i]));
            all.map(|i| i as u32).collect::<Vec<u32>>()
        };
        let lamps: Vec<_> = (planes.iter().enumerate())
            .map(|(number, plane)| {
                let plane = (*plane)?;
                let others = others(&plane, number);
                (!others.is_empty()).then_some((plane, others))
            })
            .collect();
        lamps.iter().any(Option::is_some).then_some(Self { lamps })
    }

    /// Whether a ray that meets a lamp has met another one so near before it that it does not find this one. `meets`: whether it meets
    /// a lamp.
    #[inline]
    pub fn is_hidden(
        &self,
        lamp: u32,
        (origin, direction): (Vec3, Vec3),
        meets: impl Fn(u32) -> bool,
    ) -> bool {
        let plane = |lamp: u32| self.lamps.get(lamp as usize).and_then(Option::as_ref);
        let Some((own, others)) = plane(lamp) else {
            return false;
        };
        let distance = own.distance(origin, direction);
        others.iter().any(|&other| {
            let Some((beside, _)) = plane(other) else {
                return false;
            };
            let before = beside.distance(origin, direction);
            // Of two in the same place the first lamp is met.
            let is_first = before < distance || (before == distance && other < lamp);
            is_first && distance <= before.next_up() && meets(other)
        })
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/coplanar.rs"]
mod tests;
