//! Meshes, placed meshes, and the surface at a hit.

use super::asking::Asking;
use super::moving::{self, Path, Slack};
use super::place::{HitPoint, ObjectFacts};
use super::strand::{OnStrand, StrandData};
use super::turned::{
    as_normal, cofactor, double, outside_cofactor, placed_normals, placed_points, unit,
};
use crate::effects::{Features, General};
use crate::ffi::embree::{EmbreeError, TriangleMesh};
use crate::math::float::{self, Affine, BoundedPoint, triangle_point};
use crate::scene::graph::TangentKind;
use crate::scene::{Mesh, Visibility};
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A mesh with its attributes, in object space, or in world space if it is placed once.
pub struct MeshData {
    /// Shared with Embree.
    pub triangles: Arc<TriangleMesh>,
    pub(super) normals: Option<Vec<[f32; 3]>>,
    /// It comes with normals, be they those of its triangles: Blender's flat meshes have none.
    pub(super) is_shaded_smooth: bool,
    /// The normals at steps of time, where they move.
    pub(super) moving_normals: Vec<Vec<[f32; 3]>>,
    pub(super) tangents: Option<Vec<[f32; 4]>>,
    pub(super) radial: Option<Vec<[f32; 3]>>,
    /// Coordinates that programs ask for, where the mesh's texture space does not give them.
    pub(super) generated: Option<Vec<[f32; 3]>>,
    pub(super) uvs: Vec<Vec<[f32; 2]>>,
    pub(super) colors: Option<Vec<[f32; 4]>>,
    /// Attributes that programs ask for, by their numbers.
    pub(super) attributes: Vec<Vec<[f32; 4]>>,
    /// It is made of strands or points, and the triangles stand for their segments.
    pub(super) strands: Option<StrandData>,
    /// Index of the material.
    pub material: u32,
}

/// Attributes of vertices that somebody reads, besides normals, which all shading does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attributes {
    /// So many sets of texture coordinates.
    pub uv_sets: usize,
    /// Tangents.
    pub tangents: bool,
    /// Radial tangents.
    pub radial: bool,
    /// Generated coordinates.
    pub generated: bool,
    /// Colours.
    pub colors: bool,
    /// So many attributes.
    pub attributes: usize,
}

impl MeshData {
    /// Takes a mesh over, transformed in f64 if it stands in world space.
    pub fn new(
        mesh: &Mesh,
        material: u32,
        transform: Option<&DAffine3>,
        kept: Attributes,
    ) -> Result<Self, EmbreeError> {
        let d3 = double;
        let given_normals = mesh.normals.as_ref().filter(|_| mesh.is_smooth());
        let given_tangents = mesh.tangents.as_ref().filter(|_| kept.tangents);
        let given_radial = mesh.radial.as_ref().filter(|_| kept.radial);
        let steps = moving::steps(mesh, transform).into_iter();
        let (moved, moving_normals): (Vec<_>, Vec<_>) =
            steps.map(|step| (step.positions, step.normals)).unzip();
        let given_normals = given_normals.or_else(|| {
            let moves = !mesh.motion.is_empty();
            mesh.normals.as_ref().filter(|_| moves)
        });
        let (positions, normals, tangents, radial) = match transform {
            None => (
                mesh.positions.clone(),
                given_normals.cloned(),
                given_tangents.cloned(),
                given_radial.cloned(),
            ),
            Some(t) => {
                let mirrored = t.matrix3.determinant() < 0.0;
                let n = outside_cofactor(&t.matrix3);
                (
                    placed_points(t, &mesh.positions),
                    given_normals.map(|v| placed_normals(t, v)),
                    given_tangents.map(|v| {
                        v.iter()
                            .map(|x| {
                                let d = unit(t.matrix3 * d3(&[x[0], x[1], x[2]]));
                                [d[0], d[1], d[2], if mirrored { -x[3] } else { x[3] }]
                            })
                            .collect()
                    }),
                    given_radial.map(|v| v.iter().map(|x| as_normal(&n, d3(x))).collect()),
                )
            }
        };
        Ok(Self {
            strands: StrandData::of((mesh, transform), (&positions, &moved))?,
            triangles: Arc::new(moving::triangles(
                TriangleMesh::new(positions, mesh.triangles.clone())?,
                moved,
            )?),
            normals,
            is_shaded_smooth: mesh.normals.is_some(),
            moving_normals: moving_normals.into_iter().flatten().collect(),
            tangents,
            radial,
            generated: mesh.generated.clone().filter(|_| kept.generated),
            uvs: mesh.uvs.iter().take(kept.uv_sets).cloned().collect(),
            attributes: mesh
                .attributes
                .iter()
                .take(kept.attributes)
                .cloned()
                .collect(),
            colors: mesh
                .colors
                .clone()
                .filter(|c| kept.colors && c.iter().flatten().any(|&c| c != 1.0)),
            material,
        })
    }

