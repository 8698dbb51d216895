//! What a scene calls for.

use super::census::{self, Census};
use super::requested::RequestedSettings;
use super::table::{COUNT, Decided, TABLE, row};
use crate::scene::coincident::{self, Coincident};
use crate::scene::graph::{Opacity, PrincipledSummary, Slot};
use crate::scene::{
    Diagnostics, Effect, Environment, Instance, LeftOut, Light, LightKind, Material, Medium, Mesh,
    Projection, RayKind, Scene, Subject, Visibility,
};
use enumset::EnumSet;
use serde::Serialize;
use std::collections::BTreeSet;

/// What can call for an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Thing {
    /// A placed mesh.
    Object,
    /// A material.
    Material,
    /// A light.
    Light,
    /// A camera.
    Camera,
    /// What is all around.
    World,
    /// A flag.
    Settings,
    /// What the importer names.
    File,
}

/// Something that calls for an effect.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Cause {
    /// What it is.
    pub kind: Thing,
    /// Its name.
    pub name: String,
    /// Of a material: the first object that has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
}

impl Cause {
    fn new(kind: Thing, name: impl Into<String>) -> Self {
        Self {
            kind,
            name: name.into(),
            object: None,
        }
    }
}

impl From<&Subject> for Cause {
    fn from(subject: &Subject) -> Self {
        let kind = match subject {
            Subject::Material(_) => Thing::Material,
            Subject::Object(_) => Thing::Object,
            Subject::Other(_) => Thing::File,
        };
        Self::new(kind, subject.name())
    }
}

/// What becomes of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// The scene or the settings call for it.
    Needed,
    /// Nothing calls for it.
    LeftOut,
    /// The scene calls for it, but the program does not have it yet.
    #[serde(rename = "lacking")]
    Unsupported,
}

/// One effect of a scene with what calls for it, or with why nothing does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Which one.
    pub effect: Effect,
    /// What it is.
    pub about: &'static str,
    /// Where it is decided.
    pub decided: Decided,
    /// Whether it is called for.
    pub state: State,
    /// The first things that call for it.
    pub because_of: Vec<Cause>,
    /// How many do.
    pub count: usize,
    /// Why nothing calls for it, and what only seemed to.
    pub reasons: Vec<String>,
}

/// So many causes a finding keeps.
const CAUSES_KEPT: usize = 16;

/// Effects that a scene calls for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EffectReport {
    /// Those that it calls for and that the program has.
    pub called_for: EnumSet<Effect>,
    /// One entry for each line of the table.
    pub findings: Vec<Finding>,
}

/// Whether a visibility is more than the camera's or the shadow rays' affair, which cost nothing.
fn limits_paths(visibility: Visibility) -> bool {
    [RayKind::Diffuse, RayKind::Glossy, RayKind::Transmission]
        .iter()
        .any(|&kind| !visibility.sees(kind))
}

/// Whether a light is not there for some paths, or casts no shadow. `has_media`: the scene has any.
fn is_limited(light: &Light, has_media: bool) -> bool {
    limits_paths(light.visibility)
        || has_media && !light.visibility.sees(RayKind::Volume)
        || !light.visibility.sees(RayKind::Shadow)
        || light.max_bounces < Light::MAX_BOUNCES
        || !light.is_hit
}

/// Whether there is anything between surfaces.
fn has_media(scene: &Scene) -> bool {
    let of_materials = scene.materials.iter().map(|m| m.medium.as_ref());
    let mut all = of_materials.chain([scene.medium.as_ref()]).flatten();
    all.any(|medium| medium.effect().is_some())
}

fn shines(light: &Light) -> bool {
    light.kind.strength() != 0.0 && light.color.iter().any(|&c| c != 0.0)
}

fn is_bright(environment: &Environment) -> bool {
    environment.radiance.iter().any(|&r| r != 0.0)
}

/// Whether paths have to tell kinds of rays apart in a scene.
pub fn tells_rays_apart(scene: &Scene) -> bool {
    let has_media = has_media(scene);
    scene.instances.iter().any(|i| limits_paths(i.visibility))
        || scene
            .lights
            .iter()
            .any(|l| shines(l) && is_limited(l, has_media))
        || scene
            .environment
            .as_ref()
            .is_some_and(|e| is_bright(e) && limits_paths(e.visibility))
}

/// Whether a material lets light pass beside it.
pub fn is_translucent(material: &Material, vertex_alpha: bool) -> bool {
    material.graph.summary(vertex_alpha).is_translucent()
}

/// Whether anything is not white and opaque. Interpolating ones gives one exactly.
fn colors_something(mesh: &Mesh) -> bool {
    let mut colors = mesh.colors.iter().flatten().flatten();
    colors.any(|&c| c != 1.0)
}

