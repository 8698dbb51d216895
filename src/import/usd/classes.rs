//! Prims that inherit what they have already, or themselves.
//!
//! The composition of `openusd` follows classes from prim to prim without an end where they lead back to where they began.
//! Such arcs are found in the layers before they are composed, and left out. Most of them are no loss: what they bring is
//! brought by another one, of a prim that theirs stands below.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::Cursor;

use openusd::sdf::{self, AbstractData, Path, PathListOp, Value};
use openusd::usda::TextWriter;
use openusd::usdc::{CrateData, CrateWriter};

/// Layers that are looked into for one, at most.
const MOST_LAYERS: usize = 256;
/// Places that a prim is composed of, at most.
const MOST_SITES: usize = 512;
/// Prims that are followed for one arc, at most.
const MOST_FOLLOWED: usize = 4096;
/// Steps for the arcs of a stack, at most: what is left then is left out.
const MOST_STEPS: usize = 20_000_000;
/// Fields of arcs to classes.
const FIELDS: [&str; 2] = ["inheritPaths", "specializes"];

/// Where layers are read from.
pub(super) trait Layers {
    /// The name of a layer that another one names.
    fn named(&self, asset: &str, by: &str) -> String;
    /// What a layer says.
    fn parsed(&self, layer: &str) -> Option<Box<dyn AbstractData>>;
}

/// An arc that is left out.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Dropped {
    pub layer: String,
    pub prim: Path,
    pub target: Path,
    /// What it brings is there without it.
    pub redundant: bool,
}

/// Reads a layer of either kind.
pub(super) fn parse(bytes: &[u8]) -> Option<Box<dyn AbstractData>> {
    if bytes.starts_with(b"PXR-USDC") {
        let data = CrateData::open(Cursor::new(bytes.to_vec()), true).ok()?;
        return Some(Box::new(data));
    }
    let text = std::str::from_utf8(bytes).ok()?;
    Some(Box::new(openusd::usda::parse(text).ok()?))
}

/// A layer without some arcs, of the kind that it was.
pub(super) fn without(bytes: &[u8], dropped: &[Dropped]) -> Option<Vec<u8>> {
    let data = parse(bytes)?;
    let mut data = sdf::Data::from_abstract(&*data).ok()?;
    let arcs: HashSet<_> = dropped.iter().map(|d| (&d.prim, &d.target)).collect();
    for path in data.spec_paths() {
        for field in FIELDS {
            let here = path.strip_all_variant_selections();
            let gone = |target: &Path| {
                let target = here.make_absolute(target);
                arcs.contains(&(&here, &target))
            };
            let Some(list) = list(&data, &path, field) else {
                continue;
            };
            let mut left = list.clone();
            for items in [
                &mut left.explicit_items,
                &mut left.prepended_items,
                &mut left.appended_items,
                &mut left.added_items,
            ] {
                items.retain(|target| !gone(target));
            }
            if left != list {
                data.set_field(&path, field, Value::PathListOp(left));
            }
        }
    }
    let mut out = Cursor::new(Vec::new());
    if bytes.starts_with(b"PXR-USDC") {
        CrateWriter::write(&data, &mut out).ok()?;
    } else {
        TextWriter::write(&data, &mut out).ok()?;
    }
    Some(out.into_inner())
}

fn list(data: &dyn AbstractData, path: &Path, field: &str) -> Option<PathListOp> {
    match data.try_field(path, field).ok()??.into_owned() {
        Value::PathListOp(list) => Some(list),
        _ => None,
    }
}

/// Where an arc leads.
#[derive(Clone)]
struct Arc {
    /// The layer that says so.
    by: String,
    /// Another layer.
    layer: Option<String>,
    /// What there; without, its default prim.
    target: Option<Path>,
    class: bool,
}

/// Layers that share their names of prims: one with its sublayers.
#[derive(Default)]
struct Stack {
    arcs: BTreeMap<Path, Vec<Arc>>,
    default: Option<Path>,
}

struct Search<'a> {
    layers: &'a dyn Layers,
    stacks: Vec<Stack>,
    numbers: HashMap<String, Option<usize>>,
    read: usize,
    steps: usize,
}

/// The arcs of a layer and its sublayers that lead back to where they began.
pub(super) fn tangled(layers: &dyn Layers, root: &str) -> Vec<Dropped> {
    let mut search = Search {
        layers,
        stacks: Vec::new(),
        numbers: HashMap::new(),
        read: 0,
        steps: 0,
    };
    let Some(stack) = search.stack(root) else {
        return Vec::new();
    };
    let mut classes = Vec::new();
    for (prim, arcs) in &search.stacks[stack].arcs {
        for arc in arcs.iter().filter(|arc| arc.class) {
            let target = arc.target.clone();
            classes.extend(target.map(|target| (prim.clone(), target, arc.by.clone())));
        }
    }
    let mut known: HashMap<Path, Vec<Path>> = HashMap::new();
    let mut dropped = Vec::new();
    // What stands above comes first, and stays.
    for (prim, target, layer) in classes {
        let images = search.images(stack, &prim, &target);
        let redundant = target != prim && images.contains(&prim);
        let circle = target.is_nested_with(&prim) || search.leads(stack, &images, &prim, &known);
        if redundant || circle || search.steps > MOST_STEPS {
            let arcs = search.stacks[stack].arcs.get_mut(&prim);
            arcs.into_iter()
                .for_each(|arcs| arcs.retain(|a| !a.class || a.target.as_ref() != Some(&target)));
            dropped.push(Dropped {
                layer,
                prim,
                target,
                redundant,
            });
        } else {
            known.entry(prim).or_default().push(target);
        }
    }
    dropped
}

