//! Where the answer goes: numbers, pages and plots, and the pictures themselves.

use super::super::Failure;
use super::super::args::Converge;
use super::super::report_file::{Kind, ReportFiles, pretty};
use super::renders::Shot;
use crate::film::{self, Layer};
use crate::math::primaries::WorkingSpace;
use crate::measure::convergence::{Looks, Study};
use crate::output::{self, exr};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Pixels of a plot's row.
const PNG_WIDTH: u32 = 1200;

/// The files that the flags name.
pub struct Files {
    /// Those of the answer.
    pub report: ReportFiles,
    /// A folder for everything.
    folder: Option<PathBuf>,
    /// A folder for the pictures.
    pictures: Option<PathBuf>,
    /// What `--against` reads of them.
    kept: Vec<Value>,
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
        let (mut report, mut folder) = (ReportFiles::default(), None);
        for path in &args.output {
            if let Some(kind) = Kind::of(path) {
                report.add(path, kind)?;
            } else if path.extension().is_none() {
                make_folder(path)?;
                report.add(&path.join("converge.html"), Kind::Html)?;
                report.add(&path.join("converge.json"), Kind::Json)?;
                report.add(&path.join("converge.csv"), Kind::Csv)?;
                folder = Some(path.clone());
            } else {
                return Err(Failure::usage(format!(
                    "--output {} is neither a folder nor does it end in .html, .json, .csv, .svg or .png",
                    path.display()
                )));
            }
        }
        let pictures = args.pictures.clone();
        if let Some(pictures) = &pictures {
            make_folder(pictures)?;
            output::check_writable(&pictures.join("times.json"))?;
        }
        Ok(Self {
            report,
            folder,
            pictures,
            kept: Vec::new(),
        })
    }

    /// Keeps a picture of light in a space, if that is wished.
    pub fn keep(
        &mut self,
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
        self.kept.push(
            json!({ "file": file, "samples": shot.samples, "seconds": shot.seconds, "seed": seed }),
        );
        Ok(())
    }

    /// Tells the times of the kept pictures.
    pub fn keep_times(&mut self, name: &str) -> Result<(), Failure> {
        let Some(folder) = &self.pictures else {
            return Ok(());
        };
        let times = pretty(&json!({ "renderer": name, "pictures": self.kept }))?;
        let path = folder.join(format!("{}.times.json", file_name(name)));
        self.report.put(&path, &times)
    }

    /// Writes everything that is wished.
    pub fn write(&mut self, study: &Study, looks: &Looks) -> Result<(), Failure> {
        let plots = study.plots();
        if let Some(folder) = &self.folder {
            for plot in &plots {
                let path = |end: &str| folder.join(format!("{}.{end}", file_name(&plot.title)));
                self.report.put(&path("svg"), plot.svg()?.as_bytes())?;
                self.report.put(&path("png"), &plot.png(PNG_WIDTH)?)?;
            }
        }
        let first = plots.into_iter().next().unwrap_or_default();
        self.report.write(|kind| {
            Ok(match kind {
                Kind::Json => pretty(study)?,
                Kind::Csv => study.csv().into_bytes(),
                Kind::Html => study.page(looks).html()?.into_bytes(),
                Kind::Svg => first.svg()?.into_bytes(),
                Kind::Png => first.png(PNG_WIDTH)?,
            })
        })
    }
}

/// A name without what a file's name should not have.
fn file_name(name: &str) -> String {
    let plain = |symbol: char| symbol.is_ascii_alphanumeric() || symbol == '.';
    let words = name.to_lowercase();
    let words: Vec<&str> = words
        .split(|symbol| !plain(symbol))
        .filter(|word| !word.is_empty())
        .collect();
    words.join("-").trim_matches(['-', '.']).to_owned()
}

#[cfg(test)]
#[path = "../../../tests/unit/cli/converge/files.rs"]
mod tests;
