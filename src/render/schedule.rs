//! Passes over tiles, by a pool of threads, until something says stop.

use super::adaptive;
use super::catchers::has_catchers;
use super::denoised::DenoisedRule;
use super::estimate::estimate;
use super::labels;
use super::output_time::Saving;
use super::prepare::{self, Prepared};
use super::resolve::Film;
use super::saved::{Saved, State, Traced};
use super::session::Session;
use super::tile::{Kept, Samples, Tile, locked, tiles};
use super::trace::Job;
use super::{
    Clamped, Event, Expected, Forecast, Known, Observer, OutputTime, Passed, RenderError,
    RenderSettings, Rendering, Statistics, Stop,
};
use crate::effects;
use crate::film::error::ErrorEstimate;
use crate::film::{Pass, Passes, Picture};
use crate::math::LUMINANCE;
use crate::scene::{Scene, fingerprint};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Samples of the longest pass, per pixel.
const LONGEST_PASS: u32 = 64;
/// The forecast is told after so long …
const FIRST_FORECAST: Duration = Duration::from_secs(2);
/// … and so many samples a pixel, at least.
const FORECAST_SAMPLES: f64 = 8.0;
/// The output is tried out so often, at most …
const TRIES: u32 = 4;
/// … but once only where there is not so many times as much time left as that takes.
const TRY_SHARE: u32 = 30;
/// The state is tried out again when pixels have so many times the samples: sums get harder to compress, and what is blank is
/// easier than anything.
const SAVE_AGAIN: u32 = 8;
/// With Cycles' noise threshold the error is estimated when there are so many times the samples.
const WORTH_A_LOOK: f64 = 1.2;
/// At most this long between two reports of progress.
const REPORT: Duration = Duration::from_millis(200);

/// Renders a scene.
///
/// # Errors
/// If a setting does not fit the scene or Embree fails. Never for the content of the scene:
/// what can't be rendered is left out and has been told by the importer.
pub fn render(
    scene: &Scene,
    settings: &RenderSettings,
    observer: &dyn Observer,
) -> Result<Rendering, RenderError> {
    resume(scene, settings, None, observer)
}

/// Goes on with a render that was broken off, or renders from the beginning. The picture has the bits of one that
/// was never broken off.
///
/// # Errors
/// As [`render`]; and if what was saved belongs to another scene or to settings that make another picture.
pub fn resume(
    scene: &Scene,
    settings: &RenderSettings,
    saved: Option<&Saved>,
    observer: &dyn Observer,
) -> Result<Rendering, RenderError> {
    Session::new(scene, settings.clone()).resume(saved, observer)
}

/// What a render begins with.
pub(super) struct Begun<'a> {
    /// When it was called.
    pub at: Instant,
    /// What was saved of it before.
    pub saved: Option<&'a Saved>,
}

/// Whether what was saved belongs to a scene and its settings.
pub(super) fn check_saved(
    scene: &Scene,
    settings: &RenderSettings,
    saved: Option<&Saved>,
) -> Result<(), RenderError> {
    saved.map_or(Ok(()), |saved| {
        saved.check(scene, settings).map_err(RenderError::Setting)
    })
}

/// Tells of what will take long.
pub(super) fn announce(scene: &Scene, observer: &dyn Observer) {
    if let Some(long) = prepare::long(scene) {
        observer.event(&long);
    }
}

