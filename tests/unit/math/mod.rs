use super::*;

#[test]
fn numbers_fall_apart_as_by_the_librarys_floor() {
    let exponents = (-40..40).map(|e| 2f32.powi(e));
    let numbers = exponents.flat_map(|x| [x, 1.3 * x, -x, -1.7 * x, x - 1.0, -x - 0.5]);
    for x in numbers.chain([0.0, 0.999_999_94, -0.999_999_94, 8_388_607.5, -8_388_607.5]) {
        assert_eq!(floor(x), (x.floor() as i64, x - x.floor()), "{x}");
    }
    assert_eq!(floor(1e30), (i64::MAX, 0.0));
}
