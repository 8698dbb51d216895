//! Blender's Gradient Texture.

use std::f32::consts::TAU;

use glam::Vec3;

choice! {
    /// The gradient's form.
    GradientType {
        /// X.
        Linear = "LINEAR",
        /// The square of X.
        Quadratic = "QUADRATIC",
        /// X with soft ends.
        Easing = "EASING",
        /// The mean of X and Y.
        Diagonal = "DIAGONAL",
        /// From 1 at the origin to 0 at distance 1.
        Spherical = "SPHERICAL",
        /// The square of that.
        QuadraticSphere = "QUADRATIC_SPHERE",
        /// The angle about Z.
        Radial = "RADIAL",
    }
}

/// The node's factor, 0 to 1; its colour is that grey.
pub fn gradient(gradient_type: GradientType, vector: Vec3) -> f32 {
    let Vec3 { x, y, .. } = vector;
    // Slightly less than 1, so that unit vectors give zero whatever their rounding.
    let sphere = || (0.999_999 - vector.length()).max(0.0);
    let value = match gradient_type {
        GradientType::Linear => x,
        GradientType::Quadratic => {
            let x = x.max(0.0);
            x * x
        }
        GradientType::Easing => super::smoothstep(x),
        GradientType::Diagonal => (x + y) * 0.5,
        GradientType::Spherical => sphere(),
        GradientType::QuadraticSphere => {
            let value = sphere();
            value * value
        }
        GradientType::Radial => y.atan2(x) / TAU + 0.5,
    };
    value.clamp(0.0, 1.0)
}
