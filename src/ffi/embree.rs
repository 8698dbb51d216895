//! Embree 4: devices, scenes, triangle meshes, strands, spheres, instances, and the queries on them.
//!
//! The bindings are made by bindgen at build time from the installed headers. Handles are
//! reference-counted by Embree; a [`Scene`] keeps alive what it refers to. A committed scene is
//! read-only ([`CommittedScene`]) and may be used by any number of threads.

#[allow(
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    dead_code,
    missing_docs,
    unused_imports,
    clippy::all,
    clippy::undocumented_unsafe_blocks
)]
mod sys {
    include!(concat!(env!("OUT_DIR"), "/embree.rs"));
}

mod device;
mod strands;
mod triangles;

pub use device::{Device, EmbreeError, HEADERS, InstructionSet, Version};
pub use strands::{StrandMesh, StrandShape};
pub use triangles::TriangleMesh;

use device::take_error;
use std::mem::size_of;
use std::sync::Arc;

/// "No geometry" and "no instance" in Embree's structures.
const INVALID: u32 = u32::MAX;

/// A placement by what Embree interpolates between its steps: rotations along the shortest arc, the rest linearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecomposedTransform {
    /// A unit quaternion: real part, i, j, k.
    pub rotation: [f32; 4],
    /// Along the axes, before the rotation.
    pub scale: [f32; 3],
    /// Of y along x, of z along x, of z along y.
    pub skew: [f32; 3],
    /// After the rotation.
    pub translation: [f32; 3],
}

impl DecomposedTransform {
    fn to_embree(self) -> sys::RTCQuaternionDecomposition {
        let ([r, i, j, k], [x, y, z]) = (self.rotation, self.translation);
        sys::RTCQuaternionDecomposition {
            scale_x: self.scale[0],
            scale_y: self.scale[1],
            scale_z: self.scale[2],
            skew_xy: self.skew[0],
            skew_xz: self.skew[1],
            skew_yz: self.skew[2],
            shift_x: 0.0,
            shift_y: 0.0,
            shift_z: 0.0,
            quaternion_r: r,
            quaternion_i: i,
            quaternion_j: j,
            quaternion_k: k,
            translation_x: x,
            translation_y: y,
            translation_z: z,
        }
    }
}

fn check_steps(count: usize) -> Result<(), EmbreeError> {
    let most = sys::RTC_MAX_TIME_STEP_COUNT as usize;
    if (2..=most).contains(&count) {
        return Ok(());
    }
    Err(EmbreeError(format!(
        "a motion has {count} steps; 2 to {most} can be rendered"
    )))
}

struct SceneHandle {
    raw: sys::RTCScene,
    device: Device,
    meshes: Vec<Arc<TriangleMesh>>,
    strands: Vec<Arc<StrandMesh>>,
    children: Vec<CommittedScene>,
}

// SAFETY: scenes may be used from any thread; a committed one by many at a time (Embree manual,
// "Embree API"); changes go through `&mut Scene`.
unsafe impl Send for SceneHandle {}
// SAFETY: as above: shared references exist only to committed scenes.
unsafe impl Sync for SceneHandle {}

impl Drop for SceneHandle {
    fn drop(&mut self) {
        // SAFETY: released once; the buffers and children that it refers to are fields of this
        // handle and are dropped after this.
        unsafe { sys::rtcReleaseScene(self.raw) }
    }
}

/// A scene under construction.
pub struct Scene {
    handle: SceneHandle,
}

/// A scene that is ready for queries.
#[derive(Clone)]
pub struct CommittedScene {
    handle: Arc<SceneHandle>,
}

/// A ray. `direction` need not have unit length; distances are multiples of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes.
    pub direction: [f32; 3],
    /// Hits nearer than this are ignored.
    pub near: f32,
    /// Hits farther than this are ignored.
    pub far: f32,
    /// Geometries whose masks have no bit in common with this are not there.
    pub mask: u32,
    /// When it is on its way, 0 to 1.
    pub time: f32,
}

