use super::*;

#[test]
fn numbers_in_a_file_are_those_of_memory() {
    let numbers: Vec<f32> = (0..5000).map(|i| (i as f32).sin()).collect();
    let here = Values::from(numbers.clone());
    let there = Values::in_file(&numbers).unwrap();
    assert!(there.are_in_file() && !here.are_in_file());
    assert_eq!(here, there);
    assert_eq!(&there[4990..], &numbers[4990..]);
    // A copy lies where they do.
    assert!(there.clone().are_in_file() && there.clone() == there);
    assert!(!here.clone().are_in_file());
    assert_eq!(there.clone().into_vec(), numbers);
    drop(here);
    let codes = Values::in_file(&[7u16, 9, 11]).unwrap();
    assert_eq!(*codes, [7, 9, 11]);
    assert!(Values::<u8>::in_file(&[]).unwrap().is_empty());
}

#[test]
fn numbers_are_changed_where_they_are() {
    for place in [Place::Memory, Place::File] {
        let mut values = Values::zeros(3, place);
        assert_eq!((&*values, values.place()), (&[0u8; 3][..], place));
        values.copy_from_slice(&[1, 2, 3]);
        let copy = values.clone();
        values[1] = 9;
        assert_eq!((&*values, values.place()), (&[1, 9, 3][..], place));
        assert_eq!(*copy, [1, 2, 3]);
    }
}
