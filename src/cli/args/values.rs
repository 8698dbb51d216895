//! How the text of an argument becomes a value, or a clause that says what was expected.

use crate::film::objects::Mist;
use crate::nodes::CyclesVersion;
use crate::render::RenderSettings;
use clap::Arg;
use clap::builder::{ArgExt, PossibleValue, PossibleValuesParser, TypedValueParser};
use std::ops::{Range, RangeInclusive};
use std::time::Duration;

/// Most bounces; Cycles has the same.
pub const MAX_BOUNCES: u32 = 1024;
/// Most samples a pixel.
pub const MAX_SAMPLES: u32 = 1 << 20;
/// Longest time that can be asked for: a hundred years.
const MAX_SECONDS: f64 = 100.0 * 365.25 * 86_400.0;

/// Linear Rec.709.
pub type Color = [f32; 3];
/// The first bounce at which paths may end by chance; `None` for never.
pub type Roulette = Option<u32>;
/// Of a pixel: column, row, number.
pub type Sample = (u32, u32, u32);
/// From, and the one after the last.
pub type SampleRange = Range<u32>;

/// The bounds of a whole number, for the list of flags.
#[derive(Clone, Debug)]
pub struct Whole(pub RangeInclusive<u32>);
impl ArgExt for Whole {}

/// The bounds of a number, for the list of flags.
#[derive(Clone, Debug)]
pub struct Number(pub RangeInclusive<f64>);
impl ArgExt for Number {}

/// What holds without the flag where the scene has no say: help shows it as a default, but whoever reads the flag learns that it
/// was not given.
#[derive(Clone, Debug)]
pub struct Preset(pub &'static str);
impl ArgExt for Preset {}

/// What the derived commands call for their arguments beyond clap's own: `#[arg(whole = 1..=64)]`.
pub trait Kinds {
    /// A whole number within bounds, both included.
    fn whole(self, range: RangeInclusive<u32>) -> Self;
    /// A finite number within bounds, both included.
    fn number(self, range: RangeInclusive<f64>) -> Self;
    /// What holds if it is not given.
    fn preset(self, value: &'static str) -> Self;
}

impl Kinds for Arg {
    fn whole(self, range: RangeInclusive<u32>) -> Self {
        let (min, max) = (*range.start(), *range.end());
        let parse = move |text: &str| {
            let number = text.parse().ok().filter(|n| (min..=max).contains(n));
            number.ok_or_else(|| format!("expected a whole number from {min} to {max}"))
        };
        self.value_parser(parse).add(Whole(range))
    }

    fn number(self, range: RangeInclusive<f64>) -> Self {
        let (min, max) = (*range.start(), *range.end());
        let parse = move |text: &str| {
            let number = text.parse().ok().filter(|n| (min..=max).contains(n));
            number.ok_or_else(|| format!("expected a number from {min} to {max}"))
        };
        self.value_parser(parse)
            .allow_negative_numbers(min < 0.0)
            .add(Number(range))
    }

    fn preset(self, value: &'static str) -> Self {
        self.add(Preset(value))
    }
}

/// A word, what it means, and what it stands for.
pub type Word<T> = (&'static str, &'static str, T);

/// One of a few words.
pub fn words<T>(table: &'static [Word<T>]) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    let shown = table
        .iter()
        .map(|(word, meaning, _)| PossibleValue::new(*word).help(*meaning));
    PossibleValuesParser::new(shown).try_map(move |text| {
        let word = table.iter().find(|(word, ..)| *word == text);
        word.map(|(.., value)| value.clone())
            .ok_or("there is no such word")
    })
}

/// `a`, `a or b`, `a, b or c`.
pub fn alternatives(names: &[String]) -> String {
    match names.split_last() {
        None => String::new(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}

/// All numbers of a list with commas between them.
fn list<T: std::str::FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let numbers = text.split(',').map(|part| part.trim().parse().ok());
    numbers.collect::<Option<Vec<T>>>()?.try_into().ok()
}

/// `on`, `off`, or a bounce from 1.
pub fn roulette(text: &str) -> Result<Roulette, String> {
    match text {
        "on" => Ok(RenderSettings::default().roulette),
        "off" => Ok(None),
        _ => {
            let bounce = text.parse().ok().filter(|n| (1..=MAX_BOUNCES).contains(n));
            bounce
                .map(Some)
                .ok_or_else(|| format!("expected on, off or a bounce from 1 to {MAX_BOUNCES}"))
        }
    }
}

/// `X,Y,SAMPLE`.
pub fn sample(text: &str) -> Result<Sample, String> {
    let numbers = list(text).map(|[x, y, sample]| (x, y, sample));
    numbers.ok_or_else(|| "expected three whole numbers X,Y,SAMPLE, such as 12,30,5".into())
}

/// `A..B`.
pub fn sample_range(text: &str) -> Result<SampleRange, String> {
    let ends = text.split_once("..").and_then(|(from, to)| {
        let range: SampleRange = from.trim().parse().ok()?..to.trim().parse().ok()?;
        (!range.is_empty()).then_some(range)
    });
    ends.ok_or_else(|| "expected two whole numbers A..B with A < B, such as 0..64".into())
}

/// `4G`, `512M`, `1.5GiB`, `100000`: binary multiples.
pub fn bytes(text: &str) -> Result<u64, String> {
    let lower = text.trim().to_lowercase();
    let number = lower.trim_end_matches("ib").trim_end_matches('b');
    let (number, factor) = match number.strip_suffix(['k', 'm', 'g', 't']) {
        Some(rest) => {
            let unit = number.chars().last().and_then(|c| "kmgt".find(c));
            (rest, 1024f64.powi(unit.map_or(0, |at| at as i32 + 1)))
        }
        None => (number, 1.0),
    };
    let count = number.trim().parse::<f64>().ok();
    let count = count.map(|n| n * factor);
    // Whole numbers of bytes, of which `as` keeps all.
    let count = count.filter(|n| n.is_finite() && *n >= 1.0 && *n < 1e18);
    let count = count.map(|n| n as u64);
    count.ok_or_else(|| "expected a number of bytes such as 512M or 4G".into())
}

/// `90`, `90s`, `1.5m`, `1h30m`.
pub fn duration(text: &str) -> Result<Duration, String> {
    let seconds = seconds(text).filter(|&seconds| seconds > 0.0 && seconds <= MAX_SECONDS);
    let duration = seconds.map(Duration::from_secs_f64);
    duration.ok_or_else(|| "expected a length of time such as 30s, 2m or 1h30m".into())
}

fn seconds(text: &str) -> Option<f64> {
    let mut seconds = 0.0;
    let mut rest = text.trim();
    let mut smallest_unit = f64::INFINITY;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.');
        let (number, after) = rest.split_at(digits.unwrap_or(rest.len()));
        let letters = after.find(|c: char| !c.is_ascii_alphabetic());
        let (unit, after) = after.split_at(letters.unwrap_or(after.len()));
        let unit = match unit {
            "" if smallest_unit.is_infinite() && after.is_empty() => 1.0,
            "ms" => 1e-3,
            "s" => 1.0,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            _ => return None,
        };
        // Units go down: `30s2m` is more likely a slip than a wish.
        if unit >= smallest_unit {
            return None;
        }
        smallest_unit = unit;
        seconds += number.parse::<f64>().ok()? * unit;
        rest = after;
    }
    Some(seconds)
}

/// `R,G,B`.
pub fn color(text: &str) -> Result<Color, String> {
    let color = list(text).filter(|color: &Color| color.iter().all(|&c| c.is_finite() && c >= 0.0));
    color.ok_or_else(|| {
        "expected three numbers of at least 0 with commas between them, such as 0.5,0.5,0.5".into()
    })
}

/// A version of Cycles.
pub fn cycles(text: &str) -> Result<CyclesVersion, String> {
    // The oldest that the add-on runs in. Later versions than the latest that is known are as that one.
    let oldest = CyclesVersion::new(4, 2);
    let version = text.parse().ok().filter(|version| *version >= oldest);
    version.ok_or_else(|| format!("expected a version of Blender from {oldest} on, such as 4.5"))
}

/// A share above 0, as a number or in percent.
pub fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(percent) => (percent.trim_end(), 0.01),
        None => (text.trim(), 1.0),
    };
    let share = number.parse::<f64>().ok().map(|number| number * unit);
    share
        .filter(|&share| share > 0.0 && share.is_finite())
        .ok_or_else(|| "expected a share above 0 such as 0.05 or 5%".into())
}

