use super::*;

/// Points beside the ray: near, far, behind, before its end and beyond it.
const CASES: [(f32, f32, f32); 7] = [
    (1.0, 0.5, 2.0),
    (-3.0, 0.01, 2.0),
    (5.0, 2.0, 2.0),
    (1.0, 1e4, 2.0),
    (1e4, 1.0, 2.0),
    (0.3, 0.2, f32::INFINITY),
    (-2.0, 5.0, f32::INFINITY),
];

fn of((along, beside, end): (f32, f32, f32)) -> Equiangular {
    let point = Vec3::new(beside, 0.0, along);
    Equiangular::new((Vec3::ZERO, Vec3::Z), end, (point, 0.0)).expect("a point beside the ray")
}

#[test]
fn numbers_become_shares_of_the_angle() {
    for case in CASES {
        let (along, beside, end) = case;
        let drawn = of(case);
        let (along, beside) = (f64::from(along), f64::from(beside));
        let angle = |t: f64| ((t - along) / beside).atan();
        let last = if end.is_finite() {
            angle(f64::from(end))
        } else {
            std::f64::consts::FRAC_PI_2
        };
        let mut before = 0.0;
        for i in 1..64 {
            let u = i as f32 / 64.0;
            let t = drawn.sample(u);
            assert!(t >= before && t <= end, "{case:?}: {t}");
            before = t;
            // f32 tells angles apart by 6e-8 of the whole; far points see the way under a small one.
            let share = (angle(f64::from(t)) - angle(0.0)) / (last - angle(0.0));
            assert!((share - f64::from(u)).abs() < 2e-4, "{case:?}: {u} {share}");
        }
    }
}

#[test]
fn densities_have_the_integral_one() {
    for case in CASES.into_iter().filter(|case| case.2.is_finite()) {
        let drawn = of(case);
        let steps = 200_000;
        let width = f64::from(case.2) / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|i| f64::from(drawn.density(((f64::from(i) + 0.5) * width) as f32)) * width)
            .sum();
        assert!((sum - 1.0).abs() < 1e-3, "{case:?}: {sum}");
    }
}

#[test]
fn a_point_on_the_ray_is_none() {
    let on = |radius| Equiangular::new((Vec3::ZERO, Vec3::Z), 1.0, (Vec3::Z, radius));
    assert_eq!(on(0.0), None);
    // A lamp there is as far as it is large.
    assert_eq!(on(0.5).map(|angle| angle.height()), Some(0.5));
    assert_eq!(
        Equiangular::new((Vec3::ZERO, Vec3::Z), 1.0, (Vec3::NAN, 0.0)),
        None
    );
}
