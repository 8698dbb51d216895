//! Universal Scene Description (`.usda`, `.usdc`, `.usd`, `.usdz`).
//!
//! The crate `openusd` parses the layers and composes them; what the stage says becomes a scene here.

mod binding;
mod blackbody;
mod camera;
mod classes;
mod collections;
mod crate_file;
mod crate_values;
mod curves;
mod domes;
mod files;
mod geometry;
mod ies;
mod instances;
mod lexis;
mod lights;
mod linking;
mod materials;
mod materialx;
mod materialx_blends;
mod materialx_more;
mod materialx_nodes;
mod materialx_noise;
mod materialx_places;
mod materialx_surfaces;
mod named;
mod network;
mod placing;
mod polygons;
mod preview;
mod primitives;
mod repair;
mod settings;
mod skeleton;
mod source;
mod subdivide;
mod subdivide_loop;
mod text;
mod textures;
mod transform;
mod triangles;
mod value;
mod variants;
mod volumes;
mod walk;

pub(super) use self::named::named_files;
use std::path::Path;

use glam::{DAffine3, DMat3};

use self::domes::Layout;
use self::geometry::Shapes;
use self::linking::{Linked, Shines};
use self::materials::Materials;
use self::placing::{Frame, Placed};
use self::source::Source;
use self::walk::{Item, Thing, Walk};
use super::guard::guarded;
use super::{ImportError, ImportOptions, Imported};
use crate::math::primaries::WorkingSpace;
use crate::scene::{
    Camera, Diagnostics, Environment, ImageId, ImageUse, Instance, Links, MaterialId, MeshId,
    ObjectInfo, RayKind, Scene, Verdict, Visibility,
};

/// Parsers and composition call themselves for what stands inside of what: for files that go deep on purpose.
const STACK: usize = 512 << 20;

/// What names of USD files end in.
const ENDINGS: [&str; 4] = ["usd", "usda", "usdc", "usdz"];

/// Whether a file's name or its first bytes say that it is USD.
pub(super) fn is_usd(path: &Path) -> bool {
    let ending = path
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default();
    if ENDINGS.iter().any(|e| ending.eq_ignore_ascii_case(e)) {
        return true;
    }
    let mut start = [0u8; 8];
    let read = std::fs::metadata(path)
        .ok()
        .filter(std::fs::Metadata::is_file)
        .and_then(|_| std::fs::File::open(path).ok())
        .and_then(|mut file| std::io::Read::read_exact(&mut file, &mut start).ok());
    read.is_some() && (start.starts_with(b"#usda") || start.starts_with(b"PXR-USDC"))
}

/// Reads a file; the result has not been through [`crate::scene::validate::clean`] yet.
///
/// The stage is given back after the scene is: that takes a fifth of the time, for which nobody has to wait.
pub(super) fn load(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let file = path.display().to_string();
    let (sender, receiver) = std::sync::mpsc::channel();
    let (place, options) = (path.to_owned(), options.clone());
    let work = move || {
        let mut source = None;
        let mut problem = None;
        let guarded = guarded(|| {
            let mut read_at = |careful: bool| {
                let opened = Source::open(&place, &options, careful)?;
                let source = source.insert(opened);
                let read = load_here(source, &options)?;
                Ok((read, source.has_refused_text()))
            };
            // A second time with care, where the parser refuses a text: that takes longer.
            let read = match read_at(false) {
                Ok((_, true)) => read_at(true),
                Err(ImportError::NotUsd { reason, .. }) if source::is_of_text(&reason) => {
                    read_at(true)
                }
                read => read,
            };
            let read = read.map(|(read, _)| read);
            read.map_err(|error| {
                problem = Some(error);
                String::new()
            })
        });
        // The other end waits until it has got this.
        let _ = sender.send(guarded.map_err(|reason| (reason, problem)));
        drop(source);
    };
    let broken = |reason: String| ImportError::NotUsd {
        file: file.clone(),
        reason,
    };
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(work);
    let read = thread.ok().and_then(|_| receiver.recv().ok());
    let read = read.ok_or_else(|| broken("there is not enough memory to read it".into()))?;
    read.map_err(|(reason, problem)| problem.unwrap_or_else(|| broken(reason)))
}

/// The release of Blender that a stage was written by, if it was: major and minor version.
fn blender_version(source: &Source) -> Option<lights::Blender> {
    let doc = source
        .metadata("documentation")
        .or_else(|| source.metadata("comment"));
    lights::Blender::told(&value::word(&doc?)?)
}

