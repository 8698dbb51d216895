//! From the flags of display, view and look to finished pictures; shared by `render` and `color apply`.

use super::{Failure, args};
use crate::color::{ColorConfig, DisplayTransform};
use crate::math::primaries::WorkingSpace;
use crate::measure::{self, Encoding};
use crate::output::ViewError;
pub use crate::output::{View, to_rec709};
use crate::scene::ColorManagement;
use std::path::Path;

impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::Color(error) => error.into(),
            ViewError::Output(error) => error.into(),
        }
    }
}

impl args::Seen {
    /// The first flag given.
    pub fn first_given(&self) -> Option<&'static str> {
        let flags = [
            ("ocio", self.ocio.is_some()),
            ("display", self.display.is_some()),
            ("view", self.view.is_some()),
            ("look", self.look.is_some()),
            ("exposure", self.exposure.is_some()),
            ("gamma", self.gamma.is_some()),
        ];
        flags
            .into_iter()
            .find_map(|(name, given)| given.then_some(name))
    }
}

impl args::View {
    /// The first flag given; PNG and JPEG files alone heed them.
    pub fn first_given(&self) -> Option<&'static str> {
        let seen = self.seen.first_given();
        let depth = || self.depth.map(|_| "depth");
        seen.or_else(depth)
            .or_else(|| self.quality.map(|_| "quality"))
    }
}

/// The space of the light in a file, and what the flags then start from; a file that doesn't say, or names one that Sundog does
/// not know, is taken for linear Rec.709 (for the latter with a warning).
///
/// # Errors
/// The file cannot be read.
pub fn wishes_of(path: &Path, warn: &dyn Fn(&str)) -> Result<ColorManagement, Failure> {
    let space = match measure::working_space(path)? {
        measure::LightSpace::Known(space) => space,
        measure::LightSpace::Unsaid => WorkingSpace::default(),
        measure::LightSpace::Other(name) => {
            warn(&format!(
                "{} is in a space that Sundog does not know ({name}); its numbers are taken as linear Rec.709",
                path.display()
            ));
            WorkingSpace::default()
        }
    };
    Ok(ColorManagement {
        working_space: space,
        ..ColorManagement::default()
    })
}

/// The flag's configuration; else the scene's, if it can be read; else that of the usual search.
fn configuration(
    flag: Option<&Path>,
    wishes: &ColorManagement,
    warn: &dyn Fn(&str),
) -> Result<ColorConfig, Failure> {
    if flag.is_none()
        && let Some(path) = &wishes.config
    {
        match ColorConfig::read_named_by_scene(path) {
            Ok(config) => return Ok(config),
            Err(error) => warn(&format!("{error}; the usual search takes its place")),
        }
    }
    Ok(ColorConfig::locate(flag)?)
}

impl View {
    /// As the flags say, and where they say nothing as the scene wishes. What the configuration has to tell
    /// goes through `warn`, a sentence each.
    ///
    /// # Errors
    /// The configuration cannot be read, or has no such display, view or look: one sentence that names
    /// those there are.
    pub fn new(
        flags: &args::View,
        wishes: &ColorManagement,
        warn: &dyn Fn(&str),
    ) -> Result<Self, Failure> {
        let mut view = Self::seen_by(&flags.seen, wishes, warn)?;
        view.depth = flags.depth.unwrap_or(view.depth);
        view.quality = flags.quality.map_or(view.quality, |quality| quality as u8);
        Ok(view)
    }

    /// The same for pictures that are looked at, of which no file is made.
    ///
    /// # Errors
    /// As [`View::new`].
    pub fn seen_by(
        flags: &args::Seen,
        wishes: &ColorManagement,
        warn: &dyn Fn(&str),
    ) -> Result<Self, Failure> {
        let config = configuration(flags.ocio.as_deref().map(Path::new), wishes, warn)?;
        for warning in config.warnings() {
            warn(warning);
        }
        let defaults = DisplayTransform::default();
        // The scene's view is one of its display, and its look one for that view: a flag for one of them
        // ends what the scene says of those that follow from it.
        let display = flags.display.is_some();
        let view = display || flags.view.is_some();
        let text = |flag: &Option<String>, overruled: bool, wish: &Option<String>| {
            let wish = wish.as_ref().filter(|_| !overruled);
            flag.as_ref().or(wish).cloned()
        };
        let number =
            |flag: Option<f64>, wish: Option<f64>, default| flag.or(wish).unwrap_or(default);
        let wanted = DisplayTransform {
            display: text(&flags.display, false, &wishes.display),
            view: text(&flags.view, display, &wishes.view),
            look: text(&flags.look, view, &wishes.look),
            exposure: number(flags.exposure, wishes.exposure, defaults.exposure),
            gamma: number(flags.gamma, wishes.gamma, defaults.gamma),
        };
        let view = View::through(&config, &wanted, wishes.working_space)?;
        view.warnings().iter().for_each(|warning| warn(warning));
        Ok(view)
    }

    /// What is seen of linear light, as floats, clipped to what a display shows. What is not finite stays so.
    ///
    /// # Errors
    /// OpenColorIO fails.
    pub fn seen(&self, picture: &measure::RgbImage) -> Result<measure::RgbImage, Failure> {
        Ok(measure::RgbImage {
            pixels: self.show(&picture.pixels)?,
            encoding: Encoding::Display,
            ..*picture
        })
    }
}
