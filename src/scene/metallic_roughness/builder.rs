//! The shader graph of a metallic-roughness material.

use super::*;
use crate::scene::ImageUse;
use crate::scene::graph::node::{
    self, add_shader, emission, glossy, math, mix, mix_shader, normal_map, principled, separate,
    tangent, transparent,
};
use crate::scene::graph::{
    Blend, Distribution, Graph, ImageProjection, Input, Link, MathOperation, Node, NodeKind,
    NormalSpace, TangentKind,
};

/// A graph on its way.
#[derive(Default)]
struct Builder(Graph);

impl Builder {
    fn image(&mut self, texture: &Texture, usage: ImageUse) -> Link {
        let texture = texture.clone();
        self.0.add(Node::new(NodeKind::ImageTexture {
            texture,
            usage,
            projection: ImageProjection::Flat,
        }))
    }

    fn channel(&mut self, texture: &Texture, output: u8) -> Link {
        let image = self.image(texture, ImageUse::Data);
        self.separate(image, output)
    }

    fn separate(&mut self, color: Link, output: u8) -> Link {
        let node = Node::new(NodeKind::SeparateColor).with(separate::COLOR, color);
        Link {
            output,
            ..self.0.add(node)
        }
    }

    fn product(&mut self, a: impl Into<Input>, b: impl Into<Input>, clamp: bool) -> Link {
        self.math(MathOperation::Multiply, a, b, clamp)
    }

    fn math(
        &mut self,
        operation: MathOperation,
        a: impl Into<Input>,
        b: impl Into<Input>,
        clamp: bool,
    ) -> Link {
        let node = Node::new(NodeKind::Math { operation, clamp });
        self.0.add(node.with(math::A, a).with(math::B, b))
    }

    fn tinted(&mut self, a: impl Into<Input>, b: impl Into<Input>) -> Link {
        let blend = Blend::Multiply;
        let node = Node::new(NodeKind::MixColor { blend }).with(mix::FACTOR, 1.0);
        self.0.add(node.with(mix::A, a).with(mix::B, b))
    }

    /// A factor, times the alpha of an image of data.
    fn share(&mut self, factor: f32, texture: Option<&Texture>) -> Input {
        match texture {
            None => factor.into(),
            Some(texture) => {
                let output = node::ALPHA;
                let image = self.image(texture, ImageUse::Data);
                let alpha = Link { output, ..image };
                self.product(factor, alpha, false).into()
            }
        }
    }

    /// A factor, times one number of an image.
    fn number(&mut self, factor: f32, texture: Option<&Texture>, output: u8) -> Input {
        match texture {
            None => factor.into(),
            Some(texture) => {
                let channel = self.channel(texture, output);
                self.product(factor, channel, false).into()
            }
        }
    }

    /// A colour, times that of an image.
    fn color(&mut self, factor: [f32; 3], texture: Option<&Texture>) -> Input {
        match texture {
            None => factor.into(),
            Some(texture) => {
                let image = self.image(texture, ImageUse::Color);
                self.tinted(factor, image).into()
            }
        }
    }

    /// A shader where the opacity lets it be.
    fn opaque(
        &mut self,
        m: &MetallicRoughness,
        base: Option<Link>,
        vertices: Link,
        shader: Link,
    ) -> Link {
        let alpha = |link: Link| Link {
            output: node::ALPHA,
            ..link
        };
        if m.alpha_mode == AlphaMode::Opaque {
            return shader;
        }
        let clear = Node::new(NodeKind::TransparentBsdf);
        let clear = self
            .0
            .add(clear.with(transparent::COLOR, m.transparent_color));
        let factor = self.product(m.alpha, alpha(vertices), base.is_none());
        let factor = match base {
            None => factor,
            Some(base) => self.product(factor, alpha(base), true),
        };
        let mixed = Node::new(NodeKind::MixShader);
        let mixed = match m.alpha_mode {
            AlphaMode::Mask { cutoff } => {
                let operation = MathOperation::LessThan;
                let clamp = false;
                let hole = Node::new(NodeKind::Math { operation, clamp });
                let hole = self.0.add(hole.with(math::A, factor).with(math::B, cutoff));
                let mixed = mixed.with(mix_shader::FACTOR, hole);
                mixed.with(mix_shader::A, shader).with(mix_shader::B, clear)
            }
            _ => {
                let mixed = mixed.with(mix_shader::FACTOR, factor);
                mixed.with(mix_shader::A, clear).with(mix_shader::B, shader)
            }
        };
        self.0.add(mixed)
    }

