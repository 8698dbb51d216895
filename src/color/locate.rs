//! Where the colour configuration comes from: the flag, `$OCIO`, an installed Blender, an installed `bpy`, and at last
//! OpenColorIO's own built-in one.

use std::env;
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::path::{Path, PathBuf};

/// A configuration's file or `ocio://` name, and who named it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ConfigOrigin {
    /// The flag `--ocio`.
    Flag(PathBuf),
    /// The environment variable `OCIO`.
    Environment(PathBuf),
    /// The scene's file.
    Scene(PathBuf),
    /// An installed Blender.
    Blender(PathBuf),
    /// An installed Python module `bpy`.
    Bpy(PathBuf),
    /// Nothing else was there: the default one inside OpenColorIO.
    BuiltIn(PathBuf),
}

impl ConfigOrigin {
    /// The file, or the `ocio://` name.
    pub fn path(&self) -> &Path {
        match self {
            Self::Flag(path)
            | Self::Environment(path)
            | Self::Scene(path)
            | Self::Blender(path)
            | Self::Bpy(path)
            | Self::BuiltIn(path) => path,
        }
    }

    /// Who named it, in a few words.
    pub fn named_by(&self) -> &'static str {
        match self {
            Self::Flag(_) => "given with --ocio",
            Self::Environment(_) => "named by $OCIO",
            Self::Scene(_) => "named by the scene",
            Self::Blender(_) => "of an installed Blender",
            Self::Bpy(_) => "of an installed bpy",
            Self::BuiltIn(_) => "built into OpenColorIO",
        }
    }

    /// It came from a search, not from a person.
    pub(super) fn was_searched_for(&self) -> bool {
        matches!(self, Self::Blender(_) | Self::Bpy(_))
    }
}

impl fmt::Display for ConfigOrigin {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} ({})", self.path().display(), self.named_by())
    }
}

/// Whether a configuration's path is the name of one inside OpenColorIO.
pub(super) fn is_built_in_name(path: &Path) -> bool {
    path.as_os_str().as_encoded_bytes().starts_with(b"ocio://")
}

/// The default configuration inside OpenColorIO.
pub(super) const BUILT_IN: &str = "ocio://default";

/// Where a search looks. [`SearchPlaces::of_this_process`] in the program; others in tests.
#[derive(Debug, Clone, Default)]
pub struct SearchPlaces {
    /// `$OCIO`.
    pub ocio: Option<OsString>,
    /// `$PATH`.
    pub path: Option<OsString>,
    /// The user's folder.
    pub home: Option<PathBuf>,
    /// `$XDG_CACHE_HOME`; else `~/.cache`.
    pub cache: Option<PathBuf>,
    /// `$VIRTUAL_ENV`.
    pub virtual_env: Option<PathBuf>,
    /// The root of the file system.
    pub root: PathBuf,
}

impl SearchPlaces {
    /// What this process's environment says.
    pub fn of_this_process() -> Self {
        let folder = |name: &str| {
            env::var_os(name)
                .filter(|value| !value.is_empty())
                .map(PathBuf::from)
        };
        let home = folder("HOME");
        Self {
            ocio: env::var_os("OCIO"),
            path: env::var_os("PATH"),
            cache: folder("XDG_CACHE_HOME")
                .or_else(|| home.as_ref().map(|home| home.join(".cache"))),
            home,
            virtual_env: folder("VIRTUAL_ENV"),
            root: PathBuf::from("/"),
        }
    }

    /// What to try, in this order, until one can be read. What a person named stands alone: if it cannot be read, that is
    /// an error and not a reason to take another.
    pub(super) fn candidates(&self, flag: Option<&Path>) -> Vec<ConfigOrigin> {
        if let Some(path) = flag {
            return vec![ConfigOrigin::Flag(path.to_owned())];
        }
        if let Some(path) = self.ocio.as_ref().filter(|path| !path.is_empty()) {
            return vec![ConfigOrigin::Environment(PathBuf::from(path))];
        }
        let mut found = Vec::new();
        let mut add = |origin: ConfigOrigin| {
            if !found.contains(&origin) {
                found.push(origin);
            }
        };
        for config in self
            .blender_of_path()
            .into_iter()
            .chain(self.other_blenders())
        {
            add(ConfigOrigin::Blender(config));
        }
        for config in self.bpys() {
            add(ConfigOrigin::Bpy(config));
        }
        found.push(ConfigOrigin::BuiltIn(PathBuf::from(BUILT_IN)));
        found
    }

    /// Whether a configuration is one that this machine has anyway: `$OCIO` names it, or it is an installed Blender's.
    pub fn has(&self, config: &Path) -> bool {
        let Ok(config) = config.canonicalize() else {
            return false;
        };
        let search = Self {
            ocio: None,
            ..self.clone()
        };
        search
            .candidates(None)
            .iter()
            .map(ConfigOrigin::path)
            .chain(self.ocio.as_deref().map(Path::new))
            .any(|path| path.canonicalize().is_ok_and(|path| path == config))
    }

