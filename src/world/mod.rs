//! The prepared scene: recentred, in Embree, ready for rays. Read-only while rendering.

mod camera;
mod geometry;
mod interfaces;
mod lights;
mod material;
mod origin;
mod texture;

pub use crate::ffi::embree::{Hit, InstructionSet};
pub use crate::light::Source;
pub use crate::scene::RayKind;
pub use geometry::{HitPoint, Surface};
pub use interfaces::Passage;

use crate::camera::Camera;
use crate::effects::{self, Features, General, Mask};
use crate::ffi::embree::{self, CommittedScene, Device, EmbreeError, Ray};
use crate::light::LightSet;
use crate::light::emissive::Eye;
use crate::math::float;
use crate::sampler;
use crate::scene::{self, Scene};
use crate::shading::Normals;
use geometry::{Attributes, Entry, MeshData};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use material::{Coordinates, PreparedMaterial, Preparer};
use origin::Origin;
use serde::Serialize;
use std::sync::Arc;

/// A scene ready for rays. Positions are relative to `origin`.
pub struct World {
    embree: CommittedScene,
    meshes: Vec<Arc<MeshData>>,
    entries: Vec<Entry>,
    materials: Vec<Arc<PreparedMaterial>>,
    /// All that shines.
    pub lights: LightSet,
    /// The camera.
    pub camera: Camera,
    /// What was subtracted from all positions, world space, metres.
    pub origin: DVec3,
    /// Triangles, instances expanded.
    pub triangles: u64,
    cull_backfaces: bool,
    /// For each entry whether another's interface may be close by; empty if none has one ([`interfaces`]).
    close: Vec<bool>,
    /// Some surfaces are asked whether they stop a ray.
    filtered: bool,
    /// Paths take the kinds of scattering apart, as some kinds of rays see less than others.
    pub by_kind: bool,
    /// By entry; empty where there is none.
    holdouts: Vec<bool>,
    /// See [`Naive::terminator`].
    naive_terminator: bool,
    /// The version of Embree that answers.
    pub embree_version: String,
    /// The instructions that it takes.
    pub instructions: InstructionSet,
}

/// What keeps pictures stable and can be left out, to see what it is good for and what it costs. For studies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Naive {
    /// Rays start a ten-thousandth of a metre off surfaces, whatever the scale, instead of by error bounds. The
    /// general kernel alone can do it.
    pub offsets: bool,
    /// Triangles are met by Embree's fast test, which rays can slip through at edges.
    pub edges: bool,
    /// Positions become f32 where they are, and not relative to the camera.
    pub origin: bool,
    /// Directions below a triangle are lost, although the curved surface that it stands for sees them.
    pub terminator: bool,
}

/// What a world is prepared for.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// The camera.
    pub camera: &'a scene::Camera,
    /// Width over height of the picture.
    pub aspect: f64,
    /// Effects that are kept.
    pub effects: Mask,
    /// Threads that build.
    pub threads: Option<usize>,
    /// Instructions that Embree is to take, if somebody asks for some.
    pub instructions: Option<InstructionSet>,
    /// Hide back faces of single-sided materials.
    pub cull_backfaces: bool,
    /// What is left out.
    pub naive: Naive,
    /// Texture coordinates are shown by a pass.
    pub uv_pass: bool,
    /// Paths make surfaces rougher than they are ("filter glossy").
    pub roughens: bool,
}

/// What a ray with a limit of transparent surfaces met.
#[derive(Clone, Copy, Debug)]
pub enum Met {
    /// A surface that it does not pass, and how many it has passed.
    Surface(Hit, u32),
    /// Nothing.
    Nothing,
    /// One transparent surface too many, at this distance.
    Limit(f32),
}

/// Meshes that are placed once become part of the top scene in world space; others are instanced.
fn is_shared(placements: u32) -> bool {
    placements > 1
}

/// Which entries are holdouts, if any: entries are the instances with triangles, in their order.
fn holdouts(scene: &Scene) -> Vec<bool> {
    if !scene.instances.iter().any(|instance| instance.holdout) {
        return Vec::new();
    }
    let placed = scene.instances.iter().filter(|instance| {
        let mesh = &scene.meshes[instance.mesh.0 as usize];
        !mesh.triangles.is_empty()
    });
    placed.map(|instance| instance.holdout).collect()
}

