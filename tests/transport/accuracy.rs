//! The error that a render says it has, against the error that it has; stopping, going on, joining.

use super::*;
use std::io::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;
use sundog::film::Bands;
use sundog::film::Picture;
use sundog::math::panorama::Panorama;
use sundog::render::{
    NoiseThreshold, Observer, OutputTime, Passed, Saved, State, Stop, merge, resume,
};
use sundog::sampler::Sequences;

/// One sequence of points, planned for the samples of the test of parts.
const ONE_PLANNED: Sequences = Sequences::One { planned: Some(100) };

/// A small lamp between a mirror, a glass ball and walls: light that only chance finds, in rare bright samples.
pub fn fireflies() -> Scene {
    let mut scene = Scene::default();
    let walls = diffuse([0.7, 0.65, 0.6]);
    place(
        &mut scene,
        quad([-3.0, -1.0, 3.0], [6.0, 0.0, 0.0], [0.0, 0.0, -6.0]),
        walls.clone(),
        &[DAffine3::IDENTITY],
    );
    place(
        &mut scene,
        quad([-3.0, -1.0, -2.0], [6.0, 0.0, 0.0], [0.0, 4.0, 0.0]),
        walls,
        &[DAffine3::IDENTITY],
    );
    let mirror = MetallicRoughness {
        base_color: [0.95; 3],
        metallic: 1.0,
        roughness: 0.05,
        ..MetallicRoughness::default()
    };
    let tilted = DAffine3::from_rotation_translation(
        glam::DQuat::from_rotation_z(0.5),
        DVec3::new(-1.6, 0.0, -0.5),
    );
    place(
        &mut scene,
        quad([-0.7, -0.9, 0.7], [1.4, 0.0, 0.0], [0.0, 0.0, -1.4]),
        mirror,
        &[tilted],
    );
    let glass = MetallicRoughness {
        transmission: 1.0,
        roughness: 0.0,
        ..MetallicRoughness::default()
    };
    let ball = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.6),
        glam::DQuat::IDENTITY,
        DVec3::new(0.9, -0.3, 0.0),
    );
    place(&mut scene, sphere(24, 0.0, true), glass, &[ball]);
    place(
        &mut scene,
        quad([-0.1, 2.0, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2]),
        MetallicRoughness {
            emission: [150.0, 120.0, 90.0],
            ..diffuse([0.0; 3])
        },
        &[DAffine3::IDENTITY],
    );
    scene.cameras.push(camera(DVec3::new(0.0, 0.2, 4.0), 0.8));
    scene
}

fn of_size(width: u32, height: u32, samples: u32, seed: u32) -> RenderSettings {
    RenderSettings {
        width,
        height,
        seed,
        ..small(samples, 5)
    }
}

fn tiny(samples: u32, seed: u32) -> RenderSettings {
    of_size(24, 16, samples, seed)
}

/// Some ways to find light, and one that leaves much to chance.
fn scenes() -> Vec<(&'static str, Scene)> {
    let mut scenes = gallery();
    scenes.truncate(3);
    scenes.push(("fireflies", fireflies()));
    scenes
}

fn medium(samples: u32, seed: u32) -> RenderSettings {
    of_size(48, 32, samples, seed)
}

/// Keeps the pictures after some numbers of samples, and what was said of their errors.
struct Snapshots<'a> {
    at: &'a [u32],
    kept: Mutex<Vec<(Vec<[f64; 3]>, Passed)>>,
}

impl Observer for Snapshots<'_> {
    fn event(&self, _: &sundog::render::Event) {}
    fn cancelled(&self) -> bool {
        false
    }
    fn whole_pass(&self, film: &dyn Bands, passed: &Passed) {
        if self.at.contains(&passed.least) {
            let data = &Picture::collect(film).layers[0].data;
            let colors = data.chunks(4).map(|c| [c[0], c[1], c[2]].map(f64::from));
            self.kept.lock().unwrap().push((colors.collect(), *passed));
        }
    }
}

