//! Lamps in their places: radiance, units, and Blender's conventions undone.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::lights::{Lamp, Pole, Shape, Shaping};
use super::primitives;
use crate::nodes::ies::IesProfile;
use crate::nodes::math::Math;
use crate::nodes::range::RangeKind;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::function::{PlaceInput, Space, Transformed};
use crate::scene::graph::node::{emission, image_texture};
use crate::scene::graph::{Function, Graph, ImageProjection, Input, Link, Node, NodeKind};
use crate::scene::{
    AreaShape, ImageId, ImageUse, Light, LightKind, Links, Mesh, RayKind, Sampler, Texture,
    Visibility, Wrap,
};

/// The stage's axes and unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// The stage's space to ours: Y up, metres.
    pub ours_from_stage: DAffine3,
    pub meters_per_unit: f64,
    pub z_up: bool,
}

/// A lamp that has been placed.
pub(super) enum Placed {
    Light(Box<Light>),
    /// A mesh that shines with a radiance.
    Mesh(Box<Mesh>, [f32; 3]),
    /// Light from all around, and where it is turned to.
    Dome {
        radiance: [f64; 3],
        turn: DMat3,
    },
}

/// Places a lamp; `matrix` is in the stage's space, `image` what it shows.
pub(super) fn place(
    lamp: &Lamp,
    matrix: &DAffine3,
    image: Option<(ImageId, ImageUse)>,
    frame: &Frame,
) -> Placed {
    let m = matrix.matrix3;
    // How much larger an area across the lamp's axis is in the stage than in its own space.
    let across = |a: DVec3, b: DVec3| (m * a).cross(m * b).length();
    let scale = m.determinant().abs().cbrt();
    let unit = frame.meters_per_unit;
    // What is brought to an area counts the stage's units; Blender's power is that of a scene in metres, whatever unit it writes.
    let (square, counted) = (unit * unit, if lamp.of_blender { unit * unit } else { 1.0 });
    let radiance = |area: f64| {
        let share = if lamp.normalize && area > 0.0 {
            1.0 / area
        } else {
            1.0
        };
        lamp.strength * share
    };
    let kind = match &lamp.shape {
        Shape::Dome(dome) => return self::dome(lamp, dome.pole, m, frame),
        Shape::Cylinder { radius, length } => {
            let ring = TAU * radius * scale;
            let radiance = radiance(ring * length * m.x_axis.length() * counted);
            let radiance = lamp.color.map(|c| (c * radiance) as f32);
            return Placed::Mesh(Box::new(cylinder(lamp, *radius, *length)), radiance);
        }
        Shape::Distant { angle } => distant(lamp, *angle),
        Shape::Rect { width, height } => {
            let area = width * height * across(DVec3::X, DVec3::Y);
            area_light(
                AreaShape::Rectangle,
                [*width, *height],
                radiance(area * counted),
            )
        }
        Shape::Disk { radius } => {
            let area = PI * radius * radius * across(DVec3::X, DVec3::Y);
            area_light(
                AreaShape::Ellipse,
                [2.0 * radius; 2],
                radiance(area * counted),
            )
        }
        Shape::Sphere { radius, point } => {
            let radius = radius * scale;
            // A sphere of radiance L has the intensity L·π·r²; brought to its area 4π·r², a quarter. Without a radius there is no
            // area to multiply with, and Blender's lamps without "Normalize" count as if they had a cross-section of 1.
            let quarter = 0.25 * lamp.strength;
            let bare = radius == 0.0 || (*point && lamp.of_blender);
            let intensity = if bare || lamp.normalize {
                quarter * square / counted
            } else if lamp.of_blender {
                quarter * PI * radius * radius * square
            } else {
                lamp.strength * PI * radius * radius * square
            };
            let radius = if *point { 0.0 } else { radius * unit };
            sphere(
                intensity as f32,
                radius as f32,
                &lamp.shaping,
                lamp.of_blender,
            )
        }
    };
    // As Blender has it for lamps, those that it imports too.
    let mut visibility = Visibility::ALL.without(RayKind::Camera);
    if !lamp.shadows {
        visibility = visibility.without(RayKind::Shadow);
    }
    let shaped = match kind {
        LightKind::Spot { .. } => Shaping {
            cone: None,
            ..lamp.shaping
        },
        _ => lamp.shaping,
    };
    let brightest = lamp.color.iter().fold(0.0f64, |most, c| most.max(*c));
    let (color, kind) = if brightest > 0.0 {
        (
            lamp.color.map(|c| (c / brightest) as f32),
            stronger(kind, brightest as f32),
        )
    } else {
        ([0.0; 3], kind)
    };
    Placed::Light(Box::new(Light {
        name: lamp.name.clone(),
        color,
        kind,
        world_from_light: frame.ours_from_stage * *matrix,
        visibility,
        max_bounces: Light::MAX_BOUNCES,
        is_hit: true,
        links: Links::default(),
        graph: graph(&shaped, lamp.ies.as_ref(), image).map(Box::new),
    }))
}

