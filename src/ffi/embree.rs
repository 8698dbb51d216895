//! Embree 4: devices, scenes, triangle meshes, spheres, instances, and the queries on them.
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

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::size_of;
use std::sync::{Arc, Mutex, PoisonError};

/// "No geometry" and "no instance" in Embree's structures.
const INVALID: u32 = u32::MAX;

/// What Embree said went wrong.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct EmbreeError(pub String);

thread_local! {
    /// Filled by the error callback, which Embree calls on the thread whose call failed (Embree manual, rtcSetDeviceErrorFunction);
    /// the first message wins because the rest follow from it. Devices are shared, so that a slot of each would mix up scenes.
    static ERROR: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// The error that the callback has kept on this thread, if any; forgets it.
fn take_error() -> Result<(), EmbreeError> {
    ERROR
        .take()
        .map_or(Ok(()), |message| Err(EmbreeError(message)))
}

/// Instructions by which Embree chooses its code. What it finds differs in the last bits from set to set (measured: relMSE up to
/// 5e-9 between AVX-512 and AVX2, 4e-6 between either and SSE4.2), so that it is told which to take: one that most machines have,
/// never the best of the machine at hand. (AVX-512 is not measurably faster here.)
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
pub enum InstructionSet {
    /// Of processors since 2008.
    #[serde(rename = "sse4.2")]
    Sse42,
    /// With FMA, BMI and F16C, as processors since 2013 have it.
    #[serde(rename = "avx2")]
    Avx2,
}

impl InstructionSet {
    /// All that there are, the default first.
    pub const ALL: [Self; 2] = [Self::Avx2, Self::Sse42];

    /// As Embree and people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sse42 => "sse4.2",
            Self::Avx2 => "avx2",
        }
    }

    /// The set of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|set| set.name() == name)
    }

    /// Whether this processor has it. Embree does not ask where it is told what to take: it would die of an unknown instruction.
    #[cfg(target_arch = "x86_64")]
    pub fn is_here(self) -> bool {
        let sse = is_x86_feature_detected!("sse4.2") && is_x86_feature_detected!("popcnt");
        match self {
            Self::Sse42 => sse,
            // What Embree compiles its AVX2 code with (`common/sys/sysinfo.h`; clang's -mf16c -mavx2 -mfma -mlzcnt -mbmi -mbmi2).
            Self::Avx2 => {
                sse && is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("f16c")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
            }
        }
    }

    /// Whether this processor has it.
    #[cfg(not(target_arch = "x86_64"))]
    pub fn is_here(self) -> bool {
        false
    }

    /// The one to take if nobody asks for another.
    ///
    /// # Errors
    /// If the processor has none.
    pub fn default_here() -> Result<Self, EmbreeError> {
        Self::ALL
            .into_iter()
            .find(|set| set.is_here())
            .ok_or_else(|| {
                EmbreeError(
                    "this processor has neither AVX2 nor SSE4.2; use one that has (all since 2011)"
                        .into(),
                )
            })
    }

    /// What shall be taken here: what is asked for, if anything is.
    ///
    /// # Errors
    /// If the processor lacks it.
    pub fn or_default(asked: Option<Self>) -> Result<Self, EmbreeError> {
        let Some(asked) = asked else {
            return Self::default_here();
        };
        if asked.is_here() {
            return Ok(asked);
        }
        let others: Vec<_> = Self::ALL
            .into_iter()
            .filter(|set| set.is_here())
            .map(Self::name)
            .collect();
        Err(EmbreeError(format!(
            "this processor lacks the instruction set {}; ask for {} on every machine that shares the picture",
            asked.name(),
            if others.is_empty() {
                "one that it has".into()
            } else {
                others.join(" or ")
            }
        )))
    }
}

impl std::fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

struct DeviceHandle {
    raw: sys::RTCDevice,
    instructions: InstructionSet,
}

// SAFETY: Embree's API is thread-safe for devices (Embree manual, "Embree API").
unsafe impl Send for DeviceHandle {}
// SAFETY: as above.
unsafe impl Sync for DeviceHandle {}

impl Drop for DeviceHandle {
    fn drop(&mut self) {
        // SAFETY: `raw` came from rtcNewDevice and is released once; scenes hold an Arc of this.
        unsafe { sys::rtcReleaseDevice(self.raw) }
    }
}

/// Embree's device: threads, instruction set, memory.
#[derive(Clone)]
pub struct Device(Arc<DeviceHandle>);

/// Version of the library that is loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// Incompatible changes.
    pub major: u32,
    /// New features.
    pub minor: u32,
    /// Corrections.
    pub patch: u32,
}

