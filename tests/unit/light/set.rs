use super::super::area::Area;
use super::super::emissive::tests::{eye, halves, mesh};
use super::super::environment::Environment;
use super::super::lamp::Lamp;
use super::super::sun::Sun;
use super::*;
use crate::math::warp;
use crate::math::warp::grid;
use crate::scene::Visibility;
use glam::{DAffine3, DMat3, DVec3};

fn ball(x: f32) -> Light {
    Light::Lamp(Box::new(Lamp {
        center: Vec3::new(x, 0.0, 3.0),
        radius: 0.4,
        soft_falloff: false,
        intensity: Vec3::splat(3.0 + x),
        cone: None,
    }))
}

fn area() -> Light {
    let place = DAffine3::from_translation(DVec3::new(0.0, 2.0, 2.5));
    let area = Area::new(&place, [0.8, 0.5], false, Vec3::splat(4.0), true, 3.2);
    Light::Area(Box::new(area.unwrap()))
}

fn sun() -> Light {
    let toward = Vec3::new(-0.5, -0.3, 1.0).normalize();
    Light::Sun(Sun::new(toward, Vec3::splat(0.7), 0.5))
}

fn sky() -> Light {
    let texels = vec![Vec3::splat(0.1), Vec3::splat(0.3)];
    Light::Environment(Box::new(Environment::image(
        2,
        1,
        texels,
        Vec3::ONE,
        &DMat3::IDENTITY,
    )))
}

/// Some balls and one each of the other lamps, of suns, skies and emissive squares.
fn set(balls: u32, choice: LightChoice) -> LightSet {
    let mut builder = LightSetBuilder::new(eye(), false, Default::default());
    for i in 0..balls {
        builder.add(ball(1.5 * i as f32 - 2.0), Rules::NONE, i);
    }
    builder.add(sun(), Rules::NONE, balls);
    builder.add(area(), Rules::NONE, balls + 1);
    let triangles = halves(Vec3::new(-2.0, -2.0, 2.0), 1.0).to_vec();
    builder.add_mesh(mesh(4, triangles));
    builder.add_environment(sky(), Rules::NONE);
    let device = Device::new(Some(1), None).unwrap();
    builder.build(choice, &device).unwrap()
}

/// What rays find, with the densities of light sampling: the irradiance, and the integral of the densities, that of samples
/// left out which are behind others.
fn found(set: &LightSet, at: &LightSampleContext, n: u32) -> (f64, f64) {
    let (mut irradiance, mut density) = (0.0, 0.0);
    let square = halves(Vec3::new(-2.0, -2.0, 2.0), 1.0);
    for wi in grid(n).map(warp::sphere) {
        let mut add = |radiance: Vec3, pdf: f32| {
            irradiance += f64::from(radiance.x * wi.z.max(0.0));
            density += f64::from(pdf);
        };
        let ray = (RayKind::Diffuse, 0, Shadows::Plain);
        set.le_along_ray(at, (at.point, wi, f32::INFINITY), ray, |e, pdf, _, _| {
            add(e, pdf);
        });
        set.environment_le(at, wi, ray, |e, pdf, _| add(e, pdf));
        let on = at.point + wi * ((2.0 - at.point.z) / wi.z);
        let (low, high) = (square[0][0], square[0][2]);
        let within =
            on.truncate().cmpge(low.truncate()).all() && on.truncate().cmple(high.truncate()).all();
        if wi.z > 0.0 && within {
            add(Vec3::splat(3.0), set.surface_pdf(at, wi, (4, 0), on));
        }
    }
    let each = 4.0 * std::f64::consts::PI / f64::from(n * n);
    (irradiance * each, density * each)
}

