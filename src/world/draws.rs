//! Random numbers on ways through media.

use crate::sampler::hashed;

/// Numbers for the collisions on one way.
pub struct Draws {
    key: u32,
    way: u32,
    count: u32,
    first: Option<f32>,
}

impl Draws {
    /// Of a key, for one of its ways.
    pub fn new(key: u32, way: u32) -> Self {
        Self::beginning(key, way, None)
    }

    /// The same, with a first number that is given.
    pub fn beginning(key: u32, way: u32, first: Option<f32>) -> Self {
        Self {
            key,
            way,
            count: 0,
            first,
        }
    }

    /// The next one.
    pub fn draw(&mut self) -> f32 {
        if let Some(first) = self.first.take() {
            return first;
        }
        self.count += 1;
        hashed(self.key, self.way, self.count)
    }
}
