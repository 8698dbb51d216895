//! Plots as SVG and PNG, by plotters' charts. Both have the same layout; lengths are in pixels of a plot that is
//! [`WIDE`] or [`NARROW`] wide and become finer ones when drawn, because plotters' coordinates are whole numbers.

use super::axis::Range;
use super::number::number;
use super::{Line, Plot, Point, ReportError, Series, is_unseen};
use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::chart::{ChartBuilder, ChartContext, SeriesAnno, SeriesLabelPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{
    Circle, EmptyElement, ErrorBar, IntoDynElement, PathElement, Polygon, Rectangle, Text,
};
use plotters::series::LineSeries;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, IntoFont, RGBColor, ShapeStyle, TextStyle, register_font};
use std::sync::Once;

/// Width and height of a plot as it stands on a desktop's screen and in files.
pub(super) const WIDE: Layout = Layout {
    width: 860.0,
    height: 460.0,
    ticks: (9, 7),
    file: false,
};

/// The same on a telephone.
pub(super) const NARROW: Layout = Layout {
    width: 360.0,
    height: 340.0,
    ticks: (5, 6),
    file: false,
};

/// With a title and a legend, for files.
const FILE: Layout = Layout {
    height: 540.0,
    file: true,
    ..WIDE
};

/// Steps of a pixel in SVG.
const SVG_STEPS: f64 = 4.0;

/// The size of labels.
const FONT: f64 = 13.0;

/// plotters divides the size of fonts by this for SVG (its `svg.rs`), so that letters are as high as in PNG.
const SVG_FONT: f64 = 1.24;

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

/// The number of markers; page.css knows their forms, too.
pub(super) const MARKERS: usize = 5;

/// The size and the wealth of a plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    pub width: f64,
    pub height: f64,
    /// The most labels along x and y.
    pub ticks: (usize, usize),
    /// Whether it stands alone: with title, legend and what is left out.
    pub file: bool,
}

/// A drawn plot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawn {
    pub svg: String,
    /// Left, top, right and bottom of the frame, as shares of width and height.
    pub frame: [f64; 4],
}

impl Drawn {
    /// The SVG as an element of a page: HTML knows SVG's elements without their namespace's name.
    pub fn inline(&self) -> String {
        self.svg
            .replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1)
            .replacen("<svg ", "<svg role=\"img\" aria-hidden=\"true\" ", 1)
    }
}

type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<Range, Range>>;
type Drawing<T, B> = Result<T, DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

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
            let area = BitMapBackend::with_buffer(&mut pixels, (wide, high)).into_drawing_area();
            let pen = Pen {
                scale: f64::from(wide) / FILE.width,
                font_scale: 1.0,
            };
            self.draw(&area, &FILE, pen)
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
            let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
            let pen = Pen {
                scale: SVG_STEPS,
                font_scale: SVG_FONT,
            };
            self.draw(&area, layout, pen)
                .map_err(|reason| self.not_drawn(&reason))?
        };
        let size_in_steps = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
        let size = format!("width=\"{}\" height=\"{}\"", layout.width, layout.height);
        Ok(Drawn {
            // XML has no place for control characters.
            svg: svg
                .replacen(&size_in_steps, &size, 1)
                .replace(|symbol| symbol != '\n' && is_unseen(symbol), "\u{fffd}"),
            frame,
        })
    }

    fn not_drawn(&self, reason: &impl std::fmt::Display) -> ReportError {
        ReportError::NotDrawn {
            plot: self.title.clone(),
            reason: reason.to_string(),
        }
    }

    /// Draws everything; tells where the frame is.
    fn draw<'a, B: DrawingBackend + 'a>(
        &self,
        area: &'a DrawingArea<B, Shift>,
        layout: &Layout,
        pen: Pen,
    ) -> Drawing<[f64; 4], B> {
        set_font();
        area.fill(&WHITE)?;
        // (A page says it below the plot.)
        let left_out = self.left_out_sentence().filter(|_| layout.file);
        let below = if left_out.is_some() { 24.0 } else { 4.0 };
        let (x, y) = self.ranges();
        let mut builder = ChartBuilder::on(area);
        builder
            .margin_top(pen.pixels(10.0))
            .margin_right(pen.pixels(16.0))
            .margin_bottom(pen.pixels(below))
            .margin_left(pen.pixels(4.0))
            .x_label_area_size(pen.pixels(46.0))
            .y_label_area_size(pen.pixels(66.0));
        if layout.file && !self.title.is_empty() {
            builder.caption(&self.title, pen.font(1.25, TEXT));
        }
        let mut chart = builder.build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .x_labels(layout.ticks.0)
            .y_labels(layout.ticks.1)
            .bold_line_style(pen.stroke(GRID, 1.0))
            .light_line_style(pen.stroke(LIGHT_GRID, 1.0))
            .axis_style(pen.stroke(MUTED, 1.0))
            .set_all_tick_mark_size(pen.pixels(5.0))
            .label_style(pen.font(1.0, MUTED))
            .axis_desc_style(pen.font(1.0, TEXT))
            .x_desc(self.x.title())
            .y_desc(self.y.title())
            .draw()?;
        for (index, series) in self.colored() {
            let shown = series.points.iter().filter(|point| self.shows(point));
            let points: Vec<&Point> = shown.collect();
            pen.series(&mut chart, index, series, &points, (&x, &y))?;
        }
        if layout.file && self.series.len() > 1 {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .margin(pen.pixels(8.0))
                .legend_area_size(pen.pixels(38.0))
                .background_style(WHITE.mix(0.9))
                .border_style(pen.stroke(GRID, 1.0))
                .label_font(pen.font(1.0, TEXT))
                .draw()?;
        }
        let (across, down) = chart.plotting_area().get_pixel_range();
        if self.shown_points() == 0 {
            let middle = ((across.start + across.end) / 2, (down.start + down.end) / 2);
            let style = pen
                .font(1.0, MUTED)
                .pos(Pos::new(HPos::Center, VPos::Center));
            area.draw(&Text::new("no points to show", middle, style))?;
        }
        if let Some(sentence) = left_out {
            let at = (pen.pixels(8.0), pen.pixels(layout.height - 10.0));
            let style = pen
                .font(0.92, MUTED)
                .pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(sentence, at, style))?;
        }
        area.present()?;
        let share = |at: i32, side: f64| f64::from(at) / (side * pen.scale);
        Ok([
            share(across.start, layout.width),
            share(down.start, layout.height),
            share(across.end, layout.width),
            share(down.end, layout.height),
        ])
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

