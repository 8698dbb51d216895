//! Media that vary: null scattering below bounds of their extinction.
//!
//! The bounds come from points, so that between those a medium may be denser than its bound. The weights stay those of an unbiased
//! estimate there, as null collisions may count negatively: Kutz, Habel, Li and Novák, *Spectral and Decomposition Tracking for
//! Rendering Heterogeneous Volumes*, 2017, section 5; Georgiev et al., *Integral formulations of volumetric transmittance*, 2019.

use super::Flight;
use crate::math::average;
use glam::{IVec3, Vec3};
use rayon::prelude::*;

/// What light meets over a metre at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Local {
    /// What is taken or scattered, 1/m.
    pub extinction: Vec3,
    /// What is scattered, 1/m.
    pub scattering: Vec3,
    /// Radiance that is added, W·sr⁻¹·m⁻³.
    pub emission: Vec3,
}

impl Local {
    /// Whether what it emits is asked for. Where nothing else is, light that it takes away is nothing, as in Cycles, whose bounds are of
    /// extinction and of emission above 0.
    pub fn is_asked_for(&self) -> bool {
        let is_alone = self.extinction.max_element() <= 0.0;
        self.emission.max_element() > 0.0 || !is_alone && self.emission != Vec3::ZERO
    }
}

/// Points in each cell by whose extinction it is bounded: two on each axis.
const POINTS: u32 = 2;
/// What a cell is bounded by: so much of the greatest at its own points and at those of its neighbours. In clouds of noise bounds
/// are exceeded seldom so (and raised on the way), and paths meet fewer events that are none.
const OF_OWN: f32 = 1.25;
const OF_NEIGHBOURS: f32 = 0.5;
/// A cell without extinction at its points and those of its neighbours has so much of the greatest bound: what lies between the
/// points is found, too.
const LEAST_SHARE: f32 = 1.0 / 64.0;
/// So many events on the way through a cell are enough for that, however wide the cell is. And so many on the way through a box of
/// what emits and takes little: there its emission is asked for.
const EVENTS: f32 = 8.0;

/// Steps from cell to cell that take as long as to ask for what is at a place, about: 100 instructions, and 1,000 of a noise texture.
const STEPS_OF_PLACE: f32 = 12.0;

/// Bounds of a medium's extinction in the cells of a box.
#[derive(Clone, Debug)]
pub struct Majorants {
    /// The planes between cells, by axis: one more than there are cells.
    planes: [Box<[f32]>; 3],
    values: Vec<f32>,
}

/// Planes at even distances.
pub fn even(low: Vec3, high: Vec3, count: u32) -> [Box<[f32]>; 3] {
    [0, 1, 2].map(|axis| {
        // Points on the box's faces lie in it, however they are rounded.
        let size = high[axis] - low[axis];
        let margin = (low[axis].abs().max(high[axis].abs()) * 4.0 * f32::EPSILON)
            .max(size * f32::EPSILON)
            .max(f32::MIN_POSITIVE);
        let (low, size) = (low[axis] - margin, size + 2.0 * margin);
        let plane = |i: u32| low + size * (i as f32 / count as f32);
        (0..=count).map(plane).collect()
    })
}

/// The same in a box, and about it more of them, each cell twice as wide as the one before, as far as `reach`.
pub fn widening(low: Vec3, high: Vec3, count: u32, reach: f32) -> [Box<[f32]>; 3] {
    even(low, high, count).map(|inner| {
        let (Some(first), Some(last)) = (inner.first().copied(), inner.last().copied()) else {
            return inner;
        };
        let width = (last - first) / count as f32;
        let outwards = |end: f32, sign: f32, far: f32| {
            let mut planes = Vec::new();
            let (mut at, mut step) = (end, width);
            while (far - at) * sign > 0.0 {
                // A step that rounding swallows is none.
                step = (2.0 * step).max(at.abs() * 1e-3);
                at = if (far - (at + sign * step)) * sign > 0.0 {
                    at + sign * step
                } else {
                    far
                };
                planes.push(at);
            }
            planes
        };
        let mut planes = outwards(first, -1.0, -reach);
        planes.reverse();
        planes.extend_from_slice(&inner);
        planes.extend(outwards(last, 1.0, reach));
        planes.into()
    })
}

/// What is known of a medium in a box.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bound {
    /// The greatest extinction that was found.
    pub extinction: f32,
    /// Whether it shines.
    pub emits: bool,
    /// It depends on what was looked at alone: its neighbours say nothing of it …
    pub by_range: bool,
    /// … and it is the same everywhere in it.
    pub settled: bool,
}

