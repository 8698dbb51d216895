//! What a reflecting layer leaves to the base below it, as Cycles estimates it: by tables as coarse as its own.
//!
//! The exact albedo of the layer would keep the energy at every angle, but not give Cycles' picture: of a floor of roughness 0.5 it
//! left 0.5 % more light at 75° and 1 % more at 85°, and of one of roughness 0.1 it left 2.7 % less at 88°. Cycles' estimate has the
//! mean Fresnel term of all facets that reflect to above the surface, however they mask each other. Until 5.2 it is linear between
//! 16 points of the roughness, of the cosine and of the root of the index's reflectance, and from 5.3 on between 32 points of the
//! roughness, of the root of the cosine and of that of the index's reflectance. The albedo with reflectance 1 has 32 points.

use super::quadrature::{Quadrature, View};
use super::{Reflection, smooth_blend};
use crate::math::mix;
use crate::scene::graph::ShaderRules;
use crate::shading::fresnel::Fresnel;
use glam::Vec3;
use std::sync::OnceLock;

/// Points over roughness and cosine of the albedo.
const FINE: usize = 32;
/// The first point of the cosines: of exactly grazing views only limits exist.
const LEAST_COSINE: f64 = 1e-4;
/// The last point of the indices stands for an infinite one, which has no reflectance to compare with.
const GREATEST_INDEX: f32 = 1e4;

/// Values over the cosine.
type Row<const N: usize> = OnceLock<[f32; N]>;

/// The points over the cosine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cosines {
    /// Even.
    Even,
    /// Even in the root.
    Rooted,
}

impl Cosines {
    /// The cosine at a share of the axis.
    fn at(self, share: f64) -> f64 {
        match self {
            Self::Even => share,
            Self::Rooted => share * share,
        }
        .max(LEAST_COSINE)
    }

    /// The share of the axis at a cosine.
    #[inline]
    fn share(self, cos: f32) -> f32 {
        match self {
            Self::Even => cos,
            Self::Rooted => cos.max(0.0).sqrt(),
        }
    }
}

/// Where a point is on an axis from 0 to 1.
fn share(point: usize, points: usize) -> f64 {
    point as f64 / (points - 1) as f64
}

/// α of a row.
fn alpha(row: usize, points: usize) -> f64 {
    share(row, points).powi(2)
}

/// Tables of the mean Fresnel term.
struct Means<const N: usize> {
    cosines: Cosines,
    /// By index of refraction and roughness.
    dielectric: [[Row<N>; N]; N],
    /// Of Schlick's term, by roughness.
    schlick: [Row<N>; N],
}

/// Those of Cycles until 5.2, and from 5.3 on.
static BEFORE_5_3: Means<16> = Means::new(Cosines::Even);
static SINCE_5_3: Means<32> = Means::new(Cosines::Rooted);

impl<const N: usize> Means<N> {
    const fn new(cosines: Cosines) -> Self {
        Self {
            cosines,
            dielectric: [const { [const { OnceLock::new() }; N] }; N],
            schlick: [const { OnceLock::new() }; N],
        }
    }

    /// A row: of a mirror the term itself.
    fn row(&self, row: usize, term: impl Fn(f32) -> f32) -> [f32; N] {
        let alpha = alpha(row, N);
        std::array::from_fn(|column| {
            let cos = self.cosines.at(share(column, N));
            if alpha == 0.0 {
                return term(cos as f32);
            }
            Quadrature::get().seen(&View::new(cos, alpha), &term) as f32
        })
    }

    /// The mean Fresnel terms of a roughness and an index.
    fn dielectric(&self, index: usize, row: usize) -> &[f32; N] {
        self.dielectric[index][row].get_or_init(|| {
            let root = index as f32 / (N - 1) as f32;
            let z = root * root;
            let ior = ((1.0 + z) / (1.0 - z)).min(GREATEST_INDEX);
            if index == 0 {
                return [0.0; N];
            }
            self.row(row, |cos| smooth_blend(cos, ior).clamp(0.0, 1.0))
        })
    }

    /// The means of Schlick's term of a roughness. Cycles' table is of other exponents, 5 (1/z − 1) at points of z: that of 5 lies
    /// midway between two of them.
    fn schlick(&self, row: usize) -> &[f32; N] {
        self.schlick[row].get_or_init(|| {
            let half = (N / 2) as f32;
            let ratio = half / (half - 1.0);
            self.row(row, |cos| {
                let m = (1.0 - cos).clamp(0.0, 1.0);
                0.5 * (m.powf(5.0 * ratio) + m.powf(5.0 / ratio))
            })
        })
    }

    #[inline]
    fn facet_blend(&self, (cos, roughness): (f32, f32), eta: f32) -> f32 {
        // Of an index and of its inverse the same, as in Cycles, whose base gets light that total reflection keeps, too.
        let root = ((eta - 1.0) / (eta + 1.0)).abs().sqrt();
        let (row, up) = cell(roughness, N);
        let column = cell(self.cosines.share(cos), N);
        let (index, between) = cell(root, N);
        let of = |index: usize| {
            let rows = [row, row + 1].map(|row| self.dielectric(index, row));
            bilinear(rows, column, up)
        };
        mix(of(index), of(index + 1), between)
    }

