//! Shaders, images and normal maps of node trees.

use super::{NodeJson, Reader, Refusal, SocketJson, Stop};
use crate::import::gltf::image_spaces::Conversion;
use crate::math::primaries::WorkingSpace;
use crate::nodes::CyclesVersion;
use crate::nodes::math::Math;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::node::{
    self, image_texture, math, mix_shader, normal_map, principled, transparent,
};
use crate::scene::graph::{
    Distribution, Function, HairColoring, HairFibre, HairModel, ImageProjection, Input, Link,
    MathOperation, Node, NodeKind, NormalSpace, PhaseKind, ShaderRules, SimpleBsdf, SocketKind,
    Subsurface, VolumeShader, WalkMethod,
};
use crate::scene::{
    ImageAlpha, ImageId, ImageUse, Sampler, Texture, TextureFilter, UvTransform, Wrap,
};
use serde_json::Value;

/// From this one on, normal maps stand on a normal of unit length between those of the corners.
const UNIT_NORMALS: CyclesVersion = CyclesVersion::new(5, 1);

/// The spread of a shader's facets.
fn distribution(node: &NodeJson) -> Result<Distribution, Refusal> {
    match node.text("distribution") {
        Some("MULTI_GGX") => Ok(Distribution::MultiscatterGgx),
        Some("GGX") => Ok(Distribution::Ggx),
        Some("BECKMANN") => Ok(Distribution::Beckmann),
        Some("ASHIKHMIN_SHIRLEY") => Ok(Distribution::AshikhminShirley),
        other => Err(Refusal::of(node, other.unwrap_or("unknown"))),
    }
}

/// How a shader of a volume scatters.
fn phase(node: &NodeJson) -> Result<PhaseKind, Refusal> {
    match node.text("phase") {
        Some("HENYEY_GREENSTEIN") | None => Ok(PhaseKind::HenyeyGreenstein),
        Some("RAYLEIGH") => Ok(PhaseKind::Rayleigh),
        Some("DRAINE") => Ok(PhaseKind::Draine),
        Some("FOURNIER_FORAND") => Ok(PhaseKind::FournierForand),
        Some("MIE") => Ok(PhaseKind::Mie),
        Some(other) => Err(Refusal::of(node, other)),
    }
}

