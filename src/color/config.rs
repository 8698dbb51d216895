//! A colour configuration, what can be chosen in it, and the way from a choice to a processor.

use crate::color::locate::{SearchPlaces, is_built_in_name};
use crate::color::looks::{Meant, find_look, looks_for_view};
use crate::color::pixels::{PIECE, to_display};
use crate::color::{ColorError, ConfigOrigin, Depth, DisplayPixels, SceneColors};
use crate::ffi::ocio::{self, Config, DisplayChain, OcioError, Processor, Source};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// How light is to be shown. What is `None` is what the configuration says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DisplayTransform {
    /// For example `sRGB`.
    pub display: Option<String>,
    /// For example `AgX`.
    pub view: Option<String>,
    /// For example `AgX - Punchy`, or `Punchy` with the view AgX; `None` is also what Blender calls "None".
    pub look: Option<String>,
    /// In stops: light is multiplied by 2^exposure, in the configuration's scene-linear space.
    pub exposure: f64,
    /// Display values are raised to 1/gamma.
    pub gamma: f64,
}

impl Default for DisplayTransform {
    fn default() -> Self {
        Self {
            display: None,
            view: None,
            look: None,
            exposure: 0.0,
            gamma: 1.0,
        }
    }
}

/// A [`DisplayTransform`] with every name as the configuration writes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResolvedDisplay {
    /// Display.
    pub display: String,
    /// View of the display.
    pub view: String,
    /// The look that was asked for.
    pub look: Option<String>,
    /// In stops.
    pub exposure: f64,
    /// Display values are raised to 1/gamma.
    pub gamma: f64,
}

/// One view of a display, for lists.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ViewSummary {
    /// Its name.
    pub name: String,
    /// What the configuration says about it; often empty.
    pub description: String,
    /// Names of the looks that go with it.
    pub looks: Vec<String>,
}

/// A display and its views, for lists.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DisplaySummary {
    /// Its name.
    pub name: String,
    /// The view that it shows where none is named.
    pub default_view: String,
    /// In the configuration's order.
    pub views: Vec<ViewSummary>,
}

/// A look, for lists.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LookSummary {
    /// Its name.
    pub name: String,
    /// The colour space in which it works.
    pub process_space: String,
    /// What the configuration says about it; often empty.
    pub description: String,
}

/// The length of a regular file. Of folders, devices and pipes OpenColorIO would say something strange, or read on for ever.
fn check_file(path: &Path) -> Result<u64, String> {
    match std::fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => Ok(metadata.len()),
        Ok(metadata) if metadata.is_dir() => Err("it is a folder and not a file".to_owned()),
        Ok(_) => Err("it is not a regular file".to_owned()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            Err("there is no such file".to_owned())
        }
        Err(error) => Err(error.to_string()),
    }
}

/// A colour configuration, and where it came from.
#[derive(Debug)]
pub struct ColorConfig {
    config: Config,
    origin: ConfigOrigin,
    warnings: Vec<String>,
}

impl ColorConfig {
    /// The configuration that the flag names; else the one that `$OCIO` names; else that of an installed Blender or `bpy`;
    /// else OpenColorIO's own.
    ///
    /// # Errors
    /// If one that a person named cannot be read: another is never taken in its place. (Of those that a search found, one
    /// that cannot be read is passed over, with a warning.)
    pub fn locate(flag: Option<&Path>) -> Result<Self, ColorError> {
        Self::locate_in(flag, &SearchPlaces::of_this_process())
    }

