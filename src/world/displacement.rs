//! True displacement: vertices go to where a material's graph moves them, before anything else is made of a scene.
//!
//! As in Cycles each vertex is moved once, by the first triangle that has it and whose material displaces, where that triangle's
//! corner is; objects that share a mesh share what the first of them gives. Flat meshes are moved as if they were smooth, by the
//! normals that Blender's vertices have. Files say these; else they are computed of the triangles.

use super::asking::Asking;
use super::geometry::{Attributes, MeshData, MeshInstance, unit_or_zero};
use super::material::Textures;
use super::place::ObjectFacts;
use super::view::{View, from_blender};

use crate::effects::General;
use crate::ffi::embree::EmbreeError;
use crate::scene::{
    Camera, Diagnostics, Instance, Mesh, Part, Projection, Scene, Verdict, area, tangents,
};
use crate::shading::program::{self, Program, Root};
use glam::{DAffine3, DVec3, Mat3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::HashMap;

/// How a vertex is shaded, by [`Part::vertices`].
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shaded {
    Flat,
    ByVertex,
    SmoothCorner,
    FlatCorner,
}

/// A vertex of a mesh that may have been divided into parts.
type Name = (u32, u64);

/// What displaces a mesh.
struct Displaced {
    program: Program,
    root: Root,
    /// A bump of the same displacement goes over it.
    bumps: bool,
    /// Tangents are computed anew.
    renews_tangents: bool,
}

/// Displaces the vertices of all meshes whose materials do so; their materials do it no more.
pub fn displace(scene: &mut Scene, diagnostics: &mut Diagnostics) {
    if scene
        .materials
        .iter()
        .all(|m| m.graph.displacement.is_none())
    {
        return;
    }
    let by_material = programs(scene);
    let of = |mesh: &Mesh| by_material.get(mesh.material?.0 as usize)?.as_ref();
    let names: Vec<Vec<Name>> = (0..).zip(&scene.meshes).map(names).collect();
    let round = if scene
        .meshes
        .iter()
        .any(|m| of(m).is_some() && m.normals.is_none())
    {
        round(&scene.meshes, &names)
    } else {
        FxHashMap::default()
    };
    let mut moved: FxHashMap<Name, Vec3> = FxHashMap::default();
    for (number, mesh) in (0u32..).zip(&scene.meshes) {
        let Some(by) = of(mesh) else {
            continue;
        };
        let placed = scene.instances.iter().find(|i| i.mesh.0 == number);
        let Some(instance) = placed else {
            continue;
        };
        let what = (mesh, instance);
        let vertices = (&*names[number as usize], &round);
        if let Err(error) = offsets(scene, what, by, vertices, &mut moved) {
            diagnostics.report(
                "displacement",
                Verdict::Lost,
                "true displacement",
                &mesh.name,
                format!("the surface stays where it is: {error}"),
            );
        }
    }
    let displaces: Vec<bool> = scene.meshes.iter().map(|m| of(m).is_some()).collect();
    let renews: Vec<bool> = scene
        .meshes
        .iter()
        .map(|m| of(m).is_some_and(|by| !by.bumps))
        .collect();
    let anew = |m: &Mesh| of(m).is_some_and(|by| by.renews_tangents);
    let anew: Vec<bool> = scene.meshes.iter().map(anew).collect();
    let is_touched = |names: &[Name]| names.iter().any(|name| moved.contains_key(name));
    let touched: Vec<bool> = names.iter().map(|names| is_touched(names)).collect();
    let shaded: Vec<Vec<Shaded>> = scene.meshes.iter().map(shaded).collect();
    let all_alike = |mesh: &Mesh, triangle: &[u32; 3]| [face(mesh, triangle); 3];
    let normals = |meshes: &[Mesh], of: &[bool]| vertex_normals(meshes, &names, of, all_alike);
    let before = normals(&scene.meshes, &touched);
    for (at, mesh) in scene.meshes.iter_mut().enumerate() {
        if touched[at] {
            let shaded = displaces[at].then_some(&*shaded[at]);
            move_vertices(mesh, &names[at], &moved, (shaded, renews[at]));
        }
    }
    // What is a line now has no side; what was one may have been opened.
    area::clean_displaced(scene, diagnostics);
    let after = normals(&scene.meshes, &touched);
    let renewed = normals(&scene.meshes, &renews);
    let meshes = scene.meshes.par_iter_mut().enumerate();
    meshes.for_each(|(at, mesh)| {
        if touched[at] {
            turn_normals(mesh, (&names[at], &shaded[at]), [&before, &after, &renewed]);
        }
        if let Some(part) = mesh.part.take() {
            mesh.attributes.truncate(part.vertices as usize + 1);
        }
        // Last: vertices may come apart.
        if anew[at]
            && mesh.tangents.is_some()
            && let Some(set) = mesh.tangent_set
        {
            tangents::compute(mesh, set as usize);
        }
    });
    for material in &mut scene.materials {
        if material.graph.displacement.take().is_some() {
            material.graph.prune();
        }
    }
}

/// The displacement of each material that has one.
fn programs(scene: &Scene) -> Vec<Option<Displaced>> {
    let mut rasters = HashMap::new();
    let mut source = Textures {
        rasters: &mut rasters,
        scene,
    };
    let materials = scene.materials.iter();
    materials
        .map(|material| {
            let (program, root) = program::displacement(&material.graph, &mut source)?;
            Some(Displaced {
                program,
                root,
                bumps: material.graph.bumps_displaced(),
                renews_tangents: material.graph.renews_tangents,
            })
        })
        .collect()
}

/// Names of the vertices of a mesh; without numbers of its own, those at one place are one.
fn names((number, mesh): (u32, &Mesh)) -> Vec<Name> {
    let numbers = mesh.part.and_then(|part| {
        let values = mesh.attributes.get(part.vertices as usize)?;
        Some((part.whole, values))
    });
    match numbers {
        Some((whole, values)) => {
            let name = |[low, high, ..]: &[f32; 4]| (whole, (*high as u64) << 16 | *low as u64);
            values.iter().map(name).collect()
        }
        None => {
            let mut places: FxHashMap<[u32; 3], u64> = FxHashMap::default();
            let positions = mesh.positions.iter();
            positions
                .map(|p| {
                    let next = places.len() as u64;
                    let place = p.map(|c| (c + 0.0).to_bits());
                    (u32::MAX - number, *places.entry(place).or_insert(next))
                })
                .collect()
        }
    }
}

/// How the vertices of a mesh are shaded.
fn shaded(mesh: &Mesh) -> Vec<Shaded> {
    let codes = mesh
        .part
        .and_then(|Part { vertices, .. }| mesh.attributes.get(vertices as usize));
    let Some(codes) = codes else {
        let all = if mesh.normals.is_some() {
            Shaded::ByVertex
        } else {
            Shaded::Flat
        };
        return vec![all; mesh.positions.len()];
    };
    let of = |value: &[f32; 4]| match value[2] as u32 {
        1 => Shaded::ByVertex,
        2 => Shaded::SmoothCorner,
        3 => Shaded::FlatCorner,
        _ => Shaded::Flat,
    };
    codes.iter().map(of).collect()
}

/// What a mesh's displacement adds to its vertices, in its own space, where nothing is known of them yet. `round`: the normals of the
/// vertices of flat meshes.
fn offsets(
    scene: &Scene,
    (mesh, instance): (&Mesh, &Instance),
    by: &Displaced,
    (names, round): (&[Name], &FxHashMap<Name, Vec3>),
    moved: &mut FxHashMap<Name, Vec3>,
) -> Result<(), EmbreeError> {
    let everything = Attributes {
        uv_sets: usize::MAX,
        tangents: true,
        radial: true,
        generated: true,
        colors: true,
        attributes: usize::MAX,
    };
    let data = MeshData::new(mesh, 0, None, everything)?;
    let about = (instance.info.clone(), mesh.texture_space);
    let place = &instance.world_from_object;
    let facts = ObjectFacts::new(place, DVec3::ZERO, true, about, view(scene));
    let entry = MeshInstance::instance(0, place, instance.visibility)
        .with_facts(Some(std::sync::Arc::new(facts)));
    let to_object = {
        let m = place.matrix3;
        if m.determinant() == 0.0 {
            Mat3::IDENTITY
        } else {
            m.inverse().as_mat3()
        }
    };
    for (triangle, corners) in (0u32..).zip(&mesh.triangles) {
        let outside = entry.geometric_normal::<General>(&data, triangle);
        for (&corner, (u, v)) in corners.iter().zip([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]) {
            let name = names[corner as usize];
            if moved.contains_key(&name) {
                continue;
            }
            let mut at = entry.at(&data, (triangle, u, v), Asking::along(-outside));
            if mesh.normals.is_none() {
                let normal = round.get(&name).copied().unwrap_or_default();
                at.normal = unit_or_zero(entry.normal::<General>(normal));
            }
            let world = by.program.at(&at, |at| at.color(&by.root));
            let offset = to_object * from_blender(world);
            moved.insert(
                name,
                if offset.is_finite() {
                    offset
                } else {
                    Vec3::ZERO
                },
            );
        }
    }
    Ok(())
}

/// What displacements know of the one who looks.
fn view(scene: &Scene) -> View {
    let nobody = Camera {
        name: String::new(),
        world_from_camera: DAffine3::IDENTITY,
        projection: Projection::Orthographic {
            half_width: 1.0,
            half_height: 1.0,
        },
        window: None,
        clip_near: 0.0,
        clip_far: f64::INFINITY,
        aperture: None,
        motion: None,
        stereo: None,
    };
    let camera = scene.cameras.first().unwrap_or(&nobody);
    View::new(camera, (1.0, 1), DVec3::ZERO)
}

/// Moves a mesh's vertices. What comes of their places before stays: generated coordinates, and for a bump the places, with a 0 behind
/// those of flat faces. `shaded`: how, if the mesh displaces, and whether its normals are new: those of before are kept in place of
/// the places.
fn move_vertices(
    mesh: &mut Mesh,
    names: &[Name],
    moved: &FxHashMap<Name, Vec3>,
    (shaded, renews): (Option<&[Shaded]>, bool),
) {
    if mesh.generated.is_none() {
        let space = mesh.texture_space;
        let generated = |p: &[f32; 3]| space.generated(Vec3::from(*p)).into();
        mesh.generated = Some(mesh.positions.iter().map(generated).collect());
    }
    if let (Some(part), Some(shaded)) = (mesh.part, shaded)
        && let Some(values) = mesh.attributes.get_mut(part.vertices as usize)
    {
        let is_curved = |shaded: &Shaded| !matches!(shaded, Shaded::Flat | Shaded::FlatCorner);
        let kept = match &mesh.normals {
            Some(normals) if renews => normals,
            _ => &mesh.positions,
        };
        *values = kept
            .iter()
            .zip(shaded)
            .map(|([x, y, z], how)| [*x, *y, *z, f32::from(is_curved(how))])
            .collect();
    }
    for (position, name) in mesh.positions.iter_mut().zip(names) {
        if let Some(offset) = moved.get(name) {
            *position = (Vec3::from(*position) + *offset).into();
        }
    }
    // As in Cycles: at each step by as much.
    for step in &mut mesh.motion {
        for (position, name) in step.positions.iter_mut().zip(names) {
            if let Some(offset) = moved.get(name) {
                *position = (Vec3::from(*position) + *offset).into();
            }
        }
    }
}

/// Unit normals of a triangle.
fn face(mesh: &Mesh, triangle: &[u32; 3]) -> Vec3 {
    let [a, b, c] = triangle.map(|i| Vec3::from(mesh.positions[i as usize]).as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// The normals of the vertices of flat meshes: those that their files say, else the means of their triangles'.
fn round(meshes: &[Mesh], names: &[Vec<Name>]) -> FxHashMap<Name, Vec3> {
    let told = |mesh: &Mesh| mesh.part.filter(|part| part.with_normals);
    let others: Vec<bool> = meshes
        .iter()
        .map(|m| m.normals.is_none() && told(m).is_none())
        .collect();
    let mut found = vertex_normals(meshes, names, &others, by_angles);
    for (mesh, names) in meshes.iter().zip(names) {
        let normals = told(mesh).and_then(|part| mesh.attributes.get(part.vertices as usize + 1));
        for (name, &[x, y, z, _]) in names.iter().zip(normals.into_iter().flatten()) {
            found.insert(*name, Vec3::new(x, y, z));
        }
    }
    found
}

/// Unit normals of a triangle, scaled by its angle at each corner.
fn by_angles(mesh: &Mesh, triangle: &[u32; 3]) -> [Vec3; 3] {
    let corners = triangle.map(|i| Vec3::from(mesh.positions[i as usize]).as_dvec3());
    let normal = face(mesh, triangle);
    [0, 1, 2].map(|at| {
        let [to_next, to_last] = [1, 2].map(|by| corners[(at + by) % 3] - corners[at]);
        normal * to_next.cross(to_last).length().atan2(to_next.dot(to_last)) as f32
    })
}

/// The mean of the normals of the triangles about each vertex of some meshes. `at_corners`: a triangle's, by how much they count.
fn vertex_normals(
    meshes: &[Mesh],
    names: &[Vec<Name>],
    of: &[bool],
    at_corners: impl Fn(&Mesh, &[u32; 3]) -> [Vec3; 3],
) -> FxHashMap<Name, Vec3> {
    let mut sums: FxHashMap<Name, Vec3> = FxHashMap::default();
    for ((mesh, names), _) in meshes.iter().zip(names).zip(of).filter(|(_, of)| **of) {
        for triangle in &mesh.triangles {
            for (&corner, normal) in triangle.iter().zip(at_corners(mesh, triangle)) {
                *sums.entry(names[corner as usize]).or_default() += normal;
            }
        }
    }
    for sum in sums.values_mut() {
        *sum = sum.normalize_or_zero();
    }
    sums
}

/// Turns the normals of a mesh with its vertices. `before` and `after` are those of all triangles, `renewed` those of triangles
/// over which no bump goes.
fn turn_normals(
    mesh: &mut Mesh,
    (names, shaded): (&[Name], &[Shaded]),
    [before, after, renewed]: [&FxHashMap<Name, Vec3>; 3],
) {
    let Some(mut normals) = mesh.normals.take() else {
        return;
    };
    let mut faces = vec![Vec3::ZERO; normals.len()];
    for triangle in &mesh.triangles {
        let normal = face(mesh, triangle);
        for &corner in triangle {
            faces[corner as usize] = normal;
        }
    }
    let at = |normals: &FxHashMap<Name, Vec3>, name| normals.get(name).copied().unwrap_or_default();
    for (i, normal) in normals.iter_mut().enumerate() {
        let name = &names[i];
        let turned = match shaded[i] {
            Shaded::Flat | Shaded::FlatCorner => faces[i],
            Shaded::ByVertex => at(renewed, name),
            // Vertices of sharp edges have normals of their own, which turn as that of the vertex does.
            Shaded::SmoothCorner if renewed.contains_key(name) => {
                Vec3::from(*normal) + at(after, name) - at(before, name)
            }
            // Where a bump goes over the displacement, it turns the normals of before.
            Shaded::SmoothCorner => continue,
        };
        if let Some(turned) = turned.try_normalize() {
            *normal = turned.into();
        }
    }
    mesh.normals = Some(normals);
}

#[cfg(test)]
#[path = "../../tests/unit/world/displacement.rs"]
mod tests;
