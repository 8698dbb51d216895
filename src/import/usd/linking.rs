//! Light linking and shadow linking: which prims a light is for, by its collections.

use std::collections::{BTreeMap, HashMap};

use openusd::sdf::Path;
use openusd::usd::{self, PathRule};

use super::collections;
use super::source::{Source, View};
use crate::scene::{Diagnostics, Links, Scene, Verdict};

/// Which prims belong to a light; all of them where there is nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Linked {
    /// Those that it lights …
    light: Option<usd::MembershipQuery>,
    /// … and those that cast its shadows.
    shadow: Option<usd::MembershipQuery>,
}

impl Linked {
    /// The collections of a light.
    pub(super) fn of(prim: &View, source: &Source, diagnostics: &mut Diagnostics) -> Self {
        Self {
            light: members(prim, "lightLink", source, diagnostics),
            shadow: members(prim, "shadowLink", source, diagnostics),
        }
    }

    pub(super) fn is_all(&self) -> bool {
        self.light.is_none() && self.shadow.is_none()
    }
}

fn members(
    prim: &View,
    name: &str,
    source: &Source,
    diagnostics: &mut Diagnostics,
) -> Option<usd::MembershipQuery> {
    let expression = prim.word(&format!("collection:{name}:membershipExpression"));
    if expression.is_some_and(|expression| !expression.is_empty()) {
        diagnostics.report(
            "light-linking",
            Verdict::Lost,
            "lights linked by expressions",
            prim.path().to_string(),
            "the lists of their collections count alone",
        );
    }
    // Collections of lights have all, if they do not say otherwise.
    let all = prim.truth(&format!("collection:{name}:includeRoot")) != Some(false);
    let excludes = prim.targets(&format!("collection:{name}:excludes"));
    if all && excludes.is_empty() {
        return None;
    }
    let collection = usd::Collection::new(prim.path().clone(), name);
    let query = collections::members(source, &collection)?;
    let mut rules = query.rule_map().clone();
    if all {
        rules
            .entry(Path::abs_root())
            .or_insert(PathRule::ExpandPrims);
    }
    Some(usd::MembershipQuery::new(rules))
}

/// What a lamp has become.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shines {
    Light(usize),
    Instance(usize),
    Environment,
}

/// Puts the objects into sets, and tells the lights which of them they are for. `paths` are those of the instances.
pub(super) fn link(
    scene: &mut Scene,
    lamps: &[(Shines, Linked)],
    paths: &[Path],
    diagnostics: &mut Diagnostics,
) {
    for lights in [true, false] {
        let (most, what) = if lights {
            (Links::RECEIVER_SETS, "light")
        } else {
            (Links::BLOCKER_SETS, "cast shadows of")
        };
        let of = |linked: &'_ Linked| {
            let query = if lights {
                &linked.light
            } else {
                &linked.shadow
            };
            query.clone()
        };
        let queries: Vec<_> = lamps.iter().filter_map(|(_, linked)| of(linked)).collect();
        if queries.is_empty() {
            continue;
        }
        // Objects that belong to the same lights are one set.
        let mut sets: BTreeMap<Vec<bool>, usize> = BTreeMap::new();
        let mut known: HashMap<&Path, usize> = HashMap::new();
        let set_of = |path| {
            *known.entry(path).or_insert_with(|| {
                let in_which = queries.iter().map(|query| query.is_path_included(path));
                let next = sets.len();
                *sets.entry(in_which.collect()).or_insert(next)
            })
        };
        let set_of: Vec<usize> = paths.iter().map(set_of).collect();
        if sets.len() > usize::from(most) {
            diagnostics.report(
                "light-linking",
                Verdict::Lost,
                format!("lights that {what} some objects only, in more than {most} ways"),
                "",
                format!("they {what} all objects"),
            );
            continue;
        }
        for (instance, set) in scene.instances.iter_mut().zip(set_of) {
            let links = &mut instance.info.links;
            if lights {
                links.receiver_set = set as u8;
            } else {
                links.blocker_set = set as u8;
            }
        }
        let linked = lamps.iter().filter(|(_, linked)| of(linked).is_some());
        for (at, (shines, _)) in linked.enumerate() {
            let bits = sets.iter().filter(|(in_which, _)| in_which[at]);
            let bits = bits.fold(0u64, |bits, (_, set)| bits | 1 << set);
            let links = match *shines {
                Shines::Light(light) => scene.lights.get_mut(light).map(|l| &mut l.links),
                Shines::Instance(at) => scene.instances.get_mut(at).map(|i| &mut i.info.links),
                Shines::Environment => scene.environment.as_mut().map(|e| &mut e.links),
            };
            if let Some(links) = links {
                if lights {
                    links.lit_sets = bits;
                } else {
                    links.shadow_sets = bits;
                }
            }
        }
    }
}