    /// Bytes of corners and of attributes.
    pub fn bytes(&self) -> (u64, u64) {
        let of = |values: usize, size: usize| (values * size) as u64;
        let normals = self.normals.as_ref().map_or(0, Vec::len);
        let tangents = self.tangents.as_ref().map_or(0, Vec::len);
        let radial = self.radial.as_ref().map_or(0, Vec::len);
        let generated = self.generated.as_ref().map_or(0, Vec::len);
        let colors = self.colors.as_ref().map_or(0, Vec::len);
        let uvs = self.uvs.iter().map(Vec::len).sum();
        let moving: usize = self.moving_normals.iter().map(Vec::len).sum();
        let strands = self.strands.as_ref().map_or(0, StrandData::bytes);
        (
            of(
                self.triangles.vertices().len(),
                12 * (1 + self.triangles.steps()),
            ) + of(self.triangles.triangles().len(), 12)
                + strands as u64,
            of(moving + normals + radial + generated, 12) + of(tangents + colors, 16) + of(uvs, 8),
        )
    }

    /// The box about its corners where they are placed.
    pub fn bounds(&self, place: &Affine) -> (Vec3, Vec3) {
        let corners = self.triangles.vertices().iter().map(|&p| {
            let point = Vec3::from(p);
            let error = Vec3::ZERO;
            place.bounded_point(BoundedPoint { point, error }).point
        });
        corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        })
    }

    /// Whether it has normals of vertices.
    pub fn has_normals(&self) -> bool {
        self.normals.is_some()
    }

    /// Whether it has texture coordinates.
    pub fn has_uvs(&self) -> bool {
        !self.uvs.is_empty()
    }

    /// Corners of a triangle, in the mesh's space.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles.corners(triangle).map(Vec3::from)
    }
}

/// A mesh placed in the top scene; the index is Embree's number of the geometry.
#[derive(Clone)]
pub struct MeshInstance {
    /// Which mesh.
    pub mesh: u32,
    instance: Option<Box<Placement>>,
    /// The placement mirrors: winding is turned over.
    flipped: bool,
    /// Which rays see it.
    pub visibility: Visibility,
    /// Entries that are parts of one object have one number.
    pub object: u32,
    /// What programs may ask about it, where some do.
    pub facts: Option<Arc<ObjectFacts>>,
    /// It is one thing at one time and another at another: see [`super::moving`].
    pub moves: bool,
    pub(super) slack: Slack,
    path: Option<Path>,
}

#[derive(Clone)]
struct Placement {
    world_from_object: Affine,
    /// For normals, with the sign that keeps them outside.
    normal: [Vec3; 3],
}

