//! What was seen twice among millions, in two bits each.

use std::sync::atomic::{AtomicU64, Ordering};

/// Hashes that were seen once and twice, as Bloom's filter with one function has them: some are told to be that were not.
/// Threads may add to it side by side: which is first changes nothing.
pub(super) struct Seen {
    once: Vec<AtomicU64>,
    twice: Vec<AtomicU64>,
}

impl Seen {
    /// For so many hashes.
    pub fn new(count: usize) -> Self {
        let words = (count / 4).next_power_of_two();
        let empty = || (0..words).map(|_| AtomicU64::new(0)).collect();
        Self {
            once: empty(),
            twice: empty(),
        }
    }

    fn place(&self, hash: u64) -> (usize, u64) {
        let word = (hash >> 6) as usize & (self.once.len() - 1);
        (word, 1 << (hash & 63))
    }

    pub fn add(&self, hash: u64) {
        let (word, bit) = self.place(hash);
        if self.once[word].fetch_or(bit, Ordering::Relaxed) & bit != 0 {
            self.twice[word].fetch_or(bit, Ordering::Relaxed);
        }
    }

    /// Whether a hash was added twice, or one that looks like it.
    pub fn was_twice(&self, hash: u64) -> bool {
        let (word, bit) = self.place(hash);
        self.twice[word].load(Ordering::Relaxed) & bit != 0
    }
}

/// Mixes the bits of a word (Steele, Lea and Flood, *Fast Splittable Pseudorandom Number Generators*, 2014).
pub(super) fn mixed(mut word: u64) -> u64 {
    word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

#[cfg(test)]
#[path = "../../../tests/unit/scene/coincident/seen.rs"]
mod tests;
