//! What can go wrong between light and display, one sentence each.

use crate::color::ConfigOrigin;

/// Why pixels could not be brought to a display.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ColorError {
    /// The library cannot be used at all.
    #[error("OpenColorIO cannot be used: {reason}")]
    Library {
        /// What doesn't fit.
        reason: String,
    },
    /// A named configuration is not there.
    #[error(
        "the colour configuration {origin} cannot be read: {reason}; give a .ocio or .ocioz file or a name such as ocio://default"
    )]
    Missing {
        /// Which one, and who named it.
        origin: ConfigOrigin,
        /// What the system says.
        reason: String,
    },
    /// A configuration is there, but OpenColorIO cannot make sense of it.
    #[error("the colour configuration {origin} is broken or needs another OpenColorIO: {reason}")]
    Broken {
        /// Which one, and who named it.
        origin: ConfigOrigin,
        /// What OpenColorIO says, on one line.
        reason: String,
    },
    /// A table of a configuration is nothing that can be read to its end.
    #[error(
        "the colour configuration {origin} refers to {table}, which cannot be its table of colours: {reason}"
    )]
    Table {
        /// Which one, and who named it.
        origin: ConfigOrigin,
        /// The table.
        table: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A configuration without displays.
    #[error(
        "the colour configuration {origin} has no display to show a picture on; choose another one with --ocio"
    )]
    NoDisplay {
        /// Which one, and who named it.
        origin: ConfigOrigin,
    },
    /// A display that isn't in the configuration.
    #[error("there is no display '{name}' in the colour configuration {origin}; there are: {}", list(.there))]
    UnknownDisplay {
        /// What was asked for.
        name: String,
        /// Which configuration.
        origin: ConfigOrigin,
        /// The displays that there are.
        there: Vec<String>,
    },
    /// A view that the display doesn't have.
    #[error("the display '{display}' has no view '{name}' in the colour configuration {origin}; there are: {}", list(.there))]
    UnknownView {
        /// What was asked for.
        name: String,
        /// On which display.
        display: String,
        /// Which configuration.
        origin: ConfigOrigin,
        /// The views that the display has.
        there: Vec<String>,
    },
    /// A look that isn't there, or doesn't go with the view.
    #[error("{}; there are: {}", unfit_look(.name, .view, *.elsewhere, .origin), list(.there))]
    UnknownLook {
        /// What was asked for.
        name: String,
        /// With which view.
        view: String,
        /// There is a look of this name, but it doesn't go with the view.
        elsewhere: bool,
        /// Which configuration.
        origin: ConfigOrigin,
        /// The looks that go with the view.
        there: Vec<String>,
    },
    /// Exposure or gamma out of range.
    #[error("{what} cannot be {value}: it has to be {range}")]
    OutOfRange {
        /// `exposure` or `gamma`.
        what: &'static str,
        /// What was asked for.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// It cannot be known what the configuration would make of Sundog's colours.
    #[error(
        "the colour configuration {origin} does not say how its scene_linear space stands to Rec.709, in which Sundog computes: {reason}; add the role aces_interchange to it, or choose another one with --ocio"
    )]
    NoRec709 {
        /// Which one, and who named it.
        origin: ConfigOrigin,
        /// What OpenColorIO says, on one line.
        reason: String,
    },
    /// The way to the display cannot be made, for example because a table file is missing.
    #[error(
        "the view '{view}' of the display '{display}' cannot be made with the colour configuration {origin}: {reason}"
    )]
    Unmakeable {
        /// Display.
        display: String,
        /// View.
        view: String,
        /// Which configuration.
        origin: ConfigOrigin,
        /// What OpenColorIO says, on one line.
        reason: String,
    },
    /// There is no way from a colour space to the working space.
    #[error(
        "the colour configuration {origin} has no way from '{space}' to its linear space: {reason}"
    )]
    NoInput {
        /// The colour space.
        space: String,
        /// Which configuration.
        origin: ConfigOrigin,
        /// What OpenColorIO says, on one line.
        reason: String,
    },
    /// OpenColorIO failed while it worked on pixels.
    #[error("OpenColorIO failed on the picture: {reason}")]
    Apply {
        /// What it says.
        reason: String,
    },
}

fn list(names: &[String]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

fn unfit_look(name: &str, view: &str, elsewhere: bool, origin: &ConfigOrigin) -> String {
    if elsewhere {
        format!(
            "the look '{name}' of the colour configuration {origin} does not go with the view '{view}'"
        )
    } else {
        format!(
            "there is no look '{name}' for the view '{view}' in the colour configuration {origin}"
        )
    }
}