impl Majorants {
    /// Asks for what is at points of each cell between planes, and for what is known of all of it. Beyond them there is nothing.
    pub fn new(
        planes: [Box<[f32]>; 3],
        local: impl Fn(Vec3) -> Local + Sync,
        range: impl Fn(Vec3, Vec3) -> Option<Bound> + Sync,
    ) -> Self {
        let made = Self {
            planes,
            values: Vec::new(),
        };
        let (low, high) = made.corners();
        let rate = EVENTS / (high - low).length();
        let count = made.count();
        let cells = count.element_product();
        let bound_at = |number: i32| {
            let cell = made.cell(number as usize);
            let (corner, opposite) = (made.plane(cell), made.plane(cell + 1));
            let known = range(corner, opposite);
            if let Some(known) = known.filter(|known| known.settled) {
                return known;
            }
            let mut bound = known.unwrap_or_default();
            for point in 0..POINTS.pow(3) {
                let bits = [
                    point % POINTS,
                    point / POINTS % POINTS,
                    point / POINTS / POINTS,
                ];
                // Each cell's points lie otherwise in it, so that no lattice of the medium hides between them.
                let turned = |axis: u32| {
                    let n = u64::from(number as u32) * 24 + u64::from(point * 3 + axis);
                    let turn = (n as f64 * 0.618_033_988_749_894_9).fract() as f32;
                    (bits[axis as usize] as f32 + turn) / POINTS as f32
                };
                let within = Vec3::new(turned(0), turned(1), turned(2));
                let local = local(corner + within * (opposite - corner));
                let extinction = local.extinction.max_element();
                // What is no number bounds nothing; the path meets it, and it is counted there.
                if extinction.is_finite() {
                    bound.extinction = bound.extinction.max(extinction);
                }
                bound.emits |= local.is_asked_for();
            }
            bound
        };
        let found: Vec<Bound> = (0..cells).into_par_iter().map(bound_at).collect();
        let greatest = found
            .iter()
            .map(|found| found.extinction)
            .fold(0.0, f32::max);
        let emits = found.iter().any(|found| found.emits);
        let with_neighbours = |number: i32| {
            let own = found[number as usize];
            if own.settled {
                return own.extinction.max(if own.emits { rate } else { 0.0 });
            }
            let at = made.cell(number as usize);
            let across = (made.plane(at + 1) - made.plane(at)).length();
            let floor = (greatest * LEAST_SHARE).min(EVENTS / across);
            let floor = floor.max(if emits { rate } else { 0.0 });
            if own.by_range {
                return own.extinction.max(floor);
            }
            let (from, to) = ((at - 1).max(IVec3::ZERO), (at + 1).min(count - 1));
            let mut around = 0.0f32;
            for z in from.z..=to.z {
                for y in from.y..=to.y {
                    for x in from.x..=to.x {
                        around = around.max(found[made.number(IVec3::new(x, y, z))].extinction);
                    }
                }
            }
            (own.extinction * OF_OWN)
                .max(around * OF_NEIGHBOURS)
                .max(floor)
        };
        let values = (0..cells).into_par_iter().map(with_neighbours).collect();
        Self { values, ..made }.merged()
    }

    /// What a way through the box takes, about, in steps from cell to cell: those, and places that are asked for.
    fn cost(&self) -> f32 {
        let count = self.count();
        let across = |cell: IVec3| self.plane(cell + 1) - self.plane(cell);
        let depths = self.values.iter().enumerate();
        let depths =
            depths.map(|(number, value)| value * across(self.cell(number)).dot(count.as_vec3()));
        let depth = depths.sum::<f32>() / self.values.len() as f32;
        count.element_sum() as f32 + STEPS_OF_PLACE * depth
    }

