use super::*;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::{Function, Node, NodeKind, Opacity, Slot};
use crate::scene::{
    AlphaMode, Effect, Environment, Image, ImageId, Instance, Light, LightKind, MaterialId, Mesh,
    MeshId, MetallicRoughness, NormalTexture, RayKind, Texture, Visibility,
};
use glam::DAffine3;

/// Of 8 bits.
const STEP: f32 = 1.0 / 255.0;

fn image(channels: u32, texels: &[&[u8]]) -> Image {
    Image {
        name: format!("image of {channels}"),
        width: texels.len() as u32,
        height: 1,
        channels,
        pixels: texels.concat().into(),
    }
}

fn texture(image: u32) -> Texture {
    ImageId(image).into()
}

fn plastic(name: &str) -> MetallicRoughness {
    MetallicRoughness {
        name: name.into(),
        metallic: 0.0,
        roughness: 0.5,
        ..MetallicRoughness::default()
    }
}

/// A triangle for each material.
fn scene(materials: Vec<MetallicRoughness>, images: Vec<Image>) -> Scene {
    let mut scene = Scene {
        materials: materials.into_iter().map(Into::into).collect(),
        images,
        ..Scene::default()
    };
    for number in 0..scene.materials.len() as u32 {
        scene.meshes.push(Mesh {
            name: format!("mesh {number}"),
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            tangents: Some(vec![[1.0, 0.0, 0.0, 1.0]; 3]),
            uvs: vec![vec![[0.0; 2]; 3]; 2],
            triangles: vec![[0, 1, 2]],
            material: Some(MaterialId(number)),
            ..Mesh::default()
        });
        scene.instances.push(Instance {
            motion: Vec::new(),
            name: format!("object {number}"),
            mesh: MeshId(number),
            world_from_object: DAffine3::IDENTITY,
            visibility: Visibility::ALL,
            holdout: false,
            info: Default::default(),
        });
    }
    scene
}

fn told(left_out: &[LeftOut], effect: impl Into<Option<Effect>>) -> Vec<String> {
    let effect = effect.into();
    let of = left_out.iter().filter(|entry| entry.effect == effect);
    of.map(ToString::to_string).collect()
}

#[test]
fn an_image_that_is_the_same_everywhere_is_a_factor() {
    let mut m = plastic("m");
    m.base_color = [0.5, 1.0, 1.0];
    m.base_color_texture = Some(texture(0));
    m.metallic = 1.0;
    m.metallic_roughness_texture = Some(texture(1));
    m.emission = [2.0; 3];
    m.emission_texture = Some(texture(2));
    let images = vec![
        image(3, &[&[255, 0, 255], &[255, 0, 255], &[255, 0, 255]]),
        // Red differs, but nobody reads it.
        image(3, &[&[1, 51, 102], &[2, 51, 102]]),
        image(1, &[&[10], &[11]]),
    ];
    let mut scene = scene(vec![m], images);
    let left_out = simplify(&mut scene);
    let graph = &scene.materials[0].graph;
    let p = graph.summary(false).principled[0];
    assert_eq!(p.base_color.to_array(), [0.5, 0.0, 1.0]);
    let (roughness, metallic) = (0.5 * (51.0 * STEP), 102.0 * STEP);
    assert_eq!(p.roughness, (roughness, roughness));
    assert_eq!(p.metallic, (metallic, metallic));
    // The one that varies is the only one left, under its new number.
    assert!(graph.has_texture(Slot::Emission));
    assert_eq!(graph.textures().collect::<Vec<_>>(), [&texture(0)]);
    // It, the factor on it, and the surface.
    assert_eq!(graph.nodes.len(), 3);
    assert_eq!(scene.images.len(), 1);
    assert_eq!(
        told(&left_out, Effect::BaseColorTexture),
        ["the image is the same everywhere and becomes a factor: m"]
    );
    let bytes: u64 = left_out.iter().map(|entry| entry.bytes).sum();
    // Two images, tangents of three vertices, a second set of coordinates.
    assert_eq!(bytes, 9 + 6 + 3 * 16 + 3 * 8);
}

