//! Takes the noise out of a finished picture with Open Image Denoise, and measures what that did to its brightness.
//!
//! The colour is denoised in linear light, with albedo and normal as guides; by default the guides are denoised first, each by
//! itself, as Cycles does it. The noisy picture stays beside the denoised one. A denoiser is no estimator: it moves light, or
//! loses it. How much is measured against the noisy picture, whose mean is right ([`shift`]), and can be given back ([`energy`]).

pub mod energy;
mod guided;
pub mod halves;
mod library;
pub mod passes;
pub mod shift;

pub use halves::HalvesError;
pub use library::{NotFound, Places};
pub use passes::Choice;
pub use shift::Shift;

use crate::ffi::oidn::{Library, OidnError, Role};
use crate::film::{Layer, Pass, Passes, Picture};
use guided::Guided;
use passes::{Albedo, albedo_in, noisy_name};
use serde::Serialize;
use std::time::{Duration, Instant};

pub use crate::ffi::oidn::Quality;

/// How noise in the guides is met, by Cycles' names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Prefilter {
    /// They are taken to have none.
    None,
    /// The denoiser is told that they are noisy.
    Fast,
    /// They are denoised first.
    #[default]
    Accurate,
}

/// Which passes guide the denoiser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Guides {
    /// None: the colour alone.
    None,
    /// The albedo.
    Albedo,
    /// Albedo and normal.
    #[default]
    AlbedoNormal,
}

impl Guides {
    /// Each guide's pass, and what it is to the library.
    fn passes(self) -> &'static [(Pass, Role)] {
        const BOTH: [(Pass, Role); 2] = [
            (Pass::DenoisingAlbedo, Role::Albedo),
            (Pass::DenoisingNormal, Role::Normal),
        ];
        match self {
            Self::None => &[],
            Self::Albedo => &BOTH[..1],
            Self::AlbedoNormal => &BOTH,
        }
    }
}

/// How a picture is denoised.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Settings {
    /// Noise in the guides.
    pub prefilter: Prefilter,
    /// Which there are.
    pub guides: Guides,
    /// Work.
    pub quality: Quality,
    /// Brightness is given back ([`energy`]).
    pub keep_energy: bool,
    /// Passes that are denoised beside the picture.
    #[serde(skip)]
    pub beside: Choice,
    /// Threads; 0 for all.
    #[serde(skip)]
    pub threads: usize,
}

impl Settings {
    /// The passes that a picture has to have beside those that somebody wants.
    #[must_use]
    pub fn passes(&self, wanted: Passes) -> Passes {
        let guides = self.guides.passes().iter();
        guides.fold(wanted.with(Pass::NoisyImage), |all, (pass, _)| {
            all.with(*pass)
        })
    }
}

/// Why a picture could not be denoised.
#[derive(Debug, thiserror::Error)]
pub enum DenoiseError {
    /// The library said no.
    #[error(transparent)]
    Oidn(#[from] OidnError),
    /// It has not the passes that [`Settings::passes`] names.
    #[error("the picture has no pass {0} to be denoised by")]
    Pass(&'static str),
    /// The same of parts that are to be joined.
    #[error("the parts have no pass {0} to be denoised by; render each of them with --denoise")]
    Parts(&'static str),
    /// A pass that is to be denoised is not there, or is none of light.
    #[error(
        "--denoise-passes names {wanted}, which the picture has not as a pass of light; those that it has: {}; --passes asks for more",
        if able.is_empty() { "none" } else { able }
    )]
    NoSuchPass {
        /// Its name.
        wanted: String,
        /// Those that can be denoised.
        able: String,
    },
}

/// What was done to a picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The library's version.
    pub library: String,
    /// How it was done.
    #[serde(flatten)]
    pub settings: Settings,
    /// Time that it took.
    pub time: Duration,
    /// Passes that were denoised beside the picture.
    pub passes: Vec<String>,
    /// What it did to the brightness; not known where the noise is not.
    pub shift: Option<Shift>,
    /// How far the denoised picture is from the truth, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<HalvesError>,
}

/// Denoises pictures.
pub struct Denoiser {
    library: Library,
    settings: Settings,
}

impl Denoiser {
    /// With the library that is found first.
    ///
    /// # Errors
    /// There is none that can be opened.
    pub fn find(settings: Settings, places: &Places) -> Result<Self, NotFound> {
        Ok(Self {
            library: places.open()?,
            settings,
        })
    }

    /// How it denoises.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Where the library was found, and its version.
    pub fn library(&self) -> String {
        let (version, path) = (self.library.version(), self.library.path());
        format!("Open Image Denoise {version} ({})", path.display())
    }

