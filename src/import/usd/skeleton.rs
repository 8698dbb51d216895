//! UsdSkel: meshes posed by skeletons and blend shapes, at the stage's time.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::{DAffine3, DMat3, DMat4, DVec3};
use openusd::sdf::{Path, Value};

use super::polygons::{Corner, Interpolation, Layer, Polygons};
use super::source::{Source, View};
use super::{transform, value};
use crate::scene::{Diagnostics, Verdict};

/// What prims have from above about skeletons.
#[derive(Clone, Debug, Default)]
pub(super) struct Binding {
    /// The SkelRoot that they stand below, and where it is. Without one nothing is posed.
    root: Option<(Path, DAffine3)>,
    skeleton: Option<Path>,
    animation: Option<Path>,
}

impl Binding {
    /// For what stands below a prim.
    pub(super) fn below(&self, prim: &View, kind: &str, matrix: &DAffine3) -> Self {
        let first = |name: &str| prim.targets(name).into_iter().next();
        Self {
            root: match &self.root {
                None if kind == "SkelRoot" => Some((prim.path().clone(), *matrix)),
                other => other.clone(),
            },
            skeleton: first("skel:skeleton").or_else(|| self.skeleton.clone()),
            animation: first("skel:animationSource").or_else(|| self.animation.clone()),
        }
    }

    /// The same for the parts of an instance at `path`, which are placed from its own place (and are found at `inside`).
    pub(super) fn in_instance(&self, path: &Path, inside: &Path, matrix: &DAffine3) -> Self {
        let root = self.root.as_ref().map(|(root, at)| {
            if root == path {
                (inside.clone(), DAffine3::IDENTITY)
            } else {
                (root.clone(), matrix.inverse() * *at)
            }
        });
        Self {
            root,
            ..self.clone()
        }
    }

    /// What tells apart how prototypes are posed.
    pub(super) fn key(&self) -> String {
        if self.root.is_none() && self.skeleton.is_none() && self.animation.is_none() {
            return String::new();
        }
        let path = |path: &Option<Path>| path.as_ref().map(ToString::to_string);
        let root = self
            .root
            .as_ref()
            .map(|(path, at)| format!("{path} {at:?}"));
        let (skeleton, animation) = (path(&self.skeleton), path(&self.animation));
        format!("{root:?} {skeleton:?} {animation:?}")
    }
}

/// A skeleton in a pose.
#[derive(Debug, Default)]
pub(super) struct Pose {
    /// Where the skeleton stands.
    matrix: DAffine3,
    /// Its joints in their order, and what each does to what hangs on it; none if the skeleton is not whole.
    joints: Vec<(String, DAffine3)>,
    /// Weights of blend shapes.
    weights: BTreeMap<String, f64>,
}

/// The skeletons of a stage, as they are asked for.
#[derive(Default)]
pub(super) struct Skeletons {
    known: HashMap<String, Option<Rc<Pose>>>,
}

impl Skeletons {
    /// The pose of what is bound so; `None` if it is bound to nothing.
    pub(super) fn pose(
        &mut self,
        source: &Source,
        binding: &Binding,
        diagnostics: &mut Diagnostics,
    ) -> Option<Rc<Pose>> {
        binding.root.as_ref()?;
        if binding.skeleton.is_none() && binding.animation.is_none() {
            return None;
        }
        let key = binding.key();
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let pose = pose(source, binding, diagnostics).map(Rc::new);
        self.known.insert(key, pose.clone());
        pose
    }
}

fn pose(source: &Source, binding: &Binding, diagnostics: &mut Diagnostics) -> Option<Pose> {
    let skeleton = binding.skeleton.as_ref().map(|path| source.view(path));
    let skeleton = skeleton.filter(|prim| prim.kind() == "Skeleton");
    if let (Some(path), None) = (&binding.skeleton, &skeleton) {
        diagnostics.report(
            "usd-skeleton",
            Verdict::Lost,
            "bindings to skeletons that do not exist",
            path.to_string(),
            "the meshes have the shape that stands in the file",
        );
    }
    let animation = match &skeleton {
        Some(skeleton) => animation_of(source, skeleton.path()).or(binding.animation.clone()),
        None => binding.animation.clone(),
    };
    let animation = animation.map(|path| source.view(&path));
    let animation = animation.filter(|prim| prim.kind() == "SkelAnimation");
    let weights = animation.as_ref().map(weights).unwrap_or_default();
    let mut posed = Pose {
        weights,
        ..Pose::default()
    };
    if let Some(skeleton) = &skeleton {
        posed.matrix = stands(source, binding, skeleton.path(), diagnostics);
        match joints(skeleton, animation.as_ref(), diagnostics) {
            Some(joints) => posed.joints = joints,
            None => diagnostics.report(
                "usd-skeleton",
                Verdict::Lost,
                "skeletons without a transform for each joint",
                skeleton.path().to_string(),
                "the meshes have the shape that stands in the file",
            ),
        }
    }
    Some(posed)
}

