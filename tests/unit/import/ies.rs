use super::*;
use glam::Vec3;

/// A file with values for vertical angles 0, 90, 180 and horizontal ones.
fn file(horizontal: &[f64], value: impl Fn(f64, f64) -> f64) -> String {
    let vertical = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0];
    let list = |angles: &[f64]| angles.iter().map(|a| format!("{a} ")).collect::<String>();
    let mut text = format!(
        "IESNA:LM-63-2002\n[TEST] a lamp\nTILT=NONE\n1 1000 2.0 {} {} 1 2 0 0 0\n1.5 1.0 40\n{}\n{}\n",
        vertical.len(),
        horizontal.len(),
        list(&vertical),
        list(horizontal)
    );
    for h in horizontal {
        let row: Vec<f64> = vertical.iter().map(|v| value(*v, *h)).collect();
        text += &format!("{}\n", list(&row));
    }
    text
}

fn toward(down: f64, around: f64) -> Vec3 {
    let (down, around) = (down.to_radians(), around.to_radians());
    let (sin, cos) = down.sin_cos();
    Vec3::new(
        (sin * around.cos()) as f32,
        (sin * around.sin()) as f32,
        -cos as f32,
    )
}

#[test]
fn a_lamp_that_shines_evenly() {
    let lamp = parse(file(&[0.0], |_, _| 100.0).as_bytes()).unwrap();
    // Multiplier 2 and ballast 1.5.
    assert!((lamp.mean - 300.0).abs() < 1e-9, "{}", lamp.mean);
    for (down, around) in [(0.0, 0.0), (45.0, 10.0), (90.0, 200.0), (170.0, 359.0)] {
        let found = lamp.candela.of(toward(down, around));
        assert!((found - 300.0).abs() < 1e-3, "{found}");
    }
}

#[test]
fn angles_go_from_x_to_y() {
    let all: Vec<f64> = (0..=24).map(|i| f64::from(i) * 15.0).collect();
    // Brightest toward +Y: the horizontal angle 90.
    let value = |_: f64, h: f64| 2.0 + (h - 90.0).to_radians().cos();
    let lamp = parse(file(&all, value).as_bytes()).unwrap();
    for around in [0.0f64, 45.0, 90.0, 180.0, 270.0, 300.0] {
        let found = f64::from(lamp.candela.of(toward(60.0, around)));
        let expected = 3.0 * value(0.0, around);
        assert!(
            (found / expected - 1.0).abs() < 2e-3,
            "{around}: {found} for {expected}"
        );
    }
    assert!((lamp.mean - 6.0).abs() < 1e-6, "{}", lamp.mean);
}

#[test]
fn quarters_and_halves_are_mirrored() {
    let value = |_: f64, h: f64| 1.0 + h.to_radians().cos().powi(2);
    for (from, to) in [(0, 90), (0, 180), (90, 270), (0, 360)] {
        let angles: Vec<f64> = (from / 15..=to / 15).map(|i| f64::from(i) * 15.0).collect();
        let lamp = parse(file(&angles, value).as_bytes()).unwrap();
        for around in [0.0f64, 60.0, 120.0, 210.0, 345.0] {
            let found = f64::from(lamp.candela.of(toward(90.0, around)));
            let expected = 3.0 * value(0.0, around);
            let off = (found / expected - 1.0).abs();
            assert!(
                off < 3e-3,
                "{from} to {to}, {around}: {found} for {expected}"
            );
        }
    }
}

#[test]
fn only_below_is_dark_above() {
    let text = "IESNA:LM-63-1995\nTILT=INCLUDE\n1\n2\n0 90\n1 1\n1 -1 1 3 1 1 2 0 0 0 1 1 0\n0 45 90\n0\n8 8 8\n";
    let lamp = parse(text.as_bytes()).unwrap();
    assert!((lamp.candela.of(toward(20.0, 0.0)) - 8.0).abs() < 1e-4);
    assert_eq!(lamp.candela.of(toward(120.0, 0.0)), 0.0);
    assert!((lamp.mean - 4.0).abs() < 1e-9);
}

#[test]
fn what_is_broken_has_a_sentence() {
    let good = file(&[0.0, 90.0], |_, _| 1.0);
    for cut in (0..good.len()).step_by(7) {
        let _ = parse(&good.as_bytes()[..cut]);
    }
    for (from, to) in [
        ("TILT=NONE", "TILD=NONE"),
        ("2.0 7", "2.0 70000000"),
        ("2.0 7", "2.0 -1"),
        ("0 30 60", "0 60 30"),
        ("1.5 1.0", "x 1.0"),
    ] {
        assert!(good.contains(from));
        assert!(parse(good.replace(from, to).as_bytes()).is_err(), "{to}");
    }
    let other = parse(good.replace("7 2 1 2", "7 2 2 2").as_bytes()).unwrap();
    assert!(other.is_of_another_type);
}
