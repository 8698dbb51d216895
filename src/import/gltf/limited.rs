//! Images of fewer pixels, as Blender's Simplify asks for them.

use super::image_spaces::Conversion;
use super::schema::TextureLimitJson;
use crate::import::image::{TextureLimit, halved};
use crate::scene::{Image, ImageId, Scene};
use rayon::prelude::*;
use std::collections::HashSet;
use std::mem;

impl TextureLimitJson {
    fn limit(&self) -> TextureLimit {
        TextureLimit {
            resolution: self.resolution,
            size: self.size.unwrap_or(u32::MAX),
        }
    }

    /// An image with no more pixels than that.
    pub(super) fn of(&self, image: Image, weighted: bool) -> Image {
        let halvings = self.limit().halvings(image.width, image.height);
        halved(image, halvings, weighted)
    }

    /// Makes all images of a scene so small, before they are converted. Colours that Cycles multiplies with their opacity count by it.
    pub(super) fn apply(&self, conversions: &[(ImageId, Conversion)], scene: &mut Scene) {
        let textures = scene.materials.iter().flat_map(|m| m.graph.textures());
        let multiplied = textures.filter(|texture| texture.sampler.alpha.multiplies());
        let converted = conversions.iter().filter(|(_, to)| to.alpha.multiplies());
        let weighted: HashSet<ImageId> = multiplied
            .map(|texture| texture.image)
            .chain(converted.map(|(image, _)| *image))
            .collect();
        let images = mem::take(&mut scene.images);
        let numbered: Vec<(u32, Image)> = (0..).zip(images).collect();
        scene.images = numbered
            .into_par_iter()
            .map(|(number, image)| self.of(image, weighted.contains(&ImageId(number))))
            .collect();
    }
}
