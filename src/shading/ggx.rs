//! The GGX microfacet distribution with Smith's masking, in the local frame of the normal and the tangent.

use crate::math::sqr;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Below this α the lobe is a mirror: α² = 2e-10 is where Cycles draws the line too, and where
/// D's peak 1/(π α²) still squares without overflow in f32.
pub const SMOOTH_ALPHA: f32 = 1.414e-5;

/// The widths α of the slopes' distribution along the frame's x and y, with what is calculated from them.
#[derive(Clone, Copy, Debug)]
pub struct Alpha {
    /// α along x and y.
    pub xy: Vec2,
    squared: Vec2,
    /// α_y/α_x, α_x/α_y and α_x·α_y.
    stretch: Vec3,
}

impl Alpha {
    /// The same α in all directions.
    #[inline]
    pub fn isotropic(alpha: f32) -> Self {
        Self {
            xy: Vec2::splat(alpha),
            squared: Vec2::splat(alpha * alpha),
            stretch: Vec3::new(1.0, 1.0, alpha * alpha),
        }
    }

    /// One α along the tangent and one across it. The smaller is at least a ten-thousandth of the larger, which bounds the
    /// ratios far inside f32.
    #[inline]
    pub fn anisotropic(xy: Vec2) -> Self {
        let xy = xy.max(Vec2::splat(1e-4 * xy.max_element()));
        if xy.x == xy.y {
            return Self::isotropic(xy.x);
        }
        Self {
            xy,
            squared: xy * xy,
            stretch: Vec3::new(xy.y / xy.x, xy.x / xy.y, xy.x * xy.y),
        }
    }

    /// Whether the lobe is a mirror; see [`SMOOTH_ALPHA`].
    #[inline]
    pub fn is_smooth(&self) -> bool {
        self.stretch.z <= SMOOTH_ALPHA * SMOOTH_ALPHA
    }

    /// The roughness (a root of α) under which the tables of albedos have this distribution, as in Cycles.
    #[inline]
    pub fn mean_roughness(&self) -> f32 {
        if self.xy.x == self.xy.y {
            self.xy.x.sqrt()
        } else {
            self.stretch.z.sqrt().sqrt()
        }
    }
}

/// Normal distribution for a unit half vector `h` (`h.z` > 0).
///
/// sin² is taken from x and y: 1 − z² would cancel for sharp lobes.
#[inline]
pub fn d(h: Vec3, alpha: &Alpha) -> f32 {
    let Alpha { stretch, .. } = alpha;
    let s = h.x * h.x * stretch.x + h.y * h.y * stretch.y + stretch.z * h.z * h.z;
    stretch.z / (PI * s * s)
}

/// Smith's Λ (Heitz, *Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs*,
/// JCGT 3(2), 2014, eq. 72) as a²/(1 + √(1 + a²))/2, which does not cancel for small a = α·tanθ,
/// multiplied through by cos²θ, so that grazing directions overflow to infinity and not to NaN.
#[inline]
pub fn lambda(v: Vec3, alpha: &Alpha) -> f32 {
    let z = v.z.abs();
    let s = alpha.squared.x * (v.x * v.x) + alpha.squared.y * (v.y * v.y);
    0.5 * s / (z * (z + (z * z + s).sqrt()))
}

/// The view as the lobes need it; cosθ·(1 + Λ) = (cosθ + [`stretched`](Self::stretched))/2 takes
/// the place of cosθ and of the masking, so that nothing divides by a grazing cosine.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Direction to the viewer.
    pub wo: Vec3,
    /// Length of `wo` with its horizontal parts scaled by α.
    pub stretched: f32,
}

impl View {
    /// For a unit vector in the local frame, above the surface.
    #[inline]
    pub fn new(wo: Vec3, alpha: &Alpha) -> Self {
        let horizontal = alpha.squared.x * (wo.x * wo.x) + alpha.squared.y * (wo.y * wo.y);
        let stretched = (horizontal + wo.z * wo.z).sqrt();
        Self { wo, stretched }
    }

