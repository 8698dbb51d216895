//! Directional albedos of rough surfaces, tabulated: what a single scattering at the microfacets
//! loses is put back by scaling (Turquin, *Practical multiple scattering compensation for
//! microfacet models*, 2019; the average Fresnel term after Kulla and Conty, *Revisiting
//! Physically Based Shading at Imageworks*, 2017).
//!
//! The tables are integrated when a scene first needs them, not shipped, and of them the rows of the roughnesses that its
//! materials have: 2 of 40 for one without a texture. The integrals run over
//! the slopes of the facets, in polar coordinates: there the distribution is a function of the
//! radius alone, the facets that reflect to above the surface fill a circle, and the integrand is
//! analytic inside, so that a few points of Gauss and Legendre give four digits.

use super::fresnel;
use crate::math::mix;
use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::sync::OnceLock;

/// Points of the grid over the cosine.
const COSINES: usize = 40;
/// Points of the grid over the roughness.
const ROUGHNESSES: usize = 40;
/// Points of the quadrature over the slopes' directions, in each of two quarter turns (the other
/// half turn mirrors them).
const DIRECTION_NODES: usize = 9;
/// The same from the dense side of a transmitting solid, in each of up to five intervals.
const DIRECTION_NODES_INSIDE: usize = 6;
/// Points of the quadrature over the slopes' lengths, in each interval where they are smooth.
const LENGTH_NODES: usize = 16;
/// The same where transmission is integrated too, which is dearer and smoother.
const LENGTH_NODES_BOTH: usize = 12;
/// α of the grid's first row. Below it only the ratio of cosθ to α matters.
const LEAST_ALPHA: f64 = 1e-5;

/// Rows of the grid, from the first to the last: a material reads those about its roughness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rows {
    first: usize,
    last: usize,
}

impl Rows {
    /// All there are.
    pub const ALL: Self = Self {
        first: 0,
        last: ROUGHNESSES - 1,
    };

    /// Those that are read for perceptual roughnesses between two.
    pub fn between(least: f32, greatest: f32) -> Self {
        let row = |roughness: f32| cell(roughness.clamp(0.0, 1.0), ROUGHNESSES).0;
        Self {
            first: row(least),
            last: row(greatest) + 1,
        }
    }
}

/// α of a row of the grid.
fn row_alpha(row: usize) -> f64 {
    let roughness = row as f64 / (ROUGHNESSES - 1) as f64;
    (roughness * roughness).max(LEAST_ALPHA)
}

/// A place in the tables: the cell, and where in it. All tables have the same grid, so that a
/// place is looked up once for all of them.
///
/// Masking bends where cosθ is about α, reflectance over the whole of 0..1: the first axis is
/// the mean of cosθ and of (1 + α)·cosθ/(cosθ + α), and gives half of its points to each. The
/// second axis is the roughness.
#[derive(Clone, Copy, Debug)]
pub struct LutCoordinate {
    index: usize,
    along: f32,
    up: f32,
    /// cosθ + α.
    scale: f32,
}

impl LutCoordinate {
    /// The place of a view cosine and a perceptual roughness (α is its square).
    #[inline]
    pub fn new(cos: f32, roughness: f32) -> Self {
        let c = cos.clamp(0.0, 1.0);
        let roughness = roughness.clamp(0.0, 1.0);
        let alpha = (roughness * roughness).max(LEAST_ALPHA as f32);
        let scale = c + alpha;
        let (column, along) = cell(0.5 * c * (1.0 + (1.0 + alpha) / scale), COSINES);
        let (row, up) = cell(roughness, ROUGHNESSES);
        Self {
            index: row * COSINES + column,
            along,
            up,
            scale,
        }
    }
}

/// The cosine of a column for an α: the inverse of the first axis of [`LutCoordinate`], the positive root
/// of c² + (2α + 1 − 2x)·c − 2xα.
fn column_cosine(column: usize, alpha: f64) -> f64 {
    // At exactly grazing view only limits exist.
    cosine_at(column as f64 / (COSINES - 1) as f64, alpha).clamp(1e-4 * alpha, 1.0)
}

