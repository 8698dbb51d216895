//! Nodes that compute, by Blender's names and properties.

use super::{NodeJson, Refusal, SocketJson, texture};
use crate::nodes::CyclesVersion;
use crate::nodes::color::ColorModel;
use crate::nodes::curve::{Curves, Table};
use crate::nodes::math::Math;
use crate::nodes::mix::BlendMode;
use crate::nodes::range::RangeKind;
use crate::nodes::vector::{Mapping, RotationAxis};
use crate::nodes::vector_math::VectorMath;
use crate::nodes::whole::{BooleanMath, IntegerMath};
use crate::scene::RayKind;
use crate::scene::graph::Function;
use crate::scene::graph::function::{
    DisplacementSpace, PathDepth, PlaceInput, RayPart, Space, Transformed,
};
use glam::Vec4;
use serde_json::Value;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A node's function, which output of it is meant, and what its sockets are called in the tree, where they have other names.
pub(super) struct Found {
    pub function: Function,
    pub output: u8,
    pub aliases: &'static [(&'static str, &'static str)],
}

const MIX_RGB: &[(&str, &str)] = &[
    ("Factor_Float", "Fac"),
    ("A_Color", "Color1"),
    ("B_Color", "Color2"),
];
/// Nodes of Blender before 5.0 that Combine Color and Separate Color took the place of.
const COMBINE_RGB: &[(&str, &str)] = &[("Red", "R"), ("Green", "G"), ("Blue", "B")];
const COMBINE_HSV: &[(&str, &str)] = &[("Red", "H"), ("Green", "S"), ("Blue", "V")];
const SEPARATE_RGB: &[(&str, &str)] = &[("Color", "Image")];

impl NodeJson {
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.properties.get(name)?.as_str()
    }

    pub(super) fn is(&self, name: &str) -> bool {
        self.properties.get(name).and_then(Value::as_bool) == Some(true)
    }

    pub(super) fn number(&self, name: &str) -> Option<f32> {
        Some(self.properties.get(name)?.as_f64()? as f32)
    }

    /// A property that names one of some, or a refusal that says its name.
    pub(super) fn named<T>(
        &self,
        name: &str,
        from: impl Fn(&str) -> Option<T>,
    ) -> Result<T, Refusal> {
        let text = self.text(name).unwrap_or_default();
        from(text).ok_or_else(|| Refusal::of(self, &format!("{name} {text}")))
    }
}

/// A table of rows of up to four numbers.
fn table(value: Option<&Value>, interpolate: bool, extrapolate: bool) -> Option<Table> {
    let rows = value?.get("table")?.as_array()?;
    let row = |row: &Value| {
        let numbers = row.as_array()?;
        let at = |i: usize| Some(numbers.get(i)?.as_f64()? as f32);
        let first = at(0)?;
        Some(Vec4::new(
            first,
            at(1).unwrap_or(first),
            at(2).unwrap_or(first),
            at(3).unwrap_or(1.0),
        ))
    };
    let entries: Option<Vec<Vec4>> = rows.iter().map(row).collect();
    Some(Table {
        entries: entries.filter(|entries| !entries.is_empty())?,
        interpolate,
        extrapolate,
    })
}

fn curves(node: &NodeJson) -> Result<Arc<Curves>, Refusal> {
    let value = node.properties.get("curves");
    let text = |name: &str| value?.get(name)?.as_str();
    let end = |name: &str| Some(value?.get(name)?.as_f64()? as f32);
    let table = table(value, true, text("extend") == Some("EXTRAPOLATED"));
    let table = table.ok_or_else(|| Refusal::of(node, "without a table"))?;
    Ok(Arc::new(Curves {
        table,
        least: end("min_x").unwrap_or(0.0),
        most: end("max_x").unwrap_or(1.0),
    }))
}

/// Whether bumps are filtered by what has scattered a path.
pub(super) fn widens(version: CyclesVersion) -> bool {
    version >= CyclesVersion::new(5, 2)
}

/// A Float Curve's table. Cycles from 5.0 on shows its ends beyond them where all that it takes is constant.
fn float_curve(node: &NodeJson, version: CyclesVersion) -> Result<Arc<Curves>, Refusal> {
    let mut curves = curves(node)?;
    let is_linked = |name: &str| matches!(node.inputs.get(name), Some(SocketJson::Link(_)));
    if version >= CyclesVersion::new(5, 0) && !["Factor", "Fac", "Value"].into_iter().any(is_linked)
    {
        Arc::make_mut(&mut curves).table.extrapolate = false;
    }
    Ok(curves)
}

