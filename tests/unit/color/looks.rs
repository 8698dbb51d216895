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
