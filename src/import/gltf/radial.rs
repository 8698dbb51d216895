//! Directions around the Z axis of a mesh, by its generated coordinates.

use super::schema::TextureSpaceJson;
use glam::Vec3;

/// Directions around the Z axis of generated coordinates that are known.
pub(super) fn of_generated(generated: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let around = |[x, y, _]: &[f32; 3]| [0.5 - y, x - 0.5, 0.0];
    generated.iter().map(around).collect()
}

/// Directions around the Z axis of generated coordinates. Without a texture space they are as Blender's own automatic one: the
/// box around the vertices.
pub(super) fn of_positions(
    positions: &[[f32; 3]],
    space: Option<TextureSpaceJson>,
) -> Vec<[f32; 3]> {
    let (location, size) = match space {
        Some(space) => (Vec3::from(space.location), Vec3::from(space.size)),
        None => {
            let points = || positions.iter().map(|p| Vec3::from(*p));
            let (low, high) = (
                points().fold(Vec3::INFINITY, Vec3::min),
                points().fold(Vec3::NEG_INFINITY, Vec3::max),
            );
            (0.5 * (low + high), 0.5 * (high - low))
        }
    };
    let size = Vec3::select(size.cmpeq(Vec3::ZERO), Vec3::ONE, size);
    let around = |p: &[f32; 3]| {
        let generated = (Vec3::from(*p) - location) / (2.0 * size);
        [-generated.y, generated.x, 0.0]
    };
    positions.iter().map(around).collect()
}
