use super::*;

/// It holds for mirrors and scales too.
#[test]
fn the_inverse_transpose_is_had_without_an_inverse() {
    let m = DMat3::from_cols_array(&[2.0, 0.1, 0.0, -0.3, 1.0, 0.2, 0.0, 0.4, -0.5]);
    let expected = m.inverse().transpose() * m.determinant();
    assert!(cofactor(&m).abs_diff_eq(expected, 1e-12));
}

#[test]
fn nothing_is_bound_without_a_root() {
    let binding = Binding::default();
    assert_eq!(binding.key(), "");
    let bound = Binding {
        skeleton: Some(Path::abs_root()),
        ..Binding::default()
    };
    assert_ne!(bound.key(), "");
}
