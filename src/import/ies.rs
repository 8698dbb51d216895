//! Photometric files of luminaires (ANSI/IES LM-63, 1986 to 2019).

use crate::nodes::ies::{Beyond, IesProfile};
use std::f64::consts::{FRAC_PI_2, TAU};

/// A file has thousands of values at most; more than this would be an accident.
const MOST_VALUES: usize = 1 << 22;

/// What a file says.
#[derive(Clone, Debug)]
pub(super) struct Luminaire {
    /// Candela by angle about −Z (type C).
    pub candela: IesProfile,
    /// Their mean over all directions.
    pub mean: f64,
    /// The angles are of another type than C, and only the mean counts.
    pub is_of_another_type: bool,
}

/// Reads the text of a file.
pub(super) fn parse(bytes: &[u8]) -> Result<Luminaire, String> {
    let text = String::from_utf8_lossy(bytes);
    let (head, body) = after_tilt(&text).ok_or("it has no line that begins with TILT=")?;
    let mut numbers = Numbers(body.split(|c: char| c.is_whitespace() || c == ','));
    if head.trim().eq_ignore_ascii_case("INCLUDE") {
        numbers.skip(1)?;
        let pairs = numbers.count()?;
        numbers.skip(pairs.saturating_mul(2))?;
    }
    // Lamps and lumens.
    numbers.skip(2)?;
    let multiplier = numbers.next()?;
    let (down, around) = (numbers.count()?, numbers.count()?);
    let kind = numbers.next()?;
    // Units, and three sizes.
    numbers.skip(4)?;
    let ballast = numbers.next()?;
    // The ballast's lamp factor up to 1995, and something else since; and watts.
    numbers.skip(2)?;
    let total = down
        .checked_mul(around)
        .filter(|n| (1..=MOST_VALUES).contains(n));
    let total = total.ok_or_else(|| format!("it says that it has {down} × {around} values"))?;
    let mut list = |count: usize| {
        (0..count)
            .map(|_| numbers.next())
            .collect::<Result<Vec<f64>, _>>()
    };
    let (vertical, horizontal) = (list(down)?, list(around)?);
    let scale = multiplier * ballast;
    let values: Vec<f64> = list(total)?.iter().map(|v| (v * scale).max(0.0)).collect();
    let rises = |angles: &[f64]| angles.windows(2).all(|w| w[0] < w[1]);
    if !rises(&vertical) || !rises(&horizontal) {
        return Err("its angles do not rise".into());
    }
    if !values.iter().all(|v| v.is_finite()) {
        return Err("its values are not finite".into());
    }
    if kind != 1.0 {
        let mean = values.iter().sum::<f64>() / total as f64;
        return Ok(Luminaire {
            candela: even(mean as f32),
            mean,
            is_of_another_type: true,
        });
    }
    of_type_c(&vertical, &horizontal, &values)
}

/// What stands behind TILT= in its line, and the lines after it.
fn after_tilt(text: &str) -> Option<(&str, &str)> {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        at += line.len();
        if let Some(rest) = line.trim_start().strip_prefix("TILT=") {
            return Some((rest, &text[at..]));
        }
    }
    None
}

/// The numbers of a text.
struct Numbers<I>(I);

impl<'a, I: Iterator<Item = &'a str>> Numbers<I> {
    fn next(&mut self) -> Result<f64, String> {
        let word = self.0.by_ref().find(|word| !word.is_empty());
        let word = word.ok_or("it is cut off")?;
        let number = word.parse::<f64>().ok().filter(|n| n.is_finite());
        number.ok_or_else(|| {
            let short: String = word.chars().take(20).collect();
            format!("\"{short}\" stands where a number belongs")
        })
    }

    fn count(&mut self) -> Result<usize, String> {
        let number = self.next()?;
        // Whole numbers, of which `as` keeps all.
        let is_count = number.fract() == 0.0 && (0.0..=MOST_VALUES as f64).contains(&number);
        is_count
            .then_some(number as usize)
            .ok_or_else(|| format!("{number} is no number of values"))
    }

    fn skip(&mut self, count: usize) -> Result<(), String> {
        (0..count).try_for_each(|_| self.next().map(drop))
    }
}

/// The same all around.
fn even(candela: f32) -> IesProfile {
    IesProfile {
        around: vec![0.0, TAU as f32],
        down: vec![0.0, std::f32::consts::PI],
        strengths: vec![candela; 4],
        beyond: Beyond::Same,
    }
}

