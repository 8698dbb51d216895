//! How much memory an input may ask for: in proportion to its own size, so that a small file cannot
//! claim a large one's memory.

use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes that may still be allocated for what a file contains; shared between threads.
#[derive(Debug)]
pub(crate) struct Budget {
    left: AtomicU64,
    total: u64,
}

/// Any file may ask for this much geometry (zero-filled accessors take no bytes in a file).
const FREE_GEOMETRY: u64 = 64 << 20;
/// Any composed stage may ask for this much: references and variants place one mesh many times, each with materials of its
/// own, and surfaces are subdivided.
const FREE_COMPOSED: u64 = 2 << 30;
/// Any file may ask for this much in texels: an 8K image of one colour is small in a file.
const FREE_TEXELS: u64 = 512 << 20;
/// Geometry per input byte. The most that an honest file makes of a byte is an index byte that
/// becomes a third of a 12-byte triangle (×4) on vertices of 4 quantised bytes that become 12 for
/// the position, 12 for a normal, 16 for a tangent and 8 for each UV set (×12), each split once for
/// the tangents (×3); the rest is for accessors that several primitives share.
const GEOMETRY_PER_BYTE: u64 = 256;
/// Geometry per byte of a Draco or meshopt stream. The most that honest ones make of a byte is two triangles of Draco
/// (half a byte each): 160 bytes each while they are decoded, 24 as indices, 180 where tangents split their corners, and
/// half a vertex of at most 200 bytes (×2 × 464).
const GEOMETRY_PER_PACKED_BYTE: u64 = 1024;
/// Deflate, inside PNG, EXR and WebP's sibling formats, makes at most 1032 bytes of one.
const TEXELS_PER_BYTE: u64 = 1100;

impl Budget {
    /// For the geometry of a file with so many bytes in its buffers, of which some are compressed.
    pub(crate) fn for_geometry(input_bytes: usize, packed_bytes: u64) -> Self {
        let packed = packed_bytes.min(input_bytes as u64);
        let plain = input_bytes as u64 - packed;
        Self::new(
            FREE_GEOMETRY
                .saturating_add(GEOMETRY_PER_BYTE.saturating_mul(plain))
                .saturating_add(GEOMETRY_PER_PACKED_BYTE.saturating_mul(packed)),
        )
    }

    /// For the geometry of a stage composed of layers with so many bytes, whose lists of numbers are compressed.
    pub(crate) fn for_stage(input_bytes: usize) -> Self {
        Self::new(
            FREE_COMPOSED
                .saturating_add(GEOMETRY_PER_PACKED_BYTE.saturating_mul(input_bytes as u64)),
        )
    }

    /// For the images of so many encoded bytes.
    pub(crate) fn for_image(input_bytes: usize) -> Self {
        Self::new(FREE_TEXELS + TEXELS_PER_BYTE.saturating_mul(input_bytes as u64))
    }

    /// For grids of volumes, by what the user or the machine allows.
    pub(crate) fn for_grids(allowed: Option<u64>) -> Self {
        Self::new(allowed.unwrap_or(u64::MAX))
    }

    /// What may still be taken.
    pub(crate) fn left(&self) -> u64 {
        self.left.load(Ordering::Relaxed)
    }

    fn new(total: u64) -> Self {
        Self {
            left: AtomicU64::new(total),
            total,
        }
    }

    /// Takes `count` elements of `size` bytes out of the budget; an error says how much was asked.
    pub(crate) fn take(&self, count: u64, size: usize) -> Result<(), String> {
        let bytes = count.saturating_mul(size as u64);
        let taken = self
            .left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| {
                left.checked_sub(bytes)
            });
        taken.map(|_| ()).map_err(|_| {
            format!(
                "would take {} MiB of memory beside the {} MiB of what was read before, which is out of proportion to the file (at most {} MiB together): it is damaged",
                bytes.div_ceil(1 << 20),
                (self.total - self.left()) >> 20,
                self.total >> 20
            )
        })
    }
}

#[cfg(test)]
#[path = "../../tests/unit/import/budget.rs"]
mod tests;
