use super::*;
use rayon::prelude::*;

/// What was added twice is always told, by any number of threads; of what was added once, as much as shares its bit by chance.
#[test]
fn what_was_added_twice_is_told() {
    const COUNT: u64 = 100_000;
    let seen = Seen::new(2 * COUNT as usize);
    (0..COUNT)
        .into_par_iter()
        .for_each(|number| seen.add(mixed(number)));
    (0..COUNT / 2)
        .into_par_iter()
        .for_each(|number| seen.add(mixed(number)));
    assert!((0..COUNT / 2).all(|number| seen.was_twice(mixed(number))));
    let wrong = (COUNT / 2..COUNT).filter(|&number| seen.was_twice(mixed(number)));
    let wrong = wrong.count() as f64;
    // 2¹⁶ words. A shared bit tells of two at once, so that the variance is at most twice that of Poisson's law.
    let bits = f64::from(1 << 16) * 64.0;
    let expected = (COUNT / 2) as f64 * (1.0 - (-(COUNT as f64) / bits).exp());
    assert!((wrong - expected).abs() < 5.0 * (2.0 * expected).sqrt());
}
