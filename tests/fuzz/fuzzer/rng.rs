//! Random numbers for inputs, and numbers at the edges.

use serde_json::{Value, json};

/// A stream of random numbers (SplitMix64: Steele, Lea and Flood, *Fast Splittable Pseudorandom Number Generators*,
/// 2014).
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count.max(1) as u64) as usize
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// An ordinary number, or now and then one at the edge.
    fn edged(&mut self, from: f64, to: f64, edges: &[f64]) -> Value {
        self.edged_by(1000.0, from, to, edges)
    }

    /// The same, ordinary numbers in steps of 1 over `steps`: what is kept is read by people, and what asks for tables
    /// must not ask for others each time.
    fn edged_by(&mut self, steps: f64, from: f64, to: f64, edges: &[f64]) -> Value {
        let ordinary = (self.between(from, to) * steps).round() / steps;
        json!(if self.chance(0.3) {
            self.pick(edges)
        } else {
            ordinary
        })
    }

    /// A share.
    pub fn share(&mut self) -> Value {
        self.edged(0.0, 1.0, &[0.0, 1.0, 1e-7, 1.0 - 6e-8, 1e-20, 1e-45])
    }

    pub fn specular(&mut self) -> Value {
        self.edged_by(2.0, 0.0, 2.0, &[0.0, 1.0, 1e-7, 1e-20])
    }

    pub fn color(&mut self) -> Value {
        if self.chance(0.3) {
            json!([1, 1, 1])
        } else {
            json!([self.share(), self.share(), self.share()])
        }
    }

    /// A length, of what is about 1.
    pub fn size(&mut self) -> Value {
        self.edged(0.1, 1.5, &[1e-6, 1e-3, 1.0, 1e3, 1e6])
    }

    /// The strength of a light.
    pub fn strength(&mut self) -> Value {
        self.edged(0.1, 20.0, &[0.0, 1e-10, 1e-3, 1.0, 1e6])
    }

    pub fn ior(&mut self) -> Value {
        self.edged_by(
            5.0,
            1.0,
            2.6,
            &[
                0.0,
                0.5,
                1.0,
                1.0 - 1e-7,
                1.0 + 1.2e-7,
                1.0001,
                1000.0,
                1e30,
            ],
        )
    }

    /// A place near the middle.
    pub fn place(&mut self) -> Value {
        let mut at = || self.edged(-1.5, 1.5, &[0.0, 1e-6, 1.0, -1.0]);
        json!([at(), at(), at()])
    }

    /// Angles in degrees.
    pub fn turn(&mut self) -> Value {
        let mut at = || self.edged(0.0, 360.0, &[0.0, 90.0, 180.0, 1e-5]);
        json!([at(), at(), at()])
    }

    pub fn angle(&mut self, most: f64) -> Value {
        self.edged(0.0, most, &[0.0, 1e-6, 1e-3, most, 0.999_999 * most])
    }
}
