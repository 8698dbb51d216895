//! Counts, times, sizes and shares as people say them.

/// `1 triangle`, `2 triangles`, `1.5 samples`; the count as it is written.
pub fn counted(count: impl std::fmt::Display, one: &str, many: &str) -> String {
    let count = count.to_string();
    let noun = if count == "1" { one } else { many };
    format!("{count} {noun}")
}

/// `1234567` as `1 234 567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut result = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            result.push(' ');
        }
        result.push(digit);
    }
    result
}

/// Bytes in the unit that gives a short number.
pub fn bytes(number: u64) -> String {
    let mut value = number as f64;
    let mut unit = "B";
    for next in ["KiB", "MiB", "GiB", "TiB"] {
        if value < 1024.0 {
            break;
        }
        value /= 1024.0;
        unit = next;
    }
    if unit == "B" {
        format!("{number} B")
    } else {
        format!("{value:.1} {unit}")
    }
}

/// `75.3` as `1:15`, `4000` as `1:06:40`, below a minute as `5.3 s`.
pub fn clock(seconds: f64) -> String {
    if seconds < 60.0 {
        return format!("{seconds:.1} s");
    }
    let whole = seconds.round() as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 {
        format!("{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{minutes}:{seconds:02}")
    }
}

/// Smaller shares are told as 0.
const MOST_DECIMALS: i32 = 9;

/// `2.4 %`: two digits, more where there are more before the point.
pub fn percent(share: f64) -> String {
    format!("{} %", in_percent(share, 2))
}

/// `2.10 % (1.93 to 2.42 %)`: an estimate with its interval, three digits.
pub fn estimated(estimate: f64, low: f64, high: f64) -> String {
    let [estimate, low, high] = [estimate, low, high].map(|share| in_percent(share, 3));
    format!("{estimate} % ({low} to {high} %)")
}

/// So many digits, as many decimals as that takes.
fn in_percent(share: f64, digits: i32) -> String {
    let percent = 100.0 * share;
    let decimals = if percent == 0.0 {
        0
    } else {
        (digits - 1 - percent.abs().log10().floor() as i32).clamp(0, MOST_DECIMALS) as usize
    };
    format!("{percent:.decimals$}")
}

/// `40 ms`, `4.2 s`, `1:15`: a length of time, of two digits where it is short.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "for ever".into();
    }
    if seconds.abs() < 0.0995 {
        return format!("{:.0} ms", 1000.0 * seconds);
    }
    if seconds < 0.0 {
        return format!("-{}", duration(-seconds));
    }
    match seconds {
        s if s < 0.995 => format!("{s:.2} s"),
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 59.5 => format!("{s:.0} s"),
        s => clock(s),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/math/words.rs"]
mod tests;
