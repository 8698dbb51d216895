//! Which effects a scene and its settings call for, by value.

use crate::scene::{
    AlphaMode, Environment, Light, LightKind, Material, MaterialId, RayKind, Scene, Visibility,
};
use serde::Serialize;

/// A set of effects as bits, for kernels that are compiled for it.
pub type Mask = u32;

/// Image textures and vertex colours.
pub const TEXTURES: Mask = 1;
/// Cut-outs and blends.
pub const ALPHA: Mask = 1 << 1;
/// Normal maps.
pub const NORMAL_MAPS: Mask = 1 << 2;
/// Glass, rough or clear, solid or thin.
pub const TRANSMISSION: Mask = 1 << 3;
/// Point, spot and area lights.
pub const LAMPS: Mask = 1 << 4;
/// Emissive triangles.
pub const MESH_LIGHTS: Mask = 1 << 5;
/// Sun lights.
pub const SUNS: Mask = 1 << 6;
/// Light from all around.
pub const ENVIRONMENT: Mask = 1 << 7;
/// Objects and lights that some kinds of rays do not see.
pub const VISIBILITY: Mask = 1 << 8;
/// Lenses with an opening. It lies in the camera's rays, before the path loop.
pub const DEPTH_OF_FIELD: Mask = 1 << 16;
/// Everything that the path loop is compiled for.
pub const PATHS: Mask = (1 << 9) - 1;
/// Everything.
pub const ALL: Mask = PATHS | DEPTH_OF_FIELD;

/// The one table of effects: bit, name, what it is.
pub const TABLE: [(Mask, &str, &str); 10] = [
    (TEXTURES, "textures", "image textures and vertex colours"),
    (ALPHA, "alpha", "cut-outs and blends"),
    (NORMAL_MAPS, "normal-maps", "tangent-space normal maps"),
    (
        TRANSMISSION,
        "transmission",
        "glass, rough or clear, solid or thin",
    ),
    (LAMPS, "lamps", "point, spot and area lights"),
    (MESH_LIGHTS, "mesh-lights", "emissive triangles"),
    (SUNS, "suns", "sun lights"),
    (ENVIRONMENT, "environment", "light from all around"),
    (
        VISIBILITY,
        "ray-visibility",
        "objects and lights that some rays do not see",
    ),
    (
        DEPTH_OF_FIELD,
        "depth-of-field",
        "lenses with an opening, sharp at one distance",
    ),
];

/// Whether a kernel for `set` has an effect.
#[inline(always)]
pub const fn has(set: Mask, effect: Mask) -> bool {
    set & effect != 0
}

/// Names of the effects in a set.
pub fn names(set: Mask) -> Vec<String> {
    TABLE
        .iter()
        .filter(|(bit, ..)| has(set, *bit))
        .map(|(_, name, _)| (*name).to_owned())
        .collect()
}

/// The set with these names.
///
/// # Errors
/// Names the first unknown one and lists those there are.
pub fn parse(list: &[String]) -> Result<Mask, String> {
    list.iter().try_fold(0, |set, name| {
        TABLE
            .iter()
            .find(|(_, n, _)| n == name)
            .map(|(bit, ..)| set | bit)
            .ok_or_else(|| {
                let all: Vec<_> = TABLE.iter().map(|(_, n, _)| *n).collect();
                format!("there is no effect '{name}'; there are: {}", all.join(", "))
            })
    })
}

/// One effect of a scene with what calls for it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Name in [`TABLE`].
    pub effect: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Whether the scene calls for it.
    pub needed: bool,
    /// The first objects that do (at most four).
    pub because_of: Vec<String>,
    /// How many do.
    pub count: usize,
}

/// Effects that a scene calls for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EffectSet {
    /// As bits.
    pub mask: Mask,
    /// One entry for each line of the table.
    pub findings: Vec<Finding>,
}

/// Whether a visibility is more than the camera's or the shadow rays' affair, which cost nothing.
fn limits_paths(visibility: Visibility) -> bool {
    [RayKind::Diffuse, RayKind::Glossy, RayKind::Transmission]
        .iter()
        .any(|&kind| !visibility.sees(kind))
}

/// Whether a light is not there for some paths, or casts no shadow.
fn is_limited(light: &Light) -> bool {
    limits_paths(light.visibility)
        || !light.visibility.sees(RayKind::Shadow)
        || light.max_bounces < Light::MAX_BOUNCES
}

/// The effect that a light is, if it is not black.
fn effect_of(light: &Light) -> Option<Mask> {
    let (bit, strength) = match light.kind {
        LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. } => {
            (LAMPS, intensity)
        }
        LightKind::Sun { irradiance, .. } => (SUNS, irradiance),
        LightKind::Area { power, .. } => (LAMPS, power),
    };
    let black = light.color.iter().all(|&c| c <= 0.0);
    (!black && strength > 0.0).then_some(bit)
}

fn shines(light: &Light) -> bool {
    effect_of(light).is_some()
}

fn is_bright(environment: &Environment) -> bool {
    environment.radiance.iter().any(|&r| r > 0.0)
}

