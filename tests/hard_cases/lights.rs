//! Lights at the edges of size, distance, angle and strength.

use super::kit::{self, Bench, Mean};
use super::{Case, Effort, Finding, environments};
use glam::{DAffine3, DMat3, DVec3, Mat3, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use sundog::light::area::Area;
use sundog::light::estimate::{Angle, LightBounds};
use sundog::light::lamp::{Cone, Lamp};
use sundog::light::sun::Sun;
use sundog::light::tree::Tree;
use sundog::light::triangle::Triangle;
use sundog::math::float::gamma;
use sundog::render::RenderError;
use sundog::sampler::hashed;
use sundog::scene::{AreaShape, Light, LightKind, MetallicRoughness, Scene};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "spheres-of-all-sizes",
        about: "Sphere lamps and discs from radius 0 and 1e-30 to just around the point, 1e-4 to 1e6 away: irradiance I/d², rays find what is sampled.",
        run: spheres,
    },
    Case {
        name: "sun-angles",
        about: "Suns with an angular diameter of 0, of 1e-30 to 1e-7 and up to 180°, from 1e-10 to 1e15 W/m²: the same irradiance.",
        run: suns,
    },
    Case {
        name: "spot-cones",
        about: "Spots of 0, 1e-6 to 180° with soft edges shine to their edges and no farther.",
        run: spots,
    },
    Case {
        name: "rectangles-at-all-distances",
        about: "Rectangular and elliptic area lights of size 1e-6 to 1e6, seen from 1e-4 to 1e6 of their size and edge on: Lambert's formula.",
        run: rectangles,
    },
    Case {
        name: "triangles-at-all-distances",
        about: "Emissive triangles seen from 1e-4 to 1e6 of their size and edge on: Lambert's formula.",
        run: triangles,
    },
    Case {
        name: "lamp-beside-a-stronger-one",
        about: "A lamp in a room, and one 1e8 times as strong behind the wall: the floor has the light of the first.",
        run: stronger_one,
    },
    Case {
        name: "needle",
        about: "A band of light, 20 km by 1 cm, half a metre over a floor, as two triangles and cut into 1000 strips: the radiance of the floor.",
        run: needle,
    },
    Case {
        name: "a-million-lights",
        about: "A million lights of which one matters: it is the one that is drawn, and the rest is not lost.",
        run: million,
    },
    Case {
        name: "energies",
        about: "Lights of all kinds 2^-33 (1e-10) and 2^50 (1e15) times as strong make the same picture, scaled, bit for bit.",
        run: energies,
    },
    Case {
        name: "environment-images",
        about: "Environments with one texel of 1e8, all zeros, of 1x1 and of up to 16384x8192 texels: sampled light is the integral.",
        run: environments::images,
    },
    Case {
        name: "environment-values",
        about: "NaN, infinities and negative values in an environment's file: replaced at the border, no sample is not finite.",
        run: environments::values,
    },
];

/// A point of the unit square.
pub fn square(key: u32, number: u32) -> Vec2 {
    Vec2::new(hashed(key, number, 1), hashed(key, number, 2))
}

/// z-score that no estimate may reach.
pub const Z: f64 = 4.0;

/// What the mean of cosines in a cone, over a grid of n × n midpoints, is of the true mean 1 − (1 − cos)/2. The squared radius
/// on the disc is the greater of two squares, (2k − 1)²/n² for 2k − 1 of (n/2)² points: its mean is 1/2 − 1/n².
fn on_the_grid(one_minus_cos: f64, n: u32) -> f64 {
    1.0 + one_minus_cos / f64::from(n).powi(2) / (1.0 - 0.5 * one_minus_cos)
}

