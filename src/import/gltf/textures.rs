//! Textures: which image, with which sampler, lying how.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::PathBuf;

use ::gltf::json;
use json::texture::{Info, MagFilter, WrappingMode};
use json::validation::Checked;
use serde::Deserialize;
use serde_json::Value;

use super::container::{Document, Located};
use super::image_spaces::Conversion;
use super::scene_extension::working_space;
use crate::import::ImportError;
use crate::import::image::{self, Bytes, Encoded, Format};
use crate::math::primaries::WorkingSpace;
use crate::scene::graph::Graph;
use crate::scene::{
    self, CoatNormal, Diagnostics, ImageAlpha, ImageId, MetallicRoughness, NormalTexture, Sampler,
    Texture, TextureFilter, UvTransform, Verdict, Wrap,
};

/// The images that materials turned out to need, each once.
pub(super) struct Images<'a> {
    document: &'a Document,
    /// By glTF image index; `None` for an image of a kind that we cannot read.
    known: HashMap<(usize, Option<Conversion>), Option<ImageId>>,
    /// By the bytes' place, so that two entries for one file are one image.
    by_source: HashMap<(Source, Option<Conversion>), ImageId>,
    pending: Vec<Pending<'a>>,
    /// What all may take.
    most_bytes: Option<u64>,
}

#[derive(Clone, PartialEq, Eq, Hash)]
enum Source {
    /// Address and length in the file's buffers: many views may be of the same bytes.
    View((usize, usize)),
    /// Data in the URI.
    Uri(String),
    /// By its one name, however the file writes it.
    File(PathBuf),
}

struct Pending<'a> {
    encoded: Encoded<'a>,
    /// What is done to its numbers once they are there.
    conversion: Option<Conversion>,
}

/// KHR_texture_transform as read from JSON (the `gltf` crate has none on normal textures).
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct TransformJson {
    offset: Option<[f32; 2]>,
    rotation: Option<f32>,
    scale: Option<[f32; 2]>,
    tex_coord: Option<u32>,
}

impl<'a> Images<'a> {
    pub(super) fn new(document: &'a Document, most_bytes: Option<u64>) -> Self {
        Self {
            document,
            known: HashMap::new(),
            by_source: HashMap::new(),
            pending: Vec::new(),
            most_bytes,
        }
    }

    /// A texture as a material refers to it; `None` (with a diagnostic) if its image is of no kind
    /// that we read.
    ///
    /// `json` is the reference's JSON object, for its extensions.
    pub(super) fn texture(
        &mut self,
        info: &Info,
        json: Option<&Value>,
        owner: &str,
        diagnostics: &mut Diagnostics,
    ) -> Result<Option<Texture>, ImportError> {
        self.texture_at(info.index.value(), info.tex_coord, json, owner, diagnostics)
    }

    /// As [`Self::texture`], from the bare numbers.
    pub(super) fn texture_at(
        &mut self,
        index: usize,
        tex_coord: u32,
        json: Option<&Value>,
        owner: &str,
        diagnostics: &mut Diagnostics,
    ) -> Result<Option<Texture>, ImportError> {
        let document = self.document;
        let broken = |problem: String| ImportError::malformed(&document.file, owner, problem);
        // Cycles keeps codes of sRGB for scenes in Rec.709 alone.
        let codes_are_kept =
            document.is_as_cycles_shows() && working_space(document) == WorkingSpace::default();
        let texture = document
            .core
            .textures
            .get(index)
            .ok_or_else(|| broken(format!("it uses texture {index}, which does not exist")))?;
        let sampler = match &texture.sampler {
            Some(sampler) => {
                let number = sampler.value();
                let sampler = document.core.samplers.get(number).ok_or_else(|| {
                    broken(format!(
                        "texture {index} uses a sampler that does not exist"
                    ))
                })?;
                let weighted = self.is_weighted(number, owner, diagnostics);
                let mut sampler = read_sampler(sampler, codes_are_kept);
                if weighted.map_err(broken)? {
                    sampler.alpha = ImageAlpha::WEIGHTED;
                }
                sampler
            }
            None => Sampler {
                filter: linear(codes_are_kept),
                ..Sampler::default()
            },
        };
        let Some(source) = self.choose_source(index, texture, owner, diagnostics) else {
            return Ok(None);
        };
        let Some(image) = self.image((source, None), owner, diagnostics)? else {
            return Ok(None);
        };
        let extensions = json.and_then(|j| j.get("extensions"));
        let transform = match extensions.and_then(|e| e.get("KHR_texture_transform")) {
            Some(value) => TransformJson::deserialize(value).map_err(|e| {
                let why = super::words::plain(&e);
                broken(format!("its KHR_texture_transform cannot be read ({why})"))
            })?,
            None => TransformJson::default(),
        };
        if let Some(Value::Object(extensions)) = extensions {
            for name in extensions.keys().filter(|n| *n != "KHR_texture_transform") {
                super::extensions::report_unknown(diagnostics, name, owner);
            }
        }
        let plain = UvTransform::default();
        Ok(Some(Texture {
            image,
            uv_set: transform.tex_coord.unwrap_or(tex_coord),
            transform: UvTransform {
                offset: transform.offset.unwrap_or(plain.offset),
                rotation: transform.rotation.unwrap_or(plain.rotation),
                scale: transform.scale.unwrap_or(plain.scale),
            },
            sampler,
        }))
    }

