//! Linear pictures with layers, as OpenEXR.

use super::{Metadata, OutputError, atomic_write};
use crate::film::{Layer, Picture};
use crate::math::primaries::WorkingSpace;
use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Image,
    LayerAttributes, Text, Vec2, WritableImage, f16,
};
use rayon::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number format of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SampleType {
    /// 32 bits.
    #[default]
    Float,
    /// 16 bits. Distances, positions, counts and numbers of mattes stay at 32 bits: 16 would round them to uselessness.
    Half,
}

/// How an EXR file is written.
#[derive(Clone, Copy, Debug)]
pub struct ExrOptions {
    /// Number format.
    pub sample_type: SampleType,
    /// Compression.
    pub compression: Compression,
    /// All layers, or the first one alone.
    pub all_layers: bool,
    /// What the colours are numbers of.
    pub space: WorkingSpace,
}

impl Default for ExrOptions {
    fn default() -> Self {
        Self {
            sample_type: SampleType::Float,
            compression: Compression::ZIP16,
            all_layers: true,
            space: WorkingSpace::default(),
        }
    }
}

/// What has been written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Values that were too large for 16 bits and became 65504.
    pub clamped: usize,
}

/// Writes the layers of a picture into one EXR file.
///
/// # Errors
/// A layer does not fit the picture's size, or the file cannot be written; then there is no file.
pub fn write(
    path: &Path,
    picture: &Picture,
    options: &ExrOptions,
    metadata: &Metadata,
) -> Result<Written, OutputError> {
    let failed = |reason: String| OutputError::Failed {
        path: path.display().to_string(),
        reason,
    };
    let pixels = picture.width as usize * picture.height as usize;
    if pixels == 0 {
        return Err(failed("the picture has no pixels".into()));
    }
    let kept = if options.all_layers {
        picture.layers.len()
    } else {
        1
    };
    let mut wanted = Vec::new();
    for layer in picture.layers.iter().take(kept) {
        if layer.channels.is_empty() || layer.data.len() != pixels * layer.channels.len() {
            return Err(failed(format!(
                "its layer {} does not fit the size of the picture",
                layer.name
            )));
        }
        for (index, channel) in layer.channels.iter().enumerate() {
            let name = Text::new_or_none(channel_name(&layer.name, channel)).ok_or_else(|| {
                failed(format!(
                    "the name of its layer {} is not plain text",
                    layer.name
                ))
            })?;
            wanted.push((name, layer, index));
        }
    }
    let clamped = AtomicUsize::new(0);
    let channels: Vec<AnyChannel<FlatSamples>> = wanted
        .into_par_iter()
        .map(|(name, layer, index)| {
            let samples = layer.data.iter().skip(index);
            let samples = samples.step_by(layer.channels.len()).copied();
            AnyChannel::new(
                name,
                match options.sample_type {
                    SampleType::Half if fits_half(layer) => {
                        let mut too_large = 0;
                        let values = samples
                            .map(|value| to_half(value, &mut too_large))
                            .collect();
                        clamped.fetch_add(too_large, Ordering::Relaxed);
                        FlatSamples::F16(values)
                    }
                    _ => FlatSamples::F32(samples.collect()),
                },
            )
        })
        .collect();
    let mut attributes = LayerAttributes {
        software_name: Text::new_or_none(concat!("Sundog ", env!("CARGO_PKG_VERSION"))),
        ..LayerAttributes::default()
    };
    for (name, value) in metadata {
        if let Some(name) = Text::new_or_none(name) {
            // Strings in EXR files are bytes; readers, Blender among them, take them as UTF-8.
            attributes.other.insert(
                name,
                AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes())),
            );
        }
    }
    let encoding = Encoding {
        compression: options.compression,
        ..Encoding::SMALL_LOSSLESS
    };
    let layer = exr::prelude::Layer::new(
        Vec2(picture.width as usize, picture.height as usize),
        attributes,
        encoding,
        AnyChannels::sort(channels.into()),
    );
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(chromaticities(options.space));
    if let (Some(name), Some(id)) = (
        Text::new_or_none("colorInteropID"),
        Text::new_or_none(options.space.interop_id()),
    ) {
        // What Blender 5.0 and later know the space by.
        image
            .attributes
            .other
            .insert(name, AttributeValue::Text(id));
    }
    atomic_write(path, |file| image.write().to_buffered(file))?;
    Ok(Written {
        clamped: clamped.into_inner(),
    })
}

/// The primaries and white point of a space.
fn chromaticities(space: WorkingSpace) -> Chromaticities {
    let vector = |[x, y]: [f64; 2]| Vec2(x as f32, y as f32);
    let primaries = space.primaries();
    Chromaticities {
        red: vector(primaries.red),
        green: vector(primaries.green),
        blue: vector(primaries.blue),
        white: vector(primaries.white),
    }
}

/// The picture itself has plain `R`, `G`, `B`, `A`, so that every viewer shows it; the other layers have
/// names like `Depth.Z`. Blender (tried with 4.5 and 5.0) reads such a file as a multilayer one, with
/// `Combined` and all other passes under their names. With a layer's name in front (`ViewLayer.Depth.Z`,
/// as Blender writes it) it reads the same, but other viewers find no picture; with both, it finds
/// nothing at all.
pub(super) fn channel_name(layer: &str, channel: &str) -> String {
    if layer == COMBINED {
        channel.into()
    } else {
        format!("{layer}.{channel}")
    }
}

/// Blender's name of the picture itself.
const COMBINED: &str = "Combined";

/// Whether 16 bits are enough for a layer: for colours and directions they are.
fn fits_half(layer: &Layer) -> bool {
    !(layer.name.starts_with("Crypto")
        || matches!(
            layer.name.as_str(),
            "Depth"
                | "Denoising Depth"
                | "Position"
                | "IndexOB"
                | "IndexMA"
                | "Debug Sample Count"
                | "Error"
                | "Cost"
        ))
}

fn to_half(value: f32, clamped: &mut usize) -> f16 {
    let largest = f16::MAX.to_f32();
    if value.is_finite() && value.abs() > largest {
        *clamped += 1;
        return f16::from_f32(largest.copysign(value));
    }
    f16::from_f32(value)
}