impl std::fmt::Display for Version {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// Version of the headers that the bindings were made from.
pub const HEADERS: Version = Version {
    major: sys::RTC_VERSION_MAJOR,
    minor: sys::RTC_VERSION_MINOR,
    patch: sys::RTC_VERSION_PATCH,
};

extern "C" fn remember_error(_user: *mut c_void, code: sys::RTCError, message: *const c_char) {
    let text = if code == sys::RTC_ERROR_OUT_OF_MEMORY {
        String::from("there is not enough memory for the scene")
    } else if message.is_null() {
        String::from("unknown error")
    } else {
        // SAFETY: Embree passes a NUL-terminated string that lives during the call.
        unsafe { CStr::from_ptr(message) }
            .to_string_lossy()
            .into_owned()
    };
    ERROR.with_borrow_mut(|slot| {
        slot.get_or_insert(text);
    });
}

/// The devices that there are, by their numbers of threads and instructions: never released, see [`Device::new`].
static DEVICES: Mutex<Vec<(Option<usize>, Device)>> = Mutex::new(Vec::new());

impl Device {
    /// The process's device for so many threads. `threads` bounds the threads that build (`None`: all). `instructions`: those
    /// that are asked for, if any are.
    ///
    /// It is opened once and never released. Embree limits the threads of oneTBB anew with each device that comes or goes, for
    /// which oneTBB 2021.12 takes hold of its scheduler without a lock (`threading_control::set_active_num_workers`): where the
    /// last user of the scheduler leaves at that moment, it is freed twice. A small program that opens and releases devices in
    /// two threads while others build died of that within two seconds, 6 times of 6, and never (6 runs) with a device that is
    /// kept and whose arena has been entered: the scheduler lives as long as that.
    ///
    /// # Errors
    /// If the processor is not supported, memory is short, or the loaded library does not fit the
    /// headers of the build ([`Device::verify`]).
    pub fn new(
        threads: Option<usize>,
        instructions: Option<InstructionSet>,
    ) -> Result<Self, EmbreeError> {
        let instructions = InstructionSet::or_default(instructions)?;
        let mut devices = DEVICES.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |(of, device): &&(Option<usize>, Device)| {
            *of == threads && device.instructions() == instructions
        };
        if let Some((_, device)) = devices.iter().find(same) {
            return Ok(device.clone());
        }
        let device = Self::open(threads, instructions)?;
        device.verify()?;
        devices.push((threads, device.clone()));
        Ok(device)
    }

    fn open(threads: Option<usize>, instructions: InstructionSet) -> Result<Self, EmbreeError> {
        // Other settings of a device change no bits, or (the kinds of hierarchies) follow from the instructions and the scene.
        let mut config = format!("isa={instructions}");
        if let Some(threads) = threads {
            config += &format!(",threads={threads}");
        }
        let config = CString::new(config).map_err(|e| EmbreeError(e.to_string()))?;
        // SAFETY: `config` is NUL-terminated and read during the call only.
        let raw = unsafe { sys::rtcNewDevice(config.as_ptr()) };
        if raw.is_null() {
            // SAFETY: without a device it gives this thread's last error.
            let code = unsafe { sys::rtcGetDeviceError(std::ptr::null_mut()) };
            return Err(EmbreeError(match code {
                sys::RTC_ERROR_OUT_OF_MEMORY => "there is not enough memory to begin with".into(),
                sys::RTC_ERROR_UNSUPPORTED_CPU => {
                    "this processor lacks the instructions that it needs (SSE2 at least)".into()
                }
                code => format!(
                    "no device could be opened (error {code}): memory, threads or the address space of the process (ulimit -v) may be used up"
                ),
            }));
        }
        // SAFETY: the device is alive; the callback needs nothing that could go away.
        unsafe { sys::rtcSetDeviceErrorFunction(raw, Some(remember_error), std::ptr::null_mut()) };
        Ok(Self(Arc::new(DeviceHandle { raw, instructions })))
    }

    /// The instructions that it takes.
    pub fn instructions(&self) -> InstructionSet {
        self.0.instructions
    }

    /// The version of the loaded library.
    pub fn version(&self) -> Version {
        let property = |id| {
            // SAFETY: the device is alive; unknown properties return 0.
            unsafe { sys::rtcGetDeviceProperty(self.0.raw, id) as u32 }
        };
        Version {
            major: property(sys::RTC_DEVICE_PROPERTY_VERSION_MAJOR),
            minor: property(sys::RTC_DEVICE_PROPERTY_VERSION_MINOR),
            patch: property(sys::RTC_DEVICE_PROPERTY_VERSION_PATCH),
        }
    }

