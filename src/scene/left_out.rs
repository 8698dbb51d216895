//! What is in a file but need not be rendered, with the reason.

use serde::Serialize;

use super::Effect;

/// One kind of thing that was left out for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The effect that it is part of, if it is part of one. (In JSON without one: an empty text.)
    #[serde(serialize_with = "id_or_empty")]
    pub effect: Option<Effect>,
    /// What it is, and why it is not needed: `image the same everywhere, taken as a factor`.
    pub why: &'static str,
    /// The first objects concerned (at most a few; `count` has them all).
    pub objects: Vec<String>,
    /// How many objects are concerned.
    pub count: usize,
    /// Memory that it would have taken.
    pub bytes: u64,
}

fn id_or_empty<S: serde::Serializer>(
    effect: &Option<Effect>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(effect.map_or("", Effect::id))
}

/// So many names an entry keeps.
const NAMES_KEPT: usize = 4;

impl LeftOut {
    /// Adds one object to a list in which each (effect, why) stands once.
    pub fn add(
        list: &mut Vec<Self>,
        effect: impl Into<Option<Effect>>,
        why: &'static str,
        object: &str,
        bytes: u64,
    ) {
        let effect = effect.into();
        let known = list.iter().position(|e| e.effect == effect && e.why == why);
        let at = known.unwrap_or(list.len());
        if known.is_none() {
            list.push(Self {
                effect,
                why,
                objects: Vec::new(),
                count: 0,
                bytes: 0,
            });
        }
        let entry = &mut list[at];
        entry.count += 1;
        entry.bytes += bytes;
        if entry.objects.len() < NAMES_KEPT && !entry.objects.iter().any(|known| known == object) {
            entry.objects.push(object.into());
        }
    }
}

impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.why, self.objects.join(", "))?;
        match self.count - self.objects.len() {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/scene/left_out.rs"]
mod tests;
