//! Polygons become triangles, and their values those of vertices.

use std::collections::{BTreeSet, HashMap};

use earcut::Earcut;
use glam::{DVec3, Vec3};

use super::materials::{Materials, Needs};
use super::polygons::{Corner, Layer, Polygons};
use crate::scene::{Diagnostics, Effect, MaterialId, Mesh, TextureSpace, Verdict, tangents};

/// Faces and corners of polygons, for the meshes made of them.
pub(super) struct Triangles {
    starts: Vec<usize>,
    /// Normals of the points, where they are made of those of the faces.
    smooth: Option<Vec<[f32; 3]>>,
}

impl Triangles {
    pub(super) fn of(polygons: &Polygons) -> Self {
        let starts = polygons.starts();
        let smooth = polygons.smooth.then(|| smooth_normals(polygons, &starts));
        Self { starts, smooth }
    }

    /// The mesh of some of the faces.
    pub(super) fn mesh(
        &self,
        polygons: &Polygons,
        faces: &[usize],
        name: &str,
        (materials, material): (&Materials, usize),
        diagnostics: &mut Diagnostics,
    ) -> Option<Mesh> {
        let needs = materials.needs(material);
        let layer = |name: &String| polygons.primvars.get(name);
        let colors = needs.colors.then(|| polygons.primvars.get("displayColor"));
        let opacity = needs
            .colors
            .then(|| polygons.primvars.get("displayOpacity"));
        let uvs: Vec<Option<&Layer>> = needs.uvs.iter().map(layer).collect();
        let attributes: Vec<Option<&Layer>> = needs.attributes.iter().map(layer).collect();
        let (colors, opacity) = (colors.flatten(), opacity.flatten());
        let mut layers: Vec<&Layer> = polygons.normals.iter().collect();
        layers.extend(uvs.iter().chain(&attributes).flatten());
        layers.extend(colors.iter().chain(&opacity));

        let corners = self.corners(polygons, faces);
        if corners.is_empty() {
            return None;
        }
        let (vertices, triangles) = weld(&corners, &layers);
        let of = |layer: &Layer, rest: [f32; 4]| -> Vec<[f32; 4]> {
            let one = vertices.iter().map(|c| layer.at(layer.index(*c), rest));
            one.collect()
        };
        let normals = match (&polygons.normals, &self.smooth) {
            (Some(layer), _) => Some(
                of(layer, [0.0; 4])
                    .into_iter()
                    .map(|[x, y, z, _]| [x, y, z])
                    .collect(),
            ),
            (None, Some(smooth)) => {
                Some(vertices.iter().map(|c| smooth[c.point as usize]).collect())
            }
            (None, None) => None,
        };
        let positions: Vec<[f32; 3]> = vertices
            .iter()
            .map(|c| polygons.points[c.point as usize])
            .collect();
        let has_uvs: Vec<bool> = uvs.iter().map(Option::is_some).collect();
        let mut mesh = Mesh {
            name: name.into(),
            texture_space: TextureSpace::around(&positions),
            normals,
            uvs: uvs
                .iter()
                .zip(&needs.uvs)
                .map(|(layer, name)| match layer {
                    // USD's v grows upwards.
                    Some(layer) => of(layer, [0.0; 4])
                        .iter()
                        .map(|[u, v, ..]| [*u, 1.0 - v])
                        .collect(),
                    None => {
                        let fallback = needs.uv_fallbacks.get(name);
                        let [u, v] = fallback.copied().unwrap_or_default();
                        vec![[u, 1.0 - v]; vertices.len()]
                    }
                })
                .collect(),
            colors: colored(&vertices, colors, opacity),
            attributes: attributes
                .iter()
                .enumerate()
                .map(|(at, layer)| match layer {
                    Some(layer) if layer.components == 1 => {
                        let one = of(layer, [0.0; 4]).into_iter();
                        one.map(|[v, ..]| [v, v, v, 1.0]).collect()
                    }
                    Some(layer) => of(layer, [0.0, 0.0, 0.0, 1.0]),
                    None => vec![needs.fallbacks[at]; vertices.len()],
                })
                .collect(),
            positions,
            triangles,
            material: Some(MaterialId(u32::try_from(material).unwrap_or(u32::MAX))),
            material_label: materials.label(material),
            ..Mesh::default()
        };
        complete_normals(&mut mesh);
        if let Some(set) = needs.tangents {
            if has_uvs.get(set) == Some(&true) {
                tangents::compute(&mut mesh, set);
            } else {
                diagnostics.report_effect(
                    Effect::NormalMaps,
                    "normal-map-without-uv",
                    Verdict::Lost,
                    "normal map on meshes without its texture coordinates",
                    name,
                    "the plain normals are used",
                );
            }
        }
        tell_of_coordinates(&has_uvs, needs, name, diagnostics);
        tell_of_tiles(&mesh, needs, diagnostics);
        Some(mesh)
    }

