use super::*;

fn layer_of(pass: Pass, value: impl Fn(usize) -> f32, pixels: usize) -> Layer {
    let channels = pass.channels();
    Layer {
        name: pass.name().into(),
        channels: channels.chars().map(String::from).collect(),
        data: (0..pixels * channels.len()).map(value).collect(),
    }
}

/// 64 × 48 noisy grey pixels of 0.5 over an even surface.
fn picture() -> Picture {
    let noise = |i: usize| {
        // The end of MurmurHash3: without the structure that a sequence of multiples would have.
        let mut hash = i as u32 / 4;
        hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
        hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
        0.3 + 0.4 * ((hash ^ hash >> 16) as f32 / 4_294_967_296.0)
    };
    let rgba = |i: usize| if i % 4 == 3 { 0.75 } else { noise(i) };
    Picture {
        width: 64,
        height: 48,
        layers: vec![
            layer_of(Pass::Combined, rgba, 64 * 48),
            layer_of(Pass::DenoisingAlbedo, |_| 0.8, 64 * 48),
            layer_of(Pass::DenoisingNormal, |i| [0.0, 0.0, -1.0][i % 3], 64 * 48),
            layer_of(Pass::NoisyImage, rgba, 64 * 48),
        ],
    }
}

fn denoiser(settings: Settings) -> Denoiser {
    Denoiser::find(settings, &Places::of_this_process()).unwrap()
}

#[test]
fn the_first_layer_is_denoised_and_all_else_stays() {
    for prefilter in [Prefilter::None, Prefilter::Fast, Prefilter::Accurate] {
        for guides in [Guides::None, Guides::Albedo, Guides::AlbedoNormal] {
            let settings = Settings {
                prefilter,
                guides,
                ..Settings::default()
            };
            let mut picture = picture();
            let before = picture.clone();
            let variances = vec![0.01; 64 * 48];
            let report = denoiser(settings).denoise(&mut picture, Some(&variances), &|| false);
            let shift = report.unwrap().shift.unwrap();
            assert!(shift.mean.abs() < 0.05, "{shift:?}");
            for (layer, was) in picture.layers.iter().zip(&before.layers).skip(1) {
                assert_eq!(layer.data, was.data);
            }
            let reds: Vec<f32> = picture.layers[0].data.iter().step_by(4).copied().collect();
            let mean = reds.iter().sum::<f32>() / reds.len() as f32;
            let spread = reds.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / reds.len() as f32;
            // A third of the noise's deviation, 0.4 / √12.
            assert!(spread.sqrt() < 0.04, "{prefilter:?} {guides:?}: {spread}");
            assert!(picture.colors().all(|[.., alpha]| alpha == 0.75));
        }
    }
}

#[test]
fn energy_is_kept_on_request() {
    let settings = Settings {
        keep_energy: true,
        ..Settings::default()
    };
    let mut picture = picture();
    let report = denoiser(settings).denoise(&mut picture, Some(&vec![0.01; 64 * 48]), &|| false);
    let shift = report.unwrap().shift.unwrap();
    assert!(shift.mean.abs() < 1e-6, "{shift:?}");
}

#[test]
fn a_picture_without_the_guides_stays_and_is_told() {
    let mut picture = picture();
    picture.layers.remove(2);
    let before = picture.layers[0].data.clone();
    let error = denoiser(Settings::default()).denoise(&mut picture, None, &|| false);
    assert_eq!(
        error.unwrap_err().to_string(),
        "the picture has no pass Denoising Normal to be denoised by"
    );
    let error = denoiser(Settings::default()).denoise(&mut self::picture(), None, &|| true);
    assert!(matches!(
        error,
        Err(DenoiseError::Oidn(OidnError::Cancelled))
    ));
    assert_eq!(picture.layers[0].data, before);
}

#[test]
fn settings_name_the_passes_that_they_need() {
    let wanted = Settings::default().passes(Passes::COMBINED);
    let names: Vec<_> = wanted.iter().map(Pass::name).collect();
    assert_eq!(
        names,
        [
            "Combined",
            "Denoising Albedo",
            "Denoising Normal",
            "Noisy Image"
        ]
    );
    let alone = Settings {
        guides: Guides::None,
        ..Settings::default()
    };
    assert_eq!(
        alone.passes(Passes::COMBINED),
        Passes::COMBINED.with(Pass::NoisyImage)
    );
}