impl Reader<'_, '_, '_> {
    /// The shader, attribute or displacement of a node, if it is one.
    pub(super) fn shader(&mut self, at: usize) -> Result<Option<Input>, Stop> {
        let source = self.source;
        let node = &source.nodes[at];
        let text = |name: &str| node.text(name);
        let link = match node.kind.strip_prefix("ShaderNode").unwrap_or(&node.kind) {
            "BsdfPrincipled" => self.principled(at)?,
            "SubsurfaceScattering" => {
                let what = self.subsurface(node, "falloff")?;
                self.add(at, NodeKind::Bsdf(SimpleBsdf::Subsurface(what)), &[])
            }
            "BsdfDiffuse" => self.add(
                at,
                NodeKind::DiffuseBsdf {
                    rules: self.rules(),
                },
                &[],
            ),
            "BsdfGlossy" | "BsdfAnisotropic" => {
                let distribution = distribution(node)?;
                self.add(at, NodeKind::GlossyBsdf { distribution }, &[])
            }
            "BsdfTranslucent" => self.add(at, NodeKind::Bsdf(SimpleBsdf::Translucent), &[]),
            "BsdfRayPortal" => {
                let moves = node.inputs.contains_key("Position");
                self.add(at, NodeKind::Bsdf(SimpleBsdf::RayPortal { moves }), &[])
            }
            "BsdfRefraction" => {
                let distribution = distribution(node)?;
                self.add(
                    at,
                    NodeKind::Bsdf(SimpleBsdf::Refraction { distribution }),
                    &[],
                )
            }
            "BsdfGlass" => {
                let distribution = distribution(node)?;
                self.add(
                    at,
                    NodeKind::Bsdf(SimpleBsdf::Glass {
                        distribution,
                        rules: self.rules(),
                    }),
                    &[],
                )
            }
            "BsdfMetallic" => {
                let conductor = match text("fresnel_type") {
                    Some("F82") => false,
                    Some("PHYSICAL_CONDUCTOR") => true,
                    other => return Err(Refusal::of(node, other.unwrap_or("unknown")).into()),
                };
                let bsdf = SimpleBsdf::Metallic {
                    conductor,
                    distribution: distribution(node)?,
                };
                self.add(at, NodeKind::Bsdf(bsdf), &[])
            }
            "BsdfSheen" => {
                let velvet = match text("distribution") {
                    Some("MICROFIBER") => false,
                    Some("ASHIKHMIN") => true,
                    other => return Err(Refusal::of(node, other.unwrap_or("unknown")).into()),
                };
                self.add(at, NodeKind::Bsdf(SimpleBsdf::Sheen { velvet }), &[])
            }
            "BsdfToon" => {
                let glossy = match text("component") {
                    Some("DIFFUSE") => false,
                    Some("GLOSSY") => true,
                    other => return Err(Refusal::of(node, other.unwrap_or("unknown")).into()),
                };
                self.add(at, NodeKind::Bsdf(SimpleBsdf::Toon { glossy }), &[])
            }
            "BsdfHair" => {
                let transmits = match text("component") {
                    Some("Reflection") => false,
                    Some("Transmission") => true,
                    other => return Err(Refusal::of(node, other.unwrap_or("unknown")).into()),
                };
                self.add(at, NodeKind::Bsdf(SimpleBsdf::Hair { transmits }), &[])
            }
            "BsdfHairPrincipled" => self.principled_hair(at)?,
            // Alone it is what instances are made of ([`Reader::is_holdout`]).
            "Holdout" if self.is_holdout() => return Ok(Some(Input::None)),
            "Holdout" => self.add(at, NodeKind::Holdout, &[]),
            "BsdfTransparent" => self.add(at, NodeKind::TransparentBsdf, &[]),
            // Cycles shows a background on a surface as light of its own.
            "Emission" | "Background" => self.add(at, NodeKind::Emission, &[]),
            "MixShader" => {
                let link = self.add(at, NodeKind::MixShader, &[]);
                self.second_shader(at, link, mix_shader::B);
                link
            }
            "AddShader" => {
                let link = self.add(at, NodeKind::AddShader, &[]);
                self.second_shader(at, link, node::add_shader::B);
                link
            }
            "VolumeAbsorption" => self.add(at, NodeKind::Volume(VolumeShader::Absorption), &[]),
            "VolumeScatter" => {
                let volume = VolumeShader::Scatter(phase(node)?);
                self.add(at, NodeKind::Volume(volume), &[])
            }
            "VolumeCoefficients" => {
                let volume = VolumeShader::Coefficients(phase(node)?);
                self.add(at, NodeKind::Volume(volume), &[])
            }
            "VolumePrincipled" => self.add(at, NodeKind::Volume(VolumeShader::Principled), &[]),
            _ => return Ok(None),
        };
        Ok(Some(link.into()))
    }

    /// How light goes on below the surface of a node, by the name of its property for that.
    fn subsurface(&mut self, node: &NodeJson, property: &str) -> Result<Subsurface, Refusal> {
        // Cycles 5.2 has named the old method anew, and 5.0 walks behind diffuse bounces, too.
        let is_before = |major, minor| self.version < CyclesVersion::new(major, minor);
        let method = match node.text(property) {
            Some("RANDOM_WALK") if is_before(5, 2) => WalkMethod::Legacy,
            Some("RANDOM_WALK") | None => WalkMethod::RandomWalk,
            Some("RANDOM_WALK_LEGACY") => WalkMethod::Legacy,
            Some("RANDOM_WALK_SKIN") => WalkMethod::Skin,
            Some("BURLEY") => WalkMethod::Burley,
            other => return Err(Refusal::of(node, other.unwrap_or("unknown"))),
        };
        Ok(Subsurface {
            method,
            never_backward: is_before(5, 2),
            diffuse_behind_diffuse: is_before(5, 0) || method == WalkMethod::Burley,
        })
    }

    /// A Principled Hair BSDF. Beside an elliptic section rays pass straight on.
    fn principled_hair(&mut self, at: usize) -> Result<Link, Refusal> {
        let node = &self.source.nodes[at];
        let fibre = self.fibre(node)?;
        let aspect = self.input(node, "Aspect Ratio", SocketKind::Float);
        let shader = self.add(at, NodeKind::Bsdf(SimpleBsdf::PrincipledHair(fibre)), &[]);
        let aspect = match aspect {
            Some(Input::Value([aspect, ..])) if fibre.model == HairModel::Huang => aspect,
            _ => 1.0,
        };
        if aspect == 1.0 {
            return Ok(shader);
        }
        let cover = Function::Place(PlaceInput::FibreCover(aspect.max(1e-3)));
        let cover = self.graph.add(Node::new(NodeKind::Function(cover)));
        let clear = Node::new(NodeKind::TransparentBsdf);
        let clear = self.graph.add(clear.with(transparent::COLOR, 1.0));
        let mixed = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, cover);
        let mixed = mixed.with(mix_shader::A, clear).with(mix_shader::B, shader);
        Ok(self.graph.add(mixed))
    }

    /// What a Principled Hair BSDF is.
    fn fibre(&self, node: &NodeJson) -> Result<HairFibre, Refusal> {
        let refused = |text: Option<&str>| Refusal::of(node, text.unwrap_or("unknown"));
        Ok(HairFibre {
            model: match node.text("model") {
                Some("CHIANG") => HairModel::Chiang,
                Some("HUANG") => HairModel::Huang,
                other => return Err(refused(other)),
            },
            coloring: match node.text("parametrization") {
                Some("ABSORPTION") => HairColoring::Absorption,
                Some("MELANIN") => HairColoring::Melanin,
                Some("COLOR") => HairColoring::Reflectance,
                other => return Err(refused(other)),
            },
            own_random: !matches!(node.inputs.get("Random"), Some(SocketJson::Link(_))),
            is_masked: self.version >= CyclesVersion::new(5, 0),
        })
    }

    /// Both shaders of a mix or a sum have one name, and two identifiers.
    fn second_shader(&mut self, at: usize, link: Link, socket: usize) {
        let second = self.input(&self.source.nodes[at], "Shader_001", SocketKind::Shader);
        self.graph.nodes[link.node as usize].inputs[socket] = second.unwrap_or(Input::None);
    }

    /// Those of the version that the tree is of.
    fn rules(&self) -> ShaderRules {
        ShaderRules::of(self.version)
    }

    fn principled(&mut self, at: usize) -> Result<Link, Refusal> {
        let source = self.source;
        let node = &source.nodes[at];
        let is_on = |input: &SocketJson| match input {
            SocketJson::Switch(on) => *on,
            SocketJson::Number(value) => *value != 0.0,
            _ => false,
        };
        let thin_wall = node.inputs.get("Thin Wall").is_some_and(is_on);
        let is_there = |input: Option<Input>| input.is_some_and(|i| i != Input::float(0.0));
        let scatters = is_there(self.input(node, "Subsurface Weight", SocketKind::Float));
        let kind = NodeKind::PrincipledBsdf {
            thin_wall,
            pane: true,
            edge_tint: true,
            once: node.text("distribution") == Some("GGX"),
            walk: if scatters && !thin_wall {
                Some(self.subsurface(node, "subsurface_method")?)
            } else {
                None
            },
            rules: self.rules(),
        };
        // Nodes stand after those that they read.
        let dispersion = self.dispersion(node);
        let mut shader = self.add(at, kind, &[]);
        let made = &mut self.graph.nodes[shader.node as usize];
        if let Some(dispersion) = dispersion {
            made.inputs[principled::DISPERSION] = dispersion;
        }
        if scatters {
            made.inputs[principled::SUBSURFACE_COLOR] = made.inputs[principled::BASE_COLOR];
        }
        let alpha = self.input(node, "Alpha", SocketKind::Float);
        let alpha = alpha.unwrap_or(Input::float(1.0));
        if alpha != Input::float(1.0) {
            let clear = Node::new(NodeKind::TransparentBsdf);
            let clear = self.graph.add(clear.with(transparent::COLOR, 1.0));
            let operation = MathOperation::Multiply;
            let share = Node::new(NodeKind::Math {
                operation,
                clamp: true,
            });
            let share = self
                .graph
                .add(share.with(math::A, alpha).with(math::B, 1.0));
            let mixed = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, share);
            let mixed = mixed.with(mix_shader::A, clear).with(mix_shader::B, shader);
            shader = self.graph.add(mixed);
        }
        Ok(shader)
    }

    /// How much of a Principled BSDF's index depends on the wavelength: 20 over the Abbe number, times Blender's scale.
    fn dispersion(&mut self, node: &NodeJson) -> Option<Input> {
        let number = |name: &str| self.input(node, name, SocketKind::Float);
        let scale = number("Transmission Dispersion Scale")?;
        let abbe = number("Transmission Dispersion Abbe Number")?;
        if scale == Input::float(0.0) {
            return None;
        }
        let mut math = |operation: Math, clamp: bool, a: Input, b: Input| -> Input {
            let node = Node::new(NodeKind::Function(Function::Math { operation, clamp }));
            self.graph.add(node.with(0, a).with(1, b)).into()
        };
        let scale = math(Math::Multiply, true, scale, Input::float(1.0));
        let scale = math(Math::Multiply, false, scale, Input::float(20.0));
        // No number of Abbe's is no dispersion, and one below 0 is as 0.
        let abbe = math(Math::Maximum, false, abbe, Input::float(0.0));
        Some(math(Math::Divide, false, scale, abbe))
    }

    pub(super) fn attribute(&mut self, at: usize) -> Result<Link, Stop> {
        let node = &self.source.nodes[at];
        let Some(name) = node.text("attribute") else {
            return Err(Refusal::of(node, "without an attribute").into());
        };
        let kind = NodeKind::Function(Function::Place(attribute(node, name)?));
        Ok(self.graph.add(Node::new(kind)))
    }

    /// The frame of a normal map's tangents. Where vertices have moved, Cycles keeps the tangents and takes the new normals until 4.5,
    /// keeps both in 5.0, and from 5.1 on the node says whether both are new.
    fn tangent_space(&mut self, base: Option<&str>) -> NormalSpace {
        let of_corners = if self.version < UNIT_NORMALS {
            NormalSpace::Spread
        } else {
            NormalSpace::Tangent
        };
        let moves = self.graph.displacement.is_some();
        if !moves || self.version < CyclesVersion::new(5, 0) {
            return of_corners;
        }
        if self.version >= CyclesVersion::new(5, 1) && base != Some("ORIGINAL") {
            self.graph.renews_tangents = true;
            return of_corners;
        }
        // Under a bump normals stay as they are.
        if self.graph.normal.is_some() {
            return of_corners;
        }
        let number = self.source.attributes();
        self.before = Some(number);
        NormalSpace::Before(number)
    }

    pub(super) fn normal_map(&mut self, at: usize) -> Result<Input, Stop> {
        let source = self.source;
        let node = &source.nodes[at];
        let text = |name: &str| node.text(name);
        let space = match text("space") {
            Some("TANGENT") => self.tangent_space(text("base")),
            Some("OBJECT" | "BLENDER_OBJECT") => NormalSpace::Object,
            Some("WORLD" | "BLENDER_WORLD") => NormalSpace::World,
            other => return Err(Refusal::of(node, other.unwrap_or("unknown")).into()),
        };
        // Blender's own convention has the second and the third axis turned over, and DirectX's the second.
        let blender = text("space").is_some_and(|space| space.starts_with("BLENDER"));
        let down = match text("convention") {
            None | Some("OPENGL") => false,
            Some("DIRECTX") => true,
            Some(other) => return Err(Refusal::of(node, other).into()),
        };
        let flips = [false, blender != down, blender];
        if flips == [false; 3] {
            return Ok(self.add(at, NodeKind::NormalMap { space }, &[]).into());
        }
        let color = self.input(node, "Color", SocketKind::Color);
        let color = color.unwrap_or(Input::Value(normal_map::SOCKETS[normal_map::COLOR].default));
        let multiply_add = Function::VectorMath(VectorMath::MultiplyAdd);
        let mut flipped = Node::new(NodeKind::Function(multiply_add));
        let of_flips = |yes: f32, no: f32| Input::Value(flips.map(|f| if f { yes } else { no }));
        flipped.inputs[..3].copy_from_slice(&[color, of_flips(-1.0, 1.0), of_flips(1.0, 0.0)]);
        let flipped = self.graph.add(flipped);
        let link = self.add(at, NodeKind::NormalMap { space }, &[]);
        self.graph.nodes[link.node as usize].inputs[normal_map::COLOR] = flipped.into();
        Ok(link.into())
    }

    /// An Image Texture; `divided`: its opacity is read, so that colours are told without it.
    pub(super) fn image(&mut self, at: usize, divided: bool) -> Result<Link, Stop> {
        let source = self.source;
        let node = &source.nodes[at];
        let text = |name: &str| node.text(name);
        let Some(image) = node.properties.get("image") else {
            return Err(Refusal::of(node, "without an image").into());
        };
        let of_image = |name: &str| image.get(name).and_then(Value::as_str);
        let number_of = |of: &Value, name: &str| of.get(name).and_then(Value::as_u64);
        let Some(index) = number_of(image, "index") else {
            return Err(Refusal::of(node, "without an image").into());
        };
        let space = of_image("colorspace").unwrap_or("sRGB");
        let data = matches!(space, "Non-Color" | "Raw" | "Data" | "Generic Data");
        let mut alpha = match of_image("alpha_mode") {
            Some("NONE") => ImageAlpha::None,
            Some("STRAIGHT") if !data => ImageAlpha::Straight { divided },
            Some("PREMUL") if !data => ImageAlpha::Premultiplied { divided },
            Some("STRAIGHT" | "PREMUL" | "CHANNEL_PACKED") | None => ImageAlpha::ChannelPacked,
            Some(other) => return Err(Refusal::of(node, other).into()),
        };
        // Numbers of the scene's own space are as good as data.
        let is_linear = self.linear_names.contains(&space);
        // Codes of sRGB are decoded after interpolation in Rec.709 alone, as Cycles keeps no codes of other spaces.
        let decoded_later =
            space == "sRGB" && self.linear_names[0] == WorkingSpace::default().name();
        let is_float = image.get("is_float") == Some(&Value::Bool(true));
        let usage = match (data || is_linear, decoded_later && is_float) {
            (true, _) => ImageUse::Data,
            (_, true) => ImageUse::Codes,
            _ => ImageUse::Color,
        };
        let conversion = (!decoded_later && !data && !is_linear).then(|| Conversion {
            space: space.to_owned(),
            alpha: match alpha {
                ImageAlpha::Premultiplied { .. } => ImageAlpha::Premultiplied { divided: false },
                alpha => alpha.of_texels(),
            },
        });
        if conversion.is_some() && alpha.multiplies() {
            // What is converted is multiplied.
            alpha = ImageAlpha::Premultiplied { divided };
        }
        let mut find = |index: u64| {
            let wanted = (index as usize, conversion.clone());
            let found = self.images.image(wanted, self.owner, self.diagnostics);
            // An image that is lost is cut out of the graph later, and told.
            found.map(|found| found.unwrap_or(ImageId(u32::MAX)))
        };
        let found = find(index)?;
        let (mut numbers, mut tiles) = (Vec::new(), Vec::new());
        for tile in image
            .get("tiles")
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
        {
            if let (Some(number), Some(index)) =
                (number_of(tile, "number"), number_of(tile, "index"))
            {
                numbers.push(number as u32);
                tiles.push(find(index)?);
            }
        }
        let wrap = match text("extension") {
            Some("REPEAT") | None => Wrap::Repeat,
            Some("EXTEND") => Wrap::Clamp,
            Some("MIRROR") => Wrap::Mirror,
            Some("CLIP") => Wrap::Clip,
            Some(other) => return Err(Refusal::of(node, other).into()),
        };
        let filter = match text("interpolation") {
            Some("Linear") | None => TextureFilter::Linear,
            Some("Closest") => TextureFilter::Nearest,
            // Cycles' processor path has no other for "Smart".
            Some("Cubic" | "Smart") => TextureFilter::Cubic,
            Some(other) => return Err(Refusal::of(node, other).into()),
        };
        let blend = node.number("projection_blend").unwrap_or(0.0);
        let projection = match text("projection") {
            Some("FLAT") | None => ImageProjection::Flat,
            Some("BOX") => ImageProjection::Box { blend },
            Some("SPHERE") => ImageProjection::Sphere,
            Some("TUBE") => ImageProjection::Tube,
            Some("EQUIRECTANGULAR") => ImageProjection::Equirectangular,
            Some("MIRROR_BALL") => ImageProjection::MirrorBall,
            Some(other) => return Err(Refusal::of(node, other).into()),
        };
        let uv_set = node.number("uv_set").unwrap_or(0.0) as u32;
        let vector = match self.input(node, "Vector", SocketKind::Coordinates) {
            None if node.kind == "ShaderNodeTexEnvironment" => {
                let kind = NodeKind::Function(Function::Place(PlaceInput::Position));
                self.graph.add(Node::new(kind)).into()
            }
            // Projections take texture coordinates as places, too.
            None if projection != ImageProjection::Flat || !tiles.is_empty() => {
                let kind = NodeKind::Function(Function::Place(PlaceInput::Uv(uv_set)));
                self.graph.add(Node::new(kind)).into()
            }
            vector => vector.unwrap_or(Input::None),
        };
        let texture = Texture {
            image: found,
            uv_set,
            transform: UvTransform::default(),
            sampler: Sampler {
                wrap_u: wrap,
                wrap_v: wrap,
                filter,
                alpha,
            },
        };
        let kind = if tiles.is_empty() {
            NodeKind::ImageTexture {
                texture,
                usage,
                projection,
            }
        } else {
            let textures = tiles.into_iter().map(|image| Texture {
                image,
                ..texture.clone()
            });
            NodeKind::TiledImage {
                numbers,
                textures: textures.collect(),
                usage,
                projection,
            }
        };
        let shared = Node::new(kind);
        Ok(self.graph.add(shared.with(image_texture::VECTOR, vector)))
    }
}

/// An attribute of the primitive, by its name.
pub(super) fn attribute(node: &NodeJson, name: &str) -> Result<PlaceInput, Refusal> {
    if name == "COLOR_0" {
        return Ok(PlaceInput::VertexColor);
    }
    let number = name.strip_prefix("_SUNDOG_").and_then(|n| n.parse().ok());
    let number = number.filter(|n| *n < super::super::mesh::MOST_ATTRIBUTES as u32);
    let number = number.ok_or_else(|| Refusal::of(node, name))?;
    Ok(PlaceInput::Attribute(number))
}
