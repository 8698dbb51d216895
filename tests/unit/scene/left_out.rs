use super::*;

#[test]
fn the_same_reason_stands_once_with_a_count() {
    let mut list = Vec::new();
    for i in 0..6 {
        LeftOut::add(
            &mut list,
            Effect::AlphaClip,
            "opacity is 1 everywhere",
            &format!("m{i}"),
            10,
        );
    }
    assert_eq!(list.len(), 1);
    assert_eq!((list[0].count, list[0].bytes), (6, 60));
    assert_eq!(
        list[0].to_string(),
        "opacity is 1 everywhere: m0, m1, m2, m3 and 2 more"
    );
}
