//! All lights of a scene, and which of them to sample.

mod along;
mod choice;

pub use along::Along;
use choice::AsCycles;
pub use choice::LightChoice;

use super::coplanar::{Coplanar, Plane};
use super::emissive::{EmissiveMesh, EmissiveTriangles, Eye, Twins};
use super::estimate::{Ball, LightBounds, MOST};
use super::finder::Finder;
use super::groups::LightGroups;
use super::kinds::{Groups, Light, LightSample, LightSampleContext};
use super::light_sampler::LightSampler;
use super::linking::Linking;
use super::program::LookingRay;
use super::rules::Rules;
use crate::ffi::embree::{Device, EmbreeError};
use crate::math::float;
use crate::scene::RayKind;
use glam::{Vec2, Vec3};

/// All lights of a scene. It knows nothing of the world that they stand in but what [`super::emissive::EmissiveSurface`] says.
pub struct LightSet {
    /// Finite lights: lamps first, then triangles of meshes.
    lights: Vec<Light>,
    /// Draws one of them.
    sampler: LightSampler,
    /// Who sees each lamp.
    rules: Vec<Rules>,
    /// The lamps that a ray can meet.
    sized: Vec<u32>,
    finder: Option<Finder>,
    coplanar: Option<Box<Coplanar>>,
    camera_sees_lamps: bool,
    emissive: EmissiveTriangles,
    /// Lights at infinity: the environment first, then suns.
    infinite: Vec<InfiniteLight>,
    /// Some of them is looked for, so that finite ones are compared with it.
    compares: bool,
    /// Numbers of lamps and of suns among the scene's lights.
    in_scene: (Vec<u32>, Vec<u32>),
    groups: LightGroups,
    linking: Option<Box<Linking>>,
    as_cycles: Option<Box<AsCycles>>,
    /// What is seen of a light depends on how often it is drawn, without clamping too.
    hangs_on_choice: bool,
    /// About the finite lights; `None` where Cycles, without its Light Tree, draws lights behind a surface as often as before it.
    balls: Option<Vec<Ball>>,
}

struct InfiniteLight {
    light: Light,
    rules: Rules,
    /// Luminance of its irradiance.
    estimate: f32,
    source: Source,
}

/// Something that shines, for those who look at a single path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The surface of an object, by its number among those with triangles.
    Surface(u32),
    /// A lamp, by its number among all finite lights.
    Lamp(u32),
    /// A sun's disc, by its number among the suns.
    Sun(u32),
    /// The environment.
    Environment,
}

/// Which lights a ray looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shadows {
    /// Those of which all objects cast shadows: what a ray does not meet.
    Plain,
    /// Those with blockers of their own.
    Linked,
}

/// Between what the first choice is made.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Group {
    /// All finite lights.
    Finite,
    /// One at infinity.
    Infinite(usize),
}

/// A light that was drawn.
#[derive(Clone, Copy, Debug)]
pub enum Drawn {
    /// By its number among the finite ones.
    Finite(u32),
    /// By its number among those at infinity.
    Infinite(u32),
}

/// How much of the choice between finite lights and each at infinity is by estimates.
const BY_ESTIMATE: f32 = 0.8;

/// Up to this number, rays try lamps one by one; more go into a hierarchy of their own.
const IN_A_ROW: usize = 4;

/// Gathers the lights of a scene.
pub struct LightSetBuilder {
    set: LightSet,
    suns: Vec<InfiniteLight>,
    /// By lamps the planes that they lie in.
    planes: Vec<Option<Plane>>,
    eye: Eye,
    /// `None` where back faces are not there.
    twins: Option<Twins>,
}

