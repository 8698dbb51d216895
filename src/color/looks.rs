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
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn blender() -> (Vec<String>, Vec<String>) {
        let looks = names(&[
            "High Contrast",
            "Low Contrast",
            "AgX - Punchy",
            "AgX - High Contrast",
            "False Color - Punchy",
            "Odd - One",
        ]);
        (
            looks,
            names(&["Standard", "AgX", "AgX - SDR", "False Color", "Raw"]),
        )
    }

    #[test]
    fn a_view_with_looks_of_its_own_takes_only_those() {
        let (looks, views) = blender();
        assert_eq!(
            looks_for_view("AgX", &looks, &views),
            names(&["AgX - Punchy", "AgX - High Contrast"])
        );
        assert_eq!(
            looks_for_view("AgX - SDR", &looks, &views),
            names(&["AgX - Punchy", "AgX - High Contrast"])
        );
        assert_eq!(
            looks_for_view("False Color", &looks, &views),
            names(&["False Color - Punchy"])
        );
    }

    #[test]
    fn other_views_take_the_looks_that_belong_to_none() {
        let (looks, views) = blender();
        // "Odd" is no view: its look belongs to nobody, and so to all.
        assert_eq!(
            looks_for_view("Standard", &looks, &views),
            names(&["High Contrast", "Low Contrast", "Odd - One"])
        );
    }

    #[test]
    fn short_names_are_taken_where_they_can_mean_only_one_look() {
        let (looks, views) = blender();
        let agx = looks_for_view("AgX", &looks, &views);
        let standard = looks_for_view("Standard", &looks, &views);
        assert_eq!(
            find_look("Punchy", &agx, &looks),
            Meant::Look("AgX - Punchy".to_owned())
        );
        assert_eq!(
            find_look("AgX - Punchy", &agx, &looks),
            Meant::Look("AgX - Punchy".to_owned())
        );
        assert_eq!(
            find_look("High Contrast", &agx, &looks),
            Meant::OfAnotherView
        );
        assert_eq!(
            find_look("High Contrast", &standard, &looks),
            Meant::Look("High Contrast".to_owned())
        );
        assert_eq!(
            find_look("AgX - Punchy", &standard, &looks),
            Meant::OfAnotherView
        );
        assert_eq!(find_look("Punchy", &standard, &looks), Meant::Nothing);
        assert_eq!(find_look("punchy", &agx, &looks), Meant::Nothing);
        let twins = names(&["AgX - A - B", "X - A - B"]);
        assert_eq!(find_look("A - B", &twins, &twins), Meant::Nothing);
    }
}
