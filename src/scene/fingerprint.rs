//! A number that stands for a scene's content, so that a picture can say what it shows.

use super::{ObjectInfo, Pixels, Scene, Shutter, TextureSpace, Visibility};
use crate::math::primaries::WorkingSpace;
use sha2::{Digest, Sha256};

/// SHA-256 over everything in the scene that can change the picture, as 64 hexadecimal digits.
///
/// It depends on the content, not on the file: a `.glb` and a `.gltf` of the same scene agree.
/// It may change with the version of Sundog.
pub fn fingerprint(scene: &Scene) -> String {
    let mut hash = Sha256::new();
    // Every block comes with its length, so that no two scenes give the same bytes.
    let mut block = |name: &str, bytes: &[u8]| {
        hash.update(name.as_bytes());
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    for mesh in &scene.meshes {
        block("positions", bytemuck::cast_slice(&mesh.positions));
        block(
            "normals",
            mesh.normals
                .as_deref()
                .map(bytemuck::cast_slice)
                .unwrap_or_default(),
        );
        block(
            "tangents",
            mesh.tangents
                .as_deref()
                .map(bytemuck::cast_slice)
                .unwrap_or_default(),
        );
        if let Some(radial) = &mesh.radial {
            block("radial", bytemuck::cast_slice(radial));
        }
        if let Some(generated) = &mesh.generated {
            block("generated", bytemuck::cast_slice(generated));
        }
        for uvs in &mesh.uvs {
            block("uvs", bytemuck::cast_slice(uvs));
        }
        block(
            "colors",
            mesh.colors
                .as_deref()
                .map(bytemuck::cast_slice)
                .unwrap_or_default(),
        );
        for values in &mesh.attributes {
            block("attribute", bytemuck::cast_slice(values));
        }
        if mesh.texture_space != TextureSpace::default() {
            block(
                "texture space",
                format!("{:?}", mesh.texture_space).as_bytes(),
            );
        }
        for step in &mesh.motion {
            block("step", bytemuck::cast_slice(&step.positions));
            let normals = step.normals.as_deref();
            block(
                "normals of a step",
                normals.map(bytemuck::cast_slice).unwrap_or_default(),
            );
        }
        if let Some(grids) = &mesh.grids {
            block("grids", &[u8::from(grids.density_by_object)]);
            for grid in &grids.by_number {
                block("grid", &[]);
                if let Some(grid) = grid {
                    grid.digest(|bytes| block("values", bytes));
                }
            }
        }
        if let Some(strands) = &mesh.strands {
            block("strands", format!("{:?}", strands.shape).as_bytes());
            block("radii", bytemuck::cast_slice(&strands.radii));
            block("curves' normals", bytemuck::cast_slice(&strands.normals));
        }
        block("triangles", bytemuck::cast_slice(&mesh.triangles));
        block("material", format!("{:?}", mesh.material).as_bytes());
        if mesh.material_label.index != 0.0 {
            let index = mesh.material_label.index.to_le_bytes();
            block("pass index", &index);
        }
    }
    for instance in &scene.instances {
        block("mesh", &instance.mesh.0.to_le_bytes());
        block(
            "transform",
            bytemuck::cast_slice(&instance.world_from_object.to_cols_array()),
        );
        for step in &instance.motion {
            block("step", bytemuck::cast_slice(&step.to_cols_array()));
        }
        if (instance.visibility, instance.holdout) != (Visibility::ALL, false) {
            let seen = [instance.visibility.bits(), u32::from(instance.holdout)];
            block("seen", bytemuck::cast_slice(&seen));
        }
        if instance.info != ObjectInfo::default() {
            block("info", format!("{:?}", instance.info).as_bytes());
        }
    }
    for image in &scene.images {
        block(
            "image",
            format!("{} {} {}", image.width, image.height, image.channels).as_bytes(),
        );
        match &image.pixels {
            Pixels::U8(values) => block("8", values),
            Pixels::U16(values) => block("16", bytemuck::cast_slice(values)),
            Pixels::F32(values) => block("32", bytemuck::cast_slice(values)),
        }
    }
    for group in &scene.light_groups {
        block("light group", group.as_bytes());
    }
    if scene.shutter != Shutter::default() {
        block("shutter", format!("{:?}", scene.shutter).as_bytes());
    }
    let space = scene.color_management.working_space;
    if space != WorkingSpace::default() {
        block("working space", space.name().as_bytes());
    }
    if !scene.aovs.is_empty() {
        let aovs = (&scene.aovs, &scene.world_aovs);
        block("aovs", format!("{aovs:?}").as_bytes());
    }
    if !scene.portals.is_empty() {
        block("portals", format!("{:?}", scene.portals).as_bytes());
    }
    if let Some(gi) = &scene.fast_gi {
        block("fast gi", format!("{gi:?}").as_bytes());
    }
    // The rest is small; its debugging form has every field.
    if let Some(medium) = &scene.medium {
        block("medium", format!("{medium:?}").as_bytes());
    }
    block("materials", format!("{:?}", scene.materials).as_bytes());
    block("lights", format!("{:?}", scene.lights).as_bytes());
    block("environment", format!("{:?}", scene.environment).as_bytes());
    block("cameras", format!("{:?}", scene.cameras).as_bytes());
    hash.finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

#[cfg(test)]
#[path = "../../tests/unit/scene/fingerprint.rs"]
mod tests;
