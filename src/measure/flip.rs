//! LDR-FLIP and HDR-FLIP: how much one sees when two pictures alternate.
//!
//! Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", and Andersson et al. 2021, "Visualizing
//! Errors in Rendered High Dynamic Range Images", with the separable filters of Nilsson and Akenine-Möller's note
//! `misc/separatedConvolutions.pdf` in the authors' repository, whose evaluator (PyPI's flip-evaluator 1.7) the results
//! agree with to 1e-4. Nothing is quantised: the pictures are floats from beginning to end.

use crate::math::LUMINANCE;
use glam::Vec2;
use rayon::prelude::*;
use std::f64::consts::PI;

/// The viewer's distance and screen of the papers: 0.7 m from a screen of 3840 pixels on 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// Rows that one piece of work covers. Its filters reach ten rows beyond on each side, which are filtered twice.
const BAND: usize = 64;

/// From linear Rec.709 to XYZ as the authors' evaluator has it (D65).
const TO_XYZ: [[f64; 3]; 3] = [
    [
        10_135_552.0 / 24_577_794.0,
        8_788_810.0 / 24_577_794.0,
        4_435_075.0 / 24_577_794.0,
    ],
    [
        2_613_072.0 / 12_288_897.0,
        8_788_810.0 / 12_288_897.0,
        887_015.0 / 12_288_897.0,
    ],
    [
        1_425_312.0 / 73_733_382.0,
        8_788_810.0 / 73_733_382.0,
        70_074_185.0 / 73_733_382.0,
    ],
];

// Andersson et al. 2020, section 4: exponents and knee of the colour difference, width of the features in degrees,
// exponent of the feature difference.
const COLOR_EXPONENT: f32 = 0.7;
const KNEE: f32 = 0.4;
const KNEE_ERROR: f32 = 0.95;
const FEATURE_WIDTH: f64 = 0.082;
const FEATURE_EXPONENT: f32 = 0.5;

/// (a, b) of a Gaussian a √(π/b) exp(−π² x²/b) of the eye's contrast sensitivity, x in degrees (table 1 of the paper).
const ACHROMATIC: (f64, f64) = (1.0, 0.0047);
const RED_GREEN: (f64, f64) = (1.0, 0.0053);
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// ACES as Narkowicz fits it, with its exposure of 0.6: (n₂x² + n₁x) / (d₂x² + d₁x + d₀).
const ACES_NUMERATOR: [f64; 2] = [0.36 * 2.51, 0.6 * 0.03];
const ACES_DENOMINATOR: [f64; 3] = [0.36 * 2.43, 0.6 * 0.59, 0.14];
/// The tone mapper's output that the first exposure gives to the brightest pixel, the last one to the median.
const EXPOSED_TO: f64 = 0.85;

/// The exposures of an HDR-FLIP, in stops.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Exposures {
    /// Of the first.
    pub start: f64,
    /// Of the last.
    pub stop: f64,
    /// How many, at equal distances.
    pub count: u32,
}

impl Exposures {
    /// Those of the paper's section 3.2 for a reference: from the one that shows the brightest pixel to the one that
    /// shows the median luminance, about a stop apart. Where more than half of the pixels are black the paper has no last
    /// exposure; it is then that of the median of those that are not. None if all are.
    pub fn of(reference: impl IntoIterator<Item = [f32; 3]>) -> Option<Self> {
        let mut luminances: Vec<f32> = reference
            .into_iter()
            .map(|pixel| {
                let sum: f64 = (0..3)
                    .map(|c| LUMINANCE[c] * f64::from(pixel[c].max(0.0)))
                    .sum();
                sum as f32
            })
            .collect();
        luminances.sort_unstable_by(f32::total_cmp);
        let brightest = f64::from(*luminances.last()?);
        let black = luminances.partition_point(|luminance| *luminance == 0.0);
        let median = match luminances[luminances.len() / 2] {
            0.0 => *luminances[black..].get((luminances.len() - black) / 2)?,
            median => median,
        };
        let exposed = input_of(EXPOSED_TO);
        let (start, stop) = (
            (exposed / brightest).log2(),
            (exposed / f64::from(median)).log2(),
        );
        Some(Self {
            start,
            stop,
            count: ((stop - start).ceil() as u32).max(2),
        })
    }

