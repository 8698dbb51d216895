//! The files of a picture, as flags and scene want them.

use super::progress::Reporter;
use super::view::View;
use super::{Failure, args, console};
use crate::denoise::{Denoiser, HalvesError};
use crate::film::{Bands, Picture};
use crate::measure;
use crate::output::{self, Format, Metadata, exr};
use crate::render::{OutputTime, Rendering, Tried};
use crate::scene::ColorManagement;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Where the picture goes.
pub struct Outputs {
    pub files: Vec<(PathBuf, Format)>,
    exr: exr::ExrOptions,
    /// There if PNG or JPEG files are wanted.
    view: Option<View>,
    /// What the picture goes through before.
    pub denoiser: Option<Denoiser>,
    /// How the halves of a picture are looked at, if no files are.
    judging: Option<View>,
}

impl Outputs {
    /// Makes sure that the files of the flags could be written.
    ///
    /// # Errors
    /// A name does not say the format, or can't be written.
    pub fn files(paths: &[PathBuf]) -> Result<Vec<(PathBuf, Format)>, Failure> {
        let mut files: Vec<(PathBuf, Format)> = Vec::new();
        for path in paths {
            let format = Format::of(path)?;
            output::check_writable(path)?;
            files.push((path.clone(), format));
        }
        Ok(files)
    }

    /// How the files are to be written, by the flags and by what the scene wishes.
    ///
    /// # Errors
    /// There is no such view.
    pub fn new(
        files: Vec<(PathBuf, Format)>,
        exr: &args::Exr,
        view: &args::View,
        wishes: &ColorManagement,
        reporter: &Reporter,
    ) -> Result<Self, Failure> {
        let shown = files.iter().any(|(_, format)| *format != Format::Exr);
        let view = match view.first_given() {
            _ if shown => Some(View::new(view, wishes, &|warning| reporter.warn(warning))?),
            Some(flag) => {
                reporter.warn(&format!(
                    "--{flag} does nothing to .exr files, which hold linear light"
                ));
                None
            }
            None => None,
        };
        if let Some(view) = &view {
            reporter.say(&view.summary());
        }
        Ok(Self {
            files,
            exr: exr::ExrOptions {
                sample_type: exr.exr_type,
                compression: exr.exr_compression,
                all_layers: exr.exr_layers,
                space: wishes.working_space,
            },
            view,
            denoiser: None,
            judging: None,
        })
    }

    /// Denoised halves will be looked at, also where no file is shown.
    ///
    /// # Errors
    /// There is no such view.
    pub fn judge(
        &mut self,
        view: &args::View,
        wishes: &ColorManagement,
        reporter: &Reporter,
    ) -> Result<(), Failure> {
        if self.view.is_none() {
            let warn = |warning: &str| reporter.warn(warning);
            self.judging = Some(View::new(view, wishes, &warn)?);
        }
        Ok(())
    }

