use super::*;

#[test]
fn frames_are_orthonormal_in_all_directions_and_near_the_poles() {
    let mut worst = 0f32;
    for i in 0..200 {
        for j in 0..100 {
            let phi = i as f32 * 0.031_415_9;
            let cos = 1.0 - j as f32 * 0.020_202;
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            for z in [
                Vec3::new(sin * phi.cos(), sin * phi.sin(), cos).normalize(),
                Vec3::new(1e-7 * phi.cos(), 1e-4 * phi.sin(), -1.0).normalize(),
            ] {
                let f = Frame::from_normal(z);
                for error in [
                    f.x.dot(f.y),
                    f.x.dot(f.z),
                    f.y.dot(f.z),
                    f.x.length() - 1.0,
                    f.y.length() - 1.0,
                    (f.x.cross(f.y) - f.z).length(),
                ] {
                    worst = worst.max(error.abs());
                }
            }
        }
    }
    // The paper finds errors below 1e-6 in f32 over all directions (its table 1).
    assert!(worst < 2e-6, "{worst}");
}
