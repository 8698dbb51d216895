//! All that shines, and which of it to ask.

use super::geometry::{Entry, MeshData};
use super::lamps::{self, Lamps, Rules};
use super::material::PreparedMaterial;
use super::shining::{Eye, Facet, Places, Shining};
use crate::effects::{self, Features, General, Mask};
use crate::ffi::embree::{Device, EmbreeError};
use crate::light::choice::{Chooser, Shares};
use crate::light::environment::{Environment, Texels};
use crate::light::estimate::{Angle, Bounds, MOST};
use crate::light::sun::Sun;
use crate::math::float::{self, BoundedPoint};
use crate::math::luminance;
use crate::scene::{LightKind, Pixels, RayKind, Scene};
use glam::{DVec3, Vec2, Vec3};

/// A finite emitter.
enum Emitter {
    Lamp(u32),
    Facet(Facet),
}

/// All lights of a world.
pub struct Lights {
    emitters: Vec<Emitter>,
    finite: Chooser,
    lamps: Lamps,
    suns: Vec<(Sun, Rules)>,
    /// Numbers of lamps and suns among the scene's lights.
    in_scene: (Vec<u32>, Vec<u32>),
    environment: Option<Environment>,
    environment_rules: Rules,
    environment_estimate: f32,
    sun_estimates: Vec<f32>,
    shining: Shining,
}

/// A point that is lit, as the choice between lights sees it.
#[derive(Clone, Copy, Debug)]
pub struct Shaded {
    /// Where.
    pub point: Vec3,
    /// Side that receives; `None` where both do.
    pub normal: Option<Vec3>,
    groups: Groups,
    shares: Shares,
}

/// Estimated irradiance at a point by the groups of lights.
#[derive(Clone, Copy, Debug)]
struct Groups {
    sum: f32,
    count: f32,
    finite: f32,
}

impl Shaded {
    /// Where, and which side.
    #[inline]
    fn place(&self) -> (Vec3, Option<Vec3>) {
        (self.point, self.normal)
    }

    /// Where no light is looked for.
    pub fn unlit(point: Vec3) -> Self {
        Self {
            point,
            normal: None,
            groups: Groups {
                sum: 1.0,
                count: 1.0,
                finite: 0.0,
            },
            shares: Shares::NONE,
        }
    }
}

/// Light from one place.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Towards the light, unit length.
    pub wi: Vec3,
    /// Radiance over density, MIS left to the caller.
    pub contribution: Vec3,
    /// Density per solid angle with which all of light sampling finds this direction of this light; 0 if `delta`.
    pub pdf: f32,
    /// No BSDF sample can find it.
    pub delta: bool,
    /// Where on the light; `None` at infinity. Already moved off the light's surface.
    pub target: Option<Vec3>,
    /// Who sees the light.
    pub rules: Rules,
}

/// Kinds between which the first choice is made.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Group {
    Finite,
    Environment,
    Sun(usize),
}

