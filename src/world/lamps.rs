//! Points, spots and area lights: which there are, and which of them a ray meets.

use crate::effects::{self, Mask};
use crate::ffi::embree::{self, CommittedScene, Device, EmbreeError, Ray, TriangleMesh};
use crate::light::Meeting;
use crate::light::area::Area;
use crate::light::estimate::{Angle, Bounds, Front};
use crate::light::lamp::{Cone, Lamp, LampSample};
use crate::math::luminance;
use crate::scene::{AreaShape, Light, LightKind, RayKind, Visibility};
use glam::{DAffine3, DVec3, Mat3, Vec2, Vec3};
use std::sync::Arc;

/// Who sees a light.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Kinds of rays; without [`RayKind::Shadow`] it shines through everything.
    pub visibility: Visibility,
    /// Paths with more bounces do not see it.
    pub max_bounces: u32,
}

impl Rules {
    /// Seen by all.
    pub const NONE: Self = Self {
        visibility: Visibility::ALL,
        max_bounces: u32::MAX,
    };

    /// Of a light of the scene. Without the effect only the camera is told apart.
    pub fn of(light: &Light, effects: Mask) -> Self {
        Self::new(light.visibility, light.max_bounces, effects)
    }

    /// As [`Self::of`].
    pub fn new(visibility: Visibility, max_bounces: u32, effects: Mask) -> Self {
        if effects::has(effects, effects::VISIBILITY) {
            Self {
                visibility,
                max_bounces,
            }
        } else if visibility.sees(RayKind::Camera) {
            Self::NONE
        } else {
            Self {
                visibility: Visibility::ALL.without(RayKind::Camera),
                ..Self::NONE
            }
        }
    }

    /// Whether a ray that left after so many bounces sees it.
    #[inline]
    pub fn allow(&self, kind: RayKind, bounces: u32) -> bool {
        self.visibility.sees(kind) && bounces <= self.max_bounces
    }
}

/// The form of a lamp.
enum Form {
    Ball(Lamp),
    Area(Area),
}

impl Form {
    fn sample(&self, from: Vec3, normal: Option<Vec3>, u: Vec2) -> Option<LampSample> {
        match self {
            Self::Ball(lamp) => lamp.sample(from, normal, u),
            Self::Area(area) => area.sample(from, u),
        }
    }

    fn meet(&self, at: &super::Shaded, origin: Vec3, wi: Vec3) -> Option<Meeting> {
        match self {
            Self::Ball(lamp) => lamp.meet(at.point, at.normal, origin, wi),
            Self::Area(area) => area.meet(at.point, origin, wi),
        }
    }

    /// Whether rays can find it.
    fn is_sized(&self) -> bool {
        match self {
            Self::Ball(lamp) => lamp.radius > 0.0,
            Self::Area(area) => !area.is_parallel(),
        }
    }

    fn bounds(&self) -> Bounds {
        match self {
            Self::Ball(lamp) => Bounds {
                min: lamp.center - lamp.radius,
                max: lamp.center + lamp.radius,
                intensity: luminance(lamp.intensity),
                axis: lamp.cone.as_ref().map_or(Vec3::Z, |c| c.axis),
                // A spot with a scaled transform is an ellipse: only round ones are bounded by their cone. From
                // inside its sphere a spot is a point light.
                normals: lamp
                    .cone
                    .as_ref()
                    .filter(|c| is_rigid(&c.light_from_world))
                    .map_or(Angle::ALL, |c| Angle {
                        sin: (c.one_minus_cos * (2.0 - c.one_minus_cos)).max(0.0).sqrt(),
                        cos: 1.0 - c.one_minus_cos,
                    }),
                cos_emission: 1.0,
                two_sided: false,
                front: None,
            },
            Self::Area(area) => {
                let (min, max) = area.bounds();
                Bounds {
                    min,
                    max,
                    intensity: luminance(area.intensity()),
                    axis: area.normal(),
                    normals: Angle::ZERO,
                    cos_emission: area.cos_spread(),
                    two_sided: false,
                    front: Some(Front {
                        normal: area.normal(),
                        offset: area.normal().dot(area.center()),
                    }),
                }
            }
        }
    }
}

