//! Pages of every kind of section, with known numbers, for tests/report/run.py, which opens them in Chromium.

use std::path::{Path, PathBuf};
use sundog::report::{
    Axis, Cell, Column, HeatMap, HeatMaps, Line, Page, PageImage, Plot, Point, Section, Series,
    Settings, Slider, Table,
};

/// Where tests/report/run.py looks for the pages.
fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Error over time of 40 % / √samples at 20 ms a sample, `factor` times as high.
fn falling(name: &str, factor: f64, passes: u32) -> Series {
    let points = (0..passes).map(|pass| {
        let samples = f64::from(1 << pass);
        let error = factor * 40.0 / samples.sqrt();
        Point::new(0.02 * samples, error)
            .spread(0.9 * error, 1.1 * error)
            .labelled(format!("{samples} samples"))
    });
    Series::new(name, points.collect())
}

fn curves() -> Plot {
    let fit = [0.02, 20.48].map(|time: f64| Point::new(time, 40.0 * (0.02 / time).sqrt()));
    let mut noisy = falling("Cycles", 1.7, 9);
    noisy.points.push(Point::new(10.0, f64::NAN));
    Plot {
        title: "Error over time".into(),
        note: "The mean of four seeds; the thin lines go from the least to the largest.".into(),
        x: Axis::log("time", "s"),
        y: Axis::log("error", "%"),
        series: vec![
            falling("uniform", 1.0, 11),
            falling("adaptive", 0.7, 11),
            noisy,
            Series::fitted("fit, slope −0.500", fit.to_vec()),
        ],
    }
}

fn histogram() -> Plot {
    let points = (0..30).map(|bin| {
        let center = 10f64.powf(-2.0 + f64::from(bin) / 10.0);
        let share = 12.0 * (-(f64::from(bin) - 14.0).powi(2) / 40.0).exp();
        Point::new(center, share)
    });
    Plot {
        title: "Pixels by their error".into(),
        note: String::new(),
        x: Axis::log("error of the pixel", "%"),
        y: Axis::linear("pixels", "%"),
        series: vec![Series {
            line: Line::Bars,
            ..Series::new("pixels", points.collect())
        }],
    }
}

const SIZE: (u32, u32) = (320, 180);

fn picture(name: &str, color: impl Fn(u32, u32) -> [u8; 3]) -> PageImage {
    let rgb = (0..SIZE.1)
        .flat_map(|y| (0..SIZE.0).map(move |x| (x, y)))
        .flat_map(|(x, y)| color(x, y))
        .collect();
    PageImage {
        name: name.into(),
        width: SIZE.0,
        height: SIZE.1,
        rgb,
    }
}

/// A map whose value at column x and row y is known.
fn map(name: &str, unit: &str, log: bool, value: impl Fn(u32, u32) -> f32) -> HeatMap {
    HeatMap {
        name: name.into(),
        unit: unit.into(),
        note: String::new(),
        width: SIZE.0,
        height: SIZE.1,
        values: (0..SIZE.1)
            .flat_map(|y| (0..SIZE.0).map(move |x| (x, y)))
            .map(|(x, y)| value(x, y))
            .collect(),
        log,
        brightest: None,
    }
}

fn heat_maps() -> HeatMaps {
    let distance = |x: u32, y: u32| glam::Vec2::new(x as f32 - 160.0, y as f32 - 90.0).length();
    HeatMaps {
        title: "Where".into(),
        note: "Each pixel's own.".into(),
        maps: vec![
            map("Error", "%", true, |x, y| match (x, y) {
                (0, 0) => f32::NAN,
                (1, 0) => 0.0,
                _ => 10f32.powf(2.0 - distance(x, y) / 60.0),
            }),
            map("Samples", "", false, |x, y| (x + 1000 * (y / 60)) as f32),
            map("Time", "ns", false, |x, y| 1e5 * (1.0 + distance(x, y))),
        ],
    }
}

fn table() -> Table {
    let row = |name: &str, seconds: f64, error: f64| {
        vec![Cell::text(name), Cell::number(seconds), Cell::number(error)]
    };
    Table {
        title: "Scenes".into(),
        note: "Each column can be sorted.".into(),
        columns: vec![
            Column::new("scene"),
            Column::explained("time (s)", "of tracing alone"),
            Column::explained("error (%)", "√relMSE"),
        ],
        rows: vec![
            row("cornell", 9.5, 2.0),
            row("glass", 120.0, f64::NAN),
            row("foliage", 0.031, 11.25),
            row("window room", 14_400.0, 0.5),
        ],
    }
}

