//! Which looks go with which view.
//!
//! OpenColorIO lets every look go with every view. Blender (seen in its versions 4.5 and 5.0) reads the names: the look
//! `AgX - Punchy` is one of the views `AgX`, `AgX - SDR`, `AgX - HDR 1000 nits`; a view that has such looks takes only
//! those, and every other view only looks that belong to no view. The same holds here.

/// What stands before ` - ` in a name: the family of a view, or of a look that belongs to one.
fn family(name: &str) -> &str {
    name.split_once(" - ").map_or(name, |(family, _)| family)
}

/// The family of views that a look belongs to; `None` for a look that belongs to no view of the configuration.
fn family_of_look<'a>(look: &'a str, all_views: &[String]) -> Option<&'a str> {
    let (family_of_look, _) = look.split_once(" - ")?;
    all_views
        .iter()
        .any(|view| family(view) == family_of_look)
        .then_some(family_of_look)
}

/// The looks that go with a view, in the configuration's order.
pub(super) fn looks_for_view(
    view: &str,
    all_looks: &[String],
    all_views: &[String],
) -> Vec<String> {
    let of_the_view = |look: &&String| family_of_look(look, all_views) == Some(family(view));
    let own: Vec<String> = all_looks.iter().filter(of_the_view).cloned().collect();
    if !own.is_empty() {
        return own;
    }
    all_looks
        .iter()
        .filter(|look| family_of_look(look, all_views).is_none())
        .cloned()
        .collect()
}

/// What a person means by the name of a look.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Meant {
    /// This look.
    Look(String),
    /// A look that exists but doesn't go with the view.
    OfAnotherView,
    /// Nothing that exists.
    Nothing,
}

/// Finds a look by its full name, or by its name without the view's family before it (as Blender's menu shows it),
/// where no look has just that as its full name: with AgX, `Punchy` is `AgX - Punchy`; but `High Contrast` is a look of its
/// own that doesn't go with AgX, and `AgX - High Contrast` is to be written in full.
pub(super) fn find_look(name: &str, allowed: &[String], all_looks: &[String]) -> Meant {
    if allowed.iter().any(|look| look == name) {
        return Meant::Look(name.to_owned());
    }
    if all_looks.iter().any(|look| look == name) {
        return Meant::OfAnotherView;
    }
    let mut short = allowed.iter().filter(|look| {
        look.split_once(" - ")
            .is_some_and(|(_, short)| short == name)
    });
    match (short.next(), short.next()) {
        (Some(look), None) => Meant::Look(look.clone()),
        _ => Meant::Nothing,
    }
}

#[cfg(test)]
#[path = "../../tests/unit/color/looks.rs"]
mod tests;