/// I/d² is the irradiance of a sphere of uniform radiance wholly above the horizon, whatever its radius. A sample's weight
/// is its cosine times 2I/(d²(1 + cosθ)): squared distance γ(5), its quotient with the square of the radius and the root
/// γ(9), sum, product and quotient γ(13), frame and direction γ(10), with the product γ(25) in all.
fn spheres(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let n = effort.of(16, 64, 256);
    let grid = |i: u32| {
        Vec2::new(
            ((i % n) as f32 + 0.5) / n as f32,
            ((i / n) as f32 + 0.5) / n as f32,
        )
    };
    let intensity = 7.0f32;
    let mut worst = 0f64;
    let (mut missed, mut not_finite) = (0u64, 0u64);
    for distance in [1e-4f32, 1.0, 1e3, 1e6] {
        for share in [0f32, 1e-30, 1e-12, 1e-7, 1e-3, 0.5, 0.999_999] {
            let lamp = Lamp {
                center: Vec3::new(0.0, 0.0, distance),
                radius: share * distance,
                soft_falloff: false,
                intensity: Vec3::splat(intensity),
                cone: None,
            };
            let lamp = Lamp {
                radius: if lamp.radiance().is_finite() {
                    lamp.radius
                } else {
                    0.0
                },
                ..lamp
            };
            let mut sum = 0f64;
            for i in 0..n * n {
                let Some(s) = lamp.sample(Vec3::ZERO, None, grid(i)) else {
                    not_finite += 1;
                    continue;
                };
                not_finite += u64::from(!(s.arriving.is_finite() && s.direction.wi.is_finite()));
                sum += f64::from(s.arriving.x * s.direction.wi.z);
                // The rim is a line: rays to it may pass by.
                let inside = grid(i).distance(Vec2::splat(0.5)) < 0.45;
                if !s.delta && inside && share >= 1e-3 {
                    let met = lamp.le(Vec3::ZERO, Vec3::ZERO, s.direction.wi);
                    missed += u64::from(met.is_none());
                }
            }
            let found = sum / f64::from(n * n);
            let exact = f64::from(intensity) / f64::from(distance).powi(2);
            let sin2 = (f64::from(lamp.radius) / f64::from(distance)).powi(2);
            let exact = exact * on_the_grid(1.0 - (1.0 - sin2).sqrt(), n);
            worst = worst.max((found / exact - 1.0).abs());
        }
    }
    Ok(vec![
        Finding::at_most(
            "irradiance: largest relative error",
            f64::from(gamma(25)),
            worst,
        ),
        Finding::none("rays along samples that miss the sphere", missed),
        Finding::none("samples that are not there or not finite", not_finite),
    ])
}

/// E·cosθ over the cap, weighted by its density: E·2cosθ/(1 + cos h). Roundings: sine, squares and sums γ(6), quotient and
/// product γ(8), frame and direction γ(10), the cosine's product: γ(20).
fn suns(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let n = effort.of(16u32, 64, 256);
    let mut worst = 0f64;
    let mut not_finite = 0u64;
    for angle in [
        0f32, 1e-30, 1e-22, 1e-12, 1e-8, 1.1e-7, 1.3e-7, 1e-5, 0.00918, 1.0, PI,
    ] {
        for irradiance in [1e-10f32, 1.0, 1e15, 1e30] {
            let sun = Sun::new(Vec3::Y, Vec3::splat(irradiance), angle);
            not_finite += u64::from(!(sun.is_delta() || sun.radiance().is_finite()));
            let mut sum = 0f64;
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let d = sun.sample(u);
                not_finite += u64::from(!(d.wi.is_finite() && sun.arriving().is_finite()));
                sum += f64::from(sun.arriving().x) * f64::from(d.wi.y);
            }
            let found = sum / f64::from(n * n) / f64::from(irradiance);
            let half = 0.5 * f64::from(angle.min(PI));
            let exact = on_the_grid(2.0 * (0.5 * half).sin().powi(2), n);
            worst = worst.max((found / exact - 1.0).abs());
        }
    }
    Ok(vec![
        Finding::at_most(
            "irradiance: largest relative error",
            f64::from(gamma(20)),
            worst,
        ),
        Finding::none("samples that are not finite", not_finite),
    ])
}

