use super::*;

#[test]
fn lengths_of_time() {
    let seconds = |text| duration(text).ok().map(|d| d.as_secs_f64());
    assert_eq!(seconds("90"), Some(90.0));
    assert_eq!(seconds("30s"), Some(30.0));
    assert_eq!(seconds("1.5m"), Some(90.0));
    assert_eq!(seconds("1h30m"), Some(5400.0));
    assert_eq!(seconds("1h1m1s"), Some(3661.0));
    assert_eq!(seconds("250ms"), Some(0.25));
    for wrong in [
        "", "0", "0s", "-1s", "s", "1x", "1m1h", "1s1s", "1h30", "1e999h", "nan", "inf", "1.2.3s",
        "９s",
    ] {
        assert_eq!(seconds(wrong), None, "{wrong}");
    }
}

#[test]
fn colours() {
    assert_eq!(color("1,0.5, 0"), Ok([1.0, 0.5, 0.0]));
    for wrong in [
        "", "1", "1,2", "1,2,3,4", "1,2,-3", "nan,1,1", "1,inf,1", "a,b,c",
    ] {
        assert!(color(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn roulettes() {
    for (text, bounce) in [
        ("on", Some(2)),
        ("off", None),
        ("1", Some(1)),
        ("1024", Some(1024)),
    ] {
        assert_eq!(roulette(text), Ok(bounce), "{text}");
    }
    for wrong in ["", "0", "1025", "-1", "2.5", "On"] {
        assert!(roulette(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn samples() {
    assert_eq!(sample("3, 4,4294967295"), Ok((3, 4, u32::MAX)));
    for wrong in ["", "1,2", "1,2,3,4", "-1,2,3", "1,2,4294967296"] {
        assert!(sample(wrong).unwrap_err().contains("X,Y,SAMPLE"), "{wrong}");
    }
    assert_eq!(sample_range("0 .. 64"), Ok(0..64));
    for wrong in ["", "5", "5..5", "6..5", "-1..5", "..5", "1..2..3"] {
        assert!(sample_range(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn shares() {
    assert_eq!(share("0.05"), Ok(0.05));
    assert_eq!(share("50 %"), Ok(0.5));
    for wrong in ["", "0", "-1", "nan", "inf", "1e999%", "%", "5%%", "five"] {
        assert!(share(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn numbers_within_bounds() {
    let read = |arg: Arg, text: &str| {
        let command = clap::Command::new("x").arg(arg.long("n"));
        command.try_get_matches_from(["x", &format!("--n={text}")])
    };
    let number = || Arg::new("n").number(-1.0..=1.0);
    let matches = read(number(), "-1").unwrap();
    assert_eq!(matches.get_one("n"), Some(&-1.0));
    for wrong in ["nan", "inf", "1.1", "", "one"] {
        assert!(read(number(), wrong).is_err(), "{wrong}");
    }
    for wrong in ["0", "10", "-1", "1.5", "99999999999999999999"] {
        assert!(read(Arg::new("n").whole(1..=9), wrong).is_err(), "{wrong}");
    }
}