fn snapshots(scene: &Scene, at: &[u32], settings: &RenderSettings) -> Vec<(Vec<[f64; 3]>, Passed)> {
    let watcher = Snapshots {
        at,
        kept: Mutex::default(),
    };
    render(scene, settings, &watcher).unwrap();
    watcher.kept.into_inner().unwrap()
}

/// relMSE against the mean of two independent references, without their noise: (x − a)(x − b) has the expectation
/// of (x − r)².
fn rel_mse(x: &[[f64; 3]], a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let mut sum = 0.0;
    for ((x, a), b) in x.iter().zip(a).zip(b) {
        for c in 0..3 {
            let r = 0.5 * (a[c] + b[c]);
            sum += (x[c] - a[c]) * (x[c] - b[c]) / (r * r + 0.01);
        }
    }
    sum / (3 * x.len()) as f64
}

/// A picture, and how many samples a pixel it has.
type Weighted<'a> = (&'a [[f64; 3]], f64);

/// The mean of pictures, each by its number of samples.
fn mean_of<'a>(pictures: impl Iterator<Item = Weighted<'a>>) -> Vec<[f64; 3]> {
    let (mut sum, mut samples) = (Vec::new(), 0.0);
    for (picture, weight) in pictures {
        sum.resize(picture.len(), [0.0; 3]);
        for (sum, pixel) in sum.iter_mut().zip(picture) {
            *sum = [0, 1, 2].map(|c| sum[c] + weight * pixel[c]);
        }
        samples += weight;
    }
    sum.iter_mut().flatten().for_each(|value| *value /= samples);
    sum
}

/// Two independent references for the picture of the seed `own`: what the other seeds have come to, by halves. The seeds with the most
/// samples come first, so that the halves have about as many each.
fn other_seeds(seeds: &[Weighted], own: usize) -> [Vec<[f64; 3]>; 2] {
    let others = (1..seeds.len()).map(|ahead| seeds[(own + ahead) % seeds.len()]);
    let mut others: Vec<_> = others.collect();
    others.sort_by(|a, b| b.1.total_cmp(&a.1));
    [0, 1].map(|half| mean_of(others.iter().skip(half).step_by(2).copied()))
}

/// How many numbers of samples, of 16, 64, 256, 1024 and 4096, the picture of each seed is looked at.
struct Lengths {
    /// Of scenes where little is left to chance.
    smooth: fn(usize) -> usize,
    /// Of the others.
    by_chance: fn(usize) -> usize,
}

