//! A page as one HTML file: style, script, pictures and numbers are inside. A Content-Security-Policy forbids the
//! network and every style and script but the page's own, which it knows by their hashes.

use super::draw::{self, COLORS, NARROW, WIDE};
use super::heat_map::Shown;
use super::picture::data_uri;
use super::{
    HeatMap, HeatMaps, Line, Page, Plot, ReportError, Section, Settings, Slider, Table, is_unseen,
};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use serde_json::json;
use sha2::{Digest, Sha256};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

impl Page {
    /// The page as one file that needs no other and no network.
    ///
    /// # Errors
    /// A plot or a picture of it cannot be shown.
    pub fn html(&self) -> Result<String, ReportError> {
        let (title, subtitle) = (escape(&self.title), escape(&self.subtitle));
        let policy = format!(
            "default-src 'none'; img-src data:; style-src '{}'; script-src '{}'; base-uri 'none'; form-action 'none'",
            hash(STYLE),
            hash(SCRIPT)
        );
        let mut body = String::new();
        for (index, section) in self.sections.iter().enumerate() {
            let content = section.html(index)?;
            let heading = match section.title() {
                "" => String::new(),
                title => format!("<h2>{}</h2>\n", escape(title)),
            };
            body += &format!("<section id=\"s{index}\">\n{heading}{content}</section>\n");
        }
        Ok(format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"generator\" content=\"Sundog {version}\">\n\
             <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
             <header>\n<div>\n<h1>{title}</h1>\n<p>{subtitle}</p>\n</div>\n\
             <button type=\"button\" id=\"theme\" hidden>Dark</button>\n</header>\n\
             {contents}<main>\n{body}</main>\n\
             <footer>Sundog {version}. This page is one file: it holds all that it shows and fetches nothing.</footer>\n\
             <script>{SCRIPT}</script>\n</body>\n</html>\n",
            version = env!("CARGO_PKG_VERSION"),
            contents = self.contents(),
        ))
    }

    /// Links to the sections, where there are several.
    fn contents(&self) -> String {
        let links: String = self
            .sections
            .iter()
            .enumerate()
            .filter(|(_, section)| !section.title().is_empty())
            .map(|(index, section)| {
                format!(
                    "<li><a href=\"#s{index}\">{}</a></li>\n",
                    escape(section.title())
                )
            })
            .collect();
        if self.sections.len() < 3 {
            return String::new();
        }
        format!("<nav aria-label=\"Sections\"><ul>\n{links}</ul></nav>\n")
    }
}

impl Section {
    fn title(&self) -> &str {
        match self {
            Self::Text { title, .. } => title,
            Self::Table(table) => &table.title,
            Self::Curves(plot) => &plot.title,
            Self::Slider(slider) => &slider.title,
            Self::HeatMaps(maps) => &maps.title,
            Self::Settings(settings) => &settings.title,
        }
    }

    fn html(&self, index: usize) -> Result<String, ReportError> {
        Ok(match self {
            Self::Text { paragraphs, .. } => {
                paragraphs.iter().map(|text| paragraph(text)).collect()
            }
            Self::Table(table) => paragraph(&table.note) + &sortable(table),
            Self::Curves(plot) => curves(plot, index)?,
            Self::Slider(slider) => pictures(slider)?,
            Self::HeatMaps(maps) => heat_maps(maps, index)?,
            Self::Settings(settings) => settings_table(settings),
        })
    }
}

/// Text for HTML, between tags and in quotes.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for symbol in text.chars() {
        match symbol {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\t' | '\n' => escaped.push(symbol),
            // HTML has no place for other control characters, and what turns the order of letters about would show names
            // as what they are not.
            symbol if is_unseen(symbol) => escaped.push('\u{fffd}'),
            symbol => escaped.push(symbol),
        }
    }
    escaped
}

/// JSON inside of a script element, which ends at the first `</script`, whatever stands around it.
fn json_element(value: &serde_json::Value) -> String {
    let text = value.to_string().replace('<', "\\u003c");
    let text = text.replace(is_unseen, "\u{fffd}");
    format!("<script type=\"application/json\">{text}</script>\n")
}

/// As Content-Security-Policy names a script or a style.
fn hash(content: &str) -> String {
    format!("sha256-{}", BASE64.encode(Sha256::digest(content)))
}

fn paragraph(text: &str) -> String {
    match text {
        "" => String::new(),
        text => format!("<p>{}</p>\n", escape(text)),
    }
}

