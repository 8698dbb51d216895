//! Parts of a render, made by several machines, become the picture of one.

use super::estimate::estimate;
use super::resolve::Film;
use super::saved::{Header, Saved, State, StateError, difference};
use super::schedule::clamped;
use super::tile::{Samples, Tile, tiles};
use super::{Rendering, Statistics, Stop};
use crate::film::{Pass, Passes, Picture};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Pixels that are joined from parts.
pub struct Merged {
    header: Header,
    tiles: Vec<Mutex<Tile>>,
}

/// Joins states of one render; each comes with a name for messages.
///
/// # Errors
/// They are of different scenes or settings, or the same sample is in two of them.
pub fn merge(
    parts: impl IntoIterator<Item = Result<(String, Saved), StateError>>,
) -> Result<Merged, StateError> {
    let mut whole: Option<(String, Saved)> = None;
    for part in parts {
        let (name, part) = part?;
        match &mut whole {
            None => whole = Some((name, part)),
            Some((first, whole)) => {
                let different = |what: String| {
                    StateError::Different(format!(
                        "{first} and {name} do not belong together: {what}"
                    ))
                };
                join(whole, &part).map_err(different)?;
            }
        }
    }
    let (_, saved) =
        whole.ok_or_else(|| StateError::Different("there is nothing to be joined".into()))?;
    let tiles = tiles(saved.header.region, saved.header.kept());
    saved.restore(&tiles, u32::MAX);
    // A part that was broken off goes on with its own samples, not with those of the whole.
    Ok(Merged {
        header: saved.header,
        tiles,
    })
}

fn join(whole: &mut Saved, part: &Saved) -> Result<(), String> {
    let (a, b) = (&whole.header, &part.header);
    if a.scene != b.scene {
        return Err("they are of different scenes".into());
    }
    if let Some(difference) = difference(&b.settings, &a.settings) {
        return Err(format!("the second one has {difference}"));
    }
    if let Some(why) = a.unlike(b) {
        return Err(why);
    }
    if let Some((from, to)) = common(&a.ranges, &b.ranges) {
        return Err(format!(
            "both have samples of {from}..{to}; give each machine a --sample-range of its own, or a --seed"
        ));
    }
    let full = |saved: &Saved| {
        let length = saved.header.most_samples();
        saved.pixels.iter().all(|p| p.samples == length)
    };
    let complete = full(whole) && full(part);
    for (to, from) in whole.pixels.iter_mut().zip(&part.pixels) {
        to.join(from);
    }
    for (to, from) in whole.light_passes.iter_mut().zip(&part.light_passes) {
        to.join(from);
    }
    for (to, from) in whole.features.iter_mut().zip(&part.features) {
        to.join(from);
    }
    for (to, from) in whole.objects.iter_mut().zip(&part.objects) {
        to.join(from);
    }
    for (to, from) in whole.groups.iter_mut().zip(&part.groups) {
        *to += *from;
    }
    for (to, from) in whole.aovs.iter_mut().zip(&part.aovs) {
        *to += *from;
    }
    for (to, from) in whole.halves.iter_mut().zip(&part.halves) {
        *to += *from;
    }
    for (to, from) in whole.costs.iter_mut().zip(&part.costs) {
        *to = to.saturating_add(*from);
    }
    let header = &mut whole.header;
    header.whole = complete;
    header.ranges.extend_from_slice(&part.header.ranges);
    header.ranges.sort_unstable();
    header.ranges = header.ranges.iter().fold(Vec::new(), |mut all, &range| {
        match all.last_mut() {
            Some((_, end)) if *end == range.0 => *end = range.1,
            _ => all.push(range),
        }
        all
    });
    for (to, from) in header.clamped.iter_mut().zip(part.header.clamped) {
        *to += from;
    }
    header.traced.join(&part.header.traced);
    Ok(())
}

/// The first samples that are in both lists of ranges, which are sorted.
fn common(a: &[(u32, u32)], b: &[(u32, u32)]) -> Option<(u32, u32)> {
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    while let (Some(&&x), Some(&&y)) = (a.peek(), b.peek()) {
        let (from, to) = (x.0.max(y.0), x.1.min(y.1));
        if from < to {
            return Some((from, to));
        }
        if x.1 <= y.1 {
            a.next();
        } else {
            b.next();
        }
    }
    None
}

impl Merged {
    /// What the parts say about themselves, joined.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The state, to be written.
    pub fn state(&self) -> State<'_> {
        State::of(self.header.clone(), &self.tiles)
    }

    /// The picture of all samples together, and its error.
    pub fn rendering(&self) -> Rendering {
        let (header, tiles) = (&self.header, &self.tiles[..]);
        let names = header.passes.iter().map(String::as_str);
        // A pass that this version does not know can't be in a state that it could read.
        let passes = Passes::parse(names).unwrap_or(Passes::COMBINED);
        let error = estimate(
            tiles,
            header.region,
            0.0,
            header.sequences(),
            &AtomicBool::new(false),
        );
        let film = Film::with_axes(header.axes(), header.region, tiles, passes, &header.labels)
            .with_groups(&header.light_groups)
            .with_aovs(&header.aovs, header.size)
            .with_catchers(header.catchers, header.transparent);
        let samples = Samples::of(tiles);
        let clamps = header.clamped != [0.0; 2];
        Rendering {
            picture: Picture::collect(&film),
            replicate: error.map(|_| Picture::collect(&film.replicate(false))),
            luminance_variances: (passes.has(Pass::NoisyImage))
                .then(|| film.luminance_variances())
                .flatten(),
            statistics: Statistics {
                stop: Stop::Samples,
                samples: samples.least,
                mean_samples: samples.mean,
                prepare: Duration::ZERO,
                trace: Duration::try_from_secs_f64(header.traced.seconds).unwrap_or_default(),
                rays: header.traced.rays,
                lobes_left_out: header.traced.lobes_left_out,
                non_finite: header.traced.non_finite,
                non_finite_examples: header.traced.non_finite_examples.clone(),
                non_finite_causes: header.traced.non_finite_causes.clone(),
                error,
                clamped: clamps.then(|| clamped(tiles)),
                effects: Vec::new(),
                left_out: header.left_out.clone(),
                threads: 0,
                embree: header.embree.clone(),
                instruction_set: header.instruction_set,
            },
            scene_hash: header.scene.clone().into(),
        }
    }
}