    /// Folders of installed Blenders and `bpy` modules, in the order in which their configurations are looked for.
    pub fn blenders(&self) -> Vec<PathBuf> {
        let search = Self {
            ocio: None,
            ..self.clone()
        };
        let mut folders: Vec<PathBuf> = Vec::new();
        for origin in search.candidates(None) {
            // `datafiles/colormanagement/config.ocio` in the folder, or in one of a version there.
            let data = origin.path().ancestors().nth(3).map(Path::to_owned);
            let folder = data.and_then(|data| match version_in(data.file_name()) {
                Some(_) => data.parent().map(Path::to_owned),
                None => Some(data),
            });
            folders.extend(
                folder.filter(|folder| origin.was_searched_for() && !folders.contains(folder)),
            );
        }
        folders
    }

    /// The Blender that starts when one types `blender`.
    fn blender_of_path(&self) -> Vec<PathBuf> {
        let Some(path) = &self.path else {
            return Vec::new();
        };
        let program = env::split_paths(path)
            .map(|folder| folder.join("blender"))
            .find(|program| program.is_file());
        // Links lead to the folder of the real program, which its version's folder lies beside.
        let folder = program
            .and_then(|program| program.canonicalize().ok())
            .and_then(|real| real.parent().map(Path::to_owned));
        folder
            .map(|folder| newest_first(configs_in(&folder)))
            .unwrap_or_default()
    }

    /// Blenders in the places where archives, distributions and shops put them; the newest first.
    fn other_blenders(&self) -> Vec<PathBuf> {
        let mut folders = vec![
            self.root.join("usr/share/blender"),
            self.root.join("usr/local/share/blender"),
        ];
        folders.extend(children_starting_with(&self.root.join("opt"), "blender"));
        folders.push(self.root.join("snap/blender/current"));
        let flatpak = "app/org.blender.Blender/current/active/files/blender";
        folders.push(self.root.join("var/lib/flatpak").join(flatpak));
        if let Some(home) = &self.home {
            folders.extend(children_starting_with(home, "blender"));
            folders.push(home.join(".local/share/flatpak").join(flatpak));
            folders.push(home.join(".local/share/Steam/steamapps/common/Blender"));
            folders.push(home.join(".steam/steam/steamapps/common/Blender"));
        }
        newest_first(
            folders
                .iter()
                .flat_map(|folder| configs_in(folder))
                .collect(),
        )
    }

    /// `bpy` modules: the active virtual environment's, then the newest of the others.
    fn bpys(&self) -> Vec<PathBuf> {
        let mut active = Vec::new();
        if let Some(environment) = &self.virtual_env {
            active = newest_first(bpys_below(&environment.join("lib")));
        }
        let mut others = Vec::new();
        if let Some(cache) = &self.cache {
            for environment in children_starting_with(&cache.join("sundog"), "bpy-") {
                others.extend(bpys_below(&environment.join("lib")));
            }
        }
        if let Some(home) = &self.home {
            others.extend(bpys_below(&home.join(".local/lib")));
        }
        others.extend(bpys_below(&self.root.join("usr/local/lib")));
        others.extend(bpys_below(&self.root.join("usr/lib")));
        active.extend(newest_first(others));
        active
    }
}

/// The configurations of the `bpy` modules in `lib/python3*/{site,dist}-packages`.
fn bpys_below(lib: &Path) -> Vec<PathBuf> {
    let pythons = children_starting_with(lib, "python3");
    let packages = pythons.iter().flat_map(|python| {
        [
            python.join("site-packages/bpy"),
            python.join("dist-packages/bpy"),
        ]
    });
    packages.flat_map(|package| configs_in(&package)).collect()
}

/// The configurations in a folder that has Blender's data in it, or folders of versions with the data in them.
fn configs_in(folder: &Path) -> Vec<PathBuf> {
    let in_data = Path::new("datafiles/colormanagement/config.ocio");
    let versions = children_starting_with(folder, "")
        .into_iter()
        .filter(|child| version_in(child.file_name()).is_some());
    let mut configs: Vec<PathBuf> = versions.map(|version| version.join(in_data)).collect();
    configs.push(folder.join(in_data));
    configs.retain(|config| config.is_file());
    configs
}

/// Folders whose names start so, in the order of their names; none if the parent cannot be read.
fn children_starting_with(parent: &Path, start: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(parent) else {
        return Vec::new();
    };
    let mut children: Vec<PathBuf> = entries
        .flatten()
        .filter(|entry| {
            entry
                .file_name()
                .as_encoded_bytes()
                .starts_with(start.as_bytes())
        })
        .map(|entry| entry.path())
        .filter(|path| path.is_dir())
        .collect();
    children.sort();
    children
}

/// `4.5` of a folder's name.
fn version_in(name: Option<&OsStr>) -> Option<(u32, u32)> {
    let (major, minor) = name?.to_str()?.split_once('.')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

/// Sorted by the version in the path (unknown ones last), keeping the order among equals.
fn newest_first(mut configs: Vec<PathBuf>) -> Vec<PathBuf> {
    configs.sort_by_key(|config| {
        std::cmp::Reverse(
            config
                .components()
                .rev()
                .find_map(|part| version_in(Some(part.as_os_str()))),
        )
    });
    configs
}

#[cfg(test)]
#[path = "../../tests/unit/color/locate.rs"]
mod tests;
