//! MaterialX' noises and random numbers.

use super::materialx_nodes::coordinates;
use super::materialx_places::position;
use super::network::{Network, Term};
use super::preview::{ADD, MULTIPLY, SUBTRACT, each};
use super::source::View;
use crate::nodes::color::ColorModel;
use crate::nodes::math::Math;
use crate::nodes::range::RangeKind;
use crate::nodes::vector::RotationAxis;
use crate::nodes::{Dimensions, LatticeNoise, LatticeSettings, NoiseSettings, NoiseType};
use crate::scene::graph::function::ProceduralTexture;
use crate::scene::graph::{Function, Input, Link};

/// What a node gives, if it is one of these.
pub(super) fn node(
    network: &mut Network,
    shader: &View,
    operation: &str,
    size: u8,
) -> Option<Term> {
    let flat = operation.ends_with("2d");
    Some(match operation {
        "noise2d" | "noise3d" => perlin(network, shader, flat, size),
        "fractal2d" | "fractal3d" => fractal(network, shader, flat, size),
        "cellnoise2d" | "cellnoise3d" => {
            let at = place(network, shader, flat);
            cell(network, at, flat)
        }
        "worleynoise2d" | "worleynoise3d" => {
            let at = place(network, shader, flat);
            let jitter = network.input_or(shader, "jitter", Term::number(1.0));
            let solid = network.plain(shader, "style") == Some(1.0);
            worley(network, at, jitter, (solid, flat), size)
        }
        "unifiednoise2d" | "unifiednoise3d" => unified(network, shader, flat),
        "randomfloat" => {
            let from = network.input_or(shader, "in", Term::number(0.0));
            let from = seeded(network, shader, from);
            let seed = network.plain(shader, "seed").unwrap_or(0.0);
            let number = random(network, from, seed);
            within(network, shader, number, ["min", "max"], ([0.0, 1.0], true))
        }
        "randomcolor" => random_color(network, shader),
        _ => return None,
    })
}

/// Where a noise is asked.
fn place(network: &mut Network, shader: &View, flat: bool) -> Term {
    if flat {
        return coordinates(network, shader);
    }
    let given = network.input(shader, "position");
    given.unwrap_or_else(|| position(network, false))
}

fn settings(noise: LatticeNoise, flat: bool) -> ProceduralTexture {
    ProceduralTexture::Lattice(LatticeSettings { noise, flat })
}

/// Octaves of Perlin's noise: how many, how much finer and how much lower than the one before.
#[derive(Clone, Copy)]
struct Octaves {
    count: f32,
    lacunarity: Input,
    diminish: Input,
}

impl Octaves {
    const ONE: Self = Self {
        count: 1.0,
        lacunarity: Input::Value([2.0; 3]),
        diminish: Input::Value([0.5; 3]),
    };

    fn of(network: &mut Network, shader: &View) -> Self {
        let count = network.plain(shader, "octaves").unwrap_or(3.0);
        let mut number =
            |name: &str, fallback: f32| network.input_or(shader, name, Term::number(fallback)).rgb;
        Self {
            count: count.clamp(1.0, 16.0).floor(),
            lacunarity: number("lacunarity", 2.0),
            diminish: number("diminish", 0.5),
        }
    }
}

/// Perlin's noise of one number: MaterialX has it from OSL, as Blender does.
fn one(network: &mut Network, at: Term, octaves: Octaves, flat: bool) -> Term {
    let texture = ProceduralTexture::NoiseFactor(NoiseSettings {
        dimensions: if flat {
            Dimensions::Two
        } else {
            Dimensions::Three
        },
        noise_type: NoiseType::Fbm,
        normalize: false,
    });
    let inputs = [
        at.rgb,
        Input::float(0.0),
        Input::float(1.0),
        Input::float(octaves.count - 1.0),
        octaves.diminish,
        octaves.lacunarity,
    ];
    Term::link(network.function(Function::Texture(texture), &inputs), 1)
}

