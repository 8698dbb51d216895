//! What can be said of a graph without looking at its images.

use super::super::Effect;
use super::node::{diffuse, emission, glass, glossy, math, mix_shader, principled, transparent};
use super::{
    Graph, Input, Link, MathOperation, NodeKind, Range, ShaderRules, SimpleBsdf, SocketKind, Unit,
};
use glam::Vec3;

/// Sockets of shaders, by what users call the images in them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Slot {
    /// Base colour and opacity, and the colour of what is unlit.
    BaseColor,
    /// Metallic and roughness.
    MetallicRoughness,
    /// Emission.
    Emission,
    /// Strength of a dielectric's reflection.
    Specular,
    /// Its tint.
    SpecularColor,
    /// Transmission.
    Transmission,
}

impl Slot {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::BaseColor,
        Self::MetallicRoughness,
        Self::Emission,
        Self::Specular,
        Self::SpecularColor,
        Self::Transmission,
    ];

    /// The effect that images in it are.
    pub fn effect(self) -> Effect {
        match self {
            Self::BaseColor => Effect::BaseColorTexture,
            Self::MetallicRoughness => Effect::MetallicRoughnessTexture,
            Self::Emission => Effect::EmissionTexture,
            Self::Specular => Effect::SpecularTexture,
            Self::SpecularColor => Effect::SpecularColorTexture,
            Self::Transmission => Effect::TransmissionTexture,
        }
    }
}

/// How much of the light meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Opacity {
    /// All.
    Full,
    /// It has holes where the opacity is below the threshold.
    Clip {
        /// The threshold.
        cutoff: f32,
        /// Whether the opacity may be below it.
        holes: bool,
    },
    /// A share.
    Blend {
        /// Whether it may be below 1.
        below: bool,
    },
}

/// A Principled BSDF; pairs are the least and the greatest of a number where images are black or white.
#[derive(Clone, Copy, Debug)]
pub struct PrincipledSummary {
    /// Base colour where images are white.
    pub base_color: Vec3,
    /// Metallic.
    pub metallic: (f32, f32),
    /// Roughness.
    pub roughness: (f32, f32),
    /// The most that it is anisotropic, 0..=1.
    pub anisotropy: f32,
    /// Index of refraction.
    pub ior: (f32, f32),
    /// Scales the dielectric's reflectance at normal incidence: twice the specular IOR level.
    pub specular: (f32, f32),
    /// Transmission weight.
    pub transmission: (f32, f32),
    /// Its index of refraction depends on the wavelength.
    pub disperses: bool,
    /// Sheets instead of solids.
    pub thin_wall: bool,
    /// Whose version it follows.
    pub rules: ShaderRules,
}

impl PrincipledSummary {
    /// Whether all of it is metal.
    pub fn is_metal_everywhere(&self) -> bool {
        self.metallic.0 >= 1.0
    }

    /// Whether all of it below metal is glass.
    pub fn is_glass_everywhere(&self) -> bool {
        self.transmission.0 >= 1.0
    }

    /// Whether some of it is glass.
    pub fn transmits(&self) -> bool {
        self.transmission.1 > 0.0 && !self.is_metal_everywhere()
    }

    /// Whether some of it is solid glass whose index of refraction depends on the wavelength.
    pub fn spreads_colors(&self) -> bool {
        self.disperses && self.transmits() && !self.thin_wall
    }
}

/// By what a solid refracts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidIndex {
    /// Least and greatest index.
    range: (f32, f32),
    /// How much of it depends on the wavelength: 20 over the Abbe number.
    pub dispersion: f32,
}

impl SolidIndex {
    /// Whether it is not the same everywhere.
    pub fn varies(&self) -> bool {
        self.range.0 != self.range.1
    }

    /// The index; one that stands for all where it varies, between those of water and of diamond.
    pub fn ior(&self) -> f32 {
        let (low, high) = self.range;
        if low == high {
            return low.max(1e-4);
        }
        (low.clamp(1.1, 2.5) * high.clamp(1.1, 2.5)).sqrt()
    }
}

