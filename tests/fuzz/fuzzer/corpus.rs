//! Damaged copies of real files: a scene with all that lies beside it, one file of which is damaged at a time.

use super::files::{nodes, replacement};
use super::kinds;
use super::rng::Rng;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use sundog::import::{AnimationTime, ImportOptions, load};

/// Larger files take long to read and are of no other kind than smaller ones.
const LARGEST: u64 = 3 << 20;
/// No file here takes so long, by far.
const PATIENCE: Duration = Duration::from_secs(30);

/// Scenes, which may name other files.
const SCENES: [&str; 6] = ["gltf", "glb", "usd", "usda", "usdc", "usdz"];

/// A scene of a corpus, a colour configuration, or a file that is opened by itself.
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
            "bin" | "glb" if folder.contains("draco") => "draco".into(),
            "bin" | "glb" if folder.contains("meshopt") => "meshopt".into(),
            _ if main == own => own,
            _ => format!("{own} of {main}"),
        }
    }
}

/// How a file's name ends, in small letters.
pub fn ending(path: &Path) -> String {
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
            let kind = ending(main);
            let beside = if SCENES.contains(&&*kind) {
                let mut named = sundog::import::named_files(main);
                named.retain(|path| {
                    path.metadata()
                        .is_ok_and(|m| m.is_file() && m.len() <= LARGEST)
                });
                named
            } else if kinds::is_alone(&kind) || kinds::is_configuration(&kind) {
                Vec::new()
            } else {
                continue;
            };
            list.extend(std::iter::once(main.clone()).chain(beside).map(|damaged| {
                let main = main.clone();
                Subject { main, damaged }
            }));
        }
    }
    list
}

