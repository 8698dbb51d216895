//! Between which numbers the results of nodes lie.

use super::super::material::{ImageUse, Texture};
use super::node::{math, mix, separate};
use super::{Graph, Input, Lane, Link, MathOperation, NodeKind, SocketKind};
use crate::math::{average, luminance};
use glam::{Vec3, Vec4};

/// The least and the greatest that numbers can be, in RGBA. They are infinite where nothing is known, so that nothing times
/// them is nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least.
    pub low: Vec4,
    /// The greatest.
    pub high: Vec4,
}

impl Range {
    /// Anything, also what is not finite.
    pub const UNKNOWN: Self = Self {
        low: Vec4::NEG_INFINITY,
        high: Vec4::INFINITY,
    };
    /// Any finite number.
    pub const FINITE: Self = Self {
        low: Vec4::MIN,
        high: Vec4::MAX,
    };
    /// 0 to 1.
    pub const SHARE: Self = Self {
        low: Vec4::ZERO,
        high: Vec4::ONE,
    };
    /// White and opaque.
    pub const WHITE: Self = Self::only(Vec4::ONE);

    /// One value.
    pub const fn only(value: Vec4) -> Self {
        Self {
            low: value,
            high: value,
        }
    }

    fn of(corners: impl IntoIterator<Item = Vec4>) -> Self {
        let mut corners = corners.into_iter();
        let none = Self::only(corners.next().unwrap_or(Vec4::NAN));
        let hull = corners.fold(none, |hull, corner| Self {
            low: Vec4::select(hull.low.cmple(corner), hull.low, corner),
            high: Vec4::select(hull.high.cmpge(corner), hull.high, corner),
        });
        // What is not a number may be anything.
        let numbers = !(hull.low.is_nan_mask() | hull.high.is_nan_mask());
        Self {
            low: Vec4::select(numbers, hull.low, Vec4::NEG_INFINITY),
            high: Vec4::select(numbers, hull.high, Vec4::INFINITY),
        }
    }

    /// Those of an output, where a socket of some kind takes them.
    fn taken(self, lane: Lane, kind: SocketKind) -> Self {
        match (lane, kind) {
            (Lane::One(i), _) => Self {
                low: Vec4::splat(self.low[usize::from(i)]),
                high: Vec4::splat(self.high[usize::from(i)]),
            },
            (Lane::Rgb, SocketKind::Float) => {
                let gray = |color: Vec4| Vec4::splat(luminance(color.truncate()));
                Self::of([gray(self.low), gray(self.high)])
            }
            (Lane::Xyz, SocketKind::Float) | (Lane::Mean, _) => {
                let mean = |v: Vec4| Vec4::splat(average(v.truncate()));
                Self::of([mean(self.low), mean(self.high)])
            }
            (Lane::Rgb | Lane::Xyz, _) => self,
        }
    }

    /// The only colour that there is.
    pub fn constant(&self) -> Option<[f32; 3]> {
        // 0 has two signs.
        let value = self.high.truncate() + Vec3::ZERO;
        (self.low.truncate() == value && value.is_finite()).then(|| value.to_array())
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.low.truncate().is_finite() && self.high.truncate().is_finite()
    }

    /// The least and the greatest of a number.
    pub fn number(&self) -> (f32, f32) {
        (self.low.x, self.high.x)
    }

    fn clamped(self, clamp: bool) -> Self {
        if !clamp {
            return self;
        }
        Self {
            low: self.low.clamp(Vec4::ZERO, Vec4::ONE),
            high: self.high.clamp(Vec4::ZERO, Vec4::ONE),
        }
    }
}

/// What is known of what a graph reads.
pub trait Facts {
    /// Values of an image as look-ups give them, in those of its four numbers that something takes.
    fn image(&mut self, texture: &Texture, usage: ImageUse, taken: [bool; 4]) -> Range;
    /// Colours of vertices.
    fn colors(&self) -> Range;
    /// What other nodes may give that are not the same everywhere.
    fn varying(&self) -> Range {
        Range::UNKNOWN
    }
    /// Whether a normal map of a strength changes nothing.
    fn is_flat(&mut self, _texture: &Texture, _strength: f32) -> bool {
        false
    }
}

/// Images and vertices may be black or white, and anything between.
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    /// Whether there are vertices that are not opaque.
    pub vertex_alpha: bool,
}

impl Facts for Unit {
    fn image(&mut self, _: &Texture, _: ImageUse, _: [bool; 4]) -> Range {
        Range::SHARE
    }

    fn varying(&self) -> Range {
        Range::SHARE
    }

    fn colors(&self) -> Range {
        let alpha = if self.vertex_alpha { 0.0 } else { 1.0 };
        Range {
            low: Vec3::ZERO.extend(alpha),
            high: Vec4::ONE,
        }
    }
}

/// Three interpolations and two products of numbers up to 1, each of at most two roundings.
const ROUNDINGS: f32 = 10.0 * f32::EPSILON;

