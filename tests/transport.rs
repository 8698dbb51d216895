//! Light transport on scenes built here: answers that are exact, or equalities between renders.

mod accuracy;
mod below;
mod blended;
mod branches;
mod catchers;
mod center;
mod closed_lamps;
mod coincident;
mod dispersion;
mod fast_gi;
mod forecast;
mod linking;
mod media;
mod motion;
mod nesting;
mod patterns;
mod portals;
mod replay;
mod studies;
mod translucent;
mod visibility;

use glam::{DAffine3, DVec3, Vec3};
use sundog::effects::{self, Matte};
use sundog::film::{Pass, Passes};
use sundog::render::{EffectChoice, LightSampling, RenderSettings, Rendering, Silent, render};
use sundog::sampler::hashed;
use sundog::scene::graph::{Node, NodeKind, SimpleBsdf};
use sundog::scene::{
    AlphaMode, Anisotropy, Aperture, AreaShape, Camera, Coat, CoatNormal, Environment, Image,
    ImageId, Light, LightKind, MetallicRoughness, NormalTexture, Projection, RayKind, Scene, Sheen,
    Texture, Visibility,
};
use sundog::selftest::kit::{
    camera, constant_environment, diffuse, glass, light, place, quad, sphere,
};

fn small(samples: u32, bounces: u32) -> RenderSettings {
    RenderSettings {
        width: 32,
        height: 24,
        samples,
        bounces,
        threads: Some(2),
        ..RenderSettings::default()
    }
}

fn run(scene: &Scene, settings: &RenderSettings) -> Rendering {
    let rendering = render(scene, settings, &Silent).unwrap();
    assert_eq!(
        rendering.statistics.non_finite, 0,
        "{:?}",
        rendering.statistics.non_finite_examples
    );
    rendering
}

fn colors(r: &Rendering) -> Vec<[f64; 3]> {
    r.picture.layers[0]
        .data
        .chunks(4)
        .map(|c| [f64::from(c[0]), f64::from(c[1]), f64::from(c[2])])
        .collect()
}

fn mean(r: &Rendering) -> f64 {
    let c = colors(r);
    c.iter().flatten().sum::<f64>() / (3 * c.len()) as f64
}

/// Mean of the picture over seeds, and its variance.
fn estimate(scene: &Scene, settings: &RenderSettings, seeds: std::ops::Range<u32>) -> (f64, f64) {
    let n = seeds.len() as f64;
    let means: Vec<f64> = seeds
        .map(|seed| {
            let settings = settings.clone();
            mean(&run(scene, &RenderSettings { seed, ..settings }))
        })
        .collect();
    let m = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|x| (x - m).powi(2)).sum::<f64>() / (n * (n - 1.0));
    (m, variance)
}

/// The closed, displaced room of NUMERICS.md 2.2 with spheres in it (some instanced), all of them
/// white, seen from inside, under an environment of 1: any light is a leak. No ball touches the
/// wall: beside a line where surfaces cross, a point's error bound reaches through the other one.
fn closed_room(scale: f64, center: DVec3) -> Scene {
    let mut scene = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    let room = DAffine3::from_scale_rotation_translation(
        DVec3::splat(2.0 * scale),
        glam::DQuat::from_rotation_x(0.3),
        center,
    );
    place(
        &mut scene,
        sphere(200, 0.4, false),
        diffuse([1.0; 3]),
        &[room],
    );
    let balls: Vec<DAffine3> = (0..20)
        .map(|i| {
            let r = |k| f64::from(hashed(k, i, 3)) - 0.5;
            DAffine3::from_scale_rotation_translation(
                DVec3::new(0.1, 0.15, 0.1 + 0.1 * (r(1) + 0.5)) * scale,
                glam::DQuat::from_rotation_y(6.0 * r(2)),
                center + DVec3::new(r(3), r(4), r(5) - 0.3) * 1.2 * scale,
            )
        })
        .collect();
    place(
        &mut scene,
        sphere(40, 0.3, false),
        diffuse([1.0; 3]),
        &balls,
    );
    scene
        .cameras
        .push(camera(center + DVec3::new(0.0, 0.0, 1.2 * scale), 1.2));
    scene
}

#[test]
fn no_light_leaks_into_a_closed_room_of_any_scale_or_place() {
    let mut cases: Vec<(f64, DVec3)> = [1e-4, 1e-2, 1.0, 1e2, 1e4]
        .map(|s| (s, DVec3::ZERO))
        .to_vec();
    cases.push((1.0, DVec3::new(1e7, -1e7, 0.5e7)));
    cases.push((1e-3, DVec3::new(10.0, 10.0, 10.0)));
    for (scale, center) in cases {
        // The sky is found by rays alone, the sun by light samples too.
        let mut room = closed_room(scale, center);
        let sun = LightKind::Sun {
            irradiance: 1.0,
            angle: 0.2,
        };
        room.lights.push(light("Sun", sun, DAffine3::IDENTITY));
        let r = run(&room, &small(24, 20));
        assert!(r.statistics.rays > 500_000, "{}", r.statistics.rays);
        let bright = colors(&r)
            .iter()
            .filter(|c| c.iter().any(|&v| v != 0.0))
            .count();
        assert_eq!(
            bright,
            0,
            "scale {scale} at {center}: {bright} pixels of {} see through the wall",
            32 * 24
        );
    }
}

