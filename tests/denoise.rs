//! Pictures denoised by the real library, and the features that guide it.

use glam::{DAffine3, DVec3};
use std::sync::Mutex;
use sundog::denoise::shift::{self, Block, Pair, Shift};
use sundog::denoise::{Denoiser, HalvesError, Places, Settings};
use sundog::film::{Bands, Layer, Pass, Passes, Picture};
use sundog::math::LUMINANCE;
use sundog::math::float::TWO_SIDED_95;
use sundog::measure::{self, Encoding, RgbImage};
use sundog::render::{Event, Observer, Passed, RenderSettings, Rendering, Silent, Stop, render};
use sundog::scene::{MetallicRoughness, Scene};
use sundog::selftest::kit;

/// A box of five walls under a lamp, with a mirror and a sphere of glass in it.
fn cornell() -> Scene {
    let mut scene = Scene {
        cameras: vec![kit::camera(DVec3::new(0.0, 0.0, 3.4), 0.7)],
        ..Scene::default()
    };
    let here = &[DAffine3::IDENTITY][..];
    let white = kit::diffuse([0.7; 3]);
    let (x, y, z) = ([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, -2.0]);
    let back = kit::quad([-1.0, -1.0, -1.0], x, y);
    let floor = kit::quad([-1.0, -1.0, 1.0], x, z);
    let ceiling = kit::quad([-1.0, 1.0, -1.0], x, [0.0, 0.0, 2.0]);
    for wall in [back, floor, ceiling] {
        kit::place(&mut scene, wall, white.clone(), here);
    }
    let red = kit::diffuse([0.6, 0.05, 0.05]);
    let green = kit::diffuse([0.1, 0.5, 0.1]);
    kit::place(&mut scene, kit::quad([-1.0, -1.0, 1.0], z, y), red, here);
    kit::place(
        &mut scene,
        kit::quad([1.0, -1.0, -1.0], [0.0, 0.0, 2.0], y),
        green,
        here,
    );
    let lamp = MetallicRoughness {
        emission: [12.0; 3],
        ..kit::diffuse([0.0; 3])
    };
    let shining = kit::quad([-0.3, 0.99, -0.3], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6]);
    kit::place(&mut scene, shining, lamp, here);
    let mirror = MetallicRoughness {
        base_color: [0.9, 0.9, 0.9],
        metallic: 1.0,
        roughness: 0.0,
        ..MetallicRoughness::default()
    };
    let standing = kit::quad([-0.9, -0.9, -0.6], [0.7, 0.0, -0.2], [0.0, 1.2, 0.0]);
    kit::place(&mut scene, standing, mirror, here);
    let ball = DAffine3::from_translation(DVec3::new(0.4, -0.6, 0.0))
        * DAffine3::from_scale(DVec3::splat(0.38));
    let sphere = kit::sphere(24, 0.0, true);
    kit::place(&mut scene, sphere, kit::glass(0.0, 1.5), &[ball]);
    scene
}

fn settings(samples: u32, passes: Passes) -> RenderSettings {
    RenderSettings {
        width: 128,
        height: 128,
        samples,
        bounces: 6,
        passes,
        ..RenderSettings::default()
    }
}

fn rendered(samples: u32, seed: u32, passes: Passes) -> Rendering {
    let settings = RenderSettings {
        seed,
        ..settings(samples, passes)
    };
    render(&cornell(), &settings, &Silent).unwrap()
}

fn denoiser(settings: Settings) -> Denoiser {
    Denoiser::find(settings, &Places::of_this_process()).unwrap()
}

fn layer(picture: &Picture, pass: Pass) -> &Layer {
    let mut layers = picture.layers.iter();
    layers.find(|layer| layer.name == pass.name()).unwrap()
}

fn bits(data: &[f32]) -> Vec<u32> {
    data.iter().map(|value| value.to_bits()).collect()
}

