//! Panoramas: from places in the picture to directions and back, as Cycles has them (kernel/camera/projection.h).
//!
//! Places are 0 to 1 from the left and from below; directions have x to the right, y up and z back, as glTF's cameras.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// A kind of panorama besides the equirectangular one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Panorama {
    /// The angle from the middle grows as the distance there; half the picture is half of the field of view, radians.
    FisheyeEquidistant {
        /// From edge to edge.
        fov: f32,
    },
    /// A lens that keeps areas; millimetres.
    FisheyeEquisolid {
        /// Focal length.
        lens: f32,
        /// Radians.
        fov: f32,
        /// Width and height of the sensor.
        sensor: Vec2,
    },
    /// The angle is a polynomial of the millimetres from the middle, negative.
    FisheyePolynomial {
        /// Constant, linear …
        coefficients: [f32; 5],
        /// Radians.
        fov: f32,
        /// Width and height of the sensor.
        sensor: Vec2,
    },
    /// What a mirror ball shows from far away.
    MirrorBall,
    /// A face of a cube, in equal angles.
    CubeFace,
    /// On a cylinder about the camera.
    CentralCylindrical {
        /// At the left and at the right edge, radians.
        longitude: [f32; 2],
        /// At the bottom and at the top edge, in radii.
        height: [f32; 2],
    },
}

impl Panorama {
    /// The direction of a place, of unit length; `None` where the picture is empty.
    pub fn direction(self, place: Vec2) -> Option<Vec3> {
        let middle = place - 0.5;
        match self {
            Self::FisheyeEquidistant { fov } => {
                let at = middle * 2.0;
                let r = at.length();
                (r <= 1.0).then(|| fisheye(at, r, 0.5 * fov * r))
            }
            Self::FisheyeEquisolid { lens, fov, sensor } => {
                let at = middle * sensor;
                let r = at.length();
                let most = 2.0 * lens * (0.25 * fov).sin();
                (r <= most).then(|| fisheye(at, r, 2.0 * (r / (2.0 * lens)).asin()))
            }
            Self::FisheyePolynomial {
                coefficients,
                fov,
                sensor,
            } => {
                let at = middle * sensor;
                let r = at.length();
                let angle = -coefficients.iter().rev().fold(0.0, |sum, k| sum * r + k);
                (angle.abs() <= 0.5 * fov).then(|| fisheye(at, r, angle))
            }
            Self::MirrorBall => {
                let at = middle * 2.0;
                let z2 = 1.0 - at.length_squared();
                // The mirrored view axis.
                let z = z2.max(0.0).sqrt();
                (z2 >= 0.0)
                    .then(|| Vec3::new(at.x, at.y, z) * (2.0 * z) - Vec3::Z)
                    .map(|d| Vec3::new(d.x, d.y, -d.z))
            }
            Self::CubeFace => {
                let [x, y] = (middle * FRAC_PI_2).to_array().map(f32::tan);
                Some(Vec3::new(x, y, -1.0).normalize())
            }
            Self::CentralCylindrical { longitude, height } => {
                let between = |[from, to]: [f32; 2], t: f32| from + (to - from) * t;
                let (sin, cos) = between(longitude, place.x).sin_cos();
                let up = between(height, place.y);
                Some(Vec3::new(sin, up, -cos).normalize())
            }
        }
    }

    /// The place of a direction of unit length, which may lie outside of the picture.
    pub fn place(self, d: Vec3) -> Vec2 {
        let across = Vec2::new(d.x, d.y);
        let way = across.normalize_or_zero();
        let middle = match self {
            Self::FisheyeEquidistant { fov } => way * (across.length().atan2(-d.z) / fov),
            Self::FisheyeEquisolid { lens, sensor, .. } => {
                let angle = (-d.z).clamp(-1.0, 1.0).acos();
                way * (2.0 * lens * (0.5 * angle).sin()) / sensor
            }
            Self::FisheyePolynomial {
                coefficients,
                sensor,
                ..
            } => way * distance(coefficients, (-d.z).clamp(-1.0, 1.0).acos()) / sensor,
            Self::MirrorBall => {
                let length = 2.0 * (0.5 * (1.0 - d.z)).max(0.0).sqrt();
                across / length.max(f32::MIN_POSITIVE) * 0.5
            }
            Self::CubeFace => Vec2::new(d.x.atan2(-d.z), d.y.atan2(-d.z)) * (2.0 / PI),
            Self::CentralCylindrical { longitude, height } => {
                let share = |[from, to]: [f32; 2], at: f32| (at - from) / (to - from);
                let up = d.y / Vec2::new(d.x, d.z).length();
                return Vec2::new(share(longitude, d.x.atan2(-d.z)), share(height, up));
            }
        };
        middle + 0.5
    }

    /// Whether there is such a panorama.
    pub fn is_sane(self) -> bool {
        let positive = |numbers: &[f32]| numbers.iter().all(|n| n.is_finite() && *n > 0.0);
        let span = |[from, to]: [f32; 2]| from.is_finite() && to.is_finite() && from != to;
        match self {
            Self::FisheyeEquidistant { fov } => positive(&[fov]),
            Self::FisheyeEquisolid { lens, fov, sensor } => {
                positive(&[lens, fov, sensor.x, sensor.y])
            }
            Self::FisheyePolynomial {
                coefficients,
                fov,
                sensor,
            } => positive(&[fov, sensor.x, sensor.y]) && coefficients.iter().all(|k| k.is_finite()),
            Self::MirrorBall | Self::CubeFace => true,
            Self::CentralCylindrical { longitude, height } => span(longitude) && span(height),
        }
    }

    /// Radians that the height of the picture would see, were it all as about the middle.
    pub fn height(self) -> f32 {
        const STEP: f32 = 1e-2;
        let at = |v: f32| self.direction(Vec2::new(0.5, v));
        match (at(0.5 - STEP), at(0.5 + STEP)) {
            (Some(below), Some(above)) => (above - below).length() / (2.0 * STEP),
            _ => 0.0,
        }
    }
}

/// The direction at an angle from the view axis, toward a point of the picture that is `r` from its middle.
fn fisheye(at: Vec2, r: f32, angle: f32) -> Vec3 {
    let way = if r > 0.0 { at / r } else { Vec2::X };
    let (sin, cos) = angle.sin_cos();
    (way * sin).extend(-cos)
}

/// How far from the middle an angle is, by Newton's method.
fn distance(coefficients: [f32; 5], angle: f32) -> f32 {
    let [k0, k1, k2, k3, k4] = coefficients;
    let mut r = (-angle - k0) / k1;
    for _ in 0..20 {
        let value = coefficients.iter().rev().fold(0.0, |sum, k| sum * r + k);
        let slope = k1 + r * (2.0 * k2 + r * (3.0 * k3 + r * 4.0 * k4));
        let step = (-angle - value) / slope;
        r += step;
        if step.abs() < 1e-6 {
            break;
        }
    }
    r
}

#[cfg(test)]
#[path = "../../tests/unit/math/panorama.rs"]
mod tests;
