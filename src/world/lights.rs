//! All that shines, and which of it to ask.

use super::geometry::{Entry, MeshData};
use super::lamps::{self, Lamps, Rules};
use super::material::PreparedMaterial;
use crate::effects::{self, Mask, PATHS};
use crate::ffi::embree::{Device, EmbreeError};
use crate::light::environment::{Environment, Texels};
use crate::light::sun::Sun;
use crate::light::tree::{Angle, Bounds, Tree};
use crate::light::triangle::Triangle;
use crate::math::float::{self, BoundedPoint};
use crate::math::luminance;
use crate::scene::{LightKind, Pixels, RayKind, Scene};
use glam::{DVec3, Vec2, Vec3};

/// A finite emitter.
enum Emitter {
    Lamp(u32),
    Triangle { entry: u32, triangle: u32 },
}

/// All lights of a world.
pub struct Lights {
    emitters: Vec<Emitter>,
    tree: Tree,
    lamps: Lamps,
    suns: Vec<(Sun, Rules)>,
    /// Numbers of lamps and suns among the scene's lights.
    in_scene: (Vec<u32>, Vec<u32>),
    environment: Option<Environment>,
    environment_rules: Rules,
    environment_estimate: f32,
    sun_estimates: Vec<f32>,
    triangle_corners: Vec<[Vec3; 3]>,
}

/// A point that is lit, as the choice between lights sees it.
#[derive(Clone, Copy, Debug)]
pub struct Shaded {
    /// Where.
    pub point: Vec3,
    /// Side that receives; `None` where both do.
    pub normal: Option<Vec3>,
    groups: Groups,
}

/// Estimated irradiance at a point by the groups of lights.
#[derive(Clone, Copy, Debug)]
struct Groups {
    sum: f32,
    count: f32,
    tree: f32,
}

impl Shaded {
    /// Where no light is looked for.
    pub fn unlit(point: Vec3) -> Self {
        Self {
            point,
            normal: None,
            groups: Groups {
                sum: 1.0,
                count: 1.0,
                tree: 0.0,
            },
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

/// Greater estimates of irradiance count as this one, so that sums of them stay finite: infinity over infinity is no
/// probability.
const MOST: f32 = 1e30;

/// Kinds between which the first choice is made.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Group {
    Tree,
    Environment,
    Sun(usize),
}

fn mean_emission(mesh: &MeshData, material: &PreparedMaterial, triangle: u32) -> f32 {
    // Centres of the 64 subtriangles of three subdivisions: finer textures than that are found by
    // the floor below.
    const N: u32 = 8;
    let mut sum = 0f32;
    for i in 0..N {
        for j in 0..N - i {
            let (u, v) = (
                (i as f32 + 1.0 / 3.0) / N as f32,
                (j as f32 + 1.0 / 3.0) / N as f32,
            );
            let at = mesh.at(triangle, u, v);
            sum += luminance(material.emitted(&at, at.color()));
        }
    }
    let mean = sum / (N * (N + 1) / 2) as f32;
    // A hundredth of the untextured emission: no bright texel between the sampled points is
    // without a chance.
    mean + 0.01 * luminance(material.emission)
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
        };
    }
}

/// Whether a kernel chooses between groups of lights. Without it the one that there is has probability 0.8 + 0.2, which in f32
/// too is 1.
const fn has_groups(set: Mask) -> bool {
    effects::has(set, effects::SUNS | effects::ENVIRONMENT)
}

