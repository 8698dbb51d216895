//! The walk over a stage's prims: what they place, and where.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::DAffine3;
use openusd::sdf::{Path, Specifier, Value};

use super::binding::{self, Bindings};
use super::geometry::Shapes;
use super::instances;
use super::lights::{self, Lamp};
use super::skeleton::Binding;
use super::source::{Source, View};
use super::{camera, transform, value};
use crate::import::ImportError;
use crate::scene::{Camera, Diagnostics, Verdict};

/// More placed copies than this would be an accident: each takes memory in the renderer.
pub(super) const MOST_PLACED: usize = 1 << 24;
/// Prims below prims: no scene is deeper.
const DEEPEST: usize = 1000;

/// What is placed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Thing {
    /// Meshes of one prim.
    Shape(usize),
    /// A lamp.
    Lamp(usize),
    /// A camera.
    Camera(usize),
}

/// Something in its place.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub thing: Thing,
    pub name: Rc<str>,
    pub matrix: DAffine3,
    /// The prim that it is, or the instance that it is a part of.
    pub path: Path,
    /// Colour and opacity of its own.
    pub color: Option<[f32; 4]>,
    /// It stands there whatever is done to what it is a part of.
    absolute: bool,
}

impl Item {
    /// A sphere of a Points prim.
    pub(super) fn of_point(
        (shape, name): (usize, Rc<str>),
        inherited: &Inherited,
        local: &DAffine3,
        (path, color): (&Path, Option<[f32; 4]>),
    ) -> Self {
        Self {
            thing: Thing::Shape(shape),
            name,
            matrix: inherited.matrix * *local,
            path: path.clone(),
            color,
            absolute: inherited.absolute,
        }
    }

    fn moved(&self, by: &DAffine3) -> Self {
        let matrix = if self.absolute {
            self.matrix
        } else {
            *by * self.matrix
        };
        Self {
            matrix,
            ..self.clone()
        }
    }
}

/// What prims have from those they stand below.
#[derive(Clone)]
pub(super) struct Inherited {
    pub matrix: DAffine3,
    pub absolute: bool,
    pub bindings: Bindings,
    pub skin: Binding,
    /// Instances have colours of their own, which are those of what has none.
    pub object_colors: bool,
    /// It is for the picture, and not for previews or tools.
    rendered: bool,
    /// It is invisible: cameras and settings alone count.
    hidden: bool,
    /// Constant primvars.
    pub primvars: Rc<BTreeMap<String, Value>>,
    /// Those of what the prim stands below.
    pub primvars_above: Rc<BTreeMap<String, Value>>,
    /// Blender's name of the object.
    pub object: Option<Rc<str>>,
    depth: usize,
}

impl Inherited {
    /// Whether it is in the picture.
    fn is_seen(&self) -> bool {
        self.rendered && !self.hidden
    }

    fn nothing() -> Self {
        Self {
            matrix: DAffine3::IDENTITY,
            absolute: false,
            bindings: None,
            skin: Binding::default(),
            object_colors: false,
            rendered: true,
            hidden: false,
            primvars: Rc::default(),
            primvars_above: Rc::default(),
            object: None,
            depth: 0,
        }
    }
}

/// Places in memory of what a prototype has from above: the same ones mean the same.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    prototype: String,
    bindings: usize,
    primvars: usize,
    skin: String,
    rendered: bool,
    hidden: bool,
    object_colors: bool,
    object: Option<Rc<str>>,
}

/// Items of a prototype, and what keeps the places in memory of its key taken.
struct Prototype {
    items: Rc<Vec<Item>>,
    _kept: (Bindings, Rc<BTreeMap<String, Value>>),
}

/// The walk.
pub(super) struct Walk<'a, 'd> {
    pub source: &'a Source,
    pub diagnostics: &'d mut Diagnostics,
    pub shapes: Shapes<'a>,
    pub lamps: Vec<Lamp>,
    pub cameras: Vec<Camera>,
    /// The stage's cameras by their paths, for render settings.
    pub camera_paths: Vec<String>,
    /// Paths of prims with settings of renders.
    pub settings: Vec<Path>,
    prototypes: HashMap<Key, Prototype>,
    /// Prototypes that are being walked: they cannot be parts of themselves.
    open: Vec<String>,
}

