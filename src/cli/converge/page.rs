//! The page and the plots.

use super::super::Failure;
use super::summary::{Answer, Curve, MAIN, MEASURES, Measure, apart, slope, words};
use super::{Looks, Shown};
use crate::math::words::counted;
use crate::report::{
    Axis, Cell, Column, HeatMap, HeatMaps, Page, Picture, Plot, Point, ReportError, Section,
    Series, Settings, Slider, Table,
};

/// Pixels of a plot's row.
pub const PNG_WIDTH: u32 = 1200;

/// The measures that get a plot, the first one first.
const PLOTTED: [&str; 6] = [MAIN, "rmse", "smape", "flip", "hdr_flip", "ssim"];

/// What could not be shown.
pub fn failed(error: ReportError) -> Failure {
    Failure::new(error.to_string())
}

fn measure(key: &str) -> &'static Measure {
    MEASURES
        .iter()
        .find(|measure| measure.key == key)
        .unwrap_or(&MEASURES[0])
}

/// SSIM is 1 where nothing differs: its distance from that is what converges.
fn plotted_name(measure: &Measure) -> String {
    if measure.key == "ssim" {
        "1 - SSIM".into()
    } else {
        measure.name.into()
    }
}

/// All plots.
pub fn plots(answer: &Answer) -> Vec<Plot> {
    let mut plots: Vec<Plot> = PLOTTED
        .iter()
        .map(|key| plot(answer, measure(key), true))
        .collect();
    plots.insert(1, plot(answer, measure(MAIN), false));
    plots.retain(|plot| plot.series.iter().any(|series| !series.points.is_empty()));
    plots
}

fn plot(answer: &Answer, measure: &Measure, against_time: bool) -> Plot {
    let name = plotted_name(measure);
    let title = |name: &str| {
        let mut letters = name.chars();
        letters
            .next()
            .map(|first| first.to_uppercase().chain(letters).collect::<String>())
            .unwrap_or_default()
    };
    let mut series = Vec::new();
    for curve in &answer.renderers {
        series.push(Series::new(
            &curve.name,
            points(curve, measure, against_time),
        ));
        if let (true, Some(law)) = (against_time, curve.slopes.get(measure.key))
            && let (Some(first), Some(last)) = (curve.rows.first(), curve.rows.last())
        {
            let ends = [first.seconds, last.seconds].map(|time| Point::new(time, law.at(time)));
            series.push(Series::fitted(
                format!("slope {}", slope(law)),
                ends.to_vec(),
            ));
        }
    }
    Plot {
        title: format!(
            "{} against {}",
            title(&name),
            if against_time { "time" } else { "samples" }
        ),
        note: format!(
            "{}. Mean over the seeds; the bars are one standard deviation.",
            title(measure.doc)
        ),
        x: if against_time {
            Axis::log("time of path tracing", "s")
        } else {
            Axis::log("samples a pixel", "")
        },
        y: Axis::log(name, measure.unit),
        series,
    }
}

fn points(curve: &Curve, measure: &Measure, against_time: bool) -> Vec<Point> {
    curve
        .rows
        .iter()
        .filter_map(|row| {
            let spread = (*row.measures.get(measure.key)?)?;
            let error = (measure.error)(spread.mean);
            let x = if against_time {
                row.seconds
            } else {
                f64::from(row.samples)
            };
            // A logarithmic axis has no place for what is not above 0.
            let point = Point::new(x, error).labelled(counted(row.samples, "sample", "samples"));
            let point = match spread.deviation {
                Some(deviation) if deviation < error => {
                    point.spread(error - deviation, error + deviation)
                }
                _ => point,
            };
            (error > 0.0).then_some(point)
        })
        .collect()
}

/// The page.
pub fn page(answer: &Answer, looks: &Looks) -> Page {
    let mut sections = vec![summary(answer)];
    sections.extend(plots(answer).into_iter().map(Section::Curves));
    if !answer.against.is_empty() {
        sections.push(Section::Table(equal_errors(answer)));
    }
    sections.extend(
        answer
            .renderers
            .iter()
            .map(|curve| Section::Table(rows(curve))),
    );
    sections.push(Section::Table(slopes(answer)));
    sections.push(Section::Slider(slider(answer, looks)));
    if !looks.flip.is_empty() {
        sections.push(Section::HeatMaps(flip(answer, looks)));
    }
    sections.push(Section::Settings(settings(answer)));
    Page {
        title: "Error against time".into(),
        subtitle: format!(
            "{}, {} × {} pixels, Sundog {}, {} threads",
            answer.scene, answer.width, answer.height, answer.version, answer.threads
        ),
        sections,
    }
}

fn summary(answer: &Answer) -> Section {
    let mut paragraphs = vec![format!("Reference: {}.", answer.reference)];
    for curve in &answer.renderers {
        if curve.reference != answer.reference {
            let mut text = format!("{} is measured against {}.", curve.name, curve.reference);
            if let Some(between) = &curve.reference_apart {
                text.push_str(&format!(
                    " Of the two, {}: beyond its noise that is what the renderers compute differently.",
                    apart(between)
                ));
            }
            paragraphs.push(text);
        }
    }
    paragraphs.extend(
        answer
            .against
            .iter()
            .map(|against| format!("{}.", against.sentence())),
    );
    paragraphs.push(
        "MAPE, SMAPE, SSIM and FLIP contain the noise of the reference: where they no longer fall, it is the reference that is seen."
            .into(),
    );
    Section::Text {
        title: "What was found".into(),
        paragraphs,
    }
}

