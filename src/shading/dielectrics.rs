//! Albedo tables of a material's dielectrics: its layer over the diffuse base, and its transmitting solid.

use super::fresnel;
use super::tables::{self, LutCoordinate, Rows};
use crate::math::mix;

/// Albedo tables of the dielectrics that a material needs: of its layer one where its index is the same everywhere, more where it
/// varies.
#[derive(Debug)]
pub struct Dielectrics {
    /// Tables of the reflecting layer, or none where nobody reads them.
    layer: Vec<tables::Dielectric>,
    /// Of the first and the last one the root of the reflectance at normal incidence.
    roots: (f32, f32),
    /// Tables of the transmitting solid.
    pub(super) solid: Option<tables::Solid>,
}

/// Which tables a material needs.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// Least and greatest index of the layer, if it is rough somewhere: what is smooth reads no table.
    pub layer: Option<(f32, f32)>,
    /// Index of the transmitting solid, if it is.
    pub solid: Option<f32>,
    /// For which roughnesses.
    pub rows: Rows,
}

/// Bits of the layer's and of the solid's indices, and the roughnesses.
pub type Key = ([Option<u32>; 3], Rows);

/// Tables less one where the index varies.
const STEPS: usize = 8;
/// They are even in this root of the root of the reflectance at normal incidence, |η − 1| / (η + 1): the cosine changes most near
/// an index of 1. Between indices of 0.3 and 3.5 the reflectance is at most 0.3 % off (7.5 % if they were even).
const SPACING: f32 = 2.5;
/// The least such root as a share of the greatest: the tables have no limit at 0, where the
/// reflectance is a spike at grazing views, but hardly change below this either.
const LEAST_ROOT: f32 = 1e-3;
/// The greatest, of an index of 4: few links to an index come near their bounds, and beyond the tables hardly change.
const GREATEST_ROOT: f32 = 0.6;

/// The root of the reflectance at normal incidence.
#[inline]
fn root_of(eta: f32) -> f32 {
    ((eta - 1.0) / (eta + 1.0)).abs()
}

/// The index of refraction whose reflectance at normal incidence is `specular` times that of `ior`.
pub(super) fn layer_ior(ior: f32, specular: f32) -> f32 {
    if specular == 1.0 {
        return ior;
    }
    let adjusted = fresnel::ior_from_f0(fresnel::f0_from_ior(ior) * specular);
    if ior < 1.0 { 1.0 / adjusted } else { adjusted }
}

impl Needs {
    /// What tells its tables from others.
    pub fn key(&self) -> Key {
        let ends = self.layer.unzip();
        let bits = |index: Option<f32>| index.map(f32::to_bits);
        ([bits(ends.0), bits(ends.1), bits(self.solid)], self.rows)
    }

    /// The indices of a layer, for the ends of the material's index and of its specular factor.
    pub fn layer_indices(ior: (f32, f32), specular: (f32, f32)) -> (f32, f32) {
        // An index of 0 stands for an infinite one, an end of 0 for what is near it.
        let least = if ior.0 < ior.1 {
            ior.0.max(1e-4)
        } else {
            ior.0
        };
        let all = [least, ior.1].map(fresnel::bounded_ior);
        let indices = all.map(|ior| [specular.0, specular.1].map(|factor| layer_ior(ior, factor)));
        let indices = indices.as_flattened();
        let least = indices.iter().copied().fold(f32::INFINITY, f32::min);
        (least, indices.iter().copied().fold(0.0, f32::max))
    }
}

impl Dielectrics {
    /// Tables for a material whose index and specular factor are the same everywhere.
    pub fn new(ior: f32, specular: f32, transmits: bool) -> Self {
        let index = layer_ior(fresnel::bounded_ior(ior), specular);
        Self::needed(&Needs {
            layer: Some((index, index)),
            solid: transmits.then_some(ior),
            rows: Rows::ALL,
        })
    }

    /// As far as they are needed.
    pub fn needed(needs: &Needs) -> Self {
        let rows = needs.rows;
        let table = |index: f32| tables::Dielectric::new(index, rows);
        let (layer, roots) = match needs.layer {
            None => (Vec::new(), (0.0, 0.0)),
            Some((least, greatest)) if least == greatest => (vec![table(least)], (0.0, 0.0)),
            Some((least, greatest)) => {
                let ends = [least, greatest].map(root_of);
                let most = ends[0].max(ends[1]).clamp(1e-4, GREATEST_ROOT);
                let nearest = if (least < 1.0) == (greatest < 1.0) {
                    ends[0].min(ends[1])
                } else {
                    0.0
                };
                let first = nearest.clamp(most * LEAST_ROOT, most);
                let at = |i: usize| mix(first, most, (i as f32 / STEPS as f32).powf(SPACING));
                let of_root = |root: f32| (1.0 + root) / (1.0 - root);
                let layer = (0..=STEPS).map(|i| table(of_root(at(i))));
                (layer.collect(), (first, most))
            }
        };
        Self {
            layer,
            roots,
            solid: needs
                .solid
                .map(|ior| tables::Solid::new(fresnel::bounded_ior(ior), rows)),
        }
    }

    /// (effective cosine at this place or the view's own, mean blend) for the index of the layer.
    #[inline]
    pub(super) fn layer(&self, eta: f32, cos: f32, place: Option<LutCoordinate>) -> (f32, f32) {
        let at = |i: usize| {
            let table = &self.layer[i];
            (
                place.map_or(cos, |p| table.effective_cosine(p)),
                table.average_blend(eta < 1.0),
            )
        };
        match self.layer.len() {
            0 => return (cos, 0.0),
            1 => return at(0),
            _ => {}
        }
        let (first, most) = self.roots;
        let last = self.layer.len() - 1;
        // Both are the same where the index hardly varies.
        let share = (root_of(eta) - first) / (most - first).max(f32::MIN_POSITIVE);
        let x = share.clamp(0.0, 1.0).powf(1.0 / SPACING) * last as f32;
        let i = (x as usize).min(last - 1);
        let (a, b, t) = (at(i), at(i + 1), x - i as f32);
        (mix(a.0, b.0, t), mix(a.1, b.1, t))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/shading/dielectrics.rs"]
mod tests;
