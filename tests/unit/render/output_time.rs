use super::*;

#[test]
fn tracing_and_output_fill_the_time() {
    let output = OutputTime {
        full: Duration::from_secs_f64(2.0),
        blank: Duration::from_secs_f64(0.5),
        ..OutputTime::default()
    };
    assert_eq!(output.at(0.0), output.blank);
    assert_eq!(output.at(1.0), output.full);
    // A tenth of the picture a second.
    let share = output.share_at_end(0.1, 0.1, 5.0);
    let tracing = (share - 0.1) / 0.1;
    assert!((tracing + output.at(share).as_secs_f64() - 5.0).abs() < 1e-8);
    // All of it long before the end; and no time at all.
    assert_eq!(output.share_at_end(0.5, 1.0, 60.0), 1.0);
    assert_eq!(output.share_at_end(0.25, 1.0, 0.1), 0.25);
    // Black that takes longer is a matter of chance.
    let odd = OutputTime {
        full: output.blank,
        blank: output.full,
        ..output
    };
    assert_eq!(odd.at(0.5), odd.blank);
    assert_eq!(odd.share_at_end(0.0, 0.1, 7.0), 0.5);
}
#[test]
fn tries_are_averaged() {
    let of = |seconds, is_guess| {
        let time = Duration::from_secs(seconds);
        OutputTime {
            full: time,
            blank: time,
            seen_error: time,
            is_guess,
        }
    };
    assert_eq!(of(1, false).and(3, of(5, false)), of(2, false));
    assert_eq!(of(1, true).and(1, of(5, false)), of(5, false));
    assert_eq!(of(1, false).and(1, of(5, true)), of(1, false));
}
