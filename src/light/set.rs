//! All lights of a scene, and which of them to sample.

use super::emissive::{EmissiveMesh, EmissiveTriangles, Eye, Twins};
use super::estimate::{Angle, LightBounds, MOST};
use super::finder::Finder;
use super::kinds::{Groups, Light, LightSample, LightSampleContext};
use super::light_sampler::LightSampler;
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
    camera_sees_lamps: bool,
    emissive: EmissiveTriangles,
    /// Lights at infinity: the environment first, then suns.
    infinite: Vec<InfiniteLight>,
    /// Numbers of lamps and of suns among the scene's lights.
    in_scene: (Vec<u32>, Vec<u32>),
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

/// Up to this number, rays try lamps one by one; more go into a hierarchy of their own.
const IN_A_ROW: usize = 4;

/// Gathers the lights of a scene.
pub struct LightSetBuilder {
    set: LightSet,
    suns: Vec<InfiniteLight>,
    eye: Eye,
    /// `None` where back faces are not there.
    twins: Option<Twins>,
}

impl LightSetBuilder {
    /// Of what is seen from a camera; `cull_backfaces`: surfaces with one side have no back.
    pub fn new(eye: Eye, cull_backfaces: bool) -> Self {
        Self {
            set: LightSet {
                lights: Vec::new(),
                sampler: LightSampler::default(),
                rules: Vec::new(),
                sized: Vec::new(),
                finder: None,
                camera_sees_lamps: false,
                emissive: EmissiveTriangles::default(),
                infinite: Vec::new(),
                in_scene: (Vec::new(), Vec::new()),
            },
            suns: Vec::new(),
            eye,
            twins: (!cull_backfaces).then(Twins::default),
        }
    }

    /// Adds a lamp or a sun by its number among the scene's lights. Lamps come before emissive meshes.
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

    /// The set. `by_place`: finite lights are chosen by where they are, otherwise by their power alone.
    ///
    /// # Errors
    /// If Embree fails.
    pub fn build(self, by_place: bool, device: &Device) -> Result<LightSet, EmbreeError> {
        let mut set = self.set;
        set.infinite.extend(self.suns);
        if set.sized.len() > IN_A_ROW {
            set.finder = Some(Finder::new(&set.lights, &set.sized, device)?);
        }
        set.lights.shrink_to_fit();
        let mut bounds: Vec<LightBounds> = Vec::with_capacity(set.lights.len());
        bounds.extend(set.lights.iter().filter_map(Light::bounds));
        if !by_place {
            by_power(&mut bounds);
        }
        set.sampler = LightSampler::new(bounds);
        Ok(set)
    }
}

/// Makes all lights of a tree look as if they stood in the same place and shone everywhere, so that they are drawn by their
/// power alone. One is left as it is: the estimate for all of them is weighed against the sky's.
fn by_power(bounds: &mut [LightBounds]) {
    let [first, rest @ ..] = &*bounds else {
        return;
    };
    if rest.is_empty() {
        return;
    }
    let (min, max) = rest.iter().fold((first.min, first.max), |(min, max), b| {
        (min.min(b.min), max.max(b.max))
    });
    for b in bounds {
        *b = LightBounds {
            min,
            max,
            intensity: b.intensity,
            axis: Vec3::Z,
            normals: Angle::ALL,
            cos_emission: 0.0,
            two_sided: true,
            front: None,
        };
    }
}

impl LightSet {
    /// Whether the lights of another camera may be others.
    pub fn depends_on(&self, before: &Eye, after: &Eye) -> bool {
        self.emissive.depend_on(before, after)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sampler.is_empty() && self.infinite.is_empty()
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
        let compared = !self.infinite.is_empty();
        (at.point, at.normal) = (point, normal);
        self.sampler.pmf_into(&mut at.pmf, point, normal, compared);
        at.groups = Groups {
            sum: 1.0,
            count: 1.0,
            finite: 1.0,
        };
        if compared {
            let finite = at.pmf.sum.min(MOST);
            let groups = &mut at.groups;
            *groups = Groups {
                sum: finite,
                count: f32::from(finite > 0.0),
                finite,
            };
            for light in &self.infinite {
                groups.sum += light.estimate;
                groups.count += f32::from(light.estimate > 0.0);
            }
        }
    }

