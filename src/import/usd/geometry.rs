//! Prims with a surface become triangle meshes, one for each material.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::DAffine3;
use openusd::sdf::{Path, Specifier, Value};

use super::binding;
use super::materials::{Colored, Materials};
use super::polygons::{Interpolation, Layer, Polygons};
use super::preview::DEFAULT_UV;
use super::skeleton::{self, Pose, Skeletons};
use super::source::{Source, View};
use super::volumes::Volumes;
use super::walk::Inherited;
use super::{curves, primitives, subdivide, triangles, value};
use crate::import::ImportError;
use crate::import::budget::Budget;
use crate::math::words::counted;
use crate::scene::{Diagnostics, MaterialId, Mesh, MeshId, Verdict};

/// What is known of prims with a surface.
pub(super) struct Shapes<'a> {
    source: &'a Source,
    pub materials: Materials<'a>,
    pub meshes: Vec<Mesh>,
    /// The meshes of each shape.
    pub list: Vec<Vec<MeshId>>,
    /// Whether all of each have the colour of the object that they are.
    coloured: Vec<bool>,
    skeletons: Skeletons,
    volumes: Volumes,
    /// Shapes of prims in prototypes, by all that makes them.
    known: HashMap<(String, Vec<usize>, usize), Known>,
    /// Shapes without points, so far.
    primitives: usize,
    budget: Budget,
}

/// A shape, if there is one, and what keeps the place in memory of its key taken.
struct Known {
    shape: Option<usize>,
    _above: Rc<BTreeMap<String, Value>>,
}

/// A shape, and where it stands if that is not where its prim does.
pub(super) struct Shaped {
    pub number: usize,
    pub stands: Option<DAffine3>,
}

/// What is done to surfaces that have been divided.
const AFTERWARDS: &str = ", then brought to the limit surface; texture coordinates linearly";

/// More shapes without points than this are rounded with fewer corners.
const FINE: usize = 200;

/// Prims that have a surface or fill space, but are not rendered, and what they are.
const LOST: [(&str, &str); 6] = [
    ("NurbsCurves", "curves"),
    ("HermiteCurves", "curves"),
    ("NurbsPatch", "NURBS patches"),
    ("TetMesh", "meshes of tetrahedra"),
    ("ParticleField3DGaussianSplat", "Gaussian splats"),
    ("PortalLight", "portals of lights"),
];

impl<'a> Shapes<'a> {
    pub(super) fn new(
        source: &'a Source,
        materials: Materials<'a>,
        grid_memory: Option<u64>,
    ) -> Self {
        let bytes = usize::try_from(source.files.bytes_read()).unwrap_or(usize::MAX);
        Self {
            source,
            materials,
            meshes: Vec::new(),
            list: Vec::new(),
            coloured: Vec::new(),
            skeletons: Skeletons::default(),
            volumes: Volumes::new(grid_memory),
            known: HashMap::new(),
            primitives: 0,
            budget: Budget::for_stage(bytes),
        }
    }

