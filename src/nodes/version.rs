//! Versions of Cycles, which are Blender's: where they compute differently, the one that a node tree was made with counts.

use std::fmt;
use std::str::FromStr;

/// A version of Blender, to the second number: what a third one changes is no picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CyclesVersion {
    major: u16,
    minor: u16,
}

impl CyclesVersion {
    /// The latest whose nodes are known.
    pub const LATEST: Self = Self::new(5, 3);

    /// By its numbers.
    pub const fn new(major: u16, minor: u16) -> Self {
        Self { major, minor }
    }
}

impl Default for CyclesVersion {
    fn default() -> Self {
        Self::LATEST
    }
}

impl fmt::Display for CyclesVersion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

impl FromStr for CyclesVersion {
    type Err = std::num::ParseIntError;

    /// From "4.5" or "4.5.15".
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut numbers = text.splitn(3, '.').map(str::parse::<u16>);
        let major = numbers.next().unwrap_or(Ok(0))?;
        let minor = numbers.next().unwrap_or_else(|| "".parse())?;
        numbers.next().transpose()?;
        Ok(Self { major, minor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_read_and_have_an_order() {
        let read = |text: &str| text.parse::<CyclesVersion>().ok();
        assert_eq!(read("4.5"), Some(CyclesVersion::new(4, 5)));
        assert_eq!(read("5.2.3"), Some(CyclesVersion::new(5, 2)));
        for text in ["", "5", "5.", "5.2.", "5.2.x", "five", "5.-2", "5.2.3.4"] {
            assert_eq!(read(text), None, "{text}");
        }
        assert!(read("4.10") > read("4.5") && read("5.0") > read("4.10"));
        assert_eq!(CyclesVersion::new(4, 5).to_string(), "4.5");
    }
}
