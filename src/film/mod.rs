//! Pixels, the reconstruction filter, layers.

pub mod catchers;
pub mod error;
mod extract;
pub mod features;
pub mod filter;
pub mod light_passes;
pub mod objects;
pub mod passes;
pub mod pixel;
pub mod sum;

pub use extract::Extract;
pub use passes::{Pass, Passes, TABLE, group_layer_prefix, group_layers};

use rayon::prelude::*;
use std::ops::Range;

/// A finished picture: layers of floats, scene-linear.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// The first one is the picture itself (`Combined`, RGBA, alpha associated).
    pub layers: Vec<Layer>,
}

/// One pass. `data` is interleaved, rows from top to bottom: `width * height * channels.len()` values.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Blender's name of the pass: `Combined`, `Depth`, `Normal`, `Position`, `Debug Sample Count`.
    pub name: String,
    /// Channel names as Blender's compositor reads them: R G B A, Z, X Y Z, X.
    pub channels: Vec<String>,
    /// Values.
    pub data: Vec<f32>,
}

/// A picture that can be had band by band, by several threads at a time.
pub trait Bands: Sync {
    /// Pixels a row, and rows.
    fn size(&self) -> (u32, u32);
    /// Names of the layers, and their channels, a letter each.
    fn layers(&self) -> Vec<(String, String)>;
    /// The rows of each band, from top to bottom without gaps.
    fn bands(&self) -> Vec<Range<u32>>;
    /// Writes a band's rows of each layer, from top to bottom.
    fn fill(&self, band: usize, layers: &mut [&mut [f32]]);
    /// Whether a band has something to show everywhere, at least a sample.
    fn is_begun(&self, _band: usize) -> bool {
        true
    }
}

impl Picture {
    /// All bands together, by the threads of the current pool.
    pub fn collect(source: &dyn Bands) -> Self {
        let (width, height) = source.size();
        let size = width as usize * height as usize;
        let mut layers: Vec<Layer> = source
            .layers()
            .into_iter()
            .map(|(name, channels)| Layer {
                data: vec![0.0; size * channels.len()],
                name,
                channels: channels.chars().map(String::from).collect(),
            })
            .collect();
        let bands = source.bands();
        let mut parts: Vec<Vec<&mut [f32]>> = bands.iter().map(|_| Vec::new()).collect();
        for layer in &mut layers {
            let row = width as usize * layer.channels.len();
            let mut rest = layer.data.as_mut_slice();
            for (rows, part) in bands.iter().zip(&mut parts) {
                let (first, after) = rest.split_at_mut(row * rows.len());
                part.push(first);
                rest = after;
            }
        }
        parts
            .par_iter_mut()
            .enumerate()
            .for_each(|(band, part)| source.fill(band, part));
        Self {
            width,
            height,
            layers,
        }
    }

    /// The picture before it was denoised: `None` if it has no such layer.
    pub fn noisy(&self) -> Option<Self> {
        let mut layers = self.layers.iter();
        let noisy = layers.find(|layer| layer.name == Pass::NoisyImage.name())?;
        Some(Self {
            layers: vec![noisy.clone()],
            ..*self
        })
    }

    /// The pixels of the first layer, which is the picture itself, with associated alpha (1 where there is none).
    pub fn colors(&self) -> impl Iterator<Item = [f32; 4]> {
        let pixels = self.layers.iter().take(1).flat_map(|layer| {
            let channels = layer.channels.len().max(1);
            layer.data.chunks_exact(channels)
        });
        pixels.map(|pixel| {
            let channel = |c: usize| pixel.get(c).copied();
            let [r, g, b] = [0, 1, 2].map(|c| channel(c).unwrap_or(0.0));
            [r, g, b, channel(3).unwrap_or(1.0)]
        })
    }
}

/// Rows of a band of a finished picture.
const BAND: u32 = 32;

impl Bands for Picture {
    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn layers(&self) -> Vec<(String, String)> {
        let layers = self.layers.iter();
        layers
            .map(|layer| (layer.name.clone(), layer.channels.concat()))
            .collect()
    }

    fn bands(&self) -> Vec<Range<u32>> {
        let starts = (0..self.height).step_by(BAND as usize);
        starts
            .map(|from| from..(from + BAND).min(self.height))
            .collect()
    }

    fn fill(&self, band: usize, layers: &mut [&mut [f32]]) {
        let start = band * BAND as usize * self.width as usize;
        for (layer, part) in self.layers.iter().zip(layers) {
            let n = layer.channels.len();
            part.copy_from_slice(&layer.data[start * n..][..part.len()]);
        }
    }
}
