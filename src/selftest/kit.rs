//! Scenes made of nothing, and pictures of them.

use super::Finding;
use crate::effects;
use crate::film::Picture;
use crate::render::{RenderError, RenderSettings, Rendering, Silent, render};
use crate::scene::{
    Camera, Environment, Instance, Light, LightKind, Material, MaterialId, Mesh, MeshId,
    MetallicRoughness, Projection, Scene, Visibility,
};
use crate::world::{Ablation, Options, World};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// A Lambertian surface.
pub fn diffuse(color: [f32; 3]) -> MetallicRoughness {
    MetallicRoughness {
        base_color: color,
        metallic: 0.0,
        specular: 0.0,
        ..MetallicRoughness::default()
    }
}

/// Clear glass that bounds a solid.
pub fn glass(roughness: f32, ior: f32) -> MetallicRoughness {
    MetallicRoughness {
        metallic: 0.0,
        roughness,
        transmission: 1.0,
        thin_walled: false,
        ior,
        ..MetallicRoughness::default()
    }
}

/// A white light that everything sees.
pub fn light(name: &str, kind: LightKind, world_from_light: DAffine3) -> Light {
    Light {
        name: name.into(),
        color: [1.0; 3],
        kind,
        world_from_light,
        visibility: Visibility::ALL,
        max_bounces: Light::MAX_BOUNCES,
        is_hit: true,
        links: Default::default(),
        graph: None,
    }
}

/// A closed sphere of `rings` × 2·`rings` quads, moved in or out by `bumps` of the radius; the
/// vertices of a seam and of a pole are the same bits.
pub fn sphere(rings: u32, bumps: f32, smooth: bool) -> Mesh {
    let columns = 2 * rings;
    let mut mesh = Mesh {
        name: "sphere".into(),
        ..Mesh::default()
    };
    let mut normals = Vec::new();
    let mut uvs = Vec::new();
    for r in 0..=rings {
        for c in 0..=columns {
            let (theta, phi) = (
                PI * f64::from(r) / f64::from(rings),
                TAU * f64::from(c % columns) / f64::from(columns),
            );
            let n = DVec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                theta.sin() * phi.sin(),
            );
            let n = if r == 0 {
                DVec3::Y
            } else if r == rings {
                DVec3::NEG_Y
            } else {
                n
            };
            // Waves about as long as a radian: bumps, but no spikes.
            let waves = (4.0 * n.x + 1.0).sin() + (5.0 * n.y).cos() + (3.0 * n.z + 2.0).sin();
            let radius = 1.0 + f64::from(bumps) * waves / 6.0;
            mesh.positions.push((n * radius).as_vec3().to_array());
            normals.push(n.as_vec3().to_array());
            uvs.push([
                4.0 * c as f32 / columns as f32,
                2.0 * r as f32 / rings as f32,
            ]);
        }
    }
    let at = |r: u32, c: u32| r * (columns + 1) + c;
    for r in 0..rings {
        for c in 0..columns {
            // Counter-clockwise from outside.
            if r > 0 {
                mesh.triangles.push([at(r, c), at(r, c + 1), at(r + 1, c)]);
            }
            if r + 1 < rings {
                mesh.triangles
                    .push([at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)]);
            }
        }
    }
    if smooth {
        mesh.normals = Some(normals);
    }
    mesh.uvs = vec![uvs];
    mesh
}