impl World {
    /// Prepares a scene.
    ///
    /// # Errors
    /// If Embree fails.
    pub fn new(scene: &Scene, options: &Options) -> Result<Self, EmbreeError> {
        let device = Device::new(options.threads, options.instructions)?;
        let Origin {
            at: origin,
            distant,
        } = if options.naive.origin {
            Origin::NAIVE
        } else {
            Origin::new(scene, options.camera)
        };
        let robust = !options.naive.edges;
        let keep = |effect| effects::has(options.effects, effect);

        let mut placements = vec![0u32; scene.meshes.len()];
        for instance in &scene.instances {
            placements[instance.mesh.0 as usize] += 1;
        }
        let mut preparer = Preparer::new(options.roughens);
        let mut vertex_alpha = vec![false; scene.materials.len() + 1];
        for (mesh, _) in scene
            .meshes
            .iter()
            .zip(&placements)
            .filter(|(_, n)| **n > 0)
        {
            let slot = mesh
                .material
                .map_or(scene.materials.len(), |m| m.0 as usize);
            if let (Some(colors), Some(v)) = (&mesh.colors, vertex_alpha.get_mut(slot))
                && keep(effects::VERTEX_COLORS)
            {
                *v |= colors.iter().any(|c| c[3] < 1.0);
            }
        }
        let fallback = scene::Material::default();
        let materials: Vec<Arc<PreparedMaterial>> = scene
            .materials
            .iter()
            .chain([&fallback])
            .zip(&vertex_alpha)
            .map(|(m, &a)| preparer.material(scene, &effects::kept(m, options.effects), a))
            .map(Arc::new)
            .collect();

        let mut top = embree::Scene::new(&device, robust)?;
        let mut meshes = Vec::new();
        let mut entries = Vec::new();
        let mut shared: Vec<Option<(u32, CommittedScene)>> = vec![None; scene.meshes.len()];
        let mut triangles = 0u64;
        let mut any_filtered = false;
        // Whether it is asked if it stops a ray.
        let is_filtered = |material: &PreparedMaterial| {
            (material.translucent && keep(effects::ALPHA))
                || (options.cull_backfaces && material.single_sided)
        };
        for instance in &scene.instances {
            let source = &scene.meshes[instance.mesh.0 as usize];
            if source.triangles.is_empty() {
                continue;
            }
            let material = source
                .material
                .map_or(scene.materials.len() as u32, |m| m.0);
            let prepared = &materials[material as usize];
            let filtered = is_filtered(prepared);
            any_filtered |= filtered;
            let attributes = Attributes {
                uv_sets: prepared.uv_sets().max(usize::from(options.uv_pass)),
                tangents: prepared.normal_texture.is_some(),
                colors: keep(effects::VERTEX_COLORS),
            };
            triangles += source.triangles.len() as u64;
            let visibility = if keep(effects::VISIBILITY) {
                // No ray comes from a volume: what is hidden from those alone is hidden from none, here as by the effects.
                instance.visibility.with(RayKind::Volume)
            } else {
                instance.visibility.on_paths()
            };
            let transform = DAffine3 {
                translation: instance.world_from_object.translation - origin,
                ..instance.world_from_object
            };
            if is_shared(placements[instance.mesh.0 as usize]) {
                let slot = &mut shared[instance.mesh.0 as usize];
                let (mesh, child) = match slot {
                    Some((mesh, child)) => (*mesh, child.clone()),
                    None => {
                        let data = MeshData::new(source, material, None, attributes)?;
                        let mut child = embree::Scene::new(&device, robust)?;
                        child.add_triangles(&data.triangles, filtered, u32::MAX)?;
                        let child = child.commit()?;
                        meshes.push(Arc::new(data));
                        let id = meshes.len() as u32 - 1;
                        *slot = Some((id, child.clone()));
                        (id, child)
                    }
                };
                let entry = Entry::instance(mesh, &transform, visibility);
                let m = &entry.transform();
                top.add_instance(
                    &child,
                    &[
                        m.x.to_array(),
                        m.y.to_array(),
                        m.z.to_array(),
                        m.translation.to_array(),
                    ],
                    visibility.bits(),
                )?;
                entries.push(entry);
            } else {
                let data = MeshData::new(source, material, Some(&transform), attributes)?;
                top.add_triangles(&data.triangles, filtered, visibility.bits())?;
                meshes.push(Arc::new(data));
                entries.push(Entry::flat(
                    meshes.len() as u32 - 1,
                    transform.matrix3.determinant() < 0.0,
                    visibility,
                ));
            }
        }
        let embree = top.commit()?;
        let close = interfaces::close_entries(&entries, &meshes, |mesh| {
            let material = &materials[mesh.material as usize];
            let ordered = keep(effects::TRANSMISSION) && !options.naive.offsets;
            ordered && material.bounds_a_solid() && !is_filtered(material)
        });
        let eye = Eye::new(options.camera, origin);
        let lights = lights::prepare(
            scene,
            options.effects,
            (origin, eye, options.cull_backfaces),
            &entries,
            (&meshes, &materials),
            &device,
        )?;
        let camera = camera::prepare(
            options.camera,
            options.aspect,
            options.effects,
            (origin, distant),
        );
        Ok(Self {
            embree,
            meshes,
            entries,
            materials,
            lights,
            camera,
            origin,
            triangles,
            cull_backfaces: options.cull_backfaces,
            close,
            filtered: any_filtered,
            by_kind: keep(effects::VISIBILITY) && effects::tells_rays_apart(scene),
            holdouts: if keep(effects::HOLDOUTS) {
                holdouts(scene)
            } else {
                Vec::new()
            },
            naive_terminator: options.naive.terminator,
            embree_version: device.version().to_string(),
            instructions: device.instructions(),
        })
    }

