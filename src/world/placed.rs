//! Meshes in their places, in Embree.

use super::Options;
use super::fast_gi::Approximation;
use super::geometry::{Attributes, MeshData, MeshInstance};
use super::insides::{Insides, Part};
use super::interfaces;
use super::lids::Lids;
use super::material::PreparedMaterial;
use super::moving::Path;
use super::place::ObjectFacts;
use super::view::View;
use crate::effects::{self, Effect};
use crate::ffi::embree::{self, CommittedScene, Device, EmbreeError};
use crate::scene::{Instance, Mesh, Scene};
use glam::{DAffine3, DMat3, DVec3};
use std::borrow::Cow;
use std::sync::Arc;

/// Meshes in their places.
pub struct Geometry {
    pub embree: CommittedScene,
    pub meshes: Vec<Arc<MeshData>>,
    pub entries: Vec<MeshInstance>,
    /// Triangles, instances expanded.
    pub triangles: u64,
    /// For each entry whether another's interface may be close by; empty if none has one ([`interfaces`]).
    pub close: Vec<bool>,
    /// Some surfaces are asked whether they stop a ray.
    pub filtered: bool,
    /// What passes straight on takes a colour somewhere.
    pub tinted: bool,
    /// Some surfaces send rays elsewhere.
    pub portals: bool,
    /// Some programs ask the scene by rays.
    pub traces: bool,
    /// Radians of a pixel, where some programs have Bumps that are widened.
    pub widened: Option<f32>,
    /// The objects that light goes on below the surface of.
    pub insides: Insides,
    /// By entry whether it is a holdout; empty where none is.
    pub holdouts: Vec<bool>,
    /// The same of shadow catchers.
    pub catchers: Vec<bool>,
    /// By entry how many times as steep light falls on it as it does; empty where none is.
    pub steeper: Vec<f32>,
    /// What stands for indirect light.
    pub approximation: Option<Approximation>,
    /// Some are made of strands or points.
    pub has_strands: bool,
    /// Faces that lie on each other, if any do.
    pub lids: Option<Lids>,
    /// What it was made for, by material.
    needs: Vec<Needs>,
}

/// What a material asks of the meshes that have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Needs {
    attributes: Attributes,
    /// Rays ask whether they are stopped.
    filtered: bool,
    /// What passes straight on takes a colour.
    tinted: bool,
    /// It is an interface that close ones are put in order with.
    ordered: bool,
    /// Its programs ask about places.
    asks: bool,
    /// They ask the scene by rays.
    traces: bool,
    /// Their Bumps are widened.
    widened: bool,
    /// Light goes on below it.
    goes_below: bool,
    /// It sends rays elsewhere.
    has_portal: bool,
}

impl Needs {
    fn of(material: &PreparedMaterial, options: &Options) -> Self {
        let filtered = (material.translucent && !options.effects.is_disjoint(effects::ALPHA))
            || (options.cull_backfaces && material.single_sided);
        let ordered =
            !options.effects.is_disjoint(effects::TRANSMISSION) && !options.ablation.offsets;
        Self {
            attributes: Attributes {
                uv_sets: material.uv_sets().max(usize::from(options.uv_pass)),
                tangents: material.tangents().0,
                radial: material.tangents().1,
                generated: material.reads_generated(),
                colors: options.effects.contains(Effect::VertexColors),
                attributes: material.attributes(),
            },
            filtered,
            tinted: material.is_tinted,
            ordered: ordered && material.bounds_a_solid() && !filtered,
            asks: material.asks_about_places(),
            traces: material.traces(),
            widened: material.is_widened(),
            goes_below: material.goes_below(),
            has_portal: material.has_portal(),
        }
    }

    /// The same of a mesh: rays ask about all strands, as they do not meet what they leave.
    fn of_mesh(self, mesh: &Mesh) -> Self {
        Self {
            filtered: self.filtered || mesh.has_strands(),
            // Shaders of hair ask how large a pixel is.
            asks: self.asks || mesh.has_strands(),
            ..self
        }
    }

