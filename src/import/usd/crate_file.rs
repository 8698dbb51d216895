//! A look at a binary layer before it is parsed: whether the sizes in it can be true.

/// Largest growth of LZ4: a byte of a match's length stands for 255 bytes.
const LZ4_GROWTH: u64 = 255;
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
        if too_many || (name == b"FIELDS" && !values_fit(bytes, start, version)) {
            return Err("it claims more than can be in it: it is damaged".into());
        }
    }
    Ok(())
}

/// Bytes of an element of a list, by the number of its type.
fn element(kind: u64) -> Option<u64> {
    Some(match kind {
        1 | 2 => 1,
        7 => 2,
        3 | 4 | 8 | 10..=12 | 21 => 4,
        25 => 6,
        5 | 6 | 9 | 18 | 20 | 22 | 29 | 56 => 8,
        24 | 26 => 12,
        17 | 19 | 28 | 30 => 16,
        23 => 24,
        13 | 16 | 27 => 32,
        14 => 72,
        15 => 128,
        _ => return None,
    })
}

/// Whether the lists that the fields of a file refer to can be as long as they say.
fn values_fit(bytes: &[u8], section: u64, version: &[u8]) -> bool {
    let Some(fields) = fields(bytes, section) else {
        return false;
    };
    let length = bytes.len() as u64;
    let (words, _) = fields.as_chunks::<8>();
    words.iter().all(|word| {
        let word = u64::from_le_bytes(*word);
        let (list, inlined, packed) = (word >> 63 == 1, word >> 62 & 1 == 1, word >> 61 & 1 == 1);
        let (kind, at) = (word >> 48 & 0xff, word & 0xffff_ffff_ffff);
        if inlined || at == 0 {
            return true;
        }
        if list {
            let Some(size) = element(kind) else {
                return true;
            };
            // Before 0.5 a shape stands first, and before 0.7 counts have 32 bits.
            let at = if version < [0, 5, 0].as_slice() {
                at + 4
            } else {
                at
            };
            let mask = if version < [0, 7, 0].as_slice() {
                0xffff_ffff
            } else {
                u64::MAX
            };
            let count = number(bytes, at).map(|c| c & mask);
            let most = if packed {
                length.saturating_mul(4 * LZ4_GROWTH)
            } else {
                length
            };
            return count.is_none_or(|c| c.saturating_mul(size) <= most);
        }
        let first = match kind {
            // Which operations there are stands before the first of them.
            32..=39 | 54 | 55 => number(bytes, at + 1),
            31 | 40 | 41 | 45 | 48..=50 => number(bytes, at),
            _ => None,
        };
        first.is_none_or(|count| {
            count <= length || (matches!(kind, 32..=39 | 54 | 55) && is_bare(bytes, at))
        })
    })
}

/// Whether no operation stands in a list of them.
fn is_bare(bytes: &[u8], at: u64) -> bool {
    let header = usize::try_from(at).ok().and_then(|at| bytes.get(at));
    header.is_none_or(|header| header & !1 == 0)
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
