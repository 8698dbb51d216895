//! Points and normals under transforms, in f64.

use glam::{DAffine3, DMat3, DVec3};

/// Transforms normals: the cofactor matrix keeps their direction under any scale and mirror.
pub fn cofactor(m: &DMat3) -> DMat3 {
    DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    )
}

pub fn unit(v: DVec3) -> [f32; 3] {
    v.try_normalize()
        .unwrap_or(DVec3::ZERO)
        .as_vec3()
        .to_array()
}

/// Transforms what is no unit vector by a matrix for normals, whatever the scale of that.
pub fn as_normal(matrix: &DMat3, v: DVec3) -> [f32; 3] {
    let scale = matrix.x_axis.length() + matrix.y_axis.length() + matrix.z_axis.length();
    (*matrix * v / scale.max(f64::MIN_POSITIVE))
        .as_vec3()
        .to_array()
}

/// In f64.
pub fn double(v: &[f32; 3]) -> DVec3 {
    DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))
}

pub fn placed_points(t: &DAffine3, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let placed = points.iter().map(|p| t.transform_point3(double(p)));
    placed.map(|p| p.as_vec3().to_array()).collect()
}

pub fn placed_normals(t: &DAffine3, normals: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let n = outside_cofactor(&t.matrix3);
    normals.iter().map(|x| unit(n * double(x))).collect()
}

/// The cofactor of a mirror turns normals over; the sign keeps them outside.
pub fn outside_cofactor(m: &DMat3) -> DMat3 {
    cofactor(m) * m.determinant().signum()
}
