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
