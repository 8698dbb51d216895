use super::*;

fn point(seed: u64, samples: u32, rel_mse: f64) -> Measured {
    Measured {
        seed,
        samples,
        seconds: 0.5 * f64::from(samples),
        errors: Errors {
            mse: 4.0 * rel_mse,
            rel_mse,
            mape: rel_mse.abs().sqrt(),
            smape: rel_mse.abs().sqrt(),
            ssim: None,
            flip: 0.1,
            hdr_flip: Some(0.2),
            non_finite: 0,
        },
    }
}

#[test]
fn seeds_are_averaged_and_slopes_fitted() {
    let points = [1, 2, 4, 8]
        .into_iter()
        .flat_map(|n| [0.9, 1.1].map(|noise| (n, noise)))
        .enumerate()
        .map(|(i, (n, noise))| point(i as u64 % 2, n, 0.04 * noise / f64::from(n)))
        .collect();
    let curve = Curve::new("A".into(), "r".into(), points);
    assert_eq!(curve.rows.len(), 4);
    let row = &curve.rows[2];
    assert_eq!((row.samples, row.seeds, row.seconds), (4, 2, 2.0));
    let get = |key: &str| row.measures[key].unwrap();
    assert!((get("rel_mse").mean - 0.01).abs() < 1e-12);
    assert!((get("error_percent").mean - 10.0).abs() < 1e-9);
    assert!((get("rmse").mean - 0.2).abs() < 1e-9);
    // Half the difference of 0.009 and 0.011, times √2.
    assert!((get("rel_mse").deviation.unwrap() - 0.001 * 2f64.sqrt()).abs() < 1e-12);
    assert!(row.measures["ssim"].is_none());
    assert!((row.seconds_times_rel_mse - 0.02).abs() < 1e-12);
    let law = curve.slopes["error_percent"];
    assert!((law.slope + 0.5).abs() < 1e-9 && law.slope_error.unwrap() < 1e-9);
    assert!(!curve.slopes.contains_key("ssim"));
}

#[test]
fn noise_below_the_references_is_no_number() {
    let points = vec![point(0, 1, 0.04), point(0, 2, -0.001)];
    let curve = Curve::new("A".into(), "r".into(), points);
    assert!(curve.rows[1].measures["error_percent"].is_none());
    assert_eq!(curve.against_time(main_measure()).len(), 1);
    assert!(!curve.slopes.contains_key("error_percent"));
}

#[test]
fn spreads_have_two_digits() {
    for (value, expected) in [
        (0.0, "0"),
        (0.001_234, "0.0012"),
        (0.5, "0.50"),
        (2.64, "2.6"),
        (56.4, "56"),
        (1234.0, "1234"),
        (1.26e-7, "1.3e-7"),
        (1.26e7, "1.3e7"),
    ] {
        assert_eq!(two_digits(value), expected);
    }
}

#[test]
fn ratios_have_the_error_of_their_seeds() {
    let curve = |name: &str, factors: &[f64]| {
        let points = factors
            .iter()
            .enumerate()
            .flat_map(|(seed, factor)| {
                [1, 4, 16].map(|n| point(seed as u64, n, 0.04 * factor / f64::from(n)))
            })
            .collect();
        Curve::new(name.into(), "r".into(), points)
    };
    // Without a seed the curve is that of the other one, and the time to equal error goes with the square of the error, here
    // with relMSE itself: ln 1.2 apart, of which the jackknife takes half: (1/2) · 2 · (ln 1.2 / 2)².
    let error = ratio_error(&curve("A", &[1.0, 1.0]), &curve("B", &[1.0, 1.2])).unwrap();
    assert!((error - 1.2f64.ln() / 2.0).abs() < 1e-9, "{error}");
    assert_eq!(
        ratio_error(&curve("A", &[1.0]), &curve("B", &[1.0, 1.2])),
        None
    );
}

#[test]
fn equal_errors_are_powers_of_two() {
    let ours = [(1.0, 40.0), (16.0, 10.0)];
    let theirs = [(2.0, 40.0), (32.0, 10.0)];
    let against = compared("B", &ours, &theirs);
    assert_eq!(against.at.len(), 2);
    assert!(against.at.iter().all(|at| (at.ratio - 2.0).abs() < 1e-9));
    assert!(against.sentence().contains("B takes 2.000 times"));
    assert!(
        compared("C", &ours, &[(1.0, 1.0)])
            .sentence()
            .contains("no common error")
    );
}