/// What a surface is.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Its Principled BSDFs.
    pub principled: Vec<PrincipledSummary>,
    /// The colours of its Diffuse BSDFs.
    pub diffuse: Vec<Vec3>,
    /// The colours of its Glossy BSDFs.
    pub glossy: Vec<Vec3>,
    /// Its shaders of one lobe, each with the effect that it is.
    pub simple: Vec<(SimpleBsdf, Effect)>,
    /// Emitted radiance where images are white.
    pub emission: Vec3,
    /// Some diffuse reflection is rough.
    pub is_rough_diffuse: bool,
    /// Some of it has a coat.
    pub is_coated: bool,
    /// Some of it has a layer of fibres.
    pub has_sheen: bool,
    /// A thin film lies on some of it.
    pub has_film: bool,
    /// Light is scattered through some of its base, as through a sheet.
    pub is_thin_subsurface: bool,
    /// Light goes on below some of its base.
    pub goes_below: bool,
    /// Some facets spread further one way than across it.
    pub is_anisotropic: bool,
    /// What passes straight on takes a colour.
    pub is_tinted: bool,
    /// All passes straight on everywhere, without a colour.
    pub lets_all_pass: bool,
    /// Nothing but emission.
    pub unlit: bool,
    /// How much of it is there.
    pub opacity: Opacity,
}

impl Summary {
    /// Whether it emits.
    pub fn emits(&self) -> bool {
        self.emission.max_element() > 0.0
    }

    /// Whether light can pass beside it.
    pub fn is_translucent(&self) -> bool {
        match self.opacity {
            Opacity::Full => false,
            Opacity::Clip { holes, .. } => holes,
            Opacity::Blend { below } => below,
        }
    }
}

/// Which socket of a node an image stands in, by its slot.
fn slot(kind: &NodeKind, socket: usize, unlit: bool) -> Option<Slot> {
    match kind {
        NodeKind::PrincipledBsdf { .. } => match socket {
            principled::BASE_COLOR | principled::SUBSURFACE_COLOR => Some(Slot::BaseColor),
            principled::SPECULAR_IOR_LEVEL => Some(Slot::Specular),
            principled::SPECULAR_TINT => Some(Slot::SpecularColor),
            principled::TRANSMISSION_WEIGHT => Some(Slot::Transmission),
            principled::EMISSION_COLOR | principled::EMISSION_STRENGTH => Some(Slot::Emission),
            principled::NORMAL | principled::TANGENT | principled::COAT_NORMAL => None,
            _ => Some(Slot::MetallicRoughness),
        },
        NodeKind::DiffuseBsdf { .. } if socket == diffuse::COLOR => Some(Slot::BaseColor),
        NodeKind::DiffuseBsdf { .. } if socket == diffuse::ROUGHNESS => {
            Some(Slot::MetallicRoughness)
        }
        NodeKind::GlossyBsdf { .. } => match socket {
            glossy::COLOR => Some(Slot::BaseColor),
            glossy::NORMAL | glossy::TANGENT => None,
            _ => Some(Slot::MetallicRoughness),
        },
        NodeKind::Bsdf(bsdf) => match bsdf.sockets()[socket].kind {
            SocketKind::Color => Some(Slot::BaseColor),
            SocketKind::Float => Some(Slot::MetallicRoughness),
            _ => None,
        },
        NodeKind::Emission if unlit => Some(Slot::BaseColor),
        NodeKind::Emission => Some(Slot::Emission),
        NodeKind::TransparentBsdf => Some(Slot::BaseColor),
        NodeKind::MixShader if socket == mix_shader::FACTOR => Some(Slot::BaseColor),
        _ => None,
    }
}