impl<'a, 'd> Walk<'a, 'd> {
    pub(super) fn new(
        source: &'a Source,
        shapes: Shapes<'a>,
        diagnostics: &'d mut Diagnostics,
    ) -> Self {
        Self {
            source,
            diagnostics,
            shapes,
            lamps: Vec::new(),
            cameras: Vec::new(),
            camera_paths: Vec::new(),
            settings: Vec::new(),
            prototypes: HashMap::new(),
            open: Vec::new(),
        }
    }

    /// Walks all of the stage.
    pub(super) fn run(&mut self) -> Result<Vec<Item>, ImportError> {
        let mut items = Vec::new();
        self.children(&Path::abs_root(), &Inherited::nothing(), &mut items)?;
        Ok(items)
    }

    fn children(
        &mut self,
        parent: &Path,
        inherited: &Inherited,
        items: &mut Vec<Item>,
    ) -> Result<(), ImportError> {
        let children = self.source.stage.prim(parent.clone()).children();
        for child in self.source.told(parent, children).unwrap_or_default() {
            let path = child.path();
            let defined = self.source.told(path, child.specifier()).flatten();
            // What it stands below is active, or this place would not be reached.
            let active = self.source.stage.attribute(path.clone());
            let active = self
                .source
                .told(path, active.get_metadata::<bool>("active"));
            if defined == Some(Specifier::Def) && active != Some(Some(false)) {
                self.visit(path, inherited, items)?;
            }
        }
        Ok(())
    }

    /// What a prim places, with all below it.
    fn visit(
        &mut self,
        path: &Path,
        above: &Inherited,
        items: &mut Vec<Item>,
    ) -> Result<(), ImportError> {
        if above.depth > DEEPEST {
            self.diagnostics.report(
                "usd-depth",
                Verdict::Lost,
                format!("prims more than {DEEPEST} levels deep"),
                path.to_string(),
                "left out",
            );
            return Ok(());
        }
        let prim = self.source.view(path);
        let kind = prim.kind();
        if matches!(&*kind, "Material" | "Shader" | "NodeGraph" | "GeomSubset") {
            return Ok(());
        }
        let inherited = self.below(&prim, &kind, above);
        match &*kind {
            // Neither visibility nor a purpose says that nobody looks through a camera.
            "Camera" => self.place(&prim, &kind, &inherited, items)?,
            "PointInstancer" if inherited.hidden => return Ok(()),
            "PointInstancer" => {
                return instances::of_instancer(self, &prim, &inherited, items);
            }
            "Points" if inherited.is_seen() => {
                instances::of_points(self, &prim, &inherited, items)?;
            }
            "RenderSettings" | "RenderProduct" => self.settings.push(path.clone()),
            _ if inherited.is_seen() => self.place(&prim, &kind, &inherited, items)?,
            _ => {}
        }
        if !inherited.hidden {
            self.tell_of_draw_mode(&prim);
            self.tell_of_color_space(&prim);
        }
        let instance = self.source.told(path, prim.prim.is_instance());
        if instance == Some(true) {
            // What it is composed of besides its own words, which count for the instance alone.
            let stack = self.source.told(path, prim.prim.prim_stack());
            let mut stack = stack.unwrap_or_default();
            stack.retain(|(_, site)| site != path);
            let prototype = format!("{stack:?}");
            // An instance inside of an instance has its parts in the prototype of the outer one alone.
            let inside = self.source.told(path, prim.prim.prim_in_prototype());
            let inside = inside.flatten().map(|prim| prim.path().clone());
            let inside = inside.as_ref().unwrap_or(path);
            let mut at_origin = inherited.clone();
            at_origin.skin = inherited.skin.in_instance(path, inside, &inherited.matrix);
            at_origin.matrix = DAffine3::IDENTITY;
            at_origin.absolute = false;
            let found = self.prototype(prototype, inside, false, at_origin)?;
            let place = (&inherited.matrix, inherited.absolute);
            return self.push_all(&found, place, (path, None), items);
        }
        self.children(path, &inherited, items)
    }

