//! A colour configuration, what can be chosen in it, and the way from a choice to a processor.

use crate::color::locate::{SearchPlaces, is_built_in_name};
use crate::color::looks::{Meant, find_look, looks_for_view};
use crate::color::pixels::{PIECE, to_display};
use crate::color::{ColorError, ConfigOrigin, Depth, DisplayPixels, SceneColors, tables};
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
        if !is_built_in_name(path) {
            // Those of an archive lie in it.
            if path.extension().is_some_and(|e| e == "ocioz") {
                if let Some((table, reason)) = tables::fault_in_archive(path) {
                    return Err(config.refused_table(table, reason));
                }
            } else {
                config.check_tables()?;
            }
        }
        Ok(config)
    }

    /// Refuses tables that OpenColorIO would read for ever, or that would take all memory.
    fn check_tables(&self) -> Result<(), ColorError> {
        for table in self.config.files().map_err(self.broken())? {
            let reason = match check_file(&table) {
                // Not there: an error only where it is used.
                Err(_) if !table.exists() => continue,
                Err(reason) => reason,
                Ok(length) => match tables::fault(&table, length) {
                    Some(reason) => reason,
                    None => continue,
                },
            };
            return Err(self.refused_table(table.display().to_string(), reason));
        }
        Ok(())
    }

    fn refused_table(&self, table: String, reason: String) -> ColorError {
        ColorError::Table {
            origin: self.origin.clone(),
            table,
            reason,
        }
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

impl ColorConfig {
    /// Makes what turns an image's numbers, which are of a colour space of the configuration, into those of a working space, by
    /// its name in Blender.
    ///
    /// # Errors
    /// There is no such space, or no way from it; a file that the way needs cannot be read.
    pub fn input_processor(
        &self,
        space: &str,
        working: &str,
    ) -> Result<InputProcessor, ColorError> {
        let broken = |error: OcioError| ColorError::NoInput {
            space: space.to_owned(),
            origin: self.origin.clone(),
            reason: error.text,
        };
        // Blender's working space stands in its configuration by its own name. Others have it as the role alone.
        let is_role = working == "Linear Rec.709"
            && self.config.is_scene_linear_rec709().unwrap_or(false)
            || !self.config.has_colour_space(working).map_err(broken)?;
        let target = if is_role { "scene_linear" } else { working };
        let processor = self
            .config
            .convert_processor(space, target)
            .map_err(broken)?;
        Ok(InputProcessor { processor })
    }
}

/// Turns an image's numbers into those of a working space.
#[derive(Debug)]
pub struct InputProcessor {
    processor: Processor,
}

impl InputProcessor {
    /// Turns colours in place, on all threads of the current rayon pool; alpha stays.
    ///
    /// # Errors
    /// If OpenColorIO fails.
    pub fn apply(&self, texels: &mut [[f32; 4]]) -> Result<(), ColorError> {
        texels
            .par_chunks_mut(PIECE)
            .try_for_each(|texels| self.processor.apply_rgba(texels))
            .map_err(|error| ColorError::Apply { reason: error.text })
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
#[path = "../../tests/unit/color/config.rs"]
mod tests;
