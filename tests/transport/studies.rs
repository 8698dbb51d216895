//! The settings for studies change the noise and nothing else.

use super::*;

/// Every setting on scenes of the gallery, against the default with other seeds, 16 seeds each: some
/// fifty comparisons, of which one beyond 4 σ would come about by chance once in 60 times (Student's t with 30
/// degrees of freedom). The seeds are fixed.
fn studies_change_no_mean(scenes: impl IntoIterator<Item = (&'static str, Scene)>) {
    let ways = |settings: RenderSettings| {
        let with = |light_sampling, light_samples, roulette| RenderSettings {
            light_sampling,
            light_samples,
            roulette,
            ..settings.clone()
        };
        [
            (
                "uniform directions",
                with(LightSampling::Hemisphere, 1, Some(2)),
            ),
            ("16 light samples", with(LightSampling::Mis, 16, Some(2))),
            (
                "3 light samples without MIS",
                with(LightSampling::Nee, 3, Some(2)),
            ),
            (
                "5 light samples for what only they find",
                with(LightSampling::Bsdf, 5, Some(2)),
            ),
            ("no roulette", with(LightSampling::Mis, 1, None)),
            (
                "roulette from the first bounce",
                with(LightSampling::Mis, 1, Some(1)),
            ),
        ]
    };
    for (name, scene) in scenes {
        let usual = estimate(&scene, &small(32, 4), 100..116);
        for (way, settings) in ways(small(16, 4)) {
            // A lamp through two surfaces of such glass is met by one path in ten million, which then weighs ten
            // million: no number of samples that a test can take shows the mean. (Each lobe's own means are
            // tested beside the BSDF.)
            if name == "lamps, rough glass" && settings.light_sampling == LightSampling::Hemisphere
            {
                continue;
            }
            let (m, variance) = estimate(&scene, &settings, 0..16);
            let sigma = (usual.1 + variance).sqrt();
            let z = (m - usual.0) / sigma;
            println!(
                "{name}, {way}: {m} against {}, z = {z:.2}, σ = {:.2e}",
                usual.0,
                sigma / m
            );
            assert!(
                z.abs() < 4.0,
                "{name}, {way}: {m} against {}, z = {z}",
                usual.0
            );
        }
    }
}

/// Each third scene; `long` has all of them.
#[test]
fn studies_change_no_mean_in_some_scenes() {
    studies_change_no_mean(gallery().into_iter().step_by(3));
}

mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn uniform_directions_keep_a_white_furnace() {
        super::uniform_directions_keep_the_white_furnace();
    }

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn studies_change_no_mean_in_all_scenes() {
        super::studies_change_no_mean(super::gallery());
    }
}

/// White bodies under a white sky, found by uniform directions: still 1 in the mean.
fn uniform_directions_keep_the_white_furnace() {
    for (name, roughness, metallic, transmission) in [
        ("diffuse", 1.0, 0.0, 0.0),
        ("rough metal", 0.6, 1.0, 0.0),
        ("polished plastic", 0.0, 0.0, 0.0),
        // A sheet: in a solid the weights of many bounces multiply to a mean that hardly any path shows.
        ("rough sheet of glass", 0.8, 0.0, 1.0),
    ] {
        let mut scene = Scene {
            environment: constant_environment(1.0),
            ..Scene::default()
        };
        let material = MetallicRoughness {
            roughness,
            metallic,
            transmission,
            thin_walled: false,
            ..MetallicRoughness::default()
        };
        place(
            &mut scene,
            sphere(400, 0.0, true),
            material,
            &[DAffine3::IDENTITY],
        );
        scene.cameras.push(camera(DVec3::new(0.0, 0.0, 3.0), 0.5));
        let settings = RenderSettings {
            light_sampling: LightSampling::Hemisphere,
            ..small(64, 64)
        };
        let (m, variance) = estimate(&scene, &settings, 0..12);
        println!("{name}: {m} ± {:.1e}", variance.sqrt());
        // What smooth normals on flat facets lose at the rim (see the furnace of BSDF sampling), and 4 σ.
        assert!(
            (m - 1.0).abs() < 1e-3 + 4.0 * variance.sqrt(),
            "{name}: {m}"
        );
        assert!(variance.sqrt() < 0.05, "{name}: {variance}");
    }
}

/// More light samples have less noise where the light is what is noisy: a floor under a large lamp. The points
/// of all samples are one net, so that sixteen of them are as good as sixteen times the samples: the variance
/// falls by more than the 16 of independent ones.
#[test]
fn light_samples_are_spread_together() {
    let mut scene = Scene::default();
    place(
        &mut scene,
        quad([-9.0, -1.0, 9.0], [18.0, 0.0, 0.0], [0.0, 0.0, -18.0]),
        diffuse([0.5; 3]),
        &[DAffine3::IDENTITY],
    );
    let mut light = looking_down(
        area(AreaShape::Rectangle, [3.0, 3.0], std::f32::consts::PI),
        DVec3::new(0.0, 1.0, 0.0),
        DAffine3::IDENTITY,
    );
    light.visibility = Visibility::ALL.without(RayKind::Camera);
    scene.lights.push(light);
    let mut down = camera(DVec3::new(0.0, 0.5, 0.0), 1.5);
    down.world_from_camera *= DAffine3::from_rotation_x(-1.5);
    scene.cameras.push(down);
    // One pixel at a time: all light is direct, so that what differs is the light samples' noise.
    let variance = |light_samples| {
        let pictures: Vec<_> = (0..16)
            .map(|seed| {
                colors(&run(
                    &scene,
                    &RenderSettings {
                        seed,
                        light_samples,
                        light_sampling: LightSampling::Nee,
                        ..small(4, 0)
                    },
                ))
            })
            .collect();
        let n = pictures.len() as f64;
        let pixels = pictures[0].len();
        (0..pixels)
            .map(|i| {
                let m = pictures.iter().map(|p| p[i][0]).sum::<f64>() / n;
                pictures.iter().map(|p| (p[i][0] - m).powi(2)).sum::<f64>() / (n - 1.0)
            })
            .sum::<f64>()
            / pixels as f64
    };
    let (one, sixteen) = (variance(1), variance(16));
    println!("{one:.2e} {sixteen:.2e} {:.1}", one / sixteen);
    assert!(one > 16.0 * sixteen, "{one} {sixteen}");
}
