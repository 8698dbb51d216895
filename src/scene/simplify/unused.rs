//! What nothing refers to any more.

use crate::scene::graph::{Graph, TangentKind};
use crate::scene::{Effect, ImageId, LeftOut, Material, MaterialId, Mesh, MeshId, MeshStep, Scene};

/// The numbers that things have when those that are not `kept` are gone.
fn numbers(kept: &[bool]) -> Vec<u32> {
    let mut next = 0;
    let number = |&kept: &bool| {
        let number = next;
        next += u32::from(kept);
        number
    };
    kept.iter().map(number).collect()
}

/// Takes out what is not kept.
fn retain<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    list.retain(|_| kept.next().copied().unwrap_or(true));
}

fn mesh_bytes(mesh: &Mesh) -> u64 {
    let uvs: usize = mesh.uvs.iter().map(|set| size_of_val(set.as_slice())).sum();
    (size_of_val(mesh.positions.as_slice())
        + size_of_val(mesh.triangles.as_slice())
        + mesh.normals.as_deref().map_or(0, size_of_val)
        + mesh.motion.iter().map(MeshStep::bytes).sum::<usize>()
        + mesh.tangents.as_deref().map_or(0, size_of_val)
        + mesh.radial.as_deref().map_or(0, size_of_val)
        + mesh.generated.as_deref().map_or(0, size_of_val)
        + mesh.colors.as_deref().map_or(0, size_of_val)
        + mesh
            .attributes
            .iter()
            .map(|v| size_of_val(&v[..]))
            .sum::<usize>()
        + uvs) as u64
}

/// Meshes that are placed nowhere.
pub fn meshes(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let mut kept = vec![false; scene.meshes.len()];
    for instance in &scene.instances {
        if let Some(kept) = kept.get_mut(instance.mesh.0 as usize) {
            *kept = true;
        }
    }
    for (mesh, _) in scene.meshes.iter().zip(&kept).filter(|(_, kept)| !**kept) {
        let why = "meshes that are placed nowhere";
        LeftOut::add(left_out, None, why, &mesh.name, mesh_bytes(mesh));
    }
    let numbers = numbers(&kept);
    retain(&mut scene.meshes, &kept);
    for instance in &mut scene.instances {
        if let Some(&number) = numbers.get(instance.mesh.0 as usize) {
            instance.mesh = MeshId(number);
        }
    }
}

/// Materials that no mesh has.
pub fn materials(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let mut kept = vec![false; scene.materials.len()];
    for id in scene.meshes.iter().filter_map(|mesh| mesh.material) {
        if let Some(kept) = kept.get_mut(id.0 as usize) {
            *kept = true;
        }
    }
    let materials = scene.materials.iter().zip(&kept);
    for (material, _) in materials.filter(|(_, kept)| !**kept) {
        let why = "materials that nothing has";
        LeftOut::add(left_out, None, why, &material.name, 0);
    }
    keep_materials(scene, &kept);
}

/// Takes away materials in whose place others stand, which have been told.
pub fn forget_materials(scene: &mut Scene, firsts: &[MaterialId]) {
    let numbers = firsts.iter().enumerate();
    let kept: Vec<bool> = numbers.map(|(i, first)| first.0 as usize == i).collect();
    keep_materials(scene, &kept);
}

fn keep_materials(scene: &mut Scene, kept: &[bool]) {
    let numbers = numbers(kept);
    retain(&mut scene.materials, kept);
    for id in scene
        .meshes
        .iter_mut()
        .filter_map(|mesh| mesh.material.as_mut())
    {
        if let Some(&number) = numbers.get(id.0 as usize) {
            *id = MaterialId(number);
        }
    }
}

/// Images that no material has, and that are not the environment's.
pub fn images(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let mut kept = vec![false; scene.images.len()];
    rename_images(scene, |id| {
        if let Some(kept) = kept.get_mut(id.0 as usize) {
            *kept = true;
        }
        id
    });
    for (image, _) in scene.images.iter().zip(&kept).filter(|(_, kept)| !**kept) {
        let why = "images that nothing needs";
        LeftOut::add(left_out, None, why, &image.name, image.pixels.bytes());
    }
    let numbers = numbers(&kept);
    retain(&mut scene.images, &kept);
    rename_images(scene, |id| {
        numbers.get(id.0 as usize).map_or(id, |&n| ImageId(n))
    });
}

/// Gives the images other numbers wherever something refers to them.
pub fn rename_images(scene: &mut Scene, mut name: impl FnMut(ImageId) -> ImageId) {
    let of_materials = scene.materials.iter_mut().flat_map(|material| {
        let volume = material
            .medium
            .as_mut()
            .and_then(|m| m.varying.as_deref_mut());
        std::iter::once(&mut material.graph).chain(volume)
    });
    let of_world = scene.medium.as_mut().and_then(|m| m.varying.as_deref_mut());
    for texture in of_materials.chain(of_world).flat_map(Graph::textures_mut) {
        texture.image = name(texture.image);
    }
    if let Some(image) = scene.environment.as_mut().and_then(|e| e.image.as_mut()) {
        *image = name(*image);
    }
    let of_lights = scene.lights.iter_mut().filter_map(|l| l.graph.as_mut());
    let world = scene.environment.as_mut().and_then(|e| e.graph.as_mut());
    let graphs = of_lights
        .chain(&mut scene.world_aovs)
        .map(|graph| &mut **graph);
    for graph in graphs.chain(world.map(|world| &mut world.graph)) {
        for texture in graph.textures_mut() {
            texture.image = name(texture.image);
        }
    }
}

/// Tangents without a normal map, and texture coordinates that no texture reads; the first ones stay, as a pass shows them.
pub fn attributes(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let fallback = Material::default();
    for mesh in &mut scene.meshes {
        let material = mesh
            .material
            .and_then(|id| scene.materials.get(id.0 as usize));
        let material = material.unwrap_or(&fallback);
        if !material.graph.has_tangent(TangentKind::Uv)
            && let Some(tangents) = mesh.tangents.take()
        {
            LeftOut::add(
                left_out,
                Effect::NormalMaps,
                "tangents without a normal map",
                &mesh.name,
                size_of_val(tangents.as_slice()) as u64,
            );
        }
        if !material.graph.has_tangent(TangentKind::Radial)
            && let Some(radial) = mesh.radial.take()
        {
            LeftOut::add(
                left_out,
                Effect::Anisotropy,
                "radial tangents without anisotropy",
                &mesh.name,
                size_of_val(radial.as_slice()) as u64,
            );
        }
        let read = material.graph.uv_sets().max(1);
        for set in mesh.uvs.drain(read.min(mesh.uvs.len())..) {
            LeftOut::add(
                left_out,
                None,
                "texture coordinates that nothing reads",
                &mesh.name,
                size_of_val(set.as_slice()) as u64,
            );
        }
    }
}
