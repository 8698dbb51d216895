//! Fibres by the ways of light through them: Chiang, Bitterli, Tappan and Burley, *A Practical and Controllable Hair and Fur Model
//! for Production Path Tracing*, 2016 (sections 3 and 4); Blender's Principled Hair BSDF of that model.
//!
//! Light is reflected (R), goes through (TT), is reflected inside (TRT) or goes on inside more often. Each way has a spread along the
//! fibre (d'Eon et al., *An Energy-Conserving Hair Reflectance Model*, 2011, eq. 7) and one around it, each of integral 1, so that a
//! fibre that absorbs nothing gives back all. All of the value is of the model: it has the cosine already.

use super::{LobeSample, LobeValue};
use crate::math::{Frame, luminance, sqr};
use crate::shading::fresnel;
use glam::{Vec2, Vec3, Vec3Swizzles};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// A fibre's numbers.
#[derive(Clone, Copy, Debug)]
pub struct Fibre {
    /// What it absorbs on a radius of way.
    pub absorption: Vec3,
    /// Roughness along it and around it, 0.001 to 1.
    pub roughness: Vec2,
    /// What the first reflection's roughness is of that, 0 to 1.
    pub first: f32,
    /// Tilt of the scales, radians, toward the root.
    pub tilt: f32,
    /// Index of refraction.
    pub ior: f32,
}

/// Ways of light that are told apart: R, TT, TRT, and all others.
const WAYS: usize = 4;

/// A fibre, as a view sees it.
#[derive(Clone, Copy, Debug)]
pub struct Chiang {
    /// Weight of the lobe.
    pub(super) weight: Vec3,
    /// x along the fibre, z away from the view.
    frame: Frame,
    /// Share of light on each way.
    shares: [Vec3; WAYS],
    /// Probability of each.
    chances: [f32; WAYS],
    /// Variances along the fibre: of R, TT, and of the others.
    variances: Vec3,
    /// Scale of the spread around it.
    scale: f32,
    /// Sine and cosine of the view's lean by way, as tilted scales have it; the last stands for no tilt.
    leans: [Vec2; WAYS],
    /// Turn around the fibre by way.
    turns: [f32; WAYS - 1],
    /// What denoisers and passes take for its colour.
    albedo: Vec3,
    /// Light that is sampled does not reach it on one side of its frame, as in Cycles on meshes from 5.0 on.
    masked: bool,
}

/// A number to a power, 20 or 22.
fn steep(x: f32, power: i32) -> f32 {
    x.powi(power)
}

/// The variance along the fibre of a roughness: eq. 7 of the paper.
fn variance(roughness: f32) -> f32 {
    let r = roughness;
    sqr(0.726 * r + 0.812 * r * r + 3.7 * steep(r, 20))
}

/// The scale of the logistic distribution around the fibre of a roughness: eq. 8 of the paper.
fn scale(roughness: f32) -> f32 {
    let r = roughness;
    (0.265 * r + 1.194 * r * r + 5.372 * steep(r, 22)) * (PI / 8.0).sqrt()
}

/// ln(I₀(x) e⁻ˣ) for x ≥ 0: Abramowitz and Stegun, *Handbook of Mathematical Functions*, 9.8.1 and 9.8.2, within 2e-7.
fn ln_bessel_i0_scaled(x: f32) -> f32 {
    let polynomial = |t: f32, c: &[f32]| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if x < 3.75 {
        let c = [
            1.0,
            3.515_623,
            3.089_942_5,
            1.206_749_2,
            0.265_973_2,
            0.036_076_8,
            0.004_581_3,
        ];
        return polynomial(sqr(x / 3.75), &c).ln() - x;
    }
    let c = [
        0.398_942_3,
        0.013_285_92,
        0.002_253_19,
        -0.001_575_65,
        0.009_162_81,
        -0.020_577_06,
        0.026_355_37,
        -0.016_476_33,
        0.003_923_77,
    ];
    polynomial(3.75 / x, &c).ln() - 0.5 * x.ln()
}

/// The spread along a fibre of a variance, for sines and cosines of two leans: a bound of the cosine's that is exact as both come
/// together, where the difference of products would cancel.
pub(super) fn along(a: Vec2, b: Vec2, variance: f32) -> f32 {
    let apart = 0.5 * (sqr(a.y - b.y) + sqr(a.x + b.x));
    let bessel = ln_bessel_i0_scaled(a.y * b.y / variance);
    let norm = variance * -(-2.0 / variance).exp_m1();
    (bessel - apart / variance).exp() / norm
}

