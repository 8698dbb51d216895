use super::*;

#[test]
fn what_is_not_a_number_never_holds() {
    assert!(Finding::new("", 1.0, 1.5, 0.5).holds());
    assert!(!Finding::new("", 1.0, 1.6, 0.5).holds());
    assert!(!Finding::new("", 1.0, f64::NAN, 0.5).holds());
    assert!(!Finding::none("", 1).holds());
    let nothing = Outcome {
        findings: Ok(Vec::new()),
        time: Duration::ZERO,
    };
    assert!(!nothing.holds());
}
