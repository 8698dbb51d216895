//! BSDFs: lobes ([`closure`]), the list of them at a point ([`Bsdf`]), and what shader nodes make of them.

pub mod bsdf;
pub mod closure;
pub mod dielectrics;
pub mod dispersion;
pub mod fibres;
pub mod fresnel;
pub mod ggx;
pub mod layers;
pub mod normal;
pub mod pane;
pub mod principled;
pub mod program;
pub mod simple;
pub mod spread;
pub mod tables;
pub mod texture;
pub mod thin_film;

pub use bsdf::{Bsdf, BsdfSample, Changes, Scattering};
pub use closure::{AllFeatures, BsdfFeatures, Normals};
pub use dielectrics::Dielectrics;
pub use principled::{Principled, turned};