/// Renders what is prepared.
pub(super) fn run(
    prepared: &Prepared,
    scene: &Scene,
    settings: &RenderSettings,
    begun: &Begun,
    observer: &dyn Observer,
) -> Result<Rendering, RenderError> {
    let &Begun { at: begun, saved } = begun;
    let region = settings.region();
    if let Some(saved) = saved {
        let version = &prepared.world.embree_version;
        saved.check_embree(version).map_err(RenderError::Setting)?;
    }
    let (pool, threads) = (&prepared.pool, prepared.threads);
    let prepare = begun.elapsed();
    observer.event(&Event::Prepared {
        seconds: prepare.as_secs_f64(),
        triangles: prepared.world.triangles(),
        effects: effects::names(prepared.compiled),
    });

    // Before the film: what outlives it and lies above it in the heap would keep the film's memory from being given back.
    let effects = effects::names(prepared.compiled);
    let left_out = prepared.left_out.clone();
    let embree = prepared.world.embree_version.clone();
    let kept = Kept::of_render(settings, scene);
    let tiles = tiles(region, kept);
    let before = saved.map_or_else(Traced::default, |saved| {
        saved.restore(&tiles, settings.samples)
    });
    let job = prepared.job(scene, settings, &before);
    let camera = &prepared.camera.world_from_camera;
    let labels = labels::of(scene, settings.passes);
    let film = Film::new(camera, region, &tiles, settings.passes, &labels)
        .with_groups(&scene.light_groups)
        .with_aovs(&scene.aovs, (settings.width, settings.height))
        .with_catchers(has_catchers(scene, settings), settings.transparent_film);
    let run = Run {
        left_out: &prepared.left_out,
        scene,
        job: &job,
        film: &film,
        settings,
        observer,
        before: &before,
        begun,
        trace_begun: Instant::now(),
        traced: Mutex::new(Duration::ZERO),
        error: Mutex::new(None),
        denoised: DenoisedRule::new(settings.denoised_target),
        known: Mutex::default(),
        forecast: Mutex::default(),
        passes: AtomicU64::new(0),
        estimating: Mutex::new(Duration::ZERO),
        judging: AtomicBool::new(false),
        judged: AtomicBool::new(false),
        reserve: Mutex::default(),
        trying: Mutex::default(),
        scene_hash: OnceLock::new(),
    };
    let stop = run.all(pool);
    let trace = run.trace_begun.elapsed();
    let samples = Samples::of(&tiles);
    let error = if run.judged.load(Ordering::Relaxed) {
        *locked(&run.error)
    } else {
        pool.install(|| {
            estimate(
                &tiles,
                region,
                0.0,
                settings.sequences,
                &AtomicBool::new(false),
            )
        })
    };
    // First of all: whoever has interrupted waits for it.
    if job.done.load(Ordering::Relaxed) > 0 {
        pool.install(|| {
            observer.picture(&film, samples.least, true);
            run.save(true);
        });
    }
    let mut bad = std::mem::take(&mut *locked(&job.bad));
    bad.examples.sort_unstable();
    let clamps = settings.clamp_direct > 0.0 || settings.clamp_indirect > 0.0;
    let keeps = observer.keeps_picture();
    let of = |film: &Film| pool.install(|| Picture::collect(film));
    Ok(Rendering {
        scene_hash: run.scene_hash.clone(),
        picture: if keeps { of(&film) } else { Picture::default() },
        replicate: (keeps && error.is_some() && run.can_tell_seen_error(stop))
            .then(|| of(&film.replicate(false))),
        luminance_variances: (keeps && settings.passes.has(Pass::NoisyImage))
            .then(|| film.luminance_variances())
            .flatten(),
        statistics: Statistics {
            stop,
            samples: samples.least,
            mean_samples: samples.mean,
            prepare,
            trace: trace + Duration::from_secs_f64(before.seconds),
            rays: job.rays.load(Ordering::Relaxed),
            lobes_left_out: job.lobes_left_out.load(Ordering::Relaxed),
            non_finite: bad.count,
            non_finite_examples: bad.examples,
            non_finite_causes: bad.causes,
            error,
            clamped: clamps.then(|| clamped(&tiles)),
            effects,
            left_out,
            threads,
            embree,
            instruction_set: prepared.world.instructions,
        },
    })
}

/// What clamping took away, as shares of what there would be.
pub(super) fn clamped(tiles: &[Mutex<Tile>]) -> Clamped {
    let (mut kept, mut taken) = (0.0, [0.0; 2]);
    for tile in tiles {
        let tile = locked(tile);
        for pixel in &tile.pixels {
            kept += pixel.radiance.total().dot(DVec3::from(LUMINANCE));
        }
        for row in &tile.clamped {
            for (sum, c) in taken.iter_mut().zip(row) {
                *sum += c;
            }
        }
    }
    let whole = kept + taken[0] + taken[1];
    let share = |taken: f64| if whole > 0.0 { taken / whole } else { 0.0 };
    Clamped {
        direct: share(taken[0]),
        indirect: share(taken[1]),
    }
}

