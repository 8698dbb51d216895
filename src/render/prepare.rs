//! A scene made ready for the samples that settings ask for.

use super::catchers::{CatcherJob, CatcherWorld, has_catchers};
use super::saved::Traced;
use super::trace::{AnyKernel, BadSamples, Job};
use super::{
    Ablation, EffectChoice, Event, FilterKind, InstructionSet, LightSampling, MAX_BRANCHES,
    MAX_LIGHT_SAMPLES, RenderError, RenderSettings,
};
use crate::effects::{self, Effect, EffectReport};
use crate::film::Pass;
use crate::film::filter::FilterTable;
use crate::film::light_passes::Asked;
use crate::integrator::{self, Branches, Kernels, PathSettings};
use crate::sampler::Sequence;
use crate::scene::coincident::Coincident;
use crate::scene::{Camera, Diagnostics, Material, Scene};
use crate::world::{EmbreeError, LightShares, Options, Stale, World};
use enumset::EnumSet;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Mutex, OnceLock};

/// A scene made ready.
pub struct Prepared {
    /// In Embree.
    pub world: World,
    /// Shadow catchers alone, if there are any.
    catchers: Option<CatcherWorld>,
    /// The camera that looks.
    pub camera: Camera,
    kernel: AnyKernel,
    /// Effects that the kernel has, and those outside of it that are called for.
    pub compiled: EnumSet<Effect>,
    /// Effects that the scene calls for and the settings leave out.
    pub left_out: Vec<String>,
    /// Those who work.
    pub pool: rayon::ThreadPool,
    /// How many they are.
    pub threads: usize,
    made_for: MadeFor,
}

/// What a world is made for beside the scene and the view: another calls for another world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MadeFor {
    effects: EnumSet<Effect>,
    threads: usize,
    instructions: Option<InstructionSet>,
    cull_backfaces: bool,
    light_shares: LightShares,
    clamps_direct: bool,
    ablation: Ablation,
    uv_pass: bool,
    aovs: bool,
    vectors: bool,
    roughens: bool,
    catchers: bool,
}

/// What settings want of a scene.
struct Wanted<'a> {
    camera: &'a Camera,
    aspect: f64,
    rows: u32,
    called_for: EnumSet<Effect>,
    effects: EnumSet<Effect>,
    /// Light groups.
    groups: usize,
    /// What coincides in the scene.
    coincident: &'a Coincident,
    made_for: MadeFor,
}

impl<'a> Wanted<'a> {
    fn new(
        (scene, coincident): (&'a Scene, &'a Coincident),
        settings: &RenderSettings,
    ) -> Result<Self, RenderError> {
        let setting = RenderError::Setting;
        check(settings).map_err(setting)?;
        let number = settings.camera.unwrap_or(0);
        let camera = scene.cameras.get(number).ok_or_else(|| {
            setting(match scene.cameras.len() {
                0 => "there is no camera in the scene, and nothing with a size that one could be placed before".into(),
                count => format!("camera {number} is not in the scene, which has {count}"),
            })
        })?;
        let called_for = called_for((scene, coincident), settings);
        let effects = match &settings.effects {
            EffectChoice::Auto => called_for,
            EffectChoice::All => effects::ALL,
            EffectChoice::List(list) => effects::parse(list).map_err(setting)?,
        };
        let threads = settings
            .threads
            .filter(|&n| n > 0)
            .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into));
        Ok(Self {
            camera,
            rows: settings.height,
            aspect: f64::from(settings.width) / f64::from(settings.height)
                * camera.pixel_aspect(&scene.render),
            called_for,
            effects,
            groups: scene.light_groups.len(),
            coincident,
            made_for: MadeFor {
                // The lens is the view's.
                effects: effects - Effect::DepthOfField,
                threads,
                instructions: settings.instruction_set,
                cull_backfaces: settings.cull_backfaces,
                light_shares: settings.light_shares,
                clamps_direct: settings.clamp_direct > 0.0,
                ablation: settings.ablation,
                uv_pass: settings.passes.has(Pass::Uv),
                aovs: settings.passes.has(Pass::Aov) && !scene.aovs.is_empty(),
                vectors: settings.passes.has(Pass::Vector),
                roughens: settings.filter_glossy > 0.0,
                catchers: has_catchers(scene, settings),
            },
        })
    }

    fn options(&self) -> Options<'a> {
        let MadeFor {
            threads,
            instructions,
            cull_backfaces,
            light_shares,
            clamps_direct,
            ablation,
            uv_pass,
            aovs,
            vectors,
            roughens,
            ..
        } = self.made_for;
        Options {
            camera: self.camera,
            aspect: self.aspect,
            rows: self.rows,
            // What the list leaves out is left out of the world, not only of the kernel.
            effects: self.effects,
            threads: Some(threads),
            instructions,
            cull_backfaces,
            light_shares,
            clamps_direct,
            ablation,
            uv_pass,
            aovs,
            vectors,
            roughens,
            coincident: Some(self.coincident),
        }
    }

    /// For the world of the shadow catchers alone.
    fn options_of_catchers(&self) -> Options<'a> {
        Options {
            coincident: None,
            ..self.options()
        }
    }
}

