//! Phase functions of interstellar dust, droplets and what floats in water. Their cumulative functions are known, and directions are
//! drawn by the root of those, in f64.

use std::f64::consts::{FRAC_1_PI, TAU};

/// Draine's: Henyey and Greenstein's times 1 + α cos² (*Scattering by Interstellar Dust Grains*, 2003, equation 4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draine {
    /// Of the part by Henyey and Greenstein, below 1 in magnitude.
    pub g: f32,
    /// How much more goes straight on and back, 0 or more.
    pub alpha: f32,
}

/// Below it the closed form of the cumulative function cancels by more than 1e-7: α g⁻³ u/4 for the largest α in use, 250.
const SMALL_G: f64 = 0.02;

impl Draine {
    /// By solid angle.
    pub fn density(self, cos: f64) -> f64 {
        let (g, alpha) = (f64::from(self.g), f64::from(self.alpha));
        let d = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos);
        let whole = 2.0 * TAU * (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0);
        (1.0 - g * g) * (1.0 + alpha * cos * cos) / (whole * d * d.sqrt())
    }

    /// The share of directions whose cosine is less.
    fn below(self, cos: f64) -> f64 {
        let (g, alpha) = (f64::from(self.g), f64::from(self.alpha));
        if g.abs() < SMALL_G {
            return integral(-1.0, cos, |c| TAU * self.density(c));
        }
        // With s² = 1 + g² − 2 g cos, which is linear in the cosine, the integrand is a sum of powers of s.
        let a = 1.0 + g * g;
        let k = alpha / (4.0 * g * g);
        let h = |s: f64| -(1.0 + k * a * a) / s - 2.0 * k * a * s + k * s * s * s / 3.0;
        let s = ((1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos)).sqrt();
        (h(1.0 + g) - h(s)) / (h(1.0 + g) - h(1.0 - g))
    }

    /// Draws a cosine.
    pub fn cosine(self, u: f64) -> f64 {
        let step = |cos: f64| (self.below(cos) - u, TAU * self.density(cos));
        root((-1.0, 1.0), step)
    }
}

/// Fournier and Forand's, of what floats in water (Fournier and Jonasz, *Computer-based underwater imaging analysis*, 1999).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FournierForand {
    /// δ of sin²(θ/2).
    scale: f64,
    /// The exponent ν = (3 − µ)/2 of the sizes' distribution.
    v: f64,
    /// Of the term for what goes back.
    back: f64,
}

/// Directions of f32 are not closer to straight on than this sin²(θ/2).
const STRAIGHT: f64 = f32::EPSILON as f64 / 4.0;
/// Angles below exp(−60) are straight on.
const LEAST_LOG: f64 = -60.0;

impl FournierForand {
    /// Of an index of refraction, relative to water, and the share that is scattered back. Limits are Cycles'.
    pub fn new(ior: f32, backscatter: f32) -> Self {
        let n = f64::from(ior.max(1.0 + 1e-3)) - 1.0;
        let b = f64::from(backscatter.abs().min(0.5 - 1e-3));
        let scale = 4.0 / (3.0 * n * n);
        let d90 = 0.5 * scale - 1.0;
        let v = match d90 {
            0.0 => -2.0 * b,
            _ => -(2.0 * b * d90).ln_1p() / d90.ln_1p(),
        };
        Self {
            scale,
            v,
            back: quotient(-v, scale.ln()),
        }
    }

    /// By solid angle.
    pub fn density(&self, cos: f64) -> f64 {
        self.at((0.5 * (1.0 - cos)).max(STRAIGHT))
    }

    /// By sin²(θ/2).
    fn at(&self, s: f64) -> f64 {
        let (v, delta) = (self.v, self.scale * s);
        let (l, less) = (delta.ln(), 1.0 - delta);
        let cos = 1.0 - 2.0 * s;
        // Close to 1 by their series: both differences cancel.
        let (a, b) = if less.abs() < 1e-5 {
            let a = v * (v - 1.0) * (0.5 - less * (v - 2.0) / 6.0);
            let b = -v * (v + 1.0) * (0.5 - less * (v - 1.0) / 6.0);
            (a, b)
        } else {
            let power = -(v * l).exp_m1();
            let a = (v * less - power) / (less * less);
            let b = (delta * power - v * less) / (less * less);
            (a, b)
        };
        let front = (a + b / s) * (-v * l).exp() / (2.0 * TAU);
        (front + self.back * (3.0 * cos * cos - 1.0) * FRAC_1_PI / 16.0).max(0.0)
    }

