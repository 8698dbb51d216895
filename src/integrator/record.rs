//! What a path does, step by step, for those who look at a single one: how it comes to its radiance, and which
//! of its quantities was the first that is not finite.

use crate::film::features::PathFeatures;
use crate::film::light_passes::{NoPasses, PassSink, PathPasses};
use crate::math::float::BoundedPoint;
use crate::shading::Normals;
pub use crate::shading::Scattering;
use crate::world::{Hit, RayKind, Source, Surface};
use glam::{Vec2, Vec3};

/// Takes the steps of a path. The path loop is compiled with one of these: with [`NoPasses`] and [`PathPasses`]
/// nothing of it is left.
pub trait Record {
    /// Takes a step.
    #[inline(always)]
    fn step(&mut self, _step: impl FnOnce() -> Step) {}
}

impl Record for NoPasses {}
impl Record for PathPasses {}
impl Record for PathFeatures {}

/// A step of a path. Positions are relative to the world's origin.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// A ray is sent.
    Ray {
        /// Scatterings so far.
        bounce: u32,
        /// By the last of them.
        kind: RayKind,
        /// From here …
        origin: Vec3,
        /// … to there …
        direction: Vec3,
        /// … within these distances.
        span: (f32, f32),
        /// What a unit of radiance along it brings to the camera.
        throughput: Vec3,
    },
    /// It meets a surface that it does not pass, or takes the light of a light sample at one that it does.
    Surface {
        /// Number of the object among those with triangles.
        object: u32,
        /// Number of the triangle.
        triangle: u32,
        /// Weights of its second and third corner.
        weights: Vec2,
        /// Distance along the ray.
        distance: f32,
        /// Where, with its error bound.
        point: BoundedPoint,
        /// On the side from which the ray came.
        normals: Normals,
        /// The ray came from behind.
        inside: bool,
    },
    /// The ray has found something that shines.
    Found {
        /// What.
        source: Source,
        /// Its radiance.
        radiance: Vec3,
        /// Density of the ray as a BSDF sample.
        bsdf_pdf: f32,
        /// Density with which light sampling finds it; infinite where nothing else may find it.
        light_pdf: f32,
        /// Of multiple importance sampling.
        weight: f32,
    },
    /// Russian roulette.
    Roulette {
        /// Probability to go on.
        survival: f32,
        /// The number drawn; the path goes on if it is less.
        drawn: f32,
    },
    /// A light is drawn, or none (the last if so).
    Light {
        /// Which, and what has come of it.
        light: Option<Lit>,
        /// The numbers drawn: place on the light, which light.
        numbers: Vec3,
    },
    /// A direction is drawn to go on, or none.
    Scattered {
        /// What has come of it.
        sample: Option<Scattered>,
        /// The numbers drawn.
        numbers: Vec3,
    },
    /// It goes below the surface and comes out elsewhere.
    Below {
        /// Scatterings on the way.
        steps: u32,
        /// Where it goes in …
        from: Vec3,
        /// … and comes out.
        to: Vec3,
        /// What a unit of radiance that comes out brings to the camera.
        throughput: Vec3,
    },
    /// It goes through a portal.
    Portal {
        /// Where it has met it …
        from: Vec3,
        /// … and goes on …
        to: Vec3,
        /// … in this direction.
        direction: Vec3,
        /// What a unit of radiance from there brings to the camera.
        throughput: Vec3,
    },
    /// Light is added to what the path has gathered.
    Added {
        /// The contribution.
        light: Vec3,
        /// What clamping left of it.
        kept: Vec3,
    },
    /// The path ends.
    End(End),
}

impl Step {
    /// A surface is met.
    pub(super) fn met(hit: &Hit, surface: &Surface) -> Self {
        Self::Surface {
            object: hit.object(),
            triangle: hit.primitive,
            weights: Vec2::new(hit.u, hit.v),
            distance: hit.distance,
            point: surface.point,
            normals: surface.normals,
            inside: surface.inside,
        }
    }
}

/// A light sample.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// What was drawn.
    pub source: Option<Source>,
    /// Towards it.
    pub direction: Vec3,
    /// Density with which light sampling finds the direction; 0 of lights that nothing else finds.
    pub pdf: f32,
    /// Radiance over density.
    pub contribution: Vec3,
    /// BSDF · |cos|.
    pub bsdf: Vec3,
    /// Density with which BSDF sampling finds the direction.
    pub bsdf_pdf: f32,
    /// The same with the weight of multiple importance sampling.
    pub weighted: Vec3,
    /// Share of the light that comes through; `None` if nothing would, so that no ray was sent.
    pub share: Option<f32>,
}

/// A direction to go on.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// The lobe.
    pub scattering: Scattering,
    /// The direction.
    pub direction: Vec3,
    /// BSDF · |cos| over density.
    pub weight: Vec3,
    /// Density; meaningless if `delta`.
    pub pdf: f32,
    /// Nothing else finds the direction.
    pub delta: bool,
}

