//! `sundog info`: what is in a scene.

use super::args;
use super::effect_lines::{Page, effect_lines, left_out_lines};
use super::exit::EXIT_OK;
use super::scene_file::{SceneFile, count};
use super::{Failure, console, progress, scene_file};
use crate::effects::{Asked, EffectSet, Finding, emits};
use crate::math::primaries::WorkingSpace;
use crate::math::words::counted;
use crate::scene::{
    AlphaMode, AreaShape, Bounds, Diagnostics, LeftOut, LightKind, Material, Pixels, Projection,
    Scene, Window, fingerprint, simplify,
};
use glam::{DMat3, DVec3};
use serde::Serialize;
use serde_json::json;

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(args: &args::Info) -> Result<u8, Failure> {
    let mut file = scene_file::load_all(&args.scene, &args.import, &args::Environment::default())?;
    let info = Info::of(&file);
    if args.json {
        // Before the scene becomes a simpler one.
        let mut document = serde_json::to_value(&info).unwrap_or_default();
        let needed = Needed::of(&mut file);
        document["hash"] = json!(needed.hash);
        document["left_out"] = json!(needed.left_out);
        document["effects"] = json!(needed.effects);
        console::json_document(&document);
    } else {
        let mut page = Page::default();
        info.head(&mut page);
        let mut inventory = Page::default();
        info.inventory(&mut inventory);
        let needed = Needed::of(&mut file);
        page.line("hash", needed.hash);
        page.append(&inventory);
        left_out_lines(&needed.left_out, &mut page);
        effect_lines(&needed.effects, &mut page);
        diagnostic_lines(&file.diagnostics, &mut page);
        console::output(page.text());
    }
    Ok(EXIT_OK)
}

/// What of a scene is rendered, and what that takes.
struct Needed {
    hash: String,
    left_out: Vec<LeftOut>,
    /// What a renderer has to be able to do for this scene, and what else Sundog can do.
    effects: Vec<Finding>,
}

impl Needed {
    /// Leaves the scene without what changes nothing.
    fn of(file: &mut SceneFile) -> Self {
        let left_out = simplify(&mut file.scene);
        let asked = Asked::default();
        let set = EffectSet::of(&file.scene, &asked, &left_out, &file.diagnostics);
        Self {
            hash: fingerprint(&file.scene),
            left_out,
            effects: set.findings,
        }
    }
}

#[derive(Serialize)]
struct Info<'a> {
    file: String,
    generator: Option<&'a str>,
    /// What the scene's colours are numbers of.
    working_space: WorkingSpace,
    cameras: Vec<CameraInfo<'a>>,
    lights: Vec<LightInfo<'a>>,
    environment: Option<EnvironmentInfo<'a>>,
    emissive_materials: usize,
    materials: Vec<MaterialInfo<'a>>,
    images: Vec<ImageInfo<'a>>,
    meshes: usize,
    instances: usize,
    /// In the file.
    triangles: u64,
    /// With every instance counted.
    placed_triangles: u64,
    vertices: u64,
    /// World space, metres; none for a scene without triangles.
    bounds: Option<BoundsInfo>,
    memory: Memory,
    diagnostics: &'a Diagnostics,
}

#[derive(Serialize)]
struct CameraInfo<'a> {
    name: &'a str,
    kind: &'static str,
    /// Vertical, degrees; none for parallel rays.
    field_of_view: Option<f64>,
    aspect: Option<f64>,
    position: [f64; 3],
}

#[derive(Serialize)]
struct LightInfo<'a> {
    name: &'a str,
    kind: &'static str,
    /// W/sr for points and spots, W/m² for suns, W for area lights; without the colour.
    strength: f32,
    unit: &'static str,
    color: [f32; 3],
    /// Metres, of points and spots.
    radius: Option<f32>,
    /// What else there is to say of its size and form.
    size: Option<String>,
    /// Kinds of rays that do not see it.
    hidden_from: Vec<&'static str>,
    /// Paths with more bounces do not see it.
    max_bounces: u32,
    position: [f64; 3],
}

#[derive(Serialize)]
struct EnvironmentInfo<'a> {
    image: Option<&'a str>,
    radiance: [f32; 3],
    /// Takes a direction of the world to that of the image, both by Blender's axes; by rows.
    rotation: [[f64; 3]; 3],
    /// Degrees about the up axis, where that is all.
    turn: Option<f64>,
    /// Kinds of rays that do not see it.
    hidden_from: Vec<&'static str>,
}

