//! Which red, green and blue a scene's numbers are amounts of, and the way from one such space to another.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// The linear space that a scene's colours are numbers of, and in which light is multiplied with them.
///
/// A product of colours depends on it, so that it is the scene's and not the program's: Blender 5.0 and later have one for
/// each file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum WorkingSpace {
    /// The primaries of ITU-R BT.709 and of sRGB.
    #[default]
    #[serde(rename = "Linear Rec.709")]
    Rec709,
    /// Those of ITU-R BT.2020.
    #[serde(rename = "Linear Rec.2020")]
    Rec2020,
    /// AP1 of the Academy (S-2014-004), with its white brought to D65.
    #[serde(rename = "ACEScg")]
    AcesCg,
}

/// CIE 1931 chromaticities (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: [f64; 2],
    /// Green.
    pub green: [f64; 2],
    /// Blue.
    pub blue: [f64; 2],
    /// White.
    pub white: [f64; 2],
}

const D65: [f64; 2] = [0.3127, 0.3290];

/// The cone responses of Bradford's adaptation, as ICC.1:2022 has them (annex E). It is what brings ACEScg to D65 in
/// Blender's configuration: Cycles 5.0.1's grey of (0.8, 0.2, 0.1) in ACEScg is 0.35480 with it, and 0.35489 with CAT02.
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

impl Primaries {
    /// CIE XYZ of an amount of each primary, with white at Y = 1 and adapted to D65.
    fn xyz(&self) -> DMat3 {
        let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let columns = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        let white = xyz(self.white);
        let own = columns * DMat3::from_diagonal(columns.inverse() * white);
        if self.white == D65 {
            return own;
        }
        let ratio = (BRADFORD * xyz(D65)) / (BRADFORD * white);
        BRADFORD.inverse() * DMat3::from_diagonal(ratio) * BRADFORD * own
    }
}

impl WorkingSpace {
    /// All that there are.
    pub const ALL: [Self; 3] = [Self::Rec709, Self::Rec2020, Self::AcesCg];

    /// Its name in Blender, and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rec709 => "Linear Rec.709",
            Self::Rec2020 => "Linear Rec.2020",
            Self::AcesCg => "ACEScg",
        }
    }

    /// The name that the Color Interop Forum gave it, as Blender writes it into EXR files.
    pub fn interop_id(self) -> &'static str {
        match self {
            Self::Rec709 => "lin_rec709_scene",
            Self::Rec2020 => "lin_rec2020_scene",
            Self::AcesCg => "lin_ap1_scene",
        }
    }

    /// From CIE XYZ with white at Y = 1, adapted to D65.
    pub fn from_xyz(self) -> DMat3 {
        self.primaries().xyz().inverse()
    }

    /// Its primaries and its white.
    pub fn primaries(self) -> Primaries {
        match self {
            Self::Rec709 => Primaries {
                red: [0.64, 0.33],
                green: [0.30, 0.60],
                blue: [0.15, 0.06],
                white: D65,
            },
            Self::Rec2020 => Primaries {
                red: [0.708, 0.292],
                green: [0.170, 0.797],
                blue: [0.131, 0.046],
                white: D65,
            },
            Self::AcesCg => Primaries {
                red: [0.713, 0.293],
                green: [0.165, 0.830],
                blue: [0.128, 0.044],
                white: [0.32168, 0.33767],
            },
        }
    }

    /// The one with these primaries and white, as EXR files have them (in f32, often rounded to four digits).
    pub fn with_primaries(wanted: &Primaries) -> Option<Self> {
        let far = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
        Self::ALL.into_iter().find(|space| {
            let own = space.primaries();
            let worst = far(own.red, wanted.red)
                .max(far(own.green, wanted.green))
                .max(far(own.blue, wanted.blue))
                .max(far(own.white, wanted.white));
            // Half a unit of the fourth digit. The spaces themselves are 2e-3 and more apart.
            worst <= 5e-5
        })
    }

    /// The matrix that brings linear Rec.709 to this space; `None` if it is that itself.
    pub fn matrix_from_rec709(self) -> Option<DMat3> {
        (self != Self::Rec709)
            .then(|| self.primaries().xyz().inverse() * Self::Rec709.primaries().xyz())
    }

    /// The matrix that brings colours of this space to linear Rec.709; `None` if it is that itself.
    pub fn matrix_to_rec709(self) -> Option<DMat3> {
        (self != Self::Rec709)
            .then(|| Self::Rec709.primaries().xyz().inverse() * self.primaries().xyz())
    }
}

impl std::fmt::Display for WorkingSpace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
#[path = "../../tests/unit/math/primaries.rs"]
mod tests;
