//! A look at a binary layer before it is parsed: whether the sizes in it can be true.

use super::crate_values::{LZ4_GROWTH, Values};

/// Fields, paths and specs for each byte of a file, at most: those of like prims are packed to less than a byte each.
const PER_BYTE: u64 = 8;

fn number(bytes: &[u8], at: u64) -> Option<u64> {
    let at = usize::try_from(at).ok()?;
    let eight = bytes.get(at..at.checked_add(8)?)?;
    Some(u64::from_le_bytes(eight.try_into().ok()?))
}

/// Says what is wrong with a crate file's table of contents, if something is.
///
/// The sizes that it claims decide how much memory its parser takes.
pub(super) fn fault(bytes: &[u8]) -> Option<String> {
    sections(bytes).err()
}

fn sections(bytes: &[u8]) -> Result<(), String> {
    let length = bytes.len() as u64;
    let cut = || "it ends before all of it is there".to_owned();
    let version = bytes.get(8..11).ok_or_else(cut)?;
    if version < [0, 4, 0].as_slice() {
        return Err(
            "it is a binary file of before USD 0.8, which is not read: export it again".into(),
        );
    }
    let contents = number(bytes, 16).ok_or_else(cut)?;
    let count = number(bytes, contents).ok_or_else(cut)?;
    if count >= 64 {
        return Err("its table of contents is damaged".into());
    }
    for index in 0..count {
        let entry = contents + 8 + index * 32;
        let name = usize::try_from(entry)
            .ok()
            .and_then(|at| bytes.get(at..at.checked_add(16)?))
            .ok_or_else(cut)?;
        let start = number(bytes, entry + 16).ok_or_else(cut)?;
        let size = number(bytes, entry + 24).ok_or_else(cut)?;
        if start.checked_add(size).is_none_or(|end| end > length) {
            return Err(cut());
        }
        let name = name.split(|b| *b == 0).next().unwrap_or_default();
        let claimed = number(bytes, start);
        let too_many = match name {
            // How many, how long they are together, how long that is compressed.
            b"TOKENS" => {
                let unpacked = number(bytes, start + 8);
                claimed.is_none_or(|c| c > size.saturating_mul(LZ4_GROWTH))
                    || unpacked.is_none_or(|u| u > size.saturating_mul(LZ4_GROWTH))
            }
            b"STRINGS" => claimed.is_none_or(|c| c.saturating_mul(4) > size),
            // Each takes memory whether it is there or not.
            b"FIELDS" | b"FIELDSETS" | b"PATHS" | b"SPECS" => {
                claimed.is_none_or(|c| c > length.saturating_mul(PER_BYTE))
            }
            _ => false,
        };
        let end = start + size;
        let packed = match name {
            // How long they are together stands before their block.
            b"TOKENS" => blocks_fit(bytes, start + 16, 1, end),
            b"FIELDS" => blocks_fit(bytes, start + 8, 2, end),
            b"FIELDSETS" => blocks_fit(bytes, start + 8, 1, end),
            b"SPECS" => blocks_fit(bytes, start + 8, 3, end),
            // How many there are, and how many of them are packed.
            b"PATHS" => {
                let second = number(bytes, start + 8);
                second.is_some_and(|c| c <= length.saturating_mul(PER_BYTE))
                    && blocks_fit(bytes, start + 16, 3, end)
            }
            _ => true,
        };
        let too_many = too_many || !packed;
        if too_many || (name == b"FIELDS" && !values_fit(bytes, start, version)) {
            return Err("it claims more than can be in it: it is damaged".into());
        }
    }
    Ok(())
}

/// All words of a crate file, which paths of files are among; `None` where they cannot be read.
pub(super) fn words(bytes: &[u8]) -> Option<Vec<String>> {
    fault(bytes).is_none().then_some(())?;
    let contents = number(bytes, 16)?;
    let start = (0..number(bytes, contents)?.min(64)).find_map(|index| {
        let entry = contents + 8 + index * 32;
        let at = usize::try_from(entry).ok()?;
        let name = bytes.get(at..at.checked_add(16)?)?;
        (name.starts_with(b"TOKENS\0")).then(|| number(bytes, entry + 16))?
    })?;
    let unpacked = usize::try_from(number(bytes, start + 8)?).ok()?;
    let at = usize::try_from(start + 24).ok()?;
    let size = usize::try_from(number(bytes, start + 16)?).ok()?;
    let packed = bytes.get(at..at.checked_add(size)?)?;
    let plain = unpack(packed, unpacked)?;
    let words = plain.split(|byte| *byte == 0);
    Some(
        words
            .map(|w| String::from_utf8_lossy(w).into_owned())
            .collect(),
    )
}

/// Unpacks a block of LZ4, or several of them with their sizes.
fn unpack(packed: &[u8], unpacked: usize) -> Option<Vec<u8>> {
    let (chunks, mut rest) = packed.split_first()?;
    if *chunks == 0 {
        return lz4_flex::block::decompress(rest, unpacked).ok();
    }
    let mut all = Vec::new();
    for _ in 0..*chunks {
        let (size, after) = rest.split_first_chunk::<4>()?;
        let (block, after) = after.split_at_checked(u32::from_le_bytes(*size) as usize)?;
        let left = unpacked.checked_sub(all.len())?;
        all.extend(lz4_flex::block::decompress(block, left).ok()?);
        rest = after;
    }
    Some(all)
}

/// Whether the values that the fields of a file refer to can be what they say.
fn values_fit(bytes: &[u8], section: u64, version: &[u8]) -> bool {
    let Some(fields) = fields(bytes, section) else {
        return false;
    };
    let mut values = Values::new(bytes, version);
    let (words, _) = fields.as_chunks::<8>();
    words
        .iter()
        .all(|word| values.fits(u64::from_le_bytes(*word)))
}

/// Whether the packed blocks of a section end in it: so many behind each other, each with its size first.
fn blocks_fit(bytes: &[u8], mut at: u64, blocks: usize, end: u64) -> bool {
    for _ in 0..blocks {
        let size = number(bytes, at);
        let next = size.and_then(|size| at.checked_add(8)?.checked_add(size));
        match next.filter(|next| *next <= end) {
            Some(next) => at = next,
            None => return false,
        }
    }
    true
}

/// What the fields refer to, unpacked.
fn fields(bytes: &[u8], section: u64) -> Option<Vec<u8>> {
    let count = number(bytes, section)?;
    let names = number(bytes, section + 8)?;
    let at = section.checked_add(16)?.checked_add(names)?;
    let size = number(bytes, at)?;
    let start = usize::try_from(at.checked_add(8)?).ok()?;
    let packed = bytes.get(start..start.checked_add(usize::try_from(size).ok()?)?)?;
    if count == 0 {
        return Some(Vec::new());
    }
    // Chunks, of which such short lists have none.
    let (chunks, block) = packed.split_first()?;
    if *chunks != 0 {
        return Some(Vec::new());
    }
    let unpacked = usize::try_from(count.checked_mul(8)?).ok()?;
    lz4_flex::block::decompress(block, unpacked).ok()
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/crate_file.rs"]
mod tests;