/// The estimated error is within 15 % of the true one from 16 to 4096 samples, in the median over the seeds; up to 64
/// samples of the fireflies, where that of single pictures is spread by 40 %, within 30 %, and from 256 samples on of the rough
/// glass, whose caustics have r told too low (1.15 and 1.17: docs/notes/accuracy.md), within 20 %. The interval of 95 % contains the
/// true error of 90 to 99 % of the pictures. (The median, for where a single firefly is most of a picture's error, the
/// square of it is as uncertain as what lies beneath that one pixel.) Where much is left to chance the median of 24 pictures
/// is uncertain by 5 %: these scenes have 80 seeds, the others 24. The references of each seed are the other seeds' pictures.
fn the_estimated_error_is_the_true_error_at(lengths: &Lengths) {
    let at = [16, 64, 256, 1024, 4096];
    let smooth = ["mesh light, metal", "sky and sun, plastic"];
    let (mut told, mut covered, mut failed) = (0, 0, false);
    for (name, scene) in &scenes() {
        let (seeds, length) = if smooth.contains(name) {
            (24, lengths.smooth)
        } else {
            (80, lengths.by_chance)
        };
        let pictures_of = |seed| {
            let at = &at[..length(seed)];
            snapshots(scene, at, &medium(at[at.len() - 1], seed as u32))
        };
        let all: Vec<_> = (0..seeds).map(pictures_of).collect();
        let last_of = |pictures: &'_ Vec<(Vec<[f64; 3]>, Passed)>| pictures.len() - 1;
        let last: Vec<Weighted> = all
            .iter()
            .map(|of| (&of[last_of(of)].0[..], f64::from(at[last_of(of)])))
            .collect();
        let mut ratios: [Vec<f64>; 5] = Default::default();
        let mut truths = [0.0; 5];
        for (seed, pictures) in all.iter().enumerate() {
            let [a, b] = other_seeds(&last, seed);
            for (i, (picture, passed)) in pictures.iter().enumerate() {
                let truth = rel_mse(picture, &a, &b).max(0.0).sqrt();
                let estimate = passed.error.unwrap();
                ratios[i].push(estimate.error / truth);
                truths[i] += truth;
                // All scenes alike.
                if seed < 24 {
                    told += 1;
                    covered += u32::from((estimate.low..=estimate.high).contains(&truth));
                }
            }
        }
        for ((samples, ratios), truth) in at.iter().zip(&mut ratios).zip(truths) {
            if ratios.is_empty() {
                continue;
            }
            ratios.sort_by(f64::total_cmp);
            let median = ratios[ratios.len() / 2];
            let truth = truth / ratios.len() as f64;
            println!("{name}, {samples} samples, error {truth:.3}: estimate / truth {median:.3}");
            let allowed = match (*name, *samples) {
                ("fireflies", ..=64) => 0.30,
                ("lamps, rough glass", 256..) => 0.20,
                _ => 0.15,
            };
            failed |= (median - 1.0).abs() > allowed;
        }
    }
    let share = f64::from(covered) / f64::from(told);
    println!("{covered} of {told} intervals contain the truth");
    assert!(!failed, "see above");
    assert!((0.90..=0.99).contains(&share), "{share}");
}

/// Up to 64 samples; `long` looks at more.
#[test]
fn the_estimated_error_is_the_true_error() {
    the_estimated_error_is_the_true_error_at(&Lengths {
        smooth: |_| 2,
        by_chance: |_| 2,
    });
}

/// What `make test-long` runs: the same at greater length, with the same bounds.
mod long {
    use super::*;

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn the_estimated_error_is_the_true_error_up_to_256_samples() {
        the_estimated_error_is_the_true_error_at(&Lengths {
            smooth: |_| 3,
            by_chance: |_| 3,
        });
    }

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn the_estimated_error_is_the_true_error_up_to_4096_samples() {
        // As many as take about the same time. Where much is left to chance, the references would be nearly as noisy as
        // pictures of 4096 samples.
        the_estimated_error_is_the_true_error_at(&Lengths {
            smooth: |seed| match seed {
                0..3 => 5,
                3..5 => 4,
                5..12 => 3,
                _ => 2,
            },
            by_chance: |seed| if seed < 24 { 4 } else { 3 },
        });
    }

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn the_estimated_error_after_256_samples_and_more_is_the_true_error() {
        for samples in [256, 1024, 4096] {
            the_estimated_error_of_long_renders_is_the_true_error(samples);
        }
    }

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn adaptive_sampling_has_the_means_of_uniform_sampling_in_all_scenes() {
        adaptive_sampling_has_the_means_of_uniform_sampling(&scenes());
    }
}

