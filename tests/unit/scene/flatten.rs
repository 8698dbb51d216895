use super::*;

#[test]
fn directions_do_not_depend_on_the_scale() {
    for scale in [1e-30, 1.0, 1e30] {
        let of = |x: [f64; 3], y: [f64; 3], z: [f64; 3]| {
            directions(&(DMat3::from_cols(x.into(), y.into(), z.into()) * scale))
        };
        assert_eq!(of([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]), 3);
        assert_eq!(of([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]), 2);
        assert_eq!(of([1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [0.0, 0.0, 1.0]), 2);
        assert_eq!(of([1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [0.0, 0.0, 0.0]), 1);
        assert_eq!(of([0.0; 3], [0.0; 3], [0.0; 3]), 1);
    }
}