/// Draws the sine of a lean from it.
pub(super) fn draw_along(view: Vec2, variance: f32, u: Vec2) -> f32 {
    let u1 = u.x.max(1e-5);
    let cos = 1.0 + variance * (u1 + (1.0 - u1) * (-2.0 / variance).exp()).ln();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    (-cos * view.x + sin * (TAU * u.y).cos() * view.y).clamp(-1.0, 1.0)
}

/// Share of the logistic distribution below −π.
fn tail(scale: f32) -> f32 {
    1.0 / (1.0 + (PI / scale).exp())
}

/// The logistic distribution between −π and π.
fn around(turn: f32, scale: f32) -> f32 {
    let e = (-turn.abs() / scale).exp();
    e / (scale * sqr(1.0 + e)) / (1.0 - 2.0 * tail(scale))
}

/// Draws from it.
fn draw_around(u: f32, scale: f32) -> f32 {
    let tail = tail(scale);
    let share = u * (1.0 - 2.0 * tail) + tail;
    (-scale * (1.0 / share - 1.0).ln()).clamp(-PI, PI)
}

/// An angle brought to −π to π.
fn wrapped(turn: f32) -> f32 {
    (turn + PI).rem_euclid(TAU) - PI
}

/// Sine and cosine of an angle plus another, the cosine kept positive.
fn plus(a: Vec2, b: Vec2) -> Vec2 {
    Vec2::new(a.x * b.y + a.y * b.x, (a.y * b.y - a.x * b.x).abs())
}

fn cosine(sine: f32) -> f32 {
    (1.0 - sine * sine).max(0.0).sqrt()
}

/// Share of light on each way, by the reflectance of the boundary and what is left after a way through (section 3.2).
fn attenuation(reflected: f32, left: Vec3) -> [Vec3; WAYS] {
    let through = left * sqr(1.0 - reflected);
    let back = through * left * reflected;
    let further = left * reflected;
    let rest = (Vec3::ONE - further).max(Vec3::splat(f32::MIN_POSITIVE));
    [Vec3::splat(reflected), through, back, back * further / rest]
}

/// Of which colour much hair is that absorbs, in one number for its roughness around (eq. 9).
pub fn color_scale(roughness: f32) -> f32 {
    let x = roughness;
    (((((0.245 * x) + 5.574) * x - 10.73) * x + 2.532) * x - 0.215) * x + 5.969
}

impl Chiang {
    /// For a view, with the least variance that the path wants, at a place with a `tangent` along the fibre, a geometric normal and
    /// an offset across the fibre, if that is flat.
    pub fn new(
        weight: Vec3,
        of: &Fibre,
        (tangent, geometric, across): (Vec3, Vec3, f32),
        wo: Vec3,
        (least, masked): (f32, bool),
    ) -> Self {
        let frame = frame(tangent, wo);
        let h = if across != 0.0 {
            -across
        } else {
            geometric.cross(frame.x).dot(frame.z).clamp(-1.0, 1.0)
        };
        let local = frame.to_local(wo);
        let view = Vec2::new(local.x, local.yz().length());
        let eta = of.ior;
        let cos_t = cosine(view.x / eta);
        let within = (eta * eta - sqr(view.x)).max(f32::MIN_POSITIVE).sqrt();
        let sin_gamma = (h * view.y / within).clamp(-1.0, 1.0);
        let (gamma, gamma_t) = (h.asin(), sin_gamma.asin());
        let way = 2.0 * cosine(sin_gamma) / cos_t.max(1e-6);
        let left = (-of.absorption * way).exp();
        let reflected = fresnel::dielectric(view.y * cosine(h), eta).reflectance;
        let shares = attenuation(reflected, left);
        let energies = shares.map(luminance);
        let all: f32 = energies.iter().sum();
        let rough = of.roughness.clamp(Vec2::splat(0.001), Vec2::ONE);
        let v = variance(rough.x).max(least);
        let first = variance((of.first * rough.x).clamp(0.001, 1.0)).max(least);
        let tilt = Vec2::new(of.tilt.sin(), of.tilt.cos());
        let twice = Vec2::new(2.0 * tilt.x * tilt.y, sqr(tilt.y) - sqr(tilt.x));
        let four = Vec2::new(2.0 * twice.x * twice.y, sqr(twice.y) - sqr(twice.x));
        let back = |angle: Vec2| Vec2::new(-angle.x, angle.y);
        Self {
            weight,
            frame,
            shares,
            chances: energies.map(|e| if all > 0.0 { e / all } else { 0.25 }),
            variances: Vec3::new(first, 0.25 * v, 4.0 * v),
            scale: scale(rough.y).max(least),
            leans: [
                plus(view, back(twice)),
                plus(view, tilt),
                plus(view, four),
                view,
            ],
            turns: [0.0, 1.0, 2.0].map(|p| 2.0 * p * gamma_t - 2.0 * gamma + p * PI),
            // As Cycles estimates it, by the variance in the place of the roughness around.
            albedo: (of.absorption.map(f32::sqrt) * -color_scale(v)).exp() + Vec3::splat(reflected),
            masked,
        }
    }

