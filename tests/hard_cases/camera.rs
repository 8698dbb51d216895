//! Cameras: angles, scales, lenses and places at their ends.

use super::{Case, Effort, Finding};
use glam::{DAffine3, DQuat, DVec3, Vec2};
use sundog::camera::{Aperture, Camera, Lens, Span};
use sundog::math::float;
use sundog::render::{BounceLimits, LightSampling, RenderError, RenderSettings};
use sundog::sampler::{Sequence, hashed};
use sundog::scene::validate::clean;
use sundog::scene::{self, Diagnostics, MetallicRoughness, Projection, Scene};
use sundog::selftest::kit::{
    self, Bench, camera, colors, constant_environment, differing, diffuse, mean, place, quad,
    rel_mse, small, sphere,
};
use sundog::selftest::still_life::{Lit, Similarity, looking, still_life};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "narrow-fields",
        about: "Fields of view of 1 and of 1e-3 degrees from so far away that they show the same: the picture of an orthographic camera.",
        run: narrow_fields,
    },
    Case {
        name: "wide-field",
        about: "A field of view of 179.9 degrees: directions as in f64, the horizon in the middle.",
        run: wide_field,
    },
    Case {
        name: "orthographic-scales",
        about: "Orthographic cameras 1e-6 and 1e6 wide before scenes of their size: the same picture.",
        run: orthographic_scales,
    },
    Case {
        name: "apertures",
        about: "Lenses of radius 0, 1e-20 and 1e6 m, focus at 0, 1e-6, 1e30 and infinity: what is sharp is the pinhole's picture, and a furnace stays white.",
        run: apertures,
    },
    Case {
        name: "clip-planes",
        about: "Clip planes a millionth before and behind a wall, at 1e-30 and at 1e30 m: the wall is there or not.",
        run: clip_planes,
    },
    Case {
        name: "camera-on-a-surface",
        about: "The camera exactly in the plane of a face: it sees what is beyond; next to it, it sees one side.",
        run: camera_on_a_surface,
    },
    Case {
        name: "camera-in-glass",
        about: "The camera inside of a ball of glass, in the middle, on the inner side of its surface and outside: in a white furnace all is white.",
        run: camera_in_glass,
    },
];

fn sharp(effort: Effort) -> RenderSettings {
    RenderSettings {
        bounce_limits: BounceLimits {
            diffuse: Some(0),
            ..BounceLimits::default()
        },
        ..small(effort.of(4, 64, 256), 6)
    }
}

/// Half the height of what is shown.
const HALF: f64 = 1.2;

fn orthographic(scene: &mut Scene, half: f64) {
    let camera = &mut scene.cameras[0];
    camera.projection = Projection::Orthographic {
        half_width: half * 4.0 / 3.0,
        half_height: half,
    };
    (camera.clip_near, camera.clip_far) = (0.0, f64::INFINITY);
}

/// From the distance d the parts of the scene are 1 ± s/d as large as in the orthographic picture, s the depth from
/// the plane that both show alike, at most 3.5: at the edge of the picture 24 s/d pixels of the 32. Edges are as steep as
/// the filter is narrow: 1.5 pixels for a difference of 1 at most, of pixels on edges, which are not more than all. So
/// relMSE is below (24 s / 1.5 d)² / 0.01, and where that is below 1e-4 the samples' roundings count.
fn narrow_fields(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = sharp(effort);
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    let mut scene = still_life(Lit::Sharply);
    let middle = DVec3::new(0.0, 0.4, 0.0);
    for (name, toward) in [
        ("along an axis", DVec3::Z),
        ("askew", DVec3::new(0.48, 0.36, 0.8)),
    ] {
        scene.cameras[0].world_from_camera = looking(middle + toward * 3.0, middle);
        orthographic(&mut scene, HALF);
        let reference = bench.render(&scene, &settings)?.picture;
        for degrees in [1e-2f64, 1e-3] {
            let fov = degrees.to_radians();
            let distance = HALF / (0.5 * fov).tan();
            let mut far = scene.clone();
            let camera = &mut far.cameras[0];
            camera.world_from_camera = looking(middle + toward * distance, middle);
            camera.projection = Projection::Perspective {
                vertical_fov: fov,
                aspect: None,
            };
            let picture = bench.render(&far, &settings)?.picture;
            let bound = (24.0 * 3.5 / 1.5 / distance).powi(2) / 0.01;
            let found = rel_mse(&picture, &reference);
            findings.push(Finding::at_most(
                format!("relMSE of {degrees:.0e}° {name}"),
                bound.max(1e-4),
                found,
            ));
        }
    }
    Ok(bench.with(findings))
}

