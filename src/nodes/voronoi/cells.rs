//! One octave of Voronoi cells: a lattice of unit cells with a point in each.

use std::marker::PhantomData;

use glam::{Vec2, Vec3, Vec4};

use super::super::{fused, hash, mix, smoothstep, whole};
use super::VoronoiMetric;

/// Cells of one octave in N dimensions, with the hash H.
#[derive(Clone, Copy)]
pub(super) struct Cells<const N: usize, H> {
    /// How far points may be from their cells' lowest corners.
    pub randomness: f32,
    /// How far cells flow into each other, 0 to 0.5.
    pub smoothness: f32,
    pub metric: VoronoiMetric,
    pub exponent: f32,
    pub hash: PhantomData<H>,
}

/// The PCG hashes of whole numbers: Blender 5.0 and later.
#[derive(Clone, Copy)]
pub(super) struct Pcg;

/// lookup3 of the bits of numbers: Blender before 5.0.
#[derive(Clone, Copy)]
pub(super) struct Lookup3;

/// What is found about a point.
#[derive(Clone, Copy)]
pub(super) struct Nearest<const N: usize> {
    pub distance: f32,
    pub color: Vec3,
    pub position: [f32; N],
}

impl<const N: usize> Default for Nearest<N> {
    fn default() -> Self {
        Self {
            distance: 0.0,
            color: Vec3::ZERO,
            position: [0.0; N],
        }
    }
}

/// What a cell has at random, by the hash of its number. `cell` and `offset` are added.
pub(super) trait Cellular<const N: usize> {
    /// The place of its point, 0 to 1 on each axis.
    fn place(cell: [f32; N], offset: [i32; N]) -> [f32; N];

    /// Its colour.
    fn color(cell: [f32; N], offset: [i32; N]) -> Vec3;
}

/// The cell's number as whole numbers.
#[inline(always)]
fn number<const N: usize>(cell: [f32; N], offset: [i32; N]) -> [i32; N] {
    std::array::from_fn(|axis| whole(cell[axis]).wrapping_add(offset[axis]))
}

impl Cellular<1> for Pcg {
    #[inline(always)]
    fn place([cell]: [f32; 1], [offset]: [i32; 1]) -> [f32; 1] {
        [hash::unit_1(cell + offset as f32)]
    }

    #[inline(always)]
    fn color([cell]: [f32; 1], [offset]: [i32; 1]) -> Vec3 {
        hash::color_1(cell + offset as f32)
    }
}

impl Cellular<2> for Pcg {
    #[inline(always)]
    fn place(cell: [f32; 2], offset: [i32; 2]) -> [f32; 2] {
        hash::pcg_2(number(cell, offset))
    }

    #[inline(always)]
    fn color(cell: [f32; 2], offset: [i32; 2]) -> Vec3 {
        let [x, y] = number(cell, offset);
        Vec3::from_array(hash::pcg_3([x, y, 0]))
    }
}

impl Cellular<3> for Pcg {
    #[inline(always)]
    fn place(cell: [f32; 3], offset: [i32; 3]) -> [f32; 3] {
        hash::pcg_3(number(cell, offset))
    }

    #[inline(always)]
    fn color(cell: [f32; 3], offset: [i32; 3]) -> Vec3 {
        Vec3::from_array(hash::pcg_3(number(cell, offset)))
    }
}

impl Cellular<4> for Pcg {
    #[inline(always)]
    fn place(cell: [f32; 4], offset: [i32; 4]) -> [f32; 4] {
        hash::pcg_4(number(cell, offset))
    }

    #[inline(always)]
    fn color(cell: [f32; 4], offset: [i32; 4]) -> Vec3 {
        let [x, y, z, _] = hash::pcg_4(number(cell, offset));
        Vec3::new(x, y, z)
    }
}

/// The cell's number as it is hashed by its bits.
#[inline(always)]
fn corner<const N: usize>(cell: [f32; N], offset: [i32; N]) -> [f32; N] {
    std::array::from_fn(|axis| cell[axis] + offset[axis] as f32)
}

impl Cellular<1> for Lookup3 {
    #[inline(always)]
    fn place(cell: [f32; 1], offset: [i32; 1]) -> [f32; 1] {
        Pcg::place(cell, offset)
    }

