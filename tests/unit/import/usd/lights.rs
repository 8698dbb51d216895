use super::*;

#[test]
fn releases_of_blender_are_told_apart() {
    let old = |doc: &str, normalize| Blender::told(doc).unwrap().is_old(normalize);
    assert!(old("Blender v3.0.0", None));
    assert!(old("Blender v2.93.1", None));
    assert!(!old("Blender v4.0.2", Some(true)));
    assert!(!old("Blender v4.2.1 LTS", None));
    assert!(!old("Blender v3.2.0 Alpha", None));
    assert_eq!(Blender::told("made by hand"), None);
}

/// 1000 W are 10 in the files of before 4.1, and 1000/π, normalized, in later ones.
#[test]
fn lamps_of_old_are_as_bright_as_those_of_today() {
    let mut shape = Shape::Sphere {
        radius: 0.1,
        point: false,
    };
    let (mut strength, mut normalize) = (10.0, false);
    modern(&mut shape, &mut strength, &mut normalize);
    assert!((strength - 1000.0 / PI).abs() < 1e-9 && normalize);
    let mut sun = Shape::Distant { angle: 0.1 };
    let (mut strength, mut normalize) = (3.0, false);
    modern(&mut sun, &mut strength, &mut normalize);
    assert_eq!((strength, normalize), (0.75, false));
}
