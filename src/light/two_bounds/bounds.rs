//! What a light, or a cluster of them, gives to a place at most and at least, as Cycles' Light Tree estimates it.

use super::{Emitter, Receiver, Shape};
use crate::light::estimate::MOST;
use crate::math::{sqr, warp};
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI, SQRT_2, TAU};

/// The most and the least that something gives to a place.
pub type Bounds = (f32, f32);

const NOTHING: Bounds = (0.0, 0.0);

/// Two axes that differ by less, in radians, are one.
const SAME_CONE: f32 = 5e-4;
/// Axes whose cosine is below this are opposite: any direction across them is between both.
const OPPOSITE: f32 = -0.9995;

/// Directions in which a cluster shines: normals within an angle of an axis, and light within another one of the normals.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    pub(super) axis: Vec3,
    pub(super) normals: f32,
    pub(super) emission: f32,
    /// Sine and cosine of the angle of the normals.
    pub(super) sin: f32,
    pub(super) cos: f32,
    /// Cosine of both angles together; −1 from π on.
    pub(super) cos_all: f32,
    /// Cosine of the light beyond the normals' angle; above 1 where there is none.
    pub(super) cos_beyond: f32,
}

impl Cone {
    /// By its axis and angles.
    pub fn new(axis: Vec3, normals: f32, emission: f32) -> Self {
        let (sin, cos) = normals.sin_cos();
        Self {
            axis,
            normals,
            emission,
            sin,
            cos,
            cos_all: if normals + emission > PI {
                -1.0
            } else {
                (normals + emission).cos()
            },
            cos_beyond: if emission < normals {
                2.0
            } else {
                (emission - normals).cos()
            },
        }
    }

    /// Of a light.
    pub fn of(emitter: &Emitter, measure: &Measure) -> Self {
        match emitter.shape {
            // It shines to every place from its middle.
            Shape::Lamp { cone: None, .. } => Self::new(Vec3::Y, 0.0, FRAC_PI_2),
            _ => measure.cone(),
        }
    }

    /// The same angles about another axis.
    fn about(self, axis: Vec3) -> Self {
        Self { axis, ..self }
    }
}

/// What is known of a cluster.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Lower corner of the box about it.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
    axis: Vec3,
    normals: f32,
    emission: f32,
    pub(super) energy: f32,
}

impl Measure {
    /// Of nothing.
    pub const NONE: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
        axis: Vec3::ZERO,
        normals: 0.0,
        emission: 0.0,
        energy: 0.0,
    };

    /// Of a light.
    pub fn of(emitter: &Emitter) -> Self {
        let at = |points: &[Vec3], (axis, normals, emission)| {
            let low = |low: Vec3, p: &Vec3| low.min(*p);
            let high = |high: Vec3, p: &Vec3| high.max(*p);
            Self {
                min: points.iter().fold(Vec3::INFINITY, low),
                max: points.iter().fold(Vec3::NEG_INFINITY, high),
                axis,
                normals,
                emission,
                energy: emitter.energy,
            }
        };
        match emitter.shape {
            Shape::Lamp {
                center,
                radius,
                cone,
                ..
            } => {
                let about = match cone {
                    Some((axis, half, _)) => (axis, 0.0, half.min(FRAC_PI_2)),
                    None => (Vec3::Y, PI, FRAC_PI_2),
                };
                at(&[center - radius, center + radius], about)
            }
            Shape::Area {
                center,
                normal,
                edges: [u, v],
                spread,
            } => {
                let corners = [u + v, u - v, v - u, -u - v].map(|c| center + c * 0.5);
                at(&corners, (normal, 0.0, spread))
            }
            Shape::Triangle(corners) => at(&corners, both_sides(&corners)),
            Shape::Rectangle(corners) => at(&corners, both_sides(&corners)),
            Shape::Sun(toward, half) => at(&[], (-toward, 0.0, half)),
            Shape::World => at(&[], (Vec3::Y, PI, 0.0)),
        }
    }

    /// Of two together.
    pub fn and(&self, other: &Self) -> Self {
        if other.energy == 0.0 {
            return *self;
        }
        let (axis, normals, emission) = union(
            (self.axis, self.normals, self.emission),
            (other.axis, other.normals, other.emission),
        );
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            axis,
            normals,
            emission,
            energy: self.energy + other.energy,
        }
    }

    /// Its directions.
    pub fn cone(&self) -> Cone {
        Cone::new(self.axis, self.normals, self.emission)
    }

    /// What a cluster costs: energy, times surface (or length, where it has none), times the directions in which it shines.
    pub fn cost(&self) -> f32 {
        if self.energy == 0.0 {
            return 0.0;
        }
        let d = self.max - self.min;
        let surface = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x);
        let size = if surface == 0.0 { d.length() } else { surface };
        self.energy * size * self.directions()
    }

    fn directions(&self) -> f32 {
        let o = self.normals;
        let w = (o + self.emission).min(PI);
        let (sin, cos) = o.sin_cos();
        TAU * (1.0 - cos) + FRAC_PI_2 * (2.0 * w * sin - (o - 2.0 * w).cos() - 2.0 * o * sin + cos)
    }

    /// What the cluster gives to a place. `cone`: its own; `is_distant`: at infinity.
    pub fn bounds(&self, cone: &Cone, is_distant: bool, at: &Receiver) -> Bounds {
        if is_distant {
            let seen = Seen {
                toward: -self.axis,
                cos: (self.normals + self.emission).cos(),
                far: 1.0,
                near: 1.0,
            };
            return seen.bounds(cone, self.energy, at);
        }
        let center = 0.5 * (self.min + self.max);
        let half = self.max - center;
        let to = center - at.point;
        if let Some(normal) = at.normal
            && !at.both
            && normal.dot(to) + normal.abs().dot(half.abs()) <= 0.0
        {
            return NOTHING;
        }
        let (d2, r2) = (to.length_squared(), half.length_squared());
        let distance = d2.sqrt().max(0.5 * r2.sqrt());
        let seen = Seen {
            toward: to.normalize_or_zero(),
            cos: if d2 <= r2 {
                -1.0
            } else {
                cos_from_sin2(r2 / d2)
            },
            far: distance,
            near: distance,
        };
        seen.bounds(cone, self.energy, at)
    }
}

