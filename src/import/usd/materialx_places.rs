//! MaterialX' nodes that say where a point is and how it is turned, and patterns that are made of that.

use super::materialx_nodes::{coordinates, follow_uvs, mixed};
use super::network::{Network, Term};
use super::preview::{MULTIPLY, SUBTRACT, each};
use super::source::View;
use super::value;
use super::{materialx_more, materialx_noise};
use crate::nodes::curve::Table;
use crate::nodes::math::Math;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::function::{PlaceInput, Space, Transformed};
use crate::scene::graph::{Function, Input, Link};
use std::sync::Arc;

/// What a node gives, if it is one of these.
pub(super) fn node(
    network: &mut Network,
    shader: &View,
    operation: &str,
    size: u8,
) -> Option<Term> {
    Some(match operation {
        "position" => {
            let world = is_world(network, shader, "object");
            position(network, world)
        }
        "normal" | "tangent" | "bitangent" => {
            let world = is_world(network, shader, "object");
            direction(network, operation, world)
        }
        "viewdirection" => {
            let world = is_world(network, shader, "world");
            direction(network, operation, world)
        }
        "facingratio" => facing(network, shader),
        "checkerboard" => checkerboard(network, shader, size),
        "ramp4" => corners(network, shader, size),
        "blackbody" => {
            let kelvin = network.input_or(shader, "temperature", Term::number(5000.0));
            match kelvin.constant() {
                Some(kelvin) => Term::color(glow(kelvin[0])),
                None => glow_of(network, kelvin),
            }
        }
        "swizzle" => swizzled(network, shader, size)?,
        _ => {
            return materialx_noise::node(network, shader, operation, size)
                .or_else(|| materialx_more::node(network, shader, operation, size));
        }
    })
}

/// Whether a node is asked for the world's space; "object" and "model" are one here.
fn is_world(network: &mut Network, shader: &View, fallback: &str) -> bool {
    let space = network.word(shader, "space");
    space.as_deref().unwrap_or(fallback) == "world"
}

/// Whether the stage has Blender's axes.
fn is_z_up(network: &Network) -> bool {
    let axis = network.source.and_then(|source| source.metadata("upAxis"));
    axis.as_ref().and_then(value::word).as_deref() == Some("Z")
}

/// A direction of the stage's axes in Blender's.
pub(super) fn in_blender(network: &mut Network, way: Link) -> Link {
    if is_z_up(network) {
        return way;
    }
    let parts = network.function(Function::SeparateXyz, &[way.into()]);
    let part = |output: u8| Input::Link(Link { output, ..parts });
    let back = network.math(Math::Multiply, &[part(2), Input::float(-1.0)]);
    network.function(Function::CombineXyz, &[part(0), back, part(1)])
}

/// Blender's axes in those of the stage, times a number.
fn in_stage(network: &mut Network, way: Link, times: f32) -> Input {
    let z_up = is_z_up(network);
    let scale = Input::Value([times; 3]);
    if z_up {
        return match times {
            1.0 => way.into(),
            _ => network.vector(VectorMath::Multiply, &[way.into(), scale]),
        };
    }
    let parts = network.function(Function::SeparateXyz, &[way.into()]);
    let part = |output: u8| Input::Link(Link { output, ..parts });
    let back = network.math(Math::Multiply, &[part(1), Input::float(-1.0)]);
    let turned = network.function(Function::CombineXyz, &[part(0), part(2), back]);
    match times {
        1.0 => turned.into(),
        _ => network.vector(VectorMath::Multiply, &[turned.into(), scale]),
    }
}

/// Where a point is, in the stage's units. A mesh keeps its own space.
pub(super) fn position(network: &mut Network, world: bool) -> Term {
    if !world {
        return Term::link(network.place(PlaceInput::Object), 3);
    }
    let unit = network
        .source
        .map_or(1.0, |source| source.meters_per_unit());
    let here = network.place(PlaceInput::Position);
    Term {
        rgb: in_stage(network, here, (1.0 / unit) as f32),
        ..Term::color([0.0; 3])
    }
}

