//! Nodes that compute numbers, vectors and colours: converters, textures, and what is known of the place that is shaded.

mod evaluate;
mod sockets;
mod texture;

use super::node::{Lane, Socket, SocketKind};
use crate::nodes::color::ColorModel;
use crate::nodes::curve::{Curves, Table};
use crate::nodes::ies::IesProfile;
use crate::nodes::math::Math;
use crate::nodes::mix::BlendMode;
use crate::nodes::range::RangeKind;
use crate::nodes::sky::Sky;
use crate::nodes::vector::{Mapping, RotationAxis};
use crate::nodes::vector_math::VectorMath;
use crate::nodes::whole::{BooleanMath, IntegerMath};
use crate::scene::RayKind;
pub use evaluate::Sockets;
pub use sockets::bump;
use std::sync::Arc;
pub use texture::{ProceduralTexture, VoronoiPart};

/// What is told of what a Raycast meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayPart {
    /// Whether it meets anything, whether that is its own object, and how far that is.
    Hit,
    /// Where.
    Position,
    /// Its smooth normal, on the side that the ray comes from.
    Normal,
}

/// Spaces that Vector Transform goes between, in Blender's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are Blender's")]
pub enum Space {
    World,
    Object,
    Camera,
}

/// What Vector Transform transforms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are Blender's")]
pub enum Transformed {
    Point,
    Vector,
    Normal,
}

/// What Vector Displacement's vectors are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisplacementSpace {
    /// Tangent, normal, bitangent.
    Tangent,
    /// The object's axes.
    Object,
    /// The world's axes.
    World,
}

/// What Light Path counts of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are Blender's")]
pub enum PathDepth {
    Diffuse,
    Glossy,
    Transmission,
    Transparent,
    Portal,
}

/// What is known of the place that is shaded. Vectors are in Blender's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlaceInput {
    /// Texture Coordinate: across the mesh's texture space.
    Generated,
    /// Texture Coordinate: the normal, in the object's space.
    ObjectNormal,
    /// Texture coordinates of a set, v upwards.
    Uv(u32),
    /// Texture Coordinate: in the object's space.
    Object,
    /// Texture Coordinate: in the space of another object, to which the rows go from the world.
    OfObject([[f32; 4]; 3]),
    /// Texture Coordinate and Camera Data: in the camera's space.
    Camera,
    /// Texture Coordinate: in the picture, 0 to 1.
    Window,
    /// Texture Coordinate: the mirrored direction to the viewer.
    Reflection,
    /// Geometry: in the world.
    Position,
    /// Geometry: the normal on the viewer's side.
    Normal,
    /// Geometry: the tangent about the object's Z axis.
    Tangent,
    /// Geometry: the triangle's own normal on the viewer's side.
    TrueNormal,
    /// Geometry: the direction to the viewer.
    Incoming,
    /// Geometry: on the triangle.
    Parametric,
    /// Geometry: seen from behind.
    Backfacing,
    /// Object Info: where its origin is.
    ObjectLocation,
    /// Object Info: its colour.
    ObjectColor,
    /// Object Info: its opacity in the viewport.
    ObjectAlpha,
    /// Object Info: its pass index.
    ObjectIndex,
    /// Object Info: the material's pass index.
    MaterialIndex(f32),
    /// Object Info: a number of its own.
    ObjectRandom,
    /// Camera Data: the direction in the camera's space.
    ViewVector,
    /// Camera Data: along the view.
    ViewDepth,
    /// Camera Data: from the camera.
    ViewDistance,
    /// Tangent: about an axis of the object, 0 to 2.
    RadialTangent(u8),
    /// Tangent: along texture coordinates.
    UvTangent,
    /// A value that each object has for itself, by its number.
    ObjectValue(u32),
    /// A grid of what fills the object, by its number.
    Grid {
        /// Of [`crate::scene::Grids`].
        number: u32,
        /// Between its points.
        interpolation: crate::scene::Interpolation,
        /// All its numbers where the object has no such grid.
        otherwise: f32,
    },
    /// A colour of the vertices: those of COLOR_0.
    VertexColor,
    /// An attribute of the vertices, by its number.
    Attribute(u32),
    /// Light Path: the ray is of some of these kinds, by [`crate::scene::Visibility`]'s bits.
    IsRay(u32),
    /// Light Path: how many surfaces the path has met before.
    RayDepth,
    /// Light Path: how many of them scattered it in some way.
    PathDepth(PathDepth),
    /// Light Path: the last of them was a mirror or clear glass.
    IsSingularRay,
    /// Light Path: the last of them did not let it through.
    IsReflectionRay,
    /// Light Path: how long the ray is.
    RayLength,
    /// Hair Info: it is a strand.
    IsStrand,
    /// Hair Info: how thick the strand is.
    StrandThickness,
    /// Hair Info: towards the viewer, across the strand.
    StrandNormal,
    /// Point Info: the middle of the point, in the world.
    PointPosition,
    /// Point Info: its radius.
    PointRadius,
    /// Principled Hair BSDF: 1 where its fibre has an elliptic section of this aspect ratio and the ray meets that, 0 where it passes
    /// beside; 1 on meshes.
    FibreCover(f32),
}