/// A hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hit {
    /// Multiple of the ray's direction.
    pub distance: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// Geometry in the scene that holds it (the instanced scene for instances).
    pub geometry: u32,
    /// Triangle or sphere in the geometry.
    pub primitive: u32,
    /// Geometry of the top scene that is the instance.
    pub instance: Option<u32>,
    /// That of the ray.
    pub time: f32,
}

impl Hit {
    /// Number of the object: of the geometry in the top scene.
    #[inline]
    pub fn object(&self) -> u32 {
        self.instance.unwrap_or(self.geometry)
    }

    /// The same hit with another number of the object, as another scene that holds it has.
    #[must_use]
    pub fn of_object(mut self, number: u32) -> Self {
        match &mut self.instance {
            Some(instance) => *instance = number,
            None => self.geometry = number,
        }
        self
    }
}

fn ray(r: &Ray) -> sys::RTCRay {
    sys::RTCRay {
        org_x: r.origin[0],
        org_y: r.origin[1],
        org_z: r.origin[2],
        tnear: r.near,
        dir_x: r.direction[0],
        dir_y: r.direction[1],
        dir_z: r.direction[2],
        time: r.time,
        tfar: r.far,
        mask: r.mask,
        id: 0,
        flags: 0,
    }
}

fn ray_hit(r: &Ray) -> sys::RTCRayHit {
    sys::RTCRayHit {
        ray: ray(r),
        hit: sys::RTCHit {
            Ng_x: 0.0,
            Ng_y: 0.0,
            Ng_z: 0.0,
            u: 0.0,
            v: 0.0,
            primID: INVALID,
            geomID: INVALID,
            instID: [INVALID; 1],
            instPrimID: [INVALID; 1],
        },
    }
}

fn read_hit(r: &sys::RTCRayHit) -> Option<Hit> {
    let h = &r.hit;
    (h.geomID != INVALID).then(|| Hit {
        distance: r.ray.tfar,
        u: h.u,
        v: h.v,
        geometry: h.geomID,
        primitive: h.primID,
        instance: (h.instID[0] != INVALID).then_some(h.instID[0]),
        time: r.ray.time,
    })
}

/// Embree's context with the caller's filter behind it: the filter function gets a pointer to it.
#[repr(C)]
struct FilterContext<'a, F> {
    base: sys::RTCRayQueryContext,
    filter: &'a mut F,
}

impl<'a, F> FilterContext<'a, F> {
    fn new(filter: &'a mut F) -> Self {
        Self {
            base: sys::RTCRayQueryContext {
                instID: [INVALID; 1],
                instPrimID: [INVALID; 1],
            },
            filter,
        }
    }
}

/// Asks the caller's filter about one hit; called by Embree.
unsafe extern "C" fn filter_trampoline<F: FnMut(&Hit) -> bool>(
    args: *const sys::RTCFilterFunctionNArguments,
) {
    // SAFETY: Embree passes valid arguments; with single-ray queries N is 1, so that the ray and
    // hit are plain RTCRay and RTCHit; the context is the FilterContext<F> of the query.
    unsafe {
        let args = &*args;
        if args.N != 1 || *args.valid != -1 {
            return;
        }
        let context = &mut *args.context.cast::<FilterContext<'_, F>>();
        let (r, h) = (
            &*args.ray.cast::<sys::RTCRay>(),
            &*args.hit.cast::<sys::RTCHit>(),
        );
        let hit = Hit {
            distance: r.tfar,
            u: h.u,
            v: h.v,
            geometry: h.geomID,
            primitive: h.primID,
            instance: (h.instID[0] != INVALID).then_some(h.instID[0]),
            time: r.time,
        };
        if !(context.filter)(&hit) {
            *args.valid = 0;
        }
    }
}

impl Scene {
    /// An empty scene. Queries are robust (watertight up to rounding of shared vertices).
    /// `robust`: rays do not slip through the edges between triangles.
    ///
    /// # Errors
    /// If memory is short.
    pub fn new(device: &Device, robust: bool) -> Result<Self, EmbreeError> {
        let robust = if robust {
            sys::RTC_SCENE_FLAG_ROBUST
        } else {
            0
        };
        // SAFETY: the device is alive.
        let raw = unsafe { sys::rtcNewScene(device.0.raw) };
        if raw.is_null() {
            take_error()?;
            return Err(EmbreeError("no scene could be made".into()));
        }
        // SAFETY: the scene was just made.
        unsafe {
            sys::rtcSetSceneFlags(
                raw,
                robust | sys::RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS,
            )
        };
        Ok(Self {
            handle: SceneHandle {
                raw,
                device: device.clone(),
                meshes: Vec::new(),
                strands: Vec::new(),
                children: Vec::new(),
            },
        })
    }

