//! UsdPreviewSurface and its nodes, as Blender's Principled BSDF and image textures.

use super::materials::Tiles;
use super::network::{Found, Network, Term};
use super::source::View;
use super::value;
use crate::nodes::math::Math;
use crate::nodes::vector::Mapping;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::node::{image_texture, math, mix_shader, normal_map, principled};
use crate::scene::graph::{
    Function, Graph, ImageProjection, Input, Link, MathOperation, Node, NodeKind, NormalSpace,
    ShaderRules,
};
use crate::scene::{ImageUse, Sampler, Texture, TextureFilter, Verdict, Wrap};

/// The coordinates that are meant where none are named.
pub(super) const DEFAULT_UV: &str = "st";

/// A Principled BSDF of a solid.
pub(super) fn principled() -> Node {
    Node::new(NodeKind::PrincipledBsdf {
        thin_wall: false,
        pane: false,
        edge_tint: true,
        once: false,
        walk: None,
        rules: ShaderRules::default(),
    })
}

/// A shader where the opacity lets it be.
pub(super) fn seen_through(graph: &mut Graph, shader: Link, opacity: Input) -> Link {
    if opacity == Input::float(1.0) {
        return shader;
    }
    let clear = graph.add(Node::new(NodeKind::TransparentBsdf));
    let mixed = Node::new(NodeKind::MixShader)
        .with(mix_shader::FACTOR, opacity)
        .with(mix_shader::A, clear)
        .with(mix_shader::B, shader);
    graph.add(mixed)
}

/// The graph of a UsdPreviewSurface.
pub(super) fn surface(network: &mut Network, shader: &View) -> Link {
    let one = Term::number;
    let color = network.input_or(shader, "diffuseColor", Term::color([0.18; 3]));
    let emission = network.input_or(shader, "emissiveColor", Term::color([0.0; 3]));
    let roughness = network.input_or(shader, "roughness", one(0.5));
    let coat = network.input_or(shader, "clearcoat", one(0.0));
    let coat_roughness = network.input_or(shader, "clearcoatRoughness", one(0.01));
    let opacity = network.input_or(shader, "opacity", one(1.0));
    let ior = network.input_or(shader, "ior", one(1.5));
    let mut node = principled()
        .with(principled::BASE_COLOR, color.rgb)
        .with(principled::ROUGHNESS, roughness.rgb)
        .with(principled::COAT_WEIGHT, coat.rgb)
        .with(principled::COAT_ROUGHNESS, coat_roughness.rgb)
        .with(principled::EMISSION_COLOR, emission.rgb)
        .with(principled::EMISSION_STRENGTH, 1.0);
    if network.plain(shader, "useSpecularWorkflow") == Some(1.0) {
        let specular = network.input_or(shader, "specularColor", Term::color([0.0; 3]));
        node = specular_workflow(node, specular);
    } else {
        let metallic = network.input_or(shader, "metallic", one(0.0));
        node = node
            .with(principled::METALLIC, metallic.rgb)
            .with(principled::IOR, ior.rgb);
    }
    if let Some(normal) = normal(network, shader, "normal") {
        node = node.with(principled::NORMAL, normal);
    }
    let threshold = network.plain(shader, "opacityThreshold").unwrap_or(0.0);
    let shader = network.graph.add(node);
    let opacity = if threshold > 0.0 {
        // 1 where the opacity reaches the threshold.
        let (operation, clamp) = (MathOperation::LessThan, false);
        let hole = Node::new(NodeKind::Math { operation, clamp });
        let hole = hole.with(math::A, opacity.rgb).with(math::B, threshold);
        let hole = network.graph.add(hole);
        let inputs = [Input::float(1.0), hole.into()];
        network.math(Math::Subtract, &inputs)
    } else {
        opacity.rgb
    };
    seen_through(&mut network.graph, shader, opacity)
}