impl PlaceInput {
    /// Whether the answer may be another for a light sample than for a ray that finds the same place: what only the camera's rays
    /// are told makes no difference to light, and both kinds are as long.
    pub fn tells_rays_apart(&self) -> bool {
        match *self {
            Self::IsRay(kinds) => kinds & !RayKind::Camera.bit() != 0,
            Self::RayDepth | Self::PathDepth(_) => true,
            Self::IsSingularRay | Self::IsReflectionRay | Self::FibreCover(_) => true,
            _ => false,
        }
    }

    /// Whether the answer depends on the camera.
    pub fn is_of_view(&self) -> bool {
        matches!(
            self,
            Self::Camera | Self::Window | Self::ViewVector | Self::ViewDepth | Self::ViewDistance
        )
    }
}

/// What a node computes.
#[derive(Clone, Debug, PartialEq)]
pub enum Function {
    /// Something of the place.
    Place(PlaceInput),
    /// A procedural texture.
    Texture(ProceduralTexture),
    /// Sky Texture.
    Sky(Arc<Sky>),
    /// IES Texture.
    Ies(Arc<IesProfile>),
    /// Light Falloff: with the square of the distance, multiplied with so many powers of it.
    LightFalloff {
        /// 0 for Quadratic, 1 for Linear, 2 for Constant.
        power: i32,
    },
    /// Math.
    Math {
        /// Which.
        operation: Math,
        /// Brought to 0..=1.
        clamp: bool,
    },
    /// Vector Math.
    VectorMath(VectorMath),
    /// Mix of numbers.
    MixFloat {
        /// The factor is brought to 0..=1.
        clamp: bool,
    },
    /// Mix of vectors, with a factor for each number or one for all.
    MixVector {
        /// The factor is brought to 0..=1.
        clamp: bool,
        /// One for all.
        uniform: bool,
    },
    /// Mix of colours.
    MixColor {
        /// How.
        blend: BlendMode,
        /// The factor is brought to 0..=1.
        clamp: bool,
        /// The result is.
        clamp_result: bool,
    },
    /// Color Ramp.
    ColorRamp(Arc<Table>),
    /// RGB Curves.
    Curves(Arc<Curves>),
    /// Vector Curves.
    VectorCurves(Arc<Curves>),
    /// Float Curve.
    FloatCurve(Arc<Curves>),
    /// Map Range of a number.
    MapRange {
        /// Which way.
        kind: RangeKind,
        /// It ends at the ends.
        clamp: bool,
    },
    /// Map Range of a vector.
    MapRangeVector {
        /// Which way.
        kind: RangeKind,
        /// It ends at the ends.
        clamp: bool,
    },
    /// Clamp.
    Clamp {
        /// The ends may be in any order.
        sorted: bool,
    },
    /// Integer Math. Numbers beyond 2^24 are rounded to those that stand in 32 bits with a point.
    IntegerMath(IntegerMath),
    /// Boolean Math.
    BooleanMath(BooleanMath),
    /// Get Vector Component.
    VectorComponent,
    /// Combine Color.
    CombineColor(ColorModel),
    /// Combine XYZ.
    CombineXyz,
    /// Separate Color.
    SeparateColor(ColorModel),
    /// Separate XYZ.
    SeparateXyz,
    /// Hue/Saturation/Value.
    HueSaturation,
    /// Brightness/Contrast.
    BrightContrast,
    /// Gamma.
    Gamma,
    /// Invert Color.
    Invert,
    /// RGB to BW.
    RgbToBw,
    /// Mapping.
    Mapping(Mapping),
    /// Vector Rotate.
    VectorRotate {
        /// About what.
        axis: RotationAxis,
        /// The other way.
        invert: bool,
    },
    /// Radial Tiling's coordinates.
    RadialTiling {
        /// The way to the side goes from 0 to 1.
        normalize: bool,
    },
    /// What Radial Tiling tells of segments: number, width and rotation.
    RadialSegment,
    /// Vector Transform.
    VectorTransform {
        /// What.
        what: Transformed,
        /// From where.
        from: Space,
        /// To where.
        to: Space,
    },
    /// Fresnel.
    Fresnel,
    /// Layer Weight's "Fresnel".
    LayerFresnel,
    /// Layer Weight's "Facing".
    LayerFacing,
    /// Bump.
    Bump {
        /// Hollows instead of hills.
        invert: bool,
        /// Slopes are the object's.
        object_space: bool,
        /// The attribute with the places of vertices before they were displaced: the height is that of these.
        undisplaced: Option<u32>,
        /// As in Cycles from 5.0 on: flat faces have the normals of these places, too (what the displacement turned them by, the bump does),
        /// and places beside the point lie in the displaced triangle.
        is_of_5: bool,
        /// Its steps grow with the roughness of what has scattered the path, as in Cycles from 5.2 on.
        widened: bool,
    },
    /// Displacement.
    Displacement {
        /// Heights are the object's.
        object_space: bool,
    },
    /// Vector Displacement.
    VectorDisplacement(DisplacementSpace),
    /// Ambient Occlusion.
    AmbientOcclusion {
        /// Rays for each evaluation.
        samples: u8,
        /// They go inwards.
        inside: bool,
        /// They see the object alone.
        only_local: bool,
    },
    /// Bevel.
    Bevel {
        /// Rays for each evaluation.
        samples: u8,
    },
    /// Raycast.
    Raycast {
        /// The ray sees the object alone.
        only_local: bool,
        /// What is told of it.
        part: RayPart,
    },
    /// Wireframe.
    Wireframe {
        /// Lines are so many pixels wide.
        pixels: bool,
    },
}