/// A link that saves what it holds.
fn save(name: &str, kind: &str, extension: &str, content: &[u8]) -> String {
    let file: String = name
        .chars()
        .map(|symbol| {
            if symbol.is_alphanumeric() {
                symbol
            } else {
                '-'
            }
        })
        .collect();
    format!(
        "<a download=\"{}.{extension}\" href=\"{}\" aria-label=\"Save {} as {}\">{}</a>",
        escape(&file.to_lowercase()),
        data_uri(kind, content),
        escape(name),
        extension.to_uppercase(),
        extension.to_uppercase()
    )
}

fn sortable(table: &Table) -> String {
    let numeric: Vec<bool> = (0..table.columns.len())
        .map(|column| {
            let mut cells = table.rows.iter().filter_map(|row| row.get(column));
            cells.any(|cell| cell.value.is_some())
        })
        .collect();
    let class = |column: usize| {
        if numeric.get(column).copied().unwrap_or(false) {
            " class=\"number\""
        } else {
            ""
        }
    };
    let mut text = format!(
        "<div class=\"wide-table\" tabindex=\"0\" role=\"region\" aria-label=\"{}\">\n<table class=\"sortable\">\n<thead><tr>",
        escape(if table.title.is_empty() {
            "Table"
        } else {
            &table.title
        })
    );
    for (index, column) in table.columns.iter().enumerate() {
        let explanation = match column.explanation.as_str() {
            "" => String::new(),
            text => format!(" title=\"{}\"", escape(text)),
        };
        text += &format!(
            "<th scope=\"col\"{}><button type=\"button\"{explanation}>{}</button></th>",
            class(index),
            escape(&column.name)
        );
    }
    text += "</tr></thead>\n<tbody>\n";
    for row in &table.rows {
        text += "<tr>";
        for (index, cell) in row.iter().enumerate() {
            let value = cell
                .value
                .map_or_else(String::new, |value| format!(" data-value=\"{value}\""));
            let (open, close) = if index == 0 {
                ("th scope=\"row\"", "th")
            } else {
                ("td", "td")
            };
            text += &format!(
                "<{open}{}{value}>{}</{close}>",
                class(index),
                escape(&cell.text)
            );
        }
        text += "</tr>\n";
    }
    let name = if table.title.is_empty() {
        "table"
    } else {
        &table.title
    };
    text + "</tbody>\n</table>\n</div>\n"
        + &format!(
            "<p class=\"save\">Save {}</p>\n",
            save(name, "text/csv", "csv", table.csv().as_bytes())
        )
}

fn curves(plot: &Plot, index: usize) -> Result<String, ReportError> {
    let name = if plot.title.is_empty() {
        "plot"
    } else {
        &plot.title
    };
    let about = format!("{}: {} over {}", name, plot.y.title(), plot.x.title());
    let mut text = format!(
        "<figure class=\"plot\" id=\"plot{index}\">\n<div class=\"stage\" tabindex=\"0\" role=\"application\" \
         aria-roledescription=\"plot\" aria-label=\"{}. Left and right go along a curve, up and down to another one.\">\n",
        escape(&about)
    );
    for (class, layout) in [("wide", WIDE), ("narrow", NARROW)] {
        let drawn = plot.drawn(&layout)?;
        let frame = drawn.frame.map(|share| format!("{share:.5}")).join(" ");
        // HTML knows SVG's elements without their namespace's name.
        let svg = drawn
            .svg
            .replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1)
            .replacen("<svg ", "<svg role=\"img\" aria-hidden=\"true\" ", 1);
        text += &format!("<div class=\"{class}\" data-frame=\"{frame}\">{svg}</div>\n");
    }
    text += "</div>\n";
    text += &json_element(&points(plot));
    text += "<div class=\"spoken\" role=\"status\"></div>\n<figcaption>\n";
    text += &paragraph(&plot.note);
    text += &paragraph(&plot.left_out_sentence().unwrap_or_default());
    text += &format!(
        "<p class=\"save\">Save {}, {}, {}</p>\n</figcaption>\n</figure>\n",
        save(name, "image/svg+xml", "svg", plot.svg()?.as_bytes()),
        save(name, "image/png", "png", &plot.png(1600)?),
        save(name, "text/csv", "csv", plot.csv().as_bytes()),
    );
    Ok(text + &numbers(plot))
}

