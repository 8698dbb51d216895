//! Self-intersection and gaps: rays leave the surface on which they start and no closed surface lets one through.

use super::kit::{camera, diffuse, place, prepared, quad, sphere};
use super::{Case, Effort, Finding};
use crate::effects::Matte;
use crate::ffi::embree::Hit;
use crate::math::{BOX_SIDES, Frame, float, warp};
use crate::render::RenderError;
use crate::sampler::{Sequence, hashed};
use crate::scene::{Mesh, RayKind, Scene};
use crate::world::{Asking, Scratch, Wanted, World};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "closed-rooms",
        about: "Rays bounce in closed rooms (a turned box, a cave of bumps, both far from the camera, tiny, huge, and as sheared and mirrored instances): none escapes, none meets the triangle that it leaves.",
        run: closed_rooms,
    },
    Case {
        name: "shared-edges",
        about: "Rays at the vertices and along the edges that triangles share: none passes between them.",
        run: shared_edges,
    },
    Case {
        name: "planes-through-the-camera",
        about: "Walls in the planes x = 0, y = 0 and z = 0 of the camera, whose points have no rounding error: rays that leave them meet nothing.",
        run: planes_through_the_camera,
    },
    Case {
        name: "close-sheets",
        about: "Sheets that are 1e-6 of their distance apart: rays meet the nearer one, and rays from one meet the other.",
        run: close_sheets,
    },
];

const FOREVER: (f32, f32) = (float::RAY_START, f32::INFINITY);

/// The nearest hit of a ray.
pub fn meet(world: &World, origin: Vec3, direction: Vec3) -> Option<Hit> {
    // Nothing here lets light pass: no number is drawn.
    let numbers = Sequence::new(0).sampler(0, 0, 0);
    world.intersect::<Matte>(origin, direction, FOREVER, RayKind::Diffuse, (&numbers, 0))
}

/// What became of rays that should have stayed inside.
#[derive(Clone, Copy, Default)]
pub struct Leaks {
    rays: u64,
    escaped: u64,
    from_outside: u64,
    onto_itself: u64,
}

impl Leaks {
    fn join(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            escaped: self.escaped + other.escaped,
            from_outside: self.from_outside + other.from_outside,
            onto_itself: self.onto_itself + other.onto_itself,
        }
    }

    /// None may be.
    pub fn findings(&self, room: &str) -> Vec<Finding> {
        vec![
            Finding::none(format!("rays that escaped from {room}"), self.escaped),
            Finding::none(
                format!("walls of {room} met from outside"),
                self.from_outside,
            ),
            Finding::none(
                format!("rays in {room} that met their own triangle"),
                self.onto_itself,
            ),
        ]
    }
}

/// Rays of one path; long enough to come everywhere, short enough to begin anew often.
const PATH: u32 = 16;

/// Follows a path in a room whose triangles turn their backs to the inside.
fn follow(world: &World, inside: Vec3, path: u32) -> Leaks {
    let mut leaks = Leaks::default();
    let random = |bounce: u32| {
        let number = |i: u32| hashed(bounce * 2 + i, path, 17);
        Vec2::new(number(0), number(1))
    };
    let (mut origin, mut direction) = (inside, warp::sphere(random(0)));
    let mut left = None;
    for bounce in 1..=PATH {
        leaks.rays += 1;
        let Some(hit) = meet(world, origin, direction) else {
            leaks.escaped += 1;
            break;
        };
        let triangle = (hit.instance, hit.geometry, hit.primitive);
        if left == Some(triangle) {
            leaks.onto_itself += 1;
        }
        let mut scratch = Scratch::default();
        let asking = Asking::along(direction);
        let surface = world.surface::<Matte>(&hit, (origin, asking), Wanted::Light, &mut scratch);
        if !surface.inside {
            leaks.from_outside += 1;
            break;
        }
        left = Some(triangle);
        let n = surface.normals.geometric;
        direction = Frame::from_normal(n).to_world(warp::cosine_hemisphere(random(bounce)));
        // One direction in 1e8 is below the wall when it is rounded: none of the renderer's paths goes on then.
        let Some(start) = world.ray_origin::<Matte>(&hit, &surface, direction, false) else {
            break;
        };
        origin = start;
    }
    leaks
}

