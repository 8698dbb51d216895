//! Where a stage's files are, and which of them may be read.

use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::collections::{HashMap, HashSet};
use std::io::{Cursor, Error, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::SystemTime;

use openusd::ar::{self, Asset, DefaultResolver, ResolvedPath, Resolver};
use openusd::sdf::AbstractData;

use super::classes::{self, Dropped, Layers};
use super::text::LeftOut;

/// Brackets inside brackets of a text: more than this is no scene, and the parser would follow them down its stack.
const MOST_NESTED: usize = 2000;

/// What is said where a name is that of another file but for these.
pub(super) const CAPITALS: &str = "capitals and small letters count";

/// What was asked for, but is not read.
#[derive(Debug, Default)]
pub(super) struct Refused {
    /// Files outside of the scene's folder.
    pub outside: Vec<String>,
    /// Files that are damaged, and how.
    pub damaged: Vec<(String, String)>,
    /// What is left out of the text of layers.
    pub left_out: Vec<(String, LeftOut)>,
    /// Arcs that lead back to where they began.
    pub circles: Vec<Dropped>,
}

/// Files beside the scene; shared between the stage and its reader.
#[derive(Clone)]
pub(super) struct Files {
    inner: Rc<Inner>,
}

struct Inner {
    plain: DefaultResolver,
    /// Nothing outside of this is read, if there is such a limit.
    folder: Option<PathBuf>,
    refused: RefCell<Refused>,
    /// Bytes that layers took.
    read: Cell<u64>,
    /// The scene file, until it has been looked at: its first reader wants the variables in its head alone.
    unseen: RefCell<Option<PathBuf>>,
    /// Texts are tried before they are given away, and what cannot be read in them is left out.
    careful: bool,
    /// Layers whose arcs have been looked at, and the arcs that they have to lose.
    looked_at: RefCell<HashSet<String>>,
    tangled: RefCell<HashMap<String, Vec<Dropped>>>,
}

/// Whether a name has a place of its own, on the network or on a drive of Windows.
fn has_a_place(name: &str) -> bool {
    let Some((scheme, rest)) = name.split_once(':') else {
        return false;
    };
    let letters = !scheme.is_empty() && scheme.bytes().all(|b| b.is_ascii_alphanumeric());
    letters && rest.starts_with(['/', '\\'])
}

/// Why a file is not there, if its name says so.
pub(super) fn missing(name: &str) -> Option<&'static str> {
    let network = has_a_place(name) && name.contains("://");
    network.then_some("lies on the network: download it, and name that file instead")
}

/// Why a file is of no kind that is read, if its name says so.
pub(super) fn foreign(name: &str) -> Option<&'static str> {
    let outer = name.split('[').next().unwrap_or(name);
    if name.contains(".usdz[") && name.trim_end_matches(']').ends_with(".usdz") {
        return Some("is a .usdz in a .usdz and not read: unpack the outer one");
    }
    let ending = outer.rsplit_once('.')?.1;
    let is = |other: &str| ending.eq_ignore_ascii_case(other);
    if is("mtlx") {
        return Some("is a MaterialX document and not read: export its materials into the stage");
    }
    if is("abc") || is("vdb") || is("obj") || is("gltf") || is("glb") {
        return Some("is of another format: convert it to USD first");
    }
    None
}

impl Files {
    /// Why a scene file is not opened, if a first look says so.
    pub(super) fn refusal(&self, path: &Path) -> Option<String> {
        let mut start = [0u8; 64];
        let read = regular(path).and_then(|mut file| file.read(&mut start));
        let start = &start[..read.unwrap_or(0)];
        if let Some(what) = crate::import::pointer(start) {
            return Some(format!("it is {what}"));
        }
        let begun = start.trim_ascii_start();
        if begun.is_empty() && start.len() < 64 {
            return Some("it is empty".into());
        }
        let kinds: [&[u8]; 4] = [b"#usda", b"PXR-USDC", b"PK", b"\xef\xbb\xbf"];
        if !kinds.iter().any(|kind| begun.starts_with(kind)) {
            return Some(
                "its first bytes are those of no USD file: neither of a text (#usda), nor of a binary layer (PXR-USDC), nor of a package"
                    .into(),
            );
        }
        let ending = path
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default();
        if !super::ENDINGS
            .iter()
            .any(|e| ending.eq_ignore_ascii_case(e))
        {
            return Some(
                "it is a USD file whose name does not say so: rename it to end in .usd".into(),
            );
        }
        if !start.starts_with(b"PK") {
            return None;
        }
        let Ok(archive) = zip::ZipArchive::new(regular(path).ok()?) else {
            return Some(
                "it is a package (.usdz) that is cut off or damaged: copy it again".into(),
            );
        };
        let first = archive.name_for_index(0)?;
        let ends = |name: &str, ending: &str| name.to_ascii_lowercase().ends_with(ending);
        if ends(first, ".usdz") {
            return Some(format!(
                "its first file \"{first}\" is a .usdz, and packages in packages are not read: unpack the outer one"
            ));
        }
        let is_layer = |name: &str| [".usd", ".usda", ".usdc"].iter().any(|e| ends(name, e));
        (!archive.file_names().any(is_layer)).then(|| {
            format!("there is no USD layer in it (its first file is \"{first}\"): pack it with one")
        })
    }