/// Of 16 samples a pixel against 256 of another seed, on the same box: noise of the reference makes the errors more alike.
#[test]
fn a_denoised_picture_is_nearer_to_the_truth_and_the_noisy_one_stays() {
    let passes = Settings::default().passes(Passes::COMBINED);
    let reference = rendered(256, 7, Passes::COMBINED).picture;
    let plain = rendered(16, 0, Passes::COMBINED).picture;
    let noisy = rendered(16, 0, passes);
    let denoised = |settings: Settings| {
        let mut rendering = noisy.clone();
        let variances = rendering.luminance_variances.clone();
        let report = denoiser(settings)
            .denoise(&mut rendering.picture, variances.as_deref(), &|| false)
            .unwrap();
        (rendering.picture, report)
    };
    let (first, report) = denoised(Settings::default());
    let (again, _) = denoised(Settings {
        threads: 1,
        ..Settings::default()
    });
    assert_eq!(
        bits(&first.layers[0].data),
        bits(&again.layers[0].data),
        "bits depend on the run or on the threads"
    );
    for picture in [&first, &noisy.picture] {
        let kept = layer(picture, Pass::NoisyImage);
        assert_eq!(bits(&kept.data), bits(&plain.layers[0].data));
    }
    let [before, after] = [&plain, &first].map(|picture| kit::rel_mse(picture, &reference));
    assert!(after < before / 2.0, "relMSE {before} became {after}");

    // The stated shift is that from the noisy mean; the true one lies in its interval.
    let shift = report.shift.unwrap();
    let luminance = |picture: &Picture| -> f64 {
        let pixels = kit::colors(picture);
        pixels
            .map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b)
            .sum()
    };
    let truth = luminance(&first) / luminance(&reference) - 1.0;
    let stated = luminance(&first) / luminance(&plain) - 1.0;
    assert!((shift.mean - stated).abs() < 1e-6, "{shift:?} and {stated}");
    // The reference has noise, too: a quarter of that of 16 samples.
    let interval = 1.5 * shift.mean_interval;
    assert!(
        (truth - shift.mean).abs() < interval,
        "{shift:?}, truly {truth}"
    );

    let (kept, report) = denoised(Settings {
        keep_energy: true,
        ..Settings::default()
    });
    let shift = report.shift.unwrap();
    assert!(shift.mean.abs() < 1e-6, "{shift:?}");
    let after_kept = kit::rel_mse(&kept, &reference);
    assert!(
        after_kept < before / 2.0,
        "relMSE {before} became {after_kept}"
    );
}

/// Passes of light by their own guides: nearer to the truth, and the noisy ones beside them as they were.
#[test]
fn passes_are_denoised_on_request_and_stay_beside_as_they_were() {
    let light = [
        Pass::DiffuseDirect,
        Pass::DiffuseIndirect,
        Pass::GlossyIndirect,
    ];
    let own = Settings {
        beside: "DiffDir,DiffInd,GlossInd".parse().unwrap(),
        ..Settings::default()
    };
    let wanted = light
        .iter()
        .fold(Passes::COMBINED, |all, pass| all.with(*pass));
    let wanted = wanted.with(Pass::Depth);
    let reference = rendered(256, 7, wanted).picture;
    let noisy = rendered(16, 0, own.passes(wanted)).picture;
    let mut picture = noisy.clone();
    let report = denoiser(own)
        .denoise(&mut picture, None, &|| false)
        .unwrap();
    assert_eq!(report.passes, ["DiffDir", "DiffInd", "GlossInd"]);
    for pass in light {
        let name = format!("Noisy {}", pass.name());
        let beside = picture
            .layers
            .iter()
            .find(|layer| layer.name == name)
            .unwrap();
        assert_eq!(bits(&beside.data), bits(&layer(&noisy, pass).data));
        let off = |of: &Picture| -> f64 {
            let pairs = layer(of, pass)
                .data
                .iter()
                .zip(&layer(&reference, pass).data);
            pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum()
        };
        let (before, after) = (off(&noisy), off(&picture));
        // Light over the colour of edges, of which few samples know anything, makes most of the error.
        assert!(after < 0.9 * before, "{name}: {before} became {after}");
    }
    for same in [Pass::Depth, Pass::DenoisingAlbedo] {
        assert_eq!(
            bits(&layer(&noisy, same).data),
            bits(&layer(&picture, same).data)
        );
    }
}