/// A parallelogram from a corner along two edges; it faces u × v.
pub fn quad(a: [f32; 3], u: [f32; 3], v: [f32; 3]) -> Mesh {
    let (p, u, v) = (Vec3::from(a), Vec3::from(u), Vec3::from(v));
    Mesh {
        name: "quad".into(),
        positions: [p, p + u, p + u + v, p + v].map(|x| x.to_array()).to_vec(),
        uvs: vec![vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A camera without a lens that looks along -Z; its vertical field of view is in radians.
pub fn camera(position: DVec3, fov: f64) -> Camera {
    Camera {
        name: "camera".into(),
        motion: None,
        stereo: None,
        world_from_camera: DAffine3::from_translation(position),
        projection: Projection::Perspective {
            vertical_fov: fov,
            aspect: None,
        },
        window: None,
        clip_near: 0.0,
        clip_far: f64::INFINITY,
        aperture: None,
    }
}

/// Adds a mesh with a material of its own, placed as often as there are transforms.
pub fn place(
    scene: &mut Scene,
    mesh: Mesh,
    material: impl Into<Material>,
    transforms: &[DAffine3],
) {
    let material_id = MaterialId(scene.materials.len() as u32);
    scene.materials.push(material.into());
    let id = MeshId(scene.meshes.len() as u32);
    scene.meshes.push(Mesh {
        material: Some(material_id),
        ..mesh
    });
    for (i, t) in transforms.iter().enumerate() {
        scene.instances.push(Instance {
            motion: Vec::new(),
            name: format!("{} {i}", id.0),
            mesh: id,
            world_from_object: *t,
            visibility: Visibility::ALL,
            holdout: false,
            info: Default::default(),
        });
    }
}

/// The same radiance from everywhere.
pub fn constant_environment(radiance: f32) -> Option<Environment> {
    Some(Environment {
        image: None,
        radiance: [radiance; 3],
        rotation: DMat3::IDENTITY,
        visibility: Visibility::ALL,
        links: Default::default(),
        graph: None,
    })
}

/// The world of a scene as its first camera sees it, with all effects.
///
/// # Errors
/// If Embree fails.
pub fn prepared(scene: &Scene) -> Result<World, RenderError> {
    let options = Options {
        camera: &scene.cameras[0],
        rows: 64,
        aspect: 1.0,
        effects: effects::ALL,
        threads: None,
        instructions: None,
        cull_backfaces: false,
        light_shares: Default::default(),
        clamps_direct: false,
        uv_pass: false,
        aovs: false,
        vectors: false,
        roughens: false,
        coincident: None,
        ablation: Ablation::default(),
    };
    World::new(scene, &options).map_err(|error| RenderError::Embree(error.0))
}

/// A small picture for as many samples and bounces, by all threads.
pub fn small(samples: u32, bounces: u32) -> RenderSettings {
    RenderSettings {
        width: 32,
        height: 24,
        samples,
        bounces,
        ..RenderSettings::default()
    }
}

/// Renders and keeps count of what is not finite, which no case may have.
#[derive(Default)]
pub struct Bench {
    non_finite: u64,
    /// Rays of all pictures.
    pub rays: u64,
}

impl Bench {
    /// Renders a scene.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render(
        &mut self,
        scene: &Scene,
        settings: &RenderSettings,
    ) -> Result<Rendering, RenderError> {
        let rendering = render(scene, settings, &Silent)?;
        self.non_finite += rendering.statistics.non_finite;
        self.rays += rendering.statistics.rays;
        Ok(rendering)
    }

    /// The findings of a case, and that all samples were finite.
    pub fn with(self, mut findings: Vec<Finding>) -> Vec<Finding> {
        findings.push(Finding::none(
            "samples that are not finite",
            self.non_finite,
        ));
        findings
    }
}

/// Colours of a picture, pixel by pixel.
pub fn colors(picture: &Picture) -> impl Iterator<Item = [f64; 3]> {
    let pixels = picture
        .layers
        .first()
        .map(|layer| layer.data.chunks_exact(4));
    pixels
        .into_iter()
        .flatten()
        .map(|c| [0, 1, 2].map(|i| f64::from(c[i])))
}

/// relMSE = mean over pixels and channels of (x − r)² / (r² + 0.01).
pub fn rel_mse(picture: &Picture, reference: &Picture) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for (x, r) in colors(picture).zip(colors(reference)) {
        for (x, r) in x.into_iter().zip(r) {
            sum += (x - r).powi(2) / (r * r + 0.01);
            count += 1;
        }
    }
    sum / f64::from(count)
}

/// Pixels that differ in any bit.
pub fn differing(picture: &Picture, other: &Picture) -> u64 {
    let bits = |c: [f64; 3]| c.map(f64::to_bits);
    let pairs = colors(picture).zip(colors(other));
    pairs.filter(|&(a, b)| bits(a) != bits(b)).count() as u64
}

/// Mean of all channels of all pixels.
pub fn mean(picture: &Picture) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for color in colors(picture) {
        sum += color.iter().sum::<f64>() / 3.0;
        count += 1;
    }
    sum / f64::from(count)
}

/// A mean of samples and how sure it is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mean {
    count: f64,
    mean: f64,
    /// Sum of squared differences from the mean (Welford, *Note on a Method for Calculating Corrected Sums of
    /// Squares and Products*, 1962).
    squares: f64,
}

impl Mean {
    /// Adds a sample.
    pub fn add(&mut self, value: f64) {
        self.count += 1.0;
        let before = value - self.mean;
        self.mean += before / self.count;
        self.squares += before * (value - self.mean);
    }

    /// The mean.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Estimated standard deviation of the mean.
    pub fn deviation(&self) -> f64 {
        (self.squares / (self.count - 1.0) / self.count).sqrt()
    }

    /// How far from `exact` it is, by its standard deviation and by what rounding may have done beside.
    pub fn z(&self, exact: f64, rounding: f64) -> f64 {
        (self.mean - exact).abs()
            / DVec2::new(self.deviation(), rounding)
                .length()
                .max(f64::MIN_POSITIVE)
    }
}
