//! What a saved state says of itself before the pixels, and what can't be true of it.

use super::Region;
use crate::film::Passes;
use crate::film::objects::Label;
use crate::integrator::VECTOR_SUMS;
use crate::render::InstructionSet;
use crate::render::tile::{Kept, catcher_sums};
use crate::sampler::Sequences;
use crate::scene::{Aov, ColorManagement};
use glam::DMat3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// No side of a picture is longer.
const LONGEST_SIDE: u32 = 1 << 20;
/// No honest count of samples, rays or nanoseconds is larger: so many rays take a thousand machines a thousand years. Sums of
/// eight such counts fit u64.
pub(super) const LARGEST_COUNT: u64 = 1 << 60;
/// No honest render takes longer, in seconds: thirty thousand years.
const LONGEST_TIME: f64 = 1e12;

/// What a render had done when it was saved.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Traced {
    /// Samples of all pixels together.
    pub samples: u64,
    /// Rays.
    pub rays: u64,
    /// Seconds of tracing.
    pub seconds: f64,
    /// Lobes that surfaces went without.
    #[serde(default)]
    pub lobes_left_out: u64,
    /// Samples that were not finite …
    pub non_finite: u64,
    /// … and where the first of them were.
    pub non_finite_examples: Vec<(u32, u32, u32)>,
    /// … and why, as far as it was told then.
    #[serde(default)]
    pub non_finite_causes: BTreeMap<String, u64>,
}

impl Traced {
    /// Both together.
    pub fn join(&mut self, other: &Self) {
        self.samples = self.samples.saturating_add(other.samples);
        self.rays = self.rays.saturating_add(other.rays);
        self.seconds += other.seconds;
        self.lobes_left_out = self.lobes_left_out.saturating_add(other.lobes_left_out);
        self.non_finite = self.non_finite.saturating_add(other.non_finite);
        self.non_finite_examples
            .extend_from_slice(&other.non_finite_examples);
        for (cause, count) in &other.non_finite_causes {
            let all = self.non_finite_causes.entry(cause.clone()).or_default();
            *all = all.saturating_add(*count);
        }
    }

    /// What can't be true of it.
    fn fault(&self, size: (u32, u32)) -> Option<&'static str> {
        let counts = [
            self.samples,
            self.rays,
            self.lobes_left_out,
            self.non_finite,
        ];
        let causes = self.non_finite_causes.values();
        if counts.iter().chain(causes).any(|&n| n > LARGEST_COUNT) {
            return Some("its counts are none");
        }
        if !(0.0..=LONGEST_TIME).contains(&self.seconds) {
            return Some("its time is none");
        }
        let outside = |&(x, y, _): &(u32, u32, u32)| x >= size.0 || y >= size.1;
        let examples = &self.non_finite_examples;
        let wrong = examples.len() as u64 > self.non_finite || examples.iter().any(outside);
        wrong.then_some("its samples that were not finite are none of the picture")
    }
}

/// All but the pixels.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Header {
    /// The program that wrote it.
    pub program: String,
    /// The version of Embree that met the surfaces …
    pub embree: String,
    /// … and the instructions that it took.
    pub instruction_set: InstructionSet,
    /// Fingerprint of the scene.
    pub scene: String,
    /// The settings that decide which samples there are.
    pub settings: serde_json::Map<String, serde_json::Value>,
    /// Size of the whole picture.
    pub size: (u32, u32),
    /// The part of it that is here.
    pub region: Region,
    /// Passes by name.
    pub passes: Vec<String>,
    /// The camera's axes, for passes that speak in them.
    pub axes: [[f64; 3]; 3],
    /// Numbers of the samples that are here, or are begun: from, and the one after the last.
    pub ranges: Vec<(u32, u32)>,
    /// It can be gone on with: samples of each pixel are the first ones of the only range.
    pub whole: bool,
    /// Light is kept apart for passes.
    #[serde(rename = "apart")]
    pub light_passes: bool,
    /// Features for denoisers are kept.
    #[serde(default)]
    pub features: bool,
    /// Nanoseconds are kept.
    pub costs: bool,
    /// Objects and mist are kept …
    #[serde(default)]
    pub objects: bool,
    /// … and what is known of each object.
    #[serde(default)]
    pub labels: Vec<Label>,
    /// Light groups whose light is kept.
    #[serde(default)]
    pub light_groups: Vec<String>,
    /// Motion vectors are kept.
    #[serde(default)]
    pub vectors: bool,
    /// The scene's own passes.
    #[serde(default)]
    pub aovs: Vec<Aov>,
    /// Shadow catchers are kept …
    #[serde(default)]
    pub catchers: bool,
    /// … for a film that is transparent.
    #[serde(default)]
    pub transparent: bool,
    /// The radiance of half of the samples is kept.
    #[serde(default)]
    pub halves: bool,
    /// Luminance that clamping took from direct and indirect light.
    pub clamped: [f64; 2],
    /// Effects that the scene calls for and the settings leave out.
    #[serde(default)]
    pub left_out: Vec<String>,
    /// How the scene wishes to be shown.
    pub color_management: ColorManagement,
    /// Counts.
    pub traced: Traced,
}

