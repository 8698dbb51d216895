//! One octave of Voronoi cells: a lattice of unit cells with a point in each.

use glam::Vec3;

use super::super::{fused, hash, mix, smoothstep, whole};
use super::VoronoiMetric;

/// Cells of one octave in N dimensions.
#[derive(Clone, Copy)]
pub(super) struct Cells<const N: usize> {
    /// How far points may be from their cells' lowest corners.
    pub randomness: f32,
    /// How far cells flow into each other, 0 to 0.5.
    pub smoothness: f32,
    pub metric: VoronoiMetric,
    pub exponent: f32,
}

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

impl Cellular<1> for Cells<1> {
    #[inline(always)]
    fn place([cell]: [f32; 1], [offset]: [i32; 1]) -> [f32; 1] {
        [hash::unit_1(cell + offset as f32)]
    }

    #[inline(always)]
    fn color([cell]: [f32; 1], [offset]: [i32; 1]) -> Vec3 {
        hash::color_1(cell + offset as f32)
    }
}

impl Cellular<2> for Cells<2> {
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

impl Cellular<3> for Cells<3> {
    #[inline(always)]
    fn place(cell: [f32; 3], offset: [i32; 3]) -> [f32; 3] {
        hash::pcg_3(number(cell, offset))
    }

    #[inline(always)]
    fn color(cell: [f32; 3], offset: [i32; 3]) -> Vec3 {
        Vec3::from_array(hash::pcg_3(number(cell, offset)))
    }
}

impl Cellular<4> for Cells<4> {
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

/// Calls for each cell that is at most `reach` away on every axis, X first: the order decides between equal distances.
#[inline(always)]
fn around<const N: usize>(reach: i32, mut visit: impl FnMut([i32; N])) {
    let mut offset = [-reach; N];
    loop {
        visit(offset);
        let Some(axis) = offset.iter().position(|step| *step < reach) else {
            return;
        };
        offset[axis] += 1;
        offset[..axis].fill(-reach);
    }
}

impl<const N: usize> Cells<N>
where
    Self: Cellular<N>,
{
    /// The point of a cell, seen from the cell that `offset` counts from.
    #[inline(always)]
    fn point(&self, cell: [f32; N], offset: [i32; N]) -> [f32; N] {
        let place = Self::place(cell, offset);
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
        let key = self.distance_key(a, b);
        if N == 1 {
            return key;
        }
        match self.metric {
            VoronoiMetric::Euclidean => key.sqrt(),
            VoronoiMetric::Manhattan | VoronoiMetric::Chebychev => key,
            VoronoiMetric::Minkowski => key.powf(1.0 / self.exponent),
        }
    }

    /// What grows with the distance, and costs less.
    #[inline(always)]
    fn distance_key(&self, a: [f32; N], b: [f32; N]) -> f32 {
        let difference = minus(a, b);
        if N == 1 {
            return difference[0].abs();
        }
        match self.metric {
            VoronoiMetric::Euclidean => dot(difference, difference),
            VoronoiMetric::Manhattan => sum(difference.map(f32::abs)),
            VoronoiMetric::Chebychev => difference.into_iter().fold(0.0, |a, b| b.abs().max(a)),
            VoronoiMetric::Minkowski => sum(difference.map(|x| x.abs().powf(self.exponent))),
        }
    }

    /// F1: the nearest point.
    pub(super) fn nearest(&self, p: [f32; N]) -> Nearest<N> {
        let (cell, local) = split(p);
        let mut least = f32::MAX;
        let mut found = ([0; N], [0.0; N]);
        around(1, |offset| {
            let point = self.point(cell, offset);
            let key = self.distance_key(point, local);
            if key < least {
                least = key;
                found = (offset, point);
            }
        });
        let (offset, point) = found;
        Nearest {
            distance: self.distance(point, local),
            color: Self::color(cell, offset),
            position: plus(point, cell),
        }
    }

    /// F2: the second nearest point.
    pub(super) fn second_nearest(&self, p: [f32; N]) -> Nearest<N> {
        let (cell, local) = split(p);
        let mut first = (f32::MAX, [0; N], [0.0; N]);
        let mut second = first;
        around(1, |offset| {
            let point = self.point(cell, offset);
            let distance = self.distance(point, local);
            if distance < first.0 {
                second = first;
                first = (distance, offset, point);
            } else if distance < second.0 {
                second = (distance, offset, point);
            }
        });
        let (distance, offset, point) = second;
        Nearest {
            distance,
            color: Self::color(cell, offset),
            position: plus(point, cell),
        }
    }

    /// F1 by a smooth minimum over two cells in each direction.
    pub(super) fn smooth(&self, p: [f32; N]) -> Nearest<N> {
        let (cell, local) = split(p);
        let smoothness = self.smoothness;
        let mut result = Nearest::default();
        let mut first = true;
        around(2, |offset| {
            let point = self.point(cell, offset);
            let distance = self.distance(point, local);
            let share = if first {
                1.0
            } else {
                smoothstep(0.5 + 0.5 * (result.distance - distance) / smoothness)
            };
            first = false;
            let correction = smoothness * share * (1.0 - share);
            result.distance =
                fused(share, distance - result.distance, result.distance) - correction;
            let correction = correction / (1.0 + 3.0 * smoothness);
            result.color = mix(result.color, Self::color(cell, offset), share) - correction;
            for (mixed, new) in result.position.iter_mut().zip(point) {
                *mixed = mix(*mixed, new, share) - correction;
            }
        });
        result.position = plus(cell, result.position);
        result
    }

    /// The distance to the nearest edge between cells.
    pub(super) fn distance_to_edge(&self, p: [f32; N]) -> f32 {
        // Squared distance below which two points are one.
        const SAME: f32 = 0.0001;
        let (cell, local) = split(p);
        if N == 1 {
            // Here edges are taken from the point of this cell, be it the nearest or not.
            let middle = self.point(cell, [0; N])[0];
            let edge = |step: i32| (middle + self.point(cell, [step; N])[0]) / 2.0;
            return (edge(-1) - local[0]).abs().min((edge(1) - local[0]).abs());
        }
        let mut least = f32::MAX;
        let mut closest = [0.0; N];
        around(1, |offset| {
            let to_point = minus(self.point(cell, offset), local);
            let key = dot(to_point, to_point);
            if key < least {
                least = key;
                closest = to_point;
            }
        });
        let mut distance = f32::MAX;
        around(1, |offset| {
            let to_point = minus(self.point(cell, offset), local);
            let across = minus(to_point, closest);
            let length_squared = dot(across, across);
            if length_squared > SAME {
                let middle = plus(closest, to_point).map(|x| x / 2.0);
                let length = length_squared.sqrt();
                distance = distance.min(dot(middle, across.map(|x| x / length)));
            }
        });
        distance
    }

    /// Half the distance from the nearest point to the point nearest to it.
    pub(super) fn sphere_radius(&self, p: [f32; N]) -> f32 {
        let (cell, local) = split(p);
        let straight = Self {
            metric: VoronoiMetric::Euclidean,
            ..*self
        };
        let mut least = f32::MAX;
        let mut closest = ([0; N], [0.0; N]);
        around(1, |offset| {
            let point = self.point(cell, offset);
            let key = straight.distance_key(point, local);
            if key < least {
                least = key;
                closest = (offset, point);
            }
        });
        let (from, closest) = closest;
        let mut least = f32::MAX;
        let mut neighbour = [0.0; N];
        around(1, |step| {
            if step == [0; N] {
                return;
            }
            let offset = std::array::from_fn(|axis| step[axis] + from[axis]);
            let point = self.point(cell, offset);
            let key = straight.distance_key(closest, point);
            if key < least {
                least = key;
                neighbour = point;
            }
        });
        straight.distance(neighbour, closest) / 2.0
    }
}