/// A text with its place, of which side.
pub(super) type Label = (String, (u32, u32), HPos);

/// Writes white texts, their tops at the given places, into a picture of RGB.
pub(super) fn labels(rgb: &mut [u8], size: (u32, u32), labels: &[Label]) -> Result<(), String> {
    set_font();
    let area = BitMapBackend::with_buffer(rgb, size).into_drawing_area();
    let font = ("sans-serif", 11).into_font().color(&WHITE);
    for (text, (x, y), side) in labels {
        let style = font.pos(Pos::new(*side, VPos::Top));
        area.draw(&Text::new(text.as_str(), (*x as i32, *y as i32), style))
            .map_err(|error| error.to_string())?;
    }
    area.present().map_err(|error| error.to_string())
}

/// Lengths and styles in pixels of the layout.
#[derive(Clone, Copy)]
struct Pen {
    scale: f64,
    font_scale: f64,
}

impl Pen {
    fn pixels(self, length: f64) -> i32 {
        (length * self.scale).round() as i32
    }

    fn stroke(self, color: RGBColor, width: f64) -> ShapeStyle {
        color.stroke_width(self.pixels(width).max(1) as u32)
    }

    fn font(self, size: f64, color: RGBColor) -> TextStyle<'static> {
        let font = ("sans-serif", FONT * size * self.scale * self.font_scale).into_font();
        font.color(&color)
    }

    /// Draws a series of points that all have a place.
    fn series<'a, B: DrawingBackend + 'a>(
        self,
        chart: &mut Chart<'a, B>,
        index: usize,
        series: &Series,
        points: &[&Point],
        (x, y): (&Range, &Range),
    ) -> Drawing<(), B> {
        let color = COLORS[index % COLORS.len()];
        let path: Vec<(f64, f64)> = points.iter().map(|point| (point.x, point.y)).collect();
        // The lower end of a spread may have no place on a logarithmic axis: it goes down to the frame.
        let (lowest, highest) = (y.value(0.0), y.value(1.0));
        chart.draw_series(points.iter().filter_map(|point| {
            let (low, high) = (point.low?.max(lowest), point.high?.min(highest));
            let style = color.mix(0.55).stroke_width(self.pixels(1.5) as u32);
            let caps = self.pixels(6.0) as u32;
            let bar = ErrorBar::new_vertical(point.x, low, point.y, high, style, caps);
            (series.line != Line::Dashed && series.line != Line::Bars).then_some(bar)
        }))?;
        let stroke = self.stroke(color, 2.0);
        let (dash, gap) = (self.pixels(7.0), self.pixels(5.0));
        let annotation = match series.line {
            Line::Bars => chart.draw_series(bars(&path, x, y, self.pixels(0.5) as u32, color))?,
            Line::Dashed => {
                let lengths = [dash, gap].map(f64::from);
                let (width, height) = chart.plotting_area().dim_in_pixel();
                let size = (f64::from(width), f64::from(height));
                let dashes = dashes(&path, (x, y), size, lengths);
                let dashes = dashes.into_iter();
                chart.draw_series(dashes.map(|ends| PathElement::new(ends.to_vec(), stroke)))?
            }
            Line::Solid => {
                chart.draw_series(LineSeries::new(path.iter().copied(), stroke))?;
                self.markers(chart, index, path)?
            }
            Line::None => self.markers(chart, index, path)?,
        };
        let (line, length) = (series.line, self.pixels(28.0));
        annotation.label(&series.name).legend(move |(x, y)| {
            let middle = x + length / 2;
            match (line, self.corners(index)) {
                (Line::Dashed, _) => {
                    // One dash stands for many.
                    PathElement::new([(x, y), (x + dash, y)], stroke).into_dyn()
                }
                (_, None) => Circle::new((middle, y), self.pixels(4.0), color.filled()).into_dyn(),
                (_, Some(corners)) => {
                    let corners = corners.iter().map(|(dx, dy)| (middle + dx, y + dy));
                    Polygon::new(corners.collect::<Vec<_>>(), color.filled()).into_dyn()
                }
            }
        });
        Ok(())
    }

    /// A marker on each of the points.
    fn markers<'c, 'a, B: DrawingBackend + 'a>(
        self,
        chart: &'c mut Chart<'a, B>,
        index: usize,
        path: Vec<(f64, f64)>,
    ) -> Drawing<&'c mut SeriesAnno<'a, B>, B> {
        let style = COLORS[index % COLORS.len()].filled();
        let path = path.into_iter().map(EmptyElement::at);
        match self.corners(index) {
            None => {
                let radius = self.pixels(4.0);
                chart.draw_series(path.map(|at| at + Circle::new((0, 0), radius, style)))
            }
            Some(corners) => {
                chart.draw_series(path.map(|at| at + Polygon::new(corners.clone(), style)))
            }
        }
    }

    /// Each series has a form of its own besides its colour, of [`MARKERS`]; none is a circle.
    fn corners(self, index: usize) -> Option<Vec<(i32, i32)>> {
        let corners: &[(f64, f64)] = match index % MARKERS {
            0 => return None,
            1 => &[(-3.6, -3.6), (3.6, -3.6), (3.6, 3.6), (-3.6, 3.6)],
            2 => &[(0.0, -5.0), (4.6, 3.6), (-4.6, 3.6)],
            3 => &[(0.0, -5.2), (5.2, 0.0), (0.0, 5.2), (-5.2, 0.0)],
            _ => &[(0.0, 5.0), (4.6, -3.6), (-4.6, -3.6)],
        };
        let pixels = corners
            .iter()
            .map(|(x, y)| (self.pixels(*x), self.pixels(*y)));
        Some(pixels.collect())
    }
}