    /// The shape of a prim, if it has one.
    pub(super) fn load(
        &mut self,
        prim: &View,
        kind: &str,
        inherited: &Inherited,
        name: &str,
        diagnostics: &mut Diagnostics,
    ) -> Result<Option<Shaped>, ImportError> {
        if let Some((_, what)) = LOST.iter().find(|(of, _)| *of == kind) {
            diagnostics.report(
                "usd-kind",
                Verdict::Lost,
                format!("{what} ({kind})"),
                prim.path().to_string(),
                "left out",
            );
            return Ok(None);
        }
        if kind == "Volume" {
            return Ok(self.volume(prim, inherited, name, diagnostics));
        }
        let made = ["Mesh", "BasisCurves", "Points"].contains(&kind);
        if !made && !primitives::KINDS.contains(&kind) {
            return Ok(None);
        }
        if prim.has("inputs:intensity") {
            diagnostics.report(
                "light-kind",
                Verdict::Lost,
                "meshes that are lights (MeshLightAPI)",
                prim.path().to_string(),
                "rendered with their materials",
            );
        }
        let subsets = self.subsets(prim, kind);
        let mut bound = vec![binding::materials(&inherited.bindings, prim.path())];
        for subset in &subsets {
            let bindings = binding::below(self.source, &inherited.bindings, &subset.prim());
            bound.push(binding::materials(&bindings, &subset.path));
        }
        let own = kind != "Points" || !inherited.object_colors;
        let has_colors = if own && prim.has("primvars:displayColor") {
            Colored::Vertex
        } else if inherited.object_colors {
            Colored::Object
        } else if inherited.primvars.contains_key("displayColor") {
            Colored::Vertex
        } else {
            Colored::Plain
        };
        let pose = self.pose(prim, kind, inherited, diagnostics);
        let hangs = pose
            .as_ref()
            .filter(|_| skeleton::hangs(prim, &inherited.primvars));
        let stands = hangs.and_then(|pose| pose.place());
        let shaped = |number| Shaped { number, stands };
        let materials: Vec<usize> = bound
            .iter()
            .map(|paths| self.materials.of(paths, has_colors, diagnostics))
            .collect();
        let from_above = &inherited.primvars_above;
        let place = Rc::as_ptr(from_above) as usize;
        let mut made_of = self.made_of(prim, kind);
        if pose.is_some() {
            made_of += &inherited.skin.key();
        }
        let key = (made_of, materials.clone(), place);
        if let Some(known) = self.known.get(&key) {
            return Ok(known.shape.map(shaped));
        }
        let built = self.build(
            prim,
            kind,
            (inherited, pose.as_deref()),
            (&subsets, &materials),
            name,
            diagnostics,
        );
        let meshes = built.map_err(|problem| {
            ImportError::malformed(&self.source.file, prim.path().to_string(), problem)
        })?;
        let shape = (!meshes.is_empty()).then(|| {
            let first = self.meshes.len();
            let count = meshes.len();
            self.meshes.extend(meshes);
            let id = |at: usize| MeshId(u32::try_from(at).unwrap_or(u32::MAX));
            self.list.push((first..first + count).map(id).collect());
            let by_object = |material: &usize| self.materials.is_of_objects(*material);
            self.coloured.push(materials.iter().all(by_object));
            self.list.len() - 1
        });
        let _above = from_above.clone();
        self.known.insert(key, Known { shape, _above });
        Ok(shape.map(shaped))
    }

    /// The shape of a volume.
    fn volume(
        &mut self,
        prim: &View,
        inherited: &Inherited,
        name: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<Shaped> {
        let mut mesh = self.volumes.load((self.source, prim), name, diagnostics)?;
        if !binding::materials(&inherited.bindings, prim.path()).is_empty() {
            diagnostics.report(
                "usd-volume-material",
                Verdict::Approximated,
                "materials of volumes",
                prim.path().to_string(),
                "they scatter light in grey by their density, as Blender's do without a material",
            );
        }
        let material = self.materials.filling();
        mesh.material = Some(MaterialId(u32::try_from(material).unwrap_or(u32::MAX)));
        let id = MeshId(u32::try_from(self.meshes.len()).unwrap_or(u32::MAX));
        self.meshes.push(mesh);
        self.list.push(vec![id]);
        self.coloured.push(false);
        let number = self.list.len() - 1;
        Some(Shaped {
            number,
            stands: None,
        })
    }

    /// Whether a shape has the colour of the object that it is.
    pub(super) fn is_coloured(&self, shape: usize) -> bool {
        self.coloured.get(shape) == Some(&true)
    }

    /// The pose that a prim is brought into, if it is.
    fn pose(
        &mut self,
        prim: &View,
        kind: &str,
        inherited: &Inherited,
        diagnostics: &mut Diagnostics,
    ) -> Option<Rc<Pose>> {
        let hangs = skeleton::hangs(prim, &inherited.primvars);
        if !hangs && !prim.has("skel:blendShapes") {
            return None;
        }
        let pose = self
            .skeletons
            .pose(self.source, &inherited.skin, diagnostics)?;
        if kind != "Mesh" {
            diagnostics.report(
                "usd-skeleton",
                Verdict::Lost,
                format!("skeletons of what is no mesh ({kind})"),
                prim.path().to_string(),
                "it has the shape that stands in the file",
            );
            return None;
        }
        Some(pose)
    }

    /// All that a prim is made of: the places in layers that its values come from. Where two have the same, one shape is enough.
    fn made_of(&self, prim: &View, kind: &str) -> String {
        if matches!(kind, "Mesh" | "BasisCurves") {
            let stack = self.source.told(prim.path(), prim.prim.prim_stack());
            return format!("{:?}", stack.unwrap_or_default());
        }
        if kind == "Points" {
            // One sphere for all, with the colour that they have in common.
            let colors = ["primvars:displayColor", "primvars:displayOpacity"];
            let colors = colors.map(|name| value::floats(&prim.value(name)?));
            let colors = colors.map(|found| found.filter(|(_, all)| all.len() <= 4));
            return format!("{kind} {colors:?}");
        }
        // Shapes without points are what their numbers say.
        let mut names: Vec<&String> = prim.names.iter().collect();
        names.retain(|name| {
            primitives::NUMBERS.contains(&&***name) || name.starts_with("primvars:")
        });
        names.sort();
        let numbers: Vec<_> = names.iter().map(|name| (name, prim.value(name))).collect();
        format!("{kind} {numbers:?}")
    }

    /// Parts of a mesh with materials of their own.
    fn subsets(&self, prim: &View, kind: &str) -> Vec<Subset<'a>> {
        if kind != "Mesh" {
            return Vec::new();
        }
        let children = self.source.told(prim.path(), prim.prim.children());
        let mut subsets = Vec::new();
        for child in children.unwrap_or_default() {
            let view = self.source.view(child.path());
            let defined = self.source.told(child.path(), child.specifier()).flatten();
            if view.kind() != "GeomSubset" || defined != Some(Specifier::Def) {
                continue;
            }
            let family = view.word("familyName").unwrap_or_default();
            let of_faces = !matches!(
                view.word("elementType").as_deref(),
                Some("point" | "edge" | "segment" | "tetrahedron")
            );
            let binds = view.names.iter().any(|n| n.starts_with("material:binding"));
            if of_faces && (family == "materialBind" || binds) {
                subsets.push(Subset {
                    source: self.source,
                    path: child.path().clone(),
                    faces: view.integers("indices").unwrap_or_default(),
                });
            }
        }
        subsets
    }

