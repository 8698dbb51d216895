//! Cameras: from a film position to a ray.

mod aperture;
mod eye;
mod shutter;

pub use aperture::{Aperture, nearest_focus};
pub use eye::Eye;
pub use shutter::{MovingCamera, Shutter};

use crate::math::float;
use crate::math::panorama::Panorama;
use crate::sampler::{Dimension, Sampler};
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};

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
    /// When it is on its way: 0 where the shutter opens, 1 where it closes.
    pub time: f32,
}

impl CameraRay {
    /// Whether there is no ray: the place lies outside of what a panorama shows.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.far == f32::NEG_INFINITY
    }
}

/// An interval by its middle and half its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    middle: Vec2,
    half: Vec2,
}

impl Span {
    /// Of what lies between the film's left and right, and between its bottom and top.
    pub fn between([left, right]: [f64; 2], [bottom, top]: [f64; 2]) -> Self {
        let of = |from: f64, to: f64| (0.5 * (from + to), 0.5 * (to - from));
        let (x, y) = (of(left, right), of(bottom, top));
        Self {
            middle: Vec2::new(x.0 as f32, y.0 as f32),
            half: Vec2::new(x.1 as f32, y.1 as f32),
        }
    }

    /// With edges that many times as far from 0.
    #[must_use]
    fn times(self, factor: f32) -> Self {
        Self {
            middle: self.middle * factor,
            half: self.half * factor,
        }
    }

    /// At a point of the film.
    #[inline]
    fn at(&self, film: Vec2) -> Vec2 {
        self.middle + film * self.half
    }
}

/// Kinds of projection, with what the film spans.
#[derive(Clone, Copy, Debug)]
pub enum Lens {
    /// Through one point; tangents of the angles to the view axis.
    Perspective(Span),
    /// Parallel rays; metres.
    Orthographic(Span),
    /// All about; longitude (0 is straight ahead, grows to the right) and latitude, radians.
    Equirectangular(Span),
    /// Another panorama; 0 to 1 from left to right, and from below.
    Panorama(Panorama, Span),
}

impl Lens {
    fn is_panorama(&self) -> bool {
        matches!(self, Self::Equirectangular(_) | Self::Panorama(..))
    }
}

/// A camera so far from all that it could see that f32 about it cannot tell places there apart. Its rays are made in f64
/// and begin at the plane before the scene, about which all is f32.
#[derive(Clone, Copy, Debug)]
struct Distant {
    axes: [DVec3; 3],
    /// Relative to the scene's origin.
    position: DVec3,
    /// Depth of the plane where rays begin.
    start: f64,
    near: f64,
    far: f64,
}

/// A camera ready to make rays.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    distant: Option<Distant>,
    lens: Lens,
    aperture: Option<Aperture>,
    x: Vec3,
    y: Vec3,
    z: Vec3,
    position: Vec3,
    near: f32,
    far: f32,
    eye: Option<Eye>,
}

/// Unit vectors to the right, up and back.
fn axes(world_from_camera: &DAffine3) -> [DVec3; 3] {
    let axis = |v: DVec3, fallback: DVec3| v.try_normalize().unwrap_or(fallback);
    let m = &world_from_camera.matrix3;
    [
        axis(m.x_axis, DVec3::X),
        axis(m.y_axis, DVec3::Y),
        axis(m.z_axis, DVec3::Z),
    ]
}

/// Makes the ray through a point of the film and a point of the lens.
pub type RayMaker = fn(&Camera, Vec2, &Sampler) -> CameraRay;

impl Camera {
    /// From its transform (scale is dropped) and the origin that the scene is relative to.
    pub fn new(
        lens: Lens,
        aperture: Option<Aperture>,
        world_from_camera: &DAffine3,
        origin: DVec3,
        near: f64,
        far: f64,
    ) -> Self {
        let [x, y, z] = axes(world_from_camera).map(|axis| axis.as_vec3());
        Self {
            distant: None,
            lens,
            aperture,
            x,
            y,
            z,
            position: (world_from_camera.translation - origin).as_vec3(),
            // What the camera stands on is not in its way.
            near: (near as f32).max(float::RAY_START),
            far: far as f32,
            eye: None,
        }
    }

