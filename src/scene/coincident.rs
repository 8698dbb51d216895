//! Faces that lie in one plane and on each other: two floors in one place, a rug that was never lifted, a lamp in its ceiling.
//!
//! Which of two such faces is above the other is not in the file. Cycles starts rays at the point itself and takes any hit at
//! distance 0 but that of the triangle it leaves: of two faces in a plane across an axis each lies on the other, and both are
//! black; of two that are turned, rounding decides, for about half of the rays (measured in 5.2.3: 0.35 to 0.76, most 0.5).
//! So it does across an axis where Cycles does not apply the transform to the mesh, but at 0 and at powers of two, which no
//! product rounds (0.48 to 1 of the light is left elsewhere).

mod grid;
mod seen;
mod turned;
mod twins;

use super::{Instance, Light, LightKind, Mesh, Scene, own_space};
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::cell::LazyCell;
use std::collections::BTreeMap;

/// What lies on a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlap {
    /// Nothing.
    #[default]
    None,
    /// Another one, in a plane across an axis: no ray leaves without meeting it.
    Flat,
    /// Another one where rounding decides, as in a plane that is turned: half of the rays meet it.
    Turned,
}

/// What coincides in a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coincident {
    /// What lies on each triangle, by the number of the instance; instances without any are not in it.
    pub faces: BTreeMap<u32, Vec<Overlap>>,
    /// Area lights in the plane of faces, by their numbers.
    pub lights: BTreeMap<u32, OnFaces>,
}

/// An area light and the faces that lie where it does.
#[derive(Clone, Debug, PartialEq)]
pub struct OnFaces {
    /// The plane of all of them.
    pub plane: Plane,
    /// The faces, by instance and triangle, with their corners in world space and f32.
    pub faces: BTreeMap<(u32, u32), [Vec3; 3]>,
}

/// Triangles, instances expanded, that are looked at. What a scene has beyond them is taken to lie alone: it would cost more
/// seconds than its rays.
const MOST_TRIANGLES: usize = 1 << 24;

/// Triangles and corners that a thread takes at once: fewer are not worth a second thread.
const AT_ONCE: usize = 4096;

/// What a transform may be off a turn by right angles: Blender's sine and cosine of one are f32.
const RIGHT_ANGLE: f64 = 1e-6;

/// Triangles overlap if they do by this share of the size of the smaller one, and by more than coordinates are rounded to: edges that meet
/// may cross by rounding.
const DEPTH: f64 = 1e-5;
/// What coordinates are rounded to, as a share of the largest: two points of an edge and what lies beside it, by an f32's half each.
const ROUNDED: f64 = 4.0 * f32::EPSILON as f64;

/// A plane across an axis, in world space and f32, as Cycles has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Plane {
    /// The axis that it is across.
    pub axis: usize,
    /// Bits of the coordinate along the axis.
    bits: u32,
}

impl Plane {
    /// The one through a point.
    fn through(p: Vec3, axis: usize) -> Self {
        Self {
            axis,
            bits: bits(p)[axis],
        }
    }

    /// Where it is on its axis.
    pub fn coordinate(self) -> f32 {
        f32::from_bits(self.bits)
    }

    /// Whether its coordinate is 0 or a power of two: its products with other numbers are not rounded.
    fn is_exact(self) -> bool {
        let fraction = (1 << (f32::MANTISSA_DIGITS - 1)) - 1;
        self.bits & fraction == 0
    }
}

/// A triangle in a plane across an axis, in world space and f32, as Cycles has it.
struct Flat {
    plane: Plane,
    corners: [Vec2; 3],
    instance: u32,
    triangle: u32,
}

impl Flat {
    fn bounds(&self) -> (Vec2, Vec2) {
        let [a, b, c] = self.corners;
        (a.min(b).min(c), a.max(b).max(c))
    }

