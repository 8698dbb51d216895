use super::*;
use crate::report::{Axis, Cell, Column, PageImage, Point, Series};

const EVIL: &str = "</script><script>alert('1')</script>&\"\u{1}";

fn plot() -> Plot {
    Plot {
        title: EVIL.into(),
        note: EVIL.into(),
        x: Axis::log(EVIL, EVIL),
        y: Axis::log(EVIL, EVIL),
        series: vec![
            Series::new(EVIL, vec![Point::new(1.0, 2.0).labelled(EVIL)]),
            Series::fitted(EVIL, Vec::new()),
        ],
    }
}

fn page() -> Page {
    Page {
        title: EVIL.into(),
        subtitle: EVIL.into(),
        sections: vec![
            Section::Text {
                title: EVIL.into(),
                paragraphs: vec![EVIL.into()],
            },
            Section::Table(Table {
                title: EVIL.into(),
                note: EVIL.into(),
                columns: vec![Column::explained(EVIL, EVIL)],
                rows: vec![vec![Cell::text(EVIL)]],
            }),
            Section::Curves(plot()),
            Section::Slider(Slider {
                title: EVIL.into(),
                note: EVIL.into(),
                pictures: vec![PageImage {
                    name: EVIL.into(),
                    width: 1,
                    height: 1,
                    rgb: vec![0; 3],
                }],
            }),
            Section::HeatMaps(HeatMaps {
                title: EVIL.into(),
                note: EVIL.into(),
                maps: vec![HeatMap {
                    name: EVIL.into(),
                    unit: EVIL.into(),
                    note: EVIL.into(),
                    width: 1,
                    height: 1,
                    values: vec![1.0],
                    log: false,
                    brightest: None,
                }],
            }),
            Section::Settings(Settings {
                title: EVIL.into(),
                note: EVIL.into(),
                columns: vec![EVIL.into()],
                rows: vec![(EVIL.into(), vec![EVIL.into()])],
            }),
        ],
    }
}

#[test]
fn text_stays_text() {
    let html = page().html().unwrap();
    assert!(!html.contains("<script>alert"));
    assert!(!html.contains('\u{1}'));
    let turned = Page {
        title: "a\u{202e}b\u{9b}c\nd".into(),
        ..Page::default()
    };
    let html_of_title = turned.html().unwrap();
    assert!(html_of_title.contains("<h1>a\u{fffd}b\u{fffd}c\nd</h1>"));
    // The page's own script, one of JSON for the plot and one for the heat map.
    assert_eq!(html.matches("<script").count(), 3);
    assert_eq!(html.matches("</script").count(), 3);
}

#[test]
fn nothing_comes_from_elsewhere() {
    let html = page().html().unwrap();
    for word in ["http:", "https:", "//", "@import", "url("] {
        let rest = html
            .replace(SCRIPT, "")
            .replace(STYLE, "")
            .replace("fill=\"url(#scale", "");
        // Base64 may hold two slashes.
        let outside_of_data: String = rest
            .split('"')
            .filter(|part| !part.starts_with("data:"))
            .collect();
        assert!(!outside_of_data.contains(word), "{word}");
        assert!(!STYLE.contains(word), "{word}");
    }
    assert!(!SCRIPT.contains("http"));
    assert!(html.contains("default-src 'none'"));
    assert!(html.contains(&hash(SCRIPT)) && html.contains(&hash(STYLE)));
}

#[test]
fn the_policy_would_forbid_styles_in_attributes_so_there_are_none() {
    assert!(!page().html().unwrap().contains(" style="));
}

#[test]
fn every_colour_of_a_plot_has_one_for_the_theme() {
    let svg = plot().drawn(&WIDE).unwrap().svg;
    for attribute in ["fill", "stroke"] {
        let before = format!(" {attribute}=\"#");
        for rest in svg.split(&before).skip(1) {
            let rule = format!("[{attribute}=\"#{}\"]", &rest[..6]);
            assert!(STYLE.contains(&rule), "{rule}");
        }
    }
    for color in COLORS {
        let name = format!("#{:02X}{:02X}{:02X}", color.0, color.1, color.2);
        assert!(STYLE.contains(&format!("[stroke=\"{name}\"]")), "{name}");
        assert!(STYLE.contains(&format!("[fill=\"{name}\"]")), "{name}");
    }
}

#[test]
fn an_empty_page_is_a_page() {
    let html = Page::default().html().unwrap();
    assert!(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>"));
    for section in [
        Section::Table(Table::default()),
        Section::Curves(Plot::default()),
        Section::Slider(Slider::default()),
        Section::HeatMaps(HeatMaps::default()),
        Section::Settings(Settings::default()),
    ] {
        let page = Page {
            sections: vec![section],
            ..Page::default()
        };
        assert!(page.html().is_ok());
    }
}