    /// What SUNDOG_sampler says of a sampler.
    fn is_weighted(
        &self,
        sampler: usize,
        owner: &str,
        diagnostics: &mut Diagnostics,
    ) -> Result<bool, String> {
        let name = "SUNDOG_sampler";
        let place = format!("/samplers/{sampler}/extensions/{name}");
        let Some(extension) = self.document.value.pointer(&place) else {
            return Ok(false);
        };
        let broken = || format!("the {name} of sampler {sampler} cannot be read");
        let Value::Object(properties) = extension else {
            return Err(broken());
        };
        for property in properties.keys().filter(|p| *p != "weighted_by_alpha") {
            super::extensions::report_property(diagnostics, name, property, owner);
        }
        match properties.get("weighted_by_alpha") {
            None => Ok(false),
            Some(said) => said.as_bool().ok_or_else(broken),
        }
    }

    /// The image that a texture means: an extension's, if we read its kind, else the fallback.
    fn choose_source(
        &self,
        index: usize,
        texture: &json::Texture,
        owner: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<usize> {
        let plain = Some(texture.source.value()).filter(|&i| i != u32::MAX as usize);
        let extensions = self
            .document
            .value
            .pointer(&format!("/textures/{index}/extensions"));
        let Some(Value::Object(extensions)) = extensions else {
            if plain.is_none() {
                diagnostics.report(
                    "texture-without-image",
                    Verdict::Lost,
                    "texture without an image",
                    owner,
                    "left out",
                );
            }
            return plain;
        };
        let mut chosen = plain;
        for (name, value) in extensions {
            match name.as_str() {
                "EXT_texture_webp" | "KHR_texture_basisu" => {
                    if let Some(source) = value.get("source").and_then(Value::as_u64) {
                        chosen = usize::try_from(source).ok();
                    }
                }
                _ if plain.is_some() => diagnostics.report(
                    "texture-fallback",
                    Verdict::Exact,
                    name.clone(),
                    owner,
                    "the file's own PNG or JPEG version of the texture is used",
                ),
                _ => diagnostics.report(
                    "texture-kind",
                    Verdict::Lost,
                    name.clone(),
                    owner,
                    "the texture is left out: export with PNG, JPEG, WebP or KTX2 textures",
                ),
            }
        }
        chosen
    }

    /// An image by its number, and what is to be done to its numbers.
    pub(super) fn image(
        &mut self,
        (index, conversion): (usize, Option<Conversion>),
        owner: &str,
        diagnostics: &mut Diagnostics,
    ) -> Result<Option<ImageId>, ImportError> {
        let key = (index, conversion);
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let document = self.document;
        let Some(image) = document.core.images.get(index) else {
            return Err(ImportError::malformed(
                &document.file,
                owner,
                format!("it uses image {index}, which does not exist"),
            ));
        };
        let object = match &image.name {
            Some(name) => format!("image {index} (\"{name}\")"),
            None => format!("image {index}"),
        };
        let broken = |problem: String| ImportError::malformed(&document.file, &object, problem);
        let mut data = Vec::new();
        let source = match (&image.uri, &image.buffer_view) {
            (Some(uri), _) => match document.locate(uri, &object) {
                Ok(Located::Data(decoded)) => {
                    data = decoded;
                    Source::Uri(uri.clone())
                }
                Ok(Located::File(path)) => Source::File(path),
                Err(ImportError::Remote { address, .. }) => {
                    let told = format!("image at {address}, which is not a file beside the scene");
                    lose(diagnostics, told, &object);
                    self.known.insert(key, None);
                    return Ok(None);
                }
                Err(error) => return Err(error),
            },
            (None, Some(view)) => Source::View(document.place(view.value()).map_err(broken)?),
            (None, None) => return Err(broken("it has neither data nor a file".into())),
        };
        let source = (source, key.1.clone());
        if let Some(&id) = self.by_source.get(&source) {
            self.known.insert(key, Some(id));
            return Ok(Some(id));
        }
        let bytes: Cow<'a, [u8]> = match (&source.0, &image.buffer_view) {
            (Source::File(path), _) => match document.read(path, &object) {
                Ok(data) => data.into(),
                Err(ImportError::MissingPart { needed, reason, .. }) => {
                    let told = format!("image file {needed}, which cannot be read ({reason})");
                    lose(diagnostics, told, &object);
                    self.known.insert(key, None);
                    return Ok(None);
                }
                Err(error) => return Err(error),
            },
            (Source::View(_), Some(view)) => document.view(view.value()).map_err(broken)?.0.into(),
            _ => data.into(),
        };
        match image::sniff(&bytes) {
            Format::Unsupported(kind) => {
                diagnostics.report(
                    "image-kind",
                    Verdict::Lost,
                    format!("{kind} images"),
                    &object,
                    "the textures that use them are left out: export with PNG, JPEG, WebP or KTX2 textures",
                );
                self.known.insert(key, None);
                return Ok(None);
            }
            Format::Unknown => {
                lose(diagnostics, "image of an unknown kind".into(), &object);
                self.known.insert(key, None);
                return Ok(None);
            }
            _ => {}
        }
        let name = image
            .name
            .clone()
            .or_else(|| image.uri.clone().filter(|u| !u.starts_with("data:")))
            .unwrap_or_else(|| format!("image {index}"));
        let id = ImageId(u32::try_from(self.pending.len()).unwrap_or(u32::MAX));
        let bytes = match (&source.0, bytes) {
            (Source::File(path), Cow::Owned(bytes)) => {
                image::bytes_of_file(path.clone(), bytes, self.most_bytes)
            }
            (_, bytes) => Bytes::Here(bytes),
        };
        self.pending.push(Pending {
            encoded: Encoded {
                name,
                bytes,
                becomes_floats: key.1.is_some(),
            },
            conversion: key.1.clone(),
        });
        self.known.insert(key, Some(id));
        self.by_source.insert(source, id);
        Ok(Some(id))
    }

