//! Subdivision surfaces by Catmull and Clark ("Recursively generated B-spline surfaces on arbitrary topological meshes", 1978),
//! with the creases of DeRose, Kass and Truong ("Subdivision surfaces in character animation", 1998).

use std::collections::HashMap;

use glam::DVec3;

use super::polygons::{Corner, Interpolation, Layer, Polygons};
use super::source::View;
use super::subdivide_loop;

/// A surface is divided until it has so many faces, but not more often than [`MOST_LEVELS`] times.
const ENOUGH_FACES: usize = 50_000;
const MOST_LEVELS: u32 = 4;
/// No more than so many faces, whatever the cage has.
const MOST_FACES: usize = 8_000_000;

/// What a mesh says of its creases and borders.
#[derive(Clone, Debug, Default)]
pub(super) struct Wishes {
    /// Sharpness of edges.
    edges: HashMap<(u32, u32), f64>,
    /// Sharpness of points.
    points: HashMap<u32, f64>,
    /// Points at the border with one face stay where they are.
    corners_stay: bool,
    /// Triangles are divided by Loop's scheme.
    triangles: bool,
}

impl Wishes {
    pub(super) fn of(prim: &View) -> Self {
        let mut wishes = Self {
            corners_stay: prim
                .word("interpolateBoundary")
                .is_none_or(|w| w == "edgeAndCorner"),
            triangles: prim.word("subdivisionScheme").as_deref() == Some("loop"),
            ..Self::default()
        };
        let indices = prim.integers("creaseIndices").unwrap_or_default();
        let lengths = prim.integers("creaseLengths").unwrap_or_default();
        let sharpness = numbers(prim, "creaseSharpnesses");
        let mut rest = indices.as_slice();
        let (mut edge, per_edge) = (0, sharpness.len() != lengths.len());
        for (crease, length) in lengths.iter().enumerate() {
            let length = usize::try_from(*length).unwrap_or(0).min(rest.len());
            let (chain, others) = rest.split_at(length);
            rest = others;
            for pair in chain.windows(2) {
                let at = if per_edge { edge } else { crease };
                edge += 1;
                if let ([a, b], Some(s)) = (pair, sharpness.get(at))
                    && let (Ok(a), Ok(b)) = (u32::try_from(*a), u32::try_from(*b))
                {
                    wishes.edges.insert(key(a, b), *s);
                }
            }
        }
        let corners = prim.integers("cornerIndices").unwrap_or_default();
        for (corner, s) in corners.iter().zip(numbers(prim, "cornerSharpnesses")) {
            if let Ok(corner) = u32::try_from(*corner) {
                wishes.points.insert(corner, s);
            }
        }
        wishes
    }

    /// What is left of them after a step.
    fn softer(&mut self) {
        self.points
            .values_mut()
            .for_each(|s| *s = (*s - 1.0).max(0.0));
    }
}