/// The same of three numbers.
fn three(network: &mut Network, at: Term, octaves: Octaves, flat: bool) -> Term {
    let inputs = [
        at.rgb,
        Input::float(1.0),
        Input::float(octaves.count),
        octaves.lacunarity,
        octaves.diminish,
    ];
    let texture = Function::Texture(settings(LatticeNoise::Perlin, flat));
    Term::link(network.function(texture, &inputs), 3)
}

/// The noise elsewhere: more numbers of it.
fn moved(network: &mut Network, at: Term, by: [f32; 3]) -> Term {
    let by = Term::color(by);
    Term {
        size: at.size,
        ..each(network, ADD, &[at, by])
    }
}

/// A color's or a vector's fourth number is the noise of one number elsewhere.
fn with_fourth(
    network: &mut Network,
    at: Term,
    (octaves, elsewhere): (Octaves, [f32; 3]),
    (flat, size): (bool, u8),
) -> Term {
    let mut term = three(network, at, octaves, flat);
    if size == 4 {
        let at = moved(network, at, elsewhere);
        term.a = one(network, at, octaves, flat).rgb;
    }
    Term { size, ..term }
}

fn perlin(network: &mut Network, shader: &View, flat: bool, size: u8) -> Term {
    let at = place(network, shader, flat);
    let noise = if size == 1 {
        one(network, at, Octaves::ONE, flat)
    } else {
        let elsewhere = [19.0, 73.0, if flat { 0.0 } else { 29.0 }];
        with_fourth(network, at, (Octaves::ONE, elsewhere), (flat, size))
    };
    let amplitude = network.input_or(shader, "amplitude", Term::number(1.0));
    let pivot = network.input_or(shader, "pivot", Term::number(0.0));
    let scaled = each(network, MULTIPLY, &[noise, amplitude]);
    each(network, ADD, &[scaled, pivot])
}

fn fractal(network: &mut Network, shader: &View, flat: bool, size: u8) -> Term {
    let at = place(network, shader, flat);
    let octaves = Octaves::of(network, shader);
    let elsewhere = [19.0, 193.0, if flat { 0.0 } else { 17.0 }];
    let noise = match size {
        1 => one(network, at, octaves, flat),
        2 => {
            let first = one(network, at, octaves, flat).rgb;
            let at = moved(network, at, elsewhere);
            let second = one(network, at, octaves, flat).rgb;
            let both = [first, second, Input::float(0.0)];
            Term::link(network.function(Function::CombineXyz, &both), 2)
        }
        _ => with_fourth(network, at, (octaves, elsewhere), (flat, size)),
    };
    let amplitude = network.input_or(shader, "amplitude", Term::number(1.0));
    each(network, MULTIPLY, &[noise, amplitude])
}

fn cell(network: &mut Network, at: Term, flat: bool) -> Term {
    let texture = Function::Texture(settings(LatticeNoise::Cell, flat));
    let link = network.function(texture, &[at.rgb]);
    Term::link(Link { output: 1, ..link }, 1)
}

fn worley(
    network: &mut Network,
    at: Term,
    jitter: Term,
    (solid, flat): (bool, bool),
    size: u8,
) -> Term {
    let noise = if solid {
        LatticeNoise::WorleyCell
    } else {
        LatticeNoise::Worley
    };
    let texture = Function::Texture(settings(noise, flat));
    let link = network.function(texture, &[at.rgb, jitter.rgb]);
    let output = u8::from(size == 1);
    Term::link(Link { output, ..link }, size)
}

