//! Phase functions, each sampled exactly. A cosine of 1 is straight on.

use super::Medium;
use super::particles::{Draine, FournierForand};
use crate::math::frame::Frame;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// How light is spread by a scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// Henyey and Greenstein 1941, of a mean cosine.
    HenyeyGreenstein(f32),
    /// Of particles smaller than the wavelength: 3/(16π)(1 + cos²).
    Rayleigh,
    /// Of dust, and the greater part of droplets.
    Draine(Draine),
    /// Of what floats in water.
    FournierForand(FournierForand),
}

/// A phase function with what it scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Scattering coefficient, 1/m.
    pub coefficient: Vec3,
    /// Where to.
    pub phase: Phase,
}

/// Below it Henyey and Greenstein's inversion cancels, and the function is even within 3e-3, as in Cycles.
const EVEN_G: f32 = 1e-3;

impl Phase {
    /// The density of a cosine by solid angle: it is the value, too.
    pub fn density(self, cos: f32) -> f32 {
        match self {
            Self::HenyeyGreenstein(g) if g.abs() < EVEN_G => 0.25 * FRAC_1_PI,
            Self::HenyeyGreenstein(g) if g < 0.0 => Self::HenyeyGreenstein(-g).density(-cos),
            Self::HenyeyGreenstein(g) => {
                // (1 − g)² + 2g(1 − cos): what 1 + g² − 2g cos is, without cancellation.
                let d = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos);
                let d = d.max(f32::MIN_POSITIVE);
                0.25 * FRAC_1_PI * (1.0 - g) * (1.0 + g) / (d * d.sqrt())
            }
            Self::Rayleigh => 3.0 / 16.0 * FRAC_1_PI * (1.0 + cos * cos),
            Self::Draine(dust) => dust.density(f64::from(cos)) as f32,
            Self::FournierForand(floating) => floating.density(f64::from(cos)) as f32,
        }
    }

    /// Draws a direction to go on in.
    pub(super) fn turned(self, direction: Vec3, u: f32, turn: f32) -> Vec3 {
        turned(direction, self.cosine(u), turn)
    }

    fn width(self) -> f32 {
        match self {
            Self::HenyeyGreenstein(g) => 1.0 - g.abs(),
            Self::Draine(dust) => 1.0 - dust.g.abs(),
            Self::Rayleigh => 1.0,
            Self::FournierForand(_) => 0.0,
        }
    }

    /// Draws a cosine.
    fn cosine(self, u: f32) -> f32 {
        match self {
            Self::HenyeyGreenstein(g) if g.abs() < EVEN_G => 1.0 - 2.0 * u,
            Self::HenyeyGreenstein(g) if g < 0.0 => -Self::HenyeyGreenstein(-g).cosine(u),
            Self::HenyeyGreenstein(g) => {
                let k = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
                ((1.0 + g * g - k * k) / (2.0 * g)).clamp(-1.0, 1.0)
            }
            // The root of c³ + 3c = 8u − 4 (Frisvad 2011).
            Self::Rayleigh => {
                let v = 4.0 * u - 2.0;
                let a = (v.abs() + (v * v + 1.0).sqrt()).cbrt();
                ((a - 1.0 / a).copysign(v)).clamp(-1.0, 1.0)
            }
            Self::Draine(dust) => dust.cosine(f64::from(u)) as f32,
            Self::FournierForand(floating) => floating.cosine(f64::from(u)) as f32,
        }
    }
}

impl Medium {
    /// The phase function of all lobes by channel, of what is scattered there, and the density of [`Self::scatter`].
    pub fn phase(&self, cos: f32) -> (Vec3, f32) {
        let (mut value, mut pdf, mut all) = (Vec3::ZERO, 0.0, 0.0);
        for Lobe { coefficient, phase } in &self.lobes {
            let density = phase.density(cos);
            let share = coefficient.element_sum();
            value += *coefficient * density;
            pdf += share * density;
            all += share;
        }
        let scattering = self.scattering.max(Vec3::splat(f32::MIN_POSITIVE));
        (value / scattering, if all > 0.0 { pdf / all } else { 0.0 })
    }

    /// How widely it scatters, 0 to 1: 1 less the mean cosine's magnitude, as Cycles has that.
    pub fn phase_width(&self) -> f32 {
        let (mut sum, mut all) = (0.0, 0.0);
        for Lobe { coefficient, phase } in &self.lobes {
            let share = coefficient.element_sum();
            sum += share * phase.width();
            all += share;
        }
        if all > 0.0 { sum / all } else { 1.0 }
    }

    /// Draws a direction to go on in.
    pub fn scatter(&self, direction: Vec3, u: Vec3) -> Vec3 {
        let all: f32 = self.lobes.iter().map(|l| l.coefficient.element_sum()).sum();
        let mut left = u.z * all;
        let chosen = self.lobes.iter().find(|lobe| {
            left -= lobe.coefficient.element_sum();
            left < 0.0
        });
        let phase = chosen.or(self.lobes.last()).map(|lobe| lobe.phase);
        let cos = phase.unwrap_or(Phase::HenyeyGreenstein(0.0)).cosine(u.x);
        turned(direction, cos, u.y)
    }
}

/// A direction of a cosine to another.
pub(super) fn turned(direction: Vec3, cos: f32, u: f32) -> Vec3 {
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    about(direction, (sin, cos), u)
}

/// A direction of a sine and a cosine to another: near that the cosine alone tells too little.
pub(super) fn about(direction: Vec3, (sin, cos): (f32, f32), u: f32) -> Vec3 {
    let around = Vec2::from_angle(TAU * u) * sin;
    let frame = Frame::from_normal(direction);
    frame.to_world(around.extend(cos)).normalize()
}
