//! Color Ramp and curves: tables, as Cycles reads them.

use glam::Vec4;
use std::ops::{Add, Mul, Sub};

/// Numbers along a line from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// At equal distances, the first at 0 and the last at 1.
    pub entries: Vec<Vec4>,
    /// Between entries lies a line; otherwise the entry before counts.
    pub interpolate: bool,
    /// Beyond the ends goes the line of the last two; otherwise the ends count.
    pub extrapolate: bool,
}

impl Table {
    /// The value at a place.
    #[inline]
    pub fn at(&self, place: f32) -> Vec4 {
        self.part_at(place, |entry| *entry)
    }

    /// A part of the value at a place: nothing else of the entries is read.
    #[inline]
    fn part_at<T>(&self, place: f32, part: impl Fn(&Vec4) -> T) -> T
    where
        T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
    {
        let entry = |number: usize| part(&self.entries[number]);
        let Some(last) = self.entries.len().checked_sub(1) else {
            return part(&Vec4::ZERO);
        };
        if self.extrapolate && last > 0 && !(0.0..=1.0).contains(&place) {
            let (end, inner, beyond) = if place < 0.0 {
                (entry(0), entry(1), -place)
            } else {
                (entry(last), entry(last - 1), place - 1.0)
            };
            return end + (end - inner) * (beyond * last as f32);
        }
        let along = place.clamp(0.0, 1.0) * last as f32;
        // What is not a number goes on, to be counted.
        if along.is_nan() {
            return part(&Vec4::NAN);
        }
        let before = (along as usize).min(last);
        let t = along - before as f32;
        if !self.interpolate || t == 0.0 {
            return entry(before);
        }
        entry(before) * (1.0 - t) + entry((before + 1).min(last)) * t
    }
}

/// A curve for each of three numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// The curves.
    pub table: Table,
    /// Where they begin.
    pub least: f32,
    /// Where they end.
    pub most: f32,
}

impl Curves {
    /// Each number by its own curve.
    #[inline]
    pub fn of(&self, v: glam::Vec3) -> glam::Vec3 {
        let range = self.most - self.least;
        let at = |lane: usize| {
            let place = super::math::divided(v[lane] - self.least, range);
            self.table.part_at(place, |entry| entry[lane])
        };
        glam::Vec3::new(at(0), at(1), at(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_between_and_beyond_their_entries() {
        let mut table = Table {
            entries: [0.0, 1.0, 4.0].map(Vec4::splat).to_vec(),
            interpolate: true,
            extrapolate: false,
        };
        assert_eq!([0.25, 0.75, 2.0].map(|x| table.at(x).x), [0.5, 2.5, 4.0]);
        table.interpolate = false;
        assert_eq!([0.25, 0.75, 1.0].map(|x| table.at(x).x), [0.0, 1.0, 4.0]);
        table.extrapolate = true;
        assert_eq!([-0.5, 1.5].map(|x| table.at(x).x), [-1.0, 7.0]);
        assert!(table.at(f32::NAN).x.is_nan());
        table.entries.clear();
        assert_eq!(table.at(0.5), Vec4::ZERO);
    }

    #[test]
    fn one_number_is_that_of_the_whole_value_to_the_bit() {
        for (interpolate, extrapolate) in [(true, true), (true, false), (false, true)] {
            let entry = |i: i16| Vec4::new(0.1, 0.7, -1.3, 2.9) * f32::from(i * i) + 0.3;
            let mut table = Table {
                entries: (0..7).map(entry).collect(),
                interpolate,
                extrapolate,
            };
            let places = (-30..60i16).map(|i| f32::from(i) * 0.031);
            for place in places.chain([-0.0, 0.5, 1.0, f32::NAN, f32::INFINITY]) {
                for lane in 0..4 {
                    let whole = table.at(place)[lane].to_bits();
                    assert_eq!(
                        table.part_at(place, |v| v[lane]).to_bits(),
                        whole,
                        "{place}"
                    );
                }
            }
            table.entries.clear();
            assert_eq!(table.part_at(0.5, |v| v[2]), 0.0);
        }
    }
}