fn load_here(source: &Source, options: &ImportOptions) -> Result<Imported, ImportError> {
    let mut diagnostics = Diagnostics::default();
    if let Some(wanted) = &options.variant {
        variants::choose(source, wanted)?;
    }
    let frame = frame(source);
    let shapes = Shapes::new(source, Materials::new(source, options), options.grid_memory);
    let mut walk = Walk::new(source, shapes, &mut diagnostics);
    let items = walk.run()?;
    let Walk {
        shapes,
        lamps,
        cameras,
        camera_paths,
        settings,
        ..
    } = walk;
    let Shapes {
        materials,
        meshes,
        list,
        ..
    } = shapes;
    let mut assembly = Assembly {
        scene: Scene {
            generator: source
                .metadata("documentation")
                .as_ref()
                .and_then(value::word)
                .filter(|doc| doc.contains("Blender v")),
            meshes,
            ..Scene::default()
        },
        materials,
        frame,
        source,
        options,
        domes: Vec::new(),
        chosen: Vec::new(),
        linked: Vec::new(),
        paths: Vec::new(),
    };
    for item in &items {
        assembly.place(
            item,
            (&list, &lamps, &cameras),
            &camera_paths,
            &mut diagnostics,
        )?;
    }
    let Assembly {
        mut scene,
        materials,
        chosen,
        linked,
        paths,
        domes,
        ..
    } = assembly;
    let mut list = materials.list;
    let mut of_world = None;
    scene.environment = domes::sum(domes).map(|dome| {
        of_world = dome.image;
        Environment {
            image: None,
            radiance: dome.radiance.map(|v| v as f32),
            rotation: dome.turn,
            visibility: Visibility::ALL,
            links: Links::default(),
            graph: None,
        }
    });
    linking::link(&mut scene, &linked, &paths, &mut diagnostics);
    let of_lights = scene
        .lights
        .iter_mut()
        .filter_map(|l| l.graph.as_deref_mut());
    let graphs = list.iter_mut().map(|m| &mut m.graph).chain(of_lights);
    let left = super::left_for_images(of_world.as_slice(), options.image_bytes);
    scene.images = materials.images.decode(graphs, left, &mut diagnostics);
    if let (Some(image), Some(environment)) = (of_world, &mut scene.environment) {
        environment.image = Some(ImageId(scene.images.len() as u32));
        scene.images.push(image);
    }
    scene.materials = list;
    let found = settings::Found {
        source,
        prims: &settings,
    };
    let cameras = (chosen.as_slice(), &mut scene.cameras);
    settings::apply(&found, cameras, &mut scene.render, &mut diagnostics);
    report_file(source, &mut diagnostics)?;
    scene.tell_of_catchers(&mut diagnostics);
    Ok(Imported {
        scene,
        variants: variants::names(source),
        diagnostics,
    })
}

/// The stage's axes and unit.
fn frame(source: &Source) -> Frame {
    let unit = source.meters_per_unit();
    let axis = source.metadata("upAxis").as_ref().and_then(value::word);
    let z_up = axis.as_deref() == Some("Z");
    let turn = if z_up {
        DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2)
    } else {
        DMat3::IDENTITY
    };
    // Sines of right angles are not quite 1 or 0.
    let turn = DMat3::from_cols_array(&turn.to_cols_array().map(f64::round));
    Frame {
        ours_from_stage: DAffine3::from_mat3(turn * DMat3::from_diagonal(glam::DVec3::splat(unit))),
        meters_per_unit: unit,
        z_up,
    }
}

/// A scene that is being put together.
struct Assembly<'a> {
    scene: Scene,
    materials: Materials<'a>,
    frame: Frame,
    source: &'a Source,
    options: &'a ImportOptions,
    domes: Vec<domes::Placed>,
    /// Paths of the scene's cameras.
    chosen: Vec<String>,
    /// Lamps that are not for all objects.
    linked: Vec<(Shines, Linked)>,
    /// Paths of the instances.
    paths: Vec<openusd::sdf::Path>,
}