    /// Height-correlated masking and shadowing (Heitz, eq. 99) over cosθ of the view.
    #[inline]
    pub fn g2_over_cos(&self, wi: Vec3, alpha: &Alpha) -> f32 {
        1.0 / (0.5 * (self.wo.z + self.stretched) + self.wo.z * lambda(wi, alpha))
    }

    /// Masking alone (eq. 43) over cosθ of the view.
    #[inline]
    pub fn g1_over_cos(&self) -> f32 {
        2.0 / (self.wo.z + self.stretched)
    }

    /// What [`d`] is multiplied by to be the density per solid angle of directions reflected at
    /// [`sample_visible_normal`] (Eto and Tokuyoshi, eq. 5; with bound 1 it is G1/(4 cosθ)).
    #[inline]
    pub fn reflection_density(&self, bound: f32) -> f32 {
        0.5 / (bound * self.wo.z + self.stretched)
    }
}

/// The share of the cap of visible normals that can be reflected above the surface
/// (Eto and Tokuyoshi, *Bounding VNDF Sampling for Smith-GGX Reflections*, SIGGRAPH Asia 2023,
/// eq. 4); 1 keeps all normals.
#[inline]
pub fn reflection_bound(wo: Vec3, alpha: &Alpha) -> f32 {
    let s2 = sqr(1.0 + (wo.x * wo.x + wo.y * wo.y).sqrt());
    let a2 = alpha.squared.min_element().min(1.0);
    (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z)
}

