use super::*;

#[test]
fn the_same_feature_is_told_once_with_a_count() {
    let mut list = Diagnostics::default();
    for i in 0..10 {
        list.report(
            "x",
            Verdict::Lost,
            "KHR_y",
            format!("material {i}"),
            "left out",
        );
    }
    let messages: Vec<_> = list.iter().collect();
    assert_eq!(messages.len(), 1);
    assert_eq!(messages[0].count, 10);
    assert_eq!(
        messages[0].to_string(),
        "KHR_y (material 0, material 1, material 2, material 3 and 6 more): left out"
    );
}

#[test]
fn an_effect_and_the_names_of_its_materials_come_through_when_lists_are_joined() {
    let mut list = Diagnostics::default();
    for name in ["Paint", "a \"b\""] {
        let mut one = Diagnostics::default();
        let material = Subject::Material(name.into());
        one.report_effect(
            Effect::Coat,
            "x",
            Verdict::Lost,
            "the coat",
            material,
            "none",
        );
        list.append(one);
    }
    let message = list.iter().next().unwrap();
    assert_eq!((message.effect, message.count), (Some(Effect::Coat), 2));
    assert_eq!(message.objects[1].name(), "a \"b\"");
    let json = serde_json::to_value(&list).unwrap();
    assert_eq!(json[0]["effect"], "coat");
    assert_eq!(json[0]["objects"][0], "material \"Paint\"");
}

#[test]
fn behind_the_word_left_out_it_is_not_said_again() {
    let told = |verdict, instead: &str| {
        let mut list = Diagnostics::default();
        list.report("x", verdict, "curves", "a", instead);
        list.iter().next().unwrap().introduced()
    };
    assert_eq!(told(Verdict::Lost, "left out"), "curves (a)");
    assert_eq!(told(Verdict::Lost, "not supported; left out"), "curves (a)");
    assert_eq!(
        told(Verdict::Lost, "left out: too few"),
        "curves (a): too few"
    );
    assert_eq!(told(Verdict::Lost, "made grey"), "curves (a): made grey");
    assert_eq!(
        told(Verdict::Approximated, "left out"),
        "curves (a): left out"
    );
}
