//! All that shines, and which of it to ask.

use super::geometry::{Entry, MeshData};
use super::material::PreparedMaterial;
use crate::effects::{self, Mask};
use crate::ffi::embree::{self, CommittedScene, Device, EmbreeError, Ray};
use crate::light::environment::Environment;
use crate::light::lamp::{Cone, Lamp};
use crate::light::sun::Sun;
use crate::light::tree::{Bounds, Tree};
use crate::light::triangle::Triangle;
use crate::math::float::{self, BoundedPoint};
use crate::math::luminance;
use crate::scene::{LightKind, Pixels, Scene};
use glam::{DAffine3, DVec3, Mat3, Vec2, Vec3};

/// A finite emitter.
enum Emitter {
    Lamp(u32),
    Triangle { entry: u32, triangle: u32 },
}

/// Lamps up to this number are tried one by one by rays; more go into a hierarchy of their own.
const LAMPS_IN_A_ROW: usize = 4;

/// All lights of a world.
pub struct Lights {
    emitters: Vec<Emitter>,
    tree: Tree,
    lamps: Vec<Lamp>,
    /// Emitter number of each lamp.
    lamp_emitters: Vec<u32>,
    /// Lamps with a radius, for rays that may hit them.
    sized_lamps: Vec<u32>,
    lamp_scene: Option<CommittedScene>,
    suns: Vec<Sun>,
    environment: Option<Environment>,
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
}

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
            lamps: Vec::new(),
            lamp_emitters: Vec::new(),
            sized_lamps: Vec::new(),
            lamp_scene: None,
            suns: Vec::new(),
            environment: None,
            environment_estimate: 0.0,
            sun_estimates: Vec::new(),
            triangle_corners: Vec::new(),
        };
        let mut bounds = Vec::new();
        for light in &scene.lights {
            let color = Vec3::from(light.color);
            let axis = direction(&light.world_from_light);
            match light.kind {
                LightKind::Sun { irradiance, angle } if keep(effects::SUNS) => {
                    let e = color * irradiance;
                    if luminance(e) > 0.0 {
                        lights.suns.push(Sun::new(-axis, e, angle));
                        lights.sun_estimates.push(luminance(e));
                    }
                }
                LightKind::Point {
                    intensity, radius, ..
                } if keep(effects::LAMPS) => {
                    let center = (light.world_from_light.translation - origin).as_vec3();
                    lights.add_lamp(
                        Lamp {
                            center,
                            radius,
                            intensity: color * intensity,
                            cone: None,
                        },
                        &mut bounds,
                    );
                }
                LightKind::Spot {
                    intensity,
                    radius,
                    half_angle,
                    blend,
                    ..
                } if keep(effects::LAMPS) => {
                    let center = (light.world_from_light.translation - origin).as_vec3();
                    let inverse = light.world_from_light.matrix3.inverse();
                    let cos_half_angle = half_angle.cos();
                    let width = (1.0 - cos_half_angle) * blend;
                    let cone = Cone {
                        light_from_world: if inverse.is_finite() {
                            inverse.as_mat3()
                        } else {
                            Mat3::IDENTITY
                        },
                        axis,
                        cos_half_angle,
                        steepness: if width > 0.0 {
                            1.0 / width
                        } else {
                            f32::INFINITY
                        },
                    };
                    lights.add_lamp(
                        Lamp {
                            center,
                            radius,
                            intensity: color * intensity,
                            cone: Some(cone),
                        },
                        &mut bounds,
                    );
                }
                _ => {}
            }
        }
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
                        cos_normals: 1.0,
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
        lights.tree = Tree::new(&bounds);
        if lights.sized_lamps.len() > LAMPS_IN_A_ROW {
            let spheres: Vec<[f32; 4]> = lights
                .sized_lamps
                .iter()
                .map(|&i| {
                    let l = &lights.lamps[i as usize];
                    // A little larger: the exact test follows; 2^-20 covers the roundings of Embree's.
                    [
                        l.center.x,
                        l.center.y,
                        l.center.z,
                        l.radius * (1.0 + 16.0 * f32::EPSILON),
                    ]
                })
                .collect();
            let mut scene = embree::Scene::new(device)?;
            scene.add_spheres(&spheres)?;
            lights.lamp_scene = Some(scene.commit()?);
        }
        if keep(effects::ENVIRONMENT)
            && let Some(environment) = &scene.environment
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
                lights.environment_estimate = std::f32::consts::PI * luminance(prepared.mean());
                lights.environment = Some(prepared);
            }
        }
        Ok(lights)
    }

    fn add_lamp(&mut self, lamp: Lamp, bounds: &mut Vec<Bounds>) {
        if luminance(lamp.intensity) <= 0.0 {
            return;
        }
        bounds.push(Bounds {
            min: lamp.center - lamp.radius,
            max: lamp.center + lamp.radius,
            intensity: luminance(lamp.intensity),
            axis: lamp.cone.as_ref().map_or(Vec3::Z, |c| c.axis),
            // A spot with a scaled transform is an ellipse: only round ones are bounded by their cone.
            cos_normals: lamp
                .cone
                .as_ref()
                .filter(|c| is_rigid(&c.light_from_world))
                .map_or(-1.0, |c| c.cos_half_angle),
            cos_emission: 1.0,
            two_sided: false,
        });
        let index = self.lamps.len() as u32;
        if lamp.radius > 0.0 {
            self.sized_lamps.push(index);
        }
        self.lamp_emitters.push(self.emitters.len() as u32);
        self.emitters.push(Emitter::Lamp(index));
        // Keeps `triangle_corners` parallel to `emitters`.
        self.triangle_corners.push([Vec3::ZERO; 3]);
        self.lamps.push(lamp);
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.tree.is_empty() && self.suns.is_empty() && self.environment.is_none()
    }

    /// Probability of a group, by the estimated irradiance, a part of it evenly so that no
    /// estimate can starve a group.
    #[inline]
    fn group_probability(&self, group: Group, at: &Shaded) -> f32 {
        let (sum, count, tree) = self.group_sum(at);
        let share = |estimate: f32| {
            if estimate <= 0.0 {
                return 0.0;
            }
            0.8 * estimate / sum + 0.2 / count
        };
        match group {
            Group::Tree => share(tree),
            Group::Environment => share(self.environment_estimate),
            Group::Sun(i) => share(self.sun_estimates[i]),
        }
    }

    #[inline]
    fn group_sum(&self, at: &Shaded) -> (f32, f32, f32) {
        if self.suns.is_empty() && self.environment.is_none() {
            return (1.0, 1.0, 1.0);
        }
        let tree = self.tree.importance(at.point, at.normal);
        let mut sum = tree + self.environment_estimate;
        let mut count = f32::from(tree > 0.0) + f32::from(self.environment_estimate > 0.0);
        for &s in &self.sun_estimates {
            sum += s;
            count += 1.0;
        }
        (sum, count, tree)
    }

    #[inline]
    fn choose_group(&self, at: &Shaded, u: f32) -> Option<(Group, f32, f32)> {
        let mut u = u;
        let mut last = None;
        let groups = std::iter::once(Group::Tree)
            .filter(|_| !self.tree.is_empty())
            .chain(self.environment.iter().map(|_| Group::Environment))
            .chain((0..self.suns.len()).map(Group::Sun));
        for group in groups {
            let p = self.group_probability(group, at);
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
    pub fn sample(
        &self,
        world: &super::World,
        at: &Shaded,
        u_light: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let (group, p, u_light) = self.choose_group(at, u_light)?;
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
                })
            }
            Group::Sun(i) => {
                let sun = &self.suns[i];
                let d = sun.sample(u);
                Some(if sun.is_delta() {
                    LightSample {
                        wi: d.wi,
                        contribution: sun.irradiance / p,
                        pdf: 0.0,
                        delta: true,
                        target: None,
                    }
                } else {
                    let pdf = d.pdf * p;
                    LightSample {
                        wi: d.wi,
                        contribution: sun.radiance() / pdf,
                        pdf,
                        delta: false,
                        target: None,
                    }
                })
            }
            Group::Tree => {
                let choice = self.tree.sample(at.point, at.normal, u_light)?;
                let p = p * choice.probability;
                match self.emitters[choice.emitter as usize] {
                    Emitter::Lamp(index) => {
                        let s = self.lamps[index as usize].sample(at.point, u)?;
                        let target = at.point + s.direction.wi * s.distance;
                        Some(if s.delta {
                            LightSample {
                                wi: s.direction.wi,
                                contribution: s.radiance / p,
                                pdf: 0.0,
                                delta: true,
                                target: Some(target),
                            }
                        } else {
                            let pdf = s.direction.pdf * p;
                            LightSample {
                                wi: s.direction.wi,
                                contribution: s.radiance / pdf,
                                pdf,
                                delta: false,
                                target: Some(target),
                            }
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
                            && entry.geometric_normal(mesh, triangle).dot(s.wi) > 0.0
                        {
                            return None;
                        }
                        let place = mesh.at(triangle, s.u, s.v);
                        let color = place.color();
                        let mut radiance = material.emitted(&place, color);
                        if material.translucent {
                            radiance *= material.opacity(&place, color);
                        }
                        let pdf = s.pdf * p;
                        let point = entry.point(mesh, triangle, s.u, s.v);
                        let target = float::ray_origin(point, shape.normal(), -s.wi);
                        Some(LightSample {
                            wi: s.wi,
                            contribution: radiance / pdf,
                            pdf,
                            delta: false,
                            target: Some(target),
                        })
                    }
                }
            }
        }
    }

    /// Density with which [`Self::sample`] finds a point of an emissive triangle.
    #[inline]
    pub fn triangle_pdf(&self, at: &Shaded, emitter: u32, on: &BoundedPoint) -> f32 {
        let p = self.group_probability(Group::Tree, at);
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

    /// Visits the lamps that a ray meets before `far`, in their order: radiance, and the density
    /// with which light sampling from `at` finds the direction.
    #[inline]
    pub fn lamps_along(
        &self,
        at: &Shaded,
        origin: Vec3,
        wi: Vec3,
        far: f32,
        mut visit: impl FnMut(Vec3, f32),
    ) {
        if self.sized_lamps.is_empty() {
            return;
        }
        let mut meet = |index: u32| {
            let lamp = &self.lamps[index as usize];
            // From inside a lamp neither technique sees it: as with Cycles' spheres, whose far side
            // does not shine inwards.
            if lamp.hit(origin, wi).is_some_and(|t| t < far)
                && (at.point - lamp.center).length() > lamp.radius
            {
                let p = self.group_probability(Group::Tree, at)
                    * self.tree.probability(
                        self.lamp_emitters[index as usize],
                        at.point,
                        at.normal,
                    );
                visit(lamp.emitted(wi), p * lamp.pdf(at.point));
            }
        };
        match &self.lamp_scene {
            None => self.sized_lamps.iter().for_each(|&i| meet(i)),
            Some(scene) => {
                let ray = Ray {
                    origin: origin.to_array(),
                    direction: wi.to_array(),
                    near: 0.0,
                    far,
                };
                let mut met = Vec::new();
                scene.intersect_filtered(&ray, |hit| {
                    met.push(self.sized_lamps[hit.primitive as usize]);
                    false
                });
                // Embree asks in any order, perhaps twice (both sides of a sphere).
                met.sort_unstable();
                met.dedup();
                met.into_iter().for_each(meet);
            }
        }
    }

    /// Radiance from infinity with the density of light sampling, for each light there.
    #[inline]
    pub fn from_infinity(&self, at: &Shaded, wi: Vec3, mut visit: impl FnMut(Vec3, f32)) {
        if let Some(environment) = &self.environment {
            let p = self.group_probability(Group::Environment, at);
            visit(environment.emitted(wi), p * environment.pdf(wi));
        }
        for (i, sun) in self.suns.iter().enumerate() {
            if sun.contains(wi) {
                visit(
                    sun.radiance(),
                    self.group_probability(Group::Sun(i), at) * sun.pdf(),
                );
            }
        }
    }

    /// Radiance that a camera ray sees at infinity: suns are not seen, as in Cycles.
    #[inline]
    pub fn background(&self, wi: Vec3) -> Vec3 {
        self.environment
            .as_ref()
            .map_or(Vec3::ZERO, |e| e.emitted(wi))
    }
}

fn direction(t: &DAffine3) -> Vec3 {
    (-t.matrix3.z_axis)
        .try_normalize()
        .unwrap_or(DVec3::NEG_Y)
        .as_vec3()
}

fn is_rigid(m: &Mat3) -> bool {
    let (x, y, z) = (m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    let same = |a: f32, b: f32| (a - b).abs() <= 1e-5 * a.max(b);
    same(x, y)
        && same(y, z)
        && m.x_axis.dot(m.y_axis).abs() <= 1e-5 * x * y
        && m.y_axis.dot(m.z_axis).abs() <= 1e-5 * y * z
}

fn texels(image: &crate::scene::Image) -> Vec<Vec3> {
    let n = image.channels.max(1) as usize;
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
        .collect()
}
