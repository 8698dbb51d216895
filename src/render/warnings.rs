//! What a render warns of, each in a sentence.

use super::Statistics;
use crate::integrator::MOST_LOBES;
use crate::math::words::{counted, grouped};

/// So many causes of samples that are not finite are told to people; programs hear all.
const CAUSES: usize = 4;

impl Statistics {
    /// What the picture lacks.
    pub fn warnings(&self) -> Vec<String> {
        let bad = (self.non_finite > 0).then(|| non_finite(self));
        let lobes = (self.lobes_left_out > 0).then(|| lobes_left_out(self));
        bad.into_iter().chain(lobes).collect()
    }
}

/// What a render says whose surfaces have more lobes than are kept.
fn lobes_left_out(statistics: &Statistics) -> String {
    format!(
        "{} left out where more than {MOST_LOBES} are mixed at a point: those that reflect least; simpler node trees keep all",
        counted(grouped(statistics.lobes_left_out), "lobe was", "lobes were")
    )
}

/// What a render says that has left samples out: how many, why, and how to see it.
fn non_finite(statistics: &Statistics) -> String {
    let mut causes: Vec<_> = statistics.non_finite_causes.iter().collect();
    causes.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    let told = causes.iter().take(CAUSES).map(|(cause, count)| {
        let count = grouped(**count);
        format!("{cause}: {count}")
    });
    let mut told: Vec<_> = told.collect();
    if causes.len() > CAUSES {
        told.push(format!("{} causes more", causes.len() - CAUSES));
    }
    let example = statistics.non_finite_examples.first();
    let example = example.map(|(x, y, sample)| {
        format!(
            "; --replay {x},{y},{sample} with the same flags shows the path of one; please report it with the scene"
        )
    });
    format!(
        "{} as black ({}){}",
        counted(
            grouped(statistics.non_finite),
            "sample was not finite and counts",
            "samples were not finite and count"
        ),
        told.join(", "),
        example.unwrap_or_default()
    )
}
