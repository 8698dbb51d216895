//! Light below a surface: a random walk through what fills an object, until it comes out.
//!
//! What is estimated is the walk of Cycles (CYCLES.md): its mappings from colours to media, at most [`MOST_STEPS`] steps, and
//! even scattering of the reduced coefficient from the tenth on (similarity theory: Wyman, Patterson and Wilson 1989). How it
//! is sampled is ours: directions by the phase function, and away from or towards the surface as Dwivedi would have it
//! (Křivánek and d'Eon, *A Zero-Variance-Based Sampling Scheme for Monte Carlo Subsurface Scattering*, 2014; Meng, Hanika and
//! Dachsbacher, *Improving the Dwivedi Sampling Scheme*, 2016; d'Eon and Křivánek 2020), free paths by each channel, all by
//! the balance heuristic.

use super::phase::{Phase, turned};
use crate::math::single_scattering_albedo;
use glam::Vec3;
use std::f32::consts::TAU;

/// A walk that has not come out is given up.
const MOST_STEPS: u32 = 256;
/// Steps from this on scatter evenly.
const SIMILAR_FROM: u32 = 10;
/// The greatest albedo of a scattering.
const MOST_ALBEDO: f32 = 0.999_999;
/// The least: with less, guides point nowhere. What it gives too much the walk's weight takes back.
const LEAST_ALBEDO: f32 = 0.2;
/// Below this share of what entered roulette decides. In half-spaces and slabs of dark and light skin and of milk, time × variance is
/// least between 0.3 and 1 and up to a quarter above with 0.02.
const LEAST_SHARE: f32 = 0.5;

/// Which medium a colour and a radius stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mapping {
    /// d'Eon, *A Hitchhiker's Guide to Multiple Scattering*, eq. 53.7: the radius is the mean free path.
    VanDeHulst,
    /// Chiang, Kutz and Burley, *Practical and Controllable Subsurface Scattering for Production Path Tracing*, 2016; with
    /// anisotropy Wrenninge, Villemin and Hery, *Path Traced Subsurface Scattering using Anisotropic Phase Functions and
    /// Non-Exponential Free Flights*, 2017. The radius is the reduced mean free path. Without a fit for backward scattering.
    Fitted,
}

/// What fills an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inside {
    /// Extinction coefficient, 1/m.
    pub extinction: Vec3,
    /// Albedo of a scattering.
    pub albedo: Vec3,
    /// Mean cosine of a scattering.
    pub g: f32,
    /// Weight of what enters: 1 where the albedo is not raised.
    pub weight: Vec3,
}

impl Inside {
    /// What gives back a colour, at radii in metres. Where a radius is 0 the channel has no weight.
    pub fn new(color: Vec3, radius: Vec3, g: f32, mapping: Mapping) -> Self {
        let is_fitted = mapping == Mapping::Fitted && g >= 0.0;
        let albedo = if is_fitted {
            let fit = Fit::new(g);
            Vec3::new(
                fit.albedo(color.x),
                fit.albedo(color.y),
                fit.albedo(color.z),
            )
        } else {
            single_scattering_albedo(color, g)
        };
        let albedo = albedo.clamp(Vec3::ZERO, Vec3::splat(MOST_ALBEDO));
        let raised = albedo.max(Vec3::splat(LEAST_ALBEDO));
        let scale = if is_fitted { 1.0 / (1.0 - g) } else { 1.0 };
        let there = radius.cmpgt(Vec3::ZERO);
        let extinction = scale / radius.max(Vec3::splat(f32::MIN_POSITIVE));
        Self {
            // Where there is none the others' will do: nothing weighs it.
            extinction: Vec3::select(
                there,
                extinction,
                Vec3::splat(scale / radius.max_element().max(f32::MIN_POSITIVE)),
            ),
            albedo: raised,
            g,
            weight: Vec3::select(there, albedo / raised, Vec3::ZERO),
        }
    }
}

/// The polynomials of Wrenninge, Villemin and Hery at one anisotropy.
struct Fit {
    low: [f32; 3],
    high: [f32; 3],
}

