//! Sheen: a layer of fibres, as a linearly transformed cosine (Zeltner, Burley and Chiang, *Practical Multiple-Scattering Sheen
//! Using Linearly Transformed Cosines*, 2022).

use super::sheen_table::{A, ALBEDO, B, SIZE};
use super::{LobeSample, LobeValue};
use crate::math::{Frame, mix, sqr, warp};
use crate::shading::normal;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A layer of fibres.
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    /// Weight of the lobe times its albedo for this view.
    weight: Vec3,
    /// About the lobe's own normal, x toward the viewer.
    frame: Frame,
    a: f32,
    b: f32,
}

/// A cell of a table's axis, and where in it.
fn cell(x: f32) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0) * (SIZE - 1) as f32;
    let i = (x as usize).min(SIZE - 2);
    (i, x - i as f32)
}

fn read(table: &[[f32; SIZE]; SIZE], cos: (usize, f32), roughness: (usize, f32)) -> f32 {
    let row = |row: &[f32; SIZE]| mix(row[roughness.0], row[roughness.0 + 1], roughness.1);
    mix(row(&table[cos.0]), row(&table[cos.0 + 1]), cos.1)
}

impl Sheen {
    /// For a roughness of 0..=1, seen from `wo`; none where the fit has nothing.
    pub fn new(weight: Vec3, roughness: f32, normal: Vec3, wo: Vec3) -> Option<Self> {
        let (cos, roughness) = (cell(normal.dot(wo)), cell(roughness.clamp(1e-3, 1.0)));
        let albedo = read(&ALBEDO, cos, roughness);
        let (a, b) = (read(&A, cos, roughness), read(&B, cos, roughness));
        // Twice, as the first difference cancels where the view is near to the normal.
        let tangent = wo - normal * normal.dot(wo);
        let tangent = tangent - normal * normal.dot(tangent);
        (a.abs() >= 1e-5 && albedo >= 1e-5).then(|| Self {
            weight: weight * albedo,
            frame: Frame::from_normal_and_tangent(normal, tangent),
            a,
            b,
        })
    }

    /// Mean reflectance for this view.
    pub fn albedo(&self) -> Vec3 {
        self.weight
    }

    /// The same lobe with another weight.
    #[must_use]
    pub fn scaled(self, by: Vec3) -> Self {
        let weight = self.weight * by;
        Self { weight, ..self }
    }

    /// The lobe's own normal.
    pub fn normal(&self) -> Vec3 {
        self.frame.z
    }

    /// Value and density.
    pub fn evaluate(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        let local = self.frame.to_local(wi);
        if local.z <= 0.0 {
            return LobeValue::ZERO;
        }
        let length =
            sqr(self.a * local.x + self.b * local.z) + sqr(self.a * local.y) + sqr(local.z);
        let pdf = FRAC_1_PI * local.z * sqr(self.a / length);
        let mut value = self.weight * pdf;
        if self.frame.z != smooth {
            value *= normal::bump_shadowing(smooth, self.frame.z, wi);
        }
        LobeValue { value, pdf }
    }

    /// Draws a direction by its density.
    pub fn sample(&self, smooth: Vec3, u: Vec2) -> Option<LobeSample> {
        let cosine = warp::cosine_hemisphere(u);
        let local = Vec3::new(cosine.x - cosine.z * self.b, cosine.y, cosine.z * self.a);
        let wi = self.frame.to_world(local).try_normalize()?;
        let of = self.evaluate(smooth, wi);
        LobeSample::reflected(wi, of)
    }
}