    /// What a prim hands down.
    fn below(&mut self, prim: &View, kind: &str, above: &Inherited) -> Inherited {
        // A scope and a prim without a kind have no place of their own, whatever they say.
        let local = match kind {
            "" | "Scope" => transform::Local::nowhere(),
            _ => transform::local(prim, self.diagnostics),
        };
        let mut inherited = above.clone();
        inherited.depth += 1;
        inherited.primvars_above = above.primvars.clone();
        inherited.matrix = if local.resets {
            local.matrix
        } else {
            above.matrix * local.matrix
        };
        inherited.absolute |= local.resets;
        inherited.skin = above.skin.below(prim, kind, &inherited.matrix);
        // What is not of a kind that can be seen can be neither hidden nor for a purpose.
        let invisible = prim.word("visibility").as_deref() == Some("invisible");
        inherited.hidden |= invisible && !kind.is_empty();
        let named = prim.word("userProperties:blender:object_name");
        if let Some(name) = named {
            inherited.object = Some(name.into());
        }
        if inherited.hidden {
            return inherited;
        }
        inherited.bindings = binding::below(self.source, &above.bindings, prim);
        binding::report(self.source, prim, self.diagnostics);
        let purpose = prim.word("purpose").filter(|_| !kind.is_empty());
        match purpose.as_deref() {
            Some("default" | "render") => inherited.rendered = true,
            Some(purpose @ ("proxy" | "guide")) => {
                inherited.rendered = false;
                self.diagnostics.report(
                    "usd-purpose",
                    Verdict::Exact,
                    format!("prims of the purpose \"{purpose}\""),
                    prim.path().to_string(),
                    "not in the picture: they stand for others, or guide the eye",
                );
            }
            _ => {}
        }
        let mut constant: Vec<&String> = prim.names.iter().collect();
        constant.retain(|name| {
            name.starts_with("primvars:")
                && !name.ends_with(":indices")
                && matches!(
                    prim.property_word(name, "interpolation").as_deref(),
                    None | Some("constant")
                )
        });
        if !constant.is_empty() {
            let mut primvars = BTreeMap::clone(&inherited.primvars);
            for name in constant {
                if let Some(value) = prim.value(name) {
                    let listed = prim.integers(&format!("{name}:indices"));
                    let value = listed
                        .and_then(|listed| value::picked(&value, &listed))
                        .unwrap_or(value);
                    primvars.insert(name["primvars:".len()..].to_owned(), value);
                }
            }
            inherited.primvars = Rc::new(primvars);
        }
        inherited
    }

    /// Places what the prim itself is.
    fn place(
        &mut self,
        prim: &View,
        kind: &str,
        inherited: &Inherited,
        items: &mut Vec<Item>,
    ) -> Result<(), ImportError> {
        let name: Rc<str> = match &inherited.object {
            Some(name) => name.clone(),
            None => prim.name().into(),
        };
        let mut matrix = inherited.matrix;
        let thing = if kind == "Camera" {
            let camera = camera::load(prim, &name, self.diagnostics);
            self.cameras.push(camera);
            self.camera_paths.push(prim.path().to_string());
            Some(Thing::Camera(self.cameras.len() - 1))
        } else if lights::is_light(prim, kind) {
            let lamp = lights::load(prim, kind, &name, self.source, self.diagnostics);
            lamp.map(|lamp| {
                self.lamps.push(lamp);
                Thing::Lamp(self.lamps.len() - 1)
            })
        } else {
            let shape = self
                .shapes
                .load(prim, kind, inherited, &name, self.diagnostics)?;
            // What hangs on a skeleton stands where that does.
            let stands = shape.as_ref().and_then(|shape| shape.stands);
            matrix = stands.unwrap_or(matrix);
            shape.map(|shape| Thing::Shape(shape.number))
        };
        let Some(thing) = thing else {
            return Ok(());
        };
        self.push(
            Item {
                thing,
                name,
                matrix,
                path: prim.path().clone(),
                color: None,
                absolute: inherited.absolute,
            },
            items,
        )
    }

