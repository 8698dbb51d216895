//! Where the answer goes: numbers, pages and plots, and the pictures themselves.

use super::super::Failure;
use super::super::args::Converge;
use super::renders::Shot;
use super::summary::{Answer, MEASURES};
use super::{Looks, page};
use crate::film::{self, Layer};
use crate::math::primaries::WorkingSpace;
use crate::output::{self, exr, write_beside};
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// What a file holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Json,
    Csv,
    Html,
    Svg,
    Png,
}

/// The files that the flags name.
pub struct Files {
    files: Vec<(PathBuf, Kind)>,
    /// A folder for everything.
    folder: Option<PathBuf>,
    /// A folder for the pictures.
    pictures: Option<PathBuf>,
    /// What `--against` reads of them.
    kept: Mutex<Vec<Value>>,
    written: Mutex<Vec<String>>,
}

fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|error| {
        let reason = match error.kind() {
            std::io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
            std::io::ErrorKind::NotFound => "there is no place for it".into(),
            std::io::ErrorKind::AlreadyExists | std::io::ErrorKind::NotADirectory => {
                "there is a file of that name".into()
            }
            kind => kind.to_string(),
        };
        Failure::new(format!(
            "cannot make the folder {}: {reason}",
            path.display()
        ))
    })
}

impl Files {
    /// Makes sure that they can be written.
    pub fn new(args: &Converge) -> Result<Self, Failure> {
        let (mut files, mut folder) = (Vec::new(), None);
        for path in args.output.iter().cloned() {
            let kind = match path.extension().and_then(|end| end.to_str()) {
                Some("json") => Kind::Json,
                Some("csv") => Kind::Csv,
                Some("html") => Kind::Html,
                Some("svg") => Kind::Svg,
                Some("png") => Kind::Png,
                None => {
                    make_folder(&path)?;
                    output::check_writable(&path.join("converge.json"))?;
                    folder = Some(path);
                    continue;
                }
                Some(_) => {
                    return Err(Failure::usage(format!(
                        "--output {} is neither a folder nor does it end in .html, .json, .csv, .svg or .png",
                        path.display()
                    )));
                }
            };
            output::check_writable(&path)?;
            files.push((path, kind));
        }
        let pictures = args.pictures.clone();
        if let Some(pictures) = &pictures {
            make_folder(pictures)?;
            output::check_writable(&pictures.join("times.json"))?;
        }
        Ok(Self {
            files,
            folder,
            pictures,
            kept: Mutex::default(),
            written: Mutex::default(),
        })
    }

    /// The files written so far.
    pub fn names(&self) -> Vec<String> {
        self.written
            .lock()
            .map(|names| names.clone())
            .unwrap_or_default()
    }

    fn put(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        write_beside(path, |file| file.write_all(bytes))?;
        if let Ok(mut names) = self.written.lock() {
            names.push(path.display().to_string());
        }
        Ok(())
    }

    /// Keeps a picture of light in a space, if that is wished.
    pub fn keep(
        &self,
        name: &str,
        seed: u32,
        shot: &Shot,
        space: WorkingSpace,
    ) -> Result<(), Failure> {
        let Some(folder) = &self.pictures else {
            return Ok(());
        };
        let file = format!("{}-{seed}-{}.exr", file_name(name), shot.samples);
        let picture = film::Picture {
            width: shot.picture.width,
            height: shot.picture.height,
            layers: vec![Layer {
                name: "Combined".into(),
                channels: ["R", "G", "B"].map(String::from).to_vec(),
                data: shot.picture.pixels.as_flattened().to_vec(),
            }],
        };
        let options = exr::ExrOptions {
            all_layers: false,
            space,
            ..Default::default()
        };
        exr::write(&folder.join(&file), &picture, &options, &Vec::new())?;
        if let Ok(mut kept) = self.kept.lock() {
            kept.push(json!({ "file": file, "samples": shot.samples, "seconds": shot.seconds, "seed": seed }));
        }
        Ok(())
    }

    /// Tells the times of the kept pictures.
    pub fn keep_times(&self, name: &str) -> Result<(), Failure> {
        let Some(folder) = &self.pictures else {
            return Ok(());
        };
        let pictures = self
            .kept
            .lock()
            .map(|kept| kept.clone())
            .unwrap_or_default();
        let times = json!({ "renderer": name, "pictures": pictures });
        let path = folder.join(format!("{}.times.json", file_name(name)));
        self.put(&path, pretty(&times).as_bytes())
    }

    /// Writes everything that is wished.
    pub fn write(&self, answer: &Answer, looks: &Looks) -> Result<(), Failure> {
        let mut files = self.files.clone();
        if let Some(folder) = &self.folder {
            for (name, kind) in [
                ("converge.html", Kind::Html),
                ("converge.json", Kind::Json),
                ("converge.csv", Kind::Csv),
            ] {
                files.push((folder.join(name), kind));
            }
            for plot in page::plots(answer) {
                let name = file_name(&plot.title);
                self.put(
                    &folder.join(format!("{name}.svg")),
                    plot.svg().map_err(page::failed)?.as_bytes(),
                )?;
                self.put(
                    &folder.join(format!("{name}.png")),
                    &plot.png(page::PNG_WIDTH).map_err(page::failed)?,
                )?;
            }
        }
        for (path, kind) in files {
            let plot = || page::plots(answer).into_iter().next().unwrap_or_default();
            let bytes = match kind {
                Kind::Json => pretty(answer).into_bytes(),
                Kind::Csv => csv(answer).into_bytes(),
                Kind::Html => page::page(answer, looks)
                    .html()
                    .map_err(page::failed)?
                    .into_bytes(),
                Kind::Svg => plot().svg().map_err(page::failed)?.into_bytes(),
                Kind::Png => plot().png(page::PNG_WIDTH).map_err(page::failed)?,
            };
            self.put(&path, &bytes)?;
        }
        Ok(())
    }
}

fn pretty(value: &impl serde::Serialize) -> String {
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}

/// A name without what a file's name should not have.
fn file_name(name: &str) -> String {
    let mut safe: String = name
        .to_lowercase()
        .chars()
        .map(|symbol| {
            if symbol.is_ascii_alphanumeric() || symbol == '.' {
                symbol
            } else {
                '-'
            }
        })
        .collect();
    while safe.contains("--") {
        safe = safe.replace("--", "-");
    }
    safe.trim_matches(['-', '.']).to_owned()
}

/// A line for every picture.
fn csv(answer: &Answer) -> String {
    let mut text = String::from(
        "renderer,seed,samples,seconds,mse,rel_mse,error_percent,mape,smape,ssim,flip,hdr_flip,non_finite\n",
    );
    let number = |value: Option<f64>| {
        value
            .filter(|v| v.is_finite())
            .map_or_else(String::new, |v| v.to_string())
    };
    for curve in &answer.renderers {
        let name = format!("\"{}\"", curve.name.replace('"', "\"\""));
        for point in &curve.points {
            let e = &point.errors;
            text.push_str(&format!(
                "{name},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                point.seed,
                point.samples,
                point.seconds,
                e.mse,
                e.rel_mse,
                number(Some(100.0 * e.rel_mse.sqrt())),
                e.mape,
                e.smape,
                number(e.ssim),
                e.flip,
                number(e.hdr_flip),
                e.non_finite
            ));
        }
    }
    debug_assert_eq!(MEASURES.len(), 8, "a new measure is a new column");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_plain() {
        assert_eq!(
            file_name("Cycles of Blender 4.5.15"),
            "cycles-of-blender-4.5.15"
        );
        assert_eq!(file_name("../a b/<c>"), "a-b-c");
    }
}
