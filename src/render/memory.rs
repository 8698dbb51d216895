//! How much memory a render takes, and how much there is: by the machine, by the limits of the process, by its control group.

use super::RenderSettings;
use super::tile::{Kept, shown};
use crate::math::words;
use crate::scene::{Aov, Scene};
use rustix::process::{Resource, getrlimit};
use std::path::{Path, PathBuf};

/// There is less memory than is needed: one sentence.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct NotEnoughMemory(String);

/// What a render took beyond the scene itself: 285 bytes a triangle in a scene of 262 510 triangles (with
/// many small meshes), 182 in one of 142 973.
pub const PREPARED_BYTES_A_TRIANGLE: u64 = 300;

/// Bytes that a pixel takes: its sums, and its floats in the finished picture and, for a moment, in the writer.
fn bytes_a_pixel(settings: &RenderSettings, scene: &Scene) -> u64 {
    let estimate = 6 * size_of::<f32>();
    let own = 3 * scene.light_groups.len() + Aov::floats(shown(settings.passes, &scene.aovs));
    let floats = 2 * size_of::<f32>() * (settings.passes.floats() + own);
    let kept = Kept::of_render(settings, scene);
    (kept.bytes_a_pixel() + estimate + floats) as u64
}

/// Refuses a picture of a scene for which there is not enough memory, where the system says how much there is. (The scene
/// itself has been loaded already.)
///
/// # Errors
/// There is less.
pub fn check_render(settings: &RenderSettings, scene: &Scene) -> Result<(), NotEnoughMemory> {
    let (width, height) = (settings.region().width(), settings.region().height());
    let triangles = scene.meshes.iter().map(|mesh| mesh.triangles.len() as u64);
    let prepared = triangles.sum::<u64>() * PREPARED_BYTES_A_TRIANGLE;
    let picture = u64::from(width) * u64::from(height) * bytes_a_pixel(settings, scene);
    let what = if picture >= prepared {
        format!("a picture of {width} × {height} pixels")
    } else {
        format!("a picture of {width} × {height} pixels of this scene")
    };
    let way_out = if picture >= prepared {
        "choose a smaller --width and --height"
    } else {
        "make the scene simpler, or allow more"
    };
    check(picture + prepared, &what, way_out)
}

/// Who says how much may be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bound {
    Machine,
    AddressSpace,
    Data,
    Group,
}

/// Bytes that may still be taken, by whom allows the least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    bytes: u64,
    bound: Bound,
}

impl std::fmt::Display for Room {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let bytes = words::bytes(self.bytes);
        match self.bound {
            Bound::Machine => write!(f, "{bytes} are free"),
            Bound::AddressSpace => {
                write!(f, "the limit of the process (ulimit -v) leaves {bytes}")
            }
            Bound::Data => write!(f, "the limit of the process (ulimit -d) leaves {bytes}"),
            Bound::Group => write!(
                f,
                "the memory limit of its control group (container) leaves {bytes}"
            ),
        }
    }
}

/// Refuses what needs more than there is, where the system says how much that is. `what` needs it; `way_out` is what to do.
///
/// # Errors
/// There is less.
pub fn check(needed: u64, what: &str, way_out: &str) -> Result<(), NotEnoughMemory> {
    match room() {
        Some(room) if needed > room.bytes => Err(NotEnoughMemory(format!(
            "{what} needs about {}, and {room}; {way_out}",
            words::bytes(needed),
        ))),
        _ => Ok(()),
    }
}

/// Bytes that may still be taken, as far as the system says.
pub fn free() -> u64 {
    room().map_or(u64::MAX, |room| room.bytes)
}

/// What Linux tells; none elsewhere.
fn room() -> Option<Room> {
    let root = Path::new("/");
    let machine = number_after(&root.join("proc/meminfo"), "MemAvailable:").map(|kib| kib * 1024);
    let status = root.join("proc/self/status");
    let left = |resource: Resource, used: &str| {
        let used = number_after(&status, used)? * 1024;
        Some(getrlimit(resource).current?.saturating_sub(used))
    };
    let bounds = [
        (machine, Bound::Machine),
        (left(Resource::As, "VmSize:"), Bound::AddressSpace),
        (left(Resource::Data, "VmData:"), Bound::Data),
        (group(root), Bound::Group),
    ];
    bounds
        .into_iter()
        .filter_map(|(bytes, bound)| {
            Some(Room {
                bytes: bytes?,
                bound,
            })
        })
        .min_by_key(|room| room.bytes)
}

/// The number in a file of lines that begins so.
fn number_after(path: &Path, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    rest.split_whitespace().next()?.parse().ok()
}

/// What the control group of this process and those around it leave: the least of each limit less what is taken, without
/// the pages of files, which the system takes back. (Both versions: the kernel's admin-guide/cgroup-v2.rst and
/// cgroup-v1/memory.rst.)
fn group(root: &Path) -> Option<u64> {
    let groups = std::fs::read_to_string(root.join("proc/self/cgroup")).ok()?;
    let mounts = std::fs::read_to_string(root.join("proc/self/mountinfo")).ok()?;
    let mut least: Option<u64> = None;
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else {
            continue;
        };
        let names = if controllers.is_empty() {
            [
                "memory.max",
                "memory.current",
                "inactive_file ",
                "active_file ",
            ]
        } else if controllers.split(',').any(|name| name == "memory") {
            [
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
                "total_inactive_file ",
                "total_active_file ",
            ]
        } else {
            continue;
        };
        let Some((top, below)) = mounted(&mounts, controllers.is_empty(), path) else {
            continue;
        };
        let top = root.join(top.trim_start_matches('/'));
        let mut folder = top.join(below.trim_start_matches('/'));
        // (Seen from inside of a container, the path may be that of the host.)
        if !folder.is_dir() {
            folder = top.clone();
        }
        while folder.starts_with(&top) {
            if let Some(left) = left_of(&folder, names) {
                least = Some(least.map_or(left, |least| least.min(left)));
            }
            if !folder.pop() {
                break;
            }
        }
    }
    least
}

/// Where the hierarchy is mounted, and the group's path below that.
fn mounted<'a>(mounts: &'a str, unified: bool, group: &'a str) -> Option<(&'a str, &'a str)> {
    mounts.lines().find_map(|line| {
        let (mount, kind) = line.split_once(" - ")?;
        let mut kind = kind.split(' ');
        let is_it = match kind.next()? {
            "cgroup2" => unified,
            "cgroup" => !unified && kind.nth(1)?.split(',').any(|option| option == "memory"),
            _ => false,
        };
        let mut fields = mount.split(' ').skip(3);
        let (inside, place) = (fields.next()?, fields.next()?);
        let below = group.strip_prefix(inside.trim_end_matches('/'));
        is_it.then(|| (place, below.unwrap_or(group)))
    })
}

/// What one group leaves; none where it has no limit.
fn left_of(folder: &Path, [limit, used, inactive, active]: [&str; 4]) -> Option<u64> {
    let number = |name: &str| -> Option<u64> {
        let text = std::fs::read_to_string(folder.join(name)).ok()?;
        text.trim().parse().ok()
    };
    // "max" is no number; version 1 has a huge one instead, which bounds nothing.
    let limit = number(limit)?;
    let statistics: PathBuf = folder.join("memory.stat");
    let pages = |name| number_after(&statistics, name).unwrap_or(0);
    let used = number(used)?.saturating_sub(pages(inactive) + pages(active));
    Some(limit.saturating_sub(used))
}

#[cfg(test)]
#[path = "../../tests/unit/render/memory.rs"]
mod tests;
