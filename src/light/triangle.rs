//! Emissive triangles, sampled by solid angle.

use crate::math::warp;
use glam::{Vec2, Vec3};

/// Corners in world space.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Corners.
    pub corners: [Vec3; 3],
}

/// A point on a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TriangleSample {
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// Direction from the lit point, unit length.
    pub wi: Vec3,
    /// Density per solid angle.
    pub pdf: f32,
}

/// Below this solid angle the spherical excess α + β + γ − π keeps fewer than half of f32's
/// digits (its terms are of order 1, rounded to 1e-7): the triangle is then sampled by area, from
/// which it hardly differs. Above the upper end (a triangle that nearly fills a hemisphere) the
/// great circles degenerate.
const BY_SOLID_ANGLE: std::ops::Range<f32> = 3e-4..6.2;

impl Triangle {
    /// Twice the area times the normal.
    #[inline]
    fn cross(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }

    /// Solid angle from a point.
    #[inline]
    fn solid_angle(&self, from: Vec3) -> f32 {
        let [a, b, c] = self.corners.map(|p| (p - from).normalize_or_zero());
        warp::spherical_triangle_area(a, b, c)
    }

    /// Density at a point of the triangle, when it is sampled by area.
    #[inline]
    fn area_pdf(&self, from: Vec3, on: Vec3) -> f32 {
        let d = on - from;
        let cross = self.cross();
        // distance² / (cos · area) = |d|³ / (|d·n̂|·|d|⁰ …): with cross = 2·area·n̂ it is
        // 2|d|³ / |d·cross|.
        let projected = d.dot(cross).abs();
        if projected <= 0.0 {
            0.0
        } else {
            2.0 * d.length_squared() * d.length() / projected
        }
    }

    /// Draws a point.
    #[inline]
    pub fn sample(&self, from: Vec3, u: Vec2) -> Option<TriangleSample> {
        let [a, b, c] = self.corners;
        let solid_angle = self.solid_angle(from);
        if BY_SOLID_ANGLE.contains(&solid_angle) {
            let unit = self.corners.map(|p| (p - from).normalize_or_zero());
            let wi = warp::spherical_triangle(unit[0], unit[1], unit[2], u)?;
            let (bu, bv, _) = warp::ray_plane_barycentrics(a, b - a, c - a, from, wi)?;
            // Rounding may put the point a little outside.
            let (bu, bv) = (bu.max(0.0), bv.max(0.0));
            let sum = (bu + bv).max(1.0);
            return Some(TriangleSample {
                u: bu / sum,
                v: bv / sum,
                wi,
                pdf: 1.0 / solid_angle,
            });
        }
        let q = warp::triangle(u);
        let on = a + (b - a) * q.x + (c - a) * q.y;
        let wi = (on - from).try_normalize()?;
        let pdf = self.area_pdf(from, on);
        (pdf > 0.0 && pdf.is_finite()).then_some(TriangleSample {
            u: q.x,
            v: q.y,
            wi,
            pdf,
        })
    }

    /// Density of [`Self::sample`] for the point `on` of the triangle.
    #[inline]
    pub fn pdf(&self, from: Vec3, on: Vec3) -> f32 {
        let solid_angle = self.solid_angle(from);
        if BY_SOLID_ANGLE.contains(&solid_angle) {
            1.0 / solid_angle
        } else {
            self.area_pdf(from, on)
        }
    }

    /// Area.
    pub fn area(&self) -> f32 {
        0.5 * self.cross().length()
    }

    /// Unit normal by winding; zero for a degenerate triangle.
    pub fn normal(&self) -> Vec3 {
        self.cross().normalize_or_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::grid;

    /// ∫ cosθ/π over the triangle's solid angle = its form factor (Lambert's formula), at
    /// distances from touching to far away.
    #[test]
    fn samples_integrate_the_form_factor_at_all_distances() {
        let triangle = Triangle {
            corners: [
                Vec3::new(-0.5, -0.4, 0.0),
                Vec3::new(0.6, -0.3, 0.0),
                Vec3::new(0.1, 0.7, 0.0),
            ],
        };
        for distance in [0.01f32, 0.1, 1.0, 10.0, 100.0, 1e4] {
            let from = Vec3::new(0.05, 0.02, -distance);
            let unit = triangle
                .corners
                .map(|p| (p.as_dvec3() - from.as_dvec3()).normalize());
            let edge = |p: glam::DVec3, q: glam::DVec3| {
                p.cross(q).normalize().z * 2.0 * ((p - q).length() * 0.5).asin()
            };
            let exact =
                ((edge(unit[0], unit[1]) + edge(unit[1], unit[2]) + edge(unit[2], unit[0]))
                    / std::f64::consts::TAU)
                    .abs();
            let n = 256;
            let mut sum = 0f64;
            for u in grid(n) {
                let Some(s) = triangle.sample(from, u) else {
                    continue;
                };
                let on = triangle.corners[0]
                    + (triangle.corners[1] - triangle.corners[0]) * s.u
                    + (triangle.corners[2] - triangle.corners[0]) * s.v;
                let pdf = triangle.pdf(from, on);
                assert!(
                    (pdf / s.pdf - 1.0).abs() < 2e-3,
                    "{distance}: {pdf} {}",
                    s.pdf
                );
                sum += f64::from(s.wi.z / s.pdf) * std::f64::consts::FRAC_1_PI;
            }
            let found = sum / f64::from(n * n);
            assert!(
                (found / exact - 1.0).abs() < 3e-3,
                "{distance}: {found} {exact}"
            );
        }
    }

    #[test]
    fn edge_on_and_degenerate_triangles_give_nothing_or_something_finite() {
        let flat = Triangle {
            corners: [
                Vec3::new(0.0, 0.0, 1.0),
                Vec3::new(1.0, 0.0, 1.0),
                Vec3::new(0.0, 0.0, 2.0),
            ],
        };
        let needle = Triangle {
            corners: [
                Vec3::ZERO,
                Vec3::new(1.0, 0.0, 0.0),
                Vec3::new(2.0, 1e-12, 0.0),
            ],
        };
        for t in [flat, needle] {
            for from in [
                Vec3::new(0.3, 0.0, 0.0),
                Vec3::new(0.3, 1e-6, -1.0),
                Vec3::new(0.0, 0.0, 1.0),
            ] {
                for u in [
                    Vec2::ZERO,
                    Vec2::splat(0.5),
                    Vec2::splat(crate::math::float::ONE_MINUS_EPSILON),
                ] {
                    if let Some(s) = t.sample(from, u) {
                        assert!(
                            s.pdf.is_finite() && s.pdf > 0.0 && s.wi.is_finite(),
                            "{s:?}"
                        );
                    }
                }
            }
        }
    }
}
