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
mod tests {
    use super::*;
    use crate::film::{Layer, Picture};

    #[test]
    fn layers_follow_each_other_with_rows_from_the_bottom() {
        let layer = |name: &str, channels: &str, data: &[f32]| Layer {
            name: name.into(),
            channels: channels.chars().map(String::from).collect(),
            data: data.to_vec(),
        };
        let picture = Picture {
            width: 2,
            height: 2,
            layers: vec![
                layer("Combined", "XY", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]),
                layer("Depth", "Z", &[9.0, 10.0, 11.0, 12.0]),
            ],
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.raw");
        let places = write(&path, &picture).unwrap();
        assert_eq!(
            places
                .iter()
                .map(|p| (p.name.as_str(), p.channels.as_str(), p.offset))
                .collect::<Vec<_>>(),
            [("Combined", "XY", 0), ("Depth", "Z", 32)]
        );
        let floats: Vec<f32> = std::fs::read(&path)
            .unwrap()
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        assert_eq!(
            floats,
            [
                5.0, 6.0, 7.0, 8.0, 1.0, 2.0, 3.0, 4.0, 11.0, 12.0, 9.0, 10.0
            ]
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn pictures_of_many_bands_are_whole() {
        let (width, height) = (3u32, 101u32);
        let data: Vec<f32> = (0..2 * width * height).map(|i| i as f32).collect();
        let picture = Picture {
            width,
            height,
            layers: vec![Layer {
                name: "Combined".into(),
                channels: vec!["X".into(), "Y".into()],
                data: data.clone(),
            }],
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.raw");
        write(&path, &picture).unwrap();
        let read: Vec<f32> = std::fs::read(&path)
            .unwrap()
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        let expected: Vec<f32> = data.chunks_exact(6).rev().flatten().copied().collect();
        assert!(read == expected);
        assert!(Picture::collect(&picture).layers[0].data == data);
    }
}
