//! Cameras: from a film position to a ray.

use glam::{DAffine3, DVec3, Vec2, Vec3};

/// A camera ray with the part of it that the clip planes leave.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// Relative to the scene's origin.
    pub origin: Vec3,
    /// Unit length.
    pub direction: Vec3,
    /// Distance of the near plane along the ray.
    pub near: f32,
    /// Distance of the far plane along the ray.
    pub far: f32,
}

/// Kinds of projection, half extents at distance 1 (perspective) or in metres (orthographic).
#[derive(Clone, Copy, Debug)]
pub enum Lens {
    /// A pinhole: tangents of half the fields of view.
    Perspective {
        /// Tangents of half the horizontal and vertical fields of view.
        tangents: Vec2,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the visible width and height.
        half: Vec2,
    },
}

/// A camera ready to make rays.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    lens: Lens,
    x: Vec3,
    y: Vec3,
    z: Vec3,
    position: Vec3,
    near: f32,
    far: f32,
}

impl Camera {
    /// From its transform (scale is dropped) and the origin that the scene is relative to.
    pub fn new(
        lens: Lens,
        world_from_camera: &DAffine3,
        origin: DVec3,
        near: f64,
        far: f64,
    ) -> Self {
        let axis = |v: DVec3, fallback: DVec3| v.try_normalize().unwrap_or(fallback).as_vec3();
        let m = &world_from_camera.matrix3;
        Self {
            lens,
            x: axis(m.x_axis, DVec3::X),
            y: axis(m.y_axis, DVec3::Y),
            z: axis(m.z_axis, DVec3::Z),
            position: (world_from_camera.translation - origin).as_vec3(),
            near: near as f32,
            far: far as f32,
        }
    }

    /// The ray through a point of the film: x to the right and y up, −1..1.
    #[inline]
    pub fn ray(&self, film: Vec2) -> CameraRay {
        match self.lens {
            Lens::Perspective { tangents } => {
                let d = self.x * (film.x * tangents.x) + self.y * (film.y * tangents.y) - self.z;
                // The clip planes are at depths; along the ray they are 1/cos farther.
                let slant = d.length();
                CameraRay {
                    origin: self.position,
                    direction: d / slant,
                    near: self.near * slant,
                    far: self.far * slant,
                }
            }
            Lens::Orthographic { half } => CameraRay {
                origin: self.position + self.x * (film.x * half.x) + self.y * (film.y * half.y),
                direction: -self.z,
                near: self.near,
                far: self.far,
            },
        }
    }

    /// Depth of a point: its distance along the view axis.
    #[inline]
    pub fn depth(&self, point: Vec3) -> f32 {
        -(point - self.position).dot(self.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_go_through_the_corners_of_the_field_of_view() {
        let far_away = DVec3::new(1e7, 0.0, -3e6);
        let transform = DAffine3::from_translation(far_away + DVec3::new(1.0, 2.0, 3.0));
        let lens = Lens::Perspective {
            tangents: Vec2::new(1.0, 0.5),
        };
        let camera = Camera::new(lens, &transform, far_away, 0.1, f64::INFINITY);
        let ray = camera.ray(Vec2::new(1.0, -1.0));
        assert_eq!(ray.origin, Vec3::new(1.0, 2.0, 3.0));
        assert!((ray.direction - Vec3::new(1.0, -0.5, -1.0).normalize()).length() < 1e-6);
        assert!((ray.near - 0.15).abs() < 1e-6 && ray.far.is_infinite());
        let flat = Camera::new(
            Lens::Orthographic {
                half: Vec2::new(4.0, 2.0),
            },
            &transform,
            far_away,
            0.0,
            10.0,
        );
        let ray = flat.ray(Vec2::new(0.5, 1.0));
        assert_eq!(
            (ray.origin, ray.direction),
            (Vec3::new(3.0, 4.0, 3.0), Vec3::NEG_Z)
        );
        assert!((flat.depth(Vec3::new(9.0, 9.0, -2.0)) - 5.0).abs() < 1e-6);
    }
}