    /// For a scene file. `careful`: what the parser refuses in texts is left out of them.
    pub(super) fn new(scene: &Path, allow_outside: bool, careful: bool) -> Self {
        let scene = scene.canonicalize().unwrap_or_else(|_| scene.into());
        let folder = scene.parent().map(Path::to_path_buf);
        Self {
            inner: Rc::new(Inner {
                plain: DefaultResolver::new(),
                folder: folder.filter(|_| !allow_outside),
                refused: RefCell::default(),
                read: Cell::new(0),
                unseen: RefCell::new(Some(scene)),
                careful,
                looked_at: RefCell::default(),
                tangled: RefCell::default(),
            }),
        }
    }

    /// What was asked for in vain so far.
    pub(super) fn take_refused(&self) -> Refused {
        self.inner.refused.take()
    }

    /// Bytes of all layers.
    pub(super) fn bytes_read(&self) -> u64 {
        self.inner.read.get()
    }

    /// A file of the same name but for capitals, beside one that is not there or packed with it. What lies elsewhere is not told.
    pub(super) fn in_another_case(&self, path: &str) -> Option<String> {
        if ar::split_package_relative_path_outer(path).is_none() {
            let beside = Path::new(path).parent()?.canonicalize().ok()?;
            let limit = self.inner.folder.as_ref();
            if limit.is_some_and(|folder| !beside.starts_with(folder)) {
                return None;
            }
            return crate::import::gltf::in_another_case(Path::new(path));
        }
        let name = path.trim_end_matches(']').rsplit(['/', '[']).next()?;
        let wanted = name.to_lowercase();
        let mut names = siblings(path).into_iter();
        names.find(|other| other != name && other.to_lowercase() == wanted)
    }

    /// The place of a path that a layer names.
    pub(super) fn beside(&self, path: &str, layer: &str) -> String {
        // What has a place of its own does not lie beside anything.
        if has_a_place(path) {
            return path.to_owned();
        }
        let layer = ResolvedPath::new(layer);
        self.inner.named_by(path, Some(&layer))
    }

    /// All of a file, or why not.
    pub(super) fn read(&self, path: &str) -> Result<Vec<u8>, String> {
        let resolved = self.found(path)?;
        self.inner
            .bytes(&resolved)
            .map_err(|error| error.to_string())
    }

    /// Where a file is that is read in parts, or why it is not.
    pub(super) fn place(&self, path: &str) -> Result<PathBuf, String> {
        let resolved = self.found(path)?;
        if ar::split_package_relative_path_outer(path).is_some() {
            return Err("it is packed in a .usdz: unpack that".into());
        }
        // A device or a pipe might never end.
        regular(&resolved).map_err(|error| error.to_string())?;
        Ok(resolved.to_path_buf())
    }

    fn found(&self, path: &str) -> Result<ResolvedPath, String> {
        self.resolve(path).ok_or_else(|| {
            let mut refused = self.inner.refused.borrow_mut();
            let outside = refused.outside.iter().any(|p| p == path);
            if outside {
                refused.outside.retain(|p| p != path);
                "it lies outside of the scene's folder; --allow-outside reads it".into()
            } else {
                match missing(path) {
                    Some(why) => format!("it {why}"),
                    None => match self.in_another_case(path) {
                        Some(other) => {
                            format!("there is no such file, but there is \"{other}\": {CAPITALS}")
                        }
                        None => "there is no such file".into(),
                    },
                }
            }
        })
    }
}

impl Inner {
    /// The name of what a layer names. In a package, what is not beside the layer is looked for from the package's root, as
    /// USD's own does (`SdfComputeAssetPathRelativeToLayer`): its packer writes such paths.
    fn named_by(&self, asset: &str, by: Option<&ResolvedPath>) -> String {
        let beside = self.plain.create_identifier(asset, by);
        let anchored = asset.starts_with("./") || asset.starts_with("../");
        let package =
            by.and_then(|by| ar::split_package_relative_path_inner(&by.to_string_lossy()));
        let Some((package, _)) = package.filter(|_| !anchored && !self.is_packed(&beside)) else {
            return beside;
        };
        let root = self
            .plain
            .create_identifier(asset, Some(&ResolvedPath::new(&package)));
        if self.is_packed(&root) { root } else { beside }
    }

