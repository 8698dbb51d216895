//! Node trees of worlds and lights, evaluated for the rays that find them.

use super::material::Preparer;
use super::view::{View, from_blender, to_blender};
use crate::light::computed::LightAxes;
use crate::light::program::{LightProgram, ShinePoint};
use crate::scene::Scene;
use crate::scene::graph::function::{PlaceInput, Space, Transformed};
use crate::scene::graph::{Function, Graph, NodeKind, NormalSpace};
use crate::shading::program::{Met, Openness, Place, Programs};
use glam::{DVec3, Vec2, Vec3, Vec4};

/// A node tree that shines.
#[derive(Debug)]
pub struct Shine {
    programs: Programs,
    facts: Facts,
}

/// What a tree may ask about what it belongs to.
#[derive(Clone, Copy, Debug)]
struct Facts {
    /// The world's origin.
    origin: Vec3,
    view: View,
    /// Axes of a light; the world has none of its own.
    light: Option<LightAxes>,
}

impl Shine {
    /// Of the world, or of a light that stands somewhere.
    pub fn new(
        scene: &Scene,
        graph: &Graph,
        light: Option<LightAxes>,
        (origin, view): (DVec3, View),
    ) -> Self {
        Self {
            programs: Preparer::default().programs(scene, graph),
            facts: Facts {
                origin: origin.as_vec3(),
                view,
                light,
            },
        }
    }
}

impl Shine {
    /// Adds what it tells passes of the scene's own.
    pub fn add_aovs(&self, at: &ShinePoint, sums: &mut [f64]) {
        if let Some(aovs) = &self.programs.aovs {
            let facts = &self.facts;
            aovs.add(&ShinePlace { facts, at }, sums);
        }
    }
}

impl LightProgram for Shine {
    fn emitted(&self, at: &ShinePoint) -> Vec3 {
        let emission = &self.programs.emission;
        let place = ShinePlace {
            facts: &self.facts,
            at,
        };
        emission
            .program
            .at(&place, |at| at.color(&emission.shining.open))
    }
}

/// Whether a tree asks where the camera is.
pub fn asks_about_view(graph: &Graph) -> bool {
    graph.nodes.iter().any(|node| match &node.kind {
        NodeKind::Function(Function::Place(input)) => input.is_of_view(),
        NodeKind::Function(Function::VectorTransform { from, to, .. }) => {
            [from, to].contains(&&Space::Camera)
        }
        _ => false,
    })
}

/// A point that shines, as Cycles tells it to its nodes.
struct ShinePlace<'a> {
    facts: &'a Facts,
    at: &'a ShinePoint,
}

impl ShinePlace<'_> {
    /// Where it is in the world, glTF's axes; of light from all around, its direction.
    fn position(&self) -> Vec3 {
        if self.is_direction() {
            self.at.position
        } else {
            self.at.position + self.facts.origin
        }
    }

    /// Whether its position is a direction: that of what lies at infinity.
    fn is_direction(&self) -> bool {
        self.facts.light.is_none() || self.at.distance == f32::MAX
    }

    /// As a point that the camera looks at, relative to the origin.
    fn for_camera(&self) -> Vec3 {
        self.position() - self.facts.origin
    }
}

