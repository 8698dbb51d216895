//! Media: thick and thin ones, shells, needles, boundaries that the camera is on.

use super::kit::{
    Bench, camera, colors, constant_environment, diffuse, mean, place, quad, small, sphere,
};
use super::place::same;
use super::{Case, Effort, Finding};
use crate::render::{LightSampling, RenderError, RenderSettings};
use crate::scene::{AlphaMode, Medium, MetallicRoughness, Phase, Scatterer, Scene};
use glam::{DAffine3, DVec3};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "thick-and-thin-media",
        about: "Slabs of 1e-9 to 1e6 mean free paths, and of 1e-5 and 1e-6 m in a room of 1e3 m: what they let through and emit is analytic.",
        run: thick_and_thin,
    },
    Case {
        name: "white-media",
        about: "Balls that scatter all, and all but 1e-7, evenly and by needles to and fro, up to 100 mean free paths deep, in a white furnace: they vanish.",
        run: white,
    },
    Case {
        name: "media-at-any-scale",
        about: "A ball of fog with a core, from 2^-20 to 2^20 times its size: the same bits; and 1e5 m away: the same picture.",
        run: scales,
    },
    Case {
        name: "media-that-meet",
        about: "Two slabs that absorb: nested, overlapping, with faces in one place, touching, and open ones. The depths of both add up.",
        run: meeting,
    },
    Case {
        name: "camera-on-a-boundary",
        about: "The camera is exactly on the face of a slab that absorbs: all pixels take it to be on the same side.",
        run: on_a_boundary,
    },
];

/// A kind of particles.
pub fn scattering(coefficient: [f32; 3], g: f32) -> Scatterer {
    Scatterer {
        coefficient,
        phase: Phase::HenyeyGreenstein(g),
    }
}

/// A boundary that no light minds, and what is inside.
pub fn boundary(medium: Medium) -> MetallicRoughness {
    MetallicRoughness {
        alpha: 0.0,
        alpha_mode: AlphaMode::Blend,
        medium: Some(medium),
        ..diffuse([0.0; 3])
    }
}

/// The picture is filled by a wall that shines with 1, behind a slab of a thickness along the axis of a narrow camera.
pub fn behind_a_slab(medium: Medium, thickness: f32) -> Scene {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 1e-3)],
        ..Scene::default()
    };
    let wall = quad([-9.0, -9.0, -5.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    let shining = MetallicRoughness {
        emission: [1.0; 3],
        ..diffuse([0.0; 3])
    };
    place(&mut scene, wall, shining, &[DAffine3::IDENTITY]);
    add_slab(&mut scene, medium, thickness);
    scene
}

/// Adds a slab of 8 by 8 m below the plane of X and Y.
pub fn add_slab(scene: &mut Scene, medium: Medium, thickness: f32) {
    // Two sheets are a boundary as well: the front one is entered, the back one is left.
    add_sheets(scene, medium, [Some(0.0), Some(-thickness)]);
}

/// Adds an object of sheets of 8 by 8 m at places along Z: one that faces up, and one that faces down.
fn add_sheets(scene: &mut Scene, medium: Medium, [front, back]: [Option<f32>; 2]) {
    let front = front.map(|z| quad([-4.0, -4.0, z], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]));
    let back = back.map(|z| quad([-4.0, 4.0, z], [8.0, 0.0, 0.0], [0.0, -8.0, 0.0]));
    let mut sheets = front.into_iter().chain(back);
    let Some(mut both) = sheets.next() else {
        return;
    };
    // One object, as a mesh of both would be.
    for other in sheets {
        let first = both.positions.len() as u32;
        both.positions.extend(other.positions);
        let triangles = other.triangles.iter().map(|t| t.map(|i| i + first));
        both.triangles.extend(triangles);
    }
    both.normals = None;
    place(scene, both, boundary(medium), &[DAffine3::IDENTITY]);
}

