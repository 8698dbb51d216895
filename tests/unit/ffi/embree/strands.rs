use super::*;
use crate::ffi::embree::{CommittedScene, Device, Ray};

/// An upright strand of three keys, a tenth of a metre thick in radius.
fn upright(kind: StrandShape) -> Arc<StrandMesh> {
    let keys = vec![[0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let segments = [[0, 1], [1, 2]].into_iter();
    Arc::new(StrandMesh::new(kind, &[keys], &[0.1; 3], segments).unwrap())
}

fn scene_of(strands: &Arc<StrandMesh>) -> CommittedScene {
    let device = Device::new(Some(1), None).unwrap();
    let mut scene = Scene::new(&device, true).unwrap();
    scene.add_strands(strands, u32::MAX).unwrap();
    scene.commit().unwrap()
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray {
        origin,
        direction,
        near: 0.0,
        far: f32::INFINITY,
        mask: u32::MAX,
        time: 0.0,
    }
}

const KINDS: [StrandShape; 3] = [
    StrandShape::Ribbon(3),
    StrandShape::Round,
    StrandShape::RoundLinear,
];

#[test]
fn a_hit_says_where_it_lies_along_and_across() {
    for kind in KINDS {
        let scene = scene_of(&upright(kind));
        for (x, y) in [(-0.05, 0.25), (0.0, 0.25), (0.08, 0.25), (0.05, -0.75)] {
            let hit = scene
                .intersect(&ray([x, y, 5.0], [0.0, 0.0, -2.0]))
                .unwrap();
            assert_eq!(hit.primitive, u32::from(y > 0.0), "{kind:?}");
            let strands = upright(kind);
            let (at, _) = StrandMesh::on_curve(kind, strands.keys_at(hit.primitive, 0.0), hit.u);
            // Thirds of a curve whose second derivative is at most 2: chords are off by its h²/8.
            let chords = if kind == StrandShape::Ribbon(3) {
                1.0 / 36.0
            } else {
                1e-4
            };
            assert!((at.y - y).abs() < chords, "{kind:?}: {at} for {y}");
            // Along y, seen from +z: across is +x.
            let (across, _) = StrandMesh::across_and_lean(hit.v);
            assert!((across - x * 10.0).abs() < 1e-3, "{kind:?} {x}: {}", hit.v);
            let height = if kind == StrandShape::Ribbon(3) {
                0.0
            } else {
                (0.01 - x * x).sqrt()
            };
            assert!((hit.distance * 2.0 - (5.0 - height)).abs() < 1e-4);
        }
        assert_eq!(
            scene.intersect(&ray([0.11, 0.0, 5.0], [0.0, 0.0, -1.0])),
            None
        );
    }
}

#[test]
fn the_normal_across_turns_with_the_view() {
    // From the other side +x lies on the other hand: the normal that `v` stands for is the same.
    for kind in KINDS {
        let scene = scene_of(&upright(kind));
        for z in [5.0f32, -5.0] {
            let direction = Vec3::new(0.0, 0.0, -z.signum());
            let hit = scene
                .intersect(&ray([0.05, 0.3, z], direction.to_array()))
                .unwrap();
            let normal = StrandMesh::around(Vec3::Y, direction, hit.v);
            let right = Vec3::new(0.5, 0.0, 0.75f32.sqrt() * z.signum());
            assert!(normal.abs_diff_eq(right, 2e-3), "{kind:?} {z}: {normal}");
        }
    }
}

#[test]
fn tubes_are_met_from_within_on_their_far_side() {
    for kind in [StrandShape::Round, StrandShape::RoundLinear] {
        let scene = scene_of(&upright(kind));
        let (origin, direction) = (Vec3::new(0.0, 0.3, 0.05), Vec3::X);
        let inside = ray(origin.to_array(), direction.to_array());
        assert!(scene.occluded(&inside), "{kind:?}");
        let hit = scene.intersect(&inside).unwrap();
        assert!((hit.distance - 0.75f32.sqrt() * 0.1).abs() < 1e-4);
        let outside = StrandMesh::around(Vec3::Y, direction, hit.v);
        let right = Vec3::new(0.75f32.sqrt(), 0.0, 0.5);
        assert!(
            outside.abs_diff_eq(right, 2e-3),
            "{kind:?} {}: {outside}",
            hit.v
        );
    }
}

#[test]
fn instances_have_their_strands_by_their_own_space() {
    let device = Device::new(Some(1), None).unwrap();
    for kind in KINDS {
        let mut child = Scene::new(&device, true).unwrap();
        child.add_strands(&upright(kind), u32::MAX).unwrap();
        let child = child.commit().unwrap();
        let mut scene = Scene::new(&device, true).unwrap();
        // The strand lies along x, twice as large: what was +x is −y.
        let columns = [
            [0.0, -2.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 0.0, 2.0],
            [3.0, 0.0, 0.0],
        ];
        scene.add_instance(&child, &columns, u32::MAX).unwrap();
        let scene = scene.commit().unwrap();
        let hit = scene
            .intersect(&ray([3.5, -0.1, 9.0], [0.0, 0.0, -1.0]))
            .unwrap();
        assert_eq!((hit.instance, hit.primitive), (Some(0), 1), "{kind:?}");
        assert!((hit.v - 0.5).abs() < 1e-3, "{kind:?} {hit:?}");
    }
}

#[test]
fn a_point_says_which_way_its_surface_faces() {
    let places = vec![[9.0, 9.0, 9.0], [1.0, 0.0, 0.0]];
    let segments = [[0, 0], [1, 1]].into_iter();
    let points = StrandMesh::new(StrandShape::Points, &[places], &[0.1, 0.5], segments).unwrap();
    let scene = scene_of(&Arc::new(points));
    let direction = Vec3::new(0.0, 0.0, -1.0);
    let hit = scene
        .intersect(&ray([1.3, 0.0, 4.0], direction.to_array()))
        .unwrap();
    assert_eq!(hit.primitive, 1);
    let [x, y] = StrandMesh::across_points(direction);
    let normal = x * hit.u + y * hit.v - direction * (1.0 - hit.u * hit.u - hit.v * hit.v).sqrt();
    assert!(
        normal.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-5),
        "{normal}"
    );
    assert_eq!(
        scene.intersect(&ray([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])),
        None
    );
}

#[test]
fn keys_move_with_time() {
    let at = |z| vec![[0.0, -1.0, z], [0.0, 1.0, z]];
    let steps = [at(0.0), at(2.0)];
    let segments = std::iter::once([0, 1]);
    let strands = StrandMesh::new(StrandShape::Round, &steps, &[0.1; 2], segments).unwrap();
    for (time, z) in [(0.0, 0.0), (0.25, 0.5), (1.0, 2.0)] {
        assert_eq!(strands.keys_at(0, time)[1], Vec4::new(0.0, -1.0, z, 0.1));
    }
    let scene = scene_of(&Arc::new(strands));
    let hit = scene.intersect(&Ray {
        time: 0.25,
        ..ray([0.05, 0.0, 5.0], [0.0, 0.0, -1.0])
    });
    let hit = hit.unwrap();
    assert!(
        (hit.distance - (4.5 - 0.0075f32.sqrt())).abs() < 1e-4,
        "{hit:?}"
    );
}

#[test]
fn several_curves_stand_apart() {
    // Two curves of three and of two keys; the second begins where the first does not end.
    let places: Vec<[f32; 3]> = [0.0, 1.0, 2.0, 7.0, 9.0].map(|x| [x, 0.0, 0.0]).to_vec();
    let segments = [[0, 1], [1, 2], [3, 4]].into_iter();
    let strands = StrandMesh::new(StrandShape::Round, &[places], &[0.1; 5], segments).unwrap();
    let xs = |segment| strands.keys_at(segment, 0.0).map(|key| key.x);
    assert_eq!(xs(0), [0.0, 0.0, 1.0, 2.0]);
    assert_eq!(xs(1), [0.0, 1.0, 2.0, 2.0]);
    assert_eq!(xs(2), [7.0, 7.0, 9.0, 9.0]);
    // Straight and even: the middle lies in the middle.
    let (at, along) = StrandMesh::on_curve(StrandShape::Round, strands.keys_at(1, 0.0), 0.5);
    assert!(
        (at.x - 1.5625).abs() < 1e-6 && along.x > 0.0,
        "{at} {along}"
    );
}

#[test]
fn strands_refer_to_keys_that_are_there() {
    let places = vec![[0.0; 3]; 2];
    let segments = std::iter::once([0, 2]);
    assert!(StrandMesh::new(StrandShape::Round, &[places], &[0.1; 2], segments).is_err());
}

#[test]
fn straight_tubes_lean_as_cones_and_end_in_spheres() {
    let keys = vec![[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let segments = std::iter::once([0, 1]);
    let strands =
        StrandMesh::new(StrandShape::RoundLinear, &[keys], &[0.5, 0.1], segments).unwrap();
    let scene = scene_of(&Arc::new(strands));
    let normal = |origin: [f32; 3], direction: Vec3| {
        let hit = scene.intersect(&ray(origin, direction.to_array())).unwrap();
        let (across, lean) = StrandMesh::across_and_lean(hit.v);
        let around = StrandMesh::around(Vec3::Y, direction, across);
        around * (1.0 - lean * lean).sqrt() + Vec3::Y * lean
    };
    // The cone is tangent to both spheres: 0.4 m thinner over 2 m. A step of the sine is a 256th.
    let n = normal([0.0, 0.1, 5.0], -Vec3::Z);
    let right = Vec3::new(0.0, 0.2, 0.96f32.sqrt());
    assert!(n.abs_diff_eq(right, 3e-3), "{n}");
    // From above it is a sphere of a tenth of a metre about its end.
    let n = normal([0.06, 3.0, 0.0], -Vec3::Y);
    assert!(n.abs_diff_eq(Vec3::new(0.6, 0.8, 0.0), 5e-3), "{n}");
}

#[test]
fn curves_are_told_apart_by_where_they_begin() {
    let of = |shape, segments: &[[u32; 2]]| {
        let places = vec![[0.0; 3]; 8];
        let made = StrandMesh::new(shape, &[places], &[0.1; 8], segments.iter().copied()).unwrap();
        (0..segments.len() as u32)
            .map(|i| made.curve_of(i))
            .collect::<Vec<_>>()
    };
    let found = of(
        StrandShape::Round,
        &[[0, 1], [1, 2], [3, 4], [5, 6], [6, 7]],
    );
    assert_eq!(found, [1, 1, 2, 3, 3]);
    assert_eq!(
        of(StrandShape::Points, &[[0, 0], [1, 1], [2, 2]]),
        [0, 1, 2]
    );
}
