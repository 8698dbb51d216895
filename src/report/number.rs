//! Numbers as text.

/// A number with four significant digits, as short as that can be: `0.0312`, `12.5`, `1 280`, `3.1e-7`.
pub fn number(value: f64) -> String {
    rounded(value, 4)
}

/// A number rounded to so many significant digits, without zeros at its end.
pub(super) fn rounded(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "not a number".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    // The exponent after rounding: 9.9999 becomes 10.00.
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..7).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        let exact: f64 = scientific.parse().unwrap_or(value);
        return grouped(without_zeros(&format!("{exact:.decimals$}")));
    }
    format!("{}e{exponent}", without_zeros(mantissa)).replace('-', "−")
}

fn without_zeros(text: &str) -> &str {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        text
    }
}

/// A thin space between groups of three digits, from five digits on, and a real minus sign.
fn grouped(text: &str) -> String {
    let (sign, text) = match text.strip_prefix('-') {
        Some(rest) => ("−", rest),
        None => ("", text),
    };
    let (whole, fraction) = text
        .split_at_checked(text.find('.').unwrap_or(text.len()))
        .unwrap_or((text, ""));
    let mut result = sign.to_owned();
    for (index, digit) in whole.chars().enumerate() {
        if index > 0 && whole.len() >= 5 && (whole.len() - index) % 3 == 0 {
            result.push('\u{202f}');
        }
        result.push(digit);
    }
    result + fraction
}

/// A number and its unit: `12.5 s`, `3 %`.
pub(super) fn with_unit(value: f64, unit: &str) -> String {
    if unit.is_empty() {
        number(value)
    } else {
        format!("{}\u{a0}{unit}", number(value))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/report/number.rs"]
mod tests;
