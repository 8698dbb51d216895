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
fn what_the_program_has_is_found_in_the_scene_whatever_is_said_of_it() {
    let mut told = Diagnostics::default();
    let (sun, verdict) = ("a sun", Verdict::Exact);
    told.report_effect(Effect::Suns, "any", verdict, sun, "Sun", "rendered");
    let set = EffectReport::of(
        (&Scene::default(), &Coincident::default()),
        &RequestedSettings::default(),
        &[],
        &told,
    );
    assert_eq!(set.findings[Effect::Suns as usize].state, State::LeftOut);
    assert!(set.called_for.is_empty());
}
