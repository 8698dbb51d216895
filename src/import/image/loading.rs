//! The images of a scene, decoded together: side by side, and where they would take more memory than they may, in scratch files.

use std::borrow::Cow;
use std::path::PathBuf;

use rayon::prelude::*;

use super::{Budget, ImageFailure, checked_size, decode_at, halvings, reduced, to_files};
use crate::scene::{self, Diagnostics, Image, Place, Verdict};

/// An image as it stands in a file.
pub(crate) struct Encoded<'a> {
    /// For messages.
    pub name: String,
    pub bytes: Bytes<'a>,
    /// What is done to its numbers makes floats of them.
    pub becomes_floats: bool,
}

/// Bytes of an image file.
pub(crate) enum Bytes<'a> {
    Here(Cow<'a, [u8]>),
    /// In a file of so many bytes, which is read when it is decoded.
    In(PathBuf, usize),
}

/// Where memory is limited, images that are files are read when they are decoded, not all before.
pub(crate) fn bytes_of_file(path: PathBuf, bytes: Vec<u8>, most: Option<u64>) -> Bytes<'static> {
    match most {
        Some(_) => Bytes::In(path, bytes.len()),
        None => Bytes::Here(bytes.into()),
    }
}

impl Bytes<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Here(bytes) => bytes.len(),
            Self::In(_, length) => *length,
        }
    }

    fn read(&self) -> Result<Cow<'_, [u8]>, ImageFailure> {
        match self {
            Self::Here(bytes) => Ok((&**bytes).into()),
            Self::In(path, length) => match std::fs::read(path) {
                Ok(bytes) if bytes.len() == *length => Ok(bytes.into()),
                Ok(_) => Err(ImageFailure::Damaged(
                    "its file was changed while it was read".into(),
                )),
                Err(error) => Err(ImageFailure::Damaged(error.to_string())),
            },
        }
    }
}

/// Width, height and bytes a pixel.
type Size = (u64, u64, u64);

/// What became of an image that takes more memory than is allowed.
enum Moved {
    /// Its size, and its bytes.
    ToFile((u32, u32), u64),
    /// The sizes that it had and has.
    Reduced([(u32, u32); 2]),
}

impl Moved {
    fn report(&self, name: &str, diagnostics: &mut Diagnostics) {
        let what = "images that take more memory than --max-memory allows";
        match self {
            Self::ToFile((width, height), bytes) => diagnostics.report(
                "image-in-file",
                Verdict::Exact,
                what,
                format!("image \"{name}\" ({width} × {height}, {} MiB)", bytes >> 20),
                "kept in a scratch file, of which as much is in memory as they may take; their pixels are exact",
            ),
            Self::Reduced([(width, height), (w, h)]) => diagnostics.report(
                "image-reduced",
                Verdict::Approximated,
                what,
                format!("image \"{name}\" ({width} × {height} to {w} × {h})"),
                "rendered with fewer pixels, each the mean of those that it was, as no folder for temporary files is on a disk with room: set TMPDIR to one",
            ),
        }
    }
}

/// Says that an image lies in a scratch file.
pub(crate) fn tell_in_file(image: &Image, diagnostics: &mut Diagnostics) {
    let size = (image.width, image.height);
    Moved::ToFile(size, image.pixels.bytes()).report(&image.name, diagnostics);
}

/// An image with what became of it; or its name, and why there is none.
type Decoded = Result<(Image, Option<Moved>), (String, ImageFailure)>;

/// Decodes images, each in its place of the list: those that stay in memory side by side, those that go to files one after the
/// other. `input`: bytes of what they come from; `most`: bytes that they may take.
pub(crate) fn decode_all(
    encoded: Vec<Encoded>,
    input: usize,
    most: Option<u64>,
    diagnostics: &mut Diagnostics,
) -> Vec<Result<Image, (String, ImageFailure)>> {
    // What each may take is settled from its header before any is decoded.
    let budget = Budget::for_image(input);
    let sizes: Vec<Result<_, ImageFailure>> = encoded
        .iter()
        .map(|one| {
            let (width, height, pixel) = checked_size(&one.bytes.read()?, &budget)?;
            // Of four channels.
            let least = if one.becomes_floats { 16 } else { 0 };
            Ok((width, height, pixel.max(least)))
        })
        .collect();
    let known: Vec<_> = sizes
        .iter()
        .map(|size| *size.as_ref().unwrap_or(&(0, 0, 0)))
        .collect();
    let most = most.unwrap_or(u64::MAX);
    let to_files = to_files(&known, most);
    // Where there is no room for them on a disk.
    let levels = halvings(&known, most);
    let bytes = |number: usize| {
        let (width, height, pixel) = known[number];
        width * height * pixel
    };
    let staying: u64 = (0..known.len())
        .filter(|&number| !to_files[number])
        .map(bytes)
        .sum();
    if most < u64::MAX {
        scene::keep_mapped_below(most.saturating_sub(staying));
    }
    let decode = |(number, (one, size)): (usize, (Encoded, Result<Size, ImageFailure>))| {
        let leaves = to_files[number];
        let place = if leaves { Place::File } else { Place::Memory };
        let image = size.and_then(|_| decode_at(&one.bytes.read()?, &one.name, place));
        let decoded: Decoded = match image {
            Ok(image) if leaves => Ok(moved(image, levels[number])),
            Ok(image) => Ok((image, None)),
            Err(reason) => Err((one.name, reason)),
        };
        (number, decoded)
    };
    let all = encoded.into_iter().zip(sizes).enumerate();
    let (leaving, staying): (Vec<_>, Vec<_>) = all.partition(|(number, _)| to_files[*number]);
    let mut decoded: Vec<_> = leaving.into_iter().map(decode).collect();
    decoded.par_extend(staying.into_par_iter().map(decode));
    decoded.sort_unstable_by_key(|(number, _)| *number);
    let told = decoded.into_iter().map(|(_, decoded)| {
        decoded.map(|(image, moved)| {
            if let Some(moved) = moved {
                moved.report(&image.name, diagnostics);
            }
            image
        })
    });
    told.collect()
}

/// The image in a scratch file, where it may be already; with fewer pixels where that cannot be.
fn moved(image: Image, level: u32) -> (Image, Option<Moved>) {
    let size = (image.width, image.height);
    let pixels = if image.pixels.are_in_file() {
        Ok(image.pixels.clone())
    } else {
        image.pixels.in_file()
    };
    match pixels {
        Ok(pixels) => {
            let told = Moved::ToFile(size, pixels.bytes());
            (Image { pixels, ..image }, Some(told))
        }
        Err(_) if level == 0 => (image, None),
        Err(_) => {
            let image = reduced(image, level);
            let sizes = [size, (image.width, image.height)];
            (image, Some(Moved::Reduced(sizes)))
        }
    }
}