    /// How far the picture would look from the truth once it is denoised, by both halves of its samples. `None` where nothing can
    /// be told.
    ///
    /// # Errors
    /// The denoiser or the view fails, or it was cancelled.
    pub fn denoised_error(
        &self,
        film: &dyn Bands,
        halves: [&dyn Bands; 2],
        samples: f64,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<HalvesError>, Failure> {
        let view = self.view.as_ref().or(self.judging.as_ref());
        let (Some(denoiser), Some(view)) = (&self.denoiser, view) else {
            return Ok(None);
        };
        let noisy = halves.map(Picture::collect);
        let noisy = [&noisy[0], &noisy[1]];
        let picture = Picture::collect(film);
        let denoised = denoiser.halves(&picture, noisy, cancelled);
        let denoised = denoised.map_err(|error| Failure::new(error.to_string()))?;
        let between = flip(view, &denoised[0], &denoised[1])?;
        Ok(Some(HalvesError::new(between, samples)))
    }

    /// Writes all files.
    ///
    /// # Errors
    /// A file can't be written.
    pub fn write(
        &self,
        picture: &Picture,
        metadata: &Metadata,
        reporter: &Reporter,
    ) -> Result<(), Failure> {
        let paths: Vec<_> = self.files.iter().map(|(path, _)| path.clone()).collect();
        let all = self.write_all(&paths, picture, metadata, reporter);
        let mut failures = Vec::new();
        for (path, written) in paths.iter().zip(all) {
            match written {
                Err(failure) => failures.push(failure),
                Ok(()) => {
                    reporter.say(&format!("{} written", path.display()));
                    reporter
                        .tell(&json!({ "event": "written", "file": path.display().to_string() }));
                }
            }
        }
        let joined = failures
            .into_iter()
            .reduce(|first: Failure, other| Failure {
                message: format!("{}; {}", first.message, other.message),
                ..first
            });
        joined.map_or(Ok(()), Err)
    }

    /// A failure of something else than the picture, which says that the picture is there nevertheless.
    pub fn are_there(&self, failure: Failure) -> Failure {
        let names = self.names();
        if names.is_empty() {
            return failure;
        }
        let are = if names.len() == 1 { "is" } else { "are" };
        let message = format!("{}; {} {are} written", failure.message, names.join(", "));
        Failure { message, ..failure }
    }

    /// All files at once: some keep one thread alone busy for a while.
    fn write_all(
        &self,
        paths: &[PathBuf],
        picture: &Picture,
        metadata: &Metadata,
        reporter: &Reporter,
    ) -> Vec<Result<(), Failure>> {
        let files = paths.iter().zip(&self.files);
        std::thread::scope(|scope| {
            let files: Vec<_> = files
                .map(|(path, (_, format))| {
                    let write = || self.write_one(path, *format, picture, metadata, reporter);
                    let thread = std::thread::Builder::new().spawn_scoped(scope, write);
                    // The system has no more threads: then one after the other.
                    thread.map_err(|_| write())
                })
                .collect();
            let written = files.into_iter().map(|file| match file {
                Ok(thread) => thread
                    .join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
                Err(written) => written,
            });
            written.collect()
        })
    }

    fn write_one(
        &self,
        path: &Path,
        format: Format,
        picture: &Picture,
        metadata: &Metadata,
        reporter: &Reporter,
    ) -> Result<(), Failure> {
        match format {
            Format::Exr => {
                let written = exr::write(path, picture, &self.exr, metadata)?;
                if written.clamped > 0 {
                    reporter.warn(&format!(
                            "{}: {} values above 65504 became 65504, the largest number of 16 bits; --exr-type float keeps them",
                            path.display(),
                            console::grouped(written.clamped as u64)
                        ));
                }
            }
            Format::Png | Format::Jpeg => {
                if picture.layers.is_empty() {
                    return Err(Failure::new("the render has no layer with colours"));
                }
                if let Some(view) = &self.view {
                    view.write(
                        path,
                        format,
                        picture.width,
                        picture.height,
                        &picture.colors().collect::<Vec<_>>(),
                        metadata,
                    )?;
                }
            }
        }
        Ok(())
    }

    /// How long it will take to make the files of a picture like this one, and to tell the error of what one sees: some
    /// bands of it are written to a folder beside the first file, which is then removed.
    pub fn rehearse(&self, film: &dyn Bands) -> OutputTime {
        OutputTime::rehearsed(film, |film| self.try_out(film))
    }

    /// How long it takes to make what is wanted of this.
    fn try_out(&self, film: &dyn Bands) -> Tried {
        let files = self.files.iter();
        let folders = files.map(|(path, _)| output::Passing::temporary_folder(path));
        // What fails here will fail again, and be told then.
        let Ok(folders) = folders.collect::<Result<Vec<_>, _>>() else {
            return Tried::default();
        };
        let names = self.files.iter().map(|(path, _)| path.file_name());
        let paths = folders.iter().zip(names);
        let paths: Vec<_> = paths
            .map(|((folder, _), name)| folder.path().join(name.unwrap_or_default()))
            .collect();
        let begun = Instant::now();
        let mut picture = Picture::collect(film);
        if let Some(denoiser) = &self.denoiser {
            let _ = denoiser.denoise(&mut picture, None, &|| false);
        }
        self.write_all(&paths, &picture, &Metadata::new(), &Reporter::Nobody);
        let files = begun.elapsed();
        if let Some(view) = &self.view {
            let _ = flip(view, &picture, &picture);
        }
        Tried {
            files,
            seen_error: begun.elapsed() - files,
        }
    }

    /// How different what one sees looks from what one would see without error: the mean LDR-FLIP between the picture and
    /// that of one of its replicates, which differs from it as it differs from the truth. `None` if nothing is shown or
    /// the error is not known.
    ///
    /// # Errors
    /// The view fails.
    pub fn seen_error(&self, rendering: &Rendering) -> Result<Option<f64>, Failure> {
        let (Some(view), Some(replicate)) = (&self.view, &rendering.replicate) else {
            return Ok(None);
        };
        let noisy = rendering.picture.noisy();
        flip(
            view,
            replicate,
            noisy.as_ref().unwrap_or(&rendering.picture),
        )
        .map(Some)
    }

    /// What a viewer calls the picture: the first file's name, or else the scene's.
    pub fn title(&self, scene: &Path) -> String {
        let path = self.files.first().map_or(scene, |(path, _)| path);
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// Names of the files.
    pub fn names(&self) -> Vec<String> {
        self.files
            .iter()
            .map(|(path, _)| path.display().to_string())
            .collect()
    }
}

/// The picture's colours.
pub fn light(picture: &Picture) -> measure::RgbImage {
    let colors = picture.colors();
    measure::RgbImage {
        width: picture.width,
        height: picture.height,
        pixels: colors.map(|[r, g, b, _]| [r, g, b]).collect(),
        encoding: measure::Encoding::Linear,
    }
}

/// Mean LDR-FLIP between two pictures as they are shown.
fn flip(view: &View, test: &Picture, reference: &Picture) -> Result<f64, Failure> {
    let [test, reference] = [test, reference].map(light);
    let (shown_test, shown) = (view.seen(&test)?, view.seen(&reference)?);
    let map = measure::flip_map([&test, &reference, &shown_test, &shown]);
    Ok(map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len().max(1) as f64)
}
