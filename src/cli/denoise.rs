//! Denoising, as the flags want it.

use super::Failure;
use super::args::Denoising;
use super::progress::Reporter;
use super::summary::as_json;
use crate::denoise::{DenoiseError, Denoiser, Places, Report, Settings};
use crate::ffi::oidn::OidnError;
use crate::output::Metadata;
use crate::render::{Observer, Rendering};
use serde_json::json;

/// What is told of a picture that was not waited for.
pub const INTERRUPTED: &str = "interrupted: the picture is not denoised";

/// The denoiser that the flags ask for.
///
/// # Errors
/// There is none, and it is not optional.
pub fn find(
    flags: &Denoising,
    threads: Option<u32>,
    reporter: &Reporter,
) -> Result<Option<Denoiser>, Failure> {
    if !flags.denoise {
        return Ok(None);
    }
    let settings = Settings {
        prefilter: flags.denoise_prefilter,
        guides: flags.denoise_guides,
        quality: flags.denoise_quality,
        keep_energy: flags.denoise_keep_energy,
        beside: flags.denoise_passes.clone().unwrap_or_default(),
        threads: threads.unwrap_or(0) as usize,
    };
    match Denoiser::find(settings, &Places::of_this_process()) {
        Ok(denoiser) => {
            reporter.say(&denoiser.library());
            Ok(Some(denoiser))
        }
        Err(error) => or_noisy(flags, Failure::new(error.to_string()), reporter),
    }
}

/// A denoiser that is optional leaves the picture noisy.
fn or_noisy<T>(
    flags: &Denoising,
    failure: Failure,
    reporter: &Reporter,
) -> Result<Option<T>, Failure> {
    if !flags.denoise_optional {
        return Err(failure);
    }
    reporter.warn(&format!("the picture stays noisy: {}", failure.message));
    Ok(None)
}

/// Makes sure that a picture with these layers has the passes that are to be denoised.
///
/// # Errors
/// It lacks one.
pub fn check_passes<'a>(
    denoiser: &Denoiser,
    layers: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), Failure> {
    let chosen = denoiser.settings().beside.of(layers);
    chosen
        .map(|_| ())
        .map_err(|error| Failure::usage(error.to_string()))
}

/// Denoises what was rendered.
///
/// # Errors
/// The denoiser fails, and is not optional: the picture is still the noisy one.
pub fn apply(
    flags: &Denoising,
    denoiser: &Denoiser,
    rendering: &mut Rendering,
    reporter: &Reporter,
) -> Result<Option<Report>, Failure> {
    reporter.tell(&json!({ "event": "denoising" }));
    let variances = rendering.luminance_variances.as_deref();
    let cancelled = || reporter.cancelled();
    match denoiser.denoise(&mut rendering.picture, variances, &cancelled) {
        Ok(report) => Ok(Some(report)),
        Err(DenoiseError::Oidn(OidnError::Cancelled)) => {
            reporter.warn(INTERRUPTED);
            Ok(None)
        }
        Err(error) => or_noisy(flags, Failure::new(error.to_string()), reporter),
    }
}

/// Puts what was done to a picture into its metadata.
pub fn tell_in(metadata: &mut Metadata, report: Option<&Report>) {
    if let Some(report) = report {
        metadata.push(("sundog/denoised".into(), as_json(report)));
    }
}
