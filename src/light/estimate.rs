//! What an emitter, or a cluster of them, can send to a point at most, and the draw by it.
//! (LightBounds of angles without trigonometry as in Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., §12.6.3.)

use super::lanes::{LANES, Lanes, Lanes3, mask, sin_from_cos};
use crate::math::float::gamma;
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use wide::{CmpGt, CmpLe, CmpLt};

/// An angle of 0 to π. Both are kept, as a sine that is computed from a cosine near 1 has no digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle {
    /// Its sine.
    pub sin: f32,
    /// Its cosine.
    pub cos: f32,
}

impl Angle {
    /// One direction.
    pub const ZERO: Self = Self { sin: 0.0, cos: 1.0 };
    /// All directions.
    pub const ALL: Self = Self {
        sin: 0.0,
        cos: -1.0,
    };

    pub(super) fn radians(self) -> f32 {
        // Most often it is one of these, and an arc tangent takes as long as all else of a union.
        if self == Self::ZERO {
            0.0
        } else {
            self.sin.atan2(self.cos)
        }
    }

    fn from_radians(angle: f32) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { sin, cos }
    }
}

/// What is known of an emitter for its estimate.
#[derive(Clone, Copy, Debug)]
pub struct LightBounds {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
    /// Radiant intensity in the brightest direction (luminance; of less than nothing its size).
    pub intensity: f32,
    /// Middle of the cone of normals.
    pub axis: Vec3,
    /// Half angle of the cone of normals.
    pub normals: Angle,
    /// Cosine of how far beyond its normal an emitter emits (0: a hemisphere; 1: not at all).
    pub cos_emission: f32,
    /// Emits to both sides.
    pub two_sided: bool,
    /// The side of a plane from which alone it can be seen.
    pub front: Option<Front>,
}

/// One side of a plane: its normal, and how far along that it is. (What lies in it, but for rounding, is behind: seen from as
/// near to its plane as that, a light has next to no solid angle.)
#[derive(Clone, Copy, Debug)]
pub struct Front {
    /// Unit normal.
    pub normal: Vec3,
    /// Of a point in the plane, along the normal.
    pub offset: f32,
}

/// A chosen emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Its number.
    pub emitter: u32,
    /// Probability.
    pub probability: f32,
}

/// A ball about a light.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    center: Vec3,
    radius_squared: f32,
}

impl Ball {
    /// Whether a surface of this normal, of unit length, sees nothing of it, by the cone around its middle that Cycles' Light Tree
    /// measures: as wide as the tangent of the radius.
    pub fn is_behind(&self, from: Vec3, normal: Vec3) -> bool {
        let (way, half) = (self.center - from, self.radius_squared);
        let distance = way.length_squared();
        let height = way.dot(normal);
        height <= 0.0 && height <= -(distance * half / (distance + half)).sqrt()
    }
}

impl LightBounds {
    /// Middle of the box.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Half of the box's diagonal.
    fn half(&self) -> Vec3 {
        (self.max - self.min) * 0.5
    }

    /// The ball about the box.
    pub fn ball(&self) -> Ball {
        Ball {
            center: self.center(),
            radius_squared: self.half().length_squared(),
        }
    }

    /// Of two.
    pub fn union(a: &Self, b: &Self) -> Self {
        let (axis, normals) = union_of_cones((a.axis, a.normals), (b.axis, b.normals));
        Self {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
            intensity: a.intensity + b.intensity,
            axis,
            normals,
            cos_emission: a.cos_emission.min(b.cos_emission),
            two_sided: a.two_sided || b.two_sided,
            front: None,
        }
    }
}

/// Cosines of estimates are differences of products of rounded sines: a sine of cosine c near 1 carries
/// an error of √(2·ε) ≈ 5e-4. Whatever lies within that of the bound still counts, so that no
/// light that can arrive has probability 0.
const ANGLE_MARGIN: f32 = 5e-4;

