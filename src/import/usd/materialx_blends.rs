//! MaterialX' ramps, adjustments of colours and ways to blend two of them.

use super::materialx_nodes::mixed;
use super::network::{Network, Term};
use super::preview::{ADD, MULTIPLY, SUBTRACT, each};
use super::source::View;
use crate::nodes::color::ColorModel;
use crate::nodes::math::Math;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::{Function, Input, Link};

/// What a node gives, if it is one of these.
pub(super) fn node(
    network: &mut Network,
    shader: &View,
    operation: &str,
    size: u8,
) -> Option<Term> {
    let term = match operation {
        "ramplr" | "ramptb" | "splitlr" | "splittb" => ramp(network, shader, operation),
        "contrast" => {
            let from = network.input(shader, "in")?;
            let amount = network.input_or(shader, "amount", Term::number(1.0));
            let pivot = network.input_or(shader, "pivot", Term::number(0.5));
            let around = each(network, SUBTRACT, &[from, pivot]);
            let scaled = each(network, MULTIPLY, &[around, amount]);
            each(network, ADD, &[scaled, pivot])
        }
        "hsvadjust" => adjusted(network, shader)?,
        "premult" | "unpremult" => {
            let from = network.input(shader, "in")?;
            let alpha = Term {
                rgb: from.a,
                ..Term::number(1.0)
            };
            let by = if operation == "premult" {
                MULTIPLY
            } else {
                (Math::Divide, VectorMath::Divide)
            };
            let color = Term { size: 3, ..from };
            let color = each(network, by, &[color, alpha]);
            Term { a: from.a, ..color }
        }
        "inside" | "outside" => {
            let from = network.input(shader, "in")?;
            let mask = network.input_or(shader, "mask", Term::number(1.0));
            let mask = if operation == "outside" {
                each(network, SUBTRACT, &[Term::number(1.0), mask])
            } else {
                mask
            };
            each(network, MULTIPLY, &[from, mask])
        }
        "switch" => {
            let which = network.plain(shader, "which").unwrap_or(0.0);
            let at = which.clamp(0.0, 9.0) as u8 + 1;
            network.input_or(shader, &format!("in{at}"), Term::number(0.0))
        }
        "plus" | "minus" | "difference" | "screen" | "burn" | "dodge" => {
            blended(network, shader, operation)?
        }
        // What they do to a picture is not known at a point; the picture itself is nearest.
        "blur" => network.input(shader, "in")?,
        _ => return None,
    };
    Some(Term { size, ..term })
}

/// From one value to another across the coordinates, smoothly or at once.
fn ramp(network: &mut Network, shader: &View, operation: &str) -> Term {
    let across = operation.ends_with("lr");
    let names = if across {
        ["valuel", "valuer"]
    } else {
        ["valueb", "valuet"]
    };
    let [first, second] = names.map(|name| network.input_or(shader, name, Term::number(0.0)));
    let at = super::materialx_nodes::coordinates(network, shader);
    let along = network.channel(at, u8::from(!across));
    let factor = if operation.starts_with("ramp") {
        let low = network.math(Math::Maximum, &[along, Input::float(0.0)]);
        network.math(Math::Minimum, &[low, Input::float(1.0)])
    } else {
        let center = network.input_or(shader, "center", Term::number(0.5));
        network.math(Math::GreaterThan, &[along, center.rgb])
    };
    let factor = Term {
        rgb: factor,
        ..Term::number(0.0)
    };
    mixed(network, second, first, factor)
}

/// Hue moved, saturation and value multiplied.
fn adjusted(network: &mut Network, shader: &View) -> Option<Term> {
    let from = network.input(shader, "in")?;
    let amount = network.input_or(shader, "amount", Term::color([0.0, 1.0, 1.0]));
    Some(in_hsv(network, from, amount))
}

/// Hue moved alone.
pub(super) fn hue_moved(network: &mut Network, from: Term, hue: Term) -> Term {
    let (hue, one) = (network.channel(hue, 0), Input::float(1.0));
    let amount = Function::CombineXyz;
    let amount = network.function(amount, &[hue, one, one]);
    in_hsv(network, from, Term::link(amount, 3))
}

fn in_hsv(network: &mut Network, from: Term, amount: Term) -> Term {
    let parts = network.function(Function::SeparateColor(ColorModel::Hsv), &[from.rgb]);
    let part = |output: u8| Input::Link(Link { output, ..parts });
    let [hue, saturation, value] = [0, 1, 2].map(|at| network.channel(amount, at));
    let hue = network.math(Math::Add, &[part(0), hue]);
    let hue = network.math(Math::Fract, &[hue]);
    let saturation = network.math(Math::Multiply, &[part(1), saturation]);
    let value = network.math(Math::Multiply, &[part(2), value]);
    let all = [hue, saturation, value];
    let link = network.function(Function::CombineColor(ColorModel::Hsv), &all);
    Term {
        rgb: link.into(),
        ..from
    }
}

/// A foreground on a background, by so much.
fn blended(network: &mut Network, shader: &View, operation: &str) -> Option<Term> {
    let fg = network.input_or(shader, "fg", Term::number(0.0));
    let bg = network.input_or(shader, "bg", Term::number(0.0));
    let factor = network.input_or(shader, "mix", Term::number(1.0));
    let one = Term::number(1.0);
    let divide = (Math::Divide, VectorMath::Divide);
    let whole = match operation {
        "plus" => each(network, ADD, &[bg, fg]),
        "minus" => each(network, SUBTRACT, &[bg, fg]),
        "difference" => {
            let gap = each(network, SUBTRACT, &[bg, fg]);
            each(network, (Math::Absolute, VectorMath::Absolute), &[gap])
        }
        // 1 − (1 − fg)(1 − bg).
        "screen" => {
            let dark = [fg, bg].map(|term| each(network, SUBTRACT, &[one, term]));
            let product = each(network, MULTIPLY, &dark);
            each(network, SUBTRACT, &[one, product])
        }
        // 1 − (1 − bg) / fg.
        "burn" => {
            let dark = each(network, SUBTRACT, &[one, bg]);
            let share = each(network, divide, &[dark, fg]);
            each(network, SUBTRACT, &[one, share])
        }
        // bg / (1 − fg).
        "dodge" => {
            let dark = each(network, SUBTRACT, &[one, fg]);
            each(network, divide, &[bg, dark])
        }
        _ => return None,
    };
    Some(mixed(network, whole, bg, factor))
}
