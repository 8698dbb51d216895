//! Owen-scrambled Sobol points with named dimensions.
//!
//! Every random decision of a path has a name ([`Dimension`]) and the index of its bounce; its
//! numbers depend on the pixel, the sample index, the name and the seed alone: not on the order
//! of calls, so that kernels with more or fewer effects draw the same numbers, nor on threads or
//! tiles.
//!
//! Each named pair of numbers is its own two-dimensional Sobol (0,2)-sequence, made independent
//! of the others by Owen scrambling and shuffling ("padding": Burley, *Practical Hash-based Owen
//! Scrambling*, JCGT 9(4), 2020, §5). A choice with a place behind it (a lobe and a direction, a
//! light and a point on it) is a triple of one sequence: so the samples that fall to one of the
//! choices are still spread evenly over its places, which a choice by another sequence would make
//! a random subset of. One sequence serves the whole picture: each pixel takes a block of 2^32 of it,
//! shuffled digit by digit.
//!
//! The samples of a pixel are dealt in turn to [`REPLICATES`] sequences that are randomised
//! independently of each other. Each gives an unbiased mean of its own, and only because these are
//! independent does their spread tell the error of their mean without bias (randomised quasi-Monte
//! Carlo: Owen, *Monte Carlo theory, methods and examples*, 2013, §17.1 and 17.5; L'Ecuyer and
//! Lemieux, *Recent Advances in Randomized Quasi-Monte Carlo Methods*, 2002, §2): parts of one
//! sequence would not do, for their errors partly cancel.
//!
//! With [`Sequences::One`] they are all of one sequence, whose points are spread more evenly. The two halves of the samples by
//! which the error is told are then parts of it, and it is told too large: what cancels in the mean adds up in their difference.
//! They are halves by the points on lights ([`Sampler::is_in_half`]), so that this is little where light comes from lamps.
//! Pixels take blocks as long as their samples are planned to be, in Morton's order, so that those of neighbours are spread
//! evenly together: their errors are of opposite signs rather than alike, which eyes and denoisers see less of (Ahmed and
//! Wonka, *Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels*, 2020).
//!
//! Nothing depends on how many samples there will be, but for what is planned: a render can be continued or joined from parts,
//! and has the bits of one that was asked for them all at once.

mod lanes;

use glam::{Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// Tells the numbers behind surfaces that a path has passed from those before them.
const BEHIND: u32 = 0x_71d7_ed00;

/// The random decisions of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Dimension {
    /// Place in the pixel's filter (once a path).
    Filter,
    /// Place on the lens (once a path).
    Lens,
    /// Direction within a lobe of the BSDF (x, y); which lobe, and whether it is reflected or
    /// refracted (z).
    Bsdf,
    /// Where on a light (x, y); which light (z).
    Light,
    /// Russian roulette.
    Roulette,
    /// Opacity of surfaces on the way (hashed further by what is hit), and rays of node trees.
    Opacity,
    /// When the shutter lets the path through (once a path). Its numbers are those that the first dimension has not at the second
    /// bounce, so that it changes no other number.
    Time,
}

/// How many dimensions a bounce has.
const DIMENSIONS: u32 = 6;

/// Independent sequences of each pixel: sample i belongs to number i mod 2. Two: with more, each has
/// fewer points to spread evenly (two cost 0 to 10 % in variance on the project's scenes, eight 8 to 18 %),
/// and a picture has pixels enough to make up for one degree of freedom each.
pub const REPLICATES: u32 = 2;

/// How many sequences the samples of a pixel are dealt to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sequences {
    /// [`REPLICATES`]: the error is told without bias.
    #[default]
    Two,
    /// One: less noise where light is smooth, and the error is told too large.
    One {
        /// So many samples of each pixel are spread evenly with those of its neighbours; `None`: each pixel for itself.
        planned: Option<u32>,
    },
}

impl Sequences {
    /// Whether it is the usual number.
    pub fn are_two(&self) -> bool {
        *self == Self::Two
    }

    /// The same, planned for so many samples where nothing else is said.
    #[must_use]
    pub fn planned_for(self, samples: u32) -> Self {
        match self {
            Self::One { planned: None } => Self::One {
                planned: Some(samples),
            },
            _ => self,
        }
    }

    fn count(self) -> u32 {
        match self {
            Self::Two => REPLICATES,
            Self::One { .. } => 1,
        }
    }
}

/// The numbers of one path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    index: u64,
    /// Its digits, least significant first: all sequences begin with them.
    reversed: u64,
    seed: u32,
    /// Its pixel, by Morton's order.
    pixel: u32,
}

