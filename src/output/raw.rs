//! Raw floats for a program that shows the picture while it grows: little-endian `f32`, one layer after
//! the other, channels interleaved, rows from bottom to top.

use super::OutputError;
use super::beside::write_unsynchronised;
use crate::film::Picture;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Where a layer stands in the file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Place {
    /// Name of the layer.
    pub name: String,
    /// Names of its channels in their order, such as `RGBA`.
    pub channels: String,
    /// Bytes before it.
    pub offset: u64,
}

/// Writes all layers of a picture beside and renames; the disk is not waited for.
///
/// # Errors
/// The file can't be written; then nothing is left of it.
pub fn write(path: &Path, picture: &Picture) -> Result<Vec<Place>, OutputError> {
    let mut places = Vec::new();
    let mut offset = 0;
    for layer in &picture.layers {
        places.push(Place {
            name: layer.name.clone(),
            channels: layer.channels.concat(),
            offset,
        });
        offset += size_of_val(layer.data.as_slice()) as u64;
    }
    write_unsynchronised(path, |file| -> std::io::Result<()> {
        let mut bytes = Vec::new();
        for layer in &picture.layers {
            let row = picture.width as usize * layer.channels.len();
            for values in layer.data.chunks_exact(row.max(1)).rev() {
                bytes.clear();
                bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
                file.write_all(&bytes)?;
            }
        }
        Ok(())
    })?;
    Ok(places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Layer;

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
}