impl LightSetBuilder {
    /// Of what is seen from a camera; `cull_backfaces`: surfaces with one side have no back.
    pub fn new(eye: Eye, cull_backfaces: bool, groups: LightGroups) -> Self {
        Self {
            set: LightSet {
                lights: Vec::new(),
                sampler: LightSampler::default(),
                rules: Vec::new(),
                sized: Vec::new(),
                finder: None,
                coplanar: None,
                camera_sees_lamps: false,
                emissive: EmissiveTriangles::default(),
                infinite: Vec::new(),
                compares: false,
                in_scene: (Vec::new(), Vec::new()),
                groups,
                linking: None,
                as_cycles: None,
                hangs_on_choice: false,
                balls: None,
            },
            suns: Vec::new(),
            planes: Vec::new(),
            eye,
            twins: (!cull_backfaces).then(Twins::default),
        }
    }

    /// Gives it the links of a scene.
    pub fn link(&mut self, linking: Linking) {
        self.set.linking = Some(linking.into());
    }

    /// Light samples and rays find different things: each part counts with the weight that it has in Cycles.
    pub fn hang_on_choice(&mut self) {
        self.set.hangs_on_choice = true;
    }

    /// Adds a lamp or a sun by its number among the scene's lights. Lamps come before emissive meshes. `plane`: where it hides others that
    /// lie in its plane, as in Cycles.
    pub fn add_in(&mut self, plane: Option<Plane>, light: Light, rules: Rules, in_scene: u32) {
        if plane.is_some() {
            self.planes.resize(self.set.lights.len(), None);
            self.planes.push(plane);
        }
        self.add(light, rules, in_scene);
    }

    /// The same of a light that hides none.
    pub fn add(&mut self, light: Light, rules: Rules, in_scene: u32) {
        if light.bounds().is_none() {
            self.suns.push(InfiniteLight {
                estimate: light.irradiance().min(MOST),
                light,
                rules,
                source: Source::Sun(self.suns.len() as u32),
            });
            self.set.in_scene.1.push(in_scene);
            return;
        }
        debug_assert_eq!(
            self.set.lights.len(),
            self.set.rules.len(),
            "lamps come first"
        );
        if light.is_sized() {
            self.set.sized.push(self.set.lights.len() as u32);
            self.set.camera_sees_lamps |= rules.visibility.sees(RayKind::Camera);
        }
        self.set.lights.push(light);
        self.set.rules.push(rules);
        self.set.in_scene.0.push(in_scene);
    }

    /// Adds a mesh that emits.
    pub fn add_mesh(&mut self, mesh: EmissiveMesh) {
        let LightSet {
            lights, emissive, ..
        } = &mut self.set;
        emissive.add(mesh, &self.eye, self.twins.as_mut(), lights);
    }

    /// Adds the light from all around.
    pub fn add_environment(&mut self, light: Light, rules: Rules) {
        self.set.infinite.push(InfiniteLight {
            estimate: light.irradiance().min(MOST),
            light,
            rules,
            source: Source::Environment,
        });
    }

    /// The set.
    ///
    /// # Errors
    /// If Embree fails.
    pub fn build(self, choice: LightChoice, device: &Device) -> Result<LightSet, EmbreeError> {
        let mut set = self.set;
        set.coplanar = Coplanar::new(&self.planes).map(Box::new);
        // How much rays lose of lamps that hide each other depends on how often these are drawn.
        set.hangs_on_choice |= set.coplanar.is_some();
        let choice = match choice {
            LightChoice::Place if set.hangs_on_choice => LightChoice::Tree,
            _ => choice,
        };
        set.infinite.extend(self.suns);
        set.leave_even_sky_to_bsdf();
        set.compares = set.infinite.iter().any(|light| light.estimate > 0.0);
        if set.sized.len() > IN_A_ROW {
            set.finder = Some(Finder::new(&set.lights, &set.sized, device)?);
        }
        set.lights.shrink_to_fit();
        let mut bounds: Vec<LightBounds> = Vec::with_capacity(set.lights.len());
        bounds.extend(set.lights.iter().filter_map(Light::bounds));
        let balls = || bounds.iter().map(LightBounds::ball).collect();
        set.balls = (choice != LightChoice::Even).then(balls);
        if choice == LightChoice::Power {
            choice::by_power(&mut bounds);
        }
        if let Some(mut linking) = set.linking.take() {
            let finite = (0..).zip(&bounds).map(|(number, &bounds)| {
                let source = set.source(Drawn::Finite(number));
                (source, set.number_in_scene(source), bounds)
            });
            let infinite =
                |i: &InfiniteLight| (i.source, set.number_in_scene(i.source), i.estimate);
            let infinite: Vec<_> = set.infinite.iter().map(infinite).collect();
            linking.prepare(&finite.collect::<Vec<_>>(), &infinite);
            set.linking = Some(linking);
        }
        set.sampler = LightSampler::new(bounds);
        // Lights that are linked are drawn by who sees them.
        if set.linking.is_none() {
            let as_cycles = match choice {
                LightChoice::Even => set.evenly(),
                LightChoice::Tree => set.by_tree(),
                LightChoice::Place | LightChoice::Power => None,
            };
            set.as_cycles = as_cycles.map(Box::new);
        }
        Ok(set)
    }
}

