//! Clean-up: a scene that went through [`clean`] keeps the promises of the scene types, whatever
//! file it came from.

use glam::{DAffine3, DVec3, Vec3};
use std::collections::HashSet;

use super::area;
use super::flatten::directions;
use super::graph::Graph;
use super::{
    Camera, Diagnostics, Effect, Light, LightKind, Material, Mesh, Projection, Scene, Verdict,
    duplicate_triangles, vertex_normals,
};
use crate::math::words::counted;

/// Makes a scene fit for rendering: drops what has no meaning, repairs what has one, and says so.
///
/// Afterwards all numbers are finite, all indices in range, normals and tangents of unit length (or zero, where Blender has such),
/// transforms invertible and material parameters in their legal ranges. Ids of meshes, materials and
/// images stay valid: meshes may become empty, but none is removed.
pub fn clean(scene: &mut Scene, diagnostics: &mut Diagnostics) {
    let (images, materials) = (scene.images.len(), scene.materials.len());
    for material in &mut scene.materials {
        clean_material(material, images, diagnostics);
    }
    let hidden = super::flatten::flatten(scene);
    let mut tally = Tally::default();
    let displaces = scene
        .materials
        .iter()
        .any(|m| m.graph.displacement.is_some());
    let from_blender = scene.is_from_blender();
    for mesh in &mut scene.meshes {
        if mesh.material.is_some_and(|m| m.0 as usize >= materials) {
            mesh.material = None;
            diagnostics.report(
                "bad-material",
                Verdict::Lost,
                "material that does not exist",
                &mesh.name,
                "the default material is used",
            );
        }
        clean_mesh(mesh, (displaces, from_blender), &mut tally, diagnostics);
        let material = mesh.material.map(|m| &scene.materials[m.0 as usize]);
        if let Some(material) = material.filter(|m| duplicate_triangles::make_light(m)) {
            let count = duplicate_triangles::leave_out(mesh, material.double_sided);
            tally.shining_twins.add(&mesh.name, count);
        }
    }
    tally.report(diagnostics);
    super::motion::clean(scene, diagnostics);
    clean_instances(scene, &hidden, diagnostics);
    duplicate_triangles::leave_out_across(scene).report(
        diagnostics,
        "shining-twins-of-others",
        Verdict::Approximated,
        "that shine and stand where one of another object does",
    );
    scene
        .lights
        .retain_mut(|light| clean_light(light, diagnostics));
    scene
        .cameras
        .retain_mut(|camera| clean_camera(camera, diagnostics));
    clean_environment(scene, images, diagnostics);
    super::medium::clean(scene.medium.as_mut(), images, "world", diagnostics);
}

/// Drops instances that show nothing or cannot be placed.
fn clean_instances(scene: &mut Scene, hidden: &HashSet<usize>, diagnostics: &mut Diagnostics) {
    let meshes = &scene.meshes;
    // The largest coordinate of each mesh.
    let farthest: Vec<f32> = meshes
        .iter()
        .map(|m| {
            m.positions
                .iter()
                .flatten()
                .fold(0.0f32, |largest, c| largest.max(c.abs()))
        })
        .collect();
    let mut numbers = 0..;
    scene.instances.retain(|instance| {
        let is_hidden = numbers
            .next()
            .is_some_and(|number| hidden.contains(&number));
        let id = instance.mesh.0 as usize;
        let Some(mesh) = meshes.get(id) else {
            diagnostics.report(
                "bad-instance",
                Verdict::Lost,
                "instance of a mesh that does not exist",
                &instance.name,
                "left out",
            );
            return false;
        };
        if mesh.triangles.is_empty() {
            return false;
        }
        let (name, place) = (&instance.name, &instance.world_from_object);
        let kept = has_volume(place, name, is_hidden, diagnostics)
            && is_within_reach(farthest[id], place, name, diagnostics);
        if kept {
            report_tiny(
                3.0 * growth(place) * f64::from(farthest[id]),
                name,
                diagnostics,
            );
        }
        kept
    });
}

