//! Albedo tables of a material's transmitting solid, and the index of its layer over the diffuse base.

use super::fresnel;
use super::tables::{Estimate, Indices, Rows, Solids};

/// Albedo tables of the dielectrics that a material needs.
#[derive(Debug)]
pub struct Dielectrics {
    /// Tables of the transmitting solid.
    pub(super) solid: Option<Solids>,
    /// What a layer leaves to its base, where its index is below 1.
    pub(super) below_one: Estimate,
}

/// Which tables a material needs.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// Indices of the transmitting solid, if it is.
    pub solid: Option<Indices>,
    /// For which roughnesses.
    pub rows: Rows,
    /// Of what.
    pub estimate: Estimate,
    /// What a layer of an index below 1 leaves to its base.
    pub below_one: Estimate,
}

/// Bits of the solid's indices, the roughnesses, and what is tabulated and left to bases.
pub type Key = (Option<[u32; 2]>, Rows, [Estimate; 2]);

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
        let estimates = [self.estimate, self.below_one];
        (self.solid.map(Indices::bits), self.rows, estimates)
    }
}

impl Dielectrics {
    /// Tables for a material whose index is the same everywhere.
    pub fn new(ior: f32, transmits: bool) -> Self {
        Self::needed(&Needs {
            solid: transmits.then_some(Indices::One(ior)),
            rows: Rows::ALL,
            estimate: Estimate::Exact,
            below_one: Estimate::Exact,
        })
    }

    /// As far as they are needed.
    pub fn needed(needs: &Needs) -> Self {
        let solid = |indices| Solids::new(indices, needs.rows, needs.estimate);
        Self {
            solid: needs.solid.map(solid),
            below_one: needs.below_one,
        }
    }
}
