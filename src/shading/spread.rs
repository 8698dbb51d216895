//! How the normals of facets spread about the mean one: GGX, and Beckmann's distribution.
//!
//! Both are sampled by the visible normals of GGX. Beckmann's distribution has shorter tails and less masking, so that the
//! value over that density is at most 4/e · √π.

use super::ggx::{Alpha, View};
use glam::Vec3;
use std::fmt::Debug;

/// A distribution of normals with its masking.
pub trait Spread: Copy + Debug {
    /// Bound of the value over the density of GGX's visible normals.
    const EXCESS: f32;

    /// Masking and shadowing over the cosine of the view, times the density of normals over that of GGX.
    fn masking(h: Vec3, wi: Vec3, view: &View, alpha: &Alpha) -> f32;
}

/// GGX with height-correlated masking.
#[derive(Clone, Copy, Debug)]
pub struct Ggx;

/// Normal distribution of slopes (Walter et al., *Microfacet Models for Refraction through Rough Surfaces*, EGSR 2007, with
/// their rational fit of Smith's Λ, which Cycles has too).
#[derive(Clone, Copy, Debug)]
pub struct Beckmann;

impl Spread for Ggx {
    const EXCESS: f32 = 1.0;

    #[inline(always)]
    fn masking(_: Vec3, wi: Vec3, view: &View, alpha: &Alpha) -> f32 {
        view.g2_over_cos(wi, alpha)
    }
}

impl Spread for Beckmann {
    const EXCESS: f32 = 2.61;

    #[cold]
    #[inline(never)]
    fn masking(h: Vec3, wi: Vec3, view: &View, alpha: &Alpha) -> f32 {
        let slope = h.truncate() / (alpha.xy * h.z);
        let t = slope.length_squared();
        // exp(-t) over GGX's 1/(1 + t)²; where t is infinite there are no facets.
        let density = ((1.0 + t) * (-0.5 * t).exp()).powi(2);
        let density = if density.is_finite() { density } else { 0.0 };
        density / (view.wo.z * (1.0 + lambda(view.wo, alpha) + lambda(wi, alpha)))
    }
}

/// Λ by a = 1/(α tanθ).
fn lambda(v: Vec3, alpha: &Alpha) -> f32 {
    let sine = (v.truncate() * alpha.xy).length();
    let a = v.z.abs() / sine;
    // Also where there is no sine.
    if a < 1.6 {
        ((0.396 * a - 1.259) * a + 1.0) / ((2.181 * a + 3.535) * a)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::ggx;
    use glam::Vec2;

    /// ∫ D cosθ dω = 1, by the slopes.
    #[test]
    fn beckmanns_distribution_is_normalised() {
        for alpha in [Vec2::splat(0.1), Vec2::splat(0.7), Vec2::new(0.2, 0.6)] {
            let alpha = Alpha::anisotropic(alpha);
            let view = View::new(Vec3::Z, &alpha);
            let (n, width) = (600, 5.0);
            let mut sum = 0f64;
            for k in 0..n * n {
                let at = |i: usize| width * (2.0 * (i as f32 + 0.5) / n as f32 - 1.0);
                let slope = Vec2::new(at(k % n), at(k / n)) * alpha.xy;
                let h = Vec3::new(slope.x, slope.y, 1.0).normalize();
                // Seen from above and lit from above nothing is masked: what is left is the ratio of the densities.
                let d = ggx::d(h, &alpha) * Beckmann::masking(h, Vec3::Z, &view, &alpha);
                // dω cosθ = cos⁴ of the slopes' area.
                sum += f64::from(d * h.z.powi(4));
            }
            let area = (2.0 * width / n as f32).powi(2) * alpha.xy.x * alpha.xy.y;
            let sum = sum * f64::from(area);
            assert!((sum - 1.0).abs() < 1e-3, "{alpha:?}: {sum}");
        }
    }

    #[test]
    fn values_stay_within_their_bound() {
        for alpha in [0.01, 0.3, 1.0] {
            let alpha = Alpha::isotropic(alpha);
            for cos in [1e-4f32, 0.01, 0.3, 1.0] {
                let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let view = View::new(wo, &alpha);
                for k in 0..400 {
                    let slope = 0.01 * k as f32 * alpha.xy.x;
                    for sign in [-1.0, 1.0] {
                        let h = Vec3::new(sign * slope, 0.0, 1.0).normalize();
                        let value = Beckmann::masking(h, Vec3::Z, &view, &alpha);
                        let ratio = 0.5 * value / (0.5 * view.g1_over_cos());
                        assert!(ratio <= Beckmann::EXCESS, "{cos} {slope}: {ratio}");
                    }
                }
            }
        }
    }
}
