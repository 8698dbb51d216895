//! The values of a binary layer, before they are read: whether what they claim to be made of can be there.
//!
//! Their parser takes memory for as many elements as a list says it has, and follows values inside of values down its stack.

/// Largest growth of LZ4: a byte of a match's length stands for 255 bytes.
pub(super) const LZ4_GROWTH: u64 = 255;
/// Values inside of values: more is a circle.
const DEEPEST: usize = 64;
/// Looks at values for each byte of a file, at most; more are those of a circle, or of values that stand for very many.
const PER_BYTE: u64 = 16;
/// Looks at values in any file.
const FREE: u64 = 1000;

/// Where something ends; an error is whether that is harmless, as its parser finds the end of the file there.
type Look = Result<u64, bool>;

/// A look at the values of a layer.
pub(super) struct Values<'a> {
    bytes: &'a [u8],
    version: &'a [u8],
    looked: u64,
}

/// Bytes of an element of a list, by the number of its type.
fn element(kind: u64) -> Option<u64> {
    Some(match kind {
        1 | 2 => 1,
        7 => 2,
        3 | 4 | 8 | 10..=12 | 21 | 57 => 4,
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

impl<'a> Values<'a> {
    pub(super) fn new(bytes: &'a [u8], version: &'a [u8]) -> Self {
        Self {
            bytes,
            version,
            looked: 0,
        }
    }

    /// Whether a value can be what it says.
    pub(super) fn fits(&mut self, word: u64) -> bool {
        match self.value(word, 0) {
            Ok(_) => true,
            Err(harmless) => harmless,
        }
    }

    fn length(&self) -> u64 {
        self.bytes.len() as u64
    }

    fn some<const N: usize>(&self, at: u64) -> Result<[u8; N], bool> {
        let start = usize::try_from(at).map_err(|_| true)?;
        let end = start.checked_add(N).ok_or(true)?;
        let some = self.bytes.get(start..end).ok_or(true)?;
        some.try_into().map_err(|_| true)
    }

    fn number(&self, at: u64) -> Look {
        Ok(u64::from_le_bytes(self.some(at)?))
    }

    /// A number of elements that have so many bytes each.
    fn count(&self, at: u64, size: u64) -> Look {
        let count = self.number(at)?;
        if count.saturating_mul(size) > self.length() {
            return Err(false);
        }
        Ok(count)
    }

    /// Where a jump leads that stands somewhere.
    fn jump(&self, at: u64) -> Look {
        let by = self.number(at)? as i64;
        at.checked_add_signed(by).ok_or(true)
    }

    fn value(&mut self, word: u64, depth: usize) -> Look {
        self.looked += 1;
        if depth > DEEPEST || self.looked > FREE + PER_BYTE.saturating_mul(self.length()) {
            return Err(false);
        }
        let (list, inlined, packed) = (word >> 63 == 1, word >> 62 & 1 == 1, word >> 61 & 1 == 1);
        let (kind, at) = (word >> 48 & 0xff, word & 0xffff_ffff_ffff);
        if inlined || at == 0 {
            return Ok(at);
        }
        if list {
            return self.list(kind, at, packed);
        }
        match kind {
            31 => self.dictionary(at, depth),
            32..=39 | 54 | 55 => self.operations(kind, at, depth),
            40 | 41 | 50 => self.count(at, 4),
            45 | 48 | 58 => self.count(at, 8),
            49 => self.count(at, 16),
            46 => self.samples(at, depth),
            _ => Ok(at),
        }
    }

    fn list(&self, kind: u64, at: u64, packed: bool) -> Look {
        let Some(size) = element(kind) else {
            return Ok(at);
        };
        // Before 0.5 a shape stands first, and before 0.7 counts have 32 bits.
        let at = if self.version < [0, 5, 0].as_slice() {
            at + 4
        } else {
            at
        };
        let (count, after) = if self.version < [0, 7, 0].as_slice() {
            (u64::from(u32::from_le_bytes(self.some(at)?)), at + 4)
        } else {
            (self.number(at)?, at + 8)
        };
        // Integers are packed from 0.5 on, others from 0.6 on, and very short lists never.
        let integers = matches!(kind, 3..=6);
        let from = if integers { [0, 5, 0] } else { [0, 6, 0] };
        if !packed || count < 4 || self.version < from.as_slice() {
            let fits = count.saturating_mul(size) <= self.length();
            return if fits { Ok(after) } else { Err(false) };
        }
        let block = if integers {
            after
        } else {
            match self.some::<1>(after)? {
                // A table of numbers, and which of them each is.
                [b't'] => {
                    let table = u64::from(u32::from_le_bytes(self.some(after + 1)?));
                    if table.saturating_mul(size) > self.length() {
                        return Err(false);
                    }
                    after + 5 + table * size
                }
                _ => after + 1,
            }
        };
        let bytes = self.count(block, 1)?;
        // An integer takes two bits at least.
        let most = bytes.saturating_mul(4 * LZ4_GROWTH);
        if count > most { Err(false) } else { Ok(block) }
    }

    fn dictionary(&mut self, at: u64, depth: usize) -> Look {
        let count = self.count(at, 20)?;
        let mut at = at + 8;
        for _ in 0..count {
            // Its name, and a jump over what it refers to.
            let place = self.jump(at + 4)?;
            let word = self.number(place)?;
            self.value(word, depth + 1)?;
            at = place + 8;
        }
        Ok(at)
    }

    fn operations(&mut self, kind: u64, at: u64, depth: usize) -> Look {
        let [header] = self.some::<1>(at)?;
        let mut at = at + 1;
        for bit in 1..7 {
            if header >> bit & 1 == 0 {
                continue;
            }
            let size = if matches!(kind, 37 | 39) { 8 } else { 4 };
            let count = self.count(at, size)?;
            at += 8;
            for _ in 0..count {
                at = match kind {
                    // A file, a prim, a change of time, fields of its own.
                    35 => self.dictionary(at + 24, depth + 1)?,
                    55 if self.version >= [0, 8, 0].as_slice() => at + 24,
                    55 => at + 8,
                    _ => at + size,
                };
                if at > self.length() {
                    return Err(true);
                }
            }
        }
        Ok(at)
    }

    fn samples(&mut self, at: u64, depth: usize) -> Look {
        let times = self.jump(at)?;
        let word = self.number(times)?;
        self.value(word, depth + 1)?;
        let values = self.jump(times + 8)?;
        let count = self.count(values, 8)?;
        for index in 0..count {
            let word = self.number(values + 8 + 8 * index)?;
            self.value(word, depth + 1)?;
        }
        Ok(values)
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/crate_values.rs"]
mod tests;
