//! The Vector Math node.

use super::{CyclesVersion, math};
use glam::Vec3;

choice! {
    /// What the Vector Math node does.
    #[allow(missing_docs, reason = "the names are Blender's")]
    VectorMath {
        Add = "ADD",
        Subtract = "SUBTRACT",
        Multiply = "MULTIPLY",
        Divide = "DIVIDE",
        MultiplyAdd = "MULTIPLY_ADD",
        CrossProduct = "CROSS_PRODUCT",
        Project = "PROJECT",
        Reflect = "REFLECT",
        Refract = "REFRACT",
        FaceForward = "FACEFORWARD",
        DotProduct = "DOT_PRODUCT",
        Distance = "DISTANCE",
        Length = "LENGTH",
        Scale = "SCALE",
        Normalize = "NORMALIZE",
        Absolute = "ABSOLUTE",
        Power = "POWER",
        Sign = "SIGN",
        Minimum = "MINIMUM",
        Maximum = "MAXIMUM",
        Floor = "FLOOR",
        Ceil = "CEIL",
        Fraction = "FRACTION",
        Modulo = "MODULO",
        ModuloByQuotient = "MODULO_BY_QUOTIENT",
        Wrap = "WRAP",
        Snap = "SNAP",
        Round = "ROUND",
        Sine = "SINE",
        Cosine = "COSINE",
        Tangent = "TANGENT",
    }
}

/// Of each of the three numbers.
fn each(a: Vec3, b: Vec3, of: impl Fn(f32, f32) -> f32) -> Vec3 {
    Vec3::new(of(a.x, b.x), of(a.y, b.y), of(a.z, b.z))
}

/// a / b in each number, and 0 where b is 0.
pub fn divided(a: Vec3, b: Vec3) -> Vec3 {
    each(a, b, math::divided)
}

impl VectorMath {
    /// The operation of a version: from 5.0 on Cycles finds remainders by the rounded quotient.
    pub fn of_version(self, version: CyclesVersion) -> Self {
        match self {
            Self::Modulo if version >= CyclesVersion::new(5, 0) => Self::ModuloByQuotient,
            other => other,
        }
    }

    /// The vector and the number that come out; one of them is 0, as Blender's node has one output at a time.
    pub fn of(self, a: Vec3, b: Vec3, c: Vec3, scale: f32) -> (Vec3, f32) {
        let vector = match self {
            Self::DotProduct => return (Vec3::ZERO, a.dot(b)),
            Self::Distance => return (Vec3::ZERO, a.distance(b)),
            Self::Length => return (Vec3::ZERO, a.length()),
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => divided(a, b),
            Self::MultiplyAdd => a * b + c,
            Self::CrossProduct => a.cross(b),
            Self::Project => b * math::divided(a.dot(b), b.length_squared()),
            Self::Reflect => {
                let n = b.normalize_or_zero();
                a - n * (2.0 * n.dot(a))
            }
            Self::Refract => {
                let n = b.normalize_or_zero();
                let cos = n.dot(a);
                let k = 1.0 - scale * scale * (1.0 - cos * cos);
                if k < 0.0 {
                    Vec3::ZERO
                } else {
                    a * scale - n * (scale * cos + k.sqrt())
                }
            }
            Self::FaceForward if c.dot(b) < 0.0 => a,
            Self::FaceForward => -a,
            Self::Scale => a * scale,
            Self::Normalize => a.normalize_or_zero(),
            Self::Absolute => a.abs(),
            Self::Power => each(a, b, math::power),
            Self::Sign => each(a, a, |v, _| math::Math::Sign.of(v, 0.0, 0.0)),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::Floor => a.floor(),
            Self::Ceil => a.ceil(),
            Self::Fraction => a - a.floor(),
            Self::Modulo => each(a, b, math::modulo),
            Self::ModuloByQuotient => each(a, b, |a, b| {
                if b == 0.0 {
                    0.0
                } else {
                    a - (a / b).trunc() * b
                }
            }),
            Self::Wrap => Vec3::new(
                math::wrapped(a.x, b.x, c.x),
                math::wrapped(a.y, b.y, c.y),
                math::wrapped(a.z, b.z, c.z),
            ),
            Self::Snap => divided(a, b).floor() * b,
            Self::Round => (a + 0.5).floor(),
            Self::Sine => each(a, a, |v, _| v.sin()),
            Self::Cosine => each(a, a, |v, _| v.cos()),
            Self::Tangent => each(a, a, |v, _| v.tan()),
        };
        (vector, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_calculated_as_in_blender() {
        let of = |name, a, b, c, s| VectorMath::from_name(name).unwrap().of(a, b, c, s);
        let (x, y) = (Vec3::X, Vec3::Y);
        assert_eq!(of("CROSS_PRODUCT", x, y, y, 0.0).0, Vec3::Z);
        assert_eq!(of("DOT_PRODUCT", x + y, y, y, 0.0).1, 1.0);
        assert_eq!(of("PROJECT", x + y, y * 3.0, y, 0.0).0, y);
        assert_eq!(of("PROJECT", x, Vec3::ZERO, y, 0.0).0, Vec3::ZERO);
        assert_eq!(of("REFLECT", x - y, y * 2.0, y, 0.0).0, x + y);
        assert_eq!(of("REFRACT", -y, y, y, 0.7).0, -y);
        assert_eq!(of("FACEFORWARD", x, y, -y, 0.0).0, x);
        assert_eq!(of("MODULO", -x * 1.5, x, y, 0.0).0.x, -0.5);
        // The quotient of 32 bits is 3, although 3 · 0.1 is more than 0.3.
        let remainder = |version| {
            let modulo = VectorMath::Modulo.of_version(version);
            modulo.of(x * 0.3, x * 0.1, y, 0.0).0
        };
        let (old, new) = (CyclesVersion::new(4, 5), CyclesVersion::new(5, 0));
        assert_eq!(remainder(old).x, 0.3 % 0.1);
        assert_eq!(remainder(new).x, 0.3 - 3.0 * 0.1);
        assert_ne!(remainder(old).x, remainder(new).x);
        assert_eq!(remainder(new).y, 0.0);
    }
}
