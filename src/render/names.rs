//! Names of what a path meets, as the scene has them; and of what was not finite.

use super::trace::{Job, Recorded};
use crate::integrator::{Fault, first_fault};
use crate::scene::Scene;
use crate::world::Source;

/// The instances with triangles: what the world counts as objects.
pub(super) fn objects(scene: &Scene) -> Vec<u32> {
    let placed = scene.instances.iter().enumerate();
    placed
        .filter(|(_, instance)| scene.has_triangles(instance))
        .map(|(number, _)| number as u32)
        .collect()
}

fn quoted(name: &str) -> String {
    format!("\"{name}\"")
}

impl Job<'_> {
    /// The name of an object, by its number among those with triangles.
    pub fn object(&self, number: u32) -> String {
        let objects = self.objects.get_or_init(|| objects(self.scene));
        let instance = objects.get(number as usize);
        let instance = instance.and_then(|&i| self.scene.instances.get(i as usize));
        quoted(instance.map_or("", |instance| &instance.name))
    }

    /// The name of an object's material.
    pub fn material(&self, object: u32) -> String {
        let number = self.world.material_of(object);
        let material = number.and_then(|number| self.scene.materials.get(number as usize));
        material.map_or("the default".into(), |material| quoted(&material.name))
    }

    /// What shines.
    pub fn source(&self, source: Source) -> String {
        let light = || {
            let number = self.world.lights.number_in_scene(source);
            let light = number.and_then(|number| self.scene.lights.get(number as usize));
            quoted(light.map_or("", |light| &light.name))
        };
        match source {
            Source::Surface(object) => format!("material {}", self.material(object)),
            Source::Lamp(_) => format!("light {}", light()),
            Source::Sun(_) => format!("sun {}", light()),
            Source::Environment => "the environment".into(),
        }
    }

    /// What was not finite first in a path that is not.
    pub fn cause(&self, recorded: &Recorded) -> String {
        let finite = recorded.path.radiance.is_finite();
        if finite && recorded.path.first.is_finite() {
            return "a kernel other than the general one, or a pass".into();
        }
        let fault = first_fault(&recorded.steps);
        if finite && fault == Fault::Sum {
            return "normal or albedo of what the camera sees".into();
        }
        let at = |what: &str, object| format!("{what} object {}", self.object(object));
        let of = |what: &str, source| format!("{what} {}", self.source(source));
        match fault {
            Fault::CameraRay => "camera ray".into(),
            Fault::Point(object) => at("position on", object),
            Fault::Normal(object) => at("normal of", object),
            Fault::Radiance(source) => of("radiance of", source),
            Fault::Density(source) => of("density of light samples of", source),
            Fault::LightSample(source) => of("radiance over density of", source),
            Fault::Bsdf(object) => at("BSDF of", object),
            Fault::BsdfSample(object) => at("BSDF sample of", object),
            Fault::Throughput(object) => at("throughput behind", object),
            Fault::Contribution(source) => of("throughput times radiance of", source),
            Fault::Sum => "sum of finite contributions".into(),
        }
    }
}
