//! Many of a kind: point instancers, and points as spheres.

use std::collections::HashSet;
use std::rc::Rc;

use glam::{DAffine3, DQuat};
use openusd::sdf::Value;

use super::skeleton::Binding;
use super::source::View;
use super::walk::{Inherited, Item, Thing, Walk};
use super::{transform, value};
use crate::import::ImportError;
use crate::scene::Verdict;

/// Places the instances of a point instancer.
pub(super) fn of_instancer(
    walk: &mut Walk,
    prim: &View,
    inherited: &Inherited,
    items: &mut Vec<Item>,
) -> Result<(), ImportError> {
    let path = prim.path().clone();
    let positions = prim.value("positions").as_ref().and_then(value::points);
    let (Some(positions), Some(indices)) = (positions, prim.integers("protoIndices")) else {
        return Ok(());
    };
    let turns = prim.value_of(&["orientationsf", "orientations"]);
    let turns = turns.as_ref().and_then(value::rotations);
    let scales = prim.value("scales").as_ref().and_then(value::points);
    let hidden = hidden(walk, prim, indices.len());
    let colors = colors(prim, indices.len());
    let mut prototypes = Vec::new();
    for target in prim.targets("prototypes") {
        let mut from = inherited.clone();
        from.matrix = DAffine3::IDENTITY;
        from.absolute = false;
        from.object = None;
        from.skin = Binding::default();
        from.object_colors |= !colors.is_empty();
        from.bindings = walk.bindings_above(&target);
        let found = walk.prototype(target.to_string(), &target, true, from)?;
        prototypes.push(found);
    }
    if !colors.is_empty() {
        let all = prototypes.iter().flat_map(|found| found.iter());
        tell_of_colors(walk, prim, all.map(|item| item.thing).collect());
    }
    let mut report = |what: &str, instead: &str| {
        walk.diagnostics.report(
            "usd-instances",
            Verdict::Lost,
            what,
            path.to_string(),
            instead,
        );
    };
    if positions.len() != indices.len() {
        report(
            "point instancer with other numbers of positions and of prototypes",
            "as many are placed as have both",
        );
    }
    let exists = |index: &i64| usize::try_from(*index).is_ok_and(|i| i < prototypes.len());
    if !indices.iter().all(exists) {
        report("instances of prototypes that do not exist", "left out");
    }
    for (at, (position, index)) in positions.iter().zip(&indices).enumerate() {
        if hidden.get(at) == Some(&true) {
            continue;
        }
        let turn = turns.as_ref().and_then(|turns| turns.get(at));
        let scale = scales.as_ref().and_then(|scales| scales.get(at));
        let local = transform::of_instance(
            *position,
            turn.copied().unwrap_or(DQuat::IDENTITY),
            scale.copied().unwrap_or([1.0; 3]),
        );
        let prototype = usize::try_from(*index).ok().and_then(|i| prototypes.get(i));
        let Some(found) = prototype else {
            continue;
        };
        let place = (&(inherited.matrix * local), inherited.absolute);
        walk.push_all(found, place, (&path, colors.get(at).copied()), items)?;
    }
    Ok(())
}

/// Names colours of instances that do not reach their materials.
fn tell_of_colors(walk: &mut Walk, prim: &View, things: Vec<Thing>) {
    let coloured = |thing: &Thing| match thing {
        Thing::Shape(shape) => walk.shapes.is_coloured(*shape),
        _ => true,
    };
    if !things.iter().all(coloured) {
        walk.diagnostics.report(
            "usd-instance-colour",
            Verdict::Lost,
            "colours of instances on prototypes with materials or colours of their own",
            prim.path().to_string(),
            "each of them looks as its prototype",
        );
    }
}

/// Colour and opacity of each instance or point, if they have some.
fn colors(prim: &View, count: usize) -> Vec<[f32; 4]> {
    let list = |name: &str, components: usize| -> Option<Vec<[f32; 3]>> {
        let (found, values) = value::floats(&prim.value(name)?)?;
        let single = prim.property_word(name, "interpolation");
        let constant = matches!(single.as_deref(), None | Some("constant"));
        if found != components || (constant && values.len() != components * count) {
            return None;
        }
        let held = values.len() / components;
        let indices = prim.integers(&format!("{name}:indices"));
        let indices = indices.unwrap_or_else(|| (0..held as i64).collect());
        let one = indices.iter().map(|i| {
            let start = usize::try_from(*i).ok()?.checked_mul(components)?;
            let value = values.get(start..start.checked_add(components)?)?;
            Some([0, 1, 2].map(|at| value.get(at).copied().unwrap_or(0.0).clamp(0.0, 1.0)))
        });
        let all: Vec<[f32; 3]> = one.collect::<Option<_>>()?;
        (all.len() == count && count > 1).then_some(all)
    };
    let colors = list("primvars:displayColor", 3);
    let opacities = list("primvars:displayOpacity", 1);
    if colors.is_none() && opacities.is_none() {
        return Vec::new();
    }
    let finite = |v: f32| if v.is_nan() { 0.0 } else { v };
    let one = (0..count).map(|at| {
        let [r, g, b] = colors.as_ref().map_or([1.0; 3], |all| all[at]).map(finite);
        let alpha = opacities.as_ref().map_or(1.0, |all| finite(all[at][0]));
        [r, g, b, alpha]
    });
    one.collect()
}