impl Prepared {
    /// Makes a scene ready, with what coincides in it.
    ///
    /// # Errors
    /// A setting makes no picture or does not fit the scene; or Embree fails.
    pub fn new(
        (scene, coincident): (&Scene, &Coincident),
        settings: &RenderSettings,
    ) -> Result<Self, RenderError> {
        let wanted = Wanted::new((scene, coincident), settings)?;
        let threads = wanted.made_for.threads;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| {
                RenderError::Setting(format!("{threads} threads could not be started: {e}"))
            })?;
        let worlds = pool.install(|| {
            let alone = wanted.made_for.catchers.then(|| {
                let options = wanted.options_of_catchers();
                World::new(&scene.of_catchers(), &options)
            });
            Ok((World::new(scene, &wanted.options())?, alone.transpose()?))
        });
        let worlds = worlds.map_err(|e: EmbreeError| RenderError::Embree(e.0))?;
        Ok(Self::of(worlds, pool, settings, &wanted))
    }

    /// Makes a changed scene ready. Tells what was made anew beside the view.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn renewed(
        mut self,
        (scene, coincident): (&Scene, &Coincident),
        settings: &RenderSettings,
        stale: Stale,
    ) -> Result<(Self, Stale), RenderError> {
        let wanted = Wanted::new((scene, coincident), settings)?;
        if wanted.made_for != self.made_for {
            return Ok((Self::new((scene, coincident), settings)?, Stale::ALL));
        }
        let mut alone = self.catchers.take().map(|catchers| catchers.world);
        let made = self
            .pool
            .install(|| {
                if let Some(world) = &mut alone {
                    let options = wanted.options_of_catchers();
                    world.renew(&scene.of_catchers(), &options, stale)?;
                }
                self.world.renew(scene, &wanted.options(), stale)
            })
            .map_err(|e| RenderError::Embree(e.0))?;
        let worlds = (self.world, alone);
        Ok((Self::of(worlds, self.pool, settings, &wanted), made))
    }

    fn of(
        (world, alone): (World, Option<World>),
        pool: rayon::ThreadPool,
        settings: &RenderSettings,
        wanted: &Wanted,
    ) -> Self {
        let (mask, kernel) = kernel(settings, &world, wanted);
        let catchers = alone.map(|world| CatcherWorld {
            kernel: kernels(settings, &world, wanted).1.plain,
            world,
        });
        Self {
            world,
            catchers,
            camera: wanted.camera.clone(),
            kernel,
            compiled: mask | (wanted.effects & wanted.called_for & !effects::PATHS),
            left_out: beyond(wanted.called_for, wanted.effects),
            pool,
            threads: wanted.made_for.threads,
            made_for: wanted.made_for,
        }
    }

    /// How many paths go on from the first vertex.
    fn branches(&self, settings: &RenderSettings) -> Branches {
        match settings.branches {
            Some(count) => Branches::all(count),
            None if settings.bounce_limits.volume == Some(0) => Branches::all(1),
            None if self.world.has_even_fog() => EVEN_FOG_BRANCHES,
            None if self.world.has_fog() => VARYING_FOG_BRANCHES,
            None => Branches::all(1),
        }
    }

    /// What the threads share, after what was done before.
    pub fn job<'a>(
        &'a self,
        scene: &'a Scene,
        settings: &RenderSettings,
        before: &Traced,
    ) -> Job<'a> {
        Job {
            scene,
            world: &self.world,
            catchers: self.catchers.as_ref().map(CatcherJob::new),
            kernel: self.kernel,
            camera_ray: self.world.camera.ray_maker(),
            middle: settings.passes.need_middle(),
            vectors: settings.passes.has(Pass::Vector),
            costs: settings.passes.has(Pass::Cost),
            mist: settings.mist,
            first_sample: settings.first_sample,
            path: path_settings(settings, self.branches(settings)),
            exposure: settings.film_exposure,
            sequence: Sequence::of(settings.seed, settings.sequences),
            filter: match settings.filter.kind {
                FilterKind::Box => FilterTable::box_filter(),
                FilterKind::Gauss => FilterTable::gauss(f64::from(settings.filter.width)),
                FilterKind::BlackmanHarris => {
                    FilterTable::blackman_harris(f64::from(settings.filter.width))
                }
            },
            width: settings.width,
            height: settings.height,
            rays: AtomicU64::new(before.rays),
            lobes_left_out: AtomicU64::new(before.lobes_left_out),
            done: AtomicU64::new(before.samples),
            bad: Mutex::new(BadSamples {
                count: before.non_finite,
                examples: before.non_finite_examples.clone(),
                causes: before.non_finite_causes.clone(),
            }),
            objects: OnceLock::new(),
            stop: AtomicBool::new(false),
            pause: AtomicBool::new(false),
        }
    }
}