/// Directions of what shines to both sides of a plane: from any axis in it.
fn both_sides(corners: &[Vec3]) -> (Vec3, f32, f32) {
    let axis = (corners[0] - corners[1]).normalize_or_zero();
    (axis, FRAC_PI_2, FRAC_PI_2)
}

/// Directions of two, by axes and angles.
fn union(a: (Vec3, f32, f32), b: (Vec3, f32, f32)) -> (Vec3, f32, f32) {
    if a.0 == Vec3::ZERO {
        return b;
    }
    if b.0 == Vec3::ZERO {
        return a;
    }
    let (a, b) = if b.1 > a.1 { (b, a) } else { (a, b) };
    let cos = a.0.dot(b.0);
    let between = cos.clamp(-1.0, 1.0).acos();
    let emission = a.2.max(b.2);
    if a.1 + SAME_CONE >= (between + b.1).min(PI) {
        return (a.0, a.1, emission);
    }
    let half = 0.5 * (between + a.1 + b.1);
    if half >= PI {
        return (a.0, PI, emission);
    }
    let axis = if cos < OPPOSITE {
        a.0.any_orthonormal_vector()
    } else {
        let across = (b.0 - a.0 * cos).normalize_or_zero();
        let (sin, cos) = (half - a.1).sin_cos();
        a.0 * cos + across * sin
    };
    (axis, half, emission)
}

/// What a light gives to a place. `cone`: its own.
pub fn bounds_of(emitter: &Emitter, cone: &Cone, at: &Receiver) -> Bounds {
    let seen = |center: Vec3| {
        let to = center - at.point;
        let distance = to.length();
        Seen {
            toward: if distance > 0.0 {
                to / distance
            } else {
                Vec3::ZERO
            },
            cos: f32::INFINITY,
            far: distance,
            near: distance,
        }
    };
    match emitter.shape {
        Shape::Lamp {
            center,
            radius,
            is_sphere,
            cone: spot,
        } => {
            let seen = seen(center).of_lamp(radius, is_sphere);
            match spot {
                None => seen.bounds(&cone.about(-seen.toward), emitter.energy, at),
                Some((axis, half, steepness)) => {
                    let angle = |cos: f32| cos.clamp(-1.0, 1.0).acos();
                    let least = (angle(axis.dot(-seen.toward)) - angle(seen.cos)).max(0.0);
                    let inside = least.cos() - half.min(FRAC_PI_2).cos();
                    let share = if steepness.is_finite() {
                        warp::smoothstep(inside * steepness)
                    } else {
                        f32::from(inside > 0.0)
                    };
                    seen.bounds(cone, emitter.energy * share, at)
                }
            }
        }
        Shape::Area {
            center,
            normal,
            edges: [u, v],
            ..
        } => {
            let corners = [u + v, u - v, v - u, -u - v].map(|c| center + c * 0.5);
            let seen = seen(center).with_corners(&corners, at.point);
            let above = |n: Vec3| n.dot(center - at.point) + n.dot(u).abs() + n.dot(v).abs() > 0.0;
            let shines = normal.dot(seen.toward) < 0.0 && at.normal.is_none_or(above);
            if !at.both && !shines {
                return NOTHING;
            }
            seen.bounds(cone, emitter.energy, at)
        }
        Shape::Triangle(corners) => {
            let seen = seen((corners[0] + corners[1] + corners[2]) / 3.0);
            seen.of_surface(&corners, (emitter.energy, cone), at)
        }
        Shape::Rectangle(corners) => {
            let seen = seen(corners.iter().sum::<Vec3>() / 4.0);
            seen.of_surface(&corners, (emitter.energy, cone), at)
        }
        Shape::Sun(toward, half) => {
            let cos = half.cos();
            let seen = Seen {
                toward,
                cos,
                far: 1.0 / cos,
                near: 1.0,
            };
            seen.bounds(cone, emitter.energy, at)
        }
        Shape::World => {
            let seen = Seen {
                toward: -Vec3::Y,
                cos: -1.0,
                far: 1.0,
                near: 1.0,
            };
            seen.bounds(&cone.about(-Vec3::Y), emitter.energy, at)
        }
    }
}

