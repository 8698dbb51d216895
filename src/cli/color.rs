//! `sundog color list` and `sundog color apply`.

use super::Failure;
use super::args::{self, ColorApply, ColorList};
use super::console::{self, warn};
use super::exit::EXIT_OK;
use super::scene_file::count;
use super::view::{View, wishes_of};
use crate::color::{ColorConfig, Depth, Listing};
use crate::measure::{self, Encoding};
use crate::output::{self, Format};
use std::path::Path;

/// Runs the command that was given after `sundog color`.
///
/// # Errors
/// One sentence: what could not be done, and the way out.
pub fn run(command: &args::Color) -> Result<u8, Failure> {
    match command {
        args::Color::List(args) => list(args),
        args::Color::Apply(args) => apply(args),
    }
}

fn apply(args: &ColorApply) -> Result<u8, Failure> {
    let (input, result) = (&args.input, &args.result);
    let format = Format::of(result)?;
    if format == Format::Exr {
        return Err(Failure::usage(format!(
            "{} would hold light and not display values: give a name that ends in .png or .jpg",
            result.display()
        )));
    }
    if format == Format::Jpeg && args.view.depth == Some(Depth::Sixteen) {
        return Err(Failure::usage(format!(
            "{} cannot have 16 bits a channel, JPEG has 8: use .png, or leave --depth out",
            result.display()
        )));
    }
    output::check_writable(result)?;
    let view = View::new(&args.view, &wishes_of(input, &warn)?, &warn)?;
    let (picture, alpha) = measure::load_with_alpha(input, args.layer.as_deref())?;
    if picture.encoding != Encoding::Linear {
        return Err(Failure::new(format!(
            "{} has display values already: give an .exr or .hdr file, which has light",
            input.display()
        )));
    }
    let alpha = alpha.unwrap_or_else(|| vec![1.0; picture.pixels.len()]);
    let colors = picture.pixels.iter().zip(alpha);
    let pixels: Vec<[f32; 4]> = colors.map(|(&[r, g, b], a)| [r, g, b, a]).collect();
    let odd = pixels
        .iter()
        .filter(|pixel| pixel.iter().any(|value| !value.is_finite()))
        .count();
    if odd > 0 {
        warn(&format!(
            "in {} the values of {} are infinite or no numbers; what that shows has no meaning",
            input.display(),
            count(odd as u64, "pixel")
        ));
    }
    let metadata = vec![("sundog/from".to_owned(), input.display().to_string())];
    view.write(
        result,
        format,
        picture.width,
        picture.height,
        &pixels,
        &metadata,
    )?;
    Ok(EXIT_OK)
}

fn list(args: &ColorList) -> Result<u8, Failure> {
    let config = ColorConfig::locate(args.ocio.as_deref().map(Path::new))?;
    for warning in config.warnings() {
        warn(warning);
    }
    let listing = Listing::of(&config)?;
    if args.json {
        console::json_document(&listing);
    } else {
        console::output(&listing.text(console::one_line));
    }
    Ok(EXIT_OK)
}
