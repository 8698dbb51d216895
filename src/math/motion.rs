//! Transforms between steps of time, interpolated as Cycles and Embree do: translation, scale and skew linearly, rotation along
//! the shortest arc.

use glam::{DAffine3, DMat3, DQuat, DVec3};

/// A transform in parts: scale and skew first (an upper triangular matrix), then a rotation, then a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decomposed {
    /// Of unit length.
    pub rotation: DQuat,
    /// Along the axes.
    pub scale: DVec3,
    /// Of y along x, of z along x, of z along y.
    pub skew: DVec3,
    /// Where the origin comes to.
    pub translation: DVec3,
}

impl Decomposed {
    /// By Gram and Schmidt: the axes are made orthogonal one after another. A mirror is a scale by negative numbers.
    pub fn new(transform: &DAffine3) -> Self {
        let DMat3 {
            x_axis: x,
            y_axis: mut y,
            z_axis: mut z,
        } = transform.matrix3;
        let unit = |v: DVec3| v.try_normalize().unwrap_or(DVec3::ZERO);
        let mut scale = DVec3::X * x.length();
        let i = unit(x);
        let xy = i.dot(y);
        y -= i * xy;
        scale.y = y.length();
        let j = unit(y);
        let xz = i.dot(z);
        z -= i * xz;
        let yz = j.dot(z);
        z -= j * yz;
        scale.z = z.length();
        let mut axes = DMat3::from_cols(i, j, unit(z));
        let mut skew = DVec3::new(xy, xz, yz);
        if axes.determinant() < 0.0 {
            (axes, scale, skew) = (-axes, -scale, -skew);
        }
        Self {
            rotation: DQuat::from_mat3(&axes).normalize(),
            scale,
            skew,
            translation: transform.translation,
        }
    }

    /// The transform.
    pub fn to_affine(self) -> DAffine3 {
        let Self { scale, skew, .. } = self;
        let stretch = DMat3::from_cols(
            DVec3::X * scale.x,
            DVec3::new(skew.x, scale.y, 0.0),
            DVec3::new(skew.y, skew.z, scale.z),
        );
        DAffine3 {
            matrix3: DMat3::from_quat(self.rotation) * stretch,
            translation: self.translation,
        }
    }

    fn between(self, to: Self, share: f64) -> Self {
        Self {
            rotation: self.rotation.slerp(to.rotation, share),
            scale: self.scale.lerp(to.scale, share),
            skew: self.skew.lerp(to.skew, share),
            translation: self.translation.lerp(to.translation, share),
        }
    }
}

/// The parts of transforms at equal steps of time; from each to the next the rotation takes the shorter way.
pub fn decompose(steps: &[DAffine3]) -> Vec<Decomposed> {
    let mut parts: Vec<Decomposed> = steps.iter().map(Decomposed::new).collect();
    for i in 1..parts.len() {
        if parts[i - 1].rotation.dot(parts[i].rotation) < 0.0 {
            parts[i].rotation = -parts[i].rotation;
        }
        // What is pressed to a point has no rotation of its own.
        if parts[i].scale == DVec3::ZERO {
            parts[i].rotation = parts[i - 1].rotation;
        }
    }
    if let [first, second, ..] = &mut parts[..]
        && first.scale == DVec3::ZERO
    {
        first.rotation = second.rotation;
    }
    parts
}

/// The step before a time between 0 and 1, of some equal ones, and how far the time is on the way to the next.
pub fn step(time: f32, steps: usize) -> (usize, f32) {
    let last = steps.saturating_sub(1);
    let place = time * last as f32;
    let step = (place as usize).min(last.saturating_sub(1));
    (step, place - step as f32)
}

/// The transform at a time between 0 and 1; the identity where there is none.
pub fn at(parts: &[Decomposed], time: f32) -> DAffine3 {
    let (from, share) = step(time, parts.len());
    match (parts.get(from), parts.get(from + 1)) {
        (Some(a), Some(b)) => a.between(*b, f64::from(share)).to_affine(),
        (Some(a), None) => a.to_affine(),
        _ => DAffine3::IDENTITY,
    }
}

#[cfg(test)]
#[path = "../../tests/unit/math/motion.rs"]
mod tests;
