//! `sundog render --replay`: the path of one sample, vertex by vertex.

use super::args::{Render, Sample};
use super::exit::EXIT_OK;
use super::progress::Reporter;
use super::{Failure, console, scene_file};
use crate::math::words::counted;
use crate::render::{Detail, Replay, replay};

/// Runs it.
///
/// # Errors
/// As rendering; and if the picture has no such pixel.
pub fn run(args: &Render, place: Sample) -> Result<u8, Failure> {
    let reporter = Reporter::new(&args.reporting);
    let imported = scene_file::load(&args.files.scene, &args.options)?;
    scene_file::introduce(&args.options.loading, &imported, &reporter)?;
    let path = &imported.path;
    let settings = args.settings(path, &imported.scene)?;
    let told = replay(&imported.scene, &settings, place)
        .map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    if args.reporting.json {
        console::json_line(&serde_json::json!({ "event": "replay", "replay": told }));
    } else {
        console::output(&text(&told));
    }
    Ok(EXIT_OK)
}

/// For people: a line for each step, and below it what belongs to it.
fn text(replay: &Replay) -> String {
    let [x, y] = replay.pixel;
    let mut text = format!(
        "pixel {x}, {y}, sample {}, {} pixels from the middle\n",
        replay.sample,
        number(&replay.offset)
    );
    for step in &replay.steps {
        let mut details = step.details.iter().map(|(name, detail)| {
            let name = name.replace('_', " ");
            format!("{name} {}", number(detail))
        });
        // Two lines for what has much to tell.
        let first: Vec<_> = details.by_ref().take(5).collect();
        let rest: Vec<_> = details.collect();
        text.push_str(&format!("{:<10} {}\n", step.step, first.join(" · ")));
        for line in rest.chunks(5) {
            text.push_str(&format!("{:10} {}\n", "", line.join(" · ")));
        }
    }
    text.push_str(&format!(
        "radiance   {} by {}\n",
        number(&replay.radiance),
        counted(replay.rays, "ray", "rays")
    ));
    if !replay.same_bits {
        text.push_str("           the kernel that makes the picture has other bits here: please report it with the scene\n");
    }
    if let Some(cause) = &replay.cause {
        text.push_str(&format!("not finite first: {cause}\n"));
    }
    text
}

fn number(detail: &Detail) -> String {
    let list = |numbers: &mut dyn Iterator<Item = String>| {
        format!("({})", numbers.collect::<Vec<_>>().join(", "))
    };
    match detail {
        Detail::Text(text) => console::one_line(text).into_owned(),
        Detail::Flag(true) => "yes".into(),
        Detail::Flag(false) => "no".into(),
        Detail::Count(count) => count.to_string(),
        Detail::Number(number) => shortest(*number),
        Detail::Numbers(numbers) => list(&mut numbers.iter().map(|&n| shortest(n))),
        Detail::Place(place) => list(&mut place.iter().map(|n| format!("{n:.9}"))),
    }
}

/// As few digits as tell the number from all others; with an exponent where it is far from 1.
fn shortest(number: f32) -> String {
    let size = number.abs();
    if number == 0.0 || !number.is_finite() || (1e-4..1e7).contains(&size) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}
