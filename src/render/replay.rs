//! One sample of a picture once more, with all that its path does.

use super::prepare::Prepared;
use super::saved::Traced;
use super::trace::Job;
use super::{RenderError, RenderSettings};
use crate::integrator::{End, Lit, Scattered, Scattering, Step};
use crate::scene::{RayKind, Scene, coincident};
use glam::Vec3;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// A sample and its path.
#[derive(Clone, Debug, Serialize)]
pub struct Replay {
    /// Column and row.
    pub pixel: [u32; 2],
    /// Number of the sample.
    pub sample: u32,
    /// Where in the pixel, from its centre.
    pub offset: Detail,
    /// What the path does.
    pub steps: Vec<TraceStep>,
    /// What it brings to the picture.
    pub radiance: Detail,
    /// Rays that it took.
    pub rays: u32,
    /// Whether the kernel that makes the picture has the same bits as the one that tells its steps.
    pub same_bits: bool,
    /// What is not finite first, if anything is not.
    pub cause: Option<String>,
}

/// A step of a path, in words and numbers.
#[derive(Clone, Debug)]
pub struct TraceStep {
    /// What kind of step.
    pub step: &'static str,
    /// What belongs to it.
    pub details: Vec<(&'static str, Detail)>,
}

/// Something that belongs to a step. Numbers that are not finite are `"NaN"`, `"inf"` and `"-inf"` in JSON.
#[derive(Clone, Debug, PartialEq)]
pub enum Detail {
    /// A word or a name.
    Text(String),
    /// Yes or no.
    Flag(bool),
    /// A count or a place in a list.
    Count(u32),
    /// A number of the path.
    Number(f32),
    /// Numbers of the path.
    Numbers(Vec<f32>),
    /// A place in the world.
    Place([f64; 3]),
}

impl Serialize for TraceStep {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1 + self.details.len()))?;
        map.serialize_entry("step", self.step)?;
        for (name, detail) in &self.details {
            map.serialize_entry(name, detail)?;
        }
        map.end()
    }
}

/// A number that JSON has no word for as text.
struct Number<T>(T);

macro_rules! numbers {
    ($($float:ty),*) => {$(
        impl Serialize for Number<$float> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                if self.0.is_finite() {
                    self.0.serialize(serializer)
                } else {
                    serializer.collect_str(&self.0)
                }
            }
        }
    )*};
}
numbers!(f32, f64);

impl Serialize for Detail {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => text.serialize(serializer),
            Self::Flag(flag) => flag.serialize(serializer),
            Self::Count(count) => count.serialize(serializer),
            Self::Number(number) => Number(*number).serialize(serializer),
            Self::Numbers(numbers) => serializer.collect_seq(numbers.iter().map(|&n| Number(n))),
            Self::Place(place) => serializer.collect_seq(place.iter().map(|&n| Number(n))),
        }
    }
}

impl From<Vec3> for Detail {
    fn from(v: Vec3) -> Self {
        Self::Numbers(v.to_array().to_vec())
    }
}

/// Takes a sample of a picture once more: the one with this number of the pixel in this column and row.
///
/// # Errors
/// As [`super::render`]; and if the picture has no such pixel.
pub fn replay(
    scene: &Scene,
    settings: &RenderSettings,
    (x, y, sample): (u32, u32, u32),
) -> Result<Replay, RenderError> {
    let (width, height) = (settings.width, settings.height);
    if x >= width || y >= height {
        return Err(RenderError::Setting(format!(
            "pixel {x}, {y} is outside of the picture of {width} x {height} pixels, whose first is 0, 0"
        )));
    }
    let prepared = Prepared::new((scene, &coincident::find(scene)), settings)?;
    let job = prepared.job(scene, settings, &Traced::default());
    let recorded = job.record(x, y, sample);
    let path = &recorded.path;
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    let same = |other: Vec3| bits(other) == bits(path.radiance);
    // NaN has many bits, and which of them is nobody's affair.
    let radiance = job.radiance(x, y, sample);
    let same_bits = same(radiance) || (radiance.is_nan() && path.radiance.is_nan());
    let finite = path.radiance.is_finite() && path.first.is_finite();
    Ok(Replay {
        pixel: [x, y],
        sample,
        offset: Detail::Numbers(recorded.offset.to_array().to_vec()),
        steps: recorded.steps.iter().map(|step| job.told(step)).collect(),
        radiance: path.radiance.into(),
        rays: path.rays,
        same_bits,
        cause: (!finite).then(|| job.cause(&recorded)),
    })
}

fn scattering(scattering: Scattering) -> Detail {
    let name = match scattering {
        Scattering::Diffuse => "diffuse",
        Scattering::Glossy => "glossy",
        Scattering::Transmission => "transmission",
    };
    Detail::Text(name.into())
}

fn kind(kind: RayKind) -> Detail {
    let name = RayKind::ALL.iter().find(|(k, _)| *k == kind);
    Detail::Text(name.map_or("", |(_, name)| name).into())
}