/// A render under way.
struct Run<'a> {
    /// Effects that are called for and left out.
    left_out: &'a [String],
    scene: &'a Scene,
    job: &'a Job<'a>,
    film: &'a Film<'a>,
    settings: &'a RenderSettings,
    observer: &'a dyn Observer,
    before: &'a Traced,
    /// When the render was called …
    begun: Instant,
    /// … and when the first sample was taken.
    trace_begun: Instant,
    /// Time of the passes that have ended, without what comes between them.
    traced: Mutex<Duration>,
    /// The estimate after the last whole pass.
    error: Mutex<Option<ErrorEstimate>>,
    /// What is told of the denoised picture.
    denoised: DenoisedRule,
    /// What is known of the passes that have ended …
    known: Mutex<Vec<Known>>,
    /// … and what follows.
    forecast: Mutex<Option<Forecast>>,
    /// Passes that have ended.
    passes: AtomicU64,
    /// Time that the last estimate took.
    estimating: Mutex<Duration>,
    /// The estimate that time was left for is being made: too late to break it off for want of time.
    judging: AtomicBool,
    /// No sample has come since `error` was estimated.
    judged: AtomicBool,
    /// Time that has to be left for the output; `None` while it is not known.
    reserve: Mutex<Option<Reserve>>,
    /// Held while the output is tried out.
    trying: Mutex<()>,
    /// As soon as somebody has asked for it.
    scene_hash: OnceLock<String>,
}

/// Time for the output.
#[derive(Clone, Copy)]
struct Reserve {
    output: OutputTime,
    /// How often it was tried, and how long the last time took.
    tries: u32,
    trying: Duration,
    /// How long the state takes to write, if it has been tried.
    saving: Option<Saving>,
    /// What is left for all of this and for a last estimate of the error.
    time: Duration,
    /// Whether that is enough for telling the error of the picture as it is shown.
    seen_error: bool,
}

/// Sets a flag when it goes, by a panic too: whoever waits for the flag does not wait forever.
struct SetOnDrop<'a>(&'a AtomicBool);

impl Drop for SetOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

