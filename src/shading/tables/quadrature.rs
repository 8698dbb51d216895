//! Integrals over the slopes of the facets of a rough surface, from which the tables are made.

use super::{Estimate, is_straight};
use crate::shading::fresnel;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::sync::OnceLock;

/// Points over the directions of slopes, in each of two quarter turns (the other half turn mirrors them).
const DIRECTION_NODES: usize = 9;
/// The same from the dense side of a transmitting solid, in each of up to five intervals.
const DIRECTION_NODES_INSIDE: usize = 6;
/// Points over the lengths of slopes, in each interval where the integrand is smooth.
pub(super) const LENGTH_NODES: usize = 16;
/// The same where transmission is integrated too, which is dearer and smoother.
const LENGTH_NODES_BOTH: usize = 12;

/// Nodes and weights of Gauss and Legendre on 0..1: the roots of Legendre's polynomial by Newton
/// from their asymptotic places, its values by the three-term recurrence.
pub(super) fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    std::array::from_fn(|i| {
        let n = N as f64;
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut p) = (1.0, x);
            for k in 2..=N {
                let k = k as f64;
                (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// The quadrature over the slopes of the facets.
///
/// A facet with the slope (p, q), p toward the viewer, is seen under
/// cos = (cosθ + sinθ·p)·h_z; with t = tanθ the albedo of a lobe is
/// ∫ P(p, q) (1 + t·p) · weight · G2 dp dq over the facets that scatter to its side.
/// P = 1/(π α² (1 + r²/α²)²) with r² = p² + q². With r = α·w/(1 − w), the interval 0..1 of w holds
/// all facets and P r dr dφ = w (1 − w)/(π ((1 − w)² + w²)²) dw dφ is rational.
pub(super) struct Quadrature {
    /// (cosine of the slope's direction against the viewer's, weight).
    directions: Vec<(f64, f64)>,
    /// Nodes and weights of each interval of directions seen from the dense side.
    nodes_inside: [(f64, f64); DIRECTION_NODES_INSIDE],
    lengths: [(f64, f64); LENGTH_NODES],
    lengths_both: [(f64, f64); LENGTH_NODES_BOTH],
}

/// A view, for [`Quadrature`].
#[derive(Clone, Copy)]
pub(super) struct View {
    cos: f64,
    sin: f64,
    tan: f64,
    alpha: f64,
    lambda: f64,
}

/// A facet's slope as the integrands need it.
#[derive(Clone, Copy)]
struct Slope {
    /// Measure of the facets for which this one stands, (1 + t·p) included.
    weight: f64,
    /// Cosine of the view against the facet.
    cos_facet: f64,
    /// Cosine of the facet against the surface.
    z: f64,
}

/// Smith's Λ of a direction with that cosine ([`ggx::lambda`] in f64).
pub(super) fn lambda(cos: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha * (1.0 - cos * cos).max(0.0) / (cos * cos);
    0.5 * a2 / (1.0 + (1.0 + a2).sqrt())
}

impl View {
    pub fn new(cos: f64, alpha: f64) -> Self {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Self {
            cos,
            sin,
            tan: sin / cos,
            alpha,
            lambda: lambda(cos, alpha),
        }
    }

    /// G2 for a scattered direction with that cosine to the surface.
    fn masking(&self, cos_scattered: f64) -> f64 {
        1.0 / (1.0 + self.lambda + lambda(cos_scattered, self.alpha))
    }

    /// The slope's length at which facets in the direction `k` no longer reflect to above the
    /// surface: where r² − 2 t k r = 1.
    fn reflecting_length(&self, k: f64) -> f64 {
        let tk = self.tan * k;
        let root = (1.0 + tk * tk).sqrt();
        if tk > 0.0 {
            tk + root
        } else {
            1.0 / (root - tk)
        }
    }

    /// The slope's length at which facets in the direction `k` turn away from the viewer.
    fn visible_length(&self, k: f64) -> f64 {
        if k < 0.0 && self.tan > 0.0 {
            -1.0 / (self.tan * k)
        } else {
            f64::INFINITY
        }
    }

    /// The slope's lengths at which facets in the direction `k` are seen under a cosine: the
    /// positive roots of (cosθ + sinθ·k·r)² = cos²·(1 + r²), in order; infinite where there are none.
    fn lengths_seen_under(&self, k: f64, cos: f64) -> [f64; 2] {
        let (sk, c2) = (self.sin * k, cos * cos);
        let (a, half_b, c) = (sk * sk - c2, self.cos * sk, self.cos * self.cos - c2);
        let discriminant = half_b * half_b - a * c;
        if discriminant < 0.0 {
            return [f64::INFINITY; 2];
        }
        let q = -(half_b + discriminant.sqrt().copysign(half_b));
        let positive = |r: f64| if r > 0.0 { r } else { f64::INFINITY };
        let (r, s) = (positive(q / a), positive(c / q));
        [r.min(s), r.max(s)]
    }
}

impl Quadrature {
    pub fn get() -> &'static Self {
        static QUADRATURE: OnceLock<Quadrature> = OnceLock::new();
        QUADRATURE.get_or_init(|| {
            // Quarter turns apart: toward grazing views the integrand bends between them. A weight
            // holds the mirrored half too, and 1/π of the distribution.
            let directions = [FRAC_PI_4, 3.0 * FRAC_PI_4].iter().flat_map(|middle| {
                gauss_legendre::<DIRECTION_NODES>()
                    .map(|(x, weight)| ((middle + (x - 0.5) * FRAC_PI_2).cos(), weight))
            });
            Self {
                directions: directions.collect(),
                nodes_inside: gauss_legendre(),
                lengths: gauss_legendre(),
                lengths_both: gauss_legendre(),
            }
        })
    }

    /// Visits slopes in the direction `k` with lengths between two bounds.
    #[inline(always)]
    fn visit(
        nodes: &[(f64, f64)],
        view: &View,
        k: f64,
        from: f64,
        to: f64,
        mut visit: impl FnMut(Slope),
    ) {
        let w = |r: f64| {
            if r.is_finite() {
                r / (r + view.alpha)
            } else {
                1.0
            }
        };
        let (start, span) = (w(from), w(to) - w(from));
        if span <= 0.0 {
            return;
        }
        for &(x, weight) in nodes {
            let w = start + span * x;
            let rest = 1.0 - w;
            let r = view.alpha * w / rest;
            let norm = rest * rest + w * w;
            let z = 1.0 / (1.0 + r * r).sqrt();
            let toward = r * k;
            visit(Slope {
                weight: weight * span * w * rest / (norm * norm) * (1.0 + view.tan * toward),
                cos_facet: (view.cos + view.sin * toward) * z,
                z,
            });
        }
    }

    /// Albedo of reflection with the facets' reflectance 1, and with a reflectance that is a
    /// function of the cosine to the facet.
    #[inline(always)]
    pub fn reflection(&self, view: &View, reflectance: impl Fn(f32) -> f32) -> (f64, f64) {
        let (mut all, mut reflected) = (0.0, 0.0);
        for &(k, weight) in &self.directions {
            Self::visit(
                &self.lengths,
                view,
                k,
                0.0,
                view.reflecting_length(k),
                |slope| {
                    let share = weight
                        * slope.weight
                        * view.masking(2.0 * slope.cos_facet * slope.z - view.cos);
                    all += share;
                    reflected += share * f64::from(reflectance(slope.cos_facet as f32));
                },
            );
        }
        (all, reflected)
    }

    /// The same of a reflectance that is total below a cosine to the facet: intervals of lengths and of directions end where it bends.
    pub fn reflection_below_one(
        &self,
        view: &View,
        critical: f64,
        reflectance: impl Fn(f32) -> f32,
    ) -> (f64, f64) {
        let (mut all, mut reflected) = (0.0, 0.0);
        for (k, weight) in self.directions_about(view, critical) {
            let end = view.reflecting_length(k);
            let [first, second] = view.lengths_seen_under(k, critical).map(|r| r.min(end));
            for (from, to) in [(0.0, first), (first, second), (second, end)] {
                Self::visit(&self.lengths_both, view, k, from, to, |slope| {
                    let scattered = 2.0 * slope.cos_facet * slope.z - view.cos;
                    let share = weight * slope.weight * view.masking(scattered);
                    all += share;
                    reflected += share * f64::from(reflectance(slope.cos_facet as f32));
                });
            }
        }
        (all, reflected)
    }

    /// Directions of slopes where facets that are seen under less than a critical cosine reflect totally.
    ///
    /// The facets that do not are inside of a cone about the viewer, a conic in the slopes. The integrand over the slopes' directions
    /// bends where they touch it and where they become parallel to its far end.
    fn directions_about(&self, view: &View, critical: f64) -> impl Iterator<Item = (f64, f64)> {
        let angle = |k: f64| k.clamp(-1.0, 1.0).acos();
        let sin = view.sin.max(1e-9);
        let touching = (critical * critical - view.cos * view.cos).max(0.0).sqrt() / sin;
        let far = critical / sin;
        let ends = [0.0, angle(far), angle(touching), FRAC_PI_2, angle(-far), PI];
        (0..ends.len() - 1)
            .map(move |at| (ends[at], ends[at + 1]))
            .filter(|(from, to)| to > from)
            .flat_map(move |(from, to)| {
                self.nodes_inside.map(|(x, weight)| {
                    let k = (from + (to - from) * x).cos();
                    (k, weight * (to - from) / FRAC_PI_2)
                })
            })
    }

    /// Mean over what is seen of the facets of a function of the cosine to the facet; it counts 0 where they reflect to below the
    /// surface.
    pub fn seen(&self, view: &View, f: impl Fn(f32) -> f32) -> f64 {
        let mut sum = 0.0;
        for &(k, weight) in &self.directions {
            let end = view.reflecting_length(k);
            Self::visit(&self.lengths, view, k, 0.0, end, |slope| {
                sum += weight * slope.weight * f64::from(f(slope.cos_facet as f32));
            });
        }
        // All of them together have a measure of 1 + Λ.
        sum / (1.0 + view.lambda)
    }

    /// Albedo of reflection and transmission together; less 1 where transmitted light goes straight through.
    pub fn both(&self, view: &View, glass: &Interface) -> f64 {
        let Some(critical) = glass.critical_cosine else {
            return self
                .directions
                .iter()
                .map(|&(k, weight)| weight * self.both_along(view, glass, k))
                .sum();
        };
        self.directions_about(view, critical)
            .map(|(k, weight)| weight * self.both_along(view, glass, k))
            .sum()
    }

    /// The same for the slopes in the direction `k`.
    #[inline(always)]
    fn both_along(&self, view: &View, glass: &Interface, k: f64) -> f64 {
        let (visible, reflecting) = (view.visible_length(k), view.reflecting_length(k));
        let total = glass
            .critical_cosine
            .map_or([f64::INFINITY; 2], |c| view.lengths_seen_under(k, c));
        let ends = [0.0, total[0].min(visible), total[1].min(visible), visible];
        let mut sum = 0.0;
        for (&from, &to) in ends.iter().zip(&ends[1..]) {
            Self::visit(
                &self.lengths_both,
                view,
                k,
                from,
                to.min(reflecting),
                |slope| {
                    let z = 2.0 * slope.cos_facet * slope.z - view.cos;
                    sum += slope.weight
                        * f64::from(glass.reflectance(slope.cos_facet as f32).0)
                        * view.masking(z);
                },
            );
            Self::visit(&self.lengths_both, view, k, from, to, |slope| {
                let (f, cos_t) = glass.reflectance(slope.cos_facet as f32);
                if glass.straight {
                    // All visible facets together are 1, and what they do not reflect is masked by nothing.
                    sum -= slope.weight * f64::from(f) / (1.0 + view.lambda);
                    return;
                }
                let z = slope.z * (slope.cos_facet / glass.eta - f64::from(cos_t))
                    - view.cos / glass.eta;
                if f < 1.0 && (z < 0.0 || glass.counts_wrong_side) {
                    sum += slope.weight * f64::from(1.0 - f) * view.masking(z);
                }
            });
        }
        sum
    }
}

/// The facets of a transmitting solid, as the BSDF has them.
pub(super) struct Interface {
    eta: f64,
    f0: f32,
    /// Cosine below which the reflection is total.
    critical_cosine: Option<f64>,
    /// As [`is_straight`].
    pub straight: bool,
    /// See [`Estimate::Cycles`].
    counts_wrong_side: bool,
}

impl Interface {
    pub fn new(eta: f32, ior: f32, estimate: Estimate) -> Self {
        let e = f64::from(eta);
        Self {
            eta: e,
            f0: fresnel::f0_from_ior(ior),
            critical_cosine: (e < 1.0).then(|| (1.0 - e * e).sqrt()),
            straight: is_straight(eta),
            counts_wrong_side: estimate == Estimate::Cycles,
        }
    }

    /// Reflectance and cosine of the refracted ray.
    #[inline(always)]
    fn reflectance(&self, cos: f32) -> (f32, f32) {
        let f = fresnel::dielectric(cos, self.eta as f32);
        // Where an index above 3.7 makes the reflectance fall at first, the BSDF keeps to F0.
        (f.reflectance.max(self.f0), f.cos_t)
    }
}
