//! The composed stage, asked for values at one time.

use std::cell::RefCell;
use std::collections::HashSet;
use std::fmt::Display;
use std::path::Path as FilePath;

use openusd::sdf::{self, Path, Value};
use openusd::{pcp, usd};

use super::files::{self, CAPITALS, Files};
use super::value;
use crate::import::{ImportError, ImportOptions};
use crate::scene::{Diagnostics, Verdict};

/// A stage, and the time at which it is looked at.
pub(super) struct Source {
    pub stage: usd::Stage,
    pub files: Files,
    /// The file, for messages.
    pub file: String,
    time: usd::TimeCode,
    /// Values that could not be read: of what, and why.
    problems: RefCell<Vec<(String, String)>>,
}

impl Source {
    /// Opens a file with all that it refers to.
    ///
    /// `careful`: what the parser refuses in texts is left out of them, so that the rest can be read.
    pub(super) fn open(
        path: &FilePath,
        options: &ImportOptions,
        careful: bool,
    ) -> Result<Self, ImportError> {
        let file = path.display().to_string();
        // A first look gives the system's own reasons.
        if let Err(reason) = std::fs::File::open(path).map(drop) {
            let reason = match reason.kind() {
                std::io::ErrorKind::NotFound => "there is no such file".into(),
                _ => reason.to_string(),
            };
            return Err(ImportError::Unreadable { file, reason });
        }
        let files = Files::new(path, options.allow_outside, careful);
        files.refusal(path).map_or(Ok(()), |reason| {
            let file = file.clone();
            Err(ImportError::NotUsd { file, reason })
        })?;
        let absolute = path.canonicalize().unwrap_or_else(|_| path.into());
        let Some(name) = absolute.to_str() else {
            let reason = "its path is not Unicode, which USD demands: rename it".into();
            return Err(ImportError::Unreadable { file, reason });
        };
        let stage = usd::Stage::builder().resolver(files.clone()).open(name);
        let stage = stage.map_err(|error| {
            let refused = files.take_refused();
            let reason = match refused.damaged.into_iter().next() {
                Some((_, reason)) => reason,
                None => one_line(&error),
            };
            ImportError::NotUsd {
                file: file.clone(),
                reason,
            }
        })?;
        let time = time(&stage, options);
        Ok(Self {
            stage,
            files,
            file,
            time,
            problems: RefCell::default(),
        })
    }

    /// A prim and the names of its properties.
    pub(super) fn view(&self, path: &Path) -> View<'_> {
        let prim = self.stage.prim(path.clone());
        let names = self.told(path, prim.property_names()).unwrap_or_default();
        View {
            source: self,
            names: names.iter().map(|n| n.as_str().to_owned()).collect(),
            prim,
        }
    }

    /// A result, or none and a word for later.
    pub(super) fn told<T, E: Display>(&self, path: &Path, result: Result<T, E>) -> Option<T> {
        result
            .map_err(|error| {
                let mut problems = self.problems.borrow_mut();
                if problems.len() < 64 {
                    problems.push((path.to_string(), one_line(&error)));
                }
            })
            .ok()
    }

    /// The value of an attribute, at the stage's time.
    pub(super) fn value(&self, attribute: &Path) -> Option<Value> {
        let at = self.stage.attribute(attribute.clone());
        let value = self.told(attribute, at.get_at::<Value>(self.time))?;
        value.filter(|v| !matches!(v, Value::None | Value::ValueBlock))
    }

    /// A field of the stage as a whole.
    pub(super) fn metadata(&self, field: &str) -> Option<Value> {
        self.stage.stage_metadata(field).ok().flatten()
    }

    /// How long the stage's unit is.
    pub(super) fn meters_per_unit(&self) -> f64 {
        let unit = self.metadata("metersPerUnit");
        let unit = unit.as_ref().and_then(value::number);
        // What a file that says nothing means.
        unit.filter(|u| u.is_finite() && *u > 0.0).unwrap_or(0.01)
    }

    /// Says what could not be read, and what is missing.
    pub(super) fn report(&self, diagnostics: &mut Diagnostics) {
        for (path, reason) in self.problems.take() {
            if reason.contains("decode field \"timeSamples\"") {
                diagnostics.report(
                    "usd-value",
                    Verdict::Lost,
                    "values over time, packed as old versions of the binary format do",
                    path,
                    "left out: \"usdcat FILE -o NEW.usdc\" packs them anew so that they can be read",
                );
                continue;
            }
            diagnostics.report(
                "usd-value",
                Verdict::Lost,
                format!("value that cannot be read ({reason})"),
                path,
                "left out, as if the file did not have it",
            );
        }
        for error in self.stage.composition_errors() {
            let (what, place) = composition(&error, &self.files);
            diagnostics.report("usd-composition", Verdict::Lost, what, place, "left out");
        }
    }

    /// Whether there is a text in it that the parser refused.
    pub(super) fn has_refused_text(&self) -> bool {
        let problems = self.problems.borrow();
        let of_values = problems.iter().any(|(_, reason)| is_of_text(reason));
        let errors = self.stage.composition_errors();
        of_values || errors.iter().any(|error| is_of_text(&format!("{error:#}")))
    }
}

/// Whether an error of the library is one of its parser of texts.
pub(super) fn is_of_text(error: &str) -> bool {
    error.contains("USDA")
}

