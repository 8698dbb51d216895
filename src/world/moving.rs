//! Surfaces that move, as they are at the time of a ray.
//!
//! The triangle that a ray meets is taken out of its mesh as it is at that time, with all that its corners carry, and so is the
//! placement of its object: shading, programs, light sampling and error bounds then know of no time.

use super::World;
use super::geometry::{MeshData, MeshInstance};
use super::turned::{placed_normals, placed_points};
use crate::effects::Features;
use crate::ffi::embree::{CommittedScene, DecomposedTransform, EmbreeError, Hit, TriangleMesh};
use crate::math::float::{UNIT_ROUNDOFF, gamma};
use crate::math::motion::{self, Decomposed};
use crate::scene::{Mesh, MeshStep};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::sync::Arc;

/// An object with one triangle of its mesh at one time.
pub struct Moment {
    entry: MeshInstance,
    mesh: Option<MeshData>,
}

/// What interpolation in time adds to the errors of points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slack {
    /// Of the corners, in the mesh's space.
    pub corners: Vec3,
    /// Of the placement's axes, as a share of their lengths.
    pub axes: f32,
    /// Of the placement's origin.
    pub origin: Vec3,
}

/// Roundings between the steps of a placement and its axes at a time, in Embree's kernels and in what it tells of them, which
/// may be compiled in other ways. The cosine of the angle between two quaternions is within 4 u. Rotations of less than 3.6°
/// between steps (cosine 0.9995) are interpolated linearly; above that the sine is at least 0.0316, so that the angle is within
/// 127 u. The axes turn by twice the quaternion's angle: 254 u. Sine, cosine, and the quaternion between are 40 roundings more,
/// which the products of the matrix double twice. 254 + 160 + those of the matrix and of the scale: below 512 for both.
const TURNING: u32 = 512;

impl MeshInstance {
    /// Where the corners of a triangle are in the world at a time.
    pub fn corners_at(
        &self,
        mesh: &MeshData,
        scene: &CommittedScene,
        (triangle, time): (u32, f32),
    ) -> [Vec3; 3] {
        let moment = self.at_time(mesh, scene, (triangle, time));
        let (entry, mesh, triangle) = moment.of(mesh, triangle);
        entry.world_corners(mesh, triangle)
    }

    /// As it is at a time, with a triangle of its mesh.
    #[cold]
    #[inline(never)]
    pub fn at_time(
        &self,
        mesh: &MeshData,
        scene: &CommittedScene,
        (triangle, time): (u32, f32),
    ) -> Box<Moment> {
        let mut slack = Slack::default();
        let posed = mesh.triangles.moves().then(|| {
            let (posed, error) = mesh.at_time(triangle, time);
            slack.corners = error;
            posed
        });
        let mut entry = match self.path() {
            None => self.clone(),
            Some(path) => {
                let columns = scene.transform_at(path.number, time);
                let [x, y, z, origin] = columns.map(|c| Vec3::from(c).as_dvec3());
                let place = DAffine3 {
                    matrix3: DMat3::from_cols(x, y, z),
                    translation: origin,
                };
                slack.axes = gamma(TURNING);
                // As in lerp: two products and a sum of what may cancel, twice.
                slack.origin = path.farthest * gamma(6);
                let facts = self
                    .facts
                    .as_ref()
                    .map(|facts| Arc::new(facts.moved(&place)));
                let mut moved = Self::instance(self.mesh, &place, self.visibility);
                moved.object = self.object;
                moved.with_facts(facts)
            }
        };
        entry.slack = slack;
        entry.moves = true;
        Box::new(Moment { entry, mesh: posed })
    }
}

impl Moment {
    /// The object, its mesh, and the number of the triangle in that.
    pub fn of<'a>(
        &'a self,
        mesh: &'a MeshData,
        triangle: u32,
    ) -> (&'a MeshInstance, &'a MeshData, u32) {
        match &self.mesh {
            Some(posed) => (&self.entry, posed, 0),
            None => (&self.entry, mesh, triangle),
        }
    }
}

/// The way of an object through the steps of its motion.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Embree's number of it.
    number: u32,
    /// The largest coordinates of its origin.
    farthest: Vec3,
}

impl Path {
    /// Of transforms relative to the origin of the world, and what Embree is to interpolate.
    pub fn new(steps: &[DAffine3], number: u32) -> (Self, Vec<DecomposedTransform>) {
        let farthest = steps
            .iter()
            .fold(DVec3::ZERO, |most, step| most.max(step.translation.abs()));
        let path = Self {
            number,
            farthest: farthest.as_vec3(),
        };
        let parts = motion::decompose(steps);
        (path, parts.iter().map(for_embree).collect())
    }
}