/// The animation of a skeleton: its own, or that of what it stands below.
fn animation_of(source: &Source, skeleton: &Path) -> Option<Path> {
    let mut above = skeleton.ancestors_below_root();
    above.find_map(|path| {
        let prim = source.view(&path);
        prim.targets("skel:animationSource").into_iter().next()
    })
}

fn weights(animation: &View) -> BTreeMap<String, f64> {
    let names = animation.value("blendShapes");
    let names = names.as_ref().map(value::words).unwrap_or_default();
    let weights = animation.value("blendShapeWeights");
    let weights = weights.as_ref().and_then(value::floats);
    let (_, weights) = weights.unwrap_or_default();
    let finite = |w: f32| if w.is_finite() { f64::from(w) } else { 0.0 };
    names
        .into_iter()
        .zip(weights.into_iter().map(finite))
        .collect()
}

/// Where a skeleton stands, in the space in which its SkelRoot has its place.
fn stands(
    source: &Source,
    binding: &Binding,
    skeleton: &Path,
    diagnostics: &mut Diagnostics,
) -> DAffine3 {
    let mut above: Vec<Path> = skeleton.ancestors_below_root().collect();
    above.reverse();
    let mut at = DAffine3::IDENTITY;
    if let Some((root, matrix)) = &binding.root
        && skeleton.has_prefix(root)
    {
        at = *matrix;
        above.retain(|path| path != root && path.has_prefix(root));
    }
    for path in above {
        let local = transform::local(&source.view(&path), diagnostics);
        at = if local.resets {
            local.matrix
        } else {
            at * local.matrix
        };
    }
    at
}

/// What each joint does to what hangs on it: its place now after the inverse of where it was bound.
fn joints(
    skeleton: &View,
    animation: Option<&View>,
    diagnostics: &mut Diagnostics,
) -> Option<Vec<(String, DAffine3)>> {
    let names = value::words(&skeleton.value("joints")?);
    let bind = value::matrices(&skeleton.value("bindTransforms")?)?;
    let rest = skeleton.value("restTransforms");
    let rest = rest.as_ref().and_then(value::matrices);
    let rest = rest.filter(|rest| rest.len() == names.len());
    let moved = animation.and_then(|animation| {
        let moved = moved(animation);
        if moved.is_none() && animation.has("joints") {
            diagnostics.report(
                "usd-skeleton",
                Verdict::Lost,
                "animations of skeletons whose lists differ in their lengths",
                animation.path().to_string(),
                "the joints are at rest",
            );
        }
        moved
    });
    let moved = moved.unwrap_or_default();
    if bind.len() != names.len() {
        return None;
    }
    let places: HashMap<&str, usize> = names.iter().enumerate().map(|(i, n)| (&**n, i)).collect();
    // Parents have shorter paths.
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|joint| names[*joint].len());
    let mut stands = vec![DAffine3::IDENTITY; names.len()];
    for joint in order {
        let local = moved.get(&names[joint]).copied();
        let local = local.or_else(|| rest.as_ref().map(|rest| transform::affine(rest[joint])))?;
        let mut name = names[joint].as_str();
        let mut parent = None;
        while let (None, Some((above, _))) = (parent, name.rsplit_once('/')) {
            parent = places.get(above);
            name = above;
        }
        stands[joint] = parent.map_or(local, |parent| stands[*parent] * local);
    }
    let each = names.into_iter().zip(stands).zip(bind);
    let each = each.map(|((name, stands), bind)| {
        let inverse = transform::affine(bind).inverse();
        let inverse = Some(inverse).filter(DAffine3::is_finite);
        (name, stands * inverse.unwrap_or(DAffine3::IDENTITY))
    });
    Some(each.collect())
}

