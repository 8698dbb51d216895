//! The share of light that comes through media which vary.
//!
//! A way is cut into stretches of about the same optical depth under the bounds. What is met at one place of a stretch is taken from all of
//! it analytically, and ratio tracking takes the rest (residual ratio tracking: Novák, Selle and Jarosz, *Residual Ratio Tracking for
//! Estimating Attenuation in Participating Media*, 2014). Of a share r of the bounds' optical depth τ ratio tracking alone has exp(τ r²) − 1 of
//! variance; here r is what two places differ by. The bound is raised as soon as it is exceeded, as where light collides.

use super::tracking::{Bounds, Local, MOST_COLLISIONS, March, met, survivor};
use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};

/// The optical depth of a stretch, under the bounds.
const DEPTH: f32 = 1.5;
/// Of stretches of less nothing is taken analytically: most often ratio tracking looks at nothing there.
const THIN: f32 = 0.4;
/// A stretch ends where it has this share of that depth.
const FULL: f32 = 0.75;
/// A stretch has so many bounds at the most.
const MOST_PARTS: usize = 16;

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
    let (mut light, mut raised) = (Light::default(), 1.0f32);
    // In f64: stretches may be below the rounding of an f32.
    let mut t = f64::from(from);
    let (mut stretch, mut depth) = (Stretch::new(), 0.0f32);
    loop {
        let end = bounds.end().min(to);
        let mut majorant = raised * bounds.majorant() + even;
        let whole = majorant;
        let mut stretches = 0;
        while majorant > 0.0 && f64::from(end) > t {
            let rest = f64::from(majorant) * (f64::from(end) - t);
            // What is left below this bound, in even parts.
            let room = f64::from((DEPTH - depth).max(0.5 * DEPTH));
            let part = rest / (rest / room).ceil().max(1.0);
            stretch.push((t, majorant, part as f32));
            depth += part as f32;
            t = if part < rest {
                (t + part / f64::from(majorant)).max(t.next_up())
            } else {
                f64::from(end)
            };
            if depth >= FULL * DEPTH || stretch.is_full() {
                let most = light.through(&stretch, depth, draw, local);
                stretch.clear();
                depth = 0.0;
                if light.left == Vec3::ZERO {
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
            if depth > 0.0 {
                light.through(&stretch, depth, draw, local);
            }
            return light.left;
        }
        bounds.advance_from(end);
    }
}

/// Light on its way.
struct Light {
    /// By what ratio tracking finds.
    weight: Vec3,
    /// What is taken analytically, in f64: it is a sum of many.
    depth: DVec3,
    /// What was left of it where the last stretch ended.
    left: Vec3,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            weight: Vec3::ONE,
            depth: DVec3::ZERO,
            left: Vec3::ONE,
        }
    }
}

impl Light {
    /// Goes through a stretch of an optical depth; tells the most that light met there, 1/m, over the bound there and times the last one.
    fn through(
        &mut self,
        stretch: &Stretch,
        depth: f32,
        draw: &mut impl FnMut() -> f32,
        local: &mut impl FnMut(f32) -> Local,
    ) -> f32 {
        // What is met at an optical depth of the stretch, over the bound.
        let mut over = |mut at: f32| {
            let mut found = (0.0, 1.0);
            for &(from, majorant, part) in stretch {
                found = ((from + f64::from(at.min(part) / majorant)) as f32, majorant);
                if at <= part {
                    break;
                }
                at -= part;
            }
            local(found.0).extinction / found.1
        };
        let (mut taken, mut bound) = (Vec3::ZERO, 1.0f32);
        if depth >= THIN {
            let there = over(draw() * depth);
            // What exceeds the bound, or is no number, says nothing of the rest.
            taken = Vec3::select(there.cmple(Vec3::ONE), there.max(Vec3::ZERO), Vec3::ONE);
            bound = bound.max(met(there, self.left));
            self.depth += (taken * depth).as_dvec3();
        }
        let mut at = 0.0;
        loop {
            at -= (-draw()).ln_1p() / bound;
            if at > depth {
                break;
            }
            let there = over(at);
            self.weight *= Vec3::ONE - (there - taken) / bound;
            bound = bound.max(met(there, self.left));
        }
        let share = (-self.depth).exp().as_vec3();
        // Where nothing is left, weights may grow as they like.
        let is_left = share.cmpgt(Vec3::ZERO) & self.left.cmpne(Vec3::ZERO);
        self.weight = Vec3::select(is_left, self.weight, Vec3::ZERO);
        self.weight = survivor(self.weight, self.weight * share, draw);
        self.left = self.weight * share;
        bound * stretch.last().map_or(0.0, |&(_, majorant, _)| majorant)
    }
}
