use super::*;

#[test]
fn full_values_are_one_and_grey_is_of_all_colours() {
    assert_eq!(
        Pixels::from(vec![255u8, 0]).texel(2, 0),
        Vec4::new(1.0, 1.0, 1.0, 0.0)
    );
    assert_eq!(Pixels::from(vec![65535u16]).texel(1, 0), Vec4::ONE);
    let decoded = decoded(Vec4::new(0.0, 1.0, 0.5, 0.5));
    assert!(
        (decoded - Vec4::new(0.0, 1.0, 0.214_041, 0.5))
            .abs()
            .max_element()
            < 1e-6
    );
    let nan = Pixels::from(vec![f32::NAN]);
    assert!(nan.is_same(&nan.clone()) && !nan.is_same(&Pixels::from(vec![0u8])));
}

#[test]
fn floats_are_codes_where_that_is_told() {
    let uses = [ImageUse::Color, ImageUse::Codes, ImageUse::Data];
    let of = |pixels: &Pixels| uses.map(|usage| pixels.is_encoded(usage));
    assert_eq!(of(&Pixels::from(vec![0u8])), [true, true, false]);
    assert_eq!(of(&Pixels::from(vec![0.5f32])), [false, true, false]);
}
