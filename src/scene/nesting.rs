//! Priorities of solids that overlap, as materials state them.

use super::graph::SolidIndex;
use super::{Diagnostics, Effect, Material, Verdict};

impl Material {
    /// Its priority among solids that overlap and what they refract by, if it takes part. What shines does not: light sampling
    /// would find it where it is not.
    pub fn nested(&self) -> Option<(i32, SolidIndex)> {
        let priority = self.priority?;
        let index = self.graph.solid_index()?;
        (!self.emits()).then_some((priority, index))
    }
}

/// Tells what a priority cannot say of its material.
pub(super) fn clean(material: &mut Material, diagnostics: &mut Diagnostics) {
    if material.priority.is_none() {
        return;
    }
    let (verdict, feature, instead) = match material.nested() {
        Some((_, index)) if index.varies() => (
            Verdict::Approximated,
            "priority of a solid whose index of refraction varies",
            "what overlaps with it is refracted as if the index were the same everywhere",
        ),
        Some(_) => return,
        None => {
            material.priority = None;
            (
                Verdict::Lost,
                "priority of a material that bounds no solid, or shines",
                "it takes no part in the order of overlapping solids",
            )
        }
    };
    let (effect, code) = (Effect::NestedDielectrics, "nesting");
    diagnostics.report_effect(effect, code, verdict, feature, &material.name, instead);
}