/// The same for any place on the axis.
fn cosine_at(x: f64, alpha: f64) -> f64 {
    let b = 2.0 * alpha + 1.0 - 2.0 * x;
    let root = (b * b + 8.0 * x * alpha).sqrt();
    if b > 0.0 {
        4.0 * x * alpha / (b + root)
    } else {
        0.5 * (root - b)
    }
}

/// The cell of an x in 0..=1 among `points` points, and where in the cell.
#[inline]
fn cell(x: f32, points: usize) -> (usize, f32) {
    let x = x.min(1.0) * (points - 1) as f32;
    let i = (x as usize).min(points - 2);
    (i, x - i as f32)
}

/// A function on the grid of [`LutCoordinate`], read bilinearly.
#[derive(Clone, Debug)]
struct Table {
    values: Vec<f32>,
    /// What the rows that are left out before the first would have.
    skipped: usize,
}

impl Table {
    /// Tabulates a function of the cosine and α, on all threads.
    fn tabulate(rows: Rows, f: impl Fn(f64, f64) -> f32 + Sync) -> Self {
        Self::tabulate_from(0, rows, f)
    }

    /// The same where the columns before one are not read.
    fn tabulate_from(column: usize, rows: Rows, f: impl Fn(f64, f64) -> f32 + Sync) -> Self {
        let places = (rows.first * COSINES..(rows.last + 1) * COSINES).into_par_iter();
        let value = |place: usize| {
            if place % COSINES < column {
                return 0.0;
            }
            let alpha = row_alpha(place / COSINES);
            f(column_cosine(place % COSINES, alpha), alpha)
        };
        Self {
            // Ten at a time: a part of a thread's work is worth handing over.
            values: places.with_min_len(10).map(value).collect(),
            skipped: rows.first * COSINES,
        }
    }

    #[inline]
    fn read(&self, place: LutCoordinate) -> f32 {
        let at = |i: usize| self.values[place.index + i - self.skipped];
        let (low, high) = (
            mix(at(0), at(1), place.along),
            mix(at(COSINES), at(COSINES + 1), place.along),
        );
        mix(low, high, place.up)
    }
}

/// Nodes and weights of Gauss and Legendre on 0..1: the roots of Legendre's polynomial by Newton
/// from their asymptotic places, its values by the three-term recurrence.
fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
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
struct Quadrature {
    /// (cosine of the slope's direction against the viewer's, weight).
    directions: Vec<(f64, f64)>,
    /// Nodes and weights of each interval of directions seen from the dense side.
    nodes_inside: [(f64, f64); DIRECTION_NODES_INSIDE],
    lengths: [(f64, f64); LENGTH_NODES],
    lengths_both: [(f64, f64); LENGTH_NODES_BOTH],
}

/// A view, for [`Quadrature`].
#[derive(Clone, Copy)]
struct View {
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
fn lambda(cos: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha * (1.0 - cos * cos).max(0.0) / (cos * cos);
    0.5 * a2 / (1.0 + (1.0 + a2).sqrt())
}

impl View {
    fn new(cos: f64, alpha: f64) -> Self {
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
    fn get() -> &'static Self {
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
    fn reflection(&self, view: &View, reflectance: impl Fn(f32) -> f32) -> (f64, f64) {
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

    /// Albedo of reflection and transmission together; less 1 where transmitted light goes straight through.
    fn both(&self, view: &View, glass: &Interface) -> f64 {
        let Some(critical) = glass.critical_cosine else {
            return self
                .directions
                .iter()
                .map(|&(k, weight)| weight * self.both_along(view, glass, k))
                .sum();
        };
        // Seen from the dense side the reflection is total outside a cone about the viewer, a conic
        // in the slopes. The integrand over the slopes' directions bends where they touch it and
        // where they become parallel to its far end.
        let angle = |k: f64| k.clamp(-1.0, 1.0).acos();
        let sin = view.sin.max(1e-9);
        let touching = (critical * critical - view.cos * view.cos).max(0.0).sqrt() / sin;
        let far = critical / sin;
        let ends = [0.0, angle(far), angle(touching), FRAC_PI_2, angle(-far), PI];
        let mut sum = 0.0;
        for (&from, &to) in ends.iter().zip(&ends[1..]).filter(|(from, to)| to > from) {
            for (x, weight) in self.nodes_inside {
                let k = (from + (to - from) * x).cos();
                sum += weight * (to - from) / FRAC_PI_2 * self.both_along(view, glass, k);
            }
        }
        sum
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
                if z < 0.0 && f < 1.0 {
                    sum += slope.weight * f64::from(1.0 - f) * view.masking(z);
                }
            });
        }
        sum
    }
}