    fn of_all(materials: &[Arc<PreparedMaterial>], options: &Options) -> Vec<Self> {
        let materials = materials.iter();
        materials.map(|m| Self::of(m, options)).collect()
    }
}

/// A number for each instance; those that stand one after another with one name in one place are parts of one object.
fn objects(scene: &Scene) -> Vec<u32> {
    let mut numbers = Vec::with_capacity(scene.instances.len());
    let mut before: Option<&Instance> = None;
    let mut number = 0;
    for instance in &scene.instances {
        let same = |b: &Instance| {
            b.name == instance.name
                && b.world_from_object == instance.world_from_object
                && b.motion == instance.motion
                && b.mesh != instance.mesh
        };
        number += u32::from(!before.is_some_and(same));
        numbers.push(number);
        before = Some(instance);
    }
    numbers
}

/// By entry how many times as steep light falls on it, if any has such an offset and if the effect is kept.
fn steeper(scene: &Scene, options: &Options) -> Vec<f32> {
    let steepness = |instance: &Instance| 1.0 / (1.0 - 0.5 * instance.info.shading_offset);
    by_entry(steepness, 1.0, Effect::ShadowTerminators, scene, options)
}

/// Which entries are of a kind, if any and if the effect is kept.
fn entries_that(
    are: impl Fn(&Instance) -> bool,
    effect: Effect,
    scene: &Scene,
    options: &Options,
) -> Vec<bool> {
    by_entry(are, false, effect, scene, options)
}

/// What entries have, if some instance has another than the plain one and if the effect is kept: entries are the instances with
/// triangles, in their order.
pub(super) fn by_entry<T: PartialEq>(
    of: impl Fn(&Instance) -> T,
    plain: T,
    effect: Effect,
    scene: &Scene,
    options: &Options,
) -> Vec<T> {
    let has_one = || scene.instances.iter().any(|instance| of(instance) != plain);
    if !(options.effects.contains(effect) && has_one()) {
        return Vec::new();
    }
    let placed = scene.instances.iter();
    let placed = placed.filter(|instance| scene.has_triangles(instance));
    placed.map(of).collect()
}

/// Whether a transform keeps all angles, within a millionth: as Cycles asks.
fn scales_evenly(m: &DMat3) -> bool {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let size = x.length_squared();
    let close = |value: f64| value.abs() <= 1e-6 * size;
    close(x.dot(y))
        && close(y.dot(z))
        && close(z.dot(x))
        && close(y.length_squared() - size)
        && close(z.length_squared() - size)
}

/// A mesh in object space, in Embree, for those who place it.
type Shared = (u32, CommittedScene);

/// Geometry in the making. Meshes that are placed once become part of the top scene in world space; others are instanced.
struct Builder<'a> {
    device: &'a Device,
    robust: bool,
    origin: DVec3,
    keeps_visibility: bool,
    /// Lights have blockers of their own.
    links: bool,
    view: View,
    /// What moves does so.
    moves: bool,
    top: embree::Scene,
    meshes: Vec<Arc<MeshData>>,
    entries: Vec<MeshInstance>,
    shared: Vec<Option<Shared>>,
    /// By entry, where somebody asks.
    parts: Option<Vec<Part>>,
}

