use super::*;

/// What one thread has done in a loop is processor time of the process, to better than a tick of the kernel's.
#[test]
fn processor_time_is_that_of_the_work() {
    let before = processor_seconds();
    let mut sum = 0u64;
    while processor_seconds() - before < 0.002 {
        sum = std::hint::black_box(sum + 1);
    }
    assert!(sum > 0 && processor_seconds() - before >= 0.002);
}
