//! Triangles that stand twice in one place.

use super::{AlphaMode, Material, Mesh};
use std::collections::HashSet;

/// Whether twins of such triangles make light: each is sampled as a light of its own, but a ray meets one of them. (With
/// transparency each of them counts: two layers are two.)
pub fn make_light(material: &Material) -> bool {
    material.emission.iter().any(|&c| c > 0.0) && material.alpha_mode == AlphaMode::Opaque
}

/// Leaves out triangles whose corners are those of one before them, in the same order, bit for bit; says how many.
pub fn leave_out(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let mut seen = HashSet::with_capacity(before);
    let positions = &mesh.positions;
    mesh.triangles.retain(|corners| {
        let [a, b, c] = corners.map(|i| positions[i as usize].map(f32::to_bits));
        // From the least on, as it does not matter with which a triangle begins.
        seen.insert([[a, b, c], [b, c, a], [c, a, b]].into_iter().min())
    });
    before - mesh.triangles.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twins_go_and_others_stay() {
        let (p, q, r, s) = (
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        );
        let mut mesh = Mesh {
            positions: vec![p, q, r, s, p, q, r],
            // The second is the first with other vertices, the third is turned over, the fourth begins elsewhere.
            triangles: vec![[0, 1, 2], [4, 5, 6], [0, 2, 1], [1, 2, 0], [0, 1, 3]],
            ..Mesh::default()
        };
        assert_eq!(leave_out(&mut mesh), 2);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 1], [0, 1, 3]]);
    }
}
