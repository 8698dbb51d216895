use super::*;

#[test]
fn the_name_decides_the_format() {
    assert_eq!(Format::of(Path::new("a/b.EXR")).unwrap(), Format::Exr);
    assert_eq!(Format::of(Path::new("b.png")).unwrap(), Format::Png);
    assert_eq!(Format::of(Path::new("b.jpeg")).unwrap(), Format::Jpeg);
    for wrong in ["b", "b.tif", ".exr", "exr"] {
        assert!(Format::of(Path::new(wrong)).is_err(), "{wrong}");
    }
}