impl LightSet {
    /// Whether a light is a sky of one colour, which Cycles does not sample.
    #[inline]
    pub fn is_even_sky(&self, drawn: Drawn) -> bool {
        matches!(drawn, Drawn::Infinite(i) if is_even(&self.infinite[i as usize].light))
    }

    /// Whether the lights of another camera may be others.
    pub fn depends_on(&self, before: &Eye, after: &Eye) -> bool {
        self.emissive.depend_on(before, after)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sampler.is_empty() && self.infinite.is_empty()
    }

    /// Whether there are none at infinity but points: what a ray finds behind everything is black.
    pub fn are_all_near(&self) -> bool {
        self.infinite.iter().all(|other| !other.light.is_sized())
    }

    /// A point that is to be lit.
    #[inline]
    pub fn context(&self, point: Vec3, normal: Option<Vec3>) -> LightSampleContext {
        let mut at = LightSampleContext::new(point, normal);
        self.context_into(&mut at, point, normal);
        at
    }

    /// Makes a context the one of a point that is to be lit: in place, as it is large.
    #[inline]
    pub fn context_into(&self, at: &mut LightSampleContext, point: Vec3, normal: Option<Vec3>) {
        (at.point, at.normal) = (point, normal);
        (at.facing, at.clamps) = (None, true);
        let sampler = self.sampler_for(at.receiver);
        sampler.pmf_into(&mut at.pmf, point, normal, self.compares);
        if self.compares {
            let finite = at.pmf.sum.min(MOST);
            let mut groups = Groups {
                sum: finite,
                count: f32::from(finite > 0.0),
                finite,
            };
            for i in 0..self.infinite.len() {
                let estimate = self.estimate(i, at.receiver);
                groups.sum += estimate;
                groups.count += f32::from(estimate > 0.0);
            }
            at.groups = groups;
        }
    }

    /// The choice between finite lights that a set of receivers has.
    #[inline]
    fn sampler_for(&self, receiver: u8) -> &LightSampler {
        if receiver == 0 {
            return &self.sampler;
        }
        let linking = self.linking.as_deref();
        let own = linking.and_then(|linking| linking.receivers(receiver));
        own.map_or(&self.sampler, |own| &own.sampler)
    }

    /// The estimate of a light at infinity that a set of receivers has.
    #[inline]
    fn estimate(&self, light: usize, receiver: u8) -> f32 {
        if receiver == 0 {
            return self.infinite[light].estimate;
        }
        let linking = self.linking.as_deref();
        let own = linking.and_then(|linking| linking.receivers(receiver));
        own.map_or(self.infinite[light].estimate, |own| own.infinite[light])
    }

    /// Whether lights are linked to objects.
    #[inline]
    pub fn is_linked(&self) -> bool {
        self.linking.is_some()
    }

    /// Whether some of them have blockers of their own.
    pub fn is_shadow_linked(&self) -> bool {
        let linking = self.linking.as_deref();
        linking.is_some_and(|linking| linking.has_blockers)
    }

    /// The set of receivers that an object is in; 0 where nothing is linked.
    #[cold]
    pub fn receiver(&self, object: u32) -> u8 {
        let linking = self.linking.as_deref();
        linking.map_or(0, |linking| linking.receiver(object))
    }

