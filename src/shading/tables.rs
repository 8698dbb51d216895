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

mod layering;
mod quadrature;

mod solids;
pub use layering::{albedo_below_one, facet_blend, layer_albedo, metal_estimate};
pub use solids::{Indices, Solids};

use super::fresnel;
use crate::math::mix;
use glam::Vec3;
use quadrature::{Interface, Quadrature, View};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Points of the grid over the cosine.
const COSINES: usize = 40;
/// Points of the grid over the roughness.
const ROUGHNESSES: usize = 40;
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
    /// Tabulates a function of the cosine and α, on all threads; the columns before one are not read.
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
    /// F_ms = F̄ E_avg / (1 − F̄ (1 − E_avg)). Of facets that make light the sum is kept from growing beyond all bounds.
    #[inline]
    pub fn compensation(&self, f_average: Vec3) -> Vec3 {
        let (e, e_average) = (self.directional, self.average);
        // No more than nine tenths of what facets give meet others: that is above an F̄ of 1.6 at least, where E_avg is 0.45.
        let f_average = f_average.min(Vec3::splat(0.9 / (1.0 - e_average).max(1e-6)));
        let f_ms = f_average * e_average / (Vec3::ONE - f_average * (1.0 - e_average));
        Vec3::ONE + f_ms * ((1.0 - e) / e)
    }
}

/// What is tabulated of a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Estimate {
    /// Its albedo: white glass keeps its light.
    #[default]
    Exact,
    /// Cycles' table, for files from Blender: it counts what facets refract to the side of the viewer, too, though no lobe has that
    /// light. Rough glass that is seen from within at grazing angles gets back too little.
    Cycles,
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
    /// Cosine-weighted means, by row.
    averages: Vec<f32>,
    rows: Rows,
}

impl Side {
    fn with_averages(mut self) -> Self {
        let n = 64;
        let mean = |row: usize| {
            let first = row.min(self.rows.last - 1);
            let at = |k: usize| {
                let cos = (k as f32 + 0.5) / n as f32;
                let roughness = row as f32 / (ROUGHNESSES - 1) as f32;
                let mut place = LutCoordinate::new(cos, roughness);
                // Rows beyond those that are there are not read.
                place.index = first * COSINES + place.index % COSINES;
                place.up = (row - first) as f32;
                2.0 * cos * self.read(place) / n as f32
            };
            (0..n).map(at).sum()
        };
        self.averages = (self.rows.first..=self.rows.last).map(mean).collect();
        self
    }

    #[inline]
    fn read(&self, place: LutCoordinate) -> f32 {
        match &self.grazing {
            Some(grazing) if place.index % COSINES < grazing.points.columns => grazing.read(place),
            _ => self.table.read(place),
        }
    }

    fn average(&self, place: LutCoordinate) -> f32 {
        let row = place.index / COSINES - self.rows.first;
        mix(self.averages[row], self.averages[row + 1], place.up)
    }
}

impl Solid {
    /// Tabulates for an index of refraction (above or below 1).
    pub fn new(ior: f32, rows: Rows, estimate: Estimate) -> Self {
        let quadrature = Quadrature::get();
        let side = |inside: bool| {
            let eta = if inside { 1.0 / ior } else { ior };
            let interface = Interface::new(eta, ior, estimate);
            let albedo = |cos, alpha| {
                let both = quadrature.both(&View::new(cos, alpha), &interface);
                let less = if interface.straight { 1.0 } else { 0.0 };
                (both + less).min(1.0) as f32
            };
            let points = Points::of(ior, inside);
            Side {
                table: Table::tabulate_from(points.map_or(0, |p| p.columns), rows, albedo),
                grazing: points.map(|points| Grazing::tabulate(rows, points, albedo)),
                averages: Vec::new(),
                rows,
            }
            .with_averages()
        };
        Self([side(false), side(true)])
    }

    /// The albedo at a place.
    #[inline]
    pub fn both(&self, place: LutCoordinate, inside: bool) -> f32 {
        self.0[usize::from(inside)].read(place)
    }

    /// By what a single-scattering lobe is scaled that tints what goes through; what further scatterings give back has the
    /// tint of each ([`Reflection::compensation`]).
    #[inline]
    pub fn compensation(&self, place: LutCoordinate, inside: bool, tint: Vec3) -> Vec3 {
        let side = &self.0[usize::from(inside)];
        let directional = side.read(place);
        if tint == Vec3::ONE {
            return Vec3::splat(1.0 / directional);
        }
        let average = side.average(place);
        Reflection {
            directional,
            average,
        }
        .compensation(tint)
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
#[path = "../../tests/unit/shading/tables.rs"]
mod tests;
