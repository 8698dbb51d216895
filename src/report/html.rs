//! A page as one HTML file: style, script, pictures and numbers are inside. A Content-Security-Policy forbids the
//! network and every style and script but the page's own, which it knows by their hashes.

use super::draw::{self, COLORS, MARKERS, NARROW, WIDE};
use super::picture::data_uri;
use super::{
    HeatMap, HeatMaps, Line, Page, Plot, ReportError, Section, Settings, Slider, Table, is_unseen,
    number,
};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};
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
        let version = env!("CARGO_PKG_VERSION");
        let policy = format!(
            "default-src 'none'; img-src data:; style-src '{}'; script-src '{}'; base-uri 'none'; form-action 'none'",
            hash(STYLE),
            hash(SCRIPT)
        );
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(policy);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content={ "Sundog " (version) };
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    header {
                        div { h1 { (self.title) } p { (self.subtitle) } }
                        button #theme type="button" hidden { "Dark" }
                    }
                    @if self.sections.len() > 2 { (self.contents()) }
                    main {
                        @for (index, section) in self.sections.iter().enumerate() {
                            section id={ "s" (index) } {
                                @if !section.title().is_empty() { h2 { (section.title()) } }
                                (section.html(index)?)
                            }
                        }
                    }
                    footer {
                        "Sundog " (version) ". This page is one file: it holds all that it shows and fetches nothing."
                    }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        };
        // HTML has no place for control characters, and symbols that turn the order of letters about would show names as
        // what they are not.
        let unseen = |symbol: char| is_unseen(symbol) && !matches!(symbol, '\t' | '\n');
        Ok(page.into_string().replace(unseen, "\u{fffd}"))
    }

    /// Links to the sections.
    fn contents(&self) -> Markup {
        html! {
            nav aria-label="Sections" { ul {
                @for (index, section) in self.sections.iter().enumerate() {
                    @if !section.title().is_empty() {
                        li { a href={ "#s" (index) } { (section.title()) } }
                    }
                }
            } }
        }
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

    fn html(&self, index: usize) -> Result<Markup, ReportError> {
        Ok(match self {
            Self::Text { paragraphs, .. } => html! { @for text in paragraphs { p { (text) } } },
            Self::Table(table) => sortable(table),
            Self::Curves(plot) => curves(plot, index)?,
            Self::Slider(slider) => pictures(slider)?,
            Self::HeatMaps(maps) => heat_maps(maps, index)?,
            Self::Settings(settings) => settings_table(settings),
        })
    }
}

/// JSON inside of a script element, which ends at the first `</script`, whatever stands around it.
fn json_element(value: &serde_json::Value) -> Markup {
    let text = value.to_string().replace('<', "\\u003c");
    html! { script type="application/json" { (PreEscaped(text)) } }
}

/// As Content-Security-Policy names a script or a style.
fn hash(content: &str) -> String {
    format!("sha256-{}", BASE64.encode(Sha256::digest(content)))
}

/// A paragraph, if there is a text.
fn paragraph(text: &str) -> Markup {
    html! { @if !text.is_empty() { p { (text) } } }
}

/// The title, or what kind of thing it is of.
fn named<'a>(title: &'a str, kind: &'a str) -> &'a str {
    if title.is_empty() { kind } else { title }
}

/// Links that save files, each of an extension, a media type and its content.
fn save(name: &str, files: &[(&str, &str, Vec<u8>)]) -> Markup {
    let safe = |symbol: char| {
        if symbol.is_alphanumeric() {
            symbol
        } else {
            '-'
        }
    };
    let file: String = name.to_lowercase().chars().map(safe).collect();
    html! {
        p.save {
            "Save "
            @for (index, (extension, kind, content)) in files.iter().enumerate() {
                @let shown = extension.to_uppercase();
                @if index > 0 { ", " }
                a download={ (file) "." (extension) } href=(data_uri(kind, content))
                    aria-label={ "Save " (name) " as " (shown) } { (shown) }
            }
        }
    }
}

/// A table that scrolls by itself where it is too wide.
fn wide_table(label: &str, table: &Markup) -> Markup {
    html! { div.wide-table tabindex="0" role="region" aria-label=(label) { (table) } }
}

