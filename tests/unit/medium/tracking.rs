use super::*;
use crate::medium;
use crate::sampler::hashed;

/// Extinction that grows along x, by channel; it scatters a share.
fn local(at: Vec3, slope: Vec3, albedo: f32, emission: f32) -> Local {
    let extinction = slope * at.x.max(0.0);
    Local {
        extinction,
        scattering: extinction * albedo,
        emission: Vec3::splat(emission),
    }
}

const SLOPE: Vec3 = Vec3::new(0.5, 1.0, 2.0);
/// Of the box of [`grid`], along x.
const LENGTH: f32 = 2.0;

/// Bounds by a share of what is there.
fn grid(share: f32, emission: f32) -> Majorants {
    let corners = (Vec3::new(0.0, -1.0, -1.0), Vec3::new(LENGTH, 1.0, 1.0));
    let there = |at| local(at, SLOPE * share, 0.5, emission);
    Majorants::new(even(corners.0, corners.1, 8), there, |_, _| None)
}

fn draws(sample: u32) -> impl FnMut() -> f32 {
    let mut count = 0;
    move || {
        count += 1;
        hashed(sample, 7, count)
    }
}

/// Mean of a number of samples, and its standard error.
fn estimate(samples: u32, mut of: impl FnMut(u32) -> Vec3) -> (Vec3, Vec3) {
    let (mut sum, mut squares) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
    for sample in 0..samples {
        let value = of(sample).as_dvec3();
        sum += value;
        squares += value * value;
    }
    let n = f64::from(samples);
    let mean = sum / n;
    let variance = (squares / n - mean * mean) / (n - 1.0);
    (
        mean.as_vec3(),
        variance.max(glam::DVec3::ZERO).map(f64::sqrt).as_vec3(),
    )
}

/// Four and a half standard errors: one test of some ten thousand fails by chance, and these have fixed numbers.
fn agrees((mean, error): (Vec3, Vec3), expected: Vec3, what: &str) {
    let off = (mean - expected).abs();
    let bound = error * 4.5 + 1e-6;
    assert!(
        off.cmple(bound).all(),
        "{what}: {mean} {expected} ± {error}"
    );
}

fn through(to: f32) -> Vec3 {
    (-SLOPE * (to * to / 2.0)).exp()
}

const RAY: (Vec3, Vec3) = (Vec3::new(-1.0, 0.1, 0.2), Vec3::X);

/// Bounds that are too low, by a voxel or by all of them, make noise and no error.
#[test]
fn transmittance_is_right_in_the_mean_whatever_the_bounds() {
    for share in [1.0, 0.6, 3.0] {
        let grid = grid(share, 0.0);
        let found = estimate(60_000, |sample| {
            let mut marches = [grid.along(RAY.0, RAY.1, 0.0)];
            medium::share(&mut marches, 0.0, (0.0, 9.0), draws(sample), |t| {
                local(RAY.0 + RAY.1 * t, SLOPE, 0.5, 0.0)
            })
        });
        agrees(found, through(LENGTH), &format!("bounds of {share}"));
    }
}

/// Where bounds are far too low weights would grow with each collision; the first one mends the bound. Each cell has one collision below
/// its own bound at the most until then, and that has a weight of 1 - 1/share.
#[test]
fn bounds_that_are_far_too_low_are_raised() {
    for share in [0.3, 0.1, 0.03f32] {
        let grid = grid(share, 0.0);
        let samples = 60_000;
        let found = estimate(samples, |sample| {
            let mut marches = [grid.along(RAY.0, RAY.1, 0.0)];
            medium::share(&mut marches, 0.0, (0.0, 9.0), draws(sample), |t| {
                local(RAY.0 + RAY.1 * t, SLOPE, 0.5, 0.0)
            })
        });
        agrees(found, through(LENGTH), &format!("bounds of {share}"));
        let most = (1.0 / share - 1.0).max(1.0) / (samples as f32).sqrt();
        assert!(
            found.1.max_element() < most,
            "bounds of {share}: {found:?}, {most}"
        );
    }
}

/// Of blue light a way of 2 m has 2e10 free paths, of red light one: without lower bounds it would take as many collisions, and in
/// f32 none would move on at a distance of 100 m.
#[test]
fn what_is_thick_for_one_channel_alone_ends_and_keeps_the_others() {
    let there = Local {
        extinction: Vec3::new(0.5, 0.25, 1e10),
        scattering: Vec3::ZERO,
        emission: Vec3::ZERO,
    };
    let expected = Vec3::new((-1f32).exp(), (-0.5f32).exp(), 0.0);
    let collisions = std::cell::Cell::new(0u64);
    let local = |_| {
        collisions.set(collisions.get() + 1);
        there
    };
    let samples = 2000;
    let way = (100.0, 102.0);
    let shares = estimate(samples, |sample| {
        medium::share(&mut [], 1e10, way, draws(sample), local)
    });
    agrees(shares, expected, "transmittance");
    let flights = estimate(samples, |sample| {
        match fly(&mut [], 1e10, way, (Vec3::ONE, true), draws(sample), local).0 {
            Flight::Through(weight) => weight,
            Flight::Scattered(..) => Vec3::ZERO,
        }
    });
    agrees(flights, expected, "what flies through");
    assert!(collisions.get() < u64::from(4 * samples * 20 * MOST_COLLISIONS));
}

