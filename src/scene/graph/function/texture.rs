//! Procedural textures.

use super::super::node::{Lane, Legal, Socket, SocketKind};
use super::Sockets;
use crate::nodes::{
    self, BrickInputs, BrickSettings, CheckerInputs, Dimensions, GaborInputs, GaborType,
    GradientType, LatticeInputs, LatticeSettings, MagicInputs, MagicSettings, NoiseInputs,
    NoiseSettings, VoronoiInputs, VoronoiSettings, WaveInputs, WaveSettings,
};
use crate::scene::Effect;
use glam::{Vec3, Vec4};

/// Outputs of the Voronoi Texture that are computed together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VoronoiPart {
    /// Color and Distance.
    Color,
    /// Position and W.
    Position,
    /// Radius.
    Radius,
}

/// A procedural texture, with its menus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProceduralTexture {
    /// Noise: Color, Fac.
    Noise(NoiseSettings),
    /// Noise of which the number alone is read.
    NoiseFactor(NoiseSettings),
    /// Voronoi.
    Voronoi {
        /// Its menus.
        settings: VoronoiSettings,
        /// What of it is read.
        part: VoronoiPart,
    },
    /// Wave: Color, Fac.
    Wave(WaveSettings),
    /// Magic: Color, Fac.
    Magic(MagicSettings),
    /// Brick: Color, Fac.
    Brick(BrickSettings),
    /// Checker: Color, Fac.
    Checker,
    /// Gradient: Color, Fac.
    Gradient(GradientType),
    /// White Noise: Color, Value.
    WhiteNoise(Dimensions),
    /// Gabor: Value, Phase, Intensity.
    Gabor(GaborType),
    /// MaterialX' noises that are none of Blender's: Color, Value.
    Lattice(LatticeSettings),
}

impl ProceduralTexture {
    /// The effect that it calls for.
    pub fn effect(&self) -> Effect {
        match self {
            Self::Noise(_) | Self::NoiseFactor(_) | Self::Lattice(_) => Effect::NoiseTexture,
            Self::Voronoi { .. } => Effect::VoronoiTexture,
            Self::Wave(_) => Effect::WaveTexture,
            Self::Magic(_) => Effect::MagicTexture,
            Self::Brick(_) => Effect::BrickTexture,
            Self::Checker => Effect::CheckerTexture,
            Self::Gradient(_) => Effect::GradientTexture,
            Self::WhiteNoise(_) => Effect::WhiteNoiseTexture,
            Self::Gabor(_) => Effect::GaborTexture,
        }
    }
}

const fn socket(name: &'static str, kind: SocketKind, default: f32) -> Socket {
    Socket {
        name,
        kind,
        default: [default; 3],
        legal: Legal::ANY,
    }
}

const fn float(name: &'static str, default: f32) -> Socket {
    socket(name, SocketKind::Float, default)
}

const fn color(name: &'static str, default: f32) -> Socket {
    socket(name, SocketKind::Color, default)
}

const VECTOR: Socket = socket("Vector", SocketKind::Vector, 0.0);

const NOISE: &[Socket] = &[
    VECTOR,
    float("W", 0.0),
    float("Scale", 5.0),
    float("Detail", 2.0),
    float("Roughness", 0.5),
    float("Lacunarity", 2.0),
    float("Offset", 0.0),
    float("Gain", 1.0),
    float("Distortion", 0.0),
];
const VORONOI: &[Socket] = &[
    VECTOR,
    float("W", 0.0),
    float("Scale", 5.0),
    float("Detail", 0.0),
    float("Roughness", 0.5),
    float("Lacunarity", 2.0),
    float("Smoothness", 1.0),
    float("Exponent", 0.5),
    float("Randomness", 1.0),
];
const WAVE: &[Socket] = &[
    VECTOR,
    float("Scale", 5.0),
    float("Distortion", 0.0),
    float("Detail", 2.0),
    float("Detail Scale", 1.0),
    float("Detail Roughness", 0.5),
    float("Phase Offset", 0.0),
];
const MAGIC: &[Socket] = &[VECTOR, float("Scale", 5.0), float("Distortion", 1.0)];
const BRICK: &[Socket] = &[
    VECTOR,
    color("Color1", 0.8),
    color("Color2", 0.2),
    color("Mortar", 0.0),
    float("Scale", 5.0),
    float("Mortar Size", 0.02),
    float("Mortar Smooth", 0.1),
    float("Bias", 0.0),
    float("Brick Width", 0.5),
    float("Row Height", 0.25),
];
const CHECKER: &[Socket] = &[
    VECTOR,
    color("Color1", 0.8),
    color("Color2", 0.2),
    float("Scale", 5.0),
];
const GABOR: &[Socket] = &[
    VECTOR,
    float("Scale", 5.0),
    float("Frequency", 2.0),
    float("Anisotropy", 1.0),
    float("Orientation 2D", std::f32::consts::FRAC_PI_4),
    socket(
        "Orientation 3D",
        SocketKind::Vector,
        std::f32::consts::FRAC_1_SQRT_2,
    ),
];

/// Those of [`ProceduralTexture::Lattice`].
const LATTICE: &[Socket] = &[
    VECTOR,
    float("Jitter", 1.0),
    float("Octaves", 1.0),
    float("Lacunarity", 2.0),
    float("Diminish", 0.5),
];