/// Follows paths from a point inside of a room.
pub fn leaks(world: &World, inside: Vec3, paths: u32) -> Leaks {
    (0..paths)
        .into_par_iter()
        .map(|path| follow(world, inside, path))
        .reduce(Leaks::default, Leaks::join)
}

/// A cube about the origin from -1 to 1, wound counter-clockwise from outside.
pub fn cube() -> Mesh {
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0 } else { 1.0 });
    Mesh {
        name: "cube".into(),
        positions: (0..8).map(corner).collect(),
        triangles: BOX_SIDES
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..Mesh::default()
    }
}

/// A room, the transform that places it, and how often it is there: more than once makes it an instance.
struct Room {
    name: &'static str,
    mesh: Mesh,
    place: DAffine3,
    instanced: bool,
}

fn rooms() -> Vec<Room> {
    let turned = DMat3::from_quat(DQuat::from_axis_angle(
        DVec3::new(2.0, -3.0, 6.0) / 7.0,
        1.0,
    ));
    let shear = DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.8, 1.0, 0.0),
        DVec3::new(-0.5, 0.3, -1.0),
    );
    let put = |matrix3: DMat3, at: f64| DAffine3 {
        matrix3,
        translation: DVec3::new(0.3, -0.5, 0.7) * at,
    };
    let cave = || sphere(48, 0.3, false);
    let room = |name, mesh, place, instanced| Room {
        name,
        mesh,
        place,
        instanced,
    };
    vec![
        room("a box", cube(), put(turned, 1.0), false),
        room(
            "a box at 1000 times its size away",
            cube(),
            put(turned, 1e3),
            false,
        ),
        room("a cave", cave(), put(turned, 1.0), false),
        room(
            "a cave of 1e-6 m at 1e-4 m",
            cave(),
            put(turned * 1e-6, 1e-4),
            false,
        ),
        room("a cave of 1e6 m", cave(), put(turned * 1e6, 1e6), false),
        room("an instance of a cave", cave(), put(turned, 1.0), true),
        room(
            "an instance at 100 times its size away",
            cave(),
            put(turned, 1e2),
            true,
        ),
        room(
            "an instance of 1e-3 m",
            cave(),
            put(turned * 1e-3, 1e-2),
            true,
        ),
        room("an instance of 1e3 m", cave(), put(turned * 1e3, 1e3), true),
        room(
            "a sheared and mirrored instance",
            cave(),
            put(shear * turned, 3.0),
            true,
        ),
        room(
            "an instance of 1 : 10 : 100",
            cave(),
            put(
                turned * DMat3::from_diagonal(DVec3::new(0.1, 1.0, 10.0)),
                3.0,
            ),
            true,
        ),
    ]
}

fn closed_rooms(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let rooms = rooms();
    let rays: u64 = effort.of(200_000, 10_000_000, 1_000_000_000);
    let paths = (rays / u64::from(PATH) / rooms.len() as u64) as u32;
    let mut findings = Vec::new();
    let mut all = 0;
    for Room {
        name,
        mesh,
        place: at,
        instanced,
    } in rooms
    {
        let mut scene = Scene::default();
        let far_away = DAffine3::from_translation(at.translation * 100.0 + 1e3) * at;
        let places = if instanced {
            vec![at, far_away]
        } else {
            vec![at]
        };
        place(&mut scene, mesh, diffuse([0.5; 3]), &places);
        // Something at the camera, which is the origin therefore, and not the room.
        let speck = quad([0.0; 3], [1e-12, 0.0, 0.0], [0.0, 1e-12, 0.0]);
        place(&mut scene, speck, diffuse([0.5; 3]), &[DAffine3::IDENTITY]);
        scene.cameras.push(camera(DVec3::ZERO, 1.0));
        let world = prepared(&scene)?;
        let inside = (at.translation - world.origin).as_vec3();
        let leaks = leaks(&world, inside, paths);
        all += leaks.rays;
        findings.extend(leaks.findings(name));
    }
    // What each path is cut short by is counted above.
    let least = (rays as f64 * 0.99).floor();
    findings.push(Finding::new(
        "rays",
        rays as f64,
        all as f64,
        rays as f64 - least,
    ));
    Ok(findings)
}