/// Whether paths have to tell kinds of rays apart in a scene.
pub fn tells_rays_apart(scene: &Scene) -> bool {
    scene.instances.iter().any(|i| limits_paths(i.visibility))
        || scene.lights.iter().any(|l| shines(l) && is_limited(l))
        || scene
            .environment
            .as_ref()
            .is_some_and(|e| is_bright(e) && limits_paths(e.visibility))
}

/// Whether a material lets light pass beside it.
pub fn is_translucent(material: &Material, vertex_alpha: bool) -> bool {
    let textured = material.base_color_texture.is_some();
    match material.alpha_mode {
        AlphaMode::Opaque => false,
        AlphaMode::Mask { cutoff } => material.alpha < cutoff || textured || vertex_alpha,
        AlphaMode::Blend => material.alpha < 1.0 || textured || vertex_alpha,
    }
}

/// Whether a material emits.
pub fn emits(material: &Material) -> bool {
    material.emission.iter().any(|&e| e > 0.0)
        || (material.unlit && material.base_color.iter().any(|&c| c > 0.0))
}

impl EffectSet {
    /// Looks at what is placed in the scene.
    pub fn detect(scene: &Scene) -> Self {
        let mut reasons: Vec<(Mask, String)> = Vec::new();
        let mut placed = vec![false; scene.meshes.len()];
        for instance in &scene.instances {
            if let Some(p) = placed.get_mut(instance.mesh.0 as usize) {
                *p = true;
            }
        }
        let mut used = vec![false; scene.materials.len()];
        for instance in &scene.instances {
            if limits_paths(instance.visibility) {
                reasons.push((VISIBILITY, instance.name.clone()));
            }
        }
        for (mesh, _) in scene.meshes.iter().zip(&placed).filter(|(_, p)| **p) {
            if let Some(u) = mesh
                .material
                .and_then(|MaterialId(i)| used.get_mut(i as usize))
            {
                *u = true;
            }
            let material = mesh
                .material
                .and_then(|MaterialId(i)| scene.materials.get(i as usize));
            if mesh.colors.is_some() {
                reasons.push((TEXTURES, format!("vertex colours of {}", mesh.name)));
            }
            let vertex_alpha = mesh
                .colors
                .as_ref()
                .is_some_and(|c| c.iter().any(|c| c[3] < 1.0));
            if material.is_some_and(|m| is_translucent(m, vertex_alpha)) {
                reasons.push((ALPHA, mesh.name.clone()));
            }
        }
        for (m, _) in scene.materials.iter().zip(&used).filter(|(_, u)| **u) {
            let textures = [
                &m.base_color_texture,
                &m.metallic_roughness_texture,
                &m.emission_texture,
                &m.specular_texture,
                &m.specular_color_texture,
                &m.transmission_texture,
            ];
            if textures.iter().any(|t| t.is_some()) || m.normal_texture.is_some() {
                reasons.push((TEXTURES, m.name.clone()));
            }
            if m.normal_texture.as_ref().is_some_and(|n| n.scale != 0.0) {
                reasons.push((NORMAL_MAPS, m.name.clone()));
            }
            // A texture scales the factor down.
            let all_metal = m.metallic >= 1.0 && m.metallic_roughness_texture.is_none();
            if m.transmission > 0.0 && !all_metal && !m.unlit {
                reasons.push((TRANSMISSION, m.name.clone()));
            }
            if emits(m) {
                reasons.push((MESH_LIGHTS, m.name.clone()));
            }
        }
        for light in &scene.lights {
            if let Some(bit) = effect_of(light) {
                reasons.push((bit, light.name.clone()));
                if is_limited(light) {
                    reasons.push((VISIBILITY, light.name.clone()));
                }
            }
        }
        for camera in scene.cameras.iter().filter(|c| c.aperture.is_some()) {
            reasons.push((DEPTH_OF_FIELD, camera.name.clone()));
        }
        if let Some(environment) = &scene.environment
            && is_bright(environment)
        {
            reasons.push((ENVIRONMENT, "the environment".into()));
            if limits_paths(environment.visibility) {
                reasons.push((VISIBILITY, "the environment".into()));
            }
        }
        let findings = TABLE
            .iter()
            .map(|&(bit, effect, about)| {
                let objects: Vec<&String> = reasons
                    .iter()
                    .filter(|(b, _)| *b == bit)
                    .map(|(_, n)| n)
                    .collect();
                Finding {
                    effect,
                    about,
                    needed: !objects.is_empty(),
                    because_of: objects.iter().take(4).map(|n| (*n).clone()).collect(),
                    count: objects.len(),
                }
            })
            .collect();
        Self {
            mask: reasons.iter().fold(0, |m, (b, _)| m | b),
            findings,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_scene_calls_for_nothing_and_lists_are_parsed() {
        let set = EffectSet::detect(&Scene::default());
        assert_eq!(set.mask, 0);
        assert_eq!(set.findings.len(), TABLE.len());
        assert_eq!(parse(&["alpha".into(), "suns".into()]), Ok(ALPHA | SUNS));
        assert!(parse(&["fog".into()]).unwrap_err().contains("transmission"));
        assert_eq!(names(ALL).len(), TABLE.len());
    }
}
