//! Where a stage's files are, and which of them may be read.

use std::cell::{Cell, RefCell};
use std::io::{Cursor, Error, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::SystemTime;

use openusd::ar::{self, Asset, DefaultResolver, ResolvedPath, Resolver};

/// Brackets inside brackets of a text: more than this is no scene, and the parser would follow them down its stack.
const MOST_NESTED: usize = 2000;

/// What was asked for, but is not read.
#[derive(Debug, Default)]
pub(super) struct Refused {
    /// Files outside of the scene's folder.
    pub outside: Vec<String>,
    /// Files that are damaged, and how.
    pub damaged: Vec<(String, String)>,
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
}

impl Files {
    /// For a scene file.
    pub(super) fn new(scene: &Path, allow_outside: bool) -> Self {
        let scene = scene.canonicalize().unwrap_or_else(|_| scene.into());
        let folder = scene.parent().map(Path::to_path_buf);
        Self {
            inner: Rc::new(Inner {
                plain: DefaultResolver::new(),
                folder: folder.filter(|_| !allow_outside),
                refused: RefCell::default(),
                read: Cell::new(0),
                unseen: RefCell::new(Some(scene)),
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

    /// The place of a path that a layer names.
    pub(super) fn beside(&self, path: &str, layer: &str) -> String {
        let layer = ResolvedPath::new(layer);
        self.inner.plain.create_identifier(path, Some(&layer))
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
                "there is no such file".into()
            }
        })
    }

    /// Names of the files in the folder of a path.
    pub(super) fn siblings(&self, path: &str) -> Vec<String> {
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
}

impl Inner {
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

impl Resolver for Files {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        self.inner.plain.create_identifier(asset_path, anchor)
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
        if let Some(fault) = fault(&bytes) {
            return Err(self.inner.damaged(resolved_path, fault));
        }
        let unseen = self.inner.unseen.take();
        if bytes.starts_with(b"#usda") {
            let mut text = bytes.as_slice();
            if unseen.is_some_and(|scene| *scene == **resolved_path)
                && let Some(head) = super::text::head(text)
            {
                self.inner.read.set(0);
                text = head;
            }
            return match super::text::readable(text) {
                Ok(text) => Ok(Box::new(Cursor::new(text.into_owned()))),
                Err(fault) => Err(self.inner.damaged(resolved_path, fault)),
            };
        }
        Ok(Box::new(Cursor::new(bytes)))
    }

    fn get_modification_timestamp(&self, _: &str, _: &ResolvedPath) -> Option<SystemTime> {
        None
    }
}
