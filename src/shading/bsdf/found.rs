//! What a BSDF says of a direction.

use super::Scattering;
use glam::Vec3;

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Direction to go on, world space.
    pub wi: Vec3,
    /// BSDF · |cos| / density.
    pub weight: Vec3,
    /// The part of `weight` that is due to diffuse lobes.
    pub diffuse: Vec3,
    /// Density per solid angle; meaningless if `delta`.
    pub pdf: f32,
    /// Whether the direction could not have been found otherwise.
    pub delta: bool,
    /// `wi` is on the other side of the surface.
    pub beyond: bool,
    /// The kind of lobe that was drawn; `Transmission` if `wi` is on the other side of the surface, but for fibres, whose ways through
    /// them it is.
    pub scattering: Scattering,
    /// Weight and density for an estimate of the lobes of that kind alone, beside which the others have their own.
    pub alone: (Vec3, f32),
    /// A glossy lobe was drawn, and in Cycles a diffuse one would have been: both can draw the direction, and a glossy lobe of Cycles
    /// draws it more seldom.
    pub is_as_diffuse: bool,
    /// The lobe that was drawn is a diffuse one that lets light through.
    pub is_translucent: bool,
    /// α of the lobe that was drawn, if `beyond`: 0 of clear glass, 1 of lobes without facets.
    pub alpha: f32,
}

/// The value of the BSDF for two directions.
#[derive(Clone, Copy, Debug)]
pub struct BsdfValue {
    /// BSDF · |cos|.
    pub value: Vec3,
    /// The part of `value` that is due to diffuse lobes. The rest is glossy on the viewer's side of
    /// the surface and transmission beyond it.
    pub diffuse: Vec3,
    /// Density with which [`Bsdf::sample`] finds the direction, per solid angle.
    pub pdf: f32,
    /// The part of `pdf` that is due to diffuse lobes.
    pub diffuse_pdf: f32,
}

impl BsdfValue {
    pub(super) const ZERO: Self = Self {
        value: Vec3::ZERO,
        diffuse: Vec3::ZERO,
        pdf: 0.0,
        diffuse_pdf: 0.0,
    };
}
