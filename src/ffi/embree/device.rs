//! Devices of Embree: which instructions they take, and whether the loaded library is the one of the headers.

use super::{Ray, Scene, TriangleMesh, ray_hit, read_hit, sys};
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_void};
use std::sync::{Arc, Mutex, PoisonError};

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
pub(super) fn take_error() -> Result<(), EmbreeError> {
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

pub(super) struct DeviceHandle {
    pub(super) raw: sys::RTCDevice,
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
pub struct Device(pub(super) Arc<DeviceHandle>);

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
            time: 0.0,
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