/// Makes all emitters of a tree look as if they stood in the same place and shone everywhere, so that they are drawn by their
/// power alone. One is left as it is: the estimate for all of them is weighed against the sky's.
fn by_power(bounds: &mut [Bounds]) {
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
        *b = Bounds {
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

/// Something that shines, for those who look at a single path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The surface of an object, by its number among those with triangles.
    Surface(u32),
    /// A lamp, by its number among all emitters.
    Lamp(u32),
    /// A sun's disc, by its number among the suns.
    Sun(u32),
    /// The environment.
    Environment,
}

impl Lights {
    pub(super) fn new(
        scene: &Scene,
        effects: Mask,
        (origin, eye, cull_backfaces): (DVec3, &Eye, bool),
        entries: &mut [Entry],
        meshes: &[MeshData],
        materials: &[PreparedMaterial],
        device: &Device,
    ) -> Result<Self, EmbreeError> {
        let keep = |effect| effects::has(effects, effect);
        let mut lights = Self {
            emitters: Vec::new(),
            finite: Chooser::default(),
            lamps: Lamps::default(),
            suns: Vec::new(),
            in_scene: (Vec::new(), Vec::new()),
            environment: None,
            environment_rules: Rules::NONE,
            environment_estimate: 0.0,
            sun_estimates: Vec::new(),
            shining: Shining::default(),
        };
        let mut bounds = Vec::new();
        for (number, light) in scene.lights.iter().enumerate() {
            if !effects::keeps(effects, light) {
                continue;
            }
            let rules = Rules::of(light, effects);
            if let LightKind::Sun { irradiance, angle } = light.kind {
                let e = Vec3::from(light.color) * irradiance;
                if luminance(e) > 0.0 {
                    let toward = -lamps::direction(&light.world_from_light);
                    lights.suns.push((Sun::new(toward, e, angle), rules));
                    lights.sun_estimates.push(luminance(e).min(MOST));
                    lights.in_scene.1.push(number as u32);
                }
            } else if let index = lights.lamps.len() as u32
                && let emitter = lights.emitters.len() as u32
                && let Some(b) = lights.lamps.add(light, rules, origin, emitter)
            {
                bounds.push(b);
                lights.emitters.push(Emitter::Lamp(index));
                lights.in_scene.0.push(number as u32);
            }
        }
        lights.lamps.commit(device)?;
        if keep(effects::MESH_LIGHTS) {
            let mut places = (!cull_backfaces).then(Places::default);
            for (index, entry) in entries.iter_mut().enumerate() {
                let mesh = &meshes[entry.mesh as usize];
                let material = &materials[mesh.material as usize];
                if luminance(material.emission) <= 0.0 {
                    continue;
                }
                let Self {
                    emitters, shining, ..
                } = &mut lights;
                let first = shining.add(
                    (index as u32, &*entry),
                    (mesh, material),
                    eye,
                    places.as_mut(),
                    |facet, facet_bounds| {
                        emitters.push(Emitter::Facet(facet));
                        bounds.push(facet_bounds);
                        emitters.len() as u32 - 1
                    },
                );
                entry.first_shining = first;
            }
        }
        if !keep(effects::LIGHT_TREE) {
            by_power(&mut bounds);
        }
        lights.finite = Chooser::new(bounds);
        if let Some(environment) = &scene.environment
            && effects::keeps_environment(effects, environment)
        {
            let radiance = Vec3::from(environment.radiance);
            if luminance(radiance) > 0.0 {
                let image = environment
                    .image
                    .and_then(|i| scene.images.get(i.0 as usize));
                let prepared = match image {
                    Some(image) => Environment::image(
                        image.width as usize,
                        image.height as usize,
                        texels(image),
                        radiance,
                        &environment.rotation,
                    ),
                    None => Environment::constant(radiance),
                };
                lights.environment_estimate =
                    (std::f32::consts::PI * luminance(prepared.mean())).min(MOST);
                lights.environment = Some(prepared);
                // Shadows are no choice of the world's.
                let seen = environment.visibility.with(RayKind::Shadow);
                lights.environment_rules = Rules::new(seen, u32::MAX, effects);
            }
        }
        Ok(lights)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.finite.is_empty() && self.suns.is_empty() && self.environment.is_none()
    }

    /// A point that is to be lit.
    #[inline]
    pub fn shaded<E: Features>(&self, point: Vec3, normal: Option<Vec3>) -> Shaded {
        let compared = E::LIGHTS && !(self.suns.is_empty() && self.environment.is_none());
        let shares = self.finite.shares(point, normal, compared);
        let groups = if compared {
            let finite = shares.sum.min(MOST);
            let mut sum = finite + self.environment_estimate;
            let mut count = f32::from(finite > 0.0) + f32::from(self.environment_estimate > 0.0);
            for &s in &self.sun_estimates {
                sum += s;
                count += 1.0;
            }
            Groups { sum, count, finite }
        } else {
            Groups {
                sum: 1.0,
                count: 1.0,
                finite: 1.0,
            }
        };
        Shaded {
            point,
            normal,
            groups,
            shares,
        }
    }

    /// Probability of a group, by the estimated irradiance, a part of it evenly so that no
    /// estimate can starve a group.
    #[inline]
    fn group_probability<E: Features>(&self, group: Group, at: &Shaded) -> f32 {
        // Without groups, the one that there is has probability 0.8 + 0.2, which in f32 too is 1.
        if !E::LIGHTS {
            return 1.0;
        }
        let Groups { sum, count, finite } = at.groups;
        let estimate = match group {
            Group::Finite => finite,
            Group::Environment => self.environment_estimate,
            Group::Sun(i) => self.sun_estimates[i],
        };
        if estimate <= 0.0 {
            return 0.0;
        }
        0.8 * estimate / sum + 0.2 / count
    }

    #[inline]
    fn choose_group<E: Features>(&self, at: &Shaded, u: f32) -> Option<(Group, f32, f32)> {
        if !E::LIGHTS {
            return Some((Group::Finite, 1.0, u));
        }
        let mut u = u;
        let mut last = None;
        let groups = std::iter::once(Group::Finite)
            .filter(|_| !self.finite.is_empty())
            .chain(self.environment.iter().map(|_| Group::Environment))
            .chain((0..self.suns.len()).map(Group::Sun));
        for group in groups {
            let p = self.group_probability::<E>(group, at);
            if p > 0.0 {
                if u < p {
                    return Some((group, p, (u / p).min(float::ONE_MINUS_EPSILON)));
                }
                u -= p;
                last = Some((group, p));
            }
        }
        // Rounding left a crumb of u.
        last.map(|(group, p)| (group, p, float::ONE_MINUS_EPSILON))
    }

    /// Draws a light and a direction to it.
    #[inline]
    pub fn sample<E: Features>(
        &self,
        world: &super::World,
        at: &Shaded,
        u_light: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let (group, p, u_light) = self.choose_group::<E>(at, u_light)?;
        match group {
            Group::Environment => {
                let environment = self.environment.as_ref()?;
                let d = environment.sample(u);
                let pdf = d.pdf * p;
                (pdf > 0.0).then(|| LightSample {
                    wi: d.wi,
                    contribution: environment.emitted(d.wi) / pdf,
                    pdf,
                    delta: false,
                    target: None,
                    rules: self.environment_rules,
                })
            }
            Group::Sun(i) => {
                let (sun, rules) = &self.suns[i];
                let d = sun.sample(u);
                Some(LightSample {
                    wi: d.wi,
                    contribution: sun.arriving() / p,
                    pdf: d.pdf * p,
                    delta: sun.is_delta(),
                    target: None,
                    rules: *rules,
                })
            }
            Group::Finite => {
                let choice = self.finite.sample(&at.shares, at.place(), u_light)?;
                let p = p * choice.probability;
                match self.emitters[choice.emitter as usize] {
                    Emitter::Lamp(_) if !E::LIGHTS => None,
                    Emitter::Lamp(index) => {
                        let (s, rules) = self.lamps.sample(index, at, u)?;
                        let pdf = s.direction.pdf * p;
                        Some(LightSample {
                            wi: s.direction.wi,
                            contribution: s.arriving / p,
                            pdf,
                            delta: s.delta,
                            target: Some(at.point + s.direction.wi * s.distance),
                            rules,
                        })
                    }
                    Emitter::Facet(ref facet) => {
                        let s = self.shining.sample::<E>(world, facet, at.point, u)?;
                        let entry = &world.entries[facet.entry as usize];
                        let pdf = s.pdf * p;
                        Some(LightSample {
                            wi: s.wi,
                            contribution: s.radiance / pdf,
                            pdf,
                            delta: false,
                            target: Some(s.target),
                            rules: Rules {
                                // A surface cannot shine through others.
                                visibility: entry.visibility.with(RayKind::Shadow),
                                ..Rules::NONE
                            },
                        })
                    }
                }
            }
        }
    }

    /// What [`Self::sample`] draws with a number.
    #[cold]
    pub fn drawn(&self, at: &Shaded, u_light: f32) -> Option<Source> {
        let (group, _, u_light) = self.choose_group::<General>(at, u_light)?;
        Some(match group {
            Group::Environment => Source::Environment,
            Group::Sun(i) => Source::Sun(i as u32),
            Group::Finite => {
                let emitter = self.finite.sample(&at.shares, at.place(), u_light)?.emitter;
                match self.emitters[emitter as usize] {
                    Emitter::Lamp(_) => Source::Lamp(emitter),
                    Emitter::Facet(ref facet) => Source::Surface(facet.entry),
                }
            }
        })
    }

    /// Number of a lamp or sun among the scene's lights; `None` for what is none.
    pub fn number_in_scene(&self, source: Source) -> Option<u32> {
        match source {
            Source::Lamp(emitter) => match self.emitters.get(emitter as usize)? {
                Emitter::Lamp(index) => self.in_scene.0.get(*index as usize).copied(),
                Emitter::Facet(_) => None,
            },
            Source::Sun(index) => self.in_scene.1.get(index as usize).copied(),
            Source::Surface(_) | Source::Environment => None,
        }
    }

    /// Density with which [`Self::sample`] finds a point of an emissive triangle, by its number among those that shine.
    #[inline]
    pub fn triangle_pdf<E: Features>(&self, at: &Shaded, triangle: u32, on: &BoundedPoint) -> f32 {
        let p = self.group_probability::<E>(Group::Finite, at);
        if p <= 0.0 {
            return 0.0;
        }
        let emitter = self.shining.emitter(triangle);
        let choice = self.finite.probability(&at.shares, at.place(), emitter);
        if choice <= 0.0 {
            return 0.0;
        }
        match &self.emitters[emitter as usize] {
            Emitter::Facet(facet) => p * choice * self.shining.pdf(facet, at.point, on),
            Emitter::Lamp(_) => 0.0,
        }
    }

    /// Whether the camera sees lamps.
    #[inline]
    pub fn camera_sees_lamps(&self) -> bool {
        self.lamps.seen_by_camera()
    }

    /// Visits the lamps that a ray meets before `far`, in their order: radiance, and the density
    /// with which light sampling from `at` finds the direction (infinite where nothing else may find it). The
    /// ray is of a kind and left after so many bounces.
    #[inline]
    pub fn lamps_along<E: Features>(
        &self,
        at: &Shaded,
        (origin, wi, far): (Vec3, Vec3, f32),
        (kind, bounces): (RayKind, u32),
        mut visit: impl FnMut(Vec3, f32, Source),
    ) {
        if !self.lamps.can_be_hit() {
            return;
        }
        self.lamps
            .along(at, origin, wi, far, |emitter, rules, meeting| {
                if kind == RayKind::Camera || E::EVERYTHING {
                    if !rules.allow(kind, bounces) {
                        return;
                    }
                    if kind != RayKind::Camera && !rules.visibility.sees(RayKind::Shadow) {
                        visit(meeting.radiance, f32::INFINITY, Source::Lamp(emitter));
                        return;
                    }
                }
                let p = self.group_probability::<E>(Group::Finite, at)
                    * self.finite.probability(&at.shares, at.place(), emitter);
                visit(meeting.radiance, p * meeting.pdf, Source::Lamp(emitter));
            });
    }

    /// Radiance from infinity with the density of light sampling, for each light there; as in
    /// [`Self::lamps_along`].
    #[inline]
    pub fn from_infinity<E: Features>(
        &self,
        at: &Shaded,
        wi: Vec3,
        (kind, bounces): (RayKind, u32),
        mut visit: impl FnMut(Vec3, f32, Source),
    ) {
        let seen = |rules: &Rules| {
            !(kind == RayKind::Camera || E::EVERYTHING) || rules.allow(kind, bounces)
        };
        if let Some(environment) = &self.environment
            && seen(&self.environment_rules)
        {
            let (radiance, pdf) = if kind == RayKind::Camera {
                (environment.emitted(wi), 0.0)
            } else {
                let (radiance, pdf) = environment.emitted_and_pdf(wi);
                let chosen = self.group_probability::<E>(Group::Environment, at);
                (radiance, chosen * pdf)
            };
            visit(radiance, pdf, Source::Environment);
        }
        for (i, (sun, rules)) in self.suns.iter().enumerate() {
            if sun.contains(wi) && seen(rules) {
                let pdf = if E::EVERYTHING && !rules.visibility.sees(RayKind::Shadow) {
                    f32::INFINITY
                } else {
                    self.group_probability::<E>(Group::Sun(i), at) * sun.pdf()
                };
                visit(sun.radiance(), pdf, Source::Sun(i as u32));
            }
        }
    }
}

fn texels(image: &crate::scene::Image) -> Texels {
    let n = image.channels.max(1) as usize;
    if let (3, Pixels::F32(channels)) = (n, &image.pixels) {
        return channels.clone().into();
    }
    let count = image.width as usize * image.height as usize;
    let value = |i: usize| match &image.pixels {
        Pixels::U8(p) => f32::from(p[i]) / 255.0,
        Pixels::U16(p) => f32::from(p[i]) / 65535.0,
        Pixels::F32(p) => p[i],
    };
    (0..count)
        .map(|i| {
            let at = i * n;
            if n < 3 {
                Vec3::splat(value(at))
            } else {
                Vec3::new(value(at), value(at + 1), value(at + 2))
            }
        })
        .collect::<Vec<Vec3>>()
        .into()
}
