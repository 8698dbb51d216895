use super::*;

#[test]
fn a_reduced_picture_keeps_its_shape_and_its_region() {
    let settings = RenderSettings {
        width: 1280,
        height: 720,
        region: Some(Region {
            x0: 640,
            y0: 0,
            x1: 1280,
            y1: 1,
        }),
        ..RenderSettings::default()
    };
    let small = reduced(&settings, 256);
    assert_eq!((small.width, small.height), (256, 144));
    let region = Region {
        x0: 128,
        y0: 0,
        x1: 256,
        y1: 1,
    };
    assert_eq!(small.region, Some(region));
    assert_eq!(reduced(&settings, 1280).width, 1280);
    let thin = RenderSettings {
        width: 60_000,
        height: 1,
        ..RenderSettings::default()
    };
    assert_eq!(
        (reduced(&thin, 256).width, reduced(&thin, 256).height),
        (256, 1)
    );
}
