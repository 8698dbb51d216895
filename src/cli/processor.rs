//! Whether the running processor has what the program was built for.

/// What x86-64-v3 adds and programs use first: its name, and the bit of the second register of leaf 7 or the third of leaf 1.
#[cfg(any(test, target_feature = "avx2"))]
const NEEDED: [(&str, bool, u32); 3] = [("AVX2", true, 5), ("BMI2", true, 8), ("FMA", false, 12)];

/// What a processor lacks, by the registers that tell what it has.
#[cfg(any(test, target_feature = "avx2"))]
fn lacking(of_leaf_1: u32, of_leaf_7: u32) -> Vec<&'static str> {
    let lacks = |&(_, in_leaf_7, bit): &(_, bool, u32)| {
        let register = if in_leaf_7 { of_leaf_7 } else { of_leaf_1 };
        register >> bit & 1 == 0
    };
    let needed = NEEDED.iter().filter(|needed| lacks(needed));
    needed.map(|(name, ..)| *name).collect()
}

/// Says what the running processor lacks; whether it has all that the program was built for. Else it would end with an illegal
/// instruction somewhere.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
pub(super) fn suffices() -> bool {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    let lacking = lacking(__cpuid(1).ecx, __cpuid_count(7, 0).ebx);
    if !lacking.is_empty() {
        let lacking = lacking.join(", ");
        super::console::message(&format!(
            "sundog: this program was built for processors with {lacking}, which this one has not: build it here by `make build`"
        ));
    }
    lacking.is_empty()
}

/// Built for all.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub(super) fn suffices() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_processor_lacks_has_its_name() {
        // Leaves 1 and 7 of a Nehalem of 2008 and of a Haswell of 2013 (Intel's manual, vol. 2, CPUID).
        assert_eq!(lacking(0x0098_e3fd, 0), ["AVX2", "BMI2", "FMA"]);
        assert_eq!(lacking(0x7ffa_fbff, 0x0000_27ab), [""; 0]);
        assert_eq!(lacking(0x7ffa_fbff, 0x0000_27ab & !(1 << 8)), ["BMI2"]);
    }
}