fn space(node: &NodeJson, name: &str) -> Result<Space, Refusal> {
    node.named(name, |text| {
        Some(match text {
            "WORLD" => Space::World,
            "OBJECT" => Space::Object,
            "CAMERA" => Space::Camera,
            _ => return None,
        })
    })
}

/// A plain output of a node with one.
fn only(function: Function) -> Found {
    Found {
        function,
        output: 0,
        aliases: &[],
    }
}

fn place(input: PlaceInput) -> Found {
    only(Function::Place(input))
}

/// What a node computes for one of its outputs.
pub(super) fn of(
    node: &NodeJson,
    (output, used): (&str, &BTreeSet<String>),
    material_index: f32,
    version: CyclesVersion,
) -> Result<Found, Refusal> {
    let kind = node.kind.strip_prefix("ShaderNode").unwrap_or(&node.kind);
    if let Some(found) = texture::of(node, kind, output, used, version)? {
        return Ok(found);
    }
    let one_of = |names: &[&str]| {
        let place = names.iter().position(|name| *name == output);
        place.unwrap_or(0) as u8
    };
    Ok(match kind {
        "Math" => only(Function::Math {
            operation: node.named("operation", Math::from_name)?,
            clamp: node.is("use_clamp"),
        }),
        "VectorMath" => Found {
            output: one_of(&["Vector", "Value"]),
            ..only(Function::VectorMath(
                node.named("operation", VectorMath::from_name)?
                    .of_version(version),
            ))
        },
        "FunctionNodeIntegerMath" => only(Function::IntegerMath(
            node.named("operation", IntegerMath::from_name)?,
        )),
        "FunctionNodeBooleanMath" => only(Function::BooleanMath(
            node.named("operation", BooleanMath::from_name)?,
        )),
        "FunctionNodeGetVectorComponent" => only(Function::VectorComponent),
        "Mix" => mix(node)?,
        "MixRGB" => Found {
            aliases: MIX_RGB,
            ..only(Function::MixColor {
                blend: blend(node, "Fac", true)?,
                clamp: true,
                clamp_result: node.is("use_clamp"),
            })
        },
        "ValToRGB" => {
            let ramp = node.properties.get("color_ramp");
            let steps = ramp.and_then(|r| r.get("interpolation")?.as_str()) == Some("CONSTANT");
            let table = table(ramp, !steps, false);
            let table = table.ok_or_else(|| Refusal::of(node, "without a table"))?;
            Found {
                output: one_of(&["Color", "Alpha"]),
                ..only(Function::ColorRamp(Arc::new(table)))
            }
        }
        "RGBCurve" => only(Function::Curves(curves(node)?)),
        "VectorCurve" => only(Function::VectorCurves(curves(node)?)),
        "FloatCurve" => only(Function::FloatCurve(float_curve(node, version)?)),
        "MapRange" => {
            let kind = node.named("interpolation_type", RangeKind::from_name)?;
            let clamp = node.is("clamp");
            only(if node.text("data_type") == Some("FLOAT_VECTOR") {
                Function::MapRangeVector { kind, clamp }
            } else {
                Function::MapRange { kind, clamp }
            })
        }
        "Clamp" => only(Function::Clamp {
            sorted: node.text("clamp_type") == Some("RANGE"),
        }),
        "CombineColor" => only(Function::CombineColor(
            node.named("mode", ColorModel::from_name)?,
        )),
        "SeparateColor" => Found {
            output: one_of(&["Red", "Green", "Blue"]),
            ..only(Function::SeparateColor(
                node.named("mode", ColorModel::from_name)?,
            ))
        },
        "CombineRGB" => Found {
            aliases: COMBINE_RGB,
            ..only(Function::CombineColor(ColorModel::Rgb))
        },
        "CombineHSV" => Found {
            aliases: COMBINE_HSV,
            ..only(Function::CombineColor(ColorModel::Hsv))
        },
        "SeparateRGB" => Found {
            output: one_of(&["R", "G", "B"]),
            aliases: SEPARATE_RGB,
            ..only(Function::SeparateColor(ColorModel::Rgb))
        },
        "SeparateHSV" => Found {
            output: one_of(&["H", "S", "V"]),
            ..only(Function::SeparateColor(ColorModel::Hsv))
        },
        "CombineXYZ" => only(Function::CombineXyz),
        "SeparateXYZ" => Found {
            output: one_of(&["X", "Y", "Z"]),
            ..only(Function::SeparateXyz)
        },
        "HueSaturation" => only(Function::HueSaturation),
        "BrightContrast" => only(Function::BrightContrast),
        "Gamma" => only(Function::Gamma),
        "Invert" => only(Function::Invert),
        "RGBToBW" => only(Function::RgbToBw),
        "Mapping" => only(Function::Mapping(
            node.named("vector_type", Mapping::from_name)?,
        )),
        "VectorRotate" => only(Function::VectorRotate {
            axis: node.named("rotation_type", RotationAxis::from_name)?,
            invert: node.is("invert"),
        }),
        "RadialTiling" if output == "Segment Coordinates" => only(Function::RadialTiling {
            normalize: node.is("normalize"),
        }),
        "RadialTiling" => Found {
            output: one_of(&["Segment ID", "Segment Width", "Segment Rotation"]),
            ..only(Function::RadialSegment)
        },
        "VectorTransform" => only(Function::VectorTransform {
            what: node.named("vector_type", |text| {
                Some(match text {
                    "POINT" => Transformed::Point,
                    "VECTOR" => Transformed::Vector,
                    "NORMAL" => Transformed::Normal,
                    _ => return None,
                })
            })?,
            from: space(node, "convert_from")?,
            to: space(node, "convert_to")?,
        }),
        "Fresnel" => only(Function::Fresnel),
        "LayerWeight" if output == "Facing" => only(Function::LayerFacing),
        "LayerWeight" => only(Function::LayerFresnel),
        "Bump" => only(Function::Bump {
            invert: node.is("invert"),
            object_space: false,
            undisplaced: None,
            is_of_5: false,
            widened: widens(version),
        }),
        "Displacement" => only(Function::Displacement {
            object_space: node.text("space") != Some("WORLD"),
        }),
        "VectorDisplacement" => only(Function::VectorDisplacement(node.named(
            "space",
            |space| {
                Some(match space {
                    "TANGENT" => DisplacementSpace::Tangent,
                    "OBJECT" => DisplacementSpace::Object,
                    "WORLD" => DisplacementSpace::World,
                    _ => return None,
                })
            },
        )?)),
        "AmbientOcclusion" => Found {
            output: one_of(&["Color", "AO"]),
            ..only(Function::AmbientOcclusion {
                samples: node.number("samples").unwrap_or(16.0) as u8,
                inside: node.is("inside"),
                only_local: node.is("only_local"),
            })
        },
        "Bevel" => only(Function::Bevel {
            samples: node.number("samples").unwrap_or(4.0) as u8,
        }),
        "Raycast" => {
            let (part, output) = match output {
                "Hit Position" => (RayPart::Position, 0),
                "Hit Normal" => (RayPart::Normal, 0),
                _ => (
                    RayPart::Hit,
                    one_of(&["Is Hit", "Self Hit", "Hit Distance"]),
                ),
            };
            let only_local = node.is("only_local");
            Found {
                output,
                ..only(Function::Raycast { only_local, part })
            }
        }
        "Wireframe" => only(Function::Wireframe {
            pixels: node.is("use_pixel_size"),
        }),
        "Tangent" if node.text("direction_type") == Some("UV_MAP") => place(PlaceInput::UvTangent),
        "Tangent" => place(PlaceInput::RadialTangent(node.named("axis", |axis| {
            ["X", "Y", "Z"]
                .iter()
                .position(|a| *a == axis)
                .map(|a| a as u8)
        })?)),
        _ => place(input(node, kind, output, material_index)?),
    })
}

