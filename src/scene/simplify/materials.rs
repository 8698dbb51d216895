//! Materials whose images are factors in truth, or are not seen.

use super::images;
use crate::math::primaries::WorkingSpace;
use crate::scene::graph::{self, Facts, Graph, Opacity, Range, Slot, Summary, Unit};
use crate::scene::{
    Effect, Image, ImageAlpha, ImageUse, LeftOut, Material, MaterialId, Pixels, Scene, Texture,
    TextureFilter, Wrap, decoded,
};
use glam::{BVec4A, Vec3, Vec4};
use std::collections::HashMap;

const BY_FACTOR: &str = "the factor of the image is 0";
const FOLDED: &str = "the image is the same everywhere and becomes a factor";
const ALL_METAL: &str = "not seen on a surface that is all metal";
const ALL_GLASS: &str = "not seen on a surface that is all glass";

/// Which colours the vertices of the meshes with a material have.
#[derive(Clone, Copy, Default)]
struct Vertices {
    /// Some that are not white.
    colored: bool,
    /// Some that are not opaque.
    translucent: bool,
}

/// What the images and the meshes of a scene say.
struct Known<'a> {
    images: &'a [Image],
    answers: &'a mut images::Answers,
    vertices: Vertices,
    /// Of the scene's colours.
    space: WorkingSpace,
}

impl Known<'_> {
    /// What look-ups may give: encoded images end at 1.
    fn bounds(
        &mut self,
        texture: &Texture,
        image: &Image,
        (encoded, alpha): (bool, bool),
    ) -> Range {
        let mut range = match &image.pixels {
            Pixels::F32(_) if !images::is_finite(image) => return Range::UNKNOWN,
            Pixels::F32(_) => Range::FINITE,
            // Divided by a lesser opacity, what is multiplied in the file may be anything.
            _ if texture.sampler.alpha.divides() && !texture.sampler.alpha.multiplies() => {
                Range::FINITE
            }
            _ if encoded && self.space.matrix_from_rec709().is_some() => Range::FINITE,
            _ => Range::SHARE,
        };
        let whole = texture.sampler.wrap_u != Wrap::Clip;
        if alpha
            && whole
            && let Some(least) = self.answers.least_alpha(texture.image, image)
        {
            range.low.w = least;
        }
        if matches!(image.channels, 1 | 3) || !matches!(image.pixels, Pixels::F32(_)) {
            range.high.w = 1.0;
        }
        range
    }

    /// The value that a texture has everywhere in one channel, as it is stored: interpolating what is the same gives the
    /// same bits.
    fn constant(&mut self, texture: &Texture, image: &Image, channel: usize) -> Option<f32> {
        // B-splines' weights are rounded, and there is nothing outside.
        if texture.sampler.wrap_u == Wrap::Clip || texture.sampler.filter == TextureFilter::Cubic {
            return None;
        }
        if channel == 3 && texture.sampler.alpha == ImageAlpha::None {
            return Some(1.0);
        }
        // Multiplied by opacity, colours are rounded once more, and there are none where there is no opacity.
        let alpha = texture.sampler.alpha;
        if channel < 3
            && (alpha.multiplies() || alpha.divides())
            && self.answers.least_alpha(texture.image, image) != Some(1.0)
        {
            return None;
        }
        let mut mask = [false; 4];
        mask[channel] = true;
        let mask = BVec4A::from_array(mask);
        let value = self.answers.constant(texture.image, image, mask)?;
        Some(value[channel])
    }
}

impl Facts for Known<'_> {
    fn image(&mut self, texture: &Texture, usage: ImageUse, taken: [bool; 4]) -> Range {
        let Some(image) = self.images.get(texture.image.0 as usize) else {
            return Range::UNKNOWN;
        };
        let encoded = image.pixels.is_encoded(usage);
        let mut range = self.bounds(texture, image, (encoded, taken[3]));
        if range == Range::UNKNOWN {
            return range;
        }
        let mut values = [0, 1, 2, 3].map(|channel| {
            // Looking through an image takes time.
            let of = taken[channel].then_some(texture)?;
            self.constant(of, image, channel)
        });
        if encoded {
            let stored = values.map(|value| value.unwrap_or(0.0));
            let linear = decoded(Vec4::from_array(stored));
            let there = values;
            values = [0, 1, 2, 3].map(|i| there[i].map(|_| linear[i]));
            if let Some(matrix) = self.space.matrix_from_rec709() {
                let color = matrix.as_mat3() * linear.truncate();
                let whole = there[..3].iter().all(Option::is_some);
                for (value, color) in values.iter_mut().zip(color.to_array()) {
                    *value = whole.then_some(color);
                }
            }
        }
        for (i, value) in values.into_iter().enumerate() {
            // Files of floats may hold what no factor may be.
            if let Some(value) = value.filter(|v| (0.0..=1.0).contains(v)) {
                (range.low[i], range.high[i]) = (value, value);
            }
        }
        range
    }

    fn colors(&self) -> Range {
        let mut range = if self.vertices.colored {
            Range::FINITE
        } else {
            Range::WHITE
        };
        let least = if self.vertices.translucent { 0.0 } else { 1.0 };
        (range.low.w, range.high.w) = (least, 1.0);
        range
    }

    /// As far as its bits can say: 0 lies between two codes, and half a step of 8 bits is 0.22°.
    fn is_flat(&mut self, texture: &Texture, strength: f32) -> bool {
        let Some(image) = self.images.get(texture.image.0 as usize) else {
            return false;
        };
        let half_step = match image.pixels {
            Pixels::U8(_) => 0.5 / 255.0,
            Pixels::U16(_) => 0.5 / 65_535.0,
            Pixels::F32(_) => 0.0,
        };
        // A strength above 1 makes the half step larger than what the bits leave open. The slack is for its rounding.
        let most = half_step * (1.0 + 1e-3);
        let flat = |t: Vec4| (t.x - 0.5).abs() <= most && (t.y - 0.5).abs() <= most && t.z > 0.75;
        let sampler = texture.sampler;
        let opaque = sampler.alpha == ImageAlpha::ChannelPacked && sampler.wrap_u != Wrap::Clip;
        opaque && strength.abs() <= 1.0 && images::is_whole(image) && image.texels().all(flat)
    }
}

