//! BSDF lobes and the material made of them.

pub mod bsdf;
pub mod fresnel;
pub mod ggx;
pub mod normal;
pub mod tables;

pub use bsdf::{AllKinds, Bsdf, BsdfSample, Dielectrics, Kinds, Scattering, SurfaceParameters};
