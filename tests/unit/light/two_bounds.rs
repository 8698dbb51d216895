use super::*;
use crate::sampler::hashed;
use std::f32::consts::{FRAC_PI_2, PI};

fn random(k: u32, i: u32) -> Vec3 {
    Vec3::new(hashed(k, i, 1), hashed(k, i, 2), hashed(k, i, 3))
}

/// Lamps of all kinds by turns.
fn lamps(count: u32) -> Vec<Emitter> {
    let lamp = |i: u32| {
        let center = random(1, i) * 20.0 - 10.0;
        let axis = (random(2, i) - 0.5).normalize();
        let shape = match i % 4 {
            0 => Shape::Area {
                center,
                normal: axis,
                edges: {
                    let u = axis.any_orthonormal_vector();
                    [u, axis.cross(u) * 0.5]
                },
                spread: if i.is_multiple_of(8) { FRAC_PI_2 } else { 0.4 },
            },
            kind => Shape::Lamp {
                center,
                radius: 0.1,
                is_sphere: kind == 1,
                cone: (kind == 3).then_some((axis, 0.6, 5.0)),
            },
        };
        Emitter {
            shape,
            energy: 0.1 + 10.0 * hashed(3, i, 0),
            drawn: Drawn::Finite(i),
        }
    };
    (0..count).map(lamp).collect()
}

/// A sheet of triangles.
fn mesh(count: u32, first: u32) -> Vec<Emitter> {
    let triangle = |i: u32| {
        let at = Vec3::new((i % 10) as f32 * 0.2, 3.0, (i / 10) as f32 * 0.2);
        Emitter {
            shape: Shape::Triangle([at, at + Vec3::X * 0.2, at + Vec3::Z * 0.2]),
            energy: 0.02,
            drawn: Drawn::Finite(first + i),
        }
    };
    (0..count).map(triangle).collect()
}

fn distant() -> [Emitter; 2] {
    [(Shape::World, 2.0), (Shape::Sun(Vec3::Y, 0.01), 3.0)].map(|(shape, energy)| Emitter {
        shape,
        energy,
        drawn: Drawn::Infinite(u32::from(matches!(shape, Shape::Sun(..)))),
    })
}

fn places() -> impl Iterator<Item = Receiver> {
    (0..60).map(|k| Receiver {
        point: random(7, k) * 24.0 - 12.0,
        normal: (k % 5 > 0).then(|| (random(8, k) - 0.5).normalize()),
        both: k % 3 == 0,
    })
}

/// The tree's turns share all out: probabilities sum to 1 where all lights shine, and to less where a turn leads to where none does.
#[test]
fn probabilities_sum_to_one() {
    for (count, triangles) in [(4, 0), (8, 12), (40, 90), (0, 1)] {
        let finite = count + triangles;
        let meshes: Vec<_> = (triangles > 0)
            .then(|| mesh(triangles, count))
            .into_iter()
            .collect();
        let lamps = lamps(count);
        let is_point = |lamp: &&Emitter| matches!(lamp.shape, Shape::Lamp { cone: None, .. });
        let points: Vec<Emitter> = lamps.iter().filter(is_point).copied().collect();
        let [of_all, of_points] = [&lamps, &points]
            .map(|lamps| TwoBounds::new(lamps, &meshes, &distant(), (finite as usize, 2)));
        let sum = |tree: &TwoBounds, at: &Receiver| {
            let far = (0..2).map(Drawn::Infinite);
            let all = (0..finite).map(Drawn::Finite).chain(far);
            all.map(|drawn| tree.probability(at, drawn)).sum::<f32>()
        };
        for at in places() {
            assert!(sum(&of_all, &at) < 1.0 + 1e-4, "{at:?}");
            // The world shines everywhere.
            assert!(of_all.probability(&at, Drawn::Infinite(0)) > 0.0);
            if at.both || at.normal.is_none() {
                let sum = sum(&of_points, &at);
                assert!((sum - 1.0).abs() < 1e-4, "{sum} {at:?}");
            }
        }
    }
}

