//! `sundog compare`: how far a picture is from a reference.

use super::Failure;
use super::args::{Compare, Seen};
use super::console::{self, warn};
use super::exit::EXIT_OK;
use super::report_file::{ReportFiles, check_page};
use super::view::{self, View};
use crate::measure::{self, Comparison, Difference, Encoding, MeasureError, RgbImage};
use crate::output::{self, Format, png};
use crate::render::memory;
use crate::scene::ColorManagement;
use serde::Serialize;

/// What comparing takes beyond the first picture, in bytes a pixel: 321 MiB more for 2048 × 2048 pixels than for 64 × 64, less
/// the 12 bytes of the first one.
const BYTES_A_PIXEL: u64 = 70;

/// Runs the command.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(args: &Compare) -> Result<u8, Failure> {
    let (path_a, path_b) = (args.a.as_path(), args.b.as_path());
    let map_path = args.difference_map.as_deref();
    if let Some(path) = map_path {
        if Format::of(path)? != Format::Png {
            return Err(Failure::usage(format!(
                "--difference-map {} must end in .png",
                path.display()
            )));
        }
        output::check_writable(path)?;
    }
    let (report_path, csv_path) = (args.report.as_deref(), args.csv.as_deref());
    check_page("report", report_path, "html")?;
    check_page("csv", csv_path, "csv")?;
    let layer = args.layer.as_deref();
    let a = measure::load(path_a, layer)?;
    memory::check(
        u64::from(a.width) * u64::from(a.height) * BYTES_A_PIXEL,
        &format!("comparing pictures of {} × {} pixels", a.width, a.height),
        "crop them, or allow more",
    )?;
    let b = measure::load(path_b, layer)?;
    let name_both = |error: MeasureError| {
        Failure::new(format!(
            "cannot compare {} with {}: {error}",
            path_a.display(),
            path_b.display()
        ))
    };
    let (wishes_a, wishes_b) = (
        view::wishes_of(path_a, &warn)?,
        view::wishes_of(path_b, &warn)?,
    );
    if wishes_a.working_space != wishes_b.working_space {
        warn(&format!(
            "{} holds light in {} and {} in {}: the same light has other numbers in them",
            path_a.display(),
            wishes_a.working_space,
            path_b.display(),
            wishes_b.working_space
        ));
    }
    let (shown_a, shown_b, seen) = seen(&args.seen, [(&a, &wishes_a), (&b, &wishes_b)])?;
    let difference = measure::difference_as_shown(&a, &b, &shown_a, &shown_b).map_err(name_both)?;
    let mut scale = None;
    if let Some(path) = map_path {
        let map = measure::difference_map(&a, &b).map_err(name_both)?;
        let brightest = map.brightest.unwrap_or_default();
        let text = vec![
            (
                "sundog/difference-of".to_owned(),
                path_a.display().to_string(),
            ),
            ("sundog/reference".to_owned(), path_b.display().to_string()),
            ("sundog/brightest".to_owned(), brightest.to_string()),
        ];
        let picture = map.picture_with_scale()?;
        let codes = png::Codes::Eight(&picture.rgb);
        png::write(path, picture.width, picture.height, codes, &text)?;
        scale = Some(brightest);
    }
    let mut files = ReportFiles::default();
    if let Some(path) = report_path {
        let page = Comparison {
            paths: [path_a, path_b],
            pictures: [&a, &b],
            shown: [&shown_a, &shown_b],
            seen: &seen,
            difference: &difference,
        }
        .page()?;
        files.put(path, page.html()?.as_bytes())?;
    }
    if let Some(path) = csv_path {
        files.put(path, difference.table().csv().as_bytes())?;
    }
    if args.json {
        console::json_document(&Answer {
            a: path_a.display().to_string(),
            b: path_b.display().to_string(),
            difference,
            seen,
            difference_map_scale: scale,
        });
    } else {
        console::output(&difference.text(&console::one_line(&seen)));
        if let (Some(path), Some(scale)) = (map_path, scale) {
            console::output(&format!(
                "difference map   {} (brightest: {scale})\n",
                console::one_line(&path.display().to_string())
            ));
        }
    }
    Ok(EXIT_OK)
}

/// What one sees of both pictures, and in words how: by the flags, else by the sRGB curve.
fn seen(
    flags: &Seen,
    pictures: [(&RgbImage, &ColorManagement); 2],
) -> Result<(RgbImage, RgbImage, String), Failure> {
    let [(a, wishes_a), (b, wishes_b)] = pictures;
    let flag = flags.first_given();
    if let Some(flag) = flag
        && a.encoding == Encoding::Display
    {
        return Err(Failure::usage(format!(
            "--{flag} is for linear light, and these pictures hold display values already; leave it out, or compare the EXR files"
        )));
    }
    Ok(match (flag, a.encoding) {
        (Some(_), _) => {
            let view = View::seen_by(flags, wishes_a, &warn)?;
            let other = View::seen_by(flags, wishes_b, &|_| ())?;
            (view.seen(a)?, other.seen(b)?, view.summary())
        }
        (None, Encoding::Linear) => {
            let rec709 = |picture: &RgbImage, wishes: &ColorManagement| {
                let mut picture = picture.clone();
                view::to_rec709(wishes.working_space, &mut picture.pixels);
                picture.shown()
            };
            let seen = "sRGB curve, clipped".to_owned();
            (rec709(a, wishes_a), rec709(b, wishes_b), seen)
        }
        (None, Encoding::Display) => (a.shown(), b.shown(), "as in the files".to_owned()),
    })
}

#[derive(Serialize)]
struct Answer {
    a: String,
    b: String,
    #[serde(flatten)]
    difference: Difference,
    seen: String,
    difference_map_scale: Option<f64>,
}