#[test]
fn no_ray_hits_the_triangle_that_it_leaves() {
    use sundog::math::{Frame, float::ray_origin, warp};
    use sundog::sampler::{Dimension, Sequence};
    use sundog::world::{Asking, Options, Scratch, Wanted, World};
    for (scale, center) in [
        (1e-4, DVec3::ZERO),
        (1.0, DVec3::ZERO),
        (1e4, DVec3::ZERO),
        (1.0, DVec3::splat(1e7)),
    ] {
        let scene = closed_room(scale, center);
        let options = Options {
            camera: &scene.cameras[0],
            rows: 48,
            aspect: 1.0,
            effects: enumset::EnumSet::empty(),
            threads: Some(1),
            instructions: None,
            cull_backfaces: false,
            light_shares: Default::default(),
            clamps_direct: false,
            uv_pass: false,
            aovs: false,
            vectors: false,
            roughens: false,
            coincident: None,
            ablation: Default::default(),
        };
        let world = World::new(&scene, &options).unwrap();
        let (mut rays, mut self_hits, mut escapes) = (0u32, 0u32, 0u32);
        for path in 0..4000u32 {
            let sampler = Sequence::new(3).sampler(path % 64, path / 64, 0);
            let (mut origin, mut direction) =
                (Vec3::ZERO, warp::sphere(sampler.pair(Dimension::Filter, 0)));
            let mut last = None;
            for bounce in 0..12 {
                let Some(hit) = world.intersect::<Matte>(
                    origin,
                    direction,
                    (0.0, f32::INFINITY),
                    RayKind::Camera,
                    (&sampler, 0),
                ) else {
                    escapes += 1;
                    break;
                };
                rays += 1;
                let id = (hit.instance, hit.geometry, hit.primitive);
                self_hits += u32::from(last == Some(id));
                last = Some(id);
                let mut scratch = Scratch::default();
                let asking = Asking::along(direction);
                let surface =
                    world.surface::<Matte>(&hit, (origin, asking), Wanted::Light, &mut scratch);
                let n = surface.normals.geometric;
                direction = Frame::from_normal(n).to_world(warp::cosine_hemisphere(
                    sampler.pair(Dimension::Bsdf, bounce),
                ));
                origin = ray_origin(surface.point, n);
            }
        }
        assert_eq!(
            (self_hits, escapes),
            (0, 0),
            "scale {scale} at {center}, {rays} rays"
        );
        assert!(rays > 40_000);
    }
}

/// White bodies under a white sky vanish: each pixel is 1.
#[test]
fn white_bodies_vanish_in_a_white_furnace() {
    let materials = [
        ("diffuse", diffuse([1.0; 3])),
        (
            "metal",
            MetallicRoughness {
                metallic: 1.0,
                roughness: 0.0,
                ..MetallicRoughness::default()
            },
        ),
        (
            "rough metal",
            MetallicRoughness {
                metallic: 1.0,
                roughness: 0.6,
                ..MetallicRoughness::default()
            },
        ),
        (
            "plastic",
            MetallicRoughness {
                metallic: 0.0,
                roughness: 0.4,
                ..MetallicRoughness::default()
            },
        ),
        (
            "polished plastic",
            MetallicRoughness {
                metallic: 0.0,
                roughness: 0.0,
                ..MetallicRoughness::default()
            },
        ),
        ("glass", glass(0.0, 1.5)),
        ("rough glass", glass(0.5, 1.5)),
        (
            "thin glass",
            MetallicRoughness {
                metallic: 0.0,
                roughness: 0.3,
                transmission: 1.0,
                ..MetallicRoughness::default()
            },
        ),
    ];
    const RINGS: u32 = 400;
    for (name, material) in materials {
        let mut scene = under_a_white_picture();
        place(
            &mut scene,
            sphere(RINGS, 0.0, true),
            material,
            &[DAffine3::IDENTITY],
        );
        scene.cameras.push(camera(DVec3::new(0.0, 0.0, 3.0), 0.5));
        let n = 8;
        let means: Vec<f64> = (0..n)
            .map(|seed| {
                let settings = RenderSettings {
                    seed,
                    ..small(48, 200)
                };
                mean(&run(&scene, &settings))
            })
            .collect();
        let m = means.iter().sum::<f64>() / f64::from(n);
        let variance = means.iter().map(|x| (x - m).powi(2)).sum::<f64>() / f64::from(n * (n - 1));
        println!("{name}: {m} ± {:.1e}", variance.sqrt());
        // Smooth normals on flat facets lose a little at the rim: what would cross the facet to
        // the wrong side is dropped. That many rings keep it below the bound. What is beyond it is three σ of noise at most,
        // which rough glass has.
        let bound = 1e-3 + 3.0 * variance.sqrt();
        assert!((m - 1.0).abs() < bound, "{name}: {m}, not within {bound}");
        assert!(variance.sqrt() < 2e-3, "{name}: {variance}");
    }
}

/// The same radiance from everywhere, as a picture: light samples go to it, unlike to a sky of one colour.
fn under_a_white_picture() -> Scene {
    Scene {
        environment: constant_environment(1.0).map(|environment| Environment {
            image: Some(ImageId(0)),
            ..environment
        }),
        images: vec![Image {
            name: "white".into(),
            width: 8,
            height: 4,
            channels: 3,
            pixels: vec![1f32; 3 * 8 * 4].into(),
        }],
        ..Scene::default()
    }
}

fn checker(alpha: bool) -> Image {
    let pixels: Vec<u8> = (0..8 * 8)
        .flat_map(|i| {
            let on = (i % 8 + i / 8) % 2 == 0;
            let v = if on { 230 } else { 40 };
            [v, 90, 255 - v, if alpha && on { 60 } else { 255 }]
        })
        .collect();
    Image {
        name: "checker".into(),
        width: 8,
        height: 8,
        channels: 4,
        pixels: pixels.into(),
    }
}

fn texture(image: u32) -> Texture {
    ImageId(image).into()
}

fn area(shape: AreaShape, size: [f32; 2], spread: f32) -> LightKind {
    LightKind::Area {
        shape,
        size,
        power: 12.0,
        normalize: true,
        spread,
    }
}

/// A light that looks down from a place, through a transform of its own.
fn looking_down(kind: LightKind, at: DVec3, own: DAffine3) -> Light {
    let down = glam::DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    Light {
        color: [1.0, 0.9, 0.8],
        visibility: Visibility::ALL.without(RayKind::Camera),
        ..light(
            "light",
            kind,
            DAffine3::from_rotation_translation(down, at) * own,
        )
    }
}