/// By arc tangents: the arc cosine of two axes that differ by a rounding is 0 or 3.5e-4, as it rounds.
fn union_of_cones(a: (Vec3, Angle), b: (Vec3, Angle)) -> (Vec3, Angle) {
    let (a, b) = if a.1.cos <= b.1.cos { (a, b) } else { (b, a) };
    if a.1.cos <= -1.0 {
        return (a.0, Angle::ALL);
    }
    if a.0 == b.0 {
        return a;
    }
    let (ta, tb) = (a.1.radians(), b.1.radians());
    let across = a.0.cross(b.0);
    let between = across.length().atan2(a.0.dot(b.0));
    if between + tb <= ta {
        return a;
    }
    let half = 0.5 * (ta + tb + between);
    if half >= std::f32::consts::PI {
        return (a.0, Angle::ALL);
    }
    let Some(across) = across.try_normalize() else {
        return (a.0, Angle::ALL);
    };
    let (s, c) = (half - ta).sin_cos();
    let middle = (a.0 * c + across.cross(a.0) * s).normalize();
    (middle, Angle::from_radians(half))
}

/// What each candidate that may shine gets at least. An estimate knows nothing of what stands between: a lamp 10⁸ times
/// as strong behind a wall would keep all samples from the one in the room. So the variance is at most 2^10 times
/// that of the light alone, at each draw, and the others' greater by a thousandth for each (defensive importance
/// sampling: Hesterberg, *Weighted Average Importance Sampling and Defensive Mixture Distributions*, 1995).
pub const LEAST_SHARE: f32 = 1.0 / 1024.0;

/// Greater estimates of irradiance count as this one, so that sums of them stay finite: infinity over infinity is no
/// probability.
pub const MOST: f32 = 1e30;

/// Up to [`LANES`] emitters, or clusters of them, between which and others one is chosen. Each number stands in a lane for
/// each.
#[derive(Clone, Copy, Debug)]
pub struct Candidates {
    center: Lanes3,
    half: Lanes3,
    /// |half|² and |half|.
    radius2: Lanes,
    radius: Lanes,
    /// 0 in a lane that is empty.
    intensity: Lanes,
    axis: Lanes3,
    /// How far the box reaches along the axis from its middle.
    reach: Lanes,
    normals_sin: Lanes,
    normals_cos: Lanes,
    cos_emission: Lanes,
    /// Masks: emits to both sides; has normals of all directions; is flat, and emits to one side alone.
    two_sided: Lanes,
    round: Lanes,
    flat: Lanes,
    /// The plane that it can be seen from one side of: all of space is before the plane at minus infinity.
    front_normal: Lanes3,
    front_offset: Lanes,
}

/// cos(max(0, a − b)) from (sine, cosine) of angles in 0..π.
#[inline]
fn cos_of_difference(a: (Lanes, Lanes), b: (Lanes, Lanes)) -> Lanes {
    a.1.cmp_gt(b.1).blend(Lanes::ONE, a.1 * b.1 + a.0 * b.0)
}

/// sin(max(0, a − b)).
#[inline]
fn sin_of_difference(a: (Lanes, Lanes), b: (Lanes, Lanes)) -> Lanes {
    a.1.cmp_gt(b.1).blend(Lanes::ZERO, a.0 * b.1 - a.1 * b.0)
}

