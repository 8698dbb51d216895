//! Strands of hair and points, where rays meet them.

use super::geometry::{MeshInstance, unit_or_zero};
use super::neighbourhood::across;
use super::place::HitPoint;
use super::view::{from_blender, to_blender};
use super::{Hit, World};
use crate::effects::General;
use crate::ffi::embree::{EmbreeError, StrandMesh};
use crate::math::float::{BoundedPoint, gamma};
use crate::scene::graph::function::PlaceInput;
use crate::scene::{Mesh, RayKind, StrandShape};
use crate::shading::program::Strand;
use glam::{DAffine3, Mat3, Vec3, Vec4};
use std::sync::Arc;

/// What a mesh of strands has beside the attributes of its vertices.
pub struct StrandData {
    /// Shared with Embree.
    pub mesh: Arc<StrandMesh>,
    /// Of the curves, Blender's axes, at both ends of each segment; empty where there are none. They do not turn with objects.
    normals: Vec<[[f32; 3]; 2]>,
}

/// The strand that a ray leaves, which it does not meet: a flat one would be in the way of all rays from it. As in Cycles, it is
/// the whole curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeftStrand {
    object: u32,
    curve: u32,
}

impl StrandData {
    /// Of a mesh in its own space, or in the world's by a transform, with its places there and those at steps of time. `None` if
    /// it is made of triangles.
    pub fn of(
        (mesh, transform): (&Mesh, Option<&DAffine3>),
        (positions, moved): (&[[f32; 3]], &[Vec<[f32; 3]>]),
    ) -> Result<Option<Self>, EmbreeError> {
        let Some(strands) = &mesh.strands else {
            return Ok(None);
        };
        // The mean of the scales, as in Cycles.
        let scale = transform.map_or(1.0, |t| t.matrix3.determinant().abs().cbrt() as f32);
        let radii: Vec<f32> = strands.radii.iter().map(|r| r * scale).collect();
        let still = [positions.to_vec()];
        let steps = if moved.is_empty() { &still[..] } else { moved };
        let segments = mesh.triangles.iter().map(|&[from, to, _]| [from, to]);
        let made = StrandMesh::new(strands.shape, steps, &radii, segments.clone())?;
        let mut normals = Vec::new();
        if !strands.normals.is_empty() {
            normals = segments
                .map(|ends| ends.map(|i| strands.normals[i as usize]))
                .collect();
        }
        Ok(Some(Self {
            mesh: Arc::new(made),
            normals,
        }))
    }

    /// One segment, as it is at a time.
    pub fn at_time(&self, segment: u32, time: f32) -> Self {
        let normals = self.normals.get(segment as usize);
        Self {
            mesh: Arc::new(self.mesh.at_time(segment, time)),
            normals: normals.copied().into_iter().collect(),
        }
    }

    /// The curve's normal along a segment, of any length; 0 where there is none.
    fn normal(&self, segment: u32, u: f32) -> Vec3 {
        match self.normals.get(segment as usize) {
            Some(ends) => {
                let [from, to] = ends.map(Vec3::from);
                from + (to - from) * u
            }
            None => Vec3::ZERO,
        }
    }

    /// Bytes of its own.
    pub fn bytes(&self) -> usize {
        self.mesh.bytes() + size_of_val(&*self.normals)
    }
}

/// A place on a strand.
#[derive(Clone, Copy)]
pub(super) struct OnStrand {
    /// In the mesh's space.
    pub place: Vec3,
    /// Along the strand, and seen from within the other way round; world space, of any length; 0 of points.
    pub tangent: Vec3,
    /// The normal as if the strand was round, world space, unit length.
    pub normal: Vec3,
    /// The normal of what is there: towards the viewer, of flat strands.
    pub facing: Vec3,
    /// Sine of the angle across the strand, −1 to 1; 0 of what is round.
    pub across: f32,
    /// In the mesh's space, metres.
    radius: f32,
    /// Diameter, world space, metres.
    pub thickness: f32,
    /// In the middle of the strand, in the world, relative to the origin.
    pub middle: Vec3,
    /// Of the curve, in the world, of any length; 0 where there is none.
    of_curve: Vec3,
}

impl OnStrand {
    /// Where a ray meets one; `None` on triangles.
    pub fn of(at: &HitPoint) -> Option<Self> {
        let strands = at.mesh.strands.as_ref()?;
        Some(Self::on(at, strands))
    }