/// A dielectric whose reflectance at normal incidence is a colour. The index of refraction gives its brightest part, and the tint
/// the rest; where the colour is an image, the index is that of a reflectance of 0.99 and the tint all of it.
fn specular_workflow(node: Node, specular: Term) -> Node {
    let (ior, tint) = match specular.constant() {
        Some(color) => {
            let most = color.iter().fold(0.0f32, |m, c| m.max(*c)).clamp(0.0, 0.99);
            let root = most.sqrt();
            let tint = if most > 0.0 {
                color.map(|c| (c / most).min(1.0))
            } else {
                [1.0; 3]
            };
            ((1.0 + root) / (1.0 - root), Input::Value(tint))
        }
        None => {
            let root = 0.99f32.sqrt();
            ((1.0 + root) / (1.0 - root), specular.rgb)
        }
    };
    node.with(principled::METALLIC, 0.0)
        .with(principled::IOR, ior)
        .with(principled::SPECULAR_TINT, tint)
}

/// A normal in tangent space, from −1 to 1.
fn normal(network: &mut Network, shader: &View, input: &str) -> Option<Link> {
    let Found::Node(path, output) = network.find(shader, input) else {
        // A constant one is the surface's own, or has no meaning.
        return None;
    };
    let source = network.source?;
    let from = source.view(&path);
    let coded = if from.word("info:id").as_deref() == Some("UsdUVTexture") {
        texture(network, &from, &output, (0.5, 0.5))?
    } else {
        let term = network.node(&path, &output)?;
        network.scaled(term, [0.5; 4], [0.5; 4])
    };
    if network.needs.tangents.is_none() {
        let set = if network.needs.uvs.is_empty() {
            network.uv_set(DEFAULT_UV)
        } else {
            uv_of(network, &from).unwrap_or(0)
        };
        network.needs.tangents = Some(set as usize);
    }
    let space = NormalSpace::Gltf;
    let map = Node::new(NodeKind::NormalMap { space }).with(normal_map::COLOR, coded.rgb);
    Some(network.graph.add(map))
}

/// The set of coordinates that a texture lies by.
fn uv_of(network: &mut Network, shader: &View) -> Option<u32> {
    let mut at = shader.path().clone();
    for input in ["st", "in", "in"] {
        let source = network.source?;
        let view = source.view(&at);
        let Found::Node(path, _) = network.find(&view, input) else {
            return None;
        };
        let reader = source.view(&path);
        if reader.word("info:id")?.starts_with("UsdPrimvarReader") {
            let name = network.word(&reader, "varname")?;
            return Some(network.uv_set(&name));
        }
        at = path;
    }
    None
}

/// What a node of the preview's kind gives.
pub(super) fn node(network: &mut Network, shader: &View, id: &str, output: &str) -> Option<Term> {
    match id {
        "UsdUVTexture" => texture(network, shader, output, (1.0, 0.0)),
        "UsdTransform2d" => transform(network, shader),
        _ => primvar(network, shader, id.strip_prefix("UsdPrimvarReader_")?),
    }
}

fn transform(network: &mut Network, shader: &View) -> Option<Term> {
    let from = network.input_or(shader, "in", Term::color([0.0; 3]));
    let scale = network.input_or(shader, "scale", Term::color([1.0; 3]));
    let moved = network.input_or(shader, "translation", Term::color([0.0; 3]));
    let angle = network
        .plain(shader, "rotation")
        .unwrap_or(0.0)
        .to_radians();
    let mapping = Function::Mapping(Mapping::Point);
    let inputs = [
        from.rgb,
        moved.rgb,
        Input::Value([0.0, 0.0, angle]),
        scale.rgb,
    ];
    Some(Term::link(network.function(mapping, &inputs), 2))
}