impl super::Node {
    /// The effect that a shader of one lobe is.
    pub fn simple_effect(&self, bsdf: SimpleBsdf) -> Effect {
        match bsdf {
            SimpleBsdf::Translucent => Effect::DiffuseTransmission,
            SimpleBsdf::Refraction { .. } | SimpleBsdf::Glass { .. } => {
                if self.inputs[glass::ROUGHNESS] == Input::float(0.0) {
                    Effect::ClearGlass
                } else {
                    Effect::RoughGlass
                }
            }
            SimpleBsdf::Metallic { .. } | SimpleBsdf::Toon { glossy: true } => Effect::Metal,
            SimpleBsdf::Sheen { .. } => Effect::Sheen,
            SimpleBsdf::Toon { glossy: false } => Effect::DiffuseRoughness,
            SimpleBsdf::Subsurface(_) => Effect::Subsurface,
            SimpleBsdf::RayPortal { .. } => Effect::RayPortals,
            SimpleBsdf::Hair { .. } | SimpleBsdf::PrincipledHair(_) => Effect::HairShaders,
        }
    }
}

impl Graph {
    /// The sockets of shaders that have links, by their slots.
    pub fn slots(&self) -> Vec<(Slot, usize, usize)> {
        let unlit = self.is_unlit();
        let mut slots = Vec::new();
        for (at, node) in self.nodes.iter().enumerate() {
            for (socket, input) in node.inputs.iter().enumerate() {
                if input.link().is_some()
                    && let Some(slot) = slot(&node.kind, socket, unlit)
                {
                    slots.push((slot, at, socket));
                }
            }
        }
        slots
    }

    /// Whether images stand in a slot.
    pub fn has_texture(&self, slot: Slot) -> bool {
        let mut of = self.slots().into_iter().filter(|(s, ..)| *s == slot);
        of.any(|(_, node, socket)| {
            self.textures_behind(self.nodes[node].inputs[socket])
                .next()
                .is_some()
        })
    }

    /// Whether the surface shows its colour without light.
    pub fn is_unlit(&self) -> bool {
        let shines = |kind: &NodeKind| matches!(kind, NodeKind::Emission);
        let scatters = |kind: &NodeKind| {
            matches!(
                kind,
                NodeKind::PrincipledBsdf { .. }
                    | NodeKind::DiffuseBsdf { .. }
                    | NodeKind::GlossyBsdf { .. }
                    | NodeKind::Bsdf(_)
            )
        };
        self.nodes.iter().any(|n| shines(&n.kind)) && !self.nodes.iter().any(|n| scatters(&n.kind))
    }

    /// A Mix Shader at the surface that is transparent on one side: its factor, whether the transparent one is B, and the
    /// other one.
    pub fn transparency(&self) -> Option<(usize, bool, Input)> {
        let at = self.surface?.node as usize;
        let node = &self.nodes[at];
        if node.kind != NodeKind::MixShader {
            return None;
        }
        let (a, b) = (node.inputs[mix_shader::A], node.inputs[mix_shader::B]);
        let clear = |input: Input| {
            let kind = input.link().map(|link| &self.node(link).kind);
            kind == Some(&NodeKind::TransparentBsdf)
        };
        if clear(a) {
            Some((at, false, b))
        } else if clear(b) {
            Some((at, true, a))
        } else {
            None
        }
    }

    /// Whether light goes on below its surface: by a Principled BSDF, or a Subsurface Scattering.
    pub fn goes_below(&self) -> bool {
        let is_walk =
            |node: &super::Node| matches!(node.kind, NodeKind::Bsdf(SimpleBsdf::Subsurface(_)));
        self.nodes.iter().any(is_walk) || self.summary(false).goes_below
    }

