//! Linear light becomes what a display shows, and that a file.

use super::display::{self, DisplayPicture};
use super::{Format, Metadata, OutputError};
use crate::color::{
    ColorConfig, ColorError, Depth, DisplayProcessor, DisplayTransform, SceneColors,
};
use crate::math::primaries::WorkingSpace;
use glam::DVec3;
use std::borrow::Cow;
use std::path::Path;

/// Why a picture could not be shown, or the file not be written.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// OpenColorIO fails.
    #[error(transparent)]
    Color(#[from] ColorError),
    /// The file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Quality of JPEG files in percent, without the flag.
const QUALITY: u8 = 90;

/// Everything that makes display values of linear light, ready.
pub struct View {
    processor: DisplayProcessor,
    config: String,
    /// Of PNG files.
    pub depth: Depth,
    /// Of JPEG files, in percent.
    pub quality: u8,
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
    /// Light of a space through a display, view and look of a configuration.
    ///
    /// # Errors
    /// There is no such display, view or look: one sentence that names those there are.
    pub fn through(
        config: &ColorConfig,
        wanted: &DisplayTransform,
        space: WorkingSpace,
    ) -> Result<Self, ColorError> {
        let processor = config.processor(wanted)?;
        let origin = config.origin();
        Ok(Self {
            processor,
            config: format!("{} ({})", origin.path().display(), origin.named_by()),
            depth: Depth::default(),
            quality: QUALITY,
            space,
        })
    }

    /// What OpenColorIO has to say of it, a sentence each.
    pub fn warnings(&self) -> &[String] {
        self.processor.warnings()
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

    /// Display values of linear light, as floats, clipped to what a display shows. What is not finite stays so.
    ///
    /// # Errors
    /// OpenColorIO fails.
    pub fn show(&self, light: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, ColorError> {
        let mut pixels = light.to_vec();
        to_rec709(self.space, &mut pixels);
        self.processor.show_in_place(&mut pixels)?;
        for (shown, light) in pixels.iter_mut().zip(light) {
            if !light.iter().all(|value| value.is_finite()) {
                *shown = [f32::NAN; 3];
            }
            *shown = shown.map(|value| value.clamp(0.0, 1.0));
        }
        Ok(pixels)
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
    ) -> Result<(), ViewError> {
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