/// The same after many samples on ten scenes with small pictures, all together: the ratios of so few pixels lie 20 % apart, so that
/// the median of 70 is certain to 3 %, that of a scene's seven to 9 % only. The references of each picture are what the other seeds have
/// come to, by halves. Of 70 intervals that hold with 95 %, fewer than 60 do so once in a thousand times.
fn the_estimated_error_of_long_renders_is_the_true_error(samples: u32) {
    let seeds = 7;
    let mut scenes = gallery();
    scenes.push(("fireflies", fireflies()));
    let (mut ratios, mut covered) = (Vec::new(), 0);
    for (name, scene) in &scenes {
        let run = |seed| snapshots(scene, &[samples], &tiny(samples, seed)).remove(0);
        let runs: Vec<_> = (0..seeds).map(run).collect();
        let last: Vec<Weighted> = runs
            .iter()
            .map(|run| (&run.0[..], f64::from(samples)))
            .collect();
        let mut own_ratios = Vec::new();
        for (own, (picture, passed)) in runs.iter().enumerate() {
            let [a, b] = other_seeds(&last, own);
            let truth = rel_mse(picture, &a, &b).max(0.0).sqrt();
            let estimate = passed.error.unwrap();
            own_ratios.push(estimate.error / truth);
            covered += u32::from((estimate.low..=estimate.high).contains(&truth));
        }
        own_ratios.sort_by(f64::total_cmp);
        println!("{name}: estimate / truth {own_ratios:.3?}");
        ratios.extend(own_ratios);
    }
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    println!(
        "median {median:.3}, {covered} of {} intervals contain the truth",
        ratios.len()
    );
    assert!((median - 1.0).abs() <= 0.15, "{median}");
    assert!(covered >= 60, "{covered} of {}", ratios.len());
}

/// Means over blocks of 16 × 16 pixels of some renders, and their variances.
fn blocks(
    scene: &Scene,
    settings: &RenderSettings,
    seeds: std::ops::Range<u32>,
) -> Vec<(f64, f64)> {
    let n = f64::from(seeds.end - seeds.start);
    let mut sums = [(0.0, 0.0); 6];
    for seed in seeds {
        let settings = RenderSettings {
            seed,
            ..settings.clone()
        };
        let mut blocks = [0.0; 6];
        for (i, c) in colors(&run(scene, &settings)).iter().enumerate() {
            blocks[i % 48 / 16 + 3 * (i / 48 / 16)] += (c[0] + c[1] + c[2]) / 768.0;
        }
        for (sum, block) in sums.iter_mut().zip(blocks) {
            sum.0 += block / n;
            sum.1 += block * block / n;
        }
    }
    sums.iter()
        .map(|s| (s.0, (s.1 - s.0 * s.0) / (n - 1.0)))
        .collect()
}

/// Adaptive sampling has the means of uniform sampling: z-test in each of six blocks a scene, at 4 σ (the probability that one
/// of 24 is beyond by chance is 0.0015). A sampler that stops where its own samples agree fails it with fireflies.
fn adaptive_sampling_has_the_means_of_uniform_sampling(scenes: &[(&str, Scene)]) {
    let mut failed = false;
    for (name, scene) in scenes {
        let adaptive = RenderSettings {
            pixel_error_target: 0.08,
            ..medium(1024, 0)
        };
        let a = blocks(scene, &adaptive, 0..32);
        let b = blocks(scene, &medium(192, 0), 1000..1032);
        for (i, (a, b)) in a.iter().zip(&b).enumerate() {
            let sigma = (a.1 + b.1).sqrt();
            let z = (a.0 - b.0) / sigma;
            println!(
                "{name}, block {i}: {:.5} {:.5} z {z:.2}, σ {:.2} %",
                a.0,
                b.0,
                100.0 * sigma / b.0
            );
            // The test has teeth.
            failed |= z.abs() >= 4.0 || sigma >= 0.03 * b.0 + 1e-5;
        }
    }
    assert!(!failed, "see above");
}

/// `long` looks at all scenes; fireflies take it minutes.
#[test]
fn adaptive_sampling_has_the_means_of_uniform_sampling_in_a_scene() {
    adaptive_sampling_has_the_means_of_uniform_sampling(&scenes()[..1]);
}