    /// The configuration that a scene's file names.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read_named_by_scene(path: &Path) -> Result<Self, ColorError> {
        crate::color::library_version()?;
        Self::read(&ConfigOrigin::Scene(path.to_owned()))
    }

    /// As [`ColorConfig::locate`], with the places given.
    ///
    /// # Errors
    /// As [`ColorConfig::locate`].
    pub fn locate_in(flag: Option<&Path>, places: &SearchPlaces) -> Result<Self, ColorError> {
        crate::color::library_version()?;
        let mut passed_over = Vec::new();
        let mut last = None;
        for origin in places.candidates(flag) {
            match Self::read(&origin) {
                Ok(mut found) => {
                    passed_over.append(&mut found.warnings);
                    return Ok(Self {
                        warnings: passed_over,
                        ..found
                    });
                }
                Err(error) if origin.was_searched_for() => {
                    passed_over.push(format!("{error}; it was passed over"));
                    last = Some(error);
                }
                Err(error) => return Err(error),
            }
        }
        // The built-in one comes last, is not searched for, and so has returned above.
        Err(last.unwrap_or(ColorError::Library {
            reason: "it has no configuration of its own".to_owned(),
        }))
    }

    fn read(origin: &ConfigOrigin) -> Result<Self, ColorError> {
        let path = origin.path();
        if !is_built_in_name(path)
            && let Err(reason) = check_file(path)
        {
            return Err(ColorError::Missing {
                origin: origin.clone(),
                reason,
            });
        }
        let config =
            Config::from_file(origin.path().as_os_str()).map_err(|error| ColorError::Broken {
                origin: origin.clone(),
                reason: error.text,
            })?;
        let config = Self {
            config,
            origin: origin.clone(),
            warnings: ocio::take_warnings(),
        };
        // Those of an archive lie in it.
        let archive = path.extension().is_some_and(|e| e == "ocioz");
        if !is_built_in_name(path) && !archive {
            config.check_tables()?;
        }
        Ok(config)
    }

    /// Refuses tables that OpenColorIO would read for ever, or that would take all memory.
    fn check_tables(&self) -> Result<(), ColorError> {
        /// A table of 129³ colours as text has 64 MiB.
        const LARGEST: u64 = 1 << 28;
        for table in self.config.files().map_err(self.broken())? {
            let reason = match check_file(&table) {
                // Not there: an error only where it is used.
                Err(_) if !table.exists() => continue,
                Err(reason) => reason,
                Ok(length) if length > LARGEST => format!("it has {} MiB", length >> 20),
                Ok(_) => continue,
            };
            return Err(ColorError::Table {
                origin: self.origin.clone(),
                table: table.display().to_string(),
                reason,
            });
        }
        Ok(())
    }

    /// Where it came from.
    pub fn origin(&self) -> &ConfigOrigin {
        &self.origin
    }

    /// What OpenColorIO warned of when it read the configuration, and which others were passed over; a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn broken(&self) -> impl Fn(OcioError) -> ColorError + '_ {
        |error| ColorError::Broken {
            origin: self.origin.clone(),
            reason: error.text,
        }
    }

    /// The configuration's name (often empty), and the version of its format as `2.4`.
    ///
    /// # Errors
    /// If the library fails.
    pub fn name_and_profile(&self) -> Result<(String, String), ColorError> {
        let (major, minor) = self.config.profile().map_err(self.broken())?;
        Ok((
            self.config.name().map_err(self.broken())?,
            format!("{major}.{minor}"),
        ))
    }

    /// Roles with their colour spaces.
    ///
    /// # Errors
    /// If the library fails.
    pub fn roles(&self) -> Result<Vec<ocio::Role>, ColorError> {
        self.config.roles().map_err(self.broken())
    }

    /// Names of the active colour spaces.
    ///
    /// # Errors
    /// If the library fails.
    pub fn colour_spaces(&self) -> Result<Vec<String>, ColorError> {
        let spaces = self.config.colour_spaces().map_err(self.broken())?;
        Ok(spaces.into_iter().map(|space| space.name).collect())
    }

    /// All looks.
    ///
    /// # Errors
    /// If the library fails.
    pub fn looks(&self) -> Result<Vec<LookSummary>, ColorError> {
        let looks = self.config.looks().map_err(self.broken())?;
        Ok(looks
            .into_iter()
            .map(|look| LookSummary {
                name: look.name,
                process_space: look.process_space,
                description: look.description.trim().to_owned(),
            })
            .collect())
    }

    /// All displays with their views, and the looks that go with each.
    ///
    /// # Errors
    /// If the library fails.
    pub fn displays(&self) -> Result<Vec<DisplaySummary>, ColorError> {
        let all_looks = self.look_names()?;
        let all_views = self.all_view_names()?;
        let mut displays = Vec::new();
        for name in self.config.displays().map_err(self.broken())? {
            let views = self.config.views(&name).map_err(self.broken())?;
            let default_view = self
                .config
                .default_view(&name)
                .map_err(self.broken())?
                .unwrap_or_default();
            let views = views
                .into_iter()
                .map(|view| ViewSummary {
                    looks: looks_for_view(&view.name, &all_looks, &all_views),
                    description: view.description.trim().to_owned(),
                    name: view.name,
                })
                .collect();
            displays.push(DisplaySummary {
                name,
                default_view,
                views,
            });
        }
        Ok(displays)
    }

    /// The display that is meant where none is named.
    ///
    /// # Errors
    /// If the configuration has no display.
    pub fn default_display(&self) -> Result<String, ColorError> {
        let display = self.config.default_display().map_err(self.broken())?;
        display.ok_or_else(|| ColorError::NoDisplay {
            origin: self.origin.clone(),
        })
    }

    fn look_names(&self) -> Result<Vec<String>, ColorError> {
        let looks = self.config.looks().map_err(self.broken())?;
        Ok(looks.into_iter().map(|look| look.name).collect())
    }

    fn view_names(&self, display: &str) -> Result<Vec<String>, ColorError> {
        let views = self.config.views(display).map_err(self.broken())?;
        Ok(views.into_iter().map(|view| view.name).collect())
    }

    fn all_view_names(&self) -> Result<Vec<String>, ColorError> {
        let mut all = Vec::new();
        for display in self.config.displays().map_err(self.broken())? {
            all.extend(self.view_names(&display)?);
        }
        Ok(all)
    }

    /// Fills in what was left open, and checks that everything named is there.
    ///
    /// # Errors
    /// If a display, view or look isn't there (with those that are), or exposure or gamma make no sense.
    pub fn resolve(&self, wanted: &DisplayTransform) -> Result<ResolvedDisplay, ColorError> {
        // Beyond 128 stops every f32 is 0 or infinite; the same bound leaves the factor itself finite.
        if !wanted.exposure.is_finite() || wanted.exposure.abs() > 128.0 {
            let range = "a number from -128 to 128";
            return Err(ColorError::OutOfRange {
                what: "exposure",
                value: wanted.exposure,
                range,
            });
        }
        if !wanted.gamma.is_finite() || !(1e-3..=1e3).contains(&wanted.gamma) {
            let range = "a number from 0.001 to 1000";
            return Err(ColorError::OutOfRange {
                what: "gamma",
                value: wanted.gamma,
                range,
            });
        }
        let origin = || self.origin.clone();
        let display = match &wanted.display {
            None => self.default_display()?,
            Some(name) => {
                let there = self.config.displays().map_err(self.broken())?;
                if !there.contains(name) {
                    return Err(ColorError::UnknownDisplay {
                        name: name.clone(),
                        origin: origin(),
                        there,
                    });
                }
                name.clone()
            }
        };
        let views = self.view_names(&display)?;
        let default_view = || self.config.default_view(&display).map_err(self.broken());
        let view = match &wanted.view {
            None => default_view()?.ok_or_else(|| ColorError::NoDisplay { origin: origin() })?,
            Some(name) if views.contains(name) => name.clone(),
            Some(name) => {
                return Err(ColorError::UnknownView {
                    name: name.clone(),
                    display,
                    origin: origin(),
                    there: views,
                });
            }
        };
        let all_looks = self.look_names()?;
        let look = match &wanted.look {
            None => None,
            // Blender's word for no look, unless it is one.
            Some(name) if name == "None" && !all_looks.contains(name) => None,
            Some(name) => {
                let there = looks_for_view(&view, &all_looks, &self.all_view_names()?);
                match find_look(name, &there, &all_looks) {
                    Meant::Look(look) => Some(look),
                    meant => {
                        let elsewhere = meant == Meant::OfAnotherView;
                        return Err(ColorError::UnknownLook {
                            name: name.clone(),
                            view,
                            elsewhere,
                            origin: origin(),
                            there,
                        });
                    }
                }
            }
        };
        Ok(ResolvedDisplay {
            display,
            view,
            look,
            exposure: wanted.exposure,
            gamma: wanted.gamma,
        })
    }

    /// How much brighter Blender 5.0 makes the views of its PQ and HLG displays than they are by the configuration: white
    /// at 203 cd/m² (as ITU-R BT.2408 has it for pictures in HDR video) and not at 100. Measured on what it saves; 1 for
    /// all other displays, and for configurations that are not made for Blender.
    fn white_scale(&self, resolved: &ResolvedDisplay) -> Result<f64, ColorError> {
        let made_for_blender = self
            .roles()?
            .iter()
            .any(|role| role.name == "default_sequencer");
        if !made_for_blender {
            return Ok(1.0);
        }
        let views = self
            .config
            .views(&resolved.display)
            .map_err(self.broken())?;
        let Some(view) = views.into_iter().find(|view| view.name == resolved.view) else {
            return Ok(1.0);
        };
        let ends_in = if view.colour_space == "<USE_DISPLAY_NAME>" {
            &resolved.display
        } else {
            &view.colour_space
        };
        let spaces = self.config.colour_spaces().map_err(self.broken())?;
        let is_hdr =
            |space: &ocio::ColourSpace| space.is_display_referred && space.encoding == "hdr-video";
        let hdr = spaces
            .iter()
            .any(|space| space.name == *ends_in && is_hdr(space));
        Ok(if hdr { 203.0 / 100.0 } else { 1.0 })
    }

    /// Makes what turns light into a display's code values.
    ///
    /// # Errors
    /// As [`ColorConfig::resolve`]; if the configuration doesn't say how it stands to Rec.709; if a file that the view
    /// needs cannot be read.
    pub fn processor(&self, wanted: &DisplayTransform) -> Result<DisplayProcessor, ColorError> {
        let resolved = self.resolve(wanted)?;
        let is_rec709 =
            self.config
                .is_scene_linear_rec709()
                .map_err(|error| ColorError::NoRec709 {
                    origin: self.origin.clone(),
                    reason: error.text,
                })?;
        let processor = self
            .config
            .display_processor(&DisplayChain {
                source: if is_rec709 {
                    Source::SceneLinear
                } else {
                    Source::LinearRec709
                },
                display: &resolved.display,
                view: &resolved.view,
                look: resolved.look.as_deref(),
                scale: resolved.exposure.exp2(),
                display_scale: self.white_scale(&resolved)?,
                exponent: 1.0 / resolved.gamma,
            })
            .map_err(|error| ColorError::Unmakeable {
                display: resolved.display.clone(),
                view: resolved.view.clone(),
                origin: self.origin.clone(),
                reason: error.text,
            })?;
        Ok(DisplayProcessor {
            processor,
            resolved,
            warnings: ocio::take_warnings(),
        })
    }
}