/// The share of the intensity at a direction, against f64 from the same direction. The smoothstep's slope is at most
/// 1.5 and its argument, a difference of numbers below 1 − cos of the edge over blend times that, has a relative error of
/// γ(9) of each: 1.5·2·γ(9)/blend, and its own roundings γ(4).
fn spots(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let n = effort.of(1_000u32, 10_000, 100_000);
    let blend = 0.25f32;
    let mut worst = 0f64;
    let mut beyond = 0u64;
    for half in [0f32, 1e-6, 1e-5, 1e-4, 1e-3, 0.1, 1.0, FRAC_PI_2, PI] {
        let edge = 2.0 * (0.5 * f64::from(half)).sin().powi(2);
        let cone = Cone {
            light_from_world: Mat3::IDENTITY,
            axis: Vec3::NEG_Z,
            one_minus_cos: edge as f32,
            steepness: if half > 0.0 {
                1.0 / (edge as f32 * blend)
            } else {
                f32::INFINITY
            },
        };
        let edge = f64::from(edge as f32);
        for i in 0..n {
            // Half of a turn is all there is.
            let angle = f64::from(half.max(1e-6)) * 1.25 * f64::from(hashed(3, i, half.to_bits()));
            let angle = angle.min(std::f64::consts::PI);
            let turn = std::f64::consts::TAU * f64::from(hashed(4, i, 0));
            let out = DVec3::new(
                angle.sin() * turn.cos(),
                angle.sin() * turn.sin(),
                -angle.cos(),
            )
            .as_vec3();
            let (d, share) = (out.as_dvec3(), cone.attenuation(out));
            let one_minus_cos = if d.z < 0.0 {
                (d.x * d.x + d.y * d.y) / (d.length() * (d.length() - d.z))
            } else {
                1.0 + d.z / d.length()
            };
            let x = ((edge - one_minus_cos) / (edge * f64::from(blend))).clamp(0.0, 1.0);
            let exact = if half > 0.0 {
                x * x * (3.0 - 2.0 * x)
            } else {
                0.0
            };
            worst = worst.max((f64::from(share) - exact).abs());
            beyond += u64::from(share > 0.0 && one_minus_cos > edge * (1.0 + f64::from(gamma(9))));
        }
    }
    Ok(vec![
        Finding::at_most(
            "share of the intensity: largest error",
            f64::from(3.0 * gamma(9) / blend + gamma(4)),
            worst,
        ),
        Finding::none("directions beyond the cone with light", beyond),
    ])
}

/// Lambert's formula, E = L/2 Σ angle · (normal of the edge's plane) · n, for a polygon wholly above the horizon.
fn lambert(corners: &[DVec3], normal: DVec3) -> f64 {
    let edges = (0..corners.len()).map(|i| {
        let (p, q) = (
            corners[i].normalize(),
            corners[(i + 1) % corners.len()].normalize(),
        );
        let cross = p.cross(corners[(i + 1) % corners.len()] - corners[i]);
        let Some(plane) = cross.try_normalize() else {
            return 0.0;
        };
        // Kahan's angle between unit vectors.
        let angle = 2.0 * (p - q).length().atan2((p + q).length());
        plane.dot(normal) * angle
    });
    edges.sum::<f64>().abs() * 0.5
}

/// Distances, and where from there a light of half size 1 about the origin, which shines along −Z, is looked at: over its
/// middle and near its edge, aside, and edge on.
fn viewpoints() -> impl Iterator<Item = (f64, DVec3)> {
    let distances = [1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6];
    distances.into_iter().flat_map(|d: f64| {
        let edge_on = |height: f64| DVec3::new(1.0 + d, 0.3, -height * d.min(1.0));
        let over = [DVec3::new(0.1, 0.2, -d), DVec3::new(0.8, -0.5, -d)];
        let aside = [
            DVec3::new(1.0 + d, 0.3, -0.5 * d),
            edge_on(1e-3),
            edge_on(1e-5),
        ];
        over.into_iter().chain(aside).map(move |p| (d, p))
    })
}

