//! EXT_lights_image_based: an environment by the six faces of a cube.
//!
//! The extension's prefiltered levels and its spherical harmonics are what the sharpest level makes of light on rough and on
//! matte surfaces. A path tracer finds that itself, so that the sharpest level alone is read.

use glam::{DQuat, Vec2, Vec3};
use rayon::prelude::*;
use serde::Deserialize;
use std::f32::consts::{PI, TAU};

use super::container::Document;
use super::textures::Images;
use super::words;
use crate::import::ImportError;
use crate::import::image::make_radiance;
use crate::math::srgb;
use crate::scene::{
    Diagnostics, Effect, Environment, Image, ImageId, Links, Pixels, Scene, Verdict, Visibility,
};

pub(super) const NAME: &str = "EXT_lights_image_based";

/// The widest environment that is made of a cube's faces.
const MOST_COLUMNS: u32 = 8192;

#[derive(Debug, Deserialize)]
struct ReferenceJson {
    light: usize,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct LightJson {
    #[serde(default = "upright")]
    rotation: [f64; 4],
    #[serde(default = "super::schema::one")]
    intensity: f64,
    #[serde(default)]
    specular_images: Vec<[usize; 6]>,
    #[serde(default)]
    irradiance_coefficients: Vec<[f32; 3]>,
}

fn upright() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

/// Linear colours of a square.
struct Face {
    size: usize,
    colors: Vec<Vec3>,
}

impl Face {
    /// `None` for what is no square.
    fn new(image: &Image) -> Option<Self> {
        let size = image.width as usize;
        if image.width != image.height || size == 0 {
            return None;
        }
        let of = |share: f32| srgb::decode(share);
        let colors = |codes: &dyn Fn(usize) -> f32, is_light: bool| {
            let channels = image.channels.max(1) as usize;
            (0..size * size)
                .map(|pixel| {
                    let at = |c: usize| codes(pixel * channels + c.min(channels - 1));
                    let [r, g, b] = match channels {
                        1 | 2 => [at(0); 3],
                        _ => [at(0), at(1), at(2)],
                    };
                    if is_light {
                        return Vec3::new(r, g, b);
                    }
                    let color = Vec3::new(of(r), of(g), of(b));
                    // RGBD: what is brighter than 1 has been multiplied with the alpha.
                    match channels {
                        4 => color / at(3).max(1.0 / 255.0),
                        _ => color,
                    }
                })
                .collect()
        };
        let colors = match &image.pixels {
            Pixels::U8(values) => colors(&|i| f32::from(values[i]) / 255.0, false),
            Pixels::U16(values) => colors(&|i| f32::from(values[i]) / 65535.0, false),
            Pixels::F32(values) => colors(&|i| values[i], true),
        };
        Some(Self { size, colors })
    }