impl Function {
    /// The inputs, in their order.
    pub fn sockets(&self) -> &'static [Socket] {
        sockets::of(self)
    }

    /// The outputs: what they give, and which numbers of the result they are.
    pub fn outputs(&self) -> &'static [(SocketKind, Lane)] {
        use SocketKind::{Color, Float, Normal, Vector};
        match self {
            Self::Texture(texture) => texture.outputs(),
            Self::Place(input) => match input {
                PlaceInput::Backfacing
                | PlaceInput::ObjectAlpha
                | PlaceInput::ObjectIndex
                | PlaceInput::MaterialIndex(_)
                | PlaceInput::ObjectRandom
                | PlaceInput::ViewDepth
                | PlaceInput::ViewDistance
                | PlaceInput::IsRay(_)
                | PlaceInput::IsSingularRay
                | PlaceInput::IsReflectionRay
                | PlaceInput::PathDepth(_)
                | PlaceInput::RayDepth
                | PlaceInput::RayLength
                | PlaceInput::IsStrand
                | PlaceInput::StrandThickness
                | PlaceInput::PointRadius
                | PlaceInput::FibreCover(_) => &[(Float, Lane::One(0))],
                PlaceInput::ObjectColor
                | PlaceInput::ObjectValue(_)
                | PlaceInput::Grid { .. }
                | PlaceInput::VertexColor
                | PlaceInput::Attribute(_) => &[
                    (Color, Lane::Rgb),
                    (Float, Lane::One(3)),
                    (Vector, Lane::Xyz),
                    (Float, Lane::Mean),
                ],
                _ => &[(Vector, Lane::Xyz)],
            },
            Self::Math { .. }
            | Self::IntegerMath(_)
            | Self::BooleanMath(_)
            | Self::VectorComponent
            | Self::MixFloat { .. }
            | Self::FloatCurve(_)
            | Self::MapRange { .. }
            | Self::Clamp { .. }
            | Self::RgbToBw
            | Self::Ies(_)
            | Self::LightFalloff { .. }
            | Self::Fresnel
            | Self::LayerFresnel
            | Self::LayerFacing
            | Self::Wireframe { .. } => &[(Float, Lane::One(0))],
            Self::VectorMath(_) => &[(Vector, Lane::Xyz), (Float, Lane::One(3))],
            Self::MixVector { .. }
            | Self::VectorCurves(_)
            | Self::MapRangeVector { .. }
            | Self::CombineXyz
            | Self::Mapping(_)
            | Self::VectorRotate { .. }
            | Self::RadialTiling { .. }
            | Self::VectorTransform { .. }
            | Self::Displacement { .. }
            | Self::VectorDisplacement(_)
            | Self::Bevel { .. }
            | Self::Raycast {
                part: RayPart::Position | RayPart::Normal,
                ..
            } => &[(Vector, Lane::Xyz)],
            Self::MixColor { .. }
            | Self::Curves(_)
            | Self::CombineColor(_)
            | Self::HueSaturation
            | Self::BrightContrast
            | Self::Gamma
            | Self::Sky(_)
            | Self::Invert => &[(Color, Lane::Rgb)],
            Self::ColorRamp(_) | Self::AmbientOcclusion { .. } => {
                &[(Color, Lane::Rgb), (Float, Lane::One(3))]
            }
            Self::SeparateColor(_)
            | Self::SeparateXyz
            | Self::RadialSegment
            | Self::Raycast {
                part: RayPart::Hit, ..
            } => &[
                (Float, Lane::One(0)),
                (Float, Lane::One(1)),
                (Float, Lane::One(2)),
            ],
            Self::Bump { .. } => &[(Normal, Lane::Xyz)],
        }
    }
}

#[cfg(test)]
#[path = "../../../../tests/unit/scene/graph/function/mod.rs"]
mod tests;
