use super::*;
use crate::color::DisplaySamples;

fn built_in() -> ColorConfig {
    ColorConfig::locate(Some(Path::new(
        "ocio://cg-config-v2.1.0_aces-v1.3_ocio-v2.3",
    )))
    .unwrap()
}

fn view(display: &str, view: &str) -> DisplayTransform {
    DisplayTransform {
        display: Some(display.to_owned()),
        view: Some(view.to_owned()),
        ..DisplayTransform::default()
    }
}

fn eight_bits(processor: &DisplayProcessor, colors: SceneColors<'_>) -> Vec<u8> {
    match processor.show(colors, Depth::Eight).unwrap().samples {
        DisplaySamples::Eight(values) => values,
        DisplaySamples::Sixteen(_) => panic!("8 bits were asked for"),
    }
}

const SRGB: &str = "sRGB - Display";
const PLAIN: &str = "Un-tone-mapped";

#[test]
fn light_is_brought_from_rec709_to_the_working_space_of_the_configuration() {
    // Its scene_linear is ACEScg; its plain sRGB view must give back what Rec.709 light is in sRGB.
    let processor = built_in().processor(&view(SRGB, PLAIN)).unwrap();
    let colours = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0; 3],
        [0.18; 3],
        [0.5, 0.02, 0.1],
    ];
    // IEC 61966-2-1.
    let encode = |v: f32| {
        if v <= 0.003_130_8 {
            12.92 * v
        } else {
            1.055 * v.powf(1.0 / 2.4) - 0.055
        }
    };
    let shown = eight_bits(&processor, SceneColors::Rgb(&colours));
    for (code, light) in shown.iter().zip(colours.iter().flatten()) {
        let wanted = (encode(*light) * 255.0).round();
        assert!(
            (f32::from(*code) - wanted).abs() <= 1.0,
            "{code} for {light}, not {wanted}"
        );
    }
}

#[test]
fn exposure_counts_stops_and_gamma_is_a_power() {
    let config = built_in();
    let shown = |exposure, gamma, light: f32| {
        let wanted = DisplayTransform {
            exposure,
            gamma,
            ..view(SRGB, PLAIN)
        };
        let mut pixels = [[light; 3]];
        config
            .processor(&wanted)
            .unwrap()
            .show_in_place(&mut pixels)
            .unwrap();
        pixels[0][1]
    };
    // OpenColorIO's quick logarithms and powers are good to about 1e-5.
    assert!((shown(2.0, 1.0, 0.1) - shown(0.0, 1.0, 0.4)).abs() < 3e-5);
    assert!((shown(-1.0, 1.0, 0.4) - shown(0.0, 1.0, 0.2)).abs() < 3e-5);
    assert!((shown(0.0, 2.0, 0.3) - shown(0.0, 1.0, 0.3).sqrt()).abs() < 3e-5);
}

#[test]
fn what_is_left_open_is_what_the_configuration_says() {
    let config = built_in();
    let resolved = config.resolve(&DisplayTransform::default()).unwrap();
    assert_eq!(resolved.display, config.default_display().unwrap());
    let displays = config.displays().unwrap();
    let display = displays
        .iter()
        .find(|display| display.name == resolved.display)
        .unwrap();
    assert_eq!(resolved.view, display.default_view);
    assert_eq!(resolved.look, None);
    let none = DisplayTransform {
        look: Some("None".to_owned()),
        ..DisplayTransform::default()
    };
    assert_eq!(config.resolve(&none).unwrap(), resolved);
}

#[test]
fn what_is_not_there_is_an_error_that_lists_what_is() {
    let config = built_in();
    let error = |wanted: DisplayTransform| config.processor(&wanted).unwrap_err().to_string();
    let display = error(view("No such display", PLAIN));
    assert!(
        display.contains("'No such display'") && display.contains(SRGB),
        "{display}"
    );
    let missing = error(view(SRGB, "Filmic"));
    assert!(
        missing.contains("'Filmic'") && missing.contains(PLAIN) && missing.contains(SRGB),
        "{missing}"
    );
    // The case of letters counts; nothing is guessed.
    assert!(error(view("srgb - display", PLAIN)).contains(SRGB));
    let look = error(DisplayTransform {
        look: Some("Punchy".to_owned()),
        ..view(SRGB, PLAIN)
    });
    assert!(
        look.contains("'Punchy'") && look.contains("there are: "),
        "{look}"
    );
    for text in [&display, &missing, &look] {
        assert!(!text.contains('\n'));
    }
}

#[test]
fn senseless_numbers_are_errors() {
    let config = built_in();
    for (exposure, gamma) in [
        (f64::NAN, 1.0),
        (f64::INFINITY, 1.0),
        (1e9, 1.0),
        (0.0, 0.0),
        (0.0, -1.0),
        (0.0, f64::NAN),
    ] {
        let wanted = DisplayTransform {
            exposure,
            gamma,
            ..DisplayTransform::default()
        };
        assert!(matches!(
            config.processor(&wanted),
            Err(ColorError::OutOfRange { .. })
        ));
    }
}

