//! Fresnel reflectance.

use crate::math::sqr;
use glam::Vec3;

/// Unpolarised reflectance of a dielectric with the cosine of the refracted ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Share that is reflected.
    pub reflectance: f32,
    /// Cosine of the refracted ray to the normal (0 under total internal reflection).
    pub cos_t: f32,
}

/// Fresnel's equations for the relative index `eta` = n(beyond) / n(here) and `cos_i` ≥ 0.
///
/// The refracted cosine comes from η² − sin²θ = (η − 1)(η + 1) + cos²θ, which does not cancel
/// for η near 1.
#[inline]
pub fn dielectric(cos_i: f32, eta: f32) -> Dielectric {
    of_cosine(cos_i.clamp(0.0, 1.0), eta)
}

/// The same formula for any c ≥ 0, as Blender's nodes have it for normals that are longer than 1.
#[inline]
pub fn of_cosine(c: f32, eta: f32) -> Dielectric {
    let less = (eta - 1.0) * (eta + 1.0);
    let g2 = less + c * c;
    if g2 <= 0.0 {
        return Dielectric {
            reflectance: 1.0,
            cos_t: 0.0,
        };
    }
    let g = g2.sqrt(); // η·cosθt
    // The amplitudes (c − g)/(c + g) and (η²c − g)/(η²c + g), multiplied through by their sums: the differences would cancel
    // for η near 1. What is left over cancels only at Brewster's angle, where the parallel part is 0.
    let eta2 = eta * eta;
    let perpendicular = less / sqr(g + c);
    let parallel = less * ((eta2 + 1.0) * c * c - 1.0) / sqr(eta2 * c + g);
    Dielectric {
        // Rounding may pass 1 where both are.
        reflectance: (0.5 * (sqr(perpendicular) + sqr(parallel))).clamp(0.0, 1.0),
        cos_t: (g / eta).min(1.0),
    }
}

/// Reflectance at normal incidence.
#[inline]
pub fn f0_from_ior(ior: f32) -> f32 {
    sqr((ior - 1.0) / (ior + 1.0))
}

/// The index of refraction (≥ 1) with that reflectance at normal incidence. The reflectance is
/// bounded by 0.99, as in Blender's Principled BSDF, where the index would grow without limit.
#[inline]
pub fn ior_from_f0(f0: f32) -> f32 {
    let root = f0.clamp(0.0, 0.99).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// Schlick's (1 − cosθ)⁵.
#[inline]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    sqr(sqr(m)) * m
}

/// Schlick's approximation for metals, reflectance 1 at grazing angles.
#[inline]
pub fn schlick(f0: Vec3, cos: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * schlick_weight(cos)
}

/// Mean of [`schlick`] over the cosine-weighted hemisphere: ∫ 2μ F dμ = F0 + (1 − F0)/21.
#[inline]
pub fn schlick_average(f0: Vec3) -> Vec3 {
    f0 + (Vec3::ONE - f0) * (1.0 / 21.0)
}