/// The joints that an animation moves, each in the space of its parent.
fn moved(animation: &View) -> Option<HashMap<String, DAffine3>> {
    let names = value::words(&animation.value("joints")?);
    let places = value::points(&animation.value("translations")?)?;
    let turns = value::rotations(&animation.value("rotations")?)?;
    let scales = animation.value("scales").as_ref().and_then(value::points);
    let scales = scales.unwrap_or_else(|| vec![[1.0; 3]; names.len()]);
    let lengths = [places.len(), turns.len(), scales.len()];
    if lengths != [names.len(); 3] {
        return None;
    }
    let each = places.into_iter().zip(turns).zip(scales);
    let each = each.map(|((place, turn), scale)| transform::of_instance(place, turn, scale));
    Some(names.into_iter().zip(each).collect())
}

/// The joints that the points of a mesh hang on.
struct Influences {
    joints: Vec<i64>,
    weights: Vec<f32>,
    /// So many for each point; all of them for all points if it moves as one.
    each: usize,
    rigid: bool,
    bind: DAffine3,
}

/// Constant primvars from above.
type Primvars = BTreeMap<String, Value>;

/// Whether a mesh hangs on joints, so that it stands where its skeleton does.
pub(super) fn hangs(prim: &View, above: &Primvars) -> bool {
    let there = |name: &str| prim.has(&format!("primvars:{name}")) || above.contains_key(name);
    there("skel:jointIndices") && there("skel:jointWeights")
}

fn influences(prim: &View, above: &Primvars, points: usize) -> Option<Influences> {
    let find = |name: &str| {
        let own = prim.value(&format!("primvars:{name}"));
        own.or_else(|| above.get(name).cloned())
    };
    let joints = value::integers(&find("skel:jointIndices")?)?;
    let (_, weights) = value::floats(&find("skel:jointWeights")?)?;
    let name = "primvars:skel:jointIndices";
    let told = prim.property_word(name, "interpolation");
    let rigid = !prim.has(name) || told.as_deref() == Some("constant");
    let size = prim.property_number(name, "elementSize");
    let size = size.map_or(1, |size| size.max(1.0) as usize);
    let each = if rigid {
        joints.len()
    } else if size.checked_mul(points) == Some(joints.len()) {
        size
    } else if points > 0 && joints.len().is_multiple_of(points) {
        joints.len() / points
    } else {
        return None;
    };
    let bind = find("skel:geomBindTransform");
    let bind = bind.as_ref().and_then(value::matrix);
    let whole = each > 0 && joints.len() == weights.len();
    whole.then(|| Influences {
        joints,
        weights,
        each,
        rigid,
        bind: bind.map_or(DAffine3::IDENTITY, transform::affine),
    })
}

impl Pose {
    /// Where what hangs on the joints stands.
    pub(super) fn place(&self) -> Option<DAffine3> {
        (!self.joints.is_empty()).then_some(self.matrix)
    }

    /// Brings a mesh into the pose: blend shapes first, then joints.
    pub(super) fn apply(
        &self,
        source: &Source,
        prim: &View,
        above: &Primvars,
        polygons: &mut Polygons,
        diagnostics: &mut Diagnostics,
    ) {
        let mut normals = normals_of_points(polygons);
        self.blend(source, prim, polygons, &mut normals, diagnostics);
        if !self.joints.is_empty() && hangs(prim, above) {
            self.skin(prim, above, polygons, &mut normals, diagnostics);
        }
        if let Some((_, values)) = normals {
            let layer = polygons.normals.as_mut();
            layer
                .into_iter()
                .for_each(|layer| layer.values = values.clone());
        }
    }