/// What two objects bound, 1/m: where their sheets are along Z, and how far light goes through each of them before a wall at −5.
fn meeting(_: Effort) -> Result<Vec<Finding>, RenderError> {
    const SIGMA: [f32; 2] = [0.3, 0.7];
    let slab = |from: f32, to: f32| [Some(from), Some(to)];
    let cases = [
        (
            "one in the other",
            [slab(0.0, -2.0), slab(-0.5, -1.0)],
            [2.0, 0.5],
        ),
        (
            "two that overlap",
            [slab(0.0, -2.0), slab(-1.0, -3.0)],
            [2.0, 2.0],
        ),
        (
            "two in one place",
            [slab(0.0, -2.0), slab(0.0, -2.0)],
            [2.0, 2.0],
        ),
        (
            "two with one front",
            [slab(0.0, -2.0), slab(0.0, -1.0)],
            [2.0, 1.0],
        ),
        (
            "two with one back",
            [slab(-1.0, -2.0), slab(0.0, -2.0)],
            [1.0, 2.0],
        ),
        (
            "two that touch",
            [slab(0.0, -2.0), slab(-2.0, -3.0)],
            [2.0, 1.0],
        ),
        (
            "one that is entered and never left",
            [[Some(0.0), None], slab(-1.0, -2.0)],
            [5.0, 1.0],
        ),
        (
            "one that is left and never entered",
            [[None, Some(0.0)], slab(-1.0, -2.0)],
            [0.0, 1.0],
        ),
    ];
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    for (name, sheets, ways) in cases {
        let mut scene = behind_a_slab(Medium::default(), 1.0);
        scene.instances.truncate(1);
        for (sheets, sigma) in sheets.into_iter().zip(SIGMA) {
            let medium = Medium {
                absorption: [sigma; 3],
                ..Medium::default()
            };
            add_sheets(&mut scene, medium, sheets);
        }
        let found = mean(&bench.render(&scene, &small(4, 4))?.picture);
        let depth = f64::from(SIGMA[0]) * ways[0] + f64::from(SIGMA[1]) * ways[1];
        let quantity = format!("share that is let through by {name}");
        findings.push(Finding::new(quantity, (-depth).exp(), found, 1e-5));
    }
    Ok(bench.with(findings))
}

fn thick_and_thin(_: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    for (sigma, thickness) in [
        (1e-9, 1.0),
        (1e-3, 1.0),
        (1.0, 2.0),
        (80.0, 1.0),
        (1e6, 1.0),
        (1e5, 1e-5),
        (1e5, 1e-6),
    ] {
        let medium = Medium {
            absorption: [sigma; 3],
            emission: [sigma; 3],
            ..Medium::default()
        };
        let slab = behind_a_slab(medium.clone(), thickness);
        let found = mean(&bench.render(&slab, &small(4, 4))?.picture);
        // What emits as much as it takes is as bright as the wall, whatever it lets through.
        let quantity =
            format!("radiance of a slab with a source of 1, {sigma:e}/m, {thickness:e} m");
        findings.push(Finding::new(quantity, 1.0, found, 1e-6));
        let absorbing = Medium {
            emission: [0.0; 3],
            ..medium
        };
        let slab = behind_a_slab(absorbing, thickness);
        let found = mean(&bench.render(&slab, &small(4, 4))?.picture);
        let through = f64::from(-sigma * thickness).exp();
        // Its faces are known to the roundings of their distances from the camera, 4 m.
        let bound = 1e-6 + through * f64::from(f32::EPSILON) * 8.0 * f64::from(sigma).min(1e7);
        let quantity = format!("share that is let through, {sigma:e}/m, {thickness:e} m");
        findings.push(Finding::new(quantity, through, found, bound));
    }
    // Shells before a wall 1e3 m away: the faces of the thinner one are two steps of f32 from each other.
    for (sigma, thickness) in [(1e4, 1e-5), (1e5, 1e-6)] {
        let thin = Medium {
            absorption: [sigma; 3],
            ..Medium::default()
        };
        let mut scene = behind_a_slab(thin, thickness);
        if let Some(wall) = scene.instances.first_mut() {
            wall.world_from_object = DAffine3::from_scale(DVec3::splat(200.0));
        }
        let found = mean(&bench.render(&scene, &small(4, 4))?.picture);
        // Of each face half a step, 2.4e-7 m, at the distance of the camera.
        let bound = f64::from(f32::EPSILON) * 4.0 * f64::from(sigma);
        findings.push(Finding::new(
            format!("share that a shell of {thickness:e} m lets through in a room of 1e3 m"),
            (-0.1f64).exp(),
            found,
            bound,
        ));
    }
    Ok(bench.with(findings))
}

