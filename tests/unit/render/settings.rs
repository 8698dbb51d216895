use super::*;

#[test]
fn the_size_follows_the_camera() {
    assert_eq!(picture_size(Some(2.0), None, None), (1280, 640));
    assert_eq!(picture_size(Some(0.5), None, None), (640, 1280));
    assert_eq!(picture_size(None, None, None), (1280, 720));
    assert_eq!(picture_size(Some(2.0), Some(100), None), (100, 50));
    assert_eq!(picture_size(Some(2.0), None, Some(100)), (200, 100));
    assert_eq!(picture_size(Some(2.0), Some(7), Some(9)), (7, 9));
    assert_eq!(picture_size(Some(1e9), None, None), (1280, 1));
    assert_eq!(picture_size(Some(1e-9), Some(10), None), (10, 65_536));
}

#[test]
fn regions() {
    let expected = Region {
        x0: 0,
        y0: 10,
        x1: 5,
        y1: 11,
    };
    assert_eq!(Region::from_str("0,10, 5,11"), Ok(expected));
    for wrong in [
        "",
        "0,0,1",
        "0,0,1,1,1",
        "5,0,5,1",
        "0,2,1,1",
        "-1,0,1,1",
        "0,0,1.5,1",
        "0,0,99999999999,1",
    ] {
        assert!(Region::from_str(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn filters() {
    let gauss = Filter {
        kind: FilterKind::Gauss,
        width: 2.0,
    };
    assert_eq!(Filter::from_str("gauss:2"), Ok(gauss));
    assert_eq!(Filter::from_str("blackman-harris"), Ok(Filter::default()));
    let of_a_pixel = Filter {
        kind: FilterKind::Box,
        width: 1.0,
    };
    assert_eq!(Filter::from_str("box"), Ok(of_a_pixel));
    for wrong in [
        "",
        "sinc",
        "box:2",
        "gauss:",
        "gauss:0",
        "gauss:nan",
        "gauss:11",
    ] {
        assert!(Filter::from_str(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn effect_lists() {
    assert_eq!(EffectChoice::from_str("auto"), Ok(EffectChoice::Auto));
    assert_eq!(
        EffectChoice::from_str("a,b"),
        Ok(EffectChoice::List(vec!["a".into(), "b".into()]))
    );
    assert!(EffectChoice::from_str("a,,b").is_err());
    assert!(EffectChoice::from_str("").is_err());
}
