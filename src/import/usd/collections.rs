//! UsdCollectionAPI: which prims a collection has.

use std::collections::HashSet;

use openusd::sdf::Path;
use openusd::usd::{Collection, ExpansionRule, MembershipQuery, PathExpansionRuleMap, PathRule};

use super::source::Source;

/// What stands before a collection's name.
const NAMESPACE: &str = "collection:";

/// The collection at a path `prim.collection:name`. Names may have colons in them, which the library's own does not take.
pub(super) fn of_path(path: &Path) -> Option<Collection> {
    let (prim, name) = parts(path)?;
    Some(Collection::new(prim, name))
}

fn parts(path: &Path) -> Option<(Path, String)> {
    let (prim, property) = path.split_property()?;
    let name = property.strip_prefix(NAMESPACE)?;
    let is_name = !name.is_empty() && name.split(':').all(Path::is_valid_identifier);
    is_name.then(|| (prim, name.to_owned()))
}

/// Whether a collection has members by an expression, which is not read.
pub(super) fn has_expression(source: &Source, path: &Path) -> bool {
    let expression = parts(path).and_then(|(prim, name)| {
        let prim = source.view(&prim);
        prim.word(&format!("{NAMESPACE}{name}:membershipExpression"))
    });
    expression.is_some_and(|expression| !expression.is_empty())
}

/// The prims of a collection, by its lists (the specification's "relationship mode").
pub(super) fn members(source: &Source, collection: &Collection) -> Option<MembershipQuery> {
    let mut rules = PathExpansionRuleMap::new();
    let mut seen = HashSet::new();
    collect(source, collection, &mut rules, &mut seen)?;
    Some(MembershipQuery::new(rules))
}

/// Adds a collection's rules, with those of the collections that it includes. Its own excludes come last, and win.
fn collect(
    source: &Source,
    collection: &Collection,
    rules: &mut PathExpansionRuleMap,
    seen: &mut HashSet<Path>,
) -> Option<()> {
    let stage = &source.stage;
    let path = collection.collection_path().ok()?;
    if !seen.insert(path.clone()) {
        return Some(());
    }
    let expansion = source.told(&path, collection.expansion_rule(stage))?;
    let rule = match expansion {
        ExpansionRule::ExplicitOnly => PathRule::ExplicitOnly,
        ExpansionRule::ExpandPrimsAndProperties => PathRule::ExpandPrimsAndProperties,
        _ => PathRule::ExpandPrims,
    };
    let whole = source.told(&path, collection.include_root(stage))?;
    if whole && rule != PathRule::ExplicitOnly {
        rules.insert(Path::abs_root(), rule);
    }
    for included in source.told(&path, collection.includes(stage))? {
        match of_path(&included) {
            Some(inner) => collect(source, &inner, rules, seen)?,
            None => {
                rules.insert(included, rule);
            }
        }
    }
    for excluded in source.told(&path, collection.excludes(stage))? {
        rules.insert(excluded, PathRule::Exclude);
    }
    Some(())
}
