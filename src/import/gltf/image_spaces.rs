//! Images whose numbers are of any colour space of the scene's configuration.

use crate::color::{ColorConfig, ColorError};
use crate::math::srgb;
use crate::scene::{
    ColorManagement, Diagnostics, Image, ImageAlpha, ImageId, Pixels, Subject, Values, Verdict,
};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// What becomes of an image's numbers before they are interpolated, as Cycles does it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Conversion {
    /// The colour space, by its name in the configuration.
    pub space: String,
    /// What opacity does to the colours of the file. (What is converted is multiplied with it, unless it does nothing.)
    pub alpha: ImageAlpha,
}

/// Brings images to the scene's working space.
pub(super) fn convert(
    conversions: &[(ImageId, Conversion)],
    images: &mut [Image],
    colors: &ColorManagement,
    diagnostics: &mut Diagnostics,
) {
    if conversions.is_empty() {
        return;
    }
    let config = match &colors.config {
        Some(path) => ColorConfig::read_named_by_scene(path),
        None => ColorConfig::locate(None),
    };
    let mut processors = HashMap::new();
    for (id, conversion) in conversions {
        let Some(image) = images.get_mut(id.0 as usize) else {
            continue;
        };
        let processor = processors.entry(&conversion.space).or_insert_with(|| {
            let config = config.as_ref().map_err(ColorError::clone)?;
            config.input_processor(&conversion.space, colors.working_space.name())
        });
        let apply = |texels: &mut [[f32; 4]]| match &*processor {
            Ok(processor) => processor.apply(texels),
            Err(error) => Err(error.clone()),
        };
        if let Err(error) = convert_one(image, conversion.alpha, apply) {
            diagnostics.report(
                "image-space",
                Verdict::Approximated,
                format!("images in the colour space \"{}\"", conversion.space),
                Subject::from(image.name.as_str()),
                format!("they are read as sRGB, as {error}"),
            );
            // What cannot fail.
            let decode = |texels: &mut [[f32; 4]]| {
                for texel in texels {
                    for value in &mut texel[..3] {
                        *value = srgb::decode(*value);
                    }
                }
                Ok(())
            };
            let _ = convert_one(image, conversion.alpha, decode);
        }
    }
}

/// Converts the colours of an image, as they are without their opacity.
fn convert_one(
    image: &mut Image,
    alpha: ImageAlpha,
    apply: impl Fn(&mut [[f32; 4]]) -> Result<(), ColorError>,
) -> Result<(), ColorError> {
    let channels = image.channels.clamp(1, 4) as usize;
    let made = if matches!(channels, 1 | 3) {
        channels
    } else {
        4
    };
    let count = image.width as usize * image.height as usize;
    let mut values = Values::<f32>::zeros(made * count, image.pixels.place());
    let mut texels = Vec::with_capacity(STRIPE);
    for (stripe, into) in values.chunks_mut(made * STRIPE).enumerate() {
        let first = stripe * STRIPE;
        let taken = first..first + into.len() / made;
        texels.clear();
        texels.extend(taken.map(|i| image.pixels.texel(channels, i * channels).to_array()));
        convert_texels(&mut texels, alpha, &apply)?;
        for (into, texel) in into.chunks_exact_mut(made).zip(&texels) {
            match into {
                // One number stays one: the mean of what it becomes.
                [one] => *one = texel[..3].iter().sum::<f32>() / 3.0,
                several => several.copy_from_slice(&texel[..made]),
            }
        }
    }
    image.channels = made as u32;
    image.pixels = Pixels::F32(Arc::new(values));
    Ok(())
}

/// Texels that are converted together.
const STRIPE: usize = 1 << 18;

fn convert_texels(
    texels: &mut [[f32; 4]],
    alpha: ImageAlpha,
    apply: impl Fn(&mut [[f32; 4]]) -> Result<(), ColorError>,
) -> Result<(), ColorError> {
    let associated = !matches!(alpha, ImageAlpha::ChannelPacked | ImageAlpha::None);
    let part = |alpha: f32| associated && alpha > 0.0 && alpha != 1.0;
    texels.par_iter_mut().for_each(|texel| {
        let [.., share] = *texel;
        let factor = match alpha {
            // Nothing is left of them.
            ImageAlpha::Straight { .. } if share <= 0.0 => 0.0,
            ImageAlpha::Premultiplied { .. } if part(share) => 1.0 / share,
            _ => return,
        };
        texel[..3].iter_mut().for_each(|value| *value *= factor);
    });
    apply(texels)?;
    if associated {
        texels.par_iter_mut().for_each(|texel| {
            let [.., share] = *texel;
            if part(share) {
                texel[..3].iter_mut().for_each(|value| *value *= share);
            }
        });
    }
    Ok(())
}