fn compared(operation: MathOperation, a: Range, b: Range) -> Range {
    let ((al, ah), (bl, bh)) = (a.number(), b.number());
    let slack = |low: f32, high: f32| if low == high { 0.0 } else { ROUNDINGS };
    let slack = slack(al, ah) + slack(bl, bh);
    // Where roundings cannot turn the answer.
    let (yes, no) = match operation {
        MathOperation::LessThan => (ah + slack < bl, al - slack >= bh),
        _ => (al - slack > bh, ah + slack <= bl),
    };
    match (yes, no) {
        (true, _) => Range::only(Vec4::ONE),
        (_, true) => Range::only(Vec4::ZERO),
        _ => Range::SHARE,
    }
}

fn calculated(operation: MathOperation, a: Range, b: Range) -> Range {
    use MathOperation::{Divide, GreaterThan, LessThan, Power};
    let is_one = |r: Range| r.low.x == r.high.x;
    match operation {
        LessThan | GreaterThan => compared(operation, a, b),
        // Neither grows or falls all the way.
        Divide | Power if !(is_one(a) && is_one(b)) => Range::UNKNOWN,
        _ => {
            let corner = |a: Vec4, b: Vec4| Vec4::splat(operation.of(a.x, b.x));
            Range::of([
                corner(a.low, b.low),
                corner(a.low, b.high),
                corner(a.high, b.low),
                corner(a.high, b.high),
            ])
        }
    }
}

impl Graph {
    /// What may stand in a socket, by the results of the nodes before.
    pub fn range_of(&self, results: &[Range], input: Input, kind: SocketKind) -> Range {
        match input {
            Input::None => Range::UNKNOWN,
            Input::Value(value) => Range::only(Vec3::from(value).extend(1.0)),
            Input::Link(link @ Link { node, .. }) => {
                let (_, lane) = self.gives(link);
                results[node as usize].taken(lane, kind)
            }
        }
    }

    /// What the result of a node may be.
    pub fn result(
        &self,
        (results, taken): (&[Range], &[[bool; 4]]),
        at: usize,
        facts: &mut impl Facts,
    ) -> Range {
        let node = &self.nodes[at];
        let of = |socket: usize| {
            let kind = node.kind.sockets()[socket].kind;
            self.range_of(results, node.inputs[socket], kind)
        };
        match &node.kind {
            NodeKind::ImageTexture { texture, usage, .. } => {
                facts.image(texture, *usage, taken[at])
            }
            NodeKind::TiledImage { .. } => facts.varying(),
            NodeKind::ColorAttribute => facts.colors(),
            NodeKind::SeparateColor => of(separate::COLOR),
            NodeKind::Math { operation, clamp } => {
                calculated(*operation, of(math::A), of(math::B)).clamped(*clamp)
            }
            NodeKind::MixColor { blend } => {
                let (a, b) = (of(mix::A), of(mix::B));
                let factor = of(mix::FACTOR).number();
                let corners = [
                    (a.low, b.low),
                    (a.low, b.high),
                    (a.high, b.low),
                    (a.high, b.high),
                ];
                Range::of(corners.into_iter().flat_map(|(a, b)| {
                    let at = |factor: f32| blend.of(factor, a.truncate(), b.truncate()).extend(1.0);
                    [at(factor.0), at(factor.1)]
                }))
            }
            NodeKind::Function(function) => {
                let known = (0..node.inputs.len()).map(|socket| {
                    let value = of(socket).constant()?;
                    Some(Vec3::from(value).extend(value[0]))
                });
                let known: Vec<Option<Vec4>> = known.collect();
                let inputs: Option<Vec<Vec4>> = known.iter().copied().collect();
                match inputs.and_then(|inputs| function.evaluate(&inputs)) {
                    Some(result) => Range::only(result),
                    None if function.is_annulled(&known) => Range::only(Vec4::ZERO),
                    None => facts.varying(),
                }
            }
            _ => Range::UNKNOWN,
        }
    }

    /// Which of the four numbers of each node's result other nodes take.
    pub fn taken(&self) -> Vec<[bool; 4]> {
        let mut taken = vec![[false; 4]; self.nodes.len()];
        for at in (0..self.nodes.len()).rev() {
            let node = &self.nodes[at];
            let by_node = taken[at];
            for link in node.inputs.iter().filter_map(|input| input.link()) {
                let of = &mut taken[link.node as usize];
                match self.gives(link).1 {
                    Lane::One(i) => of[usize::from(i)] = true,
                    Lane::Rgb | Lane::Xyz | Lane::Mean => {
                        for (i, of) in of[..3].iter_mut().enumerate() {
                            *of |= node.kind != NodeKind::SeparateColor || by_node[i];
                        }
                    }
                }
            }
        }
        taken
    }

    /// What the results of all nodes may be.
    pub fn results(&self, facts: &mut impl Facts) -> Vec<Range> {
        let taken = self.taken();
        let mut results = Vec::with_capacity(self.nodes.len());
        for at in 0..self.nodes.len() {
            let result = self.result((&results, &taken), at, facts);
            results.push(result);
        }
        results
    }
}
