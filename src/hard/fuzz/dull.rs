//! Scenes with much in them that changes nothing: what `scene::simplify` and the detection of effects are to see through.

use super::dice::Dice;
use crate::scene::{
    AlphaMode, Image, ImageId, Mesh, NormalTexture, Pixels, RayKind, Sampler, Scene, Texture,
    UvTransform, Visibility,
};
use std::sync::Arc;

/// Makes parts of a scene dull.
pub fn dull(scene: &mut Scene, seed: u64) {
    let mut dice = Dice::new(seed);
    images(scene, &mut dice);
    materials(scene, &mut dice);
    meshes(scene, &mut dice);
    lights(scene, &mut dice);
}

/// An image of one value, or one whose opacity is 1, or a flat normal map.
fn image(dice: &mut Dice) -> Image {
    let (width, height) = (1 + dice.below(3) as u32, 1 + dice.below(3) as u32);
    let channels = 1 + dice.below(4);
    let texel = [(); 4].map(|()| dice.pick(&[0, 1, 127, 128, 200, 255]) as u8);
    let count = (width * height) as usize;
    let kind = dice.below(3);
    let texels = (0..count).map(|_| match kind {
        0 => texel,
        1 => [(); 4].map(|()| dice.below(256) as u8),
        _ => [
            127 + dice.below(2) as u8,
            127 + dice.below(2) as u8,
            255,
            255,
        ],
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

fn texture(scene: &mut Scene, dice: &mut Dice) -> Texture {
    scene.images.push(image(dice));
    Texture {
        image: ImageId(scene.images.len() as u32 - 1),
        uv_set: dice.below(2) as u32,
        transform: UvTransform {
            offset: [dice.unit() as f32, 0.0],
            rotation: dice.pick(&[0.0, 1.0]),
            scale: dice.pick(&[[1.0, 1.0], [7.3, -2.0]]),
        },
        sampler: Sampler::default(),
    }
}

/// The same image twice, and one of the environment that is the same everywhere.
fn images(scene: &mut Scene, dice: &mut Dice) {
    if let Some(last) = scene.images.last().cloned().filter(|_| dice.chance(0.3)) {
        scene.images.push(last);
        let (first, second) = (scene.images.len() as u32 - 2, scene.images.len() as u32 - 1);
        for material in &mut scene.materials {
            for texture in material.textures_mut().into_iter().flatten() {
                if texture.image.0 == first && dice.chance(0.5) {
                    texture.image = ImageId(second);
                }
            }
        }
    }
    if dice.chance(0.3)
        && let Some(environment) = &mut scene.environment
        && let Some(image) = environment.image
        && let Some(image) = scene.images.get_mut(image.0 as usize)
        && let Pixels::F32(values) = &mut image.pixels
    {
        let value = dice.pick(&[0.0, 0.7]);
        Arc::make_mut(values).fill(value);
    }
}

fn materials(scene: &mut Scene, dice: &mut Dice) {
    for number in 0..scene.materials.len() {
        for slot in 0..6 {
            if dice.chance(0.2) {
                let texture = texture(scene, dice);
                *scene.materials[number].textures_mut()[slot] = Some(texture);
            }
        }
        if dice.chance(0.2) {
            let texture = texture(scene, dice);
            let scale = dice.pick(&[1.0, 0.5, 0.0, 3.0]);
            scene.materials[number].normal_texture = Some(NormalTexture { texture, scale });
        }
        let material = &mut scene.materials[number];
        if dice.chance(0.3) {
            material.alpha_mode = dice.pick(&[AlphaMode::Blend, AlphaMode::Mask { cutoff: 0.5 }]);
            material.alpha = dice.pick(&[1.0, 1.0, 0.6]);
        }
        if dice.chance(0.1) {
            material.base_color = [0.0; 3];
        }
        if dice.chance(0.1) {
            (material.metallic, material.transmission) = dice.pick(&[(1.0, 0.4), (0.0, 1.0)]);
        }
        if dice.chance(0.1) {
            (material.specular, material.roughness) = (0.0, 0.0);
        }
    }
    if scene.materials.len() > 1 && dice.chance(0.3) {
        let first = scene.materials[0].clone();
        scene.materials[1] = first;
    }
    if dice.chance(0.2) {
        scene.materials.extend(scene.materials.first().cloned());
    }
}

fn meshes(scene: &mut Scene, dice: &mut Dice) {
    for mesh in &mut scene.meshes {
        if dice.chance(0.3) {
            let color = dice.pick(&[[1.0; 4], [0.5, 1.0, 1.0, 1.0]]);
            mesh.colors = Some(vec![color; mesh.positions.len()]);
        }
        if dice.chance(0.3) {
            mesh.uvs.extend(mesh.uvs.first().cloned());
        }
    }
    if dice.chance(0.2) {
        scene
            .meshes
            .extend(scene.meshes.first().cloned().map(|mesh| Mesh {
                name: "nowhere".into(),
                ..mesh
            }));
    }
    for instance in &mut scene.instances {
        if dice.chance(0.05) {
            let nobody = RayKind::ALL.iter();
            instance.visibility =
                nobody.fold(Visibility::ALL, |seen, (kind, _)| seen.without(*kind));
        }
    }
}

fn lights(scene: &mut Scene, dice: &mut Dice) {
    for light in &mut scene.lights {
        if dice.chance(0.2) {
            light.color = [0.0; 3];
        }
    }
}
