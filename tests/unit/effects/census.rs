use super::*;
use crate::effects::TABLE;

#[test]
fn there_is_a_reason_for_each() {
    let census = Census {
        materials: 14,
        objects: 1,
        ..Census::default()
    };
    assert_eq!(census.reason(Effect::Coat), "weight 0 in all 14 materials");
    assert_eq!(census.reason(Effect::Holdouts), "none of the only object");
    for row in &TABLE {
        assert_ne!(
            census.reason(row.effect),
            "not called for",
            "{}",
            row.effect
        );
    }
}