    /// The factors, from the first to the last.
    fn factors(self) -> impl Iterator<Item = f64> {
        let step = (self.stop - self.start) / f64::from(self.count - 1);
        (0..self.count).map(move |i| (self.start + f64::from(i) * step).exp2())
    }
}

/// ACES, its result within 0..=1. (In f64, where the square of no f32, at no exposure there is, overflows.)
fn aces(value: f64) -> f32 {
    let x = value.max(0.0);
    let numerator = (ACES_NUMERATOR[0] * x + ACES_NUMERATOR[1]) * x;
    let denominator = (ACES_DENOMINATOR[0] * x + ACES_DENOMINATOR[1]) * x + ACES_DENOMINATOR[2];
    (numerator / denominator).min(1.0) as f32
}

/// The light that ACES shows as `output`: the positive root of its quadratic equation.
fn input_of(output: f64) -> f64 {
    let a = ACES_NUMERATOR[0] - output * ACES_DENOMINATOR[0];
    let b = ACES_NUMERATOR[1] - output * ACES_DENOMINATOR[1];
    let c = -output * ACES_DENOMINATOR[2];
    let half = -0.5 * b / a;
    half + (half * half - c / a).sqrt()
}

/// LDR-FLIP of each pixel, 0..=1. `pixels` gives reference and test, linear Rec.709 within 0..=1.
pub fn ldr(
    width: usize,
    height: usize,
    pixels: &(impl Fn(usize) -> [[f32; 3]; 2] + Sync),
) -> Vec<f32> {
    by_bands(width, height, |eye, first_row, out| {
        eye.band(width, height, first_row, pixels, out);
    })
}

/// HDR-FLIP of each pixel: the largest LDR-FLIP over the exposures, tone mapped by ACES. `pixels` gives reference and test,
/// linear Rec.709; what is below 0 counts as 0, for the tone mapper is made for light.
pub fn hdr(
    width: usize,
    height: usize,
    exposures: Exposures,
    pixels: &(impl Fn(usize) -> [[f32; 3]; 2] + Sync),
) -> Vec<f32> {
    by_bands(width, height, |eye, first_row, out| {
        let mut exposed = vec![0.0; out.len()];
        for factor in exposures.factors() {
            let shown = |at: usize| {
                pixels(at).map(|pixel| pixel.map(|value| aces(f64::from(value) * factor)))
            };
            eye.band(width, height, first_row, &shown, &mut exposed);
            for (out, error) in out.iter_mut().zip(&exposed) {
                *out = f32::max(*out, *error);
            }
        }
    })
}

/// A map whose bands are filled by the threads of the current pool; each is given its first row.
fn by_bands(
    width: usize,
    height: usize,
    fill: impl Fn(&Eye, usize, &mut [f32]) + Sync,
) -> Vec<f32> {
    let eye = Eye::new(PIXELS_PER_DEGREE);
    let mut map = vec![0.0; width * height];
    map.par_chunks_mut(width * BAND)
        .enumerate()
        .for_each(|(index, out)| fill(&eye, index * BAND, out));
    map
}

/// Filters in one dimension; the second one is the same.
struct Eye {
    /// Reach of the filters of colour, in pixels.
    color_radius: usize,
    /// Y, Cx, and the two parts of Cz.
    color: [Vec<f32>; 4],
    /// Reach of those of features.
    feature_radius: usize,
    /// Gaussian, its first and its second derivative.
    feature: [Vec<f32>; 3],
    /// From linear Rec.709 to YCxCz, whose Y is then 16 too great.
    to_opponent: [[f32; 3]; 3],
    from_opponent: [[f32; 3]; 3],
    /// From linear Rec.709 to XYZ over the white.
    to_white: [[f32; 3]; 3],
    /// The largest colour difference: green and blue.
    largest: f32,
}

