//! Sums whose value does not depend on the order of what is added: a picture that is rendered in parts
//! has the bits of one that is rendered at once.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// A sum of colours in twice the precision of f64.
///
/// What f64 rounds off a sum is itself a f64 (Møller 1965, Knuth 1969, TwoSum) and is summed apart: the
/// total is exact but for n² · 2^-106 of the sum of magnitudes (Ogita, Rump and Oishi, *Accurate Sum and Dot
/// Product*, 2005, Prop. 4.5). It is rounded once, to f32, at the end; that two orders of the same 2^24
/// values round differently takes a value within 2^-58 of the middle between two f32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ColorSum {
    sum: DVec3,
    rest: DVec3,
}

impl ColorSum {
    /// Adds a finite colour.
    #[inline]
    pub fn add(&mut self, value: Vec3) {
        self.add_f64(value.as_dvec3());
    }

    /// Adds another sum.
    pub fn join(&mut self, other: &Self) {
        self.add_f64(other.sum);
        self.rest += other.rest;
    }

    #[inline]
    fn add_f64(&mut self, value: DVec3) {
        let sum = self.sum + value;
        let came = sum - self.sum;
        self.rest += (self.sum - (sum - came)) + (value - came);
        self.sum = sum;
    }

    /// The total.
    #[inline]
    pub fn total(&self) -> DVec3 {
        self.sum + self.rest
    }
}

/// A sum of vectors with components of moderate size (normals, albedos) in fixed point: each is cut to
/// multiples of 2^-32, and sums of these up to 2^31 are exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct FixedSum([i64; 3]);

/// One, in fixed point.
const ONE: f32 = 4_294_967_296.0;

impl FixedSum {
    /// Adds a vector.
    #[inline]
    pub fn add(&mut self, value: Vec3) {
        // The product is exact, and the conversion saturates.
        for (sum, v) in self.0.iter_mut().zip((value * ONE).to_array()) {
            *sum = sum.saturating_add(v as i64);
        }
    }

    /// Adds another sum.
    pub fn join(&mut self, other: &Self) {
        for (sum, v) in self.0.iter_mut().zip(other.0) {
            *sum = sum.saturating_add(v);
        }
    }

    /// The total.
    #[inline]
    pub fn total(&self) -> DVec3 {
        DVec3::from(self.0.map(|v| v as f64)) / f64::from(ONE)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/film/sum.rs"]
mod tests;
