//! Emissive triangles of meshes: which there are, which side of them shines, and points on them.

use super::LightSample;
use super::closed::{self, Outside, place_bits};
use super::estimate::{Angle, Front, LightBounds};
use super::kinds::{Light, LightSampleContext};
use super::quad::Quad;
use super::rules::Rules;
use super::triangle::Triangle;
use crate::math::float::{self, BoundedPoint};
use crate::scene::{Camera, Projection, Visibility};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// A surface that emits, as the lights on its triangles see it. Whoever knows meshes, materials and textures implements it.
pub trait EmissiveSurface: Send + Sync {
    /// The point of a triangle with these weights of its second and third corner, and what it emits to a point from where it is
    /// seen in a direction: the two of `ray`.
    /// `None` from a side that is not there.
    /// At a time between 0 and 1.
    fn emitted(&self, place: (u32, Vec2), ray: (Vec3, Vec3), time: f32) -> Option<EmittedPoint>;

    /// About the mean luminance of the radiance that a triangle emits.
    fn mean_emission(&self, triangle: u32) -> f32;

    /// Corners of a triangle in the world, of one that moves half-way.
    fn corners(&self, triangle: u32) -> [Vec3; 3];

    /// Whether it moves.
    fn moves(&self) -> bool {
        false
    }

    /// Corners of a triangle in the world at a time between 0 and 1.
    fn corners_at(&self, triangle: u32, _time: f32) -> [Vec3; 3] {
        self.corners(triangle)
    }
}

/// A point of a surface that emits.
#[derive(Clone, Copy, Debug)]
pub struct EmittedPoint {
    /// Where, with its error bound.
    pub point: BoundedPoint,
    /// Radiance, as far as the surface is there.
    pub radiance: Vec3,
}

/// A placed mesh that emits.
pub struct EmissiveMesh {
    /// Number of the instance.
    pub instance: u32,
    /// Which rays see it.
    pub visibility: Visibility,
    /// No light gets through it, nor beside it.
    pub is_opaque: bool,
    /// Its material has one side.
    pub single_sided: bool,
    /// How many triangles it has.
    pub triangles: u32,
    /// Each is drawn by itself, as in Cycles, even if two are a rectangle: how much is clamped hangs on the density.
    pub in_triangles: bool,
    /// Parts of one object have one number.
    pub object: u32,
    /// How strongly it emits, guessed as Cycles does.
    pub guess: Vec3,
    /// What it emits.
    pub surface: Box<dyn EmissiveSurface>,
}

/// What the triangles of a mesh share.
struct Shared {
    instance: u32,
    object: u32,
    guess: Vec3,
    rules: Rules,
    surface: Box<dyn EmissiveSurface>,
}

/// Where in a mesh a light is.
struct Part {
    mesh: Arc<Shared>,
    /// Its (first) triangle.
    triangle: u32,
    /// The side that shines, where it is one alone.
    side: Option<Outside>,
    /// It moves.
    moves: bool,
}

/// A triangle of a mesh as a light.
pub struct EmissiveTriangle {
    shape: Triangle,
    part: Part,
}

/// Two triangles of a mesh that are a rectangle, and lie behind each other in it, as one light.
pub struct EmissiveRectangle {
    shape: Quad,
    part: Part,
}

impl Part {
    /// The light of a point that was drawn.
    #[inline]
    fn sample(
        &self,
        place: (u32, Vec2),
        normal: Vec3,
        (from, wi, time): (Vec3, Vec3, f32),
        pdf: f32,
    ) -> Option<LightSample> {
        let on = self.mesh.surface.emitted(place, (from, wi), time)?;
        let facing = if wi.dot(normal) > 0.0 {
            -normal
        } else {
            normal
        };
        let target = float::ray_origin(on.point, facing);
        Some(LightSample::with_density(
            wi,
            on.radiance,
            pdf,
            Some(target),
        ))
    }

    /// Of triangles that begin with its own.
    fn bounds<const N: usize>(&self, triangles: [Triangle; N]) -> LightBounds {
        let first = &triangles[0];
        let (mut min, mut max, mut intensity) = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0);
        for (triangle, number) in triangles.iter().zip(self.triangle..) {
            intensity += triangle.area() * self.mesh.surface.mean_emission(number);
            for corner in triangle.corners {
                (min, max) = (min.min(corner), max.max(corner));
            }
        }
        let axis = if self.side == Some(Outside::Back) {
            -first.normal()
        } else {
            first.normal()
        };
        let front = self.side.map(|_| Front {
            normal: axis,
            offset: axis.dot(first.corners[0]),
        });
        LightBounds {
            min,
            max,
            intensity,
            axis,
            normals: Angle::ZERO,
            cos_emission: 0.0,
            two_sided: self.side.is_none(),
            front,
        }
    }
}