struct Placed {
    form: Form,
    rules: Rules,
    /// Its number among all emitters.
    emitter: u32,
}

/// Smaller lamps, in metres, are points: the square of a smaller angle leaves f32's normal range (1e-24 m² over the
/// square of 1e7 m is its end), and with it the density.
const POINT: f32 = 1e-12;

/// Lamps up to this number are tried one by one by rays; more go into a hierarchy of their own.
const IN_A_ROW: usize = 4;

/// All lamps.
#[derive(Default)]
pub struct Lamps {
    list: Vec<Placed>,
    /// Those with a size, for rays that may hit them.
    sized: Vec<u32>,
    finder: Option<Finder>,
    seen_by_camera: bool,
}

/// Sized lamps in Embree. They are a scene of their own, as rays go through them.
struct Finder {
    scene: CommittedScene,
    /// By the number of the geometry, then of the primitive: the lamp.
    lamps: [Vec<u32>; 2],
}

impl Lamps {
    /// Adds a light of the scene that is a lamp; its bounds, if it shines.
    pub fn add(
        &mut self,
        light: &Light,
        rules: Rules,
        origin: DVec3,
        emitter: u32,
    ) -> Option<Bounds> {
        let form = form(light, origin)?;
        let bounds = form.bounds();
        if bounds.intensity <= 0.0 {
            return None;
        }
        if form.is_sized() {
            self.sized.push(self.list.len() as u32);
            self.seen_by_camera |= rules.visibility.sees(RayKind::Camera);
        }
        self.list.push(Placed {
            form,
            rules,
            emitter,
        });
        Some(bounds)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether rays can hit any.
    pub fn can_be_hit(&self) -> bool {
        !self.sized.is_empty()
    }

    /// Whether the camera sees any.
    pub fn seen_by_camera(&self) -> bool {
        self.seen_by_camera
    }

    /// Prepares for rays.
    pub fn commit(&mut self, device: &Device) -> Result<(), EmbreeError> {
        if self.sized.len() > IN_A_ROW {
            self.finder = Some(Finder::new(&self.list, &self.sized, device)?);
        }
        Ok(())
    }

    /// Draws a direction to a lamp.
    #[inline]
    pub fn sample(&self, index: u32, at: &super::Shaded, u: Vec2) -> Option<(LampSample, Rules)> {
        let lamp = &self.list[index as usize];
        let sample = lamp.form.sample(at.point, at.normal, u)?;
        Some((sample, lamp.rules))
    }

    /// Visits the lamps that a ray meets before `far`, in their order, with their numbers among all emitters. The
    /// density is that of light sampling from `at`, given the lamp.
    #[inline]
    pub fn along(
        &self,
        at: &super::Shaded,
        origin: Vec3,
        wi: Vec3,
        far: f32,
        mut visit: impl FnMut(u32, Rules, Meeting),
    ) {
        let mut meet = |index: u32| {
            let lamp = &self.list[index as usize];
            if let Some(meeting) = lamp.form.meet(at, origin, wi)
                && meeting.distance < far
            {
                visit(lamp.emitter, lamp.rules, meeting);
            }
        };
        match &self.finder {
            None => self.sized.iter().for_each(|&i| meet(i)),
            Some(finder) => finder.along(origin, wi, far).into_iter().for_each(meet),
        }
    }
}

/// Share by which lamps are larger for Embree: the exact test follows. 2⁻¹⁶ covers the roundings of its
/// intersections, which at the edge of a quadrilateral are a few units in the last place of its corners.
const LARGER: f32 = 1.0 / 65_536.0;

impl Finder {
    fn new(list: &[Placed], sized: &[u32], device: &Device) -> Result<Self, EmbreeError> {
        let (mut spheres, mut of_sphere) = (Vec::new(), Vec::new());
        let (mut corners, mut triangles, mut of_triangle) = (Vec::new(), Vec::new(), Vec::new());
        for &index in sized {
            match &list[index as usize].form {
                Form::Ball(lamp) => {
                    // A disc that turns with the point is inside of its sphere.
                    let c = lamp.center;
                    let rounding = c.abs().max_element() * 4.0 * f32::EPSILON;
                    spheres.push([c.x, c.y, c.z, lamp.radius * (1.0 + LARGER) + rounding]);
                    of_sphere.push(index);
                }
                Form::Area(area) => {
                    let first = corners.len() as u32;
                    corners.extend(area.corners(LARGER).map(|c| c.to_array()));
                    triangles.push([first, first + 1, first + 2]);
                    triangles.push([first, first + 2, first + 3]);
                    of_triangle.extend([index; 2]);
                }
            }
        }
        let mut scene = embree::Scene::new(device, true)?;
        // The geometries have the numbers 0, 1, … in the order in which they are added.
        let mut lamps = [Vec::new(), Vec::new()];
        if !spheres.is_empty() {
            let id = scene.add_spheres(&spheres)?;
            lamps[id as usize] = of_sphere;
        }
        if !triangles.is_empty() {
            let mesh = Arc::new(TriangleMesh::new(corners, triangles)?);
            let id = scene.add_triangles(&mesh, true, u32::MAX)?;
            lamps[id as usize] = of_triangle;
        }
        Ok(Self {
            scene: scene.commit()?,
            lamps,
        })
    }

