//! MaterialX' standard nodes, as Blender's.

use super::materialx::is_connected;
use super::network::{Found, Network, Term};
use super::preview::{self, ADD, DEFAULT_UV, MULTIPLY, SUBTRACT, each};
use super::source::View;
use super::value;
use super::{materialx_blends, materialx_more, materialx_places};
use crate::nodes::color::ColorModel;
use crate::nodes::math::Math;
use crate::nodes::range::RangeKind;
use crate::nodes::vector::RotationAxis;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::node::normal_map;
use crate::scene::graph::{Function, Input, Link, Node, NodeKind, NormalSpace};
use crate::scene::{ImageUse, Sampler, TextureFilter, Wrap};

/// How many numbers an output of a node has, by the end of the node's name.
fn size(name: &str) -> u8 {
    let kind = name.rsplit('_').next().unwrap_or_default();
    match kind.trim_end_matches("FA") {
        "color3" | "vector3" => 3,
        "color4" | "vector4" => 4,
        "vector2" => 2,
        _ => 1,
    }
}

/// What a node gives; its name is without "ND_".
pub(super) fn node(network: &mut Network, shader: &View, name: &str, output: &str) -> Option<Term> {
    let operation = name.split('_').next().unwrap_or_default();
    let size = size(name);
    if let Some(term) = arithmetic(network, shader, operation) {
        return Some(Term {
            size: size.max(term.size),
            ..term
        });
    }
    let input = |network: &mut Network, name: &str, fallback: f32| {
        network.input_or(shader, name, Term::number(fallback))
    };
    Some(match operation {
        "constant" => network.input(shader, "value")?,
        "convert" | "dot" | "surfacematerial" => Term {
            size,
            ..network.input(shader, "in")?
        },
        "image" | "tiledimage" => image(network, shader, name, operation)?,
        "texcoord" => uv(network, DEFAULT_UV),
        "UsdPrimvarReader" => return None,
        "geompropvalue" | "geompropvalueuniform" => primvar(network, shader, size)?,
        "geomcolor" => {
            let number = network.attribute("displayColor", [1.0; 4]);
            let link = network.place(PlaceInput::Attribute(number));
            Term {
                rgb: link.into(),
                a: Link { output: 1, ..link }.into(),
                size,
            }
        }
        "place2d" => place2d(network, shader),
        "rotate2d" => {
            let from = input(network, "in", 0.0);
            let amount = network.input_or(shader, "amount", Term::number(0.0));
            turned(network, from, amount, Term::color([0.0, 0.0, 1.0]), size)
        }
        "rotate3d" => {
            let from = input(network, "in", 0.0);
            let amount = input(network, "amount", 0.0);
            let axis = network.input_or(shader, "axis", Term::color([0.0, 1.0, 0.0]));
            turned(network, from, amount, axis, size)
        }
        "normalmap" => normal(network, shader)?,
        "mix" => {
            let fg = network.input_or(shader, "fg", Term::number(0.0));
            let bg = network.input_or(shader, "bg", Term::number(0.0));
            let factor = input(network, "mix", 0.0);
            Term {
                size,
                ..mixed(network, fg, bg, factor)
            }
        }
        _ => return parts_and_choices(network, shader, operation, (output, size)),
    })
}

