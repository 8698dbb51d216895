use super::*;
use approx::assert_relative_eq;

const UP: Vec3 = Vec3::Z;

fn lobe(albedo: Vec3, alpha: f32) -> SurfaceFeatures {
    let mut features = SurfaceFeatures::default();
    features.add(UP, albedo, alpha);
    features
}

fn pixel(path: &PathFeatures) -> (DVec3, DVec3, Option<f64>) {
    let mut pixel = PixelFeatures::default();
    pixel.add(path);
    (pixel.albedo(1.0), pixel.normal(1.0), pixel.depth(1.0))
}

#[test]
fn a_diffuse_surface_says_all_and_what_follows_nothing() {
    let mut path = PathFeatures::FOLLOWED;
    path.meet(2.0);
    path.surface(|| lobe(Vec3::new(0.2, 0.4, 0.6), 1.0));
    path.meet(5.0);
    path.surface(|| unreachable!());
    path.shine(Vec3::ONE);
    let (albedo, normal, depth) = pixel(&path);
    assert_eq!(albedo.as_vec3(), Vec3::new(0.2, 0.4, 0.6));
    assert_relative_eq!(normal.z, 1.0, epsilon = 1e-6);
    assert_eq!(depth, Some(2.0));
}

#[test]
fn a_mirror_hands_on_with_its_tint() {
    let mut path = PathFeatures::FOLLOWED;
    path.meet(2.0);
    path.surface(|| lobe(Vec3::new(0.5, 0.5, 0.8), 0.0));
    path.meet(3.0);
    path.surface(|| lobe(Vec3::splat(0.5), 1.0));
    let (albedo, normal, depth) = pixel(&path);
    assert_eq!(albedo.as_vec3(), Vec3::new(0.25, 0.25, 0.4));
    // The mean of the mirror's tint is 0.6.
    assert_relative_eq!(normal.z, 0.6, epsilon = 1e-6);
    assert_relative_eq!(depth.unwrap(), 2.0 + 0.6 * 3.0, epsilon = 1e-6);
}

/// α of 0.075 is halfway between a mirror and a diffuse lobe: half of its albedo counts as diffuse, and as that is all that is
/// asked for, nothing is handed on.
#[test]
fn halfway_rough_facets_say_half() {
    let mut path = PathFeatures::FOLLOWED;
    path.surface(|| lobe(Vec3::splat(0.8), 0.075));
    path.surface(|| unreachable!());
    assert_relative_eq!(pixel(&path).0.x, 0.4, epsilon = 1e-6);
}

/// A quarter of the albedo is diffuse: half of what lets a surface say all, and so it says half.
#[test]
fn a_glossy_coat_shares_with_what_it_mirrors() {
    let mut features = lobe(Vec3::splat(0.2), 1.0);
    features.add(UP, Vec3::splat(0.6), 0.0);
    let mut path = PathFeatures::FOLLOWED;
    path.surface(|| features);
    path.surface(|| lobe(Vec3::splat(0.5), 1.0));
    // 0.2 · 0.5 of the coated surface, 0.6 · (1 − 0.5) · 0.5 of what is mirrored.
    assert_relative_eq!(pixel(&path).0.x, 0.1 + 0.15, epsilon = 1e-6);
    assert_relative_eq!(pixel(&path).1.z, 0.5 + 0.3, epsilon = 1e-6);
}

#[test]
fn what_shines_counts_as_albedo_and_nothing_has_no_depth() {
    let mut path = PathFeatures::FOLLOWED;
    path.pass(Vec3::new(1.0, 0.5, 0.0));
    path.shine(Vec3::splat(4.0));
    let (albedo, normal, depth) = pixel(&path);
    assert_eq!((albedo, normal), (DVec3::new(4.0, 2.0, 0.0), DVec3::ZERO));
    assert_eq!(depth, None);
}

/// What bounds a volume is gone by; a path that the volume scatters has a depth, one that finds the sky behind it has none.
#[test]
fn ways_to_what_is_passed_are_a_part_of_the_depth() {
    let mut path = PathFeatures::FOLLOWED;
    path.go_by(2.0);
    assert_eq!(pixel(&path).2, None);
    path.pass(Vec3::splat(0.5));
    path.go_by(1.0);
    let mut scattered = path;
    path.meet(4.0);
    assert_eq!(pixel(&path).2, Some(2.0 + 0.5 * 5.0));
    scattered.scatter(|| Vec3::ONE, || UP);
    scattered.go_by(7.0);
    assert_eq!(pixel(&scattered).2, Some(2.5));
}

#[test]
fn a_path_that_is_not_followed_is_nothing() {
    let mut path = PathFeatures::default();
    path.meet(1.0);
    path.surface(|| unreachable!());
    path.shine(Vec3::ONE);
    assert_eq!(pixel(&path).0, DVec3::ZERO);
}
