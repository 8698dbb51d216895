//! The share of light that comes through media which vary.
//!
//! A way is cut into stretches of about the same optical depth under the bounds, and each is looked at in two places: one is the pivot of
//! a power series of the other (Kettunen, d'Eon, Pantaleoni and Novák, *An Unbiased Ray-Marching Transmittance Estimator*, 2021). Ratio
//! tracking has exp(τ r²) − 1 of variance where light meets a share r of the bounds' optical depth τ; this has some hundredths of it.

use super::tracking::{Bounds, Local, MOST_COLLISIONS, March, met, survivor};
use arrayvec::ArrayVec;
use glam::Vec3;

/// The optical depth of a stretch, under the bounds.
const DEPTH: f32 = 1.0;
/// Stretches of less are looked at by chance.
const THIN: f32 = 0.3;
/// A stretch ends where it has this share of that depth.
const FULL: f32 = 0.75;
/// How often the next order of the series is looked at, for a stretch of an optical depth of 1.
const HIGHER: f32 = 0.25;
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
    let (mut share, mut raised) = (Vec3::ONE, 1.0f32);
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
                let most = through(&stretch, depth, &mut share, draw, local);
                stretch.clear();
                depth = 0.0;
                if share == Vec3::ZERO {
                    return share;
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
                through(&stretch, depth, &mut share, draw, local);
            }
            return share;
        }
        bounds.advance_from(end);
    }
}

/// Takes from a share what a stretch of an optical depth does; tells the most that light met there, 1/m, over the bound there and times
/// the last one.
fn through(
    stretch: &Stretch,
    depth: f32,
    share: &mut Vec3,
    draw: &mut impl FnMut() -> f32,
    local: &mut impl FnMut(f32) -> Local,
) -> f32 {
    let mut most = 0.0f32;
    let light = *share;
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
        let over = local(found.0).extinction / found.1;
        most = most.max(met(over, light));
        over
    };
    if depth < THIN {
        let mut at = 0.0;
        loop {
            at -= (-draw()).ln_1p();
            if at > depth {
                break;
            }
            *share *= Vec3::ONE - over(at);
        }
    } else {
        let mut look = |u: f32| -depth * over(u * depth);
        let (a, b) = (look(draw()), look(draw()));
        // e^b from a, and e^a from b, to the first order.
        let (from_a, from_b) = (a.exp(), b.exp());
        let mut sum = 0.5 * (from_a * (Vec3::ONE + b - a) + from_b * (Vec3::ONE + a - b));
        // Higher orders by roulette.
        let (mut term, mut order) = (from_a * (b - a), 2.0);
        let goes_on = HIGHER * depth.min(1.0);
        while draw() < goes_on {
            term *= (look(draw()) - a) / (order * goes_on);
            sum += term;
            order += 1.0;
        }
        *share *= sum;
    }
    *share = survivor(*share, *share, draw);
    let last = stretch.last().map_or(0.0, |&(_, majorant, _)| majorant);
    most * last
}