/// The facets of a transmitting solid, as the BSDF has them.
struct Interface {
    eta: f64,
    f0: f32,
    /// Cosine below which the reflection is total.
    critical_cosine: Option<f64>,
    /// As [`is_straight`].
    straight: bool,
}

impl Interface {
    fn new(eta: f32, ior: f32) -> Self {
        let e = f64::from(eta);
        Self {
            eta: e,
            f0: fresnel::f0_from_ior(ior),
            critical_cosine: (e < 1.0).then(|| (1.0 - e * e).sqrt()),
            straight: is_straight(eta),
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

/// Albedos of GGX with reflectance 1 at a place.
#[derive(Clone, Copy, Debug)]
pub struct Reflection {
    /// Single-scattering albedo at the view cosine.
    pub directional: f32,
    /// Its cosine-weighted mean.
    pub average: f32,
}

/// A row of their table.
struct ReflectionRow {
    directional: [f32; COSINES],
    average: f32,
}

impl ReflectionRow {
    /// Made when a surface of its roughness is first met, on that thread: others may wait for it, and must not be given
    /// more to do meanwhile.
    #[inline]
    fn get(row: usize) -> &'static Self {
        static ROWS: [OnceLock<ReflectionRow>; ROUGHNESSES] =
            [const { OnceLock::new() }; ROUGHNESSES];
        ROWS[row].get_or_init(|| Self::new(row))
    }

    #[cold]
    fn new(row: usize) -> Self {
        let quadrature = Quadrature::get();
        let alpha = row_alpha(row);
        let directional = std::array::from_fn(|column| {
            let view = View::new(column_cosine(column, alpha), alpha);
            quadrature.reflection(&view, |_| 0.0).0.min(1.0) as f32
        });
        // ∫ 2μ E dμ with E linear between the columns: Simpson's rule is exact.
        let at = |i: usize| (column_cosine(i, alpha), f64::from(directional[i]));
        let average = (0..COSINES - 1)
            .map(|i| (at(i), at(i + 1)))
            .fold(0.0, |sum, ((c, e), (d, f))| {
                sum + (d - c) / 3.0 * (c * e + (c + d) * (e + f) + d * f)
            }) as f32;
        Self {
            directional,
            average,
        }
    }
}

impl Reflection {
    /// At a place.
    #[inline]
    pub fn at(place: LutCoordinate) -> Self {
        let (row, column) = (place.index / COSINES, place.index % COSINES);
        let (low, high) = (ReflectionRow::get(row), ReflectionRow::get(row + 1));
        let along = |row: &ReflectionRow| {
            mix(
                row.directional[column],
                row.directional[column + 1],
                place.along,
            )
        };
        Self {
            directional: mix(along(low), along(high), place.up),
            average: mix(low.average, high.average, place.up),
        }
    }

    /// By what a single-scattering lobe with mean reflectance `f_average` is scaled so that the
    /// energy of further scatterings is there: 1 + F_ms (1 − E)/E with
    /// F_ms = F̄ E_avg / (1 − F̄ (1 − E_avg)).
    #[inline]
    pub fn compensation(&self, f_average: Vec3) -> Vec3 {
        let (e, e_average) = (self.directional, self.average);
        let f_ms = f_average * e_average / (Vec3::ONE - f_average * (1.0 - e_average));
        Vec3::ONE + f_ms * ((1.0 - e) / e)
    }
}

/// Albedos of a rough dielectric with one index of refraction.
#[derive(Debug)]
pub struct Dielectric {
    /// The cosine at which a smooth interface has the rough one's mean reflectance, over
    /// cosθ + α: tabulated instead of the reflectance, because it stays smooth where the
    /// reflectance rises steeply toward grazing views, and is 1 for smooth interfaces.
    effective_cosine: Table,
    /// Cosine-weighted mean reflectance of the smooth interface, as [`fresnel::grazing_blend`].
    average_blend: f32,
}

/// Albedo of reflection and transmission together of a rough transmitting solid with one index of refraction, with nothing
/// absorbed: seen from outside and from inside.
#[derive(Debug)]
pub struct Solid([Side; 2]);

/// The same at grazing views, where the albedo bends within the first cells of [`Table`].
///
/// From outside it falls from 1 about as the square root of the cosine: with [`Table`] alone up to 5.7 % was lost under
/// cosines of 0.006 (roughness 1, index 1.1; 1.9 % at 1.5). For an index near 1 what is refracted is bent by about η − 1, and
/// whether it goes below the surface, and how much of it is masked, changes with the cosine on that scale, from inside too.
#[derive(Debug)]
struct Grazing {
    values: Vec<f32>,
    /// What the rows that are left out before the first would have.
    skipped: usize,
    points: &'static Points,
}

/// The places of [`Grazing`]: over some columns of [`Table`], even in a root of the first axis of [`LutCoordinate`].
#[derive(Debug)]
struct Points {
    columns: usize,
    count: usize,
    power: i32,
    root: fn(f32) -> f32,
}

/// For indices within 0.1 of 1: from a cosine of 1e-4 on (for α = 1) each is at most 1.5 times the one before it.
const NEAR_ONE: Points = Points {
    columns: 3,
    count: 48,
    power: 4,
    root: |x| x.sqrt().sqrt(),
};
/// For others, from outside. Linear between them, the albedo is at most 0.4 % off (roughness 1, index 1.1; 0.2 % at 1.5). Even
/// in the square root 0.7 % would be: what is left of the bend is at its end.
const FROM_OUTSIDE: Points = Points {
    columns: 2,
    count: 7,
    power: 3,
    root: f32::cbrt,
};

impl Points {
    fn of(ior: f32, inside: bool) -> Option<&'static Self> {
        if is_straight(ior) {
            None
        } else if (ior - 1.0).abs() < 0.1 {
            Some(&NEAR_ONE)
        } else {
            (!inside).then_some(&FROM_OUTSIDE)
        }
    }
}

impl Grazing {
    fn tabulate(rows: Rows, points: &'static Points, f: impl Fn(f64, f64) -> f32 + Sync) -> Self {
        let end = points.columns as f64 / (COSINES - 1) as f64;
        let value = |place: usize| {
            let alpha = row_alpha(place / points.count);
            let root = (place % points.count) as f64 / (points.count - 1) as f64;
            let cos = cosine_at(end * root.powi(points.power), alpha);
            f(cos.clamp(1e-6 * alpha, 1.0), alpha)
        };
        let skipped = rows.first * points.count;
        let places = (skipped..(rows.last + 1) * points.count).into_par_iter();
        Self {
            values: places.with_min_len(10).map(value).collect(),
            skipped,
            points,
        }
    }