/// How something is seen from a place.
struct Seen {
    /// The direction to its middle.
    toward: Vec3,
    /// Cosine of the half angle that it fills.
    cos: f32,
    /// The greatest and the smallest distance.
    far: f32,
    near: f32,
}

impl Seen {
    fn of_lamp(self, radius: f32, is_sphere: bool) -> Self {
        let distance = self.near;
        if !is_sphere {
            let far = (sqr(radius) + sqr(distance)).sqrt();
            let cos = if far > 0.0 { distance / far } else { 1.0 };
            return Self { cos, far, ..self };
        }
        if distance > radius {
            let cos = cos_from_sin2(sqr(radius / distance));
            let far = distance / cos;
            return Self { cos, far, ..self };
        }
        // Within it shines from all around.
        let distance = radius / SQRT_2;
        Self {
            cos: -1.0,
            far: distance,
            near: distance,
            ..self
        }
    }

    fn with_corners(self, corners: &[Vec3], from: Vec3) -> Self {
        corners.iter().fold(self, |seen, corner| {
            let to = *corner - from;
            let distance = to.length();
            let cos = seen.toward.dot(to) / distance;
            Self {
                cos: if distance > 0.0 {
                    seen.cos.min(cos)
                } else {
                    0.0
                },
                far: seen.far.max(distance),
                ..seen
            }
        })
    }

    fn of_surface(self, corners: &[Vec3], of: (f32, &Cone), at: &Receiver) -> Bounds {
        let above = |n: Vec3| corners.iter().any(|c| n.dot(*c - at.point) > 0.0);
        if !at.both && !at.normal.is_none_or(above) {
            return NOTHING;
        }
        self.with_corners(corners, at.point).bounds(of.1, of.0, at)
    }

    fn bounds(&self, cone: &Cone, energy: f32, at: &Receiver) -> Bounds {
        let (cos_u, sin_u) = (self.cos, sin_from_cos(self.cos));
        let (mut received, mut received_least) = (1.0, 1.0);
        if let Some(normal) = at.normal {
            let cos = normal.dot(self.toward);
            let cos = if at.both { cos.abs() } else { cos };
            let sin = sin_from_cos(cos);
            if cos < cos_u {
                received = cos * cos_u + sin * sin_u;
            }
            if !at.both && received < 0.0 {
                return NOTHING;
            }
            received_least = (cos * cos_u - sin * sin_u).max(0.0);
        }
        // Rounding would turn the one direction away from itself.
        let cos = if cone.axis == -self.toward {
            1.0
        } else {
            cone.axis.dot(-self.toward)
        };
        let sin = sin_from_cos(cos);
        let minus = cos * cos_u + sin * sin_u;
        let emitted = if cos >= cos_u || minus >= cone.cos {
            1.0
        } else if cone.normals + cone.emission > PI || minus > cone.cos_all {
            minus * cone.cos + sin_from_cos(minus) * cone.sin
        } else {
            return NOTHING;
        };
        let most = (received * energy * emitted / sqr(self.near))
            .abs()
            .min(MOST);
        let plus = cos * cos_u - sin * sin_u;
        let seen_at_most = cos < 0.0 || cos_u < 0.0 || plus < cone.cos_beyond;
        if seen_at_most {
            return (most, 0.0);
        }
        let emitted_least = plus * cone.cos - sin_from_cos(plus) * cone.sin;
        let least = (received_least * energy * emitted_least / sqr(self.far)).abs();
        (most, least.min(MOST))
    }
}

fn sin_from_cos(cos: f32) -> f32 {
    (1.0 - sqr(cos)).max(0.0).sqrt()
}

fn cos_from_sin2(sin2: f32) -> f32 {
    (1.0 - sin2).max(0.0).sqrt()
}
