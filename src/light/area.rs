//! Area lights: rectangles and ellipses that shine to one side, with Cycles' spread.
//!
//! Rectangles and ellipses are sampled by solid angle, ellipses by area where they are small as seen from the point. Where
//! the spread leaves less of an ellipse than it has area, the rectangle around what is left is sampled (points beside
//! the ellipse are samples without light). Parallelograms, the images of rectangles under sheared transforms, are two triangles that
//! are drawn alike and sampled by solid angle each.

use super::ellipse::SphericalEllipse;
use super::lamp::LampSample;
use super::rectangle::SphericalRectangle;
use super::triangle::Triangle;
use super::two_bounds::Shape;
use super::{Direction, LightHit};
use crate::math::{sqr, warp};
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{FRAC_PI_4, PI};

/// An area light in world space (relative to the scene's origin).
#[derive(Clone, Copy, Debug)]
pub struct Area {
    center: Vec3,
    /// Unit vectors in its plane.
    u: Vec3,
    v: Vec3,
    /// Unit normal on the side to which it shines.
    normal: Vec3,
    /// Half extents along `u` and `v`.
    half: Vec2,
    outline: Outline,
    spread: Spread,
    /// Radiance along the normal for a full spread.
    radiance: Vec3,
}

#[derive(Clone, Copy, Debug)]
enum Outline {
    Rectangle,
    Ellipse,
    /// Half edges by the coordinates along `u` and `v`.
    Parallelogram(Vec2, Vec2),
}

/// Cycles' "Spread": a grid of slats before the light lets through what leaves within an angle of its normal,
/// less and less towards that angle (<https://archive.blender.org/developer/D10594>).
#[derive(Clone, Copy, Debug)]
enum Spread {
    /// As it comes from a diffuse emitter.
    Full,
    /// Within a half angle: its tangent, and 1 / (tangent − angle), which keeps the power.
    Within { tangent: f32, scale: f32 },
    /// Exactly along the normal.
    Parallel,
}

impl Spread {
    /// By the full angle.
    fn new(angle: f64) -> Self {
        let half = 0.5 * angle;
        // Below a second of arc: as parallel as the sun's own light from one of its spots.
        if half < 1e-6 {
            return Self::Parallel;
        }
        if half >= 0.5 * f64::from(std::f32::consts::PI) {
            return Self::Full;
        }
        let tangent = half.tan();
        // tan x − x = x³/3 + 2x⁵/15 + …: the difference has fewer than seven digits below 1e-3.
        let less = if half < 1e-3 {
            half.powi(3) / 3.0 * (1.0 + 0.4 * half * half)
        } else {
            tangent - half
        };
        Self::Within {
            tangent: tangent as f32,
            scale: (1.0 / less) as f32,
        }
    }
}

/// A point as a light sees it.
#[derive(Clone, Copy)]
struct Local {
    /// Foot of its perpendicular, by the light's coordinates.
    foot: Vec2,
    /// Height over the light's plane, on the side to which it shines.
    height: f32,
}

/// How points on the light are drawn.
enum Plan {
    /// Uniformly over the solid angle of a rectangle.
    Spherical(SphericalRectangle),
    /// Uniformly over a rectangle: half extents, and the middle.
    Flat(Vec2, Vec2),
    /// Uniformly over the ellipse.
    Ellipse,
    /// Nearly uniformly over the solid angle of the ellipse.
    Cone(SphericalEllipse),
    /// On one of two triangles.
    Triangles(Vec2, Vec2),
}

/// Rectangles that are this many times their half diagonals away are sampled by area, which saves the angles: a relative variance of
/// 1.2 % at most, as of those that are surfaces.
const FAR: f32 = 16.0;

/// Ellipses farther than this many half diagonals are sampled by area, which saves the cone. Seen from the side their
/// distances, the third power of which weighs a sample, have a standard deviation of 3 · (1/√2) / 2 of one over that
/// (a disc's coordinates have one of half its radius): a relative variance of 2 %.
const ELLIPSE_NEAR: f32 = 8.0;