    /// The same with fewer cells where that makes ways through it cheaper: what is much the same all over needs few.
    fn merged(mut self) -> Self {
        let mut cost = self.cost();
        loop {
            let halves = (0..3).filter_map(|axis| self.halved(axis));
            let costs = halves.map(|made| (made.cost(), made));
            match costs.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((less, made)) if less < cost => (cost, self) = (less, made),
                _ => return self,
            }
        }
    }

    /// Two cells in the place of one along an axis, bounded by the greater bound of both.
    fn halved(&self, axis: usize) -> Option<Self> {
        let count = self.count();
        let last = count[axis] as usize;
        if last < 2 {
            return None;
        }
        let mut planes = self.planes.clone();
        let kept = (0..=last).filter(|&i| i % 2 == 0 || i == last);
        planes[axis] = kept.map(|i| self.planes[axis][i]).collect();
        let mut made = Self {
            planes,
            values: Vec::new(),
        };
        made.values = vec![0.0; made.count().element_product() as usize];
        for (number, value) in self.values.iter().enumerate() {
            let mut cell = self.cell(number);
            cell[axis] /= 2;
            let number = made.number(cell);
            let bound = &mut made.values[number];
            *bound = bound.max(*value);
        }
        Some(made)
    }

    /// The cell of a number.
    fn cell(&self, number: usize) -> IVec3 {
        let (at, count) = (number as i32, self.count());
        IVec3::new(at % count.x, at / count.x % count.y, at / count.x / count.y)
    }

    fn count(&self) -> IVec3 {
        IVec3::from(self.planes.each_ref().map(|planes| planes.len() as i32 - 1))
    }

    fn number(&self, cell: IVec3) -> usize {
        let count = self.count();
        ((cell.z * count.y + cell.y) * count.x + cell.x) as usize
    }

    /// The corner of a cell.
    fn plane(&self, cell: IVec3) -> Vec3 {
        let [x, y, z] = &self.planes;
        Vec3::new(x[cell.x as usize], y[cell.y as usize], z[cell.z as usize])
    }

    fn corners(&self) -> (Vec3, Vec3) {
        (self.plane(IVec3::ZERO), self.plane(self.count()))
    }

    /// The bounds along a ray from a distance on.
    pub fn along(&self, origin: Vec3, direction: Vec3, from: f32) -> March<'_> {
        let inverse = direction.recip();
        let (low, high) = self.corners();
        let (a, b) = ((low - origin) * inverse, (high - origin) * inverse);
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if origin[axis] < low[axis] || origin[axis] > high[axis] {
                    near = f32::INFINITY;
                }
            } else {
                near = near.max(a[axis].min(b[axis]));
                far = far.min(a[axis].max(b[axis]));
            }
        }
        let ahead = direction.to_array().map(|d| d > 0.0);
        let count = self.count().to_array();
        let strides = [1, count[0], count[0] * count[1]];
        let mut march = March {
            grid: self,
            ray: (origin, direction),
            inverse: inverse.to_array(),
            ahead,
            strides: [0, 1, 2].map(|axis| {
                if ahead[axis] {
                    strides[axis]
                } else {
                    -strides[axis]
                }
            }),
            leaves: far,
            cell: [0; 3],
            number: 0,
            next: [f32::INFINITY; 3],
            end: from,
            majorant: 0.0,
            inside: false,
        };
        if near >= far || far <= from {
            march.end = f32::INFINITY;
        } else if near > from {
            march.end = near;
        } else {
            march.enter(from);
        }
        march
    }
}

/// A way through the cells of [`Majorants`].
#[derive(Clone, Debug)]
pub struct March<'a> {
    grid: &'a Majorants,
    ray: (Vec3, Vec3),
    /// One over the direction.
    inverse: [f32; 3],
    /// Whether it goes up along each axis, and how far the next cell's number is from this one's.
    ahead: [bool; 3],
    strides: [i32; 3],
    /// Where it leaves the box.
    leaves: f32,
    cell: [i32; 3],
    number: i32,
    /// Where it leaves the cell, by axis.
    next: [f32; 3],
    /// How far the bound holds.
    end: f32,
    /// The bound.
    majorant: f32,
    inside: bool,
}

impl March<'_> {
    fn enter(&mut self, at: f32) {
        let (origin, direction) = self.ray;
        let (grid, point) = (self.grid, origin + direction * at);
        for axis in 0..3 {
            let planes = &grid.planes[axis];
            let below = planes.partition_point(|&plane| plane <= point[axis]);
            self.cell[axis] = below.clamp(1, planes.len() - 1) as i32 - 1;
        }
        self.number = grid.number(IVec3::from(self.cell)) as i32;
        for axis in 0..3 {
            self.next[axis] = self.crossing(axis);
        }
        self.inside = true;
        self.settle(at);
    }

    /// Where the ray leaves its cell along an axis.
    #[inline]
    fn crossing(&self, axis: usize) -> f32 {
        if self.inverse[axis].is_infinite() {
            return f32::INFINITY;
        }
        let side = self.cell[axis] + i32::from(self.ahead[axis]);
        (self.grid.planes[axis][side as usize] - self.ray.0[axis]) * self.inverse[axis]
    }

    #[inline]
    fn settle(&mut self, at: f32) {
        self.majorant = self.grid.values[self.number as usize];
        let [x, y, z] = self.next;
        self.end = x.min(y).min(z).min(self.leaves).max(at);
    }

    /// Goes on to what lies behind the end of this bound.
    #[inline]
    fn advance(&mut self) {
        let at = self.end;
        if !self.inside {
            self.enter(at);
            return;
        }
        let [x, y, z] = self.next;
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        let step = if self.ahead[axis] { 1 } else { -1 };
        self.cell[axis] += step;
        let is_out =
            self.cell[axis] < 0 || self.cell[axis] as usize + 1 >= self.grid.planes[axis].len();
        if is_out || at >= self.leaves {
            (self.majorant, self.end) = (0.0, f32::INFINITY);
            return;
        }
        self.number += self.strides[axis];
        self.next[axis] = self.crossing(axis);
        self.settle(at);
    }
}

