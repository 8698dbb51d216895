//! Blender's Wave Texture.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::Vec3;
use pulp::NullaryFnOnce;

use super::fractal::Octaves;
use super::perlin::Point;
use super::{off_edges, on_vectors};

choice! {
    /// The shape of the waves.
    WaveType {
        /// Straight bands.
        Bands = "BANDS",
        /// Rings.
        Rings = "RINGS",
    }
}

choice! {
    /// Along which axis bands follow each other.
    WaveBandsDirection {
        /// X.
        X = "X",
        /// Y.
        Y = "Y",
        /// Z.
        Z = "Z",
        /// All three alike.
        Diagonal = "DIAGONAL",
    }
}

choice! {
    /// Around which axis rings lie.
    WaveRingsDirection {
        /// X.
        X = "X",
        /// Y.
        Y = "Y",
        /// Z.
        Z = "Z",
        /// Spheres around the origin.
        Spherical = "SPHERICAL",
    }
}

choice! {
    /// The wave's form over one period.
    WaveProfile {
        /// A sine.
        Sin = "SIN",
        /// A saw tooth.
        Saw = "SAW",
        /// A triangle.
        Tri = "TRI",
    }
}

/// The node's menus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveSettings {
    /// Bands or rings.
    pub wave_type: WaveType,
    /// The direction of bands.
    pub bands_direction: WaveBandsDirection,
    /// The direction of rings.
    pub rings_direction: WaveRingsDirection,
    /// The profile.
    pub profile: WaveProfile,
}

/// The node's sockets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveInputs {
    /// Vector.
    pub vector: Vec3,
    /// Scale.
    pub scale: f32,
    /// Distortion, in radians.
    pub distortion: f32,
    /// Detail of the noise that distorts.
    pub detail: f32,
    /// Its scale.
    pub detail_scale: f32,
    /// Its roughness.
    pub detail_roughness: f32,
    /// Phase Offset.
    pub phase_offset: f32,
}

impl Default for WaveInputs {
    fn default() -> Self {
        Self {
            vector: Vec3::ZERO,
            scale: 5.0,
            distortion: 0.0,
            detail: 2.0,
            detail_scale: 1.0,
            detail_roughness: 0.5,
            phase_offset: 0.0,
        }
    }
}

/// The node's factor; its colour is that grey.
#[inline]
pub fn wave(settings: &WaveSettings, inputs: &WaveInputs) -> f32 {
    let p = off_edges(inputs.vector * inputs.scale);
    let mut phase = match settings.wave_type {
        WaveType::Bands => match settings.bands_direction {
            WaveBandsDirection::X => p.x * 20.0,
            WaveBandsDirection::Y => p.y * 20.0,
            WaveBandsDirection::Z => p.z * 20.0,
            WaveBandsDirection::Diagonal => (p.x + p.y + p.z) * 10.0,
        },
        WaveType::Rings => {
            let from_axis = match settings.rings_direction {
                WaveRingsDirection::X => p * Vec3::new(0.0, 1.0, 1.0),
                WaveRingsDirection::Y => p * Vec3::new(1.0, 0.0, 1.0),
                WaveRingsDirection::Z => p * Vec3::new(1.0, 1.0, 0.0),
                WaveRingsDirection::Spherical => p,
            };
            from_axis.length() * 20.0
        }
    };
    phase += inputs.phase_offset;
    if inputs.distortion != 0.0 {
        let octaves = Octaves {
            detail: inputs.detail,
            roughness: inputs.detail_roughness,
            lacunarity: 2.0,
        };
        let at = (p * inputs.detail_scale).to_array();
        let at = Point::<3>::from_axes(|axis| at[axis]);
        phase += inputs.distortion * (on_vectors(Fbm(octaves, at)) * 2.0 - 1.0);
    }
    match settings.profile {
        WaveProfile::Sin => 0.5 + 0.5 * (phase - FRAC_PI_2).sin(),
        WaveProfile::Saw => {
            let turns = phase * PER_TURN;
            turns - turns.floor()
        }
        WaveProfile::Tri => {
            let turns = phase * PER_TURN;
            (turns - (turns + 0.5).floor()).abs() * 2.0
        }
    }
}

/// The noise that distorts.
struct Fbm(Octaves, Point<3>);

impl NullaryFnOnce for Fbm {
    type Output = f32;

    #[inline(always)]
    fn call(self) -> f32 {
        self.0.fbm(self.1, true)
    }
}

/// Turns of a radian: Cycles' compiler, too, multiplies by the reciprocal.
const PER_TURN: f32 = 1.0 / TAU;
