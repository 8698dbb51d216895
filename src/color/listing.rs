//! What a configuration has, for people and programs.

use super::{ColorConfig, ColorError, DisplaySummary, LookSummary};
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// What `sundog color list` tells.
#[derive(Serialize)]
pub struct Listing {
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

impl Listing {
    /// What there is.
    ///
    /// # Errors
    /// OpenColorIO fails.
    pub fn of(config: &ColorConfig) -> Result<Self, ColorError> {
        let (name, format) = config.name_and_profile()?;
        Ok(Self {
            config: config.origin().path().display().to_string(),
            found: config.origin().named_by(),
            name,
            format,
            opencolorio: super::library_version()?,
            default_display: config.default_display()?,
            displays: config.displays()?,
            looks: config.looks()?,
            roles: config
                .roles()?
                .into_iter()
                .map(|role| (role.name, role.colour_space))
                .collect(),
            color_spaces: config.colour_spaces()?,
        })
    }

    /// It in lines, of which `word` takes what would command a terminal.
    pub fn text(&self, word: impl Fn(&str) -> Cow<'_, str>) -> String {
        let listing = self;
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
}
