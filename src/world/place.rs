//! What shader programs ask about a point of a surface.

use super::Options;
use super::geometry::{MeshData, MeshInstance, unit_or_zero};
use crate::effects::General;
use crate::ffi::embree::Hit;
use crate::math::float::{Affine, BoundedPoint};
use crate::scene::graph::function::{PlaceInput, Space, Transformed};
use crate::scene::graph::{NormalSpace, TangentKind};
use crate::scene::{ObjectInfo, Projection, RayKind, TextureSpace};
use crate::shading::program::Place;
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
}

impl View {
    /// That of a world's camera.
    pub fn new(options: &Options, origin: DVec3) -> Self {
        let camera = options.camera;
        let to_camera = camera.world_from_camera.inverse();
        // glTF's cameras look along −Z.
        let flip = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        let flipped = DAffine3 {
            matrix3: flip * to_camera.matrix3,
            translation: flip * to_camera.transform_point3(origin),
        };
        let window = camera.window.map(|w| w.widened_to(options.aspect));
        let height = |plain: f64| window.map_or(plain, |w| w.top - w.bottom);
        let (parallel, angle) = match camera.projection {
            Projection::Perspective { vertical_fov, .. } => {
                (0.0, height(2.0 * (0.5 * vertical_fov).tan()))
            }
            Projection::Orthographic { half_height, .. } => (height(2.0 * half_height), 0.0),
            Projection::Equirectangular { latitude, .. } => (0.0, latitude[1] - latitude[0]),
        };
        let rows = f64::from(options.rows.max(1));
        Self {
            camera: Affine::from_f64(&flipped, DVec3::ZERO),
            pixel: ((parallel / rows) as f32, (angle / rows) as f32),
        }
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

    /// The texture coordinates that the mesh's own space gives.
    fn generated(&self, object: Vec3) -> Vec3 {
        let TextureSpace { location, size } = self.texture_space;
        let (location, size) = (Vec3::from(location), Vec3::from(size));
        let size = Vec3::select(size.cmpeq(Vec3::ZERO), Vec3::ONE, size);
        (object - location + size) / (size * 2.0)
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
}

impl Asking {
    /// A shadow ray, with a hit on its way.
    pub fn of_shadow(direction: Vec3, hit: &Hit) -> Self {
        Self {
            distance: hit.distance,
            kind: RayKind::Shadow.bit(),
            ..Self::along(direction)
        }
    }

    /// Nobody in particular, along a direction.
    pub fn along(direction: Vec3) -> Self {
        Self {
            direction,
            distance: 0.0,
            kind: 0,
            depth: 0,
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

    /// In the mesh's space: the world's, relative to the origin, where it is placed once.
    fn in_mesh(&self) -> Vec3 {
        between(self.mesh.corners(self.triangle), self.u, self.v)
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
        let tangent = between(
            self.corners.map(|i| {
                let t = Vec4::from(tangents[i as usize]).truncate();
                if in_world { unit_or_zero(back * t) } else { t }
            }),
            self.u,
            self.v,
        );
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
            PlaceInput::Generated => full(facts.generated(self.in_object())),
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
            PlaceInput::Tangent => {
                // About the object's Z axis, through the middle of the texture space.
                let p = facts.generated(self.in_object());
                let around = Vec3::new(-(p.y - 0.5), p.x - 0.5, 0.0);
                let world = to_blender(facts.world_axes * around);
                let n = to_blender(self.side(self.outer_normal()));
                full(unit_or_zero(n.cross(unit_or_zero(world).cross(n))))
            }
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
            PlaceInput::VertexColor => self.color(),
            PlaceInput::Attribute(n) => {
                let values = self.mesh.attributes.get(n as usize);
                values.map_or(Vec4::ZERO, |values| self.four(values))
            }
            PlaceInput::IsRay(kinds) => number(f32::from(self.asking.kind & kinds != 0)),
            PlaceInput::RayDepth => number(self.asking.depth as f32),
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
        let (a, b) = n.any_orthonormal_pair();
        // Their cross product is the normal.
        if a.cross(b).dot(n) < 0.0 {
            [b * size, a * size]
        } else {
            [a * size, b * size]
        }
    }

    fn neighbour(&self, step: Vec3) -> Self {
        let step = from_blender(step);
        let local = match (&self.entry.facts, self.entry.is_instance()) {
            (Some(facts), true) => facts.object_axes * step,
            _ => step,
        };
        let [a, b, c] = self.mesh.corners(self.triangle);
        let (e1, e2) = (b - a, c - a);
        // The step by the edges: least squares in the triangle's plane.
        let (d11, d12, d22) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
        let (s1, s2) = (local.dot(e1), local.dot(e2));
        let det = d11 * d22 - d12 * d12;
        if det == 0.0 {
            return *self;
        }
        Self {
            u: self.u + (s1 * d22 - s2 * d12) / det,
            v: self.v + (s2 * d11 - s1 * d12) / det,
            ..*self
        }
    }

    fn object_scale(&self) -> f32 {
        // The mean of the axes, as in Cycles' "object space" distances.
        self.facts().map_or(1.0, |facts| {
            let m = facts.world_axes;
            (m.x_axis.length() + m.y_axis.length() + m.z_axis.length()) / 3.0
        })
    }
}
