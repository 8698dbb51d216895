//! Light that goes on below surfaces.

use super::{RenderSettings, estimate, floor, mean, run, small};
use glam::{DAffine3, DQuat, DVec3};
use sundog::effects::{self, Effect};
use sundog::render::EffectChoice;
use sundog::scene::graph::node::{principled, subsurface};
use sundog::scene::graph::{Graph, Node, NodeKind, SimpleBsdf, Subsurface, WalkMethod};
use sundog::scene::{Instance, LightKind, Material, Mesh, Scene};
use sundog::selftest::kit::{camera, constant_environment, diffuse, light, place, sphere};

const WALK: Subsurface = Subsurface {
    method: WalkMethod::RandomWalk,
    never_backward: false,
    diffuse_behind_diffuse: false,
};

fn material(shader: Node) -> Material {
    let mut graph = Graph::default();
    graph.surface = Some(graph.add(shader));
    Material {
        name: "below".into(),
        graph,
        double_sided: true,
        medium: None,
        priority: None,
    }
}

/// Marble of a colour, radii in metres.
fn marble(color: [f32; 3], radius: [f32; 3]) -> Material {
    let bsdf = Node::new(NodeKind::Bsdf(SimpleBsdf::Subsurface(WALK)));
    let bsdf = bsdf.with(subsurface::COLOR, color);
    let bsdf = bsdf.with(subsurface::RADIUS, radius);
    material(bsdf.with(subsurface::SCALE, 1.0))
}

/// A gleaming skin under light from behind.
fn skin() -> Material {
    let shader = Node::new(NodeKind::PrincipledBsdf {
        thin_wall: false,
        pane: true,
        edge_tint: true,
        once: false,
        rules: Default::default(),
        walk: Some(Subsurface {
            method: WalkMethod::Skin,
            diffuse_behind_diffuse: true,
            ..WALK
        }),
    });
    let shader = shader.with(principled::BASE_COLOR, [0.9, 0.6, 0.4]);
    let shader = shader.with(principled::SUBSURFACE_WEIGHT, 0.8);
    let shader = shader.with(principled::SUBSURFACE_ANISOTROPY, 0.4);
    material(shader.with(principled::SUBSURFACE_SCALE, 0.3))
}

fn lit() -> Scene {
    let mut scene = Scene {
        environment: constant_environment(0.3),
        cameras: vec![camera(DVec3::new(0.0, 0.2, 4.0), 0.8)],
        ..floor()
    };
    let at = DAffine3::from_translation(DVec3::new(-1.0, 1.5, -2.0));
    let lamp = LightKind::Point {
        intensity: 20.0,
        radius: 0.4,
        soft_falloff: false,
    };
    scene.lights.push(light("lamp", lamp, at));
    scene
}

fn at(x: f64, scale: f64) -> DAffine3 {
    let place = DVec3::new(x, 0.0, 0.0);
    DAffine3::from_scale_rotation_translation(DVec3::splat(scale), DQuat::IDENTITY, place)
}

/// A head of skin between two pieces of marble, of one mesh.
pub fn scene() -> Scene {
    let mut scene = lit();
    let stone = marble([0.9, 0.8, 0.5], [0.2, 0.1, 0.05]);
    let places = [at(-1.3, 0.5), at(1.3, 0.6)];
    place(&mut scene, sphere(12, 0.2, true), stone, &places);
    place(&mut scene, sphere(12, 0.0, true), skin(), &[at(0.0, 0.7)]);
    scene
}

/// A ball of marble alone.
fn ball(radius: [f32; 3]) -> Scene {
    let mut scene = lit();
    let stone = marble([0.8, 0.6, 0.4], radius);
    place(&mut scene, sphere(16, 0.0, true), stone, &[at(0.0, 1.0)]);
    scene
}

/// What lies in an object is not there for light below its surface: the picture has the same bits.
#[test]
fn light_below_a_surface_meets_its_own_object_alone() {
    let bare = ball([0.5, 0.3, 0.2]);
    let mut filled = bare.clone();
    let black = diffuse([0.0; 3]);
    place(&mut filled, sphere(8, 0.0, true), black, &[at(0.0, 0.6)]);
    let picture = |scene| run(scene, &small(16, 4)).picture.layers[0].data.clone();
    assert!(picture(&bare) == picture(&filled));
}

/// The triangles of one half of a mesh.
fn half(mesh: &Mesh, below: bool) -> Mesh {
    let mut half = mesh.clone();
    half.triangles.retain(|t| {
        let height: f32 = t.iter().map(|&i| mesh.positions[i as usize][1]).sum();
        (height < 0.0) == below
    });
    half
}

/// Meshes of several materials are one object with several parts: light goes from one to the other.
#[test]
fn parts_of_an_object_are_its_inside_together() {
    let whole = ball([0.6, 0.6, 0.6]);
    let mut parted = whole.clone();
    let (mesh, id) = (parted.meshes.pop().unwrap(), parted.instances.len() - 1);
    parted.instances.truncate(id);
    parted.materials.pop();
    for below in [false, true] {
        let stone = marble([0.8, 0.6, 0.4], [0.6, 0.6, 0.6]);
        place(&mut parted, half(&mesh, below), stone, &[at(0.0, 1.0)]);
        if let Some(Instance { name, .. }) = parted.instances.last_mut() {
            *name = "ball".into();
        }
    }
    let settings = small(32, 4);
    let (a, b) = (
        estimate(&whole, &settings, 0..8),
        estimate(&parted, &settings, 100..108),
    );
    let z = (a.0 - b.0) / (a.1 + b.1).sqrt();
    assert!(z.abs() < 4.0, "{} {}: z {z}", a.0, b.0);
    // It has teeth: as two objects each half is open, and light is lost.
    for (number, instance) in parted.instances.iter_mut().enumerate() {
        instance.name = format!("{number}");
    }
    let open = estimate(&parted, &settings, 100..108);
    assert!(open.0 < a.0 - 4.0 * (a.1 + open.1).sqrt(), "{a:?} {open:?}");
}

/// Where floats cannot tell the ways below from the surface, light comes back as from longer ways.
#[test]
fn tiny_radii_give_the_light_of_small_ones_back() {
    let settings = small(32, 4);
    let small = estimate(&ball([1e-3; 3]), &settings, 0..8);
    for radius in [1e-5, 1e-6, 2e-8] {
        let tiny = estimate(&ball([radius; 3]), &settings, 100..108);
        // A radius of 1e-3 of the ball's lets through the terminator what tiny ones do not: less than that of the light.
        let bound = 4.0 * (small.1 + tiny.1).sqrt() + 2e-3 * small.0;
        assert!(
            (small.0 - tiny.0).abs() < bound,
            "{radius}: {} {}",
            small.0,
            tiny.0
        );
    }
}

/// Without the effect it is a diffuse surface of the same colour.
#[test]
fn left_out_it_is_diffuse() {
    let scene = ball([0.1; 3]);
    let without = RenderSettings {
        effects: EffectChoice::List(effects::names(effects::ALL - Effect::Subsurface)),
        ..small(8, 4)
    };
    let mut plain = scene.clone();
    if let Some(last) = plain.materials.last_mut() {
        *last = diffuse([0.8, 0.6, 0.4]).into();
    }
    let (a, b) = (run(&scene, &without), run(&plain, &without));
    assert!((mean(&a) / mean(&b) - 1.0).abs() < 1e-5);
}