    /// With an eye beside its middle for each direction of a panorama.
    #[must_use]
    pub fn with_eye(self, eye: Option<Eye>) -> Self {
        Self { eye, ..self }
    }

    /// The same far away from all there is, which is within a radius about a middle (relative to the origin).
    #[must_use]
    pub fn distant(
        self,
        world_from_camera: &DAffine3,
        origin: DVec3,
        (near, far): (f64, f64),
        (middle, radius): (DVec3, f64),
    ) -> Self {
        let axes = axes(world_from_camera);
        let position = world_from_camera.translation - origin;
        let depth = (position - middle).dot(axes[2]);
        Self {
            distant: Some(Distant {
                axes,
                position,
                start: (depth - radius).max(0.0),
                near,
                far,
            }),
            ..self
        }
    }

    /// What makes this camera's rays: a pinhole asks for no point of the lens.
    pub fn ray_maker(&self) -> RayMaker {
        if self.distant.is_some() && !self.lens.is_panorama() {
            |camera, film, sampler| match &camera.distant {
                Some(distant) => camera.distant_ray(distant, film, sampler),
                None => camera.ray(film),
            }
        } else if self.eye.is_some() && self.lens.is_panorama() {
            |camera, film, sampler| {
                let ray = camera.ray_of_lens(film, sampler);
                match &camera.eye {
                    Some(eye) if !ray.is_none() => eye.sees(ray, camera.y),
                    _ => ray,
                }
            }
        } else if self.aperture.is_some() {
            Self::ray_of_lens
        } else {
            |camera, film, _| camera.ray(film)
        }
    }

    /// The ray through a point of the film and one of the lens' opening, if it has one.
    fn ray_of_lens(&self, film: Vec2, sampler: &Sampler) -> CameraRay {
        match &self.aperture {
            Some(aperture) => {
                let on_lens = aperture.sample(sampler.pair(Dimension::Lens, 0));
                self.focused(film, on_lens, aperture.focus_distance)
            }
            None => self.ray(film),
        }
    }

    /// The ray through a point of the film (x to the right and y up, −1..1) and the middle of the lens.
    #[inline]
    pub fn ray(&self, film: Vec2) -> CameraRay {
        match self.lens {
            Lens::Perspective(span) => {
                let at = span.at(film);
                let d = self.x * at.x + self.y * at.y - self.z;
                // The clip planes are at depths; along the ray they are 1/cos farther.
                let slant = d.length();
                CameraRay {
                    origin: self.position,
                    direction: d / slant,
                    near: self.near * slant,
                    far: self.far * slant,
                    time: 0.0,
                }
            }
            Lens::Orthographic(span) => {
                let at = span.at(film);
                CameraRay {
                    origin: self.position + self.x * at.x + self.y * at.y,
                    direction: -self.z,
                    near: self.near,
                    far: self.far,
                    time: 0.0,
                }
            }
            Lens::Equirectangular(span) => CameraRay {
                origin: self.position,
                direction: self.toward(span.at(film)),
                near: self.near,
                far: self.far,
                time: 0.0,
            },
            Lens::Panorama(kind, span) => {
                let direction = kind.direction(span.at(film));
                CameraRay {
                    origin: self.position,
                    direction: direction.map_or(-self.z, |d| self.in_world(d)),
                    near: self.near,
                    far: direction.map_or(f32::NEG_INFINITY, |_| self.far),
                    time: 0.0,
                }
            }
        }
    }

    /// As [`Self::ray`] and [`Self::focused`], in f64.
    fn distant_ray(&self, distant: &Distant, film: Vec2, sampler: &Sampler) -> CameraRay {
        let [x, y, z] = distant.axes;
        let (on_lens, focus) = self.aperture.map_or((DVec2::ZERO, 1.0), |aperture| {
            let on_lens = aperture.sample(sampler.pair(Dimension::Lens, 0));
            (on_lens.as_dvec2(), f64::from(aperture.focus_distance))
        });
        // Where it starts, and how far it moves on the way to one more of depth.
        let (from, step) = match self.lens {
            Lens::Perspective(span) => (on_lens, span.at(film).as_dvec2() - on_lens / focus),
            Lens::Orthographic(span) | Lens::Equirectangular(span) | Lens::Panorama(_, span) => {
                (span.at(film).as_dvec2() + on_lens, -on_lens / focus)
            }
        };
        let at = from + step * distant.start;
        let origin = distant.position + x * at.x + y * at.y - z * distant.start;
        let d = x * step.x + y * step.y - z;
        let slant = d.length();
        let along = |depth: f64| ((depth - distant.start) * slant) as f32;
        CameraRay {
            origin: origin.as_vec3(),
            direction: (d / slant).as_vec3(),
            near: along(distant.near).max(float::RAY_START),
            far: along(distant.far),
            time: 0.0,
        }
    }