    /// Cycles' curve_shader_setup and point_shader_setup say the same of normals.
    #[cold]
    fn on(at: &HitPoint, data: &StrandData) -> Self {
        let (entry, u, v) = (at.entry, at.u, at.v);
        let strands = &*data.mesh;
        let keys = strands.keys_at(at.triangle, 0.0);
        let view = -at.asking.direction.normalize_or_zero();
        let direction = to_mesh(entry, at.asking.direction).normalize_or_zero();
        let (middle, along) = StrandMesh::on_curve(strands.kind(), keys, u);
        let radius = keys[1].w + (keys[2].w - keys[1].w) * u;
        let height = |squares: f32| (1.0 - squares).max(0.0).sqrt();
        let is_flat = matches!(strands.kind(), StrandShape::Ribbon(_));
        let (normal, place, tangent) = match strands.kind() {
            StrandShape::Points => {
                let [x, y] = StrandMesh::across_points(direction);
                let normal = x * u + y * v - direction * height(u * u + v * v);
                let center = keys[1].truncate();
                (normal, center + normal * keys[1].w, Vec3::ZERO)
            }
            _ => {
                let [across, _] = StrandMesh::across(along.truncate(), direction);
                let (v, lean) = StrandMesh::across_and_lean(v);
                let around = StrandMesh::around(along.truncate(), direction, v);
                let normal =
                    around * height(lean * lean) + along.truncate().normalize_or_zero() * lean;
                let beside = if is_flat { across * v } else { normal };
                let place = middle.truncate() + beside * middle.w;
                (normal, place, along.truncate())
            }
        };
        // Of a point that is stretched too: as Cycles has it, from the middle to the place.
        let normal = unit_or_zero(match strands.kind() {
            StrandShape::Points => entry.vector::<General>(normal),
            _ => entry.normal::<General>(normal),
        });
        let tangent = entry.vector::<General>(tangent);
        let is_within = !is_flat && normal.dot(view) < 0.0;
        let thickness = if entry.is_instance() {
            let third = radius * 2.0 / 3f32.sqrt();
            entry.vector::<General>(Vec3::splat(third)).length()
        } else {
            2.0 * radius
        };
        Self {
            place,
            // As Cycles turns its derivatives with the normal.
            tangent: if is_within { -tangent } else { tangent },
            normal: if normal == Vec3::ZERO { view } else { normal },
            facing: if is_flat { view } else { normal },
            across: if is_flat { v } else { 0.0 },
            radius,
            thickness,
            of_curve: from_blender(data.normal(at.triangle, u)),
            middle: {
                let error = Vec3::ZERO;
                let point = middle.truncate();
                let place = entry.transform();
                place.bounded_point(BoundedPoint { point, error }).point
            },
        }
    }

    /// The tangent as the Geometry node tells it: along a strand, and of a point one across its normal. Unit length, Blender's axes.
    pub fn blenders_tangent(&self) -> Vec3 {
        if self.tangent == Vec3::ZERO {
            across(to_blender(self.normal))[0]
        } else {
            to_blender(unit_or_zero(self.tangent))
        }
    }

    /// Where a ray from `origin` meets it after the way `along`.
    pub fn met(&self, origin: Vec3, along: Vec3) -> BoundedPoint {
        BoundedPoint {
            point: origin + along,
            // Of the point on the ray; no ray that leaves a strand needs more, as it does not meet it again.
            error: (origin.abs() + along.abs()) * gamma(3),
        }
    }
}

impl HitPoint<'_> {
    /// What shaders of hair ask about a place on a strand or a point. The strand's own number comes as an attribute.
    pub(super) fn strand_told(&self, on: &OnStrand) -> Strand {
        let seed = self.seed();
        if on.tangent == Vec3::ZERO {
            let [tangent, second] = across(on.normal);
            return Strand {
                tangent,
                second,
                seed,
                ..Strand::NONE
            };
        }
        let coverage = match self.asking.kind & RayKind::Camera.bit() {
            0 => 1.0,
            _ => 0.5 * self.pixel() / on.radius,
        };
        Strand {
            is_strand: true,
            tangent: unit_or_zero(on.tangent),
            second: Vec3::ZERO,
            across: on.across,
            normal: on.of_curve,
            radius: on.radius,
            coverage,
            seed,
            ..Strand::NONE
        }
    }

    /// What Hair Info and Point Info tell of a place: nothing of triangles, nor of the other kind.
    pub(super) fn strand_info(&self, input: PlaceInput, origin: Vec3) -> Vec4 {
        let Some(strand) = OnStrand::of(self) else {
            return Vec4::ZERO;
        };
        let of_point = matches!(input, PlaceInput::PointPosition | PlaceInput::PointRadius);
        if of_point != (strand.tangent == Vec3::ZERO) {
            return Vec4::ZERO;
        }
        match input {
            PlaceInput::IsStrand => Vec4::ONE,
            PlaceInput::StrandThickness => Vec4::splat(strand.thickness),
            PlaceInput::PointRadius => Vec4::splat(0.5 * strand.thickness),
            PlaceInput::PointPosition => to_blender(strand.middle + origin).extend(1.0),
            _ => {
                let view = -self.asking.direction;
                let across = view - view.project_onto(strand.tangent);
                to_blender(across.normalize_or_zero()).extend(1.0)
            }
        }
    }
}

/// A direction of the world in the space of an entry's mesh.
fn to_mesh(entry: &MeshInstance, direction: Vec3) -> Vec3 {
    if !entry.is_instance() {
        return direction;
    }
    let place = entry.transform();
    Mat3::from_cols(place.x, place.y, place.z).inverse() * direction
}

impl World {
    /// The strand that a ray from a hit leaves; `None` of triangles.
    #[inline]
    pub fn strand_of(&self, hit: &Hit) -> Option<LeftStrand> {
        if !self.geometry.has_strands {
            return None;
        }
        let object = hit.object();
        let entry = &self.geometry.entries[object as usize];
        let strands = self.geometry.meshes[entry.mesh as usize].strands.as_ref()?;
        let curve = strands.mesh.curve_of(hit.primitive);
        Some(LeftStrand { object, curve })
    }

    /// Whether a hit is on the strand that a ray leaves.
    #[inline]
    pub(super) fn is_left(&self, hit: &Hit, left: Option<LeftStrand>) -> bool {
        left.is_some_and(|left| left.object == hit.object() && self.strand_of(hit) == Some(left))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/world/strand.rs"]
mod tests;