    /// Whether a sum of shaders has what is transparent in it, so that the parts may come to more than 1; or a Holdout is one of them,
    /// so that they come to less.
    pub fn adds_transparency(&self) -> bool {
        let Some(surface) = self.surface else {
            return false;
        };
        // Shaders stand before what they are part of. By node: whether it has a transparent part, and one in a sum.
        let mut parts = vec![(false, false); surface.node as usize + 1];
        for at in 0..parts.len() {
            let node = &self.nodes[at];
            let is_sum = node.kind == NodeKind::AddShader;
            if node.kind == NodeKind::TransparentBsdf {
                parts[at] = (true, false);
            } else if node.kind == NodeKind::Holdout {
                parts[at] = (false, true);
            } else if is_sum || node.kind == NodeKind::MixShader {
                let sides = &node.inputs[node.inputs.len() - 2..];
                for link in sides.iter().filter_map(|input| input.link()) {
                    let (clear, added) = parts[link.node as usize];
                    parts[at].0 |= clear;
                    parts[at].1 |= added || is_sum && clear;
                }
            }
        }
        parts[surface.node as usize].1
    }

    fn opacity(&self, results: &[Range]) -> Opacity {
        let Some((at, clear_is_b, _)) = self.transparency() else {
            // What a holdout empties has a share, too, that paths ask for there.
            let clear = |node: &super::Node| {
                matches!(node.kind, NodeKind::TransparentBsdf | NodeKind::Holdout)
            };
            return if self.nodes.iter().any(clear) {
                Opacity::Blend { below: true }
            } else {
                Opacity::Full
            };
        };
        let factor = self.nodes[at].inputs[mix_shader::FACTOR];
        let (low, high) = self.range_of(results, factor, SocketKind::Float).number();
        let below = if clear_is_b { high > 0.0 } else { low < 1.0 };
        match self.cutoff(factor) {
            Some(cutoff) => Opacity::Clip {
                cutoff,
                holes: below,
            },
            None => Opacity::Blend { below },
        }
    }

    /// Whether nothing but what is transparent is left of the surface.
    fn is_clear(&self, results: &[Range]) -> bool {
        let Some((at, clear_is_b, _)) = self.transparency() else {
            let surface = self.surface.map(|surface| &self.node(surface).kind);
            return surface == Some(&NodeKind::TransparentBsdf);
        };
        let factor = self.nodes[at].inputs[mix_shader::FACTOR];
        let (low, high) = self.range_of(results, factor, SocketKind::Float).number();
        if clear_is_b { low >= 1.0 } else { high <= 0.0 }
    }

    fn cutoff(&self, factor: Input) -> Option<f32> {
        let node = self.node(factor.link()?);
        let NodeKind::Math { operation, .. } = node.kind else {
            return None;
        };
        match (operation, node.inputs[math::B]) {
            (MathOperation::LessThan | MathOperation::GreaterThan, Input::Value([cutoff, ..])) => {
                Some(cutoff)
            }
            _ => None,
        }
    }