/// Says that the error is the reciprocal of the samples, and keeps what it was shown.
#[derive(Default)]
struct Watching(Mutex<Vec<(f64, f64)>>);

impl Observer for Watching {
    fn event(&self, _: &Event) {}
    fn cancelled(&self) -> bool {
        false
    }
    fn denoised_error(
        &self,
        film: &dyn Bands,
        halves: [&dyn Bands; 2],
        passed: &Passed,
    ) -> Option<f64> {
        let [whole, first, second] = [film, halves[0], halves[1]].map(Picture::collect);
        let sides = kit::colors(&first).zip(kit::colors(&second));
        let pixels = kit::colors(&whole).zip(sides);
        let off = pixels.map(|(whole, (first, second))| {
            let mean = |c: usize| (first[c] + second[c]) / 2.0;
            (0..3)
                .map(|c| (mean(c) - whole[c]).abs())
                .fold(0.0, f64::max)
        });
        let off = off.fold(0.0, f64::max);
        self.0.lock().unwrap().push((passed.samples, off));
        Some(1.0 / passed.samples)
    }
}

/// It is asked from 8 samples on, when there are enough new ones, and shown two halves whose mean is the picture.
#[test]
fn a_render_stops_at_the_error_of_the_denoised_picture() {
    let with_target = |denoised_target: f64| RenderSettings {
        width: 16,
        height: 16,
        denoised_target,
        ..settings(512, Passes::COMBINED)
    };
    let watching = Watching::default();
    let rendering = render(&cornell(), &with_target(1.0 / 100.0), &watching).unwrap();
    assert_eq!(rendering.statistics.stop, Stop::DenoisedError);
    let shown = watching.0.into_inner().unwrap();
    let samples: Vec<_> = shown.iter().map(|(samples, _)| *samples).collect();
    assert_eq!(samples, [8.0, 16.0, 32.0, 64.0, 128.0]);
    assert!(shown.iter().all(|(_, off)| *off < 1e-4), "{shown:?}");
    // Without a target nobody is asked.
    let watching = Watching::default();
    let rendering = render(
        &cornell(),
        &RenderSettings {
            samples: 16,
            ..with_target(0.0)
        },
        &watching,
    )
    .unwrap();
    assert_eq!(rendering.statistics.stop, Stop::Samples);
    assert!(watching.0.into_inner().unwrap().is_empty());
}

/// A picture with so many samples, and what denoising made of it and of its halves.
struct Look {
    samples: u32,
    noisy: RgbImage,
    denoised: RgbImage,
    shift: Shift,
    pair_blocks: Vec<Block>,
    halves: HalvesError,
}

/// Keeps a picture and its halves whenever it is asked for their error, from 8 samples on.
#[derive(Default)]
struct Keeping(Mutex<Vec<(u32, [Picture; 3])>>);

impl Observer for Keeping {
    fn event(&self, _: &Event) {}
    fn cancelled(&self) -> bool {
        false
    }
    fn denoised_error(
        &self,
        film: &dyn Bands,
        halves: [&dyn Bands; 2],
        passed: &Passed,
    ) -> Option<f64> {
        let pictures = [film, halves[0], halves[1]].map(Picture::collect);
        self.0.lock().unwrap().push((passed.least, pictures));
        None
    }
}

fn rgb(picture: &Picture, pass: Pass) -> RgbImage {
    let pixels = layer(picture, pass).data.chunks(4);
    RgbImage {
        width: picture.width,
        height: picture.height,
        pixels: pixels.map(|c| [c[0], c[1], c[2]]).collect(),
        encoding: Encoding::Linear,
    }
}