/// Cycles' rule: the same bits with any number of threads; pixels end at different looks.
#[test]
fn the_noise_threshold_makes_one_picture_and_stops_pixels_at_looks() {
    let (_, scene) = gallery().swap_remove(0);
    let with = |threads: usize| RenderSettings {
        noise_threshold: Some(NoiseThreshold {
            threshold: 0.02,
            min_samples: 20,
        }),
        threads: Some(threads),
        ..of_size(64, 48, 4096, 0)
    };
    let rendering = run(&scene, &with(2));
    let counts = layer(&rendering, "Debug Sample Count");
    assert_eq!(rendering.statistics.stop, Stop::NoiseThreshold);
    // After 32 samples, and each 16 beyond.
    let at_looks = |&count: &f32| count >= 32.0 && count % 16.0 == 0.0;
    assert!(counts.iter().all(at_looks), "{counts:?}");
    let most = counts.iter().fold(0f32, |a, &b| a.max(b));
    let least = counts.iter().fold(most, |a, &b| a.min(b));
    assert!(least == 32.0 && most > 64.0, "{least} {most}");
    for threads in [1, 3] {
        let again = run(&scene, &with(threads));
        for (a, b) in rendering.picture.layers.iter().zip(&again.picture.layers) {
            let bits = |data: &[f32]| data.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&a.data), bits(&b.data), "{} {threads}", a.name);
        }
    }
}

/// No neighbourhood is above the target at the end, and where little is to be done, little was done.
#[test]
fn adaptive_sampling_ends_when_every_pixel_is_good_enough() {
    let (_, scene) = gallery().swap_remove(0);
    let settings = RenderSettings {
        pixel_error_target: 0.02,
        ..of_size(64, 48, 1 << 14, 0)
    };
    let rendering = run(&scene, &settings);
    assert_eq!(rendering.statistics.stop, Stop::PixelError);
    let (errors, counts) = (
        layer(&rendering, "Error"),
        layer(&rendering, "Debug Sample Count"),
    );
    // Root mean squares over 13 × 13 pixels decide; so that of the picture is below the target, too.
    let squares: f64 = errors.iter().map(|&e| f64::from(e).powi(2)).sum();
    let error = (squares / errors.len() as f64).sqrt();
    assert!((0.01..=0.02).contains(&error), "{error}");
    let most = counts.iter().fold(0f32, |a, &b| a.max(b));
    let least = counts.iter().fold(most, |a, &b| a.min(b));
    assert!(least >= 32.0 && most > 1.2 * least, "{least} {most}");
    let mean = counts.iter().map(|&c| f64::from(c)).sum::<f64>() / counts.len() as f64;
    assert!((rendering.statistics.mean_samples - mean).abs() < 1e-9);
}

/// Each goal ends the render after a whole pass, and the picture is that of so many samples.
#[test]
fn an_error_target_ends_the_render_early() {
    let (_, scene) = gallery().swap_remove(0);
    let settings = RenderSettings {
        error_target: 0.2,
        ..small(512, 4)
    };
    let rendering = run(&scene, &settings);
    let statistics = &rendering.statistics;
    assert_eq!(statistics.stop, Stop::Error);
    assert!(statistics.samples < 512 && statistics.error.unwrap().error <= 0.2);
    let counts = layer(&rendering, "Debug Sample Count");
    assert!(counts.iter().all(|&c| c == statistics.samples as f32));
    let alone = run(&scene, &small(statistics.samples, 4));
    assert_eq!(colors(&alone), colors(&rendering));
}

/// Breaks a render off when it has been asked so many times whether it shall, that is every 5 ms and so in the middle
/// of a pass; keeps its state.
struct BreakOff {
    after: u32,
    asked: AtomicU32,
    state: Mutex<Vec<u8>>,
}

impl BreakOff {
    fn after(after: u32) -> Self {
        Self {
            after,
            asked: AtomicU32::new(0),
            state: Mutex::default(),
        }
    }
}

impl Observer for BreakOff {
    fn event(&self, _: &sundog::render::Event) {}
    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.after
    }
    fn wants_state(&self, last: bool) -> bool {
        last
    }
    fn state(&self, state: &State, _: bool) {
        state.write(&mut *self.state.lock().unwrap()).unwrap();
    }
}