    #[inline(always)]
    fn color(cell: [f32; 1], offset: [i32; 1]) -> Vec3 {
        Pcg::color(cell, offset)
    }
}

impl Cellular<2> for Lookup3 {
    #[inline(always)]
    fn place(cell: [f32; 2], offset: [i32; 2]) -> [f32; 2] {
        hash::units_2(corner(cell, offset))
    }

    #[inline(always)]
    fn color(cell: [f32; 2], offset: [i32; 2]) -> Vec3 {
        hash::color_2(Vec2::from_array(corner(cell, offset)))
    }
}

impl Cellular<3> for Lookup3 {
    #[inline(always)]
    fn place(cell: [f32; 3], offset: [i32; 3]) -> [f32; 3] {
        Self::color(cell, offset).to_array()
    }

    #[inline(always)]
    fn color(cell: [f32; 3], offset: [i32; 3]) -> Vec3 {
        hash::color_3(Vec3::from_array(corner(cell, offset)))
    }
}

impl Cellular<4> for Lookup3 {
    #[inline(always)]
    fn place(cell: [f32; 4], offset: [i32; 4]) -> [f32; 4] {
        hash::units_4(corner(cell, offset))
    }

    #[inline(always)]
    fn color(cell: [f32; 4], offset: [i32; 4]) -> Vec3 {
        hash::color_4(Vec4::from_array(corner(cell, offset)))
    }
}

/// The lattice cell in which a point lies, and its place in it.
#[inline(always)]
fn split<const N: usize>(p: [f32; N]) -> ([f32; N], [f32; N]) {
    let cell = p.map(f32::floor);
    (cell, minus(p, cell))
}

#[inline(always)]
fn minus<const N: usize>(a: [f32; N], b: [f32; N]) -> [f32; N] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

