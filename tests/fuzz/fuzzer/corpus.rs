//! Damaged copies of real files: a scene with all that lies beside it, one file of which is damaged at a time.

use super::files::{nodes, replacement};
use super::rng::Rng;
use serde_json::Value;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use sundog::import::{AnimationTime, ImportOptions, load, load_environment};
use sundog::scene::Scene;

/// Larger files take long to read and are of no other kind than smaller ones.
const LARGEST: u64 = 3 << 20;
/// No file here takes so long, by far.
const PATIENCE: Duration = Duration::from_secs(30);

/// A scene of a corpus, or an image of light.
pub struct Subject {
    /// The file that is opened.
    pub main: PathBuf,
    /// What is damaged: itself or one beside it.
    pub damaged: PathBuf,
}

impl Subject {
    /// The kind of what is damaged.
    pub fn kind(&self) -> String {
        let main = ending(&self.main);
        let own = ending(&self.damaged);
        let folder = self.main.parent().and_then(Path::file_name);
        let folder = folder.unwrap_or_default().to_string_lossy().to_lowercase();
        match &*own {
            "bin" if folder.contains("draco") => "draco".into(),
            "bin" | "glb" if folder.contains("meshopt") => "meshopt".into(),
            _ if main == own => own,
            _ => format!("{own} of {main}"),
        }
    }
}

fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_lowercase()
}

/// All that can be damaged below a folder, in the order of their names.
pub fn subjects(folder: &Path) -> Vec<Subject> {
    let mut list = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder).into_iter().flatten();
        let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
        files.sort();
        folders.extend(files.iter().filter(|path| path.is_dir()).cloned());
        files.retain(|path| {
            path.metadata()
                .is_ok_and(|m| m.is_file() && m.len() <= LARGEST)
        });
        for main in &files {
            let is_scene = ["gltf", "glb", "usd", "usda", "usdc", "usdz"].contains(&&*ending(main));
            let is_light = ["hdr", "exr"].contains(&&*ending(main));
            if is_light {
                let (main, damaged) = (main.clone(), main.clone());
                list.push(Subject { main, damaged });
            }
            if !is_scene {
                continue;
            }
            let named = sundog::import::named_files(main);
            let all = std::iter::once(main.clone()).chain(named.into_iter().filter(|path| {
                path.metadata()
                    .is_ok_and(|m| m.is_file() && m.len() <= LARGEST)
            }));
            list.extend(all.map(|damaged| Subject {
                main: main.clone(),
                damaged,
            }));
        }
    }
    list
}

/// Bytes with some damage.
pub fn damage(rng: &mut Rng, bytes: &[u8], kind: &str) -> Vec<u8> {
    let is_json = kind == "gltf" || bytes.starts_with(b"glTF");
    if is_json
        && rng.chance(0.7)
        && let Some(done) = damaged_tree(rng, bytes)
    {
        return done;
    }
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + rng.below(6) {
        if bytes.is_empty() {
            break;
        }
        // Headers are where most goes wrong.
        let reach = (bytes.len() as f64 * rng.pick(&[1.0, 1.0, 0.1, 0.01])) as usize;
        let at = rng.below(reach.max(1));
        let end = (at + 1 + rng.below(16)).min(bytes.len());
        match rng.below(6) {
            0 => bytes[at] = rng.pick(&[0, 1, 127, 128, 255, 32]),
            1 => bytes[at] ^= 1 << rng.below(8),
            2 => {
                let value: u32 = rng.pick(&[0, 1, 0x7fff_ffff, 0x8000_0000, u32::MAX, 0x1_0000]);
                for (byte, new) in bytes[at..].iter_mut().zip(value.to_le_bytes()) {
                    *byte = new;
                }
            }
            3 => drop(bytes.drain(at..end)),
            4 => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            _ if rng.chance(0.2) => bytes.truncate(at),
            _ => bytes[at] = rng.below(256) as u8,
        }
    }
    bytes
}