/// `None` if it was broken off before there was a sample.
fn state_when_broken_off(
    scene: &Scene,
    settings: &RenderSettings,
    after: u32,
) -> Option<(Saved, Stop)> {
    let observer = BreakOff::after(after);
    let rendering = render(scene, settings, &observer).unwrap();
    let state = observer.state.into_inner().unwrap();
    assert_eq!(state.is_empty(), rendering.statistics.rays == 0);
    if state.is_empty() {
        return None;
    }
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(&state).unwrap();
    file.flush().unwrap();
    let saved = Saved::read(file.path()).unwrap();
    Some((saved, rendering.statistics.stop))
}

fn state_of(scene: &Scene, settings: &RenderSettings, after: u32) -> (Saved, Stop) {
    state_when_broken_off(scene, settings, after).unwrap()
}

/// The state of a render that was broken off; earlier if it was through before it could be, and later if it had not begun, as
/// on a busy machine either thread may have to wait.
fn broken_off(scene: &Scene, settings: &RenderSettings, after: u32) -> Saved {
    let earlier = (0..8).map(|tries| after >> tries);
    let later = (1..8).map(|tries| after << tries);
    let mut states = earlier
        .chain(later)
        .filter_map(|after| state_when_broken_off(scene, settings, after));
    let state = states.find(|(_, stop)| *stop == Stop::Cancelled);
    state.expect("a render that can be broken off").0
}

fn same_bits(a: &Rendering, b: &Rendering) {
    for (x, y) in a.picture.layers.iter().zip(&b.picture.layers) {
        assert_eq!(x.name, y.name);
        if x.name != "Cost" {
            let bits = |layer: &sundog::film::Layer| -> Vec<u32> {
                layer.data.iter().map(|v| v.to_bits()).collect()
            };
            assert!(bits(x) == bits(y), "{}", x.name);
        }
    }
    let error = |r: &Rendering| r.statistics.error.unwrap().error;
    assert!((error(a) / error(b) - 1.0).abs() < 1e-12);
}

/// A render that was broken off in the middle of a pass goes on to the bits of one that was not, uniformly and
/// adaptively, with light apart, and also to more samples than it was first asked for.
#[test]
fn a_render_goes_on_where_it_was_broken_off() {
    let (two, one) = (Sequences::Two, ONE_PLANNED);
    let settings = [[(0.0, two), (0.01, two)], [(0.0, two), (0.01, one)]];
    for ((_, scene), settings) in gallery().into_iter().zip(settings) {
        for (target, sequences) in settings {
            let of = |samples| RenderSettings {
                pixel_error_target: target,
                sequences,
                passes: Passes::ALL,
                ..small(samples, 4)
            };
            let whole = run(&scene, &of(1500));
            for after in [2, 12] {
                let saved = broken_off(&scene, &of(1400), after);
                assert!(saved.samples() < 1400);
                let settings = RenderSettings {
                    threads: Some(1),
                    ..of(1500)
                };
                let resumed = resume(&scene, &settings, Some(&saved), &Silent).unwrap();
                same_bits(&resumed, &whole);
                assert_eq!(resumed.statistics.rays, whole.statistics.rays);
            }
        }
    }
}