/// Mean FLIP as the sRGB curve shows both.
fn flip(test: &RgbImage, reference: &RgbImage) -> f64 {
    let map = measure::flip_map([test, reference, &test.shown(), &reference.shown()]);
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}

/// All looks at the picture of a seed.
fn looks(scene: &Scene, side: u32, samples: u32, seed: u32) -> Vec<Look> {
    let own = Settings::default();
    let settings = RenderSettings {
        width: side,
        height: side,
        seed,
        denoised_target: f64::MIN_POSITIVE,
        ..settings(samples, own.passes(Passes::COMBINED))
    };
    let keeping = Keeping::default();
    render(scene, &settings, &keeping).unwrap();
    let denoiser = denoiser(own);
    let look = |(samples, [whole, first, second]): (u32, [Picture; 3])| {
        let levels = [&first, &second].map(|half| {
            let colors = kit::colors(half);
            colors.map(|c| c.iter().zip(LUMINANCE).map(|(v, w)| v * w).sum::<f64>())
        });
        let [a, b] = levels;
        let variances: Vec<f32> = a
            .zip(b)
            .map(|(a, b)| ((a - b) / 2.0).powi(2) as f32)
            .collect();
        let halves = denoiser.halves(&whole, [&first, &second], &|| false);
        let [a, b] = halves.unwrap().map(|half| rgb(&half, Pass::Combined));
        let mut picture = whole;
        let report = denoiser.denoise(&mut picture, Some(&variances), &|| false);
        let pair = Pair {
            size: (side, side),
            noisy: &layer(&picture, Pass::NoisyImage).data,
            variances: Some(&variances),
        };
        Look {
            samples,
            noisy: rgb(&picture, Pass::NoisyImage),
            denoised: rgb(&picture, Pass::Combined),
            shift: report.unwrap().shift.unwrap(),
            pair_blocks: pair.blocks(&layer(&picture, Pass::Combined).data),
            halves: HalvesError::new(flip(&a, &b), f64::from(samples)),
        }
    };
    keeping
        .0
        .into_inner()
        .unwrap()
        .into_iter()
        .map(look)
        .collect()
}

/// What was told, and how much of it held.
#[derive(Clone, Copy, Default)]
struct Held {
    told: f64,
    held: f64,
}

impl Held {
    fn tell(&mut self, holds: bool) {
        self.told += 1.0;
        self.held += f64::from(u8::from(holds));
    }

    fn share(self) -> f64 {
        self.held / self.told
    }
}