impl Assembly<'_> {
    fn place(
        &mut self,
        item: &Item,
        (list, lamps, cameras): (&[Vec<MeshId>], &[lights::Lamp], &[Camera]),
        camera_paths: &[String],
        diagnostics: &mut Diagnostics,
    ) -> Result<(), ImportError> {
        let world = self.frame.ours_from_stage * item.matrix;
        match item.thing {
            Thing::Shape(shape) => {
                for mesh in list.get(shape).into_iter().flatten() {
                    self.instance(item, *mesh, world);
                }
            }
            Thing::Camera(camera) => {
                let placed = camera::placed(&cameras[camera], world, self.frame.meters_per_unit);
                self.scene.cameras.push(placed);
                self.chosen.push(camera_paths[camera].clone());
            }
            Thing::Lamp(lamp) => {
                let lamp = &lamps[lamp];
                let image = self.image_on(lamp, diagnostics);
                let shines = match placing::place(lamp, &item.matrix, image, &self.frame) {
                    Placed::Light(light) => {
                        self.scene.lights.push(*light);
                        Shines::Light(self.scene.lights.len() - 1)
                    }
                    Placed::Mesh(mut mesh, radiance) => {
                        let material = self.materials.shining(&lamp.name, radiance);
                        mesh.material = Some(MaterialId(material as u32));
                        let id = MeshId(self.scene.meshes.len() as u32);
                        self.scene.meshes.push(*mesh);
                        self.instance(item, id, world);
                        let placed = self.scene.instances.last_mut();
                        let unseen = Visibility::ALL.without(RayKind::Camera);
                        placed.into_iter().for_each(|i| i.visibility = unseen);
                        Shines::Instance(self.scene.instances.len() - 1)
                    }
                    Placed::Dome { radiance, turn } => {
                        self.dome(lamp, radiance, turn, diagnostics);
                        Shines::Environment
                    }
                };
                let counts = !matches!(shines, Shines::Environment) || self.domes.len() == 1;
                if counts && !lamp.linked.is_all() {
                    self.linked.push((shines, lamp.linked.clone()));
                }
            }
        }
        Ok(())
    }

    /// The image that a lamp shows.
    fn image_on(
        &mut self,
        lamp: &lights::Lamp,
        diagnostics: &mut Diagnostics,
    ) -> Option<(ImageId, ImageUse)> {
        let (place, called) = lamp.image.as_ref()?;
        let images = &mut self.materials.images;
        let id = images.get(self.source, (place, called), &lamp.path, diagnostics)?;
        let usage = if images.is_srgb(id) {
            ImageUse::Color
        } else {
            ImageUse::Data
        };
        Some((id, usage))
    }

    fn instance(&mut self, item: &Item, mesh: MeshId, world: DAffine3) {
        self.paths.push(item.path.clone());
        self.scene.instances.push(Instance {
            name: item.name.as_ref().into(),
            mesh,
            world_from_object: world,
            motion: Vec::new(),
            visibility: Visibility::ALL,
            holdout: false,
            info: ObjectInfo {
                color: item.color.unwrap_or([1.0; 4]),
                ..ObjectInfo::default()
            },
        });
    }

    fn dome(
        &mut self,
        lamp: &lights::Lamp,
        radiance: [f64; 3],
        turn: DMat3,
        diagnostics: &mut Diagnostics,
    ) {
        let lights::Shape::Dome(dome) = &lamp.shape else {
            return;
        };
        if self.options.without_world {
            return;
        }
        let found = dome.image.as_ref().map(|(place, called)| {
            let told = match self.source.files.read(place) {
                Ok(bytes) => {
                    let taking = super::Taking {
                        space: WorkingSpace::default(),
                        floats_are_in_it: false,
                        most_bytes: self.options.image_bytes,
                    };
                    let file = &self.source.file;
                    super::environment_image(&bytes, file, called, &taking, diagnostics)
                        .map_err(|error| error.to_string())
                }
                Err(reason) => Err(format!("image \"{called}\" that cannot be read ({reason})")),
            };
            told.map(|image| match dome.layout {
                Layout::LatLong => image,
                layout => domes::upright(&image, layout).unwrap_or(image),
            })
        });
        let image = match found.transpose() {
            Ok(image) => image,
            Err(what) => {
                diagnostics.report(
                    "image-lost",
                    Verdict::Lost,
                    what,
                    &*lamp.path,
                    "the dome light is left out",
                );
                return;
            }
        };
        if !self.domes.is_empty() {
            diagnostics.report(
                "usd-domes",
                Verdict::Approximated,
                "second and further dome lights",
                &*lamp.path,
                "added to the light of the first, whose links to objects count for all",
            );
        }
        self.domes.push(domes::Placed {
            image,
            radiance,
            turn,
        });
    }
}

/// What concerns the file as a whole.
fn report_file(source: &Source, diagnostics: &mut Diagnostics) -> Result<(), ImportError> {
    source.report(diagnostics);
    let refused = source.files.take_refused();
    if let Some(needed) = refused.outside.into_iter().next() {
        return Err(ImportError::Outside {
            file: source.file.clone(),
            object: "the stage".into(),
            needed,
        });
    }
    for (layer, part) in refused.left_out {
        diagnostics.report(
            "usd-text",
            Verdict::Lost,
            "statements of a text that are not understood",
            format!("{layer}, line {}: {}", part.line, part.what),
            "left out, the rest is read",
        );
    }
    for circle in refused.circles {
        let (verdict, what, instead) = if circle.redundant {
            let what = "prims that inherit once more what those they stand below have inherited";
            (Verdict::Exact, what, "inherited once")
        } else {
            let what = "prims that inherit themselves by way of others";
            (Verdict::Lost, what, "they do not inherit those")
        };
        diagnostics.report(
            "usd-circle",
            verdict,
            what,
            circle.prim.to_string(),
            instead,
        );
    }
    for (path, reason) in refused.damaged {
        diagnostics.report(
            "usd-layer",
            Verdict::Lost,
            format!("layer that cannot be read ({reason})"),
            path,
            "left out",
        );
    }
    if source.metadata("metersPerUnit").is_none() {
        diagnostics.report(
            "usd-unit",
            Verdict::Exact,
            "stage that does not say its unit",
            "",
            "a unit is a centimetre, as USD has it",
        );
    }
    Ok(())
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/mod.rs"]
mod tests;