impl MeshInstance {
    /// A point on a triangle of its mesh, for look-ups, as a ray sees it.
    #[inline]
    pub fn at<'a>(
        &'a self,
        mesh: &'a MeshData,
        (triangle, u, v): (u32, f32, f32),
        asking: Asking<'a>,
    ) -> HitPoint<'a> {
        HitPoint {
            mesh,
            entry: self,
            corners: mesh.triangles.triangles()[triangle as usize],
            triangle,
            u,
            v,
            asking,
            outside: Vec3::ZERO,
            normal: Vec3::ZERO,
            hit: None,
            undisplaced: None,
            around: None,
        }
    }

    /// A mesh in world space.
    pub fn flat(mesh: u32, flipped: bool, visibility: Visibility) -> Self {
        Self {
            mesh,
            instance: None,
            flipped,
            visibility,
            object: 0,
            facts: None,
            moves: false,
            slack: Slack::default(),
            path: None,
        }
    }

    /// An instance; `transform` is already relative to the origin.
    pub fn instance(mesh: u32, transform: &DAffine3, visibility: Visibility) -> Self {
        let flipped = transform.matrix3.determinant() < 0.0;
        // Scaled to order 1 so that normals of tiny or huge instances stay in range.
        let c = cofactor(&transform.matrix3);
        let size = c
            .x_axis
            .abs()
            .max_element()
            .max(c.y_axis.abs().max_element())
            .max(c.z_axis.abs().max_element());
        let c = c * (if flipped { -1.0 } else { 1.0 } / if size > 0.0 { size } else { 1.0 });
        let placement = Placement {
            world_from_object: Affine::from_f64(transform, DVec3::ZERO),
            normal: [c.x_axis.as_vec3(), c.y_axis.as_vec3(), c.z_axis.as_vec3()],
        };
        Self {
            mesh,
            instance: Some(Box::new(placement)),
            flipped,
            visibility,
            object: 0,
            facts: None,
            moves: false,
            slack: Slack::default(),
            path: None,
        }
    }

    /// The same, with what programs may ask about it.
    #[must_use]
    pub fn with_facts(self, facts: Option<Arc<ObjectFacts>>) -> Self {
        Self { facts, ..self }
    }

    /// The same moving, on a way of its own or with its mesh alone.
    #[must_use]
    pub fn moving(self, path: Option<Path>) -> Self {
        Self {
            moves: true,
            path,
            ..self
        }
    }

    /// Its way, where it has one.
    pub(super) fn path(&self) -> Option<Path> {
        self.path
    }

    /// The placement of an instance.
    #[inline(always)]
    fn placement<E: Features>(&self) -> Option<&Placement> {
        if E::CURVED {
            self.instance.as_deref()
        } else {
            None
        }
    }

    /// Whether it is an instance.
    pub fn is_instance(&self) -> bool {
        self.instance.is_some()
    }

    /// The placement (identity for a flat mesh).
    pub fn transform(&self) -> Affine {
        self.placement::<General>().map_or(
            Affine {
                x: Vec3::X,
                y: Vec3::Y,
                z: Vec3::Z,
                translation: Vec3::ZERO,
            },
            |p| p.world_from_object,
        )
    }

    #[inline]
    pub(super) fn normal<E: Features>(&self, n: Vec3) -> Vec3 {
        match self.placement::<E>() {
            None => n,
            Some(p) => p.normal[0] * n.x + p.normal[1] * n.y + p.normal[2] * n.z,
        }
    }

    /// Corners of a triangle in world space.
    pub fn world_corners(&self, mesh: &MeshData, triangle: u32) -> [Vec3; 3] {
        let corners = mesh.corners(triangle);
        match &self.instance {
            None => corners,
            Some(p) => corners.map(|c| {
                p.world_from_object
                    .bounded_point(BoundedPoint {
                        point: c,
                        error: Vec3::ZERO,
                    })
                    .point
            }),
        }
    }

    /// A point of a triangle in world space, with its error bound, which does not reach over an edge.
    #[inline]
    pub fn point<E: Features>(
        &self,
        mesh: &MeshData,
        triangle: u32,
        u: f32,
        v: f32,
    ) -> BoundedPoint {
        self.point_between::<E>(mesh.corners(triangle), u, v)
    }

    /// The same between corners of the mesh.
    #[inline]
    pub(super) fn point_between<E: Features>(
        &self,
        corners: [Vec3; 3],
        u: f32,
        v: f32,
    ) -> BoundedPoint {
        let point = self.placed::<E>(triangle_point(corners, u, v));
        if !float::is_near_an_edge(u, v) {
            return point;
        }
        let edges = [corners[1] - corners[0], corners[2] - corners[0]].map(|e| self.vector::<E>(e));
        let (u, v) = float::off_the_edges(edges, u, v, point.error.max_element());
        self.placed::<E>(triangle_point(corners, u, v))
    }

    #[inline]
    fn placed<E: Features>(&self, local: BoundedPoint) -> BoundedPoint {
        if E::EVERYTHING && self.moves {
            return self.placed_for_a_moment(local);
        }
        match self.placement::<E>() {
            None => local,
            Some(p) => p.world_from_object.bounded_point(local),
        }
    }

    #[cold]
    fn placed_for_a_moment(&self, mut local: BoundedPoint) -> BoundedPoint {
        local.error += self.slack.corners;
        let Some(p) = &self.instance else {
            return local;
        };
        let mut point = p.world_from_object.bounded_point(local);
        let Affine { x, y, z, .. } = p.world_from_object;
        let size = Vec3::new(x.length(), y.length(), z.length()).dot(local.point.abs());
        point.error += self.slack.origin + Vec3::splat(self.slack.axes * size);
        point
    }

    /// A direction of the mesh in world space.
    #[inline]
    pub(super) fn vector<E: Features>(&self, v: Vec3) -> Vec3 {
        match self.placement::<E>() {
            None => v,
            Some(p) => p.world_from_object.vector(v),
        }
    }

    /// Unit normal of a triangle by its winding in world space (outside by glTF's rule).
    #[inline]
    pub fn geometric_normal<E: Features>(&self, mesh: &MeshData, triangle: u32) -> Vec3 {
        self.normal_between::<E>(mesh.corners(triangle))
    }

    /// The same between corners of the mesh.
    #[inline]
    pub(super) fn normal_between<E: Features>(&self, [a, b, c]: [Vec3; 3]) -> Vec3 {
        let n = (b - a).cross(c - a);
        // Unit first: the cross product of tiny edges leaves f32's range under a transform.
        let n = unit_or_zero(n);
        // A flat mirrored mesh has its winding turned over by the positions themselves; an
        // instance's normals are transformed with the sign already.
        if self.placement::<E>().is_none() {
            if self.flipped { -n } else { n }
        } else {
            unit_or_zero(self.normal::<E>(n))
        }
    }
}

