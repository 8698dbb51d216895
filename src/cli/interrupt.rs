//! Ctrl-C and its like: the first one ends the render and keeps the picture, the second one ends the
//! process; and how a process ends.

use super::exit::EXIT_INTERRUPTED;
use super::progress;
use crate::output::remove_unfinished;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::Duration;

/// Nothing to keep yet: an interrupt ends the process at once.
const AT_ONCE: u8 = 0;
/// A picture grows: an interrupt is kept for whoever asks.
const KEPT: u8 = 1;
/// Somebody has interrupted: the next one ends the process.
const INTERRUPTED: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(AT_ONCE);

/// So long may the system take to make a file before the process ends without it.
const PATIENCE: Duration = Duration::from_secs(1);

/// Listens to SIGINT and SIGTERM from now on. (Not to SIGHUP: `nohup` has a say in that.) `by_signal`: the process ends as
/// one that does not listen, so that a shell ends its loop, too.
///
/// # Errors
/// The system refuses.
pub fn listen(by_signal: bool) -> Result<(), String> {
    let refused = |error: std::io::Error| format!("cannot listen to Ctrl-C: {error}");
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(refused)?;
    std::thread::Builder::new()
        .name("signals".into())
        .spawn(move || {
            for signal in signals.forever() {
                if !ask_to_stop() {
                    if by_signal {
                        clean_up();
                        let _ = signal_hook::low_level::emulate_default_handler(signal);
                    }
                    leave_at_once(EXIT_INTERRUPTED);
                }
            }
        })
        .map_err(refused)?;
    Ok(())
}

/// Removes what is half written, and takes the bar off the terminal.
fn clean_up() {
    remove_unfinished(PATIENCE);
    progress::take_bar_off();
}

/// Ends the process while other threads are at work.
pub fn leave_at_once(code: u8) -> ! {
    clean_up();
    leave(code)
}

/// Ends the process without the exit handlers and destructors of libraries: those of Embree, oneTBB and OpenColorIO take away
/// what their threads work with. (Of 400 renders that were interrupted while Embree built, 22 ended by a signal of their own.)
/// What was printed has been flushed by whoever printed it.
pub fn leave(code: u8) -> ! {
    signal_hook::low_level::exit(i32::from(code))
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