impl Part {
    /// Draws a point of a triangle.
    #[inline]
    fn sample_on(&self, shape: &Triangle, at: &LightSampleContext, u: Vec2) -> Option<LightSample> {
        let s = shape.sample(at.point, u)?;
        let on = (self.triangle, Vec2::new(s.u, s.v));
        let seen = (at.point, s.wi, at.time);
        self.sample(on, shape.normal(), seen, s.pdf)
    }

    /// The same of a moving triangle.
    #[cold]
    #[inline(never)]
    fn sample_moving(&self, at: &LightSampleContext, u: Vec2) -> Option<LightSample> {
        self.sample_on(&self.shape_at(at.time), at, u)
    }

    /// A moving triangle at a time.
    #[cold]
    #[inline(never)]
    fn shape_at(&self, time: f32) -> Triangle {
        Triangle {
            corners: self.mesh.surface.corners_at(self.triangle, time),
        }
    }

    /// Of a moving triangle: it may be turned to any side, and be anywhere where it is at one of so many times, or as far from
    /// there as from each of these to the next.
    fn bounds_of_all_times(&self, half_way: &Triangle) -> LightBounds {
        const TIMES: u32 = 64;
        let mut bounds = self.bounds([*half_way]);
        let mut before: Option<Triangle> = None;
        let (mut farthest, mut area) = (0.0f32, 0.0f32);
        for number in 0..=TIMES {
            let shape = self.shape_at(number as f32 / TIMES as f32);
            for (place, corner) in shape.corners.into_iter().enumerate() {
                bounds.min = bounds.min.min(corner);
                bounds.max = bounds.max.max(corner);
                let way = before.map_or(0.0, |before| corner.distance(before.corners[place]));
                farthest = farthest.max(way);
            }
            area = area.max(shape.area());
            before = Some(shape);
        }
        LightBounds {
            min: bounds.min - farthest,
            max: bounds.max + farthest,
            intensity: area * self.mesh.surface.mean_emission(self.triangle),
            normals: Angle::ALL,
            two_sided: true,
            front: None,
            ..bounds
        }
    }
}

impl EmissiveTriangle {
    /// Its area, of one that moves half-way.
    pub fn area(&self) -> f32 {
        self.shape.area()
    }

    /// Its corners, of one that moves half-way, and how strongly it emits as Cycles guesses it.
    pub(super) fn in_tree(&self) -> ([Vec3; 3], Vec3) {
        (self.shape.corners, self.part.mesh.guess)
    }

    /// Draws a point.
    #[inline]
    pub fn sample_li(&self, at: &LightSampleContext, u: Vec2) -> Option<LightSample> {
        if self.part.moves {
            return self.part.sample_moving(at, u);
        }
        self.part.sample_on(&self.shape, at, u)
    }

    /// Density of [`Self::sample_li`] for a point of the triangle.
    #[inline]
    pub fn pdf_li(&self, at: &LightSampleContext, on: Vec3) -> f32 {
        if self.part.moves {
            return self.part.shape_at(at.time).pdf(at.point, on);
        }
        self.shape.pdf(at.point, on)
    }

    /// What is known of it for its estimate.
    pub fn bounds(&self) -> LightBounds {
        if self.part.moves {
            return self.part.bounds_of_all_times(&self.shape);
        }
        self.part.bounds([self.shape])
    }
}

impl EmissiveRectangle {
    /// Its corners, and how strongly it emits as Cycles guesses it.
    pub(super) fn in_tree(&self) -> ([Vec3; 4], Vec3) {
        let of = |number| self.part.mesh.surface.corners(number);
        let [first, second] = [self.part.triangle, self.part.triangle + 1].map(of);
        let mut others = second.into_iter().filter(|corner| !first.contains(corner));
        let fourth = others.next().unwrap_or(second[2]);
        ([first[0], first[1], first[2], fourth], self.part.mesh.guess)
    }

    /// Its area.
    pub fn area(&self) -> f32 {
        self.shape.area() as f32
    }