#[test]
fn opacity_is_1_only_where_it_is_everywhere() {
    let with = |alpha_mode, texture: Option<Texture>, alpha| MetallicRoughness {
        alpha_mode,
        alpha,
        base_color_texture: texture,
        ..plastic("m")
    };
    let mask = AlphaMode::Mask { cutoff: 0.5 };
    let images = || {
        vec![
            image(4, &[&[1, 2, 3, 255], &[3, 2, 1, 255]]),
            image(4, &[&[1, 2, 3, 254], &[3, 2, 1, 255]]),
            image(4, &[&[1, 2, 3, 127], &[3, 2, 1, 255]]),
            image(3, &[&[1, 2, 3], &[3, 2, 1]]),
        ]
    };
    let cases = [
        (with(AlphaMode::Blend, None, 1.0), true),
        (with(AlphaMode::Blend, None, 0.999), false),
        (with(AlphaMode::Blend, Some(texture(0)), 1.0), true),
        (with(AlphaMode::Blend, Some(texture(1)), 1.0), false),
        (with(AlphaMode::Blend, Some(texture(3)), 1.0), true),
        (with(mask, Some(texture(1)), 1.0), true),
        (with(mask, Some(texture(2)), 1.0), false),
        (with(mask, Some(texture(1)), 0.5), false),
        (with(AlphaMode::Mask { cutoff: 1.0 }, None, 1.0), true),
        (with(AlphaMode::Mask { cutoff: 1.5 }, None, 1.0), false),
    ];
    for (material, opaque) in cases {
        let mut scene = scene(vec![material.clone()], images());
        simplify(&mut scene);
        let found = scene.materials[0].summary().opacity == Opacity::Full;
        assert_eq!(found, opaque, "{material:?}");
    }
    // Vertices count, too.
    let mut scene = scene(vec![with(AlphaMode::Blend, None, 1.0)], images());
    scene.meshes[0].colors = Some(vec![[1.0, 1.0, 1.0, 0.9]; 3]);
    simplify(&mut scene);
    let opacity = scene.materials[0].graph.summary(true).opacity;
    assert_eq!(opacity, Opacity::Blend { below: true });
}

#[test]
fn flat_normal_maps_are_none() {
    let with = |scale| MetallicRoughness {
        normal_texture: Some(NormalTexture {
            texture: texture(0),
            scale,
        }),
        ..plastic("m")
    };
    let flat: &[&[u8]] = &[&[128, 127, 255], &[127, 128, 255]];
    let bumpy: &[&[u8]] = &[&[128, 127, 255], &[126, 128, 255]];
    for (scale, texels, gone) in [
        (1.0, flat, true),
        (2.0, flat, false),
        (1.0, bumpy, false),
        (0.0, bumpy, true),
    ] {
        let mut scene = scene(vec![with(scale)], vec![image(3, texels)]);
        let left_out = simplify(&mut scene);
        assert_eq!(!scene.materials[0].graph.has_normal_map(), gone);
        assert_eq!(scene.meshes[0].tangents.is_none(), gone);
        assert_eq!(!told(&left_out, Effect::NormalMaps).is_empty(), gone);
    }
}

#[test]
fn what_is_below_metal_or_glass_is_not_read() {
    let images = || vec![image(4, &[&[1, 2, 3, 4], &[4, 3, 2, 1]])];
    let all = |m: MetallicRoughness| MetallicRoughness {
        specular_texture: Some(texture(0)),
        specular_color_texture: Some(texture(0)),
        transmission_texture: Some(texture(0)),
        emission_texture: Some(texture(0)),
        ..m
    };
    let count = |m: MetallicRoughness| {
        let mut scene = scene(vec![all(m)], images());
        simplify(&mut scene);
        let graph = &scene.materials[0].graph;
        let slots = Slot::ALL.into_iter();
        slots.filter(|slot| graph.has_texture(*slot)).count()
    };
    let metal = |metallic| MetallicRoughness {
        metallic,
        transmission: 0.5,
        ..plastic("m")
    };
    assert_eq!(count(metal(1.0)), 0);
    assert_eq!(count(metal(0.9)), 3);
    assert_eq!(count(plastic("without transmission")), 2);
    let unlit = MetallicRoughness {
        unlit: true,
        emission: [1.0; 3],
        ..plastic("m")
    };
    assert_eq!(count(unlit), 0);
    let dull = MetallicRoughness {
        specular: 0.0,
        ..plastic("m")
    };
    assert_eq!(count(dull), 0);
}