impl Area {
    /// From the light's own space to the world's (relative to the origin). `size`: full extents along X and Y.
    /// `power`: color times watts; `None` if it has no area.
    pub fn new(
        world_from_light: &DAffine3,
        size: [f32; 2],
        ellipse: bool,
        power: Vec3,
        normalize: bool,
        spread: f32,
    ) -> Option<Self> {
        let m = world_from_light.matrix3;
        let x = m.x_axis * f64::from(size[0] * 0.5);
        let y = m.y_axis * f64::from(size[1] * 0.5);
        let (a, b) = (x.length(), y.length());
        // The sine of their angle, along the normal of their plane.
        let across = x.try_normalize()?.cross(y.try_normalize()?);
        let plane = across.try_normalize()?;
        // Where a shear tilts the Z axis against the plane, the side that it is on still decides.
        let normal = if plane.dot(m.z_axis) > 0.0 {
            -plane
        } else {
            plane
        };
        let share = if ellipse { FRAC_PI_4 } else { 1.0 };
        let area = 4.0 * a * b * across.length() * share;
        let divisor = PI * if normalize { area } else { 1.0 };
        let sheared = across.length_squared() < 1.0 - SHEAR;
        let (u, v, half, outline) = if ellipse {
            let (u, v) = principal_axes(x, y, plane);
            (u, v, DVec2::new(u.length(), v.length()), Outline::Ellipse)
        } else if sheared {
            let u = x / a;
            let v = plane.cross(u);
            let half = |e: DVec3| DVec2::new(e.dot(u), e.dot(v)).as_vec2();
            (
                u,
                v,
                // Of the box around it.
                DVec2::new(a + y.dot(u).abs(), y.dot(v).abs()),
                Outline::Parallelogram(half(x), half(y)),
            )
        } else {
            (x, y, DVec2::new(a, b), Outline::Rectangle)
        };
        Some(Self {
            center: world_from_light.translation.as_vec3(),
            u: u.normalize().as_vec3(),
            v: v.normalize().as_vec3(),
            normal: normal.as_vec3(),
            half: half.as_vec2(),
            outline,
            spread: Spread::new(f64::from(spread)),
            radiance: (power.as_dvec3() / divisor).as_vec3(),
        })
    }

    /// Centre.
    pub fn center(&self) -> Vec3 {
        self.center
    }

