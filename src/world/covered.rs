//! What lies over a Principled BSDF's base at a point, and the light that the base sends through it.

use crate::scene::graph::function::PlaceInput;
use crate::shading::layers::{Coat, Fibres, Layers};
use crate::shading::program::{Covered, Evaluation, LayerRoots, Place, Shining, reflected};
use glam::Vec3;

/// What lies over a base. `side` makes the coat's normal of that of its map.
pub(super) fn layers_at<P: Place>(
    roots: &LayerRoots,
    (normal, side): (Vec3, &dyn Fn(Vec3) -> Vec3),
    at: &mut Evaluation<'_, P>,
) -> Layers {
    let coat = roots.coat.as_ref().map(|coat| Coat {
        weight: at.number(&coat.weight),
        roughness: at.number(&coat.roughness).clamp(0.0, 1.0),
        ior: at.number(&coat.ior).max(1.0),
        tint: reflected(at.color(&coat.tint)),
        normal: match &coat.normal {
            Some(map) => side(at.color(map)),
            None => normal,
        },
    });
    let fibres = roots
        .fibres
        .as_ref()
        .map(|[weight, roughness, tint]| Fibres {
            weight: at.number(weight),
            roughness: at.number(roughness),
            tint: reflected(at.color(tint)),
        });
    Layers {
        coat,
        fibres,
        rules: roots.rules,
    }
}

/// Emitted radiance at a place, of which layers keep a part by the angle of view, as in Cycles.
#[cold]
#[inline(never)]
pub(super) fn emitted<P: Place>(shining: &Shining, place: &P, at: &mut Evaluation<'_, P>) -> Vec3 {
    // All directions have Blender's axes here: only their angles count.
    let wo = place.input(PlaceInput::Incoming).truncate();
    let side = |outside: Vec3| place.facing(outside).normalize_or_zero();
    let mut sum = at.color(&shining.open);
    for covered in &shining.covered {
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
        let layers = layers_at(layers, (normal, &side), at);
        sum += light * layers.transmittance(normal, wo);
    }
    sum
}
