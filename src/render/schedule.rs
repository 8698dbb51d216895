//! Passes over tiles, by a pool of threads, until something says stop.

use super::develop::Film;
use super::{
    Clamped, EffectChoice, Event, FilterKind, LightSampling, MAX_LIGHT_SAMPLES, Observer,
    RenderError, RenderSettings, Rendering, Statistics, Stop,
};
use crate::camera::{CameraRay, RayMaker};
use crate::effects::{self, EffectSet};
use crate::film::apart::{PathApart, PixelApart};
use crate::film::filter::FilterTable;
use crate::film::pixel::{Middle, Pixel};
use crate::film::{Passes, Picture};
use crate::integrator::{self, ApartKernel, Kernel, Path, PathSettings};
use crate::math::LUMINANCE;
use crate::sampler::{Dimension, Sampler, Sequence};
use crate::scene::Scene;
use crate::world::{Options, World};
use glam::{DVec3, Vec2};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Edge of a tile in pixels.
pub(super) const TILE: u32 = 32;
/// Samples that a tile takes between two looks at the clock, per pixel, at most.
const CHUNK: u32 = 8;
/// Samples of the longest pass, per pixel.
const LONGEST_PASS: u32 = 64;
/// So many bad samples are kept with their places.
const EXAMPLES: usize = 16;
/// At most this long between two reports of progress.
const REPORT: Duration = Duration::from_millis(200);

/// A tile of the region; places count from the corner of the full picture.
pub(super) struct Tile {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<Pixel>,
    /// Beside `pixels`, if a pass asks for it; else empty.
    pub apart: Vec<PixelApart>,
    /// Luminance that clamping took from direct and indirect light.
    clamped: [f64; 2],
    /// Samples that all its pixels have.
    least: u32,
}

/// A thread that panicked left a tile as good as before: whole samples.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Samples that were not finite: how many, and the first places (x, y, sample).
#[derive(Default)]
struct BadSamples {
    count: u64,
    examples: Vec<(u32, u32, u32)>,
}

/// A kernel, with or without light apart.
#[derive(Clone, Copy)]
enum AnyKernel {
    Together(Kernel),
    Apart(ApartKernel),
}

/// All that the threads share.
struct Job<'a> {
    world: &'a World,
    kernel: AnyKernel,
    camera_ray: RayMaker,
    /// The ray through the middle of each pixel is asked for.
    middle: bool,
    path: PathSettings,
    sequence: Sequence,
    filter: FilterTable,
    width: u32,
    height: u32,
    rays: AtomicU64,
    /// Pixel samples done.
    done: AtomicU64,
    bad: Mutex<BadSamples>,
    stop: AtomicBool,
}

