//! The lights of a scene, made ready.

use super::LightShares;
use super::asking::Asking;
use super::fast_gi::Approximation;
use super::geometry::{MeshData, MeshInstance};
use super::material::PreparedMaterial;
use super::placed::Geometry;
use super::shine::Shine;
use super::view::{View, from_blender};
use crate::effects::{self, Effect, General};
use crate::ffi::embree::{CommittedScene, Device, EmbreeError};
use crate::light::closed;
use crate::light::computed::{ComputedLight, LightAxes};
use crate::light::coplanar::Plane;
use crate::light::emissive::{EmissiveMesh, EmissiveSurface, EmittedPoint, Eye};
use crate::light::environment::{Disc, SkyTable};
use crate::light::{Light, LightChoice, LightGroups, LightSet, LightSetBuilder, Linking, Rules};
use crate::math::luminance;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::{Function, Graph, Node, NodeKind};
use crate::scene::{self, LightKind, Mesh, RayKind, Scene, WorldGraph};
use enumset::EnumSet;
use glam::{DVec3, Mat3, Vec2, Vec3};
use std::collections::HashSet;
use std::sync::Arc;

/// A mesh in its place, as the lights on it see it.
struct PlacedMesh {
    entry: MeshInstance,
    mesh: Arc<MeshData>,
    material: Arc<PreparedMaterial>,
    /// Back faces of single-sided materials are not there.
    cull_backfaces: bool,
    /// What knows where it is when it moves.
    scene: CommittedScene,
}

impl PlacedMesh {
    /// What an object emits as it stands.
    #[inline]
    fn emitted_by(
        &self,
        (entry, mesh, triangle): (&MeshInstance, &MeshData, u32),
        weights: Vec2,
        (from, wi): (Vec3, Vec3),
        time: f32,
    ) -> Option<EmittedPoint> {
        let material = &self.material;
        if self.cull_backfaces
            && material.single_sided
            && entry.geometric_normal::<General>(mesh, triangle).dot(wi) > 0.0
        {
            return None;
        }
        let point = entry.point::<General>(mesh, triangle, weights.x, weights.y);
        let mut radiance = material.emission;
        if material.emission_varies() || material.translucent {
            let place = (triangle, weights.x, weights.y);
            let asking = Asking {
                distance: point.point.distance(from),
                time,
                ..Asking::along(wi)
            };
            let at = entry.at(mesh, place, asking);
            radiance = material.emitted(&at);
            if material.translucent {
                radiance *= material.opacity(&at);
            }
        }
        Some(EmittedPoint { point, radiance })
    }

    #[cold]
    #[inline(never)]
    fn emitted_for_a_moment(
        &self,
        (entry, mesh, triangle): (&MeshInstance, &MeshData, u32),
        weights: Vec2,
        ray: (Vec3, Vec3),
        time: f32,
    ) -> Option<EmittedPoint> {
        let moment = entry.at_time(mesh, &self.scene, (triangle, time));
        self.emitted_by(moment.of(mesh, triangle), weights, ray, time)
    }
}

impl EmissiveSurface for PlacedMesh {
    fn emitted(
        &self,
        (triangle, weights): (u32, Vec2),
        (from, wi): (Vec3, Vec3),
        time: f32,
    ) -> Option<EmittedPoint> {
        let object = (&self.entry, &*self.mesh, triangle);
        if self.entry.moves {
            return self.emitted_for_a_moment(object, weights, (from, wi), time);
        }
        self.emitted_by(object, weights, (from, wi), time)
    }

