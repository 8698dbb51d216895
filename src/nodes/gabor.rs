//! Blender's Gabor Texture: sparse convolution noise (Lagae et al. 2009, "Procedural Noise using Sparse Gabor Convolution") with
//! the improvements of Tavernier et al. 2019, "Making Gabor Noise Fast and Normalized", and phase and intensity of Tricard et
//! al. 2019, "Procedural Phasor Noise".

use std::f32::consts::{FRAC_1_SQRT_2, PI, TAU};

use glam::{Vec2, Vec3};

use super::hash;

choice! {
    /// How many coordinates count.
    GaborType {
        /// X and Y.
        TwoD = "2D",
        /// The vector.
        ThreeD = "3D",
    }
}

/// The node's sockets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaborInputs {
    /// Vector.
    pub vector: Vec3,
    /// Scale.
    pub scale: f32,
    /// Frequency of the waves in each kernel, at least 0.001.
    pub frequency: f32,
    /// Anisotropy, 0 to 1: how much the kernels have one direction.
    pub anisotropy: f32,
    /// Orientation of 2D, an angle.
    pub orientation_2d: f32,
    /// Orientation of 3D, of any length.
    pub orientation_3d: Vec3,
}

impl Default for GaborInputs {
    fn default() -> Self {
        Self {
            vector: Vec3::ZERO,
            scale: 5.0,
            frequency: 2.0,
            anisotropy: 1.0,
            orientation_2d: PI / 4.0,
            orientation_3d: Vec3::new(std::f32::consts::SQRT_2, std::f32::consts::SQRT_2, 0.0),
        }
    }
}

/// The node's outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaborOutputs {
    /// Value, about 0 to 1.
    pub value: f32,
    /// Phase, 0 to 1.
    pub phase: f32,
    /// Intensity.
    pub intensity: f32,
}

/// Kernels in each cell: their number is fixed, which Tavernier et al. found better than Poisson's distribution.
const IMPULSES: usize = 8;

/// Blender's Gabor Texture.
pub fn gabor(gabor_type: GaborType, inputs: &GaborInputs) -> GaborOutputs {
    let p = inputs.vector * inputs.scale;
    let kernel = Kernel {
        frequency: inputs.frequency.max(0.001),
        isotropy: 1.0 - inputs.anisotropy.clamp(0.0, 1.0),
    };
    // The integral of the squared kernel, in the limit of high frequencies.
    let (phasor, integral) = match gabor_type {
        GaborType::TwoD => {
            let sum = kernel.sum_2d(p.truncate(), inputs.orientation_2d);
            (sum, 0.25)
        }
        GaborType::ThreeD => {
            let direction = inputs.orientation_3d.normalize_or_zero();
            (kernel.sum_3d(p, direction), 0.25 * FRAC_1_SQRT_2)
        }
    };
    // The second moment of weights that are −1 or 1 with equal probability, as Blender has it.
    const SECOND_MOMENT: f32 = 0.5;
    let deviation = (IMPULSES as f32 * SECOND_MOMENT * integral).sqrt();
    // Six deviations hold practically all values.
    let span = 6.0 * deviation;
    GaborOutputs {
        value: (phasor.y / span) * 0.5 + 0.5,
        phase: (phasor.y.atan2(phasor.x) + PI) / TAU,
        intensity: phasor.length() / span,
    }
}

/// What all kernels have in common.
struct Kernel {
    frequency: f32,
    isotropy: f32,
}

impl Kernel {
    fn sum_2d(&self, p: Vec2, orientation: f32) -> Vec2 {
        let cell = p.floor();
        let local = p - cell;
        let direction = self.direction_2d(orientation);
        let mut sum = Vec2::ZERO;
        for j in -1..=1 {
            for i in -1..=1 {
                let offset = Vec2::new(i as f32, j as f32);
                sum += self.cell_2d(cell + offset, local - offset, orientation, direction);
            }
        }
        sum
    }

