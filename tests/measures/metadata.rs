//! What files say of their pictures is what was written.

use sundog::film;
use sundog::math::primaries::WorkingSpace;
use sundog::measure::{LightSpace, metadata, working_space};
use sundog::output::{self, png::Codes};

fn one_pixel() -> film::Picture {
    film::Picture {
        width: 1,
        height: 1,
        layers: vec![film::Layer {
            name: "Combined".into(),
            channels: ["R", "G", "B"].map(String::from).to_vec(),
            data: vec![0.5; 3],
        }],
    }
}

#[test]
fn an_exr_file_says_what_its_light_is_numbers_of() {
    let folder = tempfile::tempdir().unwrap();
    let picture = one_pixel();
    for space in WorkingSpace::ALL {
        let path = folder.path().join("a.exr");
        let options = output::exr::ExrOptions {
            space,
            ..Default::default()
        };
        output::exr::write(&path, &picture, &options, &Vec::new()).unwrap();
        assert_eq!(working_space(&path).unwrap(), LightSpace::Known(space));
        let read = exr::meta::MetaData::read_from_file(&path, false).unwrap();
        let said = read.headers[0].shared_attributes.chromaticities.unwrap();
        let red = space.primaries().red;
        assert_eq!([said.red.0, said.red.1], red.map(|v| v as f32));
    }
}

#[test]
fn texts_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
    let written = vec![("sundog/samples".to_owned(), "64 Käse".to_owned())];
    let picture = one_pixel();
    output::exr::write(&exr, &picture, &Default::default(), &written).unwrap();
    output::png::write(&png, 1, 1, Codes::Eight(&[0; 3]), &written).unwrap();
    for path in [exr, png] {
        assert_eq!(metadata(&path).unwrap()["sundog/samples"], "64 Käse");
    }
    let other = folder.path().join("a.txt");
    std::fs::write(&other, "x").unwrap();
    assert!(metadata(&other).unwrap().is_empty());
    assert!(metadata(&folder.path().join("none")).is_err());
}