#[test]
fn a_render_does_not_go_on_with_another() {
    let scenes = gallery();
    let (saved, _) = state_of(&scenes[0].1, &small(4, 4), u32::MAX);
    let refused = |scene: &Scene, settings: &RenderSettings, words: &str| {
        let error = resume(scene, settings, Some(&saved), &Silent)
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(&scenes[1].1, &small(8, 4), "another scene");
    refused(&scenes[0].1, &small(8, 3), "bounces 4 instead of 3");
    let later = RenderSettings {
        first_sample: 4,
        ..small(8, 4)
    };
    refused(&scenes[0].1, &later, "begins with sample 0, not 4");
}

/// Parts of a render join, in any order, to the bits of one, and its error with them.
#[test]
fn parts_join_to_the_picture_of_one() {
    let two = gallery()
        .into_iter()
        .take(3)
        .map(|(_, s)| (s, Sequences::Two));
    let one = gallery().into_iter().take(1).map(|(_, s)| (s, ONE_PLANNED));
    for (scene, sequences) in two.chain(one) {
        let of = |first_sample, samples| RenderSettings {
            first_sample,
            sequences,
            ..small(samples, 4)
        };
        let whole = run(&scene, &of(0, 100));
        let parts = [(64, 36), (0, 17), (17, 47)];
        let states = parts.map(|(first, samples)| {
            let (saved, stop) = state_of(&scene, &of(first, samples), u32::MAX);
            assert_eq!(stop, Stop::Samples);
            saved
        });
        let named = |(i, s): (usize, &Saved)| Ok((format!("part {i}"), s.clone()));
        let joined = merge(states.iter().enumerate().map(named)).unwrap();
        assert_eq!(joined.header().ranges, [(0, 100)]);
        let rendering = joined.rendering();
        same_bits(&rendering, &whole);
        assert_eq!(rendering.statistics.samples, 100);
        // Each part has looked through the middle of each pixel once.
        assert_eq!(
            rendering.statistics.rays,
            whole.statistics.rays + 2 * 32 * 24
        );
        let twice = [&states[0], &states[0]].into_iter().enumerate().map(named);
        let Err(error) = merge(twice) else { panic!() };
        assert!(
            error.to_string().contains("both have samples of 64..100"),
            "{error}"
        );
    }
}

/// A damaged file is refused wherever it is damaged.
#[test]
fn damaged_states_are_refused() {
    let (_, scene) = gallery().swap_remove(0);
    let observer = BreakOff::after(u32::MAX);
    render(&scene, &tiny(2, 0), &observer).unwrap();
    let good = observer.state.into_inner().unwrap();
    let read = |bytes: &[u8]| {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(bytes).unwrap();
        file.flush().unwrap();
        Saved::read(file.path())
            .map(|_| ())
            .map_err(|e| e.to_string())
    };
    read(&good).unwrap();
    for place in [0, 10, 16, 30, 200, good.len() / 2, good.len() - 1] {
        let mut bad = good.clone();
        bad[place] ^= 0x15;
        assert!(read(&bad).is_err(), "{place}");
    }
    for length in [0, 5, 20, good.len() / 2, good.len() - 1] {
        assert!(read(&good[..length]).is_err(), "{length}");
    }
    let longer = [&good[..], &[0]].concat();
    assert!(read(&longer).unwrap_err().contains("length"));
}

/// Where there is no time to tell the error of what one sees, the picture is not kept waiting for it.
#[test]
fn what_there_is_no_time_for_is_left_out() {
    /// Answers at once without the error, and after so long with it.
    struct Output(Duration);
    impl Observer for Output {
        fn event(&self, _: &sundog::render::Event) {}
        fn cancelled(&self) -> bool {
            false
        }
        fn keeps_picture(&self) -> bool {
            true
        }
        fn time_for_output(&self, _: &dyn Bands) -> OutputTime {
            OutputTime {
                seen_error: self.0,
                ..OutputTime::default()
            }
        }
    }
    let (_, scene) = gallery().swap_remove(0);
    for (time, is_told) in [(0, true), (3600, false)] {
        let output = Output(Duration::from_secs(time));
        let limited = RenderSettings {
            time_limit: Some(Duration::from_millis(500)),
            ..small(1 << 20, 4)
        };
        let rendering = render(&scene, &limited, &output).unwrap();
        assert_eq!(rendering.statistics.stop, Stop::Time);
        let is_known = rendering.statistics.error.is_some();
        assert_eq!(rendering.replicate.is_some(), is_told && is_known);
        // Who has all the samples asked for has not been hurried.
        let whole = RenderSettings {
            time_limit: Some(Duration::from_secs(3600)),
            ..small(2, 4)
        };
        let rendering = render(&scene, &whole, &output).unwrap();
        assert_eq!(rendering.statistics.stop, Stop::Samples);
        assert!(rendering.replicate.is_some());
    }
}

/// A camera that sees nothing, outside of a fisheye's circle, has a last picture as any other.
#[test]
fn a_picture_without_rays_is_handed_over() {
    struct Last(AtomicU32);
    impl Observer for Last {
        fn event(&self, _: &sundog::render::Event) {}
        fn cancelled(&self) -> bool {
            false
        }
        fn picture(&self, _: &dyn Bands, _: u32, last: bool) {
            self.0.fetch_add(u32::from(last), Ordering::Relaxed);
        }
    }
    let (_, mut scene) = gallery().swap_remove(0);
    scene.cameras[0].projection = Projection::Panorama {
        kind: Panorama::FisheyeEquidistant { fov: 1.0 },
        shift: [3.0, 0.0],
    };
    let last = Last(AtomicU32::new(0));
    // Depths are asked for by a ray of their own.
    let settings = RenderSettings {
        passes: Passes::COMBINED,
        ..small(4, 4)
    };
    let rendering = render(&scene, &settings, &last).unwrap();
    assert_eq!(rendering.statistics.rays, 0);
    assert_eq!(last.0.into_inner(), 1);
}

/// What is told of the output's time is left for it, before the limit.
#[test]
fn time_is_left_for_the_output() {
    struct Slow;
    impl Observer for Slow {
        fn event(&self, _: &sundog::render::Event) {}
        fn cancelled(&self) -> bool {
            false
        }
        fn time_for_output(&self, _: &dyn Bands) -> OutputTime {
            OutputTime {
                full: Duration::from_secs(3600),
                blank: Duration::from_secs(3600),
                ..OutputTime::default()
            }
        }
    }
    let (_, scene) = gallery().swap_remove(0);
    let settings = RenderSettings {
        time_limit: Some(Duration::from_secs(3601)),
        time_spent: Duration::from_secs(1),
        ..small(1 << 20, 4)
    };
    let rendering = render(&scene, &settings, &Slow).unwrap();
    assert_eq!(rendering.statistics.stop, Stop::Time);
    assert_eq!(rendering.statistics.samples, 1);
}

/// With a time limit the state is written once early, to know how long that takes.
#[test]
fn the_time_for_the_state_is_tried_out() {
    struct Keeps(AtomicU32);
    impl Observer for Keeps {
        fn event(&self, _: &sundog::render::Event) {}
        fn cancelled(&self) -> bool {
            false
        }
        fn wants_state(&self, last: bool) -> bool {
            last
        }
        fn state(&self, _: &State, _: bool) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }
    let (_, scene) = gallery().swap_remove(0);
    for (limit, expected) in [(None, 1), (Some(Duration::from_secs(3600)), 2)] {
        let keeps = Keeps(AtomicU32::new(0));
        let settings = RenderSettings {
            time_limit: limit,
            ..small(4, 4)
        };
        let rendering = render(&scene, &settings, &keeps).unwrap();
        assert_eq!(rendering.statistics.stop, Stop::Samples);
        assert_eq!(keeps.0.into_inner(), expected);
    }
}

/// A thread of the render panics (a debug assertion, say): the render ends by that panic. The thread that watches the clock
/// must not wait for a pass that never ends.
#[test]
fn a_panic_ends_the_render() {
    struct Breaks;
    impl Observer for Breaks {
        fn event(&self, _: &sundog::render::Event) {}
        fn cancelled(&self) -> bool {
            false
        }
        fn whole_pass(&self, _: &dyn Bands, _: &Passed) {
            panic!("broken on purpose");
        }
    }
    let (ended, end) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let settings = RenderSettings {
            width: 8,
            height: 8,
            samples: 2,
            ..RenderSettings::default()
        };
        let outcome = std::panic::catch_unwind(|| render(&fireflies(), &settings, &Breaks).is_ok());
        ended.send(outcome.is_err()).unwrap();
    });
    // The minute is the way out of a hang, no measure of speed.
    assert_eq!(end.recv_timeout(Duration::from_secs(60)), Ok(true));
}
