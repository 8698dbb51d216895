//! Which material a prim is bound to: its own, that of a collection it is in, or that of what it stands below.

use std::rc::Rc;

use openusd::sdf::Path;
use openusd::usd;

use super::collections;
use super::source::{Source, View};
use crate::scene::{Diagnostics, Verdict};

/// Purposes of bindings, the one that counts first. A preview is better than nothing.
const PURPOSES: [&str; 3] = ["full", "", "preview"];

/// A material, and whether it wins over those of descendants.
#[derive(Clone, Debug)]
struct Bound {
    material: Path,
    stronger: bool,
}

/// Bindings that stand on one prim.
pub(super) struct Level {
    above: Option<Rc<Level>>,
    direct: [Option<Bound>; 3],
    collections: Vec<(usize, usd::MembershipQuery, Bound)>,
}

/// The bindings of a prim and of what it stands below.
pub(super) type Bindings = Option<Rc<Level>>;

/// Adds a prim's own bindings to those of its parent.
pub(super) fn below(source: &Source, above: &Bindings, prim: &View) -> Bindings {
    let mut names: Vec<&String> = prim.names.iter().collect();
    names.retain(|name| name.starts_with("material:binding"));
    if names.is_empty() {
        return above.clone();
    }
    names.sort();
    let mut level = Level {
        above: above.clone(),
        direct: [const { None }; 3],
        collections: Vec::new(),
    };
    for name in names {
        let targets = prim.targets(name);
        let stronger = prim.property_word(name, "bindMaterialAs").as_deref()
            == Some("strongerThanDescendants");
        let rest = name.strip_prefix("material:binding").unwrap_or_default();
        let parts: Vec<&str> = rest.split(':').skip(1).collect();
        match (parts.as_slice(), targets.as_slice()) {
            (["collection", rest @ ..], [collection, material]) => {
                let purpose = match rest {
                    [purpose, _] => *purpose,
                    _ => "",
                };
                let query = collections::of_path(collection)
                    .and_then(|collection| collections::members(source, &collection));
                let place = PURPOSES.iter().position(|p| *p == purpose);
                if let (Some(query), Some(place)) = (query, place) {
                    let material = material.clone();
                    level
                        .collections
                        .push((place, query, Bound { material, stronger }));
                }
            }
            ([] | [_], [material, ..]) => {
                let purpose = parts.first().copied().unwrap_or_default();
                if let Some(place) = PURPOSES.iter().position(|p| *p == purpose) {
                    let material = material.clone();
                    level.direct[place] = Some(Bound { material, stronger });
                }
            }
            _ => {}
        }
    }
    Some(Rc::new(level))
}

/// Names the collections of a prim's bindings that have members by expressions.
pub(super) fn report(source: &Source, prim: &View, diagnostics: &mut Diagnostics) {
    let bound = prim.names.iter();
    for name in bound.filter(|name| name.starts_with("material:binding:collection")) {
        let targets = prim.targets(name);
        if targets
            .iter()
            .any(|path| collections::has_expression(source, path))
        {
            diagnostics.report(
                "usd-binding",
                Verdict::Lost,
                "materials bound to collections by expressions",
                prim.path().to_string(),
                "the lists of their collections count alone",
            );
        }
    }
}

/// The materials that a prim may show, the one that counts first: where it has no known surface, the next one is better than none.
pub(super) fn materials(bindings: &Bindings, prim: &Path) -> Vec<Path> {
    let mut all: Vec<Path> = Vec::new();
    for purpose in 0..PURPOSES.len() {
        let mut winner: Option<&Bound> = None;
        let mut level = bindings.as_deref();
        while let Some(here) = level {
            let mut collections = here.collections.iter();
            let collected =
                collections.find(|(of, query, _)| *of == purpose && query.is_path_included(prim));
            let bound = collected.map(|(.., bound)| bound);
            if let Some(bound) = bound.or(here.direct[purpose].as_ref())
                && (winner.is_none() || bound.stronger)
            {
                winner = Some(bound);
            }
            level = here.above.as_deref();
        }
        let found = winner.map(|bound| bound.material.clone());
        all.extend(found.filter(|path| !all.contains(path)));
    }
    all
}
