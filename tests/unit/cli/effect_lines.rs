use super::*;
use crate::effects::EffectReport;
use crate::scene::Scene;

#[test]
fn effects_with_the_same_reason_share_a_line() {
    let mut page = Page::default();
    effect_lines(&EffectReport::detect(&Scene::default()).findings, &mut page);
    let text = page.text();
    assert!(
        !text.contains("effect  ") && !text.contains("lacking"),
        "{text}"
    );
    let lines: Vec<_> = text.lines().collect();
    let coat = lines.iter().find(|line| line.contains("coat, sheen"));
    assert!(coat.unwrap().ends_with("weight 0 as there is no material"));
}