/// What the first direction leaves of a picture, a row after the other: Y, Cx and Cz's two parts, then the Gaussian and
/// its derivatives of Y.
type Filtered = [Vec<f32>; 7];

impl Eye {
    fn new(pixels_per_degree: f64) -> Self {
        let widest = [ACHROMATIC, RED_GREEN, BLUE_YELLOW[0], BLUE_YELLOW[1]]
            .iter()
            .fold(0.0f64, |widest, (_, b)| widest.max(*b));
        let color_radius =
            (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
        let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let feature_radius = (3.0 * sigma).ceil() as usize;
        let white: [f64; 3] = TO_XYZ.map(|row| row.iter().sum());
        let to_white: [[f64; 3]; 3] =
            std::array::from_fn(|row| std::array::from_fn(|c| TO_XYZ[row][c] / white[row]));
        let to_opponent: [[f64; 3]; 3] = [
            std::array::from_fn(|c| 116.0 * to_white[1][c]),
            std::array::from_fn(|c| 500.0 * (to_white[0][c] - to_white[1][c])),
            std::array::from_fn(|c| 200.0 * (to_white[1][c] - to_white[2][c])),
        ];
        let from_opponent = glam::DMat3::from_cols_array_2d(&to_opponent)
            .inverse()
            .to_cols_array_2d();
        let single = |matrix: [[f64; 3]; 3]| matrix.map(|row| row.map(|value| value as f32));
        let to_white = single(to_white);
        let largest = distance(
            lab(&to_white, [0.0, 1.0, 0.0]),
            lab(&to_white, [0.0, 0.0, 1.0]),
        )
        .powf(COLOR_EXPONENT);
        Self {
            color_radius,
            color: color_filters(color_radius, pixels_per_degree),
            feature_radius,
            feature: feature_filters(feature_radius, sigma),
            to_opponent: single(to_opponent),
            from_opponent: single(from_opponent),
            to_white,
            largest,
        }
    }

    /// The errors of as many rows as `out` holds, from row `top` on.
    fn band(
        &self,
        width: usize,
        height: usize,
        top: usize,
        pixels: &impl Fn(usize) -> [[f32; 3]; 2],
        out: &mut [f32],
    ) {
        let reach = self.color_radius.max(self.feature_radius);
        let rows = out.len() / width;
        let first = top.saturating_sub(reach);
        let last = (top + rows + reach).min(height);
        let [reference, test] = self.along_rows(width, first..last, pixels);
        let mut columns = [Columns::new(width), Columns::new(width)];
        for (row, out) in out.chunks_exact_mut(width).enumerate() {
            for (columns, filtered) in columns.iter_mut().zip([&reference, &test]) {
                self.down_columns(columns, filtered, width, height, first, top + row);
            }
            let [reference, test] = &columns;
            for (x, out) in out.iter_mut().enumerate() {
                let color = self.color_error(distance(
                    self.seen(reference.color(x)),
                    self.seen(test.color(x)),
                ));
                let edge = (reference.edge(x) - test.edge(x)).abs();
                let point = (reference.point(x) - test.point(x)).abs();
                let feature =
                    (std::f32::consts::FRAC_1_SQRT_2 * edge.max(point)).powf(FEATURE_EXPONENT);
                *out = color.powf(1.0 - feature);
            }
        }
    }

    /// The first direction of both pictures' filters; beyond the edges the last pixel goes on.
    fn along_rows(
        &self,
        width: usize,
        rows: std::ops::Range<usize>,
        pixels: &impl Fn(usize) -> [[f32; 3]; 2],
    ) -> [Filtered; 2] {
        let reach = self.color_radius.max(self.feature_radius);
        let empty = || -> Filtered { std::array::from_fn(|_| vec![0.0; width * rows.len()]) };
        let mut filtered = [empty(), empty()];
        // Y, Cx and Cz of a row of both pictures, with the pixels beyond its ends.
        let mut wide: [[Vec<f32>; 3]; 2] =
            std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; width + 2 * reach]));
        for (index, y) in rows.enumerate() {
            for x in 0..width {
                for (wide, pixel) in wide.iter_mut().zip(pixels(y * width + x)) {
                    let opponent = times(&self.to_opponent, pixel);
                    for (channel, value) in wide.iter_mut().zip(opponent) {
                        channel[reach + x] = value;
                    }
                }
            }
            for (wide, filtered) in wide.iter_mut().zip(&mut filtered) {
                for channel in wide.iter_mut() {
                    let (left, right) = (channel[reach], channel[reach + width - 1]);
                    channel[..reach].fill(left);
                    channel[reach + width..].fill(right);
                }
                let [lightness, red_green, blue_yellow] = &*wide;
                let sources = [
                    (lightness, &self.color[0]),
                    (red_green, &self.color[1]),
                    (blue_yellow, &self.color[2]),
                    (blue_yellow, &self.color[3]),
                    (lightness, &self.feature[0]),
                    (lightness, &self.feature[1]),
                    (lightness, &self.feature[2]),
                ];
                for (out, (source, weights)) in filtered.iter_mut().zip(sources) {
                    let out = &mut out[index * width..][..width];
                    let begin = reach - weights.len() / 2;
                    for (tap, weight) in weights.iter().enumerate() {
                        add(out, &source[begin + tap..], *weight);
                    }
                }
            }
        }
        filtered
    }

    /// The second direction, for one row.
    fn down_columns(
        &self,
        columns: &mut Columns,
        filtered: &Filtered,
        width: usize,
        height: usize,
        first: usize,
        y: usize,
    ) {
        let [gauss, slope, curvature] = &self.feature;
        let [
            lightness,
            red_green,
            blue_yellow,
            blue_yellow_too,
            smooth,
            dx,
            ddx,
        ] = filtered;
        let sources = [
            (lightness, &self.color[0]),
            (red_green, &self.color[1]),
            (blue_yellow, &self.color[2]),
            (blue_yellow_too, &self.color[3]),
            (dx, gauss),
            (smooth, slope),
            (ddx, gauss),
            (smooth, curvature),
        ];
        for (out, (source, weights)) in columns.0.iter_mut().zip(sources) {
            out.fill(0.0);
            let radius = weights.len() / 2;
            for (tap, weight) in weights.iter().enumerate() {
                let row = (y + tap).saturating_sub(radius).min(height - 1) - first;
                add(out, &source[row * width..], *weight);
            }
        }
    }

    /// What the eye makes of a filtered colour, Y 16 too great: a colour of the screen in L*a*b*, less colourful where dark.
    fn seen(&self, opponent: [f32; 3]) -> [f32; 3] {
        let color = times(&self.from_opponent, opponent).map(|value| value.clamp(0.0, 1.0));
        lab(&self.to_white, color)
    }

    /// A distance of colours as an error, 0..=1 (section 4.1.2 of the paper).
    fn color_error(&self, distance: f32) -> f32 {
        let (error, knee) = (distance.powf(COLOR_EXPONENT), KNEE * self.largest);
        if error < knee {
            error * (KNEE_ERROR / knee)
        } else {
            KNEE_ERROR + (error - knee) / (self.largest - knee) * (1.0 - KNEE_ERROR)
        }
    }
}

