//! A look at a binary layer before it is parsed: whether the sizes in it can be true.

/// Largest growth of LZ4: a byte of a match's length stands for 255 bytes.
const LZ4_GROWTH: u64 = 255;

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
            // Integers are coded by at least 2 bits each before they are compressed.
            b"FIELDS" | b"FIELDSETS" | b"PATHS" | b"SPECS" => {
                claimed.is_none_or(|c| c > size.saturating_mul(4 * LZ4_GROWTH))
            }
            _ => false,
        };
        if too_many {
            return Err("it claims more than can be in it: it is damaged".into());
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/crate_file.rs"]
mod tests;
