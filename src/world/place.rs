//! What shader programs ask about a point of a surface.

use super::geometry::{MeshData, MeshInstance, unit_or_zero};
use crate::effects::General;
use crate::ffi::embree::Hit;
use crate::math::float;
use crate::math::float::{Affine, BoundedPoint};
use crate::sampler::{Dimension, Sampler, Sequence};
use crate::scene::graph::function::{PathDepth, PlaceInput, Space, Transformed};
use crate::scene::graph::{NormalSpace, TangentKind};
use crate::scene::{Camera, ObjectInfo, Projection, RayKind, TextureSpace};
use crate::shading::program::{Openness, Place};
use glam::{DAffine3, DMat3, DVec3, Mat3, Vec2, Vec3, Vec4};

/// Of glTF's axes, Blender's.
pub fn to_blender(v: Vec3) -> Vec3 {
    Vec3::new(v.x, -v.z, v.y)
}

/// Of Blender's axes, glTF's.
pub fn from_blender(v: Vec3) -> Vec3 {
    Vec3::new(v.x, v.z, -v.y)
}

/// What a world knows of the one who looks.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// From places relative to the origin, in glTF's axes, to the camera's: it looks along +Z, as in Cycles.
    pub camera: Affine,
    /// A pixel's height, metres: this at the camera, and so much more for each metre from it.
    pub pixel: (f32, f32),
    /// How the picture is seen.
    frame: Frame,
}

/// The edges of a picture: left, right, bottom, top.
#[derive(Clone, Copy, Debug)]
enum Frame {
    /// Tangents of angles.
    Perspective([f32; 4]),
    /// Metres.
    Orthographic([f32; 4]),
    /// Radians.
    Equirectangular([f32; 4]),
}

impl Frame {
    fn new(camera: &Camera, aspect: f64) -> Self {
        let window = camera.window.map(|w| w.widened_to(aspect));
        let edges =
            |x: f64, y: f64| window.map_or([-x, x, -y, y], |w| [w.left, w.right, w.bottom, w.top]);
        let single = |edges: [f64; 4]| edges.map(|edge| edge as f32);
        match camera.projection {
            Projection::Perspective { vertical_fov, .. } => {
                let y = (0.5 * vertical_fov).tan();
                Self::Perspective(single(edges(y * aspect, y)))
            }
            Projection::Orthographic { half_height, .. } => {
                Self::Orthographic(single(edges(half_height * aspect, half_height)))
            }
            Projection::Equirectangular {
                longitude: [left, right],
                latitude: [bottom, top],
            } => Self::Equirectangular(single([left, right, bottom, top])),
        }
    }

    /// Where in the picture a point of the camera's space is, 0 to 1.
    fn at(&self, p: Vec3) -> Vec3 {
        let (edges, at) = match self {
            Self::Perspective(edges) => (edges, [p.x / p.z, p.y / p.z]),
            Self::Orthographic(edges) => (edges, [p.x, p.y]),
            Self::Equirectangular(edges) => {
                let up = p.y / p.length().max(f32::MIN_POSITIVE);
                (edges, [p.x.atan2(p.z), up.clamp(-1.0, 1.0).asin()])
            }
        };
        let [left, right, bottom, top] = *edges;
        Vec3::new(
            (at[0] - left) / (right - left),
            (at[1] - bottom) / (top - bottom),
            0.0,
        )
    }
}

impl View {
    /// Where a place in the camera's space lies in the picture: 0 to 1 from the left, and from below.
    pub fn window(&self, p: Vec3) -> Vec3 {
        self.frame.at(p)
    }