    /// Whether light of the view's lean gets into a fibre of an index. Where none does Cycles divides 0 by 0, and the fibre is black.
    pub fn lets_in(&self, ior: f32) -> bool {
        self.leans[WAYS - 1].x.abs() < ior
    }

    /// What denoisers and passes take for its colour.
    pub fn albedo(&self) -> Vec3 {
        self.albedo * self.weight
    }

    /// Across the fibre and the view, which Cycles calls its normal.
    pub fn normal(&self) -> Vec3 {
        self.frame.y
    }

    /// Variance along the fibre by way.
    fn variance(&self, way: usize) -> f32 {
        self.variances[way.min(2)]
    }

    /// Value and density.
    pub fn evaluate(&self, wi: Vec3) -> LobeValue {
        let local = self.frame.to_local(wi);
        let lean = Vec2::new(local.x, local.yz().length());
        // The view is at −π/2.
        let turn = local.z.atan2(local.y) + FRAC_PI_2;
        let (mut value, mut pdf) = (Vec3::ZERO, 0.0);
        for way in 0..WAYS {
            let spread = match self.turns.get(way) {
                Some(to) => around(wrapped(turn - to), self.scale),
                None => 1.0 / TAU,
            };
            let density = spread * along(lean, self.leans[way], self.variance(way));
            value += self.shares[way] * density;
            pdf += self.chances[way] * density;
        }
        LobeValue {
            value: value * self.weight,
            pdf,
        }
    }

    /// What that has too much of where Cycles samples a light: nothing, but on one side on meshes.
    pub fn evaluate_backs(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        let normal = self.frame.y;
        if self.masked && smooth.dot(wi) * smooth.dot(normal) * normal.dot(wi) < 0.0 {
            let LobeValue { value, pdf } = self.evaluate(wi);
            return LobeValue {
                value: -value,
                pdf: -pdf,
            };
        }
        LobeValue::ZERO
    }

    /// Draws a direction by its density; it is reflected if that is its way.
    pub fn sample(&self, u: Vec2, mut choice: f32) -> Option<LobeSample> {
        let mut way = 0;
        while way + 1 < WAYS && choice >= self.chances[way] {
            choice -= self.chances[way];
            way += 1;
        }
        let choice = (choice / self.chances[way]).min(1.0);
        let view = self.leans[way];
        let x = draw_along(view, self.variance(way), Vec2::new(choice, u.y));
        let turn = match self.turns.get(way) {
            Some(to) => to + draw_around(u.x, self.scale),
            None => TAU * u.x,
        };
        let (z, y) = (turn - FRAC_PI_2).sin_cos();
        let across = cosine(x);
        let wi = self
            .frame
            .to_world(Vec3::new(x, y * across, z * across))
            .try_normalize()?;
        let of = self.evaluate(wi);
        LobeSample::reflected(wi, of).map(|sample| LobeSample {
            transmitted: way > 0,
            ..sample
        })
    }

    /// Bound of the value over the density of samples: that of a channel over the luminance, whose least coefficient is blue's.
    pub fn max_sample_weight(&self) -> f32 {
        self.weight.max_element() / luminance(Vec3::Z).max(0.05)
    }
}

/// The frame of a fibre and a view: x along the fibre, y across both, z away from the view. Any about the fibre for a view along it.
pub(super) fn frame(tangent: Vec3, wo: Vec3) -> Frame {
    let x = tangent;
    let y = x.cross(wo).try_normalize();
    let y = y.unwrap_or_else(|| Frame::from_normal(x).x);
    Frame {
        x,
        y,
        z: x.cross(y),
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/shading/closure/chiang.rs"]
mod tests;