fn equal_errors(answer: &Answer) -> Table {
    let name = answer
        .renderers
        .first()
        .map_or("", |curve| curve.name.as_str());
    let cells = |against: &super::summary::Against| -> Vec<Vec<Cell>> {
        against
            .at
            .iter()
            .map(|at| {
                vec![
                    Cell::text(&against.renderer),
                    Cell::number(at.error_percent),
                    Cell::number(at.seconds),
                    Cell::number(at.their_seconds),
                    Cell::number(at.ratio),
                ]
            })
            .collect()
    };
    Table {
        title: "Time to equal error".into(),
        note: "Between measured points by interpolation of logarithms; nothing is extrapolated."
            .into(),
        columns: vec![
            Column::new("renderer"),
            Column::explained("error, %", "√relMSE"),
            Column::new(format!("{name}, s")),
            Column::new("the other, s"),
            Column::explained("ratio", "above 1 the other one takes longer"),
        ],
        rows: answer.against.iter().flat_map(cells).collect(),
    }
}

fn rows(curve: &Curve) -> Table {
    let mut columns = vec![
        Column::new("samples"),
        Column::explained("time, s", "path tracing alone"),
    ];
    columns.extend(MEASURES.iter().map(|measure| {
        let unit = if measure.unit.is_empty() { "" } else { ", %" };
        Column::explained(format!("{}{unit}", measure.name), measure.doc)
    }));
    columns.push(Column::explained(
        "s × MSE",
        "does not depend on the time for independent samples",
    ));
    columns.push(Column::explained("s × relMSE", "the same, relative"));
    let cells = |row: &super::summary::Row| {
        let mut cells = vec![
            Cell::number(f64::from(row.samples)),
            Cell::number(row.seconds),
        ];
        cells.extend(MEASURES.iter().map(|measure| {
            match row.measures.get(measure.key).copied().flatten() {
                Some(spread) => Cell::shown(spread.mean, words(spread)),
                None => Cell::text("—"),
            }
        }));
        cells.push(Cell::number(row.seconds_times_mse));
        cells.push(Cell::number(row.seconds_times_rel_mse));
        cells
    };
    Table {
        title: curve.name.clone(),
        note: format!(
            "Means over {} seeds ± one standard deviation.",
            curve.rows.iter().map(|row| row.seeds).max().unwrap_or(0)
        ),
        columns,
        rows: curve.rows.iter().map(cells).collect(),
    }
}

fn slopes(answer: &Answer) -> Table {
    let mut columns = vec![Column::new("renderer")];
    columns.extend(
        MEASURES
            .iter()
            .map(|measure| Column::new(plotted_name(measure))),
    );
    Table {
        title: "Slopes".into(),
        note: "Of log error against log time, by least squares, ± standard error; -0.5 is what independent samples have (-1 for relMSE)."
            .into(),
        columns,
        rows: answer
            .renderers
            .iter()
            .map(|curve| {
                let mut cells = vec![Cell::text(&curve.name)];
                cells.extend(MEASURES.iter().map(|measure| match curve.slopes.get(measure.key) {
                    Some(law) => Cell::shown(law.slope, slope(law)),
                    None => Cell::text("—"),
                }));
                cells
            })
            .collect(),
    }
}

fn slider(answer: &Answer, looks: &Looks) -> Slider {
    let picture = |shown: &Shown| Picture {
        name: shown.name.clone(),
        width: shown.picture.width,
        height: shown.picture.height,
        rgb: shown
            .picture
            .pixels
            .iter()
            .flatten()
            .map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
            .collect(),
    };
    Slider {
        title: "Pictures".into(),
        note: format!("As one sees them: {}.", answer.view),
        pictures: looks.shown.iter().map(picture).collect(),
    }
}

fn flip(answer: &Answer, looks: &Looks) -> HeatMaps {
    HeatMaps {
        title: "FLIP of the last pictures".into(),
        note: "How much one sees when the picture and the reference alternate, 0 to 1.".into(),
        maps: looks
            .flip
            .iter()
            .map(|(name, values)| HeatMap {
                name: name.clone(),
                width: answer.width,
                height: answer.height,
                values: values.clone(),
                ..HeatMap::default()
            })
            .collect(),
    }
}

fn settings(answer: &Answer) -> Settings {
    let text = |value: &serde_json::Value| match value {
        serde_json::Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let mut rows: Vec<(String, Vec<String>)> = vec![
        ("scene".into(), vec![answer.scene.clone()]),
        ("view".into(), vec![answer.view.clone()]),
        ("threads".into(), vec![answer.threads.to_string()]),
    ];
    if let Some(settings) = answer.settings.as_object() {
        rows.extend(
            settings
                .iter()
                .filter(|(name, _)| *name != "threads")
                .map(|(name, value)| (name.replace('_', " "), vec![text(value)])),
        );
    }
    Settings {
        title: "Settings".into(),
        note: String::new(),
        columns: vec!["value".into()],
        rows,
    }
}