/// The intervals that hold the truth: of the shift of the whole, of all blocks, of the block that is told, and of FLIP. The truth of a
/// seed is the mean of the others at the most samples. Its own noise is as large as a picture's of all of their samples; intervals are
/// wider by that.
fn calibration(name: &str, scene: &Scene, side: u32, samples: u32, seeds: u32) -> [Held; 4] {
    let all: Vec<Vec<Look>> = (0..seeds)
        .map(|seed| looks(scene, side, samples, seed))
        .collect();
    let others = f64::from(seeds - 1);
    let mut held = [Held::default(); 4];
    for (own, looks) in all.iter().enumerate() {
        let mut truth = vec![[0.0f64; 3]; (side * side) as usize];
        for (_, of) in all.iter().enumerate().filter(|(seed, _)| *seed != own) {
            for (sum, pixel) in truth.iter_mut().zip(&of[of.len() - 1].noisy.pixels) {
                *sum = [0, 1, 2].map(|c| sum[c] + f64::from(pixel[c]) / others);
            }
        }
        let truth = RgbImage {
            pixels: truth.iter().map(|c| c.map(|v| v as f32)).collect(),
            ..looks[0].noisy.clone()
        };
        let rgba: Vec<f32> = truth
            .pixels
            .iter()
            .flat_map(|c| [c[0], c[1], c[2], 1.0])
            .collect();
        for look in looks {
            let wider = (1.0 + f64::from(look.samples) / (others * f64::from(samples))).sqrt();
            // As if the truth were a denoised picture: what is off is the noisy picture's error.
            let pair = Pair {
                size: (side, side),
                noisy: &look
                    .noisy
                    .pixels
                    .iter()
                    .flat_map(|c| [c[0], c[1], c[2], 1.0])
                    .collect::<Vec<_>>(),
                variances: Some(&vec![0.0; truth.pixels.len()]),
            };
            let error = pair.shift(&rgba).unwrap();
            held[0].tell(error.mean.abs() <= wider * look.shift.mean_interval);
            let blocks = look.pair_blocks.iter().zip(pair.blocks(&rgba));
            for (told, with_truth) in blocks {
                let off = (with_truth.denoised - told.noisy).abs();
                held[1].tell(off <= wider * TWO_SIDED_95 * told.variance.sqrt());
            }
            let largest = look.shift.largest;
            let across = side.div_ceil(shift::BLOCK);
            let at = (largest.y / shift::BLOCK * across + largest.x / shift::BLOCK) as usize;
            let (told, with_truth) = (look.pair_blocks[at], pair.blocks(&rgba)[at]);
            let level = (told.denoised - told.noisy) / largest.shift;
            let off = (with_truth.denoised - told.noisy).abs() / level;
            held[2].tell(off <= wider * largest.interval);
            let seen = flip(&look.denoised, &truth);
            held[3].tell((look.halves.low..=look.halves.high).contains(&seen));
        }
    }
    let [whole, blocks, largest, seen] = held.map(Held::share);
    println!(
        "{name}: of the intervals of the whole {whole:.3} hold the truth, of blocks {blocks:.3}, of the largest {largest:.3}, of FLIP {seen:.3}"
    );
    held
}

/// Of 24 seeds with 8 and 16 samples, which are not independent of each other: a share of 0.95 has a deviation of 0.045 of 24.
#[test]
fn what_is_told_of_the_denoised_picture_is_true() {
    let [whole, blocks, largest, seen] =
        calibration("box", &cornell(), 48, 16, 24).map(Held::share);
    assert!(whole >= 0.86, "{whole}");
    assert!((0.90..=0.99).contains(&blocks), "{blocks}");
    assert!(largest >= 0.86, "{largest}");
    assert!(seen >= 0.86, "{seen}");
}

/// Tinted glass tells denoisers what is behind it by its colour, as in Cycles: each of two boundaries hands on F + (1 − F) √tint, F being
/// 0.034.
#[test]
fn features_have_the_tint_of_glass() {
    let mut scene = Scene {
        cameras: vec![kit::camera(DVec3::new(0.0, 0.0, 3.0), 0.2)],
        ..Scene::default()
    };
    let tinted = MetallicRoughness {
        base_color: [0.8, 0.2, 0.1],
        ..kit::glass(0.0, 1.45)
    };
    kit::place(
        &mut scene,
        kit::sphere(24, 0.0, true),
        tinted,
        &[DAffine3::IDENTITY],
    );
    let wall = kit::quad([-40.0, -40.0, -3.0], [80.0, 0.0, 0.0], [0.0, 80.0, 0.0]);
    kit::place(
        &mut scene,
        wall,
        kit::diffuse([0.5; 3]),
        &[DAffine3::IDENTITY],
    );
    let settings = RenderSettings {
        width: 16,
        height: 16,
        samples: 64,
        passes: Passes::COMBINED.with(Pass::DenoisingAlbedo),
        ..RenderSettings::default()
    };
    let picture = render(&scene, &settings, &Silent).unwrap().picture;
    let layer = layer(&picture, Pass::DenoisingAlbedo);
    let pixels = layer.data.chunks(layer.channels.len());
    let count = (16 * 16) as f32;
    let albedo = pixels.fold([0.0; 3], |sum, of| {
        [0, 1, 2].map(|c| sum[c] + of[c] / count)
    });
    let reflected: f32 = 0.034;
    let handed_on = |tint: f32| (reflected + (1.0 - reflected) * tint.sqrt()).powi(2);
    // How many paths meet the wall is the same for all colours.
    for (found, tint) in albedo.iter().zip([0.8, 0.2, 0.1]).skip(1) {
        let wanted = handed_on(tint) / handed_on(0.8);
        let found = found / albedo[0];
        assert!(
            (found / wanted - 1.0).abs() < 0.02,
            "{albedo:?}, {found} for {wanted}"
        );
    }
}