    /// The corners of the triangles of some faces.
    fn corners(&self, polygons: &Polygons, faces: &[usize]) -> Vec<Corner> {
        let mut corners: Vec<Corner> = Vec::new();
        let mut cutter = Cutter::default();
        for &face in faces {
            if polygons.hole.get(face) == Some(&true) {
                continue;
            }
            let (start, count) = (self.starts[face], polygons.counts[face]);
            let ring = &polygons.corners[start..start + count];
            for mut triangle in cutter.cut(&polygons.points, ring) {
                if polygons.left_handed {
                    triangle.reverse();
                }
                corners.extend(triangle.map(|at| Corner {
                    face,
                    number: start + at,
                    point: ring[at],
                }));
            }
        }
        corners
    }
}

/// Names the coordinates that textures lie by and the mesh does not have.
fn tell_of_coordinates(has_uvs: &[bool], needs: &Needs, name: &str, diagnostics: &mut Diagnostics) {
    for (set, has) in has_uvs.iter().enumerate() {
        if !has {
            diagnostics.report(
                "texture-without-uv",
                Verdict::Approximated,
                format!(
                    "texture on meshes without the coordinates \"{}\"",
                    needs.uvs[set]
                ),
                name,
                match needs.uv_fallbacks.get(&needs.uvs[set]) {
                    Some([u, v]) => format!("its texel at ({u}, {v}) is shown everywhere"),
                    None => "its texel at (0, 0) is shown everywhere".to_owned(),
                },
            );
        }
    }
}

/// Names tiles of images that triangles lie on and that are not there.
fn tell_of_tiles(mesh: &Mesh, needs: &Needs, diagnostics: &mut Diagnostics) {
    for tiles in &needs.tiles {
        let Some(uvs) = mesh.uvs.get(tiles.set as usize) else {
            continue;
        };
        let mut missing = BTreeSet::new();
        for triangle in &mesh.triangles {
            let corners = triangle.map(|at| glam::Vec2::from(uvs[at as usize]));
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            // Corners on the edge of a tile belong to that which the triangle is on.
            let inside = corners.map(|corner| corner.lerp(middle, 1e-3));
            for at in inside.into_iter().chain([middle]) {
                let (u, v) = (at.x.floor(), (1.0 - at.y).floor());
                let numbered = (0.0..10.0).contains(&u) && (0.0..1000.0).contains(&v);
                let number = 1001 + u as u32 + 10 * v as u32;
                if !numbered || !tiles.numbers.contains(&number) {
                    missing.insert(if numbered { number } else { 0 });
                }
            }
        }
        for number in missing {
            let which = match number {
                0 => "tiles beyond those that have a number".to_owned(),
                number => format!("tile {number}"),
            };
            diagnostics.report(
                "image-lost",
                Verdict::Lost,
                format!(
                    "{which} of the image \"{}\" that is not there",
                    tiles.called
                ),
                mesh.name.as_str(),
                "magenta is shown there, as in Blender",
            );
        }
    }
}

/// Colour and opacity for the picture.
fn colored(
    vertices: &[Corner],
    colors: Option<&Layer>,
    opacity: Option<&Layer>,
) -> Option<Vec<[f32; 4]>> {
    if colors.is_none() && opacity.is_none() {
        return None;
    }
    let one = vertices.iter().map(|corner| {
        let color = colors.map_or([1.0; 3], |layer| layer.at(layer.index(*corner), [0.0; 3]));
        let alpha = opacity.map_or([1.0], |layer| layer.at(layer.index(*corner), [1.0]));
        let [r, g, b] = color.map(|c| {
            if c.is_finite() {
                c.clamp(0.0, 1.0)
            } else {
                0.0
            }
        });
        [r, g, b, alpha[0].clamp(0.0, 1.0)]
    });
    Some(one.collect())
}

/// Vertices for corners: those that have the same point and the same values are one.
fn weld(corners: &[Corner], layers: &[&Layer]) -> (Vec<Corner>, Vec<[u32; 3]>) {
    let mut ids: Vec<u32> = corners.iter().map(|c| c.point).collect();
    for layer in layers {
        if matches!(
            layer.interpolation,
            super::polygons::Interpolation::Constant | super::polygons::Interpolation::Vertex
        ) {
            continue;
        }
        let mut values: HashMap<[u32; 4], u32> = HashMap::new();
        let mut pairs: HashMap<(u32, u32), u32> = HashMap::with_capacity(corners.len());
        for (id, corner) in ids.iter_mut().zip(corners) {
            let value = layer.at(layer.index(*corner), [0.0; 4]).map(f32::to_bits);
            let next = values.len() as u32;
            let value = *values.entry(value).or_insert(next);
            let next = pairs.len() as u32;
            *id = *pairs.entry((*id, value)).or_insert(next);
        }
    }
    let mut places: HashMap<u32, u32> = HashMap::new();
    let mut vertices = Vec::new();
    let flat: Vec<u32> = ids
        .iter()
        .zip(corners)
        .map(|(id, corner)| {
            *places.entry(*id).or_insert_with(|| {
                vertices.push(*corner);
                vertices.len() as u32 - 1
            })
        })
        .collect();
    let (triangles, _) = flat.as_chunks::<3>();
    (vertices, triangles.to_vec())
}

