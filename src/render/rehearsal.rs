//! How long the output of a picture will take, by that of some bands of it.

use super::OutputTime;
use crate::film::{Bands, Extract};
use std::time::Duration;

/// Bands of a picture that are tried out.
const TRIED: usize = 4;
/// The remaining rows take this many times longer than the trial predicts, because the trial fits the processor's caches:
/// 0.97 to 1.25, median 1.12 of eight renders of 1280 pixels a row (cornell, foliage, many-lights, glass, 3 and 10 s). With
/// it three of cornell ended after 10.01 to 10.23 of 10 s.
const REMAINING_ROWS: f64 = 1.12;

/// How long a part of the output took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tried {
    /// Its files.
    pub files: Duration,
    /// The error of what one sees.
    pub seen_error: Duration,
}

impl OutputTime {
    /// By what it takes to make some bands of a picture.
    pub fn rehearsed(film: &dyn Bands, try_out: impl Fn(&Extract) -> Tried) -> Self {
        let (begun, blank): (Vec<_>, Vec<_>) =
            (0..film.bands().len()).partition(|&band| film.is_begun(band));
        let (begun, blank) = (
            of_these(film, &begun, &try_out),
            of_these(film, &blank, &try_out),
        );
        // Of a picture of one kind both are as that kind.
        let full = begun.or(blank).unwrap_or_default();
        Self {
            full: full.files,
            blank: blank.unwrap_or(full).files,
            seen_error: full.seen_error,
            is_guess: begun.is_none(),
        }
    }
}

/// How long it will take if all bands are as these; `None` if these are none.
///
/// What takes as long for few rows as for many (the disk, threads, what is made at the first use) must not be
/// multiplied: so one band is tried, and then some; and before that one for what is made at the first use.
fn of_these(
    film: &dyn Bands,
    bands: &[usize],
    try_out: impl Fn(&Extract) -> Tried,
) -> Option<Tried> {
    let one = Extract::of(film, bands, 1)?;
    let (first, second) = (try_out(&one), try_out(&one));
    let some = Extract::of(film, bands, TRIED)?;
    let time = try_out(&some);
    let whole = |least: Duration, time: Duration| {
        let rows = some.rows() - one.rows();
        if rows == 0 {
            return least.mul_f64(f64::from(film.size().1) / f64::from(one.rows()));
        }
        let rest = f64::from(film.size().1) - f64::from(some.rows());
        time + time
            .saturating_sub(least)
            .mul_f64(REMAINING_ROWS * rest / f64::from(rows))
    };
    Some(Tried {
        files: whole(first.files.min(second.files), time.files),
        seen_error: whole(first.seen_error.min(second.seen_error), time.seen_error),
    })
}
