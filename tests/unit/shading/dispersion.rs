use super::*;

/// The dispersion of an Abbe number.
fn of_abbe(abbe: f32) -> f32 {
    20.0 / abbe
}

#[test]
fn the_abbe_number_is_that_of_the_lines() {
    // Fraunhofer's F and C lines.
    let (f, c) = (486.13, 656.27);
    for (ior, abbe) in [(1.5168, 64.17), (1.7847, 25.76), (2.417, 55.3)] {
        let at = |wavelength| index_at(ior, of_abbe(abbe), wavelength);
        let found = (at(D_LINE) - 1.0) / (at(f) - at(c));
        // Both constants are rounded to five digits, which the small difference makes larger.
        assert!((found / abbe - 1.0).abs() < 1e-3, "{found} for {abbe}");
        assert!((at(D_LINE) - ior).abs() < 1e-4 * ior);
    }
}

#[test]
fn no_dispersion_changes_no_bit() {
    for ior in [1.0, 1.1, 1.5, 2.4] {
        for wavelength in [380.0, 550.0, 780.0] {
            assert_eq!(index_at(ior, 0.0, wavelength), ior);
        }
    }
    // An index of 0 stands for a mirror, and no index is below 1.
    assert_eq!(index_at(1.0, 5.0, 780.0), 1.0);
    assert!(index_at(1.05, 20.0, 780.0) >= 1.0);
}

#[test]
fn white_light_stays_white() {
    for space in WorkingSpace::ALL {
        let spectrum = Spectrum::of(space);
        // Evenly spread numbers: each step is met for its width to within one of them, with a weight of at most what all three
        // colours see of the spectrum, which is less than 6 as each sees less than 1 below nothing.
        let count = 1 << 22;
        let mut sum = DVec3::ZERO;
        for i in 0..count {
            let drawn = spectrum.sample((i as f32 + 0.5) / count as f32);
            assert!(drawn.weight.abs().max_element() < 6.0);
            assert!((380.0..=780.0).contains(&drawn.nanometres));
            sum += drawn.weight.as_dvec3();
        }
        let error = (sum / f64::from(count) - DVec3::ONE).abs().max_element();
        assert!(error < 6.0 * STEPS as f64 / f64::from(count), "{error}");
    }
}

#[test]
fn colours_come_in_the_order_of_the_rainbow() {
    let spectrum = Spectrum::of(WorkingSpace::Rec709);
    let count = 4096;
    let mut means = [[0.0f64; 2]; 3];
    for i in 0..count {
        let drawn = spectrum.sample((i as f32 + 0.5) / count as f32);
        // Red counts less than nothing about 500 nm, where no three primaries have the colour.
        let is_cyan = (drawn.nanometres - 500.0).abs() < 10.0;
        assert!(!is_cyan || drawn.weight.x < 0.0, "{drawn:?}");
        let weights = drawn.weight.max(Vec3::ZERO).to_array();
        for (mean, weight) in means.iter_mut().zip(weights) {
            mean[0] += f64::from(weight * drawn.nanometres);
            mean[1] += f64::from(weight);
        }
    }
    let [red, green, blue] = means.map(|[sum, weight]| sum / weight);
    assert!(red > 590.0 && red < 630.0, "{red}");
    assert!(green > 520.0 && green < 560.0, "{green}");
    assert!(blue > 440.0 && blue < 470.0, "{blue}");
}