    /// The share of directions that are closer to straight on, by sin²(θ/2).
    fn within(&self, s: f64) -> f64 {
        let l = (self.scale * s).ln();
        let front = (quotient(self.v + 1.0, l) - quotient(self.v, l) * s) * (-self.v * l).exp();
        let cos = 1.0 - 2.0 * s;
        front + self.back * cos * s * (1.0 - s) / 2.0
    }

    /// Draws a cosine.
    pub fn cosine(&self, u: f64) -> f64 {
        // By the logarithm: most are close to straight on.
        let step = |t: f64| {
            let s = t.exp();
            (self.within(s) - u, 2.0 * TAU * s * self.at(s))
        };
        1.0 - 2.0 * root((LEAST_LOG, 0.0), step).exp()
    }
}

/// (x^a − 1)/(x − 1) of x = exp(l), also at 1.
fn quotient(a: f64, l: f64) -> f64 {
    if l == 0.0 {
        return a;
    }
    (a * l).exp_m1() / l.exp_m1()
}

/// By eight points of Gauss and Legendre: of polynomials up to the fifteenth degree it is exact.
fn integral(from: f64, to: f64, of: impl Fn(f64) -> f64) -> f64 {
    const POINTS: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_3),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
        (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
    ];
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let pair =
        |(at, weight): &(f64, f64)| weight * (of(middle - half * at) + of(middle + half * at));
    half * POINTS.iter().map(pair).sum::<f64>()
}

/// Where a growing function is zero, by Newton's steps, halved where they leave what is known; `step` gives value and slope.
fn root((mut low, mut high): (f64, f64), step: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut at = 0.5 * (low + high);
    for _ in 0..100 {
        let (value, slope) = step(at);
        if value > 0.0 {
            high = at;
        } else {
            low = at;
        }
        let newton = at - value / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        // Closer than f32 tells cosines apart.
        if (next - at).abs() < 1e-10 {
            return next;
        }
        at = next;
    }
    at
}

/// Mie's, of droplets of a diameter in µm, as a mix: mean cosine of the part by Henyey and Greenstein, Draine's part, and the
/// share of that. Fitted by Jendersie and d'Eon, *An Approximate Mie Scattering Function for Fog and Cloud Rendering*, 2023,
/// equations 7 to 10, and 11 to 22 of its supplement.
pub fn droplets(diameter: f32) -> (f32, Draine, f32) {
    let d = f64::from(diameter.max(0.0));
    let l = d.ln();
    let (hg, g, alpha, share) = if d <= 0.1 {
        let share = 0.252977 - 312.983 * d.powf(4.3);
        (13.8 * d * d, 1.1456 * d * (9.29044 * d).sin(), 250.0, share)
    } else if d < 1.5 {
        let a = (l - 0.238604) * (l + 1.00667);
        let b = 0.507522 - 0.15677 * l;
        let c = 1.19692 * (a / b).cos() + 1.37932 * l + 0.0625835;
        let share = 0.146209 * (3.38707 * l + 2.11193).cos() + 0.316072 + 0.0778917 * l;
        (
            0.862 - 0.143 * l * l,
            0.379685 * c.cos() + 0.344213,
            250.0,
            share,
        )
    } else if d < 5.0 {
        let g = 0.500411 - 0.081287 / (-2.0 * l + l.tan() + 1.27551);
        let turn = (5.68947 * (l.ln() - 0.0292149)).cos();
        let share = 0.026914 * (l - turn) + 0.3764;
        (
            0.0604931 * l.ln() + 0.940256,
            g,
            7.30354 * l + 6.31675,
            share,
        )
    } else {
        let g = (-2.20679 / (d + 3.91029) - 0.428934).exp();
        let share = (-0.599085 / (d - 0.641583) - 0.665888).exp();
        let alpha = (3.62489 - 8.29288 / (d + 5.52825)).exp();
        ((-0.0990567 / (d - 1.67154)).exp(), g, alpha, share)
    };
    let draine = Draine {
        g: g as f32,
        alpha: alpha as f32,
    };
    (hg as f32, draine, share as f32)
}
