//! The ray that asks about a point of a surface, and the scene that it may ask in turn.

use super::geometry::MeshInstance;
use super::strand::LeftStrand;
use crate::ffi::embree::Hit;
use crate::sampler::{Sampler, Sequence};
use crate::scene::RayKind;
use crate::scene::graph::function::PathDepth;
use glam::Vec3;

/// The ray that asks.
#[derive(Clone, Copy, Debug)]
pub struct Asking<'p> {
    /// From where it comes.
    pub direction: Vec3,
    /// How far, also before what it has passed straight on.
    pub distance: f32,
    /// Where its length is counted from: the camera's near plane, as in Cycles.
    pub near: f32,
    /// The bit of its kind.
    pub kind: u32,
    /// Surfaces that have scattered its path.
    pub depth: u32,
    /// When it is on its way, 0 to 1.
    pub time: f32,
    /// What else is known of its path.
    pub past: &'p Past,
}

/// A ray's kind and what is known of its path.
#[derive(Clone, Copy, Debug)]
pub struct Sender<'p> {
    /// The kind.
    pub kind: RayKind,
    /// Surfaces that have scattered the path.
    pub depth: u32,
    /// How far the path has come since, to surfaces that it has passed.
    pub walked: f32,
    /// Where its length is counted from: the camera's near plane, as in Cycles.
    pub near: f32,
    /// When it is on its way, 0 to 1.
    pub time: f32,
    /// Of a shadow ray: Embree's mask of what can be in its way; 0 for all that shadow rays see.
    pub blockers: u32,
    /// What else is known of it.
    pub past: &'p Past,
}

impl From<RayKind> for Sender<'_> {
    fn from(kind: RayKind) -> Self {
        Self {
            kind,
            depth: 0,
            walked: 0.0,
            near: 0.0,
            time: 0.0,
            blockers: 0,
            past: &Past::UNKNOWN,
        }
    }
}

/// How much wider than a pixel of the picture the footprint of a path is, after what has scattered it: as Cycles has it from
/// 5.2 on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Widening {
    /// Metres where it was scattered last.
    size: f32,
    /// More for each metre from there.
    angle: f32,
}

impl Widening {
    /// At a distance from there.
    pub fn at(self, distance: f32) -> f32 {
        self.size + distance * self.angle
    }

    /// After a scattering at a distance that spreads light by so much more than the angle of a pixel.
    #[must_use]
    pub fn scattered(self, distance: f32, by: f32) -> Self {
        Self {
            size: self.at(distance),
            angle: self.angle.max(by),
        }
    }
}

/// The way that a path has come, as far as programs ask about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past {
    /// Surfaces that have scattered it diffusely, by facets, or through themselves, that it has passed straight on, and portals.
    pub depths: [u8; 5],
    /// The last of them was a mirror or clear glass.
    pub singular: bool,
    /// The last of them did not let it through.
    pub reflected: bool,
    /// It has been scattered into a wide range of directions.
    pub blurry: bool,
    /// How far the path had come when it was scattered last, metres.
    pub way: f32,
    /// How much wider than a pixel its footprint is.
    pub wide: Widening,
    /// Nanometres, where some surface's index of refraction depends on it; 0 otherwise.
    pub wavelength: f32,
    /// Index of refraction of the solid on the other side of the surface that asks, where priorities say which one that is; 0: of air.
    pub other_side: f32,
    /// Bits of what else its rays are ([`crate::light::LightSampleContext::also`]).
    pub also: u32,
    /// For random numbers, with the number of the bounce, where somebody asks for any.
    pub numbers: Option<(Sampler, u32)>,
    /// The strand that its ray leaves.
    pub left: Option<LeftStrand>,
}

impl Past {
    /// Of a path of which nothing is known.
    pub const UNKNOWN: Self = Self {
        depths: [0; 5],
        singular: false,
        reflected: false,
        blurry: false,
        way: 0.0,
        wide: Widening {
            size: 0.0,
            angle: 0.0,
        },
        wavelength: 0.0,
        other_side: 0.0,
        also: 0,
        numbers: None,
        left: None,
    };

    /// How often it was scattered in some way.
    pub(super) fn depth(&self, depth: PathDepth) -> f32 {
        let place = match depth {
            PathDepth::Diffuse => 0,
            PathDepth::Glossy => 1,
            PathDepth::Transmission => 2,
            PathDepth::Transparent => 3,
            PathDepth::Portal => 4,
        };
        f32::from(self.depths[place])
    }

    /// For random numbers; the same for all where nothing is known of the path.
    pub(super) fn numbers(&self) -> (Sampler, u32) {
        let unknown = || (Sequence::new(0).sampler(0, 0, 0), 0);
        self.numbers.unwrap_or_else(unknown)
    }
}

/// The scene around a place, for programs that ask it by rays.
pub trait Around: Sync {
    /// What a ray, of a span and at a time, meets first: where, and whether that is on the object of an entry.
    fn meets(&self, ray: (Vec3, Vec3, [f32; 2], f32), object: &MeshInstance)
    -> Option<(Hit, bool)>;
    /// Whether a shadow ray meets anything within a distance, at a time.
    fn is_shut(&self, origin: Vec3, direction: Vec3, until: (f32, f32)) -> bool;
    /// The normals of a hit, outside: that of the triangle, and the smooth one.
    fn normals(&self, hit: &Hit) -> (Vec3, Vec3);
}

impl<'p> Asking<'p> {
    /// A ray with a hit on its way.
    pub fn of(sender: &Sender<'p>, direction: Vec3, hit: &Hit) -> Self {
        Self {
            distance: sender.walked + hit.distance,
            near: sender.near,
            time: hit.time,
            ..Self::within(sender, direction)
        }
    }

    /// A ray on its way through a medium: as in Cycles, it has no length there.
    pub fn within(sender: &Sender<'p>, direction: Vec3) -> Self {
        Self {
            direction,
            distance: 0.0,
            near: 0.0,
            time: sender.time,
            kind: match sender.kind {
                RayKind::Shadow => RayKind::Shadow.bit(),
                kind => kind.bit() | sender.past.also,
            },
            depth: sender.depth,
            past: sender.past,
        }
    }

    /// Nobody in particular, along a direction.
    pub fn along(direction: Vec3) -> Self {
        Self {
            direction,
            distance: 0.0,
            near: 0.0,
            kind: 0,
            depth: 0,
            time: 0.0,
            past: &Past::UNKNOWN,
        }
    }
}