/// After so many collisions below one bound light has but channels that meet far less than the bound says: a quarter of it is their
/// bound from there on. Else what is thick for blue light alone takes a collision a free path of blue light, on the whole way.
pub(super) const MOST_COLLISIONS: u32 = 4096;

/// Bounds that hold up to a distance along a ray.
pub(super) trait Bounds {
    /// Their sum.
    fn majorant(&self) -> f32;
    /// How far all of them hold.
    fn end(&self) -> f32;
    /// Those that hold to there go on.
    fn advance_from(&mut self, end: f32);
}

impl Bounds for March<'_> {
    #[inline(always)]
    fn majorant(&self) -> f32 {
        self.majorant
    }

    #[inline(always)]
    fn end(&self) -> f32 {
        self.end
    }

    #[inline(always)]
    fn advance_from(&mut self, _: f32) {
        self.advance();
    }
}

impl Bounds for [March<'_>] {
    fn majorant(&self) -> f32 {
        self.iter().map(|march| march.majorant).sum()
    }

    fn end(&self) -> f32 {
        self.iter()
            .map(|march| march.end)
            .fold(f32::INFINITY, f32::min)
    }

    fn advance_from(&mut self, end: f32) {
        for march in self.iter_mut().filter(|march| march.end <= end) {
            march.advance();
        }
    }
}

