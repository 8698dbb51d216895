//! Pixels, the reconstruction filter, layers.

pub mod apart;
pub mod filter;
pub mod passes;
pub mod pixel;

pub use passes::{Pass, Passes};

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
    /// Blender's name of the pass: `Combined`, `Depth`, `Normal`, `Position`, `Denoising Albedo`, `Debug Sample Count`.
    pub name: String,
    /// Channel names as Blender's compositor reads them: R G B A, Z, X Y Z, X.
    pub channels: Vec<String>,
    /// Values.
    pub data: Vec<f32>,
}
