use super::*;
use crate::sampler::Sequence;
use crate::scene::{Scene, Strands};
use crate::selftest::kit::{camera, diffuse, place, prepared};
use crate::world::{Past, RayKind, Scratch, Sender, Wanted};
use glam::DVec3;

/// Two upright strands of two segments each, one behind the other as seen from +z, each of a radius of 0.1 m.
fn two(shape: StrandShape) -> Mesh {
    let upright = |z: f32| [-1.0, 0.0, 1.0].map(|y| [0.0, y, z]);
    Mesh {
        positions: [upright(0.0), upright(-1.0)].concat(),
        triangles: [[0, 1], [1, 2], [3, 4], [4, 5]]
            .map(|[a, b]| Strands::segment(a, b))
            .to_vec(),
        strands: Some(Strands {
            shape,
            radii: vec![0.1; 6],
            normals: Vec::new(),
        }),
        ..Mesh::default()
    }
}

fn world(shape: StrandShape, placed: DAffine3) -> World {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 5.0), 1.0)],
        ..Scene::default()
    };
    place(&mut scene, two(shape), diffuse([0.5; 3]), &[placed]);
    prepared(&scene).unwrap()
}

fn meet(world: &World, origin: Vec3, direction: Vec3, left: Option<LeftStrand>) -> Option<Hit> {
    let past = Past {
        left,
        ..Past::UNKNOWN
    };
    let sender = Sender {
        past: &past,
        ..RayKind::Camera.into()
    };
    let numbers = Sequence::new(0).sampler(0, 0, 0);
    let span = (0.0, f32::INFINITY);
    world.intersect::<General>(origin, direction, span, sender, (&numbers, 0))
}

const SHAPES: [StrandShape; 3] = [
    StrandShape::Ribbon(3),
    StrandShape::Round,
    StrandShape::RoundLinear,
];

#[test]
fn a_ray_does_not_meet_the_strand_that_it_leaves() {
    for shape in SHAPES {
        let world = world(shape, DAffine3::IDENTITY);
        // Positions are relative to the camera.
        let first = meet(&world, Vec3::ZERO, Vec3::new(0.01, 0.06, -1.0), None).unwrap();
        let left = world.strand_of(&first);
        assert!(left.is_some() && first.primitive == 1, "{shape:?}");
        let onward = |past| meet(&world, Vec3::ZERO, Vec3::new(0.01, 0.06, -1.0), past);
        // All of its segments are gone, and those of the other are not.
        let second = onward(left).unwrap();
        assert_eq!(second.primitive, 3, "{shape:?}");
        assert!(second.distance > first.distance + 0.9);
        assert_ne!(world.strand_of(&second), left);
        let shadow = |left| {
            let past = Past {
                left,
                ..Past::UNKNOWN
            };
            let sender = Sender {
                past: &past,
                ..RayKind::Shadow.into()
            };
            let all = (u32::MAX, &sender);
            let beside = Vec3::new(0.0, -0.5, -6.0);
            world.transmittance::<General>(beside + Vec3::X, -Vec3::X, 2.0, all)
        };
        assert_eq!(shadow(None), Vec3::ZERO);
        assert_eq!(shadow(world.strand_of(&second)), Vec3::ONE);
        assert_eq!(shadow(left), Vec3::ZERO);
    }
}

#[test]
fn a_strand_is_shaded_as_if_it_was_round() {
    for shape in SHAPES {
        let world = world(shape, DAffine3::IDENTITY);
        let direction = Vec3::new(0.012, 0.06, -1.0).normalize();
        let hit = meet(&world, Vec3::ZERO, direction, None).unwrap();
        let mut scratch = Scratch::default();
        let asking = crate::world::Asking::along(direction);
        let at = (Vec3::ZERO, asking);
        let surface = world.surface::<General>(&hit, at, Wanted::Lobes, &mut scratch);
        assert!(surface.is_strand && !surface.inside);
        let n = surface.normals.smooth;
        // About the y axis; the middle of the strand is at x = 0, z = −5.
        let point = surface.point.point;
        assert!(n.y.abs() < 1e-4 && n.z > 0.0, "{shape:?}: {n}");
        if shape != StrandShape::Ribbon(3) {
            let beside = Vec3::new(point.x, 0.0, point.z + 5.0) / 0.1;
            assert!(n.abs_diff_eq(beside, 2e-3), "{shape:?}: {n} {beside}");
        } else {
            // The share of the way across, seen from where the ray comes.
            let view = Vec3::new(-direction.x, 0.0, -direction.z).normalize();
            let across = Vec3::Y.cross(view);
            let sine = (point + Vec3::Z * 5.0).dot(across) / 0.1;
            assert!((n.dot(across) - sine).abs() < 2e-3, "{n} {sine}");
        }
    }
}