/// Columns of values by the angle about the axis in degrees, all around.
fn all_around(horizontal: &[f64], values: &[f64], rows: usize) -> Vec<(f64, Vec<f64>)> {
    let columns: Vec<(f64, Vec<f64>)> = horizontal
        .iter()
        .zip(values.chunks(rows))
        .map(|(angle, column)| (*angle, column.to_vec()))
        .collect();
    let (first, last) = (columns[0].0, columns[columns.len() - 1].0);
    let mirrored = |columns: &[(f64, Vec<f64>)], about: f64| {
        let mut both = columns.to_vec();
        let others = columns.iter().rev().filter(|(angle, _)| *angle != about);
        both.extend(others.map(|(angle, column)| (2.0 * about - angle, column.clone())));
        both
    };
    if columns.len() == 1 || last == first {
        let column = columns[0].1.clone();
        return vec![(0.0, column.clone()), (360.0, column)];
    }
    // Quarters and halves stand for what is symmetric (LM-63-2002, 5.12); 90 to 270 is of LM-63-1995.
    let whole = if first == 0.0 && last == 90.0 {
        mirrored(&mirrored(&columns, 90.0), 180.0)
    } else if first == 0.0 && last == 180.0 {
        mirrored(&columns, 180.0)
    } else if first == 90.0 && last == 270.0 {
        let mut half: Vec<_> = mirrored(&columns, 270.0)
            .into_iter()
            .map(|(angle, column)| (angle % 360.0, column))
            .collect();
        half.sort_by(|a, b| a.0.total_cmp(&b.0));
        half.dedup_by(|a, b| a.0 == b.0);
        half
    } else {
        columns
    };
    closed(whole)
}

/// Begins at 0 and ends at 360, where it is the same.
fn closed(mut columns: Vec<(f64, Vec<f64>)>) -> Vec<(f64, Vec<f64>)> {
    columns.retain(|(angle, _)| (0.0..=360.0).contains(angle));
    let ends = (columns.first().cloned(), columns.last().cloned());
    let (Some(first), Some(last)) = ends else {
        return columns;
    };
    match (first.0 == 0.0, last.0 == 360.0) {
        (true, true) => {}
        (true, false) => columns.push((360.0, first.1)),
        (false, true) => columns.insert(0, (0.0, last.1)),
        (false, false) => {
            // Between the last and the first, by their distances from 0.
            let (before, after) = (360.0 - last.0, first.0);
            let t = before / (before + after);
            let column: Vec<f64> = last
                .1
                .iter()
                .zip(&first.1)
                .map(|(a, b)| a + (b - a) * t)
                .collect();
            columns.insert(0, (0.0, column.clone()));
            columns.push((360.0, column));
        }
    }
    columns
}

/// A photometric web about −Z. Horizontal angles go from +X to +Y (EXT_lights_ies: counter-clockwise, in the X/Y plane); the
/// profile's own are atan2(x, y) + π, which is 3π/2 less the horizontal angle.
fn of_type_c(vertical: &[f64], horizontal: &[f64], values: &[f64]) -> Result<Luminaire, String> {
    let rows = vertical.len();
    let mut columns = all_around(horizontal, values, rows);
    if columns.len() < 2 {
        return Err("its horizontal angles are not within 0 and 360 degrees".into());
    }
    columns.pop();
    let mut turned: Vec<(f64, Vec<f64>)> = columns
        .into_iter()
        .map(|(angle, column)| ((270.0 - angle).rem_euclid(360.0), column))
        .collect();
    turned.sort_by(|a, b| a.0.total_cmp(&b.0));
    let columns = closed(turned);
    let mut vertical: Vec<f64> = vertical.to_vec();
    let mut columns: Vec<(f64, Vec<f64>)> = columns;
    if let [only] = *vertical {
        vertical = vec![only, only];
        for (_, column) in &mut columns {
            column.push(column[0]);
        }
    }
    // Trapezoids, by solid angle down and evenly around.
    let mut mean = 0.0;
    for (pair, angles) in columns
        .windows(2)
        .map(|w| ([&w[0].1, &w[1].1], w[1].0 - w[0].0))
    {
        for (row, ends) in vertical.windows(2).enumerate() {
            let share = ends[0].to_radians().cos() - ends[1].to_radians().cos();
            let four = pair.iter().map(|c| c[row] + c[row + 1]).sum::<f64>() / 4.0;
            mean += four * share * angles / 720.0;
        }
    }
    let profile = IesProfile {
        around: columns.iter().map(|(a, _)| a.to_radians() as f32).collect(),
        down: vertical.iter().map(|a| a.to_radians() as f32).collect(),
        strengths: columns
            .iter()
            .flat_map(|(_, column)| column.iter().map(|v| *v as f32))
            .collect(),
        beyond: Beyond::Same,
    };
    // f32 has 2π and π a little off; the ends are told by comparison.
    let profile = snapped(profile);
    if !profile.is_sane() {
        return Err("its numbers do not fit together".into());
    }
    Ok(Luminaire {
        candela: profile,
        mean,
        is_of_another_type: false,
    })
}

/// Ends at the whole circle and at the nadir's opposite exactly.
fn snapped(mut profile: IesProfile) -> IesProfile {
    let snap = |angles: &mut Vec<f32>, to: f64| {
        if let Some(last) = angles.last_mut()
            && (f64::from(*last) - to).abs() < 1e-5
        {
            *last = to as f32;
        }
    };
    snap(&mut profile.around, TAU);
    snap(&mut profile.down, 2.0 * FRAC_PI_2);
    profile
}

#[cfg(test)]
#[path = "../../tests/unit/import/ies.rs"]
mod tests;
