//! The value of a fibre for two directions: an integral over its width by Simpson's rule, in which what is behind the first boundary
//! is drawn (section 5 of the paper).

use super::super::chiang::along;
use super::section::{self, sees};
use super::{Huang, Numbers, mirror};
use crate::math::sqr;
use crate::shading::fresnel;
use glam::Vec3;
use std::f32::consts::{FRAC_2_PI, TAU};

/// Offsets over the width that are integrated over.
struct Steps {
    from: f32,
    count: usize,
    width: f32,
}

impl Steps {
    /// At most so far apart; an even number.
    fn new((from, to): (f32, f32), apart: f32) -> Self {
        let count = 2 * ((to - from) / apart * 0.5).ceil().max(1.0) as usize;
        Self {
            from,
            count,
            width: (to - from) / count as f32,
        }
    }

    /// Offsets and their weights.
    fn each(&self) -> impl Iterator<Item = (f32, f32)> {
        (0..=self.count).map(|i| {
            let weight = match i {
                i if i == 0 || i == self.count => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            (self.from + i as f32 * self.width, weight * self.width / 3.0)
        })
    }
}

/// Light at a place inside, of which all but what it is seen by is known.
struct Entered {
    /// Where to.
    direction: Vec3,
    /// Where it has entered, where it meets the boundary, and its direction: γ, γ and φ.
    angles: [f32; 3],
    /// The mean normal there, tilted.
    mean: Vec3,
    /// Its share.
    light: f32,
    /// What is left of it after the way.
    left: Vec3,
}

/// Sums over the width.
#[derive(Default)]
struct Sums {
    /// Of TT and TRT.
    refracted: Vec3,
    /// Of all further ways.
    further: Vec3,
}

/// All ways after TRT: a geometric series of what comes in, what is reflected and what is left after a way.
fn series(enters: f32, reflected: f32, left: Vec3) -> Vec3 {
    let leaves = (1.0 - reflected).max(1e-5);
    let light = left * left * left * (enters * sqr(reflected) * leaves);
    light / (Vec3::ONE - left * (1.0 - leaves))
}

fn tan_theta(direction: Vec3) -> f32 {
    direction.y / section::cos_theta(direction)
}

impl Huang {
    /// Value for a direction of the frame.
    pub(super) fn value(&self, wi: Vec3) -> Vec3 {
        let tilt = self.of.tilt.tan();
        let seen = (-tilt * tan_theta(self.wo)).max(0.0);
        if tilt * tan_theta(wi) < -1.0 || seen.is_nan() || seen > 1.0 {
            return Vec3::ZERO;
        }
        let (section, span) = (&self.section, seen.acos());
        let radius = section.radius();
        let phi = section.phi_of_view();
        let (mut from, mut to) = (section.offset_at(phi + span), section.offset_at(phi - span));
        let mut width = 2.0;
        if self.is_near() {
            // What a pixel has of the width (Yan, Jensen and Ramamoorthi, *An Efficient and Practical Near and Far Field Fur
            // Reflectance Model*, 2017).
            let least = (self.offset - self.coverage).max(-radius);
            let greatest = (self.offset + self.coverage).min(radius);
            width = (greatest - least) / radius;
            (from, to) = (from.max(least), to.min(greatest));
        }
        let ends = ((from / radius).max(-0.999), (to / radius).min(0.999));
        if ends.0 >= ends.1 {
            return Vec3::ZERO;
        }
        let projected = section::cos_theta(self.wo) * width;
        let all = self.reflected(wi, ends) + self.transmitted(wi, ends);
        let value = all / projected;
        if value.is_finite() { value } else { Vec3::ZERO }
    }

    /// R.
    fn reflected(&self, wi: Vec3, ends: (f32, f32)) -> Vec3 {
        let strength = self.of.ways.x;
        let Some(facet) = (self.wo + wi).try_normalize().filter(|_| strength > 0.0) else {
            return Vec3::ZERO;
        };
        let section = &self.section;
        let steps = Steps::new(ends, 0.7 * self.of.roughness);
        let mut sum = 0.0;
        for (offset, weight) in steps.each() {
            let gamma = section.gamma_at(offset);
            let mean = section.normal(self.of.tilt, gamma);
            let flat = Vec3::new(mean.x, 0.0, mean.z);
            if !sees(self.wo, flat, facet) || !sees(wi, flat, facet) {
                continue;
            }
            let cos = mean.dot(self.wo);
            sum += weight
                * section.gamma_by_offset(gamma)
                * self.facets(mean.dot(facet))
                * self.masked(cos, mean.dot(wi))
                * section.arc(gamma)
                * self.scale(cos, false);
        }
        let reflectance = fresnel::dielectric(self.wo.dot(facet).abs(), self.of.ior).reflectance;
        Vec3::splat(strength * 0.25 * reflectance * sum)
    }

    /// TT, TRT and all further ways.
    fn transmitted(&self, wi: Vec3, ends: (f32, f32)) -> Vec3 {
        let of = &self.of;
        if of.ways.y <= 0.0 && of.ways.z <= 0.0 {
            return Vec3::ZERO;
        }
        let mut numbers = Numbers::new(self.seed, wi);
        let steps = Steps::new(ends, 0.8 * of.roughness);
        let mut sums = Sums::default();
        for (offset, weight) in steps.each() {
            self.add_at(wi, (offset, weight), &mut sums, &mut numbers);
        }
        let spread = along(
            section::lean(self.wo),
            section::lean(wi),
            4.0 * of.roughness,
        ) / TAU;
        sums.refracted / sqr(of.ior) + sums.further * (spread * FRAC_2_PI)
    }