    fn cell_2d(&self, cell: Vec2, p: Vec2, base_orientation: f32, base_direction: Vec2) -> Vec2 {
        let mut sum = Vec2::ZERO;
        for [for_orientation, for_center, for_weight] in seeds() {
            let random = |seed: f32| hash::unit_3(cell.x, cell.y, seed);
            let center = Vec2::new(random(for_center), hash::unit_3(for_center, cell.x, cell.y));
            let p = p - center;
            let squared = p.length_squared();
            if squared >= 1.0 {
                continue;
            }
            let direction = if self.isotropy == 0.0 {
                base_direction
            } else {
                let turn = (random(for_orientation) - 0.5) * PI;
                self.direction_2d(base_orientation + turn * self.isotropy)
            };
            sum += sign(random(for_weight)) * phasor(squared, p.dot(direction));
        }
        sum
    }

    fn direction_2d(&self, orientation: f32) -> Vec2 {
        let (sine, cosine) = orientation.sin_cos();
        Vec2::new(self.frequency * cosine, self.frequency * sine)
    }

    fn sum_3d(&self, p: Vec3, orientation: Vec3) -> Vec2 {
        let cell = p.floor();
        let local = p - cell;
        let mut sum = Vec2::ZERO;
        for k in -1..=1 {
            for j in -1..=1 {
                for i in -1..=1 {
                    let offset = Vec3::new(i as f32, j as f32, k as f32);
                    sum += self.cell_3d(cell + offset, local - offset, orientation);
                }
            }
        }
        sum
    }

    fn cell_3d(&self, cell: Vec3, p: Vec3, base_orientation: Vec3) -> Vec2 {
        let Vec3 { x, y, z } = cell;
        let mut sum = Vec2::ZERO;
        for [for_orientation, for_center, for_weight] in seeds() {
            let p = p - hash::color_4(cell.extend(for_center));
            let squared = p.length_squared();
            if squared >= 1.0 {
                continue;
            }
            let turns = Vec2::new(
                hash::unit_4(x, y, z, for_orientation),
                hash::unit_4(z, x, for_orientation, y),
            );
            let direction = self.direction_3d(base_orientation, turns) * self.frequency;
            let weight = sign(hash::unit_4(x, y, z, for_weight));
            sum += weight * phasor(squared, p.dot(direction));
        }
        sum
    }

    /// The base orientation, turned at random by up to π in both spherical angles: the kernel is symmetric.
    fn direction_3d(&self, base: Vec3, turns: Vec2) -> Vec3 {
        if self.isotropy == 0.0 {
            return base;
        }
        let inclination = base.z.acos() + turns.x * PI * self.isotropy;
        let side = if base.y < 0.0 { -1.0 } else { 1.0 };
        // Along Z there is no azimuth; Cycles' values are NaN there.
        let from_z = base.truncate().length();
        let cosine = if from_z > 0.0 { base.x / from_z } else { 1.0 };
        let azimuth = side * cosine.clamp(-1.0, 1.0).acos() + turns.y * PI * self.isotropy;
        let (sine, cosine) = inclination.sin_cos();
        Vec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine)
    }
}

/// The seeds of each kernel's orientation, centre and weight.
fn seeds() -> impl Iterator<Item = [f32; 3]> {
    (0..IMPULSES).map(|i| [0, 1, 2].map(|which| (3 * i + which) as f32))
}

fn sign(random: f32) -> f32 {
    if random < 0.5 { -1.0 } else { 1.0 }
}

/// The kernel as a complex number: a Gaussian with a Hann window, which takes it to zero at distance 1, times a wave.
fn phasor(distance_squared: f32, turns: f32) -> Vec2 {
    let window = 0.5 + 0.5 * (PI * distance_squared).cos();
    let envelope = (-PI * distance_squared).exp() * window;
    let (sine, cosine) = (TAU * turns).sin_cos();
    Vec2::new(envelope * cosine, envelope * sine)
}