/// Why a path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The ray meets nothing.
    Nothing,
    /// It would have to pass one transparent surface too many.
    Transparent,
    /// It meets a hole in the picture.
    Holdout,
    /// The surface does nothing but shine.
    Unlit,
    /// No bounces are left.
    Bounces,
    /// Russian roulette.
    Roulette,
    /// No direction was drawn.
    Absorbed,
    /// The surface itself is in the way.
    Own,
    /// No way was found from below the surface.
    Below,
    /// The weight of the direction is zero.
    Black,
}

/// Keeps all steps.
#[derive(Debug, Default)]
pub struct Recorder(pub Vec<Step>);

impl Record for Recorder {
    fn step(&mut self, step: impl FnOnce() -> Step) {
        self.0.push(step());
    }
}

impl PassSink for Recorder {}

/// Why a radiance is not finite: the first of its quantities that is not. Objects by their numbers among those
/// with triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The ray of the camera.
    CameraRay,
    /// Where a ray meets an object.
    Point(u32),
    /// A normal of an object.
    Normal(u32),
    /// The radiance of something that shines.
    Radiance(Source),
    /// The density with which light sampling finds something.
    Density(Source),
    /// Radiance over density of a light sample.
    LightSample(Source),
    /// The value of an object's BSDF, or its density.
    Bsdf(u32),
    /// The weight of a direction drawn from an object's BSDF, or its density, or the direction.
    BsdfSample(u32),
    /// The product of the weights of a path.
    Throughput(u32),
    /// The product of the radiance of something and the weights of the path to it.
    Contribution(Source),
    /// The sum of finite contributions.
    Sum,
}

/// The first quantity of a path that is not finite; [`Fault::Sum`] if all of them are.
pub fn first_fault(steps: &[Step]) -> Fault {
    let (mut object, mut shining) = (0, Source::Environment);
    for step in steps {
        match step {
            Step::Surface { object: met, .. } => object = *met,
            Step::Found { source, .. } => shining = *source,
            Step::Light { light, .. } => {
                shining = light.and_then(|lit| lit.source).unwrap_or(shining);
            }
            _ => {}
        }
        if let Some(fault) = fault(step, object, shining) {
            return fault;
        }
    }
    Fault::Sum
}

/// What is not finite in a step at an object, with light of what shines.
fn fault(step: &Step, object: u32, shining: Source) -> Option<Fault> {
    let is = |bad: bool, fault: Fault| bad.then_some(fault);
    match *step {
        Step::Ray {
            bounce,
            origin,
            direction,
            throughput,
            ..
        } => {
            let fault = if bounce == 0 {
                Fault::CameraRay
            } else {
                Fault::Point(object)
            };
            is(!(origin.is_finite() && direction.is_finite()), fault)
                .or(is(!throughput.is_finite(), Fault::Throughput(object)))
        }
        Step::Surface { point, normals, .. } => {
            let Normals {
                geometric,
                curved,
                smooth,
                shading,
            } = normals;
            let point = point.point.is_finite() && point.error.is_finite();
            let normals = [geometric, curved, smooth, shading];
            let normal = normals.iter().all(|n| n.is_finite());
            is(!point, Fault::Point(object)).or(is(!normal, Fault::Normal(object)))
        }
        Step::Found {
            source,
            radiance,
            light_pdf,
            weight,
            ..
        } => is(!radiance.is_finite(), Fault::Radiance(source)).or(is(
            light_pdf.is_nan() || !weight.is_finite(),
            Fault::Density(source),
        )),
        Step::Light {
            light: Some(lit), ..
        } => {
            let finite = lit.contribution.is_finite();
            is(!lit.pdf.is_finite(), Fault::Density(shining))
                .or(is(!finite, Fault::LightSample(shining)))
                .or(is(
                    !(lit.bsdf.is_finite() && lit.weighted.is_finite()),
                    Fault::Bsdf(object),
                ))
        }
        Step::Scattered {
            sample: Some(sample),
            ..
        } => {
            let finite = sample.weight.is_finite()
                && sample.direction.is_finite()
                && (sample.delta || sample.pdf.is_finite());
            is(!finite, Fault::BsdfSample(object))
        }
        Step::Below { to, throughput, .. } | Step::Portal { to, throughput, .. } => {
            is(!to.is_finite(), Fault::Point(object))
                .or(is(!throughput.is_finite(), Fault::BsdfSample(object)))
        }
        Step::Added { light, kept } => {
            let finite = light.is_finite() && kept.is_finite();
            is(!finite, Fault::Contribution(shining))
        }
        Step::Roulette { .. } | Step::Light { .. } | Step::Scattered { .. } | Step::End(_) => None,
    }
}
