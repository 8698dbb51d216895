//! Raw floats for a program that shows the picture while it grows: little-endian `f32`, one layer after
//! the other, channels interleaved, rows from bottom to top.

use super::OutputError;
use super::atomic_write::write_unsynchronised;
use crate::film::Bands;
use rayon::prelude::*;
use serde::Serialize;
use std::fs::File;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;

/// Where a layer stands in the file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PassLocation {
    /// Name of the layer.
    pub name: String,
    /// Names of its channels in their order, such as `RGBA`.
    pub channels: String,
    /// Bytes before it.
    pub offset: u64,
}

/// Writes all layers of a picture beside and renames; the disk is not waited for. Bands are made and written by
/// the threads of the current pool side by side: nobody holds the whole.
///
/// # Errors
/// The file can't be written; then nothing is left of it.
pub fn write(path: &Path, picture: &dyn Bands) -> Result<Vec<PassLocation>, OutputError> {
    let (width, height) = picture.size();
    let mut places = Vec::new();
    let mut offset = 0;
    for (name, channels) in picture.layers() {
        let bytes = u64::from(width) * u64::from(height) * (4 * channels.len()) as u64;
        places.push(PassLocation {
            name,
            channels,
            offset,
        });
        offset += bytes;
    }
    let bands = picture.bands();
    write_unsynchronised(path, |file| {
        let file: &File = file.get_ref();
        bands
            .par_iter()
            .enumerate()
            .try_for_each_init(Vec::new, |buffers, (band, rows)| {
                write_band(file, picture, &places, band, rows, buffers)
            })
    })?;
    Ok(places)
}

/// Writes one band's rows of each layer where they stand in the file.
fn write_band(
    file: &File,
    picture: &dyn Bands,
    places: &[PassLocation],
    band: usize,
    rows: &Range<u32>,
    buffers: &mut Vec<Vec<f32>>,
) -> std::io::Result<()> {
    let (width, height) = picture.size();
    buffers.resize(places.len(), Vec::new());
    for (buffer, place) in buffers.iter_mut().zip(places) {
        buffer.resize(width as usize * rows.len() * place.channels.len(), 0.0);
    }
    let mut parts: Vec<&mut [f32]> = buffers.iter_mut().map(Vec::as_mut_slice).collect();
    picture.fill(band, &mut parts);
    for (part, place) in parts.into_iter().zip(places) {
        let row = width as usize * place.channels.len();
        turn_over(part, row);
        for value in part.iter_mut() {
            *value = f32::from_bits(value.to_bits().to_le());
        }
        let below = u64::from(height - rows.end) * (4 * row) as u64;
        file.write_all_at(bytemuck::cast_slice(part), place.offset + below)?;
    }
    Ok(())
}

/// The last row becomes the first.
fn turn_over(values: &mut [f32], row: usize) {
    let mut rest = values;
    while rest.len() >= 2 * row && row > 0 {
        let (first, after) = rest.split_at_mut(row);
        let (between, last) = after.split_at_mut(after.len() - row);
        first.swap_with_slice(last);
        rest = between;
    }
}

#[cfg(test)]
#[path = "../../tests/unit/output/raw.rs"]
mod tests;
