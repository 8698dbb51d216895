//! What a comparison of two files shows: its page and its table.

use super::{Difference, Encoding, MeasureError, RgbImage};
use crate::report::{
    Axis, Cell, Column, HeatMap, HeatMaps, Line, Page, Plot, Point, Section, Series, Settings,
    Slider, Table, number,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Bins of the histogram in each decade.
const BINS: i32 = 8;

/// Two pictures and all that is known of them.
pub struct Comparison<'a> {
    /// The files: the picture and the reference.
    pub paths: [&'a Path; 2],
    /// The numbers in them.
    pub pictures: [&'a RgbImage; 2],
    /// Display values.
    pub shown: [&'a RgbImage; 2],
    /// How these came to be.
    pub seen: &'a str,
    /// The measures.
    pub difference: &'a Difference,
}

impl Comparison<'_> {
    /// The page.
    ///
    /// # Errors
    /// A file cannot be read again.
    pub fn page(&self) -> Result<Page, MeasureError> {
        let [a, b] = self.names();
        let d = self.difference;
        let holds = match d.encoding {
            Encoding::Linear => "linear light",
            Encoding::Display => "display values",
        };
        Ok(Page {
            title: format!("{a} against {b}"),
            subtitle: format!(
                "{} × {} pixels of {holds}; error {} % (√relMSE); what is not finite is left out: {} pixels",
                d.width,
                d.height,
                number(d.error_percent()),
                u64::from(d.width) * u64::from(d.height) - d.compared
            ),
            sections: vec![
                self.slider()?,
                Section::Table(self.difference.table()),
                self.maps()?,
                self.histogram()?,
                self.settings()?,
            ],
        })
    }

    /// Names of the files; the reference gets its folder if both have one name.
    fn names(&self) -> [String; 2] {
        let names = self.paths.map(|path| match path.file_name() {
            Some(name) => name.to_string_lossy().into_owned(),
            None => path.display().to_string(),
        });
        if names[0] == names[1] {
            self.paths.map(|path| path.display().to_string())
        } else {
            names
        }
    }

    fn slider(&self) -> Result<Section, MeasureError> {
        let [a, b] = self.names();
        let map = super::difference_map(self.shown[0], self.shown[1])?;
        let brightest = map.brightest.unwrap_or_default();
        Ok(Section::Slider(Slider {
            title: "Side by side".into(),
            note: format!(
                "Shown by: {}. The difference is that of what one sees, from black to {brightest} (pale yellow).",
                self.seen
            ),
            pictures: vec![
                self.shown[0].as_codes(a),
                self.shown[1].as_codes(b),
                map.picture(),
            ],
        }))
    }

    fn maps(&self) -> Result<Section, MeasureError> {
        let [a, b] = self.pictures;
        let percent = |values: Vec<f32>| values.into_iter().map(|value| 100.0 * value).collect();
        let mut maps = vec![
            self.map("Error", "%", percent(super::error_map(a, b)?), true),
            self.map(
                "FLIP",
                "",
                super::flip_map([a, b, self.shown[0], self.shown[1]]),
                false,
            ),
        ];
        maps[0].note = "True error of each pixel: the root of the mean over its channels of (a − b)² / (b² + 0.01).".into();
        maps[1].note = "How much of a difference one sees.".into();
        let mut layers = Vec::new();
        for (path, name) in self.paths.into_iter().zip(self.names()) {
            for (layer, what, unit, factor, log) in LAYERS {
                if let Some(values) = layer_of(path, layer)? {
                    let values = values.into_iter().map(|value| factor * value).collect();
                    layers.push(self.map(&format!("{what} {name}"), unit, values, log));
                }
            }
        }
        // What is the same everywhere is told by a sentence.
        let mut note = Vec::new();
        for map in layers {
            let first = map.values.first().copied().unwrap_or(0.0);
            if map.values.iter().all(|value| *value == first) {
                let value = number(f64::from(first));
                note.push(format!("{}: {value} everywhere.", map.name));
            } else {
                maps.push(map);
            }
        }
        Ok(Section::HeatMaps(HeatMaps {
            title: "Where".into(),
            note: note.join(" "),
            maps,
        }))
    }

    fn map(&self, name: &str, unit: &str, values: Vec<f32>, log: bool) -> HeatMap {
        HeatMap {
            name: name.into(),
            unit: unit.into(),
            note: String::new(),
            width: self.difference.width,
            height: self.difference.height,
            values,
            log,
            brightest: None,
        }
    }

    fn histogram(&self) -> Result<Section, MeasureError> {
        let errors = super::error_map(self.pictures[0], self.pictures[1])?;
        let all = self.difference.compared.max(1) as f64;
        let mut bins: BTreeMap<i32, u64> = BTreeMap::new();
        let mut equal = 0u64;
        for error in errors.into_iter().filter(|error| error.is_finite()) {
            if error > 0.0 {
                let bin = (f64::from(BINS) * (100.0 * f64::from(error)).log10()).floor();
                *bins.entry(bin as i32).or_default() += 1;
            } else {
                equal += 1;
            }
        }
        let edge = |bin: i32| 10f64.powf(f64::from(bin) / f64::from(BINS));
        let (first, last) = (bins.keys().next(), bins.keys().next_back());
        let points =
            match (first, last) {
                (Some(first), Some(last)) => (*first..=*last)
                    .map(|bin| {
                        let count = bins.get(&bin).copied().unwrap_or(0);
                        let (low, high) = (edge(bin), edge(bin + 1));
                        Point::new((low * high).sqrt(), 100.0 * count as f64 / all).labelled(
                            format!("{count} pixels from {} to {} %", number(low), number(high)),
                        )
                    })
                    .collect(),
                _ => Vec::new(),
            };
        let note = match equal {
            0 => String::new(),
            equal => format!(
                "{equal} pixels ({} %) are equal in both pictures and have no place on a logarithmic axis.",
                number(100.0 * equal as f64 / all)
            ),
        };
        Ok(Section::Curves(Plot {
            title: "Pixels by their error".into(),
            note,
            x: Axis::log("error of the pixel", "%"),
            y: Axis::linear("share of the pixels", "%"),
            series: vec![Series {
                line: Line::Bars,
                ..Series::new("pixels", points)
            }],
        }))
    }

    fn settings(&self) -> Result<Section, MeasureError> {
        let mut files = Vec::new();
        for path in self.paths {
            let mut texts = BTreeMap::new();
            for (name, text) in super::metadata(path)? {
                flatten(
                    name.strip_prefix("sundog/").unwrap_or(&name),
                    &text,
                    &mut texts,
                );
            }
            files.push(texts);
        }
        let names: BTreeSet<String> = files
            .iter()
            .flat_map(|texts| texts.keys().cloned())
            .collect();
        let rows = names.into_iter().map(|name| {
            let values = files
                .iter()
                .map(|texts| texts.get(&name).cloned().unwrap_or_default())
                .collect();
            (name, values)
        });
        let rows: Vec<_> = rows.collect();
        let note = if rows.is_empty() {
            "The files say nothing of how they were made."
        } else {
            "What the files say of how they were made; marked is what differs."
        };
        Ok(Section::Settings(Settings {
            title: "Settings".into(),
            note: note.into(),
            columns: self.names().to_vec(),
            rows,
        }))
    }
}

impl Difference {
    /// The measures as a table.
    pub fn table(&self) -> Table {
        let row = |(name, value, explanation): (&str, Option<f64>, &str)| {
            let value = match value {
                Some(value) => Cell::number(value),
                None => Cell::shown(f64::NAN, "–"),
            };
            vec![Cell::text(name), value, Cell::text(explanation)]
        };
        let columns = ["measure", "value", "what it is"];
        Table {
            title: "Numbers".into(),
            note: String::new(),
            columns: columns.map(Column::new).to_vec(),
            rows: self.measures().map(row).to_vec(),
        }
    }

    /// All measures in the order in which they are shown: name, value and what it is.
    fn measures(&self) -> [(&'static str, Option<f64>, &'static str); 12] {
        [
            (
                "error (%)",
                Some(self.error_percent()),
                "√relMSE: the root of the mean over pixels and channels of (a − b)² / (b² + 0.01), with b the reference",
            ),
            (
                "relMSE",
                Some(self.rel_mse),
                "its square: falls as 1 / samples",
            ),
            (
                "RMSE",
                Some(self.rmse),
                "root of the mean of (a − b)²: rules where the picture is bright",
            ),
            (
                "MAPE",
                Some(self.mape),
                "mean of |a − b| / (|b| + 0.01): heeds single bright pixels less",
            ),
            (
                "SMAPE",
                Some(self.smape),
                "mean of 2 |a − b| / (|a| + |b| + 0.02), 0 to 2",
            ),
            (
                "largest |a − b|",
                Some(self.largest),
                "of one channel of one pixel",
            ),
            (
                "mean luminance of a",
                Some(self.mean_luminance_a),
                "Rec.709 weights",
            ),
            (
                "mean luminance of b",
                Some(self.mean_luminance_b),
                "Rec.709 weights",
            ),
            (
                "ratio of luminances",
                self.luminance_ratio,
                "a over b: 1 if nothing is too bright or too dark as a whole",
            ),
            (
                "SSIM",
                self.ssim,
                "mean structural similarity of what one sees: 1 is the same picture",
            ),
            (
                "FLIP",
                Some(self.flip),
                "mean of LDR-FLIP, the difference that one sees when the pictures alternate: 0 to 1",
            ),
            (
                "HDR-FLIP",
                self.hdr_flip,
                "the same over all exposures that show something",
            ),
        ]
    }
}

/// Layers that say how a picture was made: name, heading, unit, factor to that unit, logarithmic.
const LAYERS: [(&str, &str, &str, f32, bool); 3] = [
    ("Error", "Estimated error of", "%", 100.0, true),
    ("Debug Sample Count", "Samples of", "", 1.0, false),
    ("Cost", "Time of each pixel of", "µs", 1e-3, false),
];

/// The numbers of a layer of one channel, if the file has it.
fn layer_of(path: &Path, layer: &str) -> Result<Option<Vec<f32>>, MeasureError> {
    match super::load(path, Some(layer)) {
        Ok(picture) => Ok(Some(picture.pixels.iter().map(|pixel| pixel[0]).collect())),
        Err(MeasureError::NoSuchLayer { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// A text as it is; of a JSON object each member, `settings.samples`.
fn flatten(name: &str, text: &str, texts: &mut BTreeMap<String, String>) {
    use serde_json::Value;
    fn walk(name: &str, value: &Value, texts: &mut BTreeMap<String, String>) {
        match value {
            Value::Object(members) => {
                for (member, value) in members {
                    walk(&format!("{name}.{member}"), value, texts);
                }
            }
            Value::String(text) => {
                texts.insert(name.into(), text.clone());
            }
            Value::Null => {
                texts.insert(name.into(), "–".into());
            }
            other => {
                texts.insert(name.into(), other.to_string());
            }
        }
    }
    match serde_json::from_str(text) {
        Ok(object @ Value::Object(_)) => walk(name, &object, texts),
        _ => {
            texts.insert(name.into(), text.into());
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/measure/comparison.rs"]
mod tests;