#[test]
fn uneven_scales_stretch_strands_across() {
    // Twice as wide along x, and half as long along z.
    let placed = DAffine3::from_scale(DVec3::new(2.0, 1.0, 0.5));
    for shape in [StrandShape::Round, StrandShape::RoundLinear] {
        let world = world(shape, placed);
        let direction = Vec3::new(0.0, 0.0, -1.0);
        let hit = meet(&world, Vec3::new(0.1, 0.3, 0.0), direction, None).unwrap();
        // On the ellipse x²/0.04 + z²/0.0025 = 1, z = 0.05 √(1 − 0.25).
        let height = 0.05 * 0.75f32.sqrt();
        assert!((hit.distance - (5.0 - height)).abs() < 1e-4, "{shape:?}");
        let mut scratch = Scratch::default();
        let at = (
            Vec3::new(0.1, 0.3, 0.0),
            crate::world::Asking::along(direction),
        );
        let surface = world.surface::<General>(&hit, at, Wanted::Lobes, &mut scratch);
        let right = Vec3::new(0.1 / 0.04, 0.0, height / 0.0025).normalize();
        let n = surface.normals.smooth;
        assert!(n.abs_diff_eq(right, 2e-3), "{shape:?}: {n} {right}");
    }
}

#[test]
fn normals_of_curves_are_linear_between_keys() {
    let mut mesh = two(StrandShape::Round);
    let of = |mesh: &Mesh| StrandData::of((mesh, None), (&mesh.positions, &[])).unwrap();
    assert_eq!(of(&mesh).unwrap().normal(2, 0.5), Vec3::ZERO);
    mesh.strands.as_mut().unwrap().normals = (0..6).map(|i| [i as f32, 1.0, 0.0]).collect();
    let data = of(&mesh).unwrap();
    // From the fourth vertex to the fifth.
    assert_eq!(data.normal(2, 0.25), Vec3::new(3.25, 1.0, 0.0));
    assert_eq!(data.at_time(2, 0.0).normal(0, 0.25), data.normal(2, 0.25));
}

#[test]
fn points_are_spheres() {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 5.0), 1.0)],
        ..Scene::default()
    };
    let points = Mesh {
        positions: vec![[0.0; 3], [0.0, 0.0, -3.0]],
        triangles: vec![Strands::point(0), Strands::point(1)],
        strands: Some(Strands {
            shape: StrandShape::Points,
            radii: vec![0.5, 1.0],
            normals: Vec::new(),
        }),
        ..Mesh::default()
    };
    place(&mut scene, points, diffuse([0.5; 3]), &[DAffine3::IDENTITY]);
    let world = prepared(&scene).unwrap();
    let (origin, direction) = (Vec3::new(0.3, 0.0, 0.0), -Vec3::Z);
    let hit = meet(&world, origin, direction, None).unwrap();
    assert!((hit.distance - (5.0 - 0.4)).abs() < 1e-5, "{hit:?}");
    let mut scratch = Scratch::default();
    let at = (origin, crate::world::Asking::along(direction));
    let surface = world.surface::<General>(&hit, at, Wanted::Lobes, &mut scratch);
    let n = surface.normals.geometric;
    assert!(n.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-5), "{n}");
    // What leaves one meets the other.
    let behind = meet(&world, origin, direction, world.strand_of(&hit)).unwrap();
    assert_eq!(behind.primitive, 1);
}
