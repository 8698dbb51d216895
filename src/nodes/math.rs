//! The Math node.

/// What the Math node does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are Blender's")]
pub enum Math {
    Add,
    Subtract,
    Multiply,
    Divide,
    MultiplyAdd,
    Power,
    Logarithm,
    Sqrt,
    InverseSqrt,
    Absolute,
    Exponent,
    Minimum,
    Maximum,
    LessThan,
    GreaterThan,
    Sign,
    Compare,
    SmoothMin,
    SmoothMax,
    Round,
    Floor,
    Ceil,
    Trunc,
    Fract,
    Modulo,
    FlooredModulo,
    Wrap,
    Snap,
    PingPong,
    Sine,
    Cosine,
    Tangent,
    Sinh,
    Cosh,
    Tanh,
    Arcsine,
    Arccosine,
    Arctangent,
    Arctan2,
    Radians,
    Degrees,
}

/// a / b, and 0 where b is 0.
#[inline]
pub fn divided(a: f32, b: f32) -> f32 {
    if b == 0.0 { 0.0 } else { a / b }
}

/// a to the power of b, and 0 where that is no finite real number by nature: roots of what is negative, powers of 0.
#[inline]
pub fn power(a: f32, b: f32) -> f32 {
    if a == 0.0 {
        f32::from(b == 0.0)
    } else if a < 0.0 && b != b.trunc() {
        0.0
    } else {
        a.powf(b)
    }
}

/// The remainder with the sign of a; 0 where b is 0.
#[inline]
pub fn modulo(a: f32, b: f32) -> f32 {
    if b == 0.0 { 0.0 } else { a % b }
}

/// Brought between `low` and `high` by steps of their distance.
#[inline]
pub fn wrapped(value: f32, high: f32, low: f32) -> f32 {
    let range = high - low;
    if range == 0.0 {
        low
    } else {
        value - range * ((value - low) / range).floor()
    }
}

/// The lesser, with a rounded corner where the two differ by less than `width`.
fn smooth_minimum(a: f32, b: f32, width: f32) -> f32 {
    if width == 0.0 {
        return a.min(b);
    }
    let near = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - near * near * near * width / 6.0
}

fn ping_pong(a: f32, scale: f32) -> f32 {
    if scale == 0.0 {
        return 0.0;
    }
    let turns = (a - scale) / (2.0 * scale);
    ((turns - turns.floor()) * 2.0 * scale - scale).abs()
}

fn sign(a: f32) -> f32 {
    if a == 0.0 { 0.0 } else { a.signum() }
}

