//! Runs the fuzzer for as long as asked: `cargo run --release --example fuzz -- --minutes 10 [--seed N] [--keep FOLDER]`.
//! `--show SEED` prints an input, and `--check FILE` says what is wrong with one that stands in a file.
//! With `--corpus FOLDER --each N` it damages the files of a folder instead, each kind (or `--only KIND`) so many times; with `--seeds`
//! small files of every kind that is read.
//! See scripts/fuzz.sh, which limits memory and goes on after what ends the process.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

#[allow(
    dead_code,
    unused_imports,
    reason = "tests/fuzz.rs compares kernels, with the same modules"
)]
mod fuzzer;

use fuzzer::corpus::{Copied, Subject};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// An input that takes more processor time ends the process, and one that takes ten times as long: a machine that others use
/// as well is no reason.
const PATIENCE: Duration = Duration::from_secs(120);
/// Smaller inputs that are tried for one that failed.
const TRIES: u32 = 400;

fn argument(name: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1)
}

/// Processor time of all threads so far, where the system tells it.
fn processor_time() -> Duration {
    let told = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name before them may hold spaces, but ends with the last parenthesis; user and system time are the 12th and 13th
    // numbers behind it, in ticks of a hundredth of a second.
    let numbers = told.rsplit(')').next().unwrap_or_default();
    let ticks = numbers.split_whitespace().skip(11).take(2);
    Duration::from_millis(
        ticks
            .filter_map(|text| text.parse::<u64>().ok())
            .sum::<u64>()
            * 10,
    )
}

/// When an input was begun, by the clock and by processor time.
fn now() -> (Instant, Duration) {
    (Instant::now(), processor_time())
}

/// Damages files, `each` kind so many times, and says what is wrong; whether nothing is.
fn corpus(subjects: Vec<Subject>, each: u64, first: u64, current: &Option<PathBuf>) -> bool {
    let only = argument("--only");
    let mut good = true;
    for (kind, subjects) in fuzzer::corpus::by_kind(subjects) {
        if only.as_ref().is_some_and(|only| *only != kind) {
            continue;
        }
        let begin = |name: &str| {
            if let Some(file) = current {
                std::fs::write(file, name).unwrap();
            }
        };
        let found = |copied: &Copied, seed: u64, told: &str| {
            println!("{told}");
            if let Some(keep) = argument("--keep") {
                let file = format!("{}-{seed}.{}", kind.replace(' ', "-"), copied.ending());
                std::fs::write(Path::new(&keep).join(file), copied.bytes(seed)).unwrap();
            }
        };
        let tally = fuzzer::corpus::try_kind(&subjects, (each, first), begin, found);
        good &= tally.wrong.is_empty();
        println!(
            "{kind}: {} damaged of {} files, {} opened, {:.0} s, at most {} MiB",
            tally.tried,
            tally.files,
            tally.opened,
            tally.seconds,
            tally.most_memory >> 20
        );
    }
    good
}

fn main() {
    let number = |name: &str| argument(name).and_then(|text| text.parse::<f64>().ok());
    let minutes = number("--minutes").unwrap_or(1.0);
    let first = number("--seed").unwrap_or(0.0) as u64;
    let folder = PathBuf::from(argument("--keep").unwrap_or_else(|| "tests/fuzz/found".into()));
    // The input that is being tried, for whoever finds that the process has died.
    let current = argument("--current").map(PathBuf::from);
    if let Some(seed) = number("--show") {
        println!("{:#}", fuzzer::draw(seed as u64));
        return;
    }
    if let Some(file) = argument("--check") {
        let text = std::fs::read_to_string(file).unwrap();
        let finding = fuzzer::check(&serde_json::from_str(&text).unwrap());
        println!("{}", finding.as_deref().unwrap_or("nothing is wrong"));
        return;
    }
    std::panic::set_hook(Box::new(|_| {}));
    let each = number("--each").unwrap_or(100.0) as u64;
    if std::env::args().any(|argument| argument == "--seeds") {
        let (_folder, subjects) = fuzzer::seeds::all().unwrap();
        std::process::exit(i32::from(!corpus(subjects, each, first, &current)));
    }
    if let Some(folder) = argument("--corpus") {
        let subjects = fuzzer::corpus::subjects(Path::new(&folder));
        std::process::exit(i32::from(!corpus(subjects, each, first, &current)));
    }
    let begun = Instant::now();
    let watched = Mutex::new(now());
    let at = AtomicU64::new(first);
    let mut known: Vec<String> = Vec::new();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            loop {
                std::thread::sleep(Duration::from_millis(200));
                let seed = at.load(Ordering::Relaxed);
                if seed == u64::MAX {
                    return;
                }
                let (begun, used) = *watched.lock().unwrap();
                let taken = processor_time().saturating_sub(used);
                if taken > PATIENCE || begun.elapsed() > 10 * PATIENCE {
                    println!("hang: seed {seed} takes more than {PATIENCE:?}");
                    std::process::abort();
                }
            }
        });
        let mut seed = first;
        while begun.elapsed().as_secs_f64() < 60.0 * minutes {
            at.store(seed, Ordering::Relaxed);
            *watched.lock().unwrap() = now();
            if let Some(current) = &current {
                std::fs::write(current, seed.to_string()).unwrap();
            }
            let input = fuzzer::draw(seed);
            if let Some(finding) = fuzzer::check(&input) {
                let kind = fuzzer::kind(&finding);
                println!("seed {seed}: {finding}");
                if !known.contains(&kind) {
                    known.push(kind.clone());
                    let small = fuzzer::shrink(&input, TRIES, |candidate| {
                        *watched.lock().unwrap() = now();
                        fuzzer::check(candidate).is_some_and(|found| fuzzer::kind(&found) == kind)
                    });
                    println!("  smaller: {small}");
                    std::fs::create_dir_all(&folder).unwrap();
                    let name = format!("seed-{seed}");
                    match fuzzer::kept_name(&small, &name) {
                        Some(file) => {
                            std::fs::write(folder.join(file), fuzzer::damaged(&small)).unwrap();
                        }
                        None => {
                            let text = format!("{small:#}\n");
                            std::fs::write(folder.join(format!("{name}.json")), text).unwrap();
                        }
                    }
                }
            }
            seed += 1;
        }
        at.store(u64::MAX, Ordering::Relaxed);
        println!(
            "{} inputs from seed {first} on in {:.0} s: {} kinds of findings",
            seed - first,
            begun.elapsed().as_secs_f64(),
            known.len()
        );
    });
    std::process::exit(i32::from(!known.is_empty()));
}