    fn schlick_blend(&self, (cos, roughness): (f32, f32)) -> f32 {
        let (row, up) = cell(roughness, N);
        let rows = [row, row + 1].map(|row| self.schlick(row));
        bilinear(rows, cell(self.cosines.share(cos), N), up)
    }
}

/// The mean reflectance of a metal's facets for a view cosine and a perceptual roughness, as Cycles tells it in its passes of
/// colours; of others that of a smooth surface.
pub fn metal_estimate(metal: &Fresnel, (cos, roughness): (f32, f32), rules: ShaderRules) -> Vec3 {
    let (Fresnel::Schlick { f0 } | Fresnel::Tinted { f0, .. }) = *metal else {
        return metal.reflectance(cos);
    };
    let blend = match rules {
        ShaderRules::Before53 => BEFORE_5_3.schlick_blend((cos, roughness)),
        ShaderRules::Since53 => SINCE_5_3.schlick_blend((cos, roughness)),
    };
    f0 + (Vec3::ONE - f0) * blend
}

/// The albedo with reflectance 1 for a view cosine and a perceptual roughness.
#[inline]
fn albedo((cos, roughness): (f32, f32), rules: ShaderRules) -> f32 {
    static EVEN: [Row<FINE>; FINE] = [const { OnceLock::new() }; FINE];
    static ROOTED: [Row<FINE>; FINE] = [const { OnceLock::new() }; FINE];
    let (rows, cosines) = match rules {
        ShaderRules::Before53 => (&EVEN, Cosines::Even),
        ShaderRules::Since53 => (&ROOTED, Cosines::Rooted),
    };
    let of_row = |row: usize| {
        rows[row].get_or_init(|| {
            std::array::from_fn(|column| {
                let alpha = alpha(row, FINE);
                if alpha == 0.0 {
                    return 1.0;
                }
                let view = View::new(cosines.at(share(column, FINE)), alpha);
                Quadrature::get().reflection(&view, |_| 0.0).0.min(1.0) as f32
            })
        })
    };
    let (row, up) = cell(roughness, FINE);
    let column = cell(cosines.share(cos), FINE);
    bilinear([row, row + 1].map(of_row), column, up)
}

/// The cell of an x in 0..=1 among points, and where in it.
#[inline]
fn cell(x: f32, points: usize) -> (usize, f32) {
    super::cell(x.max(0.0), points)
}

#[inline]
fn bilinear<const N: usize>(rows: [&[f32; N]; 2], (column, along): (usize, f32), up: f32) -> f32 {
    let [low, high] = rows.map(|row| mix(row[column], row[column + 1], along));
    mix(low, high, up)
}

/// How far the mean reflectance of the facets of a dielectric has come from that at normal incidence to 1, for a view cosine and a
/// perceptual roughness.
#[inline]
pub fn facet_blend(view: (f32, f32), eta: f32, rules: ShaderRules) -> f32 {
    match rules {
        ShaderRules::Before53 => BEFORE_5_3.facet_blend(view, eta),
        ShaderRules::Since53 => SINCE_5_3.facet_blend(view, eta),
    }
}

/// What a layer of a dielectric reflects, as its base sees it, for a view cosine and a perceptual roughness.
///
/// `f0` and `average`: the reflectance at normal incidence, and over all angles. `all`: albedos of its roughness, none where nothing
/// scatters further or where that is not counted.
#[inline]
pub fn layer_albedo(
    view: (f32, f32),
    (eta, rules): (f32, ShaderRules),
    [f0, average]: [Vec3; 2],
    all: Option<&Reflection>,
) -> Vec3 {
    let reflectance = f0 + (Vec3::ONE - f0) * facet_blend(view, eta, rules);
    let Some(all) = all else {
        return reflectance;
    };
    let coarse = Reflection {
        directional: albedo(view, rules),
        average: all.average,
    };
    reflectance * coarse.compensation(average) * coarse.directional
}

/// The same of an index below 1, without gain: total reflection leaves nothing to the base. Integrated for each view, since such
/// layers are rare and the reflectance bends where it becomes total: no table that is linear between a few points has that.
#[cold]
#[inline(never)]
pub fn albedo_below_one(
    (cos, roughness): (f32, f32),
    eta: f32,
    [f0, average]: [Vec3; 2],
    all: Option<&Reflection>,
) -> Vec3 {
    let blend = |cos: f32| smooth_blend(cos, eta).clamp(0.0, 1.0);
    if roughness == 0.0 {
        return f0 + (Vec3::ONE - f0) * blend(cos);
    }
    let alpha = f64::from(roughness).powi(2).max(super::LEAST_ALPHA);
    let view = View::new(f64::from(cos).clamp(LEAST_COSINE, 1.0), alpha);
    // Sines above the index are reflected totally.
    let critical = (1.0 - f64::from(eta).powi(2)).max(0.0).sqrt();
    let (whole, blended) = Quadrature::get().reflection_below_one(&view, critical, blend);
    let once = f0 * whole as f32 + (Vec3::ONE - f0) * blended as f32;
    all.map_or(once, |all| once * all.compensation(average))
}

#[cfg(test)]
#[path = "../../../tests/unit/shading/tables/layering.rs"]
mod tests;
