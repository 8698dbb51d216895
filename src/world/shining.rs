//! Emissive triangles: which there are, which side of them shines, and points on them.

use super::World;
use super::geometry::{Entry, MeshData};
use super::material::PreparedMaterial;
use crate::effects::Features;
use crate::light::closed::{self, Outside, place_bits};
use crate::light::estimate::{Angle, Bounds, Front};
use crate::light::quad::Quad;
use crate::light::triangle::Triangle;
use crate::math::float::{self, BoundedPoint};
use crate::math::luminance;
use crate::scene::{self, Projection, Visibility};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// One of them, or two that are a rectangle and lie behind each other in their mesh.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// The placed mesh that it is of.
    pub entry: u32,
    /// Its (first) triangle.
    triangle: u32,
    shape: Shape,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    /// Its number among the triangles.
    Triangle(u32),
    /// Its number among the rectangles.
    Quad(u32),
}

/// All that shine.
#[derive(Default)]
pub struct Shining {
    triangles: Vec<Triangle>,
    quads: Vec<Quad>,
    /// For each emissive triangle the emitter that it is (a part of).
    emitters: Vec<u32>,
}

/// Where triangles that shine and have one side stand, seen by which rays, and the emitters that they are. One that is turned
/// over is no light of its own where back faces are there: a ray meets one of the two. (`scene::validate` leaves out others
/// that stand in one place, but not these, as each can be the one that is seen where back faces are not there.)
#[derive(Default)]
pub struct Places(HashMap<([[u32; 3]; 3], u32), u32>);

impl Places {
    fn key(corners: &[Vec3; 3], visibility: Visibility) -> ([[u32; 3]; 3], u32) {
        let mut bits = corners.map(place_bits);
        bits.sort_unstable();
        (bits, visibility.bits())
    }
}

/// A point of a facet, drawn for a point that it lights.
pub struct FacetSample {
    /// Towards it, unit length.
    pub wi: Vec3,
    /// Density per solid angle.
    pub pdf: f32,
    /// Radiance towards the lit point.
    pub radiance: Vec3,
    /// Where, moved off the surface.
    pub target: Vec3,
}

/// Where paths begin: within `reach` of a point.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    at: Vec3,
    reach: f32,
}

impl Eye {
    /// Of a camera, relative to the origin of the world.
    pub fn new(camera: &scene::Camera, origin: DVec3) -> Self {
        let across = match camera.projection {
            Projection::Orthographic {
                half_width,
                half_height,
            } => DVec2::new(half_width, half_height).length(),
            _ => camera.aperture.map_or(0.0, |a| a.radius),
        };
        Self {
            at: (camera.world_from_camera.translation - origin).as_vec3(),
            // Twice: the near plane is farther away in the corners of a picture.
            reach: (2.0 * camera.clip_near + across) as f32,
        }
    }

    fn may_be_in(&self, triangles: &[[Vec3; 3]]) -> bool {
        let corners = || triangles.iter().flatten();
        let low = corners().fold(Vec3::INFINITY, |low, p| low.min(*p));
        let high = corners().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
        (self.at - self.at.clamp(low, high)).length() <= self.reach
    }
}

/// The side of each triangle that light can leave, where it is one alone: of an opaque closed surface with the camera
/// outside. Paths never get into it, so that what shines on its inside is for nobody. (A camera that is inside all the
/// same finds it by looking: the density of light sampling is 0 there.)
fn outside(
    entry: &Entry,
    material: &PreparedMaterial,
    triangles: &[[Vec3; 3]],
    eye: &Eye,
) -> Option<Vec<Outside>> {
    let closing = entry.visibility == Visibility::ALL && material.is_opaque();
    (closing && !eye.may_be_in(triangles))
        .then(|| closed::outside(triangles))
        .flatten()
}

fn mean_emission(mesh: &MeshData, material: &PreparedMaterial, triangle: u32) -> f32 {
    if !material.emission_varies() {
        return luminance(material.emission);
    }
    // Centres of the 64 subtriangles of three subdivisions: finer textures than that are found by
    // the floor below.
    const N: u32 = 8;
    let mut sum = 0f32;
    for i in 0..N {
        for j in 0..N - i {
            let (u, v) = (
                (i as f32 + 1.0 / 3.0) / N as f32,
                (j as f32 + 1.0 / 3.0) / N as f32,
            );
            let at = mesh.at(triangle, u, v);
            sum += luminance(material.emitted(&at, at.color()));
        }
    }
    let mean = sum / (N * (N + 1) / 2) as f32;
    // A hundredth of the untextured emission: no bright texel between the sampled points is
    // without a chance.
    mean + 0.01 * luminance(material.emission)
}

