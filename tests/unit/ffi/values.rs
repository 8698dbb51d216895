use super::*;

#[test]
fn numbers_in_a_file_are_those_of_memory() {
    let numbers: Vec<f32> = (0..5000).map(|i| (i as f32).sin()).collect();
    let here = Values::from(numbers.clone());
    let there = Values::in_file(&numbers).unwrap();
    assert!(there.are_in_file() && !here.are_in_file());
    assert_eq!(here, there);
    assert_eq!(&there[4990..], &numbers[4990..]);
    // A copy is one of memory.
    assert!(!there.clone().are_in_file());
    drop(here);
    let codes = Values::in_file(&[7u16, 9, 11]).unwrap();
    assert_eq!(*codes, [7, 9, 11]);
    assert!(Values::<u8>::in_file(&[]).unwrap().is_empty());
}

#[test]
fn numbers_of_a_file_are_changed_in_memory() {
    let mut values = Values::in_file(&[1u8, 2, 3]).unwrap();
    values[1] = 9;
    assert!(!values.are_in_file());
    assert_eq!(*values, [1, 9, 3]);
    let mut plain = Values::from(vec![1u8, 2, 3]);
    plain[2] = 5;
    assert_eq!(*plain, [1, 2, 5]);
}
