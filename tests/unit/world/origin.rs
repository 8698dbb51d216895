use super::*;
use crate::scene::Medium;
use crate::selftest::kit::{camera, diffuse, place, sphere};
use glam::DAffine3;

#[test]
fn the_origin_is_the_camera_unless_it_is_far_from_all() {
    let mut scene = Scene::default();
    assert_eq!(Origin::new(&scene, &camera(DVec3::X, 1.0)).at, DVec3::X);
    let middle = DVec3::new(1e7, 2.0, 3.0);
    let at = [DAffine3::from_translation(middle)];
    place(&mut scene, sphere(4, 0.0, false), diffuse([0.5; 3]), &at);
    let near = middle + DVec3::Z * 20.0;
    let origin = Origin::new(&scene, &camera(near, 1.0));
    assert!(origin.distant.is_none());
    assert_eq!(origin.at, near);
    let origin = Origin::new(&scene, &camera(middle + DVec3::Z * 1e5, 1.0));
    // Half the diagonal of the box about a sphere of 1.
    let (_, radius) = origin.distant.unwrap();
    assert!((radius - 3f64.sqrt()).abs() < 1e-5, "{radius}");
    assert!((origin.at - middle).length() < 1e-6);
    // Haze of all space begins at the camera.
    scene.medium = Some(Medium::default());
    let far = middle + DVec3::Z * 1e5;
    let origin = Origin::new(&scene, &camera(far, 1.0));
    assert!(origin.distant.is_none());
    assert_eq!(origin.at, far);
}