/// Normalises vectors of any size that f32 holds: those that are twice as long to the same bits.
#[inline]
pub(super) fn unit_or_zero(v: Vec3) -> Vec3 {
    // Squares that underflow are below 1e-13 of their sum.
    if (1e-24..1e36).contains(&v.length_squared()) {
        return v.normalize();
    }
    let size = v.abs().max_element();
    if size > 0.0 && size.is_finite() {
        let exponent = f32::from_bits(size.to_bits() & f32::INFINITY.to_bits());
        (v / exponent.max(f32::MIN_POSITIVE)).normalize()
    } else {
        Vec3::ZERO
    }
}

impl MeshInstance {
    /// The normal that those of the corners make at a point, outside; the triangle's own where there are none. It can point to the
    /// other side of the triangle, where light from before it is seen by nobody: as in Cycles.
    pub fn smooth_normal(&self, mesh: &MeshData, at: &HitPoint) -> Vec3 {
        if let Some(strand) = OnStrand::of(at) {
            return strand.normal;
        }
        let outside = at.geometric_normal();
        let Some(normals) = &mesh.normals else {
            return outside;
        };
        let smooth = unit_or_zero(self.normal::<General>(at.vector(normals)));
        if smooth == Vec3::ZERO {
            outside
        } else {
            smooth
        }
    }

    /// The normal that a tangent-space one stands for, on the outside; 0 where there is none.
    pub fn mapped_normal(&self, at: &HitPoint, normal: Vec3, mapped: Vec3) -> Vec3 {
        let Some((t, b)) = self.tangent_frame(at, normal) else {
            return Vec3::ZERO;
        };
        let n = unit_or_zero(t * mapped.x + b * mapped.y + normal * mapped.z);
        if n.dot(normal) > 0.0 { n } else { Vec3::ZERO }
    }

    /// A direction along the surface; 0 where there is none.
    pub fn tangent(
        &self,
        at: &HitPoint,
        normal: Vec3,
        (kind, direction): (TangentKind, Vec2),
    ) -> Vec3 {
        if let Some(strand) = OnStrand::of(at) {
            return unit_or_zero(strand.tangent);
        }
        match kind {
            TangentKind::Uv => match self.tangent_frame(at, normal) {
                Some((t, b)) => t * direction.x + b * direction.y,
                None => Vec3::ZERO,
            },
            TangentKind::Radial => match &at.mesh.radial {
                Some(radial) => self.normal::<General>(at.vector(radial)),
                None => Vec3::ZERO,
            },
        }
    }

    /// Tangent and bitangent across the smooth normal.
    fn tangent_frame(&self, at: &HitPoint, normal: Vec3) -> Option<(Vec3, Vec3)> {
        let mesh = at.mesh;
        let (tangent, sign) = match &mesh.tangents {
            Some(tangents) => {
                let [a, b, c] = at.corners.map(|i| Vec4::from(tangents[i as usize]));
                let t = a + (b - a) * at.u + (c - a) * at.v;
                // The handedness is one of the triangle, not to be interpolated.
                (t.truncate(), if a.w < 0.0 { -1.0 } else { 1.0 })
            }
            None => {
                // From the triangle's own texture coordinates.
                let [p0, p1, p2] = mesh.corners(at.triangle);
                let uv = mesh.uvs.first()?;
                let [t0, t1, t2] = at.corners.map(|i| Vec2::from(uv[i as usize]));
                let (d1, d2) = (t1 - t0, t2 - t0);
                let det = d1.perp_dot(d2);
                if det == 0.0 {
                    return None;
                }
                (
                    (((p1 - p0) * d2.y) - ((p2 - p0) * d1.y)) / det,
                    if det < 0.0 { 1.0 } else { -1.0 },
                )
            }
        };
        let world = self.vector::<General>(tangent);
        // Given tangents of a mesh in world space have their sign turned over already.
        let mirror = if self.flipped && (self.instance.is_some() || mesh.tangents.is_none()) {
            -1.0
        } else {
            1.0
        };
        let t = unit_or_zero(world - normal * normal.dot(world));
        if t == Vec3::ZERO {
            return None;
        }
        Some((t, normal.cross(t) * (sign * mirror)))
    }
}
