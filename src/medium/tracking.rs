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

/// Points in each cell by whose extinction it is bounded: two on each axis.
const POINTS: u32 = 2;
/// A cell without extinction at its points and those of its neighbours has so much of the greatest bound: what lies between the
/// points is found, too.
const LEAST_SHARE: f32 = 1.0 / 64.0;
/// So many events on the way through a box of what emits and takes little: there its emission is asked for.
const EVENTS: f32 = 8.0;

/// Bounds of a medium's extinction in the cells of a box.
#[derive(Clone, Debug)]
pub struct Majorants {
    low: Vec3,
    high: Vec3,
    /// Cells in a metre.
    scale: Vec3,
    count: i32,
    values: Vec<f32>,
    /// Beyond the box.
    beyond: f32,
}

impl Majorants {
    /// Asks for what is at points of a box, with so many cells along each axis. `endless`: the medium goes on beyond the box.
    pub fn new(
        (low, high): (Vec3, Vec3),
        count: u32,
        endless: bool,
        local: impl Fn(Vec3) -> Local + Sync,
    ) -> Self {
        let count = count.max(1) as i32;
        // Points on the box's faces lie in it, however they are rounded.
        let margin = (low.abs().max(high.abs()) * 4.0 * f32::EPSILON)
            .max((high - low).max(Vec3::ZERO) * f32::EPSILON)
            .max(Vec3::splat(f32::MIN_POSITIVE));
        let (low, high) = (low - margin, high + margin);
        let size = (high - low) / count as f32;
        let rate = EVENTS / (high - low).length();
        let bound_at = |x: i32, y: i32, z: i32| {
            let corner = low + IVec3::new(x, y, z).as_vec3() * size;
            let (mut most, mut emits) = (0.0f32, false);
            for point in 0..POINTS.pow(3) {
                let bits = [
                    point % POINTS,
                    point / POINTS % POINTS,
                    point / POINTS / POINTS,
                ];
                // Each cell's points lie otherwise in it, so that no lattice of the medium hides between them.
                let cell = (z * count + y) * count + x;
                let turn = |axis: u32| {
                    let n = cell as u32 * 24 + point * 3 + axis;
                    (f64::from(n) * 0.618_033_988_749_894_9).fract() as f32
                };
                let within = Vec3::new(
                    bits[0] as f32 + turn(0),
                    bits[1] as f32 + turn(1),
                    bits[2] as f32 + turn(2),
                ) / POINTS as f32;
                let local = local(corner + within * size);
                let extinction = local.extinction.max_element();
                // What is no number bounds nothing; the path meets it, and it is counted there.
                if extinction.is_finite() {
                    most = most.max(extinction);
                }
                emits |= local.emission != Vec3::ZERO;
            }
            (most, emits)
        };
        let found: Vec<(f32, bool)> = (0..count.pow(3))
            .into_par_iter()
            .map(|at| bound_at(at % count, at / count % count, at / count / count))
            .collect();
        let greatest = found.iter().map(|found| found.0).fold(0.0, f32::max);
        let emits = found.iter().any(|found| found.1);
        let floor = if emits { rate } else { 0.0 }.max(greatest * LEAST_SHARE);
        let at = |x: i32, y: i32, z: i32| {
            let (around, mut most) = (|i: i32| (i - 1).max(0)..=(i + 1).min(count - 1), floor);
            for z in around(z) {
                for y in around(y) {
                    for x in around(x) {
                        most = most.max(found[((z * count + y) * count + x) as usize].0);
                    }
                }
            }
            most
        };
        let values = (0..count.pow(3))
            .into_par_iter()
            .map(|i| at(i % count, i / count % count, i / count / count))
            .collect();
        Self {
            low,
            high,
            scale: size.recip(),
            count,
            values,
            beyond: if endless { greatest.max(floor) } else { 0.0 },
        }
    }

    /// The bounds along a ray from a distance on.
    pub fn along(&self, origin: Vec3, direction: Vec3, from: f32) -> March<'_> {
        let inverse = direction.recip();
        let (a, b) = (
            (self.low - origin) * inverse,
            (self.high - origin) * inverse,
        );
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if origin[axis] < self.low[axis] || origin[axis] > self.high[axis] {
                    near = f32::INFINITY;
                }
            } else {
                near = near.max(a[axis].min(b[axis]));
                far = far.min(a[axis].max(b[axis]));
            }
        }
        let mut march = March {
            grid: self,
            ray: (origin, direction),
            leaves: far,
            cell: IVec3::ZERO,
            next: Vec3::INFINITY,
            end: from,
            majorant: self.beyond,
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
    /// Where it leaves the box.
    leaves: f32,
    cell: IVec3,
    /// Where it leaves the cell, by axis.
    next: Vec3,
    /// How far the bound holds.
    end: f32,
    /// The bound.
    majorant: f32,
    inside: bool,
}