/// A ball of a radius of 1 m in a world of 1.
fn ball(medium: Medium, radiance: f32) -> Scene {
    let mut scene = Scene {
        environment: constant_environment(radiance),
        cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 0.4)],
        ..Scene::default()
    };
    let shape = sphere(16, 0.0, false);
    place(&mut scene, shape, boundary(medium), &[DAffine3::IDENTITY]);
    scene
}

fn white(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    // Light that is met by chance alone counts 1 on each path: nothing is left to noise.
    let settings = RenderSettings {
        light_sampling: LightSampling::Bsdf,
        roulette: None,
        ..small(effort.of(1, 4, 64), 1 << 20)
    };
    for (depth, g, taken) in [
        (1.0, 0.0, 0.0),
        (10.0, 0.0, 0.0),
        (100.0, 0.0, 0.0),
        (100.0, 0.999, 0.0),
        (10.0, -0.999, 0.0),
        (100.0, 0.0, 1e-7),
    ] {
        let medium = Medium {
            scatterers: vec![scattering([depth; 3], g)],
            absorption: [depth * taken; 3],
            ..Medium::default()
        };
        let found = mean(&bench.render(&ball(medium, 1.0), &settings)?.picture);
        let quantity = format!("radiance, {depth} mean free paths, g = {g}, {taken:e} taken");
        findings.push(Finding::new(quantity, 1.0, found, 1e-3));
    }
    Ok(bench.with(findings))
}

/// A ball of fog with a core of another, by how much larger they are.
fn core(scale: f64, shift: DVec3) -> Scene {
    let fog = |sigma: f64| Medium {
        scatterers: vec![scattering([(sigma / scale) as f32; 3], 0.3)],
        absorption: [(0.5 * sigma / scale) as f32; 3],
        ..Medium::default()
    };
    let mut scene = ball(fog(1.0), 1.0);
    let inner = DAffine3::from_scale(DVec3::splat(0.5));
    place(
        &mut scene,
        sphere(16, 0.0, false),
        boundary(fog(4.0)),
        &[inner],
    );
    let all = DAffine3 {
        translation: shift,
        ..DAffine3::from_scale(DVec3::splat(scale))
    };
    for instance in &mut scene.instances {
        instance.world_from_object = all * instance.world_from_object;
    }
    for camera in &mut scene.cameras {
        camera.world_from_camera.translation =
            all.transform_point3(camera.world_from_camera.translation);
    }
    scene
}

fn scales(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 16, 256), 8);
    let original = core(1.0, DVec3::ZERO);
    let scaled = [-20, 20].map(|power| {
        let name = format!("scaled by 2^{power}");
        (name, core(f64::powi(2.0, power), DVec3::ZERO))
    });
    let moved = (
        "moved by 1e5 m".to_owned(),
        core(1.0, DVec3::new(1e5, 0.0, 0.0)),
    );
    same(&original, scaled.into_iter().chain([moved]), &settings)
}

fn on_a_boundary(_: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let medium = Medium {
        absorption: [1.0; 3],
        ..Medium::default()
    };
    let mut findings = Vec::new();
    for (name, z) in [("the front", 0.0), ("the back", -1.0)] {
        let mut scene = behind_a_slab(medium.clone(), 1.0);
        scene.cameras = vec![camera(DVec3::new(0.0, 0.0, z), 1e-3)];
        let picture = bench.render(&scene, &small(4, 4))?.picture;
        let found: Vec<f64> = colors(&picture).map(|color| color[0]).collect();
        let first = found.first().copied().unwrap_or(f64::NAN);
        let others = found.iter().filter(|&&other| (other - first).abs() > 1e-6);
        let sides = [1.0, (-1.0f64).exp()].map(|side| (side - first).abs());
        let nearest = sides.into_iter().fold(f64::INFINITY, f64::min);
        findings.push(Finding::none(
            format!("pixels that see another side from {name}"),
            others.count() as u64,
        ));
        findings.push(Finding::at_most(
            format!("difference from what either side sees from {name}"),
            1e-6,
            nearest,
        ));
    }
    Ok(bench.with(findings))
}
