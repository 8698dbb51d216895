//! Variants: the selections that a stage has, and one that is made.

use super::source::{Source, one_line};
use crate::import::ImportError;
use openusd::sdf::{self, Path, Value};
use std::collections::{BTreeMap, HashSet};

/// Variants in variants: no file has them deeper.
const MOST_LOOKS: usize = 32;
/// More prims than this are not asked for variants.
const MOST_ASKED: usize = 100_000;

/// Those that can be selected, as `set=name`.
pub(super) fn names(source: &Source) -> Vec<String> {
    let has_some = source.stage.layer_identifiers().iter().any(|layer| {
        let Some(layer) = source.stage.layer(layer) else {
            return false;
        };
        let data = layer.data();
        let is_set = |path| data.spec_type(path) == Some(sdf::SpecType::VariantSet);
        data.spec_paths().iter().any(is_set)
    });
    if has_some {
        listed(&sets(source))
    } else {
        Vec::new()
    }
}

fn listed(sets: &[(Path, String, Vec<String>)]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (_, set, variants) in sets {
        for variant in variants {
            let name = format!("{set}={variant}");
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

/// Makes the wanted selections: `set=name`, with commas between them.
///
/// What is chosen may bring sets of its own: the stage is looked at again until there is nothing new to choose.
pub(super) fn choose(source: &Source, wanted: &str) -> Result<(), ImportError> {
    let wishes: Vec<Wish> = wanted.split(',').map(Wish::of).collect();
    let mut chosen: HashSet<(Path, String)> = HashSet::new();
    let mut fulfilled = vec![false; wishes.len()];
    let mut seen = sets(source);
    for _ in 0..MOST_LOOKS {
        let mut new = false;
        for (path, set, variants) in &seen {
            for (wish, fulfilled) in wishes.iter().zip(&mut fulfilled) {
                let fits = wish.set.is_none_or(|of| of == set)
                    && variants.iter().any(|v| v == wish.variant);
                if fits && chosen.insert((path.clone(), set.clone())) {
                    select(source, path, set, wish.variant)?;
                    new = true;
                }
                *fulfilled |= fits;
            }
        }
        if !new {
            break;
        }
        seen = sets(source);
    }
    let missing = wishes.iter().zip(fulfilled).find(|(_, done)| !done);
    let Some((wish, _)) = missing else {
        return Ok(());
    };
    let there = match listed(&seen).as_slice() {
        [] => "the file has no variants".into(),
        names => format!("there are: {}", names.join(", ")),
    };
    Err(ImportError::malformed(
        &source.file,
        format!("variant \"{}\"", wish.told),
        format!("there is no such variant; {there}"),
    ))
}

/// A wanted selection.
struct Wish<'a> {
    told: &'a str,
    /// Without, any set that has the variant.
    set: Option<&'a str>,
    variant: &'a str,
}

impl<'a> Wish<'a> {
    fn of(told: &'a str) -> Self {
        let (set, variant) = match told.split_once('=') {
            Some((set, variant)) => (Some(set.trim()), variant.trim()),
            None => (None, told.trim()),
        };
        Self { told, set, variant }
    }
}

/// Selects a variant in the root layer, as it is in memory.
fn select(source: &Source, path: &Path, set: &str, variant: &str) -> Result<(), ImportError> {
    let field = sdf::FieldKey::VariantSelection.as_str();
    let prim = source.stage.override_prim(path.clone());
    let done = prim.and_then(|prim| {
        prim.update_metadata(field, |old| {
            let mut map = match old {
                Some(Value::VariantSelectionMap(map)) => map,
                _ => Default::default(),
            };
            map.insert(set.into(), variant.into());
            Value::VariantSelectionMap(map)
        })
    });
    done.map(drop).map_err(|error| {
        ImportError::malformed(
            &source.file,
            path.to_string(),
            format!("the variant cannot be chosen: {}", one_line(&error)),
        )
    })
}

/// The variant sets of the stage: prim, set and variants.
fn sets(source: &Source) -> Vec<(Path, String, Vec<String>)> {
    let mut found = Vec::new();
    let mut open = vec![Path::abs_root()];
    let mut asked = 0;
    while let Some(path) = open.pop() {
        asked += 1;
        if asked > MOST_ASKED {
            break;
        }
        let prim = source.stage.prim(path.clone());
        if !path.is_abs_root() {
            for (set, variants) in of(source, &path) {
                found.push((path.clone(), set, variants));
            }
        }
        // Instances share what they have; the sets inside are not listed.
        let instance = !path.is_abs_root() && prim.is_instance().unwrap_or(false);
        if !instance {
            let children = prim.children().unwrap_or_default();
            open.extend(children.iter().rev().map(|child| child.path().clone()));
        }
    }
    found
}

/// The variant sets of a prim, from all places that it is composed of.
fn of(source: &Source, path: &Path) -> BTreeMap<String, Vec<String>> {
    let mut sets: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let stack = source.stage.prim(path.clone()).prim_stack();
    for (layer, site) in stack.unwrap_or_default() {
        let Some(layer) = source.stage.layer(&layer) else {
            continue;
        };
        let data = layer.data();
        let field = |path: &Path, name: &str| data.try_field(path, name).ok().flatten();
        let Some(names) = field(&site, sdf::ChildrenKey::VariantSetChildren.as_str()) else {
            continue;
        };
        for set in super::value::words(&names) {
            let place = site.append_variant_selection(&set, "");
            let variants = field(&place, sdf::ChildrenKey::VariantChildren.as_str());
            let variants = variants
                .map(|v| super::value::words(&v))
                .unwrap_or_default();
            let list = sets.entry(set).or_default();
            for variant in variants {
                if !list.contains(&variant) {
                    list.push(variant);
                }
            }
        }
    }
    sets
}
