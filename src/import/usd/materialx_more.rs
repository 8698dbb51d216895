//! MaterialX' nodes that its library makes of others: waves, powers, reflections, corrections of colours, and layers of pictures.

use super::materialx_blends::hue_moved;
use super::materialx_nodes::{coordinates, mixed, saturated};
use super::materialx_places::direction;
use super::network::{Network, Term};
use super::preview::{ADD, MULTIPLY, SUBTRACT, each};
use super::source::View;
use crate::nodes::math::Math;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::Input;

const ABSOLUTE: (Math, VectorMath) = (Math::Absolute, VectorMath::Absolute);
const POWER: (Math, VectorMath) = (Math::Power, VectorMath::Power);
const SIGN: (Math, VectorMath) = (Math::Sign, VectorMath::Sign);

/// What a node gives, if it is one of these.
pub(super) fn node(
    network: &mut Network,
    shader: &View,
    operation: &str,
    size: u8,
) -> Option<Term> {
    let one = Term::number(1.0);
    let input = |network: &mut Network, name: &str, fallback: f32| {
        network.input_or(shader, name, Term::number(fallback))
    };
    let term = match operation {
        "safepower" => {
            let base = input(network, "in1", 0.0);
            let exponent = input(network, "in2", 1.0);
            safe_power(network, base, exponent)
        }
        "distance" => {
            let (a, b) = (input(network, "in1", 0.0), input(network, "in2", 0.0));
            let way = network.vector(VectorMath::Distance, &[a.rgb, b.rgb]);
            return Some(number(way));
        }
        // |x| less what is whole of it, and how far that is from the nearest whole number.
        "trianglewave" => {
            let from = input(network, "in", 0.0);
            let from = each(network, ABSOLUTE, &[from]);
            let fraction = network.math(Math::Fract, &[from.rgb]);
            let middle = network.math(Math::Subtract, &[fraction, Input::float(0.5)]);
            let middle = network.math(Math::Absolute, &[middle]);
            number(network.math(Math::Subtract, &[Input::float(0.5), middle]))
        }
        "reflect" => {
            let way = network.input_or(shader, "in", Term::color([1.0, 0.0, 0.0]));
            let normal = network.input(shader, "normal");
            let normal = normal.unwrap_or_else(|| direction(network, "normal", true));
            let rgb = network.vector(VectorMath::Reflect, &[way.rgb, normal.rgb]);
            Term { rgb, ..way }
        }
        "circle" => {
            let at = coordinates(network, shader);
            let center = network.input_or(shader, "center", Term::color([0.0; 3]));
            let radius = input(network, "radius", 0.5);
            let way = network.vector(VectorMath::Distance, &[at.rgb, center.rgb]);
            let outside = network.math(Math::GreaterThan, &[way, radius.rgb]);
            number(network.math(Math::Subtract, &[Input::float(1.0), outside]))
        }
        "colorcorrect" => corrected(network, shader),
        "logical" => logical(network, shader)?,
        "overlay" => overlaid(network, shader),
        "over" | "in" | "out" | "mask" | "matte" => {
            let fg = network.input_or(shader, "fg", Term::color([0.0; 3]));
            let bg = network.input_or(shader, "bg", Term::color([0.0; 3]));
            let factor = input(network, "mix", 1.0);
            let [front, back] = [fg, bg].map(|term| number(term.a));
            let rest = each(network, SUBTRACT, &[one, front]);
            let whole = match operation {
                "in" => each(network, MULTIPLY, &[fg, back]),
                "mask" => each(network, MULTIPLY, &[bg, front]),
                "out" => {
                    let rest = each(network, SUBTRACT, &[one, back]);
                    each(network, MULTIPLY, &[fg, rest])
                }
                _ => {
                    let behind = each(network, MULTIPLY, &[bg, rest]);
                    // The one is multiplied by its alpha already, the other is not.
                    let before = if operation == "over" {
                        fg
                    } else {
                        Term {
                            a: fg.a,
                            ..each(network, MULTIPLY, &[fg, front])
                        }
                    };
                    each(network, ADD, &[before, behind])
                }
            };
            mixed(network, whole, bg, factor)
        }
        _ => return None,
    };
    Some(Term {
        size: size.max(1),
        ..term
    })
}

fn number(rgb: Input) -> Term {
    Term {
        rgb,
        ..Term::number(0.0)
    }
}