    /// Makes a geometry, lets `fill` set it up, commits and attaches it; returns its number.
    fn attach(
        &mut self,
        kind: sys::RTCGeometryType,
        fill: impl FnOnce(sys::RTCGeometry) -> Result<(), EmbreeError>,
    ) -> Result<u32, EmbreeError> {
        let device = self.handle.device.clone();
        // SAFETY: the device is alive.
        let geometry = unsafe { sys::rtcNewGeometry(device.0.raw, kind) };
        if geometry.is_null() {
            take_error()?;
            return Err(EmbreeError("no geometry could be made".into()));
        }
        let filled = fill(geometry);
        // SAFETY: `geometry` is alive until the release; the scene takes its own reference.
        let id = unsafe {
            sys::rtcCommitGeometry(geometry);
            let id = sys::rtcAttachGeometry(self.handle.raw, geometry);
            sys::rtcReleaseGeometry(geometry);
            id
        };
        filled?;
        take_error()?;
        Ok(id)
    }

    /// Adds a triangle mesh; with `filtered` its hits are put before the filters of queries. `mask`: see [`Ray::mask`].
    /// Returns the geometry's number (0, 1, 2, … in the order of the calls).
    ///
    /// # Errors
    /// If Embree refuses it or memory is short.
    pub fn add_triangles(
        &mut self,
        mesh: &Arc<TriangleMesh>,
        filtered: bool,
        mask: u32,
    ) -> Result<u32, EmbreeError> {
        let id = self.attach(sys::RTC_GEOMETRY_TYPE_TRIANGLE, |geometry| {
            // SAFETY: the buffers live in `mesh`, which this scene keeps; they are not changed any
            // more; the vertex buffer is padded by one vertex; indices were checked.
            unsafe {
                let still = std::slice::from_ref(&mesh.vertices);
                let keys = if mesh.moves() { &mesh.keys } else { still };
                sys::rtcSetGeometryTimeStepCount(geometry, keys.len() as u32);
                for (step, vertices) in (0..).zip(keys) {
                    sys::rtcSetSharedGeometryBuffer(
                        geometry,
                        sys::RTC_BUFFER_TYPE_VERTEX,
                        step,
                        sys::RTC_FORMAT_FLOAT3,
                        vertices.as_ptr().cast(),
                        0,
                        size_of::<[f32; 3]>(),
                        mesh.vertices().len(),
                    );
                }
                sys::rtcSetSharedGeometryBuffer(
                    geometry,
                    sys::RTC_BUFFER_TYPE_INDEX,
                    0,
                    sys::RTC_FORMAT_UINT3,
                    mesh.triangles.as_ptr().cast(),
                    0,
                    size_of::<[u32; 3]>(),
                    mesh.triangles.len(),
                );
                sys::rtcSetGeometryEnableFilterFunctionFromArguments(geometry, filtered);
                sys::rtcSetGeometryMask(geometry, mask);
            }
            Ok(())
        })?;
        self.handle.meshes.push(mesh.clone());
        Ok(id)
    }

    /// Adds spheres (centre and radius); their hits are put before the filters of queries.
    ///
    /// # Errors
    /// If Embree refuses them or memory is short.
    pub fn add_spheres(&mut self, spheres: &[[f32; 4]]) -> Result<u32, EmbreeError> {
        self.attach(sys::RTC_GEOMETRY_TYPE_SPHERE_POINT, |geometry| {
            // SAFETY: Embree returns an own buffer of that many elements, or null.
            unsafe {
                let buffer = sys::rtcSetNewGeometryBuffer(
                    geometry,
                    sys::RTC_BUFFER_TYPE_VERTEX,
                    0,
                    sys::RTC_FORMAT_FLOAT4,
                    size_of::<[f32; 4]>(),
                    spheres.len(),
                );
                if buffer.is_null() {
                    return Err(EmbreeError("not enough memory for the spheres".into()));
                }
                std::ptr::copy_nonoverlapping(spheres.as_ptr(), buffer.cast(), spheres.len());
                sys::rtcSetGeometryEnableFilterFunctionFromArguments(geometry, true);
                sys::rtcSetGeometryMask(geometry, u32::MAX);
            }
            Ok(())
        })
    }