impl Candidates {
    /// Of up to [`LANES`].
    pub fn new(bounds: &[LightBounds]) -> Self {
        let empty = LightBounds {
            min: Vec3::ZERO,
            max: Vec3::ZERO,
            intensity: 0.0,
            axis: Vec3::Z,
            normals: Angle::ALL,
            cos_emission: 1.0,
            two_sided: false,
            front: None,
        };
        let all: [LightBounds; LANES] =
            std::array::from_fn(|lane| *bounds.get(lane).unwrap_or(&empty));
        let lanes = |of: fn(&LightBounds) -> f32| Lanes::from(all.each_ref().map(of));
        let vectors = |of: fn(&LightBounds) -> Vec3| Lanes3::of(all.each_ref().map(of));
        let masks = |of: fn(&LightBounds) -> bool| mask(all.each_ref().map(of));
        let (center, half) = (vectors(LightBounds::center), vectors(LightBounds::half));
        Self {
            center,
            half,
            radius2: lanes(|b| b.half().length_squared()),
            radius: lanes(|b| b.half().length()),
            intensity: lanes(|b| b.intensity),
            axis: vectors(|b| b.axis),
            reach: lanes(|b| b.axis.abs().dot(b.half())),
            normals_sin: lanes(|b| b.normals.sin),
            normals_cos: lanes(|b| b.normals.cos),
            cos_emission: lanes(|b| b.cos_emission),
            two_sided: masks(|b| b.two_sided),
            round: masks(|b| b.normals.cos <= -1.0),
            flat: masks(|b| b.normals.cos >= 1.0 && b.cos_emission >= 0.0 && !b.two_sided),
            front_normal: vectors(|b| b.front.map_or(Vec3::ZERO, |front| front.normal)),
            front_offset: lanes(|b| b.front.map_or(f32::NEG_INFINITY, |front| front.offset)),
        }
    }

    /// Estimates of the irradiance that each sends to a point: an upper bound of the angles, the middle for the distance. 0
    /// only where nothing can arrive, at most [`MOST`].
    #[inline]
    pub fn importance(&self, point: Vec3, normal: Option<Vec3>) -> Lanes {
        let margin = Lanes::splat(ANGLE_MARGIN);
        let smallest = Lanes::splat(f32::MIN_POSITIVE);
        let at = Lanes3::splat(point);
        let to = self.center.minus(&at);
        let d2 = to.dot(&to);
        let per_d2 = Lanes::ONE / d2.fast_max(smallest);
        let per_d = per_d2.sqrt();
        // Half the angle of the sphere about the box.
        let sin2 = self.radius2 * per_d2;
        let cos = (Lanes::ONE - sin2).fast_max(Lanes::ZERO).sqrt();
        let sphere = (sin2.sqrt(), cos);

        let along = self.axis.dot(&to);
        let cos_w = -along * per_d;
        let cos_w = self.two_sided.blend(cos_w.abs(), cos_w);
        let w = (sin_from_cos(cos_w), cos_w);
        let normals = (self.normals_sin, self.normals_cos);
        let x = (sin_of_difference(w, normals), cos_of_difference(w, normals));
        let emitted = self.round.blend(Lanes::ONE, cos_of_difference(x, sphere));
        // All are flat and look the other way, by their box: wide sheets of lights, a ceiling or a wall of screens, have
        // everything in the sphere around them, or nearly so. f32 holds cones of normals up to the margin for one direction.
        let averted = self.flat & (self.reach - along).cmp_lt(-margin * (d2.sqrt() + self.radius));
        let unlit = averted | self.front_normal.dot(&at).cmp_le(self.front_offset);
        let turned = emitted.cmp_le(self.cos_emission - margin) & !self.round;

        let (mut below, mut sunken, mut received) = (Lanes::ZERO, Lanes::ZERO, Lanes::ONE);
        if let Some(normal) = normal {
            let (n, across) = (Lanes3::splat(normal), Lanes3::splat(normal.abs()));
            let (height, reach) = (n.dot(&to), across.dot(&self.half));
            let size = across.dot(&Lanes3(to.0.map(Lanes::abs))) + reach;
            // Below the surface's horizon, by the box. Three differences, three products, two sums.
            below = (height + reach).cmp_lt(Lanes::splat(-gamma(8)) * size);
            let cos_i = height * per_d;
            received = cos_of_difference((sin_from_cos(cos_i), cos_i), sphere);
            sunken = received.cmp_le(-margin);
        }
        let outside =
            self.intensity * emitted.fast_max(margin) * received.fast_max(margin) * per_d2;
        // Inside the bounds all is possible, and the distance is of the size of the bounds.
        let inside = self.intensity / d2.fast_max(self.radius2).fast_max(smallest);
        let is_inside = d2.cmp_le(self.radius2 * Lanes::splat(1.0 + 1e-5));
        let estimate = is_inside
            .blend(inside, (turned | sunken).blend(Lanes::ZERO, outside))
            .fast_min(Lanes::splat(MOST));
        (unlit | below | self.intensity.cmp_le(Lanes::ZERO)).blend(Lanes::ZERO, estimate)
    }
}