    fn blend(
        &self,
        source: &Source,
        prim: &View,
        polygons: &mut Polygons,
        normals: &mut Normals,
        diagnostics: &mut Diagnostics,
    ) {
        let names = prim.value("skel:blendShapes");
        let names = names.as_ref().map(value::words).unwrap_or_default();
        let targets = prim.targets("skel:blendShapeTargets");
        for (name, target) in names.iter().zip(&targets) {
            let weight = self.weights.get(name).copied().unwrap_or(0.0);
            if weight == 0.0 {
                continue;
            }
            let shape = source.view(target);
            let listed = shape.integers("pointIndices");
            let mut whole = true;
            for (offsets, turns, share) in shares(&shape, weight) {
                let mut add = |at: usize, place: usize| {
                    let Some(point) = polygons.points.get_mut(place) else {
                        return false;
                    };
                    for (value, change) in point.iter_mut().zip(offsets[at]) {
                        *value += (share * f64::from(change)) as f32;
                    }
                    true
                };
                whole &= match &listed {
                    Some(listed) => {
                        let places = listed
                            .iter()
                            .map(|i| usize::try_from(*i).unwrap_or(usize::MAX));
                        offsets.len() <= listed.len()
                            && places
                                .zip(0..offsets.len())
                                .all(|(place, at)| add(at, place))
                    }
                    None => (0..offsets.len()).all(|at| add(at, at)),
                };
                if let (Some((owners, values)), Some(turns)) = (&mut *normals, turns) {
                    turn(owners, values, &turns, listed.as_deref(), share);
                }
            }
            if !whole {
                diagnostics.report(
                    "usd-skeleton",
                    Verdict::Lost,
                    "blend shapes that move points which do not exist",
                    target.to_string(),
                    "those offsets are left out",
                );
            }
        }
    }

    fn skin(
        &self,
        prim: &View,
        above: &Primvars,
        polygons: &mut Polygons,
        normals: &mut Normals,
        diagnostics: &mut Diagnostics,
    ) {
        let mut lose = |verdict, what: &str, instead: &str| {
            diagnostics.report(
                "usd-skeleton",
                verdict,
                what,
                prim.path().to_string(),
                instead,
            );
        };
        let Some(hung) = influences(prim, above, polygons.points.len()) else {
            lose(
                Verdict::Lost,
                "joints and weights of meshes whose numbers do not fit the points",
                "the mesh has the shape that stands in the file",
            );
            return;
        };
        if prim.word("primvars:skel:skinningMethod").as_deref() == Some("dualQuaternion") {
            lose(
                Verdict::Approximated,
                "skinning by dual quaternions",
                "the matrices of the joints are blended",
            );
        }
        // The mesh may number the joints in its own way.
        let own = prim.value("skel:joints").as_ref().map(value::words);
        let known: HashMap<&str, &DAffine3> = self.joints.iter().map(|(n, m)| (&**n, m)).collect();
        let list: Vec<DAffine3> = match &own {
            Some(own) => own
                .iter()
                .map(|name| known.get(&**name).map_or(DAffine3::IDENTITY, |m| **m))
                .collect(),
            None => self.joints.iter().map(|(_, matrix)| *matrix).collect(),
        };
        let (mut odd, mut none) = (false, false);
        let mut of = |point: usize| {
            let start = if hung.rigid { 0 } else { point * hung.each };
            let range = start..start + hung.each;
            let (mut sum, mut total) = (DMat4::ZERO, 0.0);
            for (joint, weight) in hung.joints[range.clone()].iter().zip(&hung.weights[range]) {
                let weight = f64::from(*weight);
                let joint = usize::try_from(*joint)
                    .ok()
                    .and_then(|joint| list.get(joint));
                match joint {
                    Some(matrix) if weight != 0.0 && weight.is_finite() => {
                        sum += DMat4::from(*matrix) * weight;
                        total += weight;
                    }
                    _ => {}
                }
            }
            // Weights of 8 bits are off by up to half of 1/255 each.
            odd |= total != 0.0 && (total - 1.0).abs() > hung.each as f64 * 0.5 / 255.0;
            none |= total == 0.0;
            let blended = if total == 0.0 {
                DMat4::IDENTITY
            } else {
                sum * (1.0 / total)
            };
            DAffine3::from_mat4(blended) * hung.bind
        };
        let matrices: Vec<DAffine3> = if hung.rigid {
            vec![of(0)]
        } else {
            (0..polygons.points.len()).map(&mut of).collect()
        };
        let of = |point: u32| &matrices[if hung.rigid { 0 } else { point as usize }];
        for (at, point) in polygons.points.iter_mut().enumerate() {
            let place = DVec3::from(point.map(f64::from));
            *point = of(at as u32).transform_point3(place).as_vec3().to_array();
        }
        if let Some((owners, values)) = normals {
            for (owner, normal) in owners.iter().zip(values.as_chunks_mut::<3>().0) {
                let turned = cofactor(&of(*owner).matrix3) * DVec3::from(normal.map(f64::from));
                *normal = turned.normalize_or_zero().as_vec3().to_array();
            }
        }
        if odd {
            let scaled = "scaled so that they do";
            lose(
                Verdict::Approximated,
                "weights of joints that do not sum to 1",
                scaled,
            );
        }
        if none {
            let stay = "they stay where they were bound";
            lose(
                Verdict::Approximated,
                "points without weights of joints",
                stay,
            );
        }
    }
}