/// Constants of the picture that all its samplers share.
#[derive(Clone, Copy, Debug)]
pub struct Sequence {
    /// Of each replicate.
    seeds: [u32; REPLICATES as usize],
    sequences: Sequences,
    /// Each pixel's block has 2 to the power of this many points.
    block: u32,
}

impl Sequence {
    /// Each `seed` gives an independent randomisation.
    pub fn new(seed: u32) -> Self {
        Self::of(seed, Sequences::Two)
    }

    /// The same of one or two sequences a pixel.
    pub fn of(seed: u32, sequences: Sequences) -> Self {
        let base = mix32(seed ^ 0x9e37_79b9);
        Self {
            seeds: std::array::from_fn(|replicate| {
                mix32(base.wrapping_add((replicate as u32).wrapping_mul(0xb529_7a4d)))
            }),
            sequences,
            block: match sequences {
                Sequences::One {
                    planned: Some(planned),
                } => 32 - planned.saturating_sub(1).leading_zeros(),
                _ => 32,
            },
        }
    }

    /// How many sequences each pixel has.
    #[inline]
    pub fn sequences(&self) -> Sequences {
        self.sequences
    }

    /// Whether a sample is of the second half of a pixel's samples, by the difference of which from the first the error is told.
    ///
    /// Of one sequence it is that of [`Sampler::is_in_half`], so that both differ by little more than they must.
    #[inline]
    pub fn is_second(&self, x: u32, y: u32, sample: u32) -> bool {
        match self.sequences {
            Sequences::Two => sample % REPLICATES == 1,
            Sequences::One { .. } => self.sampler(x, y, sample).is_in_half(),
        }
    }

    /// The numbers of one sample of one pixel; coordinates below 2^16.
    pub fn sampler(&self, x: u32, y: u32, sample: u32) -> Sampler {
        let morton = spread(x) | (spread(y) << 1);
        let count = self.sequences.count();
        // One or two: a division by a number that the compiler does not know takes as long as a hash.
        let number = u64::from(sample >> count.trailing_zeros());
        // What is beyond the block is in that of the same pixel in the next picture.
        let (beyond, within) = (number >> self.block, number & ((1 << self.block) - 1));
        let index = (beyond << self.block) << 32 | (morton << self.block) | within;
        Sampler {
            index,
            reversed: index.reverse_bits(),
            seed: self.seeds[(sample & (count - 1)) as usize],
            pixel: morton as u32,
        }
    }
}

impl Sampler {
    /// Two numbers in [0, 1).
    pub fn pair(&self, dimension: Dimension, bounce: u32) -> Vec2 {
        let key = self.sequence_key(dimension, bounce);
        let shuffled = self.shuffled(key);
        coordinates(key, [shuffled as u32, pascal(shuffled) as u32, 0, 0])
            .truncate()
            .truncate()
    }

    /// Three numbers in [0, 1): those of [`pair`](Self::pair), and a third of the same sequence. The
    /// three together are a (1,3)-sequence.
    pub fn triple(&self, dimension: Dimension, bounce: u32) -> Vec3 {
        self.point(dimension, bounce, |_| 0).truncate()
    }

    /// Four numbers in [0, 1): those of [`triple`](Self::triple), and a fifth coordinate of the same sequence: its fourth tells
    /// halves ([`is_in_half`](Self::is_in_half)).
    pub fn quadruple(&self, dimension: Dimension, bounce: u32) -> Vec4 {
        self.point(dimension, bounce, |index| multiplied(&FIFTH, index))
    }

    /// The first three coordinates of a point, and the one of which an index' digits are given.
    #[inline(always)]
    fn point(&self, dimension: Dimension, bounce: u32, last: impl Fn(u64) -> u32) -> Vec4 {
        let key = self.sequence_key(dimension, bounce);
        let shuffled = self.shuffled(key);
        let digits = [
            shuffled as u32,
            pascal(shuffled) as u32,
            multiplied(&THIRD, shuffled),
            last(shuffled),
        ];
        coordinates(key, digits)
    }

    /// As [`triple`](Self::triple), for a choice at a surface behind so many others that the path has passed since its last bounce:
    /// independent of the choices at these.
    pub fn triple_behind(&self, dimension: Dimension, bounce: u32, passed: u32) -> Vec3 {
        match passed {
            0 => self.triple(dimension, bounce),
            _ => {
                let behind = self.beside(BEHIND.wrapping_add(passed));
                behind.triple(dimension, bounce)
            }
        }
    }

