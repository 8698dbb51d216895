//! Surfaces that lie in each other, and interfaces of glass that are close or touch.

use super::{Case, Effort, Finding};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3};
use rayon::prelude::*;
use sundog::math::{float, warp};
use sundog::render::RenderError;
use sundog::sampler::hashed;
use sundog::scene::{Mesh, MetallicRoughness, Scene};
use sundog::selftest::kit::{
    Bench, camera, colors, constant_environment, diffuse, glass, mean, place, prepared, quad,
    small, sphere,
};
use sundog::selftest::light_leaks::{cube, grid, meet};
use sundog::world::World;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "coplanar-duplicates",
        about: "The same triangles twice, in other colours: which is seen does not depend on the seed.",
        run: coplanar_duplicates,
    },
    Case {
        name: "thin-plates",
        about: "Plates of glass from a tenth to two millionths of their distance thick: light that passes is reflected at both sides.",
        run: thin_plates,
    },
    Case {
        name: "touching-interfaces",
        about: "Balls of glass that touch from inside and outside, a shell of a millionth, a ball in one of the same size: in a white furnace none is seen.",
        run: touching_interfaces,
    },
    Case {
        name: "liquid-in-a-glass",
        about: "Liquid that ends at its glass, reaches into it, or leaves a gap of 1e-5 to 2e-7 of its size: in a white furnace it is not seen.",
        run: liquid_in_a_glass,
    },
];

/// Reflectance of unpolarised light at the entry into a dielectric, in f64.
fn fresnel(cos: f64, ior: f64) -> f64 {
    let inner = (1.0 - (1.0 - cos * cos) / (ior * ior)).sqrt();
    let s = (cos - ior * inner) / (cos + ior * inner);
    let p = (ior * cos - inner) / (ior * cos + inner);
    0.5 * (s * s + p * p)
}