fn wide_field(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let fov = 179.9f64.to_radians();
    let tangent = (0.5 * fov).tan();
    let span = Span::between([-tangent, tangent], [-tangent, tangent]);
    let turn = DAffine3::from_quat(DQuat::from_axis_angle(
        DVec3::new(2.0, -3.0, 6.0) / 7.0,
        1.0,
    ));
    let view = Camera::new(Lens::Perspective(span), None, &turn, DVec3::ZERO, 0.0, 1.0);
    let mut largest = 0f64;
    for i in 0..effort.of(10_000, 1_000_000, 10_000_000) {
        let film = Vec2::new(hashed(0, i, 1), hashed(1, i, 1)) * 2.0 - 1.0;
        let exact = DVec3::new(
            f64::from(film.x) * tangent,
            f64::from(film.y) * tangent,
            -1.0,
        );
        let exact = turn.transform_vector3(exact.normalize());
        let found = view.ray(film).direction.as_dvec3();
        largest = largest.max((found - exact).length());
    }
    // Each component: the axis and the span rounded once each, a product and two sums, five roundings of the sum of
    // magnitudes, which for orthogonal axes is at most √3 times the length; then length (4) and division (1).
    let bound = 3f64.sqrt() * f64::from(float::gamma(10));
    let mut scene = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    let black = quad([-1e6, -1.0, 1e6], [2e6, 0.0, 0.0], [0.0, 0.0, -2e6]);
    place(&mut scene, black, diffuse([0.0; 3]), &[DAffine3::IDENTITY]);
    scene.cameras.push(camera(DVec3::ZERO, fov));
    let mut bench = Bench::default();
    let settings = small(effort.of(4, 64, 256), 0);
    let picture = bench.render(&scene, &settings)?.picture;
    let rows = settings.height as usize;
    let row = |i: usize| i / settings.width as usize;
    let wrong = colors(&picture).enumerate().filter(|(i, color)| {
        let [sky, ground] = [row(*i) + 1 < rows / 2, row(*i) > rows / 2];
        (sky && color[0] != 1.0) || (ground && color[0] != 0.0)
    });
    let wrong = wrong.count() as u64;
    Ok(bench.with(vec![
        Finding::at_most("error of a direction", bound, largest),
        Finding::none("pixels on the wrong side of the horizon", wrong),
    ]))
}