#[test]
fn the_same_twice_is_once() {
    let with = |name: &str, image| MetallicRoughness {
        base_color_texture: Some(texture(image)),
        ..plastic(name)
    };
    let texels: &[&[u8]] = &[&[1, 2, 3], &[3, 2, 1]];
    let images = vec![
        image(3, texels),
        image(3, texels),
        image(3, &[&[9, 9, 9], texels[0]]),
    ];
    let mut scene = scene(vec![with("a", 0), with("b", 1), with("c", 2)], images);
    let left_out = simplify(&mut scene);
    assert_eq!((scene.materials.len(), scene.images.len()), (2, 2));
    let used: Vec<_> = scene.meshes.iter().map(|mesh| mesh.material).collect();
    assert_eq!(used, [0, 0, 1].map(|n| Some(MaterialId(n))));
    let textures: Vec<_> = scene.materials[1].graph.textures().collect();
    assert_eq!(textures, [&texture(1)]);
    let nothing = told(&left_out, None);
    assert!(nothing.contains(&"images identical to others: image of 3".to_owned()));
    assert!(nothing.contains(&"materials identical to others: b".to_owned()));
}

#[test]
fn what_no_ray_sees_is_gone() {
    let mut scene = scene(vec![plastic("a"), plastic("b")], Vec::new());
    let hidden = RayKind::ALL
        .iter()
        .fold(Visibility::ALL, |seen, (kind, _)| seen.without(*kind));
    scene.instances[0].visibility = hidden;
    scene.instances[1].visibility = hidden.with(RayKind::Shadow);
    scene.meshes[1].colors = Some(vec![[1.0; 4]; 3]);
    let light = |intensity, color| Light {
        name: "lamp".into(),
        color,
        kind: LightKind::Point {
            intensity,
            radius: 0.1,
            soft_falloff: false,
        },
        world_from_light: DAffine3::IDENTITY,
        visibility: Visibility::ALL,
        max_bounces: 4,
        is_hit: true,
        links: Default::default(),
        graph: None,
    };
    scene.lights = vec![
        light(0.0, [1.0; 3]),
        light(1.0, [0.0; 3]),
        light(1.0, [0.0, 0.1, 0.0]),
    ];
    scene.images.push(Image {
        name: "sky".into(),
        width: 2,
        height: 1,
        channels: 3,
        pixels: vec![0.25f32; 6].into(),
    });
    scene.environment = Some(Environment {
        image: Some(ImageId(0)),
        radiance: [2.0; 3],
        rotation: glam::DMat3::IDENTITY,
        visibility: Visibility::ALL,
        links: Default::default(),
        graph: None,
    });
    let left_out = simplify(&mut scene);
    assert_eq!((scene.instances.len(), scene.meshes.len()), (1, 1));
    assert_eq!(scene.instances[0].mesh, MeshId(0));
    assert!(scene.meshes[0].colors.is_none());
    assert_eq!(scene.lights.len(), 1);
    let environment = scene.environment.as_ref().unwrap();
    assert_eq!((environment.image, environment.radiance), (None, [0.5; 3]));
    assert!(scene.images.is_empty());
    assert_eq!(
        told(&left_out, Effect::PointLights),
        ["the light is black: lamp and 1 more"]
    );
    // Nothing is left to be taken out.
    assert!(simplify(&mut scene).is_empty());
}

#[test]
fn texture_coordinates_stay_that_a_tree_asks_for() {
    for (set, kept) in [(0, 1), (1, 2)] {
        let mut scene = scene(vec![plastic("a")], Vec::new());
        let asks = NodeKind::Function(Function::Place(PlaceInput::Uv(set)));
        scene.materials[0].graph.add(Node::new(asks));
        unused::attributes(&mut scene, &mut Vec::new());
        assert_eq!(scene.meshes[0].uvs.len(), kept);
    }
}
