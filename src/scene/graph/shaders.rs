//! Shaders that are nothing but a lobe, and how light goes on below surfaces.

use super::node::{Distribution, Socket};
use super::node::{glass, metallic, ray_portal, sheen, subsurface, toon, translucent};
use super::node::{hair, principled_hair};
use super::node::{principled_volume, volume_absorption, volume_coefficients, volume_scatter};
use crate::nodes::CyclesVersion;

/// The rules of Blender's shaders where 5.3 has changed them: rough diffusion, coats that cover a part, rough panes, and
/// whether a Principled BSDF's anisotropy is of what goes through it, too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShaderRules {
    /// Those until 5.2, and of files that are not Blender's.
    #[default]
    Before53,
    /// Those from 5.3 on.
    Since53,
}

impl ShaderRules {
    /// Those of a version.
    pub fn of(version: CyclesVersion) -> Self {
        if version < CyclesVersion::new(5, 3) {
            Self::Before53
        } else {
            Self::Since53
        }
    }
}

/// Shaders of one lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SimpleBsdf {
    /// Diffuse transmission.
    Translucent,
    /// Refraction at facets, without reflection.
    Refraction {
        /// The spread of the facets.
        distribution: Distribution,
    },
    /// Reflection and refraction, both of the colour.
    Glass {
        /// The spread of the facets.
        distribution: Distribution,
        /// Whose version it follows.
        rules: ShaderRules,
    },
    /// A metal.
    Metallic {
        /// By its complex index of refraction instead of its colours.
        conductor: bool,
        /// The spread of the facets.
        distribution: Distribution,
    },
    /// Fibres.
    Sheen {
        /// Facets that stand on end, instead of fibres.
        velvet: bool,
    },
    /// Light from within a cone.
    Toon {
        /// About the mirrored view instead of the normal.
        glossy: bool,
    },
    /// Light that goes on below the surface.
    Subsurface(Subsurface),
    /// What meets it goes on elsewhere.
    RayPortal {
        /// From a position of its own, and not from where it is.
        moves: bool,
    },
    /// Fibres, by one highlight: the Hair BSDF.
    Hair {
        /// What goes through instead of what is reflected.
        transmits: bool,
    },
    /// Fibres, by the ways of light through them: the Principled Hair BSDF.
    PrincipledHair(HairFibre),
}

/// What a Principled Hair BSDF is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HairFibre {
    /// How fibres scatter light.
    pub model: HairModel,
    /// What their colour follows.
    pub coloring: HairColoring,
    /// Without a link to Random, the number of each strand stands for it.
    pub own_random: bool,
    /// On meshes light that is sampled does not reach one side of its frame, as in Cycles from 5.0 on.
    pub is_masked: bool,
}

/// How fibres of hair scatter light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HairModel {
    /// Chiang, Bitterli, Tappan and Burley, *A Practical and Controllable Hair and Fur Model for Production Path Tracing*, 2016.
    Chiang,
    /// Huang, Hullin and Hanika, *A Microfacet-based Hair Scattering Model*, 2022.
    Huang,
}

/// What the colour of a fibre follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HairColoring {
    /// What much hair of it reflects.
    Reflectance,
    /// Its melanin, with a tint.
    Melanin,
    /// What it absorbs on each radius of way.
    Absorption,
}

impl SimpleBsdf {
    /// Its inputs.
    pub fn sockets(self) -> &'static [Socket] {
        match self {
            Self::Translucent => translucent::SOCKETS,
            Self::Refraction { .. } | Self::Glass { .. } => glass::SOCKETS,
            Self::Metallic { .. } => metallic::SOCKETS,
            Self::Sheen { .. } => sheen::SOCKETS,
            Self::Toon { .. } => toon::SOCKETS,
            Self::Subsurface(_) => subsurface::SOCKETS,
            Self::RayPortal { .. } => ray_portal::SOCKETS,
            Self::Hair { .. } => hair::SOCKETS,
            Self::PrincipledHair(_) => principled_hair::SOCKETS,
        }
    }

    /// Whether light is refracted into a solid.
    pub fn bounds_a_solid(self) -> bool {
        matches!(self, Self::Refraction { .. } | Self::Glass { .. })
    }

    /// Whether light goes through.
    pub fn transmits(self) -> bool {
        matches!(
            self,
            Self::Translucent
                | Self::Refraction { .. }
                | Self::Glass { .. }
                | Self::Hair { .. }
                | Self::PrincipledHair(_)
        )
    }
}

/// What a surface's colour and radius stand for below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WalkMethod {
    /// "Random Walk" from Blender 5.2 on: the radius is the mean free path.
    RandomWalk,
    /// "Random Walk" before, and "Random Walk (Legacy)" since: 4π times less.
    Legacy,
    /// "Random Walk (Skin)": the mean free path hangs on the colour, and half of the light enters diffusely.
    Skin,
    /// "Christensen-Burley": no walk, but how much comes out at which distance.
    Burley,
}

/// How light goes on below a surface: Blender's methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subsurface {
    /// What its numbers stand for.
    pub method: WalkMethod,
    /// None scatters backwards, as in Cycles before 5.2.
    pub never_backward: bool,
    /// Paths that have been scattered diffusely see a diffuse surface, as in Cycles before 5.0.
    pub diffuse_behind_diffuse: bool,
}

/// Shaders of what fills a mesh or all space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VolumeShader {
    /// It takes light.
    Absorption,
    /// It scatters light.
    Scatter(PhaseKind),
    /// It takes, scatters and emits.
    Coefficients(PhaseKind),
    /// The same by colours.
    Principled,
}

/// How a shader's light is spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhaseKind {
    /// Henyey and Greenstein's, of its anisotropy.
    HenyeyGreenstein,
    /// Of particles smaller than the wavelength.
    Rayleigh,
    /// Draine's.
    Draine,
    /// Fournier and Forand's.
    FournierForand,
    /// Mie's.
    Mie,
}

impl VolumeShader {
    /// Its inputs.
    pub fn sockets(self) -> &'static [Socket] {
        match self {
            Self::Absorption => volume_absorption::SOCKETS,
            Self::Scatter(_) => volume_scatter::SOCKETS,
            Self::Coefficients(_) => volume_coefficients::SOCKETS,
            Self::Principled => principled_volume::SOCKETS,
        }
    }
}