impl Builder<'_> {
    fn place(
        &mut self,
        instance: &Instance,
        mesh: &Mesh,
        (material, needs): (u32, Needs),
        is_shared: bool,
    ) -> Result<(), EmbreeError> {
        let visibility = if self.keeps_visibility {
            instance.visibility
        } else {
            instance.visibility.on_paths()
        };
        let links = &instance.info.links;
        let linked = if self.links {
            links.mask(visibility)
        } else {
            0
        };
        let mask = visibility.bits() | linked;
        let transform = DAffine3 {
            translation: instance.world_from_object.translation - self.origin,
            ..instance.world_from_object
        };
        let facts = needs.asks.then(|| {
            let about = (instance.info.clone(), mesh.texture_space);
            let place = &instance.world_from_object;
            let facts = ObjectFacts::new(place, self.origin, is_shared, about, self.view);
            Arc::new(facts)
        });
        if !is_shared {
            let mesh = &*self.still(mesh);
            let data = MeshData::new(mesh, material, Some(&transform), needs.attributes)?;
            Self::add(&mut self.top, &data, needs.filtered, mask)?;
            self.note(|| Part::Mesh(data.triangles.clone()));
            let flipped = transform.matrix3.determinant() < 0.0;
            let entry = MeshInstance::flat(self.meshes.len() as u32, flipped, visibility);
            let entry = entry.with_facts(facts);
            self.entries.push(match data.triangles.moves() {
                true => entry.moving(None),
                false => entry,
            });
            self.meshes.push(Arc::new(data));
            return Ok(());
        }
        let (number, child) = self.shared(instance.mesh.0 as usize, mesh, (material, needs))?;
        let entry = MeshInstance::instance(number, &transform, visibility).with_facts(facts);
        if self.moves && !instance.motion.is_empty() {
            let relative = instance.motion.iter().map(|step| DAffine3 {
                translation: step.translation - self.origin,
                ..*step
            });
            let steps: Vec<DAffine3> = relative.collect();
            let (path, steps) = Path::new(&steps, self.entries.len() as u32);
            self.top.add_moving_instance(&child, &steps, mask)?;
            self.note(|| Part::Moving(child, steps));
            self.entries.push(entry.moving(Some(path)));
            return Ok(());
        }
        let m = &entry.transform();
        let place = [m.x, m.y, m.z, m.translation].map(|column| column.to_array());
        self.top.add_instance(&child, &place, mask)?;
        self.note(|| Part::Instance(child, place));
        let moves = self.meshes[number as usize].triangles.moves();
        self.entries
            .push(if moves { entry.moving(None) } else { entry });
        Ok(())
    }

    /// Adds a mesh to a scene of Embree.
    fn add(
        scene: &mut embree::Scene,
        data: &MeshData,
        filtered: bool,
        mask: u32,
    ) -> Result<u32, EmbreeError> {
        match &data.strands {
            Some(strands) => scene.add_strands(&strands.mesh, mask),
            None => scene.add_triangles(&data.triangles, filtered, mask),
        }
    }

    /// Takes note of an entry for those who look at one object alone.
    fn note(&mut self, part: impl FnOnce() -> Part) {
        if let Some(parts) = &mut self.parts {
            parts.push(part());
        }
    }

    /// A mesh without its motion, where nothing is to move.
    fn still<'a>(&self, mesh: &'a Mesh) -> Cow<'a, Mesh> {
        if self.moves || mesh.motion.is_empty() {
            return Cow::Borrowed(mesh);
        }
        Cow::Owned(Mesh {
            motion: Vec::new(),
            ..mesh.clone()
        })
    }

    /// A mesh that is placed more than once: made when it is first met.
    fn shared(
        &mut self,
        slot: usize,
        mesh: &Mesh,
        (material, needs): (u32, Needs),
    ) -> Result<Shared, EmbreeError> {
        if let Some(shared) = &self.shared[slot] {
            return Ok(shared.clone());
        }
        let mesh = &*self.still(mesh);
        let data = MeshData::new(mesh, material, None, needs.attributes)?;
        let mut child = embree::Scene::new(self.device, self.robust)?;
        Self::add(&mut child, &data, needs.filtered, u32::MAX)?;
        let shared = (self.meshes.len() as u32, child.commit()?);
        self.meshes.push(Arc::new(data));
        self.shared[slot] = Some(shared.clone());
        Ok(shared)
    }
}