/// Nodes that take numbers apart, put them together, bring them elsewhere or choose between them.
fn parts_and_choices(
    network: &mut Network,
    shader: &View,
    operation: &str,
    (output, size): (&str, u8),
) -> Option<Term> {
    let input = |network: &mut Network, name: &str, fallback: f32| {
        network.input_or(shader, name, Term::number(fallback))
    };
    Some(match operation {
        "separate2" | "separate3" | "separate4" => {
            let term = network.input(shader, "in")?;
            let channels = [
                "outx", "outy", "outz", "outw", "outr", "outg", "outb", "outa",
            ];
            let at = channels.iter().position(|c| *c == output).unwrap_or(0) % 4;
            Term {
                rgb: network.channel(term, at as u8),
                ..Term::number(0.0)
            }
        }
        "extract" => {
            let term = network.input(shader, "in")?;
            let at = network
                .plain(shader, "index")
                .unwrap_or(0.0)
                .clamp(0.0, 3.0);
            Term {
                rgb: network.channel(term, at as u8),
                ..Term::number(0.0)
            }
        }
        "combine2" | "combine3" | "combine4" => {
            let parts = ["in1", "in2", "in3"].map(|name| input(network, name, 0.0).rgb);
            let a = input(network, "in4", 1.0).rgb;
            // A vector with one more number.
            if let Some(whole) = network.input(shader, "in1").filter(|t| t.size == 3) {
                let a = input(network, "in2", 1.0).rgb;
                return Some(Term {
                    rgb: whole.rgb,
                    a,
                    size: 4,
                });
            }
            let rgb = match parts {
                [
                    Input::Value([x, ..]),
                    Input::Value([y, ..]),
                    Input::Value([z, ..]),
                ] => Input::Value([x, y, z]),
                _ => network.function(Function::CombineXyz, &parts).into(),
            };
            Term { rgb, a, size }
        }
        "luminance" => {
            let term = network.input(shader, "in")?;
            let grey = network.vector(VectorMath::DotProduct, &[term.rgb, Input::Value(LUMA)]);
            Term {
                rgb: grey,
                size,
                ..term
            }
        }
        "saturate" => {
            let term = network.input(shader, "in")?;
            let amount = input(network, "amount", 1.0);
            Term {
                size,
                ..saturated(network, term, amount)
            }
        }
        "rgbtohsv" | "hsvtorgb" => {
            let term = network.input(shader, "in")?;
            let (from, to) = if operation == "rgbtohsv" {
                (ColorModel::Hsv, ColorModel::Rgb)
            } else {
                (ColorModel::Rgb, ColorModel::Hsv)
            };
            let parts = network.function(Function::SeparateColor(from), &[term.rgb]);
            let part = |output: u8| Input::Link(Link { output, ..parts });
            let all = [part(0), part(1), part(2)];
            Term {
                rgb: network.function(Function::CombineColor(to), &all).into(),
                ..term
            }
        }
        "remap" | "range" | "smoothstep" => remapped(network, shader, operation, size)?,
        "clamp" => {
            let term = network.input(shader, "in")?;
            let low = input(network, "low", 0.0);
            let high = input(network, "high", 1.0);
            let least = each(network, (Math::Maximum, VectorMath::Maximum), &[term, low]);
            each(
                network,
                (Math::Minimum, VectorMath::Minimum),
                &[least, high],
            )
        }
        "ifgreater" | "ifgreatereq" | "ifequal" => {
            let (a, b) = (input(network, "value1", 1.0), input(network, "value2", 0.0));
            let yes = input(network, "in1", 0.0);
            let no = input(network, "in2", 0.0);
            let is = match operation {
                "ifgreater" => network.math(Math::GreaterThan, &[a.rgb, b.rgb]),
                "ifequal" => network.math(Math::Compare, &[a.rgb, b.rgb, Input::float(0.0)]),
                _ => {
                    let less = network.math(Math::LessThan, &[a.rgb, b.rgb]);
                    network.math(Math::Subtract, &[Input::float(1.0), less])
                }
            };
            let is = Term {
                rgb: is,
                ..Term::number(0.0)
            };
            Term {
                size,
                ..mixed(network, yes, no, is)
            }
        }
        _ => {
            return materialx_blends::node(network, shader, operation, size)
                .or_else(|| materialx_places::node(network, shader, operation, size));
        }
    })
}

/// Weights of Rec.709 (ITU-R BT.709).
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// A colour by so much, its grey by the rest.
pub(super) fn saturated(network: &mut Network, color: Term, amount: Term) -> Term {
    let grey = network.vector(VectorMath::DotProduct, &[color.rgb, Input::Value(LUMA)]);
    let grey = Term {
        rgb: grey,
        size: 3,
        ..color
    };
    mixed(network, color, grey, amount)
}

