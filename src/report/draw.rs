//! Plots as SVG and PNG, by plotters. Both have the same layout; lengths are in pixels of a plot that is
//! [`WIDE`] or [`NARROW`] wide and become finer ones when drawn, because plotters' coordinates are whole numbers.

use super::axis::{Range, Tick};
use super::number::number;
use super::{Line, Plot, Point, ReportError, Series};
use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, IntoFont, RGBColor, ShapeStyle, TextStyle, register_font};
use std::sync::Once;

/// Width and height of a plot as it stands on a desktop's screen and in files.
pub(super) const WIDE: Layout = Layout {
    width: 860.0,
    height: 500.0,
    ticks: (9, 7),
    title: false,
};

/// The same on a telephone.
pub(super) const NARROW: Layout = Layout {
    width: 360.0,
    height: 380.0,
    ticks: (5, 6),
    title: false,
};

/// With a title, for files.
const FILE: Layout = Layout {
    height: 540.0,
    title: true,
    ..WIDE
};

/// Steps of a pixel in SVG.
const SVG_STEPS: f64 = 4.0;

/// A font's size of which a letter's width is measured and drawn.
const FONT: f64 = 13.0;

/// plotters divides the size of fonts by this for SVG (its `svg.rs`), so that letters are as high as in PNG.
const SVG_FONT: f64 = 1.24;

/// Letters of the reader's own font may be wider than those that are measured here.
const WIDER: f64 = 1.22;

/// Colours on white: Okabe and Ito's (2008), told apart by the colour-blind; yellow and light blue, too pale for lines,
/// are left out, orange is darker.
pub(super) const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 128, 96),
    RGBColor(168, 74, 130),
    RGBColor(148, 110, 0),
    RGBColor(74, 74, 74),
    RGBColor(88, 86, 214),
];
const TEXT: RGBColor = RGBColor(34, 34, 34);
const MUTED: RGBColor = RGBColor(85, 85, 85);
const GRID: RGBColor = RGBColor(214, 216, 220);
const LIGHT_GRID: RGBColor = RGBColor(240, 241, 243);
const WHITE: RGBColor = RGBColor(255, 255, 255);

/// The size and the wealth of a plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    pub width: f64,
    pub height: f64,
    /// The most labels along x and y.
    pub ticks: (usize, usize),
    /// Whether it stands alone: with the title above and what is left out below.
    pub title: bool,
}

/// A drawn plot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawn {
    pub svg: String,
    /// Left, top, right and bottom of the frame, as shares of width and height.
    pub frame: [f64; 4],
}

impl Plot {
    /// The plot as a file of its own, with its title; text is text.
    ///
    /// # Errors
    /// The library cannot draw it.
    pub fn svg(&self) -> Result<String, ReportError> {
        Ok(self.drawn(&FILE)?.svg)
    }

    /// The plot as PNG, `width` pixels wide.
    ///
    /// # Errors
    /// The library cannot draw it, or it has no width.
    pub fn png(&self, width: u32) -> Result<Vec<u8>, ReportError> {
        // plotters does not smooth all that it draws: twice the size, then the mean of four pixels.
        let height = (f64::from(width) * FILE.height / FILE.width).round() as u32;
        let (wide, high) = (2 * width, 2 * height);
        let mut pixels = vec![255; 3 * wide as usize * high as usize];
        {
            let backend = BitMapBackend::with_buffer(&mut pixels, (wide, high));
            let scale = f64::from(wide) / FILE.width;
            self.draw(backend.into_drawing_area(), &FILE, scale, 1.0)
                .map_err(|reason| self.not_drawn(&reason))?;
        }
        let row = 3 * wide as usize;
        let mean: Vec<u8> = (0..height as usize)
            .flat_map(|y| (0..3 * width as usize).map(move |x| (y, x)))
            .map(|(y, x)| {
                let start = 2 * y * row + 6 * (x / 3) + x % 3;
                let sum: u32 = [start, start + 3, start + row, start + row + 3]
                    .map(|index| u32::from(pixels[index]))
                    .iter()
                    .sum();
                ((sum + 2) / 4) as u8
            })
            .collect();
        super::picture::png(&self.title, (width, height), &mean)
    }