/// Relative error of a sample's weight by rounding: a difference and three terms of a product for each coordinate in the light's
/// plane γ(4), the distance γ(9), its third power over height and area γ(22), radiance and cosine γ(30).
const WEIGHT_ROUNDINGS: u32 = 30;

/// z-score of the irradiance by samples against Lambert's formula, for corners relative to the point. The receiving surface
/// faces the light's middle if all of it is above its horizon then, and the light's plane otherwise.
fn compare(
    corners: &[DVec3],
    exact: Option<f64>,
    samples: u32,
    key: u32,
    mut sample: impl FnMut(Vec2) -> Option<(Vec3, Vec3)>,
) -> f64 {
    let toward = corners.iter().sum::<DVec3>().normalize();
    let all_above = corners.iter().all(|c| c.dot(toward) > 0.0);
    let normal = if all_above { toward } else { DVec3::Z };
    let mut mean = Mean::default();
    for i in 0..samples {
        let weight =
            |(wi, arriving): (Vec3, Vec3)| f64::from(arriving.x) * wi.as_dvec3().dot(normal);
        mean.add(sample(square(key, i)).map_or(0.0, weight));
    }
    let exact = exact.unwrap_or_else(|| lambert(corners, normal));
    mean.z(exact, exact * f64::from(gamma(WEIGHT_ROUNDINGS)))
}

/// Edges of the polygon that stands for an ellipse.
const SIDES: u32 = 4096;

/// A square's corners, or those of a polygon of the circle's area.
fn outline(ellipse: bool, half: f64) -> Vec<DVec3> {
    let sides = if ellipse { SIDES } else { 4 };
    let turn = std::f64::consts::TAU / f64::from(sides);
    let radius = if ellipse {
        (turn / turn.sin()).sqrt()
    } else {
        std::f64::consts::SQRT_2
    };
    let corner = |i: u32| {
        let (sin, cos) = (turn * (f64::from(i) + 0.5)).sin_cos();
        DVec3::new(cos, sin, 0.0) * radius * half
    };
    (0..sides).map(corner).collect()
}

fn rectangles(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples = effort.of(2_000, 20_000, 1_000_000);
    let mut findings = Vec::new();
    for (ellipse, size) in [false, true]
        .into_iter()
        .flat_map(|e| [1e-6f32, 1.0, 1e6].map(|s| (e, s)))
    {
        let half = 0.5 * f64::from(size);
        let light = Area::new(
            &DAffine3::IDENTITY,
            [size; 2],
            ellipse,
            Vec3::ONE,
            false,
            PI,
        );
        let mut worst = 0f64;
        for (count, (d, from)) in viewpoints().enumerate() {
            let from = (from * half).as_vec3();
            let relative: Vec<DVec3> = outline(ellipse, half)
                .iter()
                .map(|c| *c - from.as_dvec3())
                .collect();
            // From afar 4096 edges cancel; the light is a point then, up to the square of its angle.
            let point = from.as_dvec3().length();
            let area = std::f64::consts::PI * half * half;
            let exact = (ellipse && d >= 1e4).then(|| area * -f64::from(from.z) / point.powi(3));
            let z = compare(&relative, exact, samples, count as u32, |u| {
                let s = light.as_ref()?.sample(from, u)?;
                // π times the radiance is 1.
                Some((s.direction.wi, s.arriving * PI))
            });
            worst = worst.max(z);
        }
        let shape = if ellipse { "ellipse" } else { "rectangle" };
        findings.push(Finding::at_most(
            format!("{shape} of {size:e}: largest z"),
            Z,
            worst,
        ));
    }
    Ok(findings)
}

