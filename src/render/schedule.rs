//! Passes over tiles, by a pool of threads, until something says stop.

use super::{
    EffectChoice, Event, FilterKind, LightSampling, Observer, RenderError, RenderSettings,
    Rendering, Statistics, Stop,
};
use crate::effects::{self, EffectSet};
use crate::film::filter::FilterTable;
use crate::film::pixel::Pixel;
use crate::film::{Layer, Picture};
use crate::integrator::{self, Kernel, PathSettings};
use crate::sampler::Sequence;
use crate::scene::Scene;
use crate::world::{Options, World};
use glam::{DVec3, Vec2};
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Edge of a tile in pixels.
const TILE: u32 = 32;
/// Samples that a tile takes between two looks at the clock, per pixel, at most.
const CHUNK: u32 = 8;
/// So many bad samples are kept with their places.
const EXAMPLES: usize = 16;
/// At most this long between two reports of progress.
const REPORT: Duration = Duration::from_millis(200);

struct Tile {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    pixels: Vec<Pixel>,
}

/// Samples that were not finite: how many, and the first places (x, y, sample).
#[derive(Default)]
struct BadSamples {
    count: u64,
    examples: Vec<(u32, u32, u32)>,
}

/// All that the threads share.
struct Job<'a> {
    world: &'a World,
    kernel: Kernel,
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
    /// Takes samples `from..to` of every pixel of a tile, in chunks between which it may stop.
    fn run(&self, tile: &mut Tile, from: u32, to: u32) {
        let mut start = from;
        while start < to && !self.stop.load(Ordering::Relaxed) {
            let end = (start + CHUNK).min(to);
            let mut rays = 0u64;
            for row in 0..tile.height {
                for column in 0..tile.width {
                    let (x, y) = (tile.x + column, tile.y + row);
                    let pixel = &mut tile.pixels[(row * tile.width + column) as usize];
                    for sample in start..end {
                        rays += u64::from(self.sample(x, y, sample, pixel));
                    }
                }
            }
            self.rays.fetch_add(rays, Ordering::Relaxed);
            self.done.fetch_add(
                u64::from(tile.width * tile.height) * u64::from(end - start),
                Ordering::Relaxed,
            );
            start = end;
        }
    }

    #[inline]
    fn sample(&self, x: u32, y: u32, index: u32, pixel: &mut Pixel) -> u32 {
        use crate::sampler::Dimension;
        let sampler = self.sequence.sampler(x, y, index);
        let offset = self.filter.sample(sampler.pair(Dimension::Filter, 0));
        // Pixel centres at half integers; film coordinates −1..1, y up.
        let film = Vec2::new(
            (x as f32 + 0.5 + offset.x) / self.width as f32 * 2.0 - 1.0,
            1.0 - (y as f32 + 0.5 + offset.y) / self.height as f32 * 2.0,
        );
        let mut path = (self.kernel)(self.world, &self.path, &sampler, film);
        if !path.radiance.is_finite() {
            // Counted with its place, left out, never hidden: see `Statistics::non_finite`.
            path.radiance = glam::Vec3::ZERO;
            let mut bad = self
                .bad
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            bad.count += 1;
            if bad.examples.len() < EXAMPLES {
                bad.examples.push((x, y, index));
            }
        }
        pixel.add(path.radiance, &path.first);
        path.rays
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
    let (compiled, kernel) = integrator::kernel_for(wanted);
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
        aspect: f64::from(settings.width) / f64::from(settings.height),
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

    let (width, height) = (settings.width, settings.height);
    let mut tiles: Vec<Tile> = (0..height.div_ceil(TILE))
        .flat_map(|ty| (0..width.div_ceil(TILE)).map(move |tx| (tx * TILE, ty * TILE)))
        .map(|(x, y)| {
            let (w, h) = (TILE.min(width - x), TILE.min(height - y));
            Tile {
                x,
                y,
                width: w,
                height: h,
                pixels: vec![Pixel::default(); (w * h) as usize],
            }
        })
        .collect();
    let job = Job {
        world: &world,
        kernel,
        path: PathSettings {
            bounces: settings.bounces,
            sample_lights: settings.light_sampling != LightSampling::Bsdf,
            sample_bsdf: settings.light_sampling != LightSampling::Nee,
        },
        sequence: Sequence::new(settings.samples, settings.seed),
        filter: match settings.filter.kind {
            FilterKind::Box => FilterTable::box_filter(),
            FilterKind::Gauss => FilterTable::gauss(f64::from(settings.filter.width)),
            FilterKind::BlackmanHarris => {
                FilterTable::blackman_harris(f64::from(settings.filter.width))
            }
        },
        width,
        height,
        rays: AtomicU64::new(0),
        done: AtomicU64::new(0),
        bad: Mutex::default(),
        stop: AtomicBool::new(false),
    };
    let trace_begun = Instant::now();
    let stop = run(&job, &pool, &mut tiles, settings, observer, trace_begun);
    let trace = trace_begun.elapsed();
    let (non_finite, non_finite_examples) = {
        let mut bad = job
            .bad
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        bad.examples.sort_unstable();
        (bad.count, std::mem::take(&mut bad.examples))
    };
    let samples = tiles
        .iter()
        .flat_map(|t| &t.pixels)
        .map(|p| p.samples)
        .min()
        .unwrap_or(0);
    Ok(Rendering {
        picture: picture(width, height, &tiles),
        statistics: Statistics {
            stop,
            samples,
            prepare,
            trace,
            rays: job.rays.load(Ordering::Relaxed),
            non_finite,
            non_finite_examples,
            effects: effects::names(compiled),
            threads,
        },
    })
}