    /// The plot as SVG and where its frame is.
    pub(super) fn drawn(&self, layout: &Layout) -> Result<Drawn, ReportError> {
        let size = (
            (layout.width * SVG_STEPS) as u32,
            (layout.height * SVG_STEPS) as u32,
        );
        let mut svg = String::new();
        let frame = {
            let backend = SVGBackend::with_string(&mut svg, size);
            self.draw(backend.into_drawing_area(), layout, SVG_STEPS, SVG_FONT)
                .map_err(|reason| self.not_drawn(&reason))?
        };
        let size_in_steps = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
        let size = format!("width=\"{}\" height=\"{}\"", layout.width, layout.height);
        Ok(Drawn {
            svg: svg.replacen(&size_in_steps, &size, 1),
            frame,
        })
    }

    fn not_drawn(&self, reason: &str) -> ReportError {
        ReportError::NotDrawn {
            plot: self.title.clone(),
            reason: reason.to_owned(),
        }
    }

    /// Draws everything; tells where the frame is.
    fn draw<B: DrawingBackend>(
        &self,
        area: DrawingArea<B, Shift>,
        layout: &Layout,
        scale: f64,
        font_scale: f64,
    ) -> Result<[f64; 4], String> {
        set_font();
        let mut pen = Pen {
            area,
            scale,
            font_scale,
            error: None,
        };
        pen.fill(0.0, 0.0, layout.width, layout.height, WHITE, 1.0);
        let (range_x, range_y) = self.ranges();
        let ticks_x = range_x.ticks(layout.ticks.0);
        let ticks_y = range_y.ticks(layout.ticks.1);
        let mut top = 4.0;
        if layout.title {
            pen.text(8.0, top + 10.0, &self.title, 1.25, TEXT, HPos::Left);
            top += 26.0;
        }
        top = self.legend(&mut pen, layout, top);
        pen.text(8.0, top + 8.0, &self.y.title(), 1.0, TEXT, HPos::Left);
        top += 24.0;
        let widest = |ticks: &[Tick]| {
            ticks
                .iter()
                .filter_map(|tick| tick.label.as_deref())
                .map(|label| pen.width_of(label))
                .fold(0.0, f64::max)
        };
        // (A page says it below the plot.)
        let left_out = self.left_out_sentence().filter(|_| layout.title);
        let below = 44.0 + if left_out.is_some() { 18.0 } else { 0.0 };
        let frame = Frame {
            left: 14.0 + widest(&ticks_y).max(14.0),
            top,
            right: layout.width - 14.0,
            bottom: layout.height - below,
            x: range_x,
            y: range_y,
        };
        frame.grid(&mut pen, &ticks_x, &ticks_y);
        pen.text(
            frame.right,
            frame.bottom + 31.0,
            &self.x.title(),
            1.0,
            TEXT,
            HPos::Right,
        );
        if let Some(sentence) = left_out {
            let base = frame.bottom + 50.0;
            pen.text(8.0, base, &sentence, 0.92, MUTED, HPos::Left);
        }
        for (index, series) in self.colored() {
            let points: Vec<_> = series
                .points
                .iter()
                .filter(|point| self.shows(point))
                .collect();
            frame.series(&mut pen, index, series.line, &points);
        }
        if self.shown_points() == 0 {
            let middle = (
                (frame.left + frame.right) / 2.0,
                (frame.top + frame.bottom) / 2.0,
            );
            pen.text(
                middle.0,
                middle.1,
                "no points to show",
                1.0,
                MUTED,
                HPos::Center,
            );
        }
        pen.finish()?;
        Ok([
            frame.left / layout.width,
            frame.top / layout.height,
            frame.right / layout.width,
            frame.bottom / layout.height,
        ])
    }