    /// Whether a light reaches a set of receivers.
    #[cold]
    pub fn reaches(&self, source: Source, receiver: u8) -> bool {
        (self.linking.as_deref())
            .is_none_or(|l| l.reaches(source, self.number_in_scene(source), receiver))
    }

    /// Mask of the rays that look for a light's blockers, if it has some of its own.
    #[cold]
    pub fn blockers(&self, source: Source) -> Option<u32> {
        let linking = self.linking.as_deref()?;
        linking.blockers(source, self.number_in_scene(source))
    }

    /// Probability of a group, by the estimated irradiance, a part of it evenly so that no
    /// estimate can starve a group.
    #[inline]
    fn group_probability(&self, group: Group, at: &LightSampleContext) -> f32 {
        if !self.compares {
            return f32::from(group == Group::Finite);
        }
        let Groups { sum, count, finite } = at.groups;
        let estimate = match group {
            Group::Finite => finite,
            Group::Infinite(i) => self.estimate(i, at.receiver),
        };
        if estimate <= 0.0 {
            return 0.0;
        }
        BY_ESTIMATE * estimate / sum + (1.0 - BY_ESTIMATE) / count
    }

    #[inline(always)]
    fn choose_group(&self, at: &LightSampleContext, u: f32) -> Option<(Group, f32, f32)> {
        if !self.compares {
            return Some((Group::Finite, 1.0, u));
        }
        let mut u = u;
        let mut last = None;
        let mut group = Group::Finite;
        let mut next = 0;
        if self.sampler.is_empty() {
            (group, next) = (Group::Infinite(0), 1);
        }
        loop {
            let p = self.group_probability(group, at);
            if p > 0.0 {
                if u < p {
                    return Some((group, p, (u / p).min(float::ONE_MINUS_EPSILON)));
                }
                u -= p;
                last = Some((group, p));
            }
            if next == self.infinite.len() {
                break;
            }
            (group, next) = (Group::Infinite(next), next + 1);
        }
        // Rounding left a crumb of u.
        last.map(|(group, p)| (group, p, float::ONE_MINUS_EPSILON))
    }

    /// Draws a light and a direction to it. The density is that of all of light sampling for this direction
    /// of this light.
    #[inline]
    pub fn sample(
        &self,
        at: &LightSampleContext,
        u_light: f32,
        u: Vec2,
    ) -> Option<(LightSample, Drawn)> {
        let (drawn, p) = self.draw(at, u_light)?;
        // One light alone is drawn without a look at its estimate.
        if at.receiver != 0 && !self.reaches(self.source(drawn), at.receiver) {
            return None;
        }
        if self.is_behind(at, drawn) {
            return None;
        }
        let sample = self.light(drawn).sample_li(at, u)?;
        let sample = match self.as_cycles_at(at) {
            None => sample.chosen(p)?,
            Some(cycles) => {
                let as_cycles = cycles.probability(|| at.receiver_in_tree(), drawn);
                sample.chosen(as_cycles)?.counting(as_cycles / p)
            }
        };
        Some((sample, drawn))
    }

    #[inline(always)]
    fn light(&self, drawn: Drawn) -> &Light {
        match drawn {
            Drawn::Finite(number) => &self.lights[number as usize],
            Drawn::Infinite(i) => &self.infinite[i as usize].light,
        }
    }

    /// Draws a light, with its probability.
    #[inline(always)]
    fn draw(&self, at: &LightSampleContext, u: f32) -> Option<(Drawn, f32)> {
        let (group, p, u) = self.choose_group(at, u)?;
        match group {
            Group::Infinite(i) => Some((Drawn::Infinite(i as u32), p)),
            Group::Finite => {
                let sampler = self.sampler_for(at.receiver);
                let choice = sampler.sample(&at.pmf, at.place(), u)?;
                Some((Drawn::Finite(choice.emitter), p * choice.probability))
            }
        }
    }

