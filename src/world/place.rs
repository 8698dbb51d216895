//! What shader programs ask about a point of a surface.

mod beside;

use super::asking::{Around, Asking};
use super::geometry::{MeshData, MeshInstance, unit_or_zero};
use super::neighbourhood::across;
use super::strand::OnStrand;
use super::view::{View, from_blender, to_blender};
use crate::effects::General;
use crate::math::float::{Affine, BoundedPoint};
use crate::scene::graph::function::{PlaceInput, Space, Transformed};
use crate::scene::graph::{NormalSpace, TangentKind};
use crate::scene::{ObjectInfo, TextureSpace};
use crate::shading::program::{Met, Openness, Place, Strand};
use glam::{DAffine3, DMat3, DVec3, Mat3, Vec2, Vec3, Vec4};

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
    /// The same of an object that has come to another place, relative to the origin.
    pub fn moved(&self, placed: &DAffine3) -> Self {
        let origin = self.origin.as_dvec3();
        let world_from_object = DAffine3 {
            translation: placed.translation + origin,
            ..*placed
        };
        let is_shared = self.object_from_world.is_none();
        let about = (self.info.clone(), self.texture_space);
        Self::new(&world_from_object, origin, is_shared, about, self.view)
    }

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

/// A point on a triangle by its barycentric coordinates.
#[derive(Clone, Copy)]
pub struct HitPoint<'a> {
    pub(super) mesh: &'a MeshData,
    pub(super) entry: &'a MeshInstance,
    pub(super) corners: [u32; 3],
    pub(super) triangle: u32,
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) asking: Asking<'a>,
    /// The unit normal of the triangle, outside; 0 where nobody has asked for it yet.
    pub(super) outside: Vec3,
    /// The smooth normal outside; 0 where nobody has asked for it yet.
    pub(super) normal: Vec3,
    /// Barycentric coordinates of what was hit, where this is a step of a Bump beside it.
    pub(super) hit: Option<(f32, f32)>,
    /// What it was before it was displaced, where that is asked for.
    pub(super) undisplaced: Option<beside::Undisplaced>,
    /// The scene, where programs ask it.
    pub(super) around: Option<&'a dyn Around>,
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

    pub(super) fn facts(&self) -> Option<&ObjectFacts> {
        self.entry.facts.as_deref()
    }

    /// The size of a pixel of the picture here, metres; 0 where nothing is known of who looks.
    #[inline]
    pub(super) fn pixel(&self) -> f32 {
        let asking = &self.asking;
        let distance = asking.distance * asking.direction.length();
        let along = asking.past.way + distance;
        let view = self.facts().map(|facts| &facts.view);
        view.map_or(0.0, |v| {
            v.pixel_at(asking.direction, along, asking.depth > 0) + asking.past.wide.at(distance)
        })
    }

    /// The corners in the mesh's space: the world's, relative to the origin, where it is placed once.
    #[inline]
    fn mesh_corners(&self) -> [Vec3; 3] {
        let before = self
            .undisplaced
            .and_then(|before| self.mesh.attributes.get(before.attribute as usize));
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

    /// In the mesh's space.
    #[inline]
    pub(super) fn in_mesh(&self) -> Vec3 {
        if let Some(strand) = OnStrand::of(self) {
            return strand.place;
        }
        self.place_between(self.mesh_corners(), |way| way)
    }

    /// A vector of Blender's world in the mesh's space.
    #[inline]
    pub(super) fn vector_to_mesh(&self, v: Vec3) -> Vec3 {
        let v = from_blender(v);
        match (&self.entry.facts, self.entry.is_instance()) {
            (Some(facts), true) => facts.object_axes * v,
            _ => v,
        }
    }

    fn generated(&self, facts: &ObjectFacts) -> Vec3 {
        match &self.mesh.generated {
            Some(values) => self.vector(values),
            // It is an attribute in Cycles, whatever it is made of here.
            None => facts
                .texture_space
                .generated(Self { hit: None, ..*self }.in_object()),
        }
    }

    /// The tangent about an axis through the middle of the texture space, on the viewer's side: turned into the world as
    /// normals are, as in Cycles.
    fn around(&self, facts: &ObjectFacts, axis: u8) -> Vec3 {
        let p = self.generated(facts) - 0.5;
        let around = match axis {
            0 => Vec3::new(0.0, -p.z, p.y),
            1 => Vec3::new(-p.z, 0.0, p.x),
            _ => Vec3::new(-p.y, p.x, 0.0),
        };
        let world = facts.object_axes.transpose() * around;
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
    #[inline]
    pub(super) fn in_world(&self) -> Vec3 {
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
    #[inline]
    fn in_object(&self) -> Vec3 {
        let facts = self.facts();
        let to_object = facts.and_then(|facts| facts.object_from_world.as_ref());
        if let Some(strand) = OnStrand::of(self) {
            return to_object.map_or(strand.place, |m| m.vector(strand.place) + m.translation);
        }
        match to_object {
            // The corners are brought there, not the point: what their places in the world are rounded to is the same for all points
            // of the triangle, so that small steps are as exact as they are close to the object.
            Some(m) => {
                let corners = self.mesh_corners().map(|p| m.vector(p) + m.translation);
                self.place_between(corners, |way| m.vector(way))
            }
            None => self.in_mesh(),
        }
    }

    #[inline]
    pub(super) fn outer_normal(&self) -> Vec3 {
        if self.normal == Vec3::ZERO {
            self.entry.smooth_normal(self.mesh, self)
        } else {
            self.normal
        }
    }

    /// The unit normal of the triangle, outside.
    #[inline]
    pub(super) fn geometric_normal(&self) -> Vec3 {
        if self.outside == Vec3::ZERO {
            if let Some(strand) = OnStrand::of(self) {
                return strand.facing;
            }
            self.entry
                .geometric_normal::<General>(self.mesh, self.triangle)
        } else {
            self.outside
        }
    }

    #[inline]
    fn is_inside(&self) -> bool {
        self.geometric_normal().dot(self.asking.direction) > 0.0
    }

    #[inline]
    pub(super) fn side(&self, n: Vec3) -> Vec3 {
        if self.is_inside() { -n } else { n }
    }

    /// A tangent-space normal in the frame of the corners' tangents and normals, as Cycles has it: in the object's own axes, not
    /// orthogonal between the corners, and the tangent not of unit length. 0 where there are no tangents.
    /// `before`: the attribute with the normals that stand for the corners'. `unit`: the corners' own make one of unit length.
    fn mapped_by_corners(&self, mapped: Vec3, (before, unit): (Option<u32>, bool)) -> Vec3 {
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
        let before = before
            .and_then(|n| self.mesh.attributes.get(n as usize))
            .map(|values| self.four(values))
            .filter(|normal| normal.w > 0.0);
        let normal = match &self.mesh.normals {
            Some(_) if let Some(before) = before => before.truncate(),
            Some(normals) => {
                let corners = self.corners.map(|i| Vec3::from(normals[i as usize]));
                let normal = between(corners.map(normal_of), self.u, self.v);
                if unit { unit_or_zero(normal) } else { normal }
            }
            // A bump of the displacement has not turned it.
            None => unit_or_zero(axes.transpose() * self.geometric_normal()),
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
            NormalSpace::Tangent | NormalSpace::Spread => {
                let share = strength.clamp(0.0, 1.0);
                let z = 1.0 + (normal.z - 1.0) * share;
                let scaled = Vec3::new(normal.x * strength, normal.y * strength, z);
                let unit = space == NormalSpace::Tangent;
                return self.mapped_by_corners(scaled, (None, unit));
            }
            NormalSpace::Before(attribute) => {
                self.mapped_by_corners(normal, (Some(attribute), true))
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
    fn strand(&self) -> Strand {
        match OnStrand::of(self) {
            Some(on) => self.strand_told(&on),
            None => self.strand_of_mesh(),
        }
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
                full(self.normal_in_object(to_blender(self.side(self.stepped_normal()))))
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
            PlaceInput::Tangent => full(match OnStrand::of(self) {
                Some(strand) => strand.blenders_tangent(),
                None => self.around(facts, 2),
            }),
            // The node Tangent knows no steps of Bumps.
            PlaceInput::RadialTangent(axis) => full(self.at_hit().around(facts, axis)),
            PlaceInput::UvTangent => full(self.at_hit().along_uv(facts)),
            PlaceInput::TrueNormal => full(to_blender(self.side(self.geometric_normal()))),
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
            // It is inside of what has surfaces.
            PlaceInput::Grid { otherwise, .. } => number(otherwise),
            PlaceInput::VertexColor => self.color(),
            PlaceInput::Attribute(n) => {
                let values = self.mesh.attributes.get(n as usize);
                values.map_or(Vec4::ZERO, |values| self.four(values))
            }
            PlaceInput::IsRay(kinds) => number(f32::from(self.asking.kind & kinds != 0)),
            PlaceInput::RayDepth => number(self.asking.depth as f32),
            PlaceInput::IsSingularRay => number(f32::from(self.asking.past.singular)),
            PlaceInput::IsReflectionRay => number(f32::from(self.asking.past.reflected)),
            PlaceInput::PathDepth(depth) => number(self.asking.past.depth(depth)),
            PlaceInput::RayLength => number(self.asking.distance - self.asking.near),
            PlaceInput::IsStrand
            | PlaceInput::StrandThickness
            | PlaceInput::StrandNormal
            | PlaceInput::PointPosition
            | PlaceInput::PointRadius => self.strand_info(input, facts.origin),
            PlaceInput::FibreCover(aspect) => number(f32::from(self.is_on_fibre(aspect))),
        }
    }

    fn transformed(&self, v: Vec3, what: Transformed, from: Space, to: Space) -> Vec3 {
        let Some(facts) = self.facts().filter(|_| from != to) else {
            return v;
        };
        let origin = (what == Transformed::Point).then_some(facts.origin);
        // Through the world, in glTF's axes.
        let world = match (from, what) {
            (Space::World, _) => from_blender(v),
            (Space::Object, Transformed::Point) => {
                facts.world_axes * v + from_blender(facts.location)
            }
            (Space::Object, Transformed::Vector) => facts.world_axes * v,
            (Space::Object, Transformed::Normal) => facts.object_axes.transpose() * v,
            (Space::Camera, _) => facts.view.world_from_camera(v, origin),
        };
        let result = match (to, what) {
            (Space::World, _) => to_blender(world),
            (Space::Object, Transformed::Point) => {
                facts.object_axes * (world - from_blender(facts.location))
            }
            (Space::Object, Transformed::Vector) => facts.object_axes * world,
            (Space::Object, Transformed::Normal) => facts.world_axes.transpose() * world,
            (Space::Camera, _) => facts.view.camera_from_world(world, origin),
        };
        if what == Transformed::Normal {
            unit_or_zero(result)
        } else {
            result
        }
    }

    fn box_normal(&self) -> Vec3 {
        self.normal_in_object(to_blender(self.side(self.outer_normal())))
    }

    #[inline]
    fn facing(&self, outside: Vec3) -> Vec3 {
        let n = if outside == Vec3::ZERO {
            self.outer_normal()
        } else {
            outside
        };
        to_blender(self.side(n))
    }

    #[inline]
    fn outside(&self, facing: Vec3) -> Vec3 {
        let n = self.side(from_blender(facing));
        // A unit vector comes back as it is: within the rounding of its length's square, four roundings.
        if (n.length_squared() - 1.0).abs() <= 4.0 * f32::EPSILON {
            n
        } else {
            unit_or_zero(n)
        }
    }

    #[inline]
    fn steps(&self, pixels: f32) -> [Vec3; 2] {
        let n = to_blender(self.side(self.geometric_normal()));
        // A step that the floats of the point cannot tell apart gives no slope: 2⁻¹⁸ of its coordinates leaves 5 bits to heights that
        // depend on the place in the world; a pixel of the picture can be as small. Objects' own coordinates have all bits.
        let least = self.in_world().abs().max_element() * f32::EPSILON * 32.0;
        let size = (self.pixel() * pixels)
            .max(least)
            .max(f32::MIN_POSITIVE.sqrt());
        // What curves within a step makes slopes hang on where the step goes: as in Cycles.
        let steps = across(n).map(|step| step * size);
        if self.undisplaced.is_none() {
            return steps;
        }
        // The same steps of the barycentric coordinates, across the triangle before it was displaced.
        let displaced = self.displaced();
        let by = displaced.barycentric(steps.map(|step| displaced.vector_to_mesh(step)));
        by.map_or(steps, |by| {
            by.map(|by| self.ways_of_steps().1 * self.way(by))
        })
    }

    fn of_neighbours(&self, steps: [Vec3; 2], mut number: impl FnMut(&Self) -> f32) -> [f32; 2] {
        let by = self.barycentric(steps.map(|step| self.vector_to_mesh(step)));
        let by = by.unwrap_or_default();
        let (attributes, places) = self.ways_of_steps();
        // Places go along the displaced triangle, as in Cycles: until 4.5 as far as the steps do on average.
        let ways = self.undisplaced.map(|before| {
            if before.is_of_5 {
                return by.map(|by| places * self.displaced().way(by));
            }
            let size = 0.5 * (steps[0].length() + steps[1].length());
            across(to_blender(self.side(self.geometric_normal()))).map(|way| way * size)
        });
        [0, 1].map(|i| {
            let mut there = *self;
            there.hit = self.hit.or(Some((self.u, self.v)));
            (there.u, there.v) = (self.u + attributes * by[i].0, self.v + attributes * by[i].1);
            if let (Some(before), Some(ways)) = (&mut there.undisplaced, ways) {
                before.way += ways[i];
            }
            number(&there)
        })
    }

    fn undisplaced(&self, attribute: u32, is_of_5: bool) -> Self {
        let mut before = Self {
            undisplaced: Some(beside::Undisplaced {
                attribute,
                is_of_5,
                way: Vec3::ZERO,
            }),
            ..*self
        };
        let values = self.mesh.attributes.get(attribute as usize);
        let is_flat =
            |values: &Vec<[f32; 4]>| self.corners.iter().all(|&c| values[c as usize][3] == 0.0);
        if is_of_5 && values.is_some_and(is_flat) {
            let corners = before.mesh_corners();
            before.normal = self.entry.normal_between::<General>(corners);
        }
        before
    }

    fn openness(&self, normal: Vec3, distance: f32, rays: Openness) -> f32 {
        self.at_hit().open_share(normal, distance, rays)
    }

    fn beveled(&self, radius: f32, samples: u8) -> Vec3 {
        self.at_hit().beveled_normal(radius, samples)
    }

    fn met(&self, ray: (Vec3, Vec3, f32), only_local: bool) -> Option<Met> {
        self.met_along(ray, only_local)
    }

    fn is_on_edge(&self, width: f32, pixels: bool) -> bool {
        self.is_near_edge(width, pixels)
    }
}