    /// Names with a piece of their line, in as many rows as they need; returns where the last one ends.
    fn legend<B: DrawingBackend>(&self, pen: &mut Pen<B>, layout: &Layout, top: f64) -> f64 {
        if self.series.len() < 2 {
            return top;
        }
        let (mut x, mut y) = (8.0, top);
        for (index, series) in self.colored() {
            let width = 34.0 + pen.width_of(&series.name) + 18.0;
            if x > 8.0 && x + width > layout.width {
                (x, y) = (8.0, y + 20.0);
            }
            let line = [(x, y + 8.0), (x + 28.0, y + 8.0)];
            match series.line {
                Line::Solid => pen.line(&line, COLORS[index % COLORS.len()], 2.0, 1.0),
                Line::Dashed => pen.dashes(&line, COLORS[index % COLORS.len()]),
                Line::None | Line::Bars => {}
            }
            if series.line != Line::Dashed {
                pen.marker(index, x + 14.0, y + 8.0);
            }
            pen.text(x + 34.0, y + 8.0, &series.name, 1.0, TEXT, HPos::Left);
            x += width;
        }
        y + 24.0
    }

    /// The series, each with the number of its colour and marker: a fitted one has that of what it is fitted to, which
    /// stands before it.
    pub(super) fn colored(&self) -> impl Iterator<Item = (usize, &Series)> {
        let mut next = 0;
        self.series.iter().map(move |series| {
            if series.line != Line::Dashed {
                next += 1;
            }
            (usize::saturating_sub(next, 1), series)
        })
    }

    /// What the axes range over: all points and their spreads.
    pub(super) fn ranges(&self) -> (Range, Range) {
        let points = || {
            self.series
                .iter()
                .flat_map(|series| &series.points)
                .filter(|point| self.shows(point))
        };
        let bars = self.series.iter().any(|series| series.line == Line::Bars);
        let floor = (bars && !self.y.log).then_some(0.0);
        (
            Range::of(&self.x, points().map(|point| point.x)),
            Range::of(
                &self.y,
                points()
                    .flat_map(|point| [Some(point.y), point.low, point.high])
                    .flatten()
                    .chain(floor),
            ),
        )
    }

    /// Whether a point has a place on both axes.
    pub(super) fn shows(&self, point: &Point) -> bool {
        self.x.shows(point.x) && self.y.shows(point.y)
    }

    fn shown_points(&self) -> usize {
        self.series
            .iter()
            .flat_map(|series| &series.points)
            .filter(|point| self.shows(point))
            .count()
    }

    /// Says how many points have no place on the axes; none if all have.
    pub(super) fn left_out_sentence(&self) -> Option<String> {
        let all: usize = self.series.iter().map(|series| series.points.len()).sum();
        let left_out = all - self.shown_points();
        let (noun, verb) = if left_out == 1 {
            ("point", "is")
        } else {
            ("points", "are")
        };
        let logarithmic = if self.x.log || self.y.log {
            ", or not above 0 on a logarithmic axis"
        } else {
            ""
        };
        (left_out > 0)
            .then(|| format!("{left_out} {noun} of {all} {verb} left out: not finite{logarithmic}"))
    }
}

/// Registers the font of PNG files, once: the machine may have none.
fn set_font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // It cannot fail for this font; if it did, plotters would say so when it draws.
        let _ = register_font("sans-serif", FontStyle::Normal, ttf_noto_sans::REGULAR);
    });
}

/// Where the curves are.
struct Frame {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
    x: Range,
    y: Range,
}

impl Frame {
    fn x(&self, at: f64) -> f64 {
        self.left + at * (self.right - self.left)
    }

    fn y(&self, at: f64) -> f64 {
        self.bottom - at * (self.bottom - self.top)
    }