    /// Checks that the loaded library fits the bindings: the version, and by a traced ray that it
    /// writes its results where the bindings read them and not a byte behind them. (A binding to
    /// Embree 4.2's structures fails exactly here: 4.3 made them 16 bytes longer.)
    fn verify(&self) -> Result<(), EmbreeError> {
        let version = self.version();
        if version.major != HEADERS.major
            || version
                < (Version {
                    patch: 0,
                    ..HEADERS
                })
        {
            return Err(EmbreeError(format!(
                "the loaded library is Embree {version}, but this program was built for {HEADERS} or newer of the same major version"
            )));
        }
        // SAFETY: as in `version`.
        let has = |id| unsafe { sys::rtcGetDeviceProperty(self.0.raw, id) } != 0;
        // A library that was built without a set takes a lesser one without a word: bits would differ unseen. (How many rays
        // at once are native tells them apart: eight with AVX, sixteen with AVX-512.)
        let wide = has(sys::RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED);
        let instructions = self.instructions();
        if wide != (instructions == InstructionSet::Avx2)
            || has(sys::RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)
        {
            return Err(EmbreeError(format!(
                "the loaded Embree {version} does not take the instruction set {instructions} that it is told to: it was built without, or a configuration file of its own says otherwise"
            )));
        }
        if !has(sys::RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) {
            return Err(EmbreeError(format!(
                "the loaded Embree {version} was built without ray masks (EMBREE_RAY_MASK), which ray visibility needs"
            )));
        }
        let mesh = TriangleMesh::new(
            vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
            vec![[0, 1, 2]],
        )?;
        let mut scene = Scene::new(self, true)?;
        scene.add_triangles(&Arc::new(mesh), false, u32::MAX)?;
        // This build enters the device's arena (which rtcCommitScene does not): see `new`.
        // SAFETY: the scene is alive and not shared.
        unsafe { sys::rtcJoinCommitScene(scene.handle.raw) };
        let scene = scene.committed()?;
        #[repr(C)]
        struct Guarded {
            ray_hit: sys::RTCRayHit,
            guard: [u8; 64],
        }
        let ray = Ray {
            origin: [0.25, 0.5, 0.0],
            direction: [0.0, 0.0, 1.0],
            near: 0.0,
            far: f32::INFINITY,
            mask: u32::MAX,
        };
        let mut guarded = Guarded {
            ray_hit: ray_hit(&ray),
            guard: [0xa5; 64],
        };
        // SAFETY: the scene is committed; `ray_hit` is aligned and initialised; no arguments.
        unsafe { sys::rtcIntersect1(scene.handle.raw, &mut guarded.ray_hit, std::ptr::null_mut()) };
        let hit = read_hit(&guarded.ray_hit);
        let fits = guarded.guard == [0xa5; 64]
            && hit.is_some_and(|h| {
                (h.distance - 1.0).abs() < 1e-5
                    && (h.u - 0.25).abs() < 1e-5
                    && (h.v - 0.5).abs() < 1e-5
                    && (h.geometry, h.primitive, h.instance) == (0, 0, None)
            });
        if !fits {
            return Err(EmbreeError(format!(
                "the loaded Embree {version} lays out its structures unlike the headers {HEADERS} of the build"
            )));
        }
        take_error()
    }
}

/// Vertices and corner indices in the layout that Embree reads in place.
pub struct TriangleMesh {
    /// One more than there are: Embree reads 16 bytes at each vertex.
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Takes the buffers over.
    ///
    /// # Errors
    /// If an index is out of range: Embree would read outside the buffer.
    pub fn new(mut vertices: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, EmbreeError> {
        let count = vertices.len();
        if triangles.iter().flatten().any(|&i| i as usize >= count) {
            return Err(EmbreeError(format!(
                "a triangle refers to a vertex beyond the {count} that there are"
            )));
        }
        vertices.push([0.0; 3]);
        Ok(Self {
            vertices,
            triangles,
        })
    }

    /// The vertices.
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices[..self.vertices.len() - 1]
    }

    /// The corner indices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The three corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [[f32; 3]; 3] {
        self.triangles[triangle as usize].map(|i| self.vertices[i as usize])
    }
}

struct SceneHandle {
    raw: sys::RTCScene,
    device: Device,
    meshes: Vec<Arc<TriangleMesh>>,
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
}

/// A hit.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