/// Blender's mist: three numbers that are not negative, the last one above 0.
pub fn mist(text: &str) -> Result<Mist, String> {
    let numbers = text.split(',').map(|part| part.trim().parse::<f32>().ok());
    let numbers: Option<Vec<f32>> = numbers.collect();
    let three = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    three
        .filter(|n| n.iter().all(|v| v.is_finite() && *v >= 0.0) && n[2] > 0.0)
        .map(|[start, depth, falloff]| Mist {
            start,
            depth,
            falloff,
        })
        .ok_or_else(|| "expected a start, a depth and a power above 0, such as 5,25,2".into())
}

/// Frames a second of a new file of Blender's.
const FRAME_RATE: f64 = 24.0;

/// A frame of an animation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Its time.
    pub seconds: f64,
    /// Its number, where no rate was given with it.
    pub number: Option<f64>,
}

/// A frame: its number, and after `@` how many there are in a second.
pub fn frame(text: &str) -> Result<Frame, String> {
    let (number, rate) = match text.split_once('@') {
        Some((number, rate)) => (number, rate.trim().parse().ok()),
        None => (text, Some(FRAME_RATE)),
    };
    let bare = !text.contains('@');
    let number: Option<f64> = number.trim().parse().ok();
    number
        .zip(rate)
        .filter(|(number, rate)| number.is_finite() && rate.is_finite() && *rate > 0.0)
        .map(|(number, rate)| Frame {
            seconds: number / rate,
            number: bare.then_some(number),
        })
        .ok_or_else(|| "expected a number, or a number and frames a second, such as 12@30".into())
}

#[cfg(test)]
#[path = "../../../tests/unit/cli/args/values.rs"]
mod tests;