impl Search<'_> {
    /// The number of a layer's stack.
    fn stack(&mut self, root: &str) -> Option<usize> {
        if let Some(known) = self.numbers.get(root) {
            return *known;
        }
        let mut stack = Stack::default();
        let mut seen = HashSet::new();
        let mut open = vec![root.to_owned()];
        while let Some(layer) = open.pop() {
            if self.read >= MOST_LAYERS || !seen.insert(layer.clone()) {
                continue;
            }
            self.read += 1;
            let Some(data) = self.layers.parsed(&layer) else {
                continue;
            };
            let top = Path::abs_root();
            let field = |name: &str| data.try_field(&top, name).ok().flatten();
            if let Some(Value::StringVec(below)) = field("subLayers").as_deref() {
                let below = below.iter().map(|asset| self.layers.named(asset, &layer));
                open.extend(below);
            }
            if layer == root {
                let name = field("defaultPrim");
                let name = name.as_deref().and_then(super::value::word);
                stack.default = name.and_then(|name| top.append_path(name.as_str()).ok());
            }
            self.collect(&*data, &layer, &mut stack);
        }
        let number = (!seen.is_empty()).then_some(self.stacks.len());
        self.stacks.push(stack);
        self.numbers.insert(root.to_owned(), number);
        number
    }

    /// The arcs of a layer.
    fn collect(&self, data: &dyn AbstractData, layer: &str, stack: &mut Stack) {
        for path in data.spec_paths() {
            if path.is_property_path() {
                continue;
            }
            let prim = path.strip_all_variant_selections();
            let mut arcs = Vec::new();
            for field in FIELDS {
                let targets = list(data, &path, field).map(|list| list.flatten());
                arcs.extend(targets.into_iter().flatten().map(|target| Arc {
                    by: layer.to_owned(),
                    layer: None,
                    target: Some(prim.make_absolute(&target)),
                    class: true,
                }));
            }
            let mut outside = Vec::new();
            for field in ["references", "payload"] {
                match data.try_field(&path, field).ok().flatten().as_deref() {
                    Some(Value::ReferenceListOp(list)) => {
                        let all = list.flatten().into_iter();
                        outside.extend(all.map(|r| (r.asset_path, r.prim_path)));
                    }
                    Some(Value::PayloadListOp(list)) => {
                        let all = list.flatten().into_iter();
                        outside.extend(all.map(|p| (p.asset_path, p.prim_path)));
                    }
                    Some(Value::Payload(p)) => {
                        outside.push((p.asset_path.clone(), p.prim_path.clone()));
                    }
                    _ => {}
                }
            }
            arcs.extend(outside.into_iter().map(|(asset, target)| Arc {
                by: layer.to_owned(),
                layer: (!asset.is_empty()).then(|| self.layers.named(&asset, layer)),
                target: Some(target).filter(|t| !t.is_empty()),
                class: false,
            }));
            if !arcs.is_empty() {
                stack.arcs.entry(prim).or_default().extend(arcs);
            }
        }
    }

    /// The places that a prim is composed of.
    fn sites(&mut self, stack: usize, prim: &Path) -> Vec<(usize, Path)> {
        let mut found = vec![(stack, prim.clone())];
        let mut at = 0;
        while at < found.len() && found.len() < MOST_SITES && self.steps <= MOST_STEPS {
            let (stack, path) = found[at].clone();
            at += 1;
            for above in path.ancestors_below_root() {
                let arcs = self.stacks[stack].arcs.get(&above);
                let arcs = arcs.map(|arcs| arcs.iter().take(MOST_SITES).cloned().collect());
                let arcs: Vec<Arc> = arcs.unwrap_or_default();
                self.steps += 1;
                for arc in arcs {
                    self.steps += found.len();
                    if found.len() >= MOST_SITES {
                        break;
                    }
                    let to = match &arc.layer {
                        None => Some(stack),
                        Some(layer) => self.stack(layer),
                    };
                    let Some(to) = to else {
                        continue;
                    };
                    let target = arc.target.or_else(|| self.stacks[to].default.clone());
                    let new = target.and_then(|target| path.replace_prefix(&above, &target));
                    let new = new.map(|new| (to, new));
                    found.extend(new.filter(|new| !found.contains(new)));
                }
            }
        }
        found
    }

    /// A target, and where it is seen from a prim through what that stands below.
    fn images(&mut self, stack: usize, prim: &Path, target: &Path) -> Vec<Path> {
        let mut images = vec![target.clone()];
        let above: Vec<Path> = prim.ancestors_below_root().skip(1).collect();
        for above in above {
            for (_, site) in self.sites(stack, &above) {
                let image = target.replace_prefix(&site, &above);
                images.extend(image.filter(|image| !images.contains(image)));
            }
        }
        images
    }

    /// Whether some prims lead to another through the arcs that are known.
    fn leads(
        &mut self,
        stack: usize,
        from: &[Path],
        to: &Path,
        known: &HashMap<Path, Vec<Path>>,
    ) -> bool {
        let mut seen: HashSet<Path> = from.iter().cloned().collect();
        let mut open = from.to_vec();
        while let Some(prim) = open.pop() {
            if prim == *to {
                return true;
            }
            for (_, site) in self.sites(stack, &prim) {
                for target in known.get(&site).cloned().unwrap_or_default() {
                    for image in self.images(stack, &prim, &target) {
                        if seen.len() < MOST_FOLLOWED && seen.insert(image.clone()) {
                            open.push(image);
                        }
                    }
                }
            }
        }
        false
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/classes.rs"]
mod tests;
