use super::*;
use std::str::FromStr;

#[test]
fn the_table_is_in_order_and_names_are_found() {
    for (i, row) in TABLE.iter().enumerate() {
        assert_eq!(row.0 as usize, i, "{}", row.1);
        assert!(Passes::parse([row.1].into_iter()).unwrap().has(row.0));
    }
    let some = Passes::parse(["Env", "Depth"].into_iter()).unwrap();
    let names: Vec<_> = some.iter().map(Pass::name).collect();
    assert_eq!(names, ["Combined", "Depth", "Env"]);
    assert_eq!(some.floats(), 4 + 1 + 3);
    assert!(some.need_light_passes() && !Passes::default().need_light_passes());
    // What is written if nobody says what costs no other kernel.
    assert!(!Passes::default().need_features() && Passes::ALL.need_features());
    // All the ranks of one kind of mattes by one name.
    let mattes = Passes::parse(["CryptoAsset"].into_iter()).unwrap();
    assert_eq!(mattes.floats(), 4 + 3 * 4);
    assert!(mattes.need_objects() && !mattes.need_light_passes() && !mattes.need_middle());
    assert!(!Passes::default().need_objects() && !some.need_objects());
    let error = Passes::parse(["Fog"].into_iter()).unwrap_err();
    assert!(
        error.contains("Fog") && error.contains("TransInd"),
        "{error}"
    );
}

#[test]
fn lists_of_passes() {
    assert_eq!(Passes::from_str("all"), Ok(Passes::ALL));
    let some = Passes::from_str("Depth, Debug Sample Count").unwrap();
    assert_eq!(some.floats(), 4 + 1 + 1);
    for wrong in ["", "Depth,", "depth", "Fog"] {
        assert!(
            Passes::from_str(wrong)
                .unwrap_err()
                .contains("there are: Combined")
        );
    }
}
