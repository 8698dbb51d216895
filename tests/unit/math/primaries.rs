use super::*;

#[test]
fn matrices_are_those_that_blender_converts_with() {
    // What `Image.pixels` of Blender 5.0.1 shows of a float image that is said to be in linear Rec.709.
    let light = DVec3::new(0.906_333_86, 0.484_528_66, 0.349_189_13);
    for (space, wanted) in [
        (
            WorkingSpace::AcesCg,
            DVec3::new(0.736_724_08, 0.512_316_11, 0.375_504_14),
        ),
        (
            WorkingSpace::Rec2020,
            DVec3::new(0.743_308_96, 0.512_136_40, 0.370_233_27),
        ),
    ] {
        let there = space.matrix_from_rec709().unwrap() * light;
        // Its configuration has the matrices with seven digits and more.
        assert!(
            (there - wanted).abs().max_element() < 2e-6,
            "{space}: {there}"
        );
        let back = space.matrix_to_rec709().unwrap() * there;
        assert!(
            (back - light).abs().max_element() < 1e-14,
            "{space}: {back}"
        );
        let white = space.matrix_from_rec709().unwrap() * DVec3::ONE;
        assert!((white - DVec3::ONE).abs().max_element() < 1e-14, "{white}");
    }
    assert!(WorkingSpace::Rec709.matrix_from_rec709().is_none());
}

#[test]
fn spaces_are_known_by_their_primaries() {
    for space in WorkingSpace::ALL {
        let round = |v: [f64; 2]| v.map(|v| f64::from(v as f32));
        let own = space.primaries();
        let read = Primaries {
            red: round(own.red),
            green: round(own.green),
            blue: round(own.blue),
            white: round(own.white),
        };
        assert_eq!(WorkingSpace::with_primaries(&read), Some(space));
        let other = Primaries {
            red: [0.68, 0.32],
            ..own
        };
        assert_eq!(WorkingSpace::with_primaries(&other), None);
    }
}
