//! What is in a scene, for those who ask: cameras, lights, materials, images, numbers and sizes.

use super::graph::{Opacity, Slot};
use super::{AreaShape, Bounds, LightKind, Material, MeshStep, Pixels, Projection, Scene, Window};
use crate::math::primaries::WorkingSpace;
use glam::{DMat3, DVec3};
use serde::Serialize;

/// What is in a scene.
#[derive(Serialize)]
pub struct Inventory<'a> {
    /// The program that wrote the file.
    pub generator: Option<&'a str>,
    /// What the scene's colours are numbers of.
    pub working_space: WorkingSpace,
    /// In the order of the file.
    pub cameras: Vec<CameraInfo<'a>>,
    /// Lamps; surfaces that emit are materials.
    pub lights: Vec<LightInfo<'a>>,
    /// What shines from all around.
    pub environment: Option<EnvironmentInfo<'a>>,
    /// Materials that emit.
    pub emissive_materials: usize,
    /// In the order of the file.
    pub materials: Vec<MaterialInfo<'a>>,
    /// In the order of the file.
    pub images: Vec<ImageInfo<'a>>,
    /// Each counted once.
    pub meshes: usize,
    /// How often meshes are placed.
    pub instances: usize,
    /// In the file.
    pub triangles: u64,
    /// With every instance counted.
    pub placed_triangles: u64,
    /// In the file.
    pub vertices: u64,
    /// World space, metres; none for a scene without triangles.
    pub bounds: Option<BoundsInfo>,
}

#[derive(Serialize)]
pub struct CameraInfo<'a> {
    pub name: &'a str,
    pub kind: &'static str,
    /// Vertical, degrees; none for parallel rays.
    pub field_of_view: Option<f64>,
    pub aspect: Option<f64>,
    pub position: [f64; 3],
}

#[derive(Serialize)]
pub struct LightInfo<'a> {
    pub name: &'a str,
    pub kind: &'static str,
    /// W/sr for points and spots, W/m² for suns, W for area lights; without the colour.
    pub strength: f32,
    pub unit: &'static str,
    pub color: [f32; 3],
    /// Metres, of points and spots.
    pub radius: Option<f32>,
    /// What else there is to say of its size and form.
    pub size: Option<String>,
    /// Kinds of rays that do not see it.
    pub hidden_from: Vec<&'static str>,
    /// Paths with more bounces do not see it.
    pub max_bounces: u32,
    pub position: [f64; 3],
}

#[derive(Serialize)]
pub struct EnvironmentInfo<'a> {
    pub image: Option<&'a str>,
    pub radiance: [f32; 3],
    /// Takes a direction of the world to that of the image, both by Blender's axes; by rows.
    pub rotation: [[f64; 3]; 3],
    /// Degrees about the up axis, where that is all.
    pub turn: Option<f64>,
    /// Kinds of rays that do not see it.
    pub hidden_from: Vec<&'static str>,
}

#[derive(Serialize)]
pub struct MaterialInfo<'a> {
    pub name: &'a str,
    /// What makes it more than plain: metal, textures, transmission, …
    pub traits: Vec<String>,
}

#[derive(Serialize)]
pub struct ImageInfo<'a> {
    pub name: &'a str,
    pub width: u32,
    pub height: u32,
    pub channels: u32,
    pub bits: u32,
    pub bytes: u64,
}

/// A box along the axes.
#[derive(Clone, Copy, Serialize)]
pub struct BoundsInfo {
    /// Smallest coordinates.
    pub low: [f64; 3],
    /// Largest coordinates.
    pub high: [f64; 3],
}

