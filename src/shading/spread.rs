//! How the normals of facets spread about the mean one: GGX, and Beckmann's distribution. Each is sampled by its visible normals.

use super::ggx::{self, Alpha, View};
use glam::{Vec2, Vec3};
use std::f64::consts::PI;
use std::fmt::Debug;

/// A distribution of normals with its masking. Densities are told over [`ggx::d`], by which all are multiplied.
pub trait Spread: Copy + Debug {
    /// Bound of the value over the density.
    const EXCESS: f32;

    /// Masking and shadowing over the cosine of the view, times the density of normals over that of GGX.
    fn masking(h: Vec3, wi: Vec3, view: &View, alpha: &Alpha) -> f32;

    /// A visible normal; `bound` may keep out those that reflect below the surface.
    fn sample(view: &View, alpha: &Alpha, bound: f32, u: Vec2) -> Vec3;

    /// The density per solid angle of directions that are reflected at sampled normals.
    fn reflection_density(h: Vec3, view: &View, alpha: &Alpha, bound: f32) -> f32;

    /// The density of sampled normals over the cosine of the view to them, where none is kept out.
    fn visible(h: Vec3, view: &View, alpha: &Alpha) -> f32;

    /// The density of reflections where none is kept out over the one where some are.
    fn share_of_all(view: &View, bound: f32) -> f32;
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

    #[inline(always)]
    fn sample(view: &View, alpha: &Alpha, bound: f32, u: Vec2) -> Vec3 {
        ggx::sample_visible_normal(view.wo, alpha, bound, u)
    }

    #[inline(always)]
    fn reflection_density(_: Vec3, view: &View, _: &Alpha, bound: f32) -> f32 {
        view.reflection_density(bound)
    }

    #[inline(always)]
    fn visible(_: Vec3, view: &View, _: &Alpha) -> f32 {
        view.g1_over_cos()
    }

    #[inline(always)]
    fn share_of_all(view: &View, bound: f32) -> f32 {
        view.reflection_density(1.0) / view.reflection_density(bound)
    }
}

impl Spread for Beckmann {
    /// The fit of Λ is up to 0.4 % below the true one, by which normals are drawn.
    const EXCESS: f32 = 1.005;

    #[cold]
    #[inline(never)]
    fn masking(h: Vec3, wi: Vec3, view: &View, alpha: &Alpha) -> f32 {
        density(h, alpha) / (view.wo.z * (1.0 + lambda(view.wo, alpha) + lambda(wi, alpha)))
    }

    /// By slopes (Heitz and d'Eon, *Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals*, EGSR
    /// 2014): across the view they are normal, along it their density is weighed by how the view sees them. The share of those
    /// below x is (c (1 + erf x) + s exp(−x²)/√π)/2 for a stretched view of height c and length s in the plane. As a function of
    /// erf x it rises and is concave, so that Newton's steps come from below and stay there (after Jakob, *An Improved Visible
    /// Normal Sampling Routine for the Beckmann Distribution*, 2014).
    #[cold]
    #[inline(never)]
    fn sample(view: &View, alpha: &Alpha, _: f32, u: Vec2) -> Vec3 {
        let flat = view.wo.truncate() * alpha.xy;
        let (c, s) = (f64::from(view.wo.z), f64::from(flat.length()));
        let most = libm::erf(c / s);
        let wanted = 2.0 * f64::from(u.x) * projected((c, s), most);
        let mut erf = (f64::from(u.x) * (1.0 + most) - 1.0).clamp(LEAST - 1.0, most - LEAST);
        let mut along = inverse_erf(erf);
        for _ in 0..12 {
            let share = c * (1.0 + erf) + s / PI.sqrt() * (-along * along).exp();
            let slope = (c - s * along).max(f64::MIN_POSITIVE);
            let next = (erf + (wanted - share) / slope).clamp(LEAST - 1.0, most.max(LEAST - 1.0));
            let step = (next - erf).abs();
            (erf, along) = (next, inverse_erf(next));
            // In parts of the nearer tail: a step leaves about its square, and as much as itself at the very horizon.
            if step <= 1e-5 * (1.0 - erf.abs()) {
                break;
            }
        }
        let across = inverse_erf((2.0 * f64::from(u.y) - 1.0).max(LEAST - 1.0));
        let to = flat.as_dvec2().try_normalize().unwrap_or(glam::DVec2::X);
        let slope = (to * along + to.perp() * across).as_vec2() * alpha.xy;
        (-slope).extend(1.0).normalize()
    }

    #[inline]
    fn reflection_density(h: Vec3, view: &View, alpha: &Alpha, _: f32) -> f32 {
        0.25 * Self::visible(h, view, alpha)
    }

    #[cold]
    #[inline(never)]
    fn visible(h: Vec3, view: &View, alpha: &Alpha) -> f32 {
        let flat = (view.wo.truncate() * alpha.xy).length();
        let (c, s) = (f64::from(view.wo.z), f64::from(flat));
        density(h, alpha) / projected((c, s), libm::erf(c / s)) as f32
    }

    fn share_of_all(_: &View, _: f32) -> f32 {
        1.0
    }
}

/// So far from ±1 error functions are inverted: less than any number that is drawn is from 0 and 1.
const LEAST: f64 = 1e-9;

/// What a stretched view of height `c` and length `s` in the plane sees of all facets: cosθ (1 + Λ), which nothing divides by. `erf`
/// of c/s.
fn projected((c, s): (f64, f64), erf: f64) -> f64 {
    let a = c / s;
    0.5 * (c * (1.0 + erf) + s / PI.sqrt() * (-a * a).exp())
}

