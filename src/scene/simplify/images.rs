//! Images that are the same as another, or the same everywhere.

use crate::scene::texel::{from_u8, from_u16};
use crate::scene::{Effect, Image, ImageId, LeftOut, Pixels, Scene};
use glam::{BVec4A, Vec4};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Whether an image has all the values that it should have.
pub fn is_whole(image: &Image) -> bool {
    let count = u64::from(image.width) * u64::from(image.height) * u64::from(image.channels);
    let there = match &image.pixels {
        Pixels::U8(p) => p.len(),
        Pixels::U16(p) => p.len(),
        Pixels::F32(p) => p.len(),
    };
    count > 0 && there as u64 == count && image.channels <= 4
}

/// The stored value of an image that has the same one everywhere in some channels; of others it is any.
fn constant(image: &Image, channels: BVec4A) -> Option<Vec4> {
    if !is_whole(image) {
        return None;
    }
    let mut asked = (0..4).filter(|&channel| channels.test(channel));
    let same = |channel| {
        place(image, channel).is_none_or(|place| match &image.pixels {
            Pixels::U8(p) => is_same_everywhere(every(p, image, place)),
            Pixels::U16(p) => is_same_everywhere(every(p, image, place)),
            Pixels::F32(p) => is_same_everywhere(every(p, image, place)),
        })
    };
    asked.all(same).then(|| image.texels().next())?
}

/// Where in a texel a number of it in RGBA stands; `None` where it is 1 because there is none.
fn place(image: &Image, channel: usize) -> Option<usize> {
    match (image.channels, channel) {
        (1 | 3, 3) => None,
        (1 | 2, ..3) => Some(0),
        (2, _) => Some(1),
        _ => Some(channel),
    }
}

/// The numbers in one place of each texel. They are looked at as they are stored, for there may be many.
fn every<'a, T>(values: &'a [T], image: &Image, place: usize) -> impl Iterator<Item = &'a T> {
    values[place..].iter().step_by(image.channels as usize)
}

/// Whether all are the same. A value that is not a number is not the same as itself.
fn is_same_everywhere<'a, T: PartialEq + 'a>(mut values: impl Iterator<Item = &'a T>) -> bool {
    let Some(first) = values.next() else {
        return false;
    };
    #[allow(clippy::eq_op)]
    let is_number = first == first;
    is_number && values.all(|value| value == first)
}

/// The least opacity of an image.
fn least_alpha(image: &Image) -> Option<f32> {
    if !is_whole(image) {
        return None;
    }
    let Some(place) = place(image, 3) else {
        return Some(1.0);
    };
    match &image.pixels {
        Pixels::U8(p) => every(p, image, place).min().copied().map(from_u8),
        Pixels::U16(p) => every(p, image, place).min().copied().map(from_u16),
        Pixels::F32(p) => every(p, image, place).try_fold(f32::INFINITY, |least, &alpha| {
            alpha.is_finite().then(|| least.min(alpha))
        }),
    }
}

/// What was found of images: one that many materials share is looked through once for each question.
#[derive(Default)]
pub struct Answers {
    constants: HashMap<(ImageId, u32), Option<Vec4>>,
    least_alphas: HashMap<ImageId, Option<f32>>,
}

impl Answers {
    /// As [`constant`], of image `id`.
    pub fn constant(&mut self, id: ImageId, image: &Image, channels: BVec4A) -> Option<Vec4> {
        let question = (id, channels.bitmask());
        let answer = self.constants.entry(question);
        *answer.or_insert_with(|| constant(image, channels))
    }

    /// As [`least_alpha`], of image `id`.
    pub fn least_alpha(&mut self, id: ImageId, image: &Image) -> Option<f32> {
        let answer = self.least_alphas.entry(id);
        *answer.or_insert_with(|| least_alpha(image))
    }
}

/// Whether all values of an image are finite: nothing times 0 is anything but 0.
pub fn is_finite(image: &Image) -> bool {
    match &image.pixels {
        Pixels::U8(_) | Pixels::U16(_) => true,
        Pixels::F32(values) => values.iter().all(|v| v.is_finite()),
    }
}

/// So many bytes from the beginning and as many from the middle tell most images apart.
const SAMPLE: usize = 4096;

fn sample(image: &Image) -> u64 {
    let bytes: &[u8] = match &image.pixels {
        Pixels::U8(p) => p,
        Pixels::U16(p) => bytemuck::cast_slice(p),
        Pixels::F32(p) => bytemuck::cast_slice(p),
    };
    let mut hasher = DefaultHasher::new();
    (image.width, image.height, image.channels).hash(&mut hasher);
    let part = |from: usize| &bytes[from..bytes.len().min(from + SAMPLE)];
    part(0).hash(&mut hasher);
    part(bytes.len() / 2).hash(&mut hasher);
    hasher.finish()
}

fn is_same(a: &Image, b: &Image) -> bool {
    (a.width, a.height, a.channels) == (b.width, b.height, b.channels)
        && a.pixels.is_same(&b.pixels)
}

/// For each image the first one with the same texels; unused ones are taken out later, and counted there.
fn firsts(images: &[Image]) -> Vec<ImageId> {
    let mut known: HashMap<u64, Vec<usize>> = HashMap::new();
    let first = |(number, image): (usize, &Image)| {
        let alike = known.entry(sample(image)).or_default();
        let same = alike.iter().copied().find(|&i| is_same(&images[i], image));
        if same.is_none() {
            alike.push(number);
        }
        ImageId(same.unwrap_or(number) as u32)
    };
    images.iter().enumerate().map(first).collect()
}

/// Makes one of identical images.
pub fn join(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let firsts = firsts(&scene.images);
    for (number, (image, first)) in scene.images.iter().zip(&firsts).enumerate() {
        if first.0 as usize != number {
            LeftOut::add(left_out, None, "images identical to others", &image.name, 0);
        }
    }
    super::unused::rename_images(scene, |id| firsts[id.0 as usize]);
}

/// Makes an environment of one colour of an image that has one. Not in files from Blender: Cycles takes light samples of all that has a
/// texture, and where it takes them rough glass and lamps look a little otherwise.
pub fn fold_environment(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    if scene.is_from_blender() {
        return;
    }
    let Some(environment) = &mut scene.environment else {
        return;
    };
    let image = environment
        .image
        .and_then(|id| scene.images.get(id.0 as usize));
    // Others are encoded, and nothing makes environments of them.
    let Some(image) = image.filter(|image| matches!(image.pixels, Pixels::F32(_))) else {
        return;
    };
    let Some(value) = constant(image, BVec4A::new(true, true, true, false)) else {
        return;
    };
    let mut radiance = environment.radiance;
    for (r, v) in radiance.iter_mut().zip(value.to_array()) {
        *r *= v;
    }
    if !radiance.iter().all(|r| r.is_finite() && *r >= 0.0) {
        return;
    }
    LeftOut::add(
        left_out,
        Effect::ImageEnvironment,
        "the image is the same everywhere and becomes a colour",
        &image.name,
        0,
    );
    environment.image = None;
    environment.radiance = radiance;
    super::unseen::environment(scene, left_out);
}