/// A plate before a panel of radiance 1: what passes is (1 − R)/(1 + R), all reflections between its sides added up.
/// Each sample is 1 or 0 but for roundings: the mean has the variance T (1 − T) / n.
fn thin_plates(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(64, 1024, 4096), 12);
    let n = f64::from(settings.samples * settings.width * settings.height);
    let (mut findings, mut bench) = (Vec::new(), Bench::default());
    for tilt in [0.0, 0.7] {
        for thickness in [1e-1, 1e-3, 1e-5, 2e-6] {
            let mut scene = Scene::default();
            let panel = quad([-9.0, -9.0, -3.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
            let shining = MetallicRoughness {
                emission: [1.0; 3],
                ..diffuse([0.0; 3])
            };
            place(&mut scene, panel, shining, &[DAffine3::IDENTITY]);
            let plate = DAffine3::from_scale_rotation_translation(
                DVec3::new(0.5, 0.5, 0.5 * thickness),
                DQuat::from_rotation_y(tilt),
                DVec3::new(0.0, 0.0, -1.0),
            );
            place(&mut scene, cube(), glass(0.0, 1.5), &[plate]);
            scene.cameras.push(camera(DVec3::ZERO, 0.02));
            let r = fresnel(tilt.cos(), 1.5);
            let through = (1.0 - r) / (1.0 + r);
            let found = mean(&bench.render(&scene, &settings)?.picture);
            let name = format!("light through {thickness:.0e} of glass, tilted by {tilt}");
            let bound = 4.0 * (through * (1.0 - through) / n).sqrt();
            findings.push(Finding::new(name, through, found, bound));
        }
    }
    Ok(bench.with(findings))
}

/// In a white furnace glass is not seen, however its interfaces lie: each passage keeps all light, so that all samples
/// are 1 but for the roundings of their weights, eight at each of their surfaces at most, or 0 where the path is
/// longer than the limit. `lost`: what smooth normals may lose, whose passages have no inverse where triangles are in the way.
fn furnace(
    name: &str,
    balls: &[(f32, f32, f32, bool)],
    (smooth, lost): (bool, f64),
    samples: u32,
    bench: &mut Bench,
) -> Result<Vec<Finding>, RenderError> {
    const BOUNCES: u32 = 1024;
    let mut scene = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    for &(radius, x, ior, hollow) in balls {
        let mut ball = sphere(24, 0.0, smooth);
        if hollow {
            ball.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            let normals = ball.normals.iter_mut().flatten();
            normals.for_each(|n| *n = n.map(|c| -c));
        }
        let at = DAffine3::from_scale_rotation_translation(
            DVec3::splat(f64::from(radius)),
            DQuat::from_rotation_x(0.4),
            DVec3::new(f64::from(x), 0.0, -4.0),
        );
        place(&mut scene, ball, glass(0.0, ior), &[at]);
    }
    scene.cameras.push(camera(DVec3::ZERO, 0.7));
    let picture = bench.render(&scene, &small(samples, BOUNCES))?.picture;
    let bound = f64::from(float::gamma(8 * BOUNCES));
    let brightest = colors(&picture).flatten().fold(0.0, f64::max);
    Ok(vec![
        Finding::new(
            format!("mean radiance, {name}"),
            1.0,
            mean(&picture),
            bound + lost,
        ),
        Finding::at_most(
            format!("light above 1, {name}"),
            bound,
            (brightest - 1.0).max(0.0),
        ),
    ])
}

/// Normals of the triangles, by which nothing is lost.
const FLAT: (bool, f64) = (false, 0.0);
/// Normals of the corners, with the bound of `coarse-furnace`.
const SMOOTH: (bool, f64) = (true, 5e-3);

fn touching_interfaces(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples = effort.of(4, 64, 1024);
    let (mut findings, mut bench) = (Vec::new(), Bench::default());
    for (name, balls) in [
        (
            "touching inside",
            &[(1.0, 0.0, 1.5, false), (0.5, 0.5, 1.3, false)][..],
        ),
        (
            "touching outside",
            &[(0.5, -0.5, 1.5, false), (0.5, 0.5, 1.5, false)],
        ),
        (
            "a shell 1e-6 thick",
            &[(1.0, 0.0, 1.5, false), (0.999_999, 0.0, 1.5, true)],
        ),
        (
            "one in another of the same size",
            &[(1.0, 0.0, 1.5, false), (1.0, 0.0, 1.5, false)],
        ),
    ] {
        findings.extend(furnace(name, balls, FLAT, samples, &mut bench)?);
    }
    Ok(bench.with(findings))
}

fn liquid_in_a_glass(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples = effort.of(4, 64, 1024);
    let (mut findings, mut bench) = (Vec::new(), Bench::default());
    let mut add = |name: &str, radius, normals| {
        let balls = [
            (1.0, 0.0, 1.5, false),
            (0.8, 0.0, 1.5, true),
            (radius, 0.0, 1.33, false),
        ];
        furnace(name, &balls, normals, samples, &mut bench).map(|found| findings.extend(found))
    };
    for (name, radius) in [
        ("liquid that ends at the glass", 0.8),
        ("liquid that reaches 1 % into the glass", 0.808),
        ("a gap of 1e-5 of the distance", 0.799_96),
        ("a gap of 1e-6 of the distance", 0.799_996),
    ] {
        add(name, radius, FLAT)?;
    }
    // Of liquid that it has never entered a ray comes out by chance only, if its normals are those of a ball.
    for (name, radius) in [
        ("smooth liquid that ends at the glass", 0.8),
        ("a gap of 1e-5 between smooth balls", 0.799_992),
        ("a gap of 1e-6 between smooth balls", 0.799_999_2),
        ("a gap of 2e-7 between smooth balls", 0.799_999_8),
        ("an overlap of 1e-6 of smooth balls", 0.800_000_8),
    ] {
        add(name, radius, SMOOTH)?;
    }
    Ok(bench.with(findings))
}

fn coplanar_duplicates(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let rays: u32 = effort.of(50_000, 1_000_000, 20_000_000);
    let turned = DMat3::from_quat(DQuat::from_axis_angle(
        DVec3::new(2.0, -3.0, 6.0) / 7.0,
        0.5,
    ));
    let at = DAffine3 {
        matrix3: turned,
        translation: DVec3::new(0.1, 0.2, -0.3),
    };
    let with = |second: Mesh| {
        let mut scene = Scene::default();
        for sheet in [grid(5), second] {
            place(&mut scene, sheet, diffuse([0.5; 3]), &[at]);
        }
        scene.cameras.push(camera(DVec3::ZERO, 1.0));
        prepared(&scene)
    };
    let met = |world: &World, i: u32| {
        let number = |d: u32| hashed(d, i, 3);
        let from = warp::sphere(Vec2::new(number(0), number(1))) * 3.0;
        let to = DVec3::new(
            f64::from(1.8 * number(2) - 0.9),
            f64::from(1.8 * number(3) - 0.9),
            -1.0,
        );
        let to = (turned * to).as_vec3() + Vec3::new(0.1, 0.2, -0.3);
        meet(world, from, to - from).map(|hit| (hit.geometry, hit.primitive))
    };
    let count = |is: &(dyn Fn(u32) -> bool + Sync)| {
        (0..rays).into_par_iter().filter(|&i| is(i)).count() as u64
    };
    let copies = with(grid(5))?;
    let second = count(&|i| met(&copies, i).is_some_and(|(geometry, _)| geometry == 1));
    // Of sheets that are cut along other diagonals each ray meets one or the other, but the same one in each world: what is
    // seen of them is a function of the ray alone.
    let cut_otherwise = || {
        let mut mesh = grid(5);
        for pair in mesh.triangles.chunks_exact_mut(2) {
            let ([a, b, c], [_, _, d]) = (pair[0], pair[1]);
            pair.copy_from_slice(&[[a, b, d], [b, c, d]]);
        }
        with(mesh)
    };
    let (once, again) = (cut_otherwise()?, cut_otherwise()?);
    let differ = count(&|i| met(&once, i) != met(&again, i));
    // Whichever of the two it is: always the same one.
    let minority = second.min(u64::from(rays) - second);
    Ok(vec![
        Finding::none("rays that met the other one", minority),
        Finding::none(
            "rays that met another of two that are cut differently in a second world",
            differ,
        ),
    ])
}