    /// The meshes of a prim. An error says that there is too much of it.
    fn build(
        &mut self,
        prim: &View,
        kind: &str,
        (inherited, pose): (&Inherited, Option<&Pose>),
        (subsets, materials): (&[Subset], &[usize]),
        name: &str,
        diagnostics: &mut Diagnostics,
    ) -> Result<Vec<Mesh>, String> {
        let mut strands = None;
        let polygons = match kind {
            "Mesh" => read(prim, diagnostics),
            "BasisCurves" => {
                let fits = |corners| self.budget.take(corners, 200).is_ok();
                let made = curves::polygons(prim, fits, diagnostics);
                made.map(|(polygons, of)| {
                    strands = Some(of);
                    polygons
                })
            }
            _ => {
                self.primitives += 1;
                let (kind, fine) = match kind {
                    "Points" => ("Sphere", false),
                    _ => (kind, self.primitives <= FINE),
                };
                primitives::polygons(prim, kind, fine, diagnostics)
            }
        };
        let Some(mut polygons) = polygons else {
            return Ok(Vec::new());
        };
        // Positions, normals, coordinates and triangles of each corner, some of them twice.
        if kind == "Mesh" {
            self.budget.take(polygons.corners.len() as u64, 200)?;
        }
        if let Some(pose) = pose {
            let above = &inherited.primvars;
            pose.apply(self.source, prim, above, &mut polygons, diagnostics);
        }
        let wanted = materials.iter().flat_map(|m| self.materials.primvars(*m));
        for name in wanted.collect::<std::collections::BTreeSet<_>>() {
            let mut find = |name: &str| match &strands {
                Some(strands) if prim.has(&format!("primvars:{name}")) => {
                    strands.layer(prim, &format!("primvars:{name}"))
                }
                _ => primvar(prim, inherited, name, &polygons, diagnostics),
            };
            let mut found = find(&name);
            // Blender calls the first coordinates "st" on the mesh, and by their own name in materials.
            if found.is_none() && name != DEFAULT_UV && self.materials.is_open_uv(materials, &name)
            {
                found = find(DEFAULT_UV);
            }
            if let Some(layer) = found {
                polygons.primvars.insert(name, layer);
            }
        }
        // The face's place among the materials; 0 is that of the whole mesh.
        let mut part = vec![0; polygons.counts.len()];
        for (at, subset) in subsets.iter().enumerate() {
            for face in &subset.faces {
                let face = usize::try_from(*face)
                    .ok()
                    .and_then(|face| part.get_mut(face));
                if let Some(place) = face {
                    *place = at + 1;
                }
            }
        }
        if polygons.subdivides {
            let scheme = subdivide::Wishes::of(prim);
            let corners = subdivide::corners_after(&polygons);
            self.budget.take(corners, 200)?;
            let levels = subdivide::apply(&mut polygons, &mut part, &scheme);
            diagnostics.report(
                "usd-subdivision",
                Verdict::Approximated,
                "subdivision surfaces",
                prim.path().to_string(),
                match levels {
                    0 => "not divided, as there are very many faces already".to_owned(),
                    1 => format!("divided once{AFTERWARDS}"),
                    _ => format!("divided {levels} times{AFTERWARDS}"),
                },
            );
        }
        let mut meshes = Vec::new();
        let shapes = triangles::Triangles::of(&polygons);
        for (at, material) in materials.iter().enumerate() {
            let faces: Vec<usize> = (0..part.len()).filter(|f| part[*f] == at).collect();
            let mesh = shapes.mesh(
                &polygons,
                &faces,
                name,
                (&self.materials, *material),
                diagnostics,
            );
            meshes.extend(mesh);
        }
        Ok(meshes)
    }
}