/// One of four noises, brought between two numbers.
fn unified(network: &mut Network, shader: &View, flat: bool) -> Term {
    let size = if flat { 2 } else { 3 };
    let at = place(network, shader, flat);
    let often = network.input_or(shader, "freq", Term::color([1.0; 3]));
    let offset = network.input_or(shader, "offset", Term::color([0.0; 3]));
    let at = each(network, MULTIPLY, &[at, often]);
    let at = Term {
        size,
        ..each(network, ADD, &[at, offset])
    };
    let jitter = network.input_or(shader, "jitter", Term::number(1.0));
    // Other noises than Worley's are elsewhere by it.
    let less = each(network, SUBTRACT, &[jitter, Term::number(1.0)]);
    let turn = each(network, MULTIPLY, &[less, Term::number(90_000.0)]);
    let axis = if flat {
        [0.0, 0.0, 1.0]
    } else {
        [0.1, 1.0, 0.0]
    };
    let number = match network.plain(shader, "type").unwrap_or(0.0) as u8 {
        1 => {
            let at = turned(network, at, turn, axis);
            cell(network, at, flat)
        }
        2 => {
            let solid = network.plain(shader, "style") == Some(1.0);
            worley(network, at, jitter, (solid, flat), 1)
        }
        3 => {
            let at = if flat {
                let [x, y] = [0, 1].map(|axis| network.channel(at, axis));
                let place = network.function(Function::CombineXyz, &[x, y, turn.rgb]);
                Term::link(place, 3)
            } else {
                turned(network, at, turn, axis)
            };
            let octaves = Octaves::of(network, shader);
            one(network, at, octaves, false)
        }
        _ => {
            let at = turned(network, at, turn, axis);
            let noise = one(network, at, Octaves::ONE, flat);
            let half = Term::number(0.5);
            let noise = each(network, MULTIPLY, &[noise, half]);
            each(network, ADD, &[noise, half])
        }
    };
    let clamp = network.plain(shader, "clampoutput") != Some(0.0);
    let ends = ["outmin", "outmax"];
    within(network, shader, number, ends, ([0.0, 1.0], clamp))
}

/// Turned about an axis by an angle in degrees.
fn turned(network: &mut Network, at: Term, turn: Term, axis: [f32; 3]) -> Term {
    if turn.is(0.0) {
        return at;
    }
    let angle = network.math(Math::Radians, &[turn.rgb]);
    let rotate = Function::VectorRotate {
        axis: RotationAxis::AxisAngle,
        invert: false,
    };
    let inputs = [at.rgb, Input::float(0.0), Input::Value(axis), angle];
    Term::link(network.function(rotate, &inputs), at.size)
}

/// A number of 0 to 1 brought between those in two inputs, and kept there if it is to `clamp`.
fn within(
    network: &mut Network,
    shader: &View,
    number: Term,
    [low, high]: [&str; 2],
    (fallbacks, clamp): ([f32; 2], bool),
) -> Term {
    let low = network.input_or(shader, low, Term::number(fallbacks[0]));
    let high = network.input_or(shader, high, Term::number(fallbacks[1]));
    let range = Function::MapRange {
        kind: RangeKind::Linear,
        clamp,
    };
    let (zero, one) = (Input::float(0.0), Input::float(1.0));
    let inputs = [number.rgb, zero, one, low.rgb, high.rgb];
    Term::link(network.function(range, &inputs), 1)
}

/// What random numbers are drawn by: of fractions 4096 cells for each whole number.
fn seeded(network: &mut Network, shader: &View, from: Term) -> Term {
    let id = shader.word("info:id").unwrap_or_default();
    if id.ends_with("_integer") {
        return from;
    }
    each(network, MULTIPLY, &[from, Term::number(4096.0)])
}

/// A random number of 0 to 1.
fn random(network: &mut Network, from: Term, seed: f32) -> Term {
    let inputs = [from.rgb, Input::float(seed), Input::float(0.0)];
    let place = network.function(Function::CombineXyz, &inputs);
    cell(network, Term::link(place, 2), true)
}

fn random_color(network: &mut Network, shader: &View) -> Term {
    let from = network.input_or(shader, "in", Term::number(0.0));
    let from = seeded(network, shader, from);
    let seed = network.plain(shader, "seed").unwrap_or(0.0);
    let parts = [
        ("hue", 413.3, [0.0, 1.0]),
        ("saturation", 1522.4, [0.825, 1.0]),
        ("brightness", 1813.8, [1.0, 1.0]),
    ];
    let parts = parts.map(|(name, offset, ends)| {
        let number = random(network, from, (seed + offset).ceil());
        let [low, high] = ["low", "high"].map(|end| format!("{name}{end}"));
        within(network, shader, number, [&low, &high], (ends, true)).rgb
    });
    let link = network.function(Function::CombineColor(ColorModel::Hsv), &parts);
    Term::link(link, 3)
}