/// Radiance of a place on a triangle, as far as the triangle is there.
#[inline]
fn shining<const E: Mask>(
    mesh: &MeshData,
    material: &PreparedMaterial,
    triangle: u32,
    (u, v): (f32, f32),
) -> Vec3 {
    if !effects::has(E, effects::TEXTURES | effects::ALPHA) {
        return material.emission;
    }
    let place = mesh.at(triangle, u, v);
    let color = place.color();
    let radiance = material.emitted(&place, color);
    if effects::has(E, effects::ALPHA) && material.translucent {
        radiance * material.opacity(&place, color)
    } else {
        radiance
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
        origin: DVec3,
        entries: &mut [Entry],
        meshes: &[MeshData],
        materials: &[PreparedMaterial],
        device: &Device,
    ) -> Result<Self, EmbreeError> {
        let keep = |effect| effects::has(effects, effect);
        let mut lights = Self {
            emitters: Vec::new(),
            tree: Tree::default(),
            lamps: Lamps::default(),
            suns: Vec::new(),
            in_scene: (Vec::new(), Vec::new()),
            environment: None,
            environment_rules: Rules::NONE,
            environment_estimate: 0.0,
            sun_estimates: Vec::new(),
            triangle_corners: Vec::new(),
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
                // Keeps `triangle_corners` parallel to `emitters`.
                lights.triangle_corners.push([Vec3::ZERO; 3]);
            }
        }
        lights.lamps.commit(device)?;
        if keep(effects::MESH_LIGHTS) {
            for (index, entry) in entries.iter_mut().enumerate() {
                let mesh = &meshes[entry.mesh as usize];
                let material = &materials[mesh.material as usize];
                if luminance(material.emission) <= 0.0 {
                    continue;
                }
                entry.first_emitter = lights.emitters.len() as u32;
                for triangle in 0..mesh.triangles.triangles().len() as u32 {
                    let corners = entry.world_corners(mesh, triangle);
                    let shape = Triangle { corners };
                    let [a, b, c] = corners;
                    bounds.push(Bounds {
                        min: a.min(b).min(c),
                        max: a.max(b).max(c),
                        intensity: shape.area() * mean_emission(mesh, material, triangle),
                        axis: shape.normal(),
                        normals: Angle::ZERO,
                        cos_emission: 0.0,
                        two_sided: true,
                    });
                    lights.emitters.push(Emitter::Triangle {
                        entry: index as u32,
                        triangle,
                    });
                    lights.triangle_corners.push(corners);
                }
            }
        }
        if !keep(effects::LIGHT_TREE) {
            by_power(&mut bounds);
        }
        lights.tree = Tree::new(&bounds);
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
        self.tree.is_empty() && self.suns.is_empty() && self.environment.is_none()
    }

    /// A point that is to be lit.
    #[inline]
    pub fn shaded<const E: Mask>(&self, point: Vec3, normal: Option<Vec3>) -> Shaded {
        let groups = if !has_groups(E) || self.suns.is_empty() && self.environment.is_none() {
            Groups {
                sum: 1.0,
                count: 1.0,
                tree: 1.0,
            }
        } else {
            let tree = self.tree.importance(point, normal).min(MOST);
            let mut sum = tree + self.environment_estimate;
            let mut count = f32::from(tree > 0.0) + f32::from(self.environment_estimate > 0.0);
            for &s in &self.sun_estimates {
                sum += s;
                count += 1.0;
            }
            Groups { sum, count, tree }
        };
        Shaded {
            point,
            normal,
            groups,
        }
    }

    /// Probability of a group, by the estimated irradiance, a part of it evenly so that no
    /// estimate can starve a group.
    #[inline]
    fn group_probability<const E: Mask>(&self, group: Group, at: &Shaded) -> f32 {
        if !has_groups(E) {
            return 1.0;
        }
        let Groups { sum, count, tree } = at.groups;
        let estimate = match group {
            Group::Tree => tree,
            Group::Environment => self.environment_estimate,
            Group::Sun(i) => self.sun_estimates[i],
        };
        if estimate <= 0.0 {
            return 0.0;
        }
        0.8 * estimate / sum + 0.2 / count
    }

    #[inline]
    fn choose_group<const E: Mask>(&self, at: &Shaded, u: f32) -> Option<(Group, f32, f32)> {
        if !has_groups(E) {
            return Some((Group::Tree, 1.0, u));
        }
        let mut u = u;
        let mut last = None;
        let groups = std::iter::once(Group::Tree)
            .filter(|_| !self.tree.is_empty())
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
    pub fn sample<const E: Mask>(
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
            Group::Tree => {
                let choice = self.tree.sample(at.point, at.normal, u_light)?;
                let p = p * choice.probability;
                match self.emitters[choice.emitter as usize] {
                    Emitter::Lamp(_) if !effects::has(E, effects::LAMPS) => None,
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
                    Emitter::Triangle { entry, triangle } => {
                        let shape = Triangle {
                            corners: self.triangle_corners[choice.emitter as usize],
                        };
                        let s = shape.sample(at.point, u)?;
                        let entry = &world.entries[entry as usize];
                        let mesh = &world.meshes[entry.mesh as usize];
                        let material = &world.materials[mesh.material as usize];
                        if world.cull_backfaces
                            && material.single_sided
                            && entry.geometric_normal::<E>(mesh, triangle).dot(s.wi) > 0.0
                        {
                            return None;
                        }
                        let radiance = shining::<E>(mesh, material, triangle, (s.u, s.v));
                        let pdf = s.pdf * p;
                        let point = entry.point::<E>(mesh, triangle, s.u, s.v);
                        let normal = shape.normal();
                        let facing = if s.wi.dot(normal) > 0.0 {
                            -normal
                        } else {
                            normal
                        };
                        let target = float::ray_origin(point, facing);
                        Some(LightSample {
                            wi: s.wi,
                            contribution: radiance / pdf,
                            pdf,
                            delta: false,
                            target: Some(target),
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
        let (group, _, u_light) = self.choose_group::<PATHS>(at, u_light)?;
        Some(match group {
            Group::Environment => Source::Environment,
            Group::Sun(i) => Source::Sun(i as u32),
            Group::Tree => {
                let emitter = self.tree.sample(at.point, at.normal, u_light)?.emitter;
                match self.emitters[emitter as usize] {
                    Emitter::Lamp(_) => Source::Lamp(emitter),
                    Emitter::Triangle { entry, .. } => Source::Surface(entry),
                }
            }
        })
    }

    /// Number of a lamp or sun among the scene's lights; `None` for what is none.
    pub fn number_in_scene(&self, source: Source) -> Option<u32> {
        match source {
            Source::Lamp(emitter) => match self.emitters.get(emitter as usize)? {
                Emitter::Lamp(index) => self.in_scene.0.get(*index as usize).copied(),
                Emitter::Triangle { .. } => None,
            },
            Source::Sun(index) => self.in_scene.1.get(index as usize).copied(),
            Source::Surface(_) | Source::Environment => None,
        }
    }

    /// Density with which [`Self::sample`] finds a point of an emissive triangle.
    #[inline]
    pub fn triangle_pdf<const E: Mask>(&self, at: &Shaded, emitter: u32, on: &BoundedPoint) -> f32 {
        let p = self.group_probability::<E>(Group::Tree, at);
        if p <= 0.0 {
            return 0.0;
        }
        let choice = self.tree.probability(emitter, at.point, at.normal);
        if choice <= 0.0 {
            return 0.0;
        }
        let shape = Triangle {
            corners: self.triangle_corners[emitter as usize],
        };
        p * choice * shape.pdf(at.point, on.point)
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
    pub fn lamps_along<const E: Mask>(
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
                if kind == RayKind::Camera || effects::has(E, effects::VISIBILITY) {
                    if !rules.allow(kind, bounces) {
                        return;
                    }
                    if kind != RayKind::Camera && !rules.visibility.sees(RayKind::Shadow) {
                        visit(meeting.radiance, f32::INFINITY, Source::Lamp(emitter));
                        return;
                    }
                }
                let p = self.group_probability::<E>(Group::Tree, at)
                    * self.tree.probability(emitter, at.point, at.normal);
                visit(meeting.radiance, p * meeting.pdf, Source::Lamp(emitter));
            });
    }

    /// Radiance from infinity with the density of light sampling, for each light there; as in
    /// [`Self::lamps_along`].
    #[inline]
    pub fn from_infinity<const E: Mask>(
        &self,
        at: &Shaded,
        wi: Vec3,
        (kind, bounces): (RayKind, u32),
        mut visit: impl FnMut(Vec3, f32, Source),
    ) {
        let seen = |rules: &Rules| {
            !(kind == RayKind::Camera || effects::has(E, effects::VISIBILITY))
                || rules.allow(kind, bounces)
        };
        if let Some(environment) = &self.environment
            && seen(&self.environment_rules)
        {
            let pdf = if kind == RayKind::Camera {
                0.0
            } else {
                self.group_probability::<E>(Group::Environment, at) * environment.pdf(wi)
            };
            visit(environment.emitted(wi), pdf, Source::Environment);
        }
        for (i, (sun, rules)) in self.suns.iter().enumerate() {
            if sun.contains(wi) && seen(rules) {
                let pdf = if effects::has(E, effects::VISIBILITY)
                    && !rules.visibility.sees(RayKind::Shadow)
                {
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