    /// Draws a point.
    #[inline]
    pub fn sample_li(&self, at: &LightSampleContext, u: Vec2) -> Option<LightSample> {
        let s = self.shape.sample(at.point, u)?;
        let on = (self.part.triangle + u32::from(s.second), s.weights);
        let seen = (at.point, s.wi, at.time);
        self.part.sample(on, self.shape.normal(), seen, s.pdf)
    }

    /// Density of [`Self::sample_li`] for a point of the rectangle.
    #[inline]
    pub fn pdf_li(&self, at: &LightSampleContext, on: Vec3) -> f32 {
        self.shape.pdf(at.point, on)
    }

    /// What is known of it for its estimate.
    pub fn bounds(&self) -> LightBounds {
        let triangle = |number| Triangle {
            corners: self.part.mesh.surface.corners(number),
        };
        self.part
            .bounds([self.part.triangle, self.part.triangle + 1].map(triangle))
    }
}

impl std::fmt::Debug for EmissiveTriangle {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "triangle {}", self.part.triangle)
    }
}

impl std::fmt::Debug for EmissiveRectangle {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "rectangle at triangle {}", self.part.triangle)
    }
}

/// Which triangles of surfaces are lights.
#[derive(Default)]
pub struct EmissiveTriangles {
    /// By instance, the number of its first triangle among all emissive ones; [`NONE`] where it has none.
    first: Vec<u32>,
    /// For each emissive triangle the light that it is, or is a part of.
    lights: Vec<u32>,
    /// Boxes about the meshes that shine outwards alone if the camera is not in them.
    closing: Vec<(Vec3, Vec3)>,
}

const NONE: u32 = u32::MAX;

/// Where triangles with one side stand, seen by which rays, and the lights that they are. One that is turned over is no light of
/// its own where back faces are there: a ray meets one of the two. (`scene::validate` leaves out others that stand in one place,
/// but not these, as each can be the one that is seen where back faces are not there.)
#[derive(Default)]
pub struct Twins(HashMap<([[u32; 3]; 3], u32), u32>);

impl Twins {
    fn key(corners: &[Vec3; 3], visibility: Visibility) -> ([[u32; 3]; 3], u32) {
        let mut bits = corners.map(place_bits);
        bits.sort_unstable();
        (bits, visibility.bits())
    }
}

/// Where paths begin: within `reach` of a point.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    at: Vec3,
    reach: f32,
}

impl Eye {
    /// The camera's place.
    pub fn at(&self) -> Vec3 {
        self.at
    }

    /// Of a camera, relative to the origin of the world.
    pub fn new(camera: &Camera, origin: DVec3) -> Self {
        let across = match camera.projection {
            Projection::Orthographic {
                half_width,
                half_height,
            } => DVec2::new(half_width, half_height).length(),
            _ => camera.aperture.map_or(0.0, |a| a.radius),
        };
        let at = camera.world_from_camera.translation;
        let moved = camera.motion.iter().flat_map(|motion| &motion.steps);
        let moved = moved
            .map(|step| step.translation.distance(at))
            .fold(0.0, f64::max);
        Self {
            at: (at - origin).as_vec3(),
            // Twice: the near plane is farther away in the corners of a picture.
            reach: (2.0 * camera.clip_near + across + moved) as f32,
        }
    }

    fn may_be_in(&self, (low, high): (Vec3, Vec3)) -> bool {
        (self.at - self.at.clamp(low, high)).length() <= self.reach
    }
}

/// The box about some triangles.
fn bounds(triangles: &[[Vec3; 3]]) -> (Vec3, Vec3) {
    let corners = || triangles.iter().flatten();
    let low = corners().fold(Vec3::INFINITY, |low, p| low.min(*p));
    let high = corners().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
    (low, high)
}

/// Whether a mesh may shine outwards alone: where the camera is not in it.
fn is_closing(visibility: Visibility, is_opaque: bool) -> bool {
    visibility == Visibility::ALL && is_opaque
}

/// The side of each triangle that light can leave, where it is one alone: of an opaque closed surface with the camera outside.
/// Paths never get into it, so that what shines on its inside is for nobody. (A camera that is inside all the same finds it by
/// looking: the density of light sampling is 0 there.)
pub(crate) fn outside(
    visibility: Visibility,
    is_opaque: bool,
    triangles: &[[Vec3; 3]],
    eye: &Eye,
) -> Option<Vec<Outside>> {
    (is_closing(visibility, is_opaque) && !eye.may_be_in(bounds(triangles)))
        .then(|| closed::outside(triangles))
        .flatten()
}