/// Normals of unit length; those without a direction become that of a triangle about them.
fn complete_normals(mesh: &mut Mesh) {
    let Some(normals) = &mut mesh.normals else {
        return;
    };
    let mut odd = false;
    for normal in normals.iter_mut() {
        match Vec3::from(*normal).try_normalize() {
            Some(unit) => *normal = unit.to_array(),
            None => {
                *normal = [0.0; 3];
                odd = true;
            }
        }
    }
    if !odd {
        return;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| Vec3::from(mesh.positions[i as usize]));
        let own = (b - a).cross(c - a).normalize_or(Vec3::Z).to_array();
        for corner in triangle {
            let normal = &mut normals[*corner as usize];
            if *normal == [0.0; 3] {
                *normal = own;
            }
        }
    }
}

/// Normals of points: the mean of those of the faces about them, by the angles there.
fn smooth_normals(polygons: &Polygons, starts: &[usize]) -> Vec<[f32; 3]> {
    let point = |at: u32| DVec3::from(polygons.points[at as usize].map(f64::from));
    let mut sums = vec![DVec3::ZERO; polygons.points.len()];
    for (face, start) in starts.iter().enumerate() {
        let ring = &polygons.corners[*start..start + polygons.counts[face]];
        if polygons.hole.get(face) == Some(&true) || ring.len() < 3 {
            continue;
        }
        let normal = newell(&polygons.points, ring).normalize_or_zero();
        for (at, corner) in ring.iter().enumerate() {
            let here = point(*corner);
            let before = point(ring[(at + ring.len() - 1) % ring.len()]) - here;
            let after = point(ring[(at + 1) % ring.len()]) - here;
            let product = before.length() * after.length();
            if product > 0.0 {
                let angle = (before.dot(after) / product).clamp(-1.0, 1.0).acos();
                sums[*corner as usize] += normal * angle;
            }
        }
    }
    let turn = if polygons.left_handed { -1.0 } else { 1.0 };
    let one = sums
        .iter()
        .map(|sum| (turn * sum.normalize_or_zero()).as_vec3().to_array());
    one.collect()
}

/// The area of a polygon times two, along its normal (Newell's method).
fn newell(points: &[[f32; 3]], ring: &[u32]) -> DVec3 {
    let point = |at: usize| DVec3::from(points[ring[at % ring.len()] as usize].map(f64::from));
    let first = point(0);
    (0..ring.len())
        .map(|at| (point(at) - first).cross(point(at + 1) - first))
        .sum()
}

/// Cuts polygons.
#[derive(Default)]
struct Cutter {
    earcut: Option<Earcut<f64>>,
    flat: Vec<[f64; 2]>,
    found: Vec<u32>,
}

impl Cutter {
    /// Triangles of a polygon, by the places of its corners.
    fn cut(&mut self, points: &[[f32; 3]], ring: &[u32]) -> Vec<[usize; 3]> {
        match ring.len() {
            0..=2 => Vec::new(),
            3 => vec![[0, 1, 2]],
            4 => {
                let [a, b, c, d] =
                    [0, 1, 2, 3].map(|i: usize| Vec3::from(points[ring[i] as usize]));
                let first = (b - a).cross(c - a);
                let second = (c - a).cross(d - a);
                // A corner that points inwards has to be at the end of the cut, as in Blender.
                if first.dot(second) < 0.0 {
                    vec![[0, 1, 3], [1, 2, 3]]
                } else {
                    vec![[0, 1, 2], [0, 2, 3]]
                }
            }
            count => {
                let normal = newell(points, ring);
                let x = normal.any_orthogonal_vector().normalize_or(DVec3::X);
                let y = normal.cross(x).normalize_or(DVec3::Y);
                self.flat.clear();
                self.flat.extend(ring.iter().map(|at| {
                    let point = DVec3::from(points[*at as usize].map(f64::from));
                    [point.dot(x), point.dot(y)]
                }));
                let finite = self.flat.iter().flatten().all(|v| v.is_finite());
                if normal == DVec3::ZERO || !finite {
                    return (1..count - 1).map(|i| [0, i, i + 1]).collect();
                }
                let earcut = self.earcut.get_or_insert_with(Earcut::new);
                earcut.earcut(self.flat.iter().copied(), &[], &mut self.found);
                let (triangles, _) = self.found.as_chunks::<3>();
                let flat = &self.flat;
                let turned = |t: &[u32; 3]| {
                    let [a, b, c] = t.map(|i| i as usize);
                    let side = |i: usize| [flat[i][0] - flat[a][0], flat[i][1] - flat[a][1]];
                    let (p, q) = (side(b), side(c));
                    // As the polygon turns.
                    if p[0] * q[1] - p[1] * q[0] < 0.0 {
                        [a, c, b]
                    } else {
                        [a, b, c]
                    }
                };
                triangles.iter().map(turned).collect()
            }
        }
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/triangles.rs"]
mod tests;
