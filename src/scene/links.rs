//! What a file says belongs together among lights and objects: light groups, and who is lit and shaded by whom.

use super::{Instance, MaterialId, MeshId, RayKind, Scene, Visibility};
use std::collections::HashSet;
use std::sync::Arc;

/// What a light or an object belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct Links {
    /// Its light group.
    pub group: Option<Arc<str>>,
    /// Of what shines: the sets of objects that it lights, by their bits.
    pub lit_sets: u64,
    /// The sets of objects that cast its shadows.
    pub shadow_sets: u64,
    /// Of an object: the set in which lights find it …
    pub receiver_set: u8,
    /// … and the set in which shadows do.
    pub blocker_set: u8,
    /// Of an object: it is a shadow catcher (else it is not). Of a light: it lights shadow catchers alone, too (else it does).
    pub shadow_catcher: Option<bool>,
}

impl Default for Links {
    /// All lights all, and all casts shadows.
    fn default() -> Self {
        Self {
            group: None,
            lit_sets: u64::MAX,
            shadow_sets: u64::MAX,
            receiver_set: 0,
            blocker_set: 0,
            shadow_catcher: None,
        }
    }
}

impl Links {
    /// Receivers may be in so many sets, as in Cycles.
    pub const RECEIVER_SETS: u8 = 64;
    /// Blockers may be in so many: Embree's masks have 32 bits, of which kinds of rays and the two below take some.
    pub const BLOCKER_SETS: u8 = 24;
    /// Bit of the surfaces that shine and have blockers of their own, in Embree's masks.
    pub const SHADOW_LINKED: u32 = 1 << 31;
    /// A bit that no surface has.
    const NOTHING: u32 = 1 << 30;
    const FIRST_BLOCKER: usize = RayKind::ALL.len();

    /// Whether it is a light that does not light all, or of which not all cast shadows.
    pub fn is_linked(&self) -> bool {
        (self.lit_sets & self.shadow_sets) != u64::MAX
    }

    /// Mask of the rays that look for its blockers, if those are not all objects.
    pub fn mask_of_blockers(&self) -> Option<u32> {
        let sets = (1 << Self::BLOCKER_SETS) - 1;
        let mask = ((self.shadow_sets & sets) as u32) << Self::FIRST_BLOCKER;
        (self.shadow_sets != u64::MAX).then_some(mask | Self::NOTHING)
    }

    /// What Embree's mask of an object has besides the rays that see it.
    pub fn mask(&self, visibility: Visibility) -> u32 {
        let blocks = u32::from(visibility.sees(RayKind::Shadow));
        let shines = u32::from(self.shadow_sets != u64::MAX) * Self::SHADOW_LINKED;
        shines | blocks << (Self::FIRST_BLOCKER + usize::from(self.blocker_set))
    }
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
        let mut known = HashSet::new();
        let mut group = |name: &str| -> Option<Arc<str>> {
            if known.insert(name.to_owned()) {
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
