use super::*;
use crate::scene::graph::{Node, NodeKind};
use glam::Vec4;

/// Of each kind of node that needs no place.
fn some() -> Vec<Function> {
    let table = Table {
        entries: vec![Vec4::ZERO, Vec4::ONE],
        interpolate: true,
        extrapolate: false,
    };
    let curves = Arc::new(Curves {
        table: table.clone(),
        least: 0.0,
        most: 1.0,
    });
    vec![
        Function::Math {
            operation: Math::Add,
            clamp: true,
        },
        Function::VectorMath(VectorMath::Length),
        Function::MixFloat { clamp: true },
        Function::MixVector {
            clamp: true,
            uniform: true,
        },
        Function::MixVector {
            clamp: true,
            uniform: false,
        },
        Function::MixColor {
            blend: BlendMode::Mix,
            clamp: true,
            clamp_result: true,
        },
        Function::ColorRamp(Arc::new(table)),
        Function::Curves(curves.clone()),
        Function::VectorCurves(curves.clone()),
        Function::FloatCurve(curves),
        Function::MapRange {
            kind: RangeKind::Linear,
            clamp: true,
        },
        Function::MapRangeVector {
            kind: RangeKind::Linear,
            clamp: true,
        },
        Function::Clamp { sorted: true },
        Function::CombineColor(ColorModel::Hsv),
        Function::CombineXyz,
        Function::SeparateColor(ColorModel::Hsv),
        Function::SeparateXyz,
        Function::HueSaturation,
        Function::BrightContrast,
        Function::Gamma,
        Function::Invert,
        Function::RgbToBw,
        Function::Mapping(Mapping::Point),
        Function::RadialTiling { normalize: true },
        Function::RadialSegment,
        Function::VectorRotate {
            axis: RotationAxis::Z,
            invert: false,
        },
    ]
}

#[test]
fn functions_of_numbers_are_known_at_once() {
    for function in some() {
        let defaults = function.sockets().iter();
        let inputs: Vec<_> = defaults
            .map(|s| Vec4::from((glam::Vec3::from(s.default), 1.0)))
            .collect();
        let result = function.evaluate(&inputs).unwrap();
        assert!(result.is_finite(), "{function:?} {result}");
        assert!(!function.outputs().is_empty());
        let node = Node::new(NodeKind::Function(function.clone()));
        assert_eq!(node.inputs.len(), function.sockets().len());
    }
}

#[test]
fn what_depends_on_the_place_is_not() {
    for function in [Function::Place(PlaceInput::Generated), Function::Fresnel] {
        let inputs = vec![Vec4::ONE; function.sockets().len()];
        assert_eq!(function.evaluate(&inputs), None);
    }
}
