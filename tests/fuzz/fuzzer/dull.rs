//! Scenes with much in them that changes nothing: what `scene::simplify` and the detection of effects are to see through.

use super::rng::Rng;
use std::sync::Arc;
use sundog::scene::graph::node::{math, mix, mix_shader, normal_map, principled};
use sundog::scene::graph::{Blend, Graph, Input, Link, MathOperation, Node, NodeKind, SocketKind};
use sundog::scene::{
    Image, ImageId, ImageUse, Mesh, Pixels, RayKind, Sampler, Scene, Texture, UvTransform,
    Visibility,
};

/// Makes parts of a scene dull.
pub fn dull(scene: &mut Scene, seed: u64) {
    let mut rng = Rng::new(seed);
    images(scene, &mut rng);
    materials(scene, &mut rng);
    meshes(scene, &mut rng);
    lights(scene, &mut rng);
}

/// An image of one value, or one whose opacity is 1, or a flat normal map.
fn image(rng: &mut Rng) -> Image {
    let (width, height) = (1 + rng.below(3) as u32, 1 + rng.below(3) as u32);
    let channels = 1 + rng.below(4);
    let texel = [(); 4].map(|()| rng.pick(&[0, 1, 127, 128, 200, 255]) as u8);
    let count = (width * height) as usize;
    let kind = rng.below(3);
    let texels = (0..count).map(|_| match kind {
        0 => texel,
        1 => [(); 4].map(|()| rng.below(256) as u8),
        _ => [127 + rng.below(2) as u8, 127 + rng.below(2) as u8, 255, 255],
    });
    let opaque = kind > 0;
    let mut values: Vec<u8> = Vec::new();
    for mut texel in texels.collect::<Vec<_>>() {
        if opaque {
            texel[if channels == 2 { 1 } else { 3 }] = 255;
        }
        values.extend(&texel[..channels]);
    }
    Image {
        name: "dull".into(),
        width,
        height,
        channels: channels as u32,
        pixels: values.into(),
    }
}

fn texture(scene: &mut Scene, rng: &mut Rng) -> Texture {
    scene.images.push(image(rng));
    Texture {
        image: ImageId(scene.images.len() as u32 - 1),
        uv_set: rng.below(2) as u32,
        transform: UvTransform {
            offset: [rng.unit() as f32, 0.0],
            rotation: rng.pick(&[0.0, 1.0]),
            scale: rng.pick(&[[1.0, 1.0], [7.3, -2.0]]),
        },
        sampler: Sampler::default(),
    }
}

/// The same image twice, and one of the environment that is the same everywhere.
fn images(scene: &mut Scene, rng: &mut Rng) {
    if let Some(last) = scene.images.last().cloned().filter(|_| rng.chance(0.3)) {
        scene.images.push(last);
        let (first, second) = (scene.images.len() as u32 - 2, scene.images.len() as u32 - 1);
        for material in &mut scene.materials {
            for texture in material.graph.textures_mut() {
                if texture.image.0 == first && rng.chance(0.5) {
                    texture.image = ImageId(second);
                }
            }
        }
    }
    if rng.chance(0.3)
        && let Some(environment) = &mut scene.environment
        && let Some(image) = environment.image
        && let Some(image) = scene.images.get_mut(image.0 as usize)
        && let Pixels::F32(values) = &mut image.pixels
    {
        let value = rng.pick(&[0.0, 0.7]);
        Arc::make_mut(values).fill(value);
    }
}

/// Sockets that images are put into.
const TEXTURED: [usize; 7] = [
    principled::BASE_COLOR,
    principled::METALLIC,
    principled::ROUGHNESS,
    principled::EMISSION_COLOR,
    principled::SPECULAR_IOR_LEVEL,
    principled::SPECULAR_TINT,
    principled::TRANSMISSION_WEIGHT,
];

fn principled_of(graph: &Graph) -> Vec<usize> {
    let is = |node: &Node| matches!(node.kind, NodeKind::PrincipledBsdf { .. });
    let nodes = graph.nodes.iter().enumerate();
    nodes
        .filter_map(|(at, node)| is(node).then_some(at))
        .collect()
}

/// Puts nodes before another one; the last of them is what its socket takes.
fn insert(graph: &mut Graph, at: usize, socket: usize, nodes: Vec<Node>) {
    let count = nodes.len() as u32;
    let later = |link: &mut Link| {
        if link.node >= at as u32 {
            link.node += count;
        }
    };
    for input in graph.nodes[at..].iter_mut().flat_map(|n| &mut n.inputs) {
        if let Input::Link(link) = input {
            later(link);
        }
    }
    graph.surface.as_mut().into_iter().for_each(later);
    graph.nodes.splice(at..at, nodes);
    let node = at as u32 + count - 1;
    graph.nodes[at + count as usize].inputs[socket] = Input::Link(Link { node, output: 0 });
}

fn link(node: usize) -> Link {
    Link {
        node: node as u32,
        output: 0,
    }
}

