//! Animations: the file's nodes and morph weights as they are at a time (specification 3.11).

use super::accessor;
use super::container::Document;
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
        .map_err(|problem| broken(format!("it cannot be read: {problem}")))?;
    let mut posed: Vec<(usize, String, Vec<f64>)> = Vec::new();
    for channel in &animation.channels {
        let path = &*channel.target.path;
        let node = channel.target.node;
        let has_matrix = |node: usize| {
            let node = document
                .value
                .get("nodes")
                .and_then(|nodes| nodes.get(node));
            node.is_some_and(|node| node.get("matrix").is_some())
        };
        let why = match (path, node) {
            ("translation" | "rotation" | "scale", Some(node)) if has_matrix(node) => {
                "it moves a node that has a matrix"
            }
            ("translation" | "rotation" | "scale" | "weights", Some(_)) => "",
            ("pointer", _) => "it moves other things than nodes (KHR_animation_pointer)",
            _ => "it moves what glTF has no name for",
        };
        if !why.is_empty() {
            let what = format!("a channel of an animation: {why}");
            let effect = Effect::MotionBlur;
            let instead = "it stands still";
            diagnostics.report_effect(
                effect,
                "animation-channel",
                Verdict::Lost,
                what,
                names[number].clone(),
                instead,
            );
            continue;
        }
        let sampler = animation
            .samplers
            .get(channel.sampler)
            .ok_or_else(|| broken(format!("it has no sampler {}", channel.sampler)))?;
        let value = sampler
            .at(document, wanted.seconds, path)
            .map_err(&broken)?;
        let Some(node) = node.filter(|node| *node < document.nodes) else {
            return Err(broken("it moves a node which does not exist".into()));
        };
        posed.push((node, path.to_owned(), value));
    }
    for (node, path, value) in posed {
        let place = document
            .value
            .get_mut("nodes")
            .and_then(|nodes| nodes.get_mut(node));
        if let Some(Value::Object(node)) = place {
            node.insert(path, json!(value));
        }
    }
    Ok(())
}

impl SamplerJson {
    /// The value at a time: that of the first key before it, and of the last one after it.
    fn at(&self, document: &Document, seconds: f64, path: &str) -> Result<Vec<f64>, String> {
        let budget = &document.budget;
        let times = accessor::read::<1>(document, self.input, budget)?;
        let values: Vec<f64> = match path {
            "translation" | "scale" => {
                accessor::read::<3>(document, self.output, budget)?.into_flattened()
            }
            "rotation" => accessor::read::<4>(document, self.output, budget)?.into_flattened(),
            _ => accessor::read::<1>(document, self.output, budget)?.into_flattened(),
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
            return Err(format!(
                "a sampler has {keys} times, and {numbers} numbers for {path}"
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
        let is_rotation = path == "rotation";
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
