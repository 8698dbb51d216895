//! The difference of two pictures as a picture: a heat map with a scale.

use super::{MeasureError, Picture};

/// A heat map: RGB, 8 bits, rows from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows: those of the pictures and those of the scale below.
    pub height: u32,
    /// `3 * width * height` code values.
    pub pixels: Vec<u8>,
    /// The difference that the brightest colour stands for.
    pub scale: f64,
}

/// Marks a pixel that is not finite in one of the pictures; the heat map has no such colour.
const NOT_FINITE: [u8; 3] = [0, 160, 255];

/// Size of the scale below the picture.
const SCALE_ROWS: u32 = 24;
/// Rows of its coloured bar.
const BAR_ROWS: u32 = 10;
/// So wide a picture is at least, so that the scale has room.
const LEAST_WIDTH: u32 = 96;

/// Shows the mean over the channels of |a - b| for each pixel in the colours of "magma", from black
/// (none) to pale yellow: a round number that at most 0.1 % of the pixels exceed.
///
/// # Errors
/// The pictures differ in size or in what their numbers mean.
pub fn heat_map(a: &Picture, b: &Picture) -> Result<HeatMap, MeasureError> {
    super::check_alike(a, b)?;
    let magnitudes: Vec<f64> = a
        .pixels
        .iter()
        .zip(&b.pixels)
        .map(|(pixel_a, pixel_b)| {
            pixel_a
                .iter()
                .zip(pixel_b)
                .map(|(x, y)| (f64::from(*x) - f64::from(*y)).abs())
                .sum::<f64>()
                / 3.0
        })
        .collect();
    let mut sorted: Vec<f64> = magnitudes
        .iter()
        .copied()
        .filter(|m| m.is_finite())
        .collect();
    sorted.sort_by(f64::total_cmp);
    let high =
        sorted.get(((sorted.len() as f64 * 0.999) as usize).min(sorted.len().saturating_sub(1)));
    let scale = round_up(high.copied().unwrap_or(0.0));

    let color = |share: f64| {
        colorous::MAGMA
            .eval_continuous(share.clamp(0.0, 1.0))
            .as_array()
    };
    let width = a.width.max(LEAST_WIDTH);
    let height = a.height + SCALE_ROWS;
    let mut pixels = vec![0; 3 * width as usize * height as usize];
    let mut put = |x: u32, y: u32, color: [u8; 3]| {
        let start = 3 * (y as usize * width as usize + x as usize);
        pixels[start..start + 3].copy_from_slice(&color);
    };
    for (index, magnitude) in magnitudes.iter().enumerate() {
        let (x, y) = (
            (index % a.width as usize) as u32,
            (index / a.width as usize) as u32,
        );
        put(
            x,
            y,
            if magnitude.is_finite() {
                color(magnitude / scale)
            } else {
                NOT_FINITE
            },
        );
    }
    for x in 0..width {
        for y in 0..BAR_ROWS {
            put(
                x,
                a.height + 2 + y,
                color(f64::from(x) / f64::from(width - 1)),
            );
        }
    }
    let text_row = a.height + 2 + BAR_ROWS + 3;
    let labels = [("0".to_owned(), 1), (format_number(scale), width)];
    for (label, edge) in labels {
        let text_width = 4 * label.len() as u32;
        let start = if edge == 1 { 1 } else { width - text_width };
        for (position, symbol) in label.chars().enumerate() {
            for (row, bits) in glyph(symbol).iter().enumerate() {
                for column in 0..3 {
                    if bits >> (2 - column) & 1 == 1 {
                        put(
                            start + 4 * position as u32 + column,
                            text_row + row as u32,
                            [255; 3],
                        );
                    }
                }
            }
        }
    }
    Ok(HeatMap {
        width,
        height,
        pixels,
        scale,
    })
}

/// The next of …, 0.1, 0.2, 0.5, 1, 2, 5, … (1e-6 for a difference of nothing).
fn round_up(value: f64) -> f64 {
    if value <= 1e-6 || !value.is_finite() {
        return 1e-6;
    }
    let power = value.log10().floor() as i32;
    for exponent in power..=power + 1 {
        for step in [1.0, 2.0, 5.0] {
            let candidate = step * 10f64.powi(exponent);
            if candidate >= value * (1.0 - 1e-12) {
                return candidate;
            }
        }
    }
    value
}

/// `0.05`, or `5e-5` where that is shorter to read.
fn format_number(value: f64) -> String {
    if (1e-3..1e4).contains(&value) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// Symbols of three by five dots, a row a number, the left dot in bit 2.
fn glyph(symbol: char) -> [u8; 5] {
    match symbol {
        '0' => [7, 5, 5, 5, 7],
        '1' => [2, 6, 2, 2, 7],
        '2' => [7, 1, 7, 4, 7],
        '3' => [7, 1, 7, 1, 7],
        '4' => [5, 5, 7, 1, 1],
        '5' => [7, 4, 7, 1, 7],
        '6' => [7, 4, 7, 5, 7],
        '7' => [7, 1, 1, 2, 2],
        '8' => [7, 5, 7, 5, 7],
        '9' => [7, 5, 7, 1, 7],
        '.' => [0, 0, 0, 0, 2],
        'e' => [0, 7, 7, 4, 7],
        '-' => [0, 0, 7, 0, 0],
        _ => [0; 5],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::Encoding;

    #[test]
    fn the_scale_is_a_round_number() {
        for (value, expected) in [
            (0.0, 1e-6),
            (0.03, 0.05),
            (0.05, 0.05),
            (0.051, 0.1),
            (1.0, 1.0),
            (1.2, 2.0),
            (700.0, 1000.0),
        ] {
            assert!(
                (round_up(value) / expected - 1.0).abs() < 1e-9,
                "{value}: {}",
                round_up(value)
            );
        }
    }

    #[test]
    fn colours_stand_for_magnitudes() {
        let black = Picture {
            width: 100,
            height: 1,
            pixels: vec![[0.0; 3]; 100],
            encoding: Encoding::Linear,
        };
        let mut other = black.clone();
        for (index, pixel) in other.pixels.iter_mut().enumerate() {
            *pixel = [index as f32 / 99.0; 3];
        }
        other.pixels[50] = [f32::NAN; 3];
        let map = heat_map(&other, &black).unwrap();
        assert_eq!(
            (map.width, map.height, map.scale),
            (100, 1 + SCALE_ROWS, 1.0)
        );
        // The ends of matplotlib's magma.
        let ends = [[0, 0, 4], [252, 253, 191]];
        assert_eq!(map.pixels[0..3], ends[0]);
        assert_eq!(map.pixels[3 * 99..3 * 100], ends[1]);
        assert_eq!(map.pixels[3 * 50..3 * 51], NOT_FINITE);
        // The bar below shows the same colours from one side to the other.
        let bar = 3 * 100 * 3;
        assert_eq!(map.pixels[bar..bar + 3], ends[0]);
        assert_eq!(map.pixels[bar + 297..bar + 300], ends[1]);
    }
}
