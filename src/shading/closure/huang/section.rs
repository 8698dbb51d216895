//! The elliptic section of a fibre: places on it, and directions across it (figure 5 of the paper).

use crate::math::sqr;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// An ellipse whose greater half axis is 1, seen from a direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    /// The lesser half axis.
    b: f32,
    /// Sine and cosine of the view's φ.
    view: Vec2,
    /// Half of the width that the view sees.
    radius: f32,
}

/// Cosine of the lean from across the fibre to along it.
pub(super) fn cos_theta(direction: Vec3) -> f32 {
    (sqr(direction.x) + sqr(direction.z)).sqrt()
}

/// Sine and cosine of that.
pub(super) fn lean(direction: Vec3) -> Vec2 {
    Vec2::new(direction.y, cos_theta(direction))
}

/// The angle φ of a direction.
pub(super) fn phi(direction: Vec3) -> f32 {
    direction.x.atan2(direction.z)
}

/// Whether a direction sees a facet and the mean normal.
pub(super) fn sees(direction: Vec3, mean: Vec3, facet: Vec3) -> bool {
    direction.dot(facet) > 0.0 && direction.dot(mean) > 0.0
}

impl Section {
    /// Of a lesser half axis, seen from a direction.
    pub fn new(b: f32, view: Vec3) -> Self {
        let cos = cos_theta(view);
        let view = match cos > 0.0 {
            true => Vec2::new(view.x, view.z) / cos,
            false => Vec2::Y,
        };
        let flatness = 1.0 - b * b;
        Self {
            b,
            view,
            radius: (1.0 - flatness * sqr(view.x)).max(0.0).sqrt(),
        }
    }

    fn is_round(&self) -> bool {
        self.b == 1.0
    }

    /// Half of the width that the view sees.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// φ of the view.
    pub fn phi_of_view(&self) -> f32 {
        match self.is_round() {
            true => 0.0,
            false => self.view.x.atan2(self.view.y),
        }
    }

    /// φ of a normal at γ, and what the paper reflects by it.
    pub fn phi_of(&self, gamma: f32) -> f32 {
        if self.is_round() {
            return gamma;
        }
        let (sin, cos) = gamma.sin_cos();
        (self.b * sin).atan2(cos)
    }

    /// γ of the place whose direction from the middle is φ.
    fn gamma_of(&self, phi: f32) -> f32 {
        if self.is_round() {
            return phi;
        }
        let (sin, cos) = phi.sin_cos();
        sin.atan2(self.b * cos)
    }

    /// Offset across the view of the place at φ.
    pub fn offset_at(&self, phi: f32) -> f32 {
        if self.is_round() {
            return -phi.sin();
        }
        let (sin, cos) = self.gamma_of(phi).sin_cos();
        self.b * self.view.x * cos - self.view.y * sin
    }

    /// γ of the place at an offset over the radius.
    pub fn gamma_at(&self, offset: f32) -> f32 {
        let offset = offset.clamp(-1.0, 1.0);
        if self.is_round() {
            return -offset.asin();
        }
        self.view.y.atan2(-self.b * self.view.x) - (-offset).acos()
    }

    /// How fast γ changes with the offset.
    pub fn gamma_by_offset(&self, gamma: f32) -> f32 {
        let (sin, cos) = gamma.sin_cos();
        let slope = match self.is_round() {
            true => cos,
            false => self.view.y * cos + self.b * self.view.x * sin,
        };
        if slope == 0.0 { 0.0 } else { 1.0 / slope }
    }

    /// The place at γ.
    fn place(&self, gamma: f32) -> Vec2 {
        let (sin, cos) = gamma.sin_cos();
        Vec2::new(sin, self.b * cos)
    }

    /// The normal at γ, tilted along the fibre.
    pub fn normal(&self, tilt: f32, gamma: f32) -> Vec3 {
        let (along, across) = tilt.sin_cos();
        let (sin, cos) = gamma.sin_cos();
        let around = match self.is_round() || cos.abs() < 1e-6 {
            true => Vec2::new(sin, cos),
            false => Vec2::new(self.b * sin, cos).normalize(),
        };
        Vec3::new(around.x * across, along, around.y * across)
    }

    /// Length of the ellipse by γ.
    pub fn arc(&self, gamma: f32) -> f32 {
        (1.0 - (1.0 - self.b * self.b) * sqr(gamma.sin()))
            .max(0.0)
            .sqrt()
    }

    /// The way across the section from where light has entered, in a direction of `phi`, to the place opposite of γ.
    pub fn first_way(&self, from: f32, phi: f32, opposite: f32) -> f32 {
        if self.is_round() {
            return -2.0 * (from - phi).cos();
        }
        self.place(from).distance(self.place(opposite + PI))
    }

    /// The way between two places, in a direction of `phi`.
    pub fn way(&self, from: f32, phi: f32, to: f32) -> f32 {
        if self.is_round() {
            return 2.0 * (phi - from).cos().abs();
        }
        self.place(from).distance(self.place(to))
    }
}