    /// Makes sure that parts with these passes have what joining them for this denoiser takes.
    ///
    /// # Errors
    /// They lack a pass.
    pub fn check_parts(&self, passes: &[String]) -> Result<(), DenoiseError> {
        let needed = self.settings.passes(Passes::COMBINED);
        let mut needed = needed.iter().map(Pass::name);
        let missing = needed.find(|needed| !passes.iter().any(|name| name == needed));
        missing.map_or(Ok(()), |pass| Err(DenoiseError::Parts(pass)))
    }

    /// Denoises the colours of a picture that has the passes of [`Settings::passes`]; alpha stays, and so does everything if
    /// this fails. `variances` are those of the pixels' luminances. `cancelled` is asked now and then.
    ///
    /// # Errors
    /// It lacks a pass, or the library fails or was told to stop.
    pub fn denoise(
        &self,
        picture: &mut Picture,
        variances: Option<&[f32]>,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Report, DenoiseError> {
        let begun = Instant::now();
        let size = (picture.width, picture.height);
        let noisy = layer(picture, Pass::NoisyImage)?;
        let guided = Guided::new(&self.library, &self.settings, picture, cancelled)?;
        let mut denoised = guided.light(&noisy.data, noisy.channels.len(), Albedo::IsInIt)?;
        let beside = self.beside(picture, &guided)?;
        drop(guided);
        let pair = shift::Pair {
            size,
            noisy: &noisy.data,
            variances,
        };
        if self.settings.keep_energy {
            energy::give_back(&pair, &mut denoised);
        }
        let shift = pair.shift(&denoised);
        let mut names = Vec::new();
        for (index, data) in beside {
            let layer = &mut picture.layers[index];
            let noisy = Layer {
                name: noisy_name(&layer.name),
                channels: layer.channels.clone(),
                data: std::mem::replace(&mut layer.data, data),
            };
            names.push(layer.name.clone());
            picture.layers.push(noisy);
        }
        if let Some(first) = picture.layers.first_mut() {
            first.data = denoised;
        }
        Ok(Report {
            library: self.library.version(),
            settings: self.settings.clone(),
            time: begun.elapsed(),
            passes: names,
            shift,
            error: None,
        })
    }

    /// The passes that are denoised beside the picture, by the numbers of their layers.
    fn beside(
        &self,
        picture: &Picture,
        guided: &Guided,
    ) -> Result<Vec<(usize, Vec<f32>)>, DenoiseError> {
        let names = picture.layers.iter().map(|layer| layer.name.as_str());
        let chosen = self.settings.beside.of(names)?;
        let mut denoised = Vec::new();
        for (index, layer) in picture.layers.iter().enumerate() {
            let Some(albedo) = albedo_in(&layer.name) else {
                continue;
            };
            if !chosen.contains(&layer.name.as_str()) {
                continue;
            }
            let channels = layer.channels.len();
            let mut light = guided.light(&layer.data, channels, albedo)?;
            // The noise of its pixels is not known, so that of blocks is not: the mean alone is certain.
            if self.settings.keep_energy {
                energy::give_back_means(&layer.data, &mut light, channels);
            }
            denoised.push((index, light));
        }
        Ok(denoised)
    }

    /// Both halves of a picture's samples, denoised each by itself with the guides of `picture`.
    ///
    /// # Errors
    /// As [`denoise`](Self::denoise).
    pub fn halves(
        &self,
        picture: &Picture,
        halves: [&Picture; 2],
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<[Picture; 2], DenoiseError> {
        let guided = Guided::new(&self.library, &self.settings, picture, cancelled)?;
        let denoised = |half: &Picture| {
            let noisy = layer(half, Pass::Combined)?;
            let data = guided.light(&noisy.data, noisy.channels.len(), Albedo::IsInIt)?;
            Ok::<_, DenoiseError>(Picture {
                layers: vec![Layer {
                    data,
                    ..noisy.clone()
                }],
                ..*half
            })
        };
        Ok([denoised(halves[0])?, denoised(halves[1])?])
    }
}

/// The layer of a pass.
fn layer(picture: &Picture, pass: Pass) -> Result<&Layer, DenoiseError> {
    let mut layers = picture.layers.iter();
    let found = layers.find(|layer| layer.name == pass.name());
    found.ok_or(DenoiseError::Pass(pass.name()))
}

#[cfg(test)]
#[path = "../../tests/unit/denoise/mod.rs"]
mod tests;