/// Turns light into a display's code values.
#[derive(Debug)]
pub struct DisplayProcessor {
    processor: Processor,
    resolved: ResolvedDisplay,
    warnings: Vec<String>,
}

impl DisplayProcessor {
    /// What it does, with the configuration's names.
    pub fn resolved(&self) -> &ResolvedDisplay {
        &self.resolved
    }

    /// What OpenColorIO warned of when it made the processor; a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Shows pixels of linear Rec.709 light, on all threads of the current rayon pool. Values are rounded to the nearest
    /// code value and clipped to the range, as Blender does without dither; alpha is divided out before the view and stays
    /// unassociated.
    ///
    /// # Errors
    /// If OpenColorIO fails.
    pub fn show(&self, colors: SceneColors<'_>, depth: Depth) -> Result<DisplayPixels, ColorError> {
        to_display(&self.processor, colors, depth)
    }

    /// Shows pixels in place, as floats: display values, 0..1 for what the display can show, neither rounded nor clipped.
    ///
    /// # Errors
    /// If OpenColorIO fails.
    pub fn show_in_place(&self, pixels: &mut [[f32; 3]]) -> Result<(), ColorError> {
        pixels
            .par_chunks_mut(PIECE)
            .try_for_each(|pixels| self.processor.apply_rgb(pixels))
            .map_err(|error| ColorError::Apply { reason: error.text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::DisplaySamples;

    fn built_in() -> ColorConfig {
        ColorConfig::locate(Some(Path::new(
            "ocio://cg-config-v2.1.0_aces-v1.3_ocio-v2.3",
        )))
        .unwrap()
    }

    fn view(display: &str, view: &str) -> DisplayTransform {
        DisplayTransform {
            display: Some(display.to_owned()),
            view: Some(view.to_owned()),
            ..DisplayTransform::default()
        }
    }

    fn eight_bits(processor: &DisplayProcessor, colors: SceneColors<'_>) -> Vec<u8> {
        match processor.show(colors, Depth::Eight).unwrap().samples {
            DisplaySamples::Eight(values) => values,
            DisplaySamples::Sixteen(_) => panic!("8 bits were asked for"),
        }
    }

    const SRGB: &str = "sRGB - Display";
    const PLAIN: &str = "Un-tone-mapped";

    #[test]
    fn light_is_brought_from_rec709_to_the_working_space_of_the_configuration() {
        // Its scene_linear is ACEScg; its plain sRGB view must give back what Rec.709 light is in sRGB.
        let processor = built_in().processor(&view(SRGB, PLAIN)).unwrap();
        let colours = [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0; 3],
            [0.18; 3],
            [0.5, 0.02, 0.1],
        ];
        // IEC 61966-2-1.
        let encode = |v: f32| {
            if v <= 0.003_130_8 {
                12.92 * v
            } else {
                1.055 * v.powf(1.0 / 2.4) - 0.055
            }
        };
        let shown = eight_bits(&processor, SceneColors::Rgb(&colours));
        for (code, light) in shown.iter().zip(colours.iter().flatten()) {
            let wanted = (encode(*light) * 255.0).round();
            assert!(
                (f32::from(*code) - wanted).abs() <= 1.0,
                "{code} for {light}, not {wanted}"
            );
        }
    }

    #[test]
    fn exposure_counts_stops_and_gamma_is_a_power() {
        let config = built_in();
        let shown = |exposure, gamma, light: f32| {
            let wanted = DisplayTransform {
                exposure,
                gamma,
                ..view(SRGB, PLAIN)
            };
            let mut pixels = [[light; 3]];
            config
                .processor(&wanted)
                .unwrap()
                .show_in_place(&mut pixels)
                .unwrap();
            pixels[0][1]
        };
        // OpenColorIO's quick logarithms and powers are good to about 1e-5.
        assert!((shown(2.0, 1.0, 0.1) - shown(0.0, 1.0, 0.4)).abs() < 3e-5);
        assert!((shown(-1.0, 1.0, 0.4) - shown(0.0, 1.0, 0.2)).abs() < 3e-5);
        assert!((shown(0.0, 2.0, 0.3) - shown(0.0, 1.0, 0.3).sqrt()).abs() < 3e-5);
    }

    #[test]
    fn what_is_left_open_is_what_the_configuration_says() {
        let config = built_in();
        let resolved = config.resolve(&DisplayTransform::default()).unwrap();
        assert_eq!(resolved.display, config.default_display().unwrap());
        let displays = config.displays().unwrap();
        let display = displays
            .iter()
            .find(|display| display.name == resolved.display)
            .unwrap();
        assert_eq!(resolved.view, display.default_view);
        assert_eq!(resolved.look, None);
        let none = DisplayTransform {
            look: Some("None".to_owned()),
            ..DisplayTransform::default()
        };
        assert_eq!(config.resolve(&none).unwrap(), resolved);
    }

    #[test]
    fn what_is_not_there_is_an_error_that_lists_what_is() {
        let config = built_in();
        let error = |wanted: DisplayTransform| config.processor(&wanted).unwrap_err().to_string();
        let display = error(view("No such display", PLAIN));
        assert!(
            display.contains("'No such display'") && display.contains(SRGB),
            "{display}"
        );
        let missing = error(view(SRGB, "Filmic"));
        assert!(
            missing.contains("'Filmic'") && missing.contains(PLAIN) && missing.contains(SRGB),
            "{missing}"
        );
        // The case of letters counts; nothing is guessed.
        assert!(error(view("srgb - display", PLAIN)).contains(SRGB));
        let look = error(DisplayTransform {
            look: Some("Punchy".to_owned()),
            ..view(SRGB, PLAIN)
        });
        assert!(
            look.contains("'Punchy'") && look.contains("there are: "),
            "{look}"
        );
        for text in [&display, &missing, &look] {
            assert!(!text.contains('\n'));
        }
    }

    #[test]
    fn senseless_numbers_are_errors() {
        let config = built_in();
        for (exposure, gamma) in [
            (f64::NAN, 1.0),
            (f64::INFINITY, 1.0),
            (1e9, 1.0),
            (0.0, 0.0),
            (0.0, -1.0),
            (0.0, f64::NAN),
        ] {
            let wanted = DisplayTransform {
                exposure,
                gamma,
                ..DisplayTransform::default()
            };
            assert!(matches!(
                config.processor(&wanted),
                Err(ColorError::OutOfRange { .. })
            ));
        }
    }

    #[test]
    fn a_named_configuration_that_cannot_be_read_is_an_error_of_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("text.ocio"), "this is no configuration").unwrap();
        std::fs::write(path("empty.ocio"), "").unwrap();
        std::fs::write(path("future.ocio"), "ocio_profile_version: 47\n").unwrap();
        std::fs::write(path("archive.ocioz"), "PK\x03\x04 but no archive").unwrap();
        std::fs::write(
            path("bytes.ocio"),
            (0..=255).cycle().take(5000).collect::<Vec<u8>>(),
        )
        .unwrap();
        for name in [
            "text.ocio",
            "empty.ocio",
            "future.ocio",
            "archive.ocioz",
            "bytes.ocio",
        ] {
            let error = ColorConfig::locate(Some(&path(name))).unwrap_err();
            assert!(
                matches!(error, ColorError::Broken { .. }),
                "{name}: {error:?}"
            );
            let text = error.to_string();
            assert!(
                text.contains(name) && text.contains("--ocio") && !text.contains('\n'),
                "{text}"
            );
        }
        for named in [folder.path(), &path("missing.ocio"), Path::new("/dev/zero")] {
            let error = ColorConfig::locate(Some(named)).unwrap_err();
            assert!(matches!(error, ColorError::Missing { .. }), "{error:?}");
        }
        let error = ColorConfig::locate(Some(Path::new("ocio://no-such-one")))
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("ocio://no-such-one") && !error.contains('\n'),
            "{error}"
        );
    }

    #[test]
    fn a_broken_one_that_a_search_found_is_passed_over_with_a_warning() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder
            .path()
            .join("opt/blender-9.9/9.9/datafiles/colormanagement");
        std::fs::create_dir_all(&data).unwrap();
        std::fs::write(data.join("config.ocio"), "ocio_profile_version: 47\n").unwrap();
        let mut places = SearchPlaces {
            root: folder.path().to_owned(),
            ..SearchPlaces::default()
        };
        let config = ColorConfig::locate_in(None, &places).unwrap();
        assert_eq!(
            config.origin(),
            &ConfigOrigin::BuiltIn("ocio://default".into())
        );
        assert!(
            config
                .warnings()
                .iter()
                .any(|warning| warning.contains("blender-9.9")),
            "{:?}",
            config.warnings()
        );
        // But what $OCIO names is not passed over.
        places.ocio = Some(data.join("config.ocio").into());
        assert!(matches!(
            ColorConfig::locate_in(None, &places),
            Err(ColorError::Broken { .. })
        ));
    }

    #[test]
    fn a_table_that_is_missing_and_a_space_that_is_unknown_are_sentences() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.ocio");
        let text = "ocio_profile_version: 2.1\nsearch_path: luts\nroles: {default: lin, scene_linear: lin}\n\
                    displays:\n  d:\n    - !<View> {name: v, colorspace: shown}\n\
                    colorspaces:\n  - !<ColorSpace>\n    name: lin\n  - !<ColorSpace>\n    name: shown\n    \
                    from_scene_reference: !<FileTransform> {src: table.cube}\n";
        std::fs::write(&path, text).unwrap();
        let config = ColorConfig::locate(Some(&path)).unwrap();
        let error = config.processor(&DisplayTransform::default()).unwrap_err();
        assert!(matches!(error, ColorError::NoRec709 { .. }), "{error:?}");
        let known = text.replace(
            "scene_linear: lin}",
            "scene_linear: lin, aces_interchange: lin}",
        );
        std::fs::write(&path, known).unwrap();
        let config = ColorConfig::locate(Some(&path)).unwrap();
        let error = config.processor(&DisplayTransform::default()).unwrap_err();
        assert!(matches!(error, ColorError::Unmakeable { .. }), "{error:?}");
        assert!(error.to_string().contains("table.cube"), "{error}");
    }

    #[test]
    fn pixels_of_every_kind_can_be_shown_in_every_view() {
        let odd = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            1e-45,
            -0.0,
            65504.0,
            0.5,
        ];
        let count = odd.len();
        let pixels: Vec<[f32; 4]> = (0..count.pow(4))
            .map(|index| {
                std::array::from_fn(|channel| odd[index / count.pow(channel as u32) % count])
            })
            .collect();
        let config = ColorConfig::locate(Some(Path::new("ocio://default"))).unwrap();
        for display in config.displays().unwrap() {
            for listed in display.views {
                let looks = listed
                    .looks
                    .iter()
                    .map(|look| Some(look.clone()))
                    .chain([None]);
                for look in looks {
                    let wanted = DisplayTransform {
                        look,
                        exposure: 3.0,
                        gamma: 1.5,
                        ..view(&display.name, &listed.name)
                    };
                    let processor = config.processor(&wanted).unwrap();
                    assert_eq!(
                        eight_bits(&processor, SceneColors::Rgba(&pixels)).len(),
                        pixels.len() * 4
                    );
                    assert_eq!(
                        eight_bits(&processor, SceneColors::RgbaOnBlack(&pixels)).len(),
                        pixels.len() * 3
                    );
                }
            }
        }
    }

    #[test]
    fn the_picture_does_not_depend_on_the_number_of_threads() {
        let config = built_in();
        let processor = config.processor(&DisplayTransform::default()).unwrap();
        let pixels: Vec<[f32; 3]> = (0..20_001)
            .map(|i| [i as f32 * 1e-4, (i % 977) as f32 * 1e-3, (i % 13) as f32])
            .collect();
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                processor
                    .show(SceneColors::Rgb(&pixels), Depth::Sixteen)
                    .unwrap()
            })
        };
        let alone = with(1);
        assert_eq!(alone.channels, 3);
        assert_eq!(with(2), alone);
        assert_eq!(with(7), alone);
        assert!(processor.show(SceneColors::Rgb(&[]), Depth::Eight).is_ok());
    }
}
