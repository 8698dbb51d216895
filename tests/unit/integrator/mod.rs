use super::*;
use crate::effects::{GROUPS, TRANSMISSION};

/// What kernels are made for: groups of effects, and effects that are in none.
fn units() -> Vec<EnumSet<Effect>> {
    let groups = GROUPS.iter().map(|(group, _)| *group & PATHS);
    let groups = groups.filter(|group| !group.is_empty());
    let grouped = groups
        .clone()
        .fold(EnumSet::empty(), |all, group| all | group);
    let single = PATHS - grouped;
    groups.chain(single.iter().map(EnumSet::from)).collect()
}

/// `long` asks for every set.
#[test]
fn sets_have_a_kernel_and_the_smallest_is_taken() {
    let units = units();
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

mod long {
    use super::*;

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn every_set_has_a_kernel() {
        let units = units();
        for subset in 0u32..1 << units.len() {
            let there = units.iter().enumerate();
            let there = there.filter(|(i, _)| subset >> i & 1 == 1);
            let set = there.fold(EnumSet::empty(), |set, (_, unit)| set | *unit);
            assert!(kernel_for(set).0.is_superset(set));
        }
    }
}