    /// An image of its own, at once; or why there is none.
    pub(super) fn decoded(
        &self,
        index: usize,
        owner: &str,
    ) -> Result<Result<scene::Image, String>, ImportError> {
        let document = self.document;
        let image = document.core.images.get(index);
        let named = format!("image {index}");
        let (bytes, name) = match image.map(|image| (&image.uri, &image.buffer_view)) {
            Some((Some(uri), _)) => match document.resolve(uri, owner) {
                Ok(bytes) if uri.starts_with("data:") => (bytes, named),
                Ok(bytes) => (bytes, uri.clone()),
                Err(ImportError::MissingPart { needed, reason, .. }) => {
                    return Ok(Err(format!("{needed}, which cannot be read: {reason}")));
                }
                Err(error) => return Err(error),
            },
            Some((None, Some(view))) => match document.view(view.value()) {
                Ok((bytes, _)) => (bytes.to_vec(), named),
                Err(problem) => return Ok(Err(format!("{named}: {problem}"))),
            },
            _ => return Ok(Err(format!("{named}, which is not in the file"))),
        };
        let decoded = image::decode_image(&bytes, &name);
        Ok(decoded.map_err(|reason| format!("{name}, which cannot be decoded: {reason}")))
    }

    /// Decodes all images, in parallel. Textures of those that cannot be decoded are taken from the materials, and told.
    pub(super) fn decode(
        self,
        materials: &mut [MetallicRoughness],
        graphs: &mut [Option<Graph>],
        diagnostics: &mut Diagnostics,
    ) -> (Vec<scene::Image>, Vec<(ImageId, Conversion)>) {
        // Views that lie over each other do not make the file larger than it is.
        let (inside, outside) =
            self.pending
                .iter()
                .fold((0usize, 0usize), |sum, p| match p.encoded.bytes {
                    Bytes::Here(Cow::Borrowed(bytes)) => (sum.0 + bytes.len(), sum.1),
                    ref other => (sum.0, sum.1 + other.len()),
                });
        let input = inside.min(self.document.input_bytes()) + outside;
        let (encoded, wanted): (Vec<_>, Vec<_>) = self
            .pending
            .into_iter()
            .map(|pending| (pending.encoded, pending.conversion))
            .unzip();
        let decoded = image::decode_all(encoded, input, self.most_bytes, diagnostics);
        let mut images = Vec::with_capacity(decoded.len());
        let mut places = Vec::with_capacity(decoded.len());
        let mut conversions = Vec::new();
        for (image, conversion) in decoded.into_iter().zip(wanted) {
            match image {
                Ok(image) => {
                    let place = ImageId(u32::try_from(images.len()).unwrap_or(u32::MAX));
                    conversions.extend(conversion.map(|conversion| (place, conversion)));
                    places.push(Some(place));
                    images.push(image);
                }
                Err((name, reason)) => {
                    let told = format!("image that cannot be decoded ({reason})");
                    lose(diagnostics, told, &format!("image \"{name}\""));
                    places.push(None);
                }
            }
        }
        for material in materials.iter_mut() {
            renumber(material, &places);
        }
        let of_volumes = materials
            .iter_mut()
            .filter_map(|m| m.medium.as_mut()?.varying.as_deref_mut());
        let all = graphs.iter_mut().flatten().chain(of_volumes);
        for texture in all.flat_map(Graph::textures_mut) {
            let place = places.get(texture.image.0 as usize).copied().flatten();
            // What is lost is cut out when the scene is validated.
            texture.image = place.unwrap_or(ImageId(u32::MAX));
        }
        (images, conversions)
    }
}