/// Values of the formulas by hand: two points over a floor, at 1 and at 2 metres, as strong and four times as strong. Both give the same at
/// most; at least as well, as they have no size.
#[test]
fn points_count_by_the_inverse_square() {
    let point = |x: f32, y: f32, energy: f32, i: u32| Emitter {
        shape: Shape::Lamp {
            center: Vec3::new(x, y, 0.0),
            radius: 0.0,
            is_sphere: true,
            cone: None,
        },
        energy,
        drawn: Drawn::Finite(i),
    };
    let at = Receiver {
        point: Vec3::ZERO,
        normal: Some(Vec3::Y),
        both: false,
    };
    let share = |lamps: &[Emitter]| {
        let tree = TwoBounds::new(lamps, &[], &[], (2, 0));
        tree.probability(&at, Drawn::Finite(0))
    };
    let same = share(&[point(0.0, 1.0, 1.0, 0), point(0.0, 2.0, 4.0, 1)]);
    assert!((same - 0.5).abs() < 1e-6, "{same}");
    // One that is seen aslant, by the cosine.
    let aslant = share(&[point(0.0, 1.0, 1.0, 0), point(1.0, 1.0, 2.0, 1)]);
    assert!(
        (aslant - 1.0 / (1.0 + 0.5f32.sqrt())).abs() < 1e-6,
        "{aslant}"
    );
    // What is below an opaque surface is never drawn, below one that lets light through it is.
    let below = [point(0.0, 1.0, 1.0, 0), point(0.0, -1.0, 1.0, 1)];
    assert_eq!(share(&below), 1.0);
    let tree = TwoBounds::new(&below, &[], &[], (2, 0));
    let through = Receiver { both: true, ..at };
    assert_eq!(tree.probability(&through, Drawn::Finite(0)), 0.5);
}

/// The greatest angle counts for the most, the smallest for the least: a square light overhead at a metre, a metre wide, beside a point of
/// the same energy.
#[test]
fn the_least_of_an_area_light_is_by_its_corners() {
    let area = Emitter {
        shape: Shape::Area {
            center: Vec3::Y,
            normal: -Vec3::Y,
            edges: [Vec3::X, Vec3::Z],
            spread: FRAC_PI_2,
        },
        energy: 1.0,
        drawn: Drawn::Finite(0),
    };
    let lamp = Emitter {
        shape: Shape::Lamp {
            center: Vec3::Y,
            radius: 0.0,
            is_sphere: true,
            cone: None,
        },
        energy: 1.0,
        drawn: Drawn::Finite(1),
    };
    let at = Receiver {
        point: Vec3::ZERO,
        normal: Some(Vec3::Y),
        both: false,
    };
    let tree = TwoBounds::new(&[area, lamp], &[], &[], (2, 0));
    // Corners: 1.5 m², a cosine of √(2/3) on both sides; at least 2/3 / 1.5 = 4/9 of the point's.
    let least = 4.0 / 9.0;
    let expected = 0.5 * (0.5 + least / (1.0 + least));
    let told = tree.probability(&at, Drawn::Finite(0));
    assert!((told - expected).abs() < 1e-5, "{told} {expected}");
    // Full turns hold all directions.
    let cone = Measure::of(&lamp).and(&Measure::of(&area)).cone();
    assert!(
        format!("{cone:?}").contains(&format!("normals: {PI:?}")),
        "{cone:?}"
    );
}

/// Eight at a time are what each is by itself, bit for bit; from beside them, within them and at their middle.
#[test]
fn side_by_side_is_one_by_one() {
    let tree = TwoBounds::new(&lamps(40), &[mesh(90, 40)], &distant(), (130, 2));
    let near: Vec<&Node> = (tree.nodes.iter())
        .filter(|node| !node.is_distant && node.measure.min.cmple(node.measure.max).all())
        .collect();
    let at_middles = near.iter().map(|node| Receiver {
        point: 0.5 * (node.measure.min + node.measure.max),
        normal: Some(Vec3::Y),
        both: false,
    });
    let (mut most, mut least) = (0, 0);
    for at in places().chain(at_middles) {
        for nodes in near.windows(LANES) {
            let clusters = std::array::from_fn(|lane| (&nodes[lane].measure, &nodes[lane].cone));
            let found = side_by_side::of_clusters(clusters, &at);
            for (node, found) in nodes.iter().zip(found) {
                let expected = node.measure.bounds(&node.cone, false, &at);
                assert_eq!(found, expected, "{node:?} {at:?}");
                most += u32::from(expected.0 > 0.0);
                least += u32::from(expected.1 > 0.0);
            }
        }
    }
    assert!(most > 10_000 && least > 1000, "{most} {least}");
}