    /// Lamps that a ray may meet, in their order.
    fn along(&self, origin: Vec3, wi: Vec3, far: f32) -> Vec<u32> {
        let ray = Ray {
            origin: origin.to_array(),
            direction: wi.to_array(),
            near: 0.0,
            far,
            mask: u32::MAX,
        };
        let mut met = Vec::new();
        self.scene.intersect_filtered(&ray, |hit| {
            met.push(self.lamps[hit.geometry as usize][hit.primitive as usize]);
            false
        });
        // Embree asks in any order, perhaps twice (both sides of a sphere, both triangles of an edge).
        met.sort_unstable();
        met.dedup();
        met
    }
}

fn form(light: &Light, origin: DVec3) -> Option<Form> {
    let color = Vec3::from(light.color);
    let place = DAffine3 {
        translation: light.world_from_light.translation - origin,
        ..light.world_from_light
    };
    let ball = |intensity: f32, radius, soft_falloff, cone| {
        let lamp = Lamp {
            center: place.translation.as_vec3(),
            radius: if radius < POINT { 0.0 } else { radius },
            soft_falloff,
            intensity: color * intensity,
            cone,
        };
        // So small for its strength that f32 cannot hold the radiance: a point, as for all but mirrors it is.
        let is_point = !lamp.radiance().is_finite();
        Some(Form::Ball(Lamp {
            radius: if is_point { 0.0 } else { radius },
            ..lamp
        }))
    };
    match light.kind {
        LightKind::Point {
            intensity,
            radius,
            soft_falloff,
        } => ball(intensity, radius, soft_falloff, None),
        LightKind::Spot {
            intensity,
            radius,
            soft_falloff,
            half_angle,
            blend,
        } => {
            let cone = cone(&place, half_angle, blend);
            ball(intensity, radius, soft_falloff, Some(cone))
        }
        LightKind::Area {
            shape,
            size,
            power,
            normalize,
            spread,
        } => Area::new(
            &place,
            size,
            shape == AreaShape::Ellipse,
            color * power,
            normalize,
            spread,
        )
        .map(Form::Area),
        LightKind::Sun { .. } => None,
    }
}

fn cone(place: &DAffine3, half_angle: f32, blend: f32) -> Cone {
    let inverse = place.matrix3.inverse();
    // 1 − cos x = 2 sin²(x/2): the cosine of less than 3e-4 is 1 in f32.
    let sin = (0.5 * f64::from(half_angle)).sin();
    let one_minus_cos = (2.0 * sin * sin) as f32;
    let width = one_minus_cos * blend;
    Cone {
        light_from_world: if inverse.is_finite() {
            inverse.as_mat3()
        } else {
            Mat3::IDENTITY
        },
        axis: direction(place),
        one_minus_cos,
        steepness: if width > 0.0 {
            1.0 / width
        } else {
            f32::INFINITY
        },
    }
}

/// Where a light looks.
pub fn direction(t: &DAffine3) -> Vec3 {
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