impl Fit {
    fn new(g: f32) -> Self {
        let polynomial = |coefficients: &[f32]| {
            let terms = coefficients.iter().rev();
            terms.fold(0.0, |sum, c| sum * g + c)
        };
        Self {
            low: [
                polynomial(&[
                    1.826_052_4,
                    -1.284_510_6,
                    -1.799_046_3,
                    9.193_933,
                    -22.821_56,
                    32.023_487,
                    -23.626_48,
                    7.210_67,
                ]),
                4.985_112
                    + 0.127_355_96
                        * polynomial(&[
                            0.0,
                            31.149_158,
                            -201.847_02,
                            841.576,
                            -2_018.092_9,
                            2_731.715_6,
                            -1_935.414_2,
                            559.009_05,
                        ])
                        .exp(),
                polynomial(&[
                    1.096_861,
                    -0.394_704_06,
                    1.052_581_2,
                    -8.839_637,
                    28.864_323,
                    -46.880_29,
                    38.540_284,
                    -12.718_104,
                ]),
            ],
            high: [
                polynomial(&[
                    0.496_310_2,
                    0.360_146_58,
                    -2.151_393,
                    17.889_69,
                    -55.298_4,
                    82.065_98,
                    -58.510_6,
                    15.847_83,
                ]),
                4.231_903
                    + 0.003_106_039_5
                        * polynomial(&[
                            0.0,
                            76.731_63,
                            -594.356_8,
                            2_448.883_4,
                            -5_576.685,
                            7_116.601_7,
                            -4_763.545,
                            1_303.531_8,
                        ])
                        .exp(),
                polynomial(&[
                    2.406_03,
                    -2.518_148_4,
                    9.184_949,
                    -79.219_17,
                    259.082_87,
                    -403.613_8,
                    302.857_12,
                    -87.437_05,
                ]),
            ],
        }
    }

    fn albedo(&self, color: f32) -> f32 {
        let of = |[scale, slope, power]: [f32; 3]| scale * (slope * color).atan().powf(power);
        let blend = color.powf(0.25);
        (1.0 - blend) * of(self.low) + blend * of(self.high)
    }
}

/// Numbers of a step, each in 0..1.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    /// Which channel's free path is drawn.
    pub channel: f32,
    /// How long it is.
    pub distance: f32,
    /// Whether the direction is guided, and which way.
    pub guide: f32,
    /// Its cosine.
    pub cosine: f32,
    /// Its turn.
    pub turn: f32,
    /// Roulette.
    pub survival: f32,
}

/// Where a walk begins.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Just below the surface.
    pub origin: Vec3,
    /// Inwards.
    pub direction: Vec3,
    /// Normal of the surface, outwards.
    pub normal: Vec3,
    /// How far along the direction the origin is from the surface: what of the free path is behind it.
    pub skipped: f32,
    /// What enters.
    pub throughput: Vec3,
}

/// Where it came out.
#[derive(Clone, Copy, Debug)]
pub struct Exit<H> {
    /// Start of its last ray.
    pub origin: Vec3,
    /// Outwards.
    pub direction: Vec3,
    /// What it met.
    pub hit: H,
    /// What comes out.
    pub throughput: Vec3,
    /// How many times it was scattered.
    pub steps: u32,
}

/// How directions are drawn that lead out, by Dwivedi's solution for a half-space (Meng et al., equations 9 and 10).
struct Guide {
    /// Diffusion length in mean free paths.
    length: f32,
    /// ln((ν + 1)/(ν − 1)).
    log: f32,
}

impl Guide {
    /// For an albedo of [`LEAST_ALBEDO`] at least (d'Eon and Křivánek 2020, eq. 67).
    fn new(albedo: f32) -> Self {
        let power = 2.44294 - 0.021_581_3 * albedo + 0.578_637 / albedo;
        let length = 1.0 / (1.0 - albedo.powf(power)).sqrt();
        let log = ((length + 1.0) / (length - 1.0)).ln();
        Self { length, log }
    }

    /// Density by solid angle of a direction with this cosine to the way out.
    fn density(&self, cos: f32) -> f32 {
        1.0 / (TAU * (self.length - cos) * self.log)
    }

    fn cosine(&self, u: f32) -> f32 {
        (self.length - (self.length + 1.0) * (-u * self.log).exp()).clamp(-1.0, 1.0)
    }

    /// What the extinction is multiplied by along it.
    fn stretch(&self, cos: f32) -> f32 {
        1.0 - cos / self.length
    }
}

