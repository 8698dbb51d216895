//! The end of a process whose memory is used up.

use super::exit::EXIT_ERROR;
use super::interrupt;
use rustix::process::{Resource, getrlimit};
use std::fmt::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Whether a program reads the standard output as lines of JSON.
static TELLS_JSON: AtomicBool = AtomicBool::new(false);

/// From now on the end is told as a line of JSON, too.
pub fn tell_json() {
    TELLS_JSON.store(true, Ordering::Relaxed);
}

/// From now on a thread that cannot begin ends the process with the same sentence: the standard library panics there, before
/// any of the program's code runs.
pub fn listen_to_threads() {
    // What a thread's stack for signals takes, about.
    const SIGNAL_STACK: usize = 8192;
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let message = info.payload().downcast_ref::<String>();
        if message.is_some_and(|m| m.starts_with("failed to allocate an alternative stack")) {
            used_up(SIGNAL_STACK);
        }
        before(info);
    }));
}

/// A text of bounded length that needs no memory.
struct Short {
    bytes: [u8; 512],
    length: usize,
}

impl Write for Short {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let end = self.length + text.len();
        let place = self
            .bytes
            .get_mut(self.length..end)
            .ok_or(std::fmt::Error)?;
        place.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}

/// Ends the process with a sentence: so many bytes more could not be had. Takes no memory itself.
pub fn used_up(bytes: usize) -> ! {
    // Another thread, or what is called here after all.
    static SAID: AtomicBool = AtomicBool::new(false);
    if SAID.swap(true, Ordering::SeqCst) {
        std::thread::sleep(Duration::from_secs(2));
        interrupt::leave(EXIT_ERROR);
    }
    let say = |to_programs: bool| {
        let mut text = Short {
            bytes: [0; 512],
            length: 0,
        };
        let _ = text.write_str(if to_programs {
            r#"{"event":"error","message":""#
        } else {
            "sundog: "
        });
        let _ = write!(
            text,
            "there is not enough memory: {} KiB more could not be had",
            bytes.div_ceil(1024)
        );
        for (resource, flag) in [(Resource::As, "-v"), (Resource::Data, "-d")] {
            if let Some(limit) = getrlimit(resource).current {
                let limit = limit >> 20;
                let _ = write!(
                    text,
                    ", the limit of the process (ulimit {flag}) is {limit} MiB"
                );
            }
        }
        let _ = text.write_str("; choose a smaller picture or scene, or allow it more");
        let _ = text.write_str(if to_programs { "\"}\n" } else { "\n" });
        let text = text.bytes.get(..text.length).unwrap_or_default();
        if to_programs {
            let _ = rustix::io::write(std::io::stdout(), text);
        } else {
            let _ = rustix::io::write(std::io::stderr(), text);
        }
    };
    if TELLS_JSON.load(Ordering::Relaxed) {
        say(true);
    }
    super::progress::take_bar_off();
    say(false);
    interrupt::leave_at_once(EXIT_ERROR)
}