/// Radiance of a place on a triangle, as far as the triangle is there.
#[inline]
fn radiance<E: Features>(
    mesh: &MeshData,
    material: &PreparedMaterial,
    triangle: u32,
    weights: Vec2,
) -> Vec3 {
    if !E::EVERYTHING {
        return material.emission;
    }
    let place = mesh.at(triangle, weights.x, weights.y);
    let color = place.color();
    let radiance = material.emitted(&place, color);
    if E::EVERYTHING && material.translucent {
        radiance * material.opacity(&place, color)
    } else {
        radiance
    }
}

impl Shining {
    /// Adds the triangles of an entry; `add` is told of each emitter and gives its number. The number of the first of them
    /// among all triangles that shine.
    pub fn add(
        &mut self,
        (index, entry): (u32, &Entry),
        (mesh, material): (&MeshData, &PreparedMaterial),
        eye: &Eye,
        mut places: Option<&mut Places>,
        mut add: impl FnMut(Facet, Bounds) -> u32,
    ) -> u32 {
        let first = self.emitters.len() as u32;
        let triangles: Vec<[Vec3; 3]> = (0..mesh.triangles.triangles().len() as u32)
            .map(|triangle| entry.world_corners(mesh, triangle))
            .collect();
        let outside = outside(entry, material, &triangles, eye);
        let mut at = 0;
        if !material.single_sided || !material.is_opaque() {
            places = None;
        }
        let key = |corners: &[Vec3; 3]| Places::key(corners, entry.visibility);
        let twin = |places: &Option<&mut Places>, corners: &[Vec3; 3]| {
            let emitter = places.as_ref()?.0.get(&key(corners));
            emitter.copied()
        };
        while let Some(&corners) = triangles.get(at) {
            if let Some(emitter) = twin(&places, &corners) {
                self.emitters.push(emitter);
                at += 1;
                continue;
            }
            let next = triangles
                .get(at + 1)
                .filter(|next| twin(&places, next).is_none());
            let quad = next.and_then(|&next| Quad::new(corners, next));
            let count = if quad.is_some() { 2 } else { 1 };
            let bounds = bounds(
                mesh,
                material,
                (at as u32, &triangles[at..at + count]),
                outside.as_ref().map(|sides| sides[at]),
            );
            let shape = match quad {
                Some(quad) => {
                    self.quads.push(quad);
                    Shape::Quad(self.quads.len() as u32 - 1)
                }
                None => {
                    self.triangles.push(Triangle { corners });
                    Shape::Triangle(self.triangles.len() as u32 - 1)
                }
            };
            let facet = Facet {
                entry: index,
                triangle: at as u32,
                shape,
            };
            let emitter = add(facet, bounds);
            self.emitters.extend(std::iter::repeat_n(emitter, count));
            if let Some(places) = &mut places {
                let here = triangles[at..at + count].iter();
                places.0.extend(here.map(|corners| (key(corners), emitter)));
            }
            at += count;
        }
        first
    }

    /// The emitter of a triangle, by the triangle's number among all that shine.
    #[inline]
    pub fn emitter(&self, triangle: u32) -> u32 {
        self.emitters[triangle as usize]
    }

    /// Draws a point of a facet.
    #[inline]
    pub fn sample<E: Features>(
        &self,
        world: &World,
        facet: &Facet,
        from: Vec3,
        u: Vec2,
    ) -> Option<FacetSample> {
        let (triangle, weights, wi, pdf, normal) = match facet.shape {
            Shape::Quad(number) => {
                let quad = &self.quads[number as usize];
                let s = quad.sample(from, u)?;
                let triangle = facet.triangle + u32::from(s.second);
                (triangle, s.weights, s.wi, s.pdf, quad.normal())
            }
            Shape::Triangle(number) => {
                let shape = &self.triangles[number as usize];
                let s = shape.sample(from, u)?;
                let weights = Vec2::new(s.u, s.v);
                (facet.triangle, weights, s.wi, s.pdf, shape.normal())
            }
        };
        let entry = &world.entries[facet.entry as usize];
        let mesh = &world.meshes[entry.mesh as usize];
        let material = &world.materials[mesh.material as usize];
        if world.cull_backfaces
            && material.single_sided
            && entry.geometric_normal::<E>(mesh, triangle).dot(wi) > 0.0
        {
            return None;
        }
        let point = entry.point::<E>(mesh, triangle, weights.x, weights.y);
        let facing = if wi.dot(normal) > 0.0 {
            -normal
        } else {
            normal
        };
        Some(FacetSample {
            wi,
            pdf,
            radiance: radiance::<E>(mesh, material, triangle, weights),
            target: float::ray_origin(point, facing),
        })
    }