/// How far the dielectric's true reflectance has come from normal (0) to grazing incidence (1):
/// Blender's Principled BSDF blends a tinted reflectance at normal incidence to white by it.
///
/// 0 where `f0` is 1, and where the reflectance of an index above 3.7 falls below `f0`.
#[inline]
pub fn grazing_blend(reflectance: f32, f0: f32) -> f32 {
    ((reflectance - f0) / (1.0 - f0).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// How far a dielectric's mean reflectance over the cosine-weighted hemisphere has come ([`grazing_blend`]), by the fit of Kulla and
/// Conty (*Revisiting Physically Based Shading at Imageworks*, 2017) to the true reflectance. `f0`: at normal incidence.
#[inline]
pub fn average_blend(eta: f32, f0: f32) -> f32 {
    let average = if eta < 1.0 {
        0.997_118 + eta * (0.1014 - eta * (0.965_241 + eta * 0.130_607))
    } else {
        (eta - 1.0) / (4.085_67 + 1.000_71 * eta)
    };
    grazing_blend(average, f0)
}

/// cosθ (1 − cosθ)⁶: how the edges of tinted metals bend away from Schlick's approximation.
#[inline]
fn bend(cos: f32) -> f32 {
    schlick_weight(cos) * cos * (1.0 - cos).max(0.0)
}

/// Unpolarised reflectance of a conductor in vacuum (Born and Wolf, 14.2; the real and the imaginary part of the refracted
/// wave's normal component are u and v).
#[cold]
#[inline(never)]
pub fn conductor(cos: f32, n: Vec3, k: Vec3) -> Vec3 {
    let c = cos.clamp(0.0, 1.0);
    let real = n * n - k * k;
    let difference = real - Vec3::splat(1.0 - c * c);
    let cross = 2.0 * n * k;
    let length = (difference * difference + cross * cross).map(f32::sqrt);
    let root = |square: Vec3| square.max(Vec3::ZERO).map(f32::sqrt);
    let (u, v) = (
        root(0.5 * (length + difference)),
        root(0.5 * (length - difference)),
    );
    let ratio = |a: Vec3, b: Vec3| a / b.max(Vec3::splat(f32::MIN_POSITIVE));
    let square = |a: Vec3, b: Vec3| a * a + b * b;
    let across = ratio(square(Vec3::splat(c) - u, v), square(Vec3::splat(c) + u, v));
    let (a, b) = (real * c, cross * c);
    let along = ratio(square(a - u, b - v), square(a + u, b + v));
    (0.5 * (across + along)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// The reflectance of a lobe's facets.
#[derive(Clone, Copy, Debug)]
pub enum Fresnel {
    /// The same at all angles.
    Constant,
    /// A metal, by Schlick's approximation.
    Schlick {
        /// Reflectance at normal incidence.
        f0: Vec3,
    },
    /// A metal whose edges are tinted.
    Tinted {
        /// Reflectance at normal incidence.
        f0: Vec3,
        /// What it lacks of Schlick's, over cosθ (1 − cosθ)⁶.
        lack: Vec3,
    },
    /// A metal by its complex index of refraction.
    Conductor {
        /// The real part.
        n: Vec3,
        /// The imaginary part.
        k: Vec3,
    },
    /// A dielectric by the true equations, blended from a tint at normal incidence to white.
    Dielectric {
        /// Reflectance at normal incidence, tinted.
        f0: Vec3,
        /// The index.
        eta: f32,
        /// Reflectance of `eta` at normal incidence.
        true_f0: f32,
    },
}

/// A metal's reflectance by those at normal incidence and at cosθ = 1/7.
#[cold]
pub fn bent(cos: f32, f0: f32, edge: f32) -> f32 {
    let at = |cos: f32| f0 + (1.0 - f0) * schlick_weight(cos);
    let lack = (at(1.0 / 7.0) - edge) / bend(1.0 / 7.0);
    (at(cos) - lack * bend(cos)).clamp(0.0, 1.0)
}

impl Fresnel {
    /// A metal with a tint of its edges: by it the reflectance at cosθ = 1/7 is multiplied (Kutz, Hašan and Edmondson, *Novel
    /// Aspects of the Adobe Standard Material*, 2021).
    #[inline]
    pub fn metal(f0: Vec3, tint: Vec3) -> Self {
        if tint.cmpge(Vec3::ONE).all() {
            return Self::Schlick { f0 };
        }
        let tint = tint.clamp(Vec3::ZERO, Vec3::ONE);
        let cos = 1.0 / 7.0;
        Self::Tinted {
            f0,
            lack: schlick(f0, cos) * (Vec3::ONE - tint) / bend(cos),
        }
    }

    /// Mean over the cosine-weighted hemisphere, of metals: ∫ 2μ·μ(1 − μ)⁶ dμ = 1/126.
    #[inline]
    pub fn average(&self) -> Vec3 {
        match *self {
            Self::Schlick { f0 } => schlick_average(f0),
            Self::Tinted { f0, lack } => schlick_average(f0) - lack * (1.0 / 126.0),
            Self::Conductor { n, k } => {
                // Of the tinted metal that has its reflectance at normal incidence and at cosθ = 1/7.
                let (f0, edge) = (conductor(1.0, n, k), conductor(1.0 / 7.0, n, k));
                let lack = (schlick(f0, 1.0 / 7.0) - edge) / bend(1.0 / 7.0);
                (schlick_average(f0) - lack * (1.0 / 126.0)).clamp(Vec3::ZERO, Vec3::ONE)
            }
            Self::Constant | Self::Dielectric { .. } => Vec3::ONE,
        }
    }

    /// Reflectance under an angle to the facet.
    #[inline(always)]
    pub fn reflectance(&self, cos: f32) -> Vec3 {
        match *self {
            Self::Constant => Vec3::ONE,
            Self::Schlick { f0 } => schlick(f0, cos),
            Self::Tinted { f0, lack } => {
                (schlick(f0, cos) - lack * bend(cos)).clamp(Vec3::ZERO, Vec3::ONE)
            }
            Self::Conductor { n, k } => conductor(cos, n, k),
            Self::Dielectric { f0, eta, true_f0 } => {
                let blend = grazing_blend(dielectric(cos, eta).reflectance, true_f0);
                f0 + (Vec3::ONE - f0) * blend
            }
        }
    }
}

/// The least index of refraction that is calculated with.
pub const LEAST_IOR: f32 = 1e-4;

/// The index of refraction that is calculated with: above 0, as in Cycles, where what is less reflects all but what comes straight on;
/// beyond 1e4, where F0 is within 4e-4 of 1, f32 has no digits left for what is transmitted.
#[inline]
pub fn bounded_ior(ior: f32) -> f32 {
    ior.clamp(LEAST_IOR, 1e4)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn oracle(cos_i: f64, eta: f64) -> f64 {
        let g2 = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i;
        if g2 <= 0.0 {
            return 1.0;
        }
        let cos_t = g2.sqrt() / eta;
        let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
        let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
        0.5 * (s * s + p * p)
    }

    #[test]
    fn dielectric_agrees_with_f64_from_grazing_to_normal_and_for_all_indices() {
        for eta in [
            1.0f32,
            1.0 + 1e-7,
            1.0 - 1e-6,
            1.0001,
            1.33,
            1.5,
            2.4,
            1000.0,
            1.0 / 1.5,
            0.01,
        ] {
            for i in 0..=1000 {
                let c = (i as f32 / 1000.0).powi(2);
                let found = dielectric(c, eta);
                assert!(
                    (0.0..=1.0).contains(&found.reflectance) && (0.0..=1.0).contains(&found.cos_t)
                );
                let exact = oracle(f64::from(c), f64::from(eta));
                // The subtraction g − c loses at most a few ulp of the larger term: absolute error.
                assert!(
                    (f64::from(found.reflectance) - exact).abs() < 2e-6,
                    "{eta} {c}: {found:?} {exact}"
                );
            }
        }
        assert_eq!(dielectric(0.3, 1.0).reflectance, 0.0);
    }

    #[test]
    fn the_index_and_the_reflectance_are_inverse() {
        for ior in [1.0f32, 1.1, 1.5, 2.5, 10.0] {
            assert!((ior_from_f0(f0_from_ior(ior)) / ior - 1.0).abs() < 1e-5);
        }
    }
}
