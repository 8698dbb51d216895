//! A number for each pixel, in colours with a scale.

use super::axis::Range;
use super::number::number;
use super::picture::indexed_png;
use super::{Axis, PageImage, ReportError, draw};
use flate2::{Compression, write::ZlibEncoder};
use plotters::style::text_anchor::HPos;
use std::io::Write;

/// One number for each pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// What the numbers are.
    pub name: String,
    /// In what; empty for mere numbers.
    pub unit: String,
    /// What there is to know about them; may be empty.
    pub note: String,
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Rows from top to bottom.
    pub values: Vec<f32>,
    /// Whether the colours follow the logarithm.
    pub log: bool,
    /// What the brightest colour stands for; what nearly all pixels stay below where it is not given.
    pub brightest: Option<f64>,
}

/// So many pixels may lie beyond each end of the scale: one bright one must not make all others black.
const BEYOND: f64 = 0.001;

/// The colour of what is not finite; the palette has no such colour.
const NOT_FINITE: [u8; 3] = [0, 160, 255];

/// Rows below a picture for its scale, and of its coloured bar.
const SCALE_ROWS: u32 = 26;
const BAR_ROWS: u32 = 10;
/// So wide a picture is at least, so that the scale has room.
const LEAST_WIDTH: u32 = 96;

/// Steps of the palette; the code after the last is the colour of what is not finite.
const COLORS: usize = 256;

/// What a page shows of a heat map.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shown {
    /// The coloured picture.
    pub png: Vec<u8>,
    /// Where labels of the scale stand, from 0 to 1, and what they say.
    pub labels: Vec<(f64, String)>,
    /// The scale's colours from left to right, as `#rrggbb`.
    pub colors: Vec<String>,
    /// The numbers, for the value under the pointer.
    pub codes: Codes,
    /// Pixels whose number is not finite.
    pub not_finite: usize,
}

/// The numbers in 16 bits, compressed: 65535 is not finite, 0 is zero or less on a logarithmic scale, the codes 1 to
/// 65534 go evenly from `low` to `high` (which are logarithms to base 10 on a logarithmic scale). Each code is stored
/// as its difference from the one on its left, all high bytes before all low ones (both compress better so), by zlib.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Codes {
    pub low: f64,
    pub high: f64,
    pub log: bool,
    pub bytes: Vec<u8>,
}

impl HeatMap {
    /// What the colours measure.
    pub(super) fn axis(&self) -> Axis {
        Axis {
            label: self.name.clone(),
            unit: self.unit.clone(),
            log: self.log,
        }
    }

    /// The same map, its brightest colour standing for a round number that at most 0.1 % of the pixels exceed.
    #[must_use]
    pub fn with_round_end(self) -> Self {
        let (_, high) = self.scale(&self.axis()).ends();
        Self {
            brightest: Some(round_up(high)),
            ..self
        }
    }

    /// The map in colours.
    pub fn picture(&self) -> PageImage {
        let palette = palette();
        let color = |index: &u16| *palette.get(usize::from(*index)).unwrap_or(&NOT_FINITE);
        PageImage {
            name: self.name.clone(),
            width: self.width,
            height: self.height,
            rgb: self.indices().iter().flat_map(color).collect(),
        }
    }

    /// The map in colours, with a bar of them below and the numbers of its ends.
    ///
    /// # Errors
    /// The values do not fit the size, or the library cannot draw the numbers.
    pub fn picture_with_scale(&self) -> Result<PageImage, ReportError> {
        self.check()?;
        let (map, palette) = (self.picture(), palette());
        let (width, height) = (self.width.max(LEAST_WIDTH), self.height + SCALE_ROWS);
        let mut rgb = vec![0; 3 * width as usize * height as usize];
        let row = 3 * width as usize;
        for (into, from) in rgb
            .chunks_exact_mut(row)
            .zip(map.rgb.chunks_exact(3 * self.width as usize))
        {
            into[..from.len()].copy_from_slice(from);
        }
        let bar =
            (0..width as usize).flat_map(|x| palette[x * (COLORS - 1) / (width as usize - 1)]);
        let bar: Vec<u8> = bar.collect();
        for into in rgb
            .chunks_exact_mut(row)
            .skip(self.height as usize + 2)
            .take(BAR_ROWS as usize)
        {
            into.copy_from_slice(&bar);
        }
        let (low, high) = self.scale(&self.axis()).ends();
        let y = self.height + BAR_ROWS + 2;
        let labels = [(low, 1, HPos::Left), (high, width - 1, HPos::Right)];
        draw::labels(
            &mut rgb,
            (width, height),
            &labels.map(|(value, x, side)| (number(value), (x, y), side)),
        )
        .map_err(|reason| self.not_shown(reason))?;
        Ok(PageImage {
            name: map.name,
            width,
            height,
            rgb,
        })
    }

    fn not_shown(&self, reason: String) -> ReportError {
        ReportError::NotShown {
            picture: self.name.clone(),
            reason,
        }
    }

    fn check(&self) -> Result<(), ReportError> {
        if self.values.is_empty() || self.values.len() != self.width as usize * self.height as usize
        {
            return Err(self.not_shown(format!(
                "{} numbers do not make {} × {} pixels",
                self.values.len(),
                self.width,
                self.height
            )));
        }
        Ok(())
    }