/// The floor that a mirror and a sphere of glass show is the floor to a denoiser.
#[test]
fn features_are_those_of_what_mirrors_and_glass_show() {
    let passes = Passes::COMBINED
        .with(Pass::DenoisingAlbedo)
        .with(Pass::DenoisingNormal)
        .with(Pass::DenoisingDepth);
    let mut scene = Scene {
        cameras: vec![kit::camera(DVec3::new(0.0, 0.0, 2.0), 0.4)],
        ..Scene::default()
    };
    // Left: a mirror of 80 % at 45°, which shows a red wall at the left. Right: the wall behind.
    let mirror = MetallicRoughness {
        base_color: [0.8; 3],
        metallic: 1.0,
        roughness: 0.0,
        ..MetallicRoughness::default()
    };
    let here = &[DAffine3::IDENTITY][..];
    let tilted = kit::quad([-1.0, -1.0, -2.0], [1.0, 0.0, 1.0], [0.0, 2.0, 0.0]);
    kit::place(&mut scene, tilted, mirror, here);
    let left = kit::quad([-5.0, -9.0, 9.0], [0.0, 0.0, -18.0], [0.0, 18.0, 0.0]);
    kit::place(&mut scene, left, kit::diffuse([0.5, 0.1, 0.2]), here);
    let back = kit::quad([0.0, -9.0, -3.0], [9.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    kit::place(&mut scene, back, kit::diffuse([0.3; 3]), here);
    scene.environment = kit::constant_environment(1.0);
    let settings = RenderSettings {
        width: 32,
        height: 32,
        samples: 16,
        passes,
        ..RenderSettings::default()
    };
    let picture = render(&scene, &settings, &Silent).unwrap().picture;
    let at = |pass: Pass, x: usize| {
        let layer = layer(&picture, pass);
        let n = layer.channels.len();
        layer.data[n * (16 * 32 + x)..][..n].to_vec()
    };
    let near = |values: &[f32], wanted: &[f32], within: f32| {
        let differ = values.iter().zip(wanted).map(|(a, b)| (a - b).abs());
        assert!(
            differ.fold(0.0, f32::max) < within,
            "{values:?}, not {wanted:?}"
        );
    };
    // The mirror tints by its colour; Schlick's term adds little at 45°.
    near(&at(Pass::DenoisingAlbedo, 4), &[0.4, 0.08, 0.16], 0.01);
    near(&at(Pass::DenoisingAlbedo, 28), &[0.3; 3], 1e-5);
    // Of the wall at the left, which looks to the right; shorter by the mirror's tint.
    near(&at(Pass::DenoisingNormal, 4), &[0.8, 0.0, 0.0], 0.01);
    // Of the wall behind, which looks back at the camera, whose axis Z is forward.
    near(&at(Pass::DenoisingNormal, 28), &[0.0, 0.0, -1.0], 1e-5);
    let depth = at(Pass::DenoisingDepth, 28)[0];
    assert!((5.0..5.2).contains(&depth), "{depth}");
    // About 3.5 to the mirror, and 0.8 of 4.5 to the wall.
    let depth = at(Pass::DenoisingDepth, 4)[0];
    assert!((6.9..7.4).contains(&depth), "{depth}");
}
