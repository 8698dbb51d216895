use super::*;
use crate::report::Axis;

fn plot(series: Vec<Series>) -> Plot {
    Plot {
        title: "Error over time".into(),
        note: String::new(),
        x: Axis::log("time", "s"),
        y: Axis::log("error", "%"),
        series,
    }
}

fn halving() -> Series {
    let points = (0..8)
        .map(|i| Point::new(f64::from(1 << i), 40.0 / f64::from(1 << i).sqrt()))
        .collect();
    Series::new("uniform", points)
}

#[test]
fn text_in_svg_is_text() {
    let svg = plot(vec![halving(), Series::fitted("fit <&>", vec![])])
        .svg()
        .unwrap();
    for text in [
        "Error over time",
        "time (s)",
        "error (%)",
        "uniform",
        "fit &lt;&amp;&gt;",
        "100",
    ] {
        assert!(
            svg.contains(&format!(">\n{text}\n</text>")) || svg.contains(text),
            "{text}"
        );
    }
    assert!(svg.starts_with("<svg width=\"860\" height=\"540\" viewBox=\"0 0 3440 2160\""));
}

#[test]
fn png_has_text_without_fonts_of_the_system() {
    // The name of the axis stands below the frame; without it the same rows are white.
    let ink = |x: Axis| {
        let plot = Plot {
            x,
            ..plot(vec![halving()])
        };
        let picture = image::load_from_memory(&plot.png(860).unwrap()).unwrap();
        let rows = picture.to_rgb8();
        let pixels = rows.enumerate_pixels().filter(|(_, y, _)| *y > 515);
        pixels.filter(|(_, _, pixel)| pixel.0 != [255; 3]).count()
    };
    assert!(ink(Axis::log("time", "s")) > 100);
    assert_eq!(ink(Axis::log("", "")), 0);
}

#[test]
fn empty_and_single_points_are_drawn() {
    for series in [
        vec![],
        vec![Series::new("none", vec![])],
        vec![Series::new(
            "one",
            vec![Point::new(1.0, 1.0).spread(0.0, 2.0)],
        )],
        vec![Series {
            line: Line::Bars,
            ..Series::new("bar", vec![Point::new(1.0, 1.0)])
        }],
    ] {
        let plot = plot(series);
        assert_eq!(
            plot.svg().unwrap().contains("no points to show"),
            plot.shown_points() == 0
        );
        assert!(plot.png(200).is_ok());
    }
}

#[test]
fn what_has_no_place_is_left_out_and_said() {
    let series = Series::new(
        "noisy",
        [1.0, f64::NAN, f64::INFINITY, 0.0, -1.0, 3.0]
            .map(|y| Point::new(2.0, y))
            .to_vec(),
    );
    let plot = plot(vec![series]);
    let sentence = "4 points of 6 are left out: not finite, or not above 0 on a logarithmic axis";
    assert_eq!(plot.left_out_sentence().as_deref(), Some(sentence));
    let svg = plot.svg().unwrap();
    assert!(svg.contains(sentence));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn a_fit_has_the_colour_of_its_curve() {
    let fit = || Series::fitted("fit", vec![]);
    let plot = plot(vec![halving(), fit(), halving(), fit(), fit()]);
    let colors: Vec<_> = plot.colored().map(|(color, _)| color).collect();
    assert_eq!(colors, [0, 0, 1, 1, 1]);
}