    /// The number of each pixel's colour; of what is not finite, one beyond the last.
    fn indices(&self) -> Vec<u16> {
        let range = self.scale(&self.axis());
        let index = |value: &f32| match f64::from(*value) {
            value if !value.is_finite() => COLORS as u16,
            value if self.log && value <= 0.0 => 0,
            value => (range.position(value).clamp(0.0, 1.0) * (COLORS - 1) as f64).round() as u16,
        };
        self.values.iter().map(index).collect()
    }

    /// Colours, scale and codes.
    pub(super) fn shown(&self) -> Result<Shown, ReportError> {
        self.check()?;
        let axis = self.axis();
        let palette = palette();
        Ok(Shown {
            png: self.colored(&self.indices(), &palette)?,
            labels: self.scale(&axis).labels(6),
            colors: (0..=16)
                .map(|step| {
                    let [r, g, b] = palette[step * (COLORS - 1) / 16];
                    format!("#{r:02x}{g:02x}{b:02x}")
                })
                .collect(),
            codes: self.codes(&axis)?,
            not_finite: self.values.iter().filter(|v| !v.is_finite()).count(),
        })
    }

    /// What the colours range over: from 0 (or, on a logarithmic scale, the least) to the largest, without the most
    /// extreme pixels.
    fn scale(&self, axis: &Axis) -> Range {
        let mut sorted: Vec<f64> = self.values.iter().map(|value| f64::from(*value)).collect();
        sorted.retain(|value| axis.shows(*value));
        sorted.sort_unstable_by(f64::total_cmp);
        let beyond = (sorted.len() as f64 * BEYOND) as usize;
        let kept = sorted
            .get(beyond..sorted.len() - beyond)
            .unwrap_or_default();
        let low = kept.first().copied();
        let high = self.brightest.or(kept.last().copied());
        let ends = low.into_iter().chain(high);
        if self.log {
            Range::exactly(axis, ends)
        } else {
            Range::exactly(axis, ends.chain([0.0]))
        }
    }

    fn colored(&self, indices: &[u16], palette: &[[u8; 3]]) -> Result<Vec<u8>, ReportError> {
        // A palette of a PNG has 256 colours at most; the last but one of magma is not told from the last.
        let mut colors: Vec<[u8; 3]> = palette.to_vec();
        colors[COLORS - 1] = NOT_FINITE;
        let bytes: Vec<u8> = indices
            .iter()
            .map(|index| match usize::from(*index) {
                COLORS => (COLORS - 1) as u8,
                index => index.min(COLORS - 2) as u8,
            })
            .collect();
        indexed_png(&self.name, (self.width, self.height), &bytes, &colors)
    }

    fn codes(&self, axis: &Axis) -> Result<Codes, ReportError> {
        let value_of = |value: f32| {
            let value = f64::from(value);
            if self.log { value.log10() } else { value }
        };
        let shown = || {
            self.values
                .iter()
                .filter(|value| axis.shows(f64::from(**value)))
                .map(|value| value_of(*value))
        };
        let low = shown().fold(f64::INFINITY, f64::min);
        let high = shown().fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        // Whole numbers (sample counts) stay exact: a code is then a whole step.
        let whole = !self.log && shown().all(|value| value.fract() == 0.0);
        let high = if whole && high - low < 65533.0 {
            low + 65533.0
        } else if high > low {
            high
        } else {
            low + 1.0
        };
        let codes = self.values.iter().map(|value| {
            if !value.is_finite() {
                u16::MAX
            } else if !axis.shows(f64::from(*value)) {
                0
            } else {
                let share = (value_of(*value) - low) / (high - low);
                1 + (share * 65533.0).round() as u16
            }
        });
        let mut before = 0u16;
        let differences: Vec<[u8; 2]> = codes
            .map(|code| {
                let difference = code.wrapping_sub(before);
                before = code;
                difference.to_be_bytes()
            })
            .collect();
        let bytes: Vec<u8> = (0..2)
            .flat_map(|byte| differences.iter().map(move |pair| pair[byte]))
            .collect();
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        let bytes = encoder
            .write_all(&bytes)
            .and_then(|()| encoder.finish())
            .map_err(|error| self.not_shown(error.to_string()))?;
        Ok(Codes {
            low,
            high,
            log: self.log,
            bytes,
        })
    }
}

/// The next of …, 0.1, 0.2, 0.5, 1, 2, 5, … (1e-6 for nothing).
fn round_up(value: f64) -> f64 {
    if value <= 1e-6 || !value.is_finite() {
        return 1e-6;
    }
    let power = value.log10().floor() as i32;
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * 10f64.powi(power));
    let enough = |step: &f64| *step >= value * (1.0 - 1e-12);
    steps.into_iter().find(enough).unwrap_or(value)
}

/// "Magma" (van der Walt and Smith 2015): even steps of lightness, also for the colour-blind.
fn palette() -> Vec<[u8; 3]> {
    (0..COLORS)
        .map(|step| colorous::MAGMA.eval_rational(step, COLORS).as_array())
        .collect()
}

#[cfg(test)]
#[path = "../../tests/unit/report/heat_map.rs"]
mod tests;