impl Job<'_> {
    /// Takes samples `from..to` of a tile, giving it free after each chunk for whoever wants to look.
    fn run_locked(&self, tile: &Mutex<Tile>, from: u32, to: u32) {
        let mut start = from;
        while start < to && !self.stop.load(Ordering::Relaxed) {
            let end = (start + CHUNK).min(to);
            self.run(&mut locked(tile), start, end);
            start = end;
        }
    }

    /// Takes samples `start..end` of every pixel of a tile.
    fn run(&self, tile: &mut Tile, start: u32, end: u32) {
        let mut rays = 0u64;
        for row in 0..tile.height {
            // A tile may take long: whoever wants to stop does not wait for its end.
            if self.stop.load(Ordering::Relaxed) {
                break;
            }
            for column in 0..tile.width {
                let (x, y) = (tile.x + column, tile.y + row);
                let index = (row * tile.width + column) as usize;
                let pixel = &mut tile.pixels[index];
                if start == 0 && self.middle {
                    pixel.middle = self.look(x, y);
                    rays += 1;
                }
                for sample in start..end {
                    let path = self.sample(x, y, sample, pixel, tile.apart.get_mut(index));
                    rays += u64::from(path.rays);
                    for (sum, c) in tile.clamped.iter_mut().zip(path.clamped) {
                        *sum += f64::from(c);
                    }
                }
            }
        }
        self.rays.fetch_add(rays, Ordering::Relaxed);
        // A tile that was broken off does not count as done.
        if !self.stop.load(Ordering::Relaxed) {
            tile.least = end;
            self.done.fetch_add(
                u64::from(tile.width * tile.height) * u64::from(end - start),
                Ordering::Relaxed,
            );
        }
    }

    /// The ray of a sample, at an offset from the pixel's centre.
    #[inline]
    fn ray(&self, x: u32, y: u32, sampler: &Sampler, offset: Vec2) -> CameraRay {
        // Pixel centres at half integers; film coordinates −1..1, y up.
        let film = Vec2::new(
            (x as f32 + 0.5 + offset.x) / self.width as f32 * 2.0 - 1.0,
            1.0 - (y as f32 + 0.5 + offset.y) / self.height as f32 * 2.0,
        );
        (self.camera_ray)(&self.world.camera, film, sampler)
    }

    /// What the ray through the middle of a pixel meets (of a lens: from a random point of it), which is
    /// where Cycles has its depths and positions from.
    fn look(&self, x: u32, y: u32) -> Middle {
        let sampler = self.sequence.sampler(x, y, 0);
        integrator::meet(self.world, &sampler, &self.ray(x, y, &sampler, Vec2::ZERO))
    }

    #[inline]
    fn sample(
        &self,
        x: u32,
        y: u32,
        index: u32,
        pixel: &mut Pixel,
        sums: Option<&mut PixelApart>,
    ) -> Path {
        let sampler = self.sequence.sampler(x, y, index);
        let offset = self.filter.sample(sampler.pair(Dimension::Filter, 0));
        let ray = self.ray(x, y, &sampler, offset);
        let (mut path, mut apart) = match self.kernel {
            AnyKernel::Together(kernel) => (kernel(self.world, &self.path, &sampler, &ray), None),
            AnyKernel::Apart(kernel) => {
                let mut apart = PathApart::default();
                let path = kernel(self.world, &self.path, &sampler, &ray, &mut apart);
                (path, Some(apart))
            }
        };
        if !path.radiance.is_finite() {
            // Counted with its place, left out, never hidden: see `Statistics::non_finite`.
            path.radiance = glam::Vec3::ZERO;
            path.clamped = [0.0; 2];
            apart = apart.map(|_| PathApart::default());
            let mut bad = locked(&self.bad);
            bad.count += 1;
            if bad.examples.len() < EXAMPLES {
                bad.examples.push((x, y, index));
            }
        }
        pixel.add(path.radiance, &path.first);
        if let (Some(sums), Some(apart)) = (sums, &apart) {
            sums.add(apart);
        }
        path
    }
}

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
    let begun = Instant::now();
    let setting = |text: String| RenderError::Setting(text);
    if settings.width == 0
        || settings.height == 0
        || settings.width > 65_536
        || settings.height > 65_536
    {
        return Err(setting(format!(
            "a picture of {} x {} pixels can't be made; width and height go from 1 to 65536",
            settings.width, settings.height
        )));
    }
    if settings.samples == 0 {
        return Err(setting(
            "0 samples make no picture; ask for at least 1".into(),
        ));
    }
    if !(1..=MAX_LIGHT_SAMPLES).contains(&settings.light_samples) {
        return Err(setting(format!(
            "{} light samples at a surface can't be taken; their number goes from 1 to {MAX_LIGHT_SAMPLES}",
            settings.light_samples
        )));
    }
    let region = settings.region();
    if region.x0 >= region.x1
        || region.y0 >= region.y1
        || region.x1 > settings.width
        || region.y1 > settings.height
    {
        return Err(setting(format!(
            "the region from {}, {} to {}, {} is no part of a picture of {} x {} pixels",
            region.x0, region.y0, region.x1, region.y1, settings.width, settings.height
        )));
    }
    let camera = scene
        .cameras
        .get(settings.camera.unwrap_or(0))
        .ok_or_else(|| {
            setting(format!(
                "camera {} is not in the scene, which has {}",
                settings.camera.unwrap_or(0),
                scene.cameras.len()
            ))
        })?;
    let found = EffectSet::detect(scene);
    let wanted = match &settings.effects {
        EffectChoice::Auto => found.mask,
        EffectChoice::All => effects::ALL,
        EffectChoice::List(list) => effects::parse(list).map_err(setting)?,
    };
    let apart = settings.passes.need_light_apart();
    let (kernel_effects, kernel) = if apart {
        (effects::PATHS, AnyKernel::Apart(integrator::APART))
    } else {
        let (mask, kernel) = match settings.light_sampling {
            LightSampling::Hemisphere => integrator::GENERAL,
            _ => integrator::kernel_for(wanted),
        };
        (mask, AnyKernel::Together(kernel))
    };
    let focused = if camera.aperture.is_some() {
        wanted & effects::DEPTH_OF_FIELD
    } else {
        0
    };
    let compiled = kernel_effects | focused;
    let threads = settings
        .threads
        .filter(|&n| n > 0)
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| setting(format!("{threads} threads could not be started: {e}")))?;
    let options = Options {
        camera,
        aspect: f64::from(settings.width) / f64::from(settings.height)
            * camera.pixel_aspect(&scene.render),
        // What the list leaves out is left out of the world, not only of the kernel.
        effects: wanted,
        threads: Some(threads),
        cull_backfaces: settings.cull_backfaces,
    };
    let world = pool
        .install(|| World::new(scene, &options))
        .map_err(|e| RenderError::Embree(e.0))?;
    let prepare = begun.elapsed();
    observer.event(&Event::Prepared {
        seconds: prepare.as_secs_f64(),
        triangles: world.triangles,
        effects: effects::names(compiled),
    });

    let tiles: Vec<Mutex<Tile>> = (0..region.height().div_ceil(TILE))
        .flat_map(|ty| (0..region.width().div_ceil(TILE)).map(move |tx| (tx * TILE, ty * TILE)))
        .map(|(x, y)| {
            let (w, h) = (TILE.min(region.width() - x), TILE.min(region.height() - y));
            Mutex::new(Tile {
                x: region.x0 + x,
                y: region.y0 + y,
                width: w,
                height: h,
                pixels: vec![Pixel::default(); (w * h) as usize],
                apart: vec![PixelApart::default(); if apart { (w * h) as usize } else { 0 }],
                clamped: [0.0; 2],
                least: 0,
            })
        })
        .collect();
    let limit = |clamp: f32| if clamp > 0.0 { clamp } else { f32::INFINITY };
    let most = |limit: Option<u32>| limit.unwrap_or(u32::MAX);
    let limits = settings.bounce_limits;
    let job = Job {
        world: &world,
        kernel,
        camera_ray: world.camera.ray_maker(),
        middle: settings.passes.need_middle(),
        path: PathSettings {
            bounces: settings.bounces,
            limits: [limits.diffuse, limits.glossy, limits.transmission].map(most),
            transparent: most(limits.transparent),
            clamp: [limit(settings.clamp_direct), limit(settings.clamp_indirect)],
            filter_glossy: settings.filter_glossy,
            transparent_film: settings.transparent_film,
            sample_lights: matches!(
                settings.light_sampling,
                LightSampling::Mis | LightSampling::Nee
            ),
            sample_bsdf: settings.light_sampling != LightSampling::Nee,
            uniform: settings.light_sampling == LightSampling::Hemisphere,
            light_samples: settings.light_samples,
            roulette: settings.roulette.unwrap_or(u32::MAX),
        },
        sequence: Sequence::new(settings.samples, settings.seed),
        filter: match settings.filter.kind {
            FilterKind::Box => FilterTable::box_filter(),
            FilterKind::Gauss => FilterTable::gauss(f64::from(settings.filter.width)),
            FilterKind::BlackmanHarris => {
                FilterTable::blackman_harris(f64::from(settings.filter.width))
            }
        },
        width: settings.width,
        height: settings.height,
        rays: AtomicU64::new(0),
        done: AtomicU64::new(0),
        bad: Mutex::default(),
        stop: AtomicBool::new(false),
    };
    let trace_begun = Instant::now();
    let film = Film::new(&camera.world_from_camera, region, &tiles, settings.passes);
    let stop = run(&job, &pool, &film, settings, observer, trace_begun);
    let trace = trace_begun.elapsed();
    let samples = tiles.iter().map(|tile| locked(tile).least).min();
    let samples = samples.unwrap_or(0);
    // First of all: whoever has interrupted waits for it.
    if samples > 0 || job.rays.load(Ordering::Relaxed) > 0 {
        pool.install(|| observer.picture(&film, samples, true));
    }
    let (non_finite, non_finite_examples) = {
        let mut bad = locked(&job.bad);
        bad.examples.sort_unstable();
        (bad.count, std::mem::take(&mut bad.examples))
    };
    let clamps = settings.clamp_direct > 0.0 || settings.clamp_indirect > 0.0;
    Ok(Rendering {
        picture: if observer.keeps_picture() {
            pool.install(|| Picture::collect(&film))
        } else {
            Picture::default()
        },
        statistics: Statistics {
            stop,
            samples,
            prepare,
            trace,
            rays: job.rays.load(Ordering::Relaxed),
            non_finite,
            non_finite_examples,
            noise: pool.install(|| noise(&tiles, &AtomicBool::new(false))),
            clamped: clamps.then(|| clamped(&tiles)),
            effects: effects::names(compiled),
            threads,
        },
    })
}