fn mix(node: &NodeJson) -> Result<Found, Refusal> {
    let clamp = node.is("clamp_factor");
    Ok(match node.text("data_type") {
        Some("FLOAT") => only(Function::MixFloat { clamp }),
        Some("VECTOR") => only(Function::MixVector {
            clamp,
            uniform: node.text("factor_mode") != Some("NON_UNIFORM"),
        }),
        Some("RGBA") => only(Function::MixColor {
            blend: blend(node, "Factor_Float", clamp)?,
            clamp,
            clamp_result: node.is("clamp_result"),
        }),
        other => return Err(Refusal::of(node, other.unwrap_or("without a type"))),
    })
}

/// The blend mode. Cycles leaves out a mix whose factor is the constant 0 (ConstantFolder::fold_mix), so that Exclusion
/// brings nothing below 0 up to it; nor one that is clamped to it.
fn blend(node: &NodeJson, factor: &str, clamp: bool) -> Result<BlendMode, Refusal> {
    let blend = node.named("blend_type", BlendMode::from_name)?;
    Ok(match (blend, node.inputs.get(factor)) {
        (BlendMode::Exclusion, Some(SocketJson::Number(t))) if *t == 0.0 || (clamp && *t < 0.0) => {
            BlendMode::Mix
        }
        (blend, _) => blend,
    })
}