impl Hit {
    /// Number of the object: of the geometry in the top scene.
    #[inline]
    pub fn object(&self) -> u32 {
        self.instance.unwrap_or(self.geometry)
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
        time: 0.0,
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
                sys::rtcSetSharedGeometryBuffer(
                    geometry,
                    sys::RTC_BUFFER_TYPE_VERTEX,
                    0,
                    sys::RTC_FORMAT_FLOAT3,
                    mesh.vertices.as_ptr().cast(),
                    0,
                    size_of::<[f32; 3]>(),
                    mesh.vertices().len(),
                );
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

    /// Tells of all surfaces along a ray, in no particular order, perhaps more than once of the same.
    pub fn visit(&self, r: &Ray, mut visit: impl FnMut(&Hit)) {
        let mut query = ray_hit(r);
        let mut filter = |hit: &Hit| {
            visit(hit);
            false
        };
        self.filtered(
            &mut query,
            &mut filter,
            sys::RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER,
        );
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
        let mut query = ray(r);
        let mut context = FilterContext::new(&mut filter);
        let mut args = sys::RTCOccludedArguments {
            // Without INVOKE_ARGUMENT_FILTER only the geometries that were added as filtered ask.
            flags: sys::RTC_RAY_QUERY_FLAG_INCOHERENT,
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
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    fn quad(z: f32) -> Arc<TriangleMesh> {
        Arc::new(
            TriangleMesh::new(
                vec![
                    [-1.0, -1.0, z],
                    [1.0, -1.0, z],
                    [1.0, 1.0, z],
                    [-1.0, 1.0, z],
                ],
                vec![[0, 1, 2], [0, 2, 3]],
            )
            .unwrap(),
        )
    }

    fn down(x: f32, y: f32) -> Ray {
        Ray {
            origin: [x, y, 10.0],
            direction: [0.0, 0.0, -1.0],
            near: 0.0,
            far: f32::INFINITY,
            mask: u32::MAX,
        }
    }

    #[test]
    fn the_library_fits_the_headers() {
        let device = Device::new(None, None).unwrap();
        assert!(
            device.version()
                >= Version {
                    major: 4,
                    minor: 3,
                    patch: 0
                }
        );
        assert_eq!(size_of::<sys::RTCRayHit>(), 96);
    }

    /// See [`Device::new`]: no device comes or goes meanwhile.
    #[test]
    fn devices_may_be_asked_for_while_others_build() {
        let device = Device::new(Some(2), None).unwrap();
        let stop = AtomicBool::new(false);
        std::thread::scope(|scope| {
            for threads in [Some(1), None] {
                let stop = &stop;
                scope.spawn(move || {
                    while !stop.load(Ordering::Relaxed) {
                        drop(Device::new(threads, None).unwrap());
                        std::thread::yield_now();
                    }
                });
            }
            // oneTBB's scheduler is held by threads that have used it: these come and go.
            for _ in 0..4000 {
                scope
                    .spawn(|| Scene::new(&device, true).unwrap().commit().unwrap())
                    .join()
                    .unwrap();
            }
            stop.store(true, Ordering::Relaxed);
        });
        let same = |a: &Device, b: &Device| Arc::ptr_eq(&a.0, &b.0);
        assert!(same(&device, &Device::new(Some(2), None).unwrap()));
        assert!(!same(&device, &Device::new(Some(1), None).unwrap()));
    }

    #[test]
    fn errors_stay_with_the_thread_that_made_them() {
        let device = Device::new(Some(1), None).unwrap();
        // SAFETY: the device is alive; it refuses to change what can only be read.
        unsafe { sys::rtcSetDeviceProperty(device.0.raw, sys::RTC_DEVICE_PROPERTY_VERSION, 1) };
        std::thread::scope(|scope| {
            scope.spawn(|| take_error().unwrap()).join().unwrap();
        });
        assert!(take_error().is_err());
        assert!(take_error().is_ok());
    }

    #[test]
    fn a_broken_index_is_refused() {
        assert!(TriangleMesh::new(vec![[0.0; 3]; 3], vec![[0, 1, 3]]).is_err());
    }

    #[test]
    fn hits_name_geometry_triangle_and_barycentrics() {
        let device = Device::new(Some(1), None).unwrap();
        let mut scene = Scene::new(&device, true).unwrap();
        assert_eq!(scene.add_triangles(&quad(0.0), false, u32::MAX).unwrap(), 0);
        assert_eq!(scene.add_triangles(&quad(2.0), false, u32::MAX).unwrap(), 1);
        let scene = scene.commit().unwrap();
        let hit = scene.intersect(&down(0.5, -0.25)).unwrap();
        assert_eq!((hit.geometry, hit.primitive, hit.instance), (1, 0, None));
        assert!((hit.distance - 8.0).abs() < 1e-5);
        let w = 1.0 - hit.u - hit.v;
        // Corners (-1,-1), (1,-1), (1,1).
        assert!(
            (-w + hit.u + hit.v - 0.5).abs() < 1e-6 && (-w - hit.u + hit.v + 0.25).abs() < 1e-6
        );
        assert!(scene.intersect(&down(1.5, 0.0)).is_none());
        assert!(scene.occluded(&down(0.5, 0.5)));
        assert!(!scene.occluded(&Ray {
            far: 7.9,
            ..down(0.5, 0.5)
        }));
    }

    #[test]
    fn filters_let_rays_through() {
        let device = Device::new(Some(1), None).unwrap();
        let mut scene = Scene::new(&device, true).unwrap();
        scene.add_triangles(&quad(0.0), false, u32::MAX).unwrap();
        scene.add_triangles(&quad(2.0), true, u32::MAX).unwrap();
        scene.add_triangles(&quad(4.0), true, u32::MAX).unwrap();
        let scene = scene.commit().unwrap();
        let hit = scene
            .intersect_filtered(&down(0.5, 0.1), |h| h.geometry == 1)
            .unwrap();
        assert_eq!(hit.geometry, 1);
        let mut asked = Vec::new();
        let hit = scene
            .intersect_filtered(&down(0.5, 0.1), |h| {
                asked.push(h.geometry);
                false
            })
            .unwrap();
        assert_eq!(hit.geometry, 0, "the unfiltered geometry is always hit");
        asked.sort_unstable();
        assert_eq!(asked, [1, 2]);
        let mut seen = 0;
        assert!(!scene.occluded_filtered(
            &Ray {
                far: 9.0,
                ..down(0.5, 0.1)
            },
            |_| {
                seen += 1;
                false
            }
        ));
        assert_eq!(seen, 2);
    }

    #[test]
    fn instances_are_placed_and_named() {
        let device = Device::new(Some(2), None).unwrap();
        let mut child = Scene::new(&device, true).unwrap();
        child.add_triangles(&quad(0.0), false, u32::MAX).unwrap();
        let child = child.commit().unwrap();
        let mut top = Scene::new(&device, true).unwrap();
        for x in [0.0, 10.0] {
            top.add_instance(
                &child,
                &[
                    [2.0, 0.0, 0.0],
                    [0.0, 2.0, 0.0],
                    [0.0, 0.0, 2.0],
                    [x, 0.0, 1.0],
                ],
                u32::MAX,
            )
            .unwrap();
        }
        let top = top.commit().unwrap();
        drop(child);
        let hit = top.intersect(&down(11.5, 1.5)).unwrap();
        assert_eq!((hit.geometry, hit.instance), (0, Some(1)));
        assert!((hit.distance - 9.0).abs() < 1e-5);
    }

    #[test]
    fn masks_hide_geometries_and_instances() {
        let device = Device::new(Some(1), None).unwrap();
        let mut child = Scene::new(&device, true).unwrap();
        child.add_triangles(&quad(0.0), false, u32::MAX).unwrap();
        let child = child.commit().unwrap();
        let mut top = Scene::new(&device, true).unwrap();
        top.add_triangles(&quad(4.0), false, 1).unwrap();
        let identity = [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0],
        ];
        top.add_instance(&child, &identity, 2).unwrap();
        let top = top.commit().unwrap();
        let nearest = |mask| {
            let ray = Ray {
                mask,
                ..down(0.5, 0.1)
            };
            let hit = top.intersect(&ray);
            assert_eq!(top.occluded(&ray), hit.is_some());
            hit.map(|h| h.distance.round())
        };
        assert_eq!(
            [nearest(1), nearest(2), nearest(3), nearest(4)],
            [Some(6.0), Some(10.0), Some(6.0), None]
        );
    }

    #[test]
    fn spheres_are_hit_and_filtered() {
        let device = Device::new(Some(1), None).unwrap();
        let mut scene = Scene::new(&device, true).unwrap();
        scene
            .add_spheres(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 5.0, 0.5]])
            .unwrap();
        let scene = scene.commit().unwrap();
        let mut seen = Vec::new();
        scene.intersect_filtered(&down(0.1, 0.1), |h| {
            seen.push(h.primitive);
            false
        });
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen, [0, 1]);
    }
}
