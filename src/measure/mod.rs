//! How far a picture is from another one. All sums are made in f64.

mod comparison;
pub mod convergence;
mod difference;
pub mod flip;
mod load;
mod metadata;
mod ssim;

pub use comparison::Comparison;
pub use difference::{
    Difference, difference, difference_as_shown, difference_map, error_map, flip_map,
};
pub use load::{load, load_with_alpha};
pub use metadata::{LightSpace, metadata, working_space};

/// Why two pictures could not be compared. Each message is one sentence.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// A file cannot be read as a picture.
    #[error("cannot read {path}: {reason}")]
    Unreadable {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A file or folder is not as it should be.
    #[error("{path}: {reason}")]
    Refused {
        /// Which.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A file holds something else than it should.
    #[error("{path} {reason}")]
    Unfit {
        /// The file.
        path: String,
        /// What it holds, and what it should.
        reason: String,
    },
    /// A file has no such layer.
    #[error("{path} has no layer {wanted}; it has {there}")]
    NoSuchLayer {
        /// The file.
        path: String,
        /// What was asked for.
        wanted: String,
        /// What there is.
        there: String,
    },
    /// The pictures have different sizes.
    #[error(
        "the pictures have different sizes, {a_width} × {a_height} and {b_width} × {b_height} pixels; render both at the same size"
    )]
    DifferentSizes {
        /// Pixels a row of the first.
        a_width: u32,
        /// Rows of the first.
        a_height: u32,
        /// Pixels a row of the second.
        b_width: u32,
        /// Rows of the second.
        b_height: u32,
    },
    /// One picture is linear light, the other one display values.
    #[error(
        "one picture holds linear light and the other one display values; compare two EXR files, or two PNG or JPEG files"
    )]
    DifferentEncodings,
    /// There is nothing to compare.
    #[error("no pixel is finite in both pictures")]
    NothingFinite,
}

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// Linear light (EXR, HDR).
    Linear,
    /// Display values, 0..=1 (PNG, JPEG; linear light after a view); for FLIP taken as sRGB.
    Display,
}

/// A picture to be measured.
#[derive(Clone, Debug, PartialEq)]
pub struct RgbImage {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// RGB, rows from top to bottom: `width * height` of them. A layer of one channel stands three times.
    pub pixels: Vec<[f32; 3]>,
    /// What the numbers mean.
    pub encoding: Encoding,
}

/// Two pictures can be compared if they have the same size and their numbers mean the same.
fn check_alike(a: &RgbImage, b: &RgbImage) -> Result<(), MeasureError> {
    check_sizes(a, b)?;
    if a.encoding != b.encoding {
        return Err(MeasureError::DifferentEncodings);
    }
    Ok(())
}

fn check_sizes(a: &RgbImage, b: &RgbImage) -> Result<(), MeasureError> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(MeasureError::DifferentSizes {
            a_width: a.width,
            a_height: a.height,
            b_width: b.width,
            b_height: b.height,
        });
    }
    Ok(())
}
