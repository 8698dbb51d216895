//! Shadow catchers: objects that stand for what a photograph shows, and show nothing but what others do to the light on them.

use super::{
    Diagnostics, Effect, FastGiMethod, Instance, Light, Material, Mesh, Scene, Subject, Verdict,
};
use std::collections::HashSet;

impl Instance {
    /// Whether it is a shadow catcher.
    pub fn is_catcher(&self) -> bool {
        self.info.links.shadow_catcher.unwrap_or(false)
    }
}

impl Light {
    /// Whether it shines in the photograph, too: on shadow catchers alone.
    pub fn lights_catchers(&self) -> bool {
        self.links.shadow_catcher.unwrap_or(true)
    }
}

impl Scene {
    /// Whether some object is a shadow catcher.
    pub fn has_catchers(&self) -> bool {
        let mut placed = self.instances.iter();
        placed.any(|instance| instance.is_catcher() && self.has_triangles(instance))
    }

    /// Tells of catchers that Cycles shows otherwise.
    pub fn tell_of_catchers(&self, diagnostics: &mut Diagnostics) {
        for instance in self.instances.iter().filter(|i| i.is_catcher()) {
            let Some(mesh) = self.meshes.get(instance.mesh.0 as usize) else {
                continue;
            };
            let material = mesh.material.and_then(|m| self.materials.get(m.0 as usize));
            let clear = mesh.colors.iter().flatten().any(|color| color[3] < 1.0);
            if material.is_some_and(|m| m.graph.summary(clear).is_translucent()) {
                diagnostics.report_effect(
                    Effect::ShadowCatcher,
                    "clear-catcher",
                    Verdict::Approximated,
                    "shadow catchers that light passes",
                    Subject::Object(instance.name.clone()),
                    "objects behind them are seen as they are; in Cycles they change the light on them",
                );
            }
        }
    }

    /// The scene as the photograph shows it: shadow catchers, the lights on them and the world. Numbers of meshes, materials and
    /// cameras stay what they were.
    pub fn of_catchers(&self) -> Self {
        let instances: Vec<_> = (self.instances.iter())
            .filter(|instance| instance.is_catcher())
            .cloned()
            .collect();
        let placed: HashSet<_> = instances.iter().map(|i| i.mesh.0 as usize).collect();
        let meshes = self.meshes.iter().enumerate();
        let meshes: Vec<_> = meshes
            .map(|(number, mesh)| match placed.contains(&number) {
                true => mesh.clone(),
                false => Mesh::default(),
            })
            .collect();
        let used: HashSet<_> = meshes
            .iter()
            .filter_map(|mesh| Some(mesh.material?.0 as usize))
            .collect();
        let materials = self.materials.iter().enumerate();
        let materials = materials.map(|(number, material)| match used.contains(&number) {
            true => material.clone(),
            false => Material::default(),
        });
        let lights = self.lights.iter().filter(|light| light.lights_catchers());
        Self {
            generator: self.generator.clone(),
            materials: materials.collect(),
            meshes,
            instances,
            images: self.images.clone(),
            lights: lights.cloned().collect(),
            environment: self.environment.clone(),
            portals: self.portals.clone(),
            // What fills space is no part of the photograph.
            medium: None,
            cameras: self.cameras.clone(),
            light_groups: Vec::new(),
            shutter: self.shutter.clone(),
            color_management: self.color_management.clone(),
            render: self.render,
            // What is added is so once for both.
            fast_gi: (self.fast_gi).filter(|gi| gi.method != FastGiMethod::Add),
            aovs: Vec::new(),
            world_aovs: None,
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/scene/catchers.rs"]
mod tests;