impl Geometry {
    /// Places the meshes of a scene about an origin.
    pub fn new(
        scene: &Scene,
        options: &Options,
        origin: DVec3,
        materials: &[Arc<PreparedMaterial>],
        device: &Device,
    ) -> Result<Self, EmbreeError> {
        let needs = Needs::of_all(materials, options);
        let mut placements = vec![0u32; scene.meshes.len()];
        for instance in &scene.instances {
            placements[instance.mesh.0 as usize] += 1;
        }
        let robust = !options.ablation.edges;
        let mut builder = Builder {
            device,
            robust,
            origin,
            keeps_visibility: options.effects.contains(Effect::RayVisibility),
            links: options.effects.contains(Effect::LightLinking),
            view: options.view(origin),
            moves: options.effects.contains(Effect::MotionBlur),
            top: embree::Scene::new(device, robust)?,
            meshes: Vec::new(),
            entries: Vec::new(),
            shared: vec![None; scene.meshes.len()],
            parts: needs.iter().any(|needs| needs.goes_below).then(Vec::new),
        };
        let (mut triangles, mut filtered, mut tinted, mut traces) = (0u64, false, false, false);
        let (mut portals, mut has_strands) = (false, false);
        let objects = objects(scene);
        for (instance, object) in scene.instances.iter().zip(objects) {
            let mesh = &scene.meshes[instance.mesh.0 as usize];
            if mesh.triangles.is_empty() {
                continue;
            }
            let default = scene.materials.len() as u32;
            let material = mesh.material.map_or(default, |m| m.0);
            let needs = needs[material as usize].of_mesh(mesh);
            has_strands |= mesh.has_strands();
            triangles += mesh.triangles.len() as u64;
            filtered |= needs.filtered;
            tinted |= needs.tinted;
            portals |= needs.has_portal;
            traces |= needs.traces;
            // Radii alone cannot say how strands are stretched across.
            let is_stretched =
                mesh.has_strands() && !scales_evenly(&instance.world_from_object.matrix3);
            let is_shared = placements[instance.mesh.0 as usize] > 1
                || is_stretched
                || builder.moves && !instance.motion.is_empty();
            builder.place(instance, mesh, (material, needs), is_shared)?;
            if let Some(entry) = builder.entries.last_mut() {
                entry.object = object;
            }
        }
        let widened = needs.iter().any(|needs| needs.widened);
        let widened = widened.then(|| builder.view.pixel_angle());
        let embree = builder.top.commit()?;
        let (meshes, entries) = (builder.meshes, builder.entries);
        let goes_below = |entry: &MeshInstance| {
            let material = meshes[entry.mesh as usize].material;
            needs[material as usize].goes_below && meshes[entry.mesh as usize].strands.is_none()
        };
        let insides = match &builder.parts {
            Some(parts) => Insides::new(device, robust, (&entries, parts), goes_below)?,
            None => Insides::default(),
        };
        let close = interfaces::close_entries(&entries, &meshes, |mesh| {
            needs[mesh.material as usize].ordered && mesh.strands.is_none()
        });
        Ok(Self {
            embree,
            meshes,
            entries,
            triangles,
            close,
            filtered,
            tinted,
            portals,
            has_strands,
            traces,
            widened,
            insides,
            holdouts: entries_that(|i| i.holdout, Effect::Holdouts, scene, options),
            steeper: steeper(scene, options),
            approximation: Approximation::new(scene, options),
            // A hole stays one.
            catchers: entries_that(
                |i| i.is_catcher() && !i.holdout,
                Effect::ShadowCatcher,
                scene,
                options,
            ),
            lids: if options.effects.contains(Effect::CoincidentFaces) {
                Lids::new(scene, options.coincident)
            } else {
                None
            },
            needs,
        })
    }

    /// Programs at its objects see another view from now on. Whether there are any.
    pub fn look(&mut self, view: View) -> bool {
        self.widened = self.widened.map(|_| view.pixel_angle());
        let facts = self.entries.iter_mut().filter_map(|e| e.facts.as_mut());
        let mut some = false;
        for facts in facts {
            Arc::make_mut(facts).view = view;
            some = true;
        }
        some
    }

    /// Whether it was made for what these materials need.
    pub fn fits(&self, options: &Options, materials: &[Arc<PreparedMaterial>]) -> bool {
        self.needs == Needs::of_all(materials, options)
    }
}
