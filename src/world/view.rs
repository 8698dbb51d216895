//! What a world knows of the one who looks, and Blender's axes.

use crate::math::float::Affine;
use crate::scene::{Camera, Projection};
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// Of glTF's axes, Blender's.
pub fn to_blender(v: Vec3) -> Vec3 {
    Vec3::new(v.x, -v.z, v.y)
}

/// Of Blender's axes, glTF's.
pub fn from_blender(v: Vec3) -> Vec3 {
    Vec3::new(v.x, v.z, -v.y)
}

/// What a world knows of the one who looks.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// From places relative to the origin, in glTF's axes, to the camera's: it looks along +Z, as in Cycles.
    pub camera: Affine,
    /// A pixel's height, metres: this at the camera, and so much more for each metre from it.
    pub pixel: (f32, f32),
    /// How the picture is seen.
    frame: Frame,
}

/// The edges of a picture: left, right, bottom, top.
#[derive(Clone, Copy, Debug)]
enum Frame {
    /// Tangents of angles.
    Perspective([f32; 4]),
    /// Metres.
    Orthographic([f32; 4]),
    /// Radians.
    Equirectangular([f32; 4]),
}

impl Frame {
    fn new(camera: &Camera, aspect: f64) -> Self {
        let window = camera.window.map(|w| w.widened_to(aspect));
        let edges =
            |x: f64, y: f64| window.map_or([-x, x, -y, y], |w| [w.left, w.right, w.bottom, w.top]);
        let single = |edges: [f64; 4]| edges.map(|edge| edge as f32);
        match camera.projection {
            Projection::Perspective { vertical_fov, .. } => {
                let y = (0.5 * vertical_fov).tan();
                Self::Perspective(single(edges(y * aspect, y)))
            }
            Projection::Orthographic { half_height, .. } => {
                Self::Orthographic(single(edges(half_height * aspect, half_height)))
            }
            Projection::Equirectangular {
                longitude: [left, right],
                latitude: [bottom, top],
            } => Self::Equirectangular(single([left, right, bottom, top])),
        }
    }

    /// Where in the picture a point of the camera's space is, 0 to 1.
    fn at(&self, p: Vec3) -> Vec3 {
        let (edges, at) = match self {
            Self::Perspective(edges) => (edges, [p.x / p.z, p.y / p.z]),
            Self::Orthographic(edges) => (edges, [p.x, p.y]),
            Self::Equirectangular(edges) => {
                let up = p.y / p.length().max(f32::MIN_POSITIVE);
                (edges, [p.x.atan2(p.z), up.clamp(-1.0, 1.0).asin()])
            }
        };
        let [left, right, bottom, top] = *edges;
        Vec3::new(
            (at[0] - left) / (right - left),
            (at[1] - bottom) / (top - bottom),
            0.0,
        )
    }
}

impl View {
    /// Where a place in the camera's space lies in the picture: 0 to 1 from the left, and from below.
    pub fn window(&self, p: Vec3) -> Vec3 {
        self.frame.at(p)
    }

    /// That of a world's camera.
    pub fn new(camera: &Camera, (aspect, rows): (f64, u32), origin: DVec3) -> Self {
        let to_camera = camera.world_from_camera.inverse();
        // glTF's cameras look along −Z.
        let flip = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        let flipped = DAffine3 {
            matrix3: flip * to_camera.matrix3,
            translation: flip * to_camera.transform_point3(origin),
        };
        let window = camera.window.map(|w| w.widened_to(aspect));
        let height = |plain: f64| window.map_or(plain, |w| w.top - w.bottom);
        let (parallel, angle) = match camera.projection {
            Projection::Perspective { vertical_fov, .. } => {
                (0.0, height(2.0 * (0.5 * vertical_fov).tan()))
            }
            Projection::Orthographic { half_height, .. } => (height(2.0 * half_height), 0.0),
            Projection::Equirectangular { latitude, .. } => (0.0, latitude[1] - latitude[0]),
        };
        let rows = f64::from(rows.max(1));
        Self {
            camera: Affine::from_f64(&flipped, DVec3::ZERO),
            pixel: ((parallel / rows) as f32, (angle / rows) as f32),
            frame: Frame::new(camera, aspect),
        }
    }
}
