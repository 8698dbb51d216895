//! Random inputs: all that the fuzzer has found and that is mended, and some fresh ones.

#[allow(
    dead_code,
    unused_imports,
    reason = "tests/fuzz/main.rs draws inputs and makes them smaller, with the same modules"
)]
pub mod fuzzer;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is kept in tests/fuzz/found: recipes of scenes as JSON, and damaged files.
#[test]
fn what_was_found_stays_mended() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/found");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let mut wrong = Vec::new();
    for path in &files {
        let finding = if path
            .extension()
            .is_some_and(|extension| extension == "json")
        {
            let text = std::fs::read_to_string(path).unwrap();
            fuzzer::check(&serde_json::from_str(&text).unwrap())
        } else {
            fuzzer::import(path)
        };
        if let Some(finding) = finding {
            wrong.push(format!("{}: {finding}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn random_inputs_hold() {
    for seed in 1_000_000..1_000_040 {
        let input = fuzzer::draw(seed);
        let finding = fuzzer::check(&input);
        assert_eq!(finding, None, "seed {seed}: {input:#}");
    }
}

/// Where fewer damaged files of a kind open, damage is refused before its reader is tried. (Of CDL 0.9 % open.)
const SELDOM: f64 = 0.003;
/// What a process may have of memory for files of a few kilobytes. An image may take 512 MiB for nothing, as its pixels
/// and as linear floats, and its light as much again.
const MEMORY: u64 = 6 << 30;

/// Damages small files of every kind that is read, each kind so often.
fn damaged_files_hold(each: u64) {
    let (_folder, subjects) = fuzzer::seeds::all().unwrap();
    let kinds = fuzzer::corpus::by_kind(subjects);
    let mut wrong = Vec::new();
    for (kind, subjects) in &kinds {
        // OpenColorIO takes its time, and its readers are not ours.
        let of_others = fuzzer::is_of_colors(kind);
        let each = if of_others { each.div_ceil(10) } else { each };
        let tally = fuzzer::corpus::try_kind(subjects, (each, 0), |_| (), |_, _, _| ());
        println!(
            "{kind}: {} damaged of {} files, {} opened, {:.1} s, at most {} MiB",
            tally.tried,
            tally.files,
            tally.opened,
            tally.seconds,
            tally.most_memory >> 20
        );
        if tally.most_memory > MEMORY {
            wrong.push(format!("{kind}: {} MiB of memory", tally.most_memory >> 20));
        }
        if tally.tried >= 1000 && (tally.opened as f64) < SELDOM * tally.tried as f64 {
            wrong.push(format!(
                "{kind}: {} of {} opened",
                tally.opened, tally.tried
            ));
        }
        wrong.extend(tally.wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn damaged_files_of_each_kind_open_or_are_refused() {
    damaged_files_hold(30);
}

/// Renders random scenes by the kernel made for each and by the general one, as they are and without what changes nothing:
/// the same bits. Says how many there were of which kind.
fn kernels_agree(seeds: std::ops::Range<u64>) {
    let (start, count) = (seeds.start, seeds.end - seeds.start);
    let next = AtomicU64::new(start);
    // Not by rayon: a thread that waits for the pool of a render would begin another one on its stack.
    let some = || {
        let seeds = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        let seeds = seeds.take_while(|seed| *seed < start + count);
        let compared = seeds.map(|seed| {
            let recipe = fuzzer::draw_for_kernels(seed);
            fuzzer::kernels(&recipe).unwrap_or_else(|why| panic!("seed {seed}: {why}: {recipe:#}"))
        });
        compared.collect::<Vec<_>>()
    };
    let threads = std::thread::available_parallelism().map_or(1, Into::into);
    let results: Vec<fuzzer::Compared> = std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(some)).collect();
        let results = running.into_iter().map(|thread| thread.join().unwrap());
        results.flatten().collect()
    });
    let share = |of: fn(&fuzzer::Compared) -> bool| {
        results.iter().filter(|compared| of(compared)).count() as f64 / count as f64
    };
    let (simplified, exact) = (share(|c| c.simplified), share(|c| c.exact));
    let lit = share(|c| c.lit);
    println!(
        "{count} scenes: {simplified:.3} simplified, {exact:.3} so that no bit may change, {lit:.3} not black"
    );
    assert!(simplified > 0.5 && exact > 0.1 && lit > 0.5);
}

#[test]
fn special_and_general_kernels_agree_on_random_scenes() {
    kernels_agree(0..300);
}

/// What `make test-long` runs.
mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn ten_thousand_damaged_files_of_each_kind_open_or_are_refused() {
        super::damaged_files_hold(10_000);
    }

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn special_and_general_kernels_agree_on_ten_thousand_random_scenes() {
        super::kernels_agree(0..10_000);
    }
}