/// What the script needs to know of a plot: where its points are (as shares of the frame) and what they say.
fn points(plot: &Plot) -> serde_json::Value {
    let (range_x, range_y) = plot.ranges();
    let series: Vec<_> = plot
        .colored()
        .map(|(index, series)| {
            let points: Vec<_> = series
                .points
                .iter()
                .filter(|point| plot.shows(point))
                .map(|point| {
                    let [x, y, spread] = draw::words(plot, point);
                    let at = [range_x.position(point.x), range_y.position(point.y)]
                        .map(|share| (share * 1e5).round() / 1e5);
                    json!({ "at": at, "x": x, "y": y, "spread": spread, "label": point.label })
                })
                .collect();
            // Whether there is something between two points.
            let line = matches!(series.line, Line::Solid | Line::Dashed);
            json!({ "name": series.name, "color": index % COLORS.len(), "line": line, "points": points })
        })
        .collect();
    let (low, high) = range_y.ends();
    json!({
        "x": { "label": plot.x.label },
        "y": { "label": plot.y.label, "unit": plot.y.unit, "log": plot.y.log, "low": low, "high": high },
        "series": series,
    })
}

/// The numbers of a plot as a table that opens on demand.
fn numbers(plot: &Plot) -> String {
    let spread = plot
        .series
        .iter()
        .flat_map(|series| &series.points)
        .any(|point| point.low.is_some() || point.high.is_some());
    let mut text = format!(
        "<details><summary>Numbers</summary>\n<div class=\"wide-table\" tabindex=\"0\" role=\"region\" aria-label=\"Numbers of {}\">\n\
         <table>\n<thead><tr><th scope=\"col\">curve</th><th scope=\"col\"></th><th scope=\"col\" class=\"number\">{}</th>\
         <th scope=\"col\" class=\"number\">{}</th>{}</tr></thead>\n<tbody>\n",
        escape(&plot.title),
        escape(&plot.x.title()),
        escape(&plot.y.title()),
        if spread {
            "<th scope=\"col\" class=\"number\">spread</th>"
        } else {
            ""
        }
    );
    for series in &plot.series {
        for point in &series.points {
            let [_, _, range] = draw::words(plot, point);
            let spread = if spread {
                format!("<td class=\"number\">{}</td>", escape(&range))
            } else {
                String::new()
            };
            text += &format!(
                "<tr><th scope=\"row\">{}{}</th><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>{spread}</tr>\n",
                escape(&series.name),
                if series.line == Line::Dashed {
                    " (fitted)"
                } else {
                    ""
                },
                escape(&point.label),
                super::number(point.x),
                super::number(point.y),
            );
        }
    }
    text + "</tbody>\n</table>\n</div>\n</details>\n"
}

fn pictures(slider: &Slider) -> Result<String, ReportError> {
    let options = |chosen: usize| -> String {
        slider
            .pictures
            .iter()
            .enumerate()
            .map(|(index, picture)| {
                let selected = if index == chosen { " selected" } else { "" };
                format!(
                    "<option value=\"{index}\"{selected}>{}</option>",
                    escape(&picture.name)
                )
            })
            .collect()
    };
    let right = 1.min(slider.pictures.len().saturating_sub(1));
    let mut text = paragraph(&slider.note);
    text += &format!(
        "<figure class=\"slider\">\n<div class=\"choices\">\n<label>Left <select class=\"left-choice\" aria-label=\"Picture on the left\">{}</select></label>\n\
         <label>Right <select class=\"right-choice\" aria-label=\"Picture on the right\">{}</select></label>\n\
         <label>Zoom <select class=\"zoom\" aria-label=\"Zoom\"><option value=\"0\" selected>fit</option><option value=\"1\">100 %</option>\
         <option value=\"2\">200 %</option><option value=\"4\">400 %</option><option value=\"8\">800 %</option></select></label>\n</div>\n\
         <div class=\"stage\" tabindex=\"-1\"><div class=\"pictures\">\n",
        options(0),
        options(right)
    );
    for picture in &slider.pictures {
        text += &format!(
            "<figure><img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{name}\" draggable=\"false\"><figcaption>{name}</figcaption></figure>\n",
            data_uri("image/png", &picture.png()?),
            picture.width,
            picture.height,
            name = escape(&picture.name)
        );
    }
    Ok(text
        + "<span class=\"bar\" aria-hidden=\"true\"></span>\n</div></div>\n\
           <input type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" aria-label=\"Place of the bar between both pictures\">\n\
           </figure>\n")
}

fn heat_maps(maps: &HeatMaps, index: usize) -> Result<String, ReportError> {
    let mut text = paragraph(&maps.note) + "<div class=\"maps\">\n";
    for (number, map) in maps.maps.iter().enumerate() {
        text += &heat_map(map, &map.shown()?, &format!("scale{index}-{number}"));
    }
    Ok(text + "</div>\n")
}