/// Area lights of every outline under every kind of transform, and soft lamps, over a floor with a ball: more of them
/// than are tried in a row.
fn area_lights() -> Vec<Light> {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let scale = |x: f64, y: f64, z: f64| DAffine3::from_scale(DVec3::new(x, y, z));
    let sheared = scale(1.0, 2.0, 1.0) * DAffine3::from_rotation_z(0.7) * scale(1.5, 0.6, 1.0);
    let (rectangle, ellipse) = (AreaShape::Rectangle, AreaShape::Ellipse);
    let full = std::f32::consts::PI;
    vec![
        looking_down(
            area(rectangle, [1.0, 0.5], full),
            at(-1.5, 1.0, 0.5),
            scale(1.0, -2.0, 1.0),
        ),
        looking_down(
            area(rectangle, [0.5, 0.5], 1.2),
            at(1.0, 1.5, 1.0),
            DAffine3::IDENTITY,
        ),
        looking_down(
            area(ellipse, [1.0, 2.0], full),
            at(0.5, 2.0, -1.5),
            scale(-1.0, 1.0, 3.0),
        ),
        looking_down(
            area(ellipse, [0.4, 0.4], 0.6),
            at(-0.5, 1.2, 1.5),
            DAffine3::IDENTITY,
        ),
        looking_down(
            area(rectangle, [0.5, 0.5], full),
            at(0.0, 2.5, 0.0),
            sheared,
        ),
        looking_down(
            LightKind::Point {
                intensity: 2.0,
                radius: 0.3,
                soft_falloff: true,
            },
            at(1.8, 0.5, 0.8),
            DAffine3::IDENTITY,
        ),
        looking_down(
            LightKind::Spot {
                intensity: 4.0,
                radius: 0.2,
                soft_falloff: true,
                half_angle: 0.6,
                blend: 0.4,
            },
            at(-1.8, 1.5, 1.2),
            scale(1.0, 1.7, 1.0),
        ),
    ]
}

/// A floor and nothing else.
fn floor() -> Scene {
    let mut scene = Scene::default();
    place(
        &mut scene,
        quad([-3.0, -1.0, 3.0], [6.0, 0.0, 0.0], [0.0, 0.0, -6.0]),
        diffuse([0.7, 0.6, 0.5]),
        &[DAffine3::IDENTITY],
    );
    scene
}

