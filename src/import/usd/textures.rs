//! Images that materials name.

use std::collections::HashMap;

use super::files;
use super::source::Source;
use crate::import::image::{self, Bytes, Encoded, Format};
use crate::scene::graph::Graph;
use crate::scene::{Diagnostics, Image, ImageId, Verdict};

/// The images of a stage, to be decoded together.
#[derive(Default)]
pub(super) struct Images {
    pending: Vec<Encoded<'static>>,
    /// By where they are; none for what cannot be had.
    known: HashMap<String, Option<ImageId>>,
    srgb: Vec<bool>,
    /// What all images may take.
    most_bytes: Option<u64>,
}

impl Images {
    /// Of a stage whose images may take so many bytes.
    pub(super) fn new(most_bytes: Option<u64>) -> Self {
        Self {
            most_bytes,
            ..Self::default()
        }
    }

    /// The image of a file; if there is none, that is told.
    pub(super) fn get(
        &mut self,
        source: &Source,
        (place, called): (&str, &str),
        owner: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<ImageId> {
        if let Some(known) = self.known.get(place) {
            return *known;
        }
        let read = source
            .files
            .read(place)
            .and_then(|bytes| match image::sniff(&bytes) {
                Format::Unsupported(kind) => Err(format!("it is {kind} image, which is not read")),
                Format::Unknown => Err("it is an image of an unknown kind".into()),
                _ => Ok(bytes),
            });
        let id = match read {
            Ok(bytes) => {
                self.srgb.push(is_display(&bytes));
                let bytes = match source.files.place(place) {
                    Ok(path) => image::bytes_of_file(path, bytes, self.most_bytes),
                    Err(_) => Bytes::Here(bytes.into()),
                };
                self.pending.push(Encoded {
                    name: called.to_owned(),
                    bytes,
                    becomes_floats: false,
                });
                Some(ImageId(self.pending.len() as u32 - 1))
            }
            Err(reason) => {
                lose(diagnostics, called, &reason, owner);
                None
            }
        };
        self.known.insert(place.to_owned(), id);
        id
    }

    /// The images of a path with `<UDIM>` in it, by their numbers.
    pub(super) fn tiles(
        &mut self,
        source: &Source,
        (place, called): (&str, &str),
        owner: &str,
        diagnostics: &mut Diagnostics,
    ) -> Vec<(u32, ImageId)> {
        let (before, after) = place.split_once("<UDIM>").unwrap_or((place, ""));
        let slash = before.rfind(['/', '[']).map_or(0, |at| at + 1);
        let start = &before[slash..];
        let end = after.trim_end_matches(']');
        let number = |name: &String| {
            let middle = name.strip_prefix(start)?.strip_suffix(end)?;
            let is_number = middle.len() == 4 && middle.bytes().all(|b| b.is_ascii_digit());
            middle
                .parse()
                .ok()
                .filter(|n: &u32| is_number && *n >= 1001)
        };
        let mut numbers: Vec<u32> = files::siblings(place).iter().filter_map(number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        if numbers.is_empty() {
            lose(
                diagnostics,
                called,
                "there is no file of any of its tiles",
                owner,
            );
        }
        let one = numbers.into_iter().filter_map(|number| {
            let path = place.replace("<UDIM>", &number.to_string());
            let called = called.replace("<UDIM>", &number.to_string());
            Some((
                number,
                self.get(source, (&path, &called), owner, diagnostics)?,
            ))
        });
        one.collect()
    }

    /// Whether a file that does not say so is taken as encoded for displays.
    pub(super) fn is_srgb(&self, id: ImageId) -> bool {
        self.srgb.get(id.0 as usize) == Some(&true)
    }

    /// Decodes all images; those in memory take so many bytes at most. What cannot be decoded is told, and cut out when the scene is validated.
    pub(super) fn decode<'g>(
        self,
        graphs: impl Iterator<Item = &'g mut Graph>,
        most_bytes: Option<u64>,
        diagnostics: &mut Diagnostics,
    ) -> Vec<Image> {
        let input = self.pending.iter().map(|one| one.bytes.len()).sum();
        let decoded = image::decode_all(self.pending, input, most_bytes, diagnostics);
        let mut images = Vec::new();
        let mut places = Vec::new();
        for image in decoded {
            match image {
                Ok(image) => {
                    places.push(ImageId(images.len() as u32));
                    images.push(image);
                }
                Err((name, reason)) => {
                    lose(diagnostics, &name, &reason.to_string(), "");
                    places.push(ImageId(u32::MAX));
                }
            }
        }
        for texture in graphs.flat_map(Graph::textures_mut) {
            let place = places.get(texture.image.0 as usize);
            texture.image = place.copied().unwrap_or(ImageId(u32::MAX));
        }
        images
    }
}

fn lose(diagnostics: &mut Diagnostics, called: &str, reason: &str, owner: &str) {
    diagnostics.report(
        "image-lost",
        Verdict::Lost,
        format!("image \"{called}\" that cannot be read ({reason})"),
        owner,
        "its textures show their fallback",
    );
}

/// 8 bits a channel and colours: what UsdUVTexture's "auto" takes as sRGB, where the file says nothing of its own.
fn is_display(bytes: &[u8]) -> bool {
    match image::sniff(bytes) {
        // Bits a sample and the kind of colour, in the first chunk.
        Format::Png => bytes.get(24) == Some(&8) && bytes.get(25).is_some_and(|kind| kind & 2 != 0),
        Format::Jpeg => jpeg_components(bytes).is_none_or(|count| count >= 3),
        Format::WebP | Format::Gif => true,
        // Those with few bits a pixel have a palette of colours.
        Format::Bmp => true,
        // The kind, with or without compression: colours of a palette, or without one.
        Format::Tga => matches!(bytes.get(2), Some(1 | 2 | 9 | 10)),
        Format::Tiff => tiff_is_display(bytes).unwrap_or(false),
        _ => false,
    }
}

/// Whether a TIFF has 8 bits in each of three samples or more, or a palette: by the first directory of TIFF 6.0.
fn tiff_is_display(bytes: &[u8]) -> Option<bool> {
    let little = bytes.starts_with(b"II");
    let short = |at: usize| {
        let two: [u8; 2] = bytes.get(at..at + 2)?.try_into().ok()?;
        Some(if little {
            u16::from_le_bytes(two)
        } else {
            u16::from_be_bytes(two)
        })
    };
    let long = |at: usize| {
        let four: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
        let value = if little {
            u32::from_le_bytes(four)
        } else {
            u32::from_be_bytes(four)
        };
        usize::try_from(value).ok()
    };
    let directory = long(4)?;
    let (mut bits, mut palette) = (1, false);
    let mut samples = 1;
    for entry in 0..usize::from(short(directory)?) {
        let at = directory + 2 + 12 * entry;
        let (tag, count) = (short(at)?, long(at + 4)?);
        match tag {
            // More than two numbers stand elsewhere.
            258 if count > 2 => bits = short(long(at + 8)?)?,
            258 => bits = short(at + 8)?,
            262 => palette = short(at + 8)? == 3,
            277 => samples = short(at + 8)?,
            _ => {}
        }
    }
    Some(palette || (bits == 8 && samples >= 3))
}

/// Components of a JPEG, from its frame header.
fn jpeg_components(bytes: &[u8]) -> Option<u8> {
    let mut at = 2;
    loop {
        let [0xff, kind, high, low] = *bytes.get(at..at + 4)? else {
            return None;
        };
        if matches!(kind, 0xc0..=0xcf) && !matches!(kind, 0xc4 | 0xc8 | 0xcc) {
            return bytes.get(at + 9).copied();
        }
        at += 2 + usize::from(u16::from_be_bytes([high, low]));
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/textures.rs"]
mod tests;
