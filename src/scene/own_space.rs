//! Which meshes Cycles leaves in their own space. To all others it applies the transform of their object before it traces.

use super::{Instance, Scene};

/// By instance, whether its mesh stays in its own space: others share it, it moves, or light goes on below its surface.
pub(super) fn stays(scene: &Scene) -> Vec<bool> {
    let mut users = vec![0u32; scene.meshes.len()];
    for instance in scene.instances.iter().filter(|i| !i.info.own_mesh) {
        if let Some(users) = users.get_mut(instance.mesh.0 as usize) {
            *users += 1;
        }
    }
    let goes_below: Vec<bool> = (scene.materials.iter())
        .map(|material| material.graph.goes_below())
        .collect();
    let stays = |instance: &Instance| {
        let id = instance.mesh.0 as usize;
        let material = scene.meshes.get(id).and_then(|mesh| mesh.material);
        (!instance.info.own_mesh && users.get(id).is_some_and(|&users| users > 1))
            || !instance.motion.is_empty()
            || material.is_some_and(|id| goes_below.get(id.0 as usize) == Some(&true))
    };
    scene.instances.iter().map(stays).collect()
}
