//! What a file says belongs together among lights and objects: light groups.

use super::{Instance, MaterialId, MeshId, Scene};
use std::sync::Arc;

/// What a light or an object belongs to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Links {
    /// Its light group.
    pub group: Option<Arc<str>>,
}

/// Which light groups have a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightGrouping {
    /// Those of the file.
    File,
    /// One for each lamp and each object that shines, and one for the world.
    Each,
    /// None.
    None,
}

impl LightGrouping {
    /// Gives a scene these light groups.
    pub fn choose(self, scene: &mut Scene) {
        match self {
            Self::File => {}
            Self::Each => scene.group_each_light(),
            Self::None => scene.light_groups.clear(),
        }
    }
}

impl Scene {
    /// Whether an instance places triangles: those that do are what a prepared scene counts as objects.
    pub fn has_triangles(&self, instance: &Instance) -> bool {
        let MeshId(mesh) = instance.mesh;
        let mesh = self.meshes.get(mesh as usize);
        mesh.is_some_and(|mesh| !mesh.triangles.is_empty())
    }

    /// Puts each lamp, each object that shines, and the world into a light group with its name.
    fn group_each_light(&mut self) {
        let emits: Vec<bool> = self
            .materials
            .iter()
            .map(|material| {
                let summary = material.summary();
                summary.unlit || summary.emits()
            })
            .collect();
        self.light_groups.clear();
        let mut group = |name: &str| -> Option<Arc<str>> {
            if !self.light_groups.iter().any(|known| known == name) {
                self.light_groups.push(name.into());
            }
            Some(name.into())
        };
        for light in &mut self.lights {
            light.links.group = group(&light.name);
        }
        for instance in &mut self.instances {
            let mesh = self.meshes.get(instance.mesh.0 as usize);
            let material = mesh.and_then(|mesh| mesh.material);
            if material.is_some_and(|MaterialId(id)| emits.get(id as usize) == Some(&true)) {
                instance.info.links.group = group(&instance.name);
            }
        }
        if let Some(environment) = &mut self.environment {
            environment.links.group = group("World");
        }
    }
}
