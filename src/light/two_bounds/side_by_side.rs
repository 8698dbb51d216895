//! The same as [`super::bounds`] of up to eight clusters side by side: each operation in the same order, so that the bits are the same.

use super::Receiver;
use super::bounds::{Bounds, Cone, Measure};
use crate::light::estimate::MOST;
use crate::light::lanes::{LANES, Lanes, Lanes3, sin_from_cos};
use std::f32::consts::PI;
use wide::{CmpEq, CmpGe, CmpGt, CmpLe, CmpLt};

/// Directions in which each shines.
#[derive(Clone, Copy, Debug)]
struct Cones {
    axis: Lanes3,
    sin: Lanes,
    cos: Lanes,
    cos_all: Lanes,
    cos_beyond: Lanes,
}

impl Cones {
    #[inline]
    fn of(cones: [&Cone; LANES]) -> Self {
        let lanes = |of: fn(&Cone) -> f32| Lanes::from(cones.map(of));
        Self {
            axis: Lanes3::of(cones.map(|cone| cone.axis)),
            sin: lanes(|cone| cone.sin),
            cos: lanes(|cone| cone.cos),
            // All cosines are above that of a cone of all directions.
            cos_all: lanes(|cone| {
                if cone.normals + cone.emission > PI {
                    f32::NEG_INFINITY
                } else {
                    cone.cos_all
                }
            }),
            cos_beyond: lanes(|cone| cone.cos_beyond),
        }
    }
}

/// How each is seen from a place.
struct Seen {
    toward: Lanes3,
    cos: Lanes,
    distance: Lanes,
    /// Where nothing comes from.
    hidden: Lanes,
}

impl Seen {
    /// As `bounds::Seen::bounds`.
    #[inline]
    fn bounds(&self, cones: &Cones, energy: Lanes, at: &Receiver) -> [Bounds; LANES] {
        let (cos_u, sin_u) = (self.cos, sin_from_cos(self.cos));
        let mut hidden = self.hidden;
        let (mut received, mut received_least) = (Lanes::ONE, Lanes::ONE);
        if let Some(normal) = at.normal {
            let cos = Lanes3::splat(normal).dot(&self.toward);
            let cos = if at.both { cos.abs() } else { cos };
            let sin = sin_from_cos(cos);
            let aslant = cos * cos_u + sin * sin_u;
            received = cos.cmp_lt(cos_u).blend(aslant, Lanes::ONE);
            if !at.both {
                hidden |= received.cmp_lt(Lanes::ZERO);
            }
            received_least = (cos * cos_u - sin * sin_u).fast_max(Lanes::ZERO);
        }
        let [x, y, z] = cones.axis.0;
        let [tx, ty, tz] = self.toward.0.map(|t| -t);
        let is_axis = x.cmp_eq(tx) & y.cmp_eq(ty) & z.cmp_eq(tz);
        let along = cones.axis.dot(&Lanes3([tx, ty, tz]));
        let cos = is_axis.blend(Lanes::ONE, along);
        let sin = sin_from_cos(cos);
        let minus = cos * cos_u + sin * sin_u;
        let inside = cos.cmp_ge(cos_u) | minus.cmp_ge(cones.cos);
        let aslant = minus * cones.cos + sin_from_cos(minus) * cones.sin;
        let emitted = inside.blend(Lanes::ONE, aslant);
        hidden |= !(inside | minus.cmp_gt(cones.cos_all));
        let most = (received * energy * emitted / (self.distance * self.distance)).abs();
        let most = most.fast_min(Lanes::splat(MOST));
        let plus = cos * cos_u - sin * sin_u;
        let none_at_least =
            cos.cmp_lt(Lanes::ZERO) | cos_u.cmp_lt(Lanes::ZERO) | plus.cmp_lt(cones.cos_beyond);
        let emitted_least = plus * cones.cos - sin_from_cos(plus) * cones.sin;
        let least = received_least * energy * emitted_least / (self.distance * self.distance);
        let least = least.abs().fast_min(Lanes::splat(MOST));
        let most = hidden.blend(Lanes::ZERO, most).to_array();
        let least = (hidden | none_at_least)
            .blend(Lanes::ZERO, least)
            .to_array();
        std::array::from_fn(|lane| (most[lane], least[lane]))
    }
}

/// What clusters give to a place, none of them at infinity: as [`Measure::bounds`].
#[inline]
pub fn of_clusters(clusters: [(&Measure, &Cone); LANES], at: &Receiver) -> [Bounds; LANES] {
    let measures = clusters.map(|(measure, _)| measure);
    let half = Lanes::splat(0.5);
    let low = Lanes3::of(measures.map(|m| m.min));
    let high = Lanes3::of(measures.map(|m| m.max));
    let center = Lanes3([0, 1, 2].map(|axis| half * (low.0[axis] + high.0[axis])));
    let extent = high.minus(&center);
    let to = center.minus(&Lanes3::splat(at.point));
    let mut hidden = Lanes::ZERO;
    if let Some(normal) = at.normal
        && !at.both
    {
        let across = Lanes3::splat(normal.abs()).dot(&Lanes3(extent.0.map(Lanes::abs)));
        hidden = (Lanes3::splat(normal).dot(&to) + across).cmp_le(Lanes::ZERO);
    }
    let (d2, r2) = (to.dot(&to), extent.dot(&extent));
    let distance = d2.sqrt();
    let per_length = Lanes::ONE / distance;
    // As glam's `normalize_or_zero`: nothing where there is no length.
    let has_length =
        per_length.cmp_gt(Lanes::ZERO) & per_length.cmp_lt(Lanes::splat(f32::INFINITY));
    let toward = Lanes3(to.times(per_length).0.map(|t| t & has_length));
    let outside = (Lanes::ONE - r2 / d2).fast_max(Lanes::ZERO).sqrt();
    let distance = distance.fast_max(half * r2.sqrt());
    let seen = Seen {
        toward,
        cos: d2.cmp_le(r2).blend(-Lanes::ONE, outside),
        distance,
        hidden,
    };
    let energy = Lanes::from(measures.map(|m| m.energy));
    seen.bounds(&Cones::of(clusters.map(|c| c.1)), energy, at)
}