/// Probabilities of candidates at a point, by their estimates and a little of it evenly ([`LEAST_SHARE`]) among those that may
/// shine there. As many `shares` as `groups`; they sum to 1 within γ(n + 4) for n candidates, or are 0 as nothing arrives.
/// Gives the sum of the estimates.
#[inline]
pub fn weigh(
    groups: &[Candidates],
    (point, normal): (Vec3, Option<Vec3>),
    shares: &mut [[f32; LANES]],
) -> f32 {
    let (mut sum, mut shining) = (0.0, 0.0);
    for (shares, group) in shares.iter_mut().zip(groups) {
        let estimates = group.importance(point, normal);
        *shares = estimates.to_array();
        // Not by `reduce_add`, whose order hangs on the processor, and with it the bits.
        let [a, b, c, d, e, f, g, h] = *shares;
        sum += ((a + e) + (c + g)) + ((b + f) + (d + h));
        shining += estimates.cmp_gt(Lanes::ZERO).move_mask().count_ones() as f32;
    }
    if sum > 0.0 {
        let scale = Lanes::splat((1.0 - shining * LEAST_SHARE) / sum);
        for shares in shares.iter_mut().take(groups.len()) {
            let estimates = Lanes::from(*shares);
            let share = estimates * scale + Lanes::splat(LEAST_SHARE);
            *shares = (share & estimates.cmp_gt(Lanes::ZERO)).to_array();
        }
    }
    sum
}

/// The share that a number of 0 to 1 falls to, and where in it (0 to 1, for further draws).
#[inline]
pub fn draw(shares: &[[f32; LANES]], mut u: f64) -> Option<(usize, f64)> {
    let mut last = None;
    for (at, &share) in shares.as_flattened().iter().enumerate() {
        if share > 0.0 {
            let share = f64::from(share);
            if u < share {
                return Some((at, u / share));
            }
            u -= share;
            last = Some(at);
        }
    }
    // The last one where rounding left a crumb of u.
    last.map(|at| (at, 1.0 - f64::EPSILON / 2.0))
}

/// Surface area and orientation measure of bounds (Conty Estevez and Kulla, eq. 1).
pub fn measure(b: &LightBounds) -> f32 {
    let d = b.max - b.min;
    let area = (d.x * d.y + d.y * d.z + d.z * d.x).max(d.length_squared() * 1e-3);
    b.intensity * area * orientation(b.normals, b.cos_emission).max(1e-3)
}

/// The second factor of that: the solid angle of what is emitted to, weighted by cosines beyond the normals.
fn orientation(normals: Angle, cos_emission: f32) -> f32 {
    let Angle { sin, cos } = normals;
    if cos_emission == 0.0 && cos >= 0.0 {
        // Emission by a hemisphere from normals within one: no angle is left in the formula.
        return PI * (2.0 - cos + FRAC_PI_2 * sin);
    }
    let o = normals.radians();
    let w = (o + cos_emission.clamp(-1.0, 1.0).acos()).min(PI);
    TAU * (1.0 - cos) + FRAC_PI_2 * (2.0 * w * sin - (o - 2.0 * w).cos() - 2.0 * o * sin + cos)
}

#[cfg(test)]
#[path = "../../tests/unit/light/estimate.rs"]
mod tests;