    fn grid<B: DrawingBackend>(&self, pen: &mut Pen<B>, ticks_x: &[Tick], ticks_y: &[Tick]) {
        let color = |tick: &Tick| {
            if tick.label.is_some() {
                GRID
            } else {
                LIGHT_GRID
            }
        };
        for tick in ticks_x {
            let x = self.x(tick.at);
            pen.line(&[(x, self.top), (x, self.bottom)], color(tick), 1.0, 1.0);
        }
        for tick in ticks_y {
            let y = self.y(tick.at);
            pen.line(&[(self.left, y), (self.right, y)], color(tick), 1.0, 1.0);
        }
        for tick in ticks_x {
            if let Some(label) = &tick.label {
                let half = pen.width_of(label) / 2.0;
                let x = self.x(tick.at).min(self.right + 12.0 - half);
                pen.text(x, self.bottom + 12.0, label, 1.0, MUTED, HPos::Center);
            }
        }
        for tick in ticks_y {
            if let Some(label) = &tick.label {
                let y = self.y(tick.at);
                pen.text(self.left - 6.0, y, label, 1.0, MUTED, HPos::Right);
            }
        }
        let axes = [
            (self.left, self.top),
            (self.left, self.bottom),
            (self.right, self.bottom),
        ];
        pen.line(&axes, MUTED, 1.0, 1.0);
    }

    fn series<B: DrawingBackend>(
        &self,
        pen: &mut Pen<B>,
        index: usize,
        line: Line,
        points: &[&Point],
    ) {
        let color = COLORS[index % COLORS.len()];
        let place = |x: f64, y: f64| (self.x(self.x.position(x)), self.y(self.y.position(y)));
        let path: Vec<_> = points.iter().map(|point| place(point.x, point.y)).collect();
        if line == Line::Bars {
            return self.bars(pen, color, &path);
        }
        for point in points {
            if let (Some(low), Some(high)) = (point.low, point.high) {
                self.spread(pen, color, point.x, (low, high));
            }
        }
        match line {
            Line::Solid => pen.line(&path, color, 2.0, 1.0),
            Line::Dashed => return pen.dashes(&path, color),
            Line::None | Line::Bars => {}
        }
        for (x, y) in path {
            pen.marker(index, x, y);
        }
    }

    /// A thin line from the lower to the upper end of a spread, cut off at the frame.
    fn spread<B: DrawingBackend>(
        &self,
        pen: &mut Pen<B>,
        color: RGBColor,
        x: f64,
        (low, high): (f64, f64),
    ) {
        let x = self.x(self.x.position(x));
        // A lower end at or below 0 has no place on a logarithmic axis: the spread goes down to the frame.
        let end = |value: f64| match self.y.position(value) {
            at if at.is_nan() => 0.0,
            at => at.clamp(0.0, 1.0),
        };
        let (low, high) = (self.y(end(low)), self.y(end(high)));
        pen.line(&[(x, low), (x, high)], color, 1.5, 0.55);
        for y in [low, high] {
            pen.line(&[(x - 3.0, y), (x + 3.0, y)], color, 1.5, 0.55);
        }
    }

    /// Bars a pixel apart; a point is the middle of its bar.
    fn bars<B: DrawingBackend>(&self, pen: &mut Pen<B>, color: RGBColor, path: &[(f64, f64)]) {
        for (index, &(x, y)) in path.iter().enumerate() {
            let half_way =
                |other: Option<&(f64, f64)>| other.map(|other| (other.0 - x).abs() / 2.0);
            let before = half_way(index.checked_sub(1).and_then(|index| path.get(index)));
            let after = half_way(path.get(index + 1));
            let left = before.or(after).unwrap_or(8.0);
            let right = after.or(before).unwrap_or(8.0);
            let left = (x - left).max(self.left) + 0.5;
            let right = (x + right).min(self.right) - 0.5;
            pen.fill(left, y, right, self.bottom, color, 1.0);
        }
    }
}

