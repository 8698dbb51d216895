//! Map Range and Clamp.

use super::math::divided;
use super::smoothstep;

choice! {
    /// How Map Range goes from one end to the other.
    RangeKind {
        /// In a line.
        Linear = "LINEAR",
        /// In steps.
        Stepped = "STEPPED",
        /// By 3t² − 2t³.
        SmoothStep = "SMOOTHSTEP",
        /// By 6t⁵ − 15t⁴ + 10t³.
        SmootherStep = "SMOOTHERSTEP",
    }
}

impl RangeKind {
    /// A number brought from one range to another; 0 where the first one is empty, or what clamping makes of it.
    #[inline]
    pub fn of(self, value: f32, from: (f32, f32), to: (f32, f32), steps: f32, clamp: bool) -> f32 {
        if from.0 != from.1 {
            self.of_component(value, from, to, steps, clamp)
        } else if clamp {
            between(0.0, to.0, to.1)
        } else {
            0.0
        }
    }

    /// The same of a vector's component: at the second range's begin where the first one is empty. The smooth kinds end at the ends.
    #[inline]
    pub fn of_component(
        self,
        value: f32,
        from: (f32, f32),
        to: (f32, f32),
        steps: f32,
        clamp: bool,
    ) -> f32 {
        let t = divided(value - from.0, from.1 - from.0);
        let t = match self {
            Self::Linear => t,
            Self::Stepped if steps <= 0.0 => 0.0,
            Self::Stepped => (t * (steps + 1.0)).floor() / steps,
            Self::SmoothStep => smoothstep(t),
            Self::SmootherStep => {
                let t = t.clamp(0.0, 1.0);
                t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
            }
        };
        let result = to.0 + t * (to.1 - to.0);
        if clamp && matches!(self, Self::Linear | Self::Stepped) {
            between(result, to.0, to.1)
        } else {
            result
        }
    }
}

/// A number brought between two others, whichever is the lesser.
pub fn between(value: f32, a: f32, b: f32) -> f32 {
    value.max(a.min(b)).min(a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_mapped_in_both_directions() {
        let of =
            |kind: RangeKind, value, clamp| kind.of(value, (0.0, 2.0), (1.0, -1.0), 4.0, clamp);
        assert_eq!(of(RangeKind::Linear, 3.0, false), -2.0);
        assert_eq!(of(RangeKind::Linear, 3.0, true), -1.0);
        assert_eq!(of(RangeKind::Stepped, 1.0, false), 0.0);
        assert_eq!(of(RangeKind::SmoothStep, 1.0, false), 0.0);
        assert_eq!(of(RangeKind::SmootherStep, 9.0, false), -1.0);
    }

    #[test]
    fn an_empty_range_gives_zero_before_clamping_and_of_vectors_the_begin() {
        for kind in [RangeKind::Linear, RangeKind::Stepped, RangeKind::SmoothStep] {
            let empty = (2.0, 2.0);
            assert_eq!(kind.of(1.0, empty, (3.0, 4.0), 1.0, false), 0.0);
            assert_eq!(kind.of(1.0, empty, (3.0, 4.0), 1.0, true), 3.0);
            assert_eq!(kind.of(1.0, empty, (4.0, 3.0), 1.0, true), 3.0);
            for clamp in [false, true] {
                assert_eq!(kind.of_component(1.0, empty, (4.0, 3.0), 1.0, clamp), 4.0);
            }
        }
    }
}