/// A direction of unit length in the stage's axes, or in the object's own.
pub(super) fn direction(network: &mut Network, operation: &str, world: bool) -> Term {
    let way = match operation {
        "normal" => network.place(PlaceInput::Normal),
        "viewdirection" => network.place(PlaceInput::Incoming),
        _ => {
            follow_uvs(network);
            network.place(PlaceInput::UvTangent)
        }
    };
    let mut way = Input::Link(way);
    if operation == "bitangent" {
        let normal = network.place(PlaceInput::Normal);
        way = network.vector(VectorMath::CrossProduct, &[normal.into(), way]);
    }
    if operation == "viewdirection" {
        // From the viewer to the surface.
        way = network.vector(VectorMath::Multiply, &[way, Input::Value([-1.0; 3])]);
    }
    let Input::Link(link) = way else {
        return Term::color([0.0; 3]);
    };
    let rgb = if world {
        in_stage(network, link, 1.0)
    } else {
        let turned = Function::VectorTransform {
            what: match operation {
                "normal" => Transformed::Normal,
                _ => Transformed::Vector,
            },
            from: Space::World,
            to: Space::Object,
        };
        let turned = network.function(turned, &[way]);
        network.vector(VectorMath::Normalize, &[turned.into()])
    };
    Term {
        rgb,
        ..Term::color([0.0; 3])
    }
}

/// How much a surface faces the viewer: |V·N|, or −V·N; or 1 less that.
fn facing(network: &mut Network, shader: &View) -> Term {
    let given = |network: &mut Network, name: &str, operation: &str| {
        let input = network.input(shader, name);
        input.unwrap_or_else(|| direction(network, operation, true))
    };
    let view = given(network, "viewdirection", "viewdirection");
    let normal = given(network, "normal", "normal");
    let cos = network.vector(VectorMath::DotProduct, &[view.rgb, normal.rgb]);
    let forward = network.plain(shader, "faceforward") != Some(0.0);
    let ratio = if forward {
        network.math(Math::Absolute, &[cos])
    } else {
        network.math(Math::Multiply, &[cos, Input::float(-1.0)])
    };
    let ratio = match network.plain(shader, "invert") {
        Some(1.0) => network.math(Math::Subtract, &[Input::float(1.0), ratio]),
        _ => ratio,
    };
    Term {
        rgb: ratio,
        ..Term::number(0.0)
    }
}

/// As MaterialX' own graph has it: the first colour where the sum of the whole coordinates is odd.
fn checkerboard(network: &mut Network, shader: &View, size: u8) -> Term {
    let at = coordinates(network, shader);
    let tiling = network.input_or(shader, "uvtiling", Term::color([8.0; 3]));
    let offset = network.input_or(shader, "uvoffset", Term::color([0.0; 3]));
    let at = each(network, MULTIPLY, &[at, tiling]);
    let at = each(network, SUBTRACT, &[at, offset]);
    let whole = network.vector(VectorMath::Floor, &[at.rgb]);
    let sum = network.vector(
        VectorMath::DotProduct,
        &[whole, Input::Value([1.0, 1.0, 0.0])],
    );
    let odd = network.math(Math::FlooredModulo, &[sum, Input::float(2.0)]);
    let odd = Term {
        rgb: odd,
        ..Term::number(0.0)
    };
    let first = network.input_or(shader, "color1", Term::color([1.0; 3]));
    let second = network.input_or(shader, "color2", Term::color([0.0; 3]));
    Term {
        size,
        ..mixed(network, first, second, odd)
    }
}

/// Four values at the corners: from left to right by u, and from top to bottom by v, as MaterialX' own graph has it.
fn corners(network: &mut Network, shader: &View, size: u8) -> Term {
    let at = coordinates(network, shader);
    let [u, v] = [0, 1].map(|axis| {
        let along = network.channel(at, axis);
        let low = network.math(Math::Maximum, &[along, Input::float(0.0)]);
        Term {
            rgb: network.math(Math::Minimum, &[low, Input::float(1.0)]),
            ..Term::number(0.0)
        }
    });
    let [top, bottom] = [["valuetl", "valuetr"], ["valuebl", "valuebr"]].map(|names| {
        let zero = Term {
            size,
            ..Term::number(0.0)
        };
        let [left, right] = names.map(|name| network.input_or(shader, name, zero));
        mixed(network, right, left, u)
    });
    Term {
        size,
        ..mixed(network, bottom, top, v)
    }
}