fn reason(end: End) -> &'static str {
    match end {
        End::Nothing => "the ray meets nothing",
        End::Transparent => "no transparent surface more may be passed",
        End::Holdout => "the object is a holdout",
        End::Unlit => "the surface does nothing but shine",
        End::Bounces => "no bounces are left",
        End::Roulette => "Russian roulette",
        End::Absorbed => "no direction was drawn",
        End::Own => "the surface itself is in the way of the direction",
        End::Below => "no way was found from below the surface",
        End::Black => "the weight of the direction is zero",
    }
}

impl Job<'_> {
    /// A place relative to the world's origin, in the world.
    fn place(&self, point: Vec3) -> Detail {
        Detail::Place((self.world.origin + point.as_dvec3()).to_array())
    }

    fn told(&self, step: &Step) -> TraceStep {
        let told = |step, details| TraceStep { step, details };
        let named = |name: String| Detail::Text(name.trim_matches('"').into());
        match *step {
            Step::Ray {
                bounce,
                kind: of,
                origin,
                direction,
                span,
                throughput,
            } => told(
                "ray",
                vec![
                    ("bounce", Detail::Count(bounce)),
                    ("kind", kind(of)),
                    ("origin", self.place(origin)),
                    ("direction", direction.into()),
                    ("span", Detail::Numbers(vec![span.0, span.1])),
                    ("throughput", throughput.into()),
                ],
            ),
            Step::Surface {
                object,
                triangle,
                weights,
                distance,
                point,
                normals,
                inside,
            } => told(
                "surface",
                vec![
                    ("object", named(self.object(object))),
                    ("material", named(self.material(object))),
                    ("triangle", Detail::Count(triangle)),
                    ("weights", Detail::Numbers(weights.to_array().to_vec())),
                    ("distance", Detail::Number(distance)),
                    ("point", self.place(point.point)),
                    ("error", point.error.into()),
                    ("normal", normals.geometric.into()),
                    ("smooth_normal", normals.smooth.into()),
                    ("shading_normal", normals.shading.into()),
                    ("inside", Detail::Flag(inside)),
                ],
            ),
            Step::Found {
                source,
                radiance,
                bsdf_pdf,
                light_pdf,
                weight,
            } => told(
                "found",
                vec![
                    ("source", Detail::Text(self.source(source))),
                    ("radiance", radiance.into()),
                    ("bsdf_pdf", Detail::Number(bsdf_pdf)),
                    ("light_pdf", Detail::Number(light_pdf)),
                    ("mis_weight", Detail::Number(weight)),
                ],
            ),
            Step::Roulette { survival, drawn } => told(
                "roulette",
                vec![
                    ("survival", Detail::Number(survival)),
                    ("drawn", Detail::Number(drawn)),
                ],
            ),
            Step::Light { light, numbers } => {
                let mut details = vec![("drawn", numbers.into())];
                match light {
                    None => details.push(("source", Detail::Text("none".into()))),
                    Some(lit) => details.extend(self.lit(&lit)),
                }
                told("light", details)
            }
            Step::Scattered { sample, numbers } => {
                let mut details = vec![("drawn", numbers.into())];
                match sample {
                    None => details.push(("lobe", Detail::Text("none".into()))),
                    Some(sample) => details.extend(scattered(&sample)),
                }
                told("scattered", details)
            }
            Step::Below {
                steps,
                from,
                to,
                throughput,
            } => told(
                "below",
                vec![
                    ("scatterings", Detail::Count(steps)),
                    ("from", self.place(from)),
                    ("to", self.place(to)),
                    ("throughput", throughput.into()),
                ],
            ),
            Step::Portal {
                from,
                to,
                direction,
                throughput,
            } => told(
                "portal",
                vec![
                    ("from", self.place(from)),
                    ("to", self.place(to)),
                    ("direction", direction.into()),
                    ("throughput", throughput.into()),
                ],
            ),
            Step::Added { light, kept } => {
                let mut details = vec![("light", light.into())];
                if kept != light {
                    details.push(("clamped_to", kept.into()));
                }
                told("added", details)
            }
            Step::End(end) => told("end", vec![("reason", Detail::Text(reason(end).into()))]),
        }
    }

    fn lit(&self, lit: &Lit) -> Vec<(&'static str, Detail)> {
        let source = lit.source.map(|source| self.source(source));
        let mut details = vec![
            ("source", Detail::Text(source.unwrap_or_default())),
            ("direction", lit.direction.into()),
            ("light_pdf", Detail::Number(lit.pdf)),
            ("radiance_over_pdf", lit.contribution.into()),
            ("bsdf", lit.bsdf.into()),
            ("bsdf_pdf", Detail::Number(lit.bsdf_pdf)),
            ("weighted_bsdf", lit.weighted.into()),
        ];
        match lit.share {
            Some(share) => details.push(("visible", Detail::Number(share))),
            None => details.push(("visible", Detail::Text("not asked".into()))),
        }
        details
    }
}

fn scattered(sample: &Scattered) -> Vec<(&'static str, Detail)> {
    vec![
        ("lobe", scattering(sample.scattering)),
        ("direction", sample.direction.into()),
        ("weight", sample.weight.into()),
        (
            "pdf",
            if sample.delta {
                Detail::Text("delta".into())
            } else {
                Detail::Number(sample.pdf)
            },
        ),
    ]
}
