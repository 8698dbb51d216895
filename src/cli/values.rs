//! The text of an argument becomes a value, or a clause that says what was expected.

use super::flags::{Kind, MAX_BOUNCES};
use crate::film::Passes;
use crate::render::{EffectChoice, Filter, FilterKind, Region, RenderSettings};
use std::ffi::OsStr;
use std::path::PathBuf;
use std::time::Duration;

/// A value of one of the [`Kind`]s, within its range.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Value {
    Text(String),
    Path(PathBuf),
    Integer(u64),
    Number(f64),
    Duration(Duration),
    Color([f32; 3]),
    Filter(Filter),
    Effects(EffectChoice),
    Region(Region),
    /// Of a pixel: column, row, number.
    Sample(u32, u32, u32),
    Range(u32, u32),
    Share(f64),
    Passes(Passes),
    /// The first bounce; `None` for off.
    Roulette(Option<u32>),
    Choice(&'static str),
}

/// Widest filter in pixels; Cycles allows 10 as well.
const MAX_FILTER_WIDTH: f32 = 10.0;
/// Longest time that can be asked for: a hundred years.
const MAX_SECONDS: f64 = 100.0 * 365.25 * 86_400.0;

/// Reads a value.
///
/// # Errors
/// A clause that says what was expected, for example `expected a whole number from 1 to 100`.
pub fn parse(kind: &Kind, text: &OsStr) -> Result<Value, String> {
    if *kind == Kind::Path {
        return if text.is_empty() {
            Err("expected the name of a file".into())
        } else {
            Ok(Value::Path(text.into()))
        };
    }
    let text = text.to_str().ok_or("it is not valid Unicode")?;
    match *kind {
        Kind::Switch => Err("it takes no value".into()),
        Kind::Path | Kind::Text => Ok(Value::Text(text.into())),
        Kind::Integer { min, max } => text
            .parse()
            .ok()
            .filter(|number| (min..=max).contains(number))
            .map(Value::Integer)
            .ok_or_else(|| format!("expected a whole number from {min} to {max}")),
        Kind::Number { min, max } => text
            .parse()
            .ok()
            .filter(|number| (min..=max).contains(number))
            .map(Value::Number)
            .ok_or_else(|| format!("expected a number from {min} to {max}")),
        Kind::Duration => duration(text)
            .map(Value::Duration)
            .ok_or_else(|| "expected a length of time such as 30s, 2m or 1h30m".into()),
        Kind::Color => color(text).map(Value::Color).ok_or_else(|| {
            "expected three numbers of at least 0 with commas between them, such as 0.5,0.5,0.5"
                .into()
        }),
        Kind::Filter => filter(text).map(Value::Filter),
        Kind::Effects => effects(text).map(Value::Effects),
        Kind::Region => region(text).map(Value::Region).ok_or_else(|| {
            "expected four whole numbers X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1".into()
        }),
        Kind::Address { port } => address(text, port).map(Value::Text).ok_or_else(|| {
            format!("expected HOST:PORT such as localhost:{port}, with a port from 1 to 65535")
        }),
        Kind::Sample => sample(text)
            .ok_or_else(|| "expected three whole numbers X,Y,SAMPLE, such as 12,30,5".into()),
        Kind::Range => range(text)
            .ok_or_else(|| "expected two whole numbers A..B with A < B, such as 0..64".into()),
        Kind::Share => share(text)
            .map(Value::Share)
            .ok_or_else(|| "expected a share above 0 such as 0.05 or 5%".into()),
        Kind::Roulette => roulette(text)
            .map(Value::Roulette)
            .ok_or_else(|| format!("expected on, off or a bounce from 1 to {MAX_BOUNCES}")),
        Kind::Passes => passes(text).map(Value::Passes),
        Kind::Choice { choices } => choices
            .iter()
            .find(|choice| choice.name == text)
            .map(|choice| Value::Choice(choice.name))
            .ok_or_else(|| {
                format!(
                    "expected {}",
                    alternatives(choices.iter().map(|choice| choice.name))
                )
            }),
    }
}

/// `a`, `a or b`, `a, b or c`.
pub fn alternatives<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.collect();
    match names.split_last() {
        None => String::new(),
        Some((last, [])) => (*last).into(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}

fn roulette(text: &str) -> Option<Option<u32>> {
    match text {
        "on" => Some(RenderSettings::default().roulette),
        "off" => Some(None),
        _ => {
            let bounce = text.parse().ok()?;
            (1..=MAX_BOUNCES as u32)
                .contains(&bounce)
                .then_some(Some(bounce))
        }
    }
}

/// `HOST:PORT`; addresses of IPv6 stand in brackets.
fn address(text: &str, default: u16) -> Option<String> {
    let (host, port) = match text.rsplit_once(':') {
        Some((host, port)) if !text.ends_with(']') => (host, port.parse().ok()?),
        _ => (text, default),
    };
    let bracketed = host.starts_with('[') && host.ends_with(']');
    let plain = !host.is_empty() && !host.contains([':', ' ', '[', ']']);
    (port > 0 && (bracketed || plain)).then(|| format!("{host}:{port}"))
}

fn sample(text: &str) -> Option<Value> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers?.as_slice() {
        &[x, y, sample] => Some(Value::Sample(x, y, sample)),
        _ => None,
    }
}

