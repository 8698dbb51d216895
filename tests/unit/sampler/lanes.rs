use super::*;
use proptest::prelude::*;

/// Laine and Karras' hash of one word, step by step.
fn scrambled(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

proptest! {
    #[test]
    fn four_words_are_hashed_as_each_by_itself(x: [u32; 4], seeds: [u32; 4]) {
        prop_assert_eq!(mix32(Words::new(x)).to_array(), x.map(super::super::mix32));
        let all = owen_32(Words::new(x), Words::new(seeds)).to_array();
        let each = std::array::from_fn(|i| scrambled(x[i], seeds[i]));
        prop_assert_eq!(all, each);
    }

    #[test]
    fn digits_in_reverse_order_are_turned_round(x: [u32; 4]) {
        let each = x.map(|x| super::super::unit(x.reverse_bits()));
        prop_assert_eq!(units(Words::new(x)).to_array(), each);
    }
}
