use super::*;
use crate::sampler::Sequence;
use std::f64::consts::PI;

#[test]
fn rays_go_through_the_corners_of_the_field_of_view() {
    let far_away = DVec3::new(1e7, 0.0, -3e6);
    let transform = DAffine3::from_translation(far_away + DVec3::new(1.0, 2.0, 3.0));
    let lens = Lens::Perspective(Span::between([-1.0, 1.0], [-0.5, 0.5]));
    let camera = Camera::new(lens, None, &transform, far_away, 0.1, f64::INFINITY);
    let ray = camera.ray(Vec2::new(1.0, -1.0));
    assert_eq!(ray.origin, Vec3::new(1.0, 2.0, 3.0));
    assert!((ray.direction - Vec3::new(1.0, -0.5, -1.0).normalize()).length() < 1e-6);
    assert!((ray.near - 0.15).abs() < 1e-6 && ray.far.is_infinite());
    let flat = Camera::new(
        Lens::Orthographic(Span::between([-4.0, 4.0], [-2.0, 2.0])),
        None,
        &transform,
        far_away,
        0.0,
        10.0,
    );
    let ray = flat.ray(Vec2::new(0.5, 1.0));
    assert_eq!(
        (ray.origin, ray.direction),
        (Vec3::new(3.0, 4.0, 3.0), Vec3::NEG_Z)
    );
    assert!((flat.depth(Vec3::new(9.0, 9.0, -2.0)) - 5.0).abs() < 1e-6);
}

#[test]
fn a_shifted_window_moves_the_rays() {
    let lens = Lens::Perspective(Span::between([0.0, 1.0], [-1.0, 0.5]));
    let camera = Camera::new(lens, None, &DAffine3::IDENTITY, DVec3::ZERO, 0.0, 1.0);
    for (film, tangents) in [
        (Vec2::new(-1.0, -1.0), Vec2::new(0.0, -1.0)),
        (Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.5)),
    ] {
        let d = camera.ray(film).direction;
        assert!((d.truncate() / -d.z - tangents).length() < 1e-6);
    }
}

#[test]
fn a_panorama_has_the_right_hand_on_its_right() {
    let lens = Lens::Equirectangular(Span::between([-PI, PI], [-PI / 2.0, PI / 2.0]));
    let camera = Camera::new(lens, None, &DAffine3::IDENTITY, DVec3::ZERO, 0.25, 8.0);
    for (film, direction) in [
        (Vec2::ZERO, Vec3::NEG_Z),
        (Vec2::new(0.5, 0.0), Vec3::X),
        (Vec2::new(-0.5, 0.0), Vec3::NEG_X),
        (Vec2::new(0.3, 1.0), Vec3::Y),
        (Vec2::new(1.0, 0.0), Vec3::Z),
    ] {
        let ray = camera.ray(film);
        assert!((ray.direction - direction).length() < 1e-6, "{film}");
        assert_eq!((ray.near, ray.far), (0.25, 8.0));
    }
    assert_eq!(camera.depth(Vec3::new(0.0, 3.0, 4.0)), 5.0);
}

/// Whatever point of the lens: the rays of one point of the film meet where the pinhole's ray is in
/// focus, start on the lens and have its clip planes at their depths.
#[test]
fn rays_of_all_points_of_the_lens_meet_in_focus() {
    let transform = DAffine3::from_rotation_y(0.4);
    let span = Span::between([-0.3, 0.8], [-0.4, 0.5]);
    let film = Vec2::new(0.4, -0.7);
    for lens in [
        Lens::Perspective(span),
        Lens::Orthographic(span),
        Lens::Equirectangular(span),
    ] {
        let aperture = Aperture {
            radius: 0.2,
            blades: 5,
            rotation: 0.1,
            ratio: 1.5,
            focus_distance: 3.0,
        };
        let camera = Camera::new(lens, Some(aperture), &transform, DVec3::ZERO, 0.5, 20.0);
        let middle = camera.ray(film);
        let sharp = middle.origin
            + middle.direction * (3.0 / camera.depth(middle.origin + middle.direction));
        for i in 0..64 {
            let sampler = Sequence::new(1).sampler(3, 4, i);
            let ray = (camera.ray_maker())(&camera, film, &sampler);
            let to = sharp - ray.origin;
            assert!((to.normalize() - ray.direction).length() < 1e-6, "{lens:?}");
            let off = (ray.origin - middle.origin).length();
            assert!(off <= 0.2 + 1e-6, "{lens:?} {off}");
            if !matches!(lens, Lens::Equirectangular(_)) {
                let at = |t: f32| camera.depth(ray.origin + ray.direction * t);
                assert!((at(ray.near) - 0.5).abs() < 1e-6 && (at(ray.far) - 20.0).abs() < 1e-5);
            }
        }
    }
}