/// Multiplies what is in a socket with an image.
fn multiply(graph: &mut Graph, socket: usize, texture: Texture) {
    for at in principled_of(graph).into_iter().rev() {
        let before = graph.nodes[at].inputs[socket];
        let usage = match principled::SOCKETS[socket].kind {
            SocketKind::Color => ImageUse::Color,
            _ => ImageUse::Data,
        };
        let texture = texture.clone();
        let image = Node::new(NodeKind::ImageTexture {
            texture,
            usage,
            projection: Default::default(),
        });
        let product = match usage {
            ImageUse::Color | ImageUse::Codes => Node::new(NodeKind::MixColor {
                blend: Blend::Multiply,
            })
            .with(mix::FACTOR, 1.0)
            .with(mix::A, before)
            .with(mix::B, link(at)),
            ImageUse::Data => Node::new(NodeKind::Math {
                operation: MathOperation::Multiply,
                clamp: false,
            })
            .with(math::A, before)
            .with(math::B, link(at)),
        };
        insert(graph, at, socket, vec![image, product]);
    }
}

fn bump(graph: &mut Graph, texture: Texture, strength: f32) {
    for at in principled_of(graph).into_iter().rev() {
        let usage = ImageUse::Data;
        let texture = texture.clone();
        let image = Node::new(NodeKind::ImageTexture {
            texture,
            usage,
            projection: Default::default(),
        });
        let map = Node::new(NodeKind::NormalMap {
            space: Default::default(),
        })
        .with(normal_map::STRENGTH, strength)
        .with(normal_map::COLOR, link(at));
        insert(graph, at, principled::NORMAL, vec![image, map]);
    }
}

/// Mixes the surface with a transparent one.
fn thin_out(graph: &mut Graph, alpha: f32, clip: bool) {
    let Some(surface) = graph.surface else {
        return;
    };
    graph.make_opaque();
    let surface = graph.surface.unwrap_or(surface);
    let clear = graph.add(Node::new(NodeKind::TransparentBsdf));
    let mixed = Node::new(NodeKind::MixShader);
    let mixed = if clip {
        let hole = Node::new(NodeKind::Math {
            operation: MathOperation::LessThan,
            clamp: false,
        });
        let hole = graph.add(hole.with(math::A, alpha).with(math::B, 0.5));
        let mixed = mixed.with(mix_shader::FACTOR, hole);
        mixed
            .with(mix_shader::A, surface)
            .with(mix_shader::B, clear)
    } else {
        let mixed = mixed.with(mix_shader::FACTOR, alpha);
        mixed
            .with(mix_shader::A, clear)
            .with(mix_shader::B, surface)
    };
    graph.surface = Some(graph.add(mixed));
}

fn materials(scene: &mut Scene, rng: &mut Rng) {
    for number in 0..scene.materials.len() {
        for socket in TEXTURED {
            if rng.chance(0.2) {
                let texture = texture(scene, rng);
                multiply(&mut scene.materials[number].graph, socket, texture);
            }
        }
        if rng.chance(0.2) {
            let texture = texture(scene, rng);
            let strength = rng.pick(&[1.0, 0.5, 0.0, 3.0]);
            bump(&mut scene.materials[number].graph, texture, strength);
        }
        let graph = &mut scene.materials[number].graph;
        if rng.chance(0.3) {
            let clip = rng.chance(0.5);
            let alpha = rng.pick(&[1.0, 1.0, 0.6]);
            thin_out(graph, alpha, clip);
        }
        let mut set = |socket: usize, value: f32| {
            for node in principled_of(graph) {
                graph.nodes[node].inputs[socket] = value.into();
            }
        };
        if rng.chance(0.1) {
            set(principled::BASE_COLOR, 0.0);
        }
        if rng.chance(0.1) {
            let (metallic, transmission) = rng.pick(&[(1.0, 0.4), (0.0, 1.0)]);
            set(principled::METALLIC, metallic);
            set(principled::TRANSMISSION_WEIGHT, transmission);
        }
        if rng.chance(0.1) {
            set(principled::SPECULAR_IOR_LEVEL, 0.0);
            set(principled::ROUGHNESS, 0.0);
        }
        graph.prune();
    }
    if scene.materials.len() > 1 && rng.chance(0.3) {
        let first = scene.materials[0].clone();
        scene.materials[1] = first;
    }
    if rng.chance(0.2) {
        scene.materials.extend(scene.materials.first().cloned());
    }
}

fn meshes(scene: &mut Scene, rng: &mut Rng) {
    for mesh in &mut scene.meshes {
        if rng.chance(0.3) {
            let color = rng.pick(&[[1.0; 4], [0.5, 1.0, 1.0, 1.0]]);
            mesh.colors = Some(vec![color; mesh.positions.len()]);
        }
        if rng.chance(0.3) {
            mesh.uvs.extend(mesh.uvs.first().cloned());
        }
    }
    if rng.chance(0.2) {
        scene
            .meshes
            .extend(scene.meshes.first().cloned().map(|mesh| Mesh {
                name: "nowhere".into(),
                ..mesh
            }));
    }
    for instance in &mut scene.instances {
        if rng.chance(0.05) {
            let nobody = RayKind::ALL.iter();
            instance.visibility =
                nobody.fold(Visibility::ALL, |seen, (kind, _)| seen.without(*kind));
        }
    }
}

fn lights(scene: &mut Scene, rng: &mut Rng) {
    for light in &mut scene.lights {
        if rng.chance(0.2) {
            light.color = [0.0; 3];
        }
    }
}
