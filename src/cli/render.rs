//! `sundog render`: a scene file becomes pictures.

use super::flags::{EXIT_INTERRUPTED, EXIT_OK};
use super::frames::{Frames, Watcher};
use super::parser::Parsed;
use super::progress::Reporter;
use super::tev::Viewer;
use super::view::{self, View};
use super::{Failure, console, interrupt, scene_file, settings};
use crate::effects::EffectSet;
use crate::film::Picture;
use crate::output::{self, Format, Metadata, exr};
use crate::render::{EffectChoice, RenderSettings, Rendering, Stop};
use crate::scene::{ColorManagement, Scene};
use ::exr::compression::Compression;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(parsed: Parsed) -> Result<u8, Failure> {
    interrupt::listen().map_err(Failure::new)?;
    let reporter = Reporter::new(parsed.switch("quiet"), parsed.switch("json"));
    if !parsed.given("output") && !parsed.given("frames") {
        return Err(Failure::usage(
            "nothing says where the picture goes; give --output FILE (or --frames FOLDER)",
        ));
    }
    if let Some(folder) = parsed.path("frames") {
        if !parsed.switch("json") {
            return Err(Failure::usage(
                "--frames tells its files by lines of JSON; give --json as well",
            ));
        }
        Frames::check(folder)?;
    }
    let files = Outputs::files(parsed)?;
    let imported = scene_file::load(parsed)?;
    let (path, scene) = (&imported.path, &imported.scene);
    let outputs = Outputs::new(files, parsed, &scene.color_management, &reporter)?;
    reporter.say(&format!(
        "{}: {}",
        path.display(),
        scene_file::summary(scene)
    ));
    reporter.diagnostics(&imported.diagnostics);
    if parsed.switch("strict") {
        scene_file::demand_exact(path, &imported.diagnostics)?;
    }
    let settings = settings::of(parsed, path, scene)?;
    settings::check_memory(&settings)?;
    let frames = parsed
        .path("frames")
        .map(|folder| Frames::new(folder, (settings.width, settings.height), settings.region()));
    tell_left_out(scene, &settings.effects, &reporter);
    reporter.tell(
        &json!({ "event": "scene", "file": path.display().to_string(), "settings": settings }),
    );

    let viewer = parsed.text("tev").map(|address| {
        let region = settings.region();
        let size = (region.width(), region.height());
        Viewer::open(address, &outputs.title(path), size, settings.passes)
    });
    let watcher = Watcher {
        reporter: &reporter,
        frames: frames.as_ref(),
        viewer: viewer.as_ref(),
        keeps_picture: !outputs.files.is_empty() || viewer.is_some(),
    };
    let rendering = crate::render::render(scene, &settings, &watcher);
    reporter.end();
    let rendering =
        rendering.map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    let statistics = &rendering.statistics;
    let cancelled = statistics.stop == Stop::Cancelled;
    if cancelled && statistics.rays == 0 {
        reporter.tell(&json!({ "event": "finished", "statistics": statistics, "written": [] }));
        return Err(Failure {
            code: EXIT_INTERRUPTED,
            message: format!(
                "{}: interrupted before the first sample; nothing was written",
                path.display()
            ),
        });
    }
    if let Some(frames) = &frames {
        frames.finish()?;
    }
    if statistics.non_finite > 0 {
        let example = statistics.non_finite_examples.first();
        reporter.warn(&format!(
            "{} samples were not finite and were left out{}; please report it with the scene",
            console::grouped(statistics.non_finite),
            example
                .map(|(x, y, sample)| format!(", the first at pixel {x}, {y}, sample {sample}"))
                .unwrap_or_default(),
        ));
    }
    let metadata = metadata(path, scene, &settings, &rendering);
    outputs.write(&rendering, &metadata, &reporter)?;
    if let Some(viewer) = &viewer {
        viewer.finish(&rendering.picture, &reporter);
    }
    reporter.say(&end_line(&rendering));
    reporter.tell(
        &json!({ "event": "finished", "statistics": statistics, "written": outputs.names() }),
    );
    if cancelled {
        return Err(Failure {
            code: EXIT_INTERRUPTED,
            message: format!(
                "interrupted; {} written with the {} samples a pixel there were",
                if outputs.files.is_empty() {
                    "the last frame".to_owned()
                } else {
                    outputs.names().join(", ")
                },
                statistics.samples
            ),
        });
    }
    Ok(EXIT_OK)
}

/// What a render was, in one line.
fn end_line(rendering: &Rendering) -> String {
    let (picture, statistics) = (&rendering.picture, &rendering.statistics);
    let seconds = statistics.trace.as_secs_f64();
    let mut line = format!(
        "{} × {} pixels, {} samples a pixel, {} to prepare, {} to trace, {:.2} Mray/s",
        picture.width,
        picture.height,
        statistics.samples,
        console::clock(statistics.prepare.as_secs_f64()),
        console::clock(seconds),
        if seconds > 0.0 {
            statistics.rays as f64 / seconds / 1e6
        } else {
            0.0
        },
    );
    if let Some(noise) = statistics.noise {
        line.push_str(&format!(", noise about {noise:.3}"));
    }
    if let Some(clamped) = statistics.clamped {
        line.push_str(&format!(
            "; clamping took away {:.2} % of the light (direct {:.2} %, indirect {:.2} %)",
            100.0 * (clamped.direct + clamped.indirect),
            100.0 * clamped.direct,
            100.0 * clamped.indirect
        ));
    }
    line
}

