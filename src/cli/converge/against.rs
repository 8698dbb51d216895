//! `--against FOLDER`: pictures of other renderers with their times (docs/converge.md).

use super::super::Failure;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The end of the names of the files that tell times.
const TIMES: &str = "times.json";

/// A renderer and its pictures.
#[derive(Debug)]
pub struct Peer {
    /// What it is called.
    pub name: String,
    /// Where its pictures lie.
    pub folder: PathBuf,
    /// Its pictures.
    pub pictures: Vec<Entry>,
    /// None, one or two pictures that are taken for its truth.
    pub reference: Vec<PathBuf>,
}

/// A picture.
#[derive(Debug)]
pub struct Entry {
    /// Its file.
    pub path: PathBuf,
    /// Samples a pixel.
    pub samples: u32,
    /// Seconds of path tracing.
    pub seconds: f64,
    /// Which run it belongs to.
    pub seed: u64,
}

/// What a file of times says.
#[derive(Deserialize)]
struct Times {
    renderer: String,
    pictures: Vec<Picture>,
    #[serde(default)]
    reference: Vec<String>,
}

#[derive(Deserialize)]
struct Picture {
    file: String,
    samples: u32,
    seconds: f64,
    #[serde(default)]
    seed: u64,
}

/// All renderers of a folder.
pub fn read(folder: &Path) -> Result<Vec<Peer>, Failure> {
    let refused = |reason: String| Failure::new(format!("{}: {reason}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(|error| {
        refused(match error.kind() {
            std::io::ErrorKind::NotFound => "there is no such folder".into(),
            std::io::ErrorKind::NotADirectory => "it is not a folder".into(),
            std::io::ErrorKind::PermissionDenied => "permission denied".into(),
            _ => error.to_string(),
        })
    })?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            let name = path.file_name().and_then(|name| name.to_str());
            name.is_some_and(|name| name == TIMES || name.ends_with(&format!(".{TIMES}")))
        })
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(refused(format!(
            "it has neither a {TIMES} nor a NAME.{TIMES}, which tell what the pictures took (docs/converge.md)"
        )));
    }
    files.iter().map(|file| peer(folder, file)).collect()
}

fn peer(folder: &Path, file: &Path) -> Result<Peer, Failure> {
    let refused = |reason: String| Failure::new(format!("{}: {reason}", file.display()));
    let text = std::fs::read_to_string(file)
        .map_err(|error| refused(format!("it cannot be read ({error})")))?;
    let times: Times = serde_json::from_str(&text)
        .map_err(|error| refused(format!("it is not as docs/converge.md says: {error}")))?;
    if times.pictures.is_empty() {
        return Err(refused("it names no pictures".into()));
    }
    if times.reference.len() > 2 {
        return Err(refused(
            "it names more than two references; one, or two with independent noise, can be used"
                .into(),
        ));
    }
    let place = |name: &String| {
        let path = folder.join(name);
        if path.is_file() {
            Ok(path)
        } else {
            Err(refused(format!("it names {name}, which is not there")))
        }
    };
    let mut pictures = Vec::new();
    for picture in &times.pictures {
        if picture.samples == 0 || !picture.seconds.is_finite() || picture.seconds <= 0.0 {
            return Err(refused(format!(
                "{} has {} samples and took {} s; both must be greater than 0",
                picture.file, picture.samples, picture.seconds
            )));
        }
        pictures.push(Entry {
            path: place(&picture.file)?,
            samples: picture.samples,
            seconds: picture.seconds,
            seed: picture.seed,
        });
    }
    let reference = times
        .reference
        .iter()
        .map(place)
        .collect::<Result<_, _>>()?;
    Ok(Peer {
        name: times.renderer,
        folder: folder.into(),
        pictures,
        reference,
    })
}

impl Peer {
    /// Makes sure that all pictures can be read and have the size of the render.
    pub fn check(&self, size: (u32, u32)) -> Result<(), Failure> {
        let pictures = self.pictures.iter().map(|entry| &entry.path);
        for path in pictures.chain(&self.reference) {
            super::load(path, size)?;
        }
        Ok(())
    }
}

/// The name, or with a number behind it if others have it.
pub fn distinct<'a>(name: &str, others: impl Iterator<Item = &'a str> + Clone) -> String {
    let taken = |name: &str| others.clone().any(|other| other == name);
    if !taken(name) {
        return name.to_owned();
    }
    (2..)
        .map(|number| format!("{name} ({number})"))
        .find(|name| !taken(name))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sentence(files: &[(&str, &str)]) -> String {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        match read(folder.path()) {
            Ok(peers) => format!("{} peers", peers.len()),
            Err(failure) => failure.message,
        }
    }

    #[test]
    fn bad_folders_are_one_sentence() {
        let no_folder = read(Path::new("no/such")).unwrap_err().message;
        assert!(no_folder.contains("no such folder"), "{no_folder}");
        for (files, words) in [
            (&[][..], "neither a times.json"),
            (&[("times.json", "{")], "docs/converge.md"),
            (&[("times.json", "{\"renderer\": \"A\"}")], "pictures"),
            (
                &[("times.json", "{\"renderer\": \"A\", \"pictures\": []}")],
                "no pictures",
            ),
            (
                &[(
                    "a.times.json",
                    "{\"renderer\": \"A\", \"pictures\": [{\"file\": \"a.exr\", \"samples\": 1, \"seconds\": 1}]}",
                )],
                "a.exr, which is not there",
            ),
            (
                &[
                    (
                        "times.json",
                        "{\"renderer\": \"A\", \"pictures\": [{\"file\": \"a.exr\", \"samples\": 1, \"seconds\": 0}]}",
                    ),
                    ("a.exr", ""),
                ],
                "greater than 0",
            ),
            (
                &[
                    (
                        "b.times.json",
                        "{\"renderer\": \"A\", \"pictures\": [{\"file\": \"a.exr\", \"samples\": 1, \"seconds\": 2}]}",
                    ),
                    ("a.exr", ""),
                    ("other.json", "broken"),
                ],
                "1 peers",
            ),
        ] {
            let said = sentence(files);
            assert!(said.contains(words), "{said}");
            assert_eq!(said.lines().count(), 1, "{said}");
        }
    }

    #[test]
    fn names_are_distinct() {
        let others = ["Cycles", "Cycles (2)"];
        assert_eq!(distinct("Cycles", others.into_iter()), "Cycles (3)");
        assert_eq!(distinct("Sundog", others.into_iter()), "Sundog");
    }
}