/// Draws in pixels of the layout; keeps the first error for the end.
struct Pen<B: DrawingBackend> {
    area: DrawingArea<B, Shift>,
    scale: f64,
    font_scale: f64,
    error: Option<String>,
}

impl<B: DrawingBackend> Pen<B> {
    fn place(&self, (x, y): (f64, f64)) -> (i32, i32) {
        (
            (x * self.scale).round() as i32,
            (y * self.scale).round() as i32,
        )
    }

    fn keep(&mut self, result: Result<(), DrawingAreaErrorKind<B::ErrorType>>) {
        if let Err(error) = result {
            self.error.get_or_insert(error.to_string());
        }
    }

    fn finish(mut self) -> Result<(), String> {
        let result = self.area.present();
        self.keep(result);
        self.error.map_or(Ok(()), Err)
    }

    fn style(&self, color: RGBColor, width: f64, opacity: f64) -> ShapeStyle {
        ShapeStyle {
            color: color.mix(opacity),
            filled: false,
            stroke_width: (width * self.scale).round().max(1.0) as u32,
        }
    }

    fn fill(
        &mut self,
        left: f64,
        top: f64,
        right: f64,
        bottom: f64,
        color: RGBColor,
        opacity: f64,
    ) {
        let corners = [self.place((left, top)), self.place((right, bottom))];
        let style = color.mix(opacity).filled();
        let result = self.area.draw(&Rectangle::new(corners, style));
        self.keep(result);
    }

    fn line(&mut self, path: &[(f64, f64)], color: RGBColor, width: f64, opacity: f64) {
        if path.len() < 2 {
            return;
        }
        let style = self.style(color, width, opacity);
        let path: Vec<_> = path.iter().map(|place| self.place(*place)).collect();
        let result = self.area.draw(&PathElement::new(path, style));
        self.keep(result);
    }

    /// The same as dashes of 7 pixels with gaps of 5.
    fn dashes(&mut self, path: &[(f64, f64)], color: RGBColor) {
        const DASH: f64 = 7.0;
        const PERIOD: f64 = 12.0;
        let mut walked = 0.0;
        let mut dash: Vec<(f64, f64)> = Vec::new();
        for pair in path.windows(2) {
            let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
            let length = ((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0)).sqrt();
            let mut at = 0.0;
            while at < length {
                let phase = (walked + at) % PERIOD;
                let rest = if phase < DASH {
                    DASH - phase
                } else {
                    PERIOD - phase
                };
                // At least a hundredth of a pixel, so that rounding cannot make it stand still.
                let next = (at + rest.max(0.01)).min(length);
                let place = |at: f64| (x0 + (x1 - x0) * at / length, y0 + (y1 - y0) * at / length);
                if phase < DASH {
                    if dash.is_empty() {
                        dash.push(place(at));
                    }
                    dash.push(place(next));
                }
                if phase >= DASH || next < length {
                    self.line(&std::mem::take(&mut dash), color, 2.0, 1.0);
                }
                at = next;
            }
            walked += length;
        }
        self.line(&dash, color, 2.0, 1.0);
    }

    /// Each series has a form of its own besides its colour.
    fn marker(&mut self, index: usize, x: f64, y: f64) {
        let color = COLORS[index % COLORS.len()];
        let corners: &[(f64, f64)] = match index % 5 {
            0 => {
                let radius = (4.0 * self.scale).round() as i32;
                let circle = Circle::new(self.place((x, y)), radius, color.filled());
                let result = self.area.draw(&circle);
                return self.keep(result);
            }
            1 => &[(-3.6, -3.6), (3.6, -3.6), (3.6, 3.6), (-3.6, 3.6)],
            2 => &[(0.0, -5.0), (4.6, 3.6), (-4.6, 3.6)],
            3 => &[(0.0, -5.2), (5.2, 0.0), (0.0, 5.2), (-5.2, 0.0)],
            _ => &[(0.0, 5.0), (4.6, -3.6), (-4.6, -3.6)],
        };
        let corners: Vec<_> = corners
            .iter()
            .map(|(dx, dy)| self.place((x + dx, y + dy)))
            .collect();
        let result = self.area.draw(&Polygon::new(corners, color.filled()));
        self.keep(result);
    }