fn numbers(prim: &View, name: &str) -> Vec<f64> {
    let value = prim.value(name).as_ref().and_then(super::value::floats);
    let (_, values) = value.unwrap_or_default();
    values.into_iter().map(f64::from).collect()
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// How often some polygons are divided.
fn levels(polygons: &Polygons) -> u32 {
    let first = polygons.corners.len().max(1);
    let after = |levels: u32| first.saturating_mul(4usize.saturating_pow(levels - 1));
    let mut levels = 1;
    while levels < MOST_LEVELS && after(levels + 1) <= ENOUGH_FACES {
        levels += 1;
    }
    if after(levels) > MOST_FACES {
        0
    } else {
        levels
    }
}

/// Corners that there will be.
pub(super) fn corners_after(polygons: &Polygons) -> u64 {
    let levels = levels(polygons);
    (polygons.corners.len() as u64).saturating_mul(4u64.saturating_pow(levels))
}

/// Divides polygons and the numbers of the parts that their faces belong to. Returns how often.
pub(super) fn apply(polygons: &mut Polygons, parts: &mut Vec<usize>, wishes: &Wishes) -> u32 {
    let levels = levels(polygons);
    let mut wishes = wishes.clone();
    for _ in 0..levels {
        if wishes.triangles {
            subdivide_loop::divide(polygons, parts, &mut wishes);
        } else {
            divide(polygons, parts, &mut wishes);
        }
    }
    if wishes.triangles {
        subdivide_loop::to_limit(polygons, &wishes);
    } else {
        to_limit(polygons, &wishes);
    }
    polygons.smooth = true;
    polygons.subdivides = false;
    levels
}

/// An edge and the faces on both sides.
#[derive(Clone, Debug, Default)]
pub(super) struct Edge {
    pub faces: Vec<u32>,
    pub sharpness: f64,
    /// The number of its new point.
    pub number: u32,
}

/// Edges and faces about the points of a mesh.
pub(super) struct Topology {
    edges: HashMap<(u32, u32), Edge>,
    /// Edges in the order in which they were met.
    pub order: Vec<(u32, u32)>,
    /// Points at the other ends of edges.
    pub neighbours: Vec<Vec<u32>>,
    /// Faces about each point.
    faces: Vec<Vec<u32>>,
    /// Middle of each face.
    middles: Vec<DVec3>,
}

pub(super) fn topology(polygons: &Polygons, points: &[DVec3], wishes: &Wishes) -> Topology {
    let mut all = Topology {
        edges: HashMap::new(),
        order: Vec::new(),
        neighbours: vec![Vec::new(); points.len()],
        faces: vec![Vec::new(); points.len()],
        middles: Vec::new(),
    };
    for (face, start) in polygons.starts().into_iter().enumerate() {
        let ring = &polygons.corners[start..start + polygons.counts[face]];
        let sum: DVec3 = ring.iter().map(|p| points[*p as usize]).sum();
        all.middles.push(sum / ring.len().max(1) as f64);
        for (at, a) in ring.iter().enumerate() {
            let b = ring[(at + 1) % ring.len()];
            all.faces[*a as usize].push(face as u32);
            let key = key(*a, b);
            let next = all.order.len() as u32;
            let edge = all.edges.entry(key).or_insert_with(|| {
                all.order.push(key);
                all.neighbours[*a as usize].push(b);
                all.neighbours[b as usize].push(*a);
                Edge {
                    faces: Vec::new(),
                    sharpness: wishes.edges.get(&key).copied().unwrap_or(0.0),
                    number: next,
                }
            });
            edge.faces.push(face as u32);
        }
    }
    for edge in all.edges.values_mut() {
        if edge.faces.len() != 2 {
            edge.sharpness = f64::INFINITY;
        }
    }
    all
}

impl Topology {
    pub(super) fn edge(&self, a: u32, b: u32) -> Option<&Edge> {
        self.edges.get(&key(a, b))
    }

    /// The neighbours along sharp edges, and the mean sharpness of these.
    fn sharp(&self, point: u32) -> (Vec<u32>, f64) {
        let around = self.neighbours[point as usize].iter();
        let sharp: Vec<(u32, f64)> = around
            .filter_map(|other| Some((*other, self.edge(point, *other)?.sharpness)))
            .filter(|(_, sharpness)| *sharpness > 0.0)
            .collect();
        let mean = sharp.iter().map(|(_, s)| s.min(100.0)).sum::<f64>();
        let mean = mean / sharp.len().max(1) as f64;
        (sharp.into_iter().map(|(other, _)| other).collect(), mean)
    }

    /// Where an edge's point goes.
    fn edge_point(&self, (a, b): (u32, u32), edge: &Edge, points: &[DVec3]) -> DVec3 {
        let (pa, pb) = (points[a as usize], points[b as usize]);
        let straight = 0.5 * (pa + pb);
        if edge.sharpness >= 1.0 {
            return straight;
        }
        let sides: DVec3 = edge.faces.iter().map(|f| self.middles[*f as usize]).sum();
        let smooth = 0.25 * (pa + pb + sides);
        smooth.lerp(straight, edge.sharpness)
    }

    /// Where a point goes.
    fn vertex_point(&self, point: u32, points: &[DVec3], wishes: &Wishes) -> DVec3 {
        let here = points[point as usize];
        let faces = &self.faces[point as usize];
        if faces.is_empty() {
            return here;
        }
        let n = self.neighbours[point as usize].len() as f64;
        let middles: DVec3 = faces.iter().map(|f| self.middles[*f as usize]).sum();
        let around = self.neighbours[point as usize].iter();
        let ends: DVec3 = around.map(|p| points[*p as usize]).sum();
        let smooth = (middles / faces.len() as f64 + ends / n + (n - 2.0) * here) / n;
        self.ruled(point, smooth, points, wishes)
    }

    /// Where a point goes that would go to `smooth` if nothing about it were sharp.
    pub(super) fn ruled(
        &self,
        point: u32,
        smooth: DVec3,
        points: &[DVec3],
        wishes: &Wishes,
    ) -> DVec3 {
        let here = points[point as usize];
        let faces = &self.faces[point as usize];
        let (sharp, sharpness) = self.sharp(point);
        let own = wishes.points.get(&point).copied().unwrap_or(0.0);
        let border_corner = wishes.corners_stay && faces.len() == 1;
        let (rule, weight) = match sharp.as_slice() {
            _ if own > 0.0 => (here, own),
            _ if border_corner => (here, 1.0),
            [a, b] => {
                let ends = points[*a as usize] + points[*b as usize];
                (0.75 * here + 0.125 * ends, sharpness)
            }
            [] | [_] => (smooth, 0.0),
            _ => (here, sharpness),
        };
        smooth.lerp(rule, weight.min(1.0))
    }

    /// Where endless steps bring a point that does not move or is on a crease; `None` for one that is smooth.
    pub(super) fn limit_by_creases(
        &self,
        point: u32,
        points: &[DVec3],
        wishes: &Wishes,
    ) -> Option<DVec3> {
        let here = points[point as usize];
        let faces = &self.faces[point as usize];
        let (sharp, _) = self.sharp(point);
        if faces.is_empty() || wishes.points.get(&point).is_some_and(|s| *s > 0.0) {
            return Some(here);
        }
        match sharp.as_slice() {
            [] => None,
            [a, b] if !(wishes.corners_stay && faces.len() == 1) => {
                Some((4.0 * here + points[*a as usize] + points[*b as usize]) / 6.0)
            }
            _ => Some(here),
        }
    }
}

/// One step: each face becomes one for each of its corners.
fn divide(polygons: &mut Polygons, parts: &mut Vec<usize>, wishes: &mut Wishes) {
    let points: Vec<DVec3> = doubles(&polygons.points);
    let all = topology(polygons, &points, wishes);
    let (old, edges) = (points.len() as u32, all.order.len() as u32);
    let mut next = Polygons {
        points: Vec::new(),
        counts: Vec::new(),
        corners: Vec::new(),
        hole: Vec::new(),
        primvars: polygons.primvars.clone(),
        normals: None,
        ..*polygons
    };
    let mut moved: Vec<DVec3> = (0..old)
        .map(|point| all.vertex_point(point, &points, wishes))
        .collect();
    moved.extend(all.order.iter().map(|k| match all.edges.get(k) {
        Some(edge) => all.edge_point(*k, edge, &points),
        None => DVec3::ZERO,
    }));
    moved.extend(&all.middles);
    next.points = moved.iter().map(|p| p.as_vec3().to_array()).collect();
    let starts = polygons.starts();
    let mut next_parts = Vec::new();
    // Where each new corner was: on an old corner, between two, or in the middle of a face.
    let mut origin: Vec<Blend> = Vec::new();
    for (face, start) in starts.iter().enumerate() {
        let count = polygons.counts[face];
        let ring = &polygons.corners[*start..start + count];
        if count < 3 {
            continue;
        }
        let at = |i: usize| Corner {
            face,
            number: start + i % count,
            point: ring[i % count],
        };
        let middle = old + edges + face as u32;
        let whole: Vec<Corner> = (0..count).map(at).collect();
        for i in 0..count {
            let before = (i + count - 1) % count;
            let number = |a: u32, b: u32| all.edge(a, b).map_or(0, |e| old + e.number);
            next.face(&[
                ring[i],
                number(ring[i], ring[(i + 1) % count]),
                middle,
                number(ring[before], ring[i]),
            ]);
            if let Some(hole) = next.hole.last_mut() {
                *hole = polygons.hole.get(face) == Some(&true);
            }
            next_parts.push(parts.get(face).copied().unwrap_or(0));
            origin.push(Blend(vec![at(i)]));
            origin.push(Blend(vec![at(i), at(i + 1)]));
            origin.push(Blend(whole.clone()));
            origin.push(Blend(vec![at(before), at(i)]));
        }
    }
    for layer in next.primvars.values_mut() {
        *layer = divided(layer, &origin);
    }
    softer(wishes, &all, old);
    *polygons = next;
    *parts = next_parts;
}

/// What is left of the creases after a step; new points begin at `old`.
pub(super) fn softer(wishes: &mut Wishes, all: &Topology, old: u32) {
    let mut softer = HashMap::new();
    for (key_of, edge) in &all.edges {
        let left = edge.sharpness - 1.0;
        if left > 0.0 && left.is_finite() {
            let middle = old + edge.number;
            softer.insert(key(key_of.0, middle), left);
            softer.insert(key(key_of.1, middle), left);
        }
    }
    wishes.edges = softer;
    wishes.softer();
}

/// Corners of the old face whose mean a new corner is.
pub(super) struct Blend(pub Vec<Corner>);

/// A layer on the new corners.
pub(super) fn divided(layer: &Layer, origin: &[Blend]) -> Layer {
    if layer.interpolation == Interpolation::Constant {
        return layer.clone();
    }
    let mut values = Vec::with_capacity(origin.len() * layer.components);
    for Blend(corners) in origin {
        for component in 0..layer.components {
            let of = |corner: &Corner| {
                let at = layer.index(*corner) * layer.components + component;
                layer.values.get(at).copied().unwrap_or(0.0)
            };
            let sum: f32 = corners.iter().map(of).sum();
            values.push(sum / corners.len() as f32);
        }
    }
    Layer {
        components: layer.components,
        values,
        interpolation: Interpolation::FaceVarying,
        indices: None,
    }
}

/// Brings the points to where endless steps would (Halstead, Kass and DeRose, "Efficient, fair interpolation using Catmull-Clark
/// surfaces", 1993): (n²·p + 4·Σ ends + Σ far corners) / (n(n + 5)) about points between n quads; along creases
/// (4·p + both ends) / 6.
fn to_limit(polygons: &mut Polygons, wishes: &Wishes) {
    if polygons.counts.iter().any(|count| *count != 4) {
        return;
    }
    let points = doubles(&polygons.points);
    let all = topology(polygons, &points, wishes);
    let starts = polygons.starts();
    let limit = |point: u32| {
        let here = points[point as usize];
        let faces = &all.faces[point as usize];
        let around = &all.neighbours[point as usize];
        if let Some(place) = all.limit_by_creases(point, &points, wishes) {
            return place;
        }
        let n = around.len() as f64;
        let ends: DVec3 = around.iter().map(|p| points[*p as usize]).sum();
        let far: DVec3 = faces
            .iter()
            .filter_map(|face| {
                let start = starts[*face as usize];
                let ring = &polygons.corners[start..start + 4];
                let at = ring.iter().position(|p| *p == point)?;
                Some(points[ring[(at + 2) % 4] as usize])
            })
            .sum();
        (n * n * here + 4.0 * ends + far) / (n * (n + 5.0))
    };
    let moved: Vec<[f32; 3]> = (0..points.len() as u32)
        .map(|point| limit(point).as_vec3().to_array())
        .collect();
    polygons.points = moved;
}

pub(super) fn doubles(points: &[[f32; 3]]) -> Vec<DVec3> {
    points
        .iter()
        .map(|p| DVec3::from(p.map(f64::from)))
        .collect()
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/subdivide.rs"]
mod tests;