    /// That of a world's camera.
    pub fn new(camera: &Camera, (aspect, rows): (f64, u32), origin: DVec3) -> Self {
        let to_camera = camera.world_from_camera.inverse();
        // glTF's cameras look along −Z.
        let flip = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        let flipped = DAffine3 {
            matrix3: flip * to_camera.matrix3,
            translation: flip * to_camera.transform_point3(origin),
        };
        let window = camera.window.map(|w| w.widened_to(aspect));
        let height = |plain: f64| window.map_or(plain, |w| w.top - w.bottom);
        let (parallel, angle) = match camera.projection {
            Projection::Perspective { vertical_fov, .. } => {
                (0.0, height(2.0 * (0.5 * vertical_fov).tan()))
            }
            Projection::Orthographic { half_height, .. } => (height(2.0 * half_height), 0.0),
            Projection::Equirectangular { latitude, .. } => (0.0, latitude[1] - latitude[0]),
        };
        let rows = f64::from(rows.max(1));
        Self {
            camera: Affine::from_f64(&flipped, DVec3::ZERO),
            pixel: ((parallel / rows) as f32, (angle / rows) as f32),
            frame: Frame::new(camera, aspect),
        }
    }
}

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

    /// The distance, of a radius of 1, within which a share of it lies: 10x² − 20x³ + 15x⁴ − 4x⁵ by bisection.
    pub fn radius(share: f32) -> f32 {
        let within = |x: f32| x * x * (10.0 + x * (-20.0 + x * (15.0 - 4.0 * x)));
        let (mut low, mut high) = (0.0f32, 1.0f32);
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if within(middle) < share {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// What is known of an object, for programs that ask about places.
#[derive(Clone, Debug)]
pub struct ObjectFacts {
    /// The world's origin.
    origin: Vec3,
    /// From places relative to the origin to the object's own space, of a mesh that stands in the world.
    object_from_world: Option<Affine>,
    /// The object's axes in the world (glTF's axes).
    world_axes: Mat3,
    /// The other way round.
    object_axes: Mat3,
    /// Where its origin is, in Blender's axes.
    location: Vec3,
    /// What it says of itself.
    info: ObjectInfo,
    /// The mesh's texture space.
    texture_space: TextureSpace,
    /// The one who looks.
    pub view: View,
}

impl ObjectFacts {
    /// Of an object with a mesh that is placed once (in world space), or more often.
    pub fn new(
        world_from_object: &DAffine3,
        origin: DVec3,
        is_shared: bool,
        (info, texture_space): (ObjectInfo, TextureSpace),
        view: View,
    ) -> Self {
        let placed = DAffine3 {
            translation: world_from_object.translation - origin,
            ..*world_from_object
        };
        let inverse = |m: DMat3| {
            if m.determinant() == 0.0 {
                m
            } else {
                m.inverse()
            }
        };
        let back = DAffine3 {
            matrix3: inverse(placed.matrix3),
            translation: -(inverse(placed.matrix3) * placed.translation),
        };
        Self {
            origin: origin.as_vec3(),
            object_from_world: (!is_shared).then(|| Affine::from_f64(&back, DVec3::ZERO)),
            world_axes: placed.matrix3.as_mat3(),
            object_axes: back.matrix3.as_mat3(),
            location: to_blender(world_from_object.translation.as_vec3()),
            info,
            texture_space,
            view,
        }
    }
}

/// The ray that asks.
#[derive(Clone, Copy, Debug)]
pub struct Asking {
    /// From where it comes.
    pub direction: Vec3,
    /// How far.
    pub distance: f32,
    /// The bit of its kind.
    pub kind: u32,
    /// Surfaces that have scattered its path.
    pub depth: u32,
    /// What else is known of its path.
    pub past: Past,
}

/// A ray's kind and what is known of its path.
#[derive(Clone, Copy, Debug)]
pub struct Sender {
    /// The kind.
    pub kind: RayKind,
    /// Surfaces that have scattered the path.
    pub depth: u32,
    /// What else is known of it.
    pub past: Past,
}

impl From<RayKind> for Sender {
    fn from(kind: RayKind) -> Self {
        Self {
            kind,
            depth: 0,
            past: Past::default(),
        }
    }
}

/// The way that a path has come, as far as programs ask about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Past {
    /// Surfaces that have scattered it diffusely, by facets, or through themselves, and that it has passed straight on.
    pub depths: [u8; 4],
    /// The last of them was a mirror or clear glass.
    pub singular: bool,
    /// The last of them did not let it through.
    pub reflected: bool,
    /// It has been scattered into a wide range of directions.
    pub blurry: bool,
    /// For random numbers, with the number of the bounce, where somebody asks for any.
    pub numbers: Option<(Sampler, u32)>,
}

impl Past {
    /// For random numbers; the same for all where nothing is known of the path.
    fn numbers(&self) -> (Sampler, u32) {
        let unknown = || (Sequence::new(0).sampler(0, 0, 0), 0);
        self.numbers.unwrap_or_else(unknown)
    }
}

/// The scene around a place, for programs that ask it by rays.
pub trait Around: Sync {
    /// What a ray meets first: where, and whether that is on the object of an entry.
    fn meets(&self, ray: (Vec3, Vec3, [f32; 2]), object: &MeshInstance) -> Option<(Hit, bool)>;
    /// Whether a shadow ray meets anything.
    fn is_shut(&self, origin: Vec3, direction: Vec3, far: f32) -> bool;
    /// The normals of a hit, outside: that of the triangle, and the smooth one.
    fn normals(&self, hit: &Hit) -> (Vec3, Vec3);
}

impl Asking {
    /// A ray with a hit on its way.
    pub fn of(sender: &Sender, direction: Vec3, hit: &Hit) -> Self {
        Self {
            direction,
            distance: hit.distance,
            kind: sender.kind.bit(),
            depth: sender.depth,
            past: sender.past,
        }
    }

    /// Nobody in particular, along a direction.
    pub fn along(direction: Vec3) -> Self {
        Self {
            direction,
            distance: 0.0,
            kind: 0,
            depth: 0,
            past: Past::default(),
        }
    }
}

/// A point on a triangle by its barycentric coordinates.
#[derive(Clone, Copy)]
pub struct HitPoint<'a> {
    pub(super) mesh: &'a MeshData,
    pub(super) entry: &'a MeshInstance,
    pub(super) corners: [u32; 3],
    pub(super) triangle: u32,
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) asking: Asking,
    /// The smooth normal outside; 0 where nobody has asked for it yet.
    pub(super) normal: Vec3,
    /// The attribute that tells where the corners are, in the object's space and in Blender's axes; their own places otherwise.
    pub(super) undisplaced: Option<u32>,
    /// The scene, where programs ask it.
    pub(super) around: Option<&'a dyn Around>,
}

