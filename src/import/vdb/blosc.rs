//! Blocks that Blosc 1 has packed, as OpenVDB writes them: c-blosc's README_CHUNK_FORMAT.

use std::io::Read;

/// Bytes of the header.
const HEADER: usize = 16;
/// A block is split by bytes of its numbers if each part has so many.
const LEAST_SPLIT: usize = 128;
/// … and if the numbers have no more bytes than this.
const MOST_SPLITS: usize = 16;

fn number(bytes: &[u8], at: usize) -> Result<usize, &'static str> {
    let four = bytes.get(at..at.saturating_add(4)).ok_or(CUT)?;
    let number = four.try_into().map(u32::from_le_bytes);
    number.map(|n| n as usize).map_err(|_| CUT)
}

const CUT: &str = "a packed block ends too early";

/// Unpacks all of `packed` into a buffer, which it has to fill.
pub(super) fn unpack(
    packed: &[u8],
    into: &mut [u8],
    scratch: &mut Vec<u8>,
) -> Result<(), &'static str> {
    let header = packed.get(..HEADER).ok_or(CUT)?;
    let (flags, width) = (header[2], usize::from(header[3]).max(1));
    let (bytes, block) = (number(packed, 4)?, number(packed, 8)?);
    if bytes != into.len() {
        return Err("a packed block has another size than its leaf");
    }
    if flags & 2 != 0 {
        let plain = packed.get(HEADER..HEADER + bytes).ok_or(CUT)?;
        into.copy_from_slice(plain);
        return Ok(());
    }
    if flags & 4 != 0 && width > 1 {
        return Err("its numbers are shuffled by bits, which OpenVDB does not do");
    }
    if block == 0 {
        return Err("a packed block says that it has no size");
    }
    let shuffled = flags & 1 != 0 && width > 1;
    for (index, part) in into.chunks_mut(block).enumerate() {
        let mut at = number(packed, HEADER + 4 * index)?;
        let is_split = flags & 0x10 == 0
            && width <= MOST_SPLITS
            && part.len() == block
            && block / width >= LEAST_SPLIT
            && block.is_multiple_of(width);
        let pieces = if is_split { width } else { 1 };
        scratch.clear();
        scratch.resize(part.len(), 0);
        let target: &mut [u8] = if shuffled { scratch } else { part };
        let size = target.len() / pieces;
        for piece in target.chunks_mut(size) {
            let packed_size = number(packed, at)?;
            at += 4;
            let data = packed.get(at..at.saturating_add(packed_size)).ok_or(CUT)?;
            at += packed_size;
            if packed_size == piece.len() {
                piece.copy_from_slice(data);
            } else {
                expand(flags >> 5, data, piece)?;
            }
        }
        if shuffled {
            let count = part.len() / width;
            for byte in 0..width {
                for i in 0..count {
                    part[i * width + byte] = scratch[byte * count + i];
                }
            }
            let rest = count * width;
            part[rest..].copy_from_slice(&scratch[rest..]);
        }
    }
    Ok(())
}

fn expand(codec: u8, data: &[u8], into: &mut [u8]) -> Result<(), &'static str> {
    const BROKEN: &str = "a packed block is damaged";
    let size = match codec {
        1 => lz4_flex::block::decompress_into(data, into).map_err(|_| BROKEN)?,
        3 => {
            let mut reader = flate2::read::ZlibDecoder::new(data);
            reader.read_exact(into).map_err(|_| BROKEN)?;
            into.len()
        }
        4 => zstd::bulk::decompress_to_buffer(data, into).map_err(|_| BROKEN)?,
        _ => return Err("its blocks are packed by BloscLZ or Snappy, which OpenVDB does not use"),
    };
    if size == into.len() {
        Ok(())
    } else {
        Err(BROKEN)
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/vdb/blosc.rs"]
mod tests;
