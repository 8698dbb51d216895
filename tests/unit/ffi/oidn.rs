use super::*;

fn library() -> Library {
    Library::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".native/oidn/lib")).unwrap()
}

/// Grey with noise that depends on the place.
fn noisy(width: u32, height: u32, channels: usize) -> Vec<f32> {
    // The end of MurmurHash3: without the structure that a sequence of multiples would have.
    let random = |i: u32| {
        let i = (i ^ i >> 16).wrapping_mul(0x85eb_ca6b);
        let i = (i ^ i >> 13).wrapping_mul(0xc2b2_ae35);
        (i ^ i >> 16) as f32 / 4_294_967_296.0
    };
    let value = |i: u32| 0.3 + 0.4 * random(i);
    let pixels = (0..width * height).flat_map(|i| vec![value(i); channels]);
    pixels.collect()
}

const FILTER: Filter = Filter {
    hdr: true,
    clean_guides: false,
    quality: Quality::High,
};

fn denoised(threads: usize) -> Vec<f32> {
    let library = library();
    let device = Device::new(&library, threads).unwrap();
    let data = noisy(48, 32, 4);
    let mut out = vec![7.0; data.len()];
    let color = Image {
        data: &data,
        channels: 4,
    };
    device
        .run(
            (48, 32),
            &[(Role::Color, color)],
            (&mut out, 4),
            FILTER,
            &|| false,
        )
        .unwrap();
    out
}

#[test]
fn noise_goes_and_the_fourth_channel_stays() {
    let out = denoised(1);
    let reds: Vec<f32> = out.iter().step_by(4).copied().collect();
    let mean = reds.iter().sum::<f32>() / reds.len() as f32;
    let spread = reds.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / reds.len() as f32;
    // The noise is even over 0.3..0.7, whose deviation is 0.4 / √12 = 0.115.
    assert!((mean - 0.5).abs() < 0.02, "mean {mean}");
    assert!(spread.sqrt() < 0.115 / 3.0, "deviation {}", spread.sqrt());
    assert!(out.iter().skip(3).step_by(4).all(|&alpha| alpha == 7.0));
}

#[test]
fn threads_change_no_bit() {
    let [one, two] = [1, 2].map(denoised);
    assert!(
        one.iter()
            .zip(&two)
            .all(|(a, b)| a.to_bits() == b.to_bits())
    );
}

#[test]
fn images_of_other_sizes_are_refused() {
    let library = library();
    let device = Device::new(&library, 1).unwrap();
    let data = noisy(8, 8, 3);
    let color = Image {
        data: &data,
        channels: 3,
    };
    let mut out = vec![0.0; data.len()];
    for size in [(8, 7), (9, 8), (u32::MAX, u32::MAX)] {
        let run = device.run(
            size,
            &[(Role::Color, color)],
            (&mut out, 3),
            FILTER,
            &|| false,
        );
        assert!(matches!(run, Err(OidnError::Failed(_))), "{size:?}");
    }
}

#[test]
fn who_no_longer_wants_it_ends_it() {
    let library = library();
    let device = Device::new(&library, 1).unwrap();
    let data = noisy(64, 64, 3);
    let color = Image {
        data: &data,
        channels: 3,
    };
    let mut out = vec![0.0; data.len()];
    let run = device.run(
        (64, 64),
        &[(Role::Color, color)],
        (&mut out, 3),
        FILTER,
        &|| true,
    );
    assert_eq!(run, Err(OidnError::Cancelled));
}

#[test]
fn the_version_is_told() {
    assert_eq!(library().version(), "2.5.1");
}

#[test]
fn what_is_not_there_is_named() {
    let error = Library::open(Path::new("/nowhere")).err().unwrap();
    let text = error.to_string();
    assert!(
        text.starts_with("/nowhere/libOpenImageDenoise.so.2 can't be opened: "),
        "{text}"
    );
}
