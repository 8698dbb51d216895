use super::*;

fn agree<H: Cellular<3>>(metric: VoronoiMetric, randomness: f32) {
    let cells = Cells::<3, H> {
        randomness,
        smoothness: 0.0,
        metric,
        exponent: 0.5,
        hash: PhantomData,
    };
    for number in 0..3000 {
        let x = number as f32;
        let (cell, local) = split([x * 0.173 - 200.0, (x * 0.7).sin() * 40.0, 9.0 - x * 1.37]);
        let within = cells.least_within_bounds(cell, local);
        assert_eq!(cells.least_of_all(cell, local), within, "{metric:?} at {x}");
    }
    // All eight corners are as far from the middle.
    let (cell, local) = split([0.5; 3]);
    let within = cells.least_within_bounds(cell, local);
    assert_eq!(cells.least_of_all(cell, local), within, "{metric:?}");
    let nowhere = [f32::NAN; 3];
    let within = cells.least_within_bounds(nowhere, nowhere);
    assert_eq!(cells.least_of_all(nowhere, nowhere), within);
}

/// Without randomness many cells are as far: the first of them counts.
#[test]
fn the_least_of_all_cells_is_that_within_bounds() {
    for metric in [
        VoronoiMetric::Euclidean,
        VoronoiMetric::Manhattan,
        VoronoiMetric::Chebychev,
    ] {
        for randomness in [0.0, 0.5, 1.0] {
            agree::<Pcg>(metric, randomness);
            agree::<Lookup3>(metric, randomness);
        }
    }
}