    /// Whether a package has a file, or a tile of a name with a place for numbers.
    fn is_packed(&self, name: &str) -> bool {
        let Some((before, _)) = name.split_once("<UDIM>") else {
            return self.plain.resolve(name).is_some();
        };
        let start = before.rsplit(['/', '[']).next().unwrap_or_default();
        siblings(name).iter().any(|other| other.starts_with(start))
    }

    /// Whether a file may be read; remembers it if not.
    fn is_inside(&self, path: &str) -> bool {
        let Some(folder) = &self.folder else {
            return true;
        };
        let outer = ar::split_package_relative_path_outer(path);
        let outer = outer.map_or_else(|| path.to_owned(), |(package, _)| package);
        let real = Path::new(&outer).canonicalize();
        let inside = real.is_ok_and(|real| real.starts_with(folder));
        if !inside {
            let mut refused = self.refused.borrow_mut();
            if !refused.outside.iter().any(|p| p == path) {
                refused.outside.push(path.into());
            }
        }
        inside
    }

    /// Remembers that a layer is damaged, and how.
    fn damaged(&self, layer: &ResolvedPath, fault: String) -> Error {
        let path = layer.to_string_lossy().into_owned();
        self.refused
            .borrow_mut()
            .damaged
            .push((path, fault.clone()));
        Error::other(fault)
    }

    /// A layer as the parser knows it, and whether it has arcs to classes, or sublayers. An error is why it is not parsed.
    fn prepared<'b>(
        &self,
        path: &str,
        bytes: Cow<'b, [u8]>,
        tell: bool,
    ) -> Result<(Cow<'b, [u8]>, bool), String> {
        if let Some(fault) = fault(&bytes) {
            return Err(fault);
        }
        if bytes.starts_with(b"PXR-USDC") {
            let words = super::crate_file::words(&bytes).unwrap_or_default();
            let arcs = ["inheritPaths", "specializes", "subLayers"];
            let arcs = words.iter().any(|word| arcs.contains(&&**word));
            return Ok((bytes, arcs));
        }
        if let Some(what) = crate::import::pointer(&bytes) {
            return Err(format!("it is {what}"));
        }
        if !bytes.starts_with(b"#usda") {
            return Ok((bytes, false));
        }
        let (text, mut left_out, arcs) = match bytes {
            Cow::Borrowed(bytes) => {
                let read = super::text::readable(bytes)?;
                (read.text, read.left_out, read.arcs)
            }
            Cow::Owned(bytes) => {
                let read = super::text::readable(&bytes)?;
                let changed = match read.text {
                    Cow::Owned(text) => Some(text),
                    Cow::Borrowed(_) => None,
                };
                let (left_out, arcs) = (read.left_out, read.arcs);
                (changed.unwrap_or(bytes).into(), left_out, arcs)
            }
        };
        let text = if self.careful {
            Cow::Owned(super::repair::repaired(text, &mut left_out)?)
        } else {
            text
        };
        if tell {
            // Layers are opened several times.
            let told = &mut self.refused.borrow_mut().left_out;
            if !told.iter().any(|(layer, _)| layer == path) {
                told.extend(left_out.into_iter().map(|part| (path.to_owned(), part)));
            }
        }
        Ok((text, arcs))
    }

    /// Takes the arcs out of a layer that lead back to where they began.
    fn untangle(&self, path: &str, bytes: &mut Vec<u8>) {
        if self.looked_at.borrow_mut().insert(path.to_owned()) {
            let found = classes::tangled(self, path);
            let mut tangled = self.tangled.borrow_mut();
            let known: HashSet<Dropped> = tangled.values().flatten().cloned().collect();
            for dropped in found.into_iter().filter(|d| !known.contains(d)) {
                let of_layer = tangled.entry(dropped.layer.clone()).or_default();
                of_layer.push(dropped.clone());
                self.refused.borrow_mut().circles.push(dropped);
            }
        }
        let tangled = self.tangled.borrow();
        let left = tangled.get(path).map(|gone| classes::without(bytes, gone));
        if let Some(left) = left.flatten() {
            *bytes = left;
        }
    }

    fn bytes(&self, resolved: &ResolvedPath) -> std::io::Result<Vec<u8>> {
        let path = resolved.to_string_lossy().into_owned();
        match ar::split_package_relative_path_outer(&path) {
            Some((package, inner)) => {
                let mut archive = zip::ZipArchive::new(regular(Path::new(&package))?)
                    .map_err(|error| Error::other(error.to_string()))?;
                let mut entry = archive
                    .by_name(&inner)
                    .map_err(|error| Error::other(error.to_string()))?;
                // The format forbids it, and what is packed could be of any size.
                if entry.compression() != zip::CompressionMethod::Stored {
                    return Err(Error::other(
                        "it is compressed inside its .usdz, which the format forbids: pack it again without compression",
                    ));
                }
                let mut bytes = Vec::new();
                entry.read_to_end(&mut bytes)?;
                Ok(bytes)
            }
            None => {
                let mut bytes = Vec::new();
                regular(resolved)?.read_to_end(&mut bytes)?;
                Ok(bytes)
            }
        }
    }
}