/// A part of a mesh.
struct Subset<'a> {
    source: &'a Source,
    path: Path,
    faces: Vec<i64>,
}

impl<'a> Subset<'a> {
    fn prim(&self) -> View<'a> {
        self.source.view(&self.path)
    }
}

/// A mesh as it stands in the file.
fn read(prim: &View, diagnostics: &mut Diagnostics) -> Option<Polygons> {
    let path = prim.path().to_string();
    let points = prim.value("points").as_ref().and_then(value::points)?;
    let counts = prim.integers("faceVertexCounts")?;
    let corners = prim.integers("faceVertexIndices")?;
    let mut polygons = Polygons::new(points);
    let mut dropped = 0;
    let mut rest = corners.as_slice();
    let mut holes: Vec<usize> = Vec::new();
    let mut cut = 0;
    for (face, count) in counts.iter().enumerate() {
        let wanted = usize::try_from(*count).unwrap_or(0);
        let count = wanted.min(rest.len());
        cut += usize::from(wanted > count);
        let (own, others) = rest.split_at(count);
        rest = others;
        let own: Option<Vec<u32>> = own
            .iter()
            .map(|c| {
                u32::try_from(*c)
                    .ok()
                    .filter(|c| (*c as usize) < polygons.points.len())
            })
            .collect();
        match own {
            Some(own) => {
                polygons.corners.extend(&own);
                polygons.counts.push(own.len());
            }
            // The corners stay in the count, so that values of others stand where they belong.
            None => {
                dropped += 1;
                polygons.corners.extend(std::iter::repeat_n(0, count));
                polygons.counts.push(count);
                holes.push(face);
            }
        }
    }
    if dropped > 0 {
        diagnostics.report(
            "usd-corners",
            Verdict::Lost,
            format!(
                "{} that do not exist",
                counted(dropped, "face with corners", "faces with corners")
            ),
            &path,
            "left out",
        );
    }
    if cut > 0 || !rest.is_empty() {
        diagnostics.report(
            "usd-corners",
            Verdict::Lost,
            "counts of corners (faceVertexCounts) that do not fit the list of these",
            &path,
            "faces without all of their corners have those that are there; corners without a face are left out",
        );
    }
    let listed = prim.integers("holeIndices").unwrap_or_default();
    holes.extend(listed.iter().filter_map(|h| usize::try_from(*h).ok()));
    polygons.hole = vec![false; polygons.counts.len()];
    for hole in holes {
        if let Some(place) = polygons.hole.get_mut(hole) {
            *place = true;
        }
    }
    polygons.left_handed = prim.word("orientation").as_deref() == Some("leftHanded");
    let mut own = normals(prim, &polygons, diagnostics);
    let scheme = prim.word("subdivisionScheme");
    let is_loop = scheme.as_deref() == Some("loop");
    polygons.subdivides = match scheme.as_deref() {
        Some("catmullClark") => true,
        Some("loop") => polygons.counts.iter().all(|count| *count == 3),
        _ => false,
    };
    if polygons.subdivides && own.take().is_some() {
        diagnostics.report(
            "usd-subdivision",
            Verdict::Exact,
            "normals of subdivision surfaces",
            &path,
            "not used, as USD has it: the surface has its own",
        );
    }
    if is_loop && !polygons.subdivides {
        diagnostics.report(
            "usd-subdivision",
            Verdict::Lost,
            "subdivision by Loop's scheme of what is not of triangles alone",
            &path,
            "the polygons are rendered",
        );
    }
    // The scheme of files that say nothing is Catmull and Clark's, but programs that leave it out show polygons.
    polygons.smooth = own.is_none() && matches!(scheme.as_deref(), None | Some("loop"));
    if polygons.smooth && scheme.is_none() {
        diagnostics.report(
            "usd-subdivision",
            Verdict::Approximated,
            "meshes without a word on subdivision or normals",
            &path,
            "rendered as polygons with smooth normals, as Blender and viewers show them",
        );
    }
    polygons.normals = own;
    Some(polygons)
}