    fn mean_emission(&self, triangle: u32) -> f32 {
        let Self {
            entry,
            mesh,
            material,
            ..
        } = self;
        if !material.emission_varies() {
            return luminance(material.emission.abs());
        }
        let n = divisions(self.mesh.triangles.triangles().len());
        let mut sum = 0f32;
        for i in 0..n {
            for j in 0..n - i {
                let (u, v) = (
                    (i as f32 + 1.0 / 3.0) / n as f32,
                    (j as f32 + 1.0 / 3.0) / n as f32,
                );
                // From a metre away: what falls off with the distance is not nothing.
                let asking = Asking {
                    distance: 1.0,
                    ..Asking::along(Vec3::ZERO)
                };
                let at = entry.at(mesh, (triangle, u, v), asking);
                sum += luminance(material.emitted(&at).abs());
            }
        }
        let mean = sum / (n * (n + 1) / 2) as f32;
        // A hundredth of the untextured emission: no bright texel between the sampled points is
        // without a chance.
        mean + 0.01 * luminance(material.emission.abs())
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.entry.world_corners(&self.mesh, triangle)
    }

    fn moves(&self) -> bool {
        self.entry.moves
    }

    fn corners_at(&self, triangle: u32, time: f32) -> [Vec3; 3] {
        let place = (triangle, time);
        self.entry.corners_at(&self.mesh, &self.scene, place)
    }
}

/// So many places of a mesh are asked for what they emit, or one of each triangle.
const ASKED_AT: usize = 1 << 21;

/// In how many parts a triangle's sides are cut, to ask at the centres of such parts: what is finer is found by the floor of the mean.
/// Among very many triangles each is small, and one place stands for it. (A million took longer than the picture.)
fn divisions(triangles: usize) -> u32 {
    let places = |n: u32| (n * (n + 1) / 2) as usize;
    let fits = |n: &u32| triangles.saturating_mul(places(*n)) <= ASKED_AT;
    [8, 4, 2].into_iter().find(fits).unwrap_or(1)
}

/// The lights of a scene that the effects keep, with those of placed meshes.
pub(super) fn prepare(
    scene: &Scene,
    effects: EnumSet<Effect>,
    (origin, eye, cull_backfaces): (DVec3, Eye, bool),
    (view, (shares, clamps_direct)): (View, (LightShares, bool)),
    geometry: &Geometry,
    materials: &[Arc<PreparedMaterial>],
    device: &Device,
) -> Result<LightSet, EmbreeError> {
    let by_kind = effects.contains(Effect::RayVisibility);
    let (entries, meshes) = (&geometry.entries, &geometry.meshes);
    let mut builder = LightSetBuilder::new(eye, cull_backfaces, LightGroups::of(scene));
    if effects.contains(Effect::LightLinking)
        && let Some(linking) = Linking::of(scene)
    {
        builder.link(linking);
    }
    let hangs_on_choice =
        scene.is_from_blender() && rays_find_other_things(scene, geometry, materials);
    let shares = match shares {
        LightShares::ByPlace if hangs_on_choice => LightShares::AsTree,
        shares => shares,
    };
    if hangs_on_choice {
        builder.hang_on_choice();
    }
    let in_triangles = hangs_on_choice || clamps_direct && shares != LightShares::ByPlace;
    for (number, light) in scene.lights.iter().enumerate() {
        if effects::keeps(effects, light)
            && let Some(made) = Light::from_scene(light, origin)
        {
            let made = with_tree(scene, light, made, (origin, view));
            let limits = (light.max_bounces, light.is_hit);
            let rules =
                Rules::new(light.visibility, limits, by_kind).losing_rays(scene.is_from_blender());
            let plane = scene.is_from_blender().then(|| Plane::of(light, origin));
            builder.add_in(plane.flatten(), made, rules, number as u32);
        }
    }
    if effects.contains(Effect::MeshLights) {
        for (instance, entry) in entries.iter().enumerate() {
            let mesh = &meshes[entry.mesh as usize];
            let material = &materials[mesh.material as usize];
            // Rays alone find strands that shine: they have no area to sample.
            if mesh.strands.is_some()
                || luminance(material.emission.abs()) <= 0.0
                || (shares != LightShares::ByPlace || material.emission_traces())
                    && is_left_to_rays(material)
            {
                continue;
            }
            builder.add_mesh(EmissiveMesh {
                instance: instance as u32,
                visibility: entry.visibility,
                is_opaque: material.is_opaque(),
                single_sided: material.single_sided,
                triangles: mesh.triangles.triangles().len() as u32,
                in_triangles,
                object: entry.object,
                guess: material.emission_estimate,
                surface: Box::new(PlacedMesh {
                    entry: entry.clone(),
                    mesh: mesh.clone(),
                    material: material.clone(),
                    cull_backfaces,
                    scene: geometry.embree.clone(),
                }),
            });
        }
    }
    if let Some(environment) = &scene.environment
        && effects::keeps_environment(effects, environment)
        && let Some(made) = around(
            scene,
            environment,
            (origin, view),
            (shares, hangs_on_choice),
        )
    {
        // Shadows are no choice of the world's.
        let seen = environment.visibility.with(RayKind::Shadow);
        let made = made.with_portals(&scene.portals, origin);
        builder.add_environment(made, Rules::new(seen, (u32::MAX, true), by_kind));
    }
    let choice = match effects.contains(Effect::LightTree) {
        _ if shares == LightShares::Even => LightChoice::Even,
        _ if shares == LightShares::AsTree => LightChoice::Tree,
        true => LightChoice::Place,
        false => LightChoice::Power,
    };
    builder.build(choice, device)
}

