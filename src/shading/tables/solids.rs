//! Tables of transmitting solids whose index of refraction varies over them.

use super::{Estimate, LutCoordinate, Rows, Solid};
use crate::shading::fresnel;
use glam::Vec3;

/// The indices of refraction of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Indices {
    /// The same everywhere.
    One(f32),
    /// Any between two.
    Between(f32, f32),
}

impl Indices {
    /// Bits that tell them from others.
    pub fn bits(self) -> [u32; 2] {
        match self {
            Self::One(ior) => [ior.to_bits(); 2],
            Self::Between(least, greatest) => [least.to_bits(), greatest.to_bits()],
        }
    }
}

/// Tables of indices that are this far apart at most, in [`spread`]: the albedo between them is off by 1.1 % at most, near 1.
const STEP: f32 = 0.12;

/// Above these no solid differs much from them.
const GREATEST: f32 = 4.0;

/// Tables of a solid, by index.
#[derive(Debug)]
pub struct Solids {
    /// Where several, those of indices above 1, from the least on.
    tables: Vec<Solid>,
    /// The places of the first and of the last in [`spread`].
    ends: [f32; 2],
}

/// Indices from 1 on, or their reciprocals, from 0 to 1: the root of the amplitude that is reflected at normal incidence, in which
/// albedos change evenly.
fn spread(ior: f32) -> f32 {
    ((ior - 1.0) / (ior + 1.0)).abs().sqrt()
}

fn index_at(spread: f32) -> f32 {
    let amplitude = spread * spread;
    (1.0 + amplitude) / (1.0 - amplitude)
}

impl Solids {
    /// Tabulates for some indices of refraction.
    pub fn new(indices: Indices, rows: Rows, estimate: Estimate) -> Self {
        let table = |ior| Solid::new(ior, rows, estimate);
        let (least, greatest) = match indices {
            Indices::One(ior) => {
                return Self {
                    tables: vec![table(fresnel::bounded_ior(ior))],
                    ends: [0.0; 2],
                };
            }
            Indices::Between(least, greatest) => (least, greatest),
        };
        // What is below 1 is seen from the other side.
        let [a, b] = [least, greatest].map(|ior| spread(ior.clamp(1.0 / GREATEST, GREATEST)));
        let from = if least < 1.0 && greatest > 1.0 {
            0.0
        } else {
            a.min(b)
        };
        let to = a.max(b).max(from + STEP);
        let steps = ((to - from) / STEP).ceil() as usize;
        let at = |step: usize| from + (to - from) * (step as f32 / steps as f32);
        Self {
            tables: (0..=steps).map(|step| table(index_at(at(step)))).collect(),
            ends: [from, to],
        }
    }

    /// [`Solid::compensation`] of an index of refraction.
    #[inline]
    pub fn compensation(
        &self,
        place: LutCoordinate,
        (ior, inside): (f32, bool),
        tint: Vec3,
    ) -> Vec3 {
        match &self.tables[..] {
            [only] => only.compensation(place, inside, tint),
            tables => self.between(tables, place, (ior, inside), tint),
        }
    }

    #[cold]
    fn between(
        &self,
        tables: &[Solid],
        place: LutCoordinate,
        (ior, inside): (f32, bool),
        tint: Vec3,
    ) -> Vec3 {
        let inside = inside != (ior < 1.0);
        let [from, to] = self.ends;
        let last = tables.len() - 1;
        let along = ((spread(ior) - from) / (to - from)).clamp(0.0, 1.0) * last as f32;
        let first = (along as usize).min(last - 1);
        let [a, b] = [first, first + 1].map(|i| tables[i].compensation(place, inside, tint));
        a.lerp(b, along - first as f32)
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/shading/tables/solids.rs"]
mod tests;
