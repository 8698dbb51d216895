//! Directions in which a path passes by lights, where a medium scatters their light towards it.
//!
//! A part of the directions is drawn so. What the path carries stays as if lobes and phase functions alone had drawn them, and what
//! it finds counts as much less often as they would have: then light is clamped, and paths end by roulette, as without it.

use super::{KernelBsdf, Walk};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::record::Record;
use crate::medium::{Medium, Passing};
use crate::sampler::{Dimension, hashed};
use crate::shading::BsdfSample;
use glam::Vec3;

/// Tells the numbers of lights to pass from others.
const NEAR: u32 = 0x_5511_7712;

/// The greatest share of the directions from points of a medium that are drawn so, and of those from surfaces. Light of skies and of
/// surfaces comes from elsewhere, and what is drawn so makes it noisier, from each vertex to the next. Chosen by the noise of fogs
/// (two mean free paths) below lamps: 0.4 has 0.88 of the variance with a point lamp alone, 1.8 times with a grey sky beside it, 1.1
/// to 1.4 times over a floor.
const MOST: (f32, f32) = (0.12, 0.09);
/// The optical depth to the light that makes half of it: of what is thin most light comes from surfaces.
const HALF: f32 = 0.3;
/// The optical depth that leaves half of it. Beyond it the light's rays are scattered long before a path comes near them, and where it
/// comes from no longer tells where it is.
const FAR: f32 = 4.0;

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// Directions that pass by a light near a point of a medium, and how often they are drawn. In media that vary light is looked for
    /// where the path is scattered alone.
    fn passing(&self, point: Vec3, medium: &Medium, most: f32) -> Option<(Passing, f32)> {
        let lights = &self.world.lights;
        let scattering = medium.scattering.element_sum() / 3.0;
        if self.beside.within.varies || scattering <= 0.0 || lights.is_empty() {
            return None;
        }
        let key = self.sampler.key(Dimension::Opacity, self.bounce);
        let light = lights.near(&self.beside.previous.at, hashed(key, NEAR, self.passed))?;
        let passing = Passing::new(point, light)?;
        let depth = scattering * passing.distance();
        let (near, far) = (depth / (depth + HALF), depth / FAR);
        Some((passing, most * near / (1.0 + far * far)))
    }

    /// Draws the way on from a point of a medium: with the phase function's value and density.
    pub(super) fn scattered_by(
        &mut self,
        point: Vec3,
        there: Option<&Medium>,
        u: Vec3,
    ) -> (Vec3, Vec3, f32) {
        let medium = there.unwrap_or(&self.beside.within.medium);
        let passing = self.passing(point, medium, MOST.0);
        let (drawn, u) = drawn(passing, u);
        let onward = drawn.unwrap_or_else(|| medium.scatter(self.direction, u));
        let (value, pdf) = medium.phase(self.direction.dot(onward));
        if let Some((passing, share)) = passing
            && pdf > 0.0
        {
            self.light.counts *= pdf / (share * passing.density(onward) + (1.0 - share) * pdf);
        }
        (onward, value, pdf)
    }

    /// Draws the way on from a surface.
    #[cold]
    #[inline(never)]
    pub(super) fn sample_in_media(&mut self, bsdf: &KernelBsdf<E>, u: Vec3) -> Option<BsdfSample> {
        let passing = self.passing_above(bsdf);
        let (drawn, u) = drawn(passing, u);
        let sample = match drawn {
            // On the other side is another medium.
            Some(onward) if bsdf.is_beyond(onward) => None,
            Some(onward) => bsdf.sample_towards(onward, u.z),
            None => bsdf.sample(u),
        }?;
        if let Some((passing, share)) = passing {
            self.light.counts *= if sample.delta || bsdf.is_beyond(sample.wi) {
                (1.0 - share).recip()
            } else {
                sample.pdf / (share * passing.density(sample.wi) + (1.0 - share) * sample.pdf)
            };
        }
        Some(sample)
    }

    /// The same from a surface with a medium before it, where the light is on that side. Whether a path goes elsewhere is told by the
    /// number that chooses here, too: where surfaces let it, none of the directions is drawn so.
    fn passing_above(&self, bsdf: &KernelBsdf<E>) -> Option<(Passing, f32)> {
        if !bsdf.is_samplable() || self.world.goes_below() || self.world.has_portals() {
            return None;
        }
        let medium = &self.beside.within.medium;
        let passing = self.passing(self.beside.previous.at.point, medium, MOST.1)?;
        (!bsdf.is_below(passing.0.axis())).then_some(passing)
    }
}

/// A direction that passes by a light, if a number chooses one; with the numbers that are left.
fn drawn(passing: Option<(Passing, f32)>, u: Vec3) -> (Option<Vec3>, Vec3) {
    match passing {
        Some((passing, share)) if u.z < share => {
            let direction = passing.sample(u.truncate());
            (Some(direction), u.with_z(u.z / share))
        }
        Some((_, share)) => (None, u.with_z((u.z - share) / (1.0 - share))),
        None => (None, u),
    }
}