    /// Who sees a light.
    pub fn rules(&self, drawn: Drawn) -> Rules {
        match drawn {
            Drawn::Infinite(i) => self.infinite[i as usize].rules,
            Drawn::Finite(number) => match self.lights[number as usize].of_surface() {
                Some((_, rules)) => rules,
                None => self.rules[number as usize],
            },
        }
    }

    /// What a light is to those who look at a single path.
    #[cold]
    pub fn source(&self, drawn: Drawn) -> Source {
        match drawn {
            Drawn::Infinite(i) => self.infinite[i as usize].source,
            Drawn::Finite(number) => match self.lights[number as usize].of_surface() {
                Some((instance, _)) => Source::Surface(instance),
                None => Source::Lamp(number),
            },
        }
    }

    /// Number of a lamp or sun among the scene's lights; `None` for what is none.
    pub fn number_in_scene(&self, source: Source) -> Option<u32> {
        match source {
            Source::Lamp(number) => self.in_scene.0.get(number as usize).copied(),
            Source::Sun(number) => self.in_scene.1.get(number as usize).copied(),
            Source::Surface(_) | Source::Environment => None,
        }
    }

    /// The light group of what shines, by its number.
    #[cold]
    pub fn group(&self, source: Source) -> Option<usize> {
        self.groups.of_source(source, self.number_in_scene(source))
    }

    /// Cycles' choice, where the picture depends on it: what is not clamped has less noise by Sundog's own.
    #[inline]
    fn as_cycles_at(&self, at: &LightSampleContext) -> Option<&AsCycles> {
        let cycles = self.as_cycles.as_deref()?;
        (at.clamps || self.hangs_on_choice).then_some(cycles)
    }

    /// Probability with which [`Self::sample`] says that it draws a light: its own, or Cycles'.
    #[inline]
    fn told_probability(&self, at: &LightSampleContext, light: Drawn) -> f32 {
        if let Some(cycles) = self.as_cycles_at(at) {
            return cycles.probability(|| at.receiver_in_tree(), light);
        }
        if self.is_behind(at, light) {
            return 0.0;
        }
        self.drawn_probability(at, light)
    }

    /// Probability with which it draws a finite light.
    #[inline]
    fn probability(&self, at: &LightSampleContext, light: u32) -> f32 {
        let p = self.group_probability(Group::Finite, at);
        if p <= 0.0 {
            return 0.0;
        }
        let sampler = self.sampler_for(at.receiver);
        p * sampler.probability(&at.pmf, at.place(), light)
    }

    /// Density with which [`Self::sample`] finds a point `on` a triangle of an instance; 0 if that is no light.
    #[inline]
    pub fn surface_pdf(
        &self,
        at: &LightSampleContext,
        wi: Vec3,
        (instance, triangle): (u32, u32),
        on: Vec3,
    ) -> f32 {
        let Some(number) = self.emissive.light(instance, triangle) else {
            return 0.0;
        };
        let p = self.told_probability(at, Drawn::Finite(number));
        if p <= 0.0 {
            return 0.0;
        }
        p * self.lights[number as usize].pdf_li(at, wi, on)
    }

    /// Whether a ray that left a set of receivers finds a light that is linked: one with blockers of its own is looked for by
    /// itself, but for the camera.
    #[cold]
    pub fn is_found(
        &self,
        source: Source,
        receiver: u8,
        (kind, shadows): (RayKind, Shadows),
    ) -> bool {
        let own = kind != RayKind::Camera && self.blockers(source).is_some();
        own == (shadows == Shadows::Linked) && self.reaches(source, receiver)
    }

    /// Whether rays can meet lamps after so many bounces.
    #[inline]
    pub fn has_lamps_for(&self, bounces: u32) -> bool {
        !self.sized.is_empty() && (bounces > 0 || self.camera_sees_lamps)
    }

