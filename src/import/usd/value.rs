//! Values of a stage as numbers, words and lists of ours, whatever precision they were written in.

use glam::{DMat4, DQuat};
use openusd::sdf::{AssetPath, Value};

/// A number.
pub(super) fn number(value: &Value) -> Option<f64> {
    Some(match value {
        Value::Double(v) => *v,
        Value::Float(v) => f64::from(*v),
        Value::Half(v) => v.to_f64(),
        Value::Int(v) => f64::from(*v),
        Value::Uint(v) => f64::from(*v),
        Value::Int64(v) => *v as f64,
        Value::Uint64(v) => *v as f64,
        Value::Uchar(v) => f64::from(*v),
        Value::TimeCode(v) => v.0,
        Value::Bool(v) => f64::from(u8::from(*v)),
        _ => return None,
    })
}

/// A truth.
pub(super) fn truth(value: &Value) -> Option<bool> {
    match value {
        Value::Bool(v) => Some(*v),
        other => number(other).map(|v| v != 0.0),
    }
}

/// A word.
pub(super) fn word(value: &Value) -> Option<String> {
    Some(match value {
        Value::Token(v) => v.as_str().to_owned(),
        Value::String(v) => v.clone(),
        Value::AssetPath(v) => v.as_str().to_owned(),
        _ => return None,
    })
}

/// The path of a file. Samples over time come as words.
pub(super) fn asset(value: &Value) -> Option<AssetPath> {
    match value {
        Value::AssetPath(asset) => Some(asset.clone()),
        Value::String(path) => Some(AssetPath::new(path.as_str())),
        _ => None,
    }
}

/// Words.
pub(super) fn words(value: &Value) -> Vec<String> {
    match value {
        Value::TokenVec(v) => v.iter().map(|t| t.as_str().to_owned()).collect(),
        Value::StringVec(v) => v.clone(),
        Value::TokenListOp(op) => {
            let all = op.flatten().into_iter();
            all.map(|t| t.as_str().to_owned()).collect()
        }
        other => word(other).into_iter().collect(),
    }
}

/// Two to four numbers.
pub(super) fn vector<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let (components, numbers) = floats(value)?;
    // What is one number stands for all of them nowhere; what is longer (a colour with alpha) is cut.
    if components < N || numbers.len() != components {
        return None;
    }
    // Doubles keep their precision.
    match value {
        Value::Vec2d(v) => cut(&<[f64; 2]>::from(*v)),
        Value::Vec3d(v) => cut(&<[f64; 3]>::from(*v)),
        Value::Vec4d(v) => cut(&<[f64; 4]>::from(*v)),
        _ => cut(&numbers.iter().map(|v| f64::from(*v)).collect::<Vec<_>>()),
    }
}

fn cut<const N: usize>(numbers: &[f64]) -> Option<[f64; N]> {
    numbers.get(..N)?.try_into().ok()
}

/// A rotation.
pub(super) fn rotation(value: &Value) -> Option<DQuat> {
    let [w, x, y, z] = match value {
        Value::Quatd(q) => [q.w, q.x, q.y, q.z],
        Value::Quatf(q) => [q.w, q.x, q.y, q.z].map(f64::from),
        Value::Quath(q) => [q.w, q.x, q.y, q.z].map(|v| v.to_f64()),
        _ => return None,
    };
    unit(DQuat::from_xyzw(x, y, z, w))
}

/// Rotations.
pub(super) fn rotations(value: &Value) -> Option<Vec<DQuat>> {
    let all: Vec<[f64; 4]> = match value {
        Value::QuatdVec(v) => v.iter().map(|q| [q.w, q.x, q.y, q.z]).collect(),
        Value::QuatfVec(v) => {
            let one = v.iter().map(|q| [q.w, q.x, q.y, q.z].map(f64::from));
            one.collect()
        }
        Value::QuathVec(v) => {
            let one = v.iter().map(|q| [q.w, q.x, q.y, q.z].map(|v| v.to_f64()));
            one.collect()
        }
        _ => return None,
    };
    let turn = |[w, x, y, z]: [f64; 4]| unit(DQuat::from_xyzw(x, y, z, w)).unwrap_or_default();
    Some(all.into_iter().map(turn).collect())
}

fn unit(q: DQuat) -> Option<DQuat> {
    let length = q.length();
    (length.is_finite() && length > 0.0).then(|| q / length)
}

/// A matrix for columns: USD's is for rows, and lies row by row.
pub(super) fn matrix(value: &Value) -> Option<DMat4> {
    match value {
        Value::Matrix4d(m) => Some(DMat4::from_cols_array(&m.0)),
        _ => None,
    }
}

/// Matrices for columns.
pub(super) fn matrices(value: &Value) -> Option<Vec<DMat4>> {
    match value {
        Value::Matrix4dVec(all) => Some(all.iter().map(|m| DMat4::from_cols_array(&m.0)).collect()),
        _ => None,
    }
}