fn has_vertex_alpha(mesh: &Mesh) -> bool {
    mesh.colors.iter().flatten().any(|c| c[3] < 1.0)
}

/// A placed mesh with its material.
struct Placed<'a> {
    /// The first instance.
    first: &'a Instance,
    mesh: &'a Mesh,
    places: usize,
}

/// What was found so far.
struct Findings {
    causes: Vec<Vec<Cause>>,
    counts: [usize; COUNT],
}

impl Findings {
    fn new() -> Self {
        Self {
            causes: vec![Vec::new(); COUNT],
            counts: [0; COUNT],
        }
    }

    fn add(&mut self, effect: Effect, cause: impl FnOnce() -> Cause) {
        self.counts[effect as usize] += 1;
        let causes = &mut self.causes[effect as usize];
        if causes.len() < CAUSES_KEPT {
            let cause = cause();
            if !causes.contains(&cause) {
                causes.push(cause);
            }
        }
    }

    fn object(&mut self, effect: Effect, name: &str) {
        self.add(effect, || Cause::new(Thing::Object, name));
    }

    fn instances(&mut self, scene: &Scene) {
        for instance in &scene.instances {
            if limits_paths(instance.visibility) {
                self.object(Effect::RayVisibility, &instance.name);
            }
            let mesh = scene.meshes.get(instance.mesh.0 as usize);
            let material = mesh.and_then(|mesh| scene.materials.get(mesh.material?.0 as usize));
            if instance.info.links.is_linked() && material.is_some_and(Material::emits) {
                self.object(Effect::LightLinking, &instance.name);
            }
            let deforms = mesh.is_some_and(|mesh| !mesh.motion.is_empty());
            if deforms || !instance.motion.is_empty() {
                self.object(Effect::MotionBlur, &instance.name);
            }
            if instance.is_catcher() && scene.has_triangles(instance) {
                self.object(Effect::ShadowCatcher, &instance.name);
            }
            if instance.info.shading_offset > 0.0 && scene.has_triangles(instance) {
                self.object(Effect::ShadowTerminators, &instance.name);
            }
            if instance.holdout && instance.visibility.sees(RayKind::Camera) {
                self.object(Effect::Holdouts, &instance.name);
            }
        }
    }

    fn mesh(&mut self, placed: &Placed, material: &Material) {
        let (mesh, name) = (placed.mesh, &placed.first.name);
        if placed.places > 1 {
            self.object(Effect::Instances, name);
        }
        if mesh.has_strands() {
            self.object(Effect::Strands, name);
        }
        if mesh.is_smooth() {
            self.object(Effect::SmoothNormals, name);
        }
        if colors_something(mesh) {
            self.object(Effect::VertexColors, name);
        }
        match material.graph.summary(has_vertex_alpha(mesh)).opacity {
            Opacity::Clip { holes: true, .. } => self.object(Effect::AlphaClip, name),
            Opacity::Blend { below: true } => self.object(Effect::AlphaBlend, name),
            _ => {}
        }
    }

    fn material(&mut self, m: &Material, object: &Instance) {
        let mut add = |effect, there: bool| {
            if there {
                self.add(effect, || Cause {
                    object: Some(object.name.clone()),
                    ..Cause::new(Thing::Material, m.name.clone())
                });
            }
        };
        for slot in Slot::ALL {
            add(slot.effect(), m.graph.has_texture(slot));
        }
        let bumpy = m.graph.bends_normals();
        let summary = m.summary();
        add(Effect::NormalMaps, bumpy);
        add(Effect::MeshLights, summary.emits());
        add(Effect::Unlit, summary.unlit);
        add(Effect::DiffuseRoughness, summary.is_rough_diffuse);
        add(Effect::Anisotropy, summary.is_anisotropic);
        add(Effect::Coat, summary.is_coated);
        add(Effect::Sheen, summary.has_sheen);
        add(Effect::ThinFilm, summary.has_film);
        let mut there: BTreeSet<Effect> =
            m.graph.procedural_textures().map(|t| t.effect()).collect();
        there.extend(
            summary
                .is_thin_subsurface
                .then_some(Effect::DiffuseTransmission),
        );
        there.extend(summary.goes_below.then_some(Effect::Subsurface));
        there.extend(summary.simple.iter().map(|(_, effect)| *effect));
        for p in &summary.principled {
            there.extend(lobes(p));
        }
        for color in &summary.diffuse {
            there.extend((color.max_element() > 0.0).then_some(Effect::Diffuse));
        }
        for color in &summary.glossy {
            there.extend((color.max_element() > 0.0).then_some(Effect::Metal));
        }
        there.extend(m.medium.as_ref().and_then(Medium::effect));
        for effect in there {
            add(effect, true);
        }
    }

