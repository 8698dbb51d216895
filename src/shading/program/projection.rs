//! Images in the space of their coordinates (Blender's Image Texture).

use super::Place;
use crate::scene::graph::ImageProjection;
use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::PI;

/// What Cycles shows where there is no image.
pub const MISSING: Vec4 = Vec4::new(1.0, 0.0, 1.0, 1.0);

/// The texture of the square in which coordinates lie, and where they lie in it. They are rounded towards 0, as in Cycles:
/// the square at the origin is seen from the other sides of it, too.
pub fn tile(tiles: &[(u32, u32)], uv: Vec2) -> Option<(u32, Vec2)> {
    let corner = uv.trunc();
    if !(0.0..10.0).contains(&corner.x) || !(0.0..1e6).contains(&corner.y) {
        return None;
    }
    let wanted = 1001 + 10 * corner.y as u32 + corner.x as u32;
    let (_, texture) = tiles.iter().find(|(number, _)| *number == wanted)?;
    Some((*texture, uv - corner))
}

/// What a texture has at coordinates in Blender's axes, as these lie on it.
pub fn read(
    projection: ImageProjection,
    at: Vec3,
    place: &impl Place,
    texel: impl Fn(Vec2) -> Vec4,
) -> Vec4 {
    let read = |u: f32, v: f32| texel(Vec2::new(u, v));
    match projection {
        ImageProjection::Flat => read(at.x, at.y),
        ImageProjection::Sphere => {
            let from_middle = at * 2.0 - 1.0;
            match from_middle.try_normalize() {
                Some(d) => read(turn(d), 1.0 - d.z.clamp(-1.0, 1.0).acos() / PI),
                None => read(0.0, 0.0),
            }
        }
        ImageProjection::Tube => {
            let from_middle = at * 2.0 - 1.0;
            if from_middle.truncate() == Vec2::ZERO {
                read(0.0, 0.0)
            } else {
                read(turn(from_middle), (from_middle.z + 1.0) * 0.5)
            }
        }
        ImageProjection::Equirectangular => {
            let d = at.normalize_or_zero();
            if d == Vec3::ZERO {
                return read(0.0, 0.0);
            }
            let u = 0.5 - d.y.atan2(d.x) / (2.0 * PI);
            read(u, 1.0 - d.z.clamp(-1.0, 1.0).acos() / PI)
        }
        ImageProjection::MirrorBall => {
            // Halfway between the direction and the way back to the viewer, who looks along +Y.
            let d = at.normalize_or_zero() - Vec3::Y;
            let length = 2.0 * (-0.5 * d.y).max(0.0).sqrt();
            let n = if length > 0.0 { d / length } else { d };
            read(0.5 * (n.x + 1.0), 0.5 * (n.z + 1.0))
        }
        ImageProjection::Box { blend } => {
            let normal = place.box_normal();
            let weights = sides(normal.abs(), blend);
            let mirrored = |v: f32, mirror: bool| if mirror { 1.0 - v } else { v };
            // Mirrored on the far sides, so that what is written can be read.
            let sides = [
                (weights.x, mirrored(at.y, normal.x < 0.0), at.z),
                (weights.y, mirrored(at.x, normal.y > 0.0), at.z),
                (weights.z, mirrored(at.y, normal.z > 0.0), at.x),
            ];
            let shown = sides.into_iter().filter(|(weight, ..)| *weight > 0.0);
            shown.fold(Vec4::ZERO, |sum, (weight, u, v)| sum + read(u, v) * weight)
        }
    }
}

/// Around the Z axis, from 0 to 1.
fn turn(d: Vec3) -> f32 {
    if d.truncate() == Vec2::ZERO {
        0.0
    } else {
        (1.0 - d.x.atan2(d.y) / PI) * 0.5
    }
}

/// The shares of a box's sides: one where the normal is near it, two near an edge, three near a corner.
fn sides(n: Vec3, blend: f32) -> Vec3 {
    let n = n / n.element_sum();
    let limit = 0.5 * (1.0 + blend);
    for (side, a, b) in [(0, 1, 2), (1, 0, 2), (2, 0, 1)] {
        if n[side] > limit * (n[side] + n[a]) && n[side] > limit * (n[side] + n[b]) {
            return Vec3::AXES[side];
        }
    }
    if blend <= 0.0 {
        return Vec3::X;
    }
    for (a, b, other) in [(0, 1, 2), (1, 2, 0), (0, 2, 1)] {
        let both = n[a] + n[b];
        if n[other] < (1.0 - limit) * both {
            let share = ((n[a] / both - 0.5 * (1.0 - blend)) / blend).clamp(0.0, 1.0);
            return Vec3::AXES[a] * share + Vec3::AXES[b] * (1.0 - share);
        }
    }
    (n * (2.0 - limit) + (limit - 1.0)) / (2.0 * limit - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sides_of_a_box_share_everything() {
        for blend in [0.0, 0.2, 1.0] {
            for i in 0..200 {
                let (a, b) = (i as f32 * 0.37, i as f32 * 0.11);
                let n = Vec3::new(a.sin() * b.cos(), b.sin(), a.cos() * b.cos()).abs();
                let shares = sides(n, blend);
                assert!(
                    (shares.element_sum() - 1.0).abs() < 1e-5,
                    "{n} {blend} {shares}"
                );
                assert!(shares.min_element() >= -1e-6, "{n} {blend} {shares}");
            }
        }
        assert_eq!(sides(Vec3::new(0.9, 0.1, 0.2), 0.0), Vec3::X);
        assert_eq!(
            sides(Vec3::new(0.5, 0.5, 0.0), 0.5),
            Vec3::new(0.5, 0.5, 0.0)
        );
    }

    #[test]
    fn coordinates_lie_in_the_squares_of_their_whole_numbers() {
        let tiles = [(1001, 5), (1012, 7)];
        assert_eq!(
            tile(&tiles, Vec2::new(1.25, 1.5)),
            Some((7, Vec2::new(0.25, 0.5)))
        );
        assert_eq!(
            tile(&tiles, Vec2::new(-0.25, 0.5)),
            Some((5, Vec2::new(-0.25, 0.5)))
        );
        for elsewhere in [
            Vec2::new(1.5, 0.5),
            Vec2::splat(-1.5),
            Vec2::NAN,
            Vec2::X * 11.0,
        ] {
            assert_eq!(tile(&tiles, elsewhere), None);
        }
    }

    #[test]
    fn a_turn_goes_once_around() {
        assert_eq!(turn(Vec3::Z), 0.0);
        assert_eq!(turn(Vec3::Y), 0.5);
        assert_eq!(turn(Vec3::X), 0.25);
    }
}