    /// Says what the surface is; `vertex_alpha` if some mesh with it has vertices that are not opaque.
    pub fn summary(&self, vertex_alpha: bool) -> Summary {
        let results = self.results(&mut Unit { vertex_alpha });
        let mut summary = Summary {
            principled: Vec::new(),
            diffuse: Vec::new(),
            glossy: Vec::new(),
            simple: Vec::new(),
            emission: Vec3::ZERO,
            is_rough_diffuse: false,
            is_coated: false,
            has_sheen: false,
            has_film: false,
            is_thin_subsurface: false,
            goes_below: false,
            is_anisotropic: self.nodes.iter().any(super::Node::is_anisotropic),
            is_tinted: self.adds_transparency(),
            lets_all_pass: false,
            unlit: self.is_unlit(),
            opacity: self.opacity(&results),
        };
        for node in &self.nodes {
            let range = |socket: usize| {
                let kind = node.kind.sockets()[socket].kind;
                self.range_of(&results, node.inputs[socket], kind)
            };
            let color = |socket| range(socket).high.truncate();
            let most = |socket| {
                let range = range(socket);
                range.high.abs().max(range.low.abs()).truncate()
            };
            let film = node.film_socket();
            summary.has_film |= film.is_some_and(|socket| range(socket).number().1 > 0.0);
            match node.kind {
                NodeKind::PrincipledBsdf {
                    thin_wall,
                    walk,
                    rules,
                    ..
                } => {
                    summary.emission +=
                        most(principled::EMISSION_COLOR) * most(principled::EMISSION_STRENGTH);
                    let level = range(principled::SPECULAR_IOR_LEVEL).number();
                    summary.is_rough_diffuse |=
                        range(principled::DIFFUSE_ROUGHNESS).number().1 > 0.0;
                    summary.is_coated |= range(principled::COAT_WEIGHT).number().1 > 0.0;
                    summary.has_sheen |= range(principled::SHEEN_WEIGHT).number().1 > 0.0;
                    let scatters = range(principled::SUBSURFACE_WEIGHT).number().1 > 0.0;
                    summary.is_thin_subsurface |= scatters && walk.is_none();
                    summary.goes_below |= scatters && walk.is_some();
                    summary.principled.push(PrincipledSummary {
                        base_color: color(principled::BASE_COLOR),
                        metallic: range(principled::METALLIC).number(),
                        roughness: range(principled::ROUGHNESS).number(),
                        anisotropy: range(principled::ANISOTROPIC).number().1,
                        ior: range(principled::IOR).number(),
                        specular: (2.0 * level.0, 2.0 * level.1),
                        transmission: range(principled::TRANSMISSION_WEIGHT).number(),
                        disperses: range(principled::DISPERSION).number().1 > 0.0,
                        thin_wall,
                        rules,
                    });
                }
                NodeKind::DiffuseBsdf { .. } => {
                    summary.is_rough_diffuse |= range(diffuse::ROUGHNESS).number().1 > 0.0;
                    summary.diffuse.push(color(diffuse::COLOR));
                }
                NodeKind::TransparentBsdf => {
                    let color = node.inputs[transparent::COLOR];
                    summary.is_tinted |= color != Input::Value([1.0; 3]);
                }
                NodeKind::Bsdf(bsdf) => summary.simple.push((bsdf, node.simple_effect(bsdf))),
                NodeKind::GlossyBsdf { .. } => summary.glossy.push(color(glossy::COLOR)),
                NodeKind::Emission => {
                    summary.emission += most(emission::COLOR) * most(emission::STRENGTH);
                }
                _ => {}
            }
        }
        summary.lets_all_pass = !summary.is_tinted && self.is_clear(&results);
        summary
    }

    /// By what the first of its shaders that bounds a solid refracts.
    pub fn solid_index(&self) -> Option<SolidIndex> {
        let results = self.results(&mut Unit {
            vertex_alpha: false,
        });
        self.nodes.iter().find_map(|node| {
            let range = |socket: usize| {
                let kind = node.kind.sockets()[socket].kind;
                self.range_of(&results, node.inputs[socket], kind).number()
            };
            let (range, dispersion) = match node.kind {
                NodeKind::PrincipledBsdf {
                    thin_wall: false, ..
                } if range(principled::TRANSMISSION_WEIGHT).1 > 0.0 => {
                    (range(principled::IOR), range(principled::DISPERSION).1)
                }
                NodeKind::Bsdf(bsdf) if bsdf.bounds_a_solid() => (range(glass::IOR), 0.0),
                _ => return None,
            };
            Some(SolidIndex { range, dispersion })
        })
    }

    /// The surface without what is transparent of it.
    pub fn make_opaque(&mut self) {
        if let Some((_, _, rest)) = self.transparency() {
            self.surface = rest.link();
        }
        for node in &mut self.nodes {
            if node.kind == NodeKind::TransparentBsdf {
                node.inputs[transparent::COLOR] = Input::Value([0.0; 3]);
            } else if node.kind == NodeKind::Holdout {
                let black = super::Node::new(NodeKind::TransparentBsdf);
                *node = black.with(transparent::COLOR, [0.0; 3]);
            }
        }
        self.prune();
    }

    /// The link of the surface's only shader that scatters or emits, under what is transparent of it.
    pub fn body(&self) -> Option<Link> {
        match self.transparency() {
            Some((_, _, rest)) => rest.link(),
            None => self.surface,
        }
    }
}
