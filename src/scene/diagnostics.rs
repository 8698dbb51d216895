//! What could not be carried over exactly: named, counted, told once.

use serde::Serialize;

/// How a feature of the file came through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Carried over exactly, but worth a word (for example a convention that was chosen).
    Exact,
    /// Something near to it is used instead.
    Approximated,
    /// Left out.
    Lost,
}

/// One message about one feature.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Stable name of the message, for example `unsupported-extension`.
    pub code: &'static str,
    /// How bad it is.
    pub verdict: Verdict,
    /// The feature, for example `KHR_materials_sheen`.
    pub feature: String,
    /// The first objects concerned (at most a few; `count` has them all).
    pub objects: Vec<String>,
    /// How many objects are concerned.
    pub count: usize,
    /// What is done instead: one clause.
    pub instead: String,
}

/// A list of diagnostics in which each (code, feature) stands once.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Diagnostics(Vec<Diagnostic>);

/// So many object names a message keeps.
const NAMES_KEPT: usize = 4;

impl Diagnostics {
    /// Adds a message, or adds the object to the message that already says the same.
    pub fn report(
        &mut self,
        code: &'static str,
        verdict: Verdict,
        feature: impl Into<String>,
        object: impl Into<String>,
        instead: impl Into<String>,
    ) {
        let (feature, object) = (feature.into(), object.into());
        let entry = match self
            .0
            .iter_mut()
            .position(|d| d.code == code && d.feature == feature)
        {
            Some(index) => &mut self.0[index],
            None => {
                self.0.push(Diagnostic {
                    code,
                    verdict,
                    feature,
                    objects: Vec::new(),
                    count: 0,
                    instead: instead.into(),
                });
                let last = self.0.len() - 1;
                &mut self.0[last]
            }
        };
        entry.count += 1;
        if !object.is_empty()
            && entry.objects.len() < NAMES_KEPT
            && !entry.objects.contains(&object)
        {
            entry.objects.push(object);
        }
    }

    /// The messages in the order in which they came up.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.0.iter()
    }

    /// Whether there is nothing to tell.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Takes over the messages of another list.
    pub fn append(&mut self, other: Diagnostics) {
        for message in other.0 {
            match self
                .0
                .iter_mut()
                .find(|d| d.code == message.code && d.feature == message.feature)
            {
                Some(entry) => {
                    entry.count += message.count;
                    for object in message.objects {
                        if entry.objects.len() < NAMES_KEPT && !entry.objects.contains(&object) {
                            entry.objects.push(object);
                        }
                    }
                }
                None => self.0.push(message),
            }
        }
    }
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.feature)?;
        if let Some((first, rest)) = self.objects.split_first() {
            write!(f, " ({first}")?;
            for name in rest {
                write!(f, ", {name}")?;
            }
            if self.count > self.objects.len() {
                write!(f, " and {} more", self.count - self.objects.len())?;
            }
            write!(f, ")")?;
        }
        write!(f, ": {}", self.instead)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_feature_is_told_once_with_a_count() {
        let mut list = Diagnostics::default();
        for i in 0..10 {
            list.report(
                "x",
                Verdict::Lost,
                "KHR_y",
                format!("material {i}"),
                "left out",
            );
        }
        let messages: Vec<_> = list.iter().collect();
        assert_eq!(messages.len(), 1);
        assert_eq!(messages[0].count, 10);
        assert_eq!(
            messages[0].to_string(),
            "KHR_y (material 0, material 1, material 2, material 3 and 6 more): left out"
        );
    }
}
