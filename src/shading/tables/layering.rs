//! What a reflecting layer leaves to the base below it, as Cycles estimates it: by tables as coarse as its own.
//!
//! The exact albedo of the layer would keep the energy at every angle, but not give Cycles' picture: of a floor of roughness 0.5 it
//! left 0.5 % more light at 75° and 1 % more at 85°, and of one of roughness 0.1 it left 2.7 % less at 88°. Cycles' estimate has the
//! mean Fresnel term of all facets that reflect to above the surface, however they mask each other, and is linear between 16 points
//! of the roughness, of the cosine and of the root of the index's reflectance. The albedo with reflectance 1 has 32 points.

use super::quadrature::{Quadrature, View};
use super::{Reflection, smooth_blend};
use crate::math::mix;
use crate::shading::fresnel::Fresnel;
use glam::Vec3;
use std::sync::OnceLock;

/// Points over roughness, cosine and index of the mean Fresnel term.
const POINTS: usize = 16;
/// Points over roughness and cosine of the albedo.
const FINE: usize = 32;
/// The first point of the cosines: of exactly grazing views only limits exist.
const LEAST_COSINE: f64 = 1e-4;
/// The last point of the indices stands for an infinite one, which has no reflectance to compare with.
const GREATEST_INDEX: f32 = 1e4;

/// Values over the cosine.
type Row<const N: usize> = OnceLock<[f32; N]>;

/// α and the cosine of a point of the tables.
fn view(row: usize, column: usize, points: usize) -> (f64, f64) {
    let at = |i: usize| i as f64 / (points - 1) as f64;
    (at(row) * at(row), at(column).max(LEAST_COSINE))
}

/// The mean Fresnel terms of a roughness and an index.
fn blends(index: usize, row: usize) -> &'static [f32; POINTS] {
    static ROWS: [[Row<POINTS>; POINTS]; POINTS] =
        [const { [const { OnceLock::new() }; POINTS] }; POINTS];
    ROWS[index][row].get_or_init(|| {
        let root = index as f32 / (POINTS - 1) as f32;
        let z = root * root;
        let ior = ((1.0 + z) / (1.0 - z)).min(GREATEST_INDEX);
        let blend = |cos: f32| smooth_blend(cos, ior).clamp(0.0, 1.0);
        std::array::from_fn(|column| {
            let (alpha, cos) = view(row, column, POINTS);
            if index == 0 {
                return 0.0;
            }
            if alpha == 0.0 {
                return blend(cos as f32);
            }
            Quadrature::get().seen(&View::new(cos, alpha), blend) as f32
        })
    })
}

/// The means of Schlick's term of a roughness. Cycles' table is of other exponents, 5 (1/z − 1) at points of z: that of 5 lies midway
/// between two of them.
fn schlicks(row: usize) -> &'static [f32; POINTS] {
    static ROWS: [Row<POINTS>; POINTS] = [const { OnceLock::new() }; POINTS];
    ROWS[row].get_or_init(|| {
        let term = |cos: f32| {
            let m = (1.0 - cos).clamp(0.0, 1.0);
            0.5 * (m.powf(40.0 / 7.0) + m.powf(35.0 / 8.0))
        };
        std::array::from_fn(|column| {
            let (alpha, cos) = view(row, column, POINTS);
            if alpha == 0.0 {
                return term(cos as f32);
            }
            Quadrature::get().seen(&View::new(cos, alpha), term) as f32
        })
    })
}

/// The mean reflectance of a metal's facets for a view cosine and a perceptual roughness, as Cycles tells it in its passes of
/// colours; of others that of a smooth surface.
pub fn metal_estimate(metal: &Fresnel, cos: f32, roughness: f32) -> Vec3 {
    let (Fresnel::Schlick { f0 } | Fresnel::Tinted { f0, .. }) = *metal else {
        return metal.reflectance(cos);
    };
    let (row, up) = cell(roughness, POINTS);
    let blend = bilinear([row, row + 1].map(schlicks), cell(cos, POINTS), up);
    f0 + (Vec3::ONE - f0) * blend
}

/// The albedos of a roughness.
fn albedos(row: usize) -> &'static [f32; FINE] {
    static ROWS: [Row<FINE>; FINE] = [const { OnceLock::new() }; FINE];
    ROWS[row].get_or_init(|| {
        std::array::from_fn(|column| {
            let (alpha, cos) = view(row, column, FINE);
            if alpha == 0.0 {
                return 1.0;
            }
            let view = View::new(cos, alpha);
            Quadrature::get().reflection(&view, |_| 0.0).0.min(1.0) as f32
        })
    })
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
pub fn facet_blend((cos, roughness): (f32, f32), eta: f32) -> f32 {
    // Of an index and of its inverse the same: as in Cycles no base gets the light that total reflection keeps.
    let root = ((eta - 1.0) / (eta + 1.0)).abs().sqrt();
    let (row, up) = cell(roughness, POINTS);
    let column = cell(cos, POINTS);
    let (index, between) = cell(root, POINTS);
    let of = |index: usize| bilinear([row, row + 1].map(|row| blends(index, row)), column, up);
    mix(of(index), of(index + 1), between)
}

/// What a layer of a dielectric reflects, as its base sees it, for a view cosine and a perceptual roughness.
///
/// `f0` and `average`: the reflectance at normal incidence, and over all angles. `all`: albedos of its roughness, none where nothing
/// scatters further.
#[inline]
pub fn layer_albedo(
    (cos, roughness): (f32, f32),
    eta: f32,
    [f0, average]: [Vec3; 2],
    all: Option<&Reflection>,
) -> Vec3 {
    let reflectance = f0 + (Vec3::ONE - f0) * facet_blend((cos, roughness), eta);
    let Some(all) = all else {
        return reflectance;
    };
    let (row, up) = cell(roughness, FINE);
    let coarse = Reflection {
        directional: bilinear([row, row + 1].map(albedos), cell(cos, FINE), up),
        average: all.average,
    };
    reflectance * coarse.compensation(average) * coarse.directional
}

#[cfg(test)]
#[path = "../../../tests/unit/shading/tables/layering.rs"]
mod tests;
