//! Where an axis begins and ends, and where its ticks are. Linear axes have plotters' ticks. Logarithmic ones have their own:
//! plotters' knows powers of ten alone, so that an axis from 2 to 7 would have none.

use super::Axis;
use super::number::rounded;
use plotters::coord::ranged1d::{
    BoldPoints, KeyPointHint, KeyPointWeight, NoDefaultFormatting, Ranged, ValueFormatter,
};
use plotters::coord::types::RangedCoordf64;

/// The part of an axis that a plot shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    log: bool,
    /// Ends of the axis; their logarithms to base 10 if it is logarithmic.
    low: f64,
    high: f64,
}

/// So much of the axis stays free at both ends.
const MARGIN: f64 = 0.03;

impl Range {
    /// The range of all values that the axis can show, with a margin.
    pub fn of(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| axis.shows(*value)) {
            let value = if axis.log { value.log10() } else { value };
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        } else if axis.log {
            // At least from half to double, so that noise in an almost constant curve does not fill the plot.
            let least = std::f64::consts::LOG10_2;
            let missing = (2.0 * least - (high - low)).max(0.0) / 2.0;
            (low, high) = (low - missing, high + missing);
        } else if low == high {
            let half = if low == 0.0 { 1.0 } else { 0.5 * low.abs() };
            (low, high) = (low - half, high + half);
        }
        let margin = MARGIN * (high - low);
        // A linear axis of nothing but positive values that are not far from 0 begins there.
        if !axis.log && low >= 0.0 && low < 0.5 * high {
            (low, high) = (0.0, high + margin);
        } else {
            (low, high) = (low - margin, high + margin);
        }
        Self {
            log: axis.log,
            low,
            high,
        }
    }

    /// The range of all values that the axis can show and no more.
    pub fn exactly(axis: &Axis, values: impl Iterator<Item = f64> + Clone) -> Self {
        let with_margin = Self::of(axis, values.clone());
        let scaled = values
            .filter(|value| axis.shows(*value))
            .map(|value| if axis.log { value.log10() } else { value });
        let low = scaled.clone().fold(f64::INFINITY, f64::min);
        let high = scaled.fold(f64::NEG_INFINITY, f64::max);
        if low < high {
            Self {
                low,
                high,
                ..with_margin
            }
        } else {
            with_margin
        }
    }

    /// The first and the last value; their logarithms to base 10 if the axis is logarithmic.
    pub fn ends(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// Where a value is: 0 at the beginning of the axis, 1 at its end.
    pub fn position(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        (value - self.low) / (self.high - self.low)
    }

    /// Where labels stand, from 0 to 1, and what they say; at most `most`, or one more.
    pub fn labels(&self, most: usize) -> Vec<(f64, String)> {
        let values = self.key_points(BoldPoints(most)).into_iter();
        values
            .map(|value| (self.position(value), Self::format(&value)))
            .collect()
    }

    /// The value at a place.
    pub fn value(&self, position: f64) -> f64 {
        let value = self.low + position * (self.high - self.low);
        if self.log { 10f64.powf(value) } else { value }
    }

    /// Powers of ten, with 2 and 5 between them if there is room; all of their multiples for light lines.
    fn log_ticks(&self, most: usize, light: bool) -> Vec<f64> {
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let within = |value: f64| (0.0..=1.0).contains(&self.position(value));
        let all = |steps: &[i32], stride: i32| -> Vec<f64> {
            (first..=last)
                .filter(|power| power.rem_euclid(stride) == 0)
                .flat_map(|power| steps.iter().map(move |step| power_of_ten(*step, power)))
                .filter(|value| within(*value))
                .collect()
        };
        const DIGITS: &[i32] = &[1, 2, 3, 4, 5, 6, 7, 8, 9];
        let choices = [DIGITS, &[1, 2, 5], &[1, 3], &[1]].map(|steps| (steps, 1));
        let strides = (2..).map(|stride| (&[1][..], stride));
        let fitting = choices
            .into_iter()
            .chain(strides)
            .find_map(|(steps, stride)| {
                let ticks = all(steps, stride);
                (ticks.len() <= most).then_some((ticks, stride))
            });
        match fitting {
            Some((ticks, _)) if ticks.len() < 2 => {
                linear_ticks(10f64.powf(self.low), 10f64.powf(self.high), most)
            }
            Some((_, 1)) if light => all(DIGITS, 1),
            Some(_) if light => all(&[1], 1),
            Some((ticks, _)) => ticks,
            None => Vec::new(),
        }
    }
}

fn linear_ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
    RangedCoordf64::from(low..high).key_points(BoldPoints(most))
}

impl Ranged for Range {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        from + (self.position(*value) * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let most = hint.bold_points().max(2);
        let light = matches!(hint.weight(), KeyPointWeight::Any);
        match (self.log, light) {
            (true, _) => self.log_ticks(most, light),
            (false, true) => Vec::new(),
            (false, false) => linear_ticks(self.low, self.high, most),
        }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.value(0.0)..self.value(1.0)
    }
}

impl ValueFormatter<f64> for Range {
    fn format(value: &f64) -> String {
        tick_label(*value)
    }
}

impl Axis {
    /// Whether a value has a place on the axis.
    pub(super) fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.log || value > 0.0)
    }

    /// `time (s)`.
    pub(super) fn title(&self) -> String {
        if self.unit.is_empty() {
            self.label.clone()
        } else {
            format!("{} ({})", self.label, self.unit)
        }
    }
}

/// `step · 10^power`, rounded once, as a literal would be.
fn power_of_ten(step: i32, power: i32) -> f64 {
    format!("{step}e{power}").parse().unwrap_or(f64::NAN)
}

/// `0.05`, `20 000`, `3·10⁻⁷`.
fn tick_label(value: f64) -> String {
    // Twelve digits hide the rounding of multiples of a step.
    let size = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&size) {
        return rounded(value, 12);
    }
    let text = format!("{value:.11e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: String = exponent
        .chars()
        .map(|digit| match digit {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => digit
                .to_digit(10)
                .and_then(|number| char::from_u32(0x2070 + number))
                .unwrap_or(digit),
        })
        .collect();
    match rounded(mantissa.parse().unwrap_or(f64::NAN), 12).as_str() {
        "1" => format!("10{exponent}"),
        mantissa => format!("{mantissa}·10{exponent}"),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/report/axis.rs"]
mod tests;
