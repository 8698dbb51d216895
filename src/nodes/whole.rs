//! The nodes Integer Math and Boolean Math, which Blender's shaders have from 5.3 on.

choice! {
    /// What the Integer Math node does.
    #[allow(missing_docs, reason = "the names are Blender's")]
    IntegerMath {
        Add = "ADD",
        Subtract = "SUBTRACT",
        Multiply = "MULTIPLY",
        Divide = "DIVIDE",
        MultiplyAdd = "MULTIPLY_ADD",
        Absolute = "ABSOLUTE",
        Negate = "NEGATE",
        Power = "POWER",
        Minimum = "MINIMUM",
        Maximum = "MAXIMUM",
        Sign = "SIGN",
        DivideRound = "DIVIDE_ROUND",
        DivideFloor = "DIVIDE_FLOOR",
        DivideCeil = "DIVIDE_CEIL",
        FlooredModulo = "FLOORED_MODULO",
        Modulo = "MODULO",
        GreatestCommonDivisor = "GCD",
        LeastCommonMultiple = "LCM",
    }
}

choice! {
    /// What the Boolean Math node does.
    #[allow(missing_docs, reason = "the names are Blender's")]
    BooleanMath {
        And = "AND",
        Or = "OR",
        Not = "NOT",
        NotAnd = "NAND",
        Nor = "NOR",
        Equal = "XNOR",
        NotEqual = "XOR",
        Imply = "IMPLY",
        Subtract = "NIMPLY",
    }
}

/// A number as sockets for whole ones take it: what stands after the point is cut off.
#[inline]
pub fn whole(number: f32) -> i32 {
    number as i32
}

/// b times itself, `exponent` times; what leaves 32 bits is lost. Below 0 it is the inverse, cut to a whole number.
fn power(base: i32, exponent: i32) -> i32 {
    match (base, u32::try_from(exponent)) {
        (_, Ok(exponent)) => base.wrapping_pow(exponent),
        (1, _) => 1,
        (-1, _) => 1 - 2 * (exponent & 1),
        _ => 0,
    }
}

/// The greatest number that divides both, by Euclid.
fn common_divisor(a: i32, b: i32) -> i32 {
    let (mut a, mut b) = (a.wrapping_abs(), b.wrapping_abs());
    while b != 0 {
        (a, b) = (b, a.wrapping_rem(b));
    }
    a
}

/// The greatest whole number that is not above a / b.
fn floored(a: i32, b: i32) -> i32 {
    let down = a.wrapping_rem(b) != 0 && (a < 0) != (b < 0);
    a.wrapping_div(b).wrapping_sub(i32::from(down))
}

/// The whole number nearest to a / b; halves go away from 0.
fn rounded(a: i32, b: i32) -> i32 {
    let (size, by) = (i64::from(a).abs(), i64::from(b).abs());
    let nearest = (2 * size + by) / (2 * by);
    let negative = (a < 0) != (b < 0);
    (if negative { -nearest } else { nearest }) as i32
}

impl IntegerMath {
    /// The result. What leaves 32 bits is lost; a division by 0 gives 0.
    pub fn of(self, a: i32, b: i32, c: i32) -> i32 {
        let divides = matches!(
            self,
            Self::Divide
                | Self::DivideRound
                | Self::DivideFloor
                | Self::DivideCeil
                | Self::FlooredModulo
                | Self::Modulo
        );
        if divides && b == 0 {
            return 0;
        }
        match self {
            Self::Add => a.wrapping_add(b),
            Self::Subtract => a.wrapping_sub(b),
            Self::Multiply => a.wrapping_mul(b),
            Self::Divide => a.wrapping_div(b),
            Self::MultiplyAdd => a.wrapping_mul(b).wrapping_add(c),
            Self::Absolute => a.wrapping_abs(),
            Self::Negate => a.wrapping_neg(),
            Self::Power => power(a, b),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::Sign => a.signum(),
            Self::DivideRound => rounded(a, b),
            Self::DivideFloor => floored(a, b),
            Self::DivideCeil => floored(a, b.wrapping_neg()).wrapping_neg(),
            Self::FlooredModulo => a.wrapping_rem(b).wrapping_add(b).wrapping_rem(b),
            Self::Modulo => a.wrapping_rem(b),
            Self::GreatestCommonDivisor => common_divisor(a, b),
            Self::LeastCommonMultiple => match common_divisor(a, b) {
                0 => 0,
                divisor => a.wrapping_div(divisor).wrapping_mul(b).wrapping_abs(),
            },
        }
    }
}

impl BooleanMath {
    /// The result.
    pub fn of(self, a: bool, b: bool) -> bool {
        match self {
            Self::And => a && b,
            Self::Or => a || b,
            Self::Not => !a,
            Self::NotAnd => !(a && b),
            Self::Nor => !(a || b),
            Self::Equal => a == b,
            Self::NotEqual => a != b,
            Self::Imply => !a || b,
            Self::Subtract => a && !b,
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/nodes/whole.rs"]
mod tests;