/// Two unit vectors that make a right-handed frame with a normal, in Blender's axes: those that Cycles takes.
fn across(n: Vec3) -> [Vec3; 2] {
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

/// Between the values of three corners.
#[inline]
pub(super) fn between<T>(corners: [T; 3], u: f32, v: f32) -> T
where
    T: Copy
        + std::ops::Add<Output = T>
        + std::ops::Sub<Output = T>
        + std::ops::Mul<f32, Output = T>,
{
    let [a, b, c] = corners;
    a + (b - a) * u + (c - a) * v
}

impl HitPoint<'_> {
    #[inline]
    pub(super) fn vector(&self, values: &[[f32; 3]]) -> Vec3 {
        between(
            self.corners.map(|i| Vec3::from(values[i as usize])),
            self.u,
            self.v,
        )
    }

    #[inline]
    fn four(&self, values: &[[f32; 4]]) -> Vec4 {
        between(
            self.corners.map(|i| Vec4::from(values[i as usize])),
            self.u,
            self.v,
        )
    }

    fn facts(&self) -> Option<&ObjectFacts> {
        self.entry.facts.as_deref()
    }

    /// The corners in the mesh's space: the world's, relative to the origin, where it is placed once.
    fn mesh_corners(&self) -> [Vec3; 3] {
        let before = self
            .undisplaced
            .and_then(|n| self.mesh.attributes.get(n as usize));
        let (Some(values), Some(facts)) = (before, self.facts()) else {
            return self.mesh.corners(self.triangle);
        };
        self.corners.map(|corner| {
            let p = Vec4::from(values[corner as usize]).truncate();
            if self.entry.is_instance() {
                p
            } else {
                facts.world_axes * p + (from_blender(facts.location) - facts.origin)
            }
        })
    }

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
                let (hit, is_own) = around.meets((origin, direction, [from, far]), self.entry)?;
                from = hit.distance.next_up();
                if is_own {
                    return Some(hit);
                }
            }
            None
        })
        .take(most)
    }

    /// In the mesh's space.
    fn in_mesh(&self) -> Vec3 {
        between(self.mesh_corners(), self.u, self.v)
    }

    /// A step across the mesh's triangle by its barycentric coordinates: least squares in the triangle's plane.
    fn barycentric(&self, local: Vec3) -> Option<(f32, f32)> {
        let [a, b, c] = self.mesh_corners();
        let (e1, e2) = (b - a, c - a);
        let (d11, d12, d22) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
        let (s1, s2) = (local.dot(e1), local.dot(e2));
        let det = d11 * d22 - d12 * d12;
        (det != 0.0).then(|| ((s1 * d22 - s2 * d12) / det, (s2 * d11 - s1 * d12) / det))
    }

    /// A vector of Blender's world in the mesh's space.
    fn vector_to_mesh(&self, v: Vec3) -> Vec3 {
        let v = from_blender(v);
        match (&self.entry.facts, self.entry.is_instance()) {
            (Some(facts), true) => facts.object_axes * v,
            _ => v,
        }
    }

    fn generated(&self, facts: &ObjectFacts) -> Vec3 {
        match &self.mesh.generated {
            Some(values) => self.vector(values),
            None => facts.texture_space.generated(self.in_object()),
        }
    }

    /// The tangent about an axis through the middle of the texture space, on the viewer's side. `as_normal`: it is turned into
    /// the world as normals are.
    fn around(&self, facts: &ObjectFacts, axis: u8, as_normal: bool) -> Vec3 {
        let p = self.generated(facts) - 0.5;
        let around = match axis {
            0 => Vec3::new(0.0, -p.z, p.y),
            1 => Vec3::new(-p.z, 0.0, p.x),
            _ => Vec3::new(-p.y, p.x, 0.0),
        };
        let world = if as_normal {
            facts.object_axes.transpose() * around
        } else {
            facts.world_axes * around
        };
        let n = to_blender(self.side(self.outer_normal()));
        unit_or_zero(n.cross(unit_or_zero(to_blender(world)).cross(n)))
    }

    /// The tangent along a UV map, turned into the world as normals are, as in Cycles.
    fn along_uv(&self, facts: &ObjectFacts) -> Vec3 {
        let Some(tangents) = &self.mesh.tangents else {
            return to_blender(self.tangent(TangentKind::Uv, Vec2::X));
        };
        let tangent = self.own_tangent(facts, tangents);
        let world = unit_or_zero(to_blender(facts.object_axes.transpose() * tangent));
        let n = to_blender(self.outer_normal());
        n.cross(unit_or_zero(world.cross(n)))
    }

    /// Between the corners' tangents, in the object's own axes.
    fn own_tangent(&self, facts: &ObjectFacts, tangents: &[[f32; 4]]) -> Vec3 {
        // Meshes that are placed once stand in the world.
        let in_world = facts.object_from_world.is_some();
        let own = |t: Vec3| match in_world {
            true => unit_or_zero(facts.object_axes * t),
            false => t,
        };
        let corners = self.corners.map(|i| tangents[i as usize]);
        between(
            corners.map(|t| own(Vec4::from(t).truncate())),
            self.u,
            self.v,
        )
    }

    /// In the world, relative to the origin.
    fn in_world(&self) -> Vec3 {
        let local = BoundedPoint {
            point: self.in_mesh(),
            error: Vec3::ZERO,
        };
        if self.entry.is_instance() {
            self.entry.transform().bounded_point(local).point
        } else {
            local.point
        }
    }

    /// In the object's own space.
    fn in_object(&self) -> Vec3 {
        let p = self.in_mesh();
        match self
            .facts()
            .and_then(|facts| facts.object_from_world.as_ref())
        {
            Some(m) => m.vector(p) + m.translation,
            None => p,
        }
    }

    fn outer_normal(&self) -> Vec3 {
        if self.normal == Vec3::ZERO {
            self.entry.smooth_normal(self.mesh, self)
        } else {
            self.normal
        }
    }

    fn is_inside(&self) -> bool {
        let outside = self
            .entry
            .geometric_normal::<General>(self.mesh, self.triangle);
        outside.dot(self.asking.direction) > 0.0
    }

    fn side(&self, n: Vec3) -> Vec3 {
        if self.is_inside() { -n } else { n }
    }

    /// A tangent-space normal in the frame of the corners' tangents and normals, as Cycles has it: in the object's own axes,
    /// neither orthogonal nor of unit length between the corners. 0 where there are no tangents.
    fn mapped_by_corners(&self, own: Vec3, mapped: Vec3) -> Vec3 {
        let (Some(facts), Some(tangents)) = (self.facts(), &self.mesh.tangents) else {
            return Vec3::ZERO;
        };
        let (axes, back) = (facts.world_axes, facts.object_axes);
        // Meshes that are placed once stand in the world.
        let in_world = facts.object_from_world.is_some();
        let normal_of = |n: Vec3| {
            if in_world {
                unit_or_zero(axes.transpose() * n)
            } else {
                n
            }
        };
        let tangent = self.own_tangent(facts, tangents);
        let normal = match &self.mesh.normals {
            Some(normals) => between(
                self.corners
                    .map(|i| normal_of(Vec3::from(normals[i as usize]))),
                self.u,
                self.v,
            ),
            None => unit_or_zero(axes.transpose() * own),
        };
        // The mirror of the object has turned the signs of what stands in the world.
        let mirror = if in_world && axes.determinant() < 0.0 {
            -1.0
        } else {
            1.0
        };
        let sign = tangents[self.corners[0] as usize][3].signum() * mirror;
        let n = tangent * mapped.x + normal.cross(tangent) * (sign * mapped.y) + normal * mapped.z;
        unit_or_zero(back.transpose() * n)
    }

    /// A direction of Blender's world in the object's space, for normals.
    fn normal_in_object(&self, n: Vec3) -> Vec3 {
        let Some(facts) = self.facts() else {
            return n;
        };
        unit_or_zero(facts.world_axes.transpose() * from_blender(n))
    }
}

