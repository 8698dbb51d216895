//! Participating media: transmittance, where light is scattered, and where to.
//!
//! Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th edition, chapters 11 and 14.

mod equiangular;
pub mod particles;
mod passing;
mod phase;
pub mod profile;
mod share;
pub mod tracking;
pub mod walk;

pub use equiangular::Equiangular;
pub use passing::Passing;
pub use phase::{Lobe, Phase};
pub use share::share;

use glam::Vec3;

/// What light meets over a metre where it is: the sum of all media there.
#[derive(Clone, Debug, Default)]
pub struct Medium {
    /// What is taken or scattered, 1/m.
    pub extinction: Vec3,
    /// What is scattered, 1/m.
    pub scattering: Vec3,
    /// Radiance that is added, W·sr⁻¹·m⁻³.
    pub emission: Vec3,
    /// Where to; their coefficients' sum is the scattering.
    pub lobes: Vec<Lobe>,
}

/// Where a ray through a medium is scattered, with the weight of that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flight {
    /// At a distance.
    Scattered(f32, Vec3),
    /// It comes through.
    Through(Vec3),
}

/// exp(−σ t), also where one is infinite and the other zero: nothing takes no light.
#[inline]
pub fn transmittance(extinction: Vec3, distance: f32) -> Vec3 {
    let share = |sigma: f32| {
        if sigma > 0.0 {
            (-sigma * distance).exp()
        } else {
            1.0
        }
    };
    by_channel(extinction, share)
}

/// A function of each channel's extinction. Most media take all channels alike: then it is asked once.
#[inline]
fn by_channel(extinction: Vec3, of: impl Fn(f32) -> f32) -> Vec3 {
    let Vec3 { x, y, z } = extinction;
    let first = of(x);
    if y == x && z == x {
        return Vec3::splat(first);
    }
    Vec3::new(first, of(y), of(z))
}

impl Medium {
    /// Nothing.
    pub const EMPTY: Self = Self {
        extinction: Vec3::ZERO,
        scattering: Vec3::ZERO,
        emission: Vec3::ZERO,
        lobes: Vec::new(),
    };

    /// Adds what is in the same place.
    pub fn add(&mut self, other: &Self) {
        self.extinction += other.extinction;
        self.scattering += other.scattering;
        self.emission += other.emission;
        self.lobes.extend_from_slice(&other.lobes);
    }

    /// Share of what it takes from light that it scatters.
    pub fn albedo(&self) -> Vec3 {
        let share = |i: usize| match self.extinction[i] {
            extinction if extinction > 0.0 => self.scattering[i] / extinction,
            _ => 0.0,
        };
        Vec3::new(share(0), share(1), share(2))
    }

    /// Whether light crosses it as if there were nothing.
    #[inline]
    pub fn is_clear(&self) -> bool {
        self.extinction == Vec3::ZERO && self.emission == Vec3::ZERO
    }

    /// Radiance that a distance adds: ε (1 − T)/σ, without cancellation where it is thin.
    pub fn emitted(&self, distance: f32) -> Vec3 {
        let part = |emission: f32, sigma: f32| {
            if emission == 0.0 {
                0.0
            } else if sigma * distance > 0.0 {
                emission * -(-sigma * distance).exp_m1() / sigma
            } else {
                emission * distance
            }
        };
        Vec3::new(
            part(self.emission.x, self.extinction.x),
            part(self.emission.y, self.extinction.y),
            part(self.emission.z, self.extinction.z),
        )
    }

    /// Shares of the channels by whose free paths light of a throughput is scattered; none where it is not.
    fn shares(&self, throughput: Vec3) -> Option<Vec3> {
        let Self {
            extinction,
            scattering,
            ..
        } = *self;
        let albedo = Vec3::select(
            extinction.cmpgt(Vec3::ZERO),
            scattering / extinction.max(Vec3::splat(f32::MIN_POSITIVE)),
            Vec3::ZERO,
        );
        let shares = (throughput * albedo).max(Vec3::ZERO);
        let sum = shares.element_sum();
        (sum > 0.0 && sum.is_finite()).then(|| shares / sum)
    }

