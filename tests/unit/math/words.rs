use super::*;

#[test]
fn one_is_not_many() {
    assert_eq!(counted(0, "mesh", "meshes"), "0 meshes");
    assert_eq!(counted(1, "mesh", "meshes"), "1 mesh");
    assert_eq!(counted(2, "mesh", "meshes"), "2 meshes");
    assert_eq!(counted(1.5, "sample", "samples"), "1.5 samples");
    assert_eq!(counted("1 000", "sample", "samples"), "1 000 samples");
}

#[test]
fn numbers_for_people() {
    assert_eq!(grouped(0), "0");
    assert_eq!(grouped(999), "999");
    assert_eq!(grouped(1000), "1 000");
    assert_eq!(grouped(1_234_567), "1 234 567");
    assert_eq!(bytes(1023), "1023 B");
    assert_eq!(bytes(1024), "1.0 KiB");
    assert_eq!(bytes(3 * 1024 * 1024 / 2), "1.5 MiB");
    assert_eq!(clock(5.34), "5.3 s");
    assert_eq!(clock(75.3), "1:15");
    assert_eq!(clock(4000.0), "1:06:40");
}

#[test]
fn shares_and_times_have_two_digits() {
    assert_eq!(percent(0.0237), "2.4 %");
    assert_eq!(percent(0.237), "24 %");
    assert_eq!(percent(0.000_237), "0.024 %");
    assert_eq!(percent(2.0), "200 %");
    assert_eq!(percent(0.0), "0 %");
    assert_eq!(estimated(0.0214, 0.019_32, 0.1), "2.14 % (1.93 to 10.0 %)");
    assert_eq!(duration(0.012), "12 ms");
    assert_eq!(duration(-0.5), "-0.50 s");
    assert_eq!(duration(4.23), "4.2 s");
    assert_eq!(duration(42.3), "42 s");
    assert_eq!(duration(75.3), "1:15");
    assert_eq!(duration(f64::INFINITY), "for ever");
}