    /// The side to which it shines.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Lower and upper corner of its bounds.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let (x, y) = (self.u * self.half.x, self.v * self.half.y);
        let reach = x.abs() + y.abs();
        (self.center - reach, self.center + reach)
    }

    /// Corners of a rectangle around it that is larger by a share.
    pub fn corners(&self, larger: f32) -> [Vec3; 4] {
        let rounding = self.center.abs().max_element() * 4.0 * f32::EPSILON;
        let half = self.half * (1.0 + larger) + rounding;
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(s, t)| self.center + self.u * (s * half.x) + self.v * (t * half.y))
    }

    /// Radiant intensity along the normal.
    pub fn intensity(&self) -> Vec3 {
        let peak = match self.spread {
            Spread::Full => 1.0,
            Spread::Within { tangent, scale } => tangent * scale,
            Spread::Parallel => PI as f32,
        };
        self.radiance * (peak * self.area())
    }

    /// What leaves it in all.
    pub(super) fn flux(&self) -> Vec3 {
        self.radiance * (PI as f32 * self.area())
    }

    /// As Cycles' Light Tree sees it.
    pub(super) fn in_tree(&self) -> Shape {
        Shape::Area {
            center: self.center,
            normal: self.normal,
            edges: [self.u * (2.0 * self.half.x), self.v * (2.0 * self.half.y)],
            spread: match self.spread {
                Spread::Full => std::f32::consts::FRAC_PI_2,
                Spread::Within { tangent, .. } => tangent.atan(),
                Spread::Parallel => 0.0,
            },
        }
    }

    /// Cosine of the half angle of its light.
    pub fn cos_spread(&self) -> f32 {
        match self.spread {
            Spread::Full => 0.0,
            Spread::Within { tangent, .. } => 1.0 / (1.0 + sqr(tangent)).sqrt(),
            Spread::Parallel => 1.0,
        }
    }

    /// Whether rays can find it.
    pub fn is_parallel(&self) -> bool {
        matches!(self.spread, Spread::Parallel)
    }

    /// Its area in world space.
    pub fn area(&self) -> f32 {
        match self.outline {
            Outline::Rectangle => 4.0 * self.half.x * self.half.y,
            Outline::Ellipse => PI as f32 * self.half.x * self.half.y,
            Outline::Parallelogram(x, y) => 4.0 * x.perp_dot(y).abs(),
        }
    }

    #[inline]
    fn local(&self, p: Vec3) -> Option<Local> {
        let d = p - self.center;
        let height = d.dot(self.normal);
        // Also false for what is not a number.
        (height > 0.0).then(|| Local {
            foot: Vec2::new(d.dot(self.u), d.dot(self.v)),
            height,
        })
    }

    #[inline]
    fn contains(&self, p: Vec2) -> bool {
        match self.outline {
            Outline::Rectangle => p.abs().cmple(self.half).all(),
            Outline::Ellipse => (p / self.half).length_squared() <= 1.0,
            Outline::Parallelogram(x, y) => {
                let whole = x.perp_dot(y);
                p.perp_dot(y).abs() <= whole.abs() && x.perp_dot(p).abs() <= whole.abs()
            }
        }
    }

    /// Part of the radiance that leaves in a direction with this tangent of the angle to the normal.
    #[inline]
    fn share(&self, tangent: f32) -> f32 {
        match self.spread {
            Spread::Full => 1.0,
            Spread::Within {
                tangent: end,
                scale,
            } => ((end - tangent) * scale).max(0.0),
            Spread::Parallel => 0.0,
        }
    }

    /// How to draw points for a lit point; `None` where nothing arrives.
    #[inline]
    fn plan(&self, at: Local) -> Option<Plan> {
        if let Outline::Parallelogram(x, y) = self.outline {
            return Some(Plan::Triangles(x, y));
        }
        let (mut low, mut high) = (-self.half, self.half);
        if let Spread::Within { tangent, .. } = self.spread {
            // Only what is within the spread about the foot of the perpendicular sends light here.
            let reach = at.height * tangent;
            low = low.max(at.foot - reach);
            high = high.min(at.foot + reach);
            if low.cmpge(high).any() {
                return None;
            }
        }
        let (half, middle) = ((high - low) * 0.5, (high + low) * 0.5);
        let distance2 = sqr(at.height) + (middle - at.foot).length_squared();
        if matches!(self.outline, Outline::Ellipse) && 4.0 * half.x * half.y >= self.area() {
            if distance2 > sqr(ELLIPSE_NEAR) * self.half.length_squared() {
                return Some(Plan::Ellipse);
            }
            let half = self.half.as_dvec2();
            let cone = SphericalEllipse::new(half, -at.foot.as_dvec2(), f64::from(at.height));
            return Some(cone.map_or(Plan::Ellipse, Plan::Cone));
        }
        if distance2 > sqr(FAR) * half.length_squared() {
            return Some(Plan::Flat(half, middle));
        }
        Some(
            SphericalRectangle::new(
                (low - at.foot).as_dvec2(),
                (high - at.foot).as_dvec2(),
                f64::from(at.height),
            )
            .map_or(Plan::Flat(half, middle), Plan::Spherical),
        )
    }

    /// One of the triangles of a parallelogram.
    fn triangle(&self, x: Vec2, y: Vec2, first: bool) -> Triangle {
        let corner = |p: Vec2| self.center + self.u * p.x + self.v * p.y;
        let third = if first { x - y } else { y - x };
        Triangle {
            corners: [corner(-x - y), corner(third), corner(x + y)],
        }
    }

    /// Whether a surface of this normal, of unit length, sees nothing of it, by the cone around its middle that Cycles' Light Tree
    /// measures: as wide as the angle to its furthest corner.
    pub fn is_behind(&self, from: Vec3, normal: Vec3) -> bool {
        let way = (self.center - from).normalize_or_zero();
        let height = way.dot(normal);
        if height > 0.0 {
            return false;
        }
        let (x, y) = (self.u * self.half.x, self.v * self.half.y);
        let sine = [x + y, x - y, y - x, -x - y]
            .map(|corner| (self.center + corner - from).normalize_or_zero())
            .map(|corner| way.cross(corner).length())
            .into_iter()
            .fold(0.0, f32::max);
        height <= -sine
    }

    /// Draws a point. `None` where it would not shine on `from`.
    #[inline]
    pub fn sample(&self, from: Vec3, u: Vec2) -> Option<LampSample> {
        let at = self.local(from)?;
        if self.is_parallel() {
            return self.contains(at.foot).then(|| LampSample {
                direction: Direction {
                    wi: -self.normal,
                    pdf: 0.0,
                },
                // π/A · A: the power that passes through a square metre.
                arriving: self.radiance * PI as f32,
                distance: at.height,
                delta: true,
            });
        }
        let plan = self.plan(at)?;
        let on = match &plan {
            Plan::Spherical(rectangle) => rectangle.sample(u).as_vec2() + at.foot,
            Plan::Flat(half, middle) => *middle + *half * (u * 2.0 - 1.0),
            Plan::Ellipse => warp::disk(u) * self.half,
            Plan::Cone(cone) => cone.sample(u)?.0.as_vec2() + at.foot,
            Plan::Triangles(x, y) => {
                let first = u.x < 0.5;
                let u = Vec2::new(if first { u.x * 2.0 } else { u.x * 2.0 - 1.0 }, u.y);
                let s = self.triangle(*x, *y, first).sample(from, u)?;
                at.foot
                    + Vec2::new(s.wi.dot(self.u), s.wi.dot(self.v)) * at.height
                        / -s.wi.dot(self.normal)
            }
        };
        // The points of parallelograms and of cones are inside but for rounding.
        if !matches!(plan, Plan::Triangles(..) | Plan::Cone(_)) && !self.contains(on) {
            return None;
        }
        let lateral = on - at.foot;
        let distance = (lateral.length_squared() + sqr(at.height)).sqrt();
        let wi = (self.u * lateral.x + self.v * lateral.y - self.normal * at.height) / distance;
        let share = self.share(lateral.length() / at.height);
        let pdf = self.density(from, at, &plan, on, distance);
        (share > 0.0 && pdf > 0.0 && pdf.is_finite()).then(|| LampSample {
            direction: Direction {
                wi: wi.normalize(),
                pdf,
            },
            arriving: self.radiance * (share / pdf),
            distance,
            delta: false,
        })
    }

    /// Density per solid angle of a point `on` of the light at a distance.
    #[inline]
    fn density(&self, from: Vec3, at: Local, plan: &Plan, on: Vec2, distance: f32) -> f32 {
        let by_area = |area: f32| sqr(distance) * distance / (at.height * area);
        match plan {
            Plan::Spherical(rectangle) => (1.0 / rectangle.solid_angle()) as f32,
            Plan::Flat(half, _) => by_area(4.0 * half.x * half.y),
            Plan::Ellipse => by_area(self.area()),
            Plan::Cone(cone) => cone.density((on - at.foot).as_dvec2()) as f32,
            Plan::Triangles(x, y) => {
                // The diagonal from −x−y to x+y parts the two.
                let first = (*x + *y).perp_dot(*x - *y) * (*x + *y).perp_dot(on) >= 0.0;
                let point = self.center + self.u * on.x + self.v * on.y;
                0.5 * self.triangle(*x, *y, first).pdf(from, point)
            }
        }
    }

    /// Where a ray from `origin` hits the side that shines.
    #[inline]
    pub fn le(&self, origin: Vec3, wi: Vec3) -> Option<LightHit> {
        let toward = -wi.dot(self.normal);
        if toward <= 0.0 || self.is_parallel() {
            return None;
        }
        let at = self.local(origin)?;
        let distance = at.height / toward;
        let lateral = Vec2::new(wi.dot(self.u), wi.dot(self.v));
        let on = at.foot + lateral * distance;
        if !self.contains(on) {
            return None;
        }
        let share = self.share(lateral.length() / toward);
        (share > 0.0).then_some(LightHit {
            distance,
            radiance: self.radiance * share,
            on: on.extend(0.0),
        })
    }

    /// Density with which [`Self::sample`] finds what a ray has hit.
    #[inline]
    pub fn pdf_li(&self, from: Vec3, on: Vec3) -> f32 {
        let on = on.truncate();
        self.local(from).map_or(0.0, |lit| {
            let distance = ((on - lit.foot).length_squared() + sqr(lit.height)).sqrt();
            self.plan(lit)
                .map_or(0.0, |plan| self.density(from, lit, &plan, on, distance))
        })
    }
}

/// Rectangles whose edges are this far (the squared cosine of their angle) from upright are parallelograms.
/// f32 transforms leave 1e-14; what is ignored moves a corner by less than 1e-5 of its edge.
const SHEAR: f64 = 1e-10;

/// Half axes of the ellipse with the conjugate half diameters x and y, in the plane with this unit normal (Rytz).
fn principal_axes(x: DVec3, y: DVec3, plane: DVec3) -> (DVec3, DVec3) {
    // The turn by t with x cos t + y sin t as an extremum: tan 2t = 2 x·y / (x² − y²).
    let t = 0.5 * (2.0 * x.dot(y)).atan2(x.length_squared() - y.length_squared());
    let (sin, cos) = t.sin_cos();
    let u = x * cos + y * sin;
    let v = y * cos - x * sin;
    // Upright but for rounding.
    let side = plane.cross(u.normalize());
    (u, side * v.dot(side).abs().max(f64::MIN_POSITIVE))
}

#[cfg(test)]
#[path = "../../tests/unit/light/area.rs"]
mod tests;