/// Why a slot has no images any more.
fn why_without(slot: Slot, before: &Graph, after: &Summary) -> &'static str {
    let below_metal = matches!(
        slot,
        Slot::Specular | Slot::SpecularColor | Slot::Transmission
    );
    let mut surfaces = after.principled.iter();
    if below_metal && surfaces.clone().any(|p| p.is_metal_everywhere()) {
        return ALL_METAL;
    }
    if slot == Slot::Specular && surfaces.clone().any(|p| p.is_glass_everywhere()) {
        return ALL_GLASS;
    }
    if slot == Slot::SpecularColor
        && surfaces.all(|p| p.specular.1 <= 0.0 && p.transmission.1 <= 0.0)
    {
        return BY_FACTOR;
    }
    let results = before.results(&mut Unit {
        vertex_alpha: false,
    });
    let black = before
        .slots()
        .into_iter()
        .filter(|(of, ..)| *of == slot)
        .all(|(_, node, socket)| {
            let node = &before.nodes[node];
            let kind = node.kind.sockets()[socket].kind;
            let range = before.range_of(&results, node.inputs[socket], kind);
            range.high.truncate() == Vec3::ZERO
        });
    if black { BY_FACTOR } else { FOLDED }
}

/// Folds one material; tells what is gone.
fn fold_one(material: &mut Material, known: &mut Known, left_out: &mut Vec<LeftOut>) {
    let before = material.graph.clone();
    graph::fold(&mut material.graph, known);
    if material.graph == before {
        return;
    }
    let after = material.summary();
    let mut tell = |effect: Effect, why| LeftOut::add(left_out, effect, why, &material.name, 0);
    if after.opacity == Opacity::Full {
        match before.summary(false).opacity {
            Opacity::Full => {}
            Opacity::Clip { .. } => tell(
                Effect::AlphaClip,
                "opacity is above the threshold everywhere",
            ),
            Opacity::Blend { .. } => tell(Effect::AlphaBlend, "opacity is 1 everywhere"),
        }
    }
    for slot in Slot::ALL {
        if before.has_texture(slot) && !material.graph.has_texture(slot) {
            tell(slot.effect(), why_without(slot, &before, &after));
        }
    }
    if before.has_normal_map() && !material.graph.has_normal_map() {
        let why = if before
            .normal_map_strengths()
            .all(|strength| strength == 0.0)
        {
            "the strength of the map is 0"
        } else {
            "the map is flat everywhere"
        };
        tell(Effect::NormalMaps, why);
    }
}

/// Makes factors of images that are the same everywhere, and takes away what is not seen.
pub fn fold(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    let mut vertices = vec![Vertices::default(); scene.materials.len()];
    for mesh in &scene.meshes {
        if let Some(colors) = &mesh.colors
            && let Some(id) = mesh.material
            && let Some(vertices) = vertices.get_mut(id.0 as usize)
        {
            vertices.colored = true;
            vertices.translucent |= colors.iter().any(|c| c[3] != 1.0);
        }
    }
    let mut answers = images::Answers::default();
    for (material, vertices) in scene.materials.iter_mut().zip(vertices) {
        let mut known = Known {
            images: &scene.images,
            answers: &mut answers,
            vertices,
            space: scene.color_management.working_space,
        };
        fold_one(material, &mut known, left_out);
    }
}

/// Makes one of materials that differ in nothing but their names.
pub fn join(scene: &mut Scene, left_out: &mut Vec<LeftOut>) {
    // By what tells most of them apart at once.
    let mut known: HashMap<(usize, bool), Vec<u32>> = HashMap::new();
    let mut firsts = Vec::with_capacity(scene.materials.len());
    for (number, material) in scene.materials.iter().enumerate() {
        let number = number as u32;
        let key = (material.graph.nodes.len(), material.double_sided);
        let similar = known.entry(key).or_default();
        let is_same = |&first: &u32| {
            let Material {
                graph: first,
                medium,
                priority,
                ..
            } = &scene.materials[first as usize];
            // The shortest decimals that tell a float from all others: the same text, the same bits.
            *medium == material.medium
                && *priority == material.priority
                && *first == material.graph
                && format!("{first:?}") == format!("{:?}", material.graph)
        };
        let first = similar.iter().copied().find(|first| is_same(first));
        let first = first.unwrap_or(number);
        if first == number {
            similar.push(number);
        } else {
            let why = "materials identical to others";
            LeftOut::add(left_out, None, why, &material.name, 0);
        }
        firsts.push(MaterialId(first));
    }
    for id in scene
        .meshes
        .iter_mut()
        .filter_map(|mesh| mesh.material.as_mut())
    {
        if let Some(&first) = firsts.get(id.0 as usize) {
            *id = first;
        }
    }
    // What is left over has been told.
    super::unused::forget_materials(scene, &firsts);
}