fn primvar(network: &mut Network, shader: &View, kind: &str) -> Option<Term> {
    let fallback = match network.find(shader, "fallback") {
        Found::Value(value) => value::floats(&value),
        _ => None,
    };
    let (components, numbers) = fallback.unwrap_or((1, vec![0.0]));
    let at = |i: usize| numbers.get(if components == 1 { 0 } else { i }).copied();
    let fallback = [0, 1, 2, 3].map(|i| at(i).unwrap_or(if i == 3 { 1.0 } else { 0.0 }));
    let name = network.word(shader, "varname").unwrap_or_default();
    if name.is_empty() {
        return Some(Term {
            rgb: Input::Value([fallback[0], fallback[1], fallback[2]]),
            a: Input::float(fallback[3]),
            size: if kind == "float" { 1 } else { 3 },
        });
    }
    if kind == "float2" {
        if components == 2 {
            let fallback = [fallback[0], fallback[1]];
            let known = network.needs.uv_fallbacks.entry(name.clone());
            known.or_insert(fallback);
        }
        let set = network.uv_set(&name);
        return Some(Term::link(network.place(PlaceInput::Uv(set)), 2));
    }
    if !matches!(
        kind,
        "float" | "int" | "float3" | "float4" | "point" | "normal" | "vector"
    ) {
        return None;
    }
    let number = network.attribute(&name, fallback);
    let link = network.place(PlaceInput::Attribute(number));
    Some(match kind {
        "float" | "int" => {
            let parts = network.function(Function::SeparateXyz, &[link.into()]);
            Term::link(parts, 1)
        }
        _ => Term {
            rgb: link.into(),
            a: Link { output: 1, ..link }.into(),
            size: if kind == "float4" { 4 } else { 3 },
        },
    })
}

/// An output of a UsdUVTexture, times a number and another added.
fn texture(
    network: &mut Network,
    shader: &View,
    output: &str,
    (times, plus): (f32, f32),
) -> Option<Term> {
    let four = |term: Option<Term>, fallback: [f32; 4]| {
        let Some(term) = term else { return fallback };
        let [r, g, b] = term
            .constant()
            .unwrap_or([fallback[0], fallback[1], fallback[2]]);
        let a = match term.a {
            Input::Value([a, ..]) => a,
            _ => fallback[3],
        };
        [r, g, b, a]
    };
    let scale = four(network.input(shader, "scale"), [1.0; 4]);
    let bias = four(network.input(shader, "bias"), [0.0; 4]);
    let fallback = four(network.input(shader, "fallback"), [0.0, 0.0, 0.0, 1.0]);
    let by = scale.map(|s| s * times);
    let add = bias.map(|b| b * times + plus);
    let space = network.word(shader, "sourceColorSpace");
    let usage = match space.as_deref() {
        Some("sRGB" | "srgb") => Some(ImageUse::Color),
        Some("raw" | "Raw" | "linear") => Some(ImageUse::Data),
        // The path itself may say it.
        _ => shader
            .property_word("inputs:file", "colorSpace")
            .and_then(|space| color_space(&space)),
    };
    let wrap = |word: Option<String>| match word.as_deref() {
        Some("clamp") => Wrap::Clamp,
        Some("mirror") => Wrap::Mirror,
        Some("black") => Wrap::Clip,
        // "useMetadata" too: images have none, and Blender repeats them.
        _ => Wrap::Repeat,
    };
    let sampler = Sampler {
        wrap_u: wrap(network.word(shader, "wrapS")),
        wrap_v: wrap(network.word(shader, "wrapT")),
        filter: TextureFilter::Linear,
        ..Sampler::default()
    };
    let coordinates = match network.find(shader, "st") {
        Found::Nothing => {
            let set = network.uv_set(DEFAULT_UV);
            network.place(PlaceInput::Uv(set)).into()
        }
        Found::Value(value) => Term::of(&value)?.rgb,
        Found::Node(path, output) => network.node(&path, &output)?.rgb,
    };
    let file = network.asset(shader, "file");
    let term = match file {
        Some(file) => image(network, file, (coordinates, usage), sampler),
        None => {
            network.report(
                "image-lost",
                Verdict::Lost,
                "textures without a file".into(),
                "they show their fallback",
            );
            None
        }
    };
    let term = match term {
        Some(term) => network.scaled(term, by, add),
        // The fallback is what the texture gives in the end.
        None => {
            let [r, g, b, a] = fallback.map(|v| v * times + plus);
            Term {
                rgb: Input::Value([r, g, b]),
                a: Input::float(a),
                size: 4,
            }
        }
    };
    Some(match output {
        "r" | "g" | "b" | "a" => {
            let at = "rgba".find(output).unwrap_or(0) as u8;
            let rgb = network.channel(term, at);
            Term {
                rgb,
                a: Input::float(1.0),
                size: 1,
            }
        }
        "rgba" => term,
        _ => Term { size: 3, ..term },
    })
}

