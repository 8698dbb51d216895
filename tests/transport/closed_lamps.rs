//! Closed surfaces that shine outwards alone for light sampling, and rectangles that are sampled as one.

use super::*;
use sundog::scene::Mesh;

/// A box of edges 1, wound outwards, with two triangles a side.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [-0.5f32, 0.5] {
            let first = mesh.positions.len() as u32;
            let corner = |a: f32, b: f32| {
                let mut p = [0.0; 3];
                p[axis] = sign;
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (a, b);
                p
            };
            let mut corners =
                [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(a, b)| corner(a, b));
            if sign < 0.0 {
                corners.reverse();
            }
            mesh.positions.extend(corners);
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn glowing(radiance: f32) -> MetallicRoughness {
    MetallicRoughness {
        emission: [radiance; 3],
        ..diffuse([0.3; 3])
    }
}

/// Boxes over a floor: turned, mirrored (as an instance and not), with a side missing, and one so flat that it is nearly a sheet.
fn lamps() -> Vec<(&'static str, Scene)> {
    let turned = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.8, 0.2, 0.5),
        glam::DQuat::from_rotation_z(0.4),
        DVec3::new(-0.2, 1.1, 0.0),
    );
    let mirrored = DAffine3::from_translation(DVec3::new(1.2, 0.0, 0.3))
        * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0))
        * turned;
    let flat = turned * DAffine3::from_scale(DVec3::new(1.0, 1e-4, 1.0));
    let mut open = cube();
    open.triangles.truncate(10);
    [
        ("a box", cube(), vec![turned]),
        ("a mirrored box", cube(), vec![mirrored]),
        ("two boxes, one mirrored", cube(), vec![turned, mirrored]),
        ("a flat box", cube(), vec![flat]),
        ("an open box", open, vec![turned]),
    ]
    .into_iter()
    .map(|(name, mesh, places)| {
        let mut scene = Scene::default();
        let floor = quad([-3.0, -1.0, 3.0], [6.0, 0.0, 0.0], [0.0, 0.0, -6.0]);
        place(&mut scene, floor, diffuse([0.7; 3]), &[DAffine3::IDENTITY]);
        place(&mut scene, mesh, glowing(3.0), &places);
        scene.cameras.push(camera(DVec3::new(0.0, 0.2, 4.0), 0.8));
        (name, scene)
    })
    .collect()
}

/// A camera in a glowing box, with a ball: what shines inwards is found there too.
fn glowing_room() -> Scene {
    let mut scene = Scene::default();
    place(
        &mut scene,
        cube(),
        glowing(1.0),
        &[DAffine3::from_scale(DVec3::splat(10.0))],
    );
    place(
        &mut scene,
        sphere(16, 0.0, true),
        diffuse([0.6; 3]),
        &[DAffine3::IDENTITY],
    );
    scene.cameras.push(camera(DVec3::new(0.0, 0.0, 4.0), 0.8));
    scene
}

#[test]
fn all_ways_to_find_the_light_of_closed_lamps_agree() {
    let mut scenes = lamps();
    scenes.push(("inside a glowing box", glowing_room()));
    for (name, scene) in &scenes {
        // Sixteen seeds: Student's t of at least 15 degrees, beyond 4.1 once in a thousand.
        techniques_agree(name, scene, &small(64, 3), 4.1, 0.02);
    }
}