    /// A direction of the camera's own axes.
    #[inline]
    fn in_world(&self, d: Vec3) -> Vec3 {
        self.x * d.x + self.y * d.y + self.z * d.z
    }

    /// The direction of a longitude and latitude.
    #[inline]
    fn toward(&self, at: Vec2) -> Vec3 {
        let (longitude, latitude) = (at.x.sin_cos(), at.y.sin_cos());
        self.x * (longitude.0 * latitude.1) + self.y * latitude.0
            - self.z * (longitude.1 * latitude.1)
    }

    /// The ray from a point of the lens to the point in focus of the ray through its middle.
    #[inline]
    fn focused(&self, film: Vec2, lens: Vec2, focus_distance: f32) -> CameraRay {
        // By a power of two, which rounds nothing, so that the focus is between 1 and 2: the square of one at 10²⁰ m
        // leaves f32. One at infinity has no number.
        let power = f32::from_bits(focus_distance.to_bits() & f32::INFINITY.to_bits());
        let (to_focus, lens_scale) = if focus_distance.is_infinite() {
            (1.0, 0.0)
        } else {
            let power = power.max(f32::MIN_POSITIVE);
            (focus_distance / power, power.recip())
        };
        let scaled = lens * lens_scale;
        let (start, d, depth) = match self.lens {
            Lens::Perspective(span) => {
                let at = span.at(film) * to_focus - scaled;
                let d = self.x * at.x + self.y * at.y - self.z * to_focus;
                (self.x * lens.x + self.y * lens.y, d, to_focus)
            }
            Lens::Orthographic(span) => {
                let at = span.at(film) + lens;
                let d = -(self.x * scaled.x + self.y * scaled.y + self.z * to_focus);
                (self.x * at.x + self.y * at.y, d, to_focus)
            }
            Lens::Equirectangular(_) | Lens::Panorama(..) => {
                let ray = self.ray(film);
                if ray.is_none() {
                    return ray;
                }
                let middle = ray.direction;
                // As Cycles holds the lens: its first axis leans forward as far as it can, that of a mirror ball to the side.
                let forward = match self.lens {
                    Lens::Panorama(Panorama::MirrorBall, _) => self.x,
                    _ => -self.z,
                };
                let first = (forward - middle * forward.dot(middle)).try_normalize();
                let first = first.unwrap_or(self.y);
                let second = middle.cross(first);
                let start = first * lens.x + second * lens.y;
                let d = middle * to_focus - (first * scaled.x + second * scaled.y);
                (start, d, d.length())
            }
        };
        let length = d.length();
        let slant = length / depth;
        CameraRay {
            origin: self.position + start,
            direction: d / length,
            near: self.near * slant,
            far: self.far * slant,
            time: 0.0,
        }
    }

    /// Against the view axis.
    pub fn backward(&self) -> Vec3 {
        self.z
    }

    /// How far from the camera a point is for Blender's mist: along the view axis of parallel rays alone.
    pub fn distance(&self, point: Vec3) -> f32 {
        match (&self.distant, self.lens) {
            (_, Lens::Orthographic(_)) => self.depth(point).abs(),
            (Some(distant), _) => (distant.position - point.as_dvec3()).length() as f32,
            (None, _) => (point - self.position).length(),
        }
    }

    /// Depth of a point: its distance along the view axis; from the camera for a panorama.
    #[inline]
    pub fn depth(&self, point: Vec3) -> f32 {
        if let Some(distant) = &self.distant
            && !self.lens.is_panorama()
        {
            return (distant.position - point.as_dvec3()).dot(distant.axes[2]) as f32;
        }
        match self.lens {
            Lens::Equirectangular(_) | Lens::Panorama(..) => (point - self.position).length(),
            _ => -(point - self.position).dot(self.z),
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/camera/mod.rs"]
mod tests;
