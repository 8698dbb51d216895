//! Which rays see objects, lights and the world.

use super::*;

const KINDS: [RayKind; 3] = [RayKind::Diffuse, RayKind::Glossy, RayKind::Transmission];

fn without(kinds: &[RayKind]) -> Visibility {
    kinds
        .iter()
        .fold(Visibility::ALL, |seen, kind| seen.without(*kind))
}

/// Of Student's t with 23 degrees of freedom (24 seeds; fewer where one variance is most of the sum), so much is exceeded
/// with a probability of 1e-4: 100 comparisons fail by chance in one of 100 cases, and seeds are fixed.
const LARGEST_T: f64 = 4.7;

/// As [`super::estimate`], with 24 seeds.
fn estimate(scene: &Scene, settings: &RenderSettings) -> (f64, f64) {
    super::estimate(scene, settings, 0..24)
}

/// A wall that fills the camera's view, slanted so that light from the sides is lit and reflected.
fn wall(material: MetallicRoughness) -> Scene {
    let mut scene = Scene::default();
    place(
        &mut scene,
        quad([-4.0, -4.0, -1.0], [8.0, 0.0, -3.0], [0.0, 8.0, 0.0]),
        material,
        &[DAffine3::IDENTITY],
    );
    scene.cameras.push(camera(DVec3::new(0.0, 0.0, 2.0), 0.5));
    scene
}

fn plastic() -> MetallicRoughness {
    MetallicRoughness {
        metallic: 0.0,
        roughness: 0.5,
        base_color: [0.3; 3],
        transmission: 0.4,
        thin_walled: true,
        ..MetallicRoughness::default()
    }
}

/// What gives the light.
type Source = fn(&mut Scene, Visibility);

fn sources() -> Vec<(&'static str, Source)> {
    vec![
        ("world", |scene, seen| {
            scene.environment = Some(Environment {
                visibility: seen,
                ..constant_environment(1.0).unwrap()
            });
        }),
        ("mesh", |scene, seen| {
            let shell = MetallicRoughness {
                emission: [1.0; 3],
                ..diffuse([0.0; 3])
            };
            let size = DAffine3::from_scale(DVec3::splat(30.0));
            place(scene, sphere(16, 0.0, false), shell, &[size]);
            if let Some(shell) = scene.instances.last_mut() {
                shell.visibility = seen;
            }
        }),
        ("sphere", |scene, seen| {
            let kind = LightKind::Point {
                intensity: 9.0,
                radius: 0.8,
                soft_falloff: false,
            };
            for z in [1.5, -5.0] {
                let light = looking_down(kind, DVec3::new(-1.0, 1.0, z), DAffine3::IDENTITY);
                scene.lights.push(Light {
                    visibility: seen,
                    ..light
                });
            }
        }),
        ("area", |scene, seen| {
            let kind = area(AreaShape::Rectangle, [2.0, 2.0], std::f32::consts::PI);
            for z in [1.0, -4.0] {
                let light = looking_down(kind, DVec3::new(0.0, 3.0, z), DAffine3::IDENTITY);
                scene.lights.push(Light {
                    visibility: seen,
                    ..light
                });
            }
        }),
        ("sun", |scene, seen| {
            let kind = LightKind::Sun {
                irradiance: 2.0,
                angle: 0.4,
            };
            for turn in [-0.6, -2.4] {
                let mut light = looking_down(kind, DVec3::ZERO, DAffine3::IDENTITY);
                light.world_from_light = DAffine3::from_rotation_x(turn);
                light.visibility = seen;
                scene.lights.push(light);
            }
        }),
    ]
}

/// Light that only one kind of ray sees, for each kind: together all of it.
#[test]
fn the_kinds_of_rays_share_the_light_among_them() {
    for (name, source) in sources() {
        let lit = |seen: Visibility| {
            let mut scene = wall(plastic());
            source(&mut scene, seen.without(RayKind::Camera));
            scene
        };
        let settings = small(16, 0);
        let (all, all_variance) = estimate(&lit(Visibility::ALL), &settings);
        let (mut sum, mut variance) = (0.0, all_variance);
        for kind in KINDS {
            let others: Vec<RayKind> = KINDS.into_iter().filter(|k| *k != kind).collect();
            let (part, v) = estimate(&lit(without(&others)), &settings);
            assert!(part > 0.02 * all, "{name} {kind:?}: {part} of {all}");
            sum += part;
            variance += v;
        }
        let z = (sum - all) / variance.sqrt();
        assert!(z.abs() < LARGEST_T, "{name}: {sum} {all}, z = {z}");
        assert!(variance.sqrt() < 0.05 * all, "{name}");
        let none = mean(&run(&lit(without(&KINDS)), &settings));
        assert_eq!(none, 0.0, "{name}");
    }
}