    /// Places a committed scene. The transform is column-major 3×4 (three axes, then the
    /// translation). `mask`: see [`Ray::mask`]; what is in the child must have it too.
    ///
    /// # Errors
    /// If Embree refuses it or memory is short.
    pub fn add_instance(
        &mut self,
        child: &CommittedScene,
        columns: &[[f32; 3]; 4],
        mask: u32,
    ) -> Result<u32, EmbreeError> {
        let id = self.attach(sys::RTC_GEOMETRY_TYPE_INSTANCE, |geometry| {
            // SAFETY: the child scene is alive and kept by this scene; the transform is copied.
            unsafe {
                sys::rtcSetGeometryInstancedScene(geometry, child.handle.raw);
                sys::rtcSetGeometryTransform(
                    geometry,
                    0,
                    sys::RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                    columns.as_ptr().cast(),
                );
                sys::rtcSetGeometryMask(geometry, mask);
            }
            Ok(())
        })?;
        self.handle.children.push(child.clone());
        Ok(id)
    }

    /// Places a committed scene at equal steps of time, the first at 0 and the last at 1. `mask`: see [`Ray::mask`].
    ///
    /// # Errors
    /// If Embree refuses it, memory is short, or there are more steps than it takes.
    pub fn add_moving_instance(
        &mut self,
        child: &CommittedScene,
        steps: &[DecomposedTransform],
        mask: u32,
    ) -> Result<u32, EmbreeError> {
        check_steps(steps.len())?;
        let id = self.attach(sys::RTC_GEOMETRY_TYPE_INSTANCE, |geometry| {
            // SAFETY: the child scene is alive and kept by this scene; the transforms are copied.
            unsafe {
                sys::rtcSetGeometryInstancedScene(geometry, child.handle.raw);
                sys::rtcSetGeometryTimeStepCount(geometry, steps.len() as u32);
                for (number, step) in (0..).zip(steps) {
                    let step = step.to_embree();
                    sys::rtcSetGeometryTransformQuaternion(geometry, number, &step);
                }
                sys::rtcSetGeometryMask(geometry, mask);
            }
            Ok(())
        })?;
        self.handle.children.push(child.clone());
        Ok(id)
    }

    /// Builds the hierarchy.
    ///
    /// # Errors
    /// If memory is short.
    pub fn commit(self) -> Result<CommittedScene, EmbreeError> {
        // SAFETY: the scene is alive and not shared.
        unsafe { sys::rtcCommitScene(self.handle.raw) };
        self.committed()
    }

    /// What has been built, unless that failed.
    fn committed(self) -> Result<CommittedScene, EmbreeError> {
        take_error()?;
        Ok(CommittedScene {
            handle: Arc::new(self.handle),
        })
    }
}

impl CommittedScene {
    /// The placement of an instance at a time, as [`Scene::add_instance`] takes it: what Embree itself interpolates.
    pub fn transform_at(&self, instance: u32, time: f32) -> [[f32; 3]; 4] {
        let mut columns = [[0f32; 3]; 4];
        // SAFETY: committed scene; Embree checks the number of the geometry and writes twelve floats.
        unsafe {
            sys::rtcGetGeometryTransformFromScene(
                self.handle.raw,
                instance,
                time,
                sys::RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                columns.as_mut_ptr().cast(),
            );
        }
        columns
    }

    /// The nearest hit.
    #[inline]
    pub fn intersect(&self, r: &Ray) -> Option<Hit> {
        let mut query = ray_hit(r);
        // SAFETY: committed scene, initialised ray, no arguments needed.
        unsafe { sys::rtcIntersect1(self.handle.raw, &mut query, std::ptr::null_mut()) };
        read_hit(&query)
    }