fn triangles(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples = effort.of(2_000, 20_000, 1_000_000);
    let mut findings = Vec::new();
    for size in [1e-6f64, 1.0, 1e6] {
        let half = 0.5 * size;
        let corners = [
            DVec3::new(-half, -half, 0.0),
            DVec3::new(half, -half, 0.0),
            DVec3::new(half, half, 0.0),
        ];
        let shape = Triangle {
            corners: corners.map(|c| c.as_vec3()),
        };
        let seen_from = |(count, (_, from)): (usize, (f64, DVec3))| {
            let from = (from * half).as_vec3();
            let relative = shape.corners.map(|c| c.as_dvec3() - from.as_dvec3());
            compare(&relative, None, samples, count as u32, |u| {
                let s = shape.sample(from, u)?;
                Some((s.wi, Vec3::splat(1.0 / s.pdf)))
            })
        };
        let worst = viewpoints().enumerate().map(seen_from).fold(0.0, f64::max);
        findings.push(Finding::at_most(
            format!("triangle of {size:e}: largest z"),
            Z,
            worst,
        ));
    }
    Ok(findings)
}

/// The camera looks at a point of the floor under the lamp, 1 m below it. Of n light samples the share p = 2^-10 is the
/// lamp's (`light::tree`), with the weight 1/p: the mean has the relative variance (1/p − 1)/n.
fn stronger_one(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = kit::small(effort.of(128, 1024, 16_384), 0);
    let mut scene = Scene::default();
    let floor = kit::quad([-9.0, 0.0, 9.0], [18.0, 0.0, 0.0], [0.0, 0.0, -18.0]);
    kit::place(
        &mut scene,
        floor,
        kit::diffuse([0.5; 3]),
        &[DAffine3::IDENTITY],
    );
    let wall = kit::quad([2.0, 0.0, -9.0], [0.0, 9.0, 0.0], [0.0, 0.0, 18.0]);
    kit::place(
        &mut scene,
        wall,
        kit::diffuse([0.5; 3]),
        &[DAffine3::IDENTITY],
    );
    for (x, intensity) in [(0.0, 1.0), (3.0, 1e8)] {
        let point = LightKind::Point {
            intensity,
            radius: 0.0,
            soft_falloff: false,
        };
        let at = DAffine3::from_translation(DVec3::new(x, 1.0, 0.0));
        scene.lights.push(kit::light("lamp", point, at));
    }
    let mut eye = kit::camera(DVec3::new(0.0, 2.0, 0.0), 1e-4);
    eye.world_from_camera.matrix3 = DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    scene.cameras.push(eye);
    let mut bench = Bench::default();
    let found = kit::mean(&bench.render(&scene, &settings)?.picture);
    let n = f64::from(settings.samples * settings.width * settings.height);
    let exact = 0.5 / std::f64::consts::PI;
    let bound = 4.0 * exact * (1023.0 / n).sqrt();
    let finding = Finding::new("radiance of the floor", exact, found, bound);
    Ok(bench.with(vec![finding]))
}

/// A plate that shines down onto the origin, or away from it.
fn plate(center: Vec3, half: f32, intensity: f32, axis: Vec3) -> LightBounds {
    let reach = Vec3::new(half, 0.0, half);
    LightBounds {
        min: center - reach,
        max: center + reach,
        intensity,
        axis,
        normals: Angle::ZERO,
        cos_emission: 0.0,
        two_sided: false,
        front: None,
    }
}