/// From inside, at all vertices and at points of all edges, from many places.
fn shared_edges(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let places: u32 = effort.of(4, 64, 4096);
    let mut findings = Vec::new();
    let lattice = |n: u32| {
        // The cube's faces as grids, the corners of which are small whole numbers of 1/n: directions to them are exact.
        let mut mesh = Mesh {
            name: "grid".into(),
            ..Mesh::default()
        };
        let mut number = std::collections::HashMap::new();
        let steps = n as i32;
        for axis in 0..3 {
            for side in [-steps, steps] {
                for i in (-steps..steps).step_by(2) {
                    for j in (-steps..steps).step_by(2) {
                        let mut at = |i: i32, j: i32| {
                            let mut p = [0; 3];
                            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i, j);
                            *number.entry(p).or_insert_with(|| {
                                mesh.positions.push(p.map(|c| c as f32 / n as f32));
                                mesh.positions.len() as u32 - 1
                            })
                        };
                        let (a, b, c, d) = (at(i, j), at(i + 2, j), at(i + 2, j + 2), at(i, j + 2));
                        let turns = if side > 0 {
                            [[a, b, c], [a, c, d]]
                        } else {
                            [[a, c, b], [a, d, c]]
                        };
                        mesh.triangles.extend(turns);
                    }
                }
            }
        }
        mesh
    };
    let turned = DAffine3::from_quat(DQuat::from_axis_angle(
        DVec3::new(2.0, -3.0, 6.0) / 7.0,
        1.0,
    ));
    for (name, mesh, at) in [
        ("a grid with exact corners", lattice(8), DAffine3::IDENTITY),
        ("a turned grid", lattice(8), turned),
        ("a cave", sphere(24, 0.3, false), turned),
    ] {
        let mut scene = Scene::default();
        place(&mut scene, mesh.clone(), diffuse([0.5; 3]), &[at]);
        scene.cameras.push(camera(DVec3::ZERO, 1.0));
        let world = prepared(&scene)?;
        let corner = |i: u32| {
            at.transform_point3(Vec3::from(mesh.positions[i as usize]).as_dvec3())
                .as_vec3()
        };
        let missed = |from: Vec3, to: Vec3| u64::from(meet(&world, from, to - from).is_none());
        let (vertices, edges) = (0..places)
            .into_par_iter()
            .map(|place| {
                let from = match place {
                    0 => Vec3::ZERO,
                    // A few exact places, then any.
                    1..=8 => [0, 1, 2]
                        .map(|axis| {
                            if (place - 1) >> axis & 1 == 0 {
                                -0.25
                            } else {
                                0.25
                            }
                        })
                        .into(),
                    _ => {
                        (Vec3::new(
                            hashed(1, place, 3),
                            hashed(2, place, 3),
                            hashed(3, place, 3),
                        ) - 0.5)
                            * 0.5
                    }
                };
                // Exact directions have no rounding that could miss a vertex.
                let exact = place <= 8 && at == DAffine3::IDENTITY;
                let vertices: u64 = (0..mesh.positions.len() as u32)
                    .filter(|_| exact)
                    .map(|i| missed(from, corner(i)))
                    .sum();
                let mut edges = 0;
                for &[a, b, c] in &mesh.triangles {
                    for (a, b) in [(a, b), (b, c), (c, a)] {
                        let (p, q) = (corner(a), corner(b));
                        for share in [0.5, 0.25, hashed(a, b, place)] {
                            edges += missed(from, p + (q - p) * share);
                        }
                    }
                }
                (vertices, edges)
            })
            .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        if at == DAffine3::IDENTITY {
            let name = format!("rays that missed a vertex of {name}");
            findings.push(Finding::none(name, vertices));
        }
        findings.push(Finding::none(
            format!("rays that missed an edge of {name}"),
            edges,
        ));
    }
    Ok(findings)
}

