use super::*;

#[test]
fn kinds_are_taken_out_one_by_one() {
    let seen = Visibility::ALL
        .without(RayKind::Camera)
        .without(RayKind::Shadow);
    assert!(!seen.sees(RayKind::Camera) && seen.sees(RayKind::Glossy));
    assert_eq!(seen.hidden_from(), ["camera", "shadow"]);
    assert_eq!(Visibility::ALL.bits().count_ones(), 6);
}