/// Takes all samples in growing passes; the calling thread watches the clock and the observer.
fn run(
    job: &Job,
    pool: &rayon::ThreadPool,
    tiles: &mut [Tile],
    settings: &RenderSettings,
    observer: &dyn Observer,
    begun: Instant,
) -> Stop {
    let total = u64::from(job.width) * u64::from(job.height) * u64::from(settings.samples);
    let finished = AtomicBool::new(false);
    let reason = Mutex::new(Stop::Samples);
    let passed = AtomicU64::new(0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            pool.install(|| {
                let (mut from, mut step) = (0, 1);
                while from < settings.samples && !job.stop.load(Ordering::Relaxed) {
                    let to = (from + step).min(settings.samples);
                    tiles
                        .par_iter_mut()
                        .for_each(|tile| job.run(tile, from, to));
                    from = to;
                    if !job.stop.load(Ordering::Relaxed) {
                        passed.store(u64::from(to), Ordering::Relaxed);
                    }
                    // Growing passes: a first picture soon, little waiting for the slowest tile later.
                    step = (step * 2).min(64);
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
                *reason
                    .lock()
                    .unwrap_or_else(std::sync::PoisonError::into_inner) = why;
            }
            if reported.elapsed() >= REPORT {
                reported = Instant::now();
                observer.event(&progress(
                    job,
                    settings,
                    begun,
                    passed.load(Ordering::Relaxed) as u32,
                    total,
                ));
            }
        }
    });
    observer.event(&progress(
        job,
        settings,
        begun,
        passed.load(Ordering::Relaxed) as u32,
        total,
    ));
    if job.done.load(Ordering::Relaxed) == total {
        return Stop::Samples;
    }
    reason
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn progress(
    job: &Job,
    settings: &RenderSettings,
    begun: Instant,
    samples: u32,
    total: u64,
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
    }
}

/// Blender's axes (Z up) from Sundog's (Y up).
fn blender_axes(v: DVec3) -> [f32; 3] {
    [v.x as f32, -v.z as f32, v.y as f32]
}

fn picture(width: u32, height: u32, tiles: &[Tile]) -> Picture {
    let mut layers: Vec<Layer> = [
        ("Combined", "RGBA"),
        ("Depth", "Z"),
        ("Normal", "XYZ"),
        ("Position", "XYZ"),
        ("Denoising Albedo", "RGB"),
        ("Debug Sample Count", "X"),
    ]
    .map(|(name, channels)| Layer {
        name: name.into(),
        channels: channels.chars().map(String::from).collect(),
        data: vec![0.0; width as usize * height as usize * channels.len()],
    })
    .into();
    for tile in tiles {
        for (i, p) in tile.pixels.iter().enumerate() {
            let (x, y) = (
                tile.x + i as u32 % tile.width,
                tile.y + i as u32 / tile.width,
            );
            let at = (y * width + x) as usize;
            let scale = if p.samples > 0 {
                1.0 / f64::from(p.samples)
            } else {
                0.0
            };
            let color = (p.radiance * scale).as_vec3();
            let values: [&[f32]; 6] = [
                &[color.x, color.y, color.z, 1.0],
                &[p.depth],
                &blender_axes(p.normal * scale),
                &blender_axes(p.position.as_dvec3()),
                &(p.albedo * scale).as_vec3().to_array(),
                &[p.samples as f32],
            ];
            for (layer, v) in layers.iter_mut().zip(values) {
                layer.data[at * v.len()..][..v.len()].copy_from_slice(v);
            }
        }
    }
    Picture {
        width,
        height,
        layers,
    }
}