impl<'a> Inventory<'a> {
    /// Of a scene.
    pub fn of(scene: &'a Scene) -> Self {
        Self {
            generator: scene.generator.as_deref(),
            working_space: scene.color_management.working_space,
            cameras: cameras(scene),
            lights: lights(scene),
            environment: scene
                .environment
                .as_ref()
                .map(|environment| EnvironmentInfo {
                    image: environment
                        .image
                        .and_then(|id| scene.images.get(id.0 as usize))
                        .map(|i| i.name.as_str())
                        .or(environment.graph.as_ref().map(|_| "node tree")),
                    radiance: environment.radiance,
                    rotation: environment.rotation.transpose().to_cols_array_2d(),
                    turn: turn(&environment.rotation),
                    hidden_from: environment.visibility.hidden_from(),
                }),
            emissive_materials: scene
                .materials
                .iter()
                .filter(|material| material.emits())
                .count(),
            materials: scene
                .materials
                .iter()
                .map(|material| MaterialInfo {
                    name: &material.name,
                    traits: traits(material),
                })
                .collect(),
            images: images(scene),
            meshes: scene.meshes.len(),
            instances: scene.instances.len(),
            triangles: scene
                .meshes
                .iter()
                .map(|mesh| mesh.triangles.len() as u64)
                .sum(),
            placed_triangles: scene.placed_triangles(),
            vertices: scene
                .meshes
                .iter()
                .map(|mesh| mesh.positions.len() as u64)
                .sum(),
            bounds: scene.bounds().map(|Bounds { low, high }| BoundsInfo {
                low: low.to_array(),
                high: high.to_array(),
            }),
        }
    }
}

fn images(scene: &Scene) -> Vec<ImageInfo<'_>> {
    let info = scene.images.iter().map(|image| {
        let bits = match &image.pixels {
            Pixels::U8(_) => 8,
            Pixels::U16(_) => 16,
            Pixels::F32(_) => 32,
        };
        let (width, height, channels) = (image.width, image.height, image.channels);
        ImageInfo {
            name: &image.name,
            width,
            height,
            channels,
            bits,
            bytes: image.pixels.bytes(),
        }
    });
    info.collect()
}

fn cameras(scene: &Scene) -> Vec<CameraInfo<'_>> {
    let info = scene.cameras.iter().map(|camera| {
        let window = camera.window.as_ref();
        let (kind, field_of_view, aspect) = match camera.projection {
            Projection::Perspective {
                vertical_fov,
                aspect,
            } => (
                "perspective",
                Some(
                    window
                        .map_or(vertical_fov, |w| w.top.atan() - w.bottom.atan())
                        .to_degrees(),
                ),
                window.map(Window::aspect).or(aspect),
            ),
            Projection::Orthographic {
                half_width,
                half_height,
            } => (
                "orthographic",
                None,
                Some(window.map_or(half_width / half_height, Window::aspect)),
            ),
            Projection::Equirectangular { .. } => ("equirectangular", None, None),
            Projection::Panorama { .. } => ("panorama", None, None),
        };
        let position = camera.world_from_camera.translation.to_array();
        CameraInfo {
            name: &camera.name,
            kind,
            field_of_view,
            aspect,
            position,
        }
    });
    info.collect()
}

fn lights(scene: &Scene) -> Vec<LightInfo<'_>> {
    let sphere = |radius: f32, soft: bool| {
        let form = if soft && radius > 0.0 {
            ", soft falloff"
        } else {
            ""
        };
        Some(format!("radius {radius} m{form}"))
    };
    let info = scene.lights.iter().map(|light| {
        let (kind, strength, unit, radius, size) = match light.kind {
            LightKind::Point {
                intensity,
                radius,
                soft_falloff,
            } => (
                "point",
                intensity,
                "W/sr",
                Some(radius),
                sphere(radius, soft_falloff),
            ),
            LightKind::Spot {
                intensity,
                radius,
                soft_falloff,
                ..
            } => (
                "spot",
                intensity,
                "W/sr",
                Some(radius),
                sphere(radius, soft_falloff),
            ),
            LightKind::Sun { irradiance, angle } => {
                let disc = (angle > 0.0).then(|| format!("{:.4}° across", angle.to_degrees()));
                ("sun", irradiance, "W/m²", None, disc)
            }
            LightKind::Area {
                shape,
                size: [x, y],
                power,
                normalize,
                spread,
            } => {
                let name = match shape {
                    AreaShape::Rectangle => "rectangle",
                    AreaShape::Ellipse => "ellipse",
                };
                let mut text = format!("{name} {x} × {y} m");
                if spread < std::f32::consts::PI {
                    text.push_str(&format!(", spread {:.2}°", spread.to_degrees()));
                }
                if !normalize {
                    text.push_str(", not normalised");
                }
                ("area", power, "W", None, Some(text))
            }
        };
        let position = light.world_from_light.translation.to_array();
        LightInfo {
            name: &light.name,
            kind,
            strength,
            unit,
            color: light.color,
            radius,
            size,
            hidden_from: light.visibility.hidden_from(),
            max_bounces: light.max_bounces,
            position,
        }
    });
    info.collect()
}

