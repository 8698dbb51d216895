//! Which passes there are, by Blender's names.

use super::objects::Matte;
use serde::{Serialize, Serializer};

/// A pass of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Pass {
    /// The picture itself, alpha associated.
    Combined,
    /// Distance along the view axis.
    Depth,
    /// Shading normal, world space.
    Normal,
    /// World space.
    Position,
    /// First texture coordinates of the mesh.
    Uv,
    /// Light that surfaces scatter diffusely on its way from a light, over `DiffuseColor`.
    DiffuseDirect,
    /// The same of light that other surfaces have scattered before.
    DiffuseIndirect,
    /// Share of light that surfaces scatter diffusely.
    DiffuseColor,
    /// Glossy reflection, as `DiffuseDirect`.
    GlossyDirect,
    /// Glossy reflection, as `DiffuseIndirect`.
    GlossyIndirect,
    /// Glossy reflection, as `DiffuseColor`.
    GlossyColor,
    /// Transmission, as `DiffuseDirect`.
    TransmissionDirect,
    /// Transmission, as `DiffuseIndirect`.
    TransmissionIndirect,
    /// Transmission, as `DiffuseColor`.
    TransmissionColor,
    /// Light that a volume scatters to the camera on its way from a light.
    VolumeDirect,
    /// The same of light that was scattered before.
    VolumeIndirect,
    /// What shines, seen by the camera.
    Emission,
    /// The world, seen by the camera.
    Environment,
    /// How what is seen moves in the picture.
    Vector,
    /// How far away, by Blender's mist (see [`super::objects`]).
    Mist,
    /// How open to all around.
    AmbientOcclusion,
    /// What objects do to the light on shadow catchers.
    ShadowCatcher,
    /// Pass index of the object.
    ObjectIndex,
    /// Pass index of the material.
    MaterialIndex,
    /// Cryptomatte of objects: the two that show most.
    CryptoObject00,
    /// The next two.
    CryptoObject01,
    /// The last two.
    CryptoObject02,
    /// The same of materials.
    CryptoMaterial00,
    /// The next two.
    CryptoMaterial01,
    /// The last two.
    CryptoMaterial02,
    /// The same of topmost parents.
    CryptoAsset00,
    /// The next two.
    CryptoAsset01,
    /// The last two.
    CryptoAsset02,
    /// Albedo for denoisers (see [`super::features`]).
    DenoisingAlbedo,
    /// Shading normal for denoisers, in the camera's axes.
    DenoisingNormal,
    /// Length of the path to what denoisers look at.
    DenoisingDepth,
    /// The picture before it was denoised.
    NoisyImage,
    /// Samples of each pixel.
    SampleCount,
    /// Estimated error of each pixel.
    Error,
    /// Time spent on each pixel.
    Cost,
    /// The scene's own passes, each by its name.
    Aov,
}

