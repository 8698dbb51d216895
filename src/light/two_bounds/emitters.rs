//! Lights as Cycles' Light Tree sees them.

use super::{Emitter, Shape};
use crate::light::kinds::Light;
use crate::light::set::Drawn;
use crate::math::average;
use std::f32::consts::PI;

impl Light {
    /// What the tree knows of it. `None` if it seems to have no strength at all: then it is never drawn.
    pub(in crate::light) fn in_tree(&self, drawn: Drawn) -> Option<Emitter> {
        let (shape, energy) = match self {
            Self::Lamp(lamp) => {
                let cone = lamp.cone.as_ref();
                let half = |cos: f32| 2.0 * (0.5 * cos).max(0.0).sqrt().min(1.0).asin();
                let shape = Shape::Lamp {
                    center: lamp.center,
                    radius: lamp.radius,
                    is_sphere: !lamp.soft_falloff,
                    cone: cone.map(|c| (c.axis, half(c.one_minus_cos), c.steepness)),
                };
                (shape, lamp.intensity)
            }
            Self::Area(area) => (area.in_tree(), area.flux() / PI),
            Self::Triangle(triangle) => {
                let (corners, estimate) = triangle.in_tree();
                (Shape::Triangle(corners), estimate * triangle.area())
            }
            Self::Rectangle(rectangle) => {
                let (corners, estimate) = rectangle.in_tree();
                (Shape::Rectangle(corners), estimate * rectangle.area())
            }
            Self::Sun(sun) => {
                let half = 2.0 * (0.5 * sun.one_minus_cos).sqrt().min(1.0).asin();
                (Shape::Sun(sun.toward, half), sun.irradiance)
            }
            Self::Environment(environment) => {
                (Shape::World, environment.mean() * environment.guess * PI)
            }
            Self::Computed(light) => {
                let plain = light.plain().in_tree(drawn)?;
                let energy = plain.energy * average(light.guess.abs());
                return (energy > 0.0).then_some(Emitter { energy, ..plain });
            }
        };
        let energy = average(energy.abs());
        (energy > 0.0).then_some(Emitter {
            shape,
            energy: energy.min(f32::MAX),
            drawn,
        })
    }
}
