//! What Blender's nodes compute: pure functions of their sockets, which know neither graphs nor surfaces.
//! Vectors are in Blender's axes; colours are linear in the scene's space.
//!
//! Each file is one node, or what several of them share: its settings are enums by Blender's own identifiers, its inputs
//! are the node's sockets by name, with Blender's defaults. The values are those of Cycles 5.2 within rounding: hashes,
//! lattices and the order of operations are part of what these nodes mean. Where versions of Cycles differ, a setting says
//! which is meant ([`CyclesVersion`]). `tests/unit/nodes/mod.rs` holds
//! them beside Cycles' values.
//!
//! Sources: Cycles' `kernel/svm` for the numbers; the papers are named where a node follows one.

/// A choice of a node's menu, named by Blender's identifiers.
macro_rules! choice {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $variant:ident = $identifier:literal,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name {
            $($(#[$doc])* $variant,)+
        }

        impl $name {
            /// Every choice, in the menu's order.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// The choice with this identifier of Blender's.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|choice| choice.name() == name)
            }

            /// Blender's identifier.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $identifier,)+
                }
            }
        }
    };
}

pub mod brick;
pub mod checker;
pub mod color;
pub mod curve;
mod fractal;
pub mod gabor;
pub mod gradient;
mod hash;
pub mod ies;
mod lanes;
pub mod magic;
pub mod materialx;
pub mod math;
pub mod mix;
pub mod noise;
mod perlin;
pub mod radial_tiling;
pub mod range;
pub mod sky;
pub mod vector;
pub mod vector_math;
mod version;
pub mod voronoi;
pub mod wave;
pub mod white_noise;
pub mod whole;

#[cfg(test)]
#[path = "../../tests/unit/nodes/mod.rs"]
mod tests;

pub use brick::{BrickInputs, BrickSettings, brick};
pub use checker::{CheckerInputs, checker};
pub use gabor::{GaborInputs, GaborOutputs, GaborType, gabor};
pub use gradient::{GradientType, gradient};
pub use magic::{MagicInputs, MagicSettings, magic};
pub use materialx::{LatticeInputs, LatticeNoise, LatticeSettings, lattice_noise};
pub use noise::{NoiseInputs, NoiseSettings, NoiseType, noise, noise_fac};
pub use version::CyclesVersion;
pub use voronoi::{
    VoronoiFeature, VoronoiHash, VoronoiInputs, VoronoiMetric, VoronoiOutputs, VoronoiSettings,
    voronoi,
};
pub use wave::{
    WaveBandsDirection, WaveInputs, WaveProfile, WaveRingsDirection, WaveSettings, WaveType, wave,
};
pub use white_noise::{white_noise, white_noise_value};

/// How many coordinates a texture takes, as the menu of the node says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimensions {
    /// W alone.
    One,
    /// X and Y of the vector.
    Two,
    /// The vector.
    Three,
    /// The vector and W.
    Four,
}

impl Dimensions {
    /// The choice with this identifier of Blender's.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "1D" => Some(Self::One),
            "2D" => Some(Self::Two),
            "3D" => Some(Self::Three),
            "4D" => Some(Self::Four),
            _ => None,
        }
    }
}

/// Computes with the widest vectors of the processor at hand: AVX2's where it has them. What is inlined is compiled for
/// each; no result depends on the choice, as nothing is fused that is not written so.
#[inline]
fn on_vectors<T: pulp::NullaryFnOnce>(work: T) -> T::Output {
    pulp::Arch::new().dispatch(work)
}

/// Interpolation in the order of operations that Cycles has, which is not exact at t = 1.
#[inline]
fn mix<T>(a: T, b: T, t: f32) -> T
where
    T: Copy
        + std::ops::Add<Output = T>
        + std::ops::Sub<Output = T>
        + std::ops::Mul<f32, Output = T>,
{
    a + (b - a) * t
}

/// a·b + c rounded once, as in Cycles' kernels for processors with AVX2: so that patterns agree to the last bit where they
/// move each other. One instruction within [`on_vectors`]; the same bits by a function where the processor has none.
#[inline(always)]
fn fused(a: f32, b: f32, c: f32) -> f32 {
    a.mul_add(b, c)
}

/// The cubic step from 0 at 0 to 1 at 1.
#[inline]
fn smoothstep(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// A whole number as x86's conversion makes it: what does not fit, and NaN, is the smallest one.
#[inline]
fn whole(x: f32) -> i32 {
    const LIMIT: f32 = 2_147_483_648.0;
    if (-LIMIT..LIMIT).contains(&x) {
        x as i32
    } else {
        i32::MIN
    }
}

/// Coordinates at whole numbers fall on one side for sure: by rounding they would fall on either.
#[inline]
fn off_edges(p: glam::Vec3) -> glam::Vec3 {
    (p + 0.000_001) * 0.999_999
}
