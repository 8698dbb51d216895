//! What nodes are called: Blender's names.

use super::function::PlaceInput;
use super::{Function, Graph, NodeKind, ProceduralTexture};
use std::collections::BTreeMap;

impl NodeKind {
    /// The name in Blender; none for shaders, which are lobes, and for what importers put between nodes.
    pub fn label(&self) -> Option<&'static str> {
        Some(match self {
            Self::ImageTexture { .. } => "Image Texture",
            Self::Function(function) => function.label(),
            Self::ColorAttribute => "Color Attribute",
            Self::SeparateColor => "Separate Color",
            Self::Math { .. } => "Math",
            Self::MixColor { .. } => "Mix",
            Self::NormalMap { .. } => "Normal Map",
            Self::Tangent { .. } => "Tangent",
            _ => return None,
        })
    }
}

impl Function {
    /// The name in Blender.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Place(place) => place.label(),
            Self::Texture(texture) => texture.label(),
            Self::Sky(_) => "Sky Texture",
            Self::Ies(_) => "IES Texture",
            Self::LightFalloff { .. } => "Light Falloff",
            Self::Math { .. } => "Math",
            Self::VectorMath(_) => "Vector Math",
            Self::IntegerMath(_) => "Integer Math",
            Self::BooleanMath(_) => "Boolean Math",
            Self::VectorComponent => "Get Vector Component",
            Self::MixFloat { .. } | Self::MixVector { .. } | Self::MixColor { .. } => "Mix",
            Self::ColorRamp(_) => "Color Ramp",
            Self::Curves(_) | Self::VectorCurves(_) => "Curves",
            Self::FloatCurve(_) => "Float Curve",
            Self::MapRange { .. } | Self::MapRangeVector { .. } => "Map Range",
            Self::Clamp { .. } => "Clamp",
            Self::CombineColor(_) => "Combine Color",
            Self::CombineXyz => "Combine XYZ",
            Self::SeparateColor(_) => "Separate Color",
            Self::SeparateXyz => "Separate XYZ",
            Self::HueSaturation => "Hue/Saturation/Value",
            Self::BrightContrast => "Brightness/Contrast",
            Self::Gamma => "Gamma",
            Self::Invert => "Invert Color",
            Self::RgbToBw => "RGB to BW",
            Self::Mapping(_) => "Mapping",
            Self::VectorRotate { .. } => "Vector Rotate",
            Self::RadialTiling { .. } | Self::RadialSegment => "Radial Tiling",
            Self::VectorTransform { .. } => "Vector Transform",
            Self::Fresnel => "Fresnel",
            Self::LayerFresnel | Self::LayerFacing => "Layer Weight",
            Self::Bump { .. } => "Bump",
            Self::Displacement { .. } => "Displacement",
            Self::VectorDisplacement(_) => "Vector Displacement",
            Self::AmbientOcclusion { .. } => "Ambient Occlusion",
            Self::Bevel { .. } => "Bevel",
            Self::Raycast { .. } => "Raycast",
            Self::Wireframe { .. } => "Wireframe",
        }
    }
}

impl PlaceInput {
    /// The name of Blender's node that has this output.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Generated
            | Self::ObjectNormal
            | Self::Uv(_)
            | Self::Object
            | Self::OfObject(_)
            | Self::Camera
            | Self::Window
            | Self::Reflection => "Texture Coordinate",
            Self::Position
            | Self::Normal
            | Self::Tangent
            | Self::TrueNormal
            | Self::Incoming
            | Self::Parametric
            | Self::Backfacing => "Geometry",
            Self::ObjectLocation
            | Self::ObjectColor
            | Self::ObjectAlpha
            | Self::ObjectIndex
            | Self::MaterialIndex(_)
            | Self::ObjectRandom => "Object Info",
            Self::ViewVector | Self::ViewDepth | Self::ViewDistance => "Camera Data",
            Self::VertexColor | Self::Attribute(_) | Self::ObjectValue(_) | Self::Grid { .. } => {
                "Attribute"
            }
            Self::RadialTangent(_) | Self::UvTangent => "Tangent",
            Self::IsRay(_)
            | Self::IsSingularRay
            | Self::IsReflectionRay
            | Self::PathDepth(_)
            | Self::RayDepth
            | Self::RayLength => "Light Path",
            Self::IsStrand | Self::StrandThickness | Self::StrandNormal => "Hair Info",
            Self::PointPosition | Self::PointRadius => "Point Info",
            Self::FibreCover(_) => "Principled Hair BSDF",
        }
    }
}

impl ProceduralTexture {
    /// The name in Blender.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Noise(_) | Self::NoiseFactor(_) => "Noise Texture",
            Self::Voronoi { .. } => "Voronoi Texture",
            Self::Wave(_) => "Wave Texture",
            Self::Magic(_) => "Magic Texture",
            Self::Brick(_) => "Brick Texture",
            Self::Checker => "Checker Texture",
            Self::Gradient(_) => "Gradient Texture",
            Self::WhiteNoise(_) => "White Noise Texture",
            Self::Gabor(_) => "Gabor Texture",
            Self::Lattice(_) => "MaterialX noise",
        }
    }
}

impl Graph {
    /// How many nodes of each name there are, shaders left aside.
    pub fn nodes_by_label(&self) -> BTreeMap<&'static str, usize> {
        let mut counts = BTreeMap::new();
        for label in self.nodes.iter().filter_map(|node| node.kind.label()) {
            *counts.entry(label).or_default() += 1;
        }
        counts
    }
}