/// Numbers in another order, or 0 and 1: by the letters in "channels".
fn swizzled(network: &mut Network, shader: &View, size: u8) -> Option<Term> {
    let from = network.input(shader, "in")?;
    let channels = network.word(shader, "channels")?;
    let mut parts = Vec::new();
    for letter in channels.chars() {
        parts.push(match letter {
            'r' | 'x' => network.channel(from, 0),
            'g' | 'y' => network.channel(from, 1),
            'b' | 'z' => network.channel(from, 2),
            'a' | 'w' => network.channel(from, 3),
            '0' => Input::float(0.0),
            '1' => Input::float(1.0),
            _ => return None,
        });
    }
    let at = |i: usize| parts.get(i).copied().unwrap_or(Input::float(0.0));
    if size == 1 {
        return Some(Term {
            rgb: at(0),
            ..Term::number(0.0)
        });
    }
    let rgb = network.function(Function::CombineXyz, &[at(0), at(1), at(2)]);
    Some(Term {
        rgb: rgb.into(),
        a: parts.get(3).copied().unwrap_or(Input::float(1.0)),
        size,
    })
}

/// Where temperatures of black bodies end.
const GLOW: [f64; 2] = [1667.0, 25_000.0];

/// The same of a temperature that is not the same everywhere: by a table over one over it, between whose entries lies a line.
fn glow_of(network: &mut Network, kelvin: Term) -> Term {
    let [least, most] = GLOW.map(|kelvin| kelvin as f32);
    // From the highest temperature to the lowest.
    let count = 1024;
    let entry = |at: usize| {
        let share = at as f32 / count as f32;
        let color = glow(1.0 / (1.0 / most + share * (1.0 / least - 1.0 / most)));
        glam::Vec3::from(color).extend(1.0)
    };
    let table = Table {
        entries: (0..=count).map(entry).collect(),
        interpolate: true,
        extrapolate: false,
    };
    let above = network.math(Math::Maximum, &[kelvin.rgb, Input::float(1.0)]);
    let one_over = network.math(Math::Divide, &[Input::float(1.0), above]);
    let range = 1.0 / least - 1.0 / most;
    let (scale, offset) = (1.0 / range, -1.0 / (most * range));
    let inputs = [one_over, Input::float(scale), Input::float(offset)];
    let place = network.math(Math::MultiplyAdd, &inputs);
    let ramp = Function::ColorRamp(Arc::new(table));
    Term::link(network.function(ramp, &[place]), 3)
}

/// What a black body of a temperature shines in: linear Rec.709 of luminance 1. MaterialX defines it by the Planckian locus
/// of Kim and others (US patent 7,024,034) from 1667 to 25000 K.
pub(super) fn glow(kelvin: f32) -> [f32; 3] {
    let kelvin = f64::from(kelvin).clamp(GLOW[0], GLOW[1]);
    let t = 1000.0 / kelvin;
    let cubic = |[a, b, c, d]: [f64; 4], x: f64| ((a * x + b) * x + c) * x + d;
    let x = if kelvin < 4000.0 {
        cubic([-0.266_123_9, -0.234_358_0, 0.877_695_6, 0.179_910], t)
    } else {
        cubic([-3.025_846_9, 2.107_037_9, 0.222_634_7, 0.240_390], t)
    };
    let y = if kelvin < 2222.0 {
        cubic(
            [-1.106_381_4, -1.348_110_20, 2.185_558_32, -0.202_196_83],
            x,
        )
    } else if kelvin < 4000.0 {
        cubic(
            [-0.954_947_6, -1.374_185_93, 2.091_370_15, -0.167_488_67],
            x,
        )
    } else {
        cubic([3.081_758_0, -5.873_386_70, 3.751_129_97, -0.370_014_83], x)
    };
    let (big_x, big_z) = (x / y, (1.0 - x - y) / y);
    // CIE XYZ to linear Rec.709 (IEC 61966-2-1).
    let rgb = [
        3.2406 * big_x - 1.5372 - 0.4986 * big_z,
        -0.9689 * big_x + 1.8758 + 0.0415 * big_z,
        0.0557 * big_x - 0.2040 + 1.0570 * big_z,
    ];
    rgb.map(|v| v.max(0.0) as f32)
}
