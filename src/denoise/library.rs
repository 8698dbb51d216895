//! Where the library is looked for.

use crate::color::SearchPlaces;
use crate::ffi::oidn::{FILE, Library, OidnError};
use std::env;
use std::path::{Path, PathBuf};

/// Names a folder with the library, or one with it in `lib`; then no other is looked at.
const VARIABLE: &str = "OIDN_DIR";
/// Where `make setup` puts it.
const OF_SETUP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/.native/oidn/lib");

/// There is no library that can be opened: one sentence.
#[derive(Debug, thiserror::Error)]
pub enum NotFound {
    /// Nowhere.
    #[error(
        "Open Image Denoise is not on this machine: run `make setup`, install a Blender, set {VARIABLE} to the folder of {FILE}, or leave --denoise out{}",
        .0.as_ref().map_or_else(String::new, |error| format!(" ({error})"))
    )]
    Nowhere(Option<OidnError>),
    /// Not where the variable says.
    #[error(
        "{VARIABLE} is {0}, and there is no {FILE} in it or in its folder lib: correct it, or unset it"
    )]
    NotThere(String),
    /// What the variable names is no good.
    #[error("{VARIABLE} names a library that can't be used: {0}")]
    Named(OidnError),
}

/// Where a search looks. [`Places::of_this_process`] in the program; others in tests.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// What the variable names.
    pub named: Option<PathBuf>,
    /// Folders in this order.
    pub folders: Vec<PathBuf>,
    /// The system's loader is asked at last.
    pub system: bool,
}

impl Places {
    /// The variable; else the program's own folders, that of `make setup`, those of installed Blenders, the system's.
    pub fn of_this_process() -> Self {
        let mut folders = Vec::new();
        let program = env::current_exe().ok();
        if let Some(folder) = program.as_deref().and_then(Path::parent) {
            folders.extend([folder.to_owned(), folder.join("lib"), folder.join("../lib")]);
        }
        folders.push(PathBuf::from(OF_SETUP));
        let blenders = SearchPlaces::of_this_process().blenders();
        folders.extend(blenders.into_iter().map(|folder| folder.join("lib")));
        Self {
            named: env::var_os(VARIABLE)
                .filter(|value| !value.is_empty())
                .map(PathBuf::from),
            folders,
            system: true,
        }
    }

    /// Opens the first library that can be used. What a person named stands alone.
    pub(super) fn open(&self) -> Result<Library, NotFound> {
        let has_it = |folder: &PathBuf| folder.join(FILE).is_file();
        if let Some(named) = &self.named {
            let folder = [named.clone(), named.join("lib")].into_iter().find(has_it);
            let folder = folder.ok_or_else(|| NotFound::NotThere(named.display().to_string()))?;
            return Library::open(&folder).map_err(NotFound::Named);
        }
        // The first that is there and no good says why.
        let mut first = None;
        for folder in self.folders.iter().filter(|folder| has_it(folder)) {
            match Library::open(folder) {
                Ok(library) => return Ok(library),
                Err(error) => first = first.or(Some(error)),
            }
        }
        let system = self.system.then(|| Library::open(Path::new("")));
        match system {
            Some(Ok(library)) => Ok(library),
            Some(Err(_)) | None => Err(NotFound::Nowhere(first)),
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/denoise/library.rs"]
mod tests;