/// Degrees about the up axis, if a rotation is one about it.
fn turn(rotation: &DMat3) -> Option<f64> {
    (rotation.z_axis == DVec3::Z && rotation.determinant() > 0.0)
        .then(|| rotation.x_axis.y.atan2(rotation.x_axis.x).to_degrees())
}

/// What makes a material more than plain white and rough.
fn traits(material: &Material) -> Vec<String> {
    let mut traits = Vec::new();
    let mut add = |present: bool, text: String| {
        if present {
            traits.push(text);
        }
    };
    let summary = material.summary();
    add(summary.unlit, "unlit".into());
    if let Some(p) = summary.principled.first() {
        let (metallic, roughness, transmission) = (p.metallic.1, p.roughness.1, p.transmission.1);
        add(metallic > 0.0, format!("metallic {metallic}"));
        add(true, format!("roughness {roughness}"));
        add(transmission > 0.0, format!("transmission {transmission}"));
        add(transmission > 0.0 && p.thin_wall, "thin".into());
    }
    let emission = summary.emission.to_array();
    add(summary.emits(), format!("emission {emission:?}"));
    match summary.opacity {
        Opacity::Full => {}
        Opacity::Clip { cutoff, .. } => add(true, format!("holes where alpha < {cutoff}")),
        Opacity::Blend { .. } => add(true, "blended by alpha".into()),
    }
    let filled = material.medium.as_ref().and_then(super::Medium::effect);
    add(filled.is_some(), "filled by a volume".into());
    if let Some(priority) = material.priority {
        add(true, format!("priority {priority}"));
    }
    let graph = &material.graph;
    for (texture, name) in [
        (graph.has_texture(Slot::BaseColor), "base colour"),
        (
            graph.has_texture(Slot::MetallicRoughness),
            "metallic and roughness",
        ),
        (graph.has_normal_map(), "normal"),
        (graph.has_texture(Slot::Emission), "emission"),
        (graph.has_texture(Slot::Specular), "specular"),
        (graph.has_texture(Slot::SpecularColor), "specular colour"),
        (graph.has_texture(Slot::Transmission), "transmission"),
    ] {
        add(texture, format!("{name} texture"));
    }
    traits
}

impl Scene {
    /// Triangles with every instance counted.
    pub fn placed_triangles(&self) -> u64 {
        self.instances
            .iter()
            .filter_map(|instance| self.meshes.get(instance.mesh.0 as usize))
            .map(|mesh| mesh.triangles.len() as u64)
            .sum()
    }

    /// Bytes of the meshes and their instances.
    pub fn geometry_bytes(&self) -> u64 {
        let meshes: usize = self
            .meshes
            .iter()
            .map(|mesh| {
                size_of_val(mesh.positions.as_slice())
                    + mesh.normals.as_deref().map_or(0, size_of_val)
                    + mesh.motion.iter().map(MeshStep::bytes).sum::<usize>()
                    + mesh.tangents.as_deref().map_or(0, size_of_val)
                    + mesh.radial.as_deref().map_or(0, size_of_val)
                    + mesh.generated.as_deref().map_or(0, size_of_val)
                    + mesh
                        .uvs
                        .iter()
                        .map(|uvs| size_of_val(uvs.as_slice()))
                        .sum::<usize>()
                    + mesh.colors.as_deref().map_or(0, size_of_val)
                    + mesh
                        .attributes
                        .iter()
                        .map(|v| size_of_val(&v[..]))
                        .sum::<usize>()
                    + size_of_val(mesh.triangles.as_slice())
            })
            .sum();
        (meshes + size_of_val(self.instances.as_slice())) as u64
    }
}