    /// Objects of solids that state priorities: one alone overlaps with no other.
    fn nested(&mut self, scene: &Scene) {
        let nested: Vec<bool> = scene
            .materials
            .iter()
            .map(|m| m.nested().is_some())
            .collect();
        let is_nested = |instance: &&Instance| {
            let mesh = &scene.meshes[instance.mesh.0 as usize];
            let material = mesh.material.map(|material| material.0 as usize);
            let is_nested = material.and_then(|material| nested.get(material));
            !mesh.triangles.is_empty() && is_nested.copied().unwrap_or(false)
        };
        let objects: Vec<&Instance> = scene.instances.iter().filter(is_nested).collect();
        if objects.len() > 1 {
            for object in objects {
                self.object(Effect::NestedDielectrics, &object.name);
            }
        }
    }

    fn coincident(&mut self, scene: &Scene, coincident: &Coincident) {
        for &instance in coincident.faces.keys() {
            let name = &scene.instances[instance as usize].name;
            self.object(Effect::CoincidentFaces, name);
        }
        for &light in coincident.lights.keys() {
            let name = &scene.lights[light as usize].name;
            self.add(Effect::CoincidentFaces, || {
                Cause::new(Thing::Light, name.clone())
            });
        }
    }

    fn lights(&mut self, scene: &Scene) {
        let has_media = has_media(scene);
        for light in scene.lights.iter().filter(|light| shines(light)) {
            let cause = || Cause::new(Thing::Light, light.name.clone());
            self.add(light.kind.effect(), cause);
            if is_limited(light, has_media) {
                self.add(Effect::RayVisibility, cause);
            }
            if light.links.is_linked() {
                self.add(Effect::LightLinking, cause);
            }
        }
        if let Some(effect) = scene.medium.as_ref().and_then(Medium::effect) {
            let cause = || Cause::new(Thing::World, "the world's volume");
            self.add(effect, cause);
        }
        if scene.fast_gi.is_some() {
            self.add(Effect::FastGi, || Cause::new(Thing::World, "fast GI"));
        }
        let Some(environment) = scene.environment.as_ref().filter(|e| is_bright(e)) else {
            return;
        };
        let cause = || Cause::new(Thing::World, "the environment");
        self.add(environment.effect(), cause);
        if limits_paths(environment.visibility) {
            self.add(Effect::RayVisibility, cause);
        }
    }

    fn camera(&mut self, scene: &Scene, number: usize) {
        let Some(camera) = scene.cameras.get(number) else {
            return;
        };
        let cause = || Cause::new(Thing::Camera, camera.name.clone());
        if camera.motion.is_some() {
            self.add(Effect::MotionBlur, cause);
        }
        if camera.aperture.is_some() {
            self.add(Effect::DepthOfField, cause);
        }
        match camera.projection {
            Projection::Perspective { .. } => {}
            Projection::Orthographic { .. } => self.add(Effect::OrthographicCamera, cause),
            Projection::Equirectangular { .. } | Projection::Panorama { .. } => {
                self.add(Effect::PanoramaCamera, cause)
            }
        }
    }

    /// What the importer has met and the program does not have.
    fn unsupported(&mut self, told: &Diagnostics) {
        for message in told.iter() {
            let Some(effect) = message.effect else {
                continue;
            };
            if row(effect).decided != Decided::Absent {
                continue;
            }
            for subject in &message.objects {
                self.add(effect, || Cause::from(subject));
            }
            self.counts[effect as usize] += message.count - message.objects.len();
        }
    }

    /// Materials that transmit, and meshes whose opacity is below 1.
    fn see_through(&self) -> [usize; 2] {
        let sum = |effects: &[Effect]| effects.iter().map(|&e| self.counts[e as usize]).sum();
        [
            sum(&[Effect::ClearGlass, Effect::RoughGlass, Effect::ThinGlass]),
            sum(&[Effect::AlphaBlend, Effect::AlphaClip]),
        ]
    }

    fn into_report(self, census: &Census, left_out: &[LeftOut]) -> EffectReport {
        let (mut findings, mut called_for) = (Vec::with_capacity(COUNT), EnumSet::empty());
        for ((row, because_of), count) in TABLE.iter().zip(self.causes).zip(self.counts) {
            let state = match (count, row.decided) {
                (0, _) => State::LeftOut,
                (_, Decided::Absent) => State::Unsupported,
                _ => State::Needed,
            };
            let left_out = left_out
                .iter()
                .filter(|entry| entry.effect == Some(row.effect));
            let mut reasons: Vec<String> = left_out.map(ToString::to_string).collect();
            if state == State::Needed {
                called_for |= row.effect;
            } else if state == State::LeftOut && reasons.is_empty() {
                reasons.push(census.reason(row.effect));
            }
            findings.push(Finding {
                effect: row.effect,
                about: row.about,
                decided: row.decided,
                state,
                because_of,
                count,
                reasons,
            });
        }
        EffectReport {
            called_for,
            findings,
        }
    }
}