/// Walks until it comes out. `numbers`: of a step; `meet`: what a ray from a place in a direction meets within a distance, and
/// how far away. `None` where no light comes out.
///
/// The weight is unbiased but for the end of the steps.
pub fn walk<H: Copy>(
    inside: &Inside,
    start: &Start,
    numbers: impl Fn(u32) -> Numbers,
    mut meet: impl FnMut(Vec3, Vec3, f32) -> Option<(f32, H)>,
) -> Option<Exit<H>> {
    let guide = Guide::new(inside.albedo.max_element());
    let reduced = Vec3::ONE - inside.albedo * inside.g;
    // Extinction, scattering, mean cosine and share of guided directions: at first, and when scattering is even.
    let stages = [
        (
            inside.extinction,
            inside.extinction * inside.albedo,
            inside.g,
            guided_share(inside.g),
        ),
        (
            inside.extinction * reduced,
            inside.extinction * (inside.albedo * (1.0 - inside.g)),
            0.0,
            GUIDED,
        ),
    ];
    let (mut origin, mut direction) = (start.origin, start.direction);
    let mut throughput = start.throughput * inside.weight;
    if throughput.max_element() <= 0.0 {
        return None;
    }
    let least = LEAST_SHARE * throughput.max_element();
    // One channel's free paths are drawn on the whole walk, so that a number which is spread evenly over the samples of a pixel says
    // whose walk it is. Of each channel how likely it is to be that one, by the way so far.
    let shares = throughput * inside.albedo;
    let mut shares = shares / shares.element_sum();
    let first = numbers(0);
    let channel = match first.channel {
        u if u < shares.x => 0,
        u if u < shares.x + shares.y || shares.z <= 0.0 => 1,
        _ => 2,
    };
    // How far below the surface's plane the other side is, if it is near.
    let mut opposite: Option<f32> = None;
    for step in 0..MOST_STEPS {
        let (extinction, scattered, g, guided) = stages[usize::from(step >= SIMILAR_FROM)];
        let u = if step == 0 { first } else { numbers(step) };
        // Densities of the direction over that by the phase function, with the stretch of each guide's free paths.
        let mut ways = [(1.0, 1.0), (0.0, 1.0), (0.0, 1.0)];
        let mut chosen = 0;
        if step > 0 {
            let back = opposite.map_or(0.0, |far| {
                let depth = (start.origin - origin).dot(start.normal).clamp(0.0, far);
                let scale = inside.extinction.min_element() / guide.length;
                1.0 / (1.0 + ((far - 2.0 * depth) * scale).exp())
            });
            let shares = [1.0 - guided, guided * (1.0 - back), guided * back];
            chosen = match u.guide {
                x if x < shares[1] => 1,
                x if x < guided => 2,
                _ => 0,
            };
            let phase = Phase::HenyeyGreenstein(g);
            let onward = match chosen {
                0 => phase.turned(direction, u.cosine, u.turn),
                1 => turned(start.normal, guide.cosine(u.cosine), u.turn),
                _ => turned(-start.normal, guide.cosine(u.cosine), u.turn),
            };
            let by_phase = phase.density(direction.dot(onward));
            let cos = onward.dot(start.normal);
            ways = [
                (shares[0], 1.0),
                (
                    shares[1] * guide.density(cos) / by_phase,
                    guide.stretch(cos),
                ),
                (
                    shares[2] * guide.density(-cos) / by_phase,
                    guide.stretch(-cos),
                ),
            ];
            direction = onward;
        }
        let skipped = if step == 0 { start.skipped } else { 0.0 };
        let free = -(-u.distance).ln_1p() / (extinction[channel] * ways[chosen].1);
        let far = if step == 0 {
            free.max(10.0 / extinction.min_element())
        } else {
            free
        };
        let mut met = meet(origin, direction, far);
        if step == 0 {
            opposite = met.map(|(t, _)| t * -direction.dot(start.normal));
            opposite = opposite.filter(|depth| *depth > 0.0);
            met = met.filter(|(t, _)| t + skipped < free);
        }
        let (way, length) = match met {
            Some((t, _)) => (t, t + skipped),
            None => ((free - skipped).max(0.0), free),
        };
        let passed = super::transmittance(extinction, length);
        // Densities of the free path's end, or of meeting the surface there.
        let mut pdf = Vec3::ZERO;
        for (density, stretch) in ways {
            if density > 0.0 {
                let stretched = extinction * stretch;
                let passed = if stretch == 1.0 {
                    passed
                } else {
                    super::transmittance(stretched, length)
                };
                let end = if met.is_some() {
                    passed
                } else {
                    stretched * passed
                };
                pdf += end * density;
            }
        }
        let value = if met.is_some() {
            passed
        } else {
            scattered * passed
        };
        let density = shares.dot(pdf);
        throughput *= value / density;
        shares *= pdf / density;
        if let Some((_, hit)) = met {
            return Some(Exit {
                origin,
                direction,
                hit,
                throughput,
                steps: step,
            });
        }
        origin += direction * way;
        let most = throughput.max_element();
        if !way.is_finite() {
            // It has left an open mesh.
            return None;
        }
        if most < least {
            let survival = most / least;
            if u.survival >= survival {
                return None;
            }
            throughput /= survival;
        }
    }
    None
}

/// How often directions are guided where scattering is even: more than Cycles' half gives up to a third less time × variance.
const GUIDED: f32 = 0.9;

/// The more scattering is to one side the less a guide knows of it.
fn guided_share(g: f32) -> f32 {
    1.0 - g.abs().powf(0.125).max(1.0 - GUIDED)
}

#[cfg(test)]
#[path = "../../tests/unit/medium/walk.rs"]
mod tests;