    /// Visits the lamps that a ray meets before `far`, in their order: radiance, and the density
    /// with which light sampling from `at` finds the direction (infinite where nothing else may find it). The
    /// ray is of a kind and left after so many bounces.
    #[inline]
    pub fn le_along_ray(
        &self,
        at: &LightSampleContext,
        (origin, wi, far): (Vec3, Vec3, f32),
        (kind, bounces, shadows): (RayKind, u32, Shadows),
        mut visit: impl FnMut(Vec3, f32, Source, f32),
    ) {
        if self.sized.is_empty() {
            return;
        }
        let (ray, looking) = ((origin, wi), LookingRay::to_lamp(kind, bounces));
        let mut meet = |number: u32| {
            let light = &self.lights[number as usize];
            let rules = &self.rules[number as usize];
            let hit = light.le(at, ray, looking);
            let Some(hit) = hit.filter(|hit| hit.distance < far) else {
                return;
            };
            if !rules.allow(kind, at.also, bounces)
                || self.is_hidden(number, at, (origin, wi, far), kind)
            {
                return;
            }
            if self.linking.is_some()
                && !self.is_found(Source::Lamp(number), at.receiver, (kind, shadows))
            {
                return;
            }
            let pdf = if kind != RayKind::Camera && rules.only_sampled() {
                f32::INFINITY
            } else {
                self.told_probability(at, Drawn::Finite(number)) * light.pdf_li(at, wi, hit.on)
            };
            visit(hit.radiance, pdf, Source::Lamp(number), hit.distance);
        };
        match &self.finder {
            None => self.sized.iter().copied().for_each(meet),
            Some(finder) => {
                let numbers = finder.along(origin, wi, far);
                numbers.into_iter().for_each(&mut meet);
            }
        }
    }

    /// Whether a ray meets another lamp in the plane of one that it meets, and so does not find this one.
    #[inline]
    fn is_hidden(
        &self,
        lamp: u32,
        at: &LightSampleContext,
        (origin, wi, far): (Vec3, Vec3, f32),
        kind: RayKind,
    ) -> bool {
        let Some(coplanar) = &self.coplanar else {
            return false;
        };
        coplanar.is_hidden(lamp, (origin, wi), |other| {
            let rules = &self.rules[other as usize];
            let looked_for = match kind {
                RayKind::Camera => rules.visibility.sees(kind),
                _ => rules.is_hit,
            };
            let hit = self.lights[other as usize].le(at, (origin, wi), LookingRay::sampling(0));
            looked_for && hit.is_some_and(|hit| hit.distance < far)
        })
    }

    /// Visits the lights at infinity that a ray finds where it meets nothing, as [`Self::le_along_ray`] does.
    #[inline]
    pub fn environment_le(
        &self,
        at: &LightSampleContext,
        wi: Vec3,
        (kind, bounces, shadows): (RayKind, u32, Shadows),
        mut visit: impl FnMut(Vec3, f32, Source),
    ) {
        for (i, infinite) in self.infinite.iter().enumerate() {
            let InfiniteLight {
                light,
                rules,
                source,
                ..
            } = infinite;
            if !rules.allow(kind, at.also, bounces) {
                continue;
            }
            if self.linking.is_some() && !self.is_found(*source, at.receiver, (kind, shadows)) {
                continue;
            }
            let hit = match light {
                Light::Environment(environment) => {
                    let depth = bounces + 1 + u32::from(kind != RayKind::Camera);
                    let kind = kind.bit() | at.also;
                    Some(environment.le(wi, LookingRay { kind, depth }))
                }
                // From infinity the ray's origin makes no difference.
                _ => light.le(at, (at.point, wi), LookingRay::to_lamp(kind, bounces)),
            };
            let Some(hit) = hit else {
                continue;
            };
            let pdf = if kind == RayKind::Camera {
                0.0
            } else if rules.only_sampled() {
                f32::INFINITY
            } else {
                self.told_probability(at, Drawn::Infinite(i as u32)) * light.pdf_li(at, wi, hit.on)
            };
            visit(hit.radiance, pdf, *source);
        }
    }
}

/// Whether a light is a sky of one colour; toward openings Cycles samples those, too.
fn is_even(light: &Light) -> bool {
    matches!(light, Light::Environment(sky) if sky.is_constant() && !sky.has_portals())
}

#[cfg(test)]
#[path = "../../tests/unit/light/set.rs"]
mod tests;