fn orthographic_scales(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = sharp(effort);
    let mut bench = Bench::default();
    let mut scene = still_life(Lit::Sharply);
    orthographic(&mut scene, 0.5);
    let reference = bench.render(&scene, &settings)?.picture;
    let mut findings = Vec::new();
    for scale in [1e-6, 1e6] {
        let by = Similarity {
            scale,
            ..Similarity::NONE
        };
        let picture = bench.render(&by.of(&scene), &settings)?.picture;
        let found = rel_mse(&picture, &reference);
        findings.push(Finding::at_most(
            format!("relMSE of a camera {scale:.0e} m wide"),
            1e-4,
            found,
        ));
    }
    // A field so small that all of it is inside of one triangle.
    let mut close = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    let wall = quad([-1.0, -1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    place(&mut close, wall, diffuse([0.5; 3]), &[DAffine3::IDENTITY]);
    close.cameras.push(camera(DVec3::new(0.3, 0.2, 0.0), 1.0));
    orthographic(&mut close, 1e-6);
    // Directions as the wall scatters: each sample is 1/2 but for the roundings of its weight.
    let settings = RenderSettings {
        light_sampling: LightSampling::Bsdf,
        ..small(16, 1)
    };
    let gray = mean(&bench.render(&close, &settings)?.picture);
    let bound = 0.5 * f64::from(float::gamma(64));
    findings.push(Finding::new(
        "radiance of a wall 1e-6 m of which is seen",
        0.5,
        gray,
        bound,
    ));
    Ok(bench.with(findings))
}

fn apertures(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = sharp(effort);
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    let scene = still_life(Lit::Sharply);
    let pinhole = bench.render(&scene, &settings)?.picture;
    let lens = |radius, focus_distance| scene::Aperture {
        radius,
        blades: 0,
        rotation: 0.0,
        ratio: 1.0,
        focus_distance,
    };
    let mut with = |aperture, scene: &Scene| {
        let mut scene = scene.clone();
        scene.cameras[0].aperture = Some(aperture);
        clean(&mut scene, &mut Diagnostics::default());
        bench.render(&scene, &settings)
    };
    for (name, aperture, same_bits) in [
        ("a lens of radius 0", lens(0.0, 3.0), true),
        ("a focus at 0", lens(0.1, 0.0), true),
        ("a lens of 1e-20 m", lens(1e-20, 3.0), false),
        (
            "a lens of 1e-9 m and focus at infinity",
            lens(1e-9, f64::INFINITY),
            false,
        ),
        (
            "a lens of 1e-9 m and focus at 1e30 m",
            lens(1e-9, 1e30),
            false,
        ),
        (
            "a lens of 1e-20 m and focus at 1e-6 m",
            lens(1e-20, 1e-6),
            false,
        ),
    ] {
        let picture = with(aperture, &scene)?.picture;
        findings.push(if same_bits {
            let differing = differing(&picture, &pinhole);
            Finding::none(format!("pixels that differ, {name}"), differing)
        } else {
            Finding::at_most(format!("relMSE, {name}"), 1e-4, rel_mse(&picture, &pinhole))
        });
    }
    let mut sky = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    place(
        &mut sky,
        sphere(8, 0.0, true),
        MetallicRoughness {
            unlit: true,
            base_color: [1.0; 3],
            ..MetallicRoughness::default()
        },
        &[DAffine3::from_translation(DVec3::new(0.0, 0.0, -3.0))],
    );
    sky.cameras.push(camera(DVec3::ZERO, 0.7));
    for (radius, focus) in [
        (1e6, 3.0),
        (1e6, 1e-6),
        (1e3, 1e-45),
        (1.0, 1e-6),
        (1e6, f64::INFINITY),
        (1e15, 1e15),
    ] {
        let picture = with(lens(radius, focus), &sky)?.picture;
        let other = colors(&picture)
            .flatten()
            .filter(|c| (c - 1.0).abs() > f64::from(float::gamma(8)))
            .count();
        findings.push(Finding::none(
            format!("values that are not 1, lens of {radius:.0e} m with focus at {focus:.0e} m"),
            other as u64,
        ));
    }
    // Focus at infinity: the rays of one point of the film are parallel, wherever on the lens they start.
    let span = Span::between([-0.4, 0.4], [-0.3, 0.3]);
    let aperture = Aperture {
        radius: 0.3,
        blades: 5,
        rotation: 0.0,
        ratio: 1.0,
        focus_distance: f32::INFINITY,
    };
    let view = Camera::new(
        Lens::Perspective(span),
        Some(aperture),
        &DAffine3::IDENTITY,
        DVec3::ZERO,
        0.0,
        1.0,
    );
    let mut apart = 0f64;
    for i in 0..1000 {
        let film = Vec2::new(hashed(0, i, 1), hashed(1, i, 1)) * 2.0 - 1.0;
        let sampler = Sequence::new(1).sampler(3, 4, i);
        let ray = view.ray_maker()(&view, film, &sampler);
        let middle = view.ray(film);
        apart = apart.max(f64::from((ray.direction - middle.direction).length()));
    }
    findings.push(Finding::none(
        "directions that depend on the lens' point with focus at infinity",
        u64::from(apart > 0.0),
    ));
    Ok(bench.with(findings))
}

fn clip_planes(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 32, 256), 0);
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    for (near, far, seen) in [
        (1.0 - 1e-6, 2.0, true),
        (1.0 + 1e-6, 2.0, false),
        (0.0, 1.0 - 1e-6, false),
        (0.0, 1.0 + 1e-6, true),
        (1e-30, 1e30, true),
        (0.0, f64::INFINITY, true),
        (1e-300, 1e300, true),
        (0.999, 0.999_5, false),
        (1e30, 1e31, false),
    ] {
        let mut scene = Scene::default();
        let wall = quad([-9.0, -9.0, -1.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
        let shining = MetallicRoughness {
            emission: [1.0; 3],
            ..diffuse([0.0; 3])
        };
        place(&mut scene, wall, shining, &[DAffine3::IDENTITY]);
        let mut view = camera(DVec3::ZERO, 1.2);
        (view.clip_near, view.clip_far) = (near, far);
        scene.cameras.push(view);
        let expected = if seen { 1.0 } else { 0.0 };
        let picture = bench.render(&scene, &settings)?.picture;
        let wrong = colors(&picture).filter(|c| c[0] != expected).count() as u64;
        findings.push(Finding::none(
            format!("wrong pixels of a wall at 1 m, seen from {near:e} to {far:e} m"),
            wrong,
        ));
    }
    Ok(bench.with(findings))
}

fn camera_on_a_surface(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 32, 256), 0);
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    let shining = MetallicRoughness {
        emission: [2.0; 3],
        ..diffuse([0.0; 3])
    };
    let mut seen = |place_of: DAffine3, eye: DVec3, at: DVec3| -> Result<(u64, u64), RenderError> {
        let mut scene = Scene {
            environment: constant_environment(1.0),
            ..Scene::default()
        };
        let floor = quad([-3.0, 0.0, 5.0], [7.0, 0.0, 0.0], [0.0, 0.0, -9.0]);
        place(&mut scene, floor, shining.clone(), &[place_of]);
        let mut view = camera(eye, 0.5);
        let turned = looking(DVec3::ZERO, at - eye);
        view.world_from_camera = DAffine3 {
            translation: eye,
            ..turned
        };
        scene.cameras.push(view);
        let picture = bench.render(&scene, &settings)?.picture;
        let sky = colors(&picture).filter(|c| c[0] == 1.0).count() as u64;
        Ok((sky, u64::from(settings.width * settings.height)))
    };
    for (name, eye) in [
        ("at 0", DVec3::ZERO),
        ("at 1e7 m", DVec3::new(1e7, -3e6, 2e6)),
    ] {
        for (side, at) in [
            ("up", DVec3::new(0.3, 1.0, -0.2)),
            ("down", DVec3::new(0.3, -1.0, -0.2)),
        ] {
            let (sky, all) = seen(DAffine3::from_translation(eye), eye, eye + at)?;
            findings.push(Finding::none(
                format!("pixels that see the floor on which the camera is, {name}, looking {side}"),
                all - sky,
            ));
        }
    }
    // Askew, corners are rounded: the camera is on one of the sides, and sees the floor everywhere or nowhere.
    let turn = DAffine3::from_quat(DQuat::from_axis_angle(
        DVec3::new(2.0, -3.0, 6.0) / 7.0,
        0.7,
    ));
    let normal = turn.transform_vector3(DVec3::Y);
    for (side, sign) in [("up", 1.0), ("down", -1.0)] {
        let (sky, all) = seen(turn, DVec3::ZERO, normal * sign + DVec3::new(0.1, 0.0, 0.1))?;
        findings.push(Finding::none(
            format!("pixels that do not see what the others see, askew, looking {side}"),
            sky.min(all - sky),
        ));
    }
    Ok(bench.with(findings))
}