/// First all but one turn away: that one has probability 1, but for a rounding of each of at most 2·64 levels. Then all shine, the
/// one a million times as strong as each of the rest: the sum of what they send is found, and the one is drawn at least
/// every other time.
fn million(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let count: u32 = effort.of(20_000, 50_000, 1_000_000);
    let at = |i: u32| {
        Vec3::new(hashed(1, i, 0) - 0.5, 0.0, hashed(2, i, 0) - 0.5) * 2000.0
            + Vec3::Y * (10.0 + hashed(3, i, 0))
    };
    let one = count / 3;
    let lights = |rest: f32, away: bool| -> Vec<LightBounds> {
        (0..count)
            .map(|i| match i == one {
                true => plate(Vec3::new(0.3, 1.0, 0.2), 0.1, 1.0, Vec3::NEG_Y),
                false => plate(at(i), 0.01, rest, if away { Vec3::Y } else { Vec3::NEG_Y }),
            })
            .collect()
    };
    let (point, normal) = (Vec3::ZERO, Some(Vec3::Y));
    let place = (point, normal);
    let away = Tree::new(&lights(1.0, true));
    let (first, _) = away.look(place);
    let certain = away.probability(&first, place, one);
    let draws = effort.of(1_000u32, 10_000, 100_000);
    let others = (0..draws)
        .filter(|&i| {
            away.sample(&first, place, hashed(7, i, 0))
                .is_none_or(|c| c.emitter != one)
        })
        .count();

    let facing = lights(1e-6, false);
    let tree = Tree::new(&facing);
    let (first, _) = tree.look(place);
    // What a small plate sends: intensity · cos · cos / d².
    let sent = |b: &LightBounds| {
        let d = ((b.min + b.max) * 0.5).as_dvec3();
        f64::from(b.intensity) * (d.y / d.length()).powi(2) / d.length_squared()
    };
    let exact: f64 = facing.iter().map(sent).sum();
    let mut mean = Mean::default();
    let mut hits = 0u32;
    for i in 0..draws {
        let choice = tree.sample(&first, place, hashed(8, i, 0));
        hits += u32::from(choice.is_some_and(|c| c.emitter == one));
        mean.add(choice.map_or(0.0, |c| {
            sent(&facing[c.emitter as usize]) / f64::from(c.probability)
        }));
    }
    Ok(vec![
        Finding::new(
            "probability of the only one that shines here",
            1.0,
            f64::from(certain),
            f64::from(gamma(2 * 64)),
        ),
        Finding::none("draws of others", others as u64),
        Finding::at_most("sum over all lights: z", Z, mean.z(exact, 0.0)),
        // Estimates of groups are upper bounds, so that others are drawn, too; but not more often than it.
        Finding::new(
            "share of draws of the one that matters",
            1.0,
            f64::from(hits) / f64::from(draws),
            0.5,
        ),
    ])
}

/// A light of a kind, over the scene.
fn light(kind: LightKind, x: f64) -> Light {
    kit::light(
        "light",
        kind,
        DAffine3::from_translation(DVec3::new(x, 2.0, 0.0))
            * DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2),
    )
}

