use super::*;
use crate::shading::tables::covering;

/// Mean reflectance of a layer at a place.
fn reflectance(tables: &Dielectrics, eta: f32, (cos, roughness): (f32, f32)) -> f32 {
    let place = LutCoordinate::new(cos, roughness);
    let (effective, _) = tables.layer(eta, cos, Some(place));
    fresnel::dielectric(effective, covering(eta)).reflectance
}

/// Where the index varies, tables between two indices say what a table of the index itself says.
#[test]
fn a_layer_between_two_tables_is_as_one_of_its_own() {
    let varying = Dielectrics::needed(&Needs {
        layer: Some((0.3, 3.5)),
        solid: None,
        rows: Rows::ALL,
    });
    let (mut worst, mut worst_blend) = (0.0f32, 0.0f32);
    for eta in [0.3, 0.45, 0.7, 0.93, 1.02, 1.1, 1.33, 1.52, 2.1, 3.3] {
        let own = Dielectrics::new(eta, 1.0, false);
        for k in 0..=20u8 {
            let cos = f32::from(k) / 20.0;
            for roughness in [0.1, 0.3, 0.5, 0.8, 1.0] {
                let [a, b] = [&varying, &own].map(|t| reflectance(t, eta, (cos, roughness)));
                worst = worst.max((a - b).abs());
            }
        }
        let [a, b] = [&varying, &own].map(|t| t.layer(eta, 1.0, None).1);
        worst_blend = worst_blend.max((a - b).abs());
    }
    assert!(worst < 5e-3 && worst_blend < 6e-3, "{worst} {worst_blend}");
}

/// A range of indices about 1 has that of its ends which is farther from 1, and none is 0.
#[test]
fn ranges_of_indices_cover_what_links_may_say() {
    assert_eq!(Needs::layer_indices((1.5, 1.5), (1.0, 1.0)), (1.5, 1.5));
    let (least, greatest) = Needs::layer_indices((0.0, 4.0), (1.0, 1.0));
    assert!(least > 0.0 && least < 1e-3 && greatest == 4.0);
    let (least, greatest) = Needs::layer_indices((1.5, 1.5), (0.0, 1.0));
    assert!(least == 1.0 && (greatest - 1.5).abs() < 1e-6);
}