/// What is told before so many triangles that shine are made ready that one would wonder; none for usual scenes.
pub fn long(scene: &Scene) -> Option<Event> {
    const MANY: u64 = 1 << 20;
    // Thirty million of them, placed by instances, took four minutes.
    const SECONDS_EACH: f64 = 8e-6;
    let summaries = scene.materials.iter().map(Material::summary);
    let shine: Vec<bool> = summaries.map(|s| s.unlit || s.emits()).collect();
    let shining = scene.instances.iter().filter_map(|instance| {
        let mesh = scene.meshes.get(instance.mesh.0 as usize)?;
        let shines = *shine.get(mesh.material?.0 as usize)?;
        shines.then_some(mesh.triangles.len() as u64)
    });
    let shining: u64 = shining.sum();
    (shining >= MANY).then_some(Event::Preparing {
        shining,
        seconds: shining as f64 * SECONDS_EACH,
    })
}

/// Effects that the scene, with what coincides in it, calls for as the camera of the settings sees it.
pub fn called_for(scene: (&Scene, &Coincident), settings: &RenderSettings) -> EnumSet<Effect> {
    let report = EffectReport::of(scene, &settings.requested(), &[], &Diagnostics::default());
    report.called_for & effects::ALL
}

/// Names of the effects that are called for and that a list in the settings leaves out.
pub fn left_out(called_for: EnumSet<Effect>, settings: &RenderSettings) -> Vec<String> {
    match &settings.effects {
        EffectChoice::Auto | EffectChoice::All => Vec::new(),
        // A list that can't be read is told when the scene is prepared.
        EffectChoice::List(list) => {
            effects::parse(list).map_or(Vec::new(), |wanted| beyond(called_for, wanted))
        }
    }
}

fn beyond(called_for: EnumSet<Effect>, wanted: EnumSet<Effect>) -> Vec<String> {
    effects::names(called_for - wanted - effects::STRUCTURE)
}

/// Paths that go on from the first vertex where there is even fog that scatters light more than once: light comes to it from all around.
/// So many have the least variance for their time, but for a few per cent (docs/notes/cost-of-accuracy.md).
const EVEN_FOG_BRANCHES: Branches = Branches {
    at_surface: 4,
    in_medium: 4,
};

/// The same where fog varies: a way through it takes longer.
const VARYING_FOG_BRANCHES: Branches = Branches {
    at_surface: 2,
    in_medium: 2,
};

/// The kernel for the effects that are wanted, and the effects that it has.
fn kernel(
    settings: &RenderSettings,
    world: &World,
    wanted: &Wanted,
) -> (EnumSet<Effect>, AnyKernel) {
    let passes = settings.passes;
    let occluded = passes.has(Pass::AmbientOcclusion);
    let asked = Asked {
        features: passes.need_features(),
        object: passes.need_objects(),
        occlusion: occluded.then_some(settings.ao_distance),
        groups: wanted.groups,
        environment: passes.has(Pass::Environment),
    };
    let catches = wanted.made_for.catchers;
    if asked.object || asked.groups > 0 || passes.need_light_passes() || catches {
        let kernel = AnyKernel::WithPasses {
            kernel: integrator::WITH_PASSES,
            asked,
        };
        return (effects::PATHS, kernel);
    }
    let (mask, kernels) = kernels(settings, world, wanted);
    let kernel = if asked.features {
        AnyKernel::WithFeatures(kernels.with_features)
    } else {
        AnyKernel::Plain(kernels.plain)
    };
    (mask, kernel)
}