/// Bytes with some damage.
pub fn damage(rng: &mut Rng, bytes: &[u8], kind: &str) -> Vec<u8> {
    if kind == "state"
        && rng.chance(0.9)
        && let Some(done) = damaged_state(rng, bytes)
    {
        return done;
    }
    let is_json = kind == "gltf" || bytes.starts_with(b"glTF");
    // Of what is packed the streams count.
    let of_tree = if ["draco", "meshopt"].contains(&kind) {
        0.2
    } else {
        0.7
    };
    if is_json
        && rng.chance(of_tree)
        && let Some(done) = damaged_tree(rng, bytes)
    {
        return done;
    }
    let mut bytes = bytes.to_vec();
    if std::str::from_utf8(&bytes).is_ok() && rng.chance(0.5) {
        another_number(rng, &mut bytes);
    }
    // What is refused at once tries little: a small change as often as many.
    let most = rng.pick(&[1, 1, 6]);
    let behind = if rng.chance(0.9) {
        behind_tree(&bytes)
    } else {
        0
    };
    for _ in 0..1 + rng.below(most) {
        if bytes.len() <= behind {
            break;
        }
        // Headers are where most goes wrong.
        let reach = ((bytes.len() - behind) as f64 * rng.pick(&[1.0, 1.0, 0.1, 0.01])) as usize;
        let at = behind + rng.below(reach.max(1));
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

/// Where the JSON of a binary glTF file ends; 0 of others.
fn behind_tree(bytes: &[u8]) -> usize {
    let length = bytes.get(12..16).filter(|_| bytes.starts_with(b"glTF"));
    let length = length.and_then(|length| length.try_into().ok().map(u32::from_le_bytes));
    length.map_or(0, |length| 20 + length as usize)
}

/// A text with another number in the place of one of its own.
fn another_number(rng: &mut Rng, text: &mut Vec<u8>) {
    let is_part = |byte: u8| byte.is_ascii_digit() || b".-+eE".contains(&byte);
    let starts = (0..text.len())
        .filter(|&at| text[at].is_ascii_digit() && (at == 0 || !is_part(text[at - 1])));
    let starts: Vec<usize> = starts.collect();
    if starts.is_empty() {
        return;
    }
    let at = starts[rng.below(starts.len())];
    let length = text[at..].iter().take_while(|&&byte| is_part(byte)).count();
    let other = rng.pick(&[
        "0",
        "1",
        "-1",
        "2",
        "129",
        "256",
        "65536",
        "1000000",
        "4294967296",
        "99999999999999999999",
        "1e39",
        "-1e39",
        "1e-45",
        "nan",
        "inf",
        "",
    ]);
    text.splice(at..at + length, other.bytes());
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
    let mut text = changed(rng, text)?;
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

/// JSON with other values at some places.
fn changed(rng: &mut Rng, text: &[u8]) -> Option<Vec<u8>> {
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
    serde_json::to_vec(&tree).ok()
}

/// A saved state that says something else in its header or its pixels, with the right checksum: it would be all that is looked at.
fn damaged_state(rng: &mut Rng, bytes: &[u8]) -> Option<Vec<u8>> {
    let line = bytes.iter().position(|&byte| byte == b'\n')? + 1;
    let length = u64::from_le_bytes(bytes.get(line..line + 8)?.try_into().ok()?);
    let rest = bytes.get(line + 8..bytes.len().checked_sub(32)?)?;
    let (header, packed) = rest.split_at_checked(usize::try_from(length).ok()?)?;
    let (mut header, mut packed) = (header.to_vec(), packed.to_vec());
    if rng.chance(0.5) {
        header = changed(rng, &header)?;
    } else if rng.chance(0.3) {
        packed = damage(rng, &packed, "");
    } else {
        let mut pixels = Vec::new();
        let unpacked = zstd::Decoder::new(&packed[..]).ok()?;
        unpacked.take(1 << 24).read_to_end(&mut pixels).ok()?;
        packed = zstd::encode_all(&damage(rng, &pixels, "")[..], 1).ok()?;
    }
    let length = (header.len() as u64).to_le_bytes();
    let mut whole = [&bytes[..line], &length, &header, &packed].concat();
    whole.extend(Sha256::digest(&whole));
    Some(whole)
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
        let mut all = vec![subject.main.clone()];
        if !kinds::is_alone(&ending(&subject.main)) {
            // Beside what glTF names, USD has layers of its own.
            all.extend(sundog::import::named_files(&subject.main));
            let beside = std::fs::read_dir(&home).ok()?;
            all.extend(beside.filter_map(|e| Some(e.ok()?.path())));
        }
        for file in all.iter().filter(|path| path.is_file()) {
            let Some(to) = place(file) else { continue };
            std::fs::create_dir_all(to.parent()?).ok()?;
            std::fs::copy(file, to).ok()?;
        }
        Some(Self {
            main: place(&subject.main)?,
            damaged: place(&subject.damaged)?,
            whole: std::fs::read(&subject.damaged).ok()?,
            kind: subject.kind(),
            _folder: folder,
        })
    }

    /// How the name of the damaged file ends.
    pub fn ending(&self) -> String {
        ending(&self.damaged)
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
        let open = || {
            if !SCENES.contains(&&*ending(&self.main)) {
                return kinds::open(&self.main);
            }
            match load(&self.main, &options) {
                Ok(_) => Ok(true),
                Err(error) => kinds::refused(&error),
            }
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
        outcome
    }
}

/// What came of one kind.
pub struct Tally {
    /// Damaged files that were tried …
    pub tried: u64,
    /// … of so many whole ones …
    pub files: usize,
    /// … and how many of them opened.
    pub opened: u64,
    /// What was wrong: which file by which seed, and the words.
    pub wrong: Vec<String>,
    /// The most memory that the process had meanwhile, bytes.
    pub most_memory: u64,
    /// Seconds.
    pub seconds: f64,
}

/// Damages subjects of one kind `each` times together, by seeds from `first` on. `before` is told each, `found` what fails.
pub fn try_kind(
    subjects: &[Subject],
    (each, first): (u64, u64),
    before: impl Fn(&str),
    found: impl Fn(&Copied, u64, &str),
) -> Tally {
    let begun = Instant::now();
    let mut tally = Tally {
        tried: 0,
        files: subjects.len(),
        opened: 0,
        wrong: Vec::new(),
        most_memory: 0,
        seconds: 0.0,
    };
    forget_most_memory();
    let share = each.div_ceil(subjects.len().max(1) as u64);
    for subject in subjects {
        let Some(copied) = Copied::of(subject) else {
            tally.wrong.push(format!(
                "{}: no copy of it can be made",
                subject.damaged.display()
            ));
            continue;
        };
        for seed in first..first + share {
            let name = format!("{} seed {seed}", subject.damaged.display());
            before(&name);
            tally.tried += 1;
            match copied.check(seed) {
                Ok(is_open) => tally.opened += u64::from(is_open),
                Err(wrong) => {
                    let told = format!("{name}: {wrong}");
                    found(&copied, seed, &told);
                    tally.wrong.push(told);
                }
            }
        }
    }
    tally.most_memory = most_memory();
    tally.seconds = begun.elapsed().as_secs_f64();
    tally
}

/// Subjects by their kinds.
pub fn by_kind(subjects: Vec<Subject>) -> BTreeMap<String, Vec<Subject>> {
    let mut kinds: BTreeMap<String, Vec<Subject>> = BTreeMap::new();
    for subject in subjects {
        kinds.entry(subject.kind()).or_default().push(subject);
    }
    kinds
}

/// Begins anew to watch how much memory the process has at most (`proc(5)`: 5 in clear_refs), where the system can.
fn forget_most_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// The most memory of the process since; 0 where the system does not say.
fn most_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.unwrap_or(0) << 10
}