/// A floor, a ball, and a light of each kind, `strength` times as strong.
fn lit(strength: f32) -> Scene {
    let mut scene = Scene {
        cameras: vec![kit::camera(DVec3::new(0.0, 1.0, 6.0), 0.8)],
        environment: kit::constant_environment(0.1 * strength),
        ..Scene::default()
    };
    let floor = kit::quad([-5.0, 0.0, 5.0], [10.0, 0.0, 0.0], [0.0, 0.0, -10.0]);
    kit::place(
        &mut scene,
        floor,
        kit::diffuse([0.5, 0.4, 0.3]),
        &[DAffine3::IDENTITY],
    );
    let up = DAffine3::from_translation(DVec3::Y);
    kit::place(
        &mut scene,
        kit::sphere(8, 0.0, true),
        kit::diffuse([0.7; 3]),
        &[up],
    );
    let shining = sundog::scene::MetallicRoughness {
        emission: [3.0 * strength; 3],
        ..kit::diffuse([0.2; 3])
    };
    let wall = kit::quad([-3.0, 0.5, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    kit::place(&mut scene, wall, shining, &[DAffine3::IDENTITY]);
    scene.lights = vec![
        light(
            LightKind::Point {
                intensity: strength,
                radius: 0.0,
                soft_falloff: false,
            },
            1.0,
        ),
        light(
            LightKind::Point {
                intensity: strength,
                radius: 0.1,
                soft_falloff: true,
            },
            -1.0,
        ),
        light(
            LightKind::Spot {
                intensity: strength,
                radius: 0.1,
                soft_falloff: false,
                half_angle: 0.5,
                blend: 0.2,
            },
            0.5,
        ),
        light(
            LightKind::Sun {
                irradiance: 0.3 * strength,
                angle: 0.01,
            },
            0.0,
        ),
        light(
            LightKind::Area {
                shape: AreaShape::Rectangle,
                size: [1.0, 0.5],
                power: strength,
                normalize: true,
                spread: PI,
            },
            -2.0,
        ),
    ];
    scene
}

/// Products with a power of two are exact as long as nothing leaves f32's range: each sample is scaled, and so is the sum.
fn energies(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = kit::small(effort.of(2, 8, 64), 4);
    let usual = bench.render(&lit(1.0), &settings)?;
    let mut findings = Vec::new();
    for power in [-33, 50] {
        let strength = 2f64.powi(power);
        let scaled = bench.render(&lit(strength as f32), &settings)?;
        let differing = kit::colors(&usual.picture)
            .zip(kit::colors(&scaled.picture))
            .filter(|(a, b)| a.map(|x| x * strength) != *b)
            .count();
        findings.push(Finding::none(
            format!("pixels that differ at 2^{power}"),
            differing as u64,
        ));
    }
    Ok(bench.with(findings))
}

/// A floor below the middle of a band of radiance L, width w and any length, at height h, has the radiance
/// (1/π) ∫∫ L h² / d⁴ dx dz = L (w/2) / √(h² + w²/4); what the ends of the band would send is 1e-13 of it.
fn needle(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let (radiance, length, width, height) = (10.0f32, 2e4f32, 0.01f32, 0.5f32);
    let half = f64::from(0.5 * width);
    let expected = f64::from(radiance) * half / (f64::from(height).powi(2) + half * half).sqrt();
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    for strips in [1u32, 1000] {
        let mut scene = Scene::default();
        let floor = kit::quad([-5.0, 0.0, 5.0], [10.0, 0.0, 0.0], [0.0, 0.0, -10.0]);
        kit::place(
            &mut scene,
            floor,
            kit::diffuse([1.0; 3]),
            &[DAffine3::IDENTITY],
        );
        let strip = kit::quad(
            [0.0; 3],
            [length / strips as f32, 0.0, 0.0],
            [0.0, 0.0, width],
        );
        let place = |k| {
            let x = f64::from(length) * (f64::from(k) / f64::from(strips) - 0.5);
            DAffine3::from_translation(DVec3::new(x, f64::from(height), -half))
        };
        let places: Vec<DAffine3> = (0..strips).map(place).collect();
        let glowing = MetallicRoughness {
            emission: [radiance; 3],
            ..kit::diffuse([0.0; 3])
        };
        kit::place(&mut scene, strip, glowing, &places);
        // From below the band straight down, so narrowly that all it sees is as far from the middle as 1e-4 of the height.
        let mut camera = kit::camera(DVec3::ZERO, 2e-4);
        camera.world_from_camera = DAffine3::from_translation(DVec3::new(0.0, 0.25, 0.0))
            * DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        scene.cameras.push(camera);
        let rendering = bench.render(&scene, &kit::small(effort.of(16, 64, 256), 0))?;
        let mut floor = Mean::default();
        kit::colors(&rendering.picture).for_each(|c| floor.add(c[0]));
        findings.push(Finding::at_most(
            format!("{strips} strips: z of the floor's radiance"),
            4.0,
            floor.z(expected, 1e-5 * expected),
        ));
    }
    Ok(bench.with(findings))
}
