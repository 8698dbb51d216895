//! How the Mix node blends colours.

use super::color::{from_hsv, to_hsv};
use glam::Vec3;

choice! {
    /// Blend modes of the Mix node.
    #[allow(missing_docs, reason = "the names are Blender's")]
    BlendMode {
        Mix = "MIX",
        Darken = "DARKEN",
        Multiply = "MULTIPLY",
        Burn = "BURN",
        Lighten = "LIGHTEN",
        Screen = "SCREEN",
        Dodge = "DODGE",
        Add = "ADD",
        Overlay = "OVERLAY",
        SoftLight = "SOFT_LIGHT",
        LinearLight = "LINEAR_LIGHT",
        Difference = "DIFFERENCE",
        Exclusion = "EXCLUSION",
        Subtract = "SUBTRACT",
        Divide = "DIVIDE",
        Hue = "HUE",
        Saturation = "SATURATION",
        Color = "COLOR",
        Value = "VALUE",
    }
}

fn each(a: Vec3, b: Vec3, of: impl Fn(f32, f32) -> f32) -> Vec3 {
    Vec3::new(of(a.x, b.x), of(a.y, b.y), of(a.z, b.z))
}

fn lerp(a: Vec3, b: Vec3, t: f32) -> Vec3 {
    a * (1.0 - t) + b * t
}

impl BlendMode {
    /// B blended over A by a factor.
    pub fn of(self, t: f32, a: Vec3, b: Vec3) -> Vec3 {
        let rest = 1.0 - t;
        match self {
            Self::Mix => lerp(a, b, t),
            Self::Darken => lerp(a, a.min(b), t),
            Self::Multiply => lerp(a, a * b, t),
            Self::Lighten => lerp(a, a.max(b), t),
            Self::Add => lerp(a, a + b, t),
            Self::Difference => lerp(a, (a - b).abs(), t),
            Self::Exclusion => lerp(a, a + b - a * b * 2.0, t).max(Vec3::ZERO),
            Self::Subtract => lerp(a, a - b, t),
            Self::Screen => 1.0 - (rest + (1.0 - b) * t) * (1.0 - a),
            Self::LinearLight => a + (b * 2.0 - 1.0) * t,
            Self::SoftLight => {
                let screen = 1.0 - (1.0 - b) * (1.0 - a);
                a * rest + ((1.0 - a) * b * a + a * screen) * t
            }
            Self::Divide => each(a, b, |a, b| if b == 0.0 { a } else { rest * a + t * a / b }),
            Self::Overlay => each(a, b, |a, b| {
                if a < 0.5 {
                    a * (rest + 2.0 * t * b)
                } else {
                    1.0 - (rest + 2.0 * t * (1.0 - b)) * (1.0 - a)
                }
            }),
            Self::Burn => each(a, b, |a, b| {
                let by = rest + t * b;
                if by <= 0.0 {
                    0.0
                } else {
                    (1.0 - (1.0 - a) / by).clamp(0.0, 1.0)
                }
            }),
            Self::Dodge => each(a, b, |a, b| {
                let by = 1.0 - t * b;
                if a == 0.0 {
                    0.0
                } else if by <= 0.0 {
                    1.0
                } else {
                    (a / by).min(1.0)
                }
            }),
            Self::Hue | Self::Saturation | Self::Color | Self::Value => self.of_hsv(t, a, b),
        }
    }

    /// The modes that count in hue, saturation and value. What is grey has no hue to give.
    fn of_hsv(self, t: f32, a: Vec3, b: Vec3) -> Vec3 {
        let (mut mixed, other) = (to_hsv(a), to_hsv(b));
        let rest = 1.0 - t;
        match self {
            Self::Saturation if mixed.y == 0.0 => a,
            Self::Saturation => {
                mixed.y = rest * mixed.y + t * other.y;
                from_hsv(mixed)
            }
            Self::Value => {
                mixed.z = rest * mixed.z + t * other.z;
                from_hsv(mixed)
            }
            _ if other.y == 0.0 => a,
            _ => {
                mixed.x = other.x;
                if self == Self::Color {
                    mixed.y = other.y;
                }
                lerp(a, from_hsv(mixed), t)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_modes_are_as_in_blender() {
        let (a, b) = (Vec3::new(0.2, 0.6, 0.9), Vec3::new(0.5, 0.3, 0.0));
        let wanted = [
            ("MIX", [0.35, 0.45, 0.45]),
            ("DARKEN", [0.2, 0.45, 0.45]),
            ("MULTIPLY", [0.15, 0.39, 0.45]),
            ("LIGHTEN", [0.35, 0.6, 0.9]),
            ("SCREEN", [0.4, 0.66, 0.9]),
            ("ADD", [0.45, 0.75, 0.9]),
            ("OVERLAY", [0.2, 0.52, 0.85]),
            ("SUBTRACT", [-0.05, 0.45, 0.9]),
            ("DIVIDE", [0.3, 1.3, 0.9]),
            ("DIFFERENCE", [0.25, 0.45, 0.9]),
            ("LINEAR_LIGHT", [0.2, 0.4, 0.4]),
            ("DODGE", [0.266_667, 0.705_882, 0.9]),
            ("BURN", [0.0, 0.384_615, 0.8]),
        ];
        for (name, wanted) in wanted {
            let found = BlendMode::from_name(name).unwrap().of(0.5, a, b);
            assert!(
                (found - Vec3::from(wanted)).abs().max_element() < 1e-5,
                "{name} {found}"
            );
        }
        let grey = Vec3::splat(0.5);
        assert_eq!(BlendMode::Hue.of(1.0, a, grey), a);
        assert!((BlendMode::Value.of(1.0, a, grey).max_element() - 0.5).abs() < 1e-6);
        assert!((BlendMode::Color.of(1.0, grey, b).max_element() - 0.5).abs() < 1e-6);
    }
}