/// Steps between nothing and something that lie a cell away from where the bounds were taken: there the bound is the floor of empty
/// cells, or one of nothing at all.
#[test]
fn bounds_that_are_a_cell_off_make_no_error() {
    let step = |x: f32| {
        let extinction = if (0.75..1.25).contains(&x) { 3.0 } else { 0.0 };
        Local {
            extinction: Vec3::splat(extinction),
            ..Local::default()
        }
    };
    let corners = (Vec3::new(0.0, -1.0, -1.0), Vec3::new(LENGTH, 1.0, 1.0));
    let cell = LENGTH / 16.0;
    for aside in [0.0, cell, -cell, 3.0 * cell] {
        let there = |at: Vec3| step(at.x + aside);
        let grid = Majorants::new(even(corners.0, corners.1, 16), there, |_, _| None);
        let found = estimate(60_000, |sample| {
            let mut marches = [grid.along(RAY.0, RAY.1, 0.0)];
            medium::share(&mut marches, 0.0, (0.0, 9.0), draws(sample), |t| {
                step((RAY.0 + RAY.1 * t).x)
            })
        });
        let known = Vec3::splat((-1.5f32).exp());
        agrees(found, known, &format!("bounds {aside} aside"));
    }
}

/// What comes through, what is scattered and what is emitted have known means, also over a medium that is even.
#[test]
fn flights_have_known_means() {
    let (albedo, emission) = (0.7, 0.3);
    let throughput = Vec3::new(1.0, 0.5, 0.25);
    for (share, scatters) in [(1.0, true), (0.6, true), (1.0, false)] {
        let grid = grid(share, emission);
        let fly_of = |sample: u32| {
            let mut marches = [grid.along(RAY.0, RAY.1, 1.0)];
            let light = (throughput, scatters);
            fly(&mut marches, 0.0, (1.0, 3.0), light, draws(sample), |t| {
                local(RAY.0 + RAY.1 * t, SLOPE, albedo, emission)
            })
        };
        let through = through(LENGTH);
        let passed = estimate(80_000, |sample| match fly_of(sample).0 {
            Flight::Through(weight) => weight,
            Flight::Scattered(..) => Vec3::ZERO,
        });
        agrees(passed, through, "through");
        let scattered = estimate(80_000, |sample| match fly_of(sample).0 {
            Flight::Scattered(_, weight) => weight,
            Flight::Through(_) => Vec3::ZERO,
        });
        let lost = if scatters {
            (1.0 - through) * albedo
        } else {
            Vec3::ZERO
        };
        agrees(scattered, lost, "scattered");
        if !scatters {
            // ∫ ε exp(−a x²/2) dx by Simpson's rule.
            let n = 1000;
            let h = LENGTH / n as f32;
            let at = |i: usize| (-SLOPE * (i as f32 * h).powi(2) / 2.0).exp();
            let sum: Vec3 = (0..n / 2)
                .map(|i| at(2 * i) + at(2 * i + 1) * 4.0 + at(2 * i + 2))
                .sum();
            let light = estimate(80_000, |sample| fly_of(sample).1);
            agrees(light, sum * (emission * h / 3.0), "emitted");
        }
    }
}

/// Whatever the ray, the bounds cover its way through the box without a gap, and are those of the cells it is in.
#[test]
fn marches_cover_the_way() {
    let grid = grid(1.0, 0.0);
    let (low, high) = grid.corners();
    for sample in 0..2000 {
        let mut draw = draws(sample);
        let mut point = || Vec3::new(draw(), draw(), draw()) * 6.0 - 3.0;
        let (from, to) = (point(), point());
        let axis = sample % 5;
        let mut direction = (to - from).normalize();
        // Some rays go along axes.
        if axis < 3 {
            direction = [Vec3::X, Vec3::NEG_Y, Vec3::Z][axis as usize];
        }
        let mut march = grid.along(from, direction, 0.0);
        let mut t = 0.0;
        for _ in 0..64 {
            let end = march.end;
            assert!(end >= t, "{sample}: {t} {end}");
            if end.is_finite() && end - t > 1e-4 {
                let middle = from + direction * (t + end) / 2.0;
                // The point that bounds it is not further off than half a cell.
                let point = middle - Vec3::X * (LENGTH / 16.0);
                let most = local(point, SLOPE, 0.5, 0.0).extinction.max_element();
                let inside = middle.cmpge(low).all() && middle.cmple(high).all();
                assert!(
                    !inside || march.majorant >= most,
                    "{sample}: {middle} {most}"
                );
                assert!(inside || march.majorant == 0.0, "{sample}: {middle}");
            }
            if end == f32::INFINITY {
                break;
            }
            t = end;
            march.advance();
        }
        assert_eq!(march.end, f32::INFINITY, "{sample}");
        assert_eq!(march.majorant, 0.0, "{sample}");
    }
}