/// Calls for each collision with the sum of some bounds between two distances, until one gives something. An event tells the extinction
/// there, too: where that exceeds the bound, it is the bound from there on. Weights beyond a bound would grow from collision to collision.
#[inline(always)]
fn collide<T>(
    marches: &mut [March<'_>],
    even: f32,
    span: (f32, f32),
    draw: impl FnMut() -> f32,
    event: impl FnMut(f32, f32) -> (Option<T>, f32),
) -> Option<T> {
    // Most often there is one: from cell to cell it needs no loops over all of them.
    match marches {
        [one] => collide_below(one, even, span, draw, event),
        _ => collide_below(marches, even, span, draw, event),
    }
}

/// [`collide`] for one kind of bounds.
fn collide_below<T, B: Bounds + ?Sized>(
    bounds: &mut B,
    even: f32,
    (from, to): (f32, f32),
    mut draw: impl FnMut() -> f32,
    mut event: impl FnMut(f32, f32) -> (Option<T>, f32),
) -> Option<T> {
    let mut depth = || -(-draw()).ln_1p();
    let mut raised = 1.0f32;
    // In f64: free paths may be below the rounding of an f32.
    let (mut t, mut left) = (f64::from(from), depth());
    loop {
        let mut majorant = raised * bounds.majorant() + even;
        let whole = majorant;
        let mut collisions = 0;
        let end = bounds.end().min(to);
        let ahead = |t: f64, majorant: f32| f64::from(majorant) * (f64::from(end) - t);
        // All collisions below these bounds.
        while majorant > 0.0 && ahead(t, majorant) > f64::from(left) {
            t += f64::from(left) / f64::from(majorant);
            let (found, met) = event(t as f32, majorant);
            if found.is_some() {
                return found;
            }
            left = depth();
            collisions += 1;
            if met > majorant {
                // Weights grow from twice the bound on. Where one bound is so wrong, the next ones are, too.
                if met > 2.0 * whole {
                    raised *= met / whole;
                }
                majorant = whole.max(met);
            } else if collisions % MOST_COLLISIONS == 0 {
                majorant *= 0.25;
            }
        }
        if majorant > 0.0 {
            left -= ahead(t, majorant) as f32;
        }
        t = f64::from(end);
        if end >= to || end == f32::INFINITY {
            return None;
        }
        bounds.advance_from(end);
    }
}

/// Below this share of what came in, light ends by roulette.
const FAINT: f32 = 1.0 / 16.0;

/// Ends faint light by roulette: what is left of a weight; zero where it ends.
pub(super) fn survivor(weight: Vec3, faint: Vec3, draw: impl FnOnce() -> f32) -> Vec3 {
    let left = faint.abs().max_element();
    if left >= FAINT {
        return weight;
    }
    let stays = left / FAINT;
    if draw() < stays {
        weight / stays
    } else {
        Vec3::ZERO
    }
}

/// The most that a channel meets that has light; 0 where that is not finite, which bounds nothing.
#[inline]
pub(super) fn met(extinction: Vec3, light: Vec3) -> f32 {
    let most = Vec3::select(light.cmpne(Vec3::ZERO), extinction, Vec3::ZERO).max_element();
    if most < f32::INFINITY { most } else { 0.0 }
}

/// Where light of a throughput is scattered between two distances, with the weight of that, and what the way adds to it.
/// `scatters`: whether it may be.
pub fn fly(
    marches: &mut [March<'_>],
    even: f32,
    span: (f32, f32),
    (throughput, scatters): (Vec3, bool),
    mut draw: impl FnMut() -> f32,
    mut local: impl FnMut(f32) -> Local,
) -> (Flight, Vec3) {
    let (mut weight, mut emitted) = (Vec3::ONE, Vec3::ZERO);
    let draw = std::cell::RefCell::new(&mut draw);
    let next = || (draw.borrow_mut())();
    let found = collide(marches, even, span, next, |t, majorant| {
        let local = local(t);
        emitted += weight * local.emission / majorant;
        let null = (Vec3::splat(majorant) - local.extinction) / majorant;
        let light = throughput * weight;
        let scattered = if scatters {
            local.scattering / majorant
        } else {
            Vec3::ZERO
        };
        let (s, n) = (
            average((light * scattered).abs()),
            average((light * null).abs()),
        );
        if s + n <= 0.0 {
            weight = Vec3::ZERO;
            return (Some(None), 0.0);
        }
        let share = s / (s + n);
        if share > 0.0 && next() < share {
            weight *= scattered / share;
            return (Some(Some(t)), 0.0);
        }
        weight *= null / (1.0 - share);
        weight = survivor(weight, weight, next);
        let met = met(local.extinction, weight);
        ((weight == Vec3::ZERO).then_some(None), met)
    });
    let flight = match found.flatten() {
        Some(t) => Flight::Scattered(t, weight),
        None => Flight::Through(weight),
    };
    (flight, emitted)
}

/// What a whole way through media does to light: where it may be scattered, with what all places weigh together there, and the share
/// that comes through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathered {
    /// A place, with the weight of light that is scattered there, in the place of all of them; none where nothing is.
    pub scattered: Option<(f32, Vec3)>,
    /// What comes through.
    pub through: Vec3,
    /// What the way adds.
    pub emitted: Vec3,
}

/// Asks for what is at distances along a way.
pub trait Places {
    /// What is there.
    fn local(&mut self, t: f32) -> Local;
    /// The last one that was asked for is where light is scattered, so far.
    fn keep(&mut self);
}

/// Goes the whole way, wherever light of a throughput is scattered: each collision is a place where it may be, and one of them is drawn
/// by how much (as Xu et al., *Volume Scattering Probability Guiding*, 2024, collect theirs).
pub fn gather(
    marches: &mut [March<'_>],
    even: f32,
    span: (f32, f32),
    throughput: Vec3,
    mut draw: impl FnMut() -> f32,
    places: &mut impl Places,
) -> Gathered {
    let (mut through, mut emitted) = (Vec3::ONE, Vec3::ZERO);
    let (mut scattered, mut all) = (None, 0.0f32);
    let draw = std::cell::RefCell::new(&mut draw);
    let next = || (draw.borrow_mut())();
    collide(marches, even, span, next, |t, majorant| {
        let local = places.local(t);
        emitted += through * local.emission / majorant;
        let here = through * local.scattering / majorant;
        let worth = average((throughput * here).abs());
        if worth > 0.0 {
            all += worth;
            if scattered.is_none() || next() * all < worth {
                scattered = Some((t, here / worth));
                places.keep();
            }
        }
        through *= (Vec3::splat(majorant) - local.extinction) / majorant;
        through = survivor(through, through, next);
        let met = met(local.extinction, through);
        ((through == Vec3::ZERO).then_some(()), met)
    });
    Gathered {
        scattered: scattered.map(|(t, unit)| (t, unit * all)),
        through,
        emitted,
    }
}

#[cfg(test)]
#[path = "../../tests/unit/medium/tracking.rs"]
mod tests;