fn sortable(table: &Table) -> Markup {
    let numeric = table.numeric_columns();
    let class = |column: usize| {
        numeric
            .get(column)
            .copied()
            .unwrap_or(false)
            .then_some("number")
    };
    let content = html! {
        table.sortable {
            thead { tr {
                @for (index, column) in table.columns.iter().enumerate() {
                    @let explanation = Some(&column.explanation).filter(|text| !text.is_empty());
                    th scope="col" class=[class(index)] {
                        button type="button" title=[explanation] { (column.name) }
                    }
                }
            } }
            tbody {
                @for row in &table.rows {
                    tr { @for (index, cell) in row.iter().enumerate() {
                        @if index == 0 {
                            th scope="row" class=[class(index)] data-value=[cell.value] { (cell.text) }
                        } @else {
                            td class=[class(index)] data-value=[cell.value] { (cell.text) }
                        }
                    } }
                }
            }
        }
    };
    html! {
        (paragraph(&table.note))
        (wide_table(named(&table.title, "Table"), &content))
        (save(named(&table.title, "table"), &[("csv", "text/csv", table.csv().into_bytes())]))
    }
}

fn curves(plot: &Plot, index: usize) -> Result<Markup, ReportError> {
    let name = named(&plot.title, "plot");
    let files = [
        ("svg", "image/svg+xml", plot.svg()?.into_bytes()),
        ("png", "image/png", plot.png(1600)?),
        ("csv", "text/csv", plot.csv().into_bytes()),
    ];
    Ok(html! {
        figure.plot id={ "plot" (index) } {
            @if plot.series.len() > 1 { (legend(plot)) }
            div.stage tabindex="0" role="application" aria-roledescription="plot" aria-label={
                (name) ": " (plot.y.title()) " over " (plot.x.title())
                ". Left and right go along a curve, up and down to another one."
            } {
                @for (class, layout) in [("wide", WIDE), ("narrow", NARROW)] {
                    @let drawn = plot.drawn(&layout)?;
                    @let frame = drawn.frame.map(|share| format!("{share:.5}")).join(" ");
                    div class=(class) data-frame=(frame) { (PreEscaped(drawn.inline())) }
                }
            }
            (json_element(&points(plot)))
            div.spoken role="status" {}
            figcaption {
                (paragraph(&plot.note))
                (paragraph(&plot.left_out_sentence().unwrap_or_default()))
                (save(name, &files))
            }
        }
        (numbers(plot))
    })
}