    /// Bytes of corners and of other attributes of vertices, each mesh once; Embree's own are not in it.
    pub fn mesh_bytes(&self) -> (u64, u64) {
        let bytes = self.meshes.iter().map(|mesh| mesh.bytes());
        bytes.fold((0, 0), |sum, mesh| (sum.0 + mesh.0, sum.1 + mesh.1))
    }

    /// Effects that kernels must have because of how this world is built.
    pub fn structure(&self) -> Mask {
        let mut set = 0;
        if self.entries.iter().any(Entry::is_instance) {
            set |= effects::INSTANCES;
        }
        if self.meshes.iter().any(|mesh| mesh.has_normals()) {
            set |= effects::SMOOTH_NORMALS;
        }
        set
    }

    /// The material of an object (by its number among those with triangles): its number in the scene, or the
    /// number after the last for the default material.
    pub fn material_of(&self, object: u32) -> Option<u32> {
        let entry = self.entries.get(object as usize)?;
        Some(self.meshes.get(entry.mesh as usize)?.material)
    }

    /// Whether a hit is on an object that makes a hole in the picture.
    #[inline]
    pub fn is_holdout(&self, hit: &Hit) -> bool {
        !self.holdouts.is_empty() && self.holdouts[hit.object() as usize]
    }

    /// First texture coordinates at a hit, v upwards as in Blender; 0 where the mesh has none.
    pub fn texture_coordinates(&self, hit: &Hit) -> Vec2 {
        let entry = &self.entries[hit.object() as usize];
        let mesh = &self.meshes[entry.mesh as usize];
        if !mesh.has_uvs() {
            return Vec2::ZERO;
        }
        let uv = mesh.at(hit.primitive, hit.u, hit.v).uv(0);
        Vec2::new(uv.x, 1.0 - uv.y)
    }

    /// Whether a hit is on a back face that is not there.
    #[inline]
    fn is_hidden(&self, hit: &Hit, direction: Vec3) -> bool {
        if !self.cull_backfaces {
            return false;
        }
        let entry = &self.entries[hit.object() as usize];
        let mesh = &self.meshes[entry.mesh as usize];
        self.materials[mesh.material as usize].single_sided
            && entry
                .geometric_normal::<General>(mesh, hit.primitive)
                .dot(direction)
                > 0.0
    }

    /// Opacity of a hit (0 for a back face that is hidden).
    #[inline]
    fn opacity<E: Features>(&self, hit: &Hit, direction: Vec3) -> f32 {
        if self.is_hidden(hit, direction) {
            return 0.0;
        }
        let entry = &self.entries[hit.object() as usize];
        let mesh = &self.meshes[entry.mesh as usize];
        let material = &self.materials[mesh.material as usize];
        if !E::EVERYTHING || !material.translucent {
            return 1.0;
        }
        let at = mesh.at(hit.primitive, hit.u, hit.v);
        material.opacity(&at, at.color())
    }

