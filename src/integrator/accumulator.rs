//! The light that a path gathers, clamped and kept apart for passes.

use super::path::Previous;
use super::record::{Record, Step};
use super::settings::PathSettings;
use crate::film::light_passes::PassSink;
use crate::math::luminance;
use crate::world::Source;
use glam::Vec3;

/// Light that a path has gathered.
pub(super) struct Accumulator<'a, A> {
    pub radiance: Vec3,
    /// Luminance that clamping took from direct and from indirect light.
    pub clamped: [f32; 2],
    /// So many paths share what they find: each counts by its share.
    pub branches: u32,
    /// What is added counts so many times, whatever is clamped of it: as often as the path would have come here by its lobes alone,
    /// for once that it has.
    pub counts: f32,
    /// Told where the light comes from.
    pub sink: &'a mut A,
}

impl<'a, A: PassSink + Record> Accumulator<'a, A> {
    /// Of a path that has found nothing.
    #[inline(always)]
    pub fn new(sink: &'a mut A) -> Self {
        Self {
            radiance: Vec3::ZERO,
            clamped: [0.0; 2],
            branches: 1,
            counts: 1.0,
            sink,
        }
    }

    /// Adds one contribution. `bounces`: scatterings between the camera and the surface that the light
    /// falls on, so that 0 is direct light; light that the camera sees itself counts as direct.
    ///
    /// As Cycles clamps: each contribution by itself, weights of multiple importance sampling included,
    /// scaled as a whole so that the mean of its channels is at most the limit.
    #[inline]
    pub fn add(&mut self, settings: &PathSettings, light: Vec3, bounces: u32) -> Vec3 {
        let indirect = usize::from(bounces > 0);
        let mean = light.element_sum() * (1.0 / 3.0);
        let limit = settings.clamp[indirect];
        // Each is clamped as if it were the only one.
        let share = if self.branches == 1 {
            self.counts
        } else {
            self.counts / self.branches as f32
        };
        let kept = if mean > limit {
            let kept = light * (limit / mean);
            self.clamped[indirect] += luminance(light - kept) * share;
            kept * share
        } else {
            light * share
        };
        self.radiance += kept;
        self.sink.step(|| Step::Added { light, kept });
        kept
    }

    /// Weight of radiance that a ray has found and that light sampling finds with density `light_pdf`.
    #[inline]
    pub fn weigh(
        &mut self,
        settings: &PathSettings,
        previous: &Previous,
        source: Source,
        radiance: Vec3,
        light_pdf: f32,
    ) -> f32 {
        let weight = settings.weight_of_found(previous, light_pdf);
        self.sink.step(|| Step::Found {
            source,
            radiance,
            bsdf_pdf: previous.pdf,
            light_pdf,
            weight,
        });
        weight
    }

    /// Adds light of something that shines and that a ray has found after so many bounces: it falls on the
    /// surface before, or the camera sees it itself.
    #[inline]
    pub fn add_found(&mut self, settings: &PathSettings, light: Vec3, bounce: u32) -> Vec3 {
        let kept = if bounce == 0 {
            let kept = self.add(settings, light, 0);
            self.sink.emission(kept);
            kept
        } else {
            self.add_scattered(settings, light, bounce - 1)
        };
        // One of the branches alone is followed for denoisers.
        self.sink.shine(kept * self.branches as f32);
        kept
    }

    /// Adds light that a ray has found, clamped as if it was found with a chance, and then brighter.
    #[inline]
    pub fn add_found_by_chance(
        &mut self,
        settings: &PathSettings,
        light: Vec3,
        (bounce, chance): (u32, f32),
    ) -> Vec3 {
        if chance == 1.0 {
            return self.add_found(settings, light, bounce);
        }
        self.counting(chance, |sum| {
            sum.add_found(settings, light / chance, bounce)
        })
    }

    /// Adds light of a sample that counts so many times, clamped as if it counted once.
    #[inline]
    pub fn add_sampled(
        &mut self,
        settings: &PathSettings,
        light: Vec3,
        (bounces, counts): (u32, f32),
    ) -> Vec3 {
        self.counting(counts, |sum| sum.add_scattered(settings, light, bounces))
    }

    /// Adds what counts so many times as often as the path.
    #[inline(always)]
    fn counting(&mut self, counts: f32, add: impl FnOnce(&mut Self) -> Vec3) -> Vec3 {
        let of_path = self.counts;
        self.counts = of_path * counts;
        let kept = add(self);
        self.counts = of_path;
        kept
    }

    /// Adds a share of what is open, of which so much is clamped as if it were light. Passes have no place for it.
    pub fn add_open(&mut self, settings: &PathSettings, open: Vec3, (share, bounces): (Vec3, u32)) {
        let limit = settings.clamp[usize::from(bounces > 0)];
        let mean = open.element_sum() * (1.0 / 3.0);
        let clamped = if mean > limit {
            open * (limit / mean)
        } else {
            open
        };
        let light = open * share;
        let kept = clamped * share * (self.counts / self.branches as f32);
        self.radiance += kept;
        self.sink.step(|| Step::Added { light, kept });
    }

    /// Adds light that comes by way of at least one surface.
    #[inline]
    pub fn add_scattered(&mut self, settings: &PathSettings, light: Vec3, bounces: u32) -> Vec3 {
        let kept = self.add(settings, light, bounces);
        self.sink.scattered(kept, bounces > 0);
        kept
    }
}