/// Says that an image cannot be had, and what becomes of its textures.
fn lose(diagnostics: &mut Diagnostics, feature: String, object: &str) {
    diagnostics.report(
        "image-lost",
        Verdict::Lost,
        feature,
        object,
        "its textures are left out: the factors alone count, and what it was to make shine is dark",
    );
}

/// Gives the images of a material their new places; textures without one go.
fn renumber(material: &mut MetallicRoughness, places: &[Option<ImageId>]) {
    let place = |image: ImageId| places.get(image.0 as usize).copied().flatten();
    let shone = material.emission_texture.is_some();
    for slot in material.textures_mut() {
        *slot = slot.take().and_then(|texture| {
            let image = place(texture.image)?;
            Some(Texture { image, ..texture })
        });
    }
    if shone && material.emission_texture.is_none() {
        material.emission = [0.0; 3];
    }
    if let Some(coat) = &mut material.coat
        && let CoatNormal::Map(normal) = &mut coat.normal
    {
        match place(normal.texture.image) {
            Some(image) => normal.texture.image = image,
            None => coat.normal = CoatNormal::Smooth,
        }
    }
    material.normal_texture = material.normal_texture.take().and_then(|normal| {
        let image = place(normal.texture.image)?;
        let texture = Texture {
            image,
            ..normal.texture
        };
        Some(NormalTexture { texture, ..normal })
    });
}

/// Between texels: of a file that shows what Cycles does as there, otherwise as glTF has it.
fn linear(as_cycles: bool) -> TextureFilter {
    if as_cycles {
        TextureFilter::Linear
    } else {
        TextureFilter::LinearLight
    }
}

fn read_sampler(sampler: &json::texture::Sampler, as_cycles: bool) -> Sampler {
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    Sampler {
        wrap_u: wrap(sampler.wrap_s),
        wrap_v: wrap(sampler.wrap_t),
        filter: match sampler.mag_filter {
            Some(Checked::Valid(MagFilter::Nearest)) => TextureFilter::Nearest,
            _ => linear(as_cycles),
        },
        alpha: ImageAlpha::ChannelPacked,
    }
}