/// With few lights and many, chosen by place and by power, and counted as in Cycles with its tree and without: samples of the set and rays find the same light, by one
/// estimate of the density.
#[test]
fn samples_of_all_lights_and_rays_find_the_same() {
    let choices = [
        LightChoice::Place,
        LightChoice::Power,
        LightChoice::Even,
        LightChoice::Tree,
    ];
    for (balls, choice) in [2, 20]
        .into_iter()
        .flat_map(|balls| choices.map(|c| (balls, c)))
    {
        let set = set(balls, choice);
        let at = set.context(Vec3::new(0.1, 0.2, 0.3), Some(Vec3::Z));
        let (n, choices) = (16, 4000);
        let (mut irradiance, mut drawn) = (0.0, 0.0);
        for k in 0..choices {
            let u_light = (k as f32 + 0.5) / choices as f32;
            for u in grid(n) {
                if let Some((s, _)) = set.sample(&at, u_light, u) {
                    irradiance += f64::from(s.contribution().x * s.wi.z.max(0.0) * s.counts);
                    drawn += f64::from(s.counts);
                }
            }
        }
        let all = f64::from(n * n * choices);
        let (by_rays, density) = found(&set, &at, 900);
        assert!(
            (irradiance / all / by_rays - 1.0).abs() < 1e-2,
            "{balls} {choice:?}: {} {by_rays}",
            irradiance / all
        );
        let drawn = drawn / all;
        assert!(
            (density - drawn).abs() < 1e-2,
            "{balls} {choice:?}: {density} {drawn}"
        );
    }
}

/// A lamp that stands around a point has its disc before the rays from there, which end within its sphere.
#[test]
fn rays_that_end_inside_of_a_lamp_find_its_disc() {
    for balls in [1, 20] {
        let mut builder = LightSetBuilder::new(eye(), false, Default::default());
        for i in 0..balls {
            builder.add(ball(2.0 + i as f32), Rules::NONE, i);
        }
        let around = Lamp {
            center: Vec3::new(0.0, 0.0, 0.5),
            radius: 1.0,
            soft_falloff: true,
            intensity: Vec3::ONE,
            cone: None,
        };
        builder.add(Light::Lamp(Box::new(around)), Rules::NONE, balls);
        let device = Device::new(Some(1), None).unwrap();
        let set = builder.build(LightChoice::Place, &device).unwrap();
        let at = set.context(Vec3::ZERO, None);
        let (ray, mut met) = ((Vec3::ZERO, Vec3::Z, 0.75), 0);
        let kind = (RayKind::Diffuse, 0, Shadows::Plain);
        set.le_along_ray(&at, ray, kind, |_, _, _, _| met += 1);
        assert_eq!(met, 1, "{balls} others");
    }
}

/// Sources have the numbers that the scene gives them, in whatever order lamps and suns come.
#[test]
fn sources_are_known_by_their_numbers_in_the_scene() {
    let set = set(2, LightChoice::Place);
    let numbers = [
        (Source::Lamp(0), Some(0)),
        (Source::Lamp(2), Some(3)),
        (Source::Sun(0), Some(2)),
        (Source::Lamp(3), None),
        (Source::Surface(4), None),
        (Source::Environment, None),
    ];
    for (source, number) in numbers {
        assert_eq!(set.number_in_scene(source), number, "{source:?}");
    }
    let at = set.context(Vec3::ZERO, Some(Vec3::Z));
    let drawn: Vec<_> = (0..1000)
        .filter_map(|k| Some(set.source(set.draw(&at, k as f32 / 1000.0)?.0)))
        .collect();
    for source in [
        Source::Lamp(0),
        Source::Lamp(1),
        Source::Lamp(2),
        Source::Surface(4),
        Source::Sun(0),
        Source::Environment,
    ] {
        assert!(drawn.contains(&source), "{source:?}");
    }
}