/// Scenes that call for different effects; together for all of them.
fn gallery() -> Vec<(&'static str, Scene)> {
    let base = || {
        let mut scene = floor();
        scene.cameras.push(camera(DVec3::new(0.0, 0.2, 4.0), 0.8));
        scene
    };
    let lamp = |scene: &mut Scene| {
        place(
            scene,
            quad([-0.5, 2.0, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            MetallicRoughness {
                emission: [6.0, 5.0, 4.0],
                ..diffuse([0.0; 3])
            },
            &[DAffine3::IDENTITY],
        );
    };
    let light = |kind: LightKind, at: DVec3| Light {
        color: [1.0, 0.9, 0.8],
        ..light(
            "light",
            kind,
            DAffine3::from_rotation_translation(glam::DQuat::from_rotation_x(-1.2), at),
        )
    };
    let ball = |scene: &mut Scene, material: MetallicRoughness| {
        place(
            scene,
            sphere(24, 0.0, true),
            material,
            &[DAffine3::from_scale(DVec3::splat(0.8))],
        );
    };
    let mut list = Vec::new();

    let mut scene = base();
    lamp(&mut scene);
    ball(
        &mut scene,
        MetallicRoughness {
            base_color: [0.9, 0.7, 0.3],
            roughness: 0.3,
            ..MetallicRoughness::default()
        },
    );
    list.push(("mesh light, metal", scene));

    let mut scene = base();
    scene.environment = constant_environment(0.5);
    scene.lights.push(light(
        LightKind::Sun {
            irradiance: 2.0,
            angle: 0.2,
        },
        DVec3::ZERO,
    ));
    ball(
        &mut scene,
        MetallicRoughness {
            metallic: 0.0,
            roughness: 0.2,
            base_color: [0.2, 0.5, 0.8],
            ..MetallicRoughness::default()
        },
    );
    list.push(("sky and sun, plastic", scene));

    let mut scene = base();
    scene.lights.push(light(
        LightKind::Point {
            intensity: 5.0,
            radius: 0.3,
            soft_falloff: false,
        },
        DVec3::new(-1.5, 2.0, 1.0),
    ));
    scene.lights.push(light(
        LightKind::Spot {
            intensity: 9.0,
            radius: 0.1,
            soft_falloff: false,
            half_angle: 0.5,
            blend: 0.3,
        },
        DVec3::new(0.5, 2.0, 1.5),
    ));
    scene.lights.push(light(
        LightKind::Point {
            intensity: 2.0,
            radius: 0.0,
            soft_falloff: false,
        },
        DVec3::new(1.5, 1.0, 1.0),
    ));
    ball(&mut scene, glass(0.25, 1.5));
    lamp(&mut scene);
    list.push(("lamps, rough glass", scene));

    let mut scene = base();
    lamp(&mut scene);
    scene.environment = constant_environment(0.2);
    scene.images.push(checker(false));
    ball(
        &mut scene,
        MetallicRoughness {
            metallic: 0.0,
            roughness: 0.5,
            diffuse_roughness: 0.4,
            anisotropy: Some(Anisotropy::Gltf {
                strength: 0.6,
                rotation: 0.5,
                texture: None,
            }),
            coat: Some(Box::new(Coat {
                weight: 0.8,
                texture: Some(texture(0)),
                roughness: 0.2,
                roughness_texture: None,
                ior: 1.6,
                tint: [0.9, 0.7, 0.8],
                normal: CoatNormal::Smooth,
            })),
            sheen: Some(Box::new(Sheen {
                color: [0.5, 0.4, 0.3],
                color_texture: None,
                roughness: 0.4,
                roughness_texture: None,
            })),
            thin_film: Some([400.0, 1.33]),
            base_color_texture: Some(texture(0)),
            normal_texture: Some(NormalTexture {
                texture: texture(0),
                scale: 0.4,
            }),
            ..MetallicRoughness::default()
        },
    );
    list.push(("textures and normal map", scene));

    let mut scene = base();
    lamp(&mut scene);
    scene.images.push(checker(true));
    for alpha_mode in [AlphaMode::Mask { cutoff: 0.5 }, AlphaMode::Blend] {
        ball(
            &mut scene,
            MetallicRoughness {
                alpha_mode,
                base_color_texture: Some(texture(0)),
                ..diffuse([1.0; 3])
            },
        );
    }
    list.push(("cut-outs and blends", scene));
    let mut scene = list[0].1.clone();
    scene.cameras[0].aperture = Some(Aperture {
        radius: 0.1,
        blades: 5,
        rotation: 0.2,
        ratio: 1.5,
        focus_distance: 3.0,
    });
    list.push(("a lens", scene));
    let plastic = MetallicRoughness {
        metallic: 0.0,
        roughness: 0.35,
        base_color: [0.3, 0.6, 0.4],
        ..MetallicRoughness::default()
    };
    let mut scene = base();
    scene.lights = area_lights();
    ball(&mut scene, plastic.clone());
    list.push(("area lights and soft lamps, plastic", scene));

    // Nothing that some rays miss stands between lights and what they light: there shadow rays and others disagree.
    let mut scene = base();
    scene.lights = area_lights();
    let kinds = [
        RayKind::Diffuse,
        RayKind::Glossy,
        RayKind::Transmission,
        RayKind::Shadow,
    ];
    for (i, light) in scene.lights.iter_mut().enumerate() {
        light.visibility = light.visibility.without(kinds[i % 4]);
        light.max_bounces = if i == 4 { 1 } else { Light::MAX_BOUNCES };
    }
    place(
        &mut scene,
        quad([-0.5, 3.0, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        MetallicRoughness {
            emission: [6.0, 5.0, 4.0],
            ..diffuse([0.0; 3])
        },
        &[DAffine3::IDENTITY],
    );
    if let Some(lamp) = scene.instances.last_mut() {
        lamp.visibility = Visibility::ALL.without(RayKind::Glossy);
    }
    ball(
        &mut scene,
        MetallicRoughness {
            transmission: 0.5,
            ..plastic.clone()
        },
    );
    list.push(("lights that some rays do not see", scene));

    let mut scene = base();
    scene.images.push(checker(true));
    scene.images.push(Image {
        name: "sky".into(),
        width: 2,
        height: 1,
        channels: 3,
        pixels: vec![0.9f32, 0.6, 0.3, 0.2, 0.4, 0.8].into(),
    });
    scene.environment = constant_environment(0.7).map(|environment| Environment {
        image: Some(ImageId(1)),
        ..environment
    });
    place(
        &mut scene,
        sphere(12, 0.0, true),
        MetallicRoughness {
            metallic: 0.4,
            metallic_roughness_texture: Some(texture(0)),
            emission: [0.5, 0.4, 0.3],
            emission_texture: Some(texture(0)),
            specular_texture: Some(texture(0)),
            specular_color_texture: Some(texture(0)),
            transmission: 0.5,
            transmission_texture: Some(texture(0)),
            ..plastic
        },
        &[0.6, 0.3].map(|size| DAffine3::from_scale(DVec3::splat(size))),
    );
    if let Some(mesh) = scene.meshes.last_mut() {
        let tints = (0..mesh.positions.len()).map(|i| [1.0, 0.1 * (i % 10) as f32, 0.5, 1.0]);
        mesh.colors = Some(tints.collect());
    }
    for (x, material) in [(-1.2, glass(0.0, 1.5)), (1.2, diffuse([0.8; 3]))] {
        let at = DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.5),
            glam::DQuat::IDENTITY,
            DVec3::new(x, 0.0, 0.5),
        );
        place(&mut scene, sphere(12, 0.0, true), material, &[at]);
    }
    if let Some(ball) = scene.instances.last_mut() {
        ball.holdout = true;
    }
    place(
        &mut scene,
        quad([1.0, -0.9, 1.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.0]),
        MetallicRoughness {
            simple: Some(Box::new(Node::new(NodeKind::Bsdf(SimpleBsdf::Translucent)))),
            ..MetallicRoughness::default()
        },
        &[DAffine3::IDENTITY],
    );
    list.push(("images everywhere, clear glass, a hole", scene));
    list.push(("patterns", patterns::scene()));
    list.push(("two sheets in one place", coincident::sheets(0.3)));
    list.push(("moving lamps", motion::moving_lamps()));
    list.push(("lights with receivers and blockers", linking::scene()));
    list.push(("fog", media::fog()));
    list.push(("cloud", media::cloud()));
    list.push(("coloured liquid", media::liquid()));
    list.push(("skin and marble", below::scene()));
    list.push(("portals", portals::scene()));
    list
}

/// Without the tree lights are drawn by their power alone: other noise, the same light.
#[test]
fn lights_drawn_by_power_alone_give_the_same_light() {
    let gallery = gallery();
    let lamps = gallery.iter().find(|(name, _)| name.starts_with("area"));
    let (_, scene) = lamps.unwrap();
    let without = RenderSettings {
        effects: EffectChoice::List(effects::names(effects::ALL - effects::Effect::LightTree)),
        ..small(4, 2)
    };
    let (tree, tree_variance) = estimate(scene, &small(4, 2), 0..24);
    let (power, power_variance) = estimate(scene, &without, 100..124);
    let z = (tree - power) / (tree_variance + power_variance).sqrt();
    assert!(z.abs() < 4.0, "{tree} and {power}: z {z}");
    // It is another choice.
    let rays = |settings| run(scene, settings).statistics.rays;
    assert_ne!(rays(&small(4, 2)), rays(&without));
}

/// The kernel made for a scene and the one for everything draw the same numbers: same bits.
/// Lights of less than nothing are sampled by their size: they take what the same lights give, to the bit.
#[test]
fn negative_lights_take_what_the_same_lights_give() {
    let mut scene = floor();
    scene.cameras.push(camera(DVec3::new(0.0, 0.2, 4.0), 0.8));
    scene.lights = area_lights();
    let sun = LightKind::Sun {
        irradiance: 1.0,
        angle: 0.1,
    };
    scene
        .lights
        .push(looking_down(sun, DVec3::ZERO, DAffine3::IDENTITY));
    scene.environment = constant_environment(0.2);
    place(
        &mut scene,
        sphere(24, 0.0, true),
        diffuse([0.8, 0.7, 0.6]),
        &[DAffine3::IDENTITY],
    );
    let given = colors(&run(&scene, &small(16, 3)));
    for light in &mut scene.lights {
        light.color = light.color.map(|c| -c);
    }
    let radiance = &mut scene.environment.as_mut().unwrap().radiance;
    *radiance = radiance.map(|c| -c);
    let taken = colors(&run(&scene, &small(16, 3)));
    assert!(given.iter().any(|c| c[0] > 0.5));
    for (given, taken) in given.iter().zip(&taken) {
        assert_eq!(*given, taken.map(|c| -c));
    }
}

#[test]
fn special_and_general_kernels_agree_bit_for_bit() {
    let mut covered = enumset::EnumSet::empty();
    let (_, mut grazed) = gallery().swap_remove(0);
    grazed.instances[0].info.shading_offset = 0.5;
    let more = [
        ("light that grazes counts less", grazed),
        ("a shadow catcher", catchers::with_ball()),
        ("dispersion", dispersion::with_ball()),
        ("solids that overlap", nesting::ice_in_water()),
        ("the last bounces replaced", fast_gi::of_floor()),
    ];
    for (name, scene) in gallery().into_iter().chain(more) {
        let special = run(&scene, &small(8, 6));
        let general = run(
            &scene,
            &RenderSettings {
                effects: EffectChoice::All,
                ..small(8, 6)
            },
        );
        assert!(
            special.picture.layers[0].data == general.picture.layers[0].data,
            "{name}"
        );
        assert!(mean(&special) > 0.01, "{name}");
        covered |= effects::EffectReport::detect(&scene).called_for & effects::ALL;
    }
    // What no gallery scene has: only the general kernel has it, and hard cases and lobes have tests of their own.
    let others = effects::Effect::Strands | effects::Effect::HairShaders;
    let expected = effects::ALL - others;
    assert_eq!(covered, expected, "the gallery calls for every effect");
}

/// What denoisers are told, by the kernel for it and by the one that keeps light apart as well, changes no bit of the picture.
#[test]
fn what_denoisers_are_told_changes_no_bits() {
    let features = Passes::COMBINED
        .with(Pass::DenoisingAlbedo)
        .with(Pass::DenoisingNormal)
        .with(Pass::DenoisingDepth);
    for (name, scene) in gallery() {
        let with = |passes| {
            let settings = RenderSettings {
                passes,
                ..small(6, 6)
            };
            run(&scene, &settings).picture.layers
        };
        let told = with(features);
        assert!(with(Passes::COMBINED)[0].data == told[0].data, "{name}");
        let apart = with(features.with(Pass::DiffuseColor));
        for layer in &told {
            let same = apart.iter().find(|other| other.name == layer.name);
            assert!(same.unwrap().data == layer.data, "{name}: {}", layer.name);
        }
    }
}

#[test]
fn one_two_and_seven_threads_give_the_same_bits() {
    for (name, scene) in gallery() {
        let with = |threads| {
            let r = run(
                &scene,
                &RenderSettings {
                    threads: Some(threads),
                    width: 70,
                    height: 50,
                    ..small(6, 6)
                },
            );
            r.picture
                .layers
                .iter()
                .map(|l| l.data.clone())
                .collect::<Vec<_>>()
        };
        let one = with(1);
        assert!(one == with(2) && one == with(7), "{name}");
    }
}

/// Light sampling and BSDF sampling have the mean of both together over 16 seeds, with |z| and the relative standard deviation
/// of the difference below what is given.
fn techniques_agree(
    name: &str,
    scene: &Scene,
    settings: &RenderSettings,
    greatest_z: f64,
    greatest_sigma: f64,
) {
    let estimate = |light_sampling| {
        let settings = RenderSettings {
            light_sampling,
            ..settings.clone()
        };
        estimate(scene, &settings, 0..16)
    };
    let mis = estimate(LightSampling::Mis);
    for way in [LightSampling::Nee, LightSampling::Bsdf] {
        let other = estimate(way);
        let sigma = (mis.1 + other.1).sqrt();
        let z = (other.0 - mis.0) / sigma;
        let relative = sigma / mis.0;
        let told = format!(
            "{name}, {way:?}: {} against {}, z = {z:.2}, σ = {relative:.2e}",
            other.0, mis.0
        );
        println!("{told}");
        assert!(z.abs() < greatest_z && relative < greatest_sigma, "{told}");
    }
}

/// Light sampling, BSDF sampling and both estimate the same means: 3 σ, the variance from
/// independent seeds.
fn all_ways_to_find_light_agree_within_three_sigma(
    scenes: impl IntoIterator<Item = (&'static str, Scene)>,
) {
    for (name, scene) in scenes {
        // The test has teeth: σ is at most a twentieth (light sampling alone is poor on glossy glass).
        techniques_agree(name, &scene, &small(48, 4), 3.0, 0.05);
    }
}

/// Each third scene; `long` has all of them.
#[test]
fn all_ways_to_find_light_agree() {
    all_ways_to_find_light_agree_within_three_sigma(gallery().into_iter().step_by(3));
}

mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn all_ways_to_find_light_agree_in_all_scenes() {
        super::all_ways_to_find_light_agree_within_three_sigma(super::gallery());
    }
}

/// A scene that is moved as a whole is the same scene; rounding may move single samples.
#[test]
fn a_scene_moved_by_ten_million_metres_is_the_same_picture() {
    // A portal's place is a number of its graph, which moves with nothing.
    for (name, scene) in gallery().into_iter().filter(|(name, _)| *name != "portals") {
        let moved = |by: DVec3| {
            let mut scene = scene.clone();
            scene
                .instances
                .iter_mut()
                .flat_map(|i| i.motion.iter_mut().chain([&mut i.world_from_object]))
                .for_each(|place| place.translation += by);
            scene
                .lights
                .iter_mut()
                .for_each(|l| l.world_from_light.translation += by);
            scene
                .cameras
                .iter_mut()
                .for_each(|c| c.world_from_camera.translation += by);
            scene
        };
        let (a, b) = (
            colors(&run(&scene, &small(16, 4))),
            colors(&run(&moved(DVec3::new(1e7, -3e6, 2e7)), &small(16, 4))),
        );
        let rel_mse: f64 = a
            .iter()
            .flatten()
            .zip(b.iter().flatten())
            .map(|(x, y)| (x - y).powi(2) / (x * x + 0.01))
            .sum::<f64>()
            / (3 * a.len()) as f64;
        assert!(rel_mse < 1e-4, "{name}: {rel_mse}");
    }
}

/// The irradiance of a diffuse floor under a point light, exactly: E = I cosθ / d², L = ρE/π.
#[test]
fn a_point_light_lights_a_floor_as_the_formula_says() {
    let mut scene = Scene::default();
    place(
        &mut scene,
        quad([-50.0, 0.0, 50.0], [100.0, 0.0, 0.0], [0.0, 0.0, -100.0]),
        diffuse([0.5; 3]),
        &[DAffine3::IDENTITY],
    );
    scene.lights.push(light(
        "p",
        LightKind::Point {
            intensity: 7.0,
            radius: 0.0,
            soft_falloff: false,
        },
        DAffine3::from_translation(DVec3::new(0.0, 2.0, 0.0)),
    ));
    let mut c = camera(DVec3::new(0.0, 1.0, 0.0), 1e-4);
    c.world_from_camera = DAffine3::from_rotation_translation(
        glam::DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
        DVec3::new(0.0, 1.0, 0.0),
    );
    scene.cameras.push(c);
    let m = mean(&run(&scene, &small(4, 0)));
    let exact = 0.5 / std::f64::consts::PI * 7.0 / 4.0;
    assert!((m / exact - 1.0).abs() < 1e-5, "{m} {exact}");
}

// --- Film: passes and alpha ---

fn all_passes(samples: u32) -> RenderSettings {
    RenderSettings {
        passes: Passes::ALL,
        ..small(samples, 6)
    }
}

fn layer<'a>(rendering: &'a Rendering, name: &str) -> &'a [f32] {
    let layers = &rendering.picture.layers;
    &layers.iter().find(|l| l.name == name).unwrap().data
}

