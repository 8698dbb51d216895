//! The inputs of the nodes that compute, by Blender's identifiers.

use super::super::node::{Legal, Socket, SocketKind};
use super::Function;

const fn socket(name: &'static str, kind: SocketKind, default: [f32; 3]) -> Socket {
    Socket {
        name,
        kind,
        default,
        legal: Legal::ANY,
    }
}

const fn float(name: &'static str, default: f32) -> Socket {
    socket(name, SocketKind::Float, [default; 3])
}

const fn vector(name: &'static str, default: [f32; 3]) -> Socket {
    socket(name, SocketKind::Vector, default)
}

const fn color(name: &'static str, default: [f32; 3]) -> Socket {
    socket(name, SocketKind::Color, default)
}

const NORMAL: Socket = socket("Normal", SocketKind::Normal, [0.0; 3]);

/// Inputs of the Bump node.
pub mod bump {
    /// "Strength".
    pub const STRENGTH: usize = 0;
    /// "Distance".
    pub const DISTANCE: usize = 1;
    /// "Filter Width", in pixels.
    pub const FILTER_WIDTH: usize = 2;
    /// "Height".
    pub const HEIGHT: usize = 3;
    /// "Normal".
    pub const NORMAL: usize = 4;
}

/// The inputs of a node.
pub(super) fn of(function: &Function) -> &'static [Socket] {
    match function {
        Function::Place(_) => &[],
        Function::Texture(texture) => texture.sockets(),
        Function::Sky(_) => const { &[vector("Vector", [0.0; 3])] },
        Function::Ies(_) => const { &[vector("Vector", [0.0; 3]), float("Strength", 1.0)] },
        Function::LightFalloff { .. } => {
            const { &[float("Strength", 100.0), float("Smooth", 0.0)] }
        }
        Function::Math { .. } => {
            const {
                &[
                    float("Value", 0.5),
                    float("Value_001", 0.5),
                    float("Value_002", 0.5),
                ]
            }
        }
        Function::IntegerMath(_) => {
            const {
                &[
                    float("Value", 0.0),
                    float("Value_001", 0.0),
                    float("Value_002", 0.0),
                ]
            }
        }
        Function::BooleanMath(_) => const { &[float("Boolean", 0.0), float("Boolean_001", 0.0)] },
        Function::VectorComponent => const { &[vector("Vector", [0.0; 3]), float("Index", 0.0)] },
        Function::VectorMath(_) => {
            const {
                &[
                    vector("Vector", [0.0; 3]),
                    vector("Vector_001", [0.0; 3]),
                    vector("Vector_002", [0.0; 3]),
                    float("Scale", 1.0),
                ]
            }
        }
        Function::MixFloat { .. } => {
            const {
                &[
                    float("Factor_Float", 0.5),
                    float("A_Float", 0.0),
                    float("B_Float", 0.0),
                ]
            }
        }
        Function::MixVector { uniform: true, .. } => {
            const {
                &[
                    float("Factor_Float", 0.5),
                    vector("A_Vector", [0.0; 3]),
                    vector("B_Vector", [0.0; 3]),
                ]
            }
        }
        Function::MixVector { .. } => {
            const {
                &[
                    vector("Factor_Vector", [0.5; 3]),
                    vector("A_Vector", [0.0; 3]),
                    vector("B_Vector", [0.0; 3]),
                ]
            }
        }
        Function::MixColor { .. } => {
            const {
                &[
                    float("Factor_Float", 0.5),
                    color("A_Color", [0.5; 3]),
                    color("B_Color", [0.5; 3]),
                ]
            }
        }
        Function::ColorRamp(_) => const { &[float("Fac", 0.5)] },
        Function::Curves(_) => const { &[float("Fac", 1.0), color("Color", [0.0; 3])] },
        Function::VectorCurves(_) => const { &[float("Fac", 1.0), vector("Vector", [0.0; 3])] },
        Function::FloatCurve(_) => const { &[float("Factor", 1.0), float("Value", 1.0)] },
        Function::MapRange { .. } => {
            const {
                &[
                    float("Value", 1.0),
                    float("From Min", 0.0),
                    float("From Max", 1.0),
                    float("To Min", 0.0),
                    float("To Max", 1.0),
                    float("Steps", 4.0),
                ]
            }
        }
        Function::MapRangeVector { .. } => {
            const {
                &[
                    vector("Vector", [0.0; 3]),
                    vector("From_Min_FLOAT3", [0.0; 3]),
                    vector("From_Max_FLOAT3", [1.0; 3]),
                    vector("To_Min_FLOAT3", [0.0; 3]),
                    vector("To_Max_FLOAT3", [1.0; 3]),
                    vector("Steps_FLOAT3", [4.0; 3]),
                ]
            }
        }
        Function::Clamp { .. } => {
            const { &[float("Value", 1.0), float("Min", 0.0), float("Max", 1.0)] }
        }
        Function::CombineColor(_) => {
            const { &[float("Red", 0.0), float("Green", 0.0), float("Blue", 0.0)] }
        }
        Function::CombineXyz => const { &[float("X", 0.0), float("Y", 0.0), float("Z", 0.0)] },
        Function::SeparateColor(_) => const { &[color("Color", [0.8; 3])] },
        Function::SeparateXyz => const { &[vector("Vector", [0.0; 3])] },
        Function::HueSaturation => {
            const {
                &[
                    float("Hue", 0.5),
                    float("Saturation", 1.0),
                    float("Value", 1.0),
                    float("Fac", 1.0),
                    color("Color", [0.8; 3]),
                ]
            }
        }
        Function::BrightContrast => {
            const {
                &[
                    color("Color", [1.0; 3]),
                    float("Bright", 0.0),
                    float("Contrast", 0.0),
                ]
            }
        }
        Function::Gamma => const { &[color("Color", [1.0; 3]), float("Gamma", 1.0)] },
        Function::Invert => const { &[float("Fac", 1.0), color("Color", [0.0; 3])] },
        Function::RgbToBw => const { &[color("Color", [0.5; 3])] },
        Function::Mapping(_) => {
            const {
                &[
                    vector("Vector", [0.0; 3]),
                    vector("Location", [0.0; 3]),
                    vector("Rotation", [0.0; 3]),
                    vector("Scale", [1.0; 3]),
                ]
            }
        }
        Function::VectorRotate { .. } => {
            const {
                &[
                    vector("Vector", [0.0; 3]),
                    vector("Center", [0.0; 3]),
                    vector("Axis", [0.0, 0.0, 1.0]),
                    float("Angle", 0.0),
                    vector("Rotation", [0.0; 3]),
                ]
            }
        }
        Function::RadialTiling { .. } | Function::RadialSegment => {
            const {
                &[
                    vector("Vector", [0.0; 3]),
                    float("Sides", 5.0),
                    float("Roundness", 0.0),
                ]
            }
        }
        Function::VectorTransform { .. } => const { &[vector("Vector", [0.5; 3])] },
        Function::Fresnel => const { &[float("IOR", 1.5), NORMAL] },
        Function::LayerFresnel | Function::LayerFacing => const { &[float("Blend", 0.5), NORMAL] },
        Function::Displacement { .. } => {
            const {
                &[
                    float("Height", 0.0),
                    float("Midlevel", 0.5),
                    float("Scale", 1.0),
                    NORMAL,
                ]
            }
        }
        Function::VectorDisplacement(_) => {
            const {
                &[
                    vector("Vector", [0.0; 3]),
                    float("Midlevel", 0.0),
                    float("Scale", 1.0),
                ]
            }
        }
        Function::AmbientOcclusion { .. } => {
            const { &[color("Color", [1.0; 3]), float("Distance", 1.0), NORMAL] }
        }
        Function::Bevel { .. } => const { &[float("Radius", 0.05), NORMAL] },
        Function::Raycast { .. } => {
            const {
                &[
                    vector("Position", [0.0; 3]),
                    vector("Direction", [0.0; 3]),
                    float("Length", 1.0),
                ]
            }
        }
        Function::Wireframe { .. } => const { &[float("Size", 0.01)] },
        Function::Bump { .. } => {
            const {
                &[
                    float("Strength", 1.0),
                    float("Distance", 1.0),
                    float("Filter Width", 0.1),
                    float("Height", 1.0),
                    NORMAL,
                ]
            }
        }
    }
}