/// The one table of passes: Blender's name, channels as Blender has them, what it holds.
pub const TABLE: [(Pass, &str, &str, &str); 41] = [
    (Pass::Combined, "Combined", "RGBA", "the picture itself"),
    (
        Pass::Depth,
        "Depth",
        "Z",
        "distance along the view axis (panorama: from the camera) of what the ray through the pixel's middle meets; 1e10 where that is nothing or a holdout",
    ),
    (
        Pass::Normal,
        "Normal",
        "XYZ",
        "shading normal in Blender's world axes, mean over the samples",
    ),
    (
        Pass::Position,
        "Position",
        "XYZ",
        "place in Blender's world axes, of what the ray through the pixel's middle meets",
    ),
    (
        Pass::Uv,
        "UV",
        "UVA",
        "first texture coordinates that the file has of the mesh, and how much of the pixel a surface covers",
    ),
    (
        Pass::DiffuseDirect,
        "DiffDir",
        "RGB",
        "light from lights, scattered diffusely by what the camera sees, over DiffCol",
    ),
    (
        Pass::DiffuseIndirect,
        "DiffInd",
        "RGB",
        "the same of light by way of other surfaces",
    ),
    (
        Pass::DiffuseColor,
        "DiffCol",
        "RGB",
        "share of light that what the camera sees scatters diffusely",
    ),
    (
        Pass::GlossyDirect,
        "GlossDir",
        "RGB",
        "as DiffDir, for glossy reflection",
    ),
    (
        Pass::GlossyIndirect,
        "GlossInd",
        "RGB",
        "as DiffInd, for glossy reflection",
    ),
    (
        Pass::GlossyColor,
        "GlossCol",
        "RGB",
        "as DiffCol, for glossy reflection",
    ),
    (
        Pass::TransmissionDirect,
        "TransDir",
        "RGB",
        "as DiffDir, for transmission",
    ),
    (
        Pass::TransmissionIndirect,
        "TransInd",
        "RGB",
        "as DiffInd, for transmission",
    ),
    (
        Pass::TransmissionColor,
        "TransCol",
        "RGB",
        "as DiffCol, for transmission",
    ),
    (
        Pass::VolumeDirect,
        "VolumeDir",
        "RGB",
        "light from lights that a volume scatters to the camera",
    ),
    (
        Pass::VolumeIndirect,
        "VolumeInd",
        "RGB",
        "the same of light that was scattered before",
    ),
    (
        Pass::Emission,
        "Emit",
        "RGB",
        "surfaces and volumes that shine, as the camera sees them",
    ),
    (
        Pass::Environment,
        "Env",
        "RGB",
        "the world, as the camera sees it; also with --transparent",
    ),
    (
        Pass::Vector,
        "Vector",
        "XYZW",
        "pixels to where it was a frame before, and from where it is a frame after: what the file says for pictures without motion blur; else 0",
    ),
    (
        Pass::Mist,
        "Mist",
        "Z",
        "how far away by `--mist`, 0 to 1; 1 where the camera sees nothing",
    ),
    (
        Pass::AmbientOcclusion,
        "AO",
        "RGB",
        "ambient occlusion: share of the directions about the normal, by their cosine, in which nothing is within `--ao-distance`; 0 where the camera sees nothing",
    ),
    (
        Pass::ShadowCatcher,
        "Shadow Catcher",
        "RGB",
        "what objects do to the light on shadow catchers, to multiply a photograph with; 1 where there is none. Combined is then the objects alone",
    ),
    (
        Pass::ObjectIndex,
        "IndexOB",
        "X",
        "pass index of the object that the ray through the pixel's middle meets; 0 of nothing",
    ),
    (
        Pass::MaterialIndex,
        "IndexMA",
        "X",
        "the same of its material",
    ),
    (
        Pass::CryptoObject00,
        "CryptoObject00",
        "rgba",
        "Cryptomatte of objects: number and share of the two that show most",
    ),
    (
        Pass::CryptoObject01,
        "CryptoObject01",
        "rgba",
        "the next two",
    ),
    (
        Pass::CryptoObject02,
        "CryptoObject02",
        "rgba",
        "the last two",
    ),
    (
        Pass::CryptoMaterial00,
        "CryptoMaterial00",
        "rgba",
        "the same of materials",
    ),
    (
        Pass::CryptoMaterial01,
        "CryptoMaterial01",
        "rgba",
        "the next two",
    ),
    (
        Pass::CryptoMaterial02,
        "CryptoMaterial02",
        "rgba",
        "the last two",
    ),
    (
        Pass::CryptoAsset00,
        "CryptoAsset00",
        "rgba",
        "the same of objects' topmost parents",
    ),
    (Pass::CryptoAsset01, "CryptoAsset01", "rgba", "the next two"),
    (Pass::CryptoAsset02, "CryptoAsset02", "rgba", "the last two"),
    (
        Pass::DenoisingAlbedo,
        "Denoising Albedo",
        "RGB",
        "albedo for denoisers: of what the camera sees, also in mirrors and through clear glass, tinted by them; the light of what shines",
    ),
    (
        Pass::DenoisingNormal,
        "Denoising Normal",
        "XYZ",
        "normal of the same for denoisers, in the camera's axes with Z forward, shorter where mirrors and glass are dark",
    ),
    (
        Pass::DenoisingDepth,
        "Denoising Depth",
        "Z",
        "length of the path to the same, each part counting as much as mirrors and glass before it let through; 1e10 where a sample meets nothing",
    ),
    (
        Pass::NoisyImage,
        "Noisy Image",
        "RGBA",
        "the picture before it was denoised",
    ),
    (
        Pass::SampleCount,
        "Debug Sample Count",
        "X",
        "samples of the pixel",
    ),
    (
        Pass::Error,
        "Error",
        "X",
        "estimated error of the pixel, as the 48 pixels around it let expect: the root of the mean over the channels of (x - r)^2 / (r^2 + 0.01); infinite where it is not known",
    ),
    (
        Pass::Cost,
        "Cost",
        "X",
        "nanoseconds that a thread has spent on the pixel",
    ),
    (
        Pass::Aov,
        "AOV",
        "",
        "all passes of the scene's own, each by its name: RGBA of colours, X of numbers; what materials (Blender's AOV Output nodes) and the world tell at the first surface, and at those before it whose opacity is below 0.5",
    ),
];

impl Pass {
    /// Blender's name.
    pub fn name(self) -> &'static str {
        TABLE[self as usize].1
    }

    /// Blender's names of the channels, a letter each.
    pub fn channels(self) -> &'static str {
        TABLE[self as usize].2
    }

    /// What a pass of Cryptomatte is of, and the first of its two ranks.
    pub fn matte(self) -> Option<(Matte, usize)> {
        Some(match self {
            Self::CryptoObject00 => (Matte::Object, 0),
            Self::CryptoObject01 => (Matte::Object, 2),
            Self::CryptoObject02 => (Matte::Object, 4),
            Self::CryptoMaterial00 => (Matte::Material, 0),
            Self::CryptoMaterial01 => (Matte::Material, 2),
            Self::CryptoMaterial02 => (Matte::Material, 4),
            Self::CryptoAsset00 => (Matte::Asset, 0),
            Self::CryptoAsset01 => (Matte::Asset, 2),
            Self::CryptoAsset02 => (Matte::Asset, 4),
            _ => return None,
        })
    }
}