#[derive(Serialize)]
struct MaterialInfo<'a> {
    name: &'a str,
    /// What makes it more than plain: metal, textures, transmission, …
    traits: Vec<String>,
}

#[derive(Serialize)]
struct ImageInfo<'a> {
    name: &'a str,
    width: u32,
    height: u32,
    channels: u32,
    bits: u32,
    bytes: u64,
}

#[derive(Clone, Copy, Serialize)]
struct BoundsInfo {
    low: [f64; 3],
    high: [f64; 3],
}

/// Bytes.
#[derive(Serialize)]
struct Memory {
    geometry: u64,
    images: u64,
    /// What Embree's trees and the renderer's own tables are expected to take.
    prepared_estimate: u64,
    total_estimate: u64,
}

/// What a render took beyond the scene itself: 285 bytes a triangle in a scene of 262 510 triangles (with
/// many small meshes), 182 in one of 142 973.
pub(super) const PREPARED_BYTES_A_TRIANGLE: u64 = 300;

impl<'a> Info<'a> {
    fn of(file: &'a SceneFile) -> Self {
        let scene = &file.scene;
        let images: Vec<_> = scene
            .images
            .iter()
            .map(|image| {
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
            })
            .collect();
        let triangles: u64 = scene
            .meshes
            .iter()
            .map(|mesh| mesh.triangles.len() as u64)
            .sum();
        let geometry = geometry_bytes(scene);
        let image_bytes = images.iter().map(|image| image.bytes).sum();
        let prepared_estimate = triangles * PREPARED_BYTES_A_TRIANGLE;
        Self {
            file: file.path.display().to_string(),
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
                        .map(|i| i.name.as_str()),
                    radiance: environment.radiance,
                    rotation: environment.rotation.transpose().to_cols_array_2d(),
                    turn: turn(&environment.rotation),
                    hidden_from: environment.visibility.hidden_from(),
                }),
            emissive_materials: scene
                .materials
                .iter()
                .filter(|material| emits(material))
                .count(),
            materials: scene
                .materials
                .iter()
                .map(|material| MaterialInfo {
                    name: &material.name,
                    traits: traits(material),
                })
                .collect(),
            images,
            meshes: scene.meshes.len(),
            instances: scene.instances.len(),
            triangles,
            placed_triangles: scene_file::placed_triangles(scene),
            vertices: scene
                .meshes
                .iter()
                .map(|mesh| mesh.positions.len() as u64)
                .sum(),
            bounds: scene.bounds().map(|Bounds { low, high }| BoundsInfo {
                low: low.to_array(),
                high: high.to_array(),
            }),
            memory: Memory {
                geometry,
                images: image_bytes,
                prepared_estimate,
                total_estimate: geometry + image_bytes + prepared_estimate,
            },
            diagnostics: &file.diagnostics,
        }
    }

    fn head(&self, page: &mut Page) {
        page.line("file", self.file.clone());
        if let Some(generator) = self.generator {
            page.line("made by", generator.into());
        }
        if self.working_space != WorkingSpace::default() {
            page.line("colours", format!("in {}", self.working_space));
        }
    }

    fn inventory(&self, page: &mut Page) {
        for camera in &self.cameras {
            let mut text = format!("\"{}\" {}", camera.name, camera.kind);
            if let Some(angle) = camera.field_of_view {
                text.push_str(&format!(", {angle:.2}° high"));
            }
            if let Some(aspect) = camera.aspect {
                text.push_str(&format!(", aspect {aspect:.4}"));
            }
            page.line("camera", format!("{text}, at {}", vector(camera.position)));
        }
        if self.cameras.is_empty() {
            page.line("camera", "none: export it with \"Cameras\" ticked".into());
        }
        for light in &self.lights {
            let mut text = format!(
                "\"{}\" {} {} {}",
                light.name, light.kind, light.strength, light.unit
            );
            if let Some(size) = &light.size {
                text.push_str(&format!(", {size}"));
            }
            text.push_str(&hidden(&light.hidden_from));
            page.line("light", format!("{text}, at {}", vector(light.position)));
        }
        if self.emissive_materials > 0 {
            page.line(
                "light",
                count(self.emissive_materials as u64, "emissive material"),
            );
        }
        match &self.environment {
            Some(environment) => page.line(
                "environment",
                format!(
                    "{} × {:?}, {}{}",
                    environment.image.unwrap_or("constant"),
                    environment.radiance,
                    match environment.turn {
                        Some(turn) => format!("turned by {turn}°"),
                        None => format!("turned by {:?}", environment.rotation),
                    },
                    hidden(&environment.hidden_from)
                ),
            ),
            None => page.line("environment", "none (black)".into()),
        }
        for material in &self.materials {
            let traits = if material.traits.is_empty() {
                "plain".into()
            } else {
                material.traits.join(", ")
            };
            page.line("material", format!("\"{}\" {traits}", material.name));
        }
        for image in &self.images {
            page.line(
                "image",
                format!(
                    "\"{}\" {} × {}, {} channels of {} bits, {}",
                    image.name,
                    image.width,
                    image.height,
                    image.channels,
                    image.bits,
                    console::bytes(image.bytes)
                ),
            );
        }
        page.line(
            "geometry",
            format!(
                "{} in {}, placed {}: {}",
                count(self.triangles, "triangle"),
                counted(self.meshes, "mesh", "meshes"),
                if self.instances == 1 {
                    "once".into()
                } else {
                    format!("{} times", self.instances)
                },
                count(self.placed_triangles, "triangle"),
            ),
        );
        match self.bounds {
            Some(BoundsInfo { low, high }) => {
                let size: Vec<_> = low
                    .iter()
                    .zip(high)
                    .map(|(low, high)| format!("{:.4}", high - low))
                    .collect();
                page.line(
                    "bounds",
                    format!(
                        "{} to {}, {} m",
                        vector(low),
                        vector(high),
                        size.join(" × ")
                    ),
                );
            }
            None => page.line("bounds", "none: no triangles".into()),
        }
        page.line(
            "memory",
            format!(
                "about {}: geometry {}, images {}, prepared for tracing about {}",
                console::bytes(self.memory.total_estimate),
                console::bytes(self.memory.geometry),
                console::bytes(self.memory.images),
                console::bytes(self.memory.prepared_estimate)
            ),
        );
    }
}