/// Whether a light can be rendered; one that is too small for its kind is a point.
fn clean_light(light: &mut Light, diagnostics: &mut Diagnostics) -> bool {
    let numbers = match light.kind {
        LightKind::Point { radius, .. } => [radius, 0.0, 0.0],
        LightKind::Spot {
            radius,
            half_angle,
            blend,
            ..
        } => [radius, half_angle, blend],
        LightKind::Sun { angle, .. } => [angle, 0.0, 0.0],
        LightKind::Area {
            size: [x, y],
            spread,
            ..
        } => [x, y, spread],
    };
    // Light of less than nothing takes from that of others, as in Cycles.
    let sane = numbers.iter().all(|n| n.is_finite() && *n >= 0.0)
        && light.kind.strength().is_finite()
        && light.color.iter().all(|n| n.is_finite())
        && light.world_from_light.is_finite()
        && light.world_from_light.z_axis_direction().is_some();
    if !sane {
        diagnostics.report(
            "bad-light",
            Verdict::Lost,
            "light with a negative size, a number that is not finite, or no direction",
            &light.name,
            "left out",
        );
        return false;
    }
    let extent = match light.kind {
        LightKind::Point { radius, .. } | LightKind::Spot { radius, .. } => radius,
        LightKind::Area { size: [x, y], .. } => x.max(y),
        LightKind::Sun { .. } => 0.0,
    };
    if !is_within_reach(extent, &light.world_from_light, &light.name, diagnostics) {
        return false;
    }
    if let LightKind::Point { radius, .. } | LightKind::Spot { radius, .. } = &mut light.kind
        && *radius > 0.0
        && f64::from(*radius) < LEAST
    {
        *radius = 0.0;
        diagnostics.report(
            "tiny-lamp",
            Verdict::Exact,
            "lamp smaller than 10⁻¹⁷ m",
            &light.name,
            "rendered as a point",
        );
    }
    if let LightKind::Area { size: [x, y], .. } = light.kind {
        let m = light.world_from_light.matrix3;
        let edges = (m.x_axis * f64::from(x), m.y_axis * f64::from(y));
        if edges.0.cross(edges.1) == DVec3::ZERO {
            diagnostics.report_effect(
                Effect::AreaLights,
                "flat-light",
                Verdict::Lost,
                "area light without an area",
                &light.name,
                "left out",
            );
            return false;
        }
        let extent = edges.0.length().max(edges.1.length());
        report_tiny(extent, &light.name, diagnostics);
    }
    true
}

/// Whether a camera can be rendered; clipping, window and aperture that have no meaning are left out of it.
fn clean_camera(camera: &mut Camera, diagnostics: &mut Diagnostics) -> bool {
    let positive = |n: f64| n.is_finite() && n > 0.0;
    let sane = camera.world_from_camera.is_finite()
        && camera.world_from_camera.matrix3.determinant() != 0.0
        && match camera.projection {
            Projection::Perspective {
                vertical_fov,
                aspect,
            } => {
                positive(vertical_fov)
                    && vertical_fov < std::f64::consts::PI
                    && aspect.is_none_or(positive)
            }
            Projection::Orthographic {
                half_width,
                half_height,
            } => positive(half_width) && positive(half_height),
            Projection::Equirectangular {
                longitude,
                latitude,
            } => [longitude, latitude]
                .iter()
                .all(|[from, to]| from.is_finite() && to.is_finite() && from != to),
            Projection::Panorama { kind, shift } => {
                kind.is_sane() && shift.iter().all(|s| s.is_finite())
            }
        };
    if !sane {
        diagnostics.report(
            "bad-camera",
            Verdict::Lost,
            "camera with an impossible angle, size or transform",
            &camera.name,
            "left out",
        );
        return false;
    }
    let near_is_sane = camera.clip_near.is_finite() && camera.clip_near >= 0.0;
    let far_is_sane = !camera.clip_far.is_nan() && camera.clip_far > camera.clip_near;
    if !(near_is_sane && far_is_sane) {
        diagnostics.report(
            "bad-clipping",
            Verdict::Approximated,
            "camera with impossible clipping distances",
            &camera.name,
            "nothing is clipped",
        );
        (camera.clip_near, camera.clip_far) = (0.0, f64::INFINITY);
    }
    if camera.window.is_some_and(|window| !window.is_sane()) {
        diagnostics.report(
            "bad-window",
            Verdict::Approximated,
            "camera with impossible edges of the picture",
            &camera.name,
            "its angle or size is used instead",
        );
        camera.window = None;
    }
    if camera
        .aperture
        .is_some_and(|a| a.radius != 0.0 && !a.is_sane())
    {
        diagnostics.report_effect(
            Effect::DepthOfField,
            "bad-aperture",
            Verdict::Approximated,
            "camera with an impossible aperture",
            &camera.name,
            "rendered as a pinhole: all is sharp",
        );
    }
    camera.aperture = camera.aperture.filter(crate::scene::Aperture::is_sane);
    true
}

