use super::*;
use crate::effects::General;
use crate::ffi::embree::{Device, Ray, Scene};
use crate::sampler::hashed;
use crate::scene::{Mesh, MeshStep, Visibility};
use crate::world::geometry::Attributes;

const NOTHING: Attributes = Attributes {
    uv_sets: 0,
    tangents: false,
    radial: false,
    generated: false,
    colors: false,
    attributes: 0,
};

fn triangle() -> Mesh {
    let step = |by: f32| MeshStep {
        positions: vec![
            [by, 0.0, 3.0],
            [2.0 + by, 0.0, 3.0 * by],
            [0.0, 2.0 - by, 5.0],
        ],
        normals: Some(vec![
            [0.0, 0.0, 1.0],
            [by.sin(), 0.0, by.cos()],
            [0.0, 1.0, 0.0],
        ]),
    };
    Mesh {
        positions: step(0.0).positions,
        normals: step(0.0).normals,
        motion: vec![step(-0.7), step(0.0), step(0.5)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    }
}

#[test]
fn a_triangle_is_between_its_steps() {
    let data = MeshData::new(&triangle(), 0, None, NOTHING).unwrap();
    for (time, by) in [
        (0.0, -0.7),
        (0.25, -0.35),
        (0.5, 0.0),
        (0.75, 0.25),
        (1.0, 0.5f32),
    ] {
        let (posed, error) = data.at_time(0, time);
        let [a, b, c] = posed.corners(0);
        let expected = [
            Vec3::new(by, 0.0, 3.0),
            Vec3::new(2.0 + by, 0.0, 3.0 * by),
            Vec3::new(0.0, 2.0 - by, 5.0),
        ];
        for (found, expected) in [a, b, c].into_iter().zip(expected) {
            assert!(
                (found - expected).abs().cmple(error).all(),
                "{time}: {found}"
            );
        }
        assert!(error.max_element() < 1e-5);
        let normals = posed.normals.unwrap();
        assert!(
            normals
                .iter()
                .all(|n| (Vec3::from(*n).length() - 1.0).abs() < 1e-6)
        );
    }
}

/// What Embree has hit is, by its distance along the ray and by corners and placement at the time, one point: as far apart as
/// the errors of both allow.
#[test]
fn points_are_where_embree_has_them() {
    let device = Device::new(None, None).unwrap();
    for (far, turn) in [(0.0, 0.05), (0.0, 2.5), (400.0, 1.5), (1e5, 3.0)] {
        let data = Arc::new(MeshData::new(&triangle(), 0, None, NOTHING).unwrap());
        let mut child = Scene::new(&device, true).unwrap();
        child
            .add_triangles(&data.triangles, false, u32::MAX)
            .unwrap();
        let child = child.commit().unwrap();
        let place = |time: f64| {
            DAffine3::from_translation(DVec3::new(far + time, -far, 0.3 * time))
                * DAffine3::from_rotation_x(turn * time)
                * DAffine3::from_rotation_y(0.5 * turn * time)
                * DAffine3::from_scale(DVec3::new(1.0 + 0.3 * time, -2.0, 0.7))
        };
        let steps = [-1.0, 0.0, 1.0].map(place);
        let (path, keys) = Path::new(&steps, 0);
        let mut top = Scene::new(&device, true).unwrap();
        top.add_moving_instance(&child, &keys, u32::MAX).unwrap();
        let top = top.commit().unwrap();
        let entry = MeshInstance::instance(0, &steps[1], Visibility::ALL).moving(Some(path));
        let mut hits = 0;
        for i in 0..4000 {
            let number = |n| hashed(i, n, 7);
            let time = number(0);
            let moment = entry.at_time(&data, &top, (0, time));
            let (posed, mesh, _) = moment.of(&data, 0);
            let (u, v) = (number(1) * 0.5, number(2) * 0.5);
            let aim = posed.point::<General>(mesh, 0, u, v);
            let direction =
                Vec3::new(number(3) - 0.5, number(4) - 0.5, number(5) - 0.5).normalize();
            let origin = aim.point - direction * 3.0;
            let ray = Ray {
                origin: origin.to_array(),
                direction: direction.to_array(),
                near: 0.0,
                far: f32::INFINITY,
                mask: u32::MAX,
                time,
            };
            let Some(hit) = top.intersect(&ray) else {
                continue;
            };
            hits += 1;
            assert_eq!(hit.time, time);
            // Across the triangle: along the ray the distance is of less use, where it grazes.
            let normal = posed.geometric_normal::<General>(mesh, 0);
            let on_ray = origin + direction * hit.distance;
            let point = posed.point::<General>(mesh, 0, hit.u, hit.v);
            let apart = (on_ray - point.point).dot(normal).abs();
            let of_ray = (origin.abs() + Vec3::splat(hit.distance)) * gamma(8);
            let bound = (point.error + of_ray).dot(normal.abs());
            assert!(apart <= bound, "{far} {turn}, {time}: {apart} of {bound}");
        }
        assert!(hits > 3000, "{hits}");
    }
}