/// Whole numbers.
pub(super) fn integers(value: &Value) -> Option<Vec<i64>> {
    Some(match value {
        Value::IntVec(v) => v.iter().map(|i| i64::from(*i)).collect(),
        Value::UintVec(v) => v.iter().map(|i| i64::from(*i)).collect(),
        Value::Int64Vec(v) => v.clone(),
        Value::Uint64Vec(v) => {
            let one = v.iter().map(|i| i64::try_from(*i).unwrap_or(i64::MAX));
            one.collect()
        }
        Value::UcharVec(v) => v.iter().map(|i| i64::from(*i)).collect(),
        _ => return None,
    })
}

/// One or many numbers or vectors, one after the other, and how many numbers each has.
pub(super) fn floats(value: &Value) -> Option<(usize, Vec<f32>)> {
    use bytemuck::cast_slice;
    let narrow = |v: &[f64]| v.iter().map(|v| *v as f32).collect::<Vec<f32>>();
    let halves = |v: &[half::f16]| v.iter().map(|v| v.to_f32()).collect::<Vec<f32>>();
    let whole = |v: &[i32]| v.iter().map(|v| *v as f32).collect::<Vec<f32>>();
    Some(match value {
        Value::FloatVec(v) => (1, v.clone()),
        Value::DoubleVec(v) => (1, narrow(v)),
        Value::HalfVec(v) => (1, v.iter().map(|v| v.to_f32()).collect()),
        Value::IntVec(v) => (1, whole(v)),
        Value::UintVec(v) => (1, v.iter().map(|v| *v as f32).collect()),
        Value::BoolVec(v) => (1, v.iter().map(|v| f32::from(u8::from(*v))).collect()),
        Value::Vec2fVec(v) => (2, cast_slice(v).to_vec()),
        Value::Vec2dVec(v) => (2, narrow(cast_slice(v))),
        Value::Vec2hVec(v) => (2, halves(cast_slice(v))),
        Value::Vec2iVec(v) => (2, whole(cast_slice(v))),
        Value::Vec3fVec(v) => (3, cast_slice(v).to_vec()),
        Value::Vec3dVec(v) => (3, narrow(cast_slice(v))),
        Value::Vec3hVec(v) => (3, halves(cast_slice(v))),
        Value::Vec3iVec(v) => (3, whole(cast_slice(v))),
        Value::Vec4fVec(v) => (4, cast_slice(v).to_vec()),
        Value::Vec4dVec(v) => (4, narrow(cast_slice(v))),
        Value::Vec4hVec(v) => (4, halves(cast_slice(v))),
        Value::Vec4iVec(v) => (4, whole(cast_slice(v))),
        Value::Vec2f(v) => (2, <[f32; 2]>::from(*v).to_vec()),
        Value::Vec2d(v) => (2, narrow(&<[f64; 2]>::from(*v))),
        Value::Vec2h(v) => (2, vec![v.x.to_f32(), v.y.to_f32()]),
        Value::Vec2i(v) => (2, whole(&[v.x, v.y])),
        Value::Vec3f(v) => (3, <[f32; 3]>::from(*v).to_vec()),
        Value::Vec3d(v) => (3, narrow(&<[f64; 3]>::from(*v))),
        Value::Vec3h(v) => (3, vec![v.x.to_f32(), v.y.to_f32(), v.z.to_f32()]),
        Value::Vec3i(v) => (3, whole(&[v.x, v.y, v.z])),
        Value::Vec4f(v) => (4, <[f32; 4]>::from(*v).to_vec()),
        Value::Vec4d(v) => (4, narrow(&<[f64; 4]>::from(*v))),
        Value::Vec4h(v) => (4, [v.x, v.y, v.z, v.w].map(|v| v.to_f32()).to_vec()),
        Value::Vec4i(v) => (4, whole(&[v.x, v.y, v.z, v.w])),
        other => (1, vec![number(other)? as f32]),
    })
}

/// The values of a list that some indices name; `None` where they name others, or where it is no list of numbers.
pub(super) fn picked(value: &Value, indices: &[i64]) -> Option<Value> {
    let (components, numbers) = floats(value)?;
    let mut all = Vec::with_capacity(indices.len() * components);
    for index in indices {
        let start = usize::try_from(*index).ok()?.checked_mul(components)?;
        all.extend(numbers.get(start..start.checked_add(components)?)?);
    }
    let cast = bytemuck::cast_slice::<f32, f32>(&all);
    Some(match components {
        1 => Value::FloatVec(cast.to_vec()),
        2 => Value::Vec2fVec(bytemuck::cast_slice(cast).to_vec()),
        3 => Value::Vec3fVec(bytemuck::cast_slice(cast).to_vec()),
        4 => Value::Vec4fVec(bytemuck::cast_slice(cast).to_vec()),
        _ => return None,
    })
}

/// Three numbers each.
pub(super) fn points(value: &Value) -> Option<Vec<[f32; 3]>> {
    let (components, numbers) = floats(value)?;
    let (points, _) = numbers.as_chunks::<3>();
    (components == 3).then(|| points.to_vec())
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/value.rs"]
mod tests;