/// The names of the curves, before which the style puts their colours and markers.
fn legend(plot: &Plot) -> Markup {
    html! {
        ul.legend {
            @for (index, series) in plot.colored() {
                @let marker = if series.line == Line::Dashed { "dashes".into() } else { format!("marker-{}", index % MARKERS) };
                li class={ "curve-" (index % COLORS.len()) " " (marker) } { span { (series.name) } }
            }
        }
    }
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
fn numbers(plot: &Plot) -> Markup {
    let mut points = plot.series.iter().flat_map(|series| &series.points);
    let spread = points.any(|point| point.low.is_some() || point.high.is_some());
    let content = html! {
        table {
            thead { tr {
                th scope="col" { "curve" }
                th scope="col" {}
                th.number scope="col" { (plot.x.title()) }
                th.number scope="col" { (plot.y.title()) }
                @if spread { th.number scope="col" { "spread" } }
            } }
            tbody {
                @for series in &plot.series { @for point in &series.points {
                    tr {
                        th scope="row" { (series.name) @if series.line == Line::Dashed { " (fitted)" } }
                        td { (point.label) }
                        td.number { (number(point.x)) }
                        td.number { (number(point.y)) }
                        @if spread { td.number { (draw::words(plot, point)[2]) } }
                    }
                } }
            }
        }
    };
    html! {
        details {
            summary { "Numbers" }
            (wide_table(&format!("Numbers of {}", plot.title), &content))
        }
    }
}

fn pictures(slider: &Slider) -> Result<Markup, ReportError> {
    let choice = |side: &str, chosen: usize| {
        html! {
            label {
                (side) " "
                select class={ (side.to_lowercase()) "-choice" } aria-label={ "Picture on the " (side.to_lowercase()) } {
                    @for (index, picture) in slider.pictures.iter().enumerate() {
                        option value=(index) selected[index == chosen] { (picture.name) }
                    }
                }
            }
        }
    };
    Ok(html! {
        (paragraph(&slider.note))
        figure.slider {
            div.choices {
                (choice("Left", 0))
                (choice("Right", 1.min(slider.pictures.len().saturating_sub(1))))
                label {
                    "Zoom "
                    select.zoom aria-label="Zoom" {
                        option value="0" selected { "fit" }
                        @for factor in [1, 2, 4, 8] { option value=(factor) { (factor) "00 %" } }
                    }
                }
            }
            div.stage tabindex="-1" { div.pictures {
                @for picture in &slider.pictures {
                    figure {
                        img src=(data_uri("image/png", &picture.png()?)) width=(picture.width) height=(picture.height)
                            alt=(picture.name) draggable="false";
                        figcaption { (picture.name) }
                    }
                }
                span.bar aria-hidden="true" {}
            } }
            input type="range" min="0" max="100" step="0.5" value="50"
                aria-label="Place of the bar between both pictures";
        }
    })
}

fn heat_maps(maps: &HeatMaps, index: usize) -> Result<Markup, ReportError> {
    Ok(html! {
        (paragraph(&maps.note))
        div.maps {
            @for (number, map) in maps.maps.iter().enumerate() {
                (heat_map(map, &format!("scale{index}-{number}"))?)
            }
        }
    })
}

fn heat_map(map: &HeatMap, id: &str) -> Result<Markup, ReportError> {
    let shown = map.shown()?;
    let name = map.axis().title();
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
    Ok(html! {
        figure.map {
            h3 { (name) }
            div.stage tabindex="0" role="application" aria-roledescription="heat map"
                aria-label={ (name) ". Arrow keys go from pixel to pixel, with Shift by 16." } {
                img src=(data_uri("image/png", &shown.png)) width=(map.width) height=(map.height) alt="" draggable="false";
                span.cross hidden {}
            }
            (scale(&shown, id))
            p.readout role="status" { "Point at a pixel to read its value." }
            (json_element(&about))
            figcaption { (paragraph(&map.note)) (paragraph(&not_finite)) }
        }
    })
}

/// The colours of a heat map with their numbers.
fn scale(shown: &super::heat_map::Shown, id: &str) -> Markup {
    let last = shown.colors.len().saturating_sub(1).max(1) as f64;
    let percent = |share: f64| format!("{:.2}%", 100.0 * share);
    // Labels at the ends stay inside of the picture.
    let anchor = |at: f64| match at {
        at if at < 0.05 => "start",
        at if at > 0.95 => "end",
        _ => "middle",
    };
    html! {
        svg.scale width="100%" height="34" role="img" aria-label="Colour scale" {
            defs { linearGradient id=(id) {
                @for (index, color) in shown.colors.iter().enumerate() {
                    stop offset=(percent(index as f64 / last)) stop-color=(color) {}
                }
            } }
            rect width="100%" height="12" fill={ "url(#" (id) ")" } {}
            @for (at, label) in &shown.labels {
                @let x = percent(*at);
                line x1=(x) x2=(x) y1="12" y2="17" {}
                text x=(x) y="30" text-anchor=(anchor(*at)) { (label) }
            }
        }
    }
}

fn settings_table(settings: &Settings) -> Markup {
    // What differs between the columns is what one looks for.
    let differs = |values: &[String]| values.windows(2).any(|pair| pair[0] != pair[1]);
    let content = html! {
        table.settings {
            @if !settings.columns.is_empty() {
                thead { tr {
                    th scope="col" { "setting" }
                    @for column in &settings.columns { th scope="col" { (column) } }
                } }
            }
            tbody {
                @for (name, values) in &settings.rows {
                    tr.differs[differs(values)] {
                        th scope="row" { (name) }
                        @for value in values { td { (value) } }
                    }
                }
            }
        }
    };
    html! {
        (paragraph(&settings.note))
        (wide_table(named(&settings.title, "Settings"), &content))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/report/html.rs"]
mod tests;