/// What an error of composition says, and of which prim.
fn composition(error: &pcp::Error, files: &Files) -> (String, String) {
    use pcp::Error as E;
    let arc = |arc: &pcp::ArcType| match arc {
        pcp::ArcType::Payload => "payload",
        pcp::ArcType::Inherit => "inherited prim",
        pcp::ArcType::Specialize => "specialized prim",
        _ => "reference",
    };
    match error {
        E::UnresolvedLayer {
            asset_path,
            arc: kind,
            site_path,
            introduced_by,
        } => {
            let other = || files.in_another_case(&files.beside(asset_path, introduced_by));
            let why = match files::missing(asset_path) {
                Some(why) => why.to_owned(),
                None => other().map_or("is not there".into(), |other| {
                    format!("is not there, but \"{other}\" is: {CAPITALS}")
                }),
            };
            (
                format!("{} to the file \"{asset_path}\", which {why}", arc(kind)),
                site_path.to_string(),
            )
        }
        E::MalformedLayer {
            asset_path,
            arc: kind,
            site_path,
            reason,
            ..
        } => {
            let why = match files::foreign(asset_path) {
                Some(why) => why.to_owned(),
                None => format!("cannot be read ({})", one_line(reason)),
            };
            (
                format!("{} to the file \"{asset_path}\", which {why}", arc(kind)),
                site_path.to_string(),
            )
        }
        other => (
            format!(
                "part of the stage that cannot be composed ({})",
                one_line(other)
            ),
            String::new(),
        ),
    }
}

/// The time code that the options ask for; without, where the stage starts.
fn time(stage: &usd::Stage, options: &ImportOptions) -> usd::TimeCode {
    let rate = stage.time_codes_per_second();
    let asked = options.animation.as_ref().map(|time| match time.frame {
        Some(frame) => frame,
        None => time.seconds * rate,
    });
    // Without a range, the earliest sample of each attribute counts.
    let start = stage
        .has_authored_time_code_range()
        .then(|| stage.start_time_code());
    asked
        .or(start)
        .map_or(usd::TimeCode::EARLIEST, usd::TimeCode::new)
}

/// What an error says, in one line.
pub(super) fn one_line(error: &impl Display) -> String {
    let words = format!("{error:#}");
    let words: Vec<&str> = words.split_whitespace().collect();
    let text = words.join(" ");
    match text.char_indices().nth(240) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// A prim whose properties are asked for by name.
pub(super) struct View<'a> {
    source: &'a Source,
    pub prim: usd::Prim,
    pub names: HashSet<String>,
}

impl View<'_> {
    pub(super) fn path(&self) -> &Path {
        self.prim.path()
    }

    /// The last part of its path.
    pub(super) fn name(&self) -> String {
        self.path().name().unwrap_or("/").to_owned()
    }

    pub(super) fn kind(&self) -> String {
        let name = self.source.told(self.path(), self.prim.type_name());
        let name = name.flatten();
        name.map_or_else(String::new, |name| name.as_str().to_owned())
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.names.contains(name)
    }

    pub(super) fn property(&self, name: &str) -> Option<Path> {
        self.path().append_property(name).ok()
    }

    pub(super) fn value(&self, name: &str) -> Option<Value> {
        if !self.has(name) {
            return None;
        }
        self.source.value(&self.property(name)?)
    }

    /// The value of an attribute that has been called otherwise, too (UsdLux before 21.02).
    pub(super) fn value_of(&self, names: &[&str]) -> Option<Value> {
        names.iter().find_map(|name| self.value(name))
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        value::number(&self.value(name)?)
    }

    pub(super) fn truth(&self, name: &str) -> Option<bool> {
        value::truth(&self.value(name)?)
    }

    pub(super) fn word(&self, name: &str) -> Option<String> {
        value::word(&self.value(name)?)
    }

    pub(super) fn vector<const N: usize>(&self, name: &str) -> Option<[f64; N]> {
        value::vector(&self.value(name)?)
    }

    pub(super) fn integers(&self, name: &str) -> Option<Vec<i64>> {
        value::integers(&self.value(name)?)
    }

    /// Targets of a relationship, through others that it is forwarded by.
    pub(super) fn targets(&self, name: &str) -> Vec<Path> {
        if !self.has(name) {
            return Vec::new();
        }
        let relationship = self.prim.relationship(name);
        let targets = relationship.forwarded_targets();
        self.source.told(self.path(), targets).unwrap_or_default()
    }

    /// Metadata of a property.
    pub(super) fn property_word(&self, name: &str, key: &str) -> Option<String> {
        let value = self.prim.attribute(name).get_metadata::<Value>(key);
        value::word(&value.ok().flatten()?)
    }

    /// A number in the metadata of a property.
    pub(super) fn property_number(&self, name: &str, key: &str) -> Option<f64> {
        let value = self.prim.attribute(name).get_metadata::<Value>(key);
        value::number(&value.ok().flatten()?)
    }

    /// Where the file of an asset attribute lies, and how the layer calls it.
    pub(super) fn asset(&self, name: &str) -> Option<(String, String)> {
        let asset = value::asset(&self.value(name)?)?;
        self.source.place(&asset, &self.property(name)?)
    }
}

impl Source {
    /// Where the file of an asset is that an attribute names, and how it names it.
    pub(super) fn place(
        &self,
        asset: &sdf::AssetPath,
        attribute: &Path,
    ) -> Option<(String, String)> {
        if asset.is_empty() {
            return None;
        }
        let called = asset.asset_path().to_owned();
        if let Some(path) = asset.resolved_path() {
            return Some((path.to_owned(), called));
        }
        let stack = self.stage.attribute(attribute.clone()).property_stack();
        let layer = stack
            .ok()
            .and_then(|stack| Some(stack.into_iter().next()?.0));
        let place = match layer {
            Some(layer) => self.files.beside(&called, &layer),
            None => called.clone(),
        };
        Some((place, called))
    }
}