/// What the nodes ask about the place.
fn input(
    node: &NodeJson,
    kind: &str,
    output: &str,
    material_index: f32,
) -> Result<PlaceInput, Refusal> {
    let refused = || Refusal::of(node, output);
    Ok(match (kind, output) {
        ("TexCoord", "Generated") => PlaceInput::Generated,
        ("TexCoord", "Normal") => PlaceInput::ObjectNormal,
        ("TexCoord" | "UVMap", "UV") => PlaceInput::Uv(node.number("uv_set").unwrap_or(0.0) as u32),
        ("TexCoord", "Object") => match node.properties.get("object_matrix") {
            None => PlaceInput::Object,
            Some(matrix) => {
                let numbers: Option<Vec<f32>> = matrix.as_array().and_then(|numbers| {
                    let number = |v: &Value| v.as_f64().map(|v| v as f32);
                    numbers.iter().map(number).collect()
                });
                let row = |m: &[f32], i: usize| <[f32; 4]>::try_from(m.get(4 * i..4 * i + 4)?).ok();
                let m = numbers.ok_or_else(refused)?;
                let rows = [0, 1, 2].map(|i| row(&m, i).unwrap_or_default());
                PlaceInput::OfObject(rows)
            }
        },
        ("TexCoord", "Camera") => PlaceInput::Camera,
        ("TexCoord", "Window") => PlaceInput::Window,
        ("TexCoord", "Reflection") => PlaceInput::Reflection,
        ("NewGeometry", "Position") => PlaceInput::Position,
        ("NewGeometry", "Normal") => PlaceInput::Normal,
        ("NewGeometry", "Tangent") => PlaceInput::Tangent,
        ("NewGeometry", "True Normal") => PlaceInput::TrueNormal,
        ("NewGeometry", "Incoming") => PlaceInput::Incoming,
        ("NewGeometry", "Parametric") => PlaceInput::Parametric,
        ("NewGeometry", "Backfacing") => PlaceInput::Backfacing,
        ("ObjectInfo", "Location") => PlaceInput::ObjectLocation,
        ("ObjectInfo", "Color") => PlaceInput::ObjectColor,
        ("ObjectInfo", "Alpha") => PlaceInput::ObjectAlpha,
        ("ObjectInfo", "Object Index") => PlaceInput::ObjectIndex,
        ("ObjectInfo", "Material Index") => PlaceInput::MaterialIndex(material_index),
        ("ObjectInfo", "Random") => PlaceInput::ObjectRandom,
        ("CameraData", "View Vector") => PlaceInput::ViewVector,
        ("CameraData", "View Z Depth") => PlaceInput::ViewDepth,
        ("CameraData", "View Distance") => PlaceInput::ViewDistance,
        ("LightPath", "Is Camera Ray") => PlaceInput::IsRay(RayKind::Camera.bit()),
        ("LightPath", "Is Shadow Ray") => PlaceInput::IsRay(RayKind::Shadow.bit()),
        ("LightPath", "Is Diffuse Ray") => PlaceInput::IsRay(RayKind::Diffuse.bit()),
        ("LightPath", "Is Glossy Ray") => PlaceInput::IsRay(RayKind::Glossy.bit()),
        ("LightPath", "Is Transmission Ray") => PlaceInput::IsRay(RayKind::Transmission.bit()),
        ("LightPath", "Is Volume Scatter Ray") => PlaceInput::IsRay(RayKind::Volume.bit()),
        ("LightPath", "Is Singular Ray") => PlaceInput::IsSingularRay,
        ("LightPath", "Is Reflection Ray") => PlaceInput::IsReflectionRay,
        ("LightPath", "Diffuse Depth") => PlaceInput::PathDepth(PathDepth::Diffuse),
        ("LightPath", "Glossy Depth") => PlaceInput::PathDepth(PathDepth::Glossy),
        ("LightPath", "Transmission Depth") => PlaceInput::PathDepth(PathDepth::Transmission),
        ("LightPath", "Transparent Depth") => PlaceInput::PathDepth(PathDepth::Transparent),
        ("LightPath", "Portal Depth") => PlaceInput::PathDepth(PathDepth::Portal),
        ("LightPath", "Ray Length") => PlaceInput::RayLength,
        ("LightPath", "Ray Depth") => PlaceInput::RayDepth,
        ("HairInfo", "Is Strand") => PlaceInput::IsStrand,
        ("HairInfo", "Thickness") => PlaceInput::StrandThickness,
        ("HairInfo", "Tangent Normal") => PlaceInput::StrandNormal,
        ("PointInfo", "Position") => PlaceInput::PointPosition,
        ("PointInfo", "Radius") => PlaceInput::PointRadius,
        _ => return Err(refused()),
    })
}
