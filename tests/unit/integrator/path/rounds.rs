use super::*;

fn surface(primitive: u32) -> Hit {
    Hit {
        primitive,
        ..Hit::default()
    }
}

/// How many surfaces of a circle a ray passes before that is noticed.
fn noticed(length: u32, first: u32) -> u32 {
    let mut rounds = Rounds::default();
    for number in 0..first {
        assert!(!rounds.comes_back(&surface(1000 + number), 0));
        assert!(!rounds.passes(&surface(1000 + number), 0));
    }
    for passed in 0.. {
        let hit = surface(passed % length);
        if rounds.comes_back(&hit, 0) {
            assert!(rounds.passes(&hit, 0) && !rounds.comes_back(&hit, 0));
            // The next bounce begins anew.
            assert!(!rounds.passes(&hit, 1));
            return passed;
        }
        assert!(!rounds.passes(&hit, 0));
    }
    unreachable!()
}

#[test]
fn circles_of_any_length_are_noticed() {
    for length in [1, 2, 3, 8, 100] {
        for first in [0, 1, 17, 1000] {
            let passed = noticed(length, first);
            assert!(
                passed <= 2 * first + 16 * length + 64,
                "{length} {first}: {passed}"
            );
        }
    }
}

#[test]
fn what_is_met_twice_and_what_is_met_after_another_bounce_is_no_circle() {
    let mut rounds = Rounds::default();
    for number in 0..10_000 {
        // In and out of each sphere of a row.
        for _ in 0..2 {
            let hit = surface(number);
            assert!(!rounds.comes_back(&hit, 0) && !rounds.passes(&hit, 0));
        }
        // The same one after each bounce.
        let hit = surface(7);
        assert!(!rounds.comes_back(&hit, number + 1) && !rounds.passes(&hit, number + 1));
    }
}