fn area_light(shape: AreaShape, size: [f64; 2], radiance: f64) -> LightKind {
    LightKind::Area {
        shape,
        size: size.map(|s| s as f32),
        power: (PI * radiance) as f32,
        normalize: false,
        spread: PI as f32,
    }
}

/// Blender writes a fourth of a sun's strength and half of its angle.
fn distant(lamp: &Lamp, angle: f64) -> LightKind {
    if lamp.of_blender {
        return LightKind::Sun {
            irradiance: (4.0 * lamp.strength) as f32,
            angle: (2.0 * angle).min(PI) as f32,
        };
    }
    // The projected solid angle of the disc.
    let sin = (0.5 * angle).sin();
    let size = PI * sin * sin;
    let irradiance = if lamp.normalize || size == 0.0 {
        lamp.strength
    } else {
        lamp.strength * size
    };
    LightKind::Sun {
        irradiance: irradiance as f32,
        angle: angle as f32,
    }
}

fn sphere(intensity: f32, radius: f32, shaping: &Shaping, of_blender: bool) -> LightKind {
    let soft_falloff = false;
    match shaping.cone {
        // A cone with a hard edge is the same everywhere; how soft ones fade is each program's own.
        Some((half, softness)) if half <= 0.5 * PI && (of_blender || softness == 0.0) => {
            LightKind::Spot {
                intensity,
                radius,
                soft_falloff,
                half_angle: half as f32,
                blend: softness as f32,
            }
        }
        _ => LightKind::Point {
            intensity,
            radius,
            soft_falloff,
        },
    }
}

fn stronger(kind: LightKind, by: f32) -> LightKind {
    let mut kind = kind;
    match &mut kind {
        LightKind::Point { intensity: s, .. }
        | LightKind::Spot { intensity: s, .. }
        | LightKind::Sun { irradiance: s, .. }
        | LightKind::Area { power: s, .. } => *s *= by,
    }
    kind
}