/// A power of what may be below zero: its sign stays.
pub(super) fn safe_power(network: &mut Network, base: Term, exponent: Term) -> Term {
    let sign = each(network, SIGN, &[base]);
    let size = each(network, ABSOLUTE, &[base]);
    let power = each(network, POWER, &[size, exponent]);
    each(network, MULTIPLY, &[sign, power])
}

/// Whether one or both of two are true; by the end of the node's name.
fn logical(network: &mut Network, shader: &View) -> Option<Term> {
    let id = shader.word("info:id")?;
    let no = Term::number(0.0);
    if id.ends_with("_not") {
        let from = network.input_or(shader, "in", no);
        return Some(each(network, SUBTRACT, &[Term::number(1.0), from]));
    }
    let [a, b] = ["in1", "in2"].map(|name| network.input_or(shader, name, no));
    let operation = match id.rsplit('_').next()? {
        "and" => Math::Minimum,
        "or" => Math::Maximum,
        "xor" => {
            let gap = network.math(Math::Subtract, &[a.rgb, b.rgb]);
            return Some(number(network.math(Math::Absolute, &[gap])));
        }
        _ => return None,
    };
    Some(number(network.math(operation, &[a.rgb, b.rgb])))
}

/// Twice the product where the background is dark, and 1 less twice that of the complements where it is bright.
fn overlaid(network: &mut Network, shader: &View) -> Term {
    let fg = network.input_or(shader, "fg", Term::number(0.0));
    let bg = network.input_or(shader, "bg", Term::number(0.0));
    let factor = network.input_or(shader, "mix", Term::number(1.0));
    let (one, two) = (Term::number(1.0), Term::number(2.0));
    let product = each(network, MULTIPLY, &[fg, bg]);
    let dark = each(network, MULTIPLY, &[product, two]);
    let rests = [fg, bg].map(|term| each(network, SUBTRACT, &[one, term]));
    let product = each(network, MULTIPLY, &rests);
    let product = each(network, MULTIPLY, &[product, two]);
    let bright = each(network, SUBTRACT, &[one, product]);
    // Where it is bright: 1 of twice the background and more.
    let twice = each(network, MULTIPLY, &[bg, two]);
    let floor = each(network, (Math::Floor, VectorMath::Floor), &[twice]);
    let least = (Math::Minimum, VectorMath::Minimum);
    let most = (Math::Maximum, VectorMath::Maximum);
    let is = each(network, least, &[floor, one]);
    let is = each(network, most, &[is, Term::number(0.0)]);
    let gap = each(network, SUBTRACT, &[bright, dark]);
    let gap = each(network, MULTIPLY, &[gap, is]);
    let whole = each(network, ADD, &[dark, gap]);
    mixed(network, whole, bg, factor)
}

/// Hue, saturation, gamma, lift, gain, contrast and exposure, in this order.
fn corrected(network: &mut Network, shader: &View) -> Term {
    let from = network.input_or(shader, "in", Term::color([1.0; 3]));
    let one = Term::number(1.0);
    let given = |network: &mut Network, name: &str, fallback: f32| {
        network.input_or(shader, name, Term::number(fallback))
    };
    let hue = given(network, "hue", 0.0);
    let mut color = from;
    if !hue.is(0.0) {
        color = hue_moved(network, color, hue);
    }
    let saturation = given(network, "saturation", 1.0);
    if !saturation.is(1.0) {
        color = saturated(network, color, saturation);
    }
    let gamma = given(network, "gamma", 1.0);
    if !gamma.is(1.0) {
        let exponent = each(network, (Math::Divide, VectorMath::Divide), &[one, gamma]);
        color = safe_power(network, color, exponent);
    }
    let lift = given(network, "lift", 0.0);
    let rest = each(network, SUBTRACT, &[one, lift]);
    color = each(network, MULTIPLY, &[color, rest]);
    color = each(network, ADD, &[color, lift]);
    let gain = given(network, "gain", 1.0);
    color = each(network, MULTIPLY, &[color, gain]);
    let contrast = given(network, "contrast", 1.0);
    let pivot = given(network, "contrastpivot", 0.5);
    color = each(network, SUBTRACT, &[color, pivot]);
    color = each(network, MULTIPLY, &[color, contrast]);
    color = each(network, ADD, &[color, pivot]);
    let exposure = given(network, "exposure", 0.0);
    let times = each(network, POWER, &[Term::number(2.0), exposure]);
    color = each(network, MULTIPLY, &[color, times]);
    Term { a: from.a, ..color }
}