    pub(super) fn push(&self, item: Item, items: &mut Vec<Item>) -> Result<(), ImportError> {
        if items.len() >= MOST_PLACED {
            return Err(ImportError::malformed(
                &self.source.file,
                "the stage",
                format!("it places more than {MOST_PLACED} meshes and lights"),
            ));
        }
        items.push(item);
        Ok(())
    }

    /// Places what a prototype places, as parts of the prim at `path`.
    pub(super) fn push_all(
        &self,
        found: &[Item],
        (matrix, absolute): (&DAffine3, bool),
        (path, color): (&Path, Option<[f32; 4]>),
        items: &mut Vec<Item>,
    ) -> Result<(), ImportError> {
        for item in found {
            let mut moved = item.moved(matrix);
            moved.absolute |= absolute;
            moved.path = path.clone();
            // An inner instancer's own comes first.
            moved.color = moved.color.or(color);
            self.push(moved, items)?;
        }
        Ok(())
    }

    /// What a prototype places, the first time as it is found at `path`. `whole`: the prim there is part of it.
    pub(super) fn prototype(
        &mut self,
        prototype: String,
        path: &Path,
        whole: bool,
        inherited: Inherited,
    ) -> Result<Rc<Vec<Item>>, ImportError> {
        let bindings = inherited.bindings.as_ref();
        let key = Key {
            prototype: prototype.clone(),
            bindings: bindings.map_or(0, |level| Rc::as_ptr(level) as usize),
            primvars: Rc::as_ptr(&inherited.primvars) as usize,
            skin: inherited.skin.key(),
            rendered: inherited.rendered,
            hidden: inherited.hidden,
            object_colors: inherited.object_colors,
            object: inherited.object.clone(),
        };
        if let Some(known) = self.prototypes.get(&key) {
            return Ok(known.items.clone());
        }
        if self.open.contains(&prototype) {
            self.diagnostics.report(
                "usd-cycle",
                Verdict::Lost,
                "instances of themselves",
                path.to_string(),
                "left out",
            );
            return Ok(Rc::default());
        }
        self.open.push(prototype);
        let mut items = Vec::new();
        if whole {
            self.visit(path, &inherited, &mut items)?;
        } else {
            self.children(path, &inherited, &mut items)?;
        }
        self.open.pop();
        let items = Rc::new(items);
        let _kept = (inherited.bindings, inherited.primvars);
        let known = Prototype {
            items: items.clone(),
            _kept,
        };
        self.prototypes.insert(key, known);
        Ok(items)
    }

    /// Bindings of all that a prim stands below.
    pub(super) fn bindings_above(&self, path: &Path) -> Bindings {
        let mut above: Vec<Path> = path.ancestors_below_root().skip(1).collect();
        above.reverse();
        let start: Bindings = None;
        above.iter().fold(start, |bindings, path| {
            binding::below(self.source, &bindings, &self.source.view(path))
        })
    }

    /// Colours are linear Rec.709, as USD has them without a word.
    fn tell_of_color_space(&mut self, prim: &View) {
        for name in ["colorSpace:name", "renderingColorSpace"] {
            let space = prim.word(name).unwrap_or_default();
            let ours = ["", "lin_rec709", "lin_rec709_scene", "lin_srgb"];
            if !ours.contains(&&*space) {
                self.diagnostics.report(
                    "usd-colour-space",
                    Verdict::Approximated,
                    format!("colours in the space \"{space}\""),
                    prim.path().to_string(),
                    "read as linear Rec.709",
                );
            }
        }
    }

    fn tell_of_draw_mode(&mut self, prim: &View) {
        if let Some(mode) = prim.word("model:drawMode")
            && !matches!(&*mode, "default" | "inherited")
        {
            self.diagnostics.report(
                "usd-draw-mode",
                Verdict::Approximated,
                format!("models that are to be drawn as \"{mode}\""),
                prim.path().to_string(),
                "their full geometry is rendered",
            );
        }
    }
}
