//! Which passes can be denoised beside the picture, and what guides each.

use super::DenoiseError;
use crate::film::{Pass, TABLE, group_layer_prefix};
use serde::Serialize;

/// Whether the albedo of what is seen is part of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Albedo {
    /// Its edges are edges of the light, too.
    IsInIt,
    /// The pass is over the colour, or of no surface: textures in the guide would only be put into it.
    IsNotInIt,
}

/// Which passes are denoised beside the picture.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Choice {
    /// The shadows on shadow catchers alone, as in Cycles.
    #[default]
    AsCycles,
    /// Each that can be.
    All,
    /// These as well, by their names.
    Named(Vec<String>),
}

/// How a pass is denoised; `None` if it holds no light, or is the picture itself.
pub fn albedo_in(name: &str) -> Option<Albedo> {
    if name.starts_with(&group_layer_prefix()) {
        return Some(Albedo::IsInIt);
    }
    let pass = TABLE.iter().find(|row| row.1 == name)?.0;
    Some(match pass {
        // Light over the colour of the surface that the camera sees.
        Pass::DiffuseDirect
        | Pass::DiffuseIndirect
        | Pass::GlossyDirect
        | Pass::TransmissionDirect
        // Of no surface.
        | Pass::VolumeDirect
        | Pass::VolumeIndirect
        // Without colours.
        | Pass::AmbientOcclusion
        | Pass::ShadowCatcher => Albedo::IsNotInIt,
        // The guides look through mirrors and glass, and so do these.
        Pass::GlossyIndirect
        | Pass::TransmissionIndirect
        | Pass::Emission
        | Pass::Environment => Albedo::IsInIt,
        _ => return None,
    })
}

/// What a pass is called before it was denoised: as Cycles calls its shadow catchers.
pub fn noisy_name(name: &str) -> String {
    format!("Noisy {name}")
}

impl Choice {
    /// The names among a picture's layers.
    ///
    /// # Errors
    /// One that is named is not there, or holds no light.
    pub fn of<'a>(
        &self,
        layers: impl Iterator<Item = &'a str> + Clone,
    ) -> Result<Vec<&'a str>, DenoiseError> {
        if let Self::Named(names) = self {
            for name in names {
                let is_there = layers.clone().any(|layer| layer == name);
                if !is_there || albedo_in(name).is_none() {
                    let able = layers.filter(|layer| albedo_in(layer).is_some());
                    let able: Vec<_> = able.map(String::from).collect();
                    return Err(DenoiseError::NoSuchPass {
                        wanted: name.clone(),
                        able: able.join(", "),
                    });
                }
            }
        }
        let is_chosen = |name: &str| match self {
            Self::AsCycles => name == Pass::ShadowCatcher.name(),
            Self::All => true,
            Self::Named(names) => {
                name == Pass::ShadowCatcher.name() || names.iter().any(|wanted| wanted == name)
            }
        };
        let able = layers.filter(|layer| albedo_in(layer).is_some());
        Ok(able.filter(|layer| is_chosen(layer)).collect())
    }
}

impl std::str::FromStr for Choice {
    type Err = std::convert::Infallible;

    /// `all`, or names with commas between them.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text == "all" {
            return Ok(Self::All);
        }
        let names = text
            .split(',')
            .map(str::trim)
            .filter(|name| !name.is_empty());
        Ok(Self::Named(names.map(String::from).collect()))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/denoise/passes.rs"]
mod tests;