/// Nodes that do one thing with one to three inputs.
fn arithmetic(network: &mut Network, shader: &View, operation: &str) -> Option<Term> {
    use Math as M;
    use VectorMath as V;
    let two = |network: &mut Network, fallback: f32| {
        let first = network.input_or(shader, "in1", Term::number(0.0));
        let second = network.input_or(shader, "in2", Term::number(fallback));
        [first, second]
    };
    let (numbers, vectors, fallback) = match operation {
        "add" => (M::Add, V::Add, 0.0),
        "subtract" => (M::Subtract, V::Subtract, 0.0),
        "multiply" => (M::Multiply, V::Multiply, 1.0),
        "divide" => (M::Divide, V::Divide, 1.0),
        "modulo" => (M::FlooredModulo, V::Modulo, 1.0),
        "power" => (M::Power, V::Power, 1.0),
        "min" => (M::Minimum, V::Minimum, 0.0),
        "max" => (M::Maximum, V::Maximum, 0.0),
        _ => return function(network, shader, operation),
    };
    let terms = two(network, fallback);
    Some(each(network, (numbers, vectors), &terms))
}

/// Nodes that do one thing with one input, or make a number of vectors.
fn function(network: &mut Network, shader: &View, operation: &str) -> Option<Term> {
    use Math as M;
    use VectorMath as V;
    let (numbers, vectors) = match operation {
        "absval" => (M::Absolute, V::Absolute),
        "sign" => (M::Sign, V::Sign),
        "floor" => (M::Floor, V::Floor),
        "ceil" => (M::Ceil, V::Ceil),
        "round" => (M::Round, V::Round),
        "fract" => (M::Fract, V::Fraction),
        "sin" => (M::Sine, V::Sine),
        "cos" => (M::Cosine, V::Cosine),
        "tan" => (M::Tangent, V::Tangent),
        "normalize" => (M::Sign, V::Normalize),
        "sqrt" | "ln" | "exp" | "asin" | "acos" => {
            let term = network.input(shader, "in")?;
            let operation = match operation {
                "sqrt" => M::Sqrt,
                "exp" => M::Exponent,
                "asin" => M::Arcsine,
                "acos" => M::Arccosine,
                _ => M::Logarithm,
            };
            let e = Input::float(std::f32::consts::E);
            let rgb = if term.size == 1 {
                network.math(operation, &[term.rgb, e])
            } else {
                let parts = [0, 1, 2].map(|at| network.channel(term, at));
                let parts = parts.map(|part| network.math(operation, &[part, e]));
                network.function(Function::CombineXyz, &parts).into()
            };
            let a = match term.size {
                4 => network.math(operation, &[term.a, e]),
                _ => term.a,
            };
            return Some(Term { rgb, a, ..term });
        }
        "atan2" => {
            let y = network.input_or(shader, "iny", Term::number(0.0));
            let x = network.input_or(shader, "inx", Term::number(1.0));
            return Some(Term {
                rgb: network.math(M::Arctan2, &[y.rgb, x.rgb]),
                ..Term::number(0.0)
            });
        }
        "invert" => {
            let amount = network.input_or(shader, "amount", Term::number(1.0));
            let term = network.input(shader, "in")?;
            return Some(each(network, (M::Subtract, V::Subtract), &[amount, term]));
        }
        "dotproduct" | "magnitude" | "crossproduct" => {
            let first = if operation == "magnitude" {
                "in"
            } else {
                "in1"
            };
            let first = network.input(shader, first)?;
            let second = network.input_or(shader, "in2", Term::color([0.0; 3]));
            let operation = match operation {
                "dotproduct" => V::DotProduct,
                "magnitude" => V::Length,
                _ => V::CrossProduct,
            };
            let rgb = network.vector(operation, &[first.rgb, second.rgb]);
            let size = if operation == V::CrossProduct { 3 } else { 1 };
            return Some(Term { rgb, size, ..first });
        }
        _ => return None,
    };
    let term = network.input(shader, "in")?;
    Some(each(network, (numbers, vectors), &[term]))
}

/// `first` by so much, `second` by the rest.
pub(super) fn mixed(network: &mut Network, first: Term, second: Term, factor: Term) -> Term {
    let size = first.size.max(second.size);
    if let (Some(a), Some(b), Some(t)) = (first.constant(), second.constant(), factor.constant()) {
        let rgb = [0, 1, 2].map(|i| a[i] * t[i] + b[i] * (1.0 - t[i]));
        return Term {
            rgb: Input::Value(rgb),
            a: first.a,
            size,
        };
    }
    let clamp = false;
    let function = if size == 1 {
        Function::MixFloat { clamp }
    } else {
        Function::MixVector {
            clamp,
            uniform: false,
        }
    };
    let inputs = [factor.rgb, second.rgb, first.rgb];
    let rgb = network.function(function, &inputs).into();
    let a = if size == 4 && first.a != second.a {
        let factor = network.channel(factor, 0);
        let mix = Function::MixFloat { clamp };
        network.function(mix, &[factor, second.a, first.a]).into()
    } else {
        first.a
    };
    Term { rgb, a, size }
}

