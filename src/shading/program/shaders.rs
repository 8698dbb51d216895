//! The shaders of a material, their sockets ready to be read.

use super::Root;
use crate::scene::graph::{Distribution, HairModel, ShaderRules, SimpleBsdf};
use crate::shading::Principled;

/// What a shader of a surface does, its sockets ready to be read.
#[derive(Clone, Debug)]
pub enum Shader {
    /// A Principled BSDF.
    Principled {
        /// What stands in its sockets where it is known.
        base: Principled,
        /// The other sockets, metallic first.
        linked: Vec<(usize, Root)>,
        /// The normal map, if it has one.
        normal: Option<Root>,
        /// The tangent, if it is anisotropic.
        tangent: Option<Root>,
        /// What lies over it.
        layers: Option<Box<LayerRoots>>,
    },
    /// A Diffuse BSDF.
    Diffuse {
        /// Its colour.
        color: Root,
        /// Its roughness.
        roughness: Root,
        /// The normal map, if it has one.
        normal: Option<Root>,
        /// Whose version it follows where it is rough.
        rules: ShaderRules,
    },
    /// A Glossy BSDF.
    Glossy {
        /// Its colour.
        color: Root,
        /// Roughness.
        roughness: Root,
        /// Anisotropy, −1 to 1.
        anisotropy: Root,
        /// Rotation of the tangent, in turns.
        rotation: Root,
        /// The normal map, if it has one.
        normal: Option<Root>,
        /// The tangent, if it is anisotropic.
        tangent: Option<Root>,
        /// The spread of its facets.
        distribution: Distribution,
    },
    /// A shader of one lobe.
    Simple {
        /// Which.
        bsdf: SimpleBsdf,
        /// Its sockets; those for normals and tangents are not read.
        sockets: Vec<Root>,
        /// The normal map, if it has one.
        normal: Option<Root>,
        /// The tangent, if it is anisotropic.
        tangent: Option<Root>,
    },
}

/// The sockets of a coat.
#[derive(Clone, Debug)]
pub struct CoatRoots {
    /// Its share.
    pub weight: Root,
    /// Roughness.
    pub roughness: Root,
    /// Index of refraction.
    pub ior: Root,
    /// Colour.
    pub tint: Root,
    /// Its own normal map, if it has one.
    pub normal: Option<Root>,
}

/// What lies over a Principled BSDF's base.
#[derive(Clone, Debug)]
pub struct LayerRoots {
    /// The coat.
    pub coat: Option<CoatRoots>,
    /// Weight, roughness and tint of the fibres.
    pub fibres: Option<[Root; 3]>,
    /// Whose version it follows.
    pub rules: ShaderRules,
}

impl LayerRoots {
    /// All of them.
    pub(super) fn roots(&mut self) -> impl Iterator<Item = &mut Root> {
        let coat = self.coat.iter_mut().flat_map(|coat| {
            let CoatRoots {
                weight,
                roughness,
                ior,
                tint,
                normal,
            } = coat;
            [weight, roughness, ior, tint].into_iter().chain(normal)
        });
        coat.chain(self.fibres.iter_mut().flatten())
    }
}

/// A shader and its share of the surface.
#[derive(Clone, Debug)]
pub struct Weighted {
    /// Its share of what does not pass straight on.
    pub weight: Root,
    /// What it is.
    pub shader: Shader,
}

impl Shader {
    /// The normal map of the shader.
    pub fn normal(&self) -> Option<&Root> {
        match self {
            Self::Principled { normal, .. }
            | Self::Diffuse { normal, .. }
            | Self::Glossy { normal, .. }
            | Self::Simple { normal, .. } => normal.as_ref(),
        }
    }

    /// Whether it sends rays elsewhere.
    pub fn is_portal(&self) -> bool {
        matches!(
            self,
            Self::Simple {
                bsdf: SimpleBsdf::RayPortal { .. },
                ..
            }
        )
    }

    /// Whether it is of fibres whose directions are drawn otherwise than they are evaluated, as in Cycles: what is found hangs on which
    /// way finds it.
    pub fn draws_other_fibres(&self) -> bool {
        let Self::Simple { bsdf, .. } = self else {
            return false;
        };
        match bsdf {
            SimpleBsdf::Hair { transmits } => !transmits,
            SimpleBsdf::PrincipledHair(fibre) => fibre.model == HairModel::Huang,
            _ => false,
        }
    }

    /// Whether light goes on below it.
    pub fn goes_below(&self) -> bool {
        match self {
            Self::Principled { base, .. } => base.below.is_some(),
            Self::Simple { bsdf, .. } => matches!(bsdf, SimpleBsdf::Subsurface(_)),
            Self::Diffuse { .. } | Self::Glossy { .. } => false,
        }
    }

    /// Its tangent, if it is anisotropic.
    pub fn tangent(&self) -> Option<&Root> {
        match self {
            Self::Principled { tangent, .. }
            | Self::Glossy { tangent, .. }
            | Self::Simple { tangent, .. } => tangent.as_ref(),
            Self::Diffuse { .. } => None,
        }
    }
}