impl March<'_> {
    fn enter(&mut self, at: f32) {
        let (origin, direction) = self.ray;
        let grid = self.grid;
        let place = (origin + direction * at - grid.low) * grid.scale;
        self.cell = place
            .floor()
            .as_ivec3()
            .clamp(IVec3::ZERO, IVec3::splat(grid.count - 1));
        for axis in 0..3 {
            self.next[axis] = self.crossing(axis);
        }
        self.inside = true;
        self.settle(at);
    }

    /// Where the ray leaves its cell along an axis.
    fn crossing(&self, axis: usize) -> f32 {
        let (origin, direction) = self.ray;
        if direction[axis] == 0.0 {
            return f32::INFINITY;
        }
        let side = self.cell[axis] + i32::from(direction[axis] > 0.0);
        let plane = self.grid.low[axis] + side as f32 / self.grid.scale[axis];
        (plane - origin[axis]) / direction[axis]
    }

    fn settle(&mut self, at: f32) {
        let (cell, count) = (self.cell, self.grid.count);
        self.majorant = self.grid.values[((cell.z * count + cell.y) * count + cell.x) as usize];
        self.end = self.next.min_element().min(self.leaves).max(at);
    }

    /// Goes on to what lies behind the end of this bound.
    fn advance(&mut self) {
        let at = self.end;
        if !self.inside {
            self.enter(at);
            return;
        }
        let axis = match self.next {
            n if n.x <= n.y && n.x <= n.z => 0,
            n if n.y <= n.z => 1,
            _ => 2,
        };
        self.cell[axis] += if self.ray.1[axis] > 0.0 { 1 } else { -1 };
        let is_out = !(0..self.grid.count).contains(&self.cell[axis]);
        if is_out || at >= self.leaves {
            (self.majorant, self.end) = (self.grid.beyond, f32::INFINITY);
            return;
        }
        self.next[axis] = self.crossing(axis);
        self.settle(at);
    }
}

/// Calls for each collision with the sum of some bounds between two distances, until one gives something.
fn collide<T>(
    marches: &mut [March<'_>],
    even: f32,
    (from, to): (f32, f32),
    mut draw: impl FnMut() -> f32,
    mut event: impl FnMut(f32, f32) -> Option<T>,
) -> Option<T> {
    let mut depth = || -(-draw()).ln_1p();
    let (mut t, mut left) = (from, depth());
    loop {
        let majorant = marches.iter().map(|m| m.majorant).sum::<f32>() + even;
        let ends = marches.iter().map(|m| m.end).fold(f32::INFINITY, f32::min);
        let end = ends.min(to);
        let way = if majorant > 0.0 {
            majorant * (end - t)
        } else {
            0.0
        };
        if way > left {
            t += left / majorant;
            if let Some(found) = event(t, majorant) {
                return Some(found);
            }
            left = depth();
            continue;
        }
        left -= way;
        t = end;
        if t >= to || t == f32::INFINITY {
            return None;
        }
        for march in marches.iter_mut().filter(|march| march.end <= t) {
            march.advance();
        }
    }
}

/// Below this share of what came in, light ends by roulette.
const FAINT: f32 = 1.0 / 16.0;

/// Ends faint light by roulette: what is left of a weight; zero where it ends.
fn survivor(weight: Vec3, faint: Vec3, draw: impl FnOnce() -> f32) -> Vec3 {
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

/// The share of light that comes from one distance to another, by ratio tracking: right in the mean.
pub fn ratio(
    marches: &mut [March<'_>],
    even: f32,
    span: (f32, f32),
    mut draw: impl FnMut() -> f32,
    mut local: impl FnMut(f32) -> Local,
) -> Vec3 {
    let mut share = Vec3::ONE;
    // Two streams of one: the distances' and the roulette's.
    let draw = std::cell::RefCell::new(&mut draw);
    let next = || (draw.borrow_mut())();
    collide(marches, even, span, next, |t, majorant| {
        let part = Vec3::ONE - local(t).extinction / majorant;
        share *= part;
        share = survivor(share, share, next);
        (share == Vec3::ZERO).then_some(())
    });
    share
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
            return Some(None);
        }
        let share = s / (s + n);
        if share > 0.0 && next() < share {
            weight *= scattered / share;
            return Some(Some(t));
        }
        weight *= null / (1.0 - share);
        weight = survivor(weight, weight, next);
        (weight == Vec3::ZERO).then_some(None)
    });
    let flight = match found.flatten() {
        Some(t) => Flight::Scattered(t, weight),
        None => Flight::Through(weight),
    };
    (flight, emitted)
}

#[cfg(test)]
#[path = "../../tests/unit/medium/tracking.rs"]
mod tests;