fn remapped(network: &mut Network, shader: &View, operation: &str, size: u8) -> Option<Term> {
    let term = network.input(shader, "in")?;
    let number = |network: &mut Network, name: &str, fallback: f32| {
        network.input_or(shader, name, Term::number(fallback)).rgb
    };
    let smooth = operation == "smoothstep";
    let (low, high) = if smooth {
        ("low", "high")
    } else {
        ("inlow", "inhigh")
    };
    let ends = [
        number(network, low, 0.0),
        number(network, high, 1.0),
        if smooth {
            Input::float(0.0)
        } else {
            number(network, "outlow", 0.0)
        },
        if smooth {
            Input::float(1.0)
        } else {
            number(network, "outhigh", 1.0)
        },
    ];
    let kind = if smooth {
        RangeKind::SmoothStep
    } else {
        RangeKind::Linear
    };
    let clamp = smooth || network.plain(shader, "doclamp") == Some(1.0);
    let [a, b, mut c, mut d] = ends;
    let gamma = network
        .input(shader, "gamma")
        .filter(|_| operation == "range");
    let gamma = gamma.filter(|gamma| !gamma.is(1.0));
    if gamma.is_some() {
        (c, d) = (Input::float(0.0), Input::float(1.0));
    }
    let function = if size == 1 {
        Function::MapRange { kind, clamp }
    } else {
        Function::MapRangeVector { kind, clamp }
    };
    let link = network.function(function, &[term.rgb, a, b, c, d]);
    let found = Term {
        rgb: link.into(),
        size,
        ..term
    };
    let Some(gamma) = gamma else {
        return Some(found);
    };
    let divide = (Math::Divide, VectorMath::Divide);
    let exponent = each(network, divide, &[Term::number(1.0), gamma]);
    let bent = materialx_more::safe_power(network, found, exponent);
    let [low, high] = [ends[2], ends[3]].map(|rgb| Term { rgb, ..found });
    let gap = each(network, SUBTRACT, &[high, low]);
    let scaled = each(network, MULTIPLY, &[bent, gap]);
    Some(each(network, ADD, &[scaled, low]))
}

/// The coordinates that a node is given, or those of the mesh.
pub(super) fn coordinates(network: &mut Network, shader: &View) -> Term {
    match network.input(shader, "texcoord") {
        Some(at) => at,
        None => uv(network, DEFAULT_UV),
    }
}

fn uv(network: &mut Network, name: &str) -> Term {
    let set = network.uv_set(name);
    Term::link(network.place(PlaceInput::Uv(set)), 2)
}

fn primvar(network: &mut Network, shader: &View, size: u8) -> Option<Term> {
    let name = network.word(shader, "geomprop")?;
    if size == 2 {
        return Some(uv(network, &name));
    }
    let fallback = match network.find(shader, "default") {
        Found::Value(value) => value::floats(&value).map(|(_, v)| v),
        _ => None,
    };
    let fallback = fallback.unwrap_or_default();
    let at = |i: usize| fallback.get(if size == 1 { 0 } else { i }).copied();
    let number = network.attribute(&name, [0, 1, 2, 3].map(|i| at(i).unwrap_or(0.0)));
    let link = network.place(PlaceInput::Attribute(number));
    Some(if size == 1 {
        Term::link(network.function(Function::SeparateXyz, &[link.into()]), 1)
    } else {
        let a = Link { output: 1, ..link }.into();
        Term {
            rgb: link.into(),
            a,
            size,
        }
    })
}

/// Turned about an axis by an angle in degrees.
fn turned(network: &mut Network, from: Term, amount: Term, axis: Term, size: u8) -> Term {
    if amount.is(0.0) {
        return from;
    }
    let angle = network.math(Math::Radians, &[amount.rgb]);
    let turn = Function::VectorRotate {
        axis: RotationAxis::AxisAngle,
        invert: false,
    };
    let middle = Input::float(0.0);
    let link = network.function(turn, &[from.rgb, middle, axis.rgb, angle]);
    Term::link(link, size)
}