    fn normal(&mut self, m: &MetallicRoughness) -> Input {
        let normal = m.normal_texture.as_ref();
        let normal = normal.map(|normal| self.normal_map(normal));
        normal.map_or(Input::None, Input::Link)
    }

    fn normal_map(&mut self, normal: &NormalTexture) -> Link {
        let image = self.image(&normal.texture, ImageUse::Data);
        let space = NormalSpace::Gltf;
        let map = Node::new(NodeKind::NormalMap { space });
        let map = map.with(normal_map::STRENGTH, normal.scale);
        self.0.add(map.with(normal_map::COLOR, image))
    }

    /// A Principled BSDF with its coat and its fibres.
    fn layered(&mut self, m: &MetallicRoughness, mut node: Node) -> Node {
        if let Some(coat) = &m.coat {
            let weight = self.number(coat.weight, coat.texture.as_ref(), node::RED);
            let texture = coat.roughness_texture.as_ref();
            let roughness = self.number(coat.roughness, texture, node::GREEN);
            let normal = match &coat.normal {
                CoatNormal::Map(normal) => self.normal_map(normal).into(),
                // What is no direction stands for the surface's own.
                CoatNormal::Smooth if m.normal_texture.is_some() => Input::float(0.0),
                _ => Input::None,
            };
            node = node
                .with(principled::COAT_WEIGHT, weight)
                .with(principled::COAT_ROUGHNESS, roughness)
                .with(principled::COAT_IOR, coat.ior)
                .with(principled::COAT_TINT, coat.tint)
                .with(principled::COAT_NORMAL, normal);
        }
        if let Some([thickness, ior]) = m.thin_film {
            node = node
                .with(principled::THIN_FILM_THICKNESS, thickness)
                .with(principled::THIN_FILM_IOR, ior);
        }
        if let Some(sheen) = &m.sheen {
            let color = self.color(sheen.color, sheen.color_texture.as_ref());
            let roughness = self.share(sheen.roughness, sheen.roughness_texture.as_ref());
            node = node
                .with(principled::SHEEN_WEIGHT, 1.0)
                .with(principled::SHEEN_ROUGHNESS, roughness)
                .with(principled::SHEEN_TINT, color);
        }
        node
    }

    fn glossy(&mut self, m: &MetallicRoughness, distribution: Distribution, color: Link) -> Link {
        let texture = m.metallic_roughness_texture.as_ref();
        let roughness = self.number(m.roughness, texture, node::GREEN);
        let normal = self.normal(m);
        let [roughness, anisotropy, rotation, tangent] = self.anisotropy(m, roughness);
        self.0.add(
            Node::new(NodeKind::GlossyBsdf { distribution })
                .with(glossy::COLOR, color)
                .with(glossy::ROUGHNESS, roughness)
                .with(glossy::ANISOTROPY, anisotropy)
                .with(glossy::ROTATION, rotation)
                .with(glossy::TANGENT, tangent)
                .with(glossy::NORMAL, normal),
        )
    }

    /// Blender's roughness, anisotropy, rotation and tangent.
    fn anisotropy(&mut self, m: &MetallicRoughness, roughness: Input) -> [Input; 4] {
        match &m.anisotropy {
            None => [roughness, 0.0.into(), 0.0.into(), Input::None],
            Some(Anisotropy::Blender {
                strength,
                rotation,
                tangent,
                ..
            }) => {
                let along_u = *tangent == TangentKind::Uv;
                let tangent = along_u.then(|| self.tangent(Input::None));
                let tangent = tangent.map_or(Input::None, Input::Link);
                [roughness, (*strength).into(), (*rotation).into(), tangent]
            }
            Some(Anisotropy::Gltf {
                strength,
                rotation,
                texture,
            }) => {
                let image = texture.as_ref().map(|t| self.image(t, ImageUse::Data));
                let strength = match image {
                    None => Input::from(*strength),
                    Some(image) => {
                        let channel = self.separate(image, node::BLUE);
                        self.product(*strength, channel, false).into()
                    }
                };
                let (sin, cos) = rotation.sin_cos();
                let (direction, turns) = match image {
                    None => (
                        Input::Value([0.5 + 0.5 * cos, 0.5 + 0.5 * sin, 0.5]),
                        Input::from(0.0),
                    ),
                    Some(image) => (image.into(), (rotation / std::f32::consts::TAU).into()),
                };
                let tangent = self.tangent(direction);
                let (roughness, strength) = self.as_blenders(roughness, strength);
                [roughness, strength, turns, tangent.into()]
            }
        }
    }

