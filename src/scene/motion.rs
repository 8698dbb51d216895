//! What moves while the shutter is open. Motions are told at equal steps of time, from where it opens to where it closes.

use super::flatten::directions;
use super::{Diagnostics, Effect, Mesh, Scene, Subject, Verdict};
use glam::{DAffine3, Vec3};

/// Embree takes no more steps.
pub const MOST_STEPS: usize = 129;

/// How the shutter lets light through.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shutter {
    /// How much light it lets through at equal steps of time; empty: always as much.
    pub curve: Vec<f32>,
    /// The picture is taken row by row, from the top: of the whole time that the shutter takes, the share that it is open for each
    /// row.
    pub rolling: Option<f32>,
    /// Nothing is blurred: the picture is that of the middle, and what moves is for motion vectors.
    pub still: bool,
    /// Motion vectors are of objects alone: what lies at infinity has none.
    pub objects_alone: bool,
}

/// The vertices of a mesh at a step of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshStep {
    /// Their positions, as many as the mesh has.
    pub positions: Vec<[f32; 3]>,
    /// Their unit normals, where the mesh has normals.
    pub normals: Option<Vec<[f32; 3]>>,
}

impl MeshStep {
    /// What it takes.
    pub(super) fn bytes(&self) -> usize {
        let normals = self.normals.as_deref();
        size_of_val(&self.positions[..]) + normals.map_or(0, size_of_val)
    }
}

/// A camera that moves.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraMotion {
    /// Camera space to world space at equal steps of time; empty where it stands.
    pub steps: Vec<DAffine3>,
    /// What the edges of the picture are multiplied with where the shutter opens and where it closes; half-way it is 1.
    pub zoom: [f64; 2],
}

impl CameraMotion {
    fn is_sane(&self) -> bool {
        let steps = self.steps.len();
        (steps == 0 || has_steps(steps))
            && self.steps.iter().all(DAffine3::is_finite)
            && self.zoom.iter().all(|z| z.is_finite() && *z > 0.0)
    }
}

fn has_steps(count: usize) -> bool {
    (2..=MOST_STEPS).contains(&count)
}

/// Whether an f32 holds the squares of how far points of this size go.
fn is_within_reach(step: &DAffine3, size: f64) -> bool {
    const REACH: f64 = 1e18;
    let columns = [
        step.matrix3.x_axis,
        step.matrix3.y_axis,
        step.matrix3.z_axis,
    ];
    let growth: f64 = columns.iter().map(|axis| axis.length()).sum();
    growth * size + step.translation.abs().max_element() < REACH
}

/// Says of what fills objects and varies that it does not move with them.
fn tell_of_volumes(scene: &Scene, diagnostics: &mut Diagnostics) {
    for instance in &scene.instances {
        let Some(mesh) = scene.meshes.get(instance.mesh.0 as usize) else {
            continue;
        };
        let moves = !instance.motion.is_empty() || !mesh.motion.is_empty();
        let material = mesh
            .material
            .and_then(|m| scene.materials.get(m.0 as usize));
        let medium = material.and_then(|material| material.medium.as_ref());
        if moves && medium.is_some_and(|medium| medium.varying.is_some()) {
            diagnostics.report_effect(
                Effect::Media,
                "still-volume",
                Verdict::Approximated,
                "volumes that vary on objects that move",
                Subject::Object(instance.name.clone()),
                "what fills them stands still while the shutter is open",
            );
        }
    }
}

/// Takes out motions that are none, and those that cannot be rendered, which is told.
pub(super) fn clean(scene: &mut Scene, diagnostics: &mut Diagnostics) {
    let mut refuse = |name: &str| {
        diagnostics.report(
            "bad-motion",
            Verdict::Lost,
            "motion whose steps are too many, too few, of another size than the mesh, or not finite",
            name,
            "it stands still",
        );
    };
    for mesh in &mut scene.meshes {
        if mesh.motion.is_empty() {
            continue;
        }
        if !fits(mesh) {
            mesh.motion.clear();
            refuse(&mesh.name);
        } else if mesh.motion.iter().all(|s| s.positions == mesh.positions) {
            mesh.motion.clear();
        }
    }
    let size = |mesh: &Mesh| {
        let steps = mesh.motion.iter().flat_map(|step| &step.positions);
        let all = mesh.positions.iter().chain(steps).flatten();
        f64::from(all.fold(0.0f32, |most, c| most.max(c.abs())))
    };
    let sizes: Vec<f64> = scene.meshes.iter().map(size).collect();
    for instance in &mut scene.instances {
        if instance.motion.is_empty() {
            continue;
        }
        let size = sizes.get(instance.mesh.0 as usize).copied().unwrap_or(0.0);
        let steps = &instance.motion;
        let is_flat = directions(&instance.world_from_object.matrix3) < 3;
        let sane = |step: &DAffine3| step.is_finite() && is_within_reach(step, size);
        if is_flat || !has_steps(steps.len()) || !steps.iter().all(sane) {
            instance.motion.clear();
            refuse(&instance.name);
        } else if steps.iter().all(|s| *s == instance.world_from_object) {
            instance.motion.clear();
        }
    }
    for camera in &mut scene.cameras {
        let Some(motion) = &mut camera.motion else {
            continue;
        };
        if motion.steps.iter().all(|s| *s == camera.world_from_camera) {
            motion.steps.clear();
        }
        if !motion.is_sane() {
            camera.motion = None;
            refuse(&camera.name);
        } else if motion.steps.is_empty() && motion.zoom == [1.0; 2] {
            camera.motion = None;
        }
    }
    let shutter = &mut scene.shutter;
    let light = |&c: &f32| c.is_finite() && c >= 0.0;
    let curve = &shutter.curve;
    let open = curve.iter().any(|c| *c > 0.0) && curve.len() >= 2;
    let sane = curve.is_empty() || open && curve.iter().all(light);
    if !sane {
        shutter.curve.clear();
        refuse("shutter");
    }
    if shutter
        .rolling
        .is_some_and(|share| !(0.0..=1.0).contains(&share))
    {
        shutter.rolling = None;
        refuse("shutter");
    }
    tell_of_volumes(scene, diagnostics);
}

/// Whether the steps of a mesh are of its size and finite; normals are brought to unit length.
fn fits(mesh: &mut Mesh) -> bool {
    let count = mesh.positions.len();
    let normals = mesh.normals.is_some();
    let mut fits = has_steps(mesh.motion.len());
    for step in &mut mesh.motion {
        if !normals {
            step.normals = None;
        }
        for normal in step.normals.iter_mut().flatten() {
            let n = Vec3::from(*normal).as_dvec3();
            *normal = n.normalize_or_zero().as_vec3().into();
        }
        let all = step.positions.iter().chain(step.normals.iter().flatten());
        fits &= step.positions.len() == count
            && step.normals.as_ref().is_some_and(|n| n.len() == count) == normals
            && all.flatten().all(|c| c.is_finite());
    }
    fits
}