/// Whether rays that are scattered find other light than light samples do: objects are in the way of some kinds of rays only,
/// lamps shine through what stops rays, what lets light pass or shines asks which ray it is, some fibres are drawn otherwise than they
/// are evaluated, or short rays stand for indirect light.
fn rays_find_other_things(
    scene: &Scene,
    geometry: &Geometry,
    materials: &[Arc<PreparedMaterial>],
) -> bool {
    let is_of_ray = |node: &Node| matches!(&node.kind, NodeKind::Function(Function::Place(input)) if input.tells_rays_apart());
    let of_lamps = scene
        .lights
        .iter()
        .filter_map(|light| light.graph.as_deref());
    let world = scene.environment.as_ref().and_then(|e| e.graph.as_ref());
    let mut shining = of_lamps.chain(world.map(|world| &world.graph));
    effects::tells_rays_apart(scene)
        || (scene.instances.iter()).any(|i| !i.visibility.is_alike_on_paths())
        || materials
            .iter()
            .any(|material| material.asks_which_ray() || material.draws_other_fibres())
        || shining.any(|graph| graph.nodes.iter().any(is_of_ray))
        || some_medium_is_open(scene)
        // What the last rays of paths do not see lights by their samples alone.
        || (geometry.approximation.as_ref()).is_some_and(Approximation::replaces)
}

/// Whether something fills a mesh that is open. Rays that meet nothing were in no medium, but shadow rays are in it without end.
fn some_medium_is_open(scene: &Scene) -> bool {
    let is_filled = |mesh: &&Mesh| {
        let material = mesh
            .material
            .and_then(|id| scene.materials.get(id.0 as usize));
        let medium = material.and_then(|material| material.medium.as_ref());
        medium.is_some_and(|medium| medium.effect().is_some())
    };
    let used: HashSet<u32> = scene.instances.iter().map(|i| i.mesh.0).collect();
    let meshes = scene.meshes.iter().zip(0..);
    let mut filled = meshes.filter(|(mesh, number)| used.contains(number) && is_filled(mesh));
    filled.any(|(mesh, _)| {
        let corner = |&vertex: &u32| Vec3::from(mesh.positions[vertex as usize]);
        let triangles = mesh.triangles.iter();
        let triangles: Vec<[Vec3; 3]> = triangles
            .map(|[a, b, c]| [corner(a), corner(b), corner(c)])
            .collect();
        closed::outside(&triangles).is_none()
    })
}