fn range(text: &str) -> Option<Value> {
    let (from, to) = text.split_once("..")?;
    let (from, to) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
    (from < to).then_some(Value::Range(from, to))
}

fn duration(text: &str) -> Option<Duration> {
    let mut seconds = 0.0;
    let mut rest = text.trim();
    let mut smallest_unit = f64::INFINITY;
    while !rest.is_empty() {
        let digits = rest
            .find(|c: char| !c.is_ascii_digit() && c != '.')
            .unwrap_or(rest.len());
        let number: f64 = rest[..digits].parse().ok()?;
        rest = &rest[digits..];
        let letters = rest
            .find(|c: char| !c.is_ascii_alphabetic())
            .unwrap_or(rest.len());
        let unit = match &rest[..letters] {
            "" if smallest_unit.is_infinite() && rest.is_empty() => 1.0,
            "ms" => 1e-3,
            "s" => 1.0,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            _ => return None,
        };
        // Units go down: `30s2m` is more likely a slip than a wish.
        if unit >= smallest_unit {
            return None;
        }
        smallest_unit = unit;
        seconds += number * unit;
        rest = &rest[letters..];
    }
    (seconds > 0.0 && seconds <= MAX_SECONDS).then(|| Duration::from_secs_f64(seconds))
}

fn color(text: &str) -> Option<[f32; 3]> {
    let mut color = [0.0; 3];
    let mut parts = text.split(',');
    for component in &mut color {
        *component = parts
            .next()?
            .trim()
            .parse()
            .ok()
            .filter(|c: &f32| c.is_finite() && *c >= 0.0)?;
    }
    parts.next().is_none().then_some(color)
}

fn region(text: &str) -> Option<Region> {
    let numbers: Vec<u32> = text
        .split(',')
        .map(|part| part.trim().parse().ok())
        .collect::<Option<_>>()?;
    let &[x0, y0, x1, y1] = numbers.as_slice() else {
        return None;
    };
    (x0 < x1 && y0 < y1).then_some(Region { x0, y0, x1, y1 })
}

fn share(text: &str) -> Option<f64> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(percent) => (percent.trim_end(), 0.01),
        None => (text.trim(), 1.0),
    };
    let number: f64 = number.parse().ok()?;
    let share = number * unit;
    (share > 0.0 && share.is_finite()).then_some(share)
}

fn passes(text: &str) -> Result<Passes, String> {
    if text == "all" {
        return Ok(Passes::ALL);
    }
    Passes::parse(text.split(',').map(str::trim))
}

fn filter(text: &str) -> Result<Filter, String> {
    let (name, width) = match text.split_once(':') {
        Some((name, width)) => (name, Some(width)),
        None => (text, None),
    };
    let kind = match name {
        "blackman-harris" => FilterKind::BlackmanHarris,
        "gauss" => FilterKind::Gauss,
        "box" => FilterKind::Box,
        _ => return Err("expected blackman-harris, gauss or box".into()),
    };
    let width = match (kind, width) {
        (FilterKind::Box, Some(_)) => {
            return Err("the box filter is one pixel wide and takes no width".into());
        }
        (FilterKind::Box, None) => 1.0,
        (_, None) => Filter::default().width,
        (_, Some(width)) => width
            .parse()
            .ok()
            .filter(|width| *width >= 0.01 && *width <= MAX_FILTER_WIDTH)
            .ok_or_else(|| {
                format!("expected a width from 0.01 to {MAX_FILTER_WIDTH} pixels after the colon")
            })?,
    };
    Ok(Filter { kind, width })
}