/// Rays see what the rules allow, and light that passes surfaces is for light sampling alone.
#[test]
fn rules_decide_what_rays_find() {
    let rules = |visibility, max_bounces| Rules::new(visibility, (max_bounces, true), true);
    let without = |kind| Visibility::ALL.without(kind);
    let seen = |rules: Rules, kind, bounces| {
        let mut builder = LightSetBuilder::new(eye(), false, Default::default());
        builder.add(ball(0.0), rules, 0);
        builder.add(sun(), rules, 1);
        let device = Device::new(Some(1), None).unwrap();
        let set = builder.build(LightChoice::Place, &device).unwrap();
        let at = set.context(Vec3::ZERO, None);
        let mut pdfs = Vec::new();
        let toward = Vec3::new(-0.5, -0.3, 1.0).normalize();
        let ray = (Vec3::ZERO, Vec3::Z, f32::INFINITY);
        set.le_along_ray(&at, ray, (kind, bounces, Shadows::Plain), |_, pdf, _, _| {
            pdfs.push(pdf)
        });
        set.environment_le(&at, toward, (kind, bounces, Shadows::Plain), |_, pdf, _| {
            pdfs.push(pdf)
        });
        pdfs
    };
    let finite = |pdfs: Vec<f32>| pdfs.len() == 2 && pdfs.iter().all(|pdf| pdf.is_finite());
    assert!(finite(seen(Rules::NONE, RayKind::Diffuse, 7)));
    // Without multiple importance, no scattered ray finds it, nor does one from a mirror.
    let sampled = Rules::new(Visibility::ALL, (u32::MAX, false), true);
    assert!(sampled.only_sampled());
    assert!(seen(sampled, RayKind::Glossy, 1).is_empty());
    assert_eq!(seen(sampled, RayKind::Camera, 0).len(), 2);
    let hidden = rules(without(RayKind::Diffuse), u32::MAX);
    assert!(seen(hidden, RayKind::Diffuse, 0).is_empty());
    assert!(finite(seen(hidden, RayKind::Glossy, 0)));
    let near = rules(Visibility::ALL, 1);
    assert!(finite(seen(near, RayKind::Diffuse, 1)));
    assert!(seen(near, RayKind::Diffuse, 2).is_empty());
    let through = rules(without(RayKind::Shadow), u32::MAX);
    assert_eq!(seen(through, RayKind::Diffuse, 0), [f32::INFINITY; 2]);
    assert!(finite(seen(through, RayKind::Camera, 0)));
    // As in Cycles rays have their part, which is lost behind what is in the way.
    assert!(finite(seen(through.losing_rays(true), RayKind::Diffuse, 0)));
}

/// A sky of one colour is left to the rays that the BSDF draws, beside other lights and alone.
#[test]
fn an_even_sky_has_no_light_samples() {
    let even = || Light::Environment(Box::new(Environment::constant(Vec3::splat(0.2))));
    let pdf = |with_sun: bool, rules: Rules| {
        let mut builder = LightSetBuilder::new(eye(), false, Default::default());
        builder.add_environment(even(), rules);
        if with_sun {
            builder.add(sun(), Rules::NONE, 0);
        }
        let set = builder
            .build(LightChoice::Place, &Device::new(Some(1), None).unwrap())
            .unwrap();
        let at = set.context(Vec3::ZERO, Some(Vec3::Z));
        let mut drawn = (0..100).filter_map(|k| set.draw(&at, k as f32 / 100.0));
        let sky = drawn.any(|(drawn, _)| matches!(set.source(drawn), Source::Environment));
        let mut found = Vec::new();
        set.environment_le(
            &at,
            Vec3::Y,
            (RayKind::Diffuse, 0, Shadows::Plain),
            |_, pdf, _| found.push(pdf),
        );
        (sky, found)
    };
    assert_eq!(pdf(true, Rules::NONE), (false, vec![0.0]));
    assert_eq!(pdf(false, Rules::NONE), (false, vec![0.0]));
    // Light that passes surfaces has no other way.
    let through = Rules::new(
        Visibility::ALL.without(RayKind::Shadow),
        (u32::MAX, true),
        true,
    );
    assert_eq!(pdf(true, through), (true, vec![f32::INFINITY]));
}

/// Half of the samples count for surfaces, and of the other half each lamp, each sun and a sky of several colours have the same share.
#[test]
fn lights_count_as_if_they_were_drawn_evenly() {
    let set = set(2, LightChoice::Even);
    for point in [Vec3::ZERO, Vec3::new(40.0, 0.0, 5.0)] {
        let at = set.context(point, Some(Vec3::Z));
        let finite = (0..set.lights.len() as u32).map(Drawn::Finite);
        let infinite = (0..set.infinite.len() as u32).map(Drawn::Infinite);
        let mut shares = std::collections::BTreeMap::new();
        for drawn in finite.chain(infinite) {
            // Of a surface each triangle has its part.
            let share = shares.entry(format!("{:?}", set.source(drawn)));
            *share.or_insert(0.0) += set.told_probability(&at, drawn);
        }
        assert_eq!(shares.len(), 6, "{shares:?}");
        for (source, share) in shares {
            let expected = if source.starts_with("Surface") {
                0.5
            } else {
                0.1
            };
            assert!((share - expected).abs() < 1e-6, "{source}: {share}");
        }
    }
}
