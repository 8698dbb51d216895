//! Blender's Noise Texture.

use glam::Vec3;

use super::Dimensions;
use super::fractal::Octaves;
use super::perlin::Coordinates;

choice! {
    /// How the octaves are put together. Blender makes this node of older files' Musgrave Texture, too.
    NoiseType {
        /// The product of octaves.
        Multifractal = "MULTIFRACTAL",
        /// Ridges where the noise crosses zero.
        RidgedMultifractal = "RIDGED_MULTIFRACTAL",
        /// Sum and product of octaves in one.
        HybridMultifractal = "HYBRID_MULTIFRACTAL",
        /// Fractal Brownian motion, the sum of octaves.
        Fbm = "FBM",
        /// Rougher where it is high.
        HeteroTerrain = "HETERO_TERRAIN",
    }
}

/// The node's menus and boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseSettings {
    /// How many coordinates count.
    pub dimensions: Dimensions,
    /// How octaves are put together.
    pub noise_type: NoiseType,
    /// Whether fBM is brought to 0..1; it says nothing to the other types.
    pub normalize: bool,
}

/// The node's sockets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseInputs {
    /// Vector.
    pub vector: Vec3,
    /// W, the coordinate of 1D and the fourth of 4D.
    pub w: f32,
    /// Scale, of the vector and of W.
    pub scale: f32,
    /// Detail, 0 to 15.
    pub detail: f32,
    /// Roughness, at least 0.
    pub roughness: f32,
    /// Lacunarity.
    pub lacunarity: f32,
    /// Offset, of the hybrid and ridged multifractals and of hetero terrain.
    pub offset: f32,
    /// Gain, of the hybrid and ridged multifractals.
    pub gain: f32,
    /// Distortion, by as much noise on each axis.
    pub distortion: f32,
}

impl Default for NoiseInputs {
    fn default() -> Self {
        Self {
            vector: Vec3::ZERO,
            w: 0.0,
            scale: 5.0,
            detail: 2.0,
            roughness: 0.5,
            lacunarity: 2.0,
            offset: 0.0,
            gain: 1.0,
            distortion: 0.0,
        }
    }
}

/// The factor alone, at a third of the colour's cost.
pub fn noise_fac(settings: &NoiseSettings, inputs: &NoiseInputs) -> f32 {
    let vector = inputs.vector * inputs.scale;
    let w = inputs.w * inputs.scale;
    match settings.dimensions {
        Dimensions::One => fac(settings, inputs, w),
        Dimensions::Two => fac(settings, inputs, vector.truncate()),
        Dimensions::Three => fac(settings, inputs, vector),
        Dimensions::Four => fac(settings, inputs, vector.extend(w)),
    }
}

/// The node's outputs: Fac and Color.
pub fn noise(settings: &NoiseSettings, inputs: &NoiseInputs) -> (f32, Vec3) {
    let vector = inputs.vector * inputs.scale;
    let w = inputs.w * inputs.scale;
    let color = match settings.dimensions {
        Dimensions::One => color(settings, inputs, w),
        Dimensions::Two => color(settings, inputs, vector.truncate()),
        Dimensions::Three => color(settings, inputs, vector),
        Dimensions::Four => color(settings, inputs, vector.extend(w)),
    };
    (color.x, color)
}

fn fac<P: Coordinates>(settings: &NoiseSettings, inputs: &NoiseInputs, p: P) -> f32 {
    fractal(settings, inputs, distorted(p, inputs.distortion))
}

/// Green and blue are the same noise elsewhere, at the first seeds that distortion leaves over.
fn color<P: Coordinates>(settings: &NoiseSettings, inputs: &NoiseInputs, p: P) -> Vec3 {
    let p = distorted(p, inputs.distortion);
    let seed = P::AXES;
    Vec3::new(
        fractal(settings, inputs, p),
        fractal(settings, inputs, p + P::random_offset(seed)),
        fractal(settings, inputs, p + P::random_offset(seed + 1)),
    )
}

/// The point moved along each axis by noise of that axis' seed.
fn distorted<P: Coordinates>(p: P, distortion: f32) -> P {
    if distortion == 0.0 {
        return p;
    }
    p + P::from_axes(|axis| (p + P::random_offset(axis)).signed_noise() * distortion)
}

fn fractal<P: Coordinates>(settings: &NoiseSettings, inputs: &NoiseInputs, p: P) -> f32 {
    let octaves = Octaves {
        detail: inputs.detail.clamp(0.0, 15.0),
        roughness: inputs.roughness.max(0.0),
        lacunarity: inputs.lacunarity,
    };
    let (offset, gain) = (inputs.offset, inputs.gain);
    match settings.noise_type {
        NoiseType::Multifractal => octaves.multifractal(p),
        NoiseType::RidgedMultifractal => octaves.ridged_multifractal(p, offset, gain),
        NoiseType::HybridMultifractal => octaves.hybrid_multifractal(p, offset, gain),
        NoiseType::Fbm => octaves.fbm(p, settings.normalize),
        NoiseType::HeteroTerrain => octaves.hetero_terrain(p, offset),
    }
}
