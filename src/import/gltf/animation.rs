//! Animations: the file's nodes and morph weights as they are at a time (specification 3.11).

use super::accessor;
use super::container::Document;
use super::words;
use crate::import::{AnimationTime, ImportError};
use crate::scene::{Diagnostics, Effect, Verdict};
use glam::{DQuat, DVec4};
use serde::Deserialize;
use serde_json::{Value, json};

#[derive(Debug, Deserialize)]
struct AnimationJson {
    #[serde(default)]
    channels: Vec<ChannelJson>,
    #[serde(default)]
    samplers: Vec<SamplerJson>,
}

#[derive(Debug, Deserialize)]
struct ChannelJson {
    sampler: usize,
    target: TargetJson,
}

#[derive(Debug, Deserialize)]
struct TargetJson {
    node: Option<usize>,
    path: String,
    #[serde(default)]
    extensions: TargetExtensions,
}

#[derive(Debug, Default, Deserialize)]
struct TargetExtensions {
    #[serde(rename = "KHR_animation_pointer")]
    pointer: Option<PointerJson>,
}

#[derive(Debug, Deserialize)]
struct PointerJson {
    pointer: String,
}

#[derive(Debug, Deserialize)]
struct SamplerJson {
    input: usize,
    output: usize,
    #[serde(default)]
    interpolation: Interpolation,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Interpolation {
    Step,
    #[default]
    Linear,
    CubicSpline,
}

/// Poses the nodes of a file as one of its animations has them at a time.
pub(super) fn pose(
    document: &mut Document,
    wanted: &AnimationTime,
    diagnostics: &mut Diagnostics,
) -> Result<(), ImportError> {
    let list = document.value.get("animations").and_then(Value::as_array);
    let list: Vec<&Value> = list.into_iter().flatten().collect();
    let name_of = |value: &Value| value.get("name").and_then(Value::as_str).map(str::to_owned);
    let names: Vec<String> = (list.iter().enumerate())
        .map(|(number, value)| name_of(value).unwrap_or_else(|| number.to_string()))
        .collect();
    let malformed =
        |object: String, problem: String| ImportError::malformed(&document.file, object, problem);
    let number = match &wanted.name {
        None => (!list.is_empty()).then_some(0),
        Some(wanted) => names
            .iter()
            .position(|name| name == wanted)
            .or_else(|| wanted.parse().ok().filter(|n| *n < list.len())),
    };
    let Some(number) = number else {
        let there = if names.is_empty() {
            "the file has none".to_owned()
        } else {
            format!("there are: {}", names.join(", "))
        };
        let object = wanted.name.as_deref().unwrap_or("0");
        let problem = format!("there is no such animation; {there}");
        return Err(malformed(format!("animation \"{object}\""), problem));
    };
    let owner = format!("animation \"{}\"", names[number]);
    let broken = |problem: String| malformed(owner.clone(), problem);
    let animation = AnimationJson::deserialize(list[number])
        .map_err(|problem| broken(format!("it cannot be read: {}", words::plain(&problem))))?;
    let mut posed: Vec<(String, Vec<f64>)> = Vec::new();
    let lose = |why: &str, diagnostics: &mut Diagnostics| {
        diagnostics.report_effect(
            Effect::MotionBlur,
            "animation-channel",
            Verdict::Lost,
            format!("a channel of an animation: {why}"),
            names[number].clone(),
            "it stands still",
        );
    };
    for channel in &animation.channels {
        let (place, why) = target(document, &channel.target);
        if !why.is_empty() {
            lose(why, diagnostics);
            continue;
        }
        let sampler = animation
            .samplers
            .get(channel.sampler)
            .ok_or_else(|| broken(format!("it has no sampler {}", channel.sampler)))?;
        let value = sampler
            .at(document, wanted.seconds, &place)
            .map_err(&broken)?;
        if let Some(node) = channel.target.node.filter(|node| *node >= document.nodes) {
            return Err(broken(format!(
                "it moves node {node}, which does not exist"
            )));
        }
        posed.push((place, value));
    }
    let mut value = document.value.clone();
    for (place, numbers) in &posed {
        if !set(&mut value, place, numbers) {
            lose("it moves what the file does not have", diagnostics);
        }
    }
    if !posed.is_empty() && document.replace(value).is_err() {
        lose("it makes of something what it cannot be", diagnostics);
    }
    Ok(())
}

/// Where what a channel moves stands in the JSON, and why it cannot be moved.
fn target(document: &Document, target: &TargetJson) -> (String, &'static str) {
    let has_matrix = |node: usize| {
        let node = document
            .value
            .get("nodes")
            .and_then(|nodes| nodes.get(node));
        node.is_some_and(|node| node.get("matrix").is_some())
    };
    match (&*target.path, target.node, &target.extensions.pointer) {
        ("translation" | "rotation" | "scale", Some(node), _) if has_matrix(node) => {
            (String::new(), "it moves a node that has a matrix")
        }
        (path @ ("translation" | "rotation" | "scale" | "weights"), Some(node), _) => {
            (format!("/nodes/{node}/{path}"), "")
        }
        ("pointer", _, Some(PointerJson { pointer })) => {
            let mut lists = ["nodes", "materials", "cameras", "meshes", "extensions"].iter();
            let within = pointer.split('/').nth(1).unwrap_or_default();
            match lists.any(|list| *list == within) {
                true => (pointer.clone(), ""),
                false => (String::new(), "it moves what has no motion"),
            }
        }
        _ => (String::new(), "it moves what glTF has no name for"),
    }
}

/// Puts numbers where a JSON pointer leads; whether there is such a place.
fn set(value: &mut Value, place: &str, numbers: &[f64]) -> bool {
    let Some((parent, name)) = place.rsplit_once('/') else {
        return false;
    };
    let name = name.replace("~1", "/").replace("~0", "~");
    let Some(parent) = value.pointer_mut(parent) else {
        return false;
    };
    let there = match parent {
        Value::Object(fields) => fields.get(&name),
        Value::Array(items) => name.parse().ok().and_then(|at: usize| items.get(at)),
        _ => None,
    };
    let is_list = matches!(there, Some(Value::Array(_))) || name == "weights";
    // The one thing that is no number, and may be left out.
    let is_switch = matches!(there, Some(Value::Bool(_))) || name == "visible";
    let new = match numbers {
        [one] if is_switch => json!(*one != 0.0),
        [one] if !is_list => json!(one),
        many => json!(many),
    };
    match parent {
        Value::Object(fields) => {
            fields.insert(name, new);
            true
        }
        Value::Array(items) => match name.parse().ok().and_then(|at: usize| items.get_mut(at)) {
            Some(item) => {
                *item = new;
                true
            }
            None => false,
        },
        _ => false,
    }
}

impl SamplerJson {
    /// The value at a time: that of the first key before it, and of the last one after it.
    ///
    /// `place` is the JSON pointer of what it moves.
    fn at(&self, document: &Document, seconds: f64, place: &str) -> Result<Vec<f64>, String> {
        let budget = &document.budget;
        let times = accessor::read::<1>(document, self.input, budget)?;
        let path = place.rsplit('/').next().unwrap_or_default();
        let of_node = place.starts_with("/nodes/") && place.matches('/').count() == 3;
        let path = if of_node { path } else { "" };
        let output = self.output;
        let components = accessor::components(accessor::shape(document, output)?.kind);
        let values: Vec<f64> = match components {
            1 => accessor::read::<1>(document, output, budget)?.into_flattened(),
            2 => accessor::read::<2>(document, output, budget)?.into_flattened(),
            3 => accessor::read::<3>(document, output, budget)?.into_flattened(),
            4 => accessor::read::<4>(document, output, budget)?.into_flattened(),
            _ => return Err("it moves something by matrices".into()),
        };
        // Of a cubic spline each key has three: the tangent before it, the value, and the tangent after it.
        let cubic = self.interpolation == Interpolation::CubicSpline;
        let parts = if cubic { 3 } else { 1 };
        let width = values.len() / (times.len() * parts).max(1);
        let fits = match path {
            "translation" | "scale" => width == 3,
            "rotation" => width == 4,
            _ => width > 0,
        };
        if times.is_empty() || !fits || width * times.len() * parts != values.len() {
            let (keys, numbers) = (times.len(), values.len());
            let what = if path.is_empty() { place } else { path };
            return Err(format!(
                "a sampler has {keys} times, and {numbers} numbers for {what}"
            ));
        }
        let part = |key: usize, part: usize| &values[(key * parts + part) * width..][..width];
        let value = |key: usize| part(key, parts / 2);
        let after = times.partition_point(|[time]| *time <= seconds);
        if after == 0 || after == times.len() || self.interpolation == Interpolation::Step {
            return Ok(value(after.saturating_sub(1)).to_vec());
        }
        let (from, to) = (after - 1, after);
        let span = times[to][0] - times[from][0];
        let t = if span > 0.0 {
            (seconds - times[from][0]) / span
        } else {
            1.0
        };
        let is_rotation = path == "rotation" || place.ends_with("/rotation") && width == 4;
        if cubic {
            let (t2, t3) = (t * t, t * t * t);
            let weights = [
                2.0 * t3 - 3.0 * t2 + 1.0,
                span * (t3 - 2.0 * t2 + t),
                3.0 * t2 - 2.0 * t3,
                span * (t3 - t2),
            ];
            let four = [value(from), part(from, 2), value(to), part(to, 0)];
            let sum = |i: usize| four.iter().zip(weights).map(|(v, w)| v[i] * w).sum();
            let mut result: Vec<f64> = (0..width).map(sum).collect();
            if is_rotation {
                let length = result.iter().map(|v| v * v).sum::<f64>().sqrt();
                result
                    .iter_mut()
                    .for_each(|v| *v /= length.max(f64::MIN_POSITIVE));
            }
            return Ok(result);
        }
        if is_rotation {
            let turn = |v: &[f64]| DQuat::from_vec4(DVec4::from_slice(v)).normalize();
            // Along the shorter arc.
            let between = turn(value(from)).slerp(turn(value(to)), t);
            return Ok(between.to_array().to_vec());
        }
        let pairs = value(from).iter().zip(value(to));
        Ok(pairs.map(|(a, b)| a + (b - a) * t).collect())
    }
}
