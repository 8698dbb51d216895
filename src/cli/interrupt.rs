//! Ctrl-C and its like: the first one ends the render and keeps the picture, the second one ends the
//! process.

use super::flags::EXIT_INTERRUPTED;
use crate::output::remove_unfinished;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::sync::atomic::{AtomicU8, Ordering};

/// Nothing to keep yet: an interrupt ends the process at once.
const AT_ONCE: u8 = 0;
/// A picture grows: an interrupt is kept for whoever asks.
const KEPT: u8 = 1;
/// Somebody has interrupted: the next one ends the process.
const INTERRUPTED: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(AT_ONCE);

/// Listens to SIGINT and SIGTERM from now on. (Not to SIGHUP: `nohup` has a say in that.)
///
/// # Errors
/// The system refuses.
pub fn listen() -> Result<(), String> {
    let refused = |error: std::io::Error| format!("cannot listen to Ctrl-C: {error}");
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(refused)?;
    std::thread::Builder::new()
        .name("signals".into())
        .spawn(move || {
            for _ in signals.forever() {
                if !ask_to_stop() {
                    remove_unfinished();
                    std::process::exit(i32::from(EXIT_INTERRUPTED));
                }
            }
        })
        .map_err(refused)?;
    Ok(())
}

/// From now on there is something to keep.
pub fn keep() {
    STATE.store(KEPT, Ordering::SeqCst);
}

/// Whether somebody has interrupted since [`keep`].
pub fn interrupted() -> bool {
    STATE.load(Ordering::SeqCst) == INTERRUPTED
}

/// Asks the render to stop and keep what there is; false if there is none, or it has been asked before.
fn ask_to_stop() -> bool {
    STATE
        .compare_exchange(KEPT, INTERRUPTED, Ordering::SeqCst, Ordering::SeqCst)
        .is_ok()
}

/// Whoever watched has gone: nobody is left to interrupt, so this does.
pub fn nobody_watches() {
    ask_to_stop();
}