/// The file with other values at some places of its JSON.
fn damaged_tree(rng: &mut Rng, bytes: &[u8]) -> Option<Vec<u8>> {
    let binary = bytes.starts_with(b"glTF");
    let (text, rest) = if binary {
        let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?) as usize;
        (bytes.get(20..20 + length)?, bytes.get(20 + length..)?)
    } else {
        (bytes, &[][..])
    };
    let mut tree: Value = serde_json::from_slice(text).ok()?;
    let mut places = Vec::new();
    nodes(&tree, String::new(), &mut places);
    for _ in 0..1 + rng.below(3) {
        let to = if rng.chance(0.3) {
            // Something of the same file, elsewhere.
            tree.pointer(&places[rng.below(places.len())])?.clone()
        } else {
            replacement(rng)
        };
        if let Some(part) = tree.pointer_mut(&places[rng.below(places.len())]) {
            *part = to;
        }
    }
    let mut text = serde_json::to_vec(&tree).ok()?;
    if !binary {
        return Some(text);
    }
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut file = bytes.get(..8)?.to_vec();
    file.extend(
        u32::try_from(20 + text.len() + rest.len())
            .ok()?
            .to_le_bytes(),
    );
    file.extend(u32::try_from(text.len()).ok()?.to_le_bytes());
    file.extend(b"JSON");
    file.extend(text);
    file.extend(rest);
    Some(file)
}

/// A copy of a subject and all that it names, to be damaged.
pub struct Copied {
    _folder: tempfile::TempDir,
    main: PathBuf,
    damaged: PathBuf,
    whole: Vec<u8>,
    kind: String,
}

impl Copied {
    /// Copies it; nothing of files that do not lie in its folder.
    pub fn of(subject: &Subject) -> Option<Self> {
        let folder = tempfile::tempdir().ok()?;
        let home = subject.main.parent()?.canonicalize().ok()?;
        let place = |path: &Path| {
            let real = path.canonicalize().ok()?;
            Some(folder.path().join(real.strip_prefix(&home).ok()?))
        };
        // Beside what glTF names, USD has layers of its own.
        let mut all = sundog::import::named_files(&subject.main);
        let beside = std::fs::read_dir(&home).ok()?;
        all.extend(beside.filter_map(|e| Some(e.ok()?.path())));
        for file in all.iter().filter(|path| path.is_file()) {
            let Some(to) = place(file) else { continue };
            std::fs::create_dir_all(to.parent()?).ok()?;
            std::fs::copy(file, to).ok()?;
        }
        Some(Self {
            main: place(&subject.main)?,
            damaged: place(&subject.damaged)?,
            whole: std::fs::read(&subject.damaged).ok()?,
            kind: ending(&subject.damaged),
            _folder: folder,
        })
    }

    /// The damaged bytes of a seed.
    pub fn bytes(&self, seed: u64) -> Vec<u8> {
        damage(&mut Rng::new(seed), &self.whole, &self.kind)
    }

    /// Opens the scene with the damage of a seed; says what is wrong, and whether it was opened.
    pub fn check(&self, seed: u64) -> Result<bool, String> {
        std::fs::write(&self.damaged, self.bytes(seed)).map_err(|e| e.to_string())?;
        let begun = Instant::now();
        let options = ImportOptions {
            animation: seed.is_multiple_of(2).then_some(AnimationTime {
                name: None,
                seconds: 0.3,
                frame: None,
            }),
            ..ImportOptions::default()
        };
        let open = || match &*ending(&self.main) {
            "hdr" | "exr" => load_environment(&mut Scene::default(), &self.main, 1.0, 0.0)
                .map(drop)
                .map_err(|e| e.to_string()),
            _ => load(&self.main, &options)
                .map(drop)
                .map_err(|e| e.to_string()),
        };
        let outcome = catch_unwind(AssertUnwindSafe(open));
        let outcome = outcome.map_err(|panic| {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|t| (*t).to_owned()));
            format!("panic, {}", text.unwrap_or_default())
        })?;
        if begun.elapsed() > PATIENCE {
            return Err(format!("it takes {:.0} s", begun.elapsed().as_secs_f64()));
        }
        match outcome {
            Ok(()) => Ok(true),
            Err(sentence) if sentence.is_empty() || sentence.contains('\n') => {
                Err(format!("a refusal that is no sentence: {sentence:?}"))
            }
            Err(_) => Ok(false),
        }
    }
}
