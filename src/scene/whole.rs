//! What is asked of a scene as a whole: where it is, whether anything in it shines, and a camera that sees all of it.

use super::{Camera, Material, Mesh, Projection, Scene, Window};
use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

/// A box along the axes, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner of the least coordinates.
    pub low: DVec3,
    /// The corner of the greatest.
    pub high: DVec3,
}

impl Bounds {
    fn unite(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// Half the angle that [`Scene::framed`] has between its closest two edges: that of a lens of 50 mm on 24 mm.
const HALF_ANGLE_TANGENT: f64 = 12.0 / 50.0;

/// Vertices that are looked at together.
const BLOCK: usize = 256;
/// Of the size of coordinates: boxes are the same but for this.
const ROUNDED: f64 = 1e-14;

/// The box around some vertices of a mesh.
struct Block {
    middle: DVec3,
    half: DVec3,
}

impl Block {
    fn about(points: &[[f32; 3]]) -> Self {
        let points = points.iter().map(|p| DVec3::from(p.map(f64::from)));
        let ends = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.fold(ends, |(low, high), p| (low.min(p), high.max(p)));
        Self {
            middle: 0.5 * (low + high),
            half: 0.5 * (high - low),
        }
    }

    /// The box around it in its place, less what is rounded (a few times 2⁻⁵³ of what is added): of a flat mesh all blocks end in one plane.
    fn placed(&self, place: &DAffine3) -> Bounds {
        let m = &place.matrix3;
        let size = |v: DVec3| m.x_axis.abs() * v.x + m.y_axis.abs() * v.y + m.z_axis.abs() * v.z;
        let middle = place.transform_point3(self.middle);
        let parts = size(self.middle.abs() + self.half) + place.translation.abs();
        let half = size(self.half) - parts * ROUNDED;
        Bounds {
            low: middle - half,
            high: middle + half,
        }
    }
}

/// The box around placed vertices.
fn around(place: &DAffine3, points: &[[f32; 3]]) -> Option<Bounds> {
    let points = points.iter().map(|p| {
        let point = place.transform_point3(DVec3::from(p.map(f64::from)));
        Bounds {
            low: point,
            high: point,
        }
    });
    points.reduce(Bounds::unite)
}

/// The same by blocks, of which those are left out that lie within what is known.
fn around_blocks(place: &DAffine3, points: &[[f32; 3]], blocks: &[Block]) -> Option<Bounds> {
    let boxes: Vec<Bounds> = blocks.iter().map(|block| block.placed(place)).collect();
    let of = |number: usize| {
        let first = number * BLOCK;
        around(place, &points[first..points.len().min(first + BLOCK)])
    };
    let mut all: Option<Bounds> = None;
    let add = |all: &mut Option<Bounds>, number: usize| {
        *all = match (*all, of(number)) {
            (Some(a), Some(b)) => Some(a.unite(b)),
            (a, b) => a.or(b),
        };
    };
    let numbers = 0..boxes.len();
    for axis in 0..3 {
        let least = numbers
            .clone()
            .min_by(|a, b| boxes[*a].low[axis].total_cmp(&boxes[*b].low[axis]));
        let most = numbers
            .clone()
            .max_by(|a, b| boxes[*a].high[axis].total_cmp(&boxes[*b].high[axis]));
        for number in [least, most].into_iter().flatten() {
            add(&mut all, number);
        }
    }
    for number in numbers {
        let one = &boxes[number];
        // What is not a number lies within nothing.
        let within =
            all.is_some_and(|all| one.low.cmpge(all.low).all() && one.high.cmple(all.high).all());
        if !within {
            add(&mut all, number);
        }
    }
    all
}

impl Scene {
    /// Whether its file comes from Blender: of others nobody has a picture by Cycles.
    pub fn is_from_blender(&self) -> bool {
        let generator = self.generator.as_deref();
        generator.is_some_and(|name| name.contains("Blender"))
    }

    /// The placed meshes.
    fn placed(&self) -> impl ParallelIterator<Item = (&DAffine3, &Mesh)> {
        self.instances.par_iter().filter_map(|instance| {
            let mesh = self.meshes.get(instance.mesh.0 as usize)?;
            Some((&instance.world_from_object, mesh))
        })
    }

    /// The box around all placed vertices; `None` if there are none.
    pub fn bounds(&self) -> Option<Bounds> {
        let mut times = vec![0u32; self.meshes.len()];
        for instance in &self.instances {
            if let Some(times) = times.get_mut(instance.mesh.0 as usize) {
                *times += 1;
            }
        }
        let blocks = self.meshes.par_iter().zip(&times);
        let blocks: Vec<Vec<Block>> = blocks
            .map(|(mesh, times)| match times {
                0..=2 => Vec::new(),
                _ => mesh.positions.chunks(BLOCK).map(Block::about).collect(),
            })
            .collect();
        let placed = self.instances.par_iter().filter_map(|instance| {
            let number = instance.mesh.0 as usize;
            let (mesh, blocks) = (self.meshes.get(number)?, &blocks[number]);
            let place = &instance.world_from_object;
            if blocks.len() < 2 {
                return around(place, &mesh.positions);
            }
            around_blocks(place, &mesh.positions, blocks)
        });
        placed.reduce_with(Bounds::unite)
    }

    /// Whether there is a light, a world, or a surface that gives light or shows its colour without any.
    pub fn shines(&self) -> bool {
        let is_some = |color: &[f32; 3]| color.iter().any(|&c| c != 0.0);
        let world = self.environment.as_ref();
        let glows = |(_, mesh): (&DAffine3, &Mesh)| {
            let material = mesh.material.map(|m| self.materials.get(m.0 as usize));
            material
                .flatten()
                .map(Material::summary)
                .is_some_and(|summary| summary.unlit || summary.emits())
        };
        world.is_some_and(|world| is_some(&world.radiance))
            || self
                .lights
                .iter()
                .any(|light| light.kind.strength() != 0.0 && is_some(&light.color))
            || self.placed().any(glows)
    }

    /// A camera that sees all there is, from in front (+Z, as glTF has it), somewhat to the right and above;
    /// `None` where nothing has a size.
    pub fn framed(&self) -> Option<Camera> {
        let Bounds { low, high } = self.bounds()?;
        let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
        if !(radius > 0.0 && radius.is_finite() && middle.is_finite()) {
            return None;
        }
        // The cone of the closest two edges touches a sphere around the box: sin = radius / distance. A twentieth
        // of the picture stays empty at each side.
        let distance = 1.1 * radius * (1.0 + HALF_ANGLE_TANGENT.powi(-2)).sqrt();
        let back = DVec3::new(0.5, 0.4, 1.0).normalize();
        let right = DVec3::Y.cross(back).normalize();
        let up = back.cross(right);
        Some(Camera {
            name: "all".into(),
            world_from_camera: DAffine3::from_mat3_translation(
                DMat3::from_cols(right, up, back),
                middle + distance * back,
            ),
            projection: Projection::Perspective {
                vertical_fov: 2.0 * HALF_ANGLE_TANGENT.atan(),
                aspect: None,
            },
            // Widened for pictures that are not square: the sphere fits into each.
            window: Some(Window {
                left: -HALF_ANGLE_TANGENT,
                right: HALF_ANGLE_TANGENT,
                bottom: -HALF_ANGLE_TANGENT,
                top: HALF_ANGLE_TANGENT,
            }),
            clip_near: 0.0,
            clip_far: f64::INFINITY,
            aperture: None,
            motion: None,
            stereo: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        Environment, Instance, Light, LightKind, MaterialId, MeshId, MetallicRoughness, Visibility,
    };

    /// One triangle, placed somewhere.
    fn scene(place: DAffine3) -> Scene {
        Scene {
            meshes: vec![Mesh {
                positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, -2.0]],
                triangles: vec![[0, 1, 2]],
                material: Some(MaterialId(0)),
                ..Mesh::default()
            }],
            instances: vec![Instance {
                motion: Vec::new(),
                name: "a".into(),
                mesh: MeshId(0),
                world_from_object: place,
                visibility: Visibility::ALL,
                holdout: false,
                info: Default::default(),
            }],
            materials: vec![Material::default()],
            ..Scene::default()
        }
    }

    #[test]
    fn a_framed_scene_is_in_the_picture_whatever_its_size_place_and_the_pictures_aspect() {
        for size in [1e-6, 1.0, 1e9] {
            let place = DAffine3::from_scale_rotation_translation(
                DVec3::splat(size),
                glam::DQuat::from_rotation_z(1.0),
                DVec3::new(1e4, -3e4, 7.0) * size,
            );
            let scene = scene(place);
            let camera = scene.framed().unwrap();
            let (seen, mesh) = (camera.world_from_camera.inverse(), &scene.meshes[0]);
            for aspect in [0.2, 1.0, 3.0] {
                let window = camera.window.unwrap().widened_to(aspect);
                for p in &mesh.positions {
                    let p = place.transform_point3(DVec3::from(p.map(f64::from)));
                    let p = seen.transform_point3(p);
                    let (x, y) = (p.x / -p.z, p.y / -p.z);
                    assert!(p.z < 0.0, "{size}: {p} lies behind the camera");
                    assert!(window.left < x && x < window.right, "{size}: {p}");
                    assert!(window.bottom < y && y < window.top, "{size}: {p}");
                }
            }
            // And fills it: the triangle is longer than a quarter of the picture.
            let [a, b] = [0, 1].map(|i: usize| {
                let p = place.transform_point3(DVec3::from(mesh.positions[i].map(f64::from)));
                let p = seen.transform_point3(p);
                p.truncate() / -p.z
            });
            assert!((a - b).length() > 0.5 * HALF_ANGLE_TANGENT, "{size}");
        }
    }

    #[test]
    fn nothing_can_be_framed_where_nothing_has_a_size() {
        assert!(Scene::default().framed().is_none());
        assert!(scene(DAffine3::from_scale(DVec3::ZERO)).framed().is_none());
        assert_eq!(Scene::default().bounds(), None);
    }

    /// A mesh of many vertices that is placed often has the same box as one by one, but for roundings.
    #[test]
    fn boxes_by_blocks_are_those_of_all_vertices() {
        let turned = |number: u32| {
            let angle = f64::from(number);
            DAffine3::from_scale_rotation_translation(
                DVec3::new(1.0, 0.3 + angle, 1e-3),
                glam::DQuat::from_euler(glam::EulerRot::XYZ, angle, 2.0 * angle, 0.3),
                DVec3::new(1e3 * angle.sin(), -7.0, angle),
            )
        };
        let mut scene = scene(DAffine3::IDENTITY);
        let point = |number: u32| {
            let angle = 0.01 * number as f32;
            [angle.sin() * angle, angle.cos(), (7.0 * angle).sin()]
        };
        scene.meshes[0].positions = (0..5000).map(point).collect();
        let first = scene.instances.remove(0);
        for number in 0..20 {
            scene.instances.push(Instance {
                world_from_object: turned(number),
                ..first.clone()
            });
            let one_by_one = scene
                .placed()
                .filter_map(|(place, mesh)| around(place, &mesh.positions));
            let one_by_one = one_by_one.reduce_with(Bounds::unite).unwrap();
            let found = scene.bounds().unwrap();
            let size = one_by_one.low.abs().max(one_by_one.high.abs());
            for (a, b) in [(found.low, one_by_one.low), (found.high, one_by_one.high)] {
                let far = (a - b).abs();
                assert!(far.cmple(size * 1e-13).all(), "{number}: {far}");
            }
        }
    }

    #[test]
    fn what_shines() {
        let dark = scene(DAffine3::IDENTITY);
        assert!(!dark.shines() && !Scene::default().shines());

        let mut unlit = dark.clone();
        unlit.materials[0] = MetallicRoughness {
            unlit: true,
            ..MetallicRoughness::default()
        }
        .into();
        assert!(unlit.shines());

        let mut lamp = dark.clone();
        lamp.materials[0] = MetallicRoughness {
            emission: [0.0, 0.1, 0.0],
            ..MetallicRoughness::default()
        }
        .into();
        assert!(lamp.shines());
        // A material that nothing has.
        lamp.meshes[0].material = None;
        assert!(!lamp.shines());

        let mut world = dark.clone();
        for (strength, answer) in [(0.0, false), (1.0, true)] {
            world.environment = Some(Environment {
                image: None,
                radiance: [strength; 3],
                rotation: DMat3::IDENTITY,
                visibility: Visibility::ALL,
                links: Default::default(),
                graph: None,
            });
            assert_eq!(world.shines(), answer);
        }

        let mut sun = dark;
        for (irradiance, color, answer) in [(0.0, 1.0, false), (1.0, 0.0, false), (1.0, 0.5, true)]
        {
            sun.lights = vec![Light {
                name: "sun".into(),
                color: [color; 3],
                kind: LightKind::Sun {
                    irradiance,
                    angle: 0.0,
                },
                world_from_light: DAffine3::IDENTITY,
                visibility: Visibility::ALL,
                max_bounces: Light::MAX_BOUNCES,
                is_hit: true,
                links: Default::default(),
                graph: None,
            }];
            assert_eq!(sun.shines(), answer);
        }
    }
}