/// The texture Wave; apart, so that it saves no registers for others.
#[inline(never)]
fn wave<S: Sockets + ?Sized>(settings: &WaveSettings, inputs: &S) -> Vec4 {
    let n = |socket: usize| inputs.number(socket);
    Vec4::splat(nodes::wave(
        settings,
        &WaveInputs {
            vector: inputs.vector(0),
            scale: n(1),
            distortion: n(2),
            detail: n(3),
            detail_scale: n(4),
            detail_roughness: n(5),
            phase_offset: n(6),
        },
    ))
}

/// The texture Brick, apart as well.
#[inline(never)]
fn brick<S: Sockets + ?Sized>(settings: &BrickSettings, inputs: &S) -> Vec4 {
    let n = |socket: usize| inputs.number(socket);
    let v = |socket: usize| inputs.vector(socket);
    let (factor, color) = nodes::brick(
        settings,
        &BrickInputs {
            vector: v(0),
            color1: v(1),
            color2: v(2),
            mortar: v(3),
            scale: n(4),
            mortar_size: n(5),
            mortar_smooth: n(6),
            bias: n(7),
            brick_width: n(8),
            row_height: n(9),
        },
    );
    color.extend(factor)
}

/// MaterialX' noises, apart as well.
#[inline(never)]
fn lattice<S: Sockets + ?Sized>(settings: LatticeSettings, inputs: &S) -> Vec4 {
    let n = |socket: usize| inputs.number(socket);
    let inputs = LatticeInputs {
        vector: inputs.vector(0),
        jitter: n(1),
        octaves: n(2),
        lacunarity: n(3),
        diminish: n(4),
    };
    let (numbers, number) = nodes::lattice_noise(settings, &inputs);
    numbers.extend(number)
}

impl ProceduralTexture {
    /// The inputs, in their order.
    pub fn sockets(&self) -> &'static [Socket] {
        match self {
            Self::Noise(_) | Self::NoiseFactor(_) => NOISE,
            Self::Voronoi { .. } => VORONOI,
            Self::Wave(_) => WAVE,
            Self::Magic(_) => MAGIC,
            Self::Brick(_) => BRICK,
            Self::Checker => CHECKER,
            Self::Gradient(_) => const { &[VECTOR] },
            Self::WhiteNoise(_) => const { &[VECTOR, float("W", 0.0)] },
            Self::Gabor(_) => GABOR,
            Self::Lattice(_) => LATTICE,
        }
    }

    /// The outputs: what they give, and which numbers of the result they are.
    pub fn outputs(&self) -> &'static [(SocketKind, Lane)] {
        use SocketKind::{Color, Float, Vector};
        match self {
            Self::NoiseFactor(_)
            | Self::Voronoi {
                part: VoronoiPart::Radius,
                ..
            } => &[(Float, Lane::One(0))],
            Self::Voronoi {
                part: VoronoiPart::Position,
                ..
            } => &[(Vector, Lane::Xyz), (Float, Lane::One(3))],
            Self::Gabor(_) => &[
                (Float, Lane::One(0)),
                (Float, Lane::One(1)),
                (Float, Lane::One(2)),
            ],
            _ => &[(Color, Lane::Rgb), (Float, Lane::One(3))],
        }
    }

    /// The result, from what stands in the sockets.
    #[inline(never)]
    pub fn evaluate<S: Sockets + ?Sized>(&self, inputs: &S) -> Vec4 {
        let n = |socket: usize| inputs.number(socket);
        let v = |socket: usize| inputs.vector(socket);
        let noise = || NoiseInputs {
            vector: v(0),
            w: n(1),
            scale: n(2),
            detail: n(3),
            roughness: n(4),
            lacunarity: n(5),
            offset: n(6),
            gain: n(7),
            distortion: n(8),
        };
        let colored = |(factor, color): (f32, Vec3)| color.extend(factor);
        match self {
            Self::Noise(settings) => colored(nodes::noise(settings, &noise())),
            Self::NoiseFactor(settings) => Vec4::splat(nodes::noise_fac(settings, &noise())),
            Self::Voronoi { settings, part } => {
                let found = nodes::voronoi(
                    settings,
                    &VoronoiInputs {
                        vector: v(0),
                        w: n(1),
                        scale: n(2),
                        detail: n(3),
                        roughness: n(4),
                        lacunarity: n(5),
                        smoothness: n(6),
                        exponent: n(7),
                        randomness: n(8),
                    },
                );
                match part {
                    VoronoiPart::Color => found.color.extend(found.distance),
                    VoronoiPart::Position => found.position.extend(found.w),
                    VoronoiPart::Radius => Vec4::splat(found.radius),
                }
            }
            Self::Wave(settings) => wave(settings, inputs),
            Self::Magic(settings) => {
                let inputs = MagicInputs {
                    vector: v(0),
                    scale: n(1),
                    distortion: n(2),
                };
                colored(nodes::magic(*settings, &inputs))
            }
            Self::Brick(settings) => brick(settings, inputs),
            Self::Checker => colored(nodes::checker(&CheckerInputs {
                vector: v(0),
                color1: v(1),
                color2: v(2),
                scale: n(3),
            })),
            Self::Gradient(kind) => Vec4::splat(nodes::gradient(*kind, v(0))),
            Self::WhiteNoise(dimensions) => colored(nodes::white_noise(*dimensions, v(0), n(1))),
            Self::Lattice(settings) => lattice(*settings, inputs),
            Self::Gabor(kind) => {
                let found = nodes::gabor(
                    *kind,
                    &GaborInputs {
                        vector: v(0),
                        scale: n(1),
                        frequency: n(2),
                        anisotropy: n(3),
                        orientation_2d: n(4),
                        orientation_3d: v(5),
                    },
                );
                Vec4::new(found.value, found.phase, found.intensity, 1.0)
            }
        }
    }
}