#[test]
fn a_named_configuration_that_cannot_be_read_is_an_error_of_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("text.ocio"), "this is no configuration").unwrap();
    std::fs::write(path("empty.ocio"), "").unwrap();
    std::fs::write(path("future.ocio"), "ocio_profile_version: 47\n").unwrap();
    std::fs::write(path("archive.ocioz"), "PK\x03\x04 but no archive").unwrap();
    std::fs::write(
        path("bytes.ocio"),
        (0..=255).cycle().take(5000).collect::<Vec<u8>>(),
    )
    .unwrap();
    for name in [
        "text.ocio",
        "empty.ocio",
        "future.ocio",
        "archive.ocioz",
        "bytes.ocio",
    ] {
        let error = ColorConfig::locate(Some(&path(name))).unwrap_err();
        assert!(
            matches!(error, ColorError::Broken { .. }),
            "{name}: {error:?}"
        );
        let text = error.to_string();
        assert!(
            text.contains(name) && text.contains("--ocio") && !text.contains('\n'),
            "{text}"
        );
    }
    for named in [folder.path(), &path("missing.ocio"), Path::new("/dev/zero")] {
        let error = ColorConfig::locate(Some(named)).unwrap_err();
        assert!(matches!(error, ColorError::Missing { .. }), "{error:?}");
    }
    let error = ColorConfig::locate(Some(Path::new("ocio://no-such-one")))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("ocio://no-such-one") && !error.contains('\n'),
        "{error}"
    );
}

#[test]
fn a_broken_one_that_a_search_found_is_passed_over_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder
        .path()
        .join("opt/blender-9.9/9.9/datafiles/colormanagement");
    std::fs::create_dir_all(&data).unwrap();
    std::fs::write(data.join("config.ocio"), "ocio_profile_version: 47\n").unwrap();
    let mut places = SearchPlaces {
        root: folder.path().to_owned(),
        ..SearchPlaces::default()
    };
    let config = ColorConfig::locate_in(None, &places).unwrap();
    assert_eq!(
        config.origin(),
        &ConfigOrigin::BuiltIn("ocio://default".into())
    );
    assert!(
        config
            .warnings()
            .iter()
            .any(|warning| warning.contains("blender-9.9")),
        "{:?}",
        config.warnings()
    );
    // But what $OCIO names is not passed over.
    places.ocio = Some(data.join("config.ocio").into());
    assert!(matches!(
        ColorConfig::locate_in(None, &places),
        Err(ColorError::Broken { .. })
    ));
}

#[test]
fn a_table_that_is_missing_and_a_space_that_is_unknown_are_sentences() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("config.ocio");
    let text = "ocio_profile_version: 2.1\nsearch_path: luts\nroles: {default: lin, scene_linear: lin}\n\
                displays:\n  d:\n    - !<View> {name: v, colorspace: shown}\n\
                colorspaces:\n  - !<ColorSpace>\n    name: lin\n  - !<ColorSpace>\n    name: shown\n    \
                from_scene_reference: !<FileTransform> {src: table.cube}\n";
    std::fs::write(&path, text).unwrap();
    let config = ColorConfig::locate(Some(&path)).unwrap();
    let error = config.processor(&DisplayTransform::default()).unwrap_err();
    assert!(matches!(error, ColorError::NoRec709 { .. }), "{error:?}");
    let known = text.replace(
        "scene_linear: lin}",
        "scene_linear: lin, aces_interchange: lin}",
    );
    std::fs::write(&path, known).unwrap();
    let config = ColorConfig::locate(Some(&path)).unwrap();
    let error = config.processor(&DisplayTransform::default()).unwrap_err();
    assert!(matches!(error, ColorError::Unmakeable { .. }), "{error:?}");
    assert!(error.to_string().contains("table.cube"), "{error}");
}

#[test]
fn pixels_of_every_kind_can_be_shown_in_every_view() {
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        1e-45,
        -0.0,
        65504.0,
        0.5,
    ];
    let count = odd.len();
    let pixels: Vec<[f32; 4]> = (0..count.pow(4))
        .map(|index| std::array::from_fn(|channel| odd[index / count.pow(channel as u32) % count]))
        .collect();
    let config = ColorConfig::locate(Some(Path::new("ocio://default"))).unwrap();
    for display in config.displays().unwrap() {
        for listed in display.views {
            let looks = listed
                .looks
                .iter()
                .map(|look| Some(look.clone()))
                .chain([None]);
            for look in looks {
                let wanted = DisplayTransform {
                    look,
                    exposure: 3.0,
                    gamma: 1.5,
                    ..view(&display.name, &listed.name)
                };
                let processor = config.processor(&wanted).unwrap();
                assert_eq!(
                    eight_bits(&processor, SceneColors::Rgba(&pixels)).len(),
                    pixels.len() * 4
                );
                assert_eq!(
                    eight_bits(&processor, SceneColors::RgbaOnBlack(&pixels)).len(),
                    pixels.len() * 3
                );
            }
        }
    }
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let config = built_in();
    let processor = config.processor(&DisplayTransform::default()).unwrap();
    let pixels: Vec<[f32; 3]> = (0..20_001)
        .map(|i| [i as f32 * 1e-4, (i % 977) as f32 * 1e-3, (i % 13) as f32])
        .collect();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            processor
                .show(SceneColors::Rgb(&pixels), Depth::Sixteen)
                .unwrap()
        })
    };
    let alone = with(1);
    assert_eq!(alone.channels, 3);
    assert_eq!(with(2), alone);
    assert_eq!(with(7), alone);
    assert!(processor.show(SceneColors::Rgb(&[]), Depth::Eight).is_ok());
}