impl Run<'_> {
    /// Takes all samples pass by pass; the calling thread watches the clock and the observer.
    fn all(&self, pool: &rayon::ThreadPool) -> Stop {
        let finished = AtomicBool::new(false);
        let reason = Mutex::new(Stop::Samples);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let _end = SetOnDrop(&finished);
                let why = pool.install(|| self.passes());
                if let Some(why) = why {
                    *locked(&reason) = why;
                }
            });
            let mut reported = self.trace_begun;
            let mut foretold = false;
            while !finished.load(Ordering::Acquire) {
                std::thread::sleep(Duration::from_millis(5));
                if let Some(why) = self.told_to_stop()
                    && !self.job.stop.swap(true, Ordering::Relaxed)
                {
                    *locked(&reason) = why;
                }
                // A first pass that takes long: what there is of it has to do.
                if self.time_is_short() && locked(&self.reserve).is_none() {
                    self.job.pause.store(true, Ordering::Relaxed);
                    self.leave_time();
                    self.job.pause.store(false, Ordering::Relaxed);
                }
                let some = self.passes.load(Ordering::Relaxed) > 0;
                if some && !self.stopped() && self.observer.wants_picture() {
                    // Not by the pool: its threads are at their tiles.
                    let samples = self.samples().least;
                    self.observer
                        .picture(&self.film.with(Passes::COMBINED), samples, false);
                }
                if reported.elapsed() >= REPORT {
                    reported = Instant::now();
                    self.observer.event(&self.progress());
                    if !foretold && let Some(forecast) = self.first_forecast() {
                        foretold = true;
                        self.observer.event(&forecast);
                    }
                }
            }
        });
        self.observer.event(&self.progress());
        reason.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn stopped(&self) -> bool {
        self.job.stop.load(Ordering::Relaxed)
    }

    fn told_to_stop(&self) -> Option<Stop> {
        if self.observer.cancelled() {
            return Some(Stop::Cancelled);
        }
        let judging = self.judging.load(Ordering::Relaxed);
        (self.time_left()? == Duration::ZERO && !judging).then_some(Stop::Time)
    }

    /// Time that tracing may still take, if it is limited.
    fn time_left(&self) -> Option<Duration> {
        let reserve = locked(&self.reserve).map_or(Duration::ZERO, |reserve| reserve.time);
        self.time_beside(reserve)
    }

    /// Time that is left beside something that takes time as well, if it is limited.
    fn time_beside(&self, other: Duration) -> Option<Duration> {
        let spent = self.settings.time_spent + self.begun.elapsed();
        Some(self.settings.time_limit?.saturating_sub(spent + other))
    }

    /// Pass after pass; says why there are no more, unless it was told to stop.
    fn passes(&self) -> Option<Stop> {
        let tiles = self.film.tiles();
        // What is left of a pass that was broken off.
        let mut left = tiles.iter().any(|tile| {
            let tile = locked(tile);
            tile.pixels.iter().any(|p| p.samples < p.until)
        });
        if self.before.samples > 0 && !left {
            self.judge();
        }
        let rows = tiles.iter().enumerate();
        let rows = rows.flat_map(|(tile, of)| (0..locked(of).height).map(move |row| (tile, row)));
        let rows: Vec<_> = rows.collect();
        loop {
            // A judgement that was given up says nothing to plan by: whoever goes on from here judges again.
            if self.stopped() {
                return None;
            }
            if !left && let Err(why) = self.plan() {
                return Some(why);
            }
            left = false;
            self.judged.store(false, Ordering::Relaxed);
            let begun = Instant::now();
            // Rows one by one: of its own rayon hands out a few large parts, and threads wait for the one that takes longest.
            rows.par_iter()
                .with_max_len(1)
                .for_each(|&(tile, row)| self.job.run_row(&tiles[tile], row));
            *locked(&self.traced) += begun.elapsed();
            if self.stopped() {
                return None;
            }
            self.passes.fetch_add(1, Ordering::Relaxed);
            if self.is_worth_a_look() {
                self.judge();
            }
            self.save(false);
            self.leave_time();
            // The watch looks every few milliseconds; what is known here need not wait for it.
            if self.time_left() == Some(Duration::ZERO) {
                return Some(Stop::Time);
            }
        }
    }

    /// Looks at the picture after a whole pass, so that the clock has no say in it.
    fn judge(&self) {
        let begun = Instant::now();
        self.judging.store(true, Ordering::Relaxed);
        let (tiles, region) = (self.film.tiles(), self.settings.region());
        let (target, sequences) = (self.settings.pixel_error_target, self.settings.sequences);
        let error = estimate(tiles, region, target, sequences, &self.job.stop);
        self.judging.store(false, Ordering::Relaxed);
        if self.stopped() {
            return;
        }
        *locked(&self.estimating) = begun.elapsed();
        *locked(&self.error) = error;
        self.judged.store(true, Ordering::Relaxed);
        let passed = self.passed();
        let mut known = locked(&self.known);
        known.push(Known::from(&passed));
        *locked(&self.forecast) = Forecast::of(&known);
        drop(known);
        self.observer.whole_pass(self.film, &passed);
        // Two pictures are denoised for it: the output's time has one of them in it.
        let output = locked(&self.reserve).map_or(Duration::ZERO, |reserve| reserve.time);
        let time = self.time_left().map(|left| (left, 2 * output));
        self.denoised.judge(self.film, self.observer, &passed, time);
    }

    /// Says how many samples each pixel is to have at the end of the next pass; or why there is none.
    fn plan(&self) -> Result<(), Stop> {
        let (settings, tiles) = (self.settings, self.film.tiles());
        let error = *locked(&self.error);
        if let Some(error) = error
            && settings.error_target > 0.0
            && error.error <= settings.error_target
        {
            return Err(Stop::Error);
        }
        if self.denoised.is_met() {
            return Err(Stop::DenoisedError);
        }
        let least = self.samples().least;
        let mut most = settings.samples;
        if let Some(rule) = settings.noise_threshold {
            most = most.min(rule.first_look());
            if least >= most {
                return rule.plan(tiles, settings.region(), settings.samples);
            }
        }
        if settings.pixel_error_target > 0.0 && least >= adaptive::FIRST_SAMPLES && error.is_some()
        {
            return adaptive::plan(tiles, settings.pixel_error_target, settings.samples);
        }
        let until = pass_end(least).min(most);
        if until <= least {
            return Err(Stop::Samples);
        }
        for tile in tiles {
            for pixel in &mut locked(tile).pixels {
                pixel.until = until.max(pixel.samples);
            }
        }
        Ok(())
    }

    /// Whether the picture is looked at after this pass: of the hundreds of short ones of Cycles' rule it is so now and then,
    /// unless a target asks for each.
    fn is_worth_a_look(&self) -> bool {
        if self.settings.noise_threshold.is_none() || self.settings.error_target > 0.0 {
            return true;
        }
        let last = locked(&self.known)
            .last()
            .map_or(0.0, |known| known.samples);
        self.samples().mean >= WORTH_A_LOOK * last
    }

    /// Whether a quarter of the time is over.
    fn time_is_short(&self) -> bool {
        let spent = self.settings.time_spent + self.begun.elapsed();
        let limit = self.settings.time_limit;
        limit.is_some_and(|limit| spent > limit / 4)
    }

    /// Leaves time for the output, and for telling the error of the picture as it is shown, if it is known and there is
    /// so much time. How long that takes is tried out when there is something to try it with, and some times again where
    /// that costs little: the machine may have had other things to do.
    fn leave_time(&self) {
        if self.settings.time_limit.is_none() {
            return;
        }
        let _alone = locked(&self.trying);
        let traced = self.trace_begun.elapsed().as_secs_f64();
        let samples = self.samples();
        let before = *locked(&self.reserve);
        let worth_it = |before: Reserve| {
            let left = self.time_left().unwrap_or_default();
            if before.output.is_guess {
                samples.least > 0 && !left.is_zero()
            } else {
                before.tries < TRIES && left > before.trying * TRY_SHARE
            }
        };
        // Output and state tell it, and a large scene takes long.
        self.scene_hash();
        let some = self.job.rays.load(Ordering::Relaxed) > 0;
        let saving = before.and_then(|before| before.saving);
        let again = saving.is_none_or(|saving| {
            let left = self.time_left().unwrap_or_default();
            samples.least >= SAVE_AGAIN.saturating_mul(saving.samples).max(1)
                && left > saving.time * TRY_SHARE
        });
        let saving = if some && again {
            let begun = Instant::now();
            self.save(true);
            Some(Saving {
                time: begun.elapsed(),
                samples: samples.least,
                share: samples.mean.min(1.0),
            })
        } else {
            saving
        };
        let (output, tries, trying) = match before {
            Some(before) if !worth_it(before) => (before.output, before.tries, before.trying),
            _ => {
                let begun = Instant::now();
                let output = self.observer.time_for_output(self.film);
                let tries = before.map_or(0, |before| before.tries);
                let output = before.map_or(output, |before| before.output.and(tries, output));
                (output, tries + 1, begun.elapsed())
            }
        };
        let estimating = *locked(&self.estimating);
        // All of the picture, for the share is not known yet.
        let beside = estimating + saving.map_or(Duration::ZERO, |saving| saving.at(1.0));
        // In the first pass: what of it will be there.
        let share = if samples.least > 0 {
            1.0
        } else {
            let left = self.time_beside(beside).unwrap_or_default();
            output.share_at_end(samples.mean, samples.mean / traced, left.as_secs_f64())
        };
        let least = output.at(share) + beside;
        let with_error = least + output.seen_error;
        let is_known = locked(&self.error).is_some();
        let seen_error = before.is_some_and(|before| before.seen_error)
            || is_known && self.time_beside(with_error) > Some(Duration::ZERO);
        *locked(&self.reserve) = Some(Reserve {
            output,
            tries,
            trying,
            saving,
            time: if seen_error { with_error } else { least },
            seen_error,
        });
    }

    /// Whether there is time to tell the error of the picture as it is shown.
    fn can_tell_seen_error(&self, stop: Stop) -> bool {
        let reserve = *locked(&self.reserve);
        stop != Stop::Time || reserve.is_none_or(|reserve| reserve.seen_error)
    }

    /// Gives the state to whoever keeps it.
    fn save(&self, last: bool) {
        if self.observer.wants_state(last) {
            let bad = locked(&self.job.bad).clone();
            let traced = Traced {
                samples: self.job.done.load(Ordering::Relaxed),
                rays: self.job.rays.load(Ordering::Relaxed),
                lobes_left_out: self.job.lobes_left_out.load(Ordering::Relaxed),
                seconds: self.before.seconds + self.trace_begun.elapsed().as_secs_f64(),
                non_finite: bad.count,
                non_finite_examples: bad.examples,
                non_finite_causes: bad.causes,
            };
            let world = self.job.world;
            let state = State::new(
                self.scene,
                self.scene_hash(),
                self.settings,
                (&world.embree_version, world.instructions),
                self.film,
                traced,
                self.left_out,
            );
            self.observer.state(&state, last);
        }
    }

    fn scene_hash(&self) -> &str {
        self.scene_hash.get_or_init(|| fingerprint(self.scene))
    }

    fn samples(&self) -> Samples {
        Samples::of(self.film.tiles())
    }

    fn passed(&self) -> Passed {
        let samples = self.samples();
        Passed {
            samples: samples.mean,
            least: samples.least,
            rays: self.job.rays.load(Ordering::Relaxed),
            seconds: self.before.seconds + locked(&self.traced).as_secs_f64(),
            error: *locked(&self.error),
        }
    }

    /// The table of the forecast, when it is time for it.
    fn first_forecast(&self) -> Option<Event> {
        if self.trace_begun.elapsed() < FIRST_FORECAST {
            return None;
        }
        let forecast = locked(&self.forecast);
        let forecast = forecast.as_ref()?;
        let samples = forecast.last().samples;
        (samples >= FORECAST_SAMPLES).then(|| Event::Forecast {
            samples,
            table: forecast.table(),
        })
    }

    /// Seconds from now until the error is the one that is wanted.
    fn to_goal(&self, seconds: f64) -> Option<Expected> {
        let target = self.settings.error_target;
        let forecast = locked(&self.forecast);
        let forecast = forecast.as_ref().filter(|_| target > 0.0)?;
        let now = self.before.seconds + seconds;
        Some(forecast.seconds_to(target).map(|at| (at - now).max(0.0)))
    }

    fn progress(&self) -> Event {
        let settings = self.settings;
        let seconds = self.trace_begun.elapsed().as_secs_f64();
        let pixels = f64::from(settings.region().width()) * f64::from(settings.region().height());
        let done = self.job.done.load(Ordering::Relaxed);
        let samples = done as f64 / pixels;
        let error = *locked(&self.error);
        // Each rule says how far it is; the one that will end it first is the farthest.
        let by_samples = samples / f64::from(settings.samples);
        let by_time = self.time_left().map_or(0.0, |left| {
            let left = left.as_secs_f64();
            seconds / (seconds + left).max(f64::MIN_POSITIVE)
        });
        let to_goal = self.to_goal(seconds);
        let by_error = to_goal.map_or(0.0, |left| {
            seconds / (seconds + left.expected).max(f64::MIN_POSITIVE)
        });
        let fraction = by_samples.max(by_time).max(by_error).min(1.0);
        let new = (done - self.before.samples) as f64 / pixels;
        let share = if fraction == by_samples {
            new / (f64::from(settings.samples) - samples + new)
        } else {
            fraction
        };
        Event::Progress {
            samples: samples as u32,
            of: settings.samples,
            fraction,
            seconds,
            rays: self.job.rays.load(Ordering::Relaxed),
            remaining: (share > 0.0).then(|| seconds / share - seconds),
            error,
            to_goal,
        }
    }
}

/// Where the pass ends that begins after so many samples: 1, 2, 4, 8, 16, 32, 64, 128, 192, 256 …
/// Growing passes: a first picture soon, little waiting for the slowest tile later.
/// All powers of two are among the ends: there the points of a pixel are most even.
fn pass_end(from: u32) -> u32 {
    from.saturating_add(from.clamp(1, LONGEST_PASS))
}