fn planes_through_the_camera(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let rays: u32 = effort.of(10_000, 1_000_000, 10_000_000);
    let mut findings = Vec::new();
    for axis in 0..3 {
        let (u, v) = (Vec3::AXES[(axis + 1) % 3], Vec3::AXES[(axis + 2) % 3]);
        let wall = quad(
            (u * 1.0 - v * 2.5).to_array(),
            (u * 3.0).to_array(),
            (v * 5.0).to_array(),
        );
        let mut scene = Scene::default();
        place(&mut scene, wall, diffuse([0.5; 3]), &[DAffine3::IDENTITY]);
        scene.cameras.push(camera(DVec3::ZERO, 1.0));
        let world = prepared(&scene)?;
        let (mut met, mut again) = (0u64, 0);
        for i in 0..rays {
            let number = |d: u32| hashed(d, i, 5);
            let to = u * (1.1 + 2.8 * number(0)) + v * (4.8 * number(1) - 2.4);
            let from = to + warp::sphere(Vec2::new(number(2), number(3))) * 2.0;
            let Some(hit) = meet(&world, from, to - from) else {
                continue;
            };
            met += 1;
            let mut scratch = Scratch::default();
            let asking = Asking::along(to - from);
            let surface = world.surface::<Matte>(&hit, (from, asking), Wanted::Light, &mut scratch);
            let n = surface.normals.geometric;
            let direction = Frame::from_normal(n)
                .to_world(warp::cosine_hemisphere(Vec2::new(number(4), number(5))));
            let origin = float::ray_origin(surface.point, n);
            again += u64::from(meet(&world, origin, direction).is_some());
        }
        let name = ["x", "y", "z"][axis];
        // From within the plane itself it is not met: one direction in 2^23.
        findings.push(Finding::new(
            format!("rays that met the plane {name} = 0"),
            f64::from(rays),
            met as f64,
            f64::from(rays) * 1e-3,
        ));
        findings.push(Finding::none(
            format!("rays from the plane {name} = 0 that met it again"),
            again,
        ));
    }
    Ok(findings)
}

/// The square of ±1 at z = −1 as n × n quads.
pub fn grid(n: u32) -> Mesh {
    let mut mesh = Mesh {
        name: "grid".into(),
        ..Mesh::default()
    };
    let at = |i: u32| 2.0 * i as f32 / n as f32 - 1.0;
    for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        mesh.positions.push([at(i), at(j), -1.0]);
        if i < n && j < n {
            let a = j * (n + 1) + i;
            mesh.triangles.push([a, a + 1, a + n + 2]);
            mesh.triangles.push([a, a + n + 2, a + n + 1]);
        }
    }
    mesh
}

/// The offset from the nearer sheet is γ(8) Σ |nᵢ| (|pᵢ| + |aᵢ| + |bᵢ|), with |p| below 1.3 and edges of 1/16 of the
/// distance at most 8 u · 1.5 = 7.2e-7 of it, and rounding away adds 1.2e-7: less than 1e-6.
fn close_sheets(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let rays: u32 = effort.of(20_000, 1_000_000, 20_000_000);
    let mut findings = Vec::new();
    let turned = DMat3::from_quat(DQuat::from_axis_angle(
        DVec3::new(2.0, -3.0, 6.0) / 7.0,
        0.5,
    ));
    for (name, matrix3) in [("", DMat3::IDENTITY), (" (turned)", turned)] {
        for distance in [1e-3f64, 1.0, 7e4] {
            let mut scene = Scene::default();
            for z in [1.0, 1.0 + 1e-6] {
                let sheet = grid(32);
                let at = DAffine3 {
                    matrix3: matrix3 * (distance * z),
                    translation: DVec3::ZERO,
                };
                place(&mut scene, sheet, diffuse([0.5; 3]), &[at]);
            }
            scene.cameras.push(camera(DVec3::ZERO, 1.0));
            let world = prepared(&scene)?;
            let (wrong, skipped) = (0..rays)
                .into_par_iter()
                .map(|i| {
                    let number = |d: u32| hashed(d, i, 9);
                    let to = matrix3
                        * DVec3::new(f64::from(number(0) - 0.5), f64::from(number(1) - 0.5), -1.0);
                    let direction = to.as_vec3().normalize();
                    let Some(hit) = meet(&world, Vec3::ZERO, direction) else {
                        return (1, 0);
                    };
                    let mut scratch = Scratch::default();
                    let asking = Asking::along(direction);
                    let surface = world.surface::<Matte>(
                        &hit,
                        (Vec3::ZERO, asking),
                        Wanted::Light,
                        &mut scratch,
                    );
                    let origin = float::ray_origin(surface.point, -surface.normals.geometric);
                    let next = meet(&world, origin, direction);
                    let skipped = next.is_none_or(|next| next.geometry != 1);
                    (u64::from(hit.geometry != 0), u64::from(skipped))
                })
                .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
            findings.push(Finding::none(
                format!("rays that met the farther sheet at {distance:.0e} m{name}"),
                wrong,
            ));
            findings.push(Finding::none(
                format!(
                    "rays through the nearer that missed the farther at {distance:.0e} m{name}"
                ),
                skipped,
            ));
        }
    }
    Ok(findings)
}