/// Each kind by itself, with each way to find light: the same.
fn all_ways_to_find_light_agree_for(kinds: &[RayKind]) {
    for (name, source) in sources() {
        for &kind in kinds {
            let mut scene = wall(plastic());
            let others: Vec<RayKind> = KINDS.into_iter().filter(|k| *k != kind).collect();
            source(&mut scene, without(&others).without(RayKind::Camera));
            let by = |light_sampling| {
                estimate(
                    &scene,
                    &RenderSettings {
                        light_sampling,
                        ..small(8, 0)
                    },
                )
            };
            let mis = by(LightSampling::Mis);
            for other in [
                LightSampling::Nee,
                LightSampling::Bsdf,
                LightSampling::Hemisphere,
            ]
            .map(by)
            {
                let z = (mis.0 - other.0) / (mis.1 + other.1).sqrt();
                assert!(
                    z.abs() < LARGEST_T,
                    "{name} {kind:?}: {mis:?} {other:?} z = {z}"
                );
            }
        }
    }
}

/// `long` has the other kinds.
#[test]
fn all_ways_to_find_light_agree_for_glossy_rays() {
    all_ways_to_find_light_agree_for(&[RayKind::Glossy]);
}

mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn all_ways_to_find_light_agree_for_each_kind_of_ray() {
        super::all_ways_to_find_light_agree_for(&super::KINDS);
    }
}

#[test]
fn the_camera_sees_lamps_that_it_may_see_from_the_side_that_shines() {
    let seen = |kind: LightKind, turn: f64, visibility: Visibility| {
        let mut scene = Scene::default();
        scene.cameras.push(camera(DVec3::new(0.0, 0.0, 5.0), 1e-3));
        let mut light = looking_down(kind, DVec3::ZERO, DAffine3::IDENTITY);
        light.color = [1.0; 3];
        light.world_from_light = DAffine3::from_rotation_y(turn);
        light.visibility = visibility;
        scene.lights.push(light);
        mean(&run(&scene, &small(4, 0)))
    };
    let pi = std::f64::consts::PI;
    let hidden = without(&[RayKind::Camera]);
    let disc = area(AreaShape::Ellipse, [0.5, 0.5], std::f32::consts::PI);
    let ball = |soft_falloff| LightKind::Point {
        intensity: 3.0,
        radius: 0.5,
        soft_falloff,
    };
    let area_radiance = 12.0 / (pi * pi * 0.0625);
    let ball_radiance = 3.0 / (pi * 0.25);
    for (kind, turn, radiance) in [
        (disc, pi, area_radiance),
        (disc, 0.0, 0.0),
        (ball(false), 0.0, ball_radiance),
        (ball(true), 0.0, ball_radiance),
    ] {
        let found = seen(kind, turn, Visibility::ALL);
        assert!(
            (found - radiance).abs() <= 1e-5 * radiance,
            "{kind:?} {found}"
        );
        assert_eq!(seen(kind, turn, hidden), 0.0);
    }
    let sun = LightKind::Sun {
        irradiance: 2.0,
        angle: 0.4,
    };
    let found = seen(sun, pi, Visibility::ALL);
    assert!((found / (2.0 / (pi * 0.2f64.sin().powi(2))) - 1.0).abs() < 1e-5);
    assert_eq!(seen(sun, pi, hidden), 0.0);
}

/// A floor, a lamp, and a blocker between them that the camera does not see.
fn shaded_floor(blocker: Option<Visibility>, lamp: Visibility, kind: LightKind) -> Scene {
    let mut scene = Scene::default();
    place(
        &mut scene,
        quad([-5.0, 0.0, 5.0], [10.0, 0.0, 0.0], [0.0, 0.0, -10.0]),
        diffuse([0.5; 3]),
        &[DAffine3::IDENTITY],
    );
    if let Some(visibility) = blocker {
        place(
            &mut scene,
            quad([-2.0, 1.0, 2.0], [4.0, 0.0, 0.0], [0.0, 0.0, -4.0]),
            diffuse([0.5; 3]),
            &[DAffine3::IDENTITY],
        );
        if let Some(quad) = scene.instances.last_mut() {
            quad.visibility = visibility;
        }
    }
    let light = looking_down(kind, DVec3::Y * 2.0, DAffine3::IDENTITY);
    scene.lights.push(Light {
        visibility: lamp,
        ..light
    });
    let mut c = camera(DVec3::ZERO, 0.3);
    c.world_from_camera = DAffine3::from_rotation_translation(
        glam::DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
        DVec3::Y * 3.0,
    );
    scene.cameras.push(c);
    scene
}