    /// Whether queries have to ask about hits. Where they don't, all kernels ask Embree the same: of two surfaces at
    /// the same distance the query that asks may find another than the one that does not.
    #[inline]
    fn filters<E: Features>(&self) -> bool {
        self.filtered && (E::EVERYTHING || self.cull_backfaces)
    }

    /// The nearest surface that the ray does not pass. Blended surfaces are met with the
    /// probability of their opacity, drawn from `key` and what is met, so that the order in which
    /// Embree asks does not matter.
    #[inline]
    pub fn intersect<E: Features>(
        &self,
        origin: Vec3,
        direction: Vec3,
        (near, far): (f32, f32),
        kind: RayKind,
        key: impl FnOnce() -> u32,
    ) -> Option<Hit> {
        let ray = Ray {
            origin: origin.to_array(),
            direction: direction.to_array(),
            near,
            far,
            mask: kind.bit(),
        };
        if !self.filters::<E>() {
            return self.embree.intersect(&ray);
        }
        let key = key();
        self.embree.intersect_filtered(&ray, |hit| {
            Self::stops(hit, self.opacity::<E>(hit, direction), key)
        })
    }

    /// As [`Self::intersect`], passing at most `left` surfaces.
    /// As Cycles counts: surfaces without any opacity too, but not back faces that are hidden.
    pub fn intersect_limited<E: Features>(
        &self,
        origin: Vec3,
        direction: Vec3,
        (near, far): (f32, f32),
        kind: RayKind,
        key: u32,
        left: u32,
    ) -> Met {
        let ray = Ray {
            origin: origin.to_array(),
            direction: direction.to_array(),
            near,
            far,
            mask: kind.bit(),
        };
        if !self.filters::<E>() {
            let hit = self.embree.intersect(&ray);
            return hit.map_or(Met::Nothing, |hit| Met::Surface(hit, 0));
        }
        let mut passed = Vec::new();
        let hit = self.embree.intersect_filtered(&ray, |hit| {
            if self.is_hidden(hit, direction) {
                return false;
            }
            let stops = Self::stops(hit, self.opacity::<E>(hit, direction), key);
            if !stops {
                passed.push((hit.distance, hit.instance, hit.geometry, hit.primitive));
            }
            stops
        });
        // Embree asks in any order, about surfaces behind the hit as well.
        let end = hit.map_or(far, |hit| hit.distance);
        passed.retain(|&(distance, ..)| distance <= end);
        passed.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0)
                .then_with(|| (a.1, a.2, a.3).cmp(&(b.1, b.2, b.3)))
        });
        passed.dedup();
        if let Some(&(distance, ..)) = passed.get(left as usize) {
            return Met::Limit(distance);
        }
        hit.map_or(Met::Nothing, |hit| Met::Surface(hit, passed.len() as u32))
    }

    /// Whether a hit of this opacity stops a ray.
    #[inline]
    fn stops(hit: &Hit, opacity: f32, key: u32) -> bool {
        opacity >= 1.0
            || (opacity > 0.0
                && sampler::hashed(
                    key,
                    hit.primitive,
                    hit.geometry ^ hit.instance.unwrap_or(0).rotate_left(16),
                ) < opacity)
    }

    /// Share of light that comes from `origin + direction · share` to `origin`, 0..=1. Light that would
    /// have to pass more than `limit` surfaces does not come.
    #[inline]
    pub fn transmittance<E: Features>(
        &self,
        origin: Vec3,
        direction: Vec3,
        far: f32,
        limit: u32,
    ) -> f32 {
        let ray = Ray {
            origin: origin.to_array(),
            direction: direction.to_array(),
            near: float::RAY_START,
            far,
            mask: RayKind::Shadow.bit(),
        };
        if !self.filters::<E>() {
            return if self.embree.occluded(&ray) { 0.0 } else { 1.0 };
        }
        let mut share = 1.0f32;
        let mut left = limit;
        let blocked = self.embree.occluded_filtered(&ray, |hit| {
            share *= 1.0 - self.opacity::<E>(hit, direction);
            if limit != u32::MAX && !self.is_hidden(hit, direction) {
                if left == 0 {
                    share = 0.0;
                }
                left = left.saturating_sub(1);
            }
            share <= 0.0
        });
        if blocked { 0.0 } else { share }
    }

    /// Share of light between two points with error bounds that see each other along `wi` (from
    /// `a` to `b`): both ends leave their surfaces by their bounds.
    #[inline]
    pub fn transmittance_to<E: Features>(&self, origin: Vec3, target: Vec3, limit: u32) -> f32 {
        self.transmittance::<E>(origin, target - origin, float::SHADOW_RAY_SHARE, limit)
    }

    /// Where a ray leaves a surface along `wi`; `beyond`: it goes through. `None` where the surface is in its way.
    #[inline]
    pub fn leave<E: Features>(
        &self,
        hit: &Hit,
        surface: &Surface,
        wi: Vec3,
        beyond: bool,
    ) -> Option<Vec3> {
        let normal = surface.normals.geometric;
        if wi.dot(normal) > 0.0 {
            return Some(float::ray_origin(surface.point, normal));
        }
        if beyond {
            return Some(float::ray_origin(surface.point, -normal));
        }
        if !E::CURVED {
            return None; // The surface is its triangles.
        }
        self.leave_over_the_horizon(hit, surface)
    }

    /// For directions below the triangle, but above the curved surface that it stands for: from that surface, if the way
    /// to it is free (Hanika, *Hacking the Shadow Terminator*, Ray Tracing Gems II, ch. 4; there the way is not traced,
    /// and light leaks where something else is nearer than the curved surface).
    #[cold]
    #[inline(never)]
    fn leave_over_the_horizon(&self, hit: &Hit, surface: &Surface) -> Option<Vec3> {
        if self.naive_terminator {
            return None;
        }
        let entry = &self.entries[hit.instance.unwrap_or(hit.geometry) as usize];
        let mesh = &self.meshes[entry.mesh as usize];
        let normal = surface.normals.geometric;
        let lift = geometry::lift(entry, mesh, hit, normal);
        // What is not above the error of the point is no height.
        if lift.dot(normal) <= normal.abs().dot(surface.point.error) {
            return None;
        }
        let start = float::ray_origin(surface.point, normal);
        let ray = Ray {
            origin: start.to_array(),
            direction: lift.to_array(),
            near: float::RAY_START,
            far: 1.0,
            mask: RayKind::Shadow.bit(),
        };
        (!self.embree.occluded(&ray)).then_some(start + lift)
    }

    /// For directions that the surface is in the way of, although its smooth normal sees them: the curved surface that it
    /// stands for is hollow there (or the way up to it is blocked), and what leaves it at such an angle meets it again
    /// close by, at the other end of a chord, under the same angle. That end is taken to be like this one: what is
    /// returned is how the ray arrives, turned with the surface to here. `kind`: of the ray.
    #[inline]
    pub fn meets_itself<E: Features>(
        &self,
        hit: &Hit,
        surface: &Surface,
        wi: Vec3,
        kind: RayKind,
    ) -> Option<Vec3> {
        if !E::CURVED {
            return None;
        }
        self.arrives_again(hit, surface, wi, kind)
    }

    #[cold]
    #[inline(never)]
    fn arrives_again(&self, hit: &Hit, surface: &Surface, wi: Vec3, kind: RayKind) -> Option<Vec3> {
        let Normals {
            geometric, smooth, ..
        } = surface.normals;
        let cos = wi.dot(smooth);
        let back = wi - smooth * (2.0 * cos);
        let seen = self.entries[hit.object() as usize].visibility.sees(kind);
        // From above the triangle, as the ray before it.
        let fits = cos > 0.0 && back.dot(geometric) < 0.0;
        (seen && fits && !self.naive_terminator).then_some(back)
    }

    /// The surface at a hit of the ray that begins at `origin`.
    #[inline]
    pub fn surface<E: Features>(&self, hit: &Hit, origin: Vec3, direction: Vec3) -> Surface<'_> {
        let index = if E::CURVED {
            hit.object()
        } else {
            hit.geometry
        };
        let entry = &self.entries[index as usize];
        let mesh = &self.meshes[entry.mesh as usize];
        geometry::surface::<E>(
            entry,
            mesh,
            &self.materials[mesh.material as usize],
            hit,
            (origin, direction),
        )
    }
}
