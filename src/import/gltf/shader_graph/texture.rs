//! Procedural textures of node trees, by Blender's names and properties.

use super::function::Found;
use super::{NodeJson, Refusal};
use crate::nodes::{
    BrickSettings, CyclesVersion, Dimensions, GaborType, GradientType, MagicSettings,
    NoiseSettings, NoiseType, VoronoiFeature, VoronoiHash, VoronoiMetric, VoronoiSettings,
    WaveBandsDirection, WaveProfile, WaveRingsDirection, WaveSettings, WaveType,
};
use crate::scene::graph::Function;
use crate::scene::graph::function::{ProceduralTexture, VoronoiPart};
use std::collections::BTreeSet;

/// The texture of a node, if it is one; `used` are the outputs in use.
pub(super) fn of(
    node: &NodeJson,
    kind: &str,
    output: &str,
    used: &BTreeSet<String>,
    version: CyclesVersion,
) -> Result<Option<Found>, Refusal> {
    // Of most textures: the colour, and a number.
    let mut place = u8::from(output != "Color");
    let texture = match kind {
        "TexNoise" => {
            let settings = NoiseSettings {
                dimensions: node.named("noise_dimensions", Dimensions::from_name)?,
                noise_type: match node.text("noise_type") {
                    // Before 4.1 there was but one.
                    None => NoiseType::Fbm,
                    Some(_) => node.named("noise_type", NoiseType::from_name)?,
                },
                normalize: node.text("noise_type").is_none() || node.is("normalize"),
            };
            if used.contains("Color") {
                ProceduralTexture::Noise(settings)
            } else {
                place = 0;
                ProceduralTexture::NoiseFactor(settings)
            }
        }
        "TexVoronoi" => {
            let part;
            (part, place) = match output {
                "Position" => (VoronoiPart::Position, 0),
                "W" => (VoronoiPart::Position, 1),
                "Radius" => (VoronoiPart::Radius, 0),
                _ => (VoronoiPart::Color, place),
            };
            let settings = VoronoiSettings {
                dimensions: node.named("voronoi_dimensions", Dimensions::from_name)?,
                feature: node.named("feature", VoronoiFeature::from_name)?,
                metric: node.named("distance", VoronoiMetric::from_name)?,
                normalize: node.is("normalize"),
                hash: VoronoiHash::of(version),
            };
            ProceduralTexture::Voronoi { settings, part }
        }
        "TexWave" => ProceduralTexture::Wave(WaveSettings {
            wave_type: node.named("wave_type", WaveType::from_name)?,
            bands_direction: node.named("bands_direction", WaveBandsDirection::from_name)?,
            rings_direction: node.named("rings_direction", WaveRingsDirection::from_name)?,
            profile: node.named("wave_profile", WaveProfile::from_name)?,
        }),
        "TexMagic" => {
            let depth = node.number("turbulence_depth").unwrap_or(2.0) as u8;
            ProceduralTexture::Magic(MagicSettings::of(version, depth))
        }
        "TexBrick" => {
            let number = |name: &str, default: f32| node.number(name).unwrap_or(default);
            ProceduralTexture::Brick(BrickSettings {
                offset: number("offset", 0.5),
                offset_frequency: number("offset_frequency", 2.0) as u8,
                squash: number("squash", 1.0),
                squash_frequency: number("squash_frequency", 2.0) as u8,
                without_sides: BrickSettings::are_without_sides(version),
            })
        }
        "TexChecker" => ProceduralTexture::Checker,
        "TexGradient" => {
            ProceduralTexture::Gradient(node.named("gradient_type", GradientType::from_name)?)
        }
        "TexWhiteNoise" => {
            ProceduralTexture::WhiteNoise(node.named("noise_dimensions", Dimensions::from_name)?)
        }
        "TexGabor" => {
            place = match output {
                "Phase" => 1,
                "Intensity" => 2,
                _ => 0,
            };
            ProceduralTexture::Gabor(node.named("gabor_type", GaborType::from_name)?)
        }
        _ => return Ok(None),
    };
    Ok(Some(Found {
        function: Function::Texture(texture),
        output: place,
        aliases: &[],
    }))
}
