use super::*;

#[test]
fn what_is_written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let metadata = vec![("sundog/view".to_owned(), "Käse".to_owned())];
    let values: Vec<u16> = (0..24).map(|i| i * 2000 + 7).collect();
    let pixels = DisplayPixels {
        channels: 4,
        samples: DisplaySamples::Sixteen(values.clone()),
    };
    let picture = DisplayPicture {
        width: 3,
        height: 2,
        pixels: &pixels,
    };
    let path = folder.path().join("a.png");
    write(&path, Format::Png, picture, 90, &metadata).unwrap();
    let read = image::open(&path).unwrap();
    assert_eq!(read.color(), image::ColorType::Rgba16);
    assert_eq!(read.into_rgba16().into_raw(), values);
    let decoder = ::png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
    let reader = decoder.read_info().unwrap();
    let text = &reader.info().utf8_text[0];
    assert_eq!(
        (text.keyword.as_str(), text.get_text().unwrap().as_str()),
        ("sundog/view", "Käse")
    );
    // JPEG has neither alpha nor 16 bits; nothing may stand under the name then.
    let path = folder.path().join("a.jpg");
    assert!(write(&path, Format::Jpeg, picture, 90, &metadata).is_err());
    assert!(!path.exists());
    let pixels = DisplayPixels {
        channels: 3,
        samples: DisplaySamples::Eight(vec![200; 18]),
    };
    write(
        &path,
        Format::Jpeg,
        DisplayPicture {
            pixels: &pixels,
            ..picture
        },
        90,
        &metadata,
    )
    .unwrap();
    let read = image::open(&path).unwrap().into_rgb8();
    assert_eq!(read.dimensions(), (3, 2));
    // A flat colour survives JPEG but for rounding between RGB and YCbCr.
    assert!(
        read.pixels()
            .all(|pixel| pixel.0.iter().all(|value| value.abs_diff(200) <= 2))
    );
}

#[test]
fn a_size_that_does_not_fit_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let pixels = DisplayPixels {
        channels: 3,
        samples: DisplaySamples::Eight(vec![0; 17]),
    };
    for (name, format) in [("a.png", Format::Png), ("a.jpg", Format::Jpeg)] {
        let path = folder.path().join(name);
        let picture = DisplayPicture {
            width: 3,
            height: 2,
            pixels: &pixels,
        };
        assert!(write(&path, format, picture, 90, &Vec::new()).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
