//! Directions that light leaves a fibre in, drawn by following it through (section 5 of the paper).

use super::super::LobeSample;
use super::super::chiang::draw_along;
use super::section::{self, sees};
use super::{Crossing, Huang, LobeValue, Numbers, mirror};
use crate::math::average;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Directions and light of R, TT, TRT and all further ways.
type Ways = [(Vec3, Vec3); 4];

/// Light inside, before it meets the boundary again.
struct Inside {
    /// Where to.
    direction: Vec3,
    /// Where it has entered, where it meets the boundary, and its direction: γ, γ and φ.
    angles: [f32; 3],
    /// The mean normal there, inward, tilted.
    mean: Vec3,
    /// What is left of it.
    light: Vec3,
    /// What is left of all light after this way.
    left: Vec3,
}

impl Huang {
    /// Draws a direction: `u` and `choice` stand for the offset and the way that is taken.
    pub fn sample(&self, u: Vec2, choice: f32) -> Option<LobeSample> {
        let mut numbers = Numbers::new(self.seed, Vec3::new(u.x, u.y, choice));
        let offset = if self.is_near() {
            self.offset / self.section.radius()
        } else {
            2.0 * u.y - 1.0
        };
        let first = Vec2::new(u.x, numbers.next());
        let ways = self.draw(self.section.gamma_at(offset), first, &mut numbers)?;
        let energies = ways.map(|(_, light)| average(light));
        let total: f32 = energies.iter().sum();
        let mut left = choice * total;
        let mut found = None;
        for (way, energy) in ways.iter().zip(energies) {
            if energy > 0.0 && total.is_finite() {
                found = Some((way, energy));
                if left < energy {
                    break;
                }
                left -= energy;
            }
        }
        let ((direction, light), energy) = found?;
        let wi = self.frame.to_world(*direction).try_normalize()?;
        let value = self.weight * *light * (total / energy);
        LobeSample::reflected(wi, LobeValue { value, pdf: 1.0 })
    }

    /// From a place of the section; none where that is not seen.
    fn draw(&self, gamma: f32, u: Vec2, numbers: &mut Numbers) -> Option<Ways> {
        let (section, wo, of) = (&self.section, self.wo, &self.of);
        let (flat, mean) = (section.normal(0.0, gamma), section.normal(of.tilt, gamma));
        if mean.dot(wo) < 0.0 || flat.dot(wo) < 0.0 {
            return None;
        }
        let first = self.cross(wo, mean, of.ior, u);
        if !sees(wo, flat, first.facet) {
            return None;
        }
        let mut ways = [(Vec3::Z, Vec3::ZERO); 4];
        let scale = self.scale(first.cos, false);
        let mirrored = mirror(wo, first.facet);
        if sees(mirrored, flat, first.facet) {
            let masking = self.masked_after(first.cos, mean.dot(mirrored));
            let light = of.ways.x * first.reflectance * scale * masking;
            ways[0] = (mirrored, Vec3::splat(light));
        }
        let within = first.through;
        if within != Vec3::ZERO && sees(-within, flat, first.facet) {
            let phi = section::phi(within);
            let opposite = 2.0 * section.phi_of(phi) - gamma;
            let masking = self.masked_after(first.cos, -mean.dot(within));
            let inside = Inside {
                direction: within,
                angles: [gamma, opposite, phi],
                mean: section.normal(-of.tilt, opposite),
                light: Vec3::splat((1.0 - first.reflectance) * scale * masking),
                left: self.left(within, section.first_way(gamma, phi, opposite)),
            };
            self.draw_inside(&inside, &mut ways, numbers);
        }
        Some(ways)
    }

    /// Light that has entered.
    fn draw_inside(&self, inside: &Inside, ways: &mut Ways, numbers: &mut Numbers) {
        let (section, of, mean) = (&self.section, &self.of, inside.mean);
        let view = -inside.direction;
        let flat = section.normal(0.0, inside.angles[1]);
        let second = self.cross(view, mean, 1.0 / of.ior, numbers.pair());
        if second.cos <= 0.0 || !sees(view, flat, second.facet) {
            return;
        }
        let scale = self.scale(second.cos, true);
        let leaves = 1.0 - second.reflectance;
        let out = second.through;
        if leaves > 0.0 && -mean.dot(out) > 0.0 && sees(-out, flat, second.facet) {
            let masking = self.masked_after(second.cos, -mean.dot(out));
            let share = of.ways.y * leaves * scale * masking;
            ways[1] = (out, inside.light * inside.left * share);
        }
        self.draw_again(inside, (&second, scale), ways, numbers);
    }

    /// Light that is reflected inside.
    fn draw_again(
        &self,
        inside: &Inside,
        (second, scale): (&Crossing, f32),
        ways: &mut Ways,
        numbers: &mut Numbers,
    ) {
        let (section, of) = (&self.section, &self.of);
        let [gamma, opposite, phi] = inside.angles;
        // Whence it comes.
        let view = mirror(inside.direction, second.facet);
        let phi_back = section::phi(view);
        let place = gamma - 2.0 * (section.phi_of(phi) - section.phi_of(phi_back)) + PI;
        let mean = section.normal(-of.tilt, place);
        let third = self.cross(view, mean, 1.0 / of.ior, numbers.pair());
        if third.cos <= 0.0 {
            return;
        }
        let left = self.left(view, section.way(opposite, phi_back, place));
        let share = second.reflectance
            * scale
            * self.scale(third.cos, true)
            * self.masked_after(second.cos, inside.mean.dot(-view));
        let light = inside.light * inside.left * left * share;
        let leaves = 1.0 - third.reflectance;
        let out = third.through;
        let flat = Vec3::new(mean.x, 0.0, mean.z);
        if leaves > 0.0 && sees(view, flat, third.facet) && sees(-out, flat, third.facet) {
            let masking = self.masked_after(third.cos, -mean.dot(out));
            ways[2] = (out, light * (of.ways.z * leaves * masking));
        }
        // All further ways are a geometric series, spread as Chiang et al. spread them.
        let lean = section::lean(self.wo);
        let sine = draw_along(lean, 4.0 * of.roughness, numbers.pair());
        let across = (1.0 - sine * sine).max(0.0).sqrt();
        let (x, z) = (TAU * numbers.next()).sin_cos();
        let mean_left = (inside.left * left).map(f32::sqrt);
        let leaves = (0.5 * (1.0 - second.reflectance + leaves)).max(1e-5);
        let further = mean_left * leaves / (Vec3::ONE - mean_left * (1.0 - leaves));
        let masking = self.masked_after(third.cos, mean.dot(mirror(view, third.facet)));
        ways[3] = (
            Vec3::new(x * across, sine, z * across),
            light * further * (third.reflectance * masking),
        );
    }
}