/// A set of passes; `Combined` is always among them. In the order of [`TABLE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passes(u64);

/// What the names of the layers of light groups begin with.
pub fn group_layer_prefix() -> String {
    format!("{}_", Pass::Combined.name())
}

/// Names and channels of the layers of light groups, as Cycles calls them.
pub fn group_layers(groups: &[String]) -> impl Iterator<Item = (String, String)> {
    let name = |group| format!("{}{group}", group_layer_prefix());
    groups.iter().map(move |group| (name(group), "RGB".into()))
}

impl Passes {
    /// The picture alone.
    pub const COMBINED: Self = Self(1);
    /// All that there are.
    pub const ALL: Self = Self((1 << TABLE.len()) - 1);

    /// With one more.
    #[must_use]
    pub const fn with(self, pass: Pass) -> Self {
        Self(self.0 | 1 << pass as u32)
    }

    /// Whether it is in the set.
    pub const fn has(self, pass: Pass) -> bool {
        self.0 & 1 << pass as u32 != 0
    }

    /// All that are in the set.
    pub fn iter(self) -> impl Iterator<Item = Pass> {
        TABLE.iter().map(|row| row.0).filter(move |&p| self.has(p))
    }

    /// Names and channels of their layers; the scene's own passes have others.
    pub fn layers(self) -> impl Iterator<Item = (String, String)> {
        let passes = self.iter().filter(|pass| !pass.channels().is_empty());
        passes.map(|pass| (pass.name().into(), pass.channels().into()))
    }

    /// Whether paths have to keep their light apart (see [`super::light_passes`]).
    pub fn need_light_passes(self) -> bool {
        self.iter().any(|pass| {
            !matches!(
                pass,
                Pass::Combined
                    | Pass::Depth
                    | Pass::Normal
                    | Pass::Position
                    | Pass::Vector
                    | Pass::Mist
                    | Pass::AmbientOcclusion
                    | Pass::ShadowCatcher
                    | Pass::ObjectIndex
                    | Pass::MaterialIndex
                    | Pass::DenoisingAlbedo
                    | Pass::DenoisingNormal
                    | Pass::DenoisingDepth
                    | Pass::NoisyImage
                    | Pass::SampleCount
                    | Pass::Error
                    | Pass::Cost
                    | Pass::Aov
            ) && pass.matte().is_none()
        })
    }

    /// Whether pixels know their objects (see [`super::objects`]).
    pub fn need_objects(self) -> bool {
        self.iter().any(|pass| {
            pass.matte().is_some()
                || matches!(
                    pass,
                    Pass::Mist | Pass::AmbientOcclusion | Pass::ObjectIndex | Pass::MaterialIndex
                )
        })
    }

    /// Whether paths are followed for denoisers (see [`super::features`]).
    pub fn need_features(self) -> bool {
        self.has(Pass::DenoisingAlbedo)
            || self.has(Pass::DenoisingNormal)
            || self.has(Pass::DenoisingDepth)
    }

    /// Whether the ray through the middle of each pixel is asked for.
    pub fn need_middle(self) -> bool {
        self.has(Pass::Depth)
            || self.has(Pass::Position)
            || self.has(Pass::ObjectIndex)
            || self.has(Pass::MaterialIndex)
    }

    /// Floats of a pixel.
    pub fn floats(self) -> usize {
        self.iter().map(|pass| pass.channels().len()).sum()
    }

    /// The set with these names; those of Cryptomatte without a number are all of their numbers.
    ///
    /// # Errors
    /// Names the first unknown one and lists those there are.
    pub fn parse<'a>(mut names: impl Iterator<Item = &'a str>) -> Result<Self, String> {
        names.try_fold(Self::COMBINED, |set, name| {
            let mut meant = TABLE.iter().filter(|row| {
                let numbered = row.0.matte().and_then(|_| row.1.strip_prefix(name));
                row.1 == name || numbered.is_some_and(|number| number.len() == 2)
            });
            let first = meant.next();
            first
                .map(|first| meant.fold(set.with(first.0), |set, row| set.with(row.0)))
                .ok_or_else(|| {
                    let all: Vec<_> = TABLE.iter().map(|row| row.1).collect();
                    format!("there is no pass '{name}'; there are: {}", all.join(", "))
                })
        })
    }
}

impl Default for Passes {
    /// What costs next to nothing.
    fn default() -> Self {
        Self::COMBINED
            .with(Pass::Depth)
            .with(Pass::Normal)
            .with(Pass::Position)
            .with(Pass::SampleCount)
            .with(Pass::Error)
    }
}

impl Serialize for Passes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter().map(Pass::name))
    }
}

impl std::str::FromStr for Passes {
    type Err = String;

    /// `all`, or Blender's names with commas between them; an error says which there are.
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Passes::ALL);
        }
        Passes::parse(text.split(',').map(str::trim))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/film/passes.rs"]
mod tests;