#[test]
fn shadows_follow_objects_and_lights() {
    let point = LightKind::Point {
        intensity: 5.0,
        radius: 0.0,
        soft_falloff: false,
    };
    let all = Visibility::ALL;
    let no_camera = without(&[RayKind::Camera]);
    let no_shadow = without(&[RayKind::Camera, RayKind::Shadow]);
    let picture = |blocker, lamp, kind| {
        run(&shaded_floor(blocker, lamp, kind), &small(4, 0))
            .picture
            .layers[0]
            .data
            .clone()
    };
    let free = picture(None, all, point);
    assert!(free.iter().any(|v| *v > 0.1));
    assert!(
        picture(Some(no_camera), all, point)
            .chunks(4)
            .all(|p| p[..3] == [0.0; 3])
    );
    assert!(picture(Some(no_shadow), all, point) == free);
    assert!(picture(Some(no_camera), no_shadow, point) == free);
    // The camera sees the blocker, whose upper side is lit.
    assert!(picture(Some(all), all, point) != free);
    // A lamp with a size that shines through everything: as bright as with nothing before it.
    let sized = area(AreaShape::Rectangle, [0.5, 0.5], std::f32::consts::PI);
    let through = estimate(
        &shaded_floor(Some(no_camera), no_shadow, sized),
        &small(16, 0),
    );
    let free = estimate(&shaded_floor(None, no_camera, sized), &small(16, 0));
    let z = (through.0 - free.0) / (through.1 + free.1).sqrt();
    assert!(z.abs() < 3.5, "{through:?} {free:?}");
}

/// A light that only direct paths see lights as with no bounces at all.
#[test]
fn lights_end_after_their_bounces() {
    for (name, source) in sources() {
        if ["world", "mesh"].contains(&name) {
            continue; // They have no such limit.
        }
        let picture = |limit: u32, bounces: u32| {
            let mut scene = wall(diffuse([0.8; 3]));
            place(
                &mut scene,
                quad([-4.0, -1.0, 4.0], [8.0, 0.0, 0.0], [0.0, 0.0, -8.0]),
                diffuse([0.8; 3]),
                &[DAffine3::IDENTITY],
            );
            source(&mut scene, without(&[RayKind::Camera]));
            for light in &mut scene.lights {
                light.max_bounces = limit;
            }
            mean(&run(&scene, &small(32, bounces)))
        };
        let (direct, limited, all) = (picture(1024, 0), picture(0, 4), picture(1024, 4));
        // The same random numbers, and the same light.
        assert!(
            (limited / direct - 1.0).abs() < 1e-5,
            "{name}: {limited} {direct}"
        );
        assert!(all > 1.05 * direct, "{name}: {all} {direct}");
        let one = picture(1, 4);
        assert!(direct < one && one < all, "{name}: {direct} {one} {all}");
    }
}

/// Objects stand before each other only for the rays that see them, also where they are instances.
#[test]
fn hidden_objects_do_not_stand_in_the_way() {
    for copies in [1, 2] {
        let mut scene = Scene {
            environment: constant_environment(1.0),
            ..Scene::default()
        };
        let transforms: Vec<_> = (0..copies)
            .map(|i| DAffine3::from_translation(DVec3::Z * -f64::from(i)))
            .collect();
        place(
            &mut scene,
            quad([-4.0, -4.0, -1.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]),
            diffuse([0.0; 3]),
            &transforms,
        );
        scene.cameras.push(camera(DVec3::ZERO, 0.5));
        assert_eq!(mean(&run(&scene, &small(4, 2))), 0.0);
        for instance in &mut scene.instances {
            instance.visibility = without(&[RayKind::Camera]);
        }
        assert_eq!(mean(&run(&scene, &small(4, 2))), 1.0);
        if let Some(first) = scene.instances.first_mut() {
            first.visibility = Visibility::ALL;
        }
        assert_eq!(mean(&run(&scene, &small(4, 2))), 0.0, "each has its own");
    }
}
