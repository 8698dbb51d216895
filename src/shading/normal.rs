//! Shading normals: how far they may lean, and what they cost at the terminator.

use crate::math::sqr;
use glam::Vec3;

/// A normal near `n` that reflects `wo` to above the geometric surface.
///
/// In the plane of `ng` and `n` a normal at the angle φ from `ng` reflects to the elevation
/// r·cos(2φ − β), with (r, β) the polar form of `wo`'s part in that plane. Where that falls below
/// a threshold, φ is brought back to (β + acos(t/r))/2. Cycles bends normals by the same aim and
/// threshold (a hundredth, or nine tenths of the view's own elevation).
pub fn bend_for_reflection(ng: Vec3, wo: Vec3, n: Vec3) -> Vec3 {
    let reflected = n * (2.0 * n.dot(wo)) - wo;
    let elevation = wo.dot(ng);
    let threshold = (0.9 * elevation).min(0.01);
    if reflected.dot(ng) >= threshold {
        return n;
    }
    let Some(x) = (n - ng * n.dot(ng)).try_normalize() else {
        return n;
    };
    let along = wo.dot(x);
    let r = (along * along + elevation * elevation).sqrt();
    if r <= threshold {
        return ng;
    }
    let phi = 0.5 * (along.atan2(elevation) + (threshold / r).clamp(-1.0, 1.0).acos());
    (x * phi.sin() + ng * phi.cos()).normalize()
}

/// Softens the terminator that a bumped normal `n` draws across the smooth normal `ns`: the
/// masking of a GGX surface of which the bump is a typical facet (Conty Estevez, Lecocq, Stein,
/// *A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem*, Ray Tracing
/// Gems, ch. 12). `wi` is the direction to the light; 0 where it and the normal are on different sides of the smooth surface. Both
/// may be behind it, as in Cycles: a displacement that is a bump says what is smooth, and may lean further than a normal map.
pub fn bump_shadowing(ns: Vec3, n: Vec3, wi: Vec3) -> f32 {
    let (cos_i, cos_d) = (ns.dot(wi), ns.dot(n));
    if cos_i * cos_d <= 0.0 {
        return 0.0;
    }
    let (cos_i, cos_d) = (cos_i.abs(), cos_d.abs());
    if cos_d >= 1.0 || cos_i >= 1.0 {
        return 1.0;
    }
    let tan2_d = 1.0 / sqr(cos_d) - 1.0;
    let alpha2 = (0.125 * tan2_d).min(1.0);
    let tan2_i = 1.0 / sqr(cos_i) - 1.0;
    2.0 / (1.0 + (1.0 + alpha2 * tan2_i).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bent_normals_reflect_just_above_the_surface() {
        let ng = Vec3::Z;
        for (wo, n) in [
            (Vec3::new(0.9, 0.1, 0.3), Vec3::new(-0.8, 0.2, 0.5)),
            (Vec3::new(0.99, 0.0, 0.05), Vec3::new(-0.2, 0.1, 0.9)),
            (Vec3::new(-0.7, 0.5, 0.2), Vec3::new(0.9, -0.3, 0.2)),
        ] {
            let (wo, n) = (wo.normalize(), n.normalize());
            let bent = bend_for_reflection(ng, wo, n);
            let reflected = bent * (2.0 * bent.dot(wo)) - wo;
            let threshold = (0.9 * wo.z).min(0.01);
            assert!((bent.length() - 1.0).abs() < 1e-5);
            assert!(
                (reflected.z - threshold).abs() < 1e-4,
                "{wo} {n}: {reflected}"
            );
        }
        let n = Vec3::new(0.1, 0.0, 1.0).normalize();
        assert_eq!(
            bend_for_reflection(ng, Vec3::new(0.2, 0.3, 0.9).normalize(), n),
            n
        );
    }

    #[test]
    fn bump_shadowing_is_one_without_a_bump_and_falls_to_zero_at_the_horizon() {
        let ns = Vec3::Z;
        let n = Vec3::new(0.5, 0.0, 1.0).normalize();
        assert_eq!(bump_shadowing(ns, ns, Vec3::new(0.6, 0.0, 0.8)), 1.0);
        let grazing = bump_shadowing(ns, n, Vec3::new(1.0, 0.0, 1e-3).normalize());
        assert!(grazing < 0.02 && grazing > 0.0);
        assert_eq!(
            bump_shadowing(ns, n, Vec3::new(1.0, 0.0, -0.1).normalize()),
            0.0
        );
        let below = Vec3::new(0.9, 0.0, -0.1).normalize();
        assert_eq!(bump_shadowing(ns, below, Vec3::new(0.6, 0.0, 0.8)), 0.0);
    }

    #[test]
    fn behind_the_smooth_normal_is_lit_where_the_bump_is_there_too() {
        let ns = Vec3::Z;
        let above = Vec3::new(0.5, 0.1, 0.7).normalize();
        let wi = Vec3::new(0.3, -0.2, 0.6).normalize();
        let turned = |v: Vec3| Vec3::new(v.x, v.y, -v.z);
        let both = bump_shadowing(ns, turned(above), turned(wi));
        assert_eq!(both, bump_shadowing(ns, above, wi));
        assert!(both > 0.9, "{both}");
    }
}
