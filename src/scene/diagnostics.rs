//! What could not be carried over exactly: named, counted, told once.

use std::collections::HashMap;

use serde::Serialize;

use super::Effect;

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

/// What a message is about, by its name in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A material.
    Material(String),
    /// A placed object.
    Object(String),
    /// Anything else, as the message calls it.
    Other(String),
}

impl Subject {
    /// Its name alone.
    pub fn name(&self) -> &str {
        match self {
            Self::Material(name) | Self::Object(name) | Self::Other(name) => name,
        }
    }
}

impl std::fmt::Display for Subject {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Material(name) => write!(f, "material \"{name}\""),
            Self::Object(name) | Self::Other(name) => f.write_str(name),
        }
    }
}

impl Serialize for Subject {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Compares what is written.
impl PartialEq<&str> for Subject {
    fn eq(&self, words: &&str) -> bool {
        let written = self.to_string();
        written == *words
    }
}

impl<T: Into<String>> From<T> for Subject {
    fn from(name: T) -> Self {
        Self::Other(name.into())
    }
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
    pub objects: Vec<Subject>,
    /// How many objects are concerned.
    pub count: usize,
    /// What is done instead: one clause.
    pub instead: String,
    /// The effect that it is about, where it is about one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effect: Option<Effect>,
}

/// A list of diagnostics in which each (code, feature) stands once.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    /// Where each stands: a file may name any number of features.
    places: HashMap<(&'static str, String), usize>,
}

impl PartialEq for Diagnostics {
    fn eq(&self, other: &Self) -> bool {
        self.list == other.list
    }
}

impl Eq for Diagnostics {}

impl Serialize for Diagnostics {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.list.serialize(serializer)
    }
}

/// So many object names a message keeps.
const NAMES_KEPT: usize = 4;

impl Diagnostics {
    /// Adds a message, or adds the object to the message that already says the same.
    pub fn report(
        &mut self,
        code: &'static str,
        verdict: Verdict,
        feature: impl Into<String>,
        object: impl Into<Subject>,
        instead: impl Into<String>,
    ) {
        self.add(None, code, verdict, feature.into(), object.into(), instead);
    }

    /// As [`Self::report`], of an effect.
    pub fn report_effect(
        &mut self,
        effect: Effect,
        code: &'static str,
        verdict: Verdict,
        feature: impl Into<String>,
        object: impl Into<Subject>,
        instead: impl Into<String>,
    ) {
        let (feature, object) = (feature.into(), object.into());
        self.add(Some(effect), code, verdict, feature, object, instead);
    }

    fn add(
        &mut self,
        effect: Option<Effect>,
        code: &'static str,
        verdict: Verdict,
        feature: String,
        object: Subject,
        instead: impl Into<String>,
    ) {
        let entry = self.entry(code, feature, |feature| Diagnostic {
            code,
            verdict,
            feature,
            objects: Vec::new(),
            count: 0,
            instead: instead.into(),
            effect,
        });
        entry.count += 1;
        entry.keep(object);
    }

    /// The messages in the order in which they came up.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.list.iter()
    }

    /// Whether there is nothing to tell.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Takes over the messages of another list.
    pub fn append(&mut self, other: Diagnostics) {
        for message in other.list {
            let none = Diagnostic {
                objects: Vec::new(),
                count: 0,
                ..message.clone()
            };
            let entry = self.entry(message.code, message.feature, |_| none);
            entry.count += message.count;
            for object in message.objects {
                entry.keep(object);
            }
        }
    }

    /// The message about a feature; a new one at the end of the list, if there is none yet.
    fn entry(
        &mut self,
        code: &'static str,
        feature: String,
        new: impl FnOnce(String) -> Diagnostic,
    ) -> &mut Diagnostic {
        let Self { list, places } = self;
        let place = *places
            .entry((code, feature))
            .or_insert_with_key(|(_, feature)| {
                list.push(new(feature.clone()));
                list.len() - 1
            });
        &mut list[place]
    }
}

impl Diagnostic {
    /// Keeps the name of an object, if it is one of the first.
    fn keep(&mut self, object: Subject) {
        if !object.name().is_empty()
            && self.objects.len() < NAMES_KEPT
            && !self.objects.contains(&object)
        {
            self.objects.push(object);
        }
    }

    /// The message behind the word that its verdict is introduced by: what is left out need not be said to be so again.
    pub fn introduced(&self) -> String {
        let text = self.to_string();
        let said = [": not supported; left out", ": left out"];
        if self.verdict != Verdict::Lost {
            return text;
        }
        if let Some(short) = said.iter().find_map(|end| text.strip_suffix(end)) {
            return short.to_owned();
        }
        let starts = ["left out: ", "left out, "];
        match starts.iter().find_map(|s| self.instead.strip_prefix(s)) {
            Some(rest) => {
                let before = text.len() - self.instead.len();
                format!("{}{rest}", &text[..before])
            }
            None => text,
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
#[path = "../../tests/unit/scene/diagnostics.rs"]
mod tests;
