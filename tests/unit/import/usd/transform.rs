use super::*;
use glam::DVec3;
use openusd::gf;

fn op(name: &str, value: Value) -> DAffine3 {
    operation(name, &value).unwrap()
}

/// X first, then Y, then Z: as USD's GfRotation composes them.
#[test]
fn three_rotations_turn_in_the_order_of_their_names() {
    let turned = op("xformOp:rotateXYZ", gf::vec3f(90.0, 90.0, 0.0).into());
    // Y goes to Z by X, and Z to X by Y.
    let at = turned.transform_point3(DVec3::Y);
    assert!((at - DVec3::X).length() < 1e-12, "{at}");
    let turned = op("xformOp:rotateYXZ", gf::vec3f(90.0, 90.0, 0.0).into());
    let at = turned.transform_point3(DVec3::Y);
    assert!((at - DVec3::Z).length() < 1e-12, "{at}");
}

#[test]
fn matrices_are_for_rows_in_the_file() {
    let m = gf::Matrix4d([
        0.0, 2.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 5.0, 6.0, 7.0, 1.0,
    ]);
    let m = op("xformOp:transform", Value::Matrix4d(m));
    assert_eq!(m.transform_point3(DVec3::ZERO), DVec3::new(5.0, 6.0, 7.0));
    assert_eq!(m.transform_vector3(DVec3::X), DVec3::new(0.0, 2.0, 0.0));
}

#[test]
fn single_axes_and_quaternions() {
    let at = op("xformOp:translateY", Value::Double(3.0)).transform_point3(DVec3::ZERO);
    assert_eq!(at, DVec3::new(0.0, 3.0, 0.0));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turn = op("xformOp:orient:x", Value::quatd(half, half, 0.0, 0.0));
    assert!((turn.transform_point3(DVec3::Y) - DVec3::Z).length() < 1e-12);
    assert!(operation("xformOp:orient", &Value::quatd(0.0, 0.0, 0.0, 0.0)).is_none());
    assert!(operation("xformOp:rotateABC", &gf::vec3f(0.0, 0.0, 0.0).into()).is_none());
}