/// (DiffDir + DiffInd) · DiffCol + … + Emit + Env is Combined. Each of the up to nine terms and eight sums is
/// rounded to f32 by half of 2⁻²³ at most, at sizes of at most the sum's (no term is negative); the paths' own
/// sums round as often again.
#[test]
fn the_passes_recombine_to_the_picture() {
    for (name, scene) in gallery() {
        let rendering = run(&scene, &all_passes(16));
        let of = |name: &str| layer(&rendering, name);
        let combined = of("Combined");
        let mut lit = [0.0f64; 3];
        for (pixel, whole) in combined.chunks_exact(4).enumerate() {
            for (channel, &whole) in whole[..3].iter().enumerate() {
                let at = |name: &str| f64::from(of(name)[3 * pixel + channel]);
                let mut sum = at("Emit") + at("Env") + at("VolumeDir") + at("VolumeInd");
                for (kind, lit) in ["Diff", "Gloss", "Trans"].into_iter().zip(&mut lit) {
                    let part = |what: &str| at(&format!("{kind}{what}"));
                    let light = (part("Dir") + part("Ind")) * part("Col");
                    sum += light;
                    *lit += light;
                }
                let bound = 64.0 * f64::from(f32::EPSILON) * sum + 1e-30;
                assert!(
                    (sum - f64::from(whole)).abs() <= bound,
                    "{name}, pixel {pixel}: {sum} {whole}"
                );
            }
        }
        // Every scene of the gallery has light in the passes that its name says.
        assert!(
            lit[0] > 0.0 || name.contains("metal") || name.contains("lens"),
            "{name}"
        );
        assert!(lit[2] > 0.0 || !name.contains("glass"), "{name}");
    }
}

