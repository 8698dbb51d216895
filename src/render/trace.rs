//! Samples of tiles: what each thread does.

use super::catchers::{CatcherJob, caught};
use super::tile::{Scanline, Tile, locked};
use crate::camera::{CameraRay, RayMaker};
use crate::film::catchers::{CATCHER_SUMS, CatcherPixel, Caught};
use crate::film::features::{PathFeatures, PixelFeatures};
use crate::film::filter::FilterTable;
use crate::film::light_passes::{Asked, PathPasses, PixelPasses};
use crate::film::objects::{Mist, PixelObjects};
use crate::film::pixel::{CenterSample, FirstHit, Pixel};
use crate::integrator::{
    self, Center, FeatureKernel, Kernel, PassKernel, Path, PathSettings, Recorder, Step,
    VECTOR_SUMS,
};
use crate::sampler::{Dimension, Sampler, Sequence};
use crate::scene::Scene;
use crate::world::World;
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

/// Samples that a pixel takes at a time, at most.
const CHUNK: u32 = 8;
/// So many bad samples are kept with their places.
const EXAMPLES: usize = 16;
/// So many causes are told apart.
const CAUSES: usize = 64;

/// Samples that were not finite: how many, and the first places (x, y, sample).
#[derive(Clone, Default)]
pub struct BadSamples {
    pub count: u64,
    pub examples: Vec<(u32, u32, u32)>,
    /// By what was not finite first.
    pub causes: BTreeMap<String, u64>,
}

/// A sample taken once more, step by step.
pub struct Recorded {
    /// From the pixel's centre, in pixels.
    pub offset: Vec2,
    pub path: Path,
    pub steps: Vec<Step>,
}

/// A kernel: of light alone, with features for denoisers, or with light apart and what else is asked of paths.
#[derive(Clone, Copy)]
pub enum AnyKernel {
    Plain(Kernel),
    WithFeatures(FeatureKernel),
    WithPasses { kernel: PassKernel, asked: Asked },
}

/// What a path has told beside its light.
#[derive(Default)]
struct Told {
    /// Where no light is kept apart.
    features: Option<PathFeatures>,
    passes: Option<PathPasses>,
}

impl Told {
    fn features(&self) -> Option<&PathFeatures> {
        let of_passes = || self.passes.as_ref().map(|passes| &passes.features);
        self.features.as_ref().or_else(of_passes)
    }

    fn is_finite(&self) -> bool {
        self.features.as_ref().is_none_or(PathFeatures::is_finite)
            && self.passes.as_ref().is_none_or(PathPasses::is_finite)
    }

    /// The same of a path that counts for nothing.
    fn blank(&self) -> Self {
        Self {
            features: self.features.map(|_| PathFeatures::default()),
            passes: self.passes.as_ref().map(|_| PathPasses::default()),
        }
    }
}

/// What stands beside a pixel's sums, as far as it is kept.
struct Beside<'a> {
    light_passes: Option<&'a mut PixelPasses>,
    features: Option<&'a mut PixelFeatures>,
    objects: Option<&'a mut PixelObjects>,
    groups: &'a mut [DVec3],
    /// Empty where there are none.
    catchers: &'a mut [f64],
}

/// All that the threads share.
pub struct Job<'a> {
    pub scene: &'a Scene,
    pub world: &'a World,
    /// Shadow catchers, if there are any.
    pub catchers: Option<CatcherJob<'a>>,
    pub kernel: AnyKernel,
    pub camera_ray: RayMaker,
    /// The ray through the middle of each pixel is asked for.
    pub middle: bool,
    /// Motion vectors are asked for.
    pub vectors: bool,
    /// The time that each pixel takes is asked for.
    pub costs: bool,
    /// Blender's mist, for the pass of its name.
    pub mist: Mist,
    /// Number of the first sample of each pixel.
    pub first_sample: u32,
    pub path: PathSettings,
    /// Factor on the light that comes to the film.
    pub exposure: f32,
    pub sequence: Sequence,
    pub filter: FilterTable,
    pub width: u32,
    pub height: u32,
    pub rays: AtomicU64,
    /// Lobes that surfaces went without.
    pub lobes_left_out: AtomicU64,
    /// Pixel samples done.
    pub done: AtomicU64,
    pub bad: Mutex<BadSamples>,
    /// The instances with triangles: what the world counts as objects. Made when somebody asks.
    pub objects: OnceLock<Vec<u32>>,
    pub stop: AtomicBool,
    /// Threads wait before their next row.
    pub pause: AtomicBool,
}