    fn font(&self, size: f64) -> TextStyle<'static> {
        ("sans-serif", FONT * size * self.scale * self.font_scale)
            .into_font()
            .into()
    }

    fn text(&mut self, x: f64, y: f64, text: &str, size: f64, color: RGBColor, side: HPos) {
        if text.is_empty() {
            return;
        }
        // XML has no place for control characters.
        let text: String = text
            .chars()
            .map(|symbol| {
                if symbol.is_control() {
                    '\u{fffd}'
                } else {
                    symbol
                }
            })
            .collect();
        let style = self
            .font(size)
            .color(&color)
            .pos(Pos::new(side, VPos::Center));
        let result = self.area.draw(&Text::new(text, self.place((x, y)), style));
        self.keep(result);
    }

    /// How wide a text is at the usual size, in pixels of the layout.
    fn width_of(&self, text: &str) -> f64 {
        let style = ("sans-serif", FONT * self.scale).into_font().into();
        match self.area.estimate_text_size(text, &style) {
            Ok((width, _)) => WIDER * f64::from(width) / self.scale,
            // Drawing the text will fail with the same error and tell it; half the size is a letter's usual width.
            Err(_) => 0.5 * FONT * text.chars().count() as f64,
        }
    }
}

/// A point in words, for pages: x, y and spread with their units.
pub(super) fn words(plot: &Plot, point: &Point) -> [String; 3] {
    let spread = match (point.low, point.high) {
        (Some(low), Some(high)) => format!("{} to {}", number(low), number(high)),
        _ => String::new(),
    };
    [
        super::number::with_unit(point.x, &plot.x.unit),
        super::number::with_unit(point.y, &plot.y.unit),
        spread,
    ]
}

#[cfg(test)]
mod tests {
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

    /// Share of pixels in which a PNG has something else than white.
    fn ink(png: &[u8], rows: std::ops::Range<u32>) -> usize {
        let picture = image::load_from_memory(png).unwrap().to_rgb8();
        picture
            .enumerate_pixels()
            .filter(|(_, y, _)| rows.contains(y))
            .filter(|(_, _, pixel)| pixel.0 != [255; 3])
            .count()
    }

    #[test]
    fn png_has_text_without_fonts_of_the_system() {
        // The title stands in the first 28 of 540 rows; without it nothing does.
        let with = plot(vec![halving()]).png(860).unwrap();
        let without = Plot {
            title: String::new(),
            ..plot(vec![halving()])
        }
        .png(860)
        .unwrap();
        assert!(ink(&with, 0..28) > 300, "{}", ink(&with, 0..28));
        assert_eq!(ink(&without, 0..28), 0);
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
        let sentence =
            "4 points of 6 are left out: not finite, or not above 0 on a logarithmic axis";
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

    #[test]
    fn dashes_cover_their_share_of_a_line() {
        let fitted = Series::fitted("fit", vec![Point::new(1.0, 1.0), Point::new(100.0, 1.0)]);
        let plot = plot(vec![fitted]);
        let drawn = plot.drawn(&WIDE).unwrap();
        let color = "stroke=\"#0072B2\"";
        let dashes = drawn
            .svg
            .lines()
            .filter(|line| line.contains(color))
            .count();
        let length = (drawn.frame[2] - drawn.frame[0]) * WIDE.width / (1.0 + 2.0 * 0.03);
        assert_eq!(dashes, (length / 12.0).ceil() as usize);
    }
}