/// Keeping light apart does not change the picture by a bit.
#[test]
fn passes_do_not_change_the_picture() {
    for (name, scene) in gallery() {
        let plain = RenderSettings {
            passes: Passes::COMBINED,
            ..small(8, 6)
        };
        let (plain, apart) = (run(&scene, &plain), run(&scene, &all_passes(8)));
        assert_eq!(plain.picture.layers.len(), 1);
        assert!(
            layer(&plain, "Combined") == layer(&apart, "Combined"),
            "{name}"
        );
    }
}

/// Light of a white world on a white plane with a Shading Offset of 1: 2 ∫ cos 2θ sin θ dθ up to π/4, (2√2 − 2)/3 by the cube and the
/// first power of the cosine.
#[test]
fn a_shading_offset_takes_light_that_grazes() {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 2.0), 0.5)],
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    let plane = quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
    place(&mut scene, plane, diffuse([1.0; 3]), &[DAffine3::IDENTITY]);
    assert!((mean(&run(&scene, &small(16, 0))) - 1.0).abs() < 1e-3);
    scene.instances[0].info.shading_offset = 1.0;
    let expected = (2.0 * 2.0_f64.sqrt() - 2.0) / 3.0;
    let found = mean(&run(&scene, &small(256, 0)));
    // A sample is at most 1 and on average this: its deviation is below a half.
    let bound = 5.0 * 0.5 / f64::from(256 * 32 * 24).sqrt();
    assert!((found - expected).abs() < bound, "{found} {expected}");
}

/// What clear glass reflects of a white world, and how much of the film is seen through it, come to 1: a furnace. Glass that is
/// rougher than the threshold is opaque.
#[test]
fn a_film_behind_clear_glass_has_what_the_glass_does_not_reflect() {
    let picture = |roughness: f32, transparent_glass| {
        let mut scene = Scene {
            cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 0.7)],
            environment: constant_environment(1.0),
            ..Scene::default()
        };
        let of = glass(roughness, 1.5);
        place(&mut scene, sphere(16, 0.0, true), of, &[DAffine3::IDENTITY]);
        let settings = RenderSettings {
            transparent_film: true,
            transparent_glass,
            ..small(64, 12)
        };
        let rendering = run(&scene, &settings);
        let combined = rendering.picture.layers[0].data.chunks_exact(4);
        let sums = combined.fold([0.0_f64; 2], |[light, alpha], c| {
            [light + f64::from(c[1]), alpha + f64::from(c[3])]
        });
        sums.map(|sum| sum / f64::from(32 * 24))
    };
    let [light, alpha] = picture(0.0, Some(0.1));
    // Five standard deviations of what a coin in each of 64 samples of a pixel may be off.
    let bound = 5.0 * 0.5 / f64::from(64 * 32 * 24).sqrt();
    assert!((light - alpha).abs() < bound, "{light} {alpha}");
    assert!(0.02 < light && alpha < 0.2, "{light} {alpha}");
    for opaque in [picture(0.0, None), picture(0.4, Some(0.3))] {
        let [light, alpha] = opaque;
        // All light of the world behind the sphere is in the picture; beside it there is none.
        assert!(
            (light - alpha).abs() < 0.02 && alpha > 0.2,
            "{light} {alpha}"
        );
    }
}

