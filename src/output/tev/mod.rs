//! What the image viewer tev is told over the network: packets of its protocol as its README and its
//! `Ipc.cpp` describe them (<https://github.com/Tom94/tev>, version 2.14), little-endian throughout:
//!
//! ```text
//! u32 bytes of the packet, these four included; u8 operation; what belongs to the operation
//! ```
//!
//! Texts end with a zero byte. Operations: create an image (4), update a part of it (6, the third version:
//! channels with offsets and strides of their own).

mod viewer;

pub use viewer::Viewer;

use super::exr::channel_name;
use crate::film::Bands;

/// The port on which tev listens if it is not told otherwise.
pub const PORT: u16 = 14158;

/// Where a program listens: `HOST:PORT`.
#[derive(Clone, Debug, PartialEq)]
pub struct Address(pub String);

impl std::str::FromStr for Address {
    type Err = String;

    /// `HOST:PORT`, or `HOST` for tev's own port; addresses of IPv6 stand in brackets. An error says what was expected.
    fn from_str(text: &str) -> Result<Self, String> {
        let (host, port) = match text.rsplit_once(':') {
            Some((host, port)) if !text.ends_with(']') => (host, port.parse().ok()),
            _ => (text, Some(PORT)),
        };
        let bracketed = host.starts_with('[') && host.ends_with(']');
        let plain = !host.is_empty() && !host.contains([':', ' ', '[', ']']);
        match port {
            Some(port @ 1..) if bracketed || plain => Ok(Address(format!("{host}:{port}"))),
            _ => Err(format!(
                "expected HOST:PORT such as localhost:{}, with a port from 1 to 65535",
                PORT
            )),
        }
    }
}

const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE_V3: u8 = 6;

/// A packet in the making.
struct Packet(Vec<u8>);

impl Packet {
    fn new(operation: u8, grab_focus: bool, image: &str) -> Self {
        // The length comes at the end.
        Self(vec![0, 0, 0, 0, operation, u8::from(grab_focus)]).text(image)
    }

    /// A zero byte would end the text before its end: it is left out.
    fn text(mut self, text: &str) -> Self {
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
        self
    }

    fn texts(self, texts: &[String]) -> Self {
        texts.iter().fold(self, |packet, text| packet.text(text))
    }

    /// As tev's `int32_t`: a picture's sides and numbers of channels are far from its end.
    fn number(mut self, number: usize) -> Self {
        self.0.extend((number as u32).to_le_bytes());
        self
    }

    fn long(mut self, number: usize) -> Self {
        self.0.extend((number as u64).to_le_bytes());
        self
    }

    fn finish(mut self) -> Vec<u8> {
        let length = (self.0.len() as u32).to_le_bytes();
        self.0[..4].copy_from_slice(&length);
        self.0
    }
}

/// Makes an image of zeros; one of the same name is replaced. tev shows it at once.
pub fn create_image(image: &str, (width, height): (u32, u32), channels: &[String]) -> Vec<u8> {
    Packet::new(CREATE_IMAGE, true, image)
        .number(width as usize)
        .number(height as usize)
        .number(channels.len())
        .texts(channels)
        .finish()
}

/// Sets whole rows of some channels of an image from `y` on: `values` are interleaved, rows from top to bottom.
pub fn update_rows(
    image: &str,
    channels: &[String],
    y: u32,
    width: u32,
    values: &[f32],
) -> Vec<u8> {
    let n = channels.len();
    let height = values.len() / (n * width as usize).max(1);
    let mut packet = Packet::new(UPDATE_IMAGE_V3, false, image)
        .number(n)
        .texts(channels)
        .number(0)
        .number(y as usize)
        .number(width as usize)
        .number(height);
    for offset in 0..n {
        packet = packet.long(offset);
    }
    for _ in 0..n {
        packet = packet.long(n);
    }
    packet
        .0
        .extend(values.iter().flat_map(|value| value.to_le_bytes()));
    packet.finish()
}

/// Names of a layer's channels as tev groups them: those of the picture itself stand alone, others behind
/// the name of their layer, as in EXR files.
fn channel_names(layer: &str, channels: &str) -> Vec<String> {
    channels
        .chars()
        .map(|channel| channel_name(layer, &channel.to_string()))
        .collect()
}

/// Makes an image that has room for these layers (names, and channels a letter each).
pub fn create<'a>(
    image: &str,
    size: (u32, u32),
    layers: impl Iterator<Item = (&'a str, &'a str)>,
) -> Vec<u8> {
    let channels: Vec<_> = layers
        .flat_map(|(layer, channels)| channel_names(layer, channels))
        .collect();
    create_image(image, size, &channels)
}

/// Gives `send` the packets that set the layers of a picture, band by band, until it returns false.
pub fn update(image: &str, picture: &dyn Bands, send: &mut dyn FnMut(Vec<u8>) -> bool) {
    let (width, _) = picture.size();
    let layers = picture.layers();
    let names: Vec<_> = layers
        .iter()
        .map(|(layer, channels)| channel_names(layer, channels))
        .collect();
    let mut buffers = vec![Vec::new(); names.len()];
    for (band, rows) in picture.bands().into_iter().enumerate() {
        for (buffer, names) in buffers.iter_mut().zip(&names) {
            buffer.resize(width as usize * rows.len() * names.len(), 0.0);
        }
        let mut parts: Vec<&mut [f32]> = buffers.iter_mut().map(Vec::as_mut_slice).collect();
        picture.fill(band, &mut parts);
        for (part, names) in parts.iter().zip(&names) {
            if !send(update_rows(image, names, rows.start, width, part)) {
                return;
            }
        }
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/output/tev/mod.rs"]
mod tests;
