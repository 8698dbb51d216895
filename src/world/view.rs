//! What a world knows of the one who looks, and Blender's axes.

use super::Options;
use crate::math::float::Affine;
use crate::math::panorama::Panorama;
use crate::scene::{Camera, Projection};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};

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
    /// A pixel's height in the middle of the picture, metres: this at the camera, and so much more for each metre from it.
    pixel: (f32, f32),
    /// A pixel's width over its height.
    pixel_aspect: f32,
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
    /// Another panorama, moved so far.
    Panorama(Panorama, Vec2),
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
            Projection::Panorama { kind, shift } => {
                Self::Panorama(kind, DVec2::from(shift).as_vec2())
            }
        }
    }

    /// Where in the picture a point of the camera's space is, 0 to 1.
    fn at(&self, p: Vec3) -> Vec3 {
        let (edges, at) = match self {
            Self::Panorama(kind, shift) => {
                // Its axes look back.
                let d = Vec3::new(p.x, p.y, -p.z).normalize_or_zero();
                return (kind.place(d) - *shift).extend(0.0);
            }
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

impl Options<'_> {
    /// What programs know of who looks, from an origin.
    pub(super) fn view(&self, origin: DVec3) -> View {
        View::new(self.camera, (self.aspect, self.rows), origin)
    }
}

/// The picture at three times, for motion vectors: before, now and after.
#[derive(Clone, Copy, Debug)]
pub struct Views {
    at: [View; 3],
    /// What lies at infinity moves, too.
    around: bool,
}

impl Views {
    /// Of a camera whose motion has its first step before and its last one after; `around`: what lies at infinity moves, too.
    pub fn new(camera: &Camera, size: (f64, u32), origin: DVec3, around: bool) -> Self {
        let at = |last: bool| {
            let mut camera = camera.clone();
            if let Some(motion) = camera.motion.take() {
                let place = if last {
                    motion.steps.last()
                } else {
                    motion.steps.first()
                };
                camera.world_from_camera = place.copied().unwrap_or(camera.world_from_camera);
                let zoom = motion.zoom[usize::from(last)];
                let perspective = matches!(camera.projection, Projection::Perspective { .. });
                for window in camera.window.iter_mut().filter(|_| perspective) {
                    let edges = [
                        &mut window.left,
                        &mut window.right,
                        &mut window.bottom,
                        &mut window.top,
                    ];
                    edges.into_iter().for_each(|edge| *edge *= zoom);
                }
            }
            View::new(&camera, size, origin)
        };
        Self {
            at: [at(false), View::new(camera, size, origin), at(true)],
            around,
        }
    }

    /// From now to before, and from after to now, in widths and heights of the picture, of something that is at three places.
    pub fn of_points(&self, points: [Vec3; 3]) -> [Vec2; 2] {
        self.between(|view, time| {
            view.window(view.camera.vector(points[time]) + view.camera.translation)
        })
    }

    /// The same of what lies in a direction at infinity, if that counts.
    pub fn of_direction(&self, direction: Vec3) -> Option<[Vec2; 2]> {
        let moved = || self.between(|view, _| view.frame.linear(view.camera.vector(direction)));
        self.around.then(moved)
    }

    fn between(&self, at: impl Fn(&View, usize) -> Vec3) -> [Vec2; 2] {
        let place = |time: usize| at(&self.at[time], time).truncate();
        let [before, now, after] = [place(0), place(1), place(2)];
        [before - now, now - after]
    }
}

impl Frame {
    /// Where in the picture a direction of the camera's space is, as Cycles has it for motion vectors: not divided by the depth,
    /// and of parallel rays without the edges.
    fn linear(&self, d: Vec3) -> Vec3 {
        match self {
            Self::Perspective(_) => self.at(d) * d.z,
            Self::Orthographic([left, right, bottom, top]) => {
                Vec3::new(d.x / (right - left), d.y / (top - bottom), 0.0)
            }
            Self::Equirectangular(_) | Self::Panorama(..) => self.at(d),
        }
    }
}

impl View {
    /// Whether its rays are parallel.
    pub fn is_orthographic(&self) -> bool {
        matches!(self.frame, Frame::Orthographic(_))
    }

    /// A vector of the world (glTF's axes) in the camera's space; a point of it by the world's origin.
    pub fn camera_from_world(&self, world: Vec3, origin: Option<Vec3>) -> Vec3 {
        let m = &self.camera;
        match origin {
            Some(origin) => m.vector(world - origin) + m.translation,
            None => m.vector(world),
        }
    }

    /// The other way round.
    pub fn world_from_camera(&self, v: Vec3, origin: Option<Vec3>) -> Vec3 {
        let m = &self.camera;
        let back = |p: Vec3| Vec3::new(m.x.dot(p), m.y.dot(p), m.z.dot(p));
        match origin {
            Some(origin) => back(v - m.translation) + origin,
            None => back(v),
        }
    }

    /// Where a place in the camera's space lies in the picture: 0 to 1 from the left, and from below.
    pub fn window(&self, p: Vec3) -> Vec3 {
        self.frame.at(p)
    }

    /// The size of a pixel, metres, where a ray of a unit direction (glTF's axes) has come so far; the mean of width and height,
    /// as Cycles has it. Towards the edges pixels are smaller: a step e in the plane of perspective pictures turns a direction
    /// d by the part of e across d, times cos θ. Rays that were scattered have the pixel of the middle.
    pub fn pixel_at(&self, direction: Vec3, along: f32, is_scattered: bool) -> f32 {
        let (parallel, angle) = self.pixel;
        if is_scattered || angle == 0.0 {
            return parallel + along * angle;
        }
        let d = self.camera.vector(direction).normalize_or(Vec3::Z);
        let across = |part: f32| (1.0 - part * part).max(0.0).sqrt();
        let share = match self.frame {
            Frame::Perspective(_) => d.z.max(0.0) * 0.5 * (across(d.x) + across(d.y)),
            Frame::Equirectangular(_) => 0.5 * (1.0 + self.pixel_aspect * across(d.y)),
            Frame::Orthographic(_) | Frame::Panorama(..) => 1.0,
        };
        parallel + along * angle * share
    }

    /// How much a pixel in the middle of the picture grows by each metre.
    pub fn pixel_angle(&self) -> f32 {
        self.pixel.1
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
            Projection::Panorama { kind, .. } => (0.0, f64::from(kind.height())),
        };
        let rows = f64::from(rows.max(1));
        let pixel_aspect = match camera.projection {
            Projection::Equirectangular {
                longitude,
                latitude,
            } => (longitude[1] - longitude[0]).abs() / (aspect * (latitude[1] - latitude[0]).abs()),
            _ => 1.0,
        };
        Self {
            camera: Affine::from_f64(&flipped, DVec3::ZERO),
            pixel: ((parallel / rows) as f32, (angle / rows) as f32),
            pixel_aspect: pixel_aspect as f32,
            frame: Frame::new(camera, aspect),
        }
    }
}
