//! Smaller inputs that show the same.

use serde_json::{Value, json};

/// Makes a tree smaller as long as it stays one that `fails`, trying at most so often: lists lose elements, objects
/// lose entries, numbers become simpler.
pub fn shrink(input: &Value, tries: u32, mut fails: impl FnMut(&Value) -> bool) -> Value {
    let (mut best, mut left) = (input.clone(), tries);
    loop {
        let mut smaller = None;
        for candidate in candidates(&best) {
            if left == 0 {
                return best;
            }
            left -= 1;
            if fails(&candidate) {
                smaller = Some(candidate);
                break;
            }
        }
        match smaller {
            Some(smaller) => best = smaller,
            None => return best,
        }
    }
}

/// Trees that are one step simpler, the boldest steps first.
fn candidates(value: &Value) -> Vec<Value> {
    let mut found = Vec::new();
    match value {
        Value::Array(items) => {
            if items.len() > 2 {
                found.push(json!(items[..items.len() / 2]));
                found.push(json!(items[items.len() / 2..]));
            }
            for i in 0..items.len() {
                let mut fewer = items.clone();
                fewer.remove(i);
                found.push(Value::Array(fewer));
            }
            for (i, item) in items.iter().enumerate() {
                for simpler in candidates(item) {
                    let mut items = items.clone();
                    items[i] = simpler;
                    found.push(Value::Array(items));
                }
            }
        }
        Value::Object(map) => {
            for key in map.keys() {
                let mut fewer = map.clone();
                fewer.remove(key);
                found.push(Value::Object(fewer));
            }
            for (key, item) in map {
                for simpler in candidates(item) {
                    let mut map = map.clone();
                    map[key] = simpler;
                    found.push(Value::Object(map));
                }
            }
        }
        Value::Number(number) => {
            let number = number.as_f64().unwrap_or(0.0);
            let simpler = [0.0, 1.0, number.round(), (number * 10.0).round() / 10.0];
            let simpler = simpler.into_iter().filter(|n| digits(*n) < digits(number));
            found.extend(simpler.map(|n| json!(n)));
        }
        Value::Bool(true) => found.push(json!(false)),
        _ => {}
    }
    found
}

/// How long a number is to read.
fn digits(number: f64) -> usize {
    if number == 0.0 {
        0
    } else if number == 1.0 {
        1
    } else {
        1 + number.to_string().len().min(format!("{number:e}").len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_matter_goes() {
        let input = json!({ "a": [1, 7.25, { "bad": 3.71 }], "b": true, "c": "text" });
        let fails = |value: &Value| {
            let bad = value.pointer("/a").and_then(Value::as_array);
            bad.is_some_and(|items| items.iter().any(|item| item["bad"].as_f64() > Some(2.0)))
        };
        assert_eq!(
            shrink(&input, 1000, fails),
            json!({ "a": [{ "bad": 4.0 }] })
        );
        assert_eq!(shrink(&input, 0, fails), input);
    }
}