/// A visible normal, by spherical caps (Dupuy and Benyoub, *Sampling Visible GGX Normals with
/// Spherical Caps*, CGF 42(8), 2023), the cap bounded by `bound`.
#[inline]
pub fn sample_visible_normal(wo: Vec3, alpha: &Alpha, bound: f32, u: Vec2) -> Vec3 {
    let Vec2 { x, y } = alpha.xy;
    let standard = Vec3::new(x * wo.x, y * wo.y, wo.z).normalize();
    let phi = TAU * u.x;
    let b = bound * standard.z;
    let z = (1.0 - u.y) * (1.0 + b) - b;
    let sin = (1.0 - z * z).max(0.0).sqrt();
    let (sin_phi, cos_phi) = phi.sin_cos();
    let h = Vec3::new(sin * cos_phi, sin * sin_phi, z) + standard;
    let n = Vec3::new(x * h.x, y * h.y, h.z.max(0.0));
    // At exactly grazing view the sum can vanish: any horizontal normal is visible then.
    n.try_normalize().unwrap_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(cos: f32) -> Vec3 {
        Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
    }

    /// ∫ D cosθ dω = 1, in the substitution tan²θ = α² t/(1 − t).
    #[test]
    fn the_distribution_is_normalised() {
        for alpha in [1e-4f32, 1e-2, 0.1, 0.5, 1.0] {
            let n = 20_000;
            let mut sum = 0f64;
            for i in 0..n {
                let t = (i as f64 + 0.5) / n as f64;
                let tan2 = f64::from(alpha).powi(2) * t / (1.0 - t);
                let cos2 = 1.0 / (1.0 + tan2);
                let sin = (tan2 * cos2).sqrt();
                let h = Vec3::new(sin as f32, 0.0, cos2.sqrt() as f32);
                // dω = 2π sinθ dθ = π cos⁴ d(tan²θ) / cosθ; times cosθ.
                let jacobian = std::f64::consts::PI * cos2 * cos2 * f64::from(alpha).powi(2)
                    / (1.0 - t).powi(2);
                sum += f64::from(d(h, &Alpha::isotropic(alpha))) * jacobian / n as f64;
            }
            assert!((sum - 1.0).abs() < 1e-3, "{alpha}: {sum}");
        }
    }

    /// χ² of sampled reflections against the density, integrated over cells of (cosθ, φ).
    #[test]
    fn reflections_follow_their_density() {
        use crate::sampler::{Dimension, Sequence};
        for (alpha, cos, bounded) in [
            (Vec2::splat(0.3), 0.6f32, true),
            (Vec2::splat(0.3), 0.6, false),
            (Vec2::splat(0.8), 0.2, true),
            (Vec2::splat(1.0), 0.9, true),
            (Vec2::splat(0.1), 0.3, false),
            (Vec2::new(0.6, 0.2), 0.5, true),
            (Vec2::new(0.2, 0.9), 0.3, true),
            (Vec2::new(0.2, 0.9), 0.3, false),
        ] {
            let wo = direction(cos);
            let alpha = &Alpha::anisotropic(alpha);
            let bound = if bounded {
                reflection_bound(wo, alpha)
            } else {
                1.0
            };
            let density = View::new(wo, alpha).reflection_density(bound);
            let (nz, np) = (12usize, 12usize);
            let n = 1 << 16;
            let mut counts = vec![0f64; nz * np];
            let mut below = 0f64;
            let sequence = Sequence::new(1);
            for s in 0..n {
                // One sample of many far pixels: independent enough for a χ² that only has to be small.
                let u = sequence
                    .sampler(s % 256, s / 256, 0)
                    .pair(Dimension::Bsdf, 0);
                let h = sample_visible_normal(wo, alpha, bound, u);
                let wi = h * (2.0 * wo.dot(h)) - wo;
                if wi.z <= 0.0 {
                    below += 1.0;
                    continue;
                }
                let phi = wi.y.atan2(wi.x).rem_euclid(TAU);
                let cell = ((wi.z * nz as f32) as usize).min(nz - 1) * np
                    + ((phi / TAU * np as f32) as usize).min(np - 1);
                counts[cell] += 1.0;
            }
            let mut chi2 = 0f64;
            let mut cells = 0;
            let mut inside = 0f64;
            for iz in 0..nz {
                for ip in 0..np {
                    let m = 32;
                    let mut integral = 0f64;
                    for k in 0..m * m {
                        let z = (iz as f32 + ((k % m) as f32 + 0.5) / m as f32) / nz as f32;
                        let phi = TAU * (ip as f32 + ((k / m) as f32 + 0.5) / m as f32) / np as f32;
                        let sin = (1.0 - z * z).sqrt();
                        let wi = Vec3::new(sin * phi.cos(), sin * phi.sin(), z);
                        integral += f64::from(d((wo + wi).normalize(), alpha) * density);
                    }
                    integral *= std::f64::consts::TAU / (nz * np * m * m) as f64;
                    inside += integral;
                    let expected = integral * f64::from(n);
                    if expected > 20.0 {
                        chi2 += (counts[iz * np + ip] - expected).powi(2) / expected;
                        cells += 1;
                    }
                }
            }
            // Mean + 6 σ of χ² with `cells` degrees of freedom; quadrature error included.
            let bound_chi2 = f64::from(cells) + 6.0 * (2.0 * f64::from(cells)).sqrt();
            assert!(
                chi2 < bound_chi2,
                "α {alpha:?} cos {cos}: χ² {chi2} > {bound_chi2}"
            );
            let missing = 1.0 - inside - below / f64::from(n);
            assert!(missing.abs() < 5e-3, "α {alpha:?} cos {cos}: {missing}");
        }
    }

    #[test]
    fn lambda_does_not_cancel() {
        for alpha in [1e-5f32, 1e-3, 0.1, 1.0] {
            for cos in [1e-4f32, 0.01, 0.5, 0.999] {
                let v = direction(cos);
                let (x, z, a) = (f64::from(v.x), f64::from(v.z), f64::from(alpha));
                let exact = 0.5 * ((1.0 + (a * x / z).powi(2)).sqrt() - 1.0);
                let found = f64::from(lambda(v, &Alpha::isotropic(alpha)));
                // Below 1e-9 the f64 oracle itself cancels.
                assert!(
                    (found - exact).abs() <= 1e-6 * exact + 1e-15,
                    "{alpha} {cos}: {found} {exact}"
                );
            }
        }
    }
}