fn settings() -> Settings {
    let row = |name: &str, a: &str, b: &str| (name.to_owned(), vec![a.to_owned(), b.to_owned()]);
    Settings {
        title: "Settings".into(),
        note: "What differs is marked.".into(),
        columns: vec!["shot.exr".into(), "reference.exr".into()],
        rows: vec![
            row("samples", "64", "16384"),
            row("bounces", "12", "12"),
            row(
                "scene",
                "a-very-long-name-of-a-scene-without-a-space.glb",
                "b.glb",
            ),
        ],
    }
}

fn page() -> Page {
    Page {
        title: "What accuracy costs: <three> & \"more\"".into(),
        subtitle: "Every kind of section, with known numbers".into(),
        sections: vec![
            Section::Text {
                title: "In words".into(),
                paragraphs: vec!["Text is text: <script>alert(1)</script>".into()],
            },
            Section::Curves(curves()),
            Section::Table(table()),
            Section::Slider(Slider {
                title: "Before and after".into(),
                note: String::new(),
                pictures: vec![
                    picture("red", |_, _| [220, 30, 30]),
                    picture("blue", |_, _| [30, 60, 220]),
                    picture("ramp", |x, y| {
                        [(x * 255 / 319) as u8, (y * 255 / 179) as u8, 90]
                    }),
                ],
            }),
            Section::HeatMaps(heat_maps()),
            Section::Curves(histogram()),
            Section::Settings(settings()),
        ],
    }
}

#[test]
fn pages_for_the_browser_can_be_made() {
    let folder = folder();
    let html = page().html().unwrap();
    assert!(html.len() < 2_000_000, "{} bytes", html.len());
    std::fs::write(folder.join("page.html"), html).unwrap();
    let many = (0..9).map(|n| falling(&format!("curve {n}"), 1.3f64.powi(n), 8));
    let plots = [
        ("curves", curves()),
        ("histogram", histogram()),
        ("empty", Plot::default()),
        (
            "many",
            Plot {
                series: many.collect(),
                ..curves()
            },
        ),
    ];
    for (name, plot) in plots {
        std::fs::write(folder.join(format!("{name}.svg")), plot.svg().unwrap()).unwrap();
        std::fs::write(folder.join(format!("{name}.png")), plot.png(1200).unwrap()).unwrap();
    }
}

/// A picture of 100 × 100 pixels with the layers that a render may have. Its upper half is `factor` times as bright as
/// the lower one.
fn write_exr(path: &Path, factor: f32) {
    use sundog::film;
    let layer = |name: &str, channels: &[&str], value: &dyn Fn(usize) -> f32| film::Layer {
        name: name.into(),
        channels: channels.iter().map(|channel| (*channel).into()).collect(),
        data: (0..100 * 100)
            .flat_map(|pixel| std::iter::repeat_n(value(pixel), channels.len()))
            .collect(),
    };
    let picture = film::Picture {
        width: 100,
        height: 100,
        layers: vec![
            layer("Combined", &["R", "G", "B"], &|pixel| {
                if pixel < 5000 { 0.5 * factor } else { 0.5 }
            }),
            layer("Error", &["X"], &|pixel| 0.01 + pixel as f32 * 1e-6),
            layer("Debug Sample Count", &["X"], &|pixel| {
                (16 << (pixel % 3)) as f32
            }),
            layer("Cost", &["X"], &|pixel| 1e4 + pixel as f32),
        ],
    };
    let metadata = vec![
        ("sundog/samples".to_owned(), "64".to_owned()),
        (
            "sundog/settings".to_owned(),
            format!(r#"{{"seed":1,"factor":{factor}}}"#),
        ),
    ];
    sundog::output::exr::write(path, &picture, &Default::default(), &metadata).unwrap();
}

#[test]
fn a_comparison_for_the_browser_can_be_made() {
    let folder = folder();
    write_exr(&folder.join("shot.exr"), 1.1);
    write_exr(&folder.join("reference.exr"), 1.0);
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_sundog"))
        .args(["compare", "shot.exr", "reference.exr", "--report"])
        .arg("compare.html")
        .current_dir(&folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let page = std::fs::read_to_string(folder.join("compare.html")).unwrap();
    for text in ["settings.factor", "1.1", "5000 pixels (50 %) are equal"] {
        assert!(page.contains(text), "{text}");
    }
}
