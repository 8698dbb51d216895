//! Folders with pictures of other renderers and their times (docs/converge.md).

use crate::measure::MeasureError;
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
    pub pictures: Vec<PeerPicture>,
    /// None, one or two pictures that are taken for its truth.
    pub reference: Vec<PathBuf>,
}

/// A picture.
#[derive(Debug)]
pub struct PeerPicture {
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
    pictures: Vec<PeerImage>,
    #[serde(default)]
    reference: Vec<String>,
}

#[derive(Deserialize)]
struct PeerImage {
    file: String,
    samples: u32,
    seconds: f64,
    #[serde(default)]
    seed: u64,
}

/// Something is wrong with a folder or a file.
fn refused(path: &Path, reason: impl Into<String>) -> MeasureError {
    MeasureError::Refused {
        path: path.display().to_string(),
        reason: reason.into(),
    }
}

impl Peer {
    /// All renderers of a folder.
    ///
    /// # Errors
    /// It cannot be read, or is not as docs/converge.md says.
    pub fn read_all(folder: &Path) -> Result<Vec<Self>, MeasureError> {
        let refused = |reason: String| refused(folder, reason);
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
        files.iter().map(|file| Self::read(folder, file)).collect()
    }

    fn read(folder: &Path, file: &Path) -> Result<Self, MeasureError> {
        let refused = |reason: String| refused(file, reason);
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
            pictures.push(PeerPicture {
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
        Ok(Self {
            name: times.renderer,
            folder: folder.into(),
            pictures,
            reference,
        })
    }

    /// The name, or with a number behind it if others have it.
    pub fn distinct_name<'a>(name: &str, others: impl Iterator<Item = &'a str> + Clone) -> String {
        let taken = |name: &str| others.clone().any(|other| other == name);
        if !taken(name) {
            return name.to_owned();
        }
        (2..)
            .map(|number| format!("{name} ({number})"))
            .find(|name| !taken(name))
            .unwrap_or_default()
    }
}
