//! The lights of a scene, made ready.

use super::geometry::{MeshData, MeshInstance};
use super::material::PreparedMaterial;
use super::place::Asking;
use crate::effects::{self, Effect, General};
use crate::ffi::embree::{Device, EmbreeError};
use crate::light::emissive::{EmissiveMesh, EmissiveSurface, EmittedPoint, Eye};
use crate::light::{Light, LightSet, LightSetBuilder, Rules};
use crate::math::luminance;
use crate::scene::{RayKind, Scene};
use enumset::EnumSet;
use glam::{DVec3, Vec2, Vec3};
use std::sync::Arc;

/// A mesh in its place, as the lights on it see it.
struct PlacedMesh {
    entry: MeshInstance,
    mesh: Arc<MeshData>,
    material: Arc<PreparedMaterial>,
    /// Back faces of single-sided materials are not there.
    cull_backfaces: bool,
}

impl EmissiveSurface for PlacedMesh {
    fn emitted(&self, triangle: u32, weights: Vec2, wi: Vec3) -> Option<EmittedPoint> {
        let Self {
            entry,
            mesh,
            material,
            ..
        } = self;
        if self.cull_backfaces
            && material.single_sided
            && entry.geometric_normal::<General>(mesh, triangle).dot(wi) > 0.0
        {
            return None;
        }
        let mut radiance = material.emission;
        if material.emission_varies() || material.translucent {
            let place = (triangle, weights.x, weights.y);
            let at = entry.at(mesh, place, Asking::along(wi));
            radiance = material.emitted(&at);
            if material.translucent {
                radiance *= material.opacity(&at);
            }
        }
        Some(EmittedPoint {
            point: entry.point::<General>(mesh, triangle, weights.x, weights.y),
            radiance,
        })
    }

    fn mean_emission(&self, triangle: u32) -> f32 {
        let Self {
            entry,
            mesh,
            material,
            ..
        } = self;
        if !material.emission_varies() {
            return luminance(material.emission);
        }
        // Centres of the 64 subtriangles of three subdivisions: finer textures than that are found by
        // the floor below.
        const N: u32 = 8;
        let mut sum = 0f32;
        for i in 0..N {
            for j in 0..N - i {
                let (u, v) = (
                    (i as f32 + 1.0 / 3.0) / N as f32,
                    (j as f32 + 1.0 / 3.0) / N as f32,
                );
                let at = entry.at(mesh, (triangle, u, v), Asking::along(Vec3::ZERO));
                sum += luminance(material.emitted(&at));
            }
        }
        let mean = sum / (N * (N + 1) / 2) as f32;
        // A hundredth of the untextured emission: no bright texel between the sampled points is
        // without a chance.
        mean + 0.01 * luminance(material.emission)
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.entry.world_corners(&self.mesh, triangle)
    }
}

/// The lights of a scene that the effects keep, with those of placed meshes.
pub(super) fn prepare(
    scene: &Scene,
    effects: EnumSet<Effect>,
    (origin, eye, cull_backfaces): (DVec3, Eye, bool),
    entries: &[MeshInstance],
    (meshes, materials): (&[Arc<MeshData>], &[Arc<PreparedMaterial>]),
    device: &Device,
) -> Result<LightSet, EmbreeError> {
    let by_kind = effects.contains(Effect::RayVisibility);
    let mut builder = LightSetBuilder::new(eye, cull_backfaces);
    for (number, light) in scene.lights.iter().enumerate() {
        if effects::keeps(effects, light)
            && let Some(made) = Light::from_scene(light, origin)
        {
            let rules = Rules::new(light.visibility, light.max_bounces, by_kind);
            builder.add(made, rules, number as u32);
        }
    }
    if effects.contains(Effect::MeshLights) {
        for (instance, entry) in entries.iter().enumerate() {
            let mesh = &meshes[entry.mesh as usize];
            let material = &materials[mesh.material as usize];
            if luminance(material.emission) <= 0.0 {
                continue;
            }
            builder.add_mesh(EmissiveMesh {
                instance: instance as u32,
                visibility: entry.visibility,
                is_opaque: material.is_opaque(),
                single_sided: material.single_sided,
                triangles: mesh.triangles.triangles().len() as u32,
                surface: Box::new(PlacedMesh {
                    entry: entry.clone(),
                    mesh: mesh.clone(),
                    material: material.clone(),
                    cull_backfaces,
                }),
            });
        }
    }
    if let Some(environment) = &scene.environment
        && effects::keeps_environment(effects, environment)
        && let Some(made) = Light::from_environment(environment, &scene.images)
    {
        // Shadows are no choice of the world's.
        let seen = environment.visibility.with(RayKind::Shadow);
        builder.add_environment(made, Rules::new(seen, u32::MAX, by_kind));
    }
    builder.build(effects.contains(Effect::LightTree), device)
}

#[cfg(test)]
#[path = "../../tests/unit/world/lights.rs"]
mod tests;