/// Which instances are not to be seen: for the time being, or not at all.
fn hidden(walk: &Walk, prim: &View, count: usize) -> Vec<bool> {
    let mut gone: HashSet<i64> = HashSet::new();
    gone.extend(prim.integers("invisibleIds").unwrap_or_default());
    gone.extend(inactive(walk, prim));
    if gone.is_empty() {
        return Vec::new();
    }
    let ids = prim.integers("ids");
    let id = |at: usize| match &ids {
        Some(ids) => ids.get(at).copied(),
        None => i64::try_from(at).ok(),
    };
    let one = (0..count).map(|at| id(at).is_some_and(|id| gone.contains(&id)));
    one.collect()
}

/// Ids in the metadata of a prim, in which each layer adds to those of weaker ones, or takes from them.
fn inactive(walk: &Walk, prim: &View) -> Vec<i64> {
    let stack = walk.source.told(prim.path(), prim.prim.prim_stack());
    let mut ids = Vec::new();
    for (layer, site) in stack.unwrap_or_default().iter().rev() {
        let Some(layer) = walk.source.stage.layer(layer) else {
            continue;
        };
        let field = layer.data().try_field(site, "inactiveIds");
        match field.ok().flatten().as_deref() {
            Some(Value::Int64ListOp(op)) => ids = op.compose_over(&ids),
            Some(Value::IntListOp(op)) => {
                ids = op.clone().map(i64::from).compose_over(&ids);
            }
            // A list without a word on what it does replaces others.
            Some(value) => ids = value::integers(value).unwrap_or(ids),
            None => {}
        }
    }
    ids
}

/// Places a sphere for each point.
pub(super) fn of_points(
    walk: &mut Walk,
    prim: &View,
    inherited: &Inherited,
    items: &mut Vec<Item>,
) -> Result<(), ImportError> {
    let Some(points) = prim.value("points").as_ref().and_then(value::points) else {
        return Ok(());
    };
    let colors = colors(prim, points.len());
    let mut from = inherited.clone();
    from.object_colors = !colors.is_empty();
    let name: Rc<str> = prim.name().into();
    let shape = walk
        .shapes
        .load(prim, "Points", &from, &name, walk.diagnostics)?;
    let Some(shape) = shape else {
        return Ok(());
    };
    let widths = prim.value_of(&["widths", "primvars:widths"]);
    let widths = widths.as_ref().and_then(value::floats).map(|(_, v)| v);
    let mut report = |verdict, what: &str, instead: &str| {
        let path = prim.path().to_string();
        walk.diagnostics
            .report("usd-points", verdict, what, path, instead);
    };
    if widths.is_none() {
        report(
            Verdict::Approximated,
            "points without widths",
            "they are one unit wide",
        );
    }
    if prim.has("normals") {
        report(
            Verdict::Lost,
            "normals of points",
            "they are spheres and not disks",
        );
    }
    if !colors.is_empty() {
        tell_of_colors(walk, prim, vec![Thing::Shape(shape.number)]);
    }
    let widths = widths.unwrap_or_else(|| vec![1.0]);
    for (at, point) in points.iter().enumerate() {
        let width = widths.get(if widths.len() == 1 { 0 } else { at }).copied();
        let radius = 0.5 * width.unwrap_or(0.0);
        // Nothing is seen of those without a size.
        if radius > 0.0 && radius.is_finite() && point.iter().all(|v| v.is_finite()) {
            let local = transform::of_instance(*point, DQuat::IDENTITY, [radius; 3]);
            let color = colors.get(at).copied();
            let called = (shape.number, name.clone());
            let item = Item::of_point(called, inherited, &local, (prim.path(), color));
            walk.push(item, items)?;
        }
    }
    Ok(())
}
