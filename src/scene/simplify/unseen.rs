//! Objects that no ray can reach, lights that are black, colours that are white.

use crate::scene::{Effect, LeftOut, Light, RayKind, Scene, Visibility};

/// Kinds of rays that there are.
const KINDS: [RayKind; 4] = [
    RayKind::Camera,
    RayKind::Diffuse,
    RayKind::Glossy,
    RayKind::Transmission,
];

/// Whether any ray but those to lights can find it.
fn is_found(visibility: Visibility) -> bool {
    KINDS.iter().any(|&kind| visibility.sees(kind))
}

/// Objects that nothing sees and that cast no shadow.
pub fn objects(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    scene.instances.retain(|instance| {
        let seen = is_found(instance.visibility) || instance.visibility.sees(RayKind::Shadow);
        if !seen {
            LeftOut::add(
                left_out,
                Effect::RayVisibility,
                "no ray sees the object",
                &instance.name,
                0,
            );
        }
        seen
    });
}

fn is_black(light: &Light) -> bool {
    light.kind.strength() == 0.0 || light.color == [0.0; 3]
}

/// Lights that are black, or that nothing sees.
pub fn lights(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    scene.lights.retain(|light| {
        let why = if is_black(light) {
            "the light is black"
        } else if !is_found(light.visibility) {
            "no ray sees the light"
        } else {
            return true;
        };
        LeftOut::add(left_out, light.kind.effect(), why, &light.name, 0);
        false
    });
}

/// A world that is black, or that nothing sees.
pub fn environment(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let Some(environment) = &scene.environment else {
        return;
    };
    let why = if environment.radiance == [0.0; 3] {
        "the world is black"
    } else if !is_found(environment.visibility) {
        "no ray sees the world"
    } else {
        return;
    };
    let effect = environment.effect();
    LeftOut::add(left_out, effect, why, "the environment", 0);
    scene.environment = None;
}

/// Colours of vertices that are all white and opaque.
pub fn colors(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    for mesh in &mut scene.meshes {
        let white = |colors: &Vec<[f32; 4]>| colors.iter().flatten().all(|&c| c == 1.0);
        if let Some(colors) = mesh.colors.take_if(|colors| white(colors)) {
            LeftOut::add(
                left_out,
                Effect::VertexColors,
                "white and opaque everywhere",
                &mesh.name,
                size_of_val(colors.as_slice()) as u64,
            );
        }
    }
}
