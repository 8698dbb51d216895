//! IES files of lights (ANSI/IES LM-63): candela by direction.

use std::f64::consts::PI;

use crate::nodes::ies::{Beyond, IesProfile};

/// More angles than this are no luminaire.
const MOST_ANGLES: f64 = 10_000.0;
/// Angles nearer than this are the same, degrees.
const CLOSE: f64 = 1e-4;

/// What a file says: candela at all vertical angles for each horizontal angle, in degrees.
struct File {
    /// 1: about the vertical axis (type C). The others are about axes that lie across.
    kind: f64,
    down: Vec<f64>,
    around: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

/// Numbers of a text, one after the other.
struct Words<'a>(std::iter::Peekable<std::str::SplitAsciiWhitespace<'a>>);

impl Words<'_> {
    fn number(&mut self) -> Option<f64> {
        self.0.next()?.parse().ok().filter(|v: &f64| v.is_finite())
    }

    fn numbers(&mut self, count: usize) -> Option<Vec<f64>> {
        (0..count).map(|_| self.number()).collect()
    }
}

fn count(number: f64) -> Option<usize> {
    (1.0..=MOST_ANGLES)
        .contains(&number)
        .then_some(number as usize)
}

fn read(text: &str) -> Option<File> {
    let start = text.find("TILT=")?;
    let (tilt, rest) = text[start + 5..].split_once('\n')?;
    let plain = rest.replace(',', " ");
    let mut words = Words(plain.split_ascii_whitespace().peekable());
    if tilt.trim().eq_ignore_ascii_case("INCLUDE") {
        words.number()?;
        let pairs = count(words.number()?)?;
        words.numbers(2 * pairs)?;
    }
    let head = words.numbers(10)?;
    let (down, around) = (count(head[3])?, count(head[4])?);
    let ballast = words.numbers(3)?;
    let scale = head[2] * ballast[0] * ballast[1];
    let (down, around) = (words.numbers(down)?, words.numbers(around)?);
    let rises = |angles: &[f64]| angles.windows(2).all(|w| w[0] <= w[1]);
    let rows = around.iter().map(|_| {
        let row = words.numbers(down.len())?;
        Some(row.into_iter().map(|v| (v * scale).max(0.0)).collect())
    });
    let rows = rows.collect::<Option<Vec<Vec<f64>>>>()?;
    (rises(&down) && rises(&around)).then_some(File {
        kind: head[5],
        down,
        around,
        rows,
    })
}

/// Adds what files leave out because it is the same by symmetry, so that the angles about the axis go from 0° to 360°.
fn whole_turn(around: &mut Vec<f64>, rows: &mut Vec<Vec<f64>>) {
    let is = |a: f64, b: f64| (a - b).abs() < CLOSE;
    if around.first().is_some_and(|first| is(*first, 90.0)) {
        around.iter_mut().for_each(|angle| *angle -= 90.0);
    }
    if let [_] = around.as_slice() {
        *around = vec![0.0, 360.0];
        rows.extend_from_within(..);
        return;
    }
    for whole in [180.0, 360.0] {
        if around.last().is_some_and(|last| is(*last, 0.5 * whole)) {
            for at in (0..around.len() - 1).rev() {
                around.push(whole - around[at]);
                rows.push(rows[at].clone());
            }
        }
    }
    if let (Some(first), Some(last)) = (around.first(), around.last())
        && is(*first, 0.0)
        && *last < 360.0 - CLOSE
    {
        around.push(360.0);
        rows.push(rows[0].clone());
    }
}

/// The mean candela over all directions, by the trapezoid rule in cosines and angles.
fn mean(file: &File) -> f64 {
    let mut sum = 0.0;
    for (sides, rows) in file.around.windows(2).zip(file.rows.windows(2)) {
        for at in 0..file.down.len() - 1 {
            let cos = |at: usize| file.down[at].to_radians().cos();
            let ring = cos(at) - cos(at + 1);
            let all = rows[0][at] + rows[0][at + 1] + rows[1][at] + rows[1][at + 1];
            sum += 0.25 * all * ring * (sides[1] - sides[0]).to_radians();
        }
    }
    sum / (4.0 * PI)
}

/// The profile of a file's text, as UsdLux reads it: what the light is multiplied by in each direction. `scale` rescales the
/// angles from the axis: from 0° where it is above 0, from 180° where it is below.
pub(super) fn profile(text: &str, normalize: bool, scale: f64) -> Result<IesProfile, String> {
    let mut file = read(text).ok_or("it is no IES file, or a damaged one")?;
    if file.kind != 1.0 {
        return Err("its angles are not about the vertical axis (type C)".into());
    }
    whole_turn(&mut file.around, &mut file.rows);
    if file.down.len() < 2 {
        return Err("it has too few angles".into());
    }
    let share = if normalize { mean(&file) } else { 1.0 };
    if share <= 0.0 {
        return Err("it gives no light".into());
    }
    let rescaled = |angle: f64| {
        if scale > 0.0 {
            angle * scale
        } else if scale < 0.0 {
            180.0 - (180.0 - angle) * -scale
        } else {
            angle
        }
    };
    let profile = IesProfile {
        around: file.around.iter().map(|a| a.to_radians() as f32).collect(),
        down: file
            .down
            .iter()
            .map(|a| rescaled(*a).to_radians() as f32)
            .collect(),
        strengths: file
            .rows
            .iter()
            .flatten()
            .map(|v| (v / share) as f32)
            .collect(),
        beyond: Beyond::Same,
    };
    if profile.is_sane() {
        Ok(profile)
    } else {
        Err("its numbers do not fit together".into())
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/ies.rs"]
mod tests;