#[inline(always)]
fn plus<const N: usize>(a: [f32; N], b: [f32; N]) -> [f32; N] {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

#[inline(always)]
fn dot<const N: usize>(a: [f32; N], b: [f32; N]) -> f32 {
    sum::<N>(std::array::from_fn(|axis| a[axis] * b[axis]))
}

/// In pairs, as the processor's instruction for scalar products adds.
#[inline(always)]
fn sum<const N: usize>(terms: [f32; N]) -> f32 {
    terms
        .chunks(2)
        .map(|pair| pair.iter().copied().reduce(|a, b| a + b).unwrap_or(0.0))
        .reduce(|a, b| a + b)
        .unwrap_or(0.0)
}

/// The cells that are at most `reach` away on every axis, X first: the order decides between equal distances.
struct Around<const N: usize> {
    reach: i32,
    next: Option<[i32; N]>,
}

#[inline(always)]
fn around<const N: usize>(reach: i32) -> Around<N> {
    Around {
        reach,
        next: Some([-reach; N]),
    }
}

impl<const N: usize> Iterator for Around<N> {
    type Item = [i32; N];

    #[inline(always)]
    fn next(&mut self) -> Option<[i32; N]> {
        let offset = self.next?;
        let mut following = offset;
        self.next = None;
        for step in &mut following {
            if *step < self.reach {
                *step += 1;
                self.next = Some(following);
                break;
            }
            *step = -self.reach;
        }
        Some(offset)
    }
}

/// The steps to the 27 cells around in three dimensions, axis by axis, in the order of [`around`].
const OFFSETS: [[i32; 32]; 4] = {
    let mut offsets = [[0; 32]; 4];
    let mut number = 0;
    while number < 32 {
        let mut rest = if number < 27 { number } else { 26 };
        let mut axis = 0;
        while axis < 3 {
            offsets[axis][number] = rest as i32 % 3 - 1;
            rest /= 3;
            axis += 1;
        }
        number += 1;
    }
    offsets
};

fn offset_of<const N: usize>(number: usize) -> [i32; N] {
    std::array::from_fn(|axis| OFFSETS[axis][number])
}

/// The cell of a place and, along each axis, the neighbour on the nearer side.
#[inline(always)]
fn close_by<const N: usize>(place: [f32; N]) -> impl Iterator<Item = [i32; N]> {
    (0..=N).map(move |number| {
        std::array::from_fn(|axis| match place[axis] < 0.5 {
            _ if number != axis + 1 => 0,
            true => -1,
            false => 1,
        })
    })
}

impl<const N: usize, H: Cellular<N>> Cells<N, H> {
    /// The point of a cell, seen from the cell that `offset` counts from.
    #[inline(always)]
    fn point(&self, cell: [f32; N], offset: [i32; N]) -> [f32; N] {
        let place = H::place(cell, offset);
        std::array::from_fn(|axis| {
            let corner = offset[axis] as f32;
            if N == 1 {
                fused(place[axis], self.randomness, corner)
            } else {
                corner + place[axis] * self.randomness
            }
        })
    }

    /// The distance by the metric.
    #[inline(always)]
    pub(super) fn distance(&self, a: [f32; N], b: [f32; N]) -> f32 {
        self.distance_of_key(self.key(a, b))
    }

    /// What grows with the distance, and costs less.
    #[inline(always)]
    fn key(&self, a: [f32; N], b: [f32; N]) -> f32 {
        self.key_of_terms(minus(a, b).map(|x| self.term(x)))
    }

    /// What an axis adds to the key.
    #[inline(always)]
    fn term(&self, difference: f32) -> f32 {
        match self.metric {
            VoronoiMetric::Euclidean if N > 1 => difference * difference,
            VoronoiMetric::Minkowski if N > 1 => difference.abs().powf(self.exponent),
            _ => difference.abs(),
        }
    }

    #[inline(always)]
    fn key_of_terms(&self, terms: [f32; N]) -> f32 {
        if self.metric == VoronoiMetric::Chebychev {
            terms.into_iter().fold(0.0, |a, b| b.max(a))
        } else {
            sum(terms)
        }
    }

    #[inline(always)]
    fn distance_of_key(&self, key: f32) -> f32 {
        match self.metric {
            VoronoiMetric::Euclidean if N > 1 => key.sqrt(),
            VoronoiMetric::Minkowski if N > 1 => key.powf(1.0 / self.exponent),
            _ => key,
        }
    }

    /// The same cells, measured by the straight line.
    fn straight(&self) -> Self {
        Self {
            metric: VoronoiMetric::Euclidean,
            hash: PhantomData,
            ..*self
        }
    }

    /// How near the points of the cells around `middle` can be to a place.
    #[inline(always)]
    fn bounds(&self, place: [f32; N], middle: [i32; N], reach: i32) -> Bounds<N> {
        let mut terms = [[0.0; STEPS]; N];
        // The power is neither exactly monotonic nor, with an exponent that is not positive, a growing one.
        let (margin, grows) = match self.metric {
            VoronoiMetric::Minkowski => (0.9999, self.exponent > 0.0),
            _ => (1.0, true),
        };
        if grows {
            for (axis, terms) in terms.iter_mut().enumerate() {
                for step in -reach..=reach {
                    let corner = (middle[axis] + step) as f32;
                    let below = corner - place[axis];
                    let above = place[axis] - (corner + self.randomness);
                    let gap = below.max(above).max(0.0);
                    terms[index(step)] = self.term(gap) * margin;
                }
            }
        }
        Bounds(terms)
    }

    /// The two least keys of a few points that are probably near: as bounds they spare most of the others.
    #[inline(always)]
    fn near(&self, cell: [f32; N], local: [f32; N]) -> [f32; 2] {
        let [mut first, mut second] = [f32::MAX; 2];
        for offset in close_by(local) {
            let key = self.key(self.point(cell, offset), local);
            second = second.min(key.max(first));
            first = first.min(key);
        }
        [first, second]
    }

    /// F1: the nearest point.
    #[inline(always)]
    pub(super) fn nearest(&self, p: [f32; N]) -> Nearest<N> {
        let (cell, local) = split(p);
        let (_, offset, point) = self.least(cell, local);
        Nearest {
            distance: self.distance(point, local),
            color: H::color(cell, offset),
            position: plus(point, cell),
        }
    }

    /// The nearest point: its key, cell and place.
    #[inline(always)]
    fn least(&self, cell: [f32; N], local: [f32; N]) -> (f32, [i32; N], [f32; N]) {
        // Powers are no vectors, few cells fill none, and of many cells most are too far.
        if N == 3 && self.metric != VoronoiMetric::Minkowski {
            self.least_of_all(cell, local)
        } else {
            self.least_within_bounds(cell, local)
        }
    }

    /// Cell by cell, without those that are too far.
    #[inline(always)]
    fn least_within_bounds(&self, cell: [f32; N], local: [f32; N]) -> (f32, [i32; N], [f32; N]) {
        let bounds = self.bounds(local, [0; N], 1);
        let [near, _] = self.near(cell, local);
        let mut found = (f32::MAX, [0; N], [0.0; N]);
        for offset in around(1) {
            let bound = bounds.key(self, offset);
            if bound > near || bound >= found.0 {
                continue;
            }
            let point = self.point(cell, offset);
            let key = self.key(point, local);
            if key < found.0 {
                found = (key, offset, point);
            }
        }
        found
    }

    /// By the keys of all cells at once, which the compiler computes in vectors.
    #[inline(always)]
    fn least_of_all(&self, cell: [f32; N], local: [f32; N]) -> (f32, [i32; N], [f32; N]) {
        let keys = match self.metric {
            VoronoiMetric::Chebychev => self.keys(cell, local, VoronoiMetric::Chebychev),
            VoronoiMetric::Manhattan => self.keys(cell, local, VoronoiMetric::Manhattan),
            _ => self.keys(cell, local, VoronoiMetric::Euclidean),
        };
        // Numbers from 0 on are in the order of their bits, and NaN comes after them.
        let keys = keys.map(f32::to_bits);
        let least = keys.iter().fold(f32::MAX.to_bits(), |a, b| a.min(*b));
        let none = keys.len() as u32;
        let first = (0..none)
            .zip(keys)
            .map(|(number, key)| if key == least { number } else { none })
            .fold(none, u32::min);
        if first == none {
            return (f32::MAX, [0; N], [0.0; N]);
        }
        let offset = offset_of(first as usize);
        (f32::from_bits(least), offset, self.point(cell, offset))
    }

    /// The keys of the 27 cells around, with as many again of the last one as fill up vectors.
    #[inline(always)]
    fn keys(&self, cell: [f32; N], local: [f32; N], metric: VoronoiMetric) -> [f32; 32] {
        let cells = Self {
            metric,
            hash: PhantomData,
            ..*self
        };
        let mut keys = [0.0; 32];
        for (number, key) in keys.iter_mut().enumerate() {
            let offset = std::array::from_fn(|axis| OFFSETS[axis][number]);
            *key = cells.key(cells.point(cell, offset), local);
        }
        keys
    }

    /// F2: the second nearest point.
    #[inline(always)]
    pub(super) fn second_nearest(&self, p: [f32; N]) -> Nearest<N> {
        let (cell, local) = split(p);
        let bounds = self.bounds(local, [0; N], 1);
        let [_, near] = self.near(cell, local);
        let mut first = (f32::MAX, [0; N], [0.0; N]);
        let mut second = first;
        for offset in around(1) {
            if bounds.key(self, offset) > near {
                continue;
            }
            let point = self.point(cell, offset);
            let distance = self.distance(point, local);
            if distance < first.0 {
                second = first;
                first = (distance, offset, point);
            } else if distance < second.0 {
                second = (distance, offset, point);
            }
        }
        let (distance, offset, point) = second;
        Nearest {
            distance,
            color: H::color(cell, offset),
            position: plus(point, cell),
        }
    }

    /// F1 by a smooth minimum over two cells in each direction.
    #[inline(always)]
    pub(super) fn smooth(&self, p: [f32; N]) -> Nearest<N> {
        let (cell, local) = split(p);
        let bounds = self.bounds(local, [0; N], 2);
        let smoothness = self.smoothness;
        let mut result = Nearest::default();
        let mut first = true;
        for offset in around(2) {
            let share = |result: &Nearest<N>, distance: f32| {
                smoothstep(0.5 + 0.5 * (result.distance - distance) / smoothness)
            };
            // A share of nothing changes nothing, and grows with nearness.
            if !first && share(&result, self.distance_of_key(bounds.key(self, offset))) == 0.0 {
                continue;
            }
            let point = self.point(cell, offset);
            let distance = self.distance(point, local);
            let share = if first { 1.0 } else { share(&result, distance) };
            first = false;
            let correction = smoothness * share * (1.0 - share);
            result.distance =
                fused(share, distance - result.distance, result.distance) - correction;
            let correction = correction / (1.0 + 3.0 * smoothness);
            result.color = mix(result.color, H::color(cell, offset), share) - correction;
            for (mixed, new) in result.position.iter_mut().zip(point) {
                *mixed = mix(*mixed, new, share) - correction;
            }
        }
        result.position = plus(cell, result.position);
        result
    }

    /// The distance to the nearest edge between cells.
    #[inline(always)]
    pub(super) fn distance_to_edge(&self, p: [f32; N]) -> f32 {
        // Squared distance below which two points are one.
        const SAME: f32 = 0.0001;
        // More than rounding can make of a distance.
        const MARGIN: f32 = 0.001;
        let (cell, local) = split(p);
        if N == 1 {
            // Here edges are taken from the point of this cell, be it the nearest or not.
            let middle = self.point(cell, [0; N])[0];
            let edge = |step: i32| (middle + self.point(cell, [step; N])[0]) / 2.0;
            return (edge(-1) - local[0]).abs().min((edge(1) - local[0]).abs());
        }
        let straight = self.straight();
        let (_, _, closest) = straight.least(cell, local);
        let closest = minus(closest, local);
        let radius = dot(closest, closest).sqrt();
        let edge = |offset: [i32; N]| {
            let to_point = minus(self.point(cell, offset), local);
            let across = minus(to_point, closest);
            let length_squared = dot(across, across);
            if length_squared > SAME {
                let middle = plus(closest, to_point).map(|x| x / 2.0);
                let length = length_squared.sqrt();
                dot(middle, across.map(|x| x / length))
            } else {
                f32::MAX
            }
        };
        let mut distance = f32::MAX;
        for offset in close_by(local) {
            distance = distance.min(edge(offset));
        }
        let bounds = straight.bounds(local, [0; N], 1);
        for offset in around(1) {
            // By the triangle's inequality, an edge is at least half as far as its point is farther than the closest.
            let farther = bounds.key(&straight, offset).sqrt() - radius;
            if 0.5 * farther <= distance + MARGIN {
                distance = distance.min(edge(offset));
            }
        }
        distance
    }

    /// Half the distance from the nearest point to the point nearest to it.
    #[inline(always)]
    pub(super) fn sphere_radius(&self, p: [f32; N]) -> f32 {
        let (cell, local) = split(p);
        let straight = self.straight();
        let (_, from, closest) = straight.least(cell, local);
        let bounds = straight.bounds(closest, from, 1);
        let mut least = f32::MAX;
        let mut neighbour = [0.0; N];
        let place = std::array::from_fn(|axis| closest[axis] - from[axis] as f32);
        for step in close_by(place).chain(around(1)) {
            if step == [0; N] || bounds.key(&straight, step) >= least {
                continue;
            }
            let offset = std::array::from_fn(|axis| step[axis] + from[axis]);
            let point = self.point(cell, offset);
            let key = straight.key(closest, point);
            if key < least {
                least = key;
                neighbour = point;
            }
        }
        straight.distance(neighbour, closest) / 2.0
    }
}

/// Room for bounds on each axis: two in each direction, made up to a power of two.
const STEPS: usize = 8;

#[inline(always)]
fn index(step: i32) -> usize {
    (step + 2) as usize % STEPS
}

/// The least that each axis adds to a distance's key, by the step along it. What these say is too far is not looked into:
/// the hash of a cell costs more than its bound. Differences, terms and sums are those of the keys and monotonic even as
/// rounded, so that no cell is passed over that would have counted.
struct Bounds<const N: usize>([[f32; STEPS]; N]);

impl<const N: usize> Bounds<N> {
    /// The least key of a point in this cell.
    #[inline(always)]
    fn key<H: Cellular<N>>(&self, cells: &Cells<N, H>, offset: [i32; N]) -> f32 {
        cells.key_of_terms(std::array::from_fn(|axis| {
            self.0[axis][index(offset[axis])]
        }))
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/nodes/voronoi/cells.rs"]
mod tests;
