use super::*;

#[test]
fn rounding_goes_to_the_nearest_value_and_stays_in_range() {
    for code in 0..=255_u8 {
        let exact = f32::from(code) / 255.0;
        assert_eq!(to_8_bits(exact), code);
        assert_eq!(to_8_bits(exact + 0.49 / 255.0), code);
        assert_eq!(to_8_bits(exact - 0.49 / 255.0), code);
    }
    for code in (0..=65535_u16).step_by(7) {
        assert_eq!(to_16_bits(f32::from(code) / 65535.0), code);
    }
    for (value, eight, sixteen) in [
        (f32::NAN, 0, 0),
        (f32::INFINITY, 255, 65535),
        (f32::NEG_INFINITY, 0, 0),
        (-1.0, 0, 0),
        (1e30, 255, 65535),
        (1.0, 255, 65535),
    ] {
        assert_eq!(to_8_bits(value), eight, "{value}");
        assert_eq!(to_16_bits(value), sixteen, "{value}");
    }
}

#[test]
fn alpha_is_divided_out_where_it_can_be() {
    assert_eq!(unassociated([0.25, 0.5, 1.0, 0.5]), [0.5, 1.0, 2.0]);
    assert_eq!(unassociated([0.25, 0.5, 1.0, 0.0]), [0.25, 0.5, 1.0]);
    assert_eq!(unassociated([0.25, 0.5, 1.0, 1.0]), [0.25, 0.5, 1.0]);
}
