use super::*;
use crate::scene::Verdict;

#[test]
fn an_empty_scene_calls_for_nothing() {
    let set = EffectReport::detect(&Scene::default());
    assert!(set.called_for.is_empty());
    assert_eq!(set.findings.len(), TABLE.len());
    assert!(set.findings.iter().all(|f| f.state == State::LeftOut));
    assert!(set.findings.iter().all(|f| f.reasons.len() == 1));
}
#[test]
fn what_the_importer_says_is_unsupported_with_its_names() {
    let mut told = Diagnostics::default();
    for i in 0..5 {
        let (code, material) = ("any", Subject::Material(format!("Paint {i}")));
        told.report_effect(
            Effect::Dispersion,
            code,
            Verdict::Lost,
            "words",
            material,
            "other words",
        );
    }
    // What the program has is found in the scene, whatever is said of it.
    told.report_effect(
        Effect::Suns,
        "any",
        Verdict::Exact,
        "a sun",
        "Sun",
        "rendered",
    );
    let set = EffectReport::of(&Scene::default(), &RequestedSettings::default(), &[], &told);
    let coat = &set.findings[Effect::Dispersion as usize];
    assert_eq!((coat.state, coat.count), (State::Unsupported, 5));
    let first = &coat.because_of[0];
    assert_eq!(
        (first.kind, first.name.as_str()),
        (Thing::Material, "Paint 0")
    );
    assert_eq!(set.findings[Effect::Suns as usize].state, State::LeftOut);
    assert!(set.called_for.is_empty());
}