/// What a Principled BSDF calls for.
fn lobes(p: &PrincipledSummary) -> impl Iterator<Item = Effect> {
    let over_base = !p.is_metal_everywhere() && !p.is_glass_everywhere();
    let colored = p.base_color.max_element() > 0.0;
    let reflects = p.specular.1 > 0.0 && p.ior != (1.0, 1.0);
    [
        (Effect::Metal, p.metallic.1 > 0.0),
        (Effect::Diffuse, over_base && colored),
        (Effect::Gloss, over_base && reflects),
        (kind_of_glass(p), p.transmits()),
        (Effect::Dispersion, p.spreads_colors()),
    ]
    .into_iter()
    .filter_map(|(effect, there)| there.then_some(effect))
}

/// Glass is clear where its roughness is 0; an image may make it so here and there.
pub(super) fn kind_of_glass(p: &PrincipledSummary) -> Effect {
    if p.thin_wall {
        Effect::ThinGlass
    } else if p.roughness.1 == 0.0 {
        Effect::ClearGlass
    } else {
        Effect::RoughGlass
    }
}

/// Meshes with triangles that are placed, each with its first instance.
fn placed(scene: &Scene) -> Vec<Placed<'_>> {
    let mut places = vec![0; scene.meshes.len()];
    let mut firsts: Vec<Option<&Instance>> = vec![None; scene.meshes.len()];
    for instance in &scene.instances {
        let id = instance.mesh.0 as usize;
        if let Some(count) = places.get_mut(id) {
            *count += 1;
            firsts[id].get_or_insert(instance);
        }
    }
    let meshes = scene.meshes.iter().zip(firsts).zip(places);
    meshes
        .filter(|((mesh, _), _)| !mesh.triangles.is_empty())
        .filter_map(|((mesh, first), places)| {
            Some(Placed {
                first: first?,
                mesh,
                places,
            })
        })
        .collect()
}

impl EffectReport {
    /// Looks at what is placed in the scene, as the first camera sees it.
    pub fn detect(scene: &Scene) -> Self {
        Self::of(
            (scene, &coincident::find(scene)),
            &RequestedSettings::default(),
            &[],
            &Diagnostics::default(),
        )
    }

    /// Looks at what is placed in a scene, with what coincides in it, and at what the settings ask for; `left_out` is what [`crate::scene::simplify`] has
    /// left out of it, `told` what the importer has said.
    pub fn of(
        (scene, coincident): (&Scene, &Coincident),
        requested: &RequestedSettings,
        left_out: &[LeftOut],
        told: &Diagnostics,
    ) -> Self {
        let mut found = Findings::new();
        found.instances(scene);
        let fallback = Material::default();
        let mut users: Vec<Option<&Instance>> = vec![None; scene.materials.len() + 1];
        let mut emitters = 0u64;
        let placed = placed(scene);
        for one in &placed {
            let slot = one
                .mesh
                .material
                .map_or(scene.materials.len(), |m| m.0 as usize);
            let material = scene.materials.get(slot).unwrap_or(&fallback);
            found.mesh(one, material);
            if let Some(user) = users.get_mut(slot) {
                user.get_or_insert(one.first);
            }
            // No light sampling finds strands.
            if material.emits() && !one.mesh.has_strands() {
                emitters += (one.places * one.mesh.triangles.len()) as u64;
            }
        }
        for (material, user) in scene.materials.iter().chain([&fallback]).zip(&users) {
            if let Some(user) = user {
                found.material(material, user);
            }
        }
        found.lights(scene);
        found.nested(scene);
        found.coincident(scene, coincident);
        found.camera(scene, requested.camera);
        let lamp = |light: &&Light| shines(light) && !matches!(light.kind, LightKind::Sun { .. });
        emitters += scene.lights.iter().filter(lamp).count() as u64;
        if emitters > 1 {
            found.add(Effect::LightTree, || {
                Cause::new(Thing::World, format!("{emitters} lamps and triangles"))
            });
        }
        if !scene.light_groups.is_empty() {
            found.add(Effect::LightPasses, || {
                Cause::new(Thing::Settings, "--light-groups")
            });
        }
        for (effect, there, flag) in requested.settings() {
            if there {
                found.add(effect, || Cause::new(Thing::Settings, flag));
            }
        }
        found.unsupported(told);
        let census = Census {
            materials: users.iter().flatten().count(),
            see_through: found.see_through(),
            meshes: placed.len(),
            objects: scene.instances.len(),
            lights: scene.lights.len(),
            emitters,
            environment: scene.environment.as_ref().is_some_and(is_bright),
            camera: census::camera(scene, requested.camera),
        };
        found.into_report(&census, left_out)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/effects/detect.rs"]
mod tests;
