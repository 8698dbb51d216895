//! The page and the plots.

use super::Reference;
use super::study::{Against, Curve, MAIN, MEASURES, Measure, SampleRow, Study};
use crate::math::words::counted;
use crate::measure::{RgbImage, flip_map};
use crate::report::{
    Axis, Cell, Column, HeatMap, HeatMaps, Page, Plot, Point, Section, Series, Settings, Slider,
    Table,
};

/// The measures that get a plot, the first one first.
const PLOTTED: [&str; 6] = [MAIN, "rmse", "smape", "flip", "hdr_flip", "ssim"];

/// What a page shows beyond the numbers.
#[derive(Debug, Default)]
pub struct Looks {
    /// What one sees of some pictures, by name.
    shown: Vec<(String, RgbImage)>,
    /// FLIP of the last picture of each renderer against its reference, by pixel.
    flip: Vec<(String, Vec<f32>)>,
}

impl Looks {
    /// Adds what one sees of a picture.
    pub fn add(&mut self, name: impl Into<String>, shown: RgbImage) {
        self.shown.push((name.into(), shown));
    }

    /// Adds FLIP of what one sees of a renderer's last picture.
    pub fn add_flip(&mut self, name: &str, shown: &RgbImage, reference: &Reference) {
        let reference = &reference.shown;
        let map = flip_map([shown, reference, shown, reference]);
        self.flip.push((name.into(), map));
    }
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

impl Study {
    /// All plots, the main one first.
    pub fn plots(&self) -> Vec<Plot> {
        let mut plots = PLOTTED.map(|key| plot(self, measure(key), true)).to_vec();
        plots.insert(1, plot(self, measure(MAIN), false));
        plots.retain(|plot| plot.series.iter().any(|series| !series.points.is_empty()));
        plots
    }

    /// For the terminal.
    pub fn text(&self) -> String {
        // Names come from files: what would break the line is shown as what it is.
        let line = |text: &str| text.replace('\n', "\\n");
        let (reference, view) = (line(&self.reference), line(&self.view));
        let mut text = format!("reference   {reference}\nseen        {view}\n");
        for curve in &self.renderers {
            text += &format!("\n{}\n", line(&curve.name));
            if self.renderers.len() > 1 && curve.reference != self.reference {
                text += &format!("against {}\n", line(&curve.reference));
            }
            if let Some(between) = &curve.reference_apart {
                text += &format!("{between}\n");
            }
            text += &rows(curve).text();
        }
        text += &format!("\nSlopes\n{}", slopes(self).text());
        for against in &self.against {
            text += &format!("\n{}\n", line(&against.sentence()));
        }
        if self.against.iter().any(|against| !against.at.is_empty()) {
            text += &format!("\n{}", equal_errors(self).text());
        }
        text
    }

    /// The page.
    pub fn page(&self, looks: &Looks) -> Page {
        let mut sections = vec![summary(self)];
        sections.extend(self.plots().into_iter().map(Section::Curves));
        if !self.against.is_empty() {
            sections.push(Section::Table(equal_errors(self)));
        }
        let tables = self.renderers.iter().map(rows).chain([slopes(self)]);
        sections.extend(tables.map(Section::Table));
        sections.push(Section::Slider(Slider {
            title: "Pictures".into(),
            note: format!("As one sees them: {}.", self.view),
            pictures: looks
                .shown
                .iter()
                .map(|(name, shown)| shown.as_codes(name))
                .collect(),
        }));
        if !looks.flip.is_empty() {
            sections.push(Section::HeatMaps(flip(self, looks)));
        }
        sections.push(Section::Settings(settings(self)));
        Page {
            title: "Error against time".into(),
            subtitle: format!(
                "{}, {} × {} pixels, Sundog {}, {} threads",
                self.scene, self.width, self.height, self.version, self.threads
            ),
            sections,
        }
    }
}

fn plot(study: &Study, measure: &Measure, against_time: bool) -> Plot {
    let name = plotted_name(measure);
    let title = |name: &str| {
        let mut letters = name.chars();
        letters
            .next()
            .map(|first| first.to_uppercase().chain(letters).collect::<String>())
            .unwrap_or_default()
    };
    let mut series = Vec::new();
    for curve in &study.renderers {
        series.push(Series::new(
            &curve.name,
            points(curve, measure, against_time),
        ));
        if let (true, Some(law)) = (against_time, curve.slopes.get(measure.key))
            && let (Some(first), Some(last)) = (curve.rows.first(), curve.rows.last())
        {
            let ends = [first.seconds, last.seconds].map(|time| Point::new(time, law.at(time)));
            series.push(Series::fitted(format!("slope {law}"), ends.to_vec()));
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

fn summary(study: &Study) -> Section {
    let mut paragraphs = vec![format!("Reference: {}.", study.reference)];
    for curve in &study.renderers {
        if curve.reference != study.reference {
            let mut text = format!("{} is measured against {}.", curve.name, curve.reference);
            if let Some(between) = &curve.reference_apart {
                text.push_str(&format!(
                    " Of the two, {between}: beyond its noise that is what the renderers compute differently."
                ));
            }
            paragraphs.push(text);
        }
    }
    paragraphs.extend(
        study
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

fn equal_errors(study: &Study) -> Table {
    let name = study
        .renderers
        .first()
        .map_or("", |curve| curve.name.as_str());
    let cells = |against: &Against| -> Vec<Vec<Cell>> {
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
        rows: study.against.iter().flat_map(cells).collect(),
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
    let cells = |row: &SampleRow| {
        let mut cells = vec![
            Cell::number(f64::from(row.samples)),
            Cell::number(row.seconds),
        ];
        cells.extend(MEASURES.iter().map(|measure| {
            match row.measures.get(measure.key).copied().flatten() {
                Some(spread) => Cell::shown(spread.mean, spread.to_string()),
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

fn slopes(study: &Study) -> Table {
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
        rows: study
            .renderers
            .iter()
            .map(|curve| {
                let mut cells = vec![Cell::text(&curve.name)];
                cells.extend(MEASURES.iter().map(|measure| match curve.slopes.get(measure.key) {
                    Some(law) => Cell::shown(law.slope, law.to_string()),
                    None => Cell::text("—"),
                }));
                cells
            })
            .collect(),
    }
}

fn flip(study: &Study, looks: &Looks) -> HeatMaps {
    HeatMaps {
        title: "FLIP of the last pictures".into(),
        note: "How much one sees when the picture and the reference alternate, 0 to 1.".into(),
        maps: looks
            .flip
            .iter()
            .map(|(name, values)| HeatMap {
                name: name.clone(),
                width: study.width,
                height: study.height,
                values: values.clone(),
                ..HeatMap::default()
            })
            .collect(),
    }
}

fn settings(study: &Study) -> Settings {
    let mut settings = Settings::of("value", &study.settings);
    settings.rows.retain(|(name, _)| name != "threads");
    let first = [
        ("scene", study.scene.clone()),
        ("view", study.view.clone()),
        ("threads", study.threads.to_string()),
    ];
    let first = first.map(|(name, value)| (name.to_owned(), vec![value]));
    settings.rows.splice(0..0, first);
    settings
}
