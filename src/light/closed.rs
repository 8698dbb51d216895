//! Closed surfaces: what shines on the inside of one stays there.

use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Which side of a triangle is outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// That of its normal.
    Front,
    /// The other one.
    Back,
}

/// The outside of each triangle where all of them together are closed: each edge has one triangle on either side, wound
/// alike. `None` where they are not, or a part of them holds no volume that can be told from rounding.
pub fn outside(triangles: &[[Vec3; 3]]) -> Option<Vec<Outside>> {
    let vertices = numbered(triangles)?;
    if !each_edge_is_shared(&vertices) {
        return None;
    }
    let part = parts(&vertices);
    let mut volumes: HashMap<u32, Volume> = HashMap::new();
    for (corners, [vertex, ..]) in triangles.iter().zip(&vertices) {
        let part = part[*vertex as usize];
        volumes.entry(part).or_default().add(corners);
    }
    let side = |[vertex, ..]: &[u32; 3]| volumes.get(&part[*vertex as usize])?.outside();
    vertices.iter().map(side).collect()
}

/// The bits of a place, for finding equal ones: 0 and -0 are the same.
pub fn place_bits(place: Vec3) -> [u32; 3] {
    (place + 0.0).to_array().map(f32::to_bits)
}

/// Corners by number, equal for equal positions; `None` if a triangle has one of them twice.
fn numbered(triangles: &[[Vec3; 3]]) -> Option<Vec<[u32; 3]>> {
    let corners = triangles.iter().flatten().map(|&p| place_bits(p));
    // Sorted: a table by hashes takes several times as long.
    let mut places: Vec<([u32; 3], usize)> = corners.zip(0..).collect();
    places.sort_unstable();
    let mut vertices = vec![[0u32; 3]; triangles.len()];
    let mut number = 0;
    for (i, &(place, corner)) in places.iter().enumerate() {
        number += u32::from(i > 0 && places[i - 1].0 != place);
        vertices[corner / 3][corner % 3] = number;
    }
    let whole = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    vertices.iter().all(whole).then_some(vertices)
}

/// Whether each edge has two triangles, which pass it in opposite directions.
fn each_edge_is_shared(vertices: &[[u32; 3]]) -> bool {
    let edges = vertices
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    // Its ends, then its direction.
    let mut passed: Vec<(u32, u32, bool)> =
        edges.map(|(a, b)| (a.min(b), a.max(b), a > b)).collect();
    passed.sort_unstable();
    let (pairs, rest) = passed.as_chunks::<2>();
    rest.is_empty()
        && pairs
            .iter()
            .all(|[there, back]| (there.0, there.1) == (back.0, back.1) && there.2 != back.2)
}

/// The connected part of each vertex, by the number of one of its vertices.
fn parts(vertices: &[[u32; 3]]) -> Vec<u32> {
    fn root(parent: &mut [u32], mut of: u32) -> u32 {
        while parent[of as usize] != of {
            let above = parent[of as usize];
            parent[of as usize] = parent[above as usize];
            of = above;
        }
        of
    }
    let count = vertices.iter().flatten().max().map_or(0, |&v| v + 1);
    let mut parent: Vec<u32> = (0..count).collect();
    for &[a, b, c] in vertices {
        let into = root(&mut parent, a);
        for other in [b, c] {
            let from = root(&mut parent, other);
            parent[from as usize] = into;
        }
    }
    (0..count).map(|v| root(&mut parent, v)).collect()
}

/// Six times the signed volume of a closed part, by tetrahedra from one of its corners.
#[derive(Default)]
struct Volume {
    from: Option<DVec3>,
    sum: f64,
    /// Of magnitudes.
    size: f64,
    terms: f64,
}

impl Volume {
    fn add(&mut self, corners: &[Vec3; 3]) {
        let from = *self.from.get_or_insert(corners[0].as_dvec3());
        // Differences of f32 numbers: one rounding each, of 2⁻⁵³.
        let [a, b, c] = corners.map(|p| p.as_dvec3() - from);
        self.sum += a.dot(b.cross(c));
        self.size += a.length() * b.length() * c.length();
        self.terms += 1.0;
    }

    fn outside(&self) -> Option<Outside> {
        // Three differences, two products, three sums in each term; then a sum of all terms.
        let bound = (8.0 + self.terms) * f64::EPSILON * self.size;
        if self.sum.abs() <= bound || !self.sum.is_finite() {
            None
        } else if self.sum > 0.0 {
            Some(Outside::Front)
        } else {
            Some(Outside::Back)
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/closed.rs"]
mod tests;