/// Where the picture goes.
struct Outputs {
    files: Vec<(PathBuf, Format)>,
    exr: exr::ExrOptions,
    /// There if PNG or JPEG files are wanted.
    view: Option<View>,
}

impl Outputs {
    /// Makes sure that the files of the flags could be written.
    fn files(parsed: Parsed) -> Result<Vec<(PathBuf, Format)>, Failure> {
        let mut files: Vec<(PathBuf, Format)> = Vec::new();
        for path in parsed.paths("output") {
            let format = Format::of(&path)?;
            if files.iter().any(|(other, _)| *other == path) {
                return Err(Failure::usage(format!(
                    "--output {} is given twice",
                    path.display()
                )));
            }
            output::check_writable(&path)?;
            files.push((path, format));
        }
        Ok(files)
    }

    /// How the files are to be written, by the flags and by what the scene wishes.
    fn new(
        files: Vec<(PathBuf, Format)>,
        parsed: Parsed,
        wishes: &ColorManagement,
        reporter: &Reporter,
    ) -> Result<Self, Failure> {
        let sample_type = match parsed.choice("exr-type") {
            "half" => exr::SampleType::Half,
            _ => exr::SampleType::Float,
        };
        let compression = match parsed.choice("exr-compression") {
            "zips" => Compression::ZIP1,
            "piz" => Compression::PIZ,
            "rle" => Compression::RLE,
            "none" => Compression::Uncompressed,
            _ => Compression::ZIP16,
        };
        let all_layers = parsed.choice("exr-layers") != "combined";
        let shown = files.iter().any(|(_, format)| *format != Format::Exr);
        let view = match view::first_given(parsed) {
            _ if shown => Some(View::new(parsed, wishes, &|warning| {
                reporter.warn(warning)
            })?),
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
                sample_type,
                compression,
                all_layers,
            },
            view,
        })
    }

    fn write(
        &self,
        rendering: &Rendering,
        metadata: &Metadata,
        reporter: &Reporter,
    ) -> Result<(), Failure> {
        for (path, format) in &self.files {
            match format {
                Format::Exr => {
                    let written = exr::write(path, &rendering.picture, &self.exr, metadata)?;
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
                        let picture = &rendering.picture;
                        view.write(
                            path,
                            *format,
                            picture.width,
                            picture.height,
                            &colors(picture)?,
                            metadata,
                        )?;
                    }
                }
            }
            reporter.say(&format!("{} written", path.display()));
            reporter.tell(&json!({ "event": "written", "file": path.display().to_string() }));
        }
        Ok(())
    }

    /// What a viewer calls the picture: the first file's name, or else the scene's.
    fn title(&self, scene: &Path) -> String {
        let path = self.files.first().map_or(scene, |(path, _)| path);
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    }

    fn names(&self) -> Vec<String> {
        self.files
            .iter()
            .map(|(path, _)| path.display().to_string())
            .collect()
    }
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

/// Tells which effects the scene calls for that the user's list leaves out.
fn tell_left_out(scene: &Scene, choice: &EffectChoice, reporter: &Reporter) {
    let EffectChoice::List(wanted) = choice else {
        return;
    };
    let left_out = EffectSet::detect(scene)
        .findings
        .into_iter()
        .filter(|finding| finding.needed && !wanted.iter().any(|name| name == finding.effect));
    let names: Vec<_> = left_out.map(|finding| finding.effect).collect();
    if !names.is_empty() {
        reporter.warn(&format!(
            "the scene calls for {}, which --effects leaves out",
            names.join(", ")
        ));
    }
}

/// What a picture says about how it was made.
fn metadata(
    path: &Path,
    scene: &Scene,
    settings: &RenderSettings,
    rendering: &Rendering,
) -> Metadata {
    let mut metadata: Metadata = super::versions()
        .into_iter()
        .map(|(name, version)| (format!("sundog/version/{}", name.to_lowercase()), version))
        .collect();
    let statistics = &rendering.statistics;
    let mut add = |name: &str, value: String| metadata.push((format!("sundog/{name}"), value));
    add(
        "scene",
        path.file_name()
            .map(|name| name.to_string_lossy().into_owned())
            .unwrap_or_default(),
    );
    add("scene-hash", crate::scene::fingerprint(scene));
    add(
        "date",
        humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string(),
    );
    add("samples", statistics.samples.to_string());
    add(
        "seconds/prepare",
        format!("{:.3}", statistics.prepare.as_secs_f64()),
    );
    add(
        "seconds/trace",
        format!("{:.3}", statistics.trace.as_secs_f64()),
    );
    add(
        "settings",
        serde_json::to_string(settings).unwrap_or_default(),
    );
    add(
        "statistics",
        serde_json::to_string(statistics).unwrap_or_default(),
    );
    metadata
}