/// A light with its node tree, if it has one.
fn with_tree(scene: &Scene, light: &scene::Light, made: Light, known: (DVec3, View)) -> Light {
    let Some(graph) = &light.graph else {
        return made;
    };
    let place = &light.world_from_light;
    let inverse = place.matrix3.inverse();
    let axes = LightAxes {
        light_from_world: if inverse.is_finite() {
            inverse.as_mat3()
        } else {
            Mat3::IDENTITY
        },
        location: (place.translation - known.0).as_vec3(),
        size: match light.kind {
            LightKind::Area { size, .. } => Vec2::from(size),
            LightKind::Spot { half_angle, .. } => Vec2::splat(half_angle),
            LightKind::Sun { angle, .. } => Vec2::splat(0.5 * angle),
            LightKind::Point { .. } => Vec2::ONE,
        },
    };
    let shine = Shine::new(scene, graph, Some(axes), known);
    let computed = ComputedLight::new(made, Box::new(shine), axes);
    Light::Computed(Box::new(computed)).guessed(graph.emission_estimate())
}

/// Whether Cycles leaves it to rays to find what a surface emits, as it seems faint. (Where light samples are clamped, the picture
/// depends on it; and where emission asks the scene by rays, because light samples do not.)
fn is_left_to_rays(material: &PreparedMaterial) -> bool {
    material.emission_estimate.abs().max_element() <= 0.5
}

/// Share of the samples of a world that Cycles gives to its sun, which it knows by itself.
const OF_SUN: f32 = 0.8;

/// The light from all around.
fn around(
    scene: &Scene,
    environment: &scene::Environment,
    known: (DVec3, View),
    (shares, hangs_on_choice): (LightShares, bool),
) -> Option<Light> {
    let Some(world) = &environment.graph else {
        return Light::from_environment(environment, &scene.images);
    };
    let shine = Shine::new(scene, &world.graph, None, known);
    let guess = world.graph.emission_estimate();
    let suns = suns(&world.graph, hangs_on_choice);
    let table = |columns| SkyTable {
        columns,
        as_cycles: hangs_on_choice,
    };
    let [disc] = suns[..] else {
        let table = table(columns(scene, world, !suns.is_empty()));
        let made = Light::computed(environment, Box::new(shine), table, None)?;
        return Some(made.guessed(guess));
    };
    let table = table(columns(scene, world, disc.is_none()));
    let disc = disc.map(|disc| Disc {
        share: (!disc.shines || shares != LightShares::ByPlace).then_some(OF_SUN),
        ..disc
    });
    Some(Light::computed(environment, Box::new(shine), table, disc)?.guessed(guess))
}

/// The suns of a world: discs in directions that are known, or `None`. With those that are only looked for if `sought`.
fn suns(graph: &Graph, sought: bool) -> Vec<Option<Disc>> {
    let of = |node: &Node| {
        let NodeKind::Function(Function::Sky(sky)) = &node.kind else {
            return None;
        };
        let (direction, half_angle, shines) = match (sky.sun, sky.sought) {
            (Some(sun), _) => (sun.direction, sun.half_angle, true),
            (None, Some(cone)) if sought => (cone.direction, cone.half_angle, false),
            _ => return None,
        };
        let place = |input| matches!(input, PlaceInput::Generated | PlaceInput::Position);
        let is_plain = node.inputs[0].link().is_some_and(|link| {
            matches!(graph.node(link).kind, NodeKind::Function(Function::Place(input)) if place(input))
        });
        let s = (0.5 * half_angle.min(std::f32::consts::FRAC_PI_2)).sin();
        Some(is_plain.then(|| Disc {
            toward: from_blender(direction),
            one_minus_cos: 2.0 * s * s,
            share: None,
            shines,
        }))
    };
    graph.nodes.iter().filter_map(of).collect()
}

/// Columns of the table by which light sampling finds a world: those that Cycles takes.
fn columns(scene: &Scene, world: &WorldGraph, has_hidden_suns: bool) -> usize {
    if world.resolution > 0 {
        return world.resolution as usize;
    }
    let of_images = world.graph.textures().filter_map(|texture| {
        let image = scene.images.get(texture.image.0 as usize)?;
        Some((image.width as usize).max(2 * image.height as usize))
    });
    let of_suns = has_hidden_suns.then_some(4096);
    of_images.chain(of_suns).max().unwrap_or(1024)
}

#[cfg(test)]
#[path = "../../tests/unit/world/lights.rs"]
mod tests;
