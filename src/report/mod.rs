//! Reports: plain data in, pages and plots out.
//!
//! A [`Page`] becomes one HTML file that needs nothing else: no network, no other file. A [`Plot`] becomes SVG, PNG or
//! CSV. The room knows nothing of rendering: commands fill in names, numbers and pictures.

mod axis;
mod draw;
mod heat_map;
mod html;
mod number;
mod picture;
mod table;

pub use heat_map::HeatMap;
pub use number::number;
pub use picture::PageImage;

/// Whether a symbol is not seen as itself: a control character, an end of a line, or one that turns the order of the
/// symbols around it about (Unicode's Bidi_Control). In a name it would let a text pass for another one.
pub fn is_unseen(symbol: char) -> bool {
    symbol.is_control()
        || matches!(
            symbol,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

/// Why a report could not be made. Each message is one sentence.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The drawing library refused.
    #[error("cannot draw the plot {plot}: {reason}")]
    NotDrawn {
        /// Its title.
        plot: String,
        /// What the library says.
        reason: String,
    },
    /// A picture's data does not fit its size, or cannot be written as PNG.
    #[error("cannot show the picture {picture}: {reason}")]
    NotShown {
        /// Its name.
        picture: String,
        /// What is wrong.
        reason: String,
    },
}

/// One HTML file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Heading of the page and name of the window.
    pub title: String,
    /// One line below it.
    pub subtitle: String,
    /// What it shows, from top to bottom.
    pub sections: Vec<Section>,
}

/// A part of a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Section {
    /// Sentences.
    Text {
        /// Heading.
        title: String,
        /// A paragraph each.
        paragraphs: Vec<String>,
    },
    /// Numbers that can be sorted.
    Table(Table),
    /// Curves with the values of the point under the pointer.
    Curves(Plot),
    /// Pictures over each other, with a bar between two of them.
    Slider(Slider),
    /// Numbers of each pixel in colours.
    HeatMaps(HeatMaps),
    /// How something was made: names and values.
    Settings(Settings),
}

/// Rows of cells below named columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Heading.
    pub title: String,
    /// What there is to know about it; may be empty.
    pub note: String,
    /// One for each cell of a row.
    pub columns: Vec<Column>,
    /// From top to bottom.
    pub rows: Vec<Vec<Cell>>,
}

/// The head of a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Its name, with the unit.
    pub name: String,
    /// What the numbers below it are; may be empty.
    pub explanation: String,
}

impl Column {
    /// A column without an explanation.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            explanation: String::new(),
        }
    }

    /// The same with an explanation.
    pub fn explained(name: impl Into<String>, explanation: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            explanation: explanation.into(),
        }
    }
}

/// One cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// What is read.
    pub text: String,
    /// By what it is sorted; none for words, which are sorted as such.
    pub value: Option<f64>,
}

impl Cell {
    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            value: None,
        }
    }

    /// A number with four digits.
    pub fn number(value: f64) -> Self {
        Self::shown(value, number(value))
    }

    /// A number that is written in a way of its own.
    pub fn shown(value: f64, text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            value: Some(value),
        }
    }
}

/// Curves in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// Heading.
    pub title: String,
    /// What there is to know about it; may be empty. Shown below the plot on pages, not in SVG and PNG.
    pub note: String,
    /// Rightwards.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// The curves.
    pub series: Vec<Series>,
}

/// What an axis measures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// What it is, such as `time`.
    pub label: String,
    /// In what, such as `s`; empty for a mere number.
    pub unit: String,
    /// Whether it is logarithmic.
    pub log: bool,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            log: false,
        }
    }

    /// A logarithmic axis.
    pub fn log(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            log: true,
            ..Self::linear(label, unit)
        }
    }
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// What it is of.
    pub name: String,
    /// How its points are joined.
    pub line: Line,
    /// In the order in which they are joined.
    pub points: Vec<Point>,
}

impl Series {
    /// Points joined by a line.
    pub fn new(name: impl Into<String>, points: Vec<Point>) -> Self {
        Self {
            name: name.into(),
            line: Line::Solid,
            points,
        }
    }

    /// A fitted or predicted curve: dashed, without markers, in the colour of the series before it.
    pub fn fitted(name: impl Into<String>, points: Vec<Point>) -> Self {
        Self {
            line: Line::Dashed,
            ..Self::new(name, points)
        }
    }
}

/// How the points of a series are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Line {
    /// Measured: a line with a marker on each point.
    #[default]
    Solid,
    /// Fitted or predicted: dashes without markers.
    Dashed,
    /// Markers alone.
    None,
    /// Bars from the axis up to the points: a histogram.
    Bars,
}

/// One point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// Along the x axis.
    pub x: f64,
    /// Along the y axis.
    pub y: f64,
    /// Lower end of its spread along y.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// What it is, such as `64 samples`; may be empty.
    pub label: String,
}

impl Point {
    /// A point without a spread and a label.
    pub fn new(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            ..Self::default()
        }
    }

    /// The same with a spread along y.
    #[must_use]
    pub fn spread(self, low: f64, high: f64) -> Self {
        Self {
            low: Some(low),
            high: Some(high),
            ..self
        }
    }

    /// The same with a label.
    #[must_use]
    pub fn labelled(self, label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            ..self
        }
    }
}

/// Pictures of one size, of which two are shown on both sides of a bar that can be moved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slider {
    /// Heading.
    pub title: String,
    /// What there is to know about it; may be empty.
    pub note: String,
    /// At least one. The first two are shown first.
    pub pictures: Vec<PageImage>,
}

/// Heat maps beside each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMaps {
    /// Heading.
    pub title: String,
    /// What there is to know about them; may be empty.
    pub note: String,
    /// The maps.
    pub maps: Vec<HeatMap>,
}

/// Names with a value for each of the columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Heading.
    pub title: String,
    /// What there is to know about them; may be empty.
    pub note: String,
    /// What the values are of, such as the names of two pictures.
    pub columns: Vec<String>,
    /// A name and a value for each column (empty where there is none).
    pub rows: Vec<(String, Vec<String>)>,
}

impl Settings {
    /// The members of a JSON object that are not null, `max_bounces` as `max bounces`.
    pub fn of(column: impl Into<String>, object: &serde_json::Value) -> Self {
        let text = |value: &serde_json::Value| match value.as_str() {
            Some(text) => text.to_owned(),
            None => value.to_string(),
        };
        let members = object.as_object().into_iter().flatten();
        Self {
            title: "Settings".into(),
            note: String::new(),
            columns: vec![column.into()],
            rows: members
                .filter(|(_, value)| !value.is_null())
                .map(|(name, value)| (name.replace('_', " "), vec![text(value)]))
                .collect(),
        }
    }
}
