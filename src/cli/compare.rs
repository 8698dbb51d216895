//! `sundog compare`: how far a picture is from a reference.

use super::flags::EXIT_OK;
use super::parser::Parsed;
use super::{Failure, console};
use crate::measure::{self, Difference, MeasureError};
use crate::output::{self, Format, png};
use serde::Serialize;

impl From<MeasureError> for Failure {
    fn from(error: MeasureError) -> Self {
        Failure::new(error.to_string())
    }
}

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(parsed: Parsed) -> Result<u8, Failure> {
    let (Some(path_a), Some(path_b)) = (parsed.path("A"), parsed.path("B")) else {
        return Err(Failure::usage("two pictures are needed"));
    };
    let map_path = parsed.path("difference-map");
    if let Some(path) = map_path {
        if Format::of(path)? != Format::Png {
            return Err(Failure::usage(format!(
                "--difference-map {} must end in .png",
                path.display()
            )));
        }
        output::check_writable(path)?;
    }
    let layer = parsed.text("layer");
    let a = measure::load(path_a, layer)?;
    let b = measure::load(path_b, layer)?;
    let name_both = |error: MeasureError| {
        Failure::new(format!(
            "cannot compare {} with {}: {error}",
            path_a.display(),
            path_b.display()
        ))
    };
    let difference = measure::difference(&a, &b).map_err(name_both)?;
    let mut scale = None;
    if let Some(path) = map_path {
        let map = measure::heat_map(&a, &b).map_err(name_both)?;
        let text = vec![
            (
                "sundog/difference-of".to_owned(),
                path_a.display().to_string(),
            ),
            ("sundog/reference".to_owned(), path_b.display().to_string()),
            ("sundog/brightest".to_owned(), map.scale.to_string()),
        ];
        png::write(
            path,
            map.width,
            map.height,
            png::Codes::Eight(&map.pixels),
            &text,
        )?;
        scale = Some(map.scale);
    }
    if parsed.switch("json") {
        console::json_document(&Answer {
            a: path_a.display().to_string(),
            b: path_b.display().to_string(),
            difference,
            difference_map_scale: scale,
        });
    } else {
        console::output(&table(&difference));
        if let (Some(path), Some(scale)) = (map_path, scale) {
            console::output(&format!(
                "difference map   {} (brightest: {scale})\n",
                path.display()
            ));
        }
    }
    Ok(EXIT_OK)
}

#[derive(Serialize)]
struct Answer {
    a: String,
    b: String,
    #[serde(flatten)]
    difference: Difference,
    difference_map_scale: Option<f64>,
}

fn table(d: &Difference) -> String {
    let ratio = match d.luminance_ratio {
        Some(ratio) => format!(
            "{ratio:.6} ({:.6} / {:.6})",
            d.mean_luminance_a, d.mean_luminance_b
        ),
        None => format!("none, the reference is black ({:.6})", d.mean_luminance_a),
    };
    let mut text = format!(
        "RMSE             {:.6e}\nrelMSE           {:.6e}\nmean luminance   {ratio}\nFLIP             {:.6}\nlargest          {:.6e} at {}, {}\n",
        d.rmse, d.rel_mse, d.flip, d.largest, d.largest_at.0, d.largest_at.1
    );
    if d.non_finite_a + d.non_finite_b > 0 {
        text.push_str(&format!(
            "not finite       {} and {} pixels, left out of {}\n",
            console::grouped(d.non_finite_a),
            console::grouped(d.non_finite_b),
            console::grouped(u64::from(d.width) * u64::from(d.height))
        ));
    }
    text
}