    /// The nearest hit that the filter accepts. The filter is asked for geometries that were
    /// added as filtered, in no particular order, perhaps more than once for the same hit.
    #[inline]
    pub fn intersect_filtered<F: FnMut(&Hit) -> bool>(
        &self,
        r: &Ray,
        mut filter: F,
    ) -> Option<Hit> {
        let mut query = ray_hit(r);
        // Without INVOKE_ARGUMENT_FILTER only the geometries that were added as filtered ask.
        self.filtered(&mut query, &mut filter, 0);
        read_hit(&query)
    }

    /// The same, asking for all geometries. Of several hits at the nearest distance Embree then keeps the last that it asks about, and
    /// without a filter the first.
    #[inline(never)]
    pub fn intersect_asking<F: FnMut(&Hit) -> bool>(&self, r: &Ray, mut filter: F) -> Option<Hit> {
        let mut query = ray_hit(r);
        self.filtered(
            &mut query,
            &mut filter,
            sys::RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER,
        );
        read_hit(&query)
    }

    /// Tells of all surfaces along a ray, in no particular order, perhaps more than once of the same.
    pub fn visit(&self, r: &Ray, mut visit: impl FnMut(&Hit)) {
        self.intersect_asking(r, |hit| {
            visit(hit);
            false
        });
    }

    #[inline]
    fn filtered<F: FnMut(&Hit) -> bool>(
        &self,
        query: &mut sys::RTCRayHit,
        filter: &mut F,
        flags: sys::RTCRayQueryFlags,
    ) {
        let mut context = FilterContext::new(filter);
        let mut args = sys::RTCIntersectArguments {
            flags: sys::RTC_RAY_QUERY_FLAG_INCOHERENT | flags,
            feature_mask: sys::RTC_FEATURE_FLAG_ALL,
            context: (&raw mut context).cast(),
            filter: Some(filter_trampoline::<F>),
            intersect: None,
        };
        // SAFETY: committed scene, initialised ray; the context outlives the call and has the type of the trampoline.
        unsafe { sys::rtcIntersect1(self.handle.raw, query, &mut args) };
    }

    /// Whether anything is hit.
    #[inline]
    pub fn occluded(&self, r: &Ray) -> bool {
        let mut query = ray(r);
        // SAFETY: committed scene, initialised ray, no arguments needed.
        unsafe { sys::rtcOccluded1(self.handle.raw, &mut query, std::ptr::null_mut()) };
        query.tfar == f32::NEG_INFINITY
    }

    /// Whether anything is hit that the filter accepts (see [`Self::intersect_filtered`]).
    #[inline]
    pub fn occluded_filtered<F: FnMut(&Hit) -> bool>(&self, r: &Ray, mut filter: F) -> bool {
        // Without INVOKE_ARGUMENT_FILTER only the geometries that were added as filtered ask.
        self.is_shut(r, &mut filter, 0)
    }

    /// The same, asking for all geometries.
    pub fn occluded_asking<F: FnMut(&Hit) -> bool>(&self, r: &Ray, mut filter: F) -> bool {
        self.is_shut(
            r,
            &mut filter,
            sys::RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER,
        )
    }

    #[inline]
    fn is_shut<F: FnMut(&Hit) -> bool>(
        &self,
        r: &Ray,
        filter: &mut F,
        flags: sys::RTCRayQueryFlags,
    ) -> bool {
        let mut query = ray(r);
        let mut context = FilterContext::new(filter);
        let mut args = sys::RTCOccludedArguments {
            flags: sys::RTC_RAY_QUERY_FLAG_INCOHERENT | flags,
            feature_mask: sys::RTC_FEATURE_FLAG_ALL,
            context: (&raw mut context).cast(),
            filter: Some(filter_trampoline::<F>),
            occluded: None,
        };
        // SAFETY: as above.
        unsafe { sys::rtcOccluded1(self.handle.raw, &mut query, &mut args) };
        query.tfar == f32::NEG_INFINITY
    }
}

#[cfg(test)]
#[path = "../../tests/unit/ffi/embree.rs"]
mod tests;
