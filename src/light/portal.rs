//! Openings through which the light from all around shines into rooms: Blender's portals, which shine with nothing of their own.
//!
//! Light samples go toward them in a share of the cases, as in Cycles, where they are drawn uniformly over the solid angle of an
//! opening (Ureña, Fajardo, King 2013: [`super::rectangle`]); the others follow the radiance. The density is that of the mixture,
//! so that light that comes in beside them is found as well: they change the noise alone.

use super::Direction;
use super::area::Area;
use super::environment::Environment;
use super::kinds::LightSampleContext;
use crate::math::float::ONE_MINUS_EPSILON;
use crate::math::sqr;
use glam::{Vec2, Vec3};

/// Share of the samples that go toward openings where there are some: Cycles' (`background_light_sample`).
const SHARE: f32 = 0.5;

/// Openings. Each is looked through from the side to which an area light in its place would shine.
#[derive(Debug)]
pub struct Portals(Vec<Area>);

/// What a point knows of the openings.
struct Seen<'a> {
    portals: &'a [Area],
    at: &'a LightSampleContext,
    /// Of all weights.
    sum: f32,
}

impl Portals {
    /// `None` without any.
    pub fn new(portals: Vec<Area>) -> Option<Self> {
        (!portals.is_empty()).then_some(Self(portals))
    }

    fn seen<'a>(&'a self, at: &'a LightSampleContext) -> Option<Seen<'a>> {
        let sum = self.0.iter().map(|portal| weight(portal, at)).sum();
        (sum > 0.0).then_some(Seen {
            portals: &self.0,
            at,
            sum,
        })
    }

    /// Draws a direction from the environment or toward an opening.
    #[cold]
    pub fn sample(
        &self,
        environment: &Environment,
        at: &LightSampleContext,
        u: Vec2,
    ) -> Option<Direction> {
        let Some(seen) = self.seen(at) else {
            return Some(environment.sample(u));
        };
        if u.x >= SHARE {
            let x = ((u.x - SHARE) / (1.0 - SHARE)).min(ONE_MINUS_EPSILON);
            let drawn = environment.sample(Vec2::new(x, u.y));
            let through = seen.pdf(drawn.wi, None);
            return Some(Direction {
                pdf: mixed(through, drawn.pdf),
                ..drawn
            });
        }
        let (chosen, x) = seen.choose(u.x / SHARE)?;
        let drawn = self.0[chosen].sample(at.point, Vec2::new(x, u.y))?;
        // At an edge rounding may say that the direction misses the opening that it was drawn from.
        let through = seen.pdf(drawn.direction.wi, Some((chosen, drawn.direction.pdf)));
        let plain = environment.plain_pdf(drawn.direction.wi);
        Some(Direction {
            pdf: mixed(through, plain),
            ..drawn.direction
        })
    }

    /// Density of [`Self::sample`] in a direction, in which that of the environment's own samples is `plain`.
    #[cold]
    pub fn pdf(&self, at: &LightSampleContext, wi: Vec3, plain: f32) -> f32 {
        self.seen(at)
            .map_or(plain, |seen| mixed(seen.pdf(wi, None), plain))
    }
}

impl Seen<'_> {
    /// One of the openings, by their weights, and what is left of the number.
    fn choose(&self, u: f32) -> Option<(usize, f32)> {
        let mut left = u * self.sum;
        let mut last = None;
        for (index, portal) in self.portals.iter().enumerate() {
            let weight = weight(portal, self.at);
            if weight <= 0.0 {
                continue;
            }
            if left < weight {
                return Some((index, (left / weight).min(ONE_MINUS_EPSILON)));
            }
            left -= weight;
            last = Some((index, ONE_MINUS_EPSILON));
        }
        // Rounding left a crumb.
        last
    }

    /// Density of samples toward the openings, of which one is known.
    fn pdf(&self, wi: Vec3, known: Option<(usize, f32)>) -> f32 {
        let each = self.portals.iter().enumerate().map(|(index, portal)| {
            let weight = weight(portal, self.at);
            if weight <= 0.0 {
                return 0.0;
            }
            let density = match known {
                Some((chosen, density)) if chosen == index => density,
                _ => portal
                    .le(self.at.point, wi)
                    .map_or(0.0, |hit| portal.pdf_li(self.at.point, hit.on)),
            };
            weight / self.sum * density
        });
        each.sum()
    }
}

fn mixed(through: f32, plain: f32) -> f32 {
    SHARE * through + (1.0 - SHARE) * plain
}

/// About its solid angle: area · cos / distance², with the distance's square not below the area; 0 where it shows its back or is
/// below the side that receives.
fn weight(portal: &Area, at: &LightSampleContext) -> f32 {
    let to = portal.center() - at.point;
    let height = -to.dot(portal.normal());
    if height.is_nan() || height <= 0.0 {
        return 0.0;
    }
    let is_below = |normal: Vec3| {
        let corners = portal.corners(0.0);
        corners
            .iter()
            .all(|corner| (*corner - at.point).dot(normal) <= 0.0)
    };
    if at.normal.is_some_and(is_below) {
        return 0.0;
    }
    let area = portal.area();
    let distance2 = to.length_squared() + area;
    let weight = area * height / (distance2 * distance2.sqrt());
    // Far away for its size, but there.
    if weight.is_finite() {
        weight.max(sqr(f32::EPSILON))
    } else {
        0.0
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/portal.rs"]
mod tests;