/// A row of a picture with both directions filtered: Y, Cx, Cz's parts, and the first and second derivatives of Y across
/// and down.
struct Columns([Vec<f32>; 8]);

impl Columns {
    fn new(width: usize) -> Self {
        Self(std::array::from_fn(|_| vec![0.0; width]))
    }

    fn color(&self, x: usize) -> [f32; 3] {
        [self.0[0][x], self.0[1][x], self.0[2][x] + self.0[3][x]]
    }

    /// Y goes from 0 to 116, and features are of light from 0 to 1.
    fn edge(&self, x: usize) -> f32 {
        Vec2::new(self.0[4][x], self.0[5][x]).length() / 116.0
    }

    fn point(&self, x: usize) -> f32 {
        Vec2::new(self.0[6][x], self.0[7][x]).length() / 116.0
    }
}

/// `out[i] += weight * source[i]`.
fn add(out: &mut [f32], source: &[f32], weight: f32) {
    for (out, source) in out.iter_mut().zip(source) {
        *out += weight * source;
    }
}

fn times(matrix: &[[f32; 3]; 3], [a, b, c]: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * a + row[1] * b + row[2] * c)
}

/// CIE L*a*b* with Hunt's adjustment (section 4.1.2): colours of less light are less colourful.
fn lab(to_white: &[[f32; 3]; 3], color: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = times(to_white, color).map(|t| {
        if t > DELTA * DELTA * DELTA {
            t.cbrt()
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// HyAB of Abasi et al. 2020: lightness by its difference, colour by its distance.
fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + Vec2::new(a[1] - b[1], a[2] - b[2]).length()
}

/// The filters of colour, each of sum 1; Cz's is a sum of two Gaussians, each the product of its directions.
fn color_filters(radius: usize, pixels_per_degree: f64) -> [Vec<f32>; 4] {
    let gauss = |b: f64| -> Vec<f64> {
        (0..=2 * radius)
            .map(|i| {
                let x = (i as f64 - radius as f64) / pixels_per_degree;
                (-PI * PI * x * x / b).exp()
            })
            .collect()
    };
    let scaled = |filter: &[f64], factor: f64| filter.iter().map(|w| (w * factor) as f32).collect();
    let normal = |b: f64| {
        let filter = gauss(b);
        scaled(&filter, 1.0 / filter.iter().sum::<f64>())
    };
    // The factor of a Gaussian stands once in the product of both directions: its root in each.
    let parts = BLUE_YELLOW.map(|(a, b)| {
        let factor = (a * (PI / b).sqrt()).sqrt();
        gauss(b).iter().map(|w| w * factor).collect::<Vec<f64>>()
    });
    let squares: f64 = parts
        .iter()
        .map(|part| part.iter().sum::<f64>().powi(2))
        .sum();
    let norm = 1.0 / squares.sqrt();
    [
        normal(ACHROMATIC.1),
        normal(RED_GREEN.1),
        scaled(&parts[0], norm),
        scaled(&parts[1], norm),
    ]
}

/// A Gaussian of sum 1 and its derivatives, whose weights of each sign have the sum 1.
fn feature_filters(radius: usize, sigma: f64) -> [Vec<f32>; 3] {
    let places = || (0..=2 * radius).map(|i| i as f64 - radius as f64);
    let gauss = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
    let normal = |filter: Vec<f64>| -> Vec<f32> {
        let sum_of = |sign: f64| -> f64 { filter.iter().map(|w| (w * sign).max(0.0)).sum() };
        let (positive, negative) = (sum_of(1.0), sum_of(-1.0));
        filter
            .iter()
            .map(|w| {
                (w / if *w > 0.0 {
                    positive
                } else {
                    negative.max(f64::MIN_POSITIVE)
                }) as f32
            })
            .collect()
    };
    [
        normal(places().map(gauss).collect()),
        normal(places().map(|x| -x * gauss(x)).collect()),
        normal(
            places()
                .map(|x| (x * x / (sigma * sigma) - 1.0) * gauss(x))
                .collect(),
        ),
    ]
}

#[cfg(test)]
#[path = "../../tests/unit/measure/flip.rs"]
mod tests;
