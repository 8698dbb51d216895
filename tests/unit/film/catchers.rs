use super::*;

/// Half of the paths see an object of light 3 that is no catcher, the others a catcher of light 2 and, alone, 4.
fn half() -> (CatcherPixel, DVec3) {
    let mut pixel = CatcherPixel::default();
    pixel.add(Vec3::splat(3.0), Vec3::ZERO, false);
    let split = Split {
        throughput: Vec3::ONE,
        before: Vec3::ZERO,
    };
    let caught = Caught {
        split,
        alone: Vec3::splat(4.0),
        behind: Vec3::splat(10.0),
    };
    pixel.add_caught(&caught, 1.0);
    (pixel, DVec3::splat(0.5 * 3.0 + 0.5 * 2.0))
}

#[test]
fn sums_go_through_floats() {
    let (pixel, _) = half();
    let mut floats = [0.0; CATCHER_SUMS];
    pixel.write(&mut floats);
    assert_eq!(CatcherPixel::read(&floats), pixel);
    assert_eq!(CatcherPixel::read(&[]), CatcherPixel::default());
}

#[test]
fn a_shadow_is_what_is_left_of_the_light_on_the_catcher() {
    let (pixel, all) = half();
    assert_eq!(pixel.shadow(all, 1.0, 0.5), DVec3::splat(0.5));
    // What the film does not show is not shadowed.
    assert_eq!(pixel.shadow(all, 0.5, 0.5), DVec3::splat(0.75));
    assert_eq!(CatcherPixel::default().shadow(all, 1.0, 0.5), DVec3::ONE);
}

#[test]
fn a_catcher_without_light_has_no_shadow() {
    let mut pixel = CatcherPixel::default();
    let split = Split {
        throughput: Vec3::ONE,
        before: Vec3::ZERO,
    };
    let dark = Caught {
        split,
        alone: Vec3::new(1.0, 0.0, 1.0),
        behind: Vec3::ZERO,
    };
    pixel.add_caught(&dark, 1.0);
    let shadow = pixel.shadow(DVec3::new(0.25, 0.25, 2.0), 1.0, 1.0);
    assert_eq!(shadow, DVec3::new(0.25, 1.0, 2.0));
}

#[test]
fn objects_lie_over_their_shadows() {
    let (pixel, all) = half();
    assert_eq!(pixel.objects(0.5), (DVec3::splat(1.5), 0.5));
    // Half of it is the object, and the other half half a shadow.
    assert_eq!(
        pixel.combined(all, 1.0, true, 0.5),
        (DVec3::splat(1.5), 0.75)
    );
    // The world behind it has 5 in this pixel.
    assert_eq!(
        pixel.combined(all, 1.0, false, 0.5),
        (DVec3::splat(1.5 + 5.0 * 0.25), 1.0)
    );
}

#[test]
fn light_that_others_throw_on_a_catcher_is_no_shadow() {
    let mut pixel = CatcherPixel::default();
    let split = Split {
        throughput: Vec3::ONE,
        before: Vec3::ZERO,
    };
    let lit = Caught {
        split,
        alone: Vec3::ONE,
        behind: Vec3::ONE,
    };
    pixel.add_caught(&lit, 2.0);
    let all = DVec3::splat(6.0);
    assert_eq!(pixel.shadow(all, 1.0, 1.0), DVec3::splat(3.0));
    assert_eq!(pixel.combined(all, 1.0, true, 1.0), (DVec3::ZERO, 0.0));
    assert_eq!(
        pixel.combined(all, 1.0, false, 1.0),
        (DVec3::splat(2.0), 1.0)
    );
}