    /// Density of [`Self::sample`] for a point of the facet.
    #[inline]
    pub fn pdf(&self, facet: &Facet, from: Vec3, on: &BoundedPoint) -> f32 {
        match facet.shape {
            Shape::Quad(number) => self.quads[number as usize].pdf(from, on.point),
            Shape::Triangle(number) => self.triangles[number as usize].pdf(from, on.point),
        }
    }
}

/// Of a facet with its triangles.
fn bounds(
    mesh: &MeshData,
    material: &PreparedMaterial,
    (first, triangles): (u32, &[[Vec3; 3]]),
    outside: Option<Outside>,
) -> Bounds {
    let corners = || triangles.iter().flatten();
    let shapes = || triangles.iter().map(|&corners| Triangle { corners });
    let intensity = shapes()
        .zip(first..)
        .map(|(shape, triangle)| shape.area() * mean_emission(mesh, material, triangle))
        .sum();
    let normal = shapes().next().map_or(Vec3::ZERO, |shape| shape.normal());
    let axis = if outside == Some(Outside::Back) {
        -normal
    } else {
        normal
    };
    let front = outside.and(corners().next()).map(|corner| Front {
        normal: axis,
        offset: axis.dot(*corner),
    });
    Bounds {
        min: corners().fold(Vec3::INFINITY, |min, p| min.min(*p)),
        max: corners().fold(Vec3::NEG_INFINITY, |max, p| max.max(*p)),
        intensity,
        axis,
        normals: Angle::ZERO,
        cos_emission: 0.0,
        two_sided: outside.is_none(),
        front,
    }
}

#[cfg(test)]
mod tests {
    use super::super::material::Preparer;
    use super::*;
    use crate::hard::kit::{camera, diffuse, glass};
    use crate::scene::{Material, RayKind, Scene};

    /// A tetrahedron of size 1 at the origin, wound outwards.
    fn triangles() -> Vec<[Vec3; 3]> {
        let [o, x, y, z] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
    }

    fn found(
        visibility: Visibility,
        material: &Material,
        triangles: &[[Vec3; 3]],
        eye: DVec3,
    ) -> bool {
        let entry = Entry::flat(0, false, visibility);
        let material = Preparer::new(false).material(&Scene::default(), material, false);
        let eye = Eye::new(&camera(eye, 0.8), DVec3::ZERO);
        outside(&entry, &material, triangles, &eye).is_some()
    }

    #[test]
    fn opaque_closed_surfaces_that_the_camera_is_not_in_shine_outwards() {
        let (opaque, away) = (diffuse([0.5; 3]), DVec3::splat(3.0));
        assert!(found(Visibility::ALL, &opaque, &triangles(), away));
        assert!(!found(Visibility::ALL, &opaque, &triangles()[..3], away));
        assert!(!found(
            Visibility::ALL,
            &glass(0.0, 1.5),
            &triangles(),
            away
        ));
        assert!(!found(
            Visibility::ALL,
            &opaque,
            &triangles(),
            DVec3::splat(0.2)
        ));
        let hidden = Visibility::ALL.without(RayKind::Camera);
        assert!(!found(hidden, &opaque, &triangles(), away));
        // There is no glass below metal, in whichever kernel.
        let metal = Material {
            metallic: 1.0,
            ..glass(0.0, 1.5)
        };
        assert!(found(Visibility::ALL, &metal, &triangles(), away));
        let half_there = Material {
            alpha: 0.5,
            alpha_mode: scene::AlphaMode::Blend,
            ..opaque
        };
        assert!(!found(Visibility::ALL, &half_there, &triangles(), away));
    }
}