impl EmissiveTriangles {
    /// Whether the lights of another camera may be others: it is in a mesh that the one before was not in, or the reverse.
    pub fn depend_on(&self, before: &Eye, after: &Eye) -> bool {
        let differs = |bounds: &(Vec3, Vec3)| before.may_be_in(*bounds) != after.may_be_in(*bounds);
        self.closing.iter().any(differs)
    }

    /// Adds the triangles of a mesh to the lights. `twins`: where back faces are there.
    pub fn add(
        &mut self,
        mesh: EmissiveMesh,
        eye: &Eye,
        mut twins: Option<&mut Twins>,
        lights: &mut Vec<Light>,
    ) {
        let EmissiveMesh {
            instance,
            visibility,
            is_opaque,
            single_sided,
            triangles,
            in_triangles,
            object,
            guess,
            surface,
        } = mesh;
        let triangles: Vec<[Vec3; 3]> = (0..triangles).map(|t| surface.corners(t)).collect();
        let moves = surface.moves();
        // What moves may turn its other side to the camera.
        let sides = (!moves)
            .then(|| outside(visibility, is_opaque, &triangles, eye))
            .flatten();
        self.lights.reserve(triangles.len());
        if is_closing(visibility, is_opaque) {
            self.closing.push(bounds(&triangles));
        }
        if self.first.len() <= instance as usize {
            self.first.resize(instance as usize + 1, NONE);
        }
        self.first[instance as usize] = self.lights.len() as u32;
        if !single_sided || !is_opaque || moves {
            twins = None;
        }
        let twin_of = |twins: &Option<&mut Twins>, corners: &[Vec3; 3]| {
            let light = twins.as_ref()?.0.get(&Twins::key(corners, visibility));
            light.copied()
        };
        let shared = Arc::new(Shared {
            instance,
            object,
            guess,
            rules: Rules::of_surface(visibility),
            surface,
        });
        let mut at = 0;
        while let Some(&corners) = triangles.get(at) {
            if let Some(light) = twin_of(&twins, &corners) {
                self.lights.push(light);
                at += 1;
                continue;
            }
            let next = triangles
                .get(at + 1)
                .filter(|next| !moves && !in_triangles && twin_of(&twins, next).is_none());
            let part = Part {
                mesh: shared.clone(),
                triangle: at as u32,
                side: sides.as_ref().map(|sides| sides[at]),
                moves,
            };
            let (light, count) = match next.and_then(|&next| Quad::new(corners, next)) {
                Some(shape) => {
                    let rectangle = EmissiveRectangle { shape, part };
                    (Light::Rectangle(Box::new(rectangle)), 2)
                }
                None => {
                    let shape = Triangle { corners };
                    (Light::Triangle(EmissiveTriangle { shape, part }), 1)
                }
            };
            let number = lights.len() as u32;
            lights.push(light);
            self.lights.extend(std::iter::repeat_n(number, count));
            if let Some(twins) = &mut twins {
                let here = triangles[at..at + count].iter();
                let keys = here.map(|corners| (Twins::key(corners, visibility), number));
                twins.0.extend(keys);
            }
            at += count;
        }
    }

    /// The light that a triangle of an instance is.
    #[inline]
    pub fn light(&self, instance: u32, triangle: u32) -> Option<u32> {
        let first = *self.first.get(instance as usize)?;
        (first != NONE).then(|| self.lights[(first + triangle) as usize])
    }
}

impl Light {
    /// The instance whose surface it is, and who sees that.
    #[inline]
    pub(super) fn of_surface(&self) -> Option<(u32, Rules)> {
        let mesh = &self.part()?.mesh;
        Some((mesh.instance, mesh.rules))
    }

    /// The object that it is a part of, by its number.
    pub(super) fn object(&self) -> Option<u32> {
        Some(self.part()?.mesh.object)
    }

    #[inline]
    fn part(&self) -> Option<&Part> {
        match self {
            Self::Triangle(triangle) => Some(&triangle.part),
            Self::Rectangle(rectangle) => Some(&rectangle.part),
            Self::Lamp(_)
            | Self::Area(_)
            | Self::Sun(_)
            | Self::Environment(_)
            | Self::Computed(_) => None,
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/emissive.rs"]
pub(super) mod tests;