    /// Whether a sample is in the half of its sequence by which Cycles' noise threshold judges.
    ///
    /// Of each two samples one is, by the fourth coordinate of the points that choose lights at the first surface: it is below
    /// 1/2 or not. So the lights of each half are spread nearly as evenly as those of all. Any fixed choice of samples, as
    /// by Christensen, Kensler and Kilpatrick (*Progressive Multi-Jittered Sample Sequences*, 2018, section 10.2.1), is a
    /// random half of the points, as their order is shuffled; and random halves differ by several times the error.
    #[inline]
    pub fn is_in_half(&self) -> bool {
        let point = self.shuffled(self.sequence_key(Dimension::Light, 0));
        (point as u32 & FOURTH).count_ones() % 2 == 1
    }

    /// The numbers of one of `parts` samples that take the place of this one: together the parts of all
    /// samples are the first `parts` times as many points of the same sequences.
    pub fn part(&self, part: u32, parts: u32) -> Self {
        // What is lost beyond 64 bits are digits of coordinates from 2^16 / √parts on.
        let index = self
            .index
            .wrapping_mul(u64::from(parts))
            .wrapping_add(u64::from(part));
        Self {
            index,
            reversed: index.reverse_bits(),
            ..*self
        }
    }

    /// The same path with sequences that its pixel has for itself: for what is not linear in its numbers, so that all pixels
    /// do not err alike.
    pub fn of_pixel(&self) -> Self {
        self.beside(self.pixel)
    }

    /// The same path with other sequences: for decisions that it takes beside those that have names.
    pub fn beside(&self, what: u32) -> Self {
        Self {
            seed: mix32(self.seed ^ mix32(what)),
            ..*self
        }
    }

    /// What makes a named sequence independent of the others.
    fn sequence_key(&self, dimension: Dimension, bounce: u32) -> u32 {
        mix32(
            self.seed
                .wrapping_add((bounce * DIMENSIONS + dimension as u32).wrapping_mul(0x9e37_79b1)),
        )
    }

    /// The index in the order of the sequence of this key.
    fn shuffled(&self, key: u32) -> u64 {
        owen_64(
            self.reversed,
            u64::from(mix32(key)) << 32 | u64::from(mix32(!key)),
        )
        .reverse_bits()
    }

    /// One number in [0, 1).
    pub fn single(&self, dimension: Dimension, bounce: u32) -> f32 {
        let key = self.sequence_key(dimension, bounce);
        coordinates(key, [self.shuffled(key) as u32, 0, 0, 0]).x
    }

    /// A number in [0, 1) for a decision about something, which is told apart by two words: each has a sequence of its own, so
    /// that a pixel's samples spread their decisions about the same thing evenly.
    pub fn about(&self, dimension: Dimension, bounce: u32, (a, b): (u32, u32)) -> f32 {
        let key = joined(self.sequence_key(dimension, bounce), a, b);
        coordinates(key, [self.shuffled(key) as u32, 0, 0, 0]).x
    }

    /// A key for decisions that a path takes an unknown number of times between two bounces, and that no two samples share:
    /// to be hashed with what is hit.
    ///
    /// A call, as few rays need it: where it is inlined, a part of it is calculated for all.
    #[inline(never)]
    pub fn key(&self, dimension: Dimension, bounce: u32) -> u32 {
        let low = mix32(self.index as u32 ^ self.seed);
        let high = mix32((self.index >> 32) as u32 ^ low);
        mix32(high ^ (bounce * DIMENSIONS + dimension as u32).wrapping_mul(0x9e37_79b1))
    }
}

/// A number in [0, 1) from a key and what was hit.
pub fn hashed(key: u32, a: u32, b: u32) -> f32 {
    unit(joined(key, a, b))
}

/// A key from a key and what was hit.
fn joined(key: u32, a: u32, b: u32) -> u32 {
    mix32(mix32(key ^ a.wrapping_mul(0x85eb_ca6b)) ^ b.wrapping_mul(0xc2b2_ae35))
}

/// 24 bits of a word as a float: of 24 digits too, so that it is at most [`ONE_MINUS_EPSILON`].
///
/// [`ONE_MINUS_EPSILON`]: crate::math::float::ONE_MINUS_EPSILON
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A point's coordinates, of the digits in reverse order that Sobol's matrices give: each scrambled for itself.
#[inline(always)]
fn coordinates(key: u32, digits: [u32; 4]) -> Vec4 {
    let keys = [0x5851_f42d, 0x1405_7b7e, 0x3c6e_f372, 0x2545_f491].map(|way| key ^ way);
    let seeds = lanes::mix32(lanes::Words::new(keys));
    lanes::units(lanes::owen_32(lanes::Words::new(digits), seeds))
}

/// A bijective integer hash with full avalanche (the two-round multiply-xorshift construction,
/// constants found by exhaustive search: Wellons, *Prospecting for Hash Functions*, 2018).
fn mix32(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Spreads the low 32 bits of `x` to the even bits.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    x = (x | (x << 16)) & 0x0000_ffff_0000_ffff;
    x = (x | (x << 8)) & 0x00ff_00ff_00ff_00ff;
    x = (x | (x << 4)) & 0x0f0f_0f0f_0f0f_0f0f;
    x = (x | (x << 2)) & 0x3333_3333_3333_3333;
    (x | (x << 1)) & 0x5555_5555_5555_5555
}