/// Thick as a wall, and thin as nothing.
#[test]
fn extremes_end_and_stay_finite() {
    for density in [1e-9f32, 1e6] {
        let thick = |_: Vec3| Local {
            extinction: Vec3::splat(density),
            scattering: Vec3::splat(density),
            emission: Vec3::ZERO,
        };
        let grid = Majorants::new(widening(Vec3::ZERO, Vec3::ONE, 4, 1.0), thick, |_, _| None);
        let (from, direction) = (Vec3::new(0.5, 0.5, -1.0), Vec3::Z);
        let shares = estimate(1000, |sample| {
            let mut marches = [grid.along(from, direction, 0.0)];
            let there = |t: f32| thick(from + direction * t);
            medium::share(
                &mut marches,
                0.0,
                (0.0, f32::INFINITY),
                draws(sample),
                there,
            )
        });
        agrees(shares, Vec3::splat((-density).exp()), "thick and thin");
    }
}

/// Planes about a box go on to where they shall, and only outwards.
#[test]
fn planes_widen() {
    let (low, high) = (Vec3::new(-1.0, 5.0, -3e4), Vec3::new(1.0, 6.0, 3e4));
    let [x, y, z] = widening(low, high, 4, 1e4);
    for (planes, inner) in [(&x, true), (&y, true), (&z, false)] {
        assert!(
            planes.windows(2).all(|pair| pair[0] < pair[1]),
            "{planes:?}"
        );
        assert!(planes.len() < 64, "{}", planes.len());
        let ends = (planes[0], planes[planes.len() - 1]);
        assert_eq!(ends == (-1e4, 1e4), inner, "{ends:?}");
    }
}

/// What is the same all over needs one cell; what is nowhere but in a part keeps its cells along that axis alone.
#[test]
fn cells_are_merged_where_ways_get_cheaper() {
    let corners = (Vec3::splat(-10.0), Vec3::splat(10.0));
    let made = |there: &(dyn Fn(Vec3) -> f32 + Sync)| {
        let there = |at: Vec3| Local {
            extinction: Vec3::splat(there(at)),
            ..Local::default()
        };
        Majorants::new(even(corners.0, corners.1, 32), there, |_, _| None)
    };
    assert_eq!(made(&|_| 0.1).count(), IVec3::ONE);
    let layer = made(&|at| if at.y < -5.0 { 1.0 } else { 0.0 });
    assert_eq!((layer.count().x, layer.count().z), (1, 1));
    assert!(layer.count().y >= 3, "{}", layer.count());
    let thick = made(&|at| if at.length() < 5.0 { 10.0 } else { 0.0 });
    assert!(thick.count().min_element() >= 16, "{}", thick.count());
    // No bound is lost.
    for grid in [layer, thick] {
        let halved = grid.halved(1).unwrap();
        for (number, value) in grid.values.iter().enumerate() {
            let cell = grid.cell(number);
            let both = halved.number(IVec3::new(cell.x, cell.y / 2, cell.z));
            assert!(halved.values[both] >= *value);
        }
    }
}

/// Light that is taken away where nothing else is: no event asks for it, as in Cycles.
#[test]
fn what_only_takes_light_is_not_asked_for() {
    let of = |extinction: f32, emission: [f32; 3]| {
        let local = Local {
            extinction: Vec3::splat(extinction),
            scattering: Vec3::ZERO,
            emission: Vec3::from(emission),
        };
        local.is_asked_for()
    };
    assert!(!of(0.0, [-1.0, -1.0, -0.1]) && !of(0.0, [0.0; 3]) && !of(1.0, [0.0; 3]));
    assert!(of(0.0, [-1.0, 0.2, 0.0]) && of(0.1, [-1.0; 3]) && of(0.1, [1.0; 3]));
    let corners = (Vec3::ZERO, Vec3::ONE);
    let greatest = |emission: f32| {
        let there = |_| local(Vec3::ZERO, Vec3::ZERO, 0.0, emission);
        let bounds = Majorants::new(even(corners.0, corners.1, 2), there, |_, _| None);
        bounds.values.iter().copied().fold(0.0, f32::max)
    };
    assert_eq!(greatest(-1.0), 0.0);
    assert!(greatest(1.0) > 0.0);
}