fn diagnostic_lines(diagnostics: &Diagnostics, page: &mut Page) {
    for diagnostic in diagnostics.iter() {
        page.line(
            progress::verdict_word(diagnostic.verdict),
            diagnostic.to_string(),
        );
    }
    if diagnostics.is_empty() {
        page.line("carried over", "everything, exactly".into());
    }
}

fn vector([x, y, z]: [f64; 3]) -> String {
    format!("({x:.4}, {y:.4}, {z:.4})")
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

/// `, not seen by camera, glossy rays`.
fn hidden(kinds: &[&str]) -> String {
    if kinds.is_empty() {
        String::new()
    } else {
        format!(", not seen by {} rays", kinds.join(", "))
    }
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
    add(material.unlit, "unlit".into());
    add(
        material.metallic > 0.0,
        format!("metallic {}", material.metallic),
    );
    add(true, format!("roughness {}", material.roughness));
    add(
        material.transmission > 0.0,
        format!("transmission {}", material.transmission),
    );
    add(
        material.transmission > 0.0 && material.thin_walled,
        "thin".into(),
    );
    add(emits(material), format!("emission {:?}", material.emission));
    match material.alpha_mode {
        AlphaMode::Opaque => {}
        AlphaMode::Mask { cutoff } => add(true, format!("holes where alpha < {cutoff}")),
        AlphaMode::Blend => add(true, "blended by alpha".into()),
    }
    for (texture, name) in [
        (material.base_color_texture.is_some(), "base colour"),
        (
            material.metallic_roughness_texture.is_some(),
            "metallic and roughness",
        ),
        (material.normal_texture.is_some(), "normal"),
        (material.emission_texture.is_some(), "emission"),
        (material.specular_texture.is_some(), "specular"),
        (material.specular_color_texture.is_some(), "specular colour"),
        (material.transmission_texture.is_some(), "transmission"),
    ] {
        add(texture, format!("{name} texture"));
    }
    traits
}

fn geometry_bytes(scene: &Scene) -> u64 {
    let meshes: usize = scene
        .meshes
        .iter()
        .map(|mesh| {
            size_of_val(mesh.positions.as_slice())
                + mesh.normals.as_deref().map_or(0, size_of_val)
                + mesh.tangents.as_deref().map_or(0, size_of_val)
                + mesh
                    .uvs
                    .iter()
                    .map(|uvs| size_of_val(uvs.as_slice()))
                    .sum::<usize>()
                + mesh.colors.as_deref().map_or(0, size_of_val)
                + size_of_val(mesh.triangles.as_slice())
        })
        .sum();
    (meshes + size_of_val(scene.instances.as_slice())) as u64
}