/// Names of the files in the folder of a path.
pub(super) fn siblings(path: &str) -> Vec<String> {
    if let Some((package, inner)) = ar::split_package_relative_path_outer(path) {
        let folder = inner.rsplit_once('/').map_or("", |(folder, _)| folder);
        let Ok(file) = std::fs::File::open(package) else {
            return Vec::new();
        };
        let Ok(archive) = zip::ZipArchive::new(file) else {
            return Vec::new();
        };
        let names = archive.file_names().filter_map(|name| {
            let (of, name) = name.rsplit_once('/').unwrap_or(("", name));
            (of == folder).then(|| name.to_owned())
        });
        return names.collect();
    }
    let Some(folder) = Path::new(path).parent() else {
        return Vec::new();
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect()
}

/// Opens a regular file: a device or a pipe might never end.
fn regular(path: &Path) -> std::io::Result<std::fs::File> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(Error::other("it is not a regular file"));
    }
    std::fs::File::open(path)
}

/// Why a layer's bytes are not parsed, if they are not.
fn fault(bytes: &[u8]) -> Option<String> {
    if bytes.starts_with(b"PXR-USDC") {
        return super::crate_file::fault(bytes);
    }
    if bytes.starts_with(b"PK") {
        return None;
    }
    let (mut depth, mut most) = (0usize, 0usize);
    for byte in bytes {
        match byte {
            b'{' | b'[' | b'(' => {
                depth += 1;
                most = most.max(depth);
            }
            b'}' | b']' | b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    (most > MOST_NESTED).then(|| format!("its brackets are nested {most} deep"))
}

impl Layers for Inner {
    fn named(&self, asset: &str, by: &str) -> String {
        let by = ResolvedPath::new(by);
        let name = self.named_by(asset, Some(&by));
        let resolved = self.plain.resolve(&name);
        resolved.map_or(name, |path| path.to_string_lossy().into_owned())
    }

    fn parsed(&self, layer: &str) -> Option<Box<dyn AbstractData>> {
        let resolved = self.plain.resolve(layer)?;
        if !self.is_inside(&resolved.to_string_lossy()) {
            return None;
        }
        let bytes = self.bytes(&resolved).ok()?;
        let (bytes, _) = self.prepared(layer, bytes.into(), false).ok()?;
        classes::parse(&bytes)
    }
}

impl Resolver for Files {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        if has_a_place(asset_path) {
            return asset_path.to_owned();
        }
        self.inner.named_by(asset_path, anchor)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        let resolved = self.inner.plain.resolve(asset_path)?;
        let path = resolved.to_string_lossy().into_owned();
        self.inner.is_inside(&path).then_some(resolved)
    }

    fn resolve_for_new_asset(&self, _: &str) -> Option<ResolvedPath> {
        None
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> std::io::Result<Box<dyn Asset>> {
        let bytes = self.inner.bytes(resolved_path)?;
        let size = bytes.len() as u64;
        self.inner.read.set(self.inner.read.get() + size);
        let unseen = self.inner.unseen.take();
        let path = resolved_path.to_string_lossy().into_owned();
        let unseen = unseen.is_some_and(|scene| *scene == **resolved_path);
        let head = Some(&*bytes).filter(|_| unseen && bytes.starts_with(b"#usda"));
        if let Some(head) = head.and_then(super::text::head) {
            self.inner.read.set(0);
            let head = self.inner.prepared(&path, head.into(), false);
            return match head {
                Ok((head, _)) => Ok(Box::new(Cursor::new(head.into_owned()))),
                Err(fault) => Err(self.inner.damaged(resolved_path, fault)),
            };
        }
        let prepared = self.inner.prepared(&path, bytes.into(), true);
        let (bytes, arcs) = prepared.map_err(|fault| self.inner.damaged(resolved_path, fault))?;
        let mut bytes = bytes.into_owned();
        if arcs {
            self.inner.untangle(&path, &mut bytes);
        }
        Ok(Box::new(Cursor::new(bytes)))
    }

    fn get_modification_timestamp(&self, _: &str, _: &ResolvedPath) -> Option<SystemTime> {
        None
    }
}