    fn in_world(&self) -> [Vec3; 3] {
        let Plane { axis, .. } = self.plane;
        self.corners.map(|p| {
            let mut corner = Vec3::ZERO;
            corner[axis] = self.plane.coordinate();
            // As `without` leaves it out.
            corner[(axis + 1) % 3] = p.x;
            corner[(axis + 2) % 3] = p.y;
            corner
        })
    }
}

/// Looks for what coincides, in files that come from Blender.
pub fn find(scene: &Scene) -> Coincident {
    let mut found = Coincident::default();
    if !scene.is_from_blender() {
        return found;
    }
    let (flats, (twins, turned)) = rayon::join(
        || {
            let mut flats = flats(scene);
            // Stable: faces of one plane mostly stand together already.
            flats.sort_by_key(|flat| flat.plane);
            flats
        },
        || rayon::join(|| twins::find(scene), || turned::find(scene)),
    );
    // Most scenes have no such faces.
    let instanced = LazyCell::new(|| own_space::stays(scene));
    for group in flats.chunk_by(|a, b| a.plane == b.plane) {
        for number in overlapping(group, |_, _| true) {
            let flat = &group[number];
            let rounds = instanced[flat.instance as usize] && !flat.plane.is_exact();
            let overlap = if rounds {
                Overlap::Turned
            } else {
                Overlap::Flat
            };
            found.mark(scene, flat, overlap);
        }
    }
    for (instance, triangle) in twins.into_iter().chain(turned) {
        found.turned(scene, instance, triangle);
    }
    let lights = (0..).zip(&scene.lights);
    let on_faces = lights.filter_map(|(number, light)| Some((number, faces_under(light, &flats)?)));
    found.lights = on_faces.collect();
    found
}

impl Coincident {
    /// Whether nothing does.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.lights.is_empty()
    }

    fn overlap<'a>(&'a mut self, scene: &Scene, instance: u32, triangle: u32) -> &'a mut Overlap {
        let of = self.faces.entry(instance).or_insert_with(|| {
            let mesh = mesh_of(scene, &scene.instances[instance as usize]);
            vec![Overlap::None; mesh.triangles.len()]
        });
        &mut of[triangle as usize]
    }

    fn mark(&mut self, scene: &Scene, flat: &Flat, overlap: Overlap) {
        *self.overlap(scene, flat.instance, flat.triangle) = overlap;
    }

    /// What is flat stays flat.
    fn turned(&mut self, scene: &Scene, instance: u32, triangle: u32) {
        let overlap = self.overlap(scene, instance, triangle);
        if *overlap == Overlap::None {
            *overlap = Overlap::Turned;
        }
    }
}

fn mesh_of<'a>(scene: &'a Scene, instance: &Instance) -> &'a Mesh {
    &scene.meshes[instance.mesh.0 as usize]
}

/// What moves lies on nothing for long, and strands have no faces.
fn lies_on_nothing(scene: &Scene, instance: &Instance) -> bool {
    let mesh = mesh_of(scene, instance);
    !instance.motion.is_empty() || !mesh.motion.is_empty() || mesh.has_strands()
}

/// Which axes of the world are along an axis of what is transformed: coordinates along them hang on one coordinate alone, however it is
/// turned about them.
fn kept_axes(transform: &DAffine3) -> [bool; 3] {
    let rows = transform.matrix3.transpose();
    [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| {
        let size = row.abs();
        let others = size.element_sum() - size.max_element();
        others <= RIGHT_ANGLE * size.max_element()
    })
}

fn placed(transform: &DAffine3, p: [f32; 3]) -> Vec3 {
    let [x, y, z] = p.map(f64::from);
    transform.transform_point3(DVec3::new(x, y, z)).as_vec3()
}

fn corners(mesh: &Mesh, triangle: u32) -> [[f32; 3]; 3] {
    mesh.triangles[triangle as usize].map(|corner| mesh.positions[corner as usize])
}