/// Moved, scaled and turned coordinates: (uv − pivot) / scale, turned back, − offset, + pivot.
fn place2d(network: &mut Network, shader: &View) -> Term {
    let from = coordinates(network, shader);
    let pivot = network.input_or(shader, "pivot", Term::color([0.0; 3]));
    let scale = network.input_or(shader, "scale", Term::color([1.0; 3]));
    let offset = network.input_or(shader, "offset", Term::color([0.0; 3]));
    let rotate = network.input_or(shader, "rotate", Term::number(0.0));
    let axis = Term::color([0.0, 0.0, -1.0]);
    let rotates_first = network.plain(shader, "operationorder") == Some(1.0);
    let mut at = each(network, SUBTRACT, &[from, pivot]);
    if rotates_first {
        at = each(network, SUBTRACT, &[at, offset]);
        at = turned(network, at, rotate, axis, 2);
        at = each(network, (Math::Divide, VectorMath::Divide), &[at, scale]);
    } else {
        at = each(network, (Math::Divide, VectorMath::Divide), &[at, scale]);
        at = turned(network, at, rotate, axis, 2);
        at = each(network, SUBTRACT, &[at, offset]);
    }
    let at = each(network, ADD, &[at, pivot]);
    Term { size: 2, ..at }
}

/// Tangents follow the first coordinates of the material.
pub(super) fn follow_uvs(network: &mut Network) {
    if network.needs.uvs.is_empty() {
        network.uv_set(DEFAULT_UV);
    }
    network.needs.tangents.get_or_insert(0);
}

fn normal(network: &mut Network, shader: &View) -> Option<Term> {
    if !is_connected(network, shader, "in") {
        return None;
    }
    let coded = network.input(shader, "in")?;
    let scale = network.input_or(shader, "scale", Term::number(1.0));
    follow_uvs(network);
    let space = NormalSpace::Gltf;
    let map = Node::new(NodeKind::NormalMap { space })
        .with(normal_map::COLOR, coded.rgb)
        .with(normal_map::STRENGTH, scale.rgb);
    Some(Term::link(network.graph.add(map), 3))
}

fn image(network: &mut Network, shader: &View, name: &str, operation: &str) -> Option<Term> {
    let size = size(name);
    let fallback = network.input(shader, "default");
    let fallback = fallback.unwrap_or(Term {
        size,
        ..Term::number(0.0)
    });
    let mut at = coordinates(network, shader);
    if operation == "tiledimage" {
        let tiling = network.input_or(shader, "uvtiling", Term::color([1.0; 3]));
        let offset = network.input_or(shader, "uvoffset", Term::color([0.0; 3]));
        at = each(network, MULTIPLY, &[at, tiling]);
        at = each(network, SUBTRACT, &[at, offset]);
    }
    let wrap = |word: Option<String>| match word.as_deref() {
        Some("clamp") => Wrap::Clamp,
        Some("mirror") => Wrap::Mirror,
        Some("constant") => Wrap::Clip,
        _ => Wrap::Repeat,
    };
    let sampler = Sampler {
        wrap_u: wrap(network.word(shader, "uaddressmode")),
        wrap_v: wrap(network.word(shader, "vaddressmode")),
        filter: match network.word(shader, "filtertype").as_deref() {
            Some("closest") => TextureFilter::Nearest,
            Some("cubic") => TextureFilter::Cubic,
            _ => TextureFilter::Linear,
        },
        ..Sampler::default()
    };
    let space = shader.property_word("inputs:file", "colorSpace");
    let usage = space.and_then(|space| preview::color_space(&space));
    let usage = usage.unwrap_or(ImageUse::Data);
    let file = network.asset(shader, "file");
    let term = file.and_then(|file| preview::image(network, file, (at.rgb, Some(usage)), sampler));
    let Some(term) = term else {
        return Some(fallback);
    };
    Some(if size == 1 {
        Term {
            rgb: network.channel(term, 0),
            ..Term::number(0.0)
        }
    } else {
        Term { size, ..term }
    })
}