fn heat_map(map: &HeatMap, shown: &Shown, id: &str) -> String {
    let name = escape(&if map.unit.is_empty() {
        map.name.clone()
    } else {
        format!("{} ({})", map.name, map.unit)
    });
    let not_finite = match shown.not_finite {
        0 => String::new(),
        1 => "1 pixel is not finite (blue).".to_owned(),
        count => format!("{count} pixels are not finite (blue)."),
    };
    let codes = &shown.codes;
    let about = json!({
        "low": codes.low, "high": codes.high, "log": codes.log, "unit": map.unit,
        "codes": BASE64.encode(&codes.bytes),
    });
    format!(
        "<figure class=\"map\">\n<h3>{name}</h3>\n\
         <div class=\"stage\" tabindex=\"0\" role=\"application\" aria-roledescription=\"heat map\" \
         aria-label=\"{name}. Arrow keys go from pixel to pixel, with Shift by 16.\">\
         <img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"\" draggable=\"false\"><span class=\"cross\" hidden></span></div>\n\
         {}<p class=\"readout\" role=\"status\">Point at a pixel to read its value.</p>\n{}\
         <figcaption>{}{}</figcaption>\n</figure>\n",
        data_uri("image/png", &shown.png),
        map.width,
        map.height,
        scale(shown, id),
        json_element(&about),
        paragraph(&map.note),
        paragraph(&not_finite),
    )
}

/// The colours of a heat map with their numbers.
fn scale(shown: &Shown, id: &str) -> String {
    let last = shown.colors.len().saturating_sub(1).max(1) as f64;
    let stops: String = shown
        .colors
        .iter()
        .enumerate()
        .map(|(index, color)| {
            format!(
                "<stop offset=\"{:.2}%\" stop-color=\"{color}\"/>",
                100.0 * index as f64 / last
            )
        })
        .collect();
    let labels: String = shown
        .ticks
        .iter()
        .filter_map(|tick| Some((100.0 * tick.at, tick.label.as_ref()?)))
        .map(|(at, label)| {
            // Labels at the ends stay inside of the picture.
            let anchor = match at {
                at if at < 5.0 => "start",
                at if at > 95.0 => "end",
                _ => "middle",
            };
            format!(
                "<line x1=\"{at:.2}%\" x2=\"{at:.2}%\" y1=\"12\" y2=\"17\"/><text x=\"{at:.2}%\" y=\"30\" text-anchor=\"{anchor}\">{}</text>",
                escape(label)
            )
        })
        .collect();
    format!(
        "<svg class=\"scale\" width=\"100%\" height=\"34\" role=\"img\" aria-label=\"Colour scale\">\
         <defs><linearGradient id=\"{id}\">{stops}</linearGradient></defs>\
         <rect width=\"100%\" height=\"12\" fill=\"url(#{id})\"/>{labels}</svg>\n"
    )
}

fn settings_table(settings: &Settings) -> String {
    let mut text = paragraph(&settings.note);
    text += &format!(
        "<div class=\"wide-table\" tabindex=\"0\" role=\"region\" aria-label=\"{}\">\n<table class=\"settings\">\n",
        escape(if settings.title.is_empty() {
            "Settings"
        } else {
            &settings.title
        })
    );
    if !settings.columns.is_empty() {
        let heads: String = settings
            .columns
            .iter()
            .map(|column| format!("<th scope=\"col\">{}</th>", escape(column)))
            .collect();
        text += &format!("<thead><tr><th scope=\"col\">setting</th>{heads}</tr></thead>\n");
    }
    text += "<tbody>\n";
    for (name, values) in &settings.rows {
        // What differs between the columns is what one looks for.
        let differs = values.windows(2).any(|pair| pair[0] != pair[1]);
        let class = if differs { " class=\"differs\"" } else { "" };
        let cells: String = values
            .iter()
            .map(|value| format!("<td>{}</td>", escape(value)))
            .collect();
        text += &format!(
            "<tr{class}><th scope=\"row\">{}</th>{cells}</tr>\n",
            escape(name)
        );
    }
    text + "</tbody>\n</table>\n</div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Axis, Cell, Column, Picture, Point, Series};

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
                    pictures: vec![Picture {
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
        assert_eq!(escape("a\u{202e}b\u{9b}c\nd"), "a\u{fffd}b\u{fffd}c\nd");
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
        assert!(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>\n"));
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
}