impl Place for HitPoint<'_> {
    #[inline]
    fn uv(&self, set: u32) -> Vec2 {
        self.mesh
            .uvs
            .get(set as usize)
            .map_or(Vec2::ZERO, |values| {
                between(
                    self.corners.map(|i| Vec2::from(values[i as usize])),
                    self.u,
                    self.v,
                )
            })
    }

    #[inline]
    fn color(&self) -> Vec4 {
        let colors = self.mesh.colors.as_ref();
        colors.map_or(Vec4::ONE, |values| self.four(values))
    }

    fn mapped_normal(&self, space: NormalSpace, normal: Vec3, strength: f32) -> Vec3 {
        let own = self.outer_normal();
        let mapped = match space {
            NormalSpace::Gltf => {
                let scale = Vec3::new(strength, strength, 1.0);
                return self.entry.mapped_normal(self, own, normal * scale);
            }
            NormalSpace::Tangent => {
                let share = strength.clamp(0.0, 1.0);
                let z = 1.0 + (normal.z - 1.0) * share;
                let scaled = Vec3::new(normal.x * strength, normal.y * strength, z);
                return self.mapped_by_corners(own, scaled);
            }
            NormalSpace::Object => {
                let world =
                    self.transformed(normal, Transformed::Normal, Space::Object, Space::World);
                from_blender(world)
            }
            NormalSpace::World => unit_or_zero(from_blender(normal)),
        };
        if mapped == Vec3::ZERO || strength == 1.0 {
            return mapped;
        }
        unit_or_zero(own + (mapped - own) * strength.max(0.0))
    }

    fn tangent(&self, kind: TangentKind, direction: Vec2) -> Vec3 {
        let normal = self.outer_normal();
        self.entry.tangent(self, normal, (kind, direction))
    }

    #[cold]
    fn input(&self, input: PlaceInput) -> Vec4 {
        let full = |v: Vec3| v.extend(1.0);
        let number = Vec4::splat;
        let Some(facts) = self.facts() else {
            debug_assert!(
                false,
                "a program asks about a place of which nothing was kept: {input:?}"
            );
            return Vec4::ZERO;
        };
        match input {
            PlaceInput::Generated => full(self.generated(facts)),
            PlaceInput::ObjectNormal => {
                full(self.normal_in_object(to_blender(self.side(self.outer_normal()))))
            }
            PlaceInput::Uv(set) => {
                let uv = self.uv(set);
                full(Vec3::new(uv.x, 1.0 - uv.y, 0.0))
            }
            PlaceInput::Object => full(self.in_object()),
            PlaceInput::OfObject(rows) => {
                let p = to_blender(self.in_world() + facts.origin).extend(1.0);
                full(Vec3::from(rows.map(|row| Vec4::from(row).dot(p))))
            }
            PlaceInput::Camera => {
                let m = &facts.view.camera;
                full(m.vector(self.in_world()) + m.translation)
            }
            PlaceInput::Window => {
                let m = &facts.view.camera;
                let p = m.vector(self.in_world()) + m.translation;
                full(facts.view.window(p))
            }
            PlaceInput::ViewVector => {
                let m = &facts.view.camera;
                let p = m.vector(self.in_world()) + m.translation;
                full(p.normalize_or_zero())
            }
            PlaceInput::ViewDepth => {
                let m = &facts.view.camera;
                number((m.vector(self.in_world()) + m.translation).z)
            }
            PlaceInput::ViewDistance => {
                let m = &facts.view.camera;
                number((m.vector(self.in_world()) + m.translation).length())
            }
            PlaceInput::Reflection => {
                let n = to_blender(self.side(self.outer_normal()));
                let i = -to_blender(self.asking.direction).normalize_or_zero();
                full(n * (2.0 * n.dot(i)) - i)
            }
            PlaceInput::Position => full(to_blender(self.in_world() + facts.origin)),
            PlaceInput::Normal => full(to_blender(self.side(self.outer_normal()))),
            PlaceInput::Tangent => full(self.around(facts, 2, false)),
            PlaceInput::RadialTangent(axis) => full(self.around(facts, axis, true)),
            PlaceInput::UvTangent => full(self.along_uv(facts)),
            PlaceInput::TrueNormal => {
                let n = self
                    .entry
                    .geometric_normal::<General>(self.mesh, self.triangle);
                full(to_blender(self.side(n)))
            }
            PlaceInput::Incoming => full(-to_blender(self.asking.direction).normalize_or_zero()),
            // Cycles' own order of the corners: it gives 1 − u − v and u.
            PlaceInput::Parametric => full(Vec3::new(1.0 - self.u - self.v, self.u, 0.0)),
            PlaceInput::Backfacing => number(f32::from(self.is_inside())),
            PlaceInput::ObjectLocation => full(facts.location),
            PlaceInput::ObjectColor => Vec4::from(facts.info.color),
            PlaceInput::ObjectAlpha => number(facts.info.color[3]),
            PlaceInput::ObjectIndex => number(facts.info.index),
            PlaceInput::MaterialIndex(index) => number(index),
            PlaceInput::ObjectRandom => number(facts.info.random),
            PlaceInput::ObjectValue(n) => {
                let value = facts.info.values.get(n as usize);
                value.map_or(Vec4::ZERO, |value| Vec4::from(*value))
            }
            PlaceInput::VertexColor => self.color(),
            PlaceInput::Attribute(n) => {
                let values = self.mesh.attributes.get(n as usize);
                values.map_or(Vec4::ZERO, |values| self.four(values))
            }
            PlaceInput::IsRay(kinds) => number(f32::from(self.asking.kind & kinds != 0)),
            PlaceInput::RayDepth => number(self.asking.depth as f32),
            PlaceInput::IsSingularRay => number(f32::from(self.asking.past.singular)),
            PlaceInput::IsReflectionRay => number(f32::from(self.asking.past.reflected)),
            PlaceInput::PathDepth(depth) => {
                let place = match depth {
                    PathDepth::Diffuse => 0,
                    PathDepth::Glossy => 1,
                    PathDepth::Transmission => 2,
                    PathDepth::Transparent => 3,
                };
                number(f32::from(self.asking.past.depths[place]))
            }
            PlaceInput::RayLength => number(self.asking.distance),
        }
    }

    fn transformed(&self, v: Vec3, what: Transformed, from: Space, to: Space) -> Vec3 {
        let Some(facts) = self.facts().filter(|_| from != to) else {
            return v;
        };
        // Through the world, in glTF's axes.
        let world = match (from, what) {
            (Space::World, _) => from_blender(v),
            (Space::Object, Transformed::Point) => {
                facts.world_axes * v + from_blender(facts.location)
            }
            (Space::Object, Transformed::Vector) => facts.world_axes * v,
            (Space::Object, Transformed::Normal) => facts.object_axes.transpose() * v,
            (Space::Camera, _) => {
                let m = &facts.view.camera;
                let p = if what == Transformed::Point {
                    v - m.translation
                } else {
                    v
                };
                let back = Vec3::new(m.x.dot(p), m.y.dot(p), m.z.dot(p));
                if what == Transformed::Point {
                    back + facts.origin
                } else {
                    back
                }
            }
        };
        let result = match (to, what) {
            (Space::World, _) => to_blender(world),
            (Space::Object, Transformed::Point) => {
                facts.object_axes * (world - from_blender(facts.location))
            }
            (Space::Object, Transformed::Vector) => facts.object_axes * world,
            (Space::Object, Transformed::Normal) => facts.world_axes.transpose() * world,
            (Space::Camera, Transformed::Point) => {
                let m = &facts.view.camera;
                m.vector(world - facts.origin) + m.translation
            }
            (Space::Camera, _) => facts.view.camera.vector(world),
        };
        if what == Transformed::Normal {
            unit_or_zero(result)
        } else {
            result
        }
    }

    fn facing(&self, outside: Vec3) -> Vec3 {
        let n = if outside == Vec3::ZERO {
            self.outer_normal()
        } else {
            outside
        };
        to_blender(self.side(n))
    }

    fn outside(&self, facing: Vec3) -> Vec3 {
        unit_or_zero(self.side(from_blender(facing)))
    }

    fn steps(&self, pixels: f32) -> [Vec3; 2] {
        let n = to_blender(
            self.side(
                self.entry
                    .geometric_normal::<General>(self.mesh, self.triangle),
            ),
        );
        let (parallel, angle) = self.facts().map_or((0.0, 0.0), |facts| facts.view.pixel);
        let along = self.asking.distance * self.asking.direction.length();
        // A step that the floats of the point cannot tell apart gives no slope: 2⁻¹² of its coordinates leaves 11 bits.
        let least = self.in_world().abs().max_element() * f32::EPSILON * 2048.0;
        let size = ((parallel + along * angle) * pixels)
            .max(least)
            .max(f32::MIN_POSITIVE.sqrt());
        // What curves within a step makes slopes hang on where the step goes: as in Cycles.
        let steps = across(n).map(|step| step * size);
        if self.undisplaced.is_none() {
            return steps;
        }
        // The same steps of the barycentric coordinates, across the triangle before it was displaced.
        let [p, q, r] = self.mesh_corners();
        let displaced = Self {
            undisplaced: None,
            ..*self
        };
        steps.map(|step| {
            let by = displaced.barycentric(displaced.vector_to_mesh(step));
            let Some((u, v)) = by else {
                return step;
            };
            let local = (q - p) * u + (r - p) * v;
            to_blender(match &self.entry.facts {
                Some(facts) if self.entry.is_instance() => facts.world_axes * local,
                _ => local,
            })
        })
    }

    fn neighbour(&self, step: Vec3) -> Self {
        match self.barycentric(self.vector_to_mesh(step)) {
            None => *self,
            Some((u, v)) => Self {
                u: self.u + u,
                v: self.v + v,
                ..*self
            },
        }
    }

    fn undisplaced(&self, attribute: u32) -> Self {
        Self {
            undisplaced: Some(attribute),
            ..*self
        }
    }

    fn openness(&self, normal: Vec3, distance: f32, rays: Openness) -> f32 {
        let (Some(around), true) = (self.around, distance > 0.0 && rays.samples > 0) else {
            return 1.0;
        };
        let numbers = self.asking.past.numbers();
        let normal = from_blender(normal);
        let (tangent, across) = normal.any_orthonormal_pair();
        let point = self
            .entry
            .point::<General>(self.mesh, self.triangle, self.u, self.v);
        let outside = self
            .entry
            .geometric_normal::<General>(self.mesh, self.triangle);
        let mut open = 0u32;
        for sample in 0..u32::from(rays.samples) {
            let [turn, share] = spread(numbers, (sample, rays.samples));
            let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
            let radius = share.sqrt();
            let up = (1.0 - share).max(0.0).sqrt();
            let direction = (tangent * cos + across * sin) * radius + normal * up;
            let side = if outside.dot(direction) < 0.0 {
                -outside
            } else {
                outside
            };
            let origin = float::ray_origin(point, side);
            let shut = if rays.only_local {
                let ray = (origin, direction, [0.0, distance]);
                self.local_hits(around, ray, 1).next().is_some()
            } else {
                around.is_shut(origin, direction, distance)
            };
            open += u32::from(!shut);
        }
        open as f32 / f32::from(rays.samples)
    }

    fn beveled(&self, radius: f32, samples: u8) -> Vec3 {
        let own = to_blender(self.side(self.outer_normal()));
        let Some(around) = self.around else {
            return own;
        };
        if radius <= 0.0 || samples == 0 || self.asking.past.blurry {
            return own;
        }
        let numbers = self.asking.past.numbers();
        let point = self.in_world();
        let geometric = self
            .entry
            .geometric_normal::<General>(self.mesh, self.triangle);
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

    fn is_on_edge(&self, width: f32, pixels: bool) -> bool {
        let mut width = 0.5 * width;
        if pixels {
            // What a pixel is wide across the surface, projected to the viewer, by the tangents that Cycles takes.
            let normal = self
                .entry
                .geometric_normal::<General>(self.mesh, self.triangle);
            let n = to_blender(self.side(normal));
            let view = to_blender(self.asking.direction).normalize_or_zero();
            let (parallel, angle) = self.facts().map_or((0.0, 0.0), |facts| facts.view.pixel);
            let pixel = parallel + self.asking.distance * self.asking.direction.length() * angle;
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