/// What values of a colour space mean, if it is one of ours.
pub(super) fn color_space(name: &str) -> Option<ImageUse> {
    match name {
        "sRGB"
        | "srgb"
        | "srgb_texture"
        | "srgb_rec709_display"
        | "srgb_rec709_scene"
        | "srgb_displayp3" => Some(ImageUse::Color),
        "raw" | "Raw" | "linear" | "data" | "identity" | "lin_rec709" | "lin_rec709_scene"
        | "lin_srgb" => Some(ImageUse::Data),
        _ => None,
    }
}

/// An image at some coordinates; `usage` is none where the file itself decides.
pub(super) fn image(
    network: &mut Network,
    (place, called): (String, String),
    (coordinates, usage): (Input, Option<ImageUse>),
    sampler: Sampler,
) -> Option<Term> {
    let source = network.source?;
    let owner = network.material.clone();
    let owner = format!("material \"{owner}\"");
    let (images, diagnostics) = (network.images.as_mut()?, network.diagnostics.as_mut()?);
    let file = (place.as_str(), called.as_str());
    let texture = |image| Texture {
        sampler,
        ..Texture::from(image)
    };
    let projection = ImageProjection::Flat;
    let of = |srgb: bool| {
        if srgb {
            ImageUse::Color
        } else {
            ImageUse::Data
        }
    };
    let kind = if place.contains("<UDIM>") {
        let tiles = images.tiles(source, file, &owner, diagnostics);
        let (_, first) = *tiles.first()?;
        if let Input::Link(at) = coordinates
            && let NodeKind::Function(Function::Place(PlaceInput::Uv(set))) =
                network.graph.node(at).kind
        {
            network.needs.tiles.push(Tiles {
                set,
                numbers: tiles.iter().map(|(number, _)| *number).collect(),
                called: file.1.to_owned(),
            });
        }
        NodeKind::TiledImage {
            numbers: tiles.iter().map(|(number, _)| *number).collect(),
            textures: tiles.iter().map(|(_, image)| texture(*image)).collect(),
            usage: usage.unwrap_or_else(|| of(images.is_srgb(first))),
            projection,
        }
    } else {
        let image = images.get(source, file, &owner, diagnostics)?;
        NodeKind::ImageTexture {
            texture: texture(image),
            usage: usage.unwrap_or_else(|| of(images.is_srgb(image))),
            projection,
        }
    };
    let node = Node::new(kind).with(image_texture::VECTOR, coordinates);
    let link = network.graph.add(node);
    Some(Term {
        rgb: link.into(),
        a: Link { output: 1, ..link }.into(),
        size: 4,
    })
}

/// Operations of one number and of several, for [`each`].
pub(super) const ADD: (Math, VectorMath) = (Math::Add, VectorMath::Add);
pub(super) const SUBTRACT: (Math, VectorMath) = (Math::Subtract, VectorMath::Subtract);
pub(super) const MULTIPLY: (Math, VectorMath) = (Math::Multiply, VectorMath::Multiply);

/// All of a term's numbers by one operation.
pub(super) fn each(
    network: &mut Network,
    (numbers, vectors): (Math, VectorMath),
    terms: &[Term],
) -> Term {
    let size = terms.iter().map(|t| t.size).max().unwrap_or(1);
    let inputs: Vec<Input> = terms.iter().map(|t| t.rgb).collect();
    let rgb = if size == 1 {
        network.math(numbers, &inputs)
    } else {
        network.vector(vectors, &inputs)
    };
    let a = if size == 4 {
        let inputs: Vec<Input> = terms
            .iter()
            .map(|t| if t.size == 4 { t.a } else { t.rgb })
            .collect();
        network.math(numbers, &inputs)
    } else {
        Input::float(1.0)
    };
    Term { rgb, a, size }
}
