use super::*;

#[test]
fn four_digits_and_no_more() {
    for (value, expected) in [
        (0.0, "0"),
        (1.0, "1"),
        (0.031_249_9, "0.03125"),
        (12.5, "12.5"),
        (9.999_96, "10"),
        (1280.0, "1280"),
        (921_600.0, "921\u{202f}600"),
        (12_345.6, "12\u{202f}350"),
        (3.1e-7, "3.1e−7"),
        (-0.5, "−0.5"),
        (1e9, "1e9"),
        (f64::INFINITY, "∞"),
        (f64::NAN, "not a number"),
    ] {
        assert_eq!(number(value), expected);
    }
}

#[test]
fn units_follow() {
    assert_eq!(with_unit(2.0, "s"), "2\u{a0}s");
    assert_eq!(with_unit(2.0, ""), "2");
}
