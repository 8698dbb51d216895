use super::super::estimate::LEAST_SHARE;
use super::*;

fn emitters(n: usize) -> Vec<LightBounds> {
    (0..n)
        .map(|i| {
            let r = |k: u32| crate::sampler::hashed(k, i as u32, 17);
            let center = Vec3::new(r(1), r(2), r(3)) * 20.0 - 10.0;
            let sphere = i % 3 == 0;
            let axis = (Vec3::new(r(4), r(5), r(6)) - 0.5).normalize();
            LightBounds {
                min: center - 0.1,
                max: center + 0.1,
                intensity: r(7) * 10.0 + 0.01,
                axis,
                normals: if sphere { Angle::ALL } else { Angle::ZERO },
                cos_emission: 0.0,
                two_sided: i % 2 == 0,
                front: None,
            }
        })
        .collect()
}

/// Normals all over a cone are priced as the cone is, whatever its angle.
#[test]
fn heaps_are_priced_as_their_bounds() {
    for cos in [1.0f32, 0.9, 0.5, 0.0, -0.5, -0.9, -1.0] {
        let flat = emitters(2)[1];
        let n = 1000;
        let heap = (0..n).fold(Heap::NONE, |heap, i| {
            // A spiral, even by area.
            let z = 1.0 - (1.0 - cos) * (i as f32 + 0.5) / n as f32;
            let (y, x) = (i as f32 * 2.399_963).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            heap.and(&Heap::of(&LightBounds {
                axis: Vec3::new(x * r, y * r, z),
                ..flat
            }))
        });
        let bounds = LightBounds {
            intensity: flat.intensity * n as f32,
            normals: Angle {
                sin: (1.0 - cos * cos).sqrt(),
                cos,
            },
            ..flat
        };
        let ratio = heap.measure() / measure(&bounds);
        assert!((ratio - 1.0).abs() < 2e-3, "{cos}: {ratio}");
    }
}

#[test]
fn probabilities_sum_to_one_and_agree_with_the_draws() {
    let lights = emitters(300);
    let tree = Tree::new(&lights);
    for (point, normal) in [
        (Vec3::new(1.0, 2.0, 3.0), Some(Vec3::Y)),
        (Vec3::new(-30.0, 0.0, 0.0), None),
        (lights[7].center(), Some(Vec3::X)),
    ] {
        let place = (point, normal);
        let (first, _) = tree.look(place);
        let sum: f64 = (0..300)
            .map(|i| f64::from(tree.probability(&first, place, i)))
            .sum();
        let n = 20_000;
        let mut drawn = 0f64;
        for k in 0..n {
            // A node whose bounds promise light may have children that can't send any: then
            // nothing is drawn, and the probabilities sum to less than 1.
            let Some(choice) = tree.sample(&first, place, (k as f32 + 0.5) / n as f32) else {
                continue;
            };
            drawn += 1.0 / f64::from(n);
            let expected = tree.probability(&first, place, choice.emitter);
            assert!((choice.probability / expected - 1.0).abs() < 1e-5);
        }
        // Each of at most 300 emitters may lose one of the 20,000 strata at its ends.
        assert!((sum - drawn).abs() < 300.0 / f64::from(n), "{sum} {drawn}");
        // Half of the space is below the horizon and a third of the emitters face one way:
        // clusters promise about twice what they hold (0.48 at the first point).
        assert!(drawn > 0.4, "{drawn} {sum} at {point}");
    }
}

/// No emitter that can light a point has probability 0: sampled points on emitters that see
/// the receiver are compared with the estimate.
#[test]
fn what_can_arrive_can_be_drawn() {
    let lights = emitters(400);
    let tree = Tree::new(&lights);
    for k in 0..400u32 {
        let r = |j: u32| crate::sampler::hashed(j, k, 99);
        let point = Vec3::new(r(1), r(2), r(3)) * 30.0 - 15.0;
        let normal = (Vec3::new(r(4), r(5), r(6)) - 0.5).normalize();
        let place = (point, Some(normal));
        let (first, _) = tree.look(place);
        for (i, light) in lights.iter().enumerate() {
            let on = light.center() + (Vec3::new(r(7), r(8), r(9)) - 0.5) * 0.2;
            let wi = (on - point).normalize();
            let cos_emitted = if light.normals == Angle::ALL {
                1.0
            } else if light.two_sided {
                light.axis.dot(wi).abs()
            } else {
                -light.axis.dot(wi)
            };
            if wi.dot(normal) > 0.0 && cos_emitted > 0.0 {
                assert!(tree.probability(&first, place, i as u32) > 0.0, "{k} {i}");
            }
        }
    }
}

