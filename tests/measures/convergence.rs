//! Fits, times to equal error, and references whose noise is taken out, by hand.

use sundog::measure::convergence::{PowerLaw, Reference, time_ratio, time_to};
use sundog::measure::{Encoding, MeasureError, RgbImage};

fn picture(pixels: Vec<[f32; 3]>) -> RgbImage {
    RgbImage {
        width: pixels.len() as u32,
        height: 1,
        pixels,
        encoding: Encoding::Linear,
    }
}

#[test]
fn a_power_law_is_found_again() {
    let times = [0.5, 1.0, 2.0, 4.0, 8.0];
    let law = PowerLaw::fit(times.map(|t| (t, 3.0 * f64::powf(t, -0.5)))).unwrap();
    assert!((law.slope + 0.5).abs() < 1e-12 && (law.factor - 3.0).abs() < 1e-12);
    assert!(law.slope_error.unwrap() < 1e-12);
    assert!((law.at(4.0) - 1.5).abs() < 1e-12);
    // ln y = 0, 1, 0 at ln x = 0, 1, 2: slope 0, residuals -1/3, 2/3, -1/3, so s² = 6/9 and the error is √(s²/2).
    let bent = PowerLaw::fit(
        [0.0f64, 1.0, 2.0].map(|x| (x.exp(), if x == 1.0 { 1.0f64.exp() } else { 1.0 })),
    )
    .unwrap();
    assert!(bent.slope.abs() < 1e-12);
    assert!((bent.slope_error.unwrap() - (6.0f64 / 9.0 / 2.0).sqrt()).abs() < 1e-12);
    assert_eq!(PowerLaw::fit([(1.0, 2.0)]), None);
    assert_eq!(PowerLaw::fit([(1.0, 2.0), (1.0, 3.0)]), None);
    assert_eq!(PowerLaw::fit([(1.0, 2.0), (2.0, -1.0), (0.0, 1.0)]), None);
    let two = PowerLaw::fit([(1.0, 2.0), (4.0, 1.0)]).unwrap();
    assert!((two.slope + 0.5).abs() < 1e-12 && two.slope_error.is_none());
}

#[test]
fn times_to_equal_error() {
    let curve: Vec<_> = [1.0, 2.0, 4.0, 8.0].map(|t: f64| (t, t.powf(-0.5))).into();
    assert!((time_to(&curve, 0.6).unwrap() - 1.0 / 0.36).abs() < 1e-12);
    assert_eq!(time_to(&curve, 1.0), Some(1.0));
    assert_eq!(time_to(&curve, 1.1), None);
    assert_eq!(time_to(&curve, 0.1), None);
    assert_eq!(time_to(&[], 0.1), None);
    // Three times the time at each number of samples, and twice the noise: 3 · 2² times the time to equal error.
    let slow: Vec<_> = [1.0, 4.0, 16.0, 64.0]
        .map(|t: f64| (3.0 * t, 2.0 * t.powf(-0.5)))
        .into();
    let ratio = time_ratio(&curve, &slow).unwrap();
    for value in [ratio.ratio, ratio.least, ratio.greatest] {
        assert!((value - 12.0).abs() < 1e-9, "{ratio:?}");
    }
    assert_eq!(ratio.highest_error, 1.0);
    assert_eq!(time_ratio(&curve, &[(1.0, 100.0), (2.0, 50.0)]), None);
}

#[test]
fn the_noise_of_the_reference_is_taken_out() {
    // Truth 1; halves off by ±0.5 in all four combinations with a picture that is off by ±0.25: the noise of all three is
    // uncorrelated, so that exactly 0.25² is left.
    let signs = |bit: usize| (0..8).map(move |i| if i >> bit & 1 == 1 { 1.0 } else { -1.0 });
    let off = |bit: usize, by: f32| picture(signs(bit).map(|s: f32| [1.0 + by * s; 3]).collect());
    let (x, a, b) = (off(0, 0.25), off(1, 0.5), off(2, 0.5));
    let shown = |p: &RgbImage| Ok::<_, MeasureError>(p.shown());
    let reference = Reference::halves([a.clone(), b], shown).unwrap();
    let errors = reference.errors(&x, &x.shown()).unwrap();
    assert!((errors.mse - 0.0625).abs() < 1e-7, "{errors:?}");
    // The mean of the halves has the variance 0.5² / 2; relative to 1, 1.5² and 0.5² with the offset.
    let own: f64 = [(0.25, 1.0f64), (0.0, 1.5), (0.0, 0.5), (0.25, 1.0)]
        .iter()
        .map(|(square, r)| square / (r * r + 0.01))
        .sum::<f64>()
        / 4.0;
    assert!((reference.own_rel_mse().unwrap() - own).abs() < 1e-9);
    let single = Reference::single(a.clone(), a.shown());
    assert_eq!(single.own_rel_mse(), None);
    let errors = single.errors(&x, &x.shown()).unwrap();
    assert!((errors.mse - (0.0625 + 0.25)).abs() < 1e-7);
    // Against itself, with the halves in the other order, the noise is there in full: E[(b - a)(a - b)] = -2 · 0.5².
    let (c, d) = (off(1, 0.5), off(2, 0.5));
    let turned = Reference::halves([d, c], shown).unwrap();
    let between = reference.between(&turned).unwrap();
    assert!(
        between.without_noise && between.rel_mse < 0.0,
        "{between:?}"
    );
    // Equal references lie nowhere apart, for certain.
    let none = single.between(&single).unwrap();
    assert_eq!(
        (none.rel_mse, none.standard_error, none.without_noise),
        (0.0, 0.0, false)
    );
    let wide = picture(vec![[1.0; 3]; 3]);
    assert!(Reference::halves([a, wide], shown).is_err());
}