/// The second generator matrix of Sobol's sequence, Pascal's triangle modulo 2, applied to the
/// digits of an index: digit k of the result is the sum of all digits j with C(j, k) odd, which
/// by Lucas' theorem are the j that contain the bits of k. Summing over supersets takes one step
/// a bit of the position.
fn pascal(mut x: u64) -> u64 {
    x ^= (x >> 1) & 0x5555_5555_5555_5555;
    x ^= (x >> 2) & 0x3333_3333_3333_3333;
    x ^= (x >> 4) & 0x0f0f_0f0f_0f0f_0f0f;
    x ^= (x >> 8) & 0x00ff_00ff_00ff_00ff;
    x ^= (x >> 16) & 0x0000_ffff_0000_ffff;
    x ^ ((x >> 32) & 0x0000_0000_ffff_ffff)
}

/// The numbers mₖ of a coordinate of Sobol's sequence, by its primitive polynomial and the first of them. Bit i - 1 of `terms` is the
/// coefficient of the power that is i below the highest (Joe and Kuo, *Constructing Sobol sequences with better
/// two-dimensional projections*, 2008, eq. 2).
const fn numbers(terms: u32, first: &[u64]) -> [u64; 64] {
    let degree = first.len();
    let mut m = [0u64; 64];
    let mut k = 0;
    while k < 64 {
        if k < degree {
            m[k] = first[k];
        } else {
            m[k] = m[k - degree];
            let mut i = 1;
            while i <= degree {
                if terms >> (i - 1) & 1 == 1 {
                    m[k] ^= m[k - i] << i;
                }
                i += 1;
            }
        }
        k += 1;
    }
    m
}

/// What each byte of an index adds to a coordinate of Sobol's sequence, most significant digit in the lowest bit.
type Matrix = [[u32; 256]; 8];

/// The third coordinate: primitive polynomial x² + x + 1 with m₁ = 1, m₂ = 3 (Joe and Kuo, eq. 2 and table).
static THIRD: Matrix = matrix(&numbers(0b11, &[1, 3]));

/// The fifth: x³ + x² + 1 with 1, 1, 1.
static FIFTH: Matrix = matrix(&numbers(0b101, &[1, 1, 1]));

const fn matrix(m: &[u64; 64]) -> Matrix {
    let mut table = [[0; 256]; 8];
    let mut entry = 0;
    while entry < 8 * 256 {
        let (byte, value) = (entry / 256, entry % 256);
        let mut bit = 0;
        while bit < 8 {
            if value >> bit & 1 == 1 {
                // mₖ has k digits (k counts from 1), the first of them its highest bit.
                let k = 8 * byte + bit;
                table[byte][value] ^= (m[k] << (63 - k)).reverse_bits() as u32;
            }
            bit += 1;
        }
        entry += 1;
    }
    table
}

/// A generator matrix of Sobol's sequence applied to the digits of an index.
fn multiplied(matrix: &Matrix, index: u64) -> u32 {
    index
        .to_le_bytes()
        .iter()
        .zip(matrix)
        .fold(0, |sum, (&byte, table)| sum ^ table[byte as usize])
}

/// Which digits of an index add to the first digit of the fourth coordinate of Sobol's sequence: primitive polynomial x³ + x + 1
/// with m₁ = 1, m₂ = 3, m₃ = 1 (Joe and Kuo, as for [`THIRD`]).
const FOURTH: u32 = {
    let m = numbers(0b110, &[1, 3, 1]);
    let mut digits = 0;
    let mut k = 0;
    while k < 32 {
        digits |= ((m[k] >> k & 1) as u32) << k;
        k += 1;
    }
    digits
};

/// Owen scrambling of a number of 64 digits, which stand in reverse order (least significant first): each step changes a bit only
/// by the bits below it (Laine and Karras, *Stratified Sampling for Stochastic Transparency*, 2011; constants after Vegdahl,
/// *Building a Better LK Hash*, 2021). The even multipliers are random.
fn owen_64(mut x: u64, seed: u64) -> u64 {
    x ^= x.wrapping_mul(0x3d20_adea_8a2f_6e14);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 32) | 1);
    x ^= x.wrapping_mul(0x0552_6c56_d1b5_4a32);
    x ^ x.wrapping_mul(0x53a2_2864_9c6e_3d7a)
}

#[cfg(test)]
#[path = "../../tests/unit/sampler/mod.rs"]
mod tests;