/// However strong the other one is, a light that may shine is drawn once in 1024 times.
#[test]
fn no_light_starves_beside_a_stronger_one() {
    let at = |x: f32, intensity: f32| LightBounds {
        min: Vec3::new(x, 0.0, 0.0),
        max: Vec3::new(x, 0.0, 0.0),
        intensity,
        axis: Vec3::Z,
        normals: Angle::ALL,
        cos_emission: 1.0,
        two_sided: false,
        front: None,
    };
    for stronger in [1e4, 1e8, 1e30] {
        let tree = Tree::new(&[at(-1.0, stronger), at(1.0, 1.0)]);
        let place = (Vec3::ZERO, None);
        let (first, _) = tree.look(place);
        let sum = tree.probability(&first, place, 0) + tree.probability(&first, place, 1);
        assert!((sum - 1.0).abs() < 1e-6);
        let n = 1 << 16;
        let weak = (0..n)
            .filter_map(|k| tree.sample(&first, place, k as f32 / n as f32))
            .filter(|choice| choice.emitter == 1)
            .inspect(|choice| {
                assert!((LEAST_SHARE..1.2 * LEAST_SHARE).contains(&choice.probability))
            })
            .count();
        // The share of the other, rounded, may take one of the strata.
        assert!(((n >> 10) - 1..(n >> 10) * 6 / 5).contains(&weak), "{weak}");
    }
}

/// Between a number of 24 bits and the next, and the same for a scene of twice the size.
#[test]
fn finer_numbers_stay_in_their_cell() {
    for k in 0..1000u32 {
        let r = |j: u32| sampler::hashed(j, k, 5);
        let (u, point) = (r(0), Vec3::new(r(1), -r(2), r(3)));
        let finer_u = finer(u, point);
        let cell = f64::from(u)..f64::from(u) + 1.0 / 16_777_216.0;
        assert!(cell.contains(&finer_u) && finer_u < 1.0);
        assert_eq!(finer_u, finer(u, point * 1024.0));
    }
}

/// Built by several threads: the same tree, from which each emitter is drawn as the bounds above it say.
#[test]
fn large_trees_are_the_same_by_any_number_of_threads() {
    let lights = emitters(1 << 15);
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        let mut order: Vec<u32> = (0..lights.len() as u32).collect();
        let mut nodes = Vec::new();
        pool.install(|| build(&lights, &mut order, 0, &mut nodes));
        let facts = nodes
            .iter()
            .map(|n| (n.index, n.leaf, n.bounds.min, n.bounds.max));
        facts.collect::<Vec<_>>()
    };
    let (one, three) = (by(1), by(3));
    assert_eq!(one, three);
    // Preorder: the first child is next, the second where the node says, and every emitter is reached once.
    let mut seen = vec![false; lights.len()];
    let mut stack = vec![0usize];
    while let Some(at) = stack.pop() {
        let (index, leaf, ..) = one[at];
        if leaf {
            assert!(!std::mem::replace(&mut seen[index as usize], true));
        } else {
            stack.extend([at + 1, index as usize]);
        }
    }
    assert!(seen.into_iter().all(|s| s));
}

#[test]
fn many_lights_in_one_place_and_none_at_all_are_fine() {
    let one = emitters(1)[0];
    let tree = Tree::new(&vec![one; 5000]);
    let place = (Vec3::ZERO, None);
    let (first, _) = tree.look(place);
    let sum: f64 = (0..5000)
        .map(|i| f64::from(tree.probability(&first, place, i)))
        .sum();
    assert!((sum - 1.0).abs() < 1e-3);
    let none = Tree::new(&[]);
    assert!(none.sample(&none.look(place).0, place, 0.5).is_none());
}