fn for_embree(part: &Decomposed) -> DecomposedTransform {
    let q = part.rotation.as_quat();
    DecomposedTransform {
        rotation: [q.w, q.x, q.y, q.z],
        scale: part.scale.as_vec3().to_array(),
        skew: part.skew.as_vec3().to_array(),
        translation: part.translation.as_vec3().to_array(),
    }
}

impl MeshData {
    /// A triangle as it is at a time, with a bound on the error of its corners.
    ///
    /// Embree computes them anew. It and this round the share of the way from one step to the next by up to four units of the
    /// number of steps, and the mean of two places by three roundings each.
    fn at_time(&self, triangle: u32, time: f32) -> (Self, Vec3) {
        let corners = self.triangles.triangles()[triangle as usize];
        let steps = self.triangles.steps();
        let (step, share) = motion::step(time, steps);
        let mut error = Vec3::ZERO;
        let places = corners.map(|corner| {
            let [a, b] = [step, step + 1].map(|s| Vec3::from(self.triangles.vertex_at(s, corner)));
            let way = (b - a).abs() * (4.0 * steps as f32 * UNIT_ROUNDOFF);
            error = error.max(way + (a.abs() + b.abs()) * gamma(6));
            (a * (1.0 - share) + b * share).to_array()
        });
        let pick3 = |values: &[[f32; 3]]| corners.map(|i| values[i as usize]).to_vec();
        let pick4 = |values: &[[f32; 4]]| corners.map(|i| values[i as usize]).to_vec();
        let normals = match self.moving_normals.get(step..step + 2) {
            Some([before, after]) => Some(
                corners
                    .map(|i| {
                        let [a, b] = [before, after].map(|n| Vec3::from(n[i as usize]));
                        (a * (1.0 - share) + b * share)
                            .normalize_or_zero()
                            .to_array()
                    })
                    .to_vec(),
            ),
            _ => self.normals.as_deref().map(pick3),
        };
        let posed = Self {
            triangles: Arc::new(TriangleMesh::single(places)),
            normals,
            is_shaded_smooth: self.is_shaded_smooth,
            moving_normals: Vec::new(),
            tangents: self.tangents.as_deref().map(pick4),
            radial: self.radial.as_deref().map(pick3),
            generated: self.generated.as_deref().map(pick3),
            uvs: self
                .uvs
                .iter()
                .map(|set| corners.map(|i| set[i as usize]).to_vec())
                .collect(),
            colors: self.colors.as_deref().map(pick4),
            attributes: self.attributes.iter().map(|set| pick4(set)).collect(),
            strands: self
                .strands
                .as_ref()
                .map(|strands| strands.at_time(triangle, time)),
            material: self.material,
        };
        (posed, error)
    }
}

/// Positions at steps of time, and normals, of a mesh that is placed by a transform or not at all.
pub fn steps(mesh: &Mesh, transform: Option<&DAffine3>) -> Vec<MeshStep> {
    let place = |step: &MeshStep| match transform {
        None => step.clone(),
        Some(t) => MeshStep {
            positions: placed_points(t, &step.positions),
            normals: step.normals.as_ref().map(|n| placed_normals(t, n)),
        },
    };
    mesh.motion.iter().map(place).collect()
}

/// Steps of a mesh as its mesh in the world has them.
pub fn triangles(
    mesh: TriangleMesh,
    steps: Vec<Vec<[f32; 3]>>,
) -> Result<TriangleMesh, EmbreeError> {
    if steps.is_empty() {
        return Ok(mesh);
    }
    mesh.moving(steps)
}

impl World {
    /// The object of a hit, its mesh, and the number of the triangle in that: as they are at the time of the hit, in `moment`
    /// where they move.
    #[inline(always)]
    pub(super) fn object_at<'a, E: Features>(
        &'a self,
        hit: &Hit,
        moment: &'a mut Option<Box<Moment>>,
    ) -> (&'a MeshInstance, &'a MeshData, u32) {
        let index = if E::CURVED {
            hit.object()
        } else {
            hit.geometry
        };
        let entry = &self.geometry.entries[index as usize];
        let mesh = &*self.geometry.meshes[entry.mesh as usize];
        if !E::EVERYTHING || !entry.moves {
            return (entry, mesh, hit.primitive);
        }
        let place = (hit.primitive, hit.time);
        let posed = entry.at_time(mesh, &self.geometry.embree, place);
        moment.insert(posed).of(mesh, hit.primitive)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/world/moving.rs"]
mod tests;
