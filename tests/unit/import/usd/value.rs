use super::*;
use openusd::gf;

#[test]
fn numbers_of_all_precisions_are_numbers() {
    for value in [
        Value::Int(3),
        Value::Float(3.0),
        Value::Double(3.0),
        Value::Uchar(3),
    ] {
        assert_eq!(number(&value), Some(3.0));
    }
    assert_eq!(number(&Value::String("3".into())), None);
    assert_eq!(truth(&Value::Int(1)), Some(true));
}

#[test]
fn doubles_keep_their_precision() {
    let fine = 1.0 + 1e-12;
    assert_eq!(
        vector::<3>(&Value::vec3d(fine, 2.0, 3.0)),
        Some([fine, 2.0, 3.0])
    );
    assert_eq!(vector::<2>(&Value::vec3f(1.0, 2.0, 3.0)), Some([1.0, 2.0]));
    assert_eq!(vector::<3>(&Value::vec2f(1.0, 2.0)), None);
}

#[test]
fn lists_lie_flat() {
    let list = Value::Vec3fVec(vec![gf::vec3f(1.0, 2.0, 3.0), gf::vec3f(4.0, 5.0, 6.0)]);
    assert_eq!(floats(&list), Some((3, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0])));
    assert_eq!(points(&list), Some(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]));
    assert_eq!(points(&Value::FloatVec(vec![1.0, 2.0, 3.0])), None);
}

#[test]
fn rotations_have_unit_length() {
    let q = rotation(&Value::quatf(0.0, 2.0, 0.0, 0.0)).unwrap();
    assert_eq!([q.x, q.w], [1.0, 0.0]);
    assert!(rotation(&Value::quatf(0.0, 0.0, 0.0, 0.0)).is_none());
}
