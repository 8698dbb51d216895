use super::*;
use std::ffi::OsStr;

fn default_config() -> Config {
    Config::from_file(OsStr::new("ocio://default")).unwrap()
}

#[test]
fn shim_and_library_belong_together() {
    let versions = check().unwrap();
    assert_eq!(versions.headers >> 16, versions.library >> 16);
    assert!(
        versions.library >= 0x0204_0000,
        "{}",
        versions.library_text()
    );
}

#[test]
fn a_struct_of_another_size_is_refused() {
    let mut abi = std::mem::MaybeUninit::<sys::SundogOcioAbi>::zeroed();
    // SAFETY: the size is wrong on purpose: the shim must write nothing.
    let written =
        unsafe { sys::sundog_ocio_abi(abi.as_mut_ptr(), size_of::<sys::SundogOcioAbi>() - 4) };
    assert!(!written);
}

#[test]
fn the_built_in_configuration_can_be_listed() {
    let config = default_config();
    assert!(config.name().unwrap().starts_with("cg-config-"));
    assert_eq!(config.profile().unwrap().0, 2);
    assert!(
        config
            .roles()
            .unwrap()
            .iter()
            .any(|role| role.name == "scene_linear" && role.colour_space == "ACEScg")
    );
    assert!(
        config
            .colour_spaces()
            .unwrap()
            .iter()
            .any(|space| space.name == "ACEScg" && !space.is_data)
    );
    let display = config.default_display().unwrap().unwrap();
    assert!(config.displays().unwrap().contains(&display));
    let view = config.default_view(&display).unwrap().unwrap();
    assert!(
        config
            .views(&display)
            .unwrap()
            .iter()
            .any(|listed| listed.name == view)
    );
    assert!(config.views("no such display").unwrap().is_empty());
    assert!(!config.looks().unwrap().is_empty());
    assert!(config.has_colour_space("scene_linear").unwrap());
    assert!(!config.has_colour_space("no such space").unwrap());
}

#[test]
fn converting_there_and_back_is_nothing() {
    let config = default_config();
    let rec709 = "Linear Rec.709 (sRGB)";
    let there = config.convert_processor(rec709, "ACEScg").unwrap();
    let back = config.convert_processor("ACEScg", rec709).unwrap();
    let before = [[0.18_f32, 0.5, 1.0], [0.0, -0.25, 4.0]];
    let mut pixels = before;
    there.apply_rgb(&mut pixels).unwrap();
    // Red of Rec.709 into AP1 with the Bradford adaptation, row by row: 0.6131 0.3395 0.0474 (S-2014-004's primaries).
    assert!(
        (pixels[0][0] - (0.6131 * 0.18 + 0.3395 * 0.5 + 0.0474)).abs() < 2e-4,
        "{pixels:?}"
    );
    back.apply_rgb(&mut pixels).unwrap();
    for (a, b) in pixels.iter().flatten().zip(before.iter().flatten()) {
        // Two 3×3 matrices in f32 on values up to 4.
        assert!((a - b).abs() <= 16.0 * f32::EPSILON * 4.0, "{a} {b}");
    }
    assert!(
        config
            .convert_processor("ACEScg", "ACEScg")
            .unwrap()
            .is_identity()
            .unwrap()
    );
}

#[test]
fn alpha_is_handed_through() {
    let config = default_config();
    let processor = config.convert_processor("ACEScg", "ACES2065-1").unwrap();
    let mut with_alpha = [[0.2_f32, 0.3, 0.4, 0.123]];
    let mut without = [[0.2_f32, 0.3, 0.4]];
    processor.apply_rgba(&mut with_alpha).unwrap();
    processor.apply_rgb(&mut without).unwrap();
    assert_eq!(with_alpha[0][..3], without[0]);
    assert_eq!(with_alpha[0][3], 0.123);
    processor.apply_rgb(&mut []).unwrap();
}