/// Triangles of a mesh that lie across an axis, in its own space.
fn across_axes(mesh: &Mesh) -> Vec<u32> {
    let lies = |&triangle: &u32| {
        let [a, b, c] = corners(mesh, triangle);
        (0..3).any(|axis| a[axis] == b[axis] && a[axis] == c[axis])
    };
    (0..mesh.triangles.len() as u32).filter(lies).collect()
}

/// All triangles across an axis, that have an area.
fn flats(scene: &Scene) -> Vec<Flat> {
    let mut of_mesh: Vec<Option<Vec<u32>>> = vec![None; scene.meshes.len()];
    let mut flats = Vec::new();
    for (number, instance) in scene.instances.iter().enumerate() {
        let place = &instance.world_from_object;
        let kept = kept_axes(place);
        if kept == [false; 3] || lies_on_nothing(scene, instance) {
            continue;
        }
        let mesh = mesh_of(scene, instance);
        let slot = &mut of_mesh[instance.mesh.0 as usize];
        for &triangle in slot.get_or_insert_with(|| across_axes(mesh)).iter() {
            let [a, b, c] = corners(mesh, triangle).map(|p| placed(place, p));
            let is_level = |axis: usize| a[axis] == b[axis] && a[axis] == c[axis];
            let Some(axis) = (0..3).find(|&axis| kept[axis] && is_level(axis)) else {
                continue;
            };
            let flat = Flat {
                plane: Plane::through(a, axis),
                corners: [a, b, c].map(|p| without(p, axis)),
                instance: number as u32,
                triangle,
            };
            if area(flat.corners.map(Vec2::as_dvec2)) != 0.0 {
                flats.push(flat);
            }
        }
        if flats.len() > MOST_TRIANGLES {
            break;
        }
    }
    flats
}

fn without(p: Vec3, axis: usize) -> Vec2 {
    match axis {
        0 => Vec2::new(p.y, p.z),
        1 => Vec2::new(p.z, p.x),
        _ => Vec2::new(p.x, p.y),
    }
}

/// Twice the area, with the sign of the winding.
fn area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether the insides of two triangles meet: no edge of either parts them (the theorem of separating axes).
fn meet(a: &Flat, b: &Flat) -> bool {
    let [a, b] = [a, b].map(|flat| flat.corners.map(Vec2::as_dvec2));
    let longest = |of: &[DVec2; 3]| {
        let edges = (0..3).map(|i| of[i].distance(of[(i + 1) % 3]));
        edges.fold(0.0, f64::max)
    };
    let corners = a.iter().chain(&b);
    let farthest = corners.map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let depth = (DEPTH * longest(&a).min(longest(&b))).max(ROUNDED * farthest);
    let parts = |one: &[DVec2; 3], other: &[DVec2; 3]| {
        let winding = area(*one).signum();
        (0..3).any(|i| {
            let (from, to) = (one[i], one[(i + 1) % 3]);
            let edge = (to - from) * winding;
            let least = depth * edge.length();
            other.iter().all(|&p| edge.perp_dot(p - from) <= least)
        })
    };
    !parts(&a, &b) && !parts(&b, &a)
}

/// So few triangles are compared in pairs: no tree of boxes is made as fast.
const FEW: usize = 16;

/// So many comparisons are exact; after them boxes decide.
const MOST_COMPARISONS: usize = 20_000_000;

/// A box of [`rstar`] without its edges: those of neighbours are no overlap.
fn inner_box((low, high): (Vec2, Vec2)) -> AABB<[f32; 2]> {
    let low = low.to_array().map(f32::next_up);
    AABB::from_corners(low, high.to_array().map(f32::next_down))
}

/// Numbers of those triangles of one plane that another overlaps; `may` says of two by their numbers whether they could.
fn overlapping(group: &[Flat], may: impl Fn(usize, usize) -> bool + Sync) -> Vec<usize> {
    if group.len() <= FEW {
        return overlapping_few(group, may);
    }
    grid::overlapping(group, &may).unwrap_or_else(|| overlapping_in_tree(group, may))
}

