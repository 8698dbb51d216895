//! glTF 2.0 (`.glb`, `.gltf`).

mod accessor;
mod animation;
mod camera;
mod camera_schema;
mod container;
mod cube_light;
mod deform;
mod draco;
mod extensions;
mod grids;
mod ies_lights;
mod image_spaces;
mod khr_surfaces;
mod layers;
mod lights;
mod limited;
mod material;
mod material_list;
mod medium;
mod mesh;
mod meshopt;
mod named;
mod placement;
mod radial;
mod scene_extension;
mod schema;
mod shader_graph;
mod shapes;
mod strands;
mod strokes;
mod textures;
mod variants;
mod walk;
mod words;
mod world;

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use serde_json::Value;

use self::container::Document;
pub(super) use self::container::in_another_case;
use self::material_list::Materials;
use self::shapes::{load_meshes, poses};
use self::walk::{Shaped, Walk};
use super::budget::Budget;
use super::{ImportError, ImportOptions, Imported};
use crate::scene::{Diagnostics, Effect, Instance, MeshId, Scene, Verdict};

pub(super) use self::named::named_files;

/// More placed copies than this would be an accident: each takes memory in the renderer.
const MOST_INSTANCES: usize = 1 << 26;

/// Reads a file; the result has not been through [`crate::scene::validate::clean`] yet.
pub(super) fn load(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let mut document = Document::open(path, options.allow_outside)?;
    document.grid_budget = Budget::for_grids(options.grid_memory);
    extensions::check_required(&document)?;
    let variants = variants::names(&document)?;
    let mut diagnostics = Diagnostics::default();
    // First, as it reads the file's JSON anew.
    if let Some(time) = &options.animation {
        animation::pose(&mut document, time, &mut diagnostics)?;
    }
    if let Some(wanted) = &options.variant {
        variants::choose(&mut document, &variants, wanted)?;
    }

    let mut walk = Walk {
        document: &document,
        options,
        budget: &document.budget,
        diagnostics: &mut diagnostics,
        reached: vec![false; document.nodes],
        joints: document.joints(),
        worlds: HashMap::new(),
        placed: Vec::new(),
        lights: Vec::new(),
        portals: Vec::new(),
        open_units: Vec::new(),
        light_graphs: Vec::new(),
        cameras: Vec::new(),
        scene: None,
    };
    walk.run()?;
    let Walk {
        worlds,
        scene: scene_index,
        mut placed,
        mut lights,
        portals,
        open_units,
        light_graphs,
        cameras,
        ..
    } = walk;

    report_whole_file(&document, options, &mut diagnostics);
    let shapes: BTreeSet<Shaped> = placed.iter().map(|p| p.mesh).collect();
    let used_meshes: BTreeSet<usize> = shapes.iter().map(|s| s.mesh).collect();
    let poses = poses(
        &document,
        &shapes,
        &mut placed,
        &worlds,
        &document.budget,
        &mut diagnostics,
    )?;
    let extension = scene_index.and_then(|i| document.graph.scenes[i].extensions.sundog.as_ref());
    let aovs = scene_extension::aovs(extension);
    let mut materials = Materials::load(&document, &used_meshes, &aovs, options, &mut diagnostics)?;
    let world = extension
        .and_then(|s| s.world.as_ref())
        .filter(|_| !options.without_world);
    let world_graph = match world.and_then(|world| world.shader_graph.as_ref()) {
        Some(value) => shader_graph::load_world(
            &document,
            value,
            &mut materials.images,
            options.cycles,
            &mut diagnostics,
        )?,
        None => None,
    };
    let filled = world.and_then(|world| world.volume.as_ref()?.graph.as_ref());
    let world_volume = match filled {
        Some(value) => shader_graph::load_volume(
            &document,
            (value, None),
            &mut materials.images,
            options.cycles,
            &mut diagnostics,
        )?,
        None => None,
    };
    let world_aovs = match world.and_then(|world| world.aovs.as_ref()) {
        Some(value) if !aovs.is_empty() => shader_graph::load_aovs(
            &document,
            (value, None),
            &aovs,
            &mut materials.images,
            options.cycles,
            &mut diagnostics,
        )?,
        _ => None,
    };
    // Their images are among those of the materials.
    let of_materials = materials.graphs.len();
    materials.graphs.append(&mut materials.aovs);
    materials.graphs.push(world_aovs.map(|loaded| loaded.graph));
    materials.graphs.push(world_graph);
    materials.graphs.push(world_volume);
    for (light, value) in &light_graphs {
        let which = (value, &*lights[*light].name);
        let graph = shader_graph::load_light(
            &document,
            which,
            &mut materials.images,
            options.cycles,
            &mut diagnostics,
        )?;
        materials.graphs.push(graph);
    }
    let (images, conversions) =
        materials
            .images
            .decode(&mut materials.list, &mut materials.graphs, &mut diagnostics);
    let mut of_others = materials.graphs.split_off(of_materials).into_iter();
    let material_aovs: Vec<_> = of_others.by_ref().take(of_materials).collect();
    let world_aovs = of_others.next().flatten();
    let world_graph = of_others.next().flatten();
    let world_volume = of_others.next().flatten();
    for ((light, _), graph) in light_graphs.into_iter().zip(of_others) {
        lights[light].graph = graph.map(Box::new);
    }

    let meshes = load_meshes(
        &document,
        &poses,
        &materials.by_primitive,
        &document.budget,
        &mut diagnostics,
    )?;
    let holdouts = materials.holdouts;
    let mut scene = Scene {
        generator: document.core.asset.generator.clone(),
        materials: materials
            .list
            .into_iter()
            .zip(materials.graphs)
            .zip(material_aovs)
            .map(|((flat, graph), aovs)| {
                let mut material = flat.with_graph(graph);
                if let Some(aovs) = aovs {
                    material.graph.take_aovs(aovs);
                }
                material
            })
            .collect(),
        aovs,
        world_aovs: world_aovs.map(Box::new),
        images,
        lights,
        portals,
        cameras,
        ..Scene::default()
    };
    let mut ids: HashMap<Shaped, Vec<MeshId>> = HashMap::new();
    let mut strokes = Vec::new();
    for (index, primitives) in meshes {
        let list = ids.entry(index).or_default();
        for primitive in primitives {
            let id = MeshId(u32::try_from(scene.meshes.len()).unwrap_or(u32::MAX));
            list.push(id);
            strokes.extend(primitive.stroke.map(|stroke| (id, stroke)));
            scene.meshes.push(primitive.mesh);
        }
    }
    let is_holdout = |mesh: MeshId, scene: &Scene| {
        let material = scene.meshes[mesh.0 as usize].material;
        material.is_some_and(|id| holdouts.get(id.0 as usize) == Some(&true))
    };
    for place in placed {
        for &mesh in ids.get(&place.mesh).into_iter().flatten() {
            if scene.instances.len() >= MOST_INSTANCES {
                return Err(ImportError::malformed(
                    &document.file,
                    "scene",
                    format!("it places more than {MOST_INSTANCES} meshes"),
                ));
            }
            let holdout = place.holdout || is_holdout(mesh, &scene);
            scene.instances.push(Instance {
                name: place.name.clone(),
                mesh,
                world_from_object: place.world_from_object,
                motion: place.motion.clone(),
                visibility: place.visibility,
                holdout,
                info: place.info.clone(),
            });
        }
    }
    strokes::draw(&mut scene, strokes, &document.budget, &mut diagnostics)
        .map_err(|problem| ImportError::malformed(&document.file, "points and lines", problem))?;
    lights::choose_units(&open_units, &mut scene, &mut diagnostics);
    if let Some(extension) = extension {
        let place = (path, options.allow_outside);
        scene_extension::apply(extension, place, &mut scene, &mut diagnostics);
    }
    let limit = extension.and_then(|extension| extension.texture_limit.as_ref());
    if let Some(limit) = limit {
        limit.apply(&conversions, &mut scene);
    }
    image_spaces::convert(
        &conversions,
        &mut scene.images,
        &scene.color_management,
        &mut diagnostics,
    );
    if let Some(world) = world {
        world::load(
            &document,
            (world, world_graph),
            (options.image_bytes, limit),
            &mut scene,
            &mut diagnostics,
        )?;
    }
    if world.is_none() && !options.without_world {
        cube_light::load(&document, scene_index, &mut scene, &mut diagnostics)?;
    }
    if let Some(medium) = &mut scene.medium {
        medium.varying = world_volume.map(Box::new);
    }
    scene.tell_of_catchers(&mut diagnostics);
    Ok(Imported {
        scene,
        variants,
        diagnostics,
    })
}

/// What concerns the file as a whole.
fn report_whole_file(document: &Document, options: &ImportOptions, diagnostics: &mut Diagnostics) {
    let handled = [
        "KHR_lights_punctual",
        cube_light::NAME,
        ies_lights::NAME,
        "KHR_materials_variants",
    ];
    // Without a choice it is told what is shown.
    let handled = &handled[..3 + usize::from(options.variant.is_some())];
    extensions::report_others(document, "", "the file", handled, diagnostics);
    if let Some(Value::Array(animations)) = document.value.get("animations")
        && options.animation.is_none()
    {
        for (index, animation) in animations.iter().enumerate() {
            let name = animation
                .get("name")
                .and_then(Value::as_str)
                .map(str::to_owned);
            diagnostics.report_effect(
                Effect::MotionBlur,
                "animation",
                Verdict::Lost,
                "animations",
                name.unwrap_or_else(|| format!("animation {index}")),
                "the scene stands still, as its nodes are placed in the file; --frame or --seconds poses it",
            );
        }
    }
}
