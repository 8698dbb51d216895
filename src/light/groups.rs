//! Which light group each light of a scene is in, for passes.

use super::Source;
use crate::scene::{Links, Scene};
use std::collections::HashMap;

/// Light groups by the numbers of what shines; empty where the scene has none.
#[derive(Debug, Default)]
pub struct LightGroups {
    /// Of the scene's lights.
    lights: Vec<Option<usize>>,
    /// Of the instances with triangles, as the world counts objects.
    surfaces: Vec<Option<usize>>,
    environment: Option<usize>,
}

impl LightGroups {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Self {
        if scene.light_groups.is_empty() {
            return Self::default();
        }
        let names = scene.light_groups.iter().map(String::as_str);
        let numbers: HashMap<&str, usize> = names.zip(0..).collect();
        let number = |links: &Links| numbers.get(links.group.as_deref()?).copied();
        let lights = scene.lights.iter().map(|light| number(&light.links));
        let surfaces = scene.instances.iter();
        let surfaces = surfaces.filter(|instance| scene.has_triangles(instance));
        let environment = scene.environment.as_ref();
        Self {
            lights: lights.collect(),
            surfaces: surfaces
                .map(|instance| number(&instance.info.links))
                .collect(),
            environment: environment.and_then(|environment| number(&environment.links)),
        }
    }

    /// The group of a light; lamps and suns by their number among the scene's lights.
    pub fn of_source(&self, source: Source, in_scene: Option<u32>) -> Option<usize> {
        match source {
            Source::Surface(number) => *self.surfaces.get(number as usize)?,
            Source::Lamp(_) | Source::Sun(_) => *self.lights.get(in_scene? as usize)?,
            Source::Environment => self.environment,
        }
    }
}