/// The same by a tree of boxes: triangles may stand in a few crowded places of a wide plane, where a grid compares all with all.
fn overlapping_in_tree(group: &[Flat], may: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let boxed = |(number, flat): (usize, &Flat)| {
        let (low, high) = flat.bounds();
        GeomWithData::new(Rectangle::from_corners(low.into(), high.into()), number)
    };
    let tree = RTree::bulk_load(group.iter().enumerate().map(boxed).collect());
    let mut found = vec![false; group.len()];
    let mut left = MOST_COMPARISONS;
    for number in 0..group.len() {
        // Each looks for one that it overlaps: what else overlaps that one finds it by itself.
        if found[number] {
            continue;
        }
        let bounds = group[number].bounds();
        let mut near = tree.locate_in_envelope_intersecting(&inner_box(bounds));
        let other = near.find(|other| {
            if other.data == number || !overlap(bounds, group[other.data].bounds()) {
                return false;
            }
            left = left.saturating_sub(1);
            may(number, other.data) && (left == 0 || meet(&group[number], &group[other.data]))
        });
        if let Some(other) = other {
            (found[number], found[other.data]) = (true, true);
        }
    }
    (0..group.len()).filter(|&number| found[number]).collect()
}

/// The same by comparing all with all.
fn overlapping_few(group: &[Flat], may: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let mut found = [false; FEW];
    for (number, one) in group.iter().enumerate() {
        for (before, other) in group[..number].iter().enumerate() {
            let known = found[number] && found[before];
            if !known
                && overlap(one.bounds(), other.bounds())
                && may(number, before)
                && meet(one, other)
            {
                (found[number], found[before]) = (true, true);
            }
        }
    }
    (0..group.len()).filter(|&number| found[number]).collect()
}

fn bits(p: Vec3) -> [u32; 3] {
    // The two zeros are one place.
    p.to_array().map(|value| (value + 0.0).to_bits())
}

/// The plane across an axis in which an area light lies, and its box there.
fn plane_of(light: &Light) -> Option<(Plane, (Vec2, Vec2))> {
    let LightKind::Area { size, .. } = light.kind else {
        return None;
    };
    let place = &light.world_from_light;
    if kept_axes(place) != [true; 3] {
        return None;
    }
    let [x, y] = size.map(|extent| 0.5 * extent);
    let ends = [[-x, -y, 0.0], [x, y, 0.0]].map(|p| placed(place, p));
    let axis = (0..3).find(|&axis| ends[0][axis] == ends[1][axis])?;
    let [a, b] = ends.map(|p| without(p, axis));
    Some((Plane::through(ends[0], axis), (a.min(b), a.max(b))))
}

/// Whether two boxes have more than an edge in common.
fn overlap(a: (Vec2, Vec2), b: (Vec2, Vec2)) -> bool {
    a.0.cmplt(b.1).all() && b.0.cmplt(a.1).all()
}

/// The faces that lie in the plane of an area light and where it is, by their boxes; `None` without any. `flats` are in the order
/// of their planes.
fn faces_under(light: &Light, flats: &[Flat]) -> Option<OnFaces> {
    let (plane, bounds) = plane_of(light)?;
    let first = flats.partition_point(|flat| flat.plane < plane);
    let in_plane = flats[first..].iter().take_while(|flat| flat.plane == plane);
    let under = in_plane.filter(|flat| overlap(bounds, flat.bounds()));
    let faces: BTreeMap<_, _> = under
        .map(|flat| ((flat.instance, flat.triangle), flat.in_world()))
        .collect();
    (!faces.is_empty()).then_some(OnFaces { plane, faces })
}

#[cfg(test)]
#[path = "../../tests/unit/scene/coincident.rs"]
mod tests;