impl Job<'_> {
    /// Brings each pixel of a tile's row to the samples that it is to have, putting it back after each chunk for whoever
    /// wants to look. (Rows and not tiles: adaptive sampling may want so much of one tile that all other threads would
    /// wait for it.)
    pub fn run_row(&self, tile: &Mutex<Tile>, row: u32) {
        while !self.stop.load(Ordering::Relaxed) {
            // Whoever asks for the pause wants to look, or the processor for himself.
            if self.pause.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
                continue;
            }
            let unfinished = locked(tile).unfinished(row);
            let Some(mut pixels) = unfinished else {
                return;
            };
            self.run(&mut pixels);
            locked(tile).put_back(row, &pixels);
        }
    }

    /// Takes some of the samples that pixels of a row lack.
    fn run(&self, row: &mut Scanline) {
        let (mut rays, mut done, mut lobes_left_out) = (0u64, 0u64, 0u64);
        let mut clock = self.costs.then(Instant::now);
        let (first, y) = row.place;
        let groups = row.groups.len() / row.pixels.len().max(1);
        let each = row.aovs.len() / row.pixels.len().max(1);
        let caught = if self.catchers.is_some() {
            CATCHER_SUMS
        } else {
            0
        };
        for (index, (x, pixel)) in (first..).zip(&mut row.pixels).enumerate() {
            let wanted = pixel.until.saturating_sub(pixel.samples).min(CHUNK);
            if wanted == 0 {
                continue;
            }
            if pixel.samples == 0 && self.middle {
                let (middle, object) = self.look(x, y);
                pixel.middle = middle;
                if let Some(objects) = row.objects.get_mut(index) {
                    objects.set_middle(object);
                }
                rays += 1;
            }
            // The same ray for all samples: it is traced for the first of them.
            let center = row.centers.get_mut(index).map(|met| {
                rays += u64::from(met.is_none());
                *met.get_or_insert_with(|| self.center(x, y))
            });
            for _ in 0..wanted {
                let number = self.first_sample + pixel.samples;
                let own = &mut row.aovs[index * each..(index + 1) * each];
                let (catchers, own) = own.split_at_mut(caught);
                let beside = Beside {
                    light_passes: row.light_passes.get_mut(index),
                    features: row.features.get_mut(index),
                    objects: row.objects.get_mut(index),
                    groups: &mut row.groups[index * groups..][..groups],
                    catchers,
                };
                let path = self.sample((x, y, number), pixel, beside, center.as_ref());
                if !own.is_empty() {
                    rays += u64::from(self.aovs(x, y, number, own));
                }
                rays += u64::from(path.rays);
                lobes_left_out += u64::from(path.lobes_left_out);
                if let Some(half) = row.halves.get_mut(index)
                    && self.sequence.sampler(x, y, number).is_in_half()
                {
                    *half += path.radiance.as_dvec3();
                }
                for (sum, c) in row.clamped.iter_mut().zip(path.clamped) {
                    *sum += f64::from(c);
                }
            }
            done += u64::from(wanted);
            if let (Some(clock), Some(cost)) = (&mut clock, row.costs.get_mut(index)) {
                let now = Instant::now();
                *cost += (now - *clock).as_nanos() as u64;
                *clock = now;
            }
        }
        self.rays.fetch_add(rays, Ordering::Relaxed);
        self.lobes_left_out
            .fetch_add(lobes_left_out, Ordering::Relaxed);
        self.done.fetch_add(done, Ordering::Relaxed);
    }

    /// The ray of a sample, at an offset from the pixel's centre.
    #[inline]
    fn ray(&self, x: u32, y: u32, sampler: &Sampler, offset: Vec2) -> CameraRay {
        self.ray_in((self.world, self.camera_ray), (x, y), sampler, offset)
    }

    /// The same in one of the worlds.
    #[inline]
    fn ray_in(
        &self,
        (world, maker): (&World, RayMaker),
        (x, y): (u32, u32),
        sampler: &Sampler,
        offset: Vec2,
    ) -> CameraRay {
        // Pixel centres at half integers; film coordinates −1..1, y up.
        let film = Vec2::new(
            (x as f32 + 0.5 + offset.x) / self.width as f32 * 2.0 - 1.0,
            1.0 - (y as f32 + 0.5 + offset.y) / self.height as f32 * 2.0,
        );
        let camera = (&world.camera, maker);
        match &world.shutter {
            None => camera.1(camera.0, film, sampler),
            Some(shutter) => shutter.ray(camera, (film, (y, self.height)), sampler),
        }
    }

    /// What the ray through the middle of a pixel meets (of a lens: from a random point of it), which is
    /// where Cycles has its depths and positions from.
    fn look(&self, x: u32, y: u32) -> (CenterSample, Option<u32>) {
        let sampler = self.sequence.sampler(x, y, 0);
        let ray = self.ray(x, y, &sampler, Vec2::ZERO);
        if ray.is_none() {
            return (CenterSample::default(), None);
        }
        integrator::meet(self.world, &self.path, &sampler, &ray)
    }

    /// The same as passes of data tell of it, if they tell of nothing else.
    #[cold]
    fn center(&self, x: u32, y: u32) -> Option<Center> {
        let sampler = self.sequence.sampler(x, y, 0);
        let ray = self.ray(x, y, &sampler, Vec2::ZERO);
        let met =
            (!ray.is_none()).then(|| integrator::center(self.world, &self.path, &sampler, &ray));
        met.flatten()
            .filter(|met| met.normal.is_finite() && met.uv.is_finite())
    }

    #[inline]
    fn sample(
        &self,
        (x, y, index): (u32, u32, u32),
        pixel: &mut Pixel,
        beside: Beside,
        center: Option<&Option<Center>>,
    ) -> Path {
        let mut told = Told::default();
        let mut path = self.path(x, y, index, &mut told);
        let caught = told
            .passes
            .as_ref()
            .and_then(|passes| self.caught((x, y, index), passes, &mut path.rays));
        // Once here, so that estimates of the error, passes and states speak of the same picture.
        path.radiance *= self.exposure;
        path.clamped = path.clamped.map(|taken| taken * self.exposure);
        if let Some(passes) = &mut told.passes {
            passes.expose(self.exposure);
        }
        let passes_finite = told.is_finite() && caught.is_none_or(|caught| caught.is_finite());
        if !(path.radiance.is_finite() && path.first.is_finite() && passes_finite) {
            // Counted with its place and cause, black in the picture, never hidden: see `Statistics::non_finite`.
            self.bad(x, y, index);
            path.radiance = Vec3::ZERO;
            path.clamped = [0.0; 2];
            path.first = FirstHit::default();
            told = told.blank();
        }
        if let Some(met) = center {
            path.first.normal = met.map_or(Vec3::ZERO, |met| met.normal);
            if let Some(passes) = &mut told.passes {
                passes.center(met.map(|met| (met.uv, met.object)));
            }
        }
        let second = self.sequence.is_second(x, y, index);
        pixel.add(second, path.radiance, &path.first);
        if !beside.catchers.is_empty() {
            let mut sums = CatcherPixel::read(beside.catchers);
            match (&caught, &told.passes) {
                (Some(caught), Some(passes)) if passes.split.is_some() => {
                    sums.add_caught(caught, self.exposure)
                }
                (_, passes) => {
                    let world = passes
                        .as_ref()
                        .map_or(Vec3::ZERO, PathPasses::of_environment);
                    sums.add(path.radiance, world, path.first.transparent);
                }
            }
            sums.write(beside.catchers);
        }
        if let (Some(sums), Some(features)) = (beside.features, told.features()) {
            sums.add(features);
        }
        if let Some(path) = &told.passes {
            if let Some(sums) = beside.light_passes {
                sums.add(path);
            }
            for (sum, light) in beside.groups.iter_mut().zip(&path.groups) {
                *sum += light.as_dvec3();
            }
            if let Some(sums) = beside.objects {
                for object in &path.objects {
                    sums.add(object, self.mist);
                }
            }
        }
        path
    }

    /// A path by the kernel of the picture. What it tells passes is written in place: it is large, and most pictures have none.
    #[inline]
    fn path(&self, x: u32, y: u32, index: u32, told: &mut Told) -> Path {
        let sampler = self.sequence.sampler(x, y, index);
        let offset = self.filter.sample(sampler.pair(Dimension::Filter, 0));
        let ray = self.ray(x, y, &sampler, offset);
        if ray.is_none() {
            return Path::NONE;
        }
        match self.kernel {
            AnyKernel::Plain(kernel) => kernel(self.world, &self.path, &sampler, &ray),
            AnyKernel::WithFeatures(kernel) => {
                let told = told.features.insert(PathFeatures::FOLLOWED);
                kernel(self.world, &self.path, &sampler, &ray, told)
            }
            AnyKernel::WithPasses { kernel, asked } => {
                let told = told.passes.insert(PathPasses::new(asked));
                kernel(self.world, &self.path, &sampler, &ray, told)
            }
        }
    }

    /// What a path that has met a shadow catcher finds without the objects.
    #[cold]
    fn caught(
        &self,
        (x, y, index): (u32, u32, u32),
        passes: &PathPasses,
        rays: &mut u32,
    ) -> Option<Caught> {
        let (split, alone) = (passes.split?, self.catchers.as_ref()?);
        // The same numbers: where nothing is in the way, both halves have the same bits.
        let sampler = self.sequence.sampler(x, y, index);
        let offset = self.filter.sample(sampler.pair(Dimension::Filter, 0));
        let ray = self.ray_in((alone.world, alone.camera_ray), (x, y), &sampler, offset);
        let path = (alone.kernel)(alone.world, &self.path, &sampler, &ray);
        *rays += path.rays;
        let behind = if self.path.transparent_film {
            Vec3::ZERO
        } else {
            integrator::behind(alone.world, &self.path, &ray)
        };
        Some(caught(split, path.radiance, behind))
    }

    /// Adds what a sample tells passes of the scene's own; rays that it took.
    #[cold]
    fn aovs(&self, x: u32, y: u32, index: u32, sums: &mut [f64]) -> u32 {
        let sampler = self.sequence.sampler(x, y, index);
        let offset = self.filter.sample(sampler.pair(Dimension::Filter, 0));
        let ray = self.ray(x, y, &sampler, offset);
        if ray.is_none() {
            return 0;
        }
        let (sums, vectors) = if self.vectors {
            let (sums, vectors) = sums.split_at_mut(sums.len().saturating_sub(VECTOR_SUMS));
            (sums, vectors.try_into().ok())
        } else {
            (sums, None)
        };
        integrator::add_aovs(self.world, &self.path, &sampler, &ray, (sums, vectors))
    }

    /// The radiance of a sample by the kernel of the picture.
    pub fn radiance(&self, x: u32, y: u32, index: u32) -> Vec3 {
        self.path(x, y, index, &mut Told::default()).radiance
    }

    /// Takes a sample once more, telling each step.
    pub fn record(&self, x: u32, y: u32, index: u32) -> Recorded {
        let sampler = self.sequence.sampler(x, y, index);
        let offset = self.filter.sample(sampler.pair(Dimension::Filter, 0));
        let ray = self.ray(x, y, &sampler, offset);
        let mut recorder = Recorder::default();
        let path = integrator::RECORDING(self.world, &self.path, &sampler, &ray, &mut recorder);
        Recorded {
            offset,
            path,
            steps: recorder.0,
        }
    }

    /// Counts a sample that is not finite.
    #[cold]
    #[inline(never)]
    fn bad(&self, x: u32, y: u32, index: u32) {
        let cause = self.cause(&self.record(x, y, index));
        let mut bad = locked(&self.bad);
        bad.count += 1;
        if bad.examples.len() < EXAMPLES {
            bad.examples.push((x, y, index));
        }
        let cause = if bad.causes.len() < CAUSES || bad.causes.contains_key(&cause) {
            cause
        } else {
            "other causes".into()
        };
        *bad.causes.entry(cause).or_default() += 1;
    }
}