/// The density of normals over that of GGX.
fn density(h: Vec3, alpha: &Alpha) -> f32 {
    let slope = h.truncate() / (alpha.xy * h.z);
    let t = slope.length_squared();
    // exp(-t) over GGX's 1/(1 + t)²; where t is infinite there are no facets.
    let density = ((1.0 + t) * (-0.5 * t).exp()).powi(2);
    if density.is_finite() { density } else { 0.0 }
}

/// The inverse of the error function (Giles, *Approximating the erfinv Function*, GPU Computing Gems, 2011), to the last bits of f32
/// as his polynomials are; beyond their reach with one of Halley's steps: for what is [`LEAST`] or more from ±1.
fn inverse_erf(x: f64) -> f64 {
    let polynomial = |w: f64, of: [f64; 9]| of.into_iter().fold(0.0, |sum, c| sum * w + c);
    let w = -((1.0 - x) * (1.0 + x)).ln();
    let by = if w < 5.0 {
        let of = [
            2.810_226_36e-8,
            3.432_739_39e-7,
            -3.523_387_7e-6,
            -4.391_506_54e-6,
            2.185_808_7e-4,
            -1.253_725_03e-3,
            -4.177_681_64e-3,
            0.246_640_727,
            1.501_409_41,
        ];
        polynomial(w - 2.5, of)
    } else {
        let of = [
            -2.002_142_57e-4,
            1.009_505_58e-4,
            1.349_343_22e-3,
            -3.673_428_44e-3,
            5.739_507_73e-3,
            -7.622_461_3e-3,
            9.438_870_47e-3,
            1.001_674_06,
            2.832_976_82,
        ];
        polynomial(w.sqrt() - 3.0, of)
    };
    let root = by * x;
    if w < 16.0 {
        return root;
    }
    let off = (libm::erf(root) - x) * 0.5 * PI.sqrt() * (root * root).exp();
    root - off / (1.0 + root * off)
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
            for k in 1..2000 {
                let cos = 5e-4 * k as f32;
                let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let view = View::new(wo, &alpha);
                let value = Beckmann::masking(Vec3::Z, Vec3::Z, &view, &alpha);
                let ratio = value / Beckmann::visible(Vec3::Z, &view, &alpha);
                assert!(ratio <= Beckmann::EXCESS, "{cos}: {ratio}");
            }
        }
    }

    #[test]
    fn the_inverse_of_the_error_function_is_one() {
        for k in -500..=500 {
            let x = 0.0086 * f64::from(k);
            let erf = libm::erf(x);
            assert!(1.0 - erf.abs() > LEAST);
            let found = inverse_erf(erf);
            let bound = (2e-7 * x.abs()).min(1e-6);
            assert!((found - x).abs() <= bound, "{x}: {found}");
        }
    }

    /// χ² of the drawn slopes along and across the view against their density, at views from above to grazing.
    #[test]
    fn visible_normals_follow_their_density() {
        use crate::sampler::{Dimension, Sequence};
        for (cos, alpha) in [
            (0.99f32, Vec2::splat(0.3)),
            (0.5, Vec2::splat(0.8)),
            (0.1, Vec2::splat(0.25)),
            (1e-3, Vec2::splat(0.5)),
            (0.3, Vec2::new(0.2, 0.9)),
        ] {
            let alpha = Alpha::anisotropic(alpha);
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let view = View::new(wo, &alpha);
            const CELLS: usize = 16;
            let width = 3.2f32;
            let n = 40_000u32;
            let sequence = Sequence::new(3);
            let mut counts = vec![0f64; CELLS * CELLS];
            for k in 0..n {
                let u = sequence.sampler(0, 0, k).pair(Dimension::Bsdf, 0);
                let h = Beckmann::sample(&view, &alpha, 1.0, u);
                let slope = h.truncate() / (h.z * alpha.xy);
                let cell = ((slope / width + 1.0) * (0.5 * CELLS as f32)).floor();
                if cell.min_element() >= 0.0 && cell.max_element() < CELLS as f32 {
                    counts[cell.y as usize * CELLS + cell.x as usize] += 1.0;
                }
            }
            let (mut chi2, mut cells) = (0.0, 0);
            for (cell, count) in counts.iter().enumerate() {
                const PARTS: usize = 24;
                let mut expected = 0f64;
                for part in 0..PARTS * PARTS {
                    let at = |cell: usize, part: usize| {
                        let place = cell as f32 + (part as f32 + 0.5) / PARTS as f32;
                        width * (2.0 * place / CELLS as f32 - 1.0)
                    };
                    let slope = Vec2::new(
                        at(cell % CELLS, part % PARTS),
                        at(cell / CELLS, part / PARTS),
                    ) * alpha.xy;
                    let h = slope.extend(1.0).normalize();
                    // Per solid angle, cos³ of the area of slopes.
                    let density = ggx::d(h, &alpha)
                        * Beckmann::visible(h, &view, &alpha)
                        * wo.dot(h).max(0.0)
                        * h.z.powi(3);
                    expected += f64::from(density);
                }
                let side = f64::from(2.0 * width) / (CELLS * PARTS) as f64;
                expected *= side * side * f64::from(alpha.xy.x * alpha.xy.y) * f64::from(n);
                if expected >= 5.0 {
                    chi2 += (count - expected).powi(2) / expected;
                    cells += 1;
                }
            }
            // Mean and variance of χ² are the cells and twice that; five standard deviations.
            let cells = f64::from(cells);
            assert!(cells > 20.0);
            let most = cells + 5.0 * (2.0 * cells).sqrt();
            assert!(chi2 < most, "{cos} {alpha:?}: {chi2} of {cells}");
        }
    }
}
