//! Spherical stereo: an eye for each direction of a panorama.

use super::CameraRay;
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;

/// One of two eyes on a circle that turns with the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// How far to the right of the middle, metres.
    pub offset: f32,
    /// How far away both eyes see the same; infinite where they look alike.
    pub convergence: f32,
    /// Angles from the horizon between which the offset fades to nothing, radians.
    pub pole_merge: Option<[f32; 2]>,
}

impl Eye {
    /// What of the offset is left at an angle from the horizon: a quarter of a cosine's wave, as in Cycles.
    fn left_at(&self, altitude: f32) -> f32 {
        match self.pole_merge {
            Some([_, to]) if to > 0.0 && altitude > to => 0.0,
            Some([from, to]) if to > 0.0 && altitude > from => {
                ((altitude - from) / (to - from) * FRAC_PI_2).cos()
            }
            _ => 1.0,
        }
    }

    /// The ray of the eye for one of the middle.
    pub fn sees(&self, ray: CameraRay, up: Vec3) -> CameraRay {
        let altitude = ray.direction.dot(up).clamp(-1.0, 1.0).asin().abs();
        let side = ray.direction.cross(up).normalize_or_zero();
        let offset = side * (self.offset * self.left_at(altitude));
        let direction = if self.convergence.is_finite() {
            let toward = ray.direction * self.convergence - offset;
            toward.try_normalize().unwrap_or(ray.direction)
        } else {
            ray.direction
        };
        CameraRay {
            origin: ray.origin + offset,
            direction,
            ..ray
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/camera/eye.rs"]
mod tests;