/// Drops an environment whose numbers have no meaning.
fn clean_environment(scene: &mut Scene, images: usize, diagnostics: &mut Diagnostics) {
    if let Some(environment) = &mut scene.environment {
        let sane = environment.radiance.iter().all(|c| c.is_finite())
            && environment.rotation.is_finite()
            && environment.rotation.determinant() != 0.0
            && environment.image.is_none_or(|i| (i.0 as usize) < images);
        if !sane {
            diagnostics.report_effect(
                environment.effect(),
                "bad-environment",
                Verdict::Lost,
                "environment with impossible numbers",
                "",
                "left out",
            );
            scene.environment = None;
        }
    }
    for light in &mut scene.lights {
        if let Some(graph) = &mut light.graph {
            clean_graph(graph, images, &light.name, diagnostics);
        }
    }
    let world = scene.environment.as_mut().and_then(|e| e.graph.as_mut());
    if let Some(world) = world {
        clean_graph(&mut world.graph, images, "the world", diagnostics);
    }
    if let Some(aovs) = &mut scene.world_aovs {
        clean_graph(aovs, images, "the world", diagnostics);
    }
}

/// Triangles that were left out, by mesh, for a message that says how many there were in all.
#[derive(Debug, Default)]
pub struct Dropped(Vec<(String, usize)>);

impl Dropped {
    /// Adds some triangles of a mesh (none: nothing happens).
    pub fn add(&mut self, mesh: &str, triangles: usize) {
        if triangles > 0 {
            self.0.push((mesh.into(), triangles));
        }
    }

    /// Says that their corners name vertices that do not exist.
    pub fn report_bad_indices(&self, diagnostics: &mut Diagnostics) {
        self.report(
            diagnostics,
            "bad-indices",
            Verdict::Lost,
            "with vertices that do not exist",
        );
    }

    pub(super) fn report(
        &self,
        diagnostics: &mut Diagnostics,
        code: &'static str,
        verdict: Verdict,
        why: &str,
    ) {
        let total: usize = self.0.iter().map(|(_, n)| n).sum();
        for (mesh, _) in &self.0 {
            diagnostics.report(
                code,
                verdict,
                format!("{} {why}", counted(total, "triangle", "triangles")),
                mesh,
                "left out",
            );
        }
    }
}

trait Direction {
    fn z_axis_direction(&self) -> Option<DVec3>;
}

impl Direction for DAffine3 {
    fn z_axis_direction(&self) -> Option<DVec3> {
        self.matrix3.z_axis.try_normalize()
    }
}

