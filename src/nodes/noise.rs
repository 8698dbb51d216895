//! Blender's Noise Texture.

use glam::Vec3;
use pulp::NullaryFnOnce;

use super::fractal::Octaves;
use super::perlin::{Noise, Point};
use super::{Dimensions, on_vectors};

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
    match settings.dimensions {
        Dimensions::One => fac(settings, inputs, point::<1>(inputs)),
        Dimensions::Two => fac(settings, inputs, point::<2>(inputs)),
        Dimensions::Three => fac(settings, inputs, point::<3>(inputs)),
        Dimensions::Four => fac(settings, inputs, point::<4>(inputs)),
    }
}

/// The node's outputs: Fac and Color.
pub fn noise(settings: &NoiseSettings, inputs: &NoiseInputs) -> (f32, Vec3) {
    let color = match settings.dimensions {
        Dimensions::One => color(settings, inputs, point::<1>(inputs), 1),
        Dimensions::Two => color(settings, inputs, point::<2>(inputs), 2),
        Dimensions::Three => color(settings, inputs, point::<3>(inputs), 3),
        Dimensions::Four => color(settings, inputs, point::<4>(inputs), 4),
    };
    (color.x, color)
}

/// The scaled coordinates that count: W alone in one dimension, after the vector's in four.
fn point<const N: usize>(inputs: &NoiseInputs) -> Point<N> {
    let p = inputs.vector.extend(inputs.w) * inputs.scale;
    Point::from_axes(|axis| if N == 1 { p.w } else { p[axis] })
}

fn fac<P: Noise>(settings: &NoiseSettings, inputs: &NoiseInputs, p: P) -> f32 {
    fractal(settings, inputs, p.distorted(inputs.distortion))
}

/// Green and blue are the same noise elsewhere, at the first seeds that distortion leaves over.
fn color<P: Noise>(settings: &NoiseSettings, inputs: &NoiseInputs, p: P, seed: usize) -> Vec3 {
    let p = p.distorted(inputs.distortion);
    Vec3::new(
        fractal(settings, inputs, p),
        fractal(settings, inputs, p + P::random_offset(seed)),
        fractal(settings, inputs, p + P::random_offset(seed + 1)),
    )
}

fn fractal<P: Noise>(settings: &NoiseSettings, inputs: &NoiseInputs, p: P) -> f32 {
    on_vectors(Fractal {
        settings,
        inputs,
        p,
    })
}

/// One fractal of a node's settings at a point.
struct Fractal<'a, P> {
    settings: &'a NoiseSettings,
    inputs: &'a NoiseInputs,
    p: P,
}

impl<P: Noise> NullaryFnOnce for Fractal<'_, P> {
    type Output = f32;

    #[inline(always)]
    fn call(self) -> f32 {
        let Self {
            settings,
            inputs,
            p,
        } = self;
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
}