    /// Adds what enters at an offset.
    fn add_at(
        &self,
        wi: Vec3,
        (offset, weight): (f32, f32),
        sums: &mut Sums,
        numbers: &mut Numbers,
    ) {
        let (section, of, wo) = (&self.section, &self.of, self.wo);
        let gamma = section.gamma_at(offset);
        let mean = section.normal(of.tilt, gamma);
        let flat = section.normal(0.0, gamma);
        let first = self.cross(wo, mean, of.ior, numbers.pair());
        let within = first.through;
        let is_seen = |mean: Vec3| sees(wo, mean, first.facet) && sees(-within, mean, first.facet);
        if within == Vec3::ZERO || !is_seen(mean) || !is_seen(flat) {
            return;
        }
        let phi = section::phi(within);
        let opposite = 2.0 * section.phi_of(phi) - gamma;
        let entered = Entered {
            direction: within,
            angles: [gamma, opposite, phi],
            mean: section.normal(-of.tilt, opposite),
            light: weight * section.gamma_by_offset(gamma) * (1.0 - first.reflectance),
            left: self.left(within, section.first_way(gamma, phi, opposite)),
        };
        // Masking, and the change of variables at the first boundary.
        let cos_out = -mean.dot(within);
        let at_first = self.scale(first.cos, false) * self.masked_after(first.cos, cos_out)
            / cos_out
            * first.cos;
        if of.ways.y > 0.0 {
            sums.refracted += self.straight(wi, &entered) * (of.ways.y * at_first);
        }
        if of.ways.z > 0.0 {
            self.add_back(wi, &entered, at_first, sums, numbers);
        }
    }

    /// Refraction to a direction at a mean normal from inside, but for masking and what is left: by the facet that does it.
    /// None where no facet does.
    fn refraction(
        &self,
        view: Vec3,
        mean: Vec3,
        wi: Vec3,
        is_flat_seen: impl Fn(Vec3) -> bool,
    ) -> Option<f32> {
        let inverse = 1.0 / self.of.ior;
        let sum = view + wi * inverse;
        let length = sum.length();
        let facet = sum / length;
        let cos = mean.dot(facet);
        if cos.is_nan() || cos < 0.0 || !is_flat_seen(facet) {
            return None;
        }
        let (cos_in, cos_out) = (view.dot(facet), -wi.dot(facet));
        let enters = 1.0 - fresnel::dielectric(cos_in.abs(), inverse).reflectance;
        Some(enters * self.facets(cos) * cos_in * cos_out / sqr(length))
    }

    /// TT.
    fn straight(&self, wi: Vec3, at: &Entered) -> Vec3 {
        let view = -at.direction;
        // Total reflection otherwise.
        if wi.dot(at.direction) < 1.0 / self.of.ior - 1e-5 {
            return Vec3::ZERO;
        }
        let Some(share) = self.refraction(view, at.mean, wi, |_| true) else {
            return Vec3::ZERO;
        };
        let cos = view.dot(at.mean);
        let masking = self.masked(cos, -wi.dot(at.mean));
        let arc = self.section.arc(at.angles[1]);
        let value = at.left * (at.light * share * self.scale(cos, true) * masking * arc);
        if value.is_finite() { value } else { Vec3::ZERO }
    }

    /// TRT and all further ways.
    fn add_back(
        &self,
        wi: Vec3,
        at: &Entered,
        at_first: f32,
        sums: &mut Sums,
        numbers: &mut Numbers,
    ) {
        let (section, of, mean) = (&self.section, &self.of, at.mean);
        let view = -at.direction;
        let [gamma, opposite, phi] = at.angles;
        let second = self.cross(view, mean, 1.0 / of.ior, numbers.pair());
        if view.dot(second.facet) <= 0.0 {
            return;
        }
        // Whence it comes at the third boundary.
        let back = mirror(at.direction, second.facet);
        let further = series(at.light, second.reflectance, at.left);
        if -back.dot(wi) < 1.0 / of.ior - 1e-5 {
            sums.further += further;
            return;
        }
        let flat = section.normal(0.0, opposite);
        let is_seen =
            |mean: Vec3| sees(view, mean, second.facet) && sees(-back, mean, second.facet);
        if !is_seen(mean) || !is_seen(flat) {
            return;
        }
        sums.further += further;
        let phi_back = section::phi(back);
        let place =
            gamma - 2.0 * (section.phi_of(phi) - section.phi_of(phi_back)) + std::f32::consts::PI;
        let (third, flat) = (section.normal(-of.tilt, place), section.normal(0.0, place));
        let is_facet_seen = |facet: Vec3| {
            let both = |mean: Vec3| sees(back, mean, facet) && sees(-wi, mean, facet);
            both(third) && both(flat)
        };
        let Some(share) = self.refraction(back, third, wi, is_facet_seen) else {
            return;
        };
        let (cos, cos_back, cos_third) = (view.dot(mean), -back.dot(mean), third.dot(back));
        let left = at.left * self.left(back, section.way(opposite, phi_back, place));
        let at_second =
            second.reflectance * self.scale(cos, true) * self.masked_after(cos, cos_back)
                / cos_back
                * cos;
        let at_third = share * self.scale(cos_third, true) * self.masked(cos_third, -third.dot(wi));
        let all = at.light * at_first * at_second * at_third * section.arc(place);
        let value = left * (of.ways.z * all);
        if value.is_finite() {
            sums.refracted += value;
        }
    }
}