    fn tangent(&mut self, direction: Input) -> Link {
        let mut node = Node::new(NodeKind::Tangent {
            kind: TangentKind::Uv,
        });
        if direction != Input::None {
            node.inputs[tangent::DIRECTION] = direction;
        }
        self.0.add(node)
    }

    /// glTF has α across the tangent and α + (1 - α)·strength² along it; Blender r²·aspect and r²/aspect, with an aspect of
    /// √(1 - 0.9·anisotropy). The roughness and the anisotropy of Blender that mean the same, as far as the aspect goes.
    fn as_blenders(&mut self, roughness: Input, strength: Input) -> (Input, Input) {
        use MathOperation::{Add, Divide, Power, Subtract};
        let across = self.product(roughness, roughness, false);
        let square = self.product(strength, strength, false);
        let rest = self.math(Subtract, 1.0, across, false);
        let more = self.product(rest, square, false);
        let along = self.math(Add, across, more, false);
        let ratio = self.math(Divide, across, along, false);
        let lack = self.math(Subtract, 1.0, ratio, false);
        let anisotropy = self.math(Divide, lack, 0.9, true);
        let both = self.product(across, along, false);
        let roughness = self.math(Power, both, 0.25, false);
        (roughness.into(), anisotropy.into())
    }

    fn principled(&mut self, m: &MetallicRoughness, base_color: Link) -> Link {
        let glossy = m.glossiness.zip(m.specular_color_texture.as_ref());
        let glossy = glossy.map(|(factor, texture)| self.specular_glossiness(m, factor, texture));
        let metal = m.metallic_roughness_texture.as_ref();
        let metal = metal.map(|texture| self.image(texture, ImageUse::Data));
        let mut factor = |factor: f32, output: u8| match metal {
            None => Input::from(factor),
            Some(image) => {
                let channel = self.separate(image, output);
                self.product(factor, channel, false).into()
            }
        };
        let metallic = factor(m.metallic, node::BLUE);
        let roughness = match glossy {
            Some([roughness, _]) => roughness,
            None => factor(m.roughness, node::GREEN),
        };
        let [roughness, anisotropy, rotation, tangent] = self.anisotropy(m, roughness);
        let specular = self.share(0.5 * m.specular, m.specular_texture.as_ref());
        let tint = match glossy {
            Some([_, tint]) => tint,
            None => self.color(m.specular_color, m.specular_color_texture.as_ref()),
        };
        let transmission = self.number(m.transmission, m.transmission_texture.as_ref(), node::RED);
        let emission = self.color(m.emission, m.emission_texture.as_ref());
        let normal = self.normal(m);
        let kind = NodeKind::PrincipledBsdf {
            thin_wall: m.thin_walled,
            edge_tint: m.edge_tint,
            once: false,
            pane: false,
            walk: None,
            rules: m.rules,
        };
        let node = Node::new(kind)
            .with(principled::BASE_COLOR, base_color)
            .with(principled::METALLIC, metallic)
            .with(principled::ROUGHNESS, roughness)
            .with(principled::IOR, m.ior)
            .with(principled::DISPERSION, m.dispersion)
            .with(principled::DIFFUSE_ROUGHNESS, m.diffuse_roughness)
            .with(principled::ANISOTROPIC, anisotropy)
            .with(principled::ANISOTROPIC_ROTATION, rotation)
            .with(principled::TANGENT, tangent)
            .with(principled::SPECULAR_IOR_LEVEL, specular)
            .with(principled::SPECULAR_TINT, tint)
            .with(principled::TRANSMISSION_WEIGHT, transmission)
            .with(principled::EMISSION_COLOR, emission)
            .with(principled::EMISSION_STRENGTH, 1.0)
            .with(principled::NORMAL, normal);
        let node = self.layered(m, node);
        let node = self.scattered_through(m, node);
        self.filmed(m, node, emission)
    }