/// The dashes of a path by the lengths of a dash and a gap, on a plot of a size, all in pixels. (Not plotters' own: they take
/// `hypotf` of a newer C library than the add-on's package may need.)
fn dashes(
    path: &[(f64, f64)],
    (x, y): (&Range, &Range),
    (width, height): (f64, f64),
    [dash, gap]: [f64; 2],
) -> Vec<[(f64, f64); 2]> {
    let on_plot = |&(a, b): &(f64, f64)| (x.position(a) * width, y.position(b) * height);
    let back = |(a, b): (f64, f64)| (x.value(a / width), y.value(b / height));
    let (mut found, mut done) = (Vec::new(), 0.0);
    for ends in path.windows(2) {
        let (from, to) = (on_plot(&ends[0]), on_plot(&ends[1]));
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = (dx * dx + dy * dy).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            continue;
        }
        let at = |along: f64| {
            let share = along / length;
            back((from.0 + dx * share, from.1 + dy * share))
        };
        let mut along = 0.0;
        while along < length {
            // How far the pattern has come, and whether that is on a dash.
            let phase = done % (dash + gap);
            let left = if phase < dash { dash } else { dash + gap } - phase;
            let next = (along + left.max(0.5)).min(length);
            if phase < dash {
                found.push([at(along), at(next)]);
            }
            done += next - along;
            along = next;
        }
    }
    found
}

/// Bars with a gap between them; a point is the middle of its bar.
fn bars(
    path: &[(f64, f64)],
    x: &Range,
    y: &Range,
    gap: u32,
    color: RGBColor,
) -> Vec<Rectangle<(f64, f64)>> {
    let at: Vec<f64> = path.iter().map(|point| x.position(point.0)).collect();
    let half_way = |from: f64, other: Option<&f64>| Some((from - other?).abs() / 2.0);
    let bar = |(index, &(_, height)): (usize, &(f64, f64))| {
        let middle = at[index];
        let before = half_way(
            middle,
            index.checked_sub(1).and_then(|before| at.get(before)),
        );
        let after = half_way(middle, at.get(index + 1));
        let left = middle - before.or(after).unwrap_or(0.01);
        let right = middle + after.or(before).unwrap_or(0.01);
        let ends = [left, right].map(|end| x.value(end.clamp(0.0, 1.0)));
        let corners = [(ends[0], height), (ends[1], y.value(0.0))];
        let mut bar = Rectangle::new(corners, color.filled());
        bar.set_margin(0, 0, gap, gap);
        bar
    };
    path.iter().enumerate().map(bar).collect()
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
#[path = "../../tests/unit/report/draw.rs"]
mod tests;