    /// Probability of a group, by the estimated irradiance, a part of it evenly so that no
    /// estimate can starve a group.
    #[inline]
    fn group_probability(&self, group: Group, at: &LightSampleContext) -> f32 {
        if self.infinite.is_empty() {
            return 1.0;
        }
        let Groups { sum, count, finite } = at.groups;
        let estimate = match group {
            Group::Finite => finite,
            Group::Infinite(i) => self.infinite[i].estimate,
        };
        if estimate <= 0.0 {
            return 0.0;
        }
        0.8 * estimate / sum + 0.2 / count
    }

    #[inline(always)]
    fn choose_group(&self, at: &LightSampleContext, u: f32) -> Option<(Group, f32, f32)> {
        if self.infinite.is_empty() {
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
        let light = match drawn {
            Drawn::Finite(number) => &self.lights[number as usize],
            Drawn::Infinite(i) => &self.infinite[i as usize].light,
        };
        Some((light.sample_li(at, u)?.chosen(p)?, drawn))
    }

    /// Draws a light, with its probability.
    #[inline(always)]
    fn draw(&self, at: &LightSampleContext, u: f32) -> Option<(Drawn, f32)> {
        let (group, p, u) = self.choose_group(at, u)?;
        match group {
            Group::Infinite(i) => Some((Drawn::Infinite(i as u32), p)),
            Group::Finite => {
                let choice = self.sampler.sample(&at.pmf, at.place(), u)?;
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

    /// Probability with which [`Self::sample`] draws a finite light.
    #[inline]
    fn probability(&self, at: &LightSampleContext, light: u32) -> f32 {
        let p = self.group_probability(Group::Finite, at);
        if p <= 0.0 {
            return 0.0;
        }
        p * self.sampler.probability(&at.pmf, at.place(), light)
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
        let p = self.probability(at, number);
        if p <= 0.0 {
            return 0.0;
        }
        p * self.lights[number as usize].pdf_li(at, wi, on)
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
        (kind, bounces): (RayKind, u32),
        mut visit: impl FnMut(Vec3, f32, Source),
    ) {
        if self.sized.is_empty() {
            return;
        }
        let mut meet = |number: u32| {
            let light = &self.lights[number as usize];
            let rules = &self.rules[number as usize];
            let Some(hit) = light.le(at, origin, wi).filter(|hit| hit.distance < far) else {
                return;
            };
            if !rules.allow(kind, bounces) {
                return;
            }
            let pdf = if kind != RayKind::Camera && rules.shines_through() {
                f32::INFINITY
            } else {
                self.probability(at, number) * light.pdf_li(at, wi, hit.on)
            };
            visit(hit.radiance, pdf, Source::Lamp(number));
        };
        match &self.finder {
            None => self.sized.iter().copied().for_each(meet),
            Some(finder) => {
                let numbers = finder.along(origin, wi, far);
                numbers.into_iter().for_each(&mut meet);
            }
        }
    }

    /// Visits the lights at infinity that a ray finds where it meets nothing, as [`Self::le_along_ray`] does.
    #[inline]
    pub fn environment_le(
        &self,
        at: &LightSampleContext,
        wi: Vec3,
        (kind, bounces): (RayKind, u32),
        mut visit: impl FnMut(Vec3, f32, Source),
    ) {
        for (i, infinite) in self.infinite.iter().enumerate() {
            let InfiniteLight {
                light,
                rules,
                source,
                ..
            } = infinite;
            if !rules.allow(kind, bounces) {
                continue;
            }
            // From infinity the ray's origin makes no difference.
            let Some(hit) = light.le(at, at.point, wi) else {
                continue;
            };
            let pdf = if kind == RayKind::Camera {
                0.0
            } else if rules.shines_through() {
                f32::INFINITY
            } else {
                self.group_probability(Group::Infinite(i), at) * light.pdf_li(at, wi, hit.on)
            };
            visit(hit.radiance, pdf, *source);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::area::Area;
    use super::super::emissive::tests::{eye, halves, mesh};
    use super::super::environment::Environment;
    use super::super::lamp::Lamp;
    use super::super::sun::Sun;
    use super::*;
    use crate::math::warp;
    use crate::math::warp::grid;
    use crate::scene::Visibility;
    use glam::{DAffine3, DVec3};

    fn ball(x: f32) -> Light {
        Light::Lamp(Box::new(Lamp {
            center: Vec3::new(x, 0.0, 3.0),
            radius: 0.4,
            soft_falloff: false,
            intensity: Vec3::splat(3.0 + x),
            cone: None,
        }))
    }

    fn area() -> Light {
        let place = DAffine3::from_translation(DVec3::new(0.0, 2.0, 2.5));
        let area = Area::new(&place, [0.8, 0.5], false, Vec3::splat(4.0), true, 3.2);
        Light::Area(Box::new(area.unwrap()))
    }

    fn sun() -> Light {
        let toward = Vec3::new(-0.5, -0.3, 1.0).normalize();
        Light::Sun(Sun::new(toward, Vec3::splat(0.7), 0.5))
    }

    fn sky() -> Light {
        Light::Environment(Box::new(Environment::constant(Vec3::splat(0.2))))
    }

    /// Some balls and one each of the other lamps, of suns, skies and emissive squares.
    fn set(balls: u32, by_place: bool) -> LightSet {
        let mut builder = LightSetBuilder::new(eye(), false);
        for i in 0..balls {
            builder.add(ball(1.5 * i as f32 - 2.0), Rules::NONE, i);
        }
        builder.add(sun(), Rules::NONE, balls);
        builder.add(area(), Rules::NONE, balls + 1);
        let triangles = halves(Vec3::new(-2.0, -2.0, 2.0), 1.0).to_vec();
        builder.add_mesh(mesh(4, triangles));
        builder.add_environment(sky(), Rules::NONE);
        let device = Device::new(Some(1), None).unwrap();
        builder.build(by_place, &device).unwrap()
    }

    /// What rays find, with the densities of light sampling: the irradiance, and the integral of the densities, that of samples
    /// left out which are behind others.
    fn found(set: &LightSet, at: &LightSampleContext, n: u32) -> (f64, f64) {
        let (mut irradiance, mut density) = (0.0, 0.0);
        let square = halves(Vec3::new(-2.0, -2.0, 2.0), 1.0);
        for wi in grid(n).map(warp::sphere) {
            let mut add = |radiance: Vec3, pdf: f32| {
                irradiance += f64::from(radiance.x * wi.z.max(0.0));
                density += f64::from(pdf);
            };
            let ray = (RayKind::Diffuse, 0);
            set.le_along_ray(at, (at.point, wi, f32::INFINITY), ray, |e, pdf, _| {
                add(e, pdf);
            });
            set.environment_le(at, wi, ray, |e, pdf, _| add(e, pdf));
            let on = at.point + wi * ((2.0 - at.point.z) / wi.z);
            let (low, high) = (square[0][0], square[0][2]);
            let within = on.truncate().cmpge(low.truncate()).all()
                && on.truncate().cmple(high.truncate()).all();
            if wi.z > 0.0 && within {
                add(Vec3::splat(3.0), set.surface_pdf(at, wi, (4, 0), on));
            }
        }
        let each = 4.0 * std::f64::consts::PI / f64::from(n * n);
        (irradiance * each, density * each)
    }

    /// With few lights and many, chosen by place and by power: samples of the set and rays find the same light, by one
    /// estimate of the density.
    #[test]
    fn samples_of_all_lights_and_rays_find_the_same() {
        for (balls, by_place) in [(2, true), (2, false), (20, true), (20, false)] {
            let set = set(balls, by_place);
            let at = set.context(Vec3::new(0.1, 0.2, 0.3), Some(Vec3::Z));
            let (n, choices) = (16, 4000);
            let (mut irradiance, mut drawn) = (0.0, 0u32);
            for k in 0..choices {
                let u_light = (k as f32 + 0.5) / choices as f32;
                for u in grid(n) {
                    if let Some((s, _)) = set.sample(&at, u_light, u) {
                        irradiance += f64::from(s.contribution().x * s.wi.z.max(0.0));
                        drawn += 1;
                    }
                }
            }
            let all = f64::from(n * n * choices);
            let (by_rays, density) = found(&set, &at, 900);
            assert!(
                (irradiance / all / by_rays - 1.0).abs() < 1e-2,
                "{balls} {by_place}: {} {by_rays}",
                irradiance / all
            );
            let drawn = f64::from(drawn) / all;
            assert!(
                (density - drawn).abs() < 1e-2,
                "{balls} {by_place}: {density} {drawn}"
            );
        }
    }

    /// Sources have the numbers that the scene gives them, in whatever order lamps and suns come.
    #[test]
    fn sources_are_known_by_their_numbers_in_the_scene() {
        let set = set(2, true);
        let numbers = [
            (Source::Lamp(0), Some(0)),
            (Source::Lamp(2), Some(3)),
            (Source::Sun(0), Some(2)),
            (Source::Lamp(3), None),
            (Source::Surface(4), None),
            (Source::Environment, None),
        ];
        for (source, number) in numbers {
            assert_eq!(set.number_in_scene(source), number, "{source:?}");
        }
        let at = set.context(Vec3::ZERO, Some(Vec3::Z));
        let drawn: Vec<_> = (0..1000)
            .filter_map(|k| Some(set.source(set.draw(&at, k as f32 / 1000.0)?.0)))
            .collect();
        for source in [
            Source::Lamp(0),
            Source::Lamp(1),
            Source::Lamp(2),
            Source::Surface(4),
            Source::Sun(0),
            Source::Environment,
        ] {
            assert!(drawn.contains(&source), "{source:?}");
        }
    }

    /// Rays see what the rules allow, and light that passes surfaces is for light sampling alone.
    #[test]
    fn rules_decide_what_rays_find() {
        let rules = |visibility, max_bounces| Rules::new(visibility, max_bounces, true);
        let without = |kind| Visibility::ALL.without(kind);
        let seen = |rules: Rules, kind, bounces| {
            let mut builder = LightSetBuilder::new(eye(), false);
            builder.add(ball(0.0), rules, 0);
            builder.add(sun(), rules, 1);
            let device = Device::new(Some(1), None).unwrap();
            let set = builder.build(true, &device).unwrap();
            let at = set.context(Vec3::ZERO, None);
            let mut pdfs = Vec::new();
            let toward = Vec3::new(-0.5, -0.3, 1.0).normalize();
            let ray = (Vec3::ZERO, Vec3::Z, f32::INFINITY);
            set.le_along_ray(&at, ray, (kind, bounces), |_, pdf, _| pdfs.push(pdf));
            set.environment_le(&at, toward, (kind, bounces), |_, pdf, _| pdfs.push(pdf));
            pdfs
        };
        let finite = |pdfs: Vec<f32>| pdfs.len() == 2 && pdfs.iter().all(|pdf| pdf.is_finite());
        assert!(finite(seen(Rules::NONE, RayKind::Diffuse, 7)));
        let hidden = rules(without(RayKind::Diffuse), u32::MAX);
        assert!(seen(hidden, RayKind::Diffuse, 0).is_empty());
        assert!(finite(seen(hidden, RayKind::Glossy, 0)));
        let near = rules(Visibility::ALL, 1);
        assert!(finite(seen(near, RayKind::Diffuse, 1)));
        assert!(seen(near, RayKind::Diffuse, 2).is_empty());
        let through = rules(without(RayKind::Shadow), u32::MAX);
        assert_eq!(seen(through, RayKind::Diffuse, 0), [f32::INFINITY; 2]);
        assert!(finite(seen(through, RayKind::Camera, 0)));
    }
}