/// Estimated root of the picture's relMSE (mean over pixels and channels of the squared error over the
/// squared value + 0.01); `None` while a pixel has less than two samples, and
/// when nobody waits for it any more. Tiles are summed in their order,
/// so that the number does not depend on the threads.
fn noise(tiles: &[Mutex<Tile>], given_up: &AtomicBool) -> Option<f64> {
    let sums: Option<Vec<(f64, usize)>> = tiles
        .par_iter()
        .map(|tile| {
            if given_up.load(Ordering::Relaxed) {
                return None;
            }
            let tile = locked(tile);
            let sum: Option<f64> = tile.pixels.iter().map(Pixel::relative_square_error).sum();
            sum.map(|sum| (sum, 3 * tile.pixels.len()))
        })
        .collect();
    let (sum, values) = sums?
        .into_iter()
        .fold((0.0, 0), |a, tile| (a.0 + tile.0, a.1 + tile.1));
    (values > 0).then(|| (sum / values as f64).sqrt())
}

/// What clamping took away, as shares of what there would be.
fn clamped(tiles: &[Mutex<Tile>]) -> Clamped {
    let (mut kept, mut taken) = (0.0, [0.0; 2]);
    for tile in tiles {
        let tile = locked(tile);
        for pixel in &tile.pixels {
            kept += pixel.radiance.dot(DVec3::from(LUMINANCE));
        }
        for (sum, c) in taken.iter_mut().zip(tile.clamped) {
            *sum += c;
        }
    }
    let whole = kept + taken[0] + taken[1];
    let share = |taken: f64| if whole > 0.0 { taken / whole } else { 0.0 };
    Clamped {
        direct: share(taken[0]),
        indirect: share(taken[1]),
    }
}

