//! The Math node.

choice! {
    /// What the Math node does.
    #[allow(missing_docs, reason = "the names are Blender's")]
    Math {
        Add = "ADD",
        Subtract = "SUBTRACT",
        Multiply = "MULTIPLY",
        Divide = "DIVIDE",
        MultiplyAdd = "MULTIPLY_ADD",
        Power = "POWER",
        Logarithm = "LOGARITHM",
        Sqrt = "SQRT",
        InverseSqrt = "INVERSE_SQRT",
        Absolute = "ABSOLUTE",
        Exponent = "EXPONENT",
        Minimum = "MINIMUM",
        Maximum = "MAXIMUM",
        LessThan = "LESS_THAN",
        GreaterThan = "GREATER_THAN",
        Sign = "SIGN",
        Compare = "COMPARE",
        SmoothMin = "SMOOTH_MIN",
        SmoothMax = "SMOOTH_MAX",
        Round = "ROUND",
        Floor = "FLOOR",
        Ceil = "CEIL",
        Trunc = "TRUNC",
        Fract = "FRACT",
        Modulo = "MODULO",
        FlooredModulo = "FLOORED_MODULO",
        Wrap = "WRAP",
        Snap = "SNAP",
        PingPong = "PINGPONG",
        Sine = "SINE",
        Cosine = "COSINE",
        Tangent = "TANGENT",
        Sinh = "SINH",
        Cosh = "COSH",
        Tanh = "TANH",
        Arcsine = "ARCSINE",
        Arccosine = "ARCCOSINE",
        Arctangent = "ARCTANGENT",
        Arctan2 = "ARCTAN2",
        Radians = "RADIANS",
        Degrees = "DEGREES",
    }
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
    /// Whether the third number counts.
    #[inline]
    pub const fn takes_three(self) -> bool {
        matches!(
            self,
            Self::MultiplyAdd | Self::Compare | Self::SmoothMin | Self::SmoothMax | Self::Wrap
        )
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
    fn the_third_number_counts_where_it_is_said_to() {
        for &operation in Math::ALL {
            let of = |c| operation.of(1.5, 1.75, c).to_bits();
            let counts = [0.0, 0.5, 3.0]
                .map(of)
                .windows(2)
                .any(|two| two[0] != two[1]);
            assert_eq!(counts, operation.takes_three(), "{operation:?}");
        }
    }

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