/// The normals: those of a primvar before those of the mesh.
fn normals(prim: &View, polygons: &Polygons, diagnostics: &mut Diagnostics) -> Option<Layer> {
    let name = ["primvars:normals", "normals"]
        .into_iter()
        .find(|name| prim.has(name) && prim.value(name).is_some())?;
    let fallback = if name == "normals" {
        Interpolation::Vertex
    } else {
        Interpolation::Constant
    };
    layer(prim, name, fallback, polygons, diagnostics).filter(|layer| layer.components == 3)
}

/// A primvar of a prim, or the constant one of what it stands below.
fn primvar(
    prim: &View,
    inherited: &Inherited,
    name: &str,
    polygons: &Polygons,
    diagnostics: &mut Diagnostics,
) -> Option<Layer> {
    let full = format!("primvars:{name}");
    if prim.has(&full) {
        return layer(prim, &full, Interpolation::Constant, polygons, diagnostics);
    }
    if let Some(known) = polygons.primvars.get(name) {
        return Some(known.clone());
    }
    let (components, values) = value::floats(inherited.primvars.get(name)?)?;
    Some(Layer {
        components,
        values,
        interpolation: Interpolation::Constant,
        indices: None,
    })
}

/// Values of an attribute over the mesh, if there are as many as there have to be.
fn layer(
    prim: &View,
    name: &str,
    fallback: Interpolation,
    polygons: &Polygons,
    diagnostics: &mut Diagnostics,
) -> Option<Layer> {
    let (components, values) = value::floats(&prim.value(name)?)?;
    let told = prim.property_word(name, "interpolation");
    let interpolation = match told.as_deref() {
        Some("constant") => Interpolation::Constant,
        Some("uniform") => Interpolation::Uniform,
        Some("vertex" | "varying") => Interpolation::Vertex,
        Some("faceVarying") => Interpolation::FaceVarying,
        _ => fallback,
    };
    let listed = prim.integers(&format!("{name}:indices"));
    let held = values.len() / components.max(1);
    let indices = match listed {
        None => None,
        Some(listed) => {
            let index = |i: &i64| u32::try_from(*i).ok().filter(|i| (*i as usize) < held);
            let all: Option<Vec<u32>> = listed.iter().map(index).collect();
            match all {
                Some(all) => Some(all),
                None => {
                    lose(
                        prim,
                        name,
                        "it refers to values that do not exist",
                        diagnostics,
                    );
                    return None;
                }
            }
        }
    };
    let there = indices.as_ref().map_or(held, Vec::len);
    let layer = Layer {
        components,
        values,
        interpolation,
        indices,
    };
    // Constant ones may be lists of which the first counts.
    if there < polygons.wanted(interpolation) {
        let wanted = polygons.wanted(interpolation);
        let why = format!("it has {there} values where {wanted} belong");
        lose(prim, name, &why, diagnostics);
        return None;
    }
    Some(layer)
}

fn lose(prim: &View, name: &str, why: &str, diagnostics: &mut Diagnostics) {
    diagnostics.report(
        "usd-primvar",
        Verdict::Lost,
        format!("\"{name}\" that cannot be used ({why})"),
        prim.path().to_string(),
        "left out, as if the mesh did not have it",
    );
}
