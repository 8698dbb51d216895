use super::*;

#[test]
fn what_lies_between_tables_is_near_to_its_own() {
    let all = Solids::new(Indices::Between(0.0, 4.0), Rows::ALL, Estimate::Exact);
    for ior in [0.4f32, 0.62, 0.93, 1.07, 1.33, 1.5, 2.2, 3.1] {
        let own = Solids::new(Indices::One(ior), Rows::ALL, Estimate::Exact);
        for inside in [false, true] {
            for (cos, roughness) in [(0.9, 0.5), (0.5, 1.0), (0.3, 0.7), (0.7, 0.9)] {
                let place = LutCoordinate::new(cos, roughness);
                let [found, exact] =
                    [&all, &own].map(|s| s.compensation(place, (ior, inside), Vec3::ONE).x);
                assert!(
                    (found / exact - 1.0).abs() < 0.012,
                    "{ior} {inside} {cos} {roughness}: {found} {exact}"
                );
            }
        }
    }
}

#[test]
fn an_index_that_is_the_same_everywhere_has_one_table() {
    let one = Solids::new(Indices::One(0.7), Rows::ALL, Estimate::Exact);
    assert_eq!(one.tables.len(), 1);
    let place = LutCoordinate::new(0.6, 0.8);
    let alone = Solid::new(0.7, Rows::ALL, Estimate::Exact);
    for inside in [false, true] {
        assert_eq!(
            one.compensation(place, (0.7, inside), Vec3::ONE),
            alone.compensation(place, inside, Vec3::ONE)
        );
    }
}
