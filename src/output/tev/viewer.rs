//! The picture in the image viewer tev while it grows.
//!
//! A thread of its own connects and sends. The render only ever leaves a picture for it, and only when it
//! has nothing left to send: a viewer that is slow sees fewer pictures, one that is not there costs a warning.

use crate::film::Bands;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// At least this long between two pictures.
const SHORTEST: Duration = Duration::from_millis(250);
/// And so long for each of its pixels. (Making one takes 30 instructions and sending it a copy of 16 bytes by
/// the system, about 15 ns: 3 % of one thread at most.)
const REST: Duration = Duration::from_nanos(500);
/// So long may a viewer take to accept a connection, and to take more bytes.
const PATIENCE: Duration = Duration::from_secs(5);
/// Bytes sent at a time.
const PIECE: usize = 1 << 16;
/// So many packets of the last picture may wait: not a second copy of all of it.
const AHEAD: usize = 4;

/// What the render and the sending thread share.
#[derive(Default)]
struct Post {
    /// To be sent, in this order; the first one stays here until it is.
    packets: VecDeque<Arc<Vec<u8>>>,
    /// Grows with every step forward.
    steps: u64,
    /// No more will come.
    over: bool,
    /// Why nothing is sent any more.
    failure: Option<String>,
}

struct Shared {
    post: Mutex<Post>,
    changed: Condvar,
    patience: Duration,
}

impl Shared {
    fn post(&self) -> MutexGuard<'_, Post> {
        self.post.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, post: MutexGuard<'a, Post>) -> MutexGuard<'a, Post> {
        self.changed
            .wait(post)
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves a packet; false if nobody sends it.
    fn leave(&self, packet: Vec<u8>) -> bool {
        let mut post = self.post();
        post.packets.push_back(Arc::new(packet));
        self.changed.notify_all();
        post.failure.is_none()
    }

    /// Waits until at most so many packets are left, as long as there are steps forward.
    fn settle(&self, most: usize) {
        let mut post = self.post();
        while post.packets.len() > most && post.failure.is_none() {
            let before = post.steps;
            // The sending thread gives up after its own patience, except where the system does not even
            // find the address.
            let (next, waited) = self
                .changed
                .wait_timeout(post, 2 * self.patience)
                .unwrap_or_else(PoisonError::into_inner);
            post = next;
            if waited.timed_out() && post.steps == before && post.failure.is_none() {
                post.failure = Some("it does not answer".into());
            }
        }
    }

    fn step(&self) {
        self.post().steps += 1;
        self.changed.notify_all();
    }

    /// The sending thread.
    fn send_all(&self, address: &str) -> io::Result<()> {
        let mut stream = connect(address, self.patience)?;
        self.step();
        loop {
            let packet = {
                let mut post = self.post();
                loop {
                    match post.packets.front() {
                        Some(packet) => break packet.clone(),
                        None if post.over => return Ok(()),
                        None => post = self.wait(post),
                    }
                }
            };
            for piece in packet.chunks(PIECE) {
                stream.write_all(piece)?;
                self.step();
            }
            self.post().packets.pop_front();
            self.changed.notify_all();
        }
    }
}

fn connect(address: &str, patience: Duration) -> io::Result<TcpStream> {
    let mut refused = io::Error::new(ErrorKind::NotFound, "there is no such address");
    for place in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&place, patience) {
            Ok(stream) => {
                stream.set_write_timeout(Some(patience))?;
                return Ok(stream);
            }
            Err(error) => refused = error,
        }
    }
    Err(refused)
}

/// What keeps a viewer from being told, in words that do not depend on the system.
fn reason(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::ConnectionRefused => "nobody listens there".into(),
        ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted | ErrorKind::BrokenPipe => {
            "it has gone away".into()
        }
        ErrorKind::WouldBlock | ErrorKind::TimedOut => "it does not answer".into(),
        _ => {
            let text = error.to_string();
            text.split(" (os error").next().unwrap_or_default().into()
        }
    }
}

/// When the next picture is due.
struct Timing {
    due: Instant,
    /// A failure has been told.
    told: bool,
}

/// A viewer that shows a picture.
pub struct Viewer {
    address: String,
    image: String,
    shared: Arc<Shared>,
    timing: Mutex<Timing>,
}

impl Viewer {
    /// Begins to connect, and makes an image of this name and size with room for all these layers. Waits for
    /// nothing.
    pub fn open(address: &str, image: &str, size: (u32, u32), layers: &[(String, String)]) -> Self {
        Self::patient(address, image, size, layers, PATIENCE)
    }

    /// The same for a viewer that may take this long.
    fn patient(
        address: &str,
        image: &str,
        size: (u32, u32),
        layers: &[(String, String)],
        patience: Duration,
    ) -> Self {
        let layers = layers.iter();
        let layers = layers.map(|(name, channels)| (&**name, &**channels));
        let shared = Arc::new(Shared {
            post: Mutex::default(),
            changed: Condvar::new(),
            patience,
        });
        shared.leave(super::create(image, size, layers));
        let viewer = Self {
            address: address.into(),
            image: image.into(),
            shared: shared.clone(),
            timing: Mutex::new(Timing {
                due: Instant::now(),
                told: false,
            }),
        };
        let address = address.to_owned();
        let sender = shared.clone();
        let spawned = std::thread::Builder::new()
            .name("tev".into())
            .spawn(move || {
                let failed = sender.send_all(&address).err();
                let mut post = sender.post();
                post.failure = post.failure.take().or(failed.as_ref().map(reason));
                post.packets.clear();
                sender.changed.notify_all();
            });
        if let Err(error) = spawned {
            shared.post().failure = Some(reason(&error));
        }
        viewer
    }

    fn timing(&self) -> MutexGuard<'_, Timing> {
        self.timing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether it is time for a picture and all there was is sent. Warns, once, if the viewer is lost.
    pub fn is_due(&self, warn: &dyn Fn(&str)) -> bool {
        let post = self.shared.post();
        if let Some(failure) = &post.failure {
            let told = std::mem::replace(&mut self.timing().told, true);
            if !told {
                warn(&format!(
                    "--tev: {} does not show the picture: {failure}; the render does without it",
                    self.address
                ));
            }
            return false;
        }
        post.packets.is_empty() && Instant::now() >= self.timing().due
    }

    /// Leaves the picture so far for the viewer.
    pub fn show(&self, picture: &dyn Bands) {
        super::update(&self.image, picture, &mut |packet| {
            self.shared.leave(packet)
        });
        let (width, height) = picture.size();
        let rest = REST.mul_f64(f64::from(width) * f64::from(height));
        self.timing().due = Instant::now() + rest.max(SHORTEST);
    }

    /// Sends the finished picture and waits until the viewer has it, as long as it takes any of it.
    pub fn finish(&self, picture: &dyn Bands, warn: &dyn Fn(&str)) {
        super::update(&self.image, picture, &mut |packet| {
            self.shared.settle(AHEAD);
            self.shared.leave(packet)
        });
        self.shared.settle(0);
        self.is_due(warn);
        self.shared.post().over = true;
        self.shared.changed.notify_all();
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/output/tev/viewer.rs"]
mod tests;