    /// The value at a place of its columns.
    #[cold]
    fn read(&self, place: LutCoordinate) -> f32 {
        let points = self.points;
        let (row, column) = (place.index / COSINES, place.index % COSINES);
        let x = (column as f32 + place.along) / points.columns as f32;
        let (i, along) = cell((points.root)(x), points.count);
        let mixed = |row: usize| {
            let at = row * points.count + i - self.skipped;
            mix(self.values[at], self.values[at + 1], along)
        };
        mix(mixed(row), mixed(row + 1), place.up)
    }
}

/// A side of a [`Solid`].
#[derive(Debug)]
struct Side {
    table: Table,
    grazing: Option<Grazing>,
}

impl Solid {
    /// Tabulates for an index of refraction (above or below 1).
    pub fn new(ior: f32, rows: Rows) -> Self {
        let quadrature = Quadrature::get();
        let side = |inside: bool| {
            let interface = Interface::new(if inside { 1.0 / ior } else { ior }, ior);
            let albedo = |cos, alpha| {
                let both = quadrature.both(&View::new(cos, alpha), &interface);
                let less = if interface.straight { 1.0 } else { 0.0 };
                (both + less).min(1.0) as f32
            };
            let points = Points::of(ior, inside);
            Side {
                table: Table::tabulate_from(points.map_or(0, |p| p.columns), rows, albedo),
                grazing: points.map(|points| Grazing::tabulate(rows, points, albedo)),
            }
        };
        Self([side(false), side(true)])
    }