impl Header {
    /// How many sequences the samples of a pixel are of.
    pub fn sequences(&self) -> Sequences {
        let named = self.settings.get("sequences").cloned();
        let of = named.and_then(|named| serde_json::from_value(named).ok());
        of.unwrap_or_default()
    }

    /// The camera's axes.
    pub(in crate::render) fn axes(&self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.axes)
    }

    /// Which sums there are besides those of all pixels.
    pub(in crate::render) fn kept(&self) -> Kept {
        Kept {
            light_passes: self.light_passes,
            features: self.features,
            costs: self.costs,
            objects: self.objects,
            groups: self.light_groups.len(),
            aovs: catcher_sums(self.catchers)
                + Aov::floats(&self.aovs)
                + if self.vectors { VECTOR_SUMS } else { 0 },
            halves: self.halves,
            // Whoever goes on traces them once more.
            centers: false,
        }
    }

    /// Bytes of a pixel.
    pub(super) fn pixel_bytes(&self) -> usize {
        self.kept().bytes_a_pixel()
    }

    /// Samples that a pixel may have: all that are here or begun.
    pub(in crate::render) fn most_samples(&self) -> u32 {
        // They do not overlap (`fault`): their sum is below 2^32.
        self.ranges.iter().map(|(from, to)| to - from).sum()
    }

    /// What can't be true of it.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let Region { x0, y0, x1, y1 } = self.region;
        let size = self.size;
        if x0 >= x1 || y0 >= y1 || x1 > size.0 || y1 > size.1 {
            return Some("its region is none");
        }
        if size.0.max(size.1) > LONGEST_SIDE {
            return Some("its picture is too large");
        }
        let Ok(passes) = Passes::parse(self.passes.iter().map(String::as_str)) else {
            return Some("it has passes that there are not");
        };
        let own = (self.light_groups.len(), &self.aovs[..], self.catchers);
        if self.kept() != Kept::of(passes, own, self.halves) {
            return Some("it does not keep what its passes need");
        }
        let each = self.ranges.iter().all(|(from, to)| from <= to);
        let sorted = self.ranges.is_sorted_by(|a, b| a.1 <= b.0);
        if self.ranges.is_empty() || !each || !sorted {
            return Some("its samples are none");
        }
        let floats = self.axes.as_flattened().iter().chain(&self.clamped);
        let labels = self.labels.iter().all(Label::is_finite);
        if !(labels && floats.copied().all(f64::is_finite)) {
            return Some("its numbers are not finite");
        }
        self.traced.fault(size)
    }

    /// Why the pixels of another can't be put to those of this one.
    pub(in crate::render) fn unlike(&self, other: &Self) -> Option<String> {
        let shape = |h: &Self| (h.size, h.region, h.kept());
        if shape(self) != shape(other)
            || self.passes != other.passes
            || self.axes != other.axes
            || self.aovs != other.aovs
            || (self.catchers, self.transparent) != (other.catchers, other.transparent)
        {
            return Some("they are of different pictures".into());
        }
        if self.instruction_set != other.instruction_set {
            let (a, b) = (self.instruction_set, other.instruction_set);
            let least = a.min(b);
            return Some(format!(
                "the first was traced with the instruction set {a}, the second with {b}, and bits differ; render all parts with --instruction-set {least}"
            ));
        }
        (self.embree != other.embree).then(|| {
            format!(
                "the first was traced with Embree {}, the second with {}, and bits differ; render all parts with the same Sundog",
                self.embree, other.embree
            )
        })
    }
}
