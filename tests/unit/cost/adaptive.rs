use super::*;
use crate::film::Layer;

/// 40 × 4 pixels, whose tiles are 2 × 2.
fn picture(error: impl Fn(usize, usize) -> f32) -> Picture {
    let pixels = (0..160).map(|i| error(i % 40, i / 40));
    Picture {
        width: 40,
        height: 4,
        layers: vec![Layer {
            name: Pass::Error.name().into(),
            channels: vec!["X".into()],
            data: pixels.collect(),
        }],
    }
}

#[test]
fn the_worst_tile_is_that_of_all_rounds() {
    let mut tiles = Tiles::default();
    // One pixel of four in the second tile of the lower row, then all of the last one.
    tiles.add(&picture(|x, y| if (x, y) == (2, 2) { 0.4 } else { 0.0 }));
    assert!((tiles.worst(1) - 0.2).abs() < 1e-6);
    tiles.add(&picture(|x, y| if x > 37 && y > 1 { 0.3 } else { 0.0 }));
    assert!((tiles.worst(2) - (0.09f64 / 2.0).sqrt()).abs() < 1e-6);
}

#[test]
fn a_tolerance_that_is_out_of_reach_is_measured_where_it_is_not() {
    let of = |samples, pixel_error_target| RenderSettings {
        samples,
        pixel_error_target,
        ..RenderSettings::default()
    };
    // The mean error is 20 % after 256 samples.
    let (measured, picture) = (of(256, 0.0), picture(|x, _| if x < 20 { 0.1 } else { 0.3 }));
    let plan = |full| {
        let plan = Plan::new(&full, &measured, &picture);
        (plan.tolerance, plan.adaptive.pixel_error_target, plan.more)
    };
    let near = |a: (f64, f64, f64), b: (f64, f64, f64)| {
        let off = |a: f64, b: f64| (a / b - 1.0).abs();
        assert!(
            off(a.0, b.0) + off(a.1, b.1) + off(a.2, b.2) < 1e-6,
            "{a:?} {b:?}"
        );
    };
    near(plan(of(1024, 0.05)), (0.05, 0.2, 16.0));
    near(plan(of(1024, 0.5)), (0.5, 0.5, 1.0));
    // Not asked for: half of the error by four times the samples.
    near(plan(of(1024, 0.0)), (0.1, 0.2, 4.0));
    // Few samples were measured: adaptive sampling takes 64, with half of their error.
    let few = Plan::new(&of(1024, 0.05), &of(16, 0.0), &picture);
    near(
        (few.tolerance, few.adaptive.pixel_error_target, few.more),
        (0.05, 0.1, 4.0),
    );
}
