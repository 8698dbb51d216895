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
    // One kernel has all of them, so that no set is without; a lesser one that is taken has what two, or all but two, call for.
    let all = units.iter().fold(EnumSet::empty(), |all, unit| all | *unit);
    for (first, second) in units
        .iter()
        .flat_map(|a| units.iter().map(move |b| (*a, *b)))
    {
        for set in [first | second, all - first - second, all] {
            assert!(kernel_for(set).0.is_superset(set));
        }
    }
    assert_eq!(kernel_for(BOX).0, BOX);
    assert_eq!(kernel_for(Effect::Suns.into()).0, MATTE);
    assert_eq!(kernel_for(Effect::Suns | Effect::Gloss).0, OPAQUE);
    assert_eq!(kernel_for(TRANSMISSION).0, PATHS);
}
