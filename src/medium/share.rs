//! The share of light that comes through media which vary.
//!
//! A way is cut into stretches of about the same optical depth under the bounds. Places at even optical depths of a stretch say what is
//! met on all of it: e to the minus of their mean. That is a little too much, as e⁻ˣ is convex; now and then finer combs of places
//! are asked for, and what they differ by makes up for it (Misso, Bitterli, Georgiev and Jarosz, *Unbiased and Consistent Rendering
//! using Biased Estimators*, 2022, eq. 14: of the telescoping sum one term is drawn). The bounds only say where places lie, so that
//! bounds that are too low make noise and no weights without end.

use super::tracking::{Bounds, Local, MOST_COLLISIONS, March, met, survivor};
use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};

/// The optical depth of a stretch, under the bounds.
const DEPTH: f32 = 4.0;
/// A stretch ends where it has this share of that depth.
const FULL: f32 = 0.75;
/// A stretch has so many bounds at the most.
const MOST_PARTS: usize = 32;
/// Bounds in one stretch differ by no more than this: else places lie by the greatest, and tell nothing of what the least hides if that
/// is too low.
const ALIKE: f32 = 8.0;
/// Ratio tracking goes through what has less depth: most often it looks at nothing there.
const THIN: f32 = 0.4;
/// Places in each unit of optical depth. More of them make less noise, but not by as much as they take.
const PLACES: f32 = 0.6;
/// How often a comb is twice as fine, and twice again. The squares of what two combs differ by fall with 1/16 or faster from one to the
/// next where a medium is smooth, and with ¼ at edges: there each finer comb adds a quarter more variance than the one before. Drawn
/// more often they would add less, and take more than that is worth.
const FINER: f32 = 0.2;
/// The finest comb has 2 to this times the places of the first: a finer one would be drawn once in 10⁷ times.
const FINEST: u32 = 10;

/// Parts of a stretch, each below one bound: where it begins, the bound, and its optical depth.
type Stretch = ArrayVec<(f64, f32, f32), MOST_PARTS>;

/// The share of light that comes from one distance to another, right in the mean.
pub fn share(
    marches: &mut [March<'_>],
    even: f32,
    span: (f32, f32),
    mut draw: impl FnMut() -> f32,
    mut local: impl FnMut(f32) -> Local,
) -> Vec3 {
    // Most often there is one: from cell to cell it needs no loops over all of them.
    match marches {
        [one] => below(one, even, span, &mut draw, &mut local),
        _ => below(marches, even, span, &mut draw, &mut local),
    }
}

/// [`share`] for one kind of bounds.
fn below<B: Bounds + ?Sized>(
    bounds: &mut B,
    even: f32,
    (from, to): (f32, f32),
    draw: &mut impl FnMut() -> f32,
    local: &mut impl FnMut(f32) -> Local,
) -> Vec3 {
    let mut light = Light::default();
    let mut raised = 1.0f32;
    // In f64: stretches may be below the rounding of an f32.
    let mut t = f64::from(from);
    loop {
        let end = bounds.end().min(to);
        let mut majorant = raised * bounds.majorant() + even;
        let whole = majorant;
        if !light.goes_with(majorant) {
            light.go(draw, local);
        }
        let mut stretches = 0;
        while majorant > 0.0 && f64::from(end) > t {
            let rest = f64::from(majorant) * (f64::from(end) - t);
            // What is left below this bound, in even parts.
            let room = f64::from((DEPTH - light.depth).max(0.5 * DEPTH));
            let part = rest / (rest / room).ceil().max(1.0);
            light.stretch.push((t, majorant, part as f32));
            light.depth += part as f32;
            t = if part < rest {
                (t + part / f64::from(majorant)).max(t.next_up())
            } else {
                f64::from(end)
            };
            if light.depth >= FULL * DEPTH || light.stretch.is_full() {
                let most = light.go(draw, local) * majorant;
                if light.left == DVec3::ZERO {
                    return Vec3::ZERO;
                }
                stretches += 1;
                // As where light collides below a bound that is wrong.
                if most > majorant {
                    if most > 2.0 * whole {
                        raised *= most / whole;
                    }
                    majorant = whole.max(most);
                } else if stretches % MOST_COLLISIONS == 0 {
                    majorant *= 0.25;
                }
            }
        }
        t = f64::from(end);
        if end >= to || end == f32::INFINITY {
            light.go(draw, local);
            return light.left.as_vec3();
        }
        bounds.advance_from(end);
    }
}

/// Light on its way.
struct Light {
    /// What is left of it, in f64: it is a product of many.
    left: DVec3,
    /// What it has still to go through, and its optical depth.
    stretch: Stretch,
    depth: f32,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            left: DVec3::ONE,
            stretch: Stretch::new(),
            depth: 0.0,
        }
    }
}

