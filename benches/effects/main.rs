//! What each effect costs each scene: instructions of a sample by callgrind, times of a sample in turn.
//!
//!     cargo bench --bench effects -- [SCENE.glb[:ENVIRONMENT]…] [--time] [--check | --write]
//!
//! Without a scene it takes the Cornell box that it makes itself. docs/notes/effects.md says what the tables mean.

#![allow(clippy::print_stdout, clippy::print_stderr)]

mod cornell;
mod kernels;

use enumset::EnumSet;
use kernels::{Candidate, candidates};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use sundog::effects::{self, ALL, Effect, EffectReport};
use sundog::film::filter::FilterTable;
use sundog::import::{self, ImportOptions};
use sundog::integrator::{Branches, Kernel, PathSettings};
use sundog::sampler::{Dimension, Sequence};
use sundog::scene::Scene;
use sundog::world::{Ablation, Options, World};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Width and height of the picture whose samples are counted, samples of each of its pixels.
const COUNTED: (u32, u32) = (48, 2);
/// The same for what is timed.
const TIMED: (u32, u32) = (64, 4);
/// How often each kernel is timed, in turn with the others.
const REPEATS: usize = 15;
/// How much a kernel may move before `--check` fails.
const MOVED: f64 = 0.02;
const REFERENCE: &str = "benches/effects/reference.json";

/// A scene to trace, by its word on the command line.
fn load(word: &str) -> Outcome<(String, Scene)> {
    if word == "cornell" {
        return Ok((word.into(), cornell::cornell()));
    }
    let (file, environment) = word.split_once(':').unwrap_or((word, ""));
    let mut scene = import::load(Path::new(file), &ImportOptions::default())?.scene;
    if !environment.is_empty() {
        import::load_environment(&mut scene, Path::new(environment), 1.0, 0.0)?;
    }
    let name = Path::new(file).file_stem().unwrap_or_default();
    Ok((name.to_string_lossy().into(), scene))
}

fn world(scene: &Scene, effects: EnumSet<Effect>) -> Outcome<World> {
    let camera = scene.cameras.first().ok_or("the scene has no camera")?;
    let options = Options {
        camera,
        rows: 48,
        aspect: 1.0,
        effects,
        threads: Some(1),
        instructions: None,
        cull_backfaces: false,
        light_shares: Default::default(),
        clamps_direct: false,
        uv_pass: false,
        aovs: false,
        vectors: false,
        roughens: false,
        coincident: None,
        ablation: Ablation::default(),
    };
    Ok(World::new(scene, &options)?)
}

/// As a picture of default settings has it.
const PATHS: PathSettings = PathSettings {
    volume_limit: u32::MAX,
    bounces: 12,
    limits: [u32::MAX; 3],
    transparent: u32::MAX,
    alpha_threshold: 0.5,
    clamp: [f32::INFINITY; 2],
    filter_glossy: 0.0,
    transparent_film: false,
    clear_alpha: -1.0,
    caustics: [true; 2],
    sample_lights: true,
    sample_bsdf: true,
    uniform: false,
    naive_offsets: false,
    light_samples: 1,
    branches: Branches::all(1),
    roulette: 2,
};

/// Traces all samples of a picture: what callgrind counts. The sum keeps the compiler from leaving anything out,
/// and kernels with all that a scene calls for must agree in its bits.
#[inline(never)]
fn counted_samples(
    world: &World,
    kernel: Kernel,
    filter: &FilterTable,
    picture: (u32, u32),
) -> [u64; 3] {
    samples(world, kernel, filter, picture)
}

#[inline(always)]
fn samples(
    world: &World,
    kernel: Kernel,
    filter: &FilterTable,
    (size, samples): (u32, u32),
) -> [u64; 3] {
    let sequence = Sequence::new(0);
    let camera_ray = world.camera.ray_maker();
    let mut sums = [0u64; 3];
    for pixel in 0..size * size {
        let (x, y) = (pixel % size, pixel / size);
        for sample in 0..samples {
            let sampler = sequence.sampler(x, y, sample);
            let offset = filter.sample(sampler.pair(Dimension::Filter, 0));
            let film = glam::Vec2::new(
                (x as f32 + 0.5 + offset.x) / size as f32 * 2.0 - 1.0,
                1.0 - (y as f32 + 0.5 + offset.y) / size as f32 * 2.0,
            );
            let ray = camera_ray(&world.camera, film, &sampler);
            let path = kernel(world, &PATHS, &sampler, &ray);
            for (sum, value) in sums.iter_mut().zip(path.radiance.to_array()) {
                *sum = sum.wrapping_add(u64::from(value.to_bits()));
            }
        }
    }
    sums
}