    /// Between the four nearest texels; beyond the edges those of the edges.
    fn at(&self, place: Vec2) -> Vec3 {
        let most = self.size as f32 - 1.0;
        let p = (place * self.size as f32 - 0.5).clamp(Vec2::ZERO, Vec2::splat(most));
        let (x, y) = (p.x as usize, p.y as usize);
        let (s, t) = (p.x - x as f32, p.y - y as f32);
        let (x1, y1) = ((x + 1).min(self.size - 1), (y + 1).min(self.size - 1));
        let texel = |x: usize, y: usize| self.colors[y * self.size + x];
        let row = |y: usize| texel(x, y).lerp(texel(x1, y), s);
        row(y).lerp(row(y1), t)
    }
}

/// The face of a direction, and where on it: from the left and from the top, as it is seen from inside. The faces are those of
/// cube maps (OpenGL 4.6, table 8.19), each mirrored to how it is seen, as the extension has them.
fn place(d: Vec3) -> (usize, Vec2) {
    let size = d.abs();
    let (face, across, down, depth) = if size.x >= size.y && size.x >= size.z {
        (
            usize::from(d.x < 0.0),
            d.z.copysign(d.z * d.x),
            -d.y,
            size.x,
        )
    } else if size.y >= size.z {
        (
            2 + usize::from(d.y < 0.0),
            -d.x,
            d.z.copysign(d.z * d.y),
            size.y,
        )
    } else {
        (
            4 + usize::from(d.z < 0.0),
            -d.x.copysign(d.x * d.z),
            -d.y,
            size.z,
        )
    };
    (face, Vec2::new(across, down) / depth * 0.5 + 0.5)
}

/// Gives the scene the light of its scene in the file, if that has one.
pub(super) fn load(
    document: &Document,
    index: Option<usize>,
    scene: &mut Scene,
    diagnostics: &mut Diagnostics,
) -> Result<(), ImportError> {
    let at = index.map(|index| format!("/scenes/{index}/extensions/{NAME}"));
    let Some(reference) = at.and_then(|at| document.value.pointer(&at)) else {
        return Ok(());
    };
    let broken = |problem: String| ImportError::malformed(&document.file, NAME, problem);
    let reading = |e: serde_json::Error| broken(format!("it cannot be read: {}", words::plain(&e)));
    let ReferenceJson { light: number } = ReferenceJson::deserialize(reference).map_err(reading)?;
    let light = format!("/extensions/{NAME}/lights/{number}");
    let light = document
        .value
        .pointer(&light)
        .ok_or_else(|| broken(format!("a scene uses light {number}, which does not exist")))?;
    let light = LightJson::deserialize(light).map_err(reading)?;
    let legal = light.intensity.is_finite() && light.intensity >= 0.0;
    if !legal || !light.rotation.iter().all(|c| c.is_finite()) {
        return Err(broken("its rotation and intensity must be numbers".into()));
    }
    let mut environment = Environment {
        image: None,
        radiance: [light.intensity as f32; 3],
        rotation: image_from_world(light.rotation),
        visibility: Visibility::ALL,
        links: Links::default(),
        graph: None,
    };
    match faces(document, &light)? {
        Ok(faces) => {
            let image = panorama(&faces);
            let id = u32::try_from(scene.images.len()).unwrap_or(u32::MAX);
            environment.image = Some(ImageId(id));
            scene.images.push(image);
            diagnostics.report_effect(
                Effect::ImageEnvironment,
                "image-based-light",
                Verdict::Exact,
                NAME,
                "world",
                "its sharpest level lights the scene, its numbers taken as W/(sr·m²)",
            );
        }
        Err(why) => {
            let mean = light.irradiance_coefficients.first();
            // The first coefficient times the first basis function, 1/(2√π), and the cosine's π, over π for a radiance: as in
            // Ramamoorthi and Hanrahan 2001, equation 10, with what the extension calls irradiance.
            let mean = mean.map_or([0.0; 3], |c| c.map(|c| c.max(0.0) * 0.5 / PI.sqrt()));
            environment.radiance = mean.map(|c| c * light.intensity as f32);
            diagnostics.report_effect(
                Effect::ImageEnvironment,
                "image-based-light",
                Verdict::Lost,
                format!("images of {NAME} ({why})"),
                "world",
                "its mean alone lights the scene, the same from all around",
            );
        }
    }
    scene.environment = Some(environment);
    Ok(())
}

/// The faces of the sharpest level, or why there are none.
fn faces(document: &Document, light: &LightJson) -> Result<Result<Vec<Face>, String>, ImportError> {
    let Some(indices) = light.specular_images.first() else {
        return Ok(Err("there are none".into()));
    };
    let images = Images::new(document, None);
    let mut faces = Vec::with_capacity(6);
    for &index in indices {
        let image = match images.decoded(index, NAME)? {
            Ok(image) => image,
            Err(why) => return Ok(Err(why)),
        };
        match Face::new(&image) {
            Some(face) => faces.push(face),
            None => return Ok(Err(format!("image {index} is no square"))),
        }
    }
    Ok(Ok(faces))
}

/// An equirectangular image with as many texels along the horizon as the faces have.
fn panorama(faces: &[Face]) -> Image {
    let size = faces.iter().map(|face| face.size).max().unwrap_or(1);
    let width = u32::try_from(4 * size)
        .unwrap_or(u32::MAX)
        .min(MOST_COLUMNS);
    let height = width / 2;
    let mut values = vec![0.0; 3 * width as usize * height as usize];
    let rows = values.par_chunks_mut(3 * width as usize).enumerate();
    rows.for_each(|(row, values)| {
        // The middle of the picture is +X, and its top is up: see `light::environment`.
        let elevation = (0.5 - (row as f32 + 0.5) / height as f32) * PI;
        for (column, texel) in values.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let phi = (0.5 - (column as f32 + 0.5) / width as f32) * TAU;
            let (sin, cos) = phi.sin_cos();
            let d = Vec3::new(
                elevation.cos() * cos,
                elevation.sin(),
                -elevation.cos() * sin,
            );
            let (face, at) = place(d);
            *texel = faces[face].at(at).to_array();
        }
    });
    make_radiance(&mut values);
    Image {
        name: NAME.into(),
        width,
        height,
        channels: 3,
        pixels: values.into(),
    }
}

/// From the world to the image, both by Blender's axes.
fn image_from_world([x, y, z, w]: [f64; 4]) -> glam::DMat3 {
    let turn = DQuat::from_xyzw(x, y, z, w);
    let turn = if turn.length_squared() > 0.0 {
        turn.normalize()
    } else {
        DQuat::IDENTITY
    };
    // glTF's (x, y, z) is (x, -z, y) of Blender.
    let to_blender = glam::DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0]);
    to_blender * glam::DMat3::from_quat(turn.inverse()) * to_blender.transpose()
}

#[cfg(test)]
#[path = "../../../tests/unit/import/gltf/cube_light.rs"]
mod tests;