    /// The albedo at a place.
    #[inline]
    pub fn both(&self, place: LutCoordinate, inside: bool) -> f32 {
        let side = &self.0[usize::from(inside)];
        match &side.grazing {
            Some(grazing) if place.index % COSINES < grazing.points.columns => grazing.read(place),
            _ => side.table.read(place),
        }
    }
}

/// How far the reflectance of a smooth interface has come from normal to grazing incidence.
#[inline]
pub fn smooth_blend(cos: f32, eta: f32) -> f32 {
    fresnel::grazing_blend(
        fresnel::dielectric(cos, eta).reflectance,
        fresnel::f0_from_ior(eta),
    )
}

/// The cosine at which the smooth interface has come that far; `smooth_blend` falls with the cosine.
fn cosine_of_blend(blend: f32, eta: f32) -> f32 {
    let (mut low, mut high) = (0f32, 1f32);
    // Once for each bit of an f32 near 1.
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if smooth_blend(middle, eta) > blend {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

impl Dielectric {
    /// Tabulates for an index of refraction (above or below 1).
    pub fn new(ior: f32, rows: Rows) -> Self {
        let quadrature = Quadrature::get();
        let effective_cosine = Table::tabulate(rows, |cos, alpha| {
            let (all, reflected) =
                quadrature.reflection(&View::new(cos, alpha), |c| smooth_blend(c, ior));
            cosine_of_blend((reflected / all) as f32, ior) / (cos + alpha) as f32
        });
        let n = 1024;
        let average_blend = (0..n)
            .map(|k| {
                let mu = (k as f32 + 0.5) / n as f32;
                2.0 * mu * smooth_blend(mu, ior) / n as f32
            })
            .sum();
        Self {
            effective_cosine,
            average_blend,
        }
    }

    /// The cosine at which a smooth interface has the mean reflectance of the rough one.
    #[inline]
    pub fn effective_cosine(&self, place: LutCoordinate) -> f32 {
        self.effective_cosine.read(place) * place.scale
    }

    /// How far the cosine-weighted mean over all directions of the smooth interface's reflectance
    /// has come from F0 to 1.
    pub fn average_blend(&self) -> f32 {
        self.average_blend
    }
}

/// Whether an index is so near to 1 that transmitted light is taken straight through, with nothing
/// masked (what is reflected at grazing views is): the half vector of transmission vanishes as η − 1, and with it the Jacobian's digits;
/// 1e-4 leaves ten bits.
#[inline]
pub fn is_straight(eta: f32) -> bool {
    (eta - 1.0).abs() < 1e-4
}

/// Refracts `wo` at the normal `h` (both on one side); `eta` = n(beyond)/n(here).
#[inline]
pub fn refract(wo: Vec3, h: Vec3, cos_t: f32, eta: f32) -> Vec3 {
    h * (wo.dot(h) / eta - cos_t) - wo / eta
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::ggx;

    /// GGX's albedo by another route: over directions of light, closer together toward grazing
    /// ones, in f64.
    fn albedo_over_light(cos: f64, alpha: f64) -> f64 {
        let sin = (1.0 - cos * cos).sqrt();
        let (nz, np) = (1000, 200);
        let mut sum = 0.0;
        for i in 0..nz {
            let root = (i as f64 + 0.5) / nz as f64;
            let z = root * root;
            let s = (1.0 - z * z).sqrt();
            for j in 0..np {
                // Half the turn, by symmetry.
                let phi = PI * (j as f64 + 0.5) / np as f64;
                let (hx, hy, hz) = (sin + s * phi.cos(), s * phi.sin(), cos + z);
                let slope2 = (hx * hx + hy * hy) / (hz * hz * alpha * alpha);
                let cos_h2 = hz * hz / (hx * hx + hy * hy + hz * hz);
                let d = 1.0 / (PI * alpha * alpha * (cos_h2 * (1.0 + slope2)).powi(2));
                sum += 2.0 * root * d / (4.0 * cos * (1.0 + lambda(cos, alpha) + lambda(z, alpha)));
            }
        }
        sum * 2.0 * PI / f64::from(nz * np)
    }

    /// Within a cell the table is linear where the albedo bends: E'' ≤ 12 in the roughness makes
    /// 12/8·(1/39)² = 1e-3; at most as much for the cosine.
    #[test]
    fn albedo_agrees_with_the_integral_over_directions_of_light() {
        for (cos, roughness) in [
            (0.8f32, 1.0f32),
            (0.3, 0.7),
            (0.05, 0.5),
            (0.5, 0.45),
            (0.97, 0.9),
        ] {
            let exact = albedo_over_light(f64::from(cos), f64::from(roughness * roughness));
            let found = f64::from(Reflection::at(LutCoordinate::new(cos, roughness)).directional);
            assert!(
                (found - exact).abs() < 2e-3,
                "{cos} {roughness}: {found} {exact}"
            );
        }
        assert!((Reflection::at(LutCoordinate::new(0.5, 0.0)).directional - 1.0).abs() < 1e-5);
    }

    /// The quadrature itself, without the table between: the midpoint rule has steps of 0.016 in
    /// angle and facets tilt by α ≥ 0.2, so its error is below (0.016/0.2)²/24 = 3e-4.
    #[test]
    fn the_quadrature_agrees_with_the_integral_over_directions_of_light() {
        for (cos, alpha) in [
            (0.8, 1.0),
            (0.3, 0.49),
            (0.05, 0.25),
            (1.0, 0.3),
            (0.6, 0.2),
        ] {
            let exact = albedo_over_light(cos, alpha);
            let found = Quadrature::get()
                .reflection(&View::new(cos, alpha), |_| 0.0)
                .0;
            assert!(
                (found - exact).abs() < 4e-4,
                "{cos} {alpha}: {found} {exact}"
            );
        }
    }

    /// ∫ x^k dx = 1/(k + 1) for k up to 2n − 1.
    #[test]
    fn the_nodes_integrate_polynomials() {
        let nodes = gauss_legendre::<LENGTH_NODES>();
        for k in 0..2 * LENGTH_NODES as i32 {
            let sum: f64 = nodes.iter().map(|(x, weight)| weight * x.powi(k)).sum();
            assert!((sum - 1.0 / f64::from(k + 1)).abs() < 1e-14, "{k}: {sum}");
        }
    }

    /// The same from outside for indices that are not near 1, at rows of the grid and between them.
    #[test]
    fn grazing_views_from_outside_agree_with_the_integral() {
        for ior in [0.6f32, 1.1, 1.2, 1.33, 1.5, 2.4] {
            let solid = Solid::new(ior, Rows::ALL);
            let interface = Interface::new(ior, ior);
            for roughness in [0.1f32, 0.3, 0.57, 0.8, 0.98, 1.0] {
                for step in 0..60 {
                    let cos = 1e-5f32.powf(step as f32 / 60.0) * 0.1;
                    let view = View::new(f64::from(cos), f64::from(roughness * roughness));
                    let exact = Quadrature::get().both(&view, &interface);
                    let found = f64::from(solid.both(LutCoordinate::new(cos, roughness), false));
                    assert!(
                        (exact / found - 1.0).abs() < 5e-3,
                        "{ior} {roughness} {cos}: {found} {exact}"
                    );
                }
            }
        }
    }

    /// Between the points, near 1, against the integral itself: within the error that is allowed for from outside. From inside the
    /// albedo falls with the cosine, the fourth power of the columns' root, of which the 17th cell is linear within 12/8/17² =
    /// 0.5 %, and about as steeply with the roughness: 20/8·(1/39/0.28)² = 2 % between its rows. Together 3 % from a cosine of 1e-3 on.
    #[test]
    fn grazing_columns_agree_with_the_integral() {
        for ior in [1.0003f32, 1.003, 1.03] {
            let solid = Solid::new(ior, Rows::ALL);
            for inside in [false, true] {
                let eta = if inside { 1.0 / ior } else { ior };
                let interface = Interface::new(eta, ior);
                let (least, bound) = if inside {
                    (1e-3f32, 0.03)
                } else {
                    (1e-4, 5e-3)
                };
                for roughness in [0.1f32, 0.3, 0.57, 0.98] {
                    for step in 0..30 {
                        let cos =
                            least.powf(step as f32 / 30.0) * 0.1f32.powf(1.0 - step as f32 / 30.0);
                        let view = View::new(f64::from(cos), f64::from(roughness * roughness));
                        let exact = Quadrature::get().both(&view, &interface);
                        let found =
                            f64::from(solid.both(LutCoordinate::new(cos, roughness), inside));
                        assert!(
                            (exact / found - 1.0).abs() < bound,
                            "{ior} {inside} {roughness} {cos}: {found} {exact}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn columns_are_the_inverse_of_places() {
        for row in 0..ROUGHNESSES {
            let roughness = row as f32 / (ROUGHNESSES - 1) as f32;
            for column in 0..COSINES {
                let place =
                    LutCoordinate::new(column_cosine(column, row_alpha(row)) as f32, roughness);
                let x = (place.index % COSINES) as f32 + place.along;
                // The axis has a slope of up to 1/α, and f32 resolves cosθ near 1 to 6e-8 of that.
                assert!((x - column as f32).abs() < 0.01, "{row} {column}: {x}");
            }
        }
    }

    #[test]
    fn a_mirror_reflects_as_its_interface_does() {
        let table = Dielectric::new(1.5, Rows::ALL);
        for cos in [1.0f32, 0.7, 0.3, 0.1, 0.02] {
            let found = table.effective_cosine(LutCoordinate::new(cos, 0.0));
            // 2⁻²⁴ of the bisection, and the reflectance's own digits where it is flat.
            let (a, b) = (smooth_blend(found, 1.5), smooth_blend(cos, 1.5));
            assert!((a - b).abs() < 2e-3 * b + 1e-5, "{cos}: {a} {b}");
        }
    }

    /// Tables of some rows alone have the bits of those of all of them, wherever they are read.
    #[test]
    fn some_rows_read_as_all_of_them() {
        let coat = Dielectric::new(1.4, Rows::ALL);
        let solids = [1.4, 1.03].map(|ior| (ior, Solid::new(ior, Rows::ALL)));
        for (least, greatest) in [
            (0.5, 0.5),
            (0.0, 0.1),
            (0.3, 1.0),
            (1.0, 1.0),
            (20.0 / 39.0, 20.0 / 39.0),
        ] {
            let rows = Rows::between(least, greatest);
            let few = Dielectric::new(1.4, rows);
            let few_solids = solids
                .each_ref()
                .map(|(ior, all)| (all, Solid::new(*ior, rows)));
            for k in 0..=8u8 {
                let roughness = mix(least, greatest, f32::from(k) / 8.0);
                for cos in [0.0, 0.01, 0.3, 1.0] {
                    let place = LutCoordinate::new(cos, roughness);
                    assert_eq!(coat.effective_cosine(place), few.effective_cosine(place));
                    for (inside, (all, few)) in [false, true]
                        .into_iter()
                        .flat_map(|i| few_solids.iter().map(move |s| (i, s)))
                    {
                        assert_eq!(all.both(place, inside), few.both(place, inside));
                    }
                }
            }
        }
    }

    #[test]
    fn refraction_obeys_snell() {
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let f = fresnel::dielectric(0.8, 1.5);
        let wi = refract(wo, Vec3::Z, f.cos_t, 1.5);
        assert!((wi.length() - 1.0).abs() < 1e-6 && (wi.x + 0.4).abs() < 1e-6 && wi.z < 0.0);
        // Masking in f64 is the kernel's.
        let v = Vec3::new(0.0, 0.8, 0.6);
        assert!(
            (lambda(f64::from(v.z), 0.3) - f64::from(ggx::lambda(v, &ggx::Alpha::isotropic(0.3))))
                .abs()
                < 1e-6
        );
    }
}