/// Turns normals like the inverse transpose, and needs no inverse.
fn cofactor(m: &DMat3) -> DMat3 {
    DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    )
}

/// The point that each normal belongs to, and the normals.
type Normals = Option<(Vec<u32>, Vec<f32>)>;

/// Makes the normals of a mesh those of points or of corners, each by itself.
fn normals_of_points(polygons: &mut Polygons) -> Normals {
    let layer = polygons.normals.as_ref()?;
    if layer.interpolation == Interpolation::Vertex && layer.indices.is_none() {
        let owners = (0..polygons.points.len()).map(|at| at as u32).collect();
        return Some((owners, layer.values.clone()));
    }
    let mut values = Vec::with_capacity(3 * polygons.corners.len());
    let mut number = 0;
    for (face, count) in polygons.counts.iter().enumerate() {
        for _ in 0..*count {
            let point = polygons.corners[number];
            let corner = Corner {
                face,
                number,
                point,
            };
            values.extend(layer.at(layer.index(corner), [0.0f32; 3]));
            number += 1;
        }
    }
    polygons.normals = Some(Layer {
        components: 3,
        values: values.clone(),
        interpolation: Interpolation::FaceVarying,
        indices: None,
    });
    Some((polygons.corners.clone(), values))
}

/// Adds offsets to normals.
fn turn(
    owners: &[u32],
    values: &mut [f32],
    turns: &[[f32; 3]],
    listed: Option<&[i64]>,
    share: f64,
) {
    let places: Option<HashMap<i64, usize>> = listed.map(|listed| {
        listed
            .iter()
            .enumerate()
            .map(|(at, point)| (*point, at))
            .collect()
    });
    for (owner, normal) in owners.iter().zip(values.as_chunks_mut::<3>().0) {
        let at = match &places {
            Some(places) => places.get(&i64::from(*owner)).copied(),
            None => Some(*owner as usize),
        };
        if let Some(change) = at.and_then(|at| turns.get(at)) {
            for (value, change) in normal.iter_mut().zip(change) {
                *value += (share * f64::from(*change)) as f32;
            }
        }
    }
}

/// Offsets of points and of normals, and how much of them counts.
type Share = (Vec<[f32; 3]>, Option<Vec<[f32; 3]>>, f64);

/// What a blend shape amounts to at a weight: between the shapes on both sides, of which the mesh itself is that at 0.
fn shares(shape: &View, weight: f64) -> Vec<Share> {
    let list = |name: &str| shape.value(name).as_ref().and_then(value::points);
    let mut between: Vec<(f64, String)> = shape
        .names
        .iter()
        .filter(|name| name.starts_with("inbetweens:") && !name.ends_with(":normalOffsets"))
        .filter_map(|name| Some((shape.property_number(name, "weight")?, name.clone())))
        .filter(|(at, _)| at.is_finite() && *at != 0.0 && *at != 1.0)
        .collect();
    between.push((0.0, String::new()));
    between.push((1.0, "offsets".into()));
    between.sort_by(|a, b| a.0.total_cmp(&b.0));
    let next = between.partition_point(|(at, _)| *at <= weight);
    let next = next.clamp(1, between.len() - 1);
    let ((low, first), (high, second)) = (&between[next - 1], &between[next]);
    // Beyond the outermost two it goes on as between them.
    let share = (weight - low) / (high - low);
    let of = |name: &String, share: f64| {
        let turns = if name == "offsets" {
            list("normalOffsets")
        } else {
            list(&format!("{name}:normalOffsets"))
        };
        (share != 0.0 && !name.is_empty()).then(|| Some((list(name)?, turns, share)))?
    };
    [of(first, 1.0 - share), of(second, share)]
        .into_iter()
        .flatten()
        .collect()
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/skeleton.rs"]
mod tests;
