use super::*;
use crate::effects::{GROUPS, TRANSMISSION};

#[test]
fn every_set_has_a_kernel_and_the_smallest_is_taken() {
    let groups = GROUPS.iter().map(|(group, _)| *group & PATHS);
    let groups = groups.filter(|group| !group.is_empty());
    let single = PATHS
        - groups
            .clone()
            .fold(EnumSet::empty(), |all, group| all | group);
    let units: Vec<_> = groups.chain(single.iter().map(EnumSet::from)).collect();
    for subset in 0u32..1 << units.len() {
        let there = units.iter().enumerate();
        let there = there.filter(|(i, _)| subset >> i & 1 == 1);
        let set = there.fold(EnumSet::empty(), |set, (_, unit)| set | *unit);
        assert!(kernel_for(set).0.is_superset(set));
    }
    assert_eq!(kernel_for(BOX).0, BOX);
    assert_eq!(kernel_for(Effect::Suns.into()).0, MATTE);
    assert_eq!(kernel_for(Effect::Suns | Effect::Gloss).0, OPAQUE);
    assert_eq!(kernel_for(TRANSMISSION).0, PATHS);
}
