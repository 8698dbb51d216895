//! Ctrl-C: the first one ends the render and keeps the picture, the second one ends the process.

use super::flags::EXIT_INTERRUPTED;
use crate::output::remove_unfinished;
use std::sync::atomic::{AtomicU8, Ordering};

/// Nothing to keep yet: an interrupt ends the process at once.
const AT_ONCE: u8 = 0;
/// A picture grows: an interrupt is kept for whoever asks.
const KEPT: u8 = 1;
/// Somebody has interrupted: the next one ends the process.
const INTERRUPTED: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(AT_ONCE);

/// Listens to Ctrl-C from now on.
///
/// # Errors
/// The system refuses.
pub fn listen() -> Result<(), String> {
    ctrlc::set_handler(|| {
        if STATE
            .compare_exchange(KEPT, INTERRUPTED, Ordering::SeqCst, Ordering::SeqCst)
            .is_err()
        {
            remove_unfinished();
            std::process::exit(i32::from(EXIT_INTERRUPTED));
        }
    })
    .map_err(|error| format!("cannot listen to Ctrl-C: {error}"))
}

/// From now on there is something to keep.
pub fn keep() {
    STATE.store(KEPT, Ordering::SeqCst);
}

/// Whether Ctrl-C has come since [`keep`].
pub fn interrupted() -> bool {
    STATE.load(Ordering::SeqCst) == INTERRUPTED
}
