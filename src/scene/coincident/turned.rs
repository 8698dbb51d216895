//! Faces that overlap in a plane that is turned, with corners of their own: a cushion pushed into a sofa of the same slope.

use super::seen::{Seen, mixed};
use super::{AT_ONCE, Flat, Plane, corners, lies_on_nothing, mesh_of, overlapping, placed};
use crate::math::float;
use crate::scene::{Instance, Scene};
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

/// Triangles of a scene among which such faces are looked for, those of the smallest meshes: a million takes about a fifth of a second.
const MOST_TRIANGLES: usize = 1 << 20;

/// Cells of a normal's components, and of the scene's extent along it. Faces in one plane are in one cell but for
/// roundings, which are about a thousandth of a cell: so many pairs are missed.
const NORMAL_CELLS: f64 = 1024.0;
const DISTANCE_CELLS: f64 = 8192.0;

/// Borders of cells lie off the round numbers that models are built of.
const OFF_ROUND: f64 = 0.381_966;

/// Neither in a plane that modelled normals lie in: of a plane's two normals the one on its side is taken.
const ASIDE: DVec3 = DVec3::new(0.594_603, 0.353_553, 0.722_096);

/// A face, and the cell of its plane.
struct Face {
    cell: u64,
    instance: u32,
    triangle: u32,
}

/// The plane of a face in world space.
struct Placed {
    instance: u32,
    triangle: u32,
    normal: DVec3,
    /// From the origin.
    distance: f64,
    /// The largest coordinate of a corner.
    size: f64,
}

/// Triangles that overlap another in their plane, whichever way it lies.
pub(super) fn find(scene: &Scene) -> Vec<(u32, u32)> {
    let mut faces = faces(scene, &looked_at(scene));
    faces.par_sort_unstable_by_key(|face| (face.cell, face.instance, face.triangle));
    let cells: Vec<&[Face]> = faces
        .chunk_by(|a, b| a.cell == b.cell)
        .filter(|cell| cell.len() > 1)
        .collect();
    cells
        .par_iter()
        .flat_map_iter(|cell| overlaps(scene, cell))
        .collect()
}

/// Instances whose faces are looked at, without the largest where all are too many: a landscape of millions does not hide that a figure on it
/// stands twice.
fn looked_at(scene: &Scene) -> Vec<(u32, &Instance)> {
    let mut still: Vec<(u32, &Instance)> = (0..)
        .zip(&scene.instances)
        .filter(|(_, instance)| !lies_on_nothing(scene, instance))
        .collect();
    let count = |(_, instance): &(u32, &Instance)| mesh_of(scene, instance).triangles.len();
    if still.iter().map(count).sum::<usize>() > MOST_TRIANGLES {
        still.sort_by_key(count);
        let mut sum = 0;
        still.retain(|each| {
            sum += count(each);
            sum <= MOST_TRIANGLES
        });
    }
    still
}

/// Faces, but for those that are seen to be alone in their cell: of what is curved, nearly all.
fn faces(scene: &Scene, looked_at: &[(u32, &Instance)]) -> Vec<Face> {
    let planes: Vec<Placed> = looked_at
        .par_iter()
        .flat_map(|&(number, instance)| planes(scene, number, instance))
        .collect();
    let extent = planes.par_iter().map(|plane| plane.size);
    let extent = extent.reduce(|| 0.0, f64::max);
    let face = |plane: &Placed| {
        let cell = |value: f64, cells: f64| ((value + 2.0) * cells + OFF_ROUND) as u64;
        let share = if extent > 0.0 {
            plane.distance / extent
        } else {
            0.0
        };
        // No share is above √3, and no cell above 2¹⁵.
        let cell = plane
            .normal
            .to_array()
            .into_iter()
            .fold(cell(share, DISTANCE_CELLS), |sum, component| {
                sum << 15 | cell(component, NORMAL_CELLS)
            });
        Face {
            cell,
            instance: plane.instance,
            triangle: plane.triangle,
        }
    };
    let mut faces: Vec<Face> = planes.par_iter().map(face).collect();
    let seen = Seen::new(faces.len());
    faces.par_iter().for_each(|face| seen.add(mixed(face.cell)));
    faces.retain(|face| seen.was_twice(mixed(face.cell)));
    faces
}

/// The planes of an instance's triangles that have one.
fn planes(scene: &Scene, number: u32, instance: &Instance) -> Vec<Placed> {
    let mesh = mesh_of(scene, instance);
    let place = |p: &[f32; 3]| placed(&instance.world_from_object, *p);
    let positions = mesh.positions.par_iter().with_min_len(AT_ONCE);
    let places: Vec<Vec3> = positions.map(place).collect();
    let plane = |(triangle, of): (usize, &[u32; 3])| {
        let [a, b, c] = of.map(|corner| places[corner as usize].as_dvec3());
        let normal = (b - a).cross(c - a).try_normalize()?;
        let normal = normal * 1f64.copysign(normal.dot(ASIDE));
        Some(Placed {
            instance: number,
            triangle: triangle as u32,
            normal,
            distance: normal.dot(a),
            size: a.abs().max_element(),
        })
    };
    let triangles = mesh.triangles.par_iter().with_min_len(AT_ONCE);
    triangles.enumerate().filter_map(plane).collect()
}

/// Those of a cell that overlap.
fn overlaps(scene: &Scene, group: &[Face]) -> Vec<(u32, u32)> {
    let world: Vec<[DVec3; 3]> = group
        .iter()
        .map(|face| {
            let instance = &scene.instances[face.instance as usize];
            corners(mesh_of(scene, instance), face.triangle)
                .map(|p| placed(&instance.world_from_object, p).as_dvec3())
        })
        .collect();
    let normals: Vec<DVec3> = world
        .iter()
        .map(|[a, b, c]| (b - a).cross(c - a).normalize())
        .collect();
    let (across, along) = normals[0].any_orthonormal_pair();
    let flats: Vec<Flat> = group
        .iter()
        .zip(&world)
        .map(|(face, corners)| Flat {
            plane: Plane::through(Vec3::ZERO, 0),
            corners: corners.map(|p| DVec2::new(p.dot(across), p.dot(along)).as_vec2()),
            instance: face.instance,
            triangle: face.triangle,
        })
        .collect();
    let lies_on = |face: usize, other: usize| {
        let (normal, at) = (normals[other], world[other][0]);
        world[face]
            .iter()
            .all(|p| (p - at).dot(normal).abs() <= rounding(normal, at.abs().max(p.abs())))
    };
    overlapping(&flats, |a, b| lies_on(a, b) && lies_on(b, a))
        .into_iter()
        .map(|number| (group[number].instance, group[number].triangle))
        .collect()
}

/// How far two points of one plane may be off it: each coordinate of both is rounded once where it is written and once where it
/// is placed. Along the plane that counts for nothing: a floor ten metres wide is not ten times as thick.
fn rounding(normal: DVec3, size: DVec3) -> f64 {
    4.0 * f64::from(float::UNIT_ROUNDOFF) * normal.abs().dot(size)
}