    /// Roughness and tint of a reflection whose colour and glossiness one image has.
    fn specular_glossiness(
        &mut self,
        m: &MetallicRoughness,
        factor: f32,
        texture: &Texture,
    ) -> [Input; 2] {
        let image = self.image(texture, ImageUse::Color);
        let output = node::ALPHA;
        let glossiness = self.product(factor, Link { output, ..image }, false);
        let roughness = self.math(MathOperation::Subtract, 1.0, glossiness, true);
        let tint = self.tinted(m.specular_color, image);
        [roughness.into(), tint.into()]
    }

    /// A Principled BSDF of whose diffuse base a share is scattered to the other side.
    fn scattered_through(&mut self, m: &MetallicRoughness, node: Node) -> Node {
        let Some(through) = &m.diffuse_transmission else {
            return node;
        };
        let weight = self.share(through.factor, through.texture.as_ref());
        let color = self.color(through.color, through.color_texture.as_ref());
        node.with(principled::SUBSURFACE_WEIGHT, weight)
            .with(principled::SUBSURFACE_ANISOTROPY, 1.0)
            .with(principled::SUBSURFACE_COLOR, color)
    }

    /// A Principled BSDF with its thin film. Where that is a share of it, it is two: with the film and without, and what they
    /// emit stands beside them.
    fn filmed(&mut self, m: &MetallicRoughness, node: Node, emission: Input) -> Link {
        let Some(film) = &m.iridescence else {
            return self.0.add(node);
        };
        let [least, most] = film.thickness;
        let thickness = match &film.thickness_texture {
            None => Input::from(most),
            Some(texture) => {
                let between = self.number(most - least, Some(texture), node::GREEN);
                self.math(MathOperation::Add, least, between, false).into()
            }
        };
        let with_film = |node: Node| {
            node.with(principled::THIN_FILM_THICKNESS, thickness)
                .with(principled::THIN_FILM_IOR, film.ior)
        };
        let factor = self.number(film.factor, film.texture.as_ref(), node::RED);
        if factor == Input::float(1.0) {
            return self.0.add(with_film(node));
        }
        let dark = node
            .with(principled::EMISSION_COLOR, 1.0)
            .with(principled::EMISSION_STRENGTH, 0.0);
        let plain = self.0.add(dark.clone());
        let filmed = self.0.add(with_film(dark));
        let mixed = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, factor);
        let mixed = mixed.with(mix_shader::A, plain).with(mix_shader::B, filmed);
        let mixed = self.0.add(mixed);
        if emission == Input::Value([0.0; 3]) {
            return mixed;
        }
        let shining = Node::new(NodeKind::Emission).with(emission::COLOR, emission);
        let shining = self.0.add(shining);
        let both = Node::new(NodeKind::AddShader);
        self.0
            .add(both.with(add_shader::A, mixed).with(add_shader::B, shining))
    }
}

impl From<MetallicRoughness> for Material {
    fn from(m: MetallicRoughness) -> Self {
        let mut builder = Builder::default();
        let vertices = builder.0.add(Node::new(NodeKind::ColorAttribute));
        let base = m.base_color_texture.as_ref();
        let base = base.map(|texture| builder.image(texture, ImageUse::Color));
        let mut color = builder.tinted(m.base_color, vertices);
        if let Some(base) = base {
            color = builder.tinted(color, base);
        }
        let shader = if m.unlit {
            let emission = Node::new(NodeKind::Emission).with(emission::COLOR, color);
            builder.0.add(emission)
        } else if let Some(node) = &m.simple {
            let normal = builder.normal(&m);
            let mut node = Node::clone(node);
            let sockets = node.kind.sockets().iter();
            for (input, socket) in node.inputs.iter_mut().zip(sockets) {
                if socket.name == "Normal" {
                    *input = normal;
                }
            }
            builder.0.add(node)
        } else if let Some(distribution) = m.glossy {
            builder.glossy(&m, distribution, color)
        } else {
            builder.principled(&m, color)
        };
        let surface = builder.opaque(&m, base, vertices, shader);
        let mut graph = builder.0;
        graph.surface = Some(surface);
        graph.prune();
        Self {
            name: m.name,
            graph,
            double_sided: m.double_sided,
            medium: m.medium,
            priority: m.priority,
        }
    }
}
