use super::*;

fn mean(map: &[f32]) -> f64 {
    map.iter().map(|error| f64::from(*error)).sum::<f64>() / map.len() as f64
}

#[test]
fn flat_pictures_have_the_colour_error_alone() {
    // White and black are 100 apart in HyAB, 100^0.7 = 25.12; the largest, green and blue, 41.28. Beyond 0.4 of that the
    // error grows from 0.95 to 1: 0.95 + 0.05 (25.12 - 16.51) / (41.28 - 16.51) = 0.9674.
    let map = ldr(70, 67, &|_| [[0.0; 3], [1.0; 3]]);
    for error in &map {
        assert!((error - 0.9674).abs() < 1e-4, "{error}");
    }
    // Green and blue are the most different colours there are.
    let map = ldr(3, 2, &|_| [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!((mean(&map) - 1.0).abs() < 1e-5);
    // Middle grey, L* = 50: lightness differs by 50, below the knee of 0.4 · 41.28: 0.95 · 50^0.7 / 16.51 = 0.8896.
    let grey = 0.184_187;
    let map = ldr(3, 2, &|_| [[0.0; 3], [grey; 3]]);
    assert!((mean(&map) - 0.8896).abs() < 1e-3, "{}", mean(&map));
}

#[test]
fn the_same_picture_has_no_error_and_the_order_no_say() {
    let noise = |at: usize, seed: u32| {
        let hash = (at as u32).wrapping_mul(0x9E37_79B9) ^ seed.wrapping_mul(0x85EB_CA6B);
        let hash = (hash ^ hash >> 15).wrapping_mul(0x2C1B_3C6D);
        [0, 8, 16].map(|shift| (hash >> shift & 255) as f32 / 255.0)
    };
    assert!(
        ldr(33, 130, &|at| [noise(at, 1); 2])
            .iter()
            .all(|error| *error == 0.0)
    );
    let there = ldr(33, 130, &|at| [noise(at, 1), noise(at, 2)]);
    let back = ldr(33, 130, &|at| [noise(at, 2), noise(at, 1)]);
    assert_eq!(there, back);
    assert!(there.iter().all(|error| (0.0..=1.0).contains(error)));
}

#[test]
fn an_edge_is_seen_more_than_its_colours() {
    // A line one pixel wide on grey, and the same light spread over all: the line's features raise the error.
    let line = ldr(41, 41, &|at| {
        [[0.2; 3], [if at % 41 == 20 { 0.4 } else { 0.2 }; 3]]
    });
    let flat = ldr(41, 41, &|_| [[0.2; 3], [0.2 + 0.2 / 41.0; 3]]);
    assert!(line[20 * 41 + 20] > 3.0 * flat[20 * 41 + 20]);
}

#[test]
fn filters_have_the_sums_they_should() {
    let eye = Eye::new(PIXELS_PER_DEGREE);
    // 3 √(0.04 / 2π²) · 67.02 = 9.05 and 3 · 0.041 · 67.02 = 8.24 pixels.
    assert_eq!((eye.color_radius, eye.feature_radius), (10, 9));
    let sum = |filter: &[f32]| filter.iter().map(|w| f64::from(*w)).sum::<f64>();
    let [lightness, red_green, one, two] = &eye.color;
    assert!((sum(lightness) - 1.0).abs() < 1e-6);
    assert!((sum(red_green) - 1.0).abs() < 1e-6);
    assert!((sum(one).powi(2) + sum(two).powi(2) - 1.0).abs() < 1e-6);
    let [gauss, slope, curvature] = &eye.feature;
    assert!((sum(gauss) - 1.0).abs() < 1e-6);
    for derivative in [slope, curvature] {
        assert!(sum(derivative).abs() < 1e-6);
        let size: f64 = derivative.iter().map(|w| f64::from(w.abs())).sum();
        assert!((size - 2.0).abs() < 1e-6);
    }
}

#[test]
fn exposures_go_from_the_brightest_to_the_median() {
    // The tone mapper shows its input of 0.85 as such, by its own formula.
    let exposed = input_of(EXPOSED_TO);
    assert!((aces(exposed) - 0.85).abs() < 1e-6);
    let grey = |value: f32| [value; 3];
    let exposures = Exposures::of([grey(8.0), grey(1.0), grey(0.25), grey(1.0)]).unwrap();
    assert!((exposures.start - (exposed / 8.0).log2()).abs() < 1e-6);
    assert!((exposures.stop - exposed.log2()).abs() < 1e-6);
    assert_eq!(exposures.count, 3);
    // A flat picture still has two, and black says nothing.
    assert_eq!(Exposures::of([grey(1.0)]).unwrap().count, 2);
    let mostly_black = Exposures::of([grey(0.0), grey(0.0), grey(0.0), grey(4.0)]).unwrap();
    assert!((mostly_black.stop - (exposed / 4.0).log2()).abs() < 1e-6);
    assert_eq!(Exposures::of([grey(0.0), grey(-1.0)]), None);
    assert_eq!(Exposures::of([]), None);
}

#[test]
fn hdr_finds_the_exposure_that_shows_most() {
    // Ten times as bright as white: LDR sees nothing, some exposure does; a factor of two all over is seen the most where
    // the median is, which is where the last exposure shows it.
    let exposures = Exposures::of([[10.0; 3]]).unwrap();
    let map = hdr(12, 70, exposures, &|_| [[10.0; 3], [20.0; 3]]);
    let one = ldr(12, 70, &|_| {
        [10.0, 20.0].map(|value| [aces(value * exposures.start.exp2()); 3])
    });
    assert_eq!(map, one);
    assert!(mean(&map) > 0.1);
    // The ends of f32 at the last exposure there can be.
    let far = Exposures::of([[f32::MAX; 3], [1e-45; 3], [1e-45; 3]]).unwrap();
    let map = hdr(3, 1, far, &|at| {
        [[[f32::MAX; 3], [0.0; 3], [1e-45; 3]][at], [f32::MAX; 3]]
    });
    assert!(map.iter().all(|error| error.is_finite()), "{map:?}");
}