fn camera_in_glass(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    const BOUNCES: u32 = 1024;
    let settings = small(effort.of(4, 64, 1024), BOUNCES);
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    let bound = f64::from(float::gamma(8 * BOUNCES));
    for (name, x) in [
        ("in the middle", 0.0),
        ("half-way", 0.5),
        ("1e-7 inside of the surface", 1.0 - 1e-7),
        ("on the surface", 1.0),
        ("1e-7 outside of the surface", 1.0 + 1e-7),
    ] {
        let mut scene = Scene {
            environment: constant_environment(1.0),
            ..Scene::default()
        };
        let glass = kit::glass(0.0, 1.5);
        place(
            &mut scene,
            sphere(24, 0.0, true),
            glass,
            &[DAffine3::IDENTITY],
        );
        let eye = DVec3::X * x;
        // Along the normal: what falls in at more than 42 degrees would never come out of a round ball.
        let mut view = camera(eye, 0.7);
        view.world_from_camera = looking(eye, eye - DVec3::X);
        scene.cameras.push(view);
        let picture = bench.render(&scene, &settings)?.picture;
        let brightest = colors(&picture).flatten().fold(0.0, f64::max);
        findings.push(Finding::new(
            format!("mean radiance, {name}"),
            1.0,
            mean(&picture),
            bound,
        ));
        findings.push(Finding::at_most(
            format!("light above 1, {name}"),
            bound,
            (brightest - 1.0).max(0.0),
        ));
    }
    Ok(bench.with(findings))
}
