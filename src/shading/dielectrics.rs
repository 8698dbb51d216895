//! Albedo tables of a material's dielectrics: its layer over the diffuse base, and its transmitting solid.

use super::fresnel;
use super::tables::{self, LutCoordinate, Rows};
use crate::math::{mix, sqr};

/// Albedo tables of the dielectrics that a material needs, in the order of the specular factor:
/// one where the factor is constant, more where a texture varies it.
#[derive(Debug)]
pub struct Dielectrics {
    /// Tables of the reflecting layer at specular factors over 0..=`max_specular`, or one for the
    /// constant factor, or none where nobody reads them.
    layer: Vec<tables::Dielectric>,
    /// Greatest specular factor.
    max_specular: f32,
    /// Tables of the transmitting solid.
    pub(super) solid: Option<tables::Solid>,
}

/// Tables over a textured specular factor: evenly spaced over its square root, about as the
/// distance of the index from 1 grows.
const SPECULAR_STEPS: usize = 7;
/// The least of them as a share of the greatest: the tables have no limit at 0, where the
/// reflectance is a spike at grazing views, but hardly change below this either.
const LEAST_SPECULAR: f32 = 1e-4;

/// The index of refraction whose reflectance at normal incidence is `specular` times that of `ior`.
pub(super) fn layer_ior(ior: f32, specular: f32) -> f32 {
    if specular == 1.0 {
        return ior;
    }
    let adjusted = fresnel::ior_from_f0(fresnel::f0_from_ior(ior) * specular);
    if ior < 1.0 { 1.0 / adjusted } else { adjusted }
}

impl Dielectrics {
    /// Tables for a material with a constant or textured specular factor.
    pub fn new(ior: f32, specular: f32, textured: bool, transmits: bool) -> Self {
        Self::needed(ior, specular, textured, (true, transmits), Rows::ALL)
    }

    /// As far as the layer and the solid are rough somewhere (what is smooth reads no table), for some roughnesses.
    pub fn needed(
        ior: f32,
        specular: f32,
        textured: bool,
        (layer, solid): (bool, bool),
        rows: Rows,
    ) -> Self {
        let ior = fresnel::bounded_ior(ior);
        let layer = if !layer {
            Vec::new()
        } else if textured && specular > 0.0 {
            (0..SPECULAR_STEPS)
                .map(|i| sqr(i as f32 / (SPECULAR_STEPS - 1) as f32).max(LEAST_SPECULAR))
                .map(|share| tables::Dielectric::new(layer_ior(ior, specular * share), rows))
                .collect()
        } else {
            vec![tables::Dielectric::new(layer_ior(ior, specular), rows)]
        };
        Self {
            layer,
            max_specular: specular,
            solid: solid.then(|| tables::Solid::new(ior, rows)),
        }
    }

    /// (effective cosine at this place or the view's own, mean blend) for a specular factor.
    #[inline]
    pub(super) fn layer(
        &self,
        specular: f32,
        cos: f32,
        place: Option<LutCoordinate>,
    ) -> (f32, f32) {
        let at = |i: usize| {
            let table = &self.layer[i];
            (
                place.map_or(cos, |p| table.effective_cosine(p)),
                table.average_blend(),
            )
        };
        match self.layer.len() {
            0 => return (cos, 0.0),
            1 => return at(0),
            _ => {}
        }
        let x =
            (specular / self.max_specular).clamp(0.0, 1.0).sqrt() * (self.layer.len() - 1) as f32;
        let i = (x as usize).min(self.layer.len() - 2);
        let (a, b, t) = (at(i), at(i + 1), x - i as f32);
        (mix(a.0, b.0, t), mix(a.1, b.1, t))
    }
}