fn effects(text: &str) -> Result<EffectChoice, String> {
    match text {
        "auto" => Ok(EffectChoice::Auto),
        "all" => Ok(EffectChoice::All),
        _ => {
            let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
            if names.iter().any(String::is_empty) {
                return Err(
                    "expected auto, all, or names of effects with commas between them".into(),
                );
            }
            Ok(EffectChoice::List(names))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_time() {
        let seconds = |text| duration(text).map(|d| d.as_secs_f64());
        assert_eq!(seconds("90"), Some(90.0));
        assert_eq!(seconds("30s"), Some(30.0));
        assert_eq!(seconds("1.5m"), Some(90.0));
        assert_eq!(seconds("1h30m"), Some(5400.0));
        assert_eq!(seconds("1h1m1s"), Some(3661.0));
        assert_eq!(seconds("250ms"), Some(0.25));
        for wrong in [
            "", "0", "0s", "-1s", "s", "1x", "1m1h", "1s1s", "1h30", "1e999h", "nan", "inf",
            "1.2.3s", "９s",
        ] {
            assert_eq!(seconds(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn colours() {
        assert_eq!(color("1,0.5, 0"), Some([1.0, 0.5, 0.0]));
        for wrong in [
            "", "1", "1,2", "1,2,3,4", "1,2,-3", "nan,1,1", "1,inf,1", "a,b,c",
        ] {
            assert_eq!(color(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn addresses() {
        let kind = Kind::Address { port: 14158 };
        let read = |text: &str| match parse(&kind, text.as_ref()) {
            Ok(Value::Text(text)) => Some(text),
            _ => None,
        };
        for (text, address) in [
            ("localhost", "localhost:14158"),
            ("viewer.example:80", "viewer.example:80"),
            ("127.0.0.1:65535", "127.0.0.1:65535"),
            ("[::1]", "[::1]:14158"),
            ("[::1]:7", "[::1]:7"),
        ] {
            assert_eq!(read(text).as_deref(), Some(address), "{text}");
        }
        for wrong in [
            "", ":", ":80", "a:", "a:0", "a:65536", "a:b", "::1", "a b", "[::1", "a:80:80",
        ] {
            assert_eq!(read(wrong), None, "{wrong}");
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
            assert_eq!(roulette(text), Some(bounce), "{text}");
        }
        for wrong in ["", "0", "1025", "-1", "2.5", "On"] {
            assert_eq!(roulette(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn regions() {
        assert_eq!(
            region("0,10, 5,11"),
            Some(Region {
                x0: 0,
                y0: 10,
                x1: 5,
                y1: 11
            })
        );
        for wrong in [
            "",
            "0,0,1",
            "0,0,1,1,1",
            "5,0,5,1",
            "0,2,1,1",
            "-1,0,1,1",
            "0,0,1.5,1",
            "0,0,99999999999,1",
        ] {
            assert_eq!(region(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn samples() {
        let of = |text| parse(&Kind::Sample, OsStr::new(text));
        assert_eq!(of("3, 4,4294967295"), Ok(Value::Sample(3, 4, u32::MAX)));
        for bad in ["", "1,2", "1,2,3,4", "-1,2,3", "1,2,4294967296"] {
            assert!(of(bad).unwrap_err().contains("X,Y,SAMPLE"), "{bad}");
        }
    }

    #[test]
    fn shares() {
        assert_eq!(share("0.05"), Some(0.05));
        assert_eq!(share("50 %"), Some(0.5));
        for wrong in ["", "0", "-1", "nan", "inf", "1e999%", "%", "5%%", "five"] {
            assert_eq!(share(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn lists_of_passes() {
        assert_eq!(passes("all"), Ok(Passes::ALL));
        let some = passes("Depth, Debug Sample Count").unwrap();
        assert_eq!(some.floats(), 4 + 1 + 1);
        for wrong in ["", "Depth,", "depth", "Fog"] {
            assert!(passes(wrong).unwrap_err().contains("there are: Combined"));
        }
    }

    #[test]
    fn filters() {
        assert_eq!(
            filter("gauss:2"),
            Ok(Filter {
                kind: FilterKind::Gauss,
                width: 2.0
            })
        );
        assert_eq!(filter("blackman-harris"), Ok(Filter::default()));
        assert_eq!(
            filter("box"),
            Ok(Filter {
                kind: FilterKind::Box,
                width: 1.0
            })
        );
        for wrong in [
            "",
            "sinc",
            "box:2",
            "gauss:",
            "gauss:0",
            "gauss:nan",
            "gauss:11",
        ] {
            assert!(filter(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn effect_lists() {
        assert_eq!(effects("auto"), Ok(EffectChoice::Auto));
        assert_eq!(
            effects("a,b"),
            Ok(EffectChoice::List(vec!["a".into(), "b".into()]))
        );
        assert!(effects("a,,b").is_err());
        assert!(effects("").is_err());
    }

    #[test]
    fn numbers_within_bounds() {
        let kind = Kind::Number {
            min: -1.0,
            max: 1.0,
        };
        assert_eq!(parse(&kind, "-1".as_ref()), Ok(Value::Number(-1.0)));
        for wrong in ["nan", "inf", "1.1", "", "one"] {
            assert!(parse(&kind, wrong.as_ref()).is_err(), "{wrong}");
        }
        let kind = Kind::Integer { min: 1, max: 9 };
        for wrong in ["0", "10", "-1", "1.5", "99999999999999999999"] {
            assert!(parse(&kind, wrong.as_ref()).is_err(), "{wrong}");
        }
    }
}