/// Takes all samples in growing passes; the calling thread watches the clock and the observer.
fn run(
    job: &Job,
    pool: &rayon::ThreadPool,
    film: &Film,
    settings: &RenderSettings,
    observer: &dyn Observer,
    begun: Instant,
) -> Stop {
    let (region, tiles) = (settings.region(), film.tiles());
    let total =
        u64::from(region.width()) * u64::from(region.height()) * u64::from(settings.samples);
    let finished = AtomicBool::new(false);
    let reason = Mutex::new(Stop::Samples);
    let passed = AtomicU64::new(0);
    // The bits of the estimate after the last whole pass; NaN for none yet.
    let error = AtomicU64::new(f64::NAN.to_bits());
    let told = || Some(f64::from_bits(error.load(Ordering::Relaxed))).filter(|e| e.is_finite());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            pool.install(|| {
                let mut from = 0;
                let mut traced = Duration::ZERO;
                while from < settings.samples && !job.stop.load(Ordering::Relaxed) {
                    let to = pass_end(from).min(settings.samples);
                    let pass_begun = Instant::now();
                    tiles
                        .par_iter()
                        .for_each(|tile| job.run_locked(tile, from, to));
                    traced += pass_begun.elapsed();
                    from = to;
                    if !job.stop.load(Ordering::Relaxed) {
                        observer.whole_pass(film, to, traced.as_secs_f64());
                        let now = noise(tiles, &job.stop).unwrap_or(f64::NAN);
                        error.store(now.to_bits(), Ordering::Relaxed);
                        passed.store(u64::from(to), Ordering::Relaxed);
                        // After whole passes alone, so that the clock has no say in the picture.
                        let enough = settings.noise_target > 0.0 && now <= settings.noise_target;
                        if enough && to < settings.samples {
                            *locked(&reason) = Stop::Noise;
                            break;
                        }
                    }
                }
            });
            finished.store(true, Ordering::Release);
        });
        let mut reported = begun;
        while !finished.load(Ordering::Acquire) {
            std::thread::sleep(Duration::from_millis(5));
            let why = if observer.cancelled() {
                Some(Stop::Cancelled)
            } else if settings
                .time_limit
                .is_some_and(|limit| begun.elapsed() >= limit)
            {
                Some(Stop::Time)
            } else {
                None
            };
            if let Some(why) = why
                && !job.stop.swap(true, Ordering::Relaxed)
            {
                *locked(&reason) = why;
            }
            let samples = passed.load(Ordering::Relaxed) as u32;
            if samples > 0 && !job.stop.load(Ordering::Relaxed) && observer.wants_picture() {
                // Not by the pool: its threads are at their tiles.
                observer.picture(&film.with(Passes::COMBINED), samples, false);
            }
            if reported.elapsed() >= REPORT {
                reported = Instant::now();
                observer.event(&progress(job, settings, begun, samples, total, told()));
            }
        }
    });
    observer.event(&progress(
        job,
        settings,
        begun,
        passed.load(Ordering::Relaxed) as u32,
        total,
        told(),
    ));
    if job.done.load(Ordering::Relaxed) == total {
        return Stop::Samples;
    }
    reason.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// Where the pass ends that begins after so many samples: 1, 2, 4, 8, 16, 32, 64, 128, 192, 256 …
/// Growing passes: a first picture soon, little waiting for the slowest tile later.
/// All powers of two are among the ends: there the points of a pixel are most even.
fn pass_end(from: u32) -> u32 {
    from.saturating_add(from.clamp(1, LONGEST_PASS))
}

fn progress(
    job: &Job,
    settings: &RenderSettings,
    begun: Instant,
    samples: u32,
    total: u64,
    noise: Option<f64>,
) -> Event {
    let seconds = begun.elapsed().as_secs_f64();
    let fraction = job.done.load(Ordering::Relaxed) as f64 / total as f64;
    let by_samples = (fraction > 0.0).then(|| seconds / fraction - seconds);
    let by_time = settings
        .time_limit
        .map(|limit| (limit.as_secs_f64() - seconds).max(0.0));
    Event::Progress {
        samples,
        of: settings.samples,
        fraction,
        seconds,
        rays: job.rays.load(Ordering::Relaxed),
        remaining: match (by_samples, by_time) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        },
        noise,
    }
}