/// Whether an instance's transform can be inverted, in a way that does not depend on its scale.
fn has_volume(
    transform: &DAffine3,
    name: &str,
    is_hidden: bool,
    diagnostics: &mut Diagnostics,
) -> bool {
    if !transform.is_finite() {
        diagnostics.report(
            "bad-transform",
            Verdict::Lost,
            "transform that is not finite",
            name,
            "the object is left out",
        );
        return false;
    }
    // What keeps a plane has become a mesh of its own before, if it has an area and Cycles shows it.
    let is_flat = directions(&transform.matrix3) < 3;
    if is_flat {
        let (what, how) = if is_hidden {
            (
                "object scaled to a plane, whose mesh others share, moves, or lets light below its surface",
                "left out, as in Cycles",
            )
        } else {
            ("object scaled to a line or to a point", "left out")
        };
        diagnostics.report("singular-transform", Verdict::Exact, what, name, how);
    }
    !is_flat
}

/// Distances up to this many metres have squares that an f32 holds.
const REACH: f64 = 1e18;

/// The largest entry of a transform's matrix.
fn growth(transform: &DAffine3) -> f64 {
    let entries = transform.matrix3.to_cols_array();
    entries.iter().fold(0.0, |m, c| m.max(c.abs()))
}

/// Whether a placed mesh is near enough to be rendered in f32.
fn is_within_reach(
    farthest: f32,
    transform: &DAffine3,
    name: &str,
    diagnostics: &mut Diagnostics,
) -> bool {
    // No sum of three products of entries and coordinates is larger than three times the largest.
    let near = 3.0 * growth(transform) * f64::from(farthest)
        + transform.translation.abs().max_element()
        < REACH;
    if !near {
        diagnostics.report(
            "out-of-reach",
            Verdict::Lost,
            "object or light farther away or larger than 10¹⁸ m",
            name,
            "left out",
        );
    }
    near
}

/// Below this many metres squares of lengths and their products leave the range of f32.
const LEAST: f64 = 1e-17;

/// Tells an object of whose points none is this far from its origin.
fn report_tiny(extent: f64, name: &str, diagnostics: &mut Diagnostics) {
    if extent < LEAST {
        diagnostics.report(
            "too-small",
            Verdict::Lost,
            "object or light smaller than 10⁻¹⁷ m",
            name,
            "rays may miss it: scale the scene up",
        );
    }
}

/// The triangles that [`clean`] leaves out, by reason.
#[derive(Debug, Default)]
struct Tally {
    bad_indices: Dropped,
    not_finite: Dropped,
    without_area: Dropped,
    shining_twins: Dropped,
}

impl Tally {
    fn report(&self, diagnostics: &mut Diagnostics) {
        self.bad_indices.report_bad_indices(diagnostics);
        self.not_finite.report(
            diagnostics,
            "non-finite-positions",
            Verdict::Lost,
            "with corners that are not finite",
        );
        area::report(&self.without_area, diagnostics);
        self.shining_twins.report(
            diagnostics,
            "shining-twins",
            Verdict::Approximated,
            "that shine and stand where another one does",
        );
    }
}