impl Light {
    /// Whether places of one stretch tell of what lies below this bound, too.
    fn goes_with(&self, majorant: f32) -> bool {
        self.stretch.first().is_none_or(|&(_, other, _)| {
            majorant <= 0.0 || (majorant <= ALIKE * other && other <= ALIKE * majorant)
        })
    }

    /// Goes through the stretch; tells the most that it met there, over the bound, and at least 1.
    fn go(&mut self, draw: &mut impl FnMut() -> f32, local: &mut impl FnMut(f32) -> Local) -> f32 {
        if self.stretch.is_empty() {
            return 1.0;
        }
        let depth = std::mem::take(&mut self.depth);
        let mut places = Places::of(&self.stretch);
        let mut bound = 1.0f32;
        if depth < THIN {
            let mut at = 0.0;
            loop {
                at -= (-draw()).ln_1p() / bound;
                if at > depth {
                    break;
                }
                let there = places.over(at, local);
                self.left *= (Vec3::ONE - there / bound).as_dvec3();
                bound = bound.max(met(there, self.left.as_vec3()));
            }
        } else {
            let light = self.left.as_vec3();
            let over = |at: f32| {
                let there = places.over(at, local);
                bound = bound.max(met(there, light));
                there
            };
            self.left *= by_combs(depth, draw, over);
        }
        self.stretch.clear();
        let stays = survivor(Vec3::ONE, self.left.as_vec3(), draw);
        self.left *= stays.as_dvec3();
        bound
    }
}

/// The share that comes through a stretch of an optical depth: `over` is what is met at a depth in it, over the bound.
fn by_combs(
    depth: f32,
    draw: &mut impl FnMut() -> f32,
    mut over: impl FnMut(f32) -> Vec3,
) -> DVec3 {
    let count = (depth * PLACES).round().max(1.0) as u32;
    let (order, probability) = order(draw());
    let combs = 1u32 << order;
    let all = count * combs;
    let (step, offset) = (depth / all as f32, draw());
    let chosen = if order > 1 {
        (draw() * combs as f32) as u32
    } else {
        0
    };
    let (mut halves, mut one) = ([Vec3::ZERO; 2], Vec3::ZERO);
    for i in 0..all {
        let there = over((i as f32 + offset) * step);
        halves[i as usize % 2] += there;
        if i & (combs - 1) == chosen {
            one += there;
        }
    }
    let share = |sum: Vec3, places: u32| {
        let depth = sum.as_dvec3() * (f64::from(depth) / f64::from(places));
        (-depth).exp()
    };
    let finest = share(halves[0] + halves[1], all);
    if order == 0 {
        return finest;
    }
    let coarser = (share(halves[0], all / 2) + share(halves[1], all / 2)) / 2.0;
    // Two combs say more than one, where there are no more than that.
    let first = if order == 1 {
        coarser
    } else {
        share(one, count)
    };
    first + (finest - coarser) / f64::from(probability)
}

/// How often a comb is made twice as fine, for a number in [0, 1), with the probability of that.
fn order(mut u: f32) -> (u32, f32) {
    let (mut order, mut probability) = (0, 1.0 - FINER);
    while u < FINER && order < FINEST {
        u /= FINER;
        order += 1;
        probability *= FINER;
    }
    (order, probability)
}

/// Places of a stretch by optical depth; each lies behind the one before.
struct Places<'s> {
    stretch: &'s Stretch,
    part: usize,
    before: f32,
}

impl<'s> Places<'s> {
    fn of(stretch: &'s Stretch) -> Self {
        Self {
            stretch,
            part: 0,
            before: 0.0,
        }
    }

    /// What is met at an optical depth, over the bound.
    fn over(&mut self, at: f32, local: &mut impl FnMut(f32) -> Local) -> Vec3 {
        let (mut from, mut majorant, mut part) = self.stretch[self.part];
        while self.part + 1 < self.stretch.len() && at - self.before > part {
            self.before += part;
            self.part += 1;
            (from, majorant, part) = self.stretch[self.part];
        }
        let within = (at - self.before).clamp(0.0, part);
        local((from + f64::from(within / majorant)) as f32).extinction / majorant
    }
}

#[cfg(test)]
#[path = "../../tests/unit/medium/share.rs"]
mod tests;
