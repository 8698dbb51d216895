//! Normals of vertices that tell nothing.

use super::Mesh;
use glam::DVec3;

/// Half the distance from 1 to the next f32.
const UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 * 0.5;

impl Mesh {
    /// Whether it has normals that are not those of its triangles: a flat mesh needs none.
    ///
    /// Corners with coordinates of at most c that are rounded to f32 are off by √3 u c, their edges by twice that, and the cross
    /// product of the edges e, f by 2√3 u c (|e| + |f|), over twice the area. Whoever made the file computed in f32 too: twice as
    /// much, and 8 u for the roundings of the normals themselves.
    pub fn is_smooth(&self) -> bool {
        let Some(normals) = &self.normals else {
            return false;
        };
        !self.has_strands()
            && !self.triangles.iter().all(|triangle| {
                let at = |values: &[[f32; 3]], i: u32| {
                    let value = values.get(i as usize).copied().unwrap_or_default();
                    DVec3::from(value.map(f64::from))
                };
                let [a, b, c] = triangle.map(|i| at(&self.positions, i));
                let (e, f) = (b - a, c - a);
                let cross = e.cross(f);
                let area = cross.length();
                if area <= 0.0 {
                    return true; // No ray meets it.
                }
                let farthest = [a, b, c]
                    .into_iter()
                    .fold(0.0, |c: f64, p| c.max(p.abs().max_element()));
                let corners = 4.0 * 3f64.sqrt() * farthest * (e.length() + f.length()) / area;
                let bound = UNIT_ROUNDOFF * (corners + 8.0);
                let own = cross / area;
                triangle
                    .iter()
                    .all(|&i| (at(normals, i) - own).length() <= bound)
            })
    }
}

#[cfg(test)]
#[path = "../../tests/unit/scene/flat.rs"]
mod tests;