#[test]
fn exposure_and_gamma_come_at_the_two_ends() {
    let config = Config::from_text(LINEAR_WITH_RAW_VIEW.as_bytes()).unwrap();
    let chain = DisplayChain {
        source: Source::SceneLinear,
        display: "d",
        view: "v",
        look: None,
        scale: 4.0,
        display_scale: 1.0,
        exponent: 0.5,
    };
    let mut pixels = [[0.25_f32, 0.0625, 1.0]];
    config
        .display_processor(&chain)
        .unwrap()
        .apply_rgb(&mut pixels)
        .unwrap();
    for (value, wanted) in pixels[0].iter().zip([1.0_f32, 0.5, 2.0]) {
        // OpenColorIO's quick power is good to about 17 bits.
        assert!((value - wanted).abs() < 2e-5 * wanted, "{pixels:?}");
    }
}

const LINEAR_WITH_RAW_VIEW: &str = "ocio_profile_version: 2
roles: {default: lin, scene_linear: lin}
displays:
  d:
    - !<View> {name: v, colorspace: lin}
colorspaces:
  - !<ColorSpace>
    name: lin
";

#[test]
fn broken_texts_and_names_are_errors() {
    for text in [
        "",
        "no configuration",
        "ocio_profile_version: 99",
        "ocio_profile_version: [",
        "ocio_profile_version: 2\ncolorspaces: 3",
        "\0\0\0",
        "%YAML 9.9\n---\n!!binary AAAA",
    ] {
        let error = Config::from_text(text.as_bytes()).unwrap_err();
        assert!(
            !error.text.is_empty() && !error.text.contains('\n'),
            "{error:?}"
        );
    }
    // Nesting that a recursive reader could run out of stack with.
    let deep = format!("ocio_profile_version: 2\nroles: {}", "[".repeat(200_000));
    assert!(Config::from_text(deep.as_bytes()).is_err());
    assert!(Config::from_file(OsStr::new("/no/such/config.ocio")).is_err());
    assert!(Config::from_file(OsStr::new("ocio://no-such-config")).is_err());
    assert!(Config::from_file(OsStr::new("a\0b")).is_err());

    let config = default_config();
    assert!(config.convert_processor("ACEScg", "no such space").is_err());
    let chain = DisplayChain {
        source: Source::SceneLinear,
        display: "x",
        view: "y",
        look: None,
        scale: 1.0,
        display_scale: 1.0,
        exponent: 1.0,
    };
    assert!(config.display_processor(&chain).is_err());
}

#[test]
fn a_configuration_without_a_way_to_rec709_says_so() {
    let config = Config::from_text(LINEAR_WITH_RAW_VIEW.as_bytes()).unwrap();
    assert!(config.is_scene_linear_rec709().is_err());
    assert!(Config::raw().unwrap().is_scene_linear_rec709().is_err());
}

#[test]
fn pixels_of_every_kind_and_from_many_threads() {
    let config = default_config();
    let display = config.default_display().unwrap().unwrap();
    let view = config.default_view(&display).unwrap().unwrap();
    assert!(!config.is_scene_linear_rec709().unwrap());
    let chain = DisplayChain {
        source: Source::LinearRec709,
        display: &display,
        view: &view,
        look: None,
        scale: 2.0,
        display_scale: 1.0,
        exponent: 0.8,
    };
    let processor = config.display_processor(&chain).unwrap();
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        -0.0,
        1e-45,
        0.5,
    ];
    let count = odd.len();
    let pixels: Vec<[f32; 3]> = (0..count * count * count)
        .map(|index| {
            [
                odd[index / count / count],
                odd[index / count % count],
                odd[index % count],
            ]
        })
        .collect();
    let mut alone = pixels.clone();
    processor.apply_rgb(&mut alone).unwrap();
    let bits = |pixels: &[[f32; 3]]| {
        pixels
            .iter()
            .flatten()
            .map(|value| value.to_bits())
            .collect::<Vec<_>>()
    };
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let mut mine = pixels.clone();
                processor.apply_rgb(&mut mine).unwrap();
                assert_eq!(bits(&mine), bits(&alone));
            });
        }
    });
}

#[test]
fn a_configuration_may_be_asked_from_many_threads() {
    let config = default_config();
    let display = config.default_display().unwrap().unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..20 {
                    assert!(!config.views(&display).unwrap().is_empty());
                    assert!(config.convert_processor("ACEScg", "ACES2065-1").is_ok());
                }
            });
        }
    });
}
