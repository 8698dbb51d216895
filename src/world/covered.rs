//! What lies over a Principled BSDF's base at a point, and the light that the base sends through it.

use super::material::{Preparer, tables_of};
use crate::scene::graph::function::PlaceInput;
use crate::shading::Dielectrics;
use crate::shading::dielectrics::Needs;
use crate::shading::layers::{Coat, Fibres, Layers};
use crate::shading::program::{Covered, Emission, Evaluation, LayerRoots, Place, Root, reflected};
use crate::shading::tables::Rows;
use glam::Vec3;
use std::sync::Arc;

impl Preparer {
    /// Tables of a coat.
    pub(super) fn coat(&self, layers: &LayerRoots) -> Option<Arc<Dielectrics>> {
        let coat = layers.coat.as_ref()?;
        let number = |root: &Root| root.constant().map(|c| c.x);
        let (roughness, ior) = (number(&coat.roughness), number(&coat.ior).unwrap_or(1.5));
        let rows = Rows::between(
            roughness.unwrap_or(0.0),
            roughness.filter(|_| !self.roughens()).unwrap_or(1.0),
        );
        // Of linked ones nobody knows the greatest.
        let ends = match coat.ior.constant() {
            Some(_) => (ior, ior),
            None => (1.0, f32::INFINITY),
        };
        let layer = (ends.1 > 1.0).then(|| Needs::layer_indices(ends, (1.0, 1.0)));
        Some(tables_of(Needs {
            layer,
            solid: None,
            rows,
        }))
    }
}

/// What lies over a base, with the tables of its coat. `side` makes the coat's normal of that of its map.
pub(super) fn layers_at<'a, P: Place>(
    roots: &LayerRoots,
    tables: Option<&'a Dielectrics>,
    (normal, side): (Vec3, &dyn Fn(Vec3) -> Vec3),
    at: &mut Evaluation<'_, P>,
) -> Layers<'a> {
    let coat = roots.coat.as_ref().zip(tables).map(|(coat, tables)| Coat {
        weight: at.number(&coat.weight),
        roughness: at.number(&coat.roughness).clamp(0.0, 1.0),
        ior: at.number(&coat.ior).max(1.0),
        tint: reflected(at.color(&coat.tint)),
        normal: match &coat.normal {
            Some(map) => side(at.color(map)),
            None => normal,
        },
        tables,
    });
    let fibres = roots
        .fibres
        .as_ref()
        .map(|[weight, roughness, tint]| Fibres {
            weight: at.number(weight),
            roughness: at.number(roughness),
            tint: reflected(at.color(tint)),
        });
    Layers { coat, fibres }
}

/// Emitted radiance at a place, of which layers keep a part by the angle of view, as in Cycles.
#[cold]
#[inline(never)]
pub(super) fn emitted(
    emission: &Emission,
    coats: &[Option<Arc<Dielectrics>>],
    place: &impl Place,
) -> Vec3 {
    // All directions have Blender's axes here: only their angles count.
    let wo = place.input(PlaceInput::Incoming).truncate();
    let side = |outside: Vec3| place.facing(outside).normalize_or_zero();
    emission.program.at(place, |at| {
        let mut sum = at.color(&emission.open);
        for (covered, coat) in emission.covered.iter().zip(coats) {
            let Covered {
                light,
                normal,
                layers,
            } = covered;
            let light = at.color(light);
            if light == Vec3::ZERO {
                continue;
            }
            let map = normal.as_ref().map_or(Vec3::ZERO, |root| at.color(root));
            let normal = side(map);
            let layers = layers_at(layers, coat.as_deref(), (normal, &side), at);
            sum += light * layers.transmittance(normal, wo);
        }
        sum
    })
}
