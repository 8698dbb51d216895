use super::*;
use IntegerMath as M;

#[test]
fn whole_numbers_are_divided_as_their_names_say() {
    // By what is below 0, too: (a, b), and what each way gives.
    for (a, b, [cut, nearest, floor, ceil, rest, floored_rest]) in [
        (7, 2, [3, 4, 3, 4, 1, 1]),
        (-7, 2, [-3, -4, -4, -3, -1, 1]),
        (7, -2, [-3, -4, -4, -3, 1, -1]),
        (-7, -2, [3, 4, 3, 4, -1, -1]),
        (6, 3, [2, 2, 2, 2, 0, 0]),
        (5, 3, [1, 2, 1, 2, 2, 2]),
        (4, 3, [1, 1, 1, 2, 1, 1]),
        (5, 0, [0; 6]),
    ] {
        let found = [
            M::Divide,
            M::DivideRound,
            M::DivideFloor,
            M::DivideCeil,
            M::Modulo,
            M::FlooredModulo,
        ];
        assert_eq!(
            found.map(|way| way.of(a, b, 0)),
            [cut, nearest, floor, ceil, rest, floored_rest],
            "{a} / {b}"
        );
    }
}

#[test]
fn powers_and_divisors_are_whole() {
    for (a, b, expected) in [
        (2, 10, 1024),
        (-3, 3, -27),
        (5, 0, 1),
        (0, 0, 1),
        (2, -1, 0),
        (-1, -3, -1),
        (-1, -2, 1),
        (1, -9, 1),
    ] {
        assert_eq!(M::Power.of(a, b, 0), expected, "{a} ^ {b}");
    }
    // What leaves 32 bits is lost, as C's unsigned numbers lose it.
    assert_eq!(M::Power.of(3, 21, 0), 1_870_418_611);
    assert_eq!(M::GreatestCommonDivisor.of(-12, 18, 0), 6);
    assert_eq!(M::GreatestCommonDivisor.of(0, 0, 0), 0);
    assert_eq!(M::LeastCommonMultiple.of(-4, 6, 0), 12);
    assert_eq!(M::LeastCommonMultiple.of(0, 6, 0), 0);
    assert_eq!(M::MultiplyAdd.of(3, 4, 5), 17);
}

#[test]
fn no_numbers_overflow() {
    let ends = [i32::MIN, -1, 0, 1, i32::MAX];
    for operation in M::ALL {
        for a in ends {
            for b in ends {
                let _ = operation.of(a, b, i32::MAX);
            }
        }
    }
    assert_eq!(
        [f32::NAN, f32::INFINITY, -0.9, 0.9, 1.9].map(whole),
        [0, i32::MAX, 0, 0, 1]
    );
}

#[test]
fn truths_are_joined_as_their_names_say() {
    let of = |operation: BooleanMath| {
        [(false, false), (false, true), (true, false), (true, true)]
            .map(|(a, b)| operation.of(a, b))
    };
    let expected = [
        [false, false, false, true],
        [false, true, true, true],
        [true, true, false, false],
        [true, true, true, false],
        [true, false, false, false],
        [true, false, false, true],
        [false, true, true, false],
        [true, true, false, true],
        [false, false, true, false],
    ];
    assert_eq!(
        BooleanMath::ALL.iter().map(|o| of(*o)).collect::<Vec<_>>(),
        expected
    );
}
