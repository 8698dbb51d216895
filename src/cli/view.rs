//! From the flags of display, view and look to finished pictures; shared by `render` and `color apply`.

use super::{Failure, args};
use crate::color::{
    ColorConfig, ColorError, Depth, DisplayProcessor, DisplayTransform, SceneColors,
};
use crate::math::primaries::WorkingSpace;
use crate::measure::{self, Encoding};
use crate::output::display::{self, DisplayPicture};
use crate::output::{Format, Metadata};
use crate::scene::ColorManagement;
use glam::DVec3;
use std::borrow::Cow;
use std::path::Path;

impl From<ColorError> for Failure {
    fn from(error: ColorError) -> Self {
        Failure::new(error.to_string())
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

/// Quality of JPEG files in percent, without the flag.
const QUALITY: u8 = 90;

/// Everything that makes display values of linear light, ready.
pub struct View {
    processor: DisplayProcessor,
    config: String,
    depth: Depth,
    quality: u8,
    /// What the light is numbers of. The processor takes linear Rec.709.
    space: WorkingSpace,
}

/// Brings colours of a space to linear Rec.709; whatever stands behind the third number stays.
pub fn to_rec709<const N: usize>(space: WorkingSpace, pixels: &mut [[f32; N]]) {
    let Some(matrix) = space.matrix_to_rec709() else {
        return;
    };
    for pixel in pixels {
        if let [r, g, b, ..] = pixel.as_mut_slice() {
            let light = matrix * DVec3::new(f64::from(*r), f64::from(*g), f64::from(*b));
            [*r, *g, *b] = light.as_vec3().to_array();
        }
    }
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
        Ok(Self {
            depth: flags.depth.unwrap_or_default(),
            quality: flags.quality.map_or(QUALITY, |quality| quality as u8),
            ..Self::seen_by(&flags.seen, wishes, warn)?
        })
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
        let processor = config.processor(&wanted)?;
        for warning in processor.warnings() {
            warn(warning);
        }
        Ok(Self {
            processor,
            config: format!(
                "{} ({})",
                config.origin().path().display(),
                config.origin().named_by()
            ),
            depth: Depth::default(),
            quality: QUALITY,
            space: wishes.working_space,
        })
    }

    /// One line about what is shown how.
    pub fn summary(&self) -> String {
        let shown = self.processor.resolved();
        let look = shown
            .look
            .as_deref()
            .map(|look| format!(", look {look}"))
            .unwrap_or_default();
        format!(
            "display {}, view {}{look}; configuration {}",
            shown.display, shown.view, self.config
        )
    }

    /// What is seen of linear light, as floats, clipped to what a display shows. What is not finite stays so.
    ///
    /// # Errors
    /// OpenColorIO fails.
    pub fn seen(&self, picture: &measure::Picture) -> Result<measure::Picture, Failure> {
        let mut pixels = picture.pixels.clone();
        to_rec709(self.space, &mut pixels);
        self.processor.show_in_place(&mut pixels)?;
        for (shown, light) in pixels.iter_mut().zip(&picture.pixels) {
            if !light.iter().all(|value| value.is_finite()) {
                *shown = [f32::NAN; 3];
            }
            *shown = shown.map(|value| value.clamp(0.0, 1.0));
        }
        Ok(measure::Picture {
            pixels,
            encoding: Encoding::Display,
            ..*picture
        })
    }

    /// Shows linear pixels of the scene's space with associated alpha and writes them as PNG or JPEG. Alpha is kept
    /// in a PNG if there is any; a JPEG shows the picture on black.
    ///
    /// # Errors
    /// OpenColorIO fails, or the file cannot be written.
    pub fn write(
        &self,
        path: &Path,
        format: Format,
        width: u32,
        height: u32,
        pixels: &[[f32; 4]],
        metadata: &Metadata,
    ) -> Result<(), Failure> {
        let mut pixels = Cow::Borrowed(pixels);
        if self.space != WorkingSpace::default() {
            to_rec709(self.space, pixels.to_mut());
        }
        let pixels = &*pixels;
        let opaque = pixels.iter().all(|pixel| pixel[3] == 1.0);
        let (colors, depth) = match format {
            Format::Jpeg => (SceneColors::RgbaOnBlack(pixels), Depth::Eight),
            _ if opaque => (SceneColors::RgbaOnBlack(pixels), self.depth),
            _ => (SceneColors::Rgba(pixels), self.depth),
        };
        let shown = self.processor.show(colors, depth)?;
        let mut metadata = metadata.clone();
        let resolved = self.processor.resolved();
        for (name, value) in [
            ("config", self.config.clone()),
            ("display", resolved.display.clone()),
            ("view", resolved.view.clone()),
            (
                "look",
                resolved.look.clone().unwrap_or_else(|| "None".into()),
            ),
            ("exposure", resolved.exposure.to_string()),
            ("gamma", resolved.gamma.to_string()),
        ] {
            metadata.push((format!("sundog/{name}"), value));
        }
        display::write(
            path,
            format,
            DisplayPicture {
                width,
                height,
                pixels: &shown,
            },
            self.quality,
            &metadata,
        )?;
        Ok(())
    }
}