    /// Distances at which light of a throughput is scattered on the way to another; none where it is not.
    pub fn distances(&self, throughput: Vec3, end: f32) -> Option<Distances> {
        let (shares, taken) = (self.shares(throughput)?, self.taken(end));
        let sum = shares.dot(taken);
        (sum > 0.0).then(|| Distances {
            extinction: self.extinction,
            end,
            taken,
            shares: shares / sum,
        })
    }

    /// Share that it takes on a distance, without cancellation where it is thin.
    fn taken(&self, distance: f32) -> Vec3 {
        let share = |sigma: f32| {
            if sigma > 0.0 {
                -(-sigma * distance).exp_m1()
            } else {
                0.0
            }
        };
        by_channel(self.extinction, share)
    }

    /// How likely light of a throughput comes through a distance, where it is scattered as often as light is. 1 where that is too
    /// seldom for a number.
    pub fn coming_through(&self, throughput: Vec3, distance: f32) -> f32 {
        let Some(shares) = self.shares(throughput) else {
            return 1.0;
        };
        let share = (shares * transmittance(self.extinction, distance)).element_sum();
        if share > 1e-12 { share } else { 1.0 }
    }

    /// Draws where light of a throughput is scattered on the way to a distance; also how often light comes so, for once that it is
    /// drawn. One channel's free path is drawn, by what it scatters, and all of them count by the balance heuristic.
    ///
    /// `worth`: what comes to a path that is scattered, for what comes to one that is not. It only changes how often the one and
    /// the other is drawn; with 1 it is as often as light is.
    pub fn fly(&self, throughput: Vec3, distance: f32, worth: f32, u: f32) -> (Flight, f32) {
        let Self {
            extinction,
            scattering,
            ..
        } = *self;
        let Some(shares) = self.shares(throughput) else {
            return (Flight::Through(transmittance(extinction, distance)), 1.0);
        };
        let (channel, u) = chosen(shares, u);
        let passed = || transmittance(extinction, distance);
        // How much oftener than light a path is scattered.
        let often = if worth == 1.0 {
            Vec3::ONE
        } else {
            let taken = self.taken(distance);
            if worth == f32::INFINITY {
                Vec3::select(taken.cmpgt(Vec3::ZERO), taken.recip(), Vec3::ZERO)
            } else {
                worth / (taken * worth + passed())
            }
        };
        let t = -(-u / often[channel]).ln_1p() / extinction[channel];
        if t < distance {
            let passed = transmittance(extinction, t);
            let by_light = shares * extinction * passed;
            let pdf = (by_light * often).element_sum();
            let flight = Flight::Scattered(t, scattering * passed / pdf);
            (flight, by_light.element_sum() / pdf)
        } else {
            let passed = passed();
            let by_light = (shares * passed).element_sum();
            let likely = if worth == 1.0 {
                by_light
            } else {
                // What is left of 1, as passed / (taken · worth + passed).
                (shares * (passed * often / worth)).element_sum()
            };
            (Flight::Through(passed / likely), by_light / likely)
        }
    }
}

/// Distances on a way, each with its density. One channel's free path is drawn, by what it scatters on that way, and all of them
/// count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    extinction: Vec3,
    end: f32,
    /// What each channel loses on the whole way.
    taken: Vec3,
    /// By which channels are drawn, over what all of them lose.
    shares: Vec3,
}

impl Distances {
    /// The distance of a number from 0 to 1.
    pub fn sample(&self, u: f32) -> Option<f32> {
        let (channel, u) = chosen(self.shares * self.taken, u);
        let t = -(-u * self.taken[channel]).ln_1p() / self.extinction[channel];
        t.is_finite().then(|| t.min(self.end))
    }

    /// Density of a distance at which so much of the light is left, 1/m.
    pub fn density(&self, left: Vec3) -> f32 {
        self.shares.dot(self.extinction * left)
    }
}

/// The channel that a number chooses by shares, and the number stretched for what follows.
fn chosen(shares: Vec3, u: f32) -> (usize, f32) {
    let (channel, low) = match u {
        u if u < shares.x => (0, 0.0),
        u if u < shares.x + shares.y || shares.z <= 0.0 => (1, shares.x),
        _ => (2, shares.x + shares.y),
    };
    let u = (u - low) / shares[channel];
    (channel, u.clamp(0.0, 1.0 - f32::EPSILON / 2.0))
}

#[cfg(test)]
#[path = "../../tests/unit/medium/mod.rs"]
mod tests;