impl Place for ShinePlace<'_> {
    fn uv(&self, _: u32) -> Vec2 {
        // In Blender v grows upwards. The world has none: (0, 0).
        let uv = match self.facts.light {
            Some(_) => self.at.uv,
            None => Vec2::ZERO,
        };
        Vec2::new(uv.x, 1.0 - uv.y)
    }

    fn color(&self) -> Vec4 {
        Vec4::ONE
    }

    fn mapped_normal(&self, _: NormalSpace, _: Vec3, _: f32) -> Vec3 {
        Vec3::ZERO
    }

    fn input(&self, input: PlaceInput) -> Vec4 {
        let full = |v: Vec3| v.extend(1.0);
        let number = Vec4::splat;
        let (facts, at) = (self.facts, self.at);
        let camera = &facts.view.camera;
        match input {
            // Of the world they are the direction, as its position.
            PlaceInput::Generated if facts.light.is_none() => full(to_blender(at.position)),
            // There is no other box around a light.
            PlaceInput::Object | PlaceInput::Generated => full(match &facts.light {
                Some(axes) => {
                    axes.light_from_world * (self.position() - facts.origin - axes.location)
                }
                None => to_blender(at.position),
            }),
            PlaceInput::ObjectNormal => full(match &facts.light {
                // As normals turn: by the transpose of the way back.
                Some(axes) => {
                    let n = axes.light_from_world.inverse().transpose() * at.normal;
                    n.normalize_or_zero()
                }
                None => to_blender(at.normal),
            }),
            PlaceInput::OfObject(rows) => {
                let p = to_blender(self.position()).extend(1.0);
                full(Vec3::from(rows.map(|row| Vec4::from(row).dot(p))))
            }
            // Directions are as far from the camera as they are from the middle of the world.
            PlaceInput::Camera if facts.light.is_none() => full(camera.vector(at.position)),
            PlaceInput::Camera => full(camera.vector(self.for_camera()) + camera.translation),
            PlaceInput::Window | PlaceInput::ViewVector => {
                // Light from all around lies that way from the camera.
                let p = match facts.light {
                    None => camera.vector(at.position),
                    Some(_) => camera.vector(self.for_camera()) + camera.translation,
                };
                full(match input {
                    PlaceInput::Window => facts.view.window(p),
                    _ => p.normalize_or_zero(),
                })
            }
            PlaceInput::ViewDepth => {
                number((camera.vector(self.for_camera()) + camera.translation).z)
            }
            PlaceInput::ViewDistance => {
                number((camera.vector(self.for_camera()) + camera.translation).length())
            }
            PlaceInput::Reflection if facts.light.is_some() => {
                let (n, i) = (to_blender(at.normal), to_blender(at.incoming));
                full(n * (2.0 * n.dot(i)) - i)
            }
            PlaceInput::Reflection | PlaceInput::Incoming => full(to_blender(at.incoming)),
            PlaceInput::Position => full(to_blender(self.position())),
            PlaceInput::Normal | PlaceInput::TrueNormal => full(to_blender(at.normal)),
            // Where a light has texture coordinates, it has these as its barycentric ones, too.
            PlaceInput::Parametric | PlaceInput::Uv(_) if facts.light.is_some() => {
                full(at.uv.extend(0.0))
            }
            PlaceInput::Parametric => full(Vec3::X),
            PlaceInput::ObjectLocation => full(match &facts.light {
                Some(axes) => to_blender(axes.location + facts.origin),
                None => Vec3::ZERO,
            }),
            PlaceInput::IsRay(kinds) => number(f32::from(at.ray.kind & kinds != 0)),
            PlaceInput::RayDepth => number(at.ray.depth as f32),
            PlaceInput::RayLength => number(at.distance),
            PlaceInput::MaterialIndex(index) => number(index),
            // What only surfaces have.
            PlaceInput::Uv(_) => full(Vec3::ZERO),
            _ => Vec4::ZERO,
        }
    }

    fn transformed(&self, v: Vec3, what: Transformed, from: Space, to: Space) -> Vec3 {
        let facts = self.facts;
        let origin = (what == Transformed::Point).then_some(facts.origin);
        let world = match (from, &facts.light) {
            (Space::Camera, _) => facts.view.world_from_camera(v, origin),
            (Space::Object, Some(axes)) => {
                let back = axes.light_from_world.inverse();
                match what {
                    Transformed::Point => back * v + axes.location + facts.origin,
                    Transformed::Vector => back * v,
                    Transformed::Normal => axes.light_from_world.transpose() * v,
                }
            }
            _ => from_blender(v),
        };
        let result = match (to, &facts.light) {
            (Space::Camera, _) => facts.view.camera_from_world(world, origin),
            (Space::Object, Some(axes)) => match what {
                Transformed::Point => {
                    axes.light_from_world * (world - facts.origin - axes.location)
                }
                Transformed::Vector => axes.light_from_world * world,
                Transformed::Normal => axes.light_from_world.inverse().transpose() * world,
            },
            _ => to_blender(world),
        };
        if what == Transformed::Normal {
            result.normalize_or_zero()
        } else {
            result
        }
    }

    fn facing(&self, outside: Vec3) -> Vec3 {
        to_blender(if outside == Vec3::ZERO {
            self.at.normal
        } else {
            outside
        })
    }

    fn outside(&self, facing: Vec3) -> Vec3 {
        from_blender(facing).normalize_or_zero()
    }

    fn steps(&self, _: f32) -> [Vec3; 2] {
        // Nothing is raised where there is no surface.
        [Vec3::ZERO; 2]
    }

    fn of_neighbours(&self, _: [Vec3; 2], mut number: impl FnMut(&Self) -> f32) -> [f32; 2] {
        [number(self); 2]
    }

    fn undisplaced(&self, _: u32, _: bool) -> Self {
        Self { ..*self }
    }

    // There is nothing around, and nothing with an edge.
    fn openness(&self, _: Vec3, _: f32, _: Openness) -> f32 {
        1.0
    }

    fn beveled(&self, _: f32, _: u8) -> Vec3 {
        to_blender(self.at.normal)
    }

    fn met(&self, _: (Vec3, Vec3, f32), _: bool) -> Option<Met> {
        None
    }

    fn is_on_edge(&self, _: f32, _: bool) -> bool {
        false
    }
}

#[cfg(test)]
#[path = "../../tests/unit/world/shine.rs"]
mod tests;