/// What is told of a kernel on a scene.
struct Figure {
    name: String,
    instructions: f64,
    /// Nanoseconds of a sample, one for each turn.
    times: Vec<f64>,
}

/// Nanoseconds of a sample by each kernel, in turn, so that what else the machine does falls on all alike.
fn times(worlds: &[(Candidate, World)]) -> Vec<Vec<f64>> {
    let all = f64::from(TIMED.0 * TIMED.0 * TIMED.1);
    let filter = FilterTable::box_filter();
    let mut times = vec![Vec::new(); worlds.len()];
    for _ in 0..REPEATS {
        for ((candidate, world), times) in worlds.iter().zip(&mut times) {
            let begun = Instant::now();
            std::hint::black_box(counted_samples(world, candidate.kernel, &filter, TIMED));
            times.push(begun.elapsed().as_nanos() as f64 / all);
        }
    }
    times
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The kernels to look at on a scene with the worlds made for them.
fn prepared(scene: &Scene) -> Outcome<Vec<(Candidate, World)>> {
    let needed = EffectReport::detect(scene).called_for & ALL;
    let mut list = Vec::new();
    for candidate in candidates(needed) {
        // The general kernel is given what it is given with `--effects all`.
        let effects = if candidate.effects == effects::PATHS {
            ALL
        } else {
            needed
        };
        let world = world(scene, effects)?;
        list.push((candidate, world));
    }
    Ok(list)
}

/// Traces once with each kernel and says nothing: callgrind counts, and writes a file after each.
fn count(word: &str) -> Outcome<()> {
    let (_, scene) = load(word)?;
    let mut first = None;
    let filter = FilterTable::box_filter();
    for (candidate, world) in prepared(&scene)? {
        // Not counted: tables that are made when they are first asked for are no sample's, and a few samples do not ask for all.
        std::hint::black_box(samples(&world, candidate.kernel, &filter, COUNTED));
        let sums = counted_samples(&world, candidate.kernel, &filter, COUNTED);
        if *first.get_or_insert(sums) != sums {
            return Err(format!("{} has other bits than the first kernel", candidate.name).into());
        }
    }
    Ok(())
}

/// Instructions of a sample by each of so many kernels, by this program under callgrind.
fn instructions(word: &str, kernels: usize) -> Outcome<Vec<f64>> {
    let folder = std::env::temp_dir().join(format!("sundog-effects-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let out = folder.join("callgrind");
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--collect-atstart=no", "--cache-sim=no"]);
    command.args([
        "--toggle-collect=effects::counted_samples",
        "--dump-after=effects::counted_samples",
    ]);
    command.arg(format!("--callgrind-out-file={}", out.display()));
    command
        .arg(std::env::current_exe()?)
        .args(["--count", word]);
    let done = command
        .output()
        .map_err(|e| format!("valgrind could not be run: {e}"))?;
    if !done.status.success() {
        return Err(String::from_utf8_lossy(&done.stderr).into_owned().into());
    }
    let all = f64::from(COUNTED.0 * COUNTED.0 * COUNTED.1);
    let figures = (1..=kernels).map(|number| {
        let path = PathBuf::from(format!("{}.{number}", out.display()));
        let text = std::fs::read_to_string(&path)?;
        let total = text
            .lines()
            .find_map(|l| l.strip_prefix("summary: ").or(l.strip_prefix("totals: ")));
        let total: f64 = total.ok_or("callgrind says no total")?.trim().parse()?;
        Ok(total / all)
    });
    let figures = figures.collect::<Outcome<Vec<f64>>>();
    std::fs::remove_dir_all(&folder)?;
    figures
}

fn figures(word: &str, time: bool) -> Outcome<(String, Vec<Figure>)> {
    let (name, scene) = load(word)?;
    let worlds = prepared(&scene)?;
    let counts = instructions(word, worlds.len())?;
    let times = if time {
        times(&worlds)
    } else {
        vec![Vec::new(); worlds.len()]
    };
    let figures =
        worlds
            .iter()
            .zip(counts)
            .zip(times)
            .map(|(((candidate, _), instructions), times)| Figure {
                name: candidate.name.clone(),
                instructions,
                times,
            });
    Ok((name, figures.collect()))
}

/// One table, its first kernel being what the others are related to.
fn print(scene: &str, figures: &[Figure]) {
    let Some(base) = figures.first() else { return };
    println!(
        "\n{scene}\n\n| kernel | instructions | | ns | ratio of medians |\n| --- | --- | --- | --- | --- |"
    );
    for figure in figures {
        let change = 100.0 * (figure.instructions / base.instructions - 1.0);
        // Each turn by itself: what slowed one of a pair slowed the other.
        let pairs: Vec<f64> = figure
            .times
            .iter()
            .zip(&base.times)
            .map(|(a, b)| a / b)
            .collect();
        println!(
            "| {} | {:.0} | {change:+.1} % | {:.0} | {:.3} |",
            figure.name,
            figure.instructions,
            median(&figure.times),
            median(&pairs),
        );
    }
}

/// What the figures depend on besides this program's source.
fn toolchain() -> String {
    let said = |program: &str| {
        let out = Command::new(program).arg("--version").output();
        out.map_or_else(
            |_| "unknown".into(),
            |o| String::from_utf8_lossy(&o.stdout).trim().to_owned(),
        )
    };
    format!(
        "{}, {}, Embree {}",
        said("rustc"),
        said("valgrind"),
        sundog::ffi::embree::HEADERS
    )
}

/// Instructions by scene and kernel.
type Reference = BTreeMap<String, BTreeMap<String, f64>>;

fn check(now: &Reference) -> Outcome<()> {
    let text = std::fs::read_to_string(REFERENCE)?;
    let (toolchain_then, then): (String, Reference) = serde_json::from_str(&text)?;
    if toolchain_then != toolchain() {
        println!(
            "the figures of reference were made with {toolchain_then}; this is {}",
            toolchain()
        );
    }
    let mut moved = Vec::new();
    for (scene, kernels) in &then {
        for (kernel, &before) in kernels {
            let Some(&after) = now.get(scene).and_then(|k| k.get(kernel)) else {
                continue;
            };
            let change = after / before - 1.0;
            println!(
                "{scene}, {kernel}: {before:.0} then, {after:.0} now, {:+.2} %",
                100.0 * change
            );
            if change.abs() > MOVED {
                moved.push(format!("{scene}, {kernel}"));
            }
        }
    }
    if moved.is_empty() {
        Ok(())
    } else {
        Err(format!("moved by more than 2 %: {}", moved.join("; ")).into())
    }
}

fn run() -> Outcome<()> {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| a != "--bench")
        .collect();
    let has = |flag: &str| words.iter().any(|w| w == flag);
    let mut scenes: Vec<&str> = words
        .iter()
        .map(String::as_str)
        .filter(|w| !w.starts_with("--"))
        .collect();
    if scenes.is_empty() {
        scenes.push("cornell");
    }
    if has("--count") {
        return count(scenes[0]);
    }
    println!("{}", toolchain());
    let mut reference = Reference::new();
    for word in scenes {
        let (name, figures) = figures(word, !has("--check"))?;
        print(&name, &figures);
        let kept = figures.iter().filter(|f| !f.name.starts_with('+'));
        let kernels = kept
            .map(|f| (f.name.clone(), f.instructions.round()))
            .collect();
        reference.insert(name, kernels);
    }
    if has("--write") {
        std::fs::write(
            REFERENCE,
            serde_json::to_string_pretty(&(toolchain(), &reference))? + "\n",
        )?;
    }
    if has("--check") {
        check(&reference)?;
    }
    Ok(())
}

fn main() -> std::process::ExitCode {
    match run() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}