/// The kernels that keep no light apart, and the effects that they have.
fn kernels(
    settings: &RenderSettings,
    world: &World,
    wanted: &Wanted,
) -> (EnumSet<Effect>, Kernels) {
    match settings.light_sampling {
        LightSampling::Hemisphere => integrator::GENERAL,
        _ if settings.ablation.offsets
            || settings.branches.is_some_and(|count| count > 1)
            || world.has_mixed_shaders()
            || world.has_media() =>
        {
            integrator::GENERAL
        }
        _ => integrator::kernel_for(wanted.effects | world.structure()),
    }
}

fn path_settings(settings: &RenderSettings, branches: Branches) -> PathSettings {
    let limit = |clamp: f32| if clamp > 0.0 { clamp } else { f32::INFINITY };
    let most = |limit: Option<u32>| limit.unwrap_or(u32::MAX);
    let limits = settings.bounce_limits;
    PathSettings {
        bounces: settings.bounces,
        limits: [limits.diffuse, limits.glossy, limits.transmission].map(most),
        transparent: most(limits.transparent),
        alpha_threshold: settings.alpha_threshold,
        volume_limit: most(limits.volume),
        clamp: [limit(settings.clamp_direct), limit(settings.clamp_indirect)],
        filter_glossy: settings.filter_glossy,
        transparent_film: settings.transparent_film,
        // α is the square of a roughness.
        clear_alpha: match settings.transparent_glass {
            Some(roughness) if settings.transparent_film => roughness * roughness,
            _ => -1.0,
        },
        caustics: [settings.caustics.reflective, settings.caustics.refractive],
        sample_lights: matches!(
            settings.light_sampling,
            LightSampling::Mis | LightSampling::Nee
        ),
        sample_bsdf: settings.light_sampling != LightSampling::Nee,
        uniform: settings.light_sampling == LightSampling::Hemisphere,
        naive_offsets: settings.ablation.offsets,
        light_samples: settings.light_samples,
        branches,
        roulette: settings.roulette.unwrap_or(u32::MAX),
    }
}

/// Says what no picture can be made with.
fn check(settings: &RenderSettings) -> Result<(), String> {
    let (width, height) = (settings.width, settings.height);
    if width == 0 || height == 0 || width > 65_536 || height > 65_536 {
        return Err(format!(
            "a picture of {width} x {height} pixels can't be made; width and height go from 1 to 65536"
        ));
    }
    if settings.samples == 0 {
        return Err("0 samples make no picture; ask for at least 1".into());
    }
    if settings
        .first_sample
        .checked_add(settings.samples)
        .is_none()
    {
        return Err(format!(
            "samples from {} on are {} too many; there are 4294967295",
            settings.first_sample, settings.samples
        ));
    }
    if !(1..=MAX_LIGHT_SAMPLES).contains(&settings.light_samples) {
        return Err(format!(
            "{} light samples at a surface can't be taken; their number goes from 1 to {MAX_LIGHT_SAMPLES}",
            settings.light_samples
        ));
    }
    if let Some(count) = settings.branches
        && !(1..=MAX_BRANCHES).contains(&count)
    {
        return Err(format!(
            "{count} paths can't go on from what the camera sees; their number goes from 1 to {MAX_BRANCHES}"
        ));
    }
    if !(settings.film_exposure.is_finite() && settings.film_exposure >= 0.0) {
        return Err(format!(
            "a film exposure of {} makes no picture; it is a factor from 0 on",
            settings.film_exposure
        ));
    }
    let region = settings.region();
    if region.x0 >= region.x1 || region.y0 >= region.y1 || region.x1 > width || region.y1 > height {
        return Err(format!(
            "the region from {}, {} to {}, {} is no part of a picture of {width} x {height} pixels",
            region.x0, region.y0, region.x1, region.y1
        ));
    }
    Ok(())
}

#[cfg(test)]
#[path = "../../tests/unit/render/prepare.rs"]
mod tests;