/// A white plane with a hole and a holdout beside it, before a grey sky: what lies straight behind the camera's
/// rays is no part of the picture, but lights the plane, whose light is 1/2 of albedo 1/2 under a sky of 1.
#[test]
fn a_transparent_film_leaves_out_what_it_should() {
    let mut scene = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    let part = |x: f32| quad([x, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let grey = diffuse([0.5; 3]);
    let hole = MetallicRoughness {
        alpha: 0.0,
        alpha_mode: AlphaMode::Blend,
        ..grey.clone()
    };
    place(&mut scene, part(-2.0), grey.clone(), &[DAffine3::IDENTITY]);
    place(&mut scene, part(-1.0), hole, &[DAffine3::IDENTITY]);
    place(&mut scene, part(0.0), grey, &[DAffine3::IDENTITY]);
    scene.instances[2].holdout = true;
    // Columns 0 to 3: the plane, the hole, the holdout, nothing.
    scene.cameras.push(Camera {
        projection: Projection::Orthographic {
            half_width: 2.0,
            half_height: 0.5,
        },
        ..camera(DVec3::Z, 1.0)
    });
    let settings = RenderSettings {
        width: 4,
        height: 1,
        filter: sundog::render::Filter {
            kind: sundog::render::FilterKind::Box,
            width: 1.0,
        },
        passes: Passes::ALL,
        ..small(64, 2)
    };
    let opaque = run(&scene, &settings);
    let clear = run(
        &scene,
        &RenderSettings {
            transparent_film: true,
            ..settings
        },
    );
    let alphas = |r: &Rendering| -> Vec<f32> {
        let pixels = layer(r, "Combined").chunks_exact(4);
        pixels.map(|p| p[3]).collect()
    };
    assert_eq!(alphas(&opaque), [1.0, 1.0, 0.0, 1.0]);
    assert_eq!(alphas(&clear), [1.0, 0.0, 0.0, 0.0]);
    let (o, c) = (layer(&opaque, "Combined"), layer(&clear, "Combined"));
    assert_eq!(o[..4], c[..4], "the sky lights the plane as before");
    assert!((o[0] - 0.5).abs() < 0.01, "{}", o[0]);
    assert_eq!((o[4], o[8], o[12]), (1.0, 0.0, 1.0));
    assert_eq!(c[4..7], [0.0; 3]);
    assert_eq!(c[8..11], [0.0; 3]);
    assert_eq!(c[12..15], [0.0; 3]);
    // As in Cycles, the world stays in its own pass.
    assert_eq!(layer(&clear, "Env")[9..12], [1.0; 3]);
}

/// Depth and position are those of the ray through the middle of the pixel, exactly: a plane under 45°.
#[test]
fn depth_and_position_are_of_the_middle_of_the_pixel() {
    let mut scene = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    // z = x − 4.
    place(
        &mut scene,
        quad([-8.0, -8.0, -12.0], [16.0, 0.0, 16.0], [0.0, 16.0, 0.0]),
        diffuse([0.5; 3]),
        &[DAffine3::IDENTITY],
    );
    scene.cameras.push(camera(DVec3::new(0.0, 0.0, 0.0), 0.5));
    let settings = RenderSettings {
        passes: Passes::ALL,
        ..small(3, 1)
    };
    let rendering = run(&scene, &settings);
    let t = (0.25f64).tan();
    for (i, &depth) in layer(&rendering, "Depth").iter().enumerate() {
        let (x, y) = ((i % 32) as f64 + 0.5, (i / 32) as f64 + 0.5);
        let (tx, ty) = ((x / 16.0 - 1.0) * t * 32.0 / 24.0, (1.0 - y / 12.0) * t);
        // −d = tx d − 4.
        let d = 4.0 / (1.0 + tx);
        assert!((f64::from(depth) - d).abs() < 1e-5, "{i}: {depth} {d}");
        // Blender's axes: x, depth, height.
        let p = &layer(&rendering, "Position")[3 * i..3 * i + 3];
        for (found, expected) in p.iter().zip([tx * d, d, ty * d]) {
            assert!((f64::from(*found) - expected).abs() < 1e-5, "{i}: {p:?}");
        }
    }
}

/// The camera's film is a circle of confusion: a point of light far behind the focus, seen by a lens, is the
/// lens' own shape, turned round its centre. A tiny lamp would do; here a small bright square at depth 2f, whose
/// image on the focal plane at depth f is the lens itself (similar triangles: r (2f − f) / 2f = r/2).
#[test]
fn a_point_out_of_focus_is_the_shape_of_the_lens() {
    let f = 2.0;
    for (blades, ratio) in [(0, 1.0), (3, 1.0), (6, 1.0), (0, 2.0)] {
        let mut scene = Scene::default();
        let e = 0.04f32;
        let light = MetallicRoughness {
            emission: [1.0; 3],
            ..diffuse([0.0; 3])
        };
        place(
            &mut scene,
            quad(
                [-e, -e, -2.0 * f as f32],
                [2.0 * e, 0.0, 0.0],
                [0.0, 2.0 * e, 0.0],
            ),
            light,
            &[DAffine3::IDENTITY],
        );
        let radius = 0.5;
        // The window spans ±0.5 at the focal plane: ±0.5/f in tangents.
        scene.cameras.push(Camera {
            window: Some(sundog::scene::Window {
                left: -0.5 / f,
                right: 0.5 / f,
                bottom: -0.5 / f,
                top: 0.5 / f,
            }),
            aperture: Some(Aperture {
                radius,
                blades,
                rotation: 0.0,
                ratio,
                focus_distance: f,
            }),
            ..camera(DVec3::ZERO, 1.0)
        });
        let n = 64u32;
        let rendering = run(
            &scene,
            &RenderSettings {
                width: n,
                height: n,
                ..small(512, 0)
            },
        );
        let combined = layer(&rendering, "Combined");
        // Two rays that meet at depth 2f cross the focal plane at half their distance on the lens, on the same
        // side; the blur by the square's own size and by the pixel filter is 1.5 pixels and e/2 at most.
        let blur = 0.5 * f64::from(e) + 1.6 / f64::from(n);
        let inside = |x: f64, y: f64, slack: f64| {
            let (x, y) = (x * ratio, y);
            let r = 0.5 * radius;
            if blades == 0 {
                return (x * x + y * y).sqrt() < r + slack * ratio;
            }
            let k = f64::from(blades);
            (0..blades).all(|i| {
                let angle = f64::from(i) * std::f64::consts::TAU / k;
                x * angle.cos() + y * angle.sin() < r * (std::f64::consts::PI / k).cos() + slack
            })
        };
        let (mut covered, mut dark, mut bright, mut sum, mut squares) = (0, 0, 0, 0.0, 0.0);
        for (i, pixel) in combined.chunks_exact(4).enumerate() {
            let x = (f64::from(i as u32 % n) + 0.5) / f64::from(n) - 0.5;
            let y = 0.5 - (f64::from(i as u32 / n) + 0.5) / f64::from(n);
            let value = f64::from(pixel[0]);
            if !inside(x, y, blur) {
                assert_eq!(value, 0.0, "{blades} {ratio}: light at {x}, {y}");
                dark += 1;
            } else if inside(x, y, -blur) {
                covered += 1;
                sum += value;
                squares += value * value;
            }
            bright += usize::from(value > 0.0);
        }
        assert!(
            covered > 100 && dark > 100 && bright > covered * 9 / 10,
            "{blades}: {covered} {dark} {bright}"
        );
        // Even inside: the lens is sampled by its area. The share of the lens through which a point sees the
        // square: (2e)² seen from depth f at 2f, that is (4e)²… over the lens' area.
        let count = covered as f64;
        let mean = sum / count;
        let area = if blades == 0 {
            std::f64::consts::PI
        } else {
            0.5 * f64::from(blades) * (std::f64::consts::TAU / f64::from(blades)).sin()
        } * radius
            * radius
            / ratio;
        // From a point of the focal plane the square at twice the depth covers (2 · 2e / …)² of the lens: a lens
        // point q sends its ray through p to 2p − q, which lies in the square for q in a square of the same size.
        let expected = (2.0 * f64::from(e)).powi(2) / area;
        let sigma = ((squares / count - mean * mean) / count).sqrt();
        assert!(
            (mean - expected).abs() < 5.0 * sigma,
            "{blades} {ratio}: {mean} {expected} ± {sigma}"
        );
    }
}

/// The film's exposure scales light and nothing else. By 2, which rounds nothing, so that bits can be asked for; the
/// limits of clamping hold before it, as in Cycles.
#[test]
fn film_exposure_scales_the_light_and_nothing_else() {
    // A floor that shines, of which the camera sees the edges.
    let mut scene = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    let shining = MetallicRoughness {
        emission: [0.3; 3],
        ..diffuse([0.5; 3])
    };
    place(
        &mut scene,
        quad([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        shining,
        &[DAffine3::IDENTITY],
    );
    scene.cameras.push(camera(DVec3::Z, 2.0));
    let settings = RenderSettings {
        clamp_direct: 0.25,
        ..all_passes(4)
    };
    let plain = run(&scene, &settings);
    let exposed = run(
        &scene,
        &RenderSettings {
            film_exposure: 2.0,
            ..settings
        },
    );
    let mut scaled = Vec::new();
    for pass in plain.picture.layers.iter().map(|layer| &*layer.name) {
        let (a, b) = (layer(&plain, pass), layer(&exposed, pass));
        let light = |v: &[f32]| v.iter().map(|x| 2.0 * x).collect::<Vec<_>>();
        match pass {
            // Of relative errors those of dark pixels are told with a floor; time is another each time.
            "Error" | "Cost" => {}
            "Combined" | "Noisy Image" => {
                for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
                    assert_eq!(light(&a[..3]), b[..3]);
                    assert_eq!(a[3], b[3]);
                }
            }
            _ if light(a) == b && a != b => scaled.push(pass),
            _ => assert_eq!(a, b, "{pass}"),
        }
    }
    assert_eq!(scaled, ["DiffDir", "Emit", "Env"]);
    let taken = |r: &Rendering| r.statistics.clamped;
    assert_eq!(taken(&plain), taken(&exposed));
}

/// A small grey floor under a large sheet, in a white sky: of a mirror it has its light by reflection alone, of glass
/// without reflections by transmission alone. Without such caustics it is black, as in Cycles.
#[test]
fn caustics_that_are_off_leave_out_reflections_or_transmission() {
    use sundog::render::Caustics;
    let sheet = |material: MetallicRoughness| {
        let mut scene = Scene {
            environment: constant_environment(1.0),
            ..Scene::default()
        };
        place(
            &mut scene,
            quad([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            diffuse([0.5; 3]),
            &[DAffine3::IDENTITY],
        );
        place(
            &mut scene,
            quad([-1e4, -1e4, 5.0], [0.0, 2e4, 0.0], [2e4, 0.0, 0.0]),
            material,
            &[DAffine3::IDENTITY],
        );
        scene.cameras.push(camera(DVec3::Z, 0.5));
        scene
    };
    let plain = MetallicRoughness {
        roughness: 0.0,
        double_sided: true,
        ..MetallicRoughness::default()
    };
    let mirror = sheet(MetallicRoughness {
        metallic: 1.0,
        ..plain.clone()
    });
    let glass = sheet(MetallicRoughness {
        metallic: 0.0,
        transmission: 1.0,
        base_color: [0.9; 3],
        ior: 1.0,
        ..plain
    });
    let floor = |scene: &Scene, reflective, refractive| {
        let settings = RenderSettings {
            caustics: Caustics {
                reflective,
                refractive,
            },
            ..small(16, 4)
        };
        mean(&run(scene, &settings))
    };
    // Past the sheet's edges comes (5 / 1e4)² of the light.
    let black = |light: f64| light < 1e-6;
    // From below, the floor hides 1/(π 10²) of what the mirror shows, and returns half of that.
    assert!((floor(&mirror, true, true) - 0.5).abs() < 0.01);
    assert!((floor(&mirror, true, false) - 0.5).abs() < 0.01);
    assert!(black(floor(&mirror, false, true)));
    assert!((floor(&glass, true, true) - 0.45).abs() < 0.01);
    assert!((floor(&glass, false, true) - 0.45).abs() < 0.01);
    assert!(black(floor(&glass, true, false)));
    assert!(black(floor(&glass, false, false)));
}