impl Math {
    /// By Blender's identifier.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "ADD" => Self::Add,
            "SUBTRACT" => Self::Subtract,
            "MULTIPLY" => Self::Multiply,
            "DIVIDE" => Self::Divide,
            "MULTIPLY_ADD" => Self::MultiplyAdd,
            "POWER" => Self::Power,
            "LOGARITHM" => Self::Logarithm,
            "SQRT" => Self::Sqrt,
            "INVERSE_SQRT" => Self::InverseSqrt,
            "ABSOLUTE" => Self::Absolute,
            "EXPONENT" => Self::Exponent,
            "MINIMUM" => Self::Minimum,
            "MAXIMUM" => Self::Maximum,
            "LESS_THAN" => Self::LessThan,
            "GREATER_THAN" => Self::GreaterThan,
            "SIGN" => Self::Sign,
            "COMPARE" => Self::Compare,
            "SMOOTH_MIN" => Self::SmoothMin,
            "SMOOTH_MAX" => Self::SmoothMax,
            "ROUND" => Self::Round,
            "FLOOR" => Self::Floor,
            "CEIL" => Self::Ceil,
            "TRUNC" => Self::Trunc,
            "FRACT" => Self::Fract,
            "MODULO" => Self::Modulo,
            "FLOORED_MODULO" => Self::FlooredModulo,
            "WRAP" => Self::Wrap,
            "SNAP" => Self::Snap,
            "PINGPONG" => Self::PingPong,
            "SINE" => Self::Sine,
            "COSINE" => Self::Cosine,
            "TANGENT" => Self::Tangent,
            "SINH" => Self::Sinh,
            "COSH" => Self::Cosh,
            "TANH" => Self::Tanh,
            "ARCSINE" => Self::Arcsine,
            "ARCCOSINE" => Self::Arccosine,
            "ARCTANGENT" => Self::Arctangent,
            "ARCTAN2" => Self::Arctan2,
            "RADIANS" => Self::Radians,
            "DEGREES" => Self::Degrees,
            _ => return None,
        })
    }

    /// The result.
    pub fn of(self, a: f32, b: f32, c: f32) -> f32 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => divided(a, b),
            Self::MultiplyAdd => a * b + c,
            Self::Power => power(a, b),
            Self::Logarithm if a <= 0.0 || b <= 0.0 => 0.0,
            Self::Logarithm => divided(a.ln(), b.ln()),
            Self::Sqrt => a.max(0.0).sqrt(),
            Self::InverseSqrt if a <= 0.0 => 0.0,
            Self::InverseSqrt => 1.0 / a.sqrt(),
            Self::Absolute => a.abs(),
            Self::Exponent => a.exp(),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::LessThan => f32::from(a < b),
            Self::GreaterThan => f32::from(a > b),
            Self::Sign => sign(a),
            Self::Compare => f32::from(a == b || (a - b).abs() <= c.max(f32::EPSILON)),
            Self::SmoothMin => smooth_minimum(a, b, c),
            Self::SmoothMax => -smooth_minimum(-a, -b, c),
            Self::Round => (a + 0.5).floor(),
            Self::Floor => a.floor(),
            Self::Ceil => a.ceil(),
            Self::Trunc => a.trunc(),
            Self::Fract => a - a.floor(),
            Self::Modulo => modulo(a, b),
            Self::FlooredModulo if b == 0.0 => 0.0,
            Self::FlooredModulo => a - (a / b).floor() * b,
            Self::Wrap => wrapped(a, b, c),
            Self::Snap => divided(a, b).floor() * b,
            Self::PingPong => ping_pong(a, b),
            Self::Sine => a.sin(),
            Self::Cosine => a.cos(),
            Self::Tangent => a.tan(),
            Self::Sinh => a.sinh(),
            Self::Cosh => a.cosh(),
            Self::Tanh => a.tanh(),
            Self::Arcsine => a.clamp(-1.0, 1.0).asin(),
            Self::Arccosine => a.clamp(-1.0, 1.0).acos(),
            Self::Arctangent => a.atan(),
            Self::Arctan2 => a.atan2(b),
            Self::Radians => a.to_radians(),
            Self::Degrees => a.to_degrees(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Math;

    #[test]
    fn what_has_no_answer_is_what_blender_says() {
        let of = |name, a, b, c| Math::from_name(name).unwrap().of(a, b, c);
        assert_eq!(of("DIVIDE", 1.0, 0.0, 0.0), 0.0);
        assert_eq!(of("POWER", -2.0, 0.5, 0.0), 0.0);
        assert_eq!(of("POWER", 0.0, -1.0, 0.0), 0.0);
        assert_eq!(of("LOGARITHM", 8.0, 2.0, 0.0), 3.0);
        assert_eq!(of("LOGARITHM", -1.0, 2.0, 0.0), 0.0);
        assert_eq!(of("MODULO", -5.5, 2.0, 0.0), -1.5);
        assert_eq!(of("FLOORED_MODULO", -5.5, 2.0, 0.0), 0.5);
        assert_eq!(of("WRAP", 3.5, 1.0, -1.0), -0.5);
        assert_eq!(of("PINGPONG", 2.75, 1.0, 0.0), 0.75);
        assert_eq!(of("SMOOTH_MIN", 1.0, 1.0, 0.6), 0.9);
        assert_eq!(of("COMPARE", 1.0, 1.2, 0.25), 1.0);
        assert_eq!(of("SIGN", -0.0, 0.0, 0.0), 0.0);
        assert_eq!(of("ROUND", -0.5, 0.0, 0.0), 0.0);
        assert_eq!(Math::from_name("WHAT"), None);
    }
}
