//! `sundog color list` and `sundog color apply`.

use super::args::{self, ColorApply, ColorList};
use super::exit::EXIT_OK;
use super::scene_file::count;
use super::view::{View, wishes_of};
use super::{Failure, console};
use crate::color::{ColorConfig, Depth, DisplaySummary, LookSummary};
use crate::measure::{self, Encoding};
use crate::output::{self, Format};
use serde::Serialize;
use std::collections::BTreeMap;
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

fn warn(text: &str) {
    console::message(&format!("sundog: warning: {text}"));
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
    let pixels: Vec<[f32; 4]> = match alpha {
        Some(alpha) => picture
            .pixels
            .iter()
            .zip(alpha)
            .map(|(&[r, g, b], alpha)| [r, g, b, alpha])
            .collect(),
        None => picture
            .pixels
            .iter()
            .map(|&[r, g, b]| [r, g, b, 1.0])
            .collect(),
    };
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

/// What `sundog color list` tells.
#[derive(Serialize)]
struct Listing {
    config: String,
    found: &'static str,
    name: String,
    format: String,
    opencolorio: String,
    default_display: String,
    displays: Vec<DisplaySummary>,
    looks: Vec<LookSummary>,
    roles: BTreeMap<String, String>,
    color_spaces: Vec<String>,
}

fn list(args: &ColorList) -> Result<u8, Failure> {
    let config = ColorConfig::locate(args.ocio.as_deref().map(Path::new))?;
    for warning in config.warnings() {
        warn(warning);
    }
    let (name, format) = config.name_and_profile()?;
    let listing = Listing {
        config: config.origin().path().display().to_string(),
        found: config.origin().named_by(),
        name,
        format,
        opencolorio: crate::color::library_version()?,
        default_display: config.default_display()?,
        displays: config.displays()?,
        looks: config.looks()?,
        roles: config
            .roles()?
            .into_iter()
            .map(|role| (role.name, role.colour_space))
            .collect(),
        color_spaces: config.colour_spaces()?,
    };
    if args.json {
        console::json_document(&listing);
    } else {
        console::output(&text(&listing));
    }
    Ok(EXIT_OK)
}

fn text(listing: &Listing) -> String {
    let word = console::one_line;
    let mut text = format!(
        "configuration   {} ({})\n",
        word(&listing.config),
        listing.found
    );
    if !listing.name.is_empty() {
        text.push_str(&format!("name            {}\n", word(&listing.name)));
    }
    text.push_str(&format!("format          {}\n", word(&listing.format)));
    text.push_str(&format!("OpenColorIO     {}\n", listing.opencolorio));
    let mark = |is_default: bool| if is_default { " (default)" } else { "" };
    text.push_str("\nDisplays and their views\n");
    // Views with the same looks together: a look is written once, not at every view.
    let mut views_of: Vec<(&[String], Vec<&str>)> = Vec::new();
    for display in &listing.displays {
        text.push_str(&format!(
            "  {}{}\n",
            word(&display.name),
            mark(display.name == listing.default_display)
        ));
        for view in &display.views {
            text.push_str(&format!(
                "    {}{}\n",
                word(&view.name),
                mark(view.name == display.default_view)
            ));
            match views_of.iter_mut().find(|(looks, _)| *looks == view.looks) {
                Some((_, views)) if views.contains(&view.name.as_str()) => {}
                Some((_, views)) => views.push(&view.name),
                None => views_of.push((&view.looks, vec![&view.name])),
            }
        }
    }
    for (looks, views) in views_of {
        text.push_str(&format!("\nLooks for {}\n", word(&views.join(", "))));
        for look in looks {
            text.push_str(&format!("  {}\n", word(look)));
        }
        if looks.is_empty() {
            text.push_str("  none\n");
        }
    }
    text.push_str("\nColour spaces\n");
    for space in &listing.color_spaces {
        text.push_str(&format!("  {}\n", word(space)));
    }
    text
}
