//! `sundog info`: what is in a scene.

use super::args;
use super::effect_lines::{Page, effect_lines, left_out_lines};
use super::exit::EXIT_OK;
use super::scene_file::{SceneFile, count};
use super::{Failure, console, progress, scene_file};
use crate::effects::{EffectReport, Finding, RequestedSettings};
use crate::math::primaries::WorkingSpace;
use crate::math::words::counted;
use crate::render::memory::PREPARED_BYTES_A_TRIANGLE;
use crate::scene::coincident;
use crate::scene::{BoundsInfo, Diagnostics, Inventory, LeftOut, Scene, fingerprint, simplify};
use serde::Serialize;
use serde_json::json;
use std::collections::{BTreeMap, HashMap};

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
        document["nodes"] = json!(needed.nodes);
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
        for nodes in &needed.nodes {
            page.line("nodes", nodes.words());
        }
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
    /// Of materials with nodes beside shaders.
    nodes: Vec<Nodes>,
}

/// The nodes of a material, shaders left aside.
#[derive(Serialize)]
struct Nodes {
    material: String,
    /// How many of each name are evaluated at hits.
    evaluated: BTreeMap<&'static str, usize>,
    /// How many are constants, or change nothing.
    folded: usize,
}

impl Nodes {
    fn words(&self) -> String {
        let name = |(name, &count): (&&str, &usize)| match count {
            1 => (*name).to_owned(),
            _ => format!("{name} ({count})"),
        };
        let evaluated: Vec<_> = self.evaluated.iter().map(name).collect();
        let evaluated = match evaluated.is_empty() {
            true => "none".into(),
            false => evaluated.join(", "),
        };
        format!(
            "\"{}\" at hits: {evaluated}; folded: {}",
            self.material, self.folded
        )
    }
}

/// By the material's name.
fn node_counts(scene: &Scene) -> HashMap<String, usize> {
    let materials = scene.materials.iter();
    materials
        .map(|m| (m.name.clone(), m.graph.nodes_by_label().values().sum()))
        .collect()
}

impl Needed {
    /// Leaves the scene without what changes nothing.
    fn of(file: &mut SceneFile) -> Self {
        let before = node_counts(&file.scene);
        let left_out = simplify(&mut file.scene);
        let nodes = file.scene.materials.iter().filter_map(|material| {
            let all = before.get(&material.name).copied().unwrap_or(0);
            let evaluated = material.graph.nodes_by_label();
            let folded = all.saturating_sub(evaluated.values().sum());
            (all > 0).then(|| Nodes {
                material: material.name.clone(),
                evaluated,
                folded,
            })
        });
        let nodes = nodes.collect();
        let requested = RequestedSettings::default();
        let report = EffectReport::of(
            (&file.scene, &coincident::find(&file.scene)),
            &requested,
            &left_out,
            &file.diagnostics,
        );
        Self {
            hash: fingerprint(&file.scene),
            left_out,
            nodes,
            effects: report.findings,
        }
    }
}

#[derive(Serialize)]
struct Info<'a> {
    file: String,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    variants: &'a [String],
    #[serde(flatten)]
    inventory: Inventory<'a>,
    memory: Memory,
    diagnostics: &'a Diagnostics,
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

impl<'a> Info<'a> {
    fn of(file: &'a SceneFile) -> Self {
        let scene = &file.scene;
        let inventory = Inventory::of(scene);
        let geometry = scene.geometry_bytes();
        let image_bytes = inventory.images.iter().map(|image| image.bytes).sum();
        let prepared_estimate = inventory.triangles * PREPARED_BYTES_A_TRIANGLE;
        Self {
            file: file.path.display().to_string(),
            variants: &file.variants,
            inventory,
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
        if let Some(generator) = self.inventory.generator {
            page.line("made by", generator.into());
        }
        if self.inventory.working_space != WorkingSpace::default() {
            page.line("colours", format!("in {}", self.inventory.working_space));
        }
        if !self.variants.is_empty() {
            let names: Vec<_> = self.variants.iter().map(|n| format!("\"{n}\"")).collect();
            page.line("variants", names.join(", "));
        }
    }

    fn inventory(&self, page: &mut Page) {
        for camera in &self.inventory.cameras {
            let mut text = format!("\"{}\" {}", camera.name, camera.kind);
            if let Some(angle) = camera.field_of_view {
                text.push_str(&format!(", {angle:.2}° high"));
            }
            if let Some(aspect) = camera.aspect {
                text.push_str(&format!(", aspect {aspect:.4}"));
            }
            page.line("camera", format!("{text}, at {}", vector(camera.position)));
        }
        if self.inventory.cameras.is_empty() {
            page.line("camera", "none: export it with \"Cameras\" ticked".into());
        }
        for light in &self.inventory.lights {
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
        if self.inventory.emissive_materials > 0 {
            page.line(
                "light",
                count(
                    self.inventory.emissive_materials as u64,
                    "emissive material",
                ),
            );
        }
        match &self.inventory.environment {
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
        for material in &self.inventory.materials {
            let traits = if material.traits.is_empty() {
                "plain".into()
            } else {
                material.traits.join(", ")
            };
            page.line("material", format!("\"{}\" {traits}", material.name));
        }
        for image in &self.inventory.images {
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
                count(self.inventory.triangles, "triangle"),
                counted(self.inventory.meshes, "mesh", "meshes"),
                if self.inventory.instances == 1 {
                    "once".into()
                } else {
                    format!("{} times", self.inventory.instances)
                },
                count(self.inventory.placed_triangles, "triangle"),
            ),
        );
        match self.inventory.bounds {
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
            diagnostic.introduced(),
        );
    }
    if diagnostics.is_empty() {
        page.line("carried over", "everything, exactly".into());
    }
}

fn vector([x, y, z]: [f64; 3]) -> String {
    format!("({x:.4}, {y:.4}, {z:.4})")
}

/// `, not seen by camera, glossy rays`.
fn hidden(kinds: &[&str]) -> String {
    if kinds.is_empty() {
        String::new()
    } else {
        format!(", not seen by {} rays", kinds.join(", "))
    }
}