/// `displaces`: triangles without area are left to [`area::clean_displaced`], because displacement may open them.
fn clean_mesh(
    mesh: &mut Mesh,
    (displaces, from_blender): (bool, bool),
    tally: &mut Tally,
    diagnostics: &mut Diagnostics,
) {
    let count = mesh.positions.len();
    let fits = |length: Option<usize>| length.is_none_or(|l| l == count);
    let lengths_match = fits(mesh.normals.as_ref().map(Vec::len))
        && fits(mesh.tangents.as_ref().map(Vec::len))
        && fits(mesh.radial.as_ref().map(Vec::len))
        && fits(mesh.generated.as_ref().map(Vec::len))
        && fits(mesh.colors.as_ref().map(Vec::len))
        && fits(mesh.strands.as_ref().map(|strands| strands.radii.len()))
        && mesh
            .strands
            .as_ref()
            .is_none_or(|s| s.normals.is_empty() || s.normals.len() == count)
        && mesh
            .attributes
            .iter()
            .all(|values| fits(Some(values.len())))
        && mesh.uvs.iter().all(|set| fits(Some(set.len())));
    if !lengths_match {
        diagnostics.report(
            "bad-attributes",
            Verdict::Lost,
            "mesh whose attributes differ in length",
            &mesh.name,
            "left out",
        );
        mesh.triangles.clear();
        return;
    }
    let before = mesh.triangles.len();
    mesh.triangles
        .retain(|t| t.iter().all(|&i| (i as usize) < count));
    let whole = mesh.triangles.len();
    tally.bad_indices.add(&mesh.name, before - whole);

    let positions = &mesh.positions;
    let corner = |i: u32| Vec3::from(positions[i as usize]);
    mesh.triangles
        .retain(|t| t.iter().all(|&i| corner(i).is_finite()));
    let finite = mesh.triangles.len();
    tally.not_finite.add(&mesh.name, whole - finite);

    let lines = match &mesh.strands {
        Some(strands) => {
            let has_size = |&i: &u32| strands.radii[i as usize] > 0.0;
            mesh.triangles
                .retain(|corners| corners.iter().any(has_size));
            finite - mesh.triangles.len()
        }
        None if displaces => 0,
        None => area::leave_out_without(mesh),
    };
    tally.without_area.add(&mesh.name, lines);
    // Vertices that no triangle uses any more must not spoil bounds.
    for position in &mut mesh.positions {
        if position.iter().any(|c| !c.is_finite()) {
            *position = [0.0; 3];
        }
    }
    vertex_normals::clean(mesh, from_blender, diagnostics);
    vertex_normals::clean_tangents(mesh, diagnostics);
    for direction in mesh.radial.iter_mut().chain(&mut mesh.generated).flatten() {
        if direction.iter().any(|c| !c.is_finite()) {
            *direction = [0.0; 3];
        }
    }
    let mut replaced = false;
    for set in &mut mesh.uvs {
        for value in set.iter_mut().flatten().filter(|v| !v.is_finite()) {
            (*value, replaced) = (0.0, true);
        }
    }
    if replaced {
        diagnostics.report(
            "bad-uvs",
            Verdict::Approximated,
            "texture coordinates that are not finite",
            &mesh.name,
            "taken as 0",
        );
    }
    let mut replaced = false;
    let space = &mut mesh.texture_space;
    let numbers = space.location.iter_mut().chain(&mut space.size);
    for value in numbers.chain(mesh.attributes.iter_mut().flatten().flatten()) {
        if !value.is_finite() {
            *value = 0.0;
        }
    }
    for value in mesh.colors.iter_mut().flatten().flatten() {
        if !(value.is_finite() && *value >= 0.0) {
            (*value, replaced) = (0.0, true);
        }
    }
    if replaced {
        diagnostics.report_effect(
            Effect::VertexColors,
            "bad-colours",
            Verdict::Approximated,
            "vertex colours that are negative or not finite",
            &mesh.name,
            "taken as 0",
        );
    }
}

fn clean_material(material: &mut Material, images: usize, diagnostics: &mut Diagnostics) {
    clean_graph(&mut material.graph, images, &material.name, diagnostics);
    super::medium::clean(
        material.medium.as_mut(),
        images,
        &material.name,
        diagnostics,
    );
    super::nesting::clean(material, diagnostics);
}

pub(super) fn clean_graph(
    graph: &mut Graph,
    images: usize,
    owner: &str,
    diagnostics: &mut Diagnostics,
) {
    let faults = graph.clean(images);
    let mut tell = |there: bool, code, verdict, feature: &str, instead: &str| {
        if there {
            diagnostics.report(code, verdict, feature, owner, instead);
        }
    };
    tell(
        faults.links,
        "bad-link",
        Verdict::Lost,
        "links between nodes that go nowhere",
        "left out",
    );
    tell(
        faults.numbers,
        "material-range",
        Verdict::Approximated,
        "material with numbers outside of their legal range",
        "the nearest legal number is used",
    );
    tell(
        faults.textures,
        "bad-texture",
        Verdict::Lost,
        "texture without an image or with a transform that is not finite",
        "left out",
    );
}