/// What the shaping leaves of the light in each direction, θ from the axis: cos^focus, and 1 less the smooth step between
/// the cone's inner and outer angle, as in USD's own renderer (hdEmbree); times a profile and an image.
fn graph(
    shaping: &Shaping,
    ies: Option<&Arc<IesProfile>>,
    image: Option<(ImageId, ImageUse)>,
) -> Option<Graph> {
    if shaping.cone.is_none() && shaping.focus == 0.0 && ies.is_none() && image.is_none() {
        return None;
    }
    let mut graph = Graph::default();
    let picture = image.map(|image| picture(&mut graph, image));
    let function = |f: Function| Node::new(NodeKind::Function(f));
    let math = |operation: Math| {
        function(Function::Math {
            operation,
            clamp: false,
        })
    };
    let way = graph.add(function(Function::Place(PlaceInput::Incoming)));
    // In the lamp's own axes, which looks down its -Z.
    let turned = Function::VectorTransform {
        what: Transformed::Normal,
        from: Space::World,
        to: Space::Object,
    };
    let way = graph.add(function(turned).with(0, way));
    let parts = graph.add(function(Function::SeparateXyz).with(0, way));
    let along = Link { output: 2, ..parts };
    let cos = graph.add(math(Math::Multiply).with(0, along).with(1, -1.0));
    let mut strength = Input::float(1.0);
    if shaping.focus > 0.0 {
        let front = graph.add(math(Math::Maximum).with(0, cos).with(1, 0.0));
        let power = graph.add(
            math(Math::Power)
                .with(0, front)
                .with(1, shaping.focus as f32),
        );
        strength = power.into();
    }
    if let Some((half, softness)) = shaping.cone {
        let angle = graph.add(math(Math::Arccosine).with(0, cos));
        let (half, inner) = (half as f32, (half * (1.0 - softness)) as f32);
        let open = if inner < half {
            let range = Function::MapRange {
                kind: RangeKind::SmoothStep,
                clamp: true,
            };
            let range = function(range).with(0, angle).with(1, inner).with(2, half);
            graph.add(range.with(3, 1.0).with(4, 0.0))
        } else {
            graph.add(math(Math::LessThan).with(0, angle).with(1, half))
        };
        strength = graph
            .add(math(Math::Multiply).with(0, strength).with(1, open))
            .into();
    }
    if let Some(profile) = ies {
        let profile = graph.add(function(Function::Ies(profile.clone())).with(0, way));
        strength = graph
            .add(math(Math::Multiply).with(0, strength).with(1, profile))
            .into();
    }
    let mut shining = Node::new(NodeKind::Emission).with(emission::STRENGTH, strength);
    if let Some(picture) = picture {
        shining = shining.with(emission::COLOR, picture);
    }
    let shining = graph.add(shining);
    graph.surface = Some(shining);
    Some(graph)
}

/// An image upright on a rectangle for who looks at its front: its left is on +X, its top on +Y.
fn picture(graph: &mut Graph, (image, usage): (ImageId, ImageUse)) -> Link {
    let function = |f: Function| Node::new(NodeKind::Function(f));
    let at = graph.add(function(Function::Place(PlaceInput::Uv(0))));
    let mirrored = function(Function::VectorMath(VectorMath::MultiplyAdd))
        .with(0, at)
        .with(1, [-1.0, 1.0, 1.0])
        .with(2, [1.0, 0.0, 0.0]);
    let mirrored = graph.add(mirrored);
    let texture = Node::new(NodeKind::ImageTexture {
        texture: Texture {
            sampler: Sampler {
                wrap_u: Wrap::Clamp,
                wrap_v: Wrap::Clamp,
                ..Sampler::default()
            },
            ..Texture::from(image)
        },
        usage,
        projection: ImageProjection::Flat,
    });
    graph.add(texture.with(image_texture::VECTOR, mirrored))
}

/// The side of a cylinder along X.
fn cylinder(lamp: &Lamp, radius: f64, length: f64) -> Mesh {
    let (positions, normals, triangles) = primitives::tube(radius, length);
    Mesh {
        name: lamp.name.clone(),
        positions,
        normals: Some(normals),
        triangles,
        ..Mesh::default()
    }
}

/// The image's middle is on the light's +Z, its left on +X, its pole on +Y; in Blender's axes these are +X, +Y and +Z.
fn dome(lamp: &Lamp, pole: Pole, m: DMat3, frame: &Frame) -> Placed {
    let radiance = lamp.color.map(|c| c * lamp.strength);
    let x = m.x_axis.normalize_or(DVec3::X);
    let y = (m.y_axis - x * x.dot(m.y_axis)).normalize_or(DVec3::Y);
    let turned = DMat3::from_cols(x, y, x.cross(y));
    let upright = match pole {
        Pole::Z => true,
        Pole::Scene => frame.z_up,
        Pole::Y => false,
    };
    // A dome whose pole is Z is turned there from Y.
    let turned = if upright {
        turned * DMat3::from_rotation_x(0.5 * PI)
    } else {
        turned
    };
    let image_from_light = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    // Stages that are Z up have Blender's axes; others have (x, -z, y) of them.
    let stage_from_blender = if frame.z_up {
        DMat3::IDENTITY
    } else {
        DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y)
    };
    Placed::Dome {
        radiance,
        turn: image_from_light * turned.transpose() * stage_from_blender,
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/placing.rs"]
mod tests;
