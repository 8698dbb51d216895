//! The files of a picture, as flags and scene want them.

use super::progress::Reporter;
use super::view::View;
use super::{Failure, args, console};
use crate::film::{Bands, Extract, Picture};
use crate::measure;
use crate::output::{self, Format, Metadata, exr};
use crate::render::{OutputTime, Rendering};
use crate::scene::ColorManagement;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Bands of a picture that are tried out.
const TRIED: usize = 4;
/// So many times as long as they let expect takes the rest of the whole, as they fit the processor's caches, and it does not:
/// 0.97 to 1.25, median 1.12 of eight renders of 1280 pixels a row (cornell, foliage, many-lights, glass, 3 and 10 s; then
/// by the whole time of the bands). With it three of cornell ended after 10.01 to 10.23 of 10 s.
const WHOLE: f64 = 1.12;

/// Where the picture goes.
pub struct Outputs {
    pub files: Vec<(PathBuf, Format)>,
    exr: exr::ExrOptions,
    /// There if PNG or JPEG files are wanted.
    view: Option<View>,
}

/// How long a part of the output took.
#[derive(Clone, Copy, Default)]
struct Tried {
    files: Duration,
    seen_error: Duration,
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
        })
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
        let mut failures = failures.into_iter();
        let Some(mut first) = failures.next() else {
            return Ok(());
        };
        for failure in failures {
            first.message = format!("{}; {}", first.message, failure.message);
        }
        Err(first)
    }

    /// A failure of something else than the picture, which says that the picture is there nevertheless.
    pub fn are_there(&self, failure: Failure) -> Failure {
        match self.names().as_slice() {
            [] => failure,
            [name] => Failure {
                message: format!("{}; {name} is written", failure.message),
                ..failure
            },
            names => Failure {
                message: format!("{}; {} are written", failure.message, names.join(", ")),
                ..failure
            },
        }
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
                if let Some(view) = &self.view {
                    view.write(
                        path,
                        format,
                        picture.width,
                        picture.height,
                        &colors(picture)?,
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
        let (begun, blank): (Vec<_>, Vec<_>) =
            (0..film.bands().len()).partition(|&band| film.is_begun(band));
        let (begun, blank) = (self.of_these(film, &begun), self.of_these(film, &blank));
        // Of a picture of one kind both are as that kind.
        let full = begun.or(blank).unwrap_or_default();
        OutputTime {
            full: full.files,
            blank: blank.unwrap_or(full).files,
            seen_error: full.seen_error,
            is_guess: begun.is_none(),
        }
    }

    /// How long it will take if all bands are as these; `None` if these are none.
    ///
    /// What takes as long for few rows as for many (the disk, threads, what is made at the first use) must not be
    /// multiplied: so one band is tried, and then some; and before that one for what is made at the first use.
    fn of_these(&self, film: &dyn Bands, bands: &[usize]) -> Option<Tried> {
        let one = Extract::of(film, bands, 1)?;
        let (first, second) = (self.try_out(&one), self.try_out(&one));
        let some = Extract::of(film, bands, TRIED)?;
        let time = self.try_out(&some);
        let whole = |least: Duration, time: Duration| {
            let rows = some.rows() - one.rows();
            if rows == 0 {
                return least.mul_f64(f64::from(film.size().1) / f64::from(one.rows()));
            }
            let rest = f64::from(film.size().1) - f64::from(some.rows());
            time + time
                .saturating_sub(least)
                .mul_f64(WHOLE * rest / f64::from(rows))
        };
        Some(Tried {
            files: whole(first.files.min(second.files), time.files),
            seen_error: whole(first.seen_error.min(second.seen_error), time.seen_error),
        })
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
        let picture = Picture::collect(film);
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
        flip(view, replicate, &rendering.picture).map(Some)
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

/// The colours of the first layer, which is the picture itself.
pub fn light(picture: &Picture) -> measure::RgbImage {
    let pixels = picture.layers.first().map_or_else(Vec::new, |layer| {
        layer
            .data
            .chunks_exact(layer.channels.len().max(1))
            .map(|pixel| std::array::from_fn(|c| pixel.get(c).copied().unwrap_or(0.0)))
            .collect()
    });
    measure::RgbImage {
        width: picture.width,
        height: picture.height,
        pixels,
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

/// The pixels of the picture itself, with associated alpha (1 where the picture has none).
fn colors(picture: &Picture) -> Result<Vec<[f32; 4]>, Failure> {
    let missing = || Failure::new("the render has no layer with colours");
    let layer = picture.layers.first().ok_or_else(missing)?;
    match layer.channels.len() {
        3 => Ok(layer
            .data
            .chunks_exact(3)
            .map(|p| [p[0], p[1], p[2], 1.0])
            .collect()),
        4 => Ok(layer
            .data
            .chunks_exact(4)
            .map(|p| [p[0], p[1], p[2], p[3]])
            .collect()),
        _ => Err(missing()),
    }
}
