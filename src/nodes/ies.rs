//! Blender's IES Texture: how strongly a luminaire shines, by direction, as Cycles interpolates the measured values.

use super::CyclesVersion;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// The values of a file, made ready: about the axis, and from it.
#[derive(Clone, Debug, PartialEq)]
pub struct IesProfile {
    /// Angles about the axis, radians, rising; at least two.
    pub around: Vec<f32>,
    /// Angles from the axis, radians, rising; at least two.
    pub down: Vec<f32>,
    /// For each of the first, values at all of the second.
    pub strengths: Vec<f32>,
    /// What the curves go through beyond the first and the last angle.
    pub beyond: Beyond,
}

/// Values beyond the angles that were measured, where the angles do not go all around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// The value there again, as in Cycles from 5.0 on.
    Same,
    /// 0, as before.
    Zero,
}

impl Beyond {
    /// Of a version.
    pub fn of(version: CyclesVersion) -> Self {
        if version < CyclesVersion::new(5, 0) {
            Self::Zero
        } else {
            Self::Same
        }
    }

    fn of_value(self, value: f32) -> f32 {
        match self {
            Self::Same => value,
            Self::Zero => 0.0,
        }
    }
}

/// Between the second and the third of four values, through which the curve goes (Catmull and Rom).
fn cubic([a, b, c, d]: [f32; 4], x: f32) -> f32 {
    0.5 * (((d + 3.0 * (b - c) - a) * x + (2.0 * a - 5.0 * b + 4.0 * c - d)) * x + (c - a)) * x + b
}

/// Nearer to an end than this, angles are taken for it.
const CLOSE: f32 = 1e-7;

/// The interval that an angle lies in, and where; `None` outside of all.
fn interval(angles: &[f32], angle: f32) -> Option<(usize, f32)> {
    let (first, last) = (*angles.first()?, *angles.last()?);
    if angle < first || angle >= last {
        return None;
    }
    let i = angles
        .partition_point(|&a| a < angle)
        .clamp(1, angles.len() - 1)
        - 1;
    let width = angles[i + 1] - angles[i];
    Some((
        i,
        if width > 0.0 {
            (angle - angles[i]) / width
        } else {
            0.0
        },
    ))
}

impl IesProfile {
    /// Whether its numbers fit together.
    pub fn is_sane(&self) -> bool {
        let rises = |angles: &[f32]| angles.len() >= 2 && angles.windows(2).all(|w| w[0] <= w[1]);
        rises(&self.around)
            && rises(&self.down)
            && self.strengths.len() == self.around.len() * self.down.len()
            && self.strengths.iter().all(|s| s.is_finite())
    }

    /// The strength toward a direction, seen from the luminaire, whose axis is −Z.
    pub fn of(&self, direction: Vec3) -> f32 {
        let d = direction.normalize_or_zero();
        let (around, down) = (d.x.atan2(d.y) + PI, (-d.z).clamp(-1.0, 1.0).acos());
        let (Some((v, s)), Some((h, t))) =
            (interval(&self.down, down), interval(&self.around, around))
        else {
            return 0.0;
        };
        let (last_h, last_v) = (self.around.len() - 1, self.down.len() - 1);
        let begins = self.down[0] < CLOSE;
        let ends = self.down[last_v] > PI - CLOSE;
        let is_closed = self.around[0] < CLOSE && self.around[last_h] > TAU - CLOSE;
        let column = |h: usize| {
            let at = |v: usize| self.strengths[h * (last_v + 1) + v];
            let (b, c) = (at(v), at(v + 1));
            // Beyond a pole comes what is before it.
            let a = match v {
                0 if begins => at(1),
                0 => self.beyond.of_value(b),
                _ => at(v - 1),
            };
            let d = match last_v - v {
                1 if ends => at(last_v - 1),
                1 => self.beyond.of_value(c),
                _ => at(v + 2),
            };
            cubic([a, b, c, d], s)
        };
        let (b, c) = (column(h), column(h + 1));
        // The last column is the first one again.
        let a = match h {
            0 if is_closed => column(last_h - 1),
            0 => self.beyond.of_value(b),
            _ => column(h - 1),
        };
        let d = match last_h - h {
            1 if is_closed => column(1),
            // Cycles takes the second one here.
            1 => self.beyond.of_value(b),
            _ => column(h + 2),
        };
        cubic([a, b, c, d], t).max(0.0)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/nodes/ies.rs"]
mod tests;
