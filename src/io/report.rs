//! What a reader says: its value with warnings, or an error that names file and place.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// What a file held, and what had to be repaired or left out to read it.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Loaded<T> {
    /// The content.
    pub value: T,
    /// The repairs and omissions, in the order they were found; empty for a clean file.
    pub warnings: Vec<Warning>,
}

impl<T> Loaded<T> {
    /// The content turned into something else, with the same warnings.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Loaded<U> {
        Loaded { value: f(self.value), warnings: self.warnings }
    }
}

/// Something in a file that was repaired or left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// The file.
    pub path: PathBuf,
    /// Where in it (the first place, if there are several); empty where the whole file is meant.
    pub place: String,
    /// What was found and what was done about it.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.place.as_str() {
            "" => write!(f, "{}: {}", self.path.display(), self.message),
            place => write!(f, "{}, {place}: {}", self.path.display(), self.message),
        }
    }
}

/// The name of the file being read and the warnings so far; makes the errors.
#[derive(Debug)]
pub(super) struct Report {
    pub(super) path: PathBuf,
    pub(super) warnings: Vec<Warning>,
}

impl Report {
    pub(super) fn new(path: impl AsRef<Path>) -> Self {
        Self { path: path.as_ref().to_owned(), warnings: Vec::new() }
    }

    pub(super) fn error(&self, place: impl Into<String>, reason: impl Into<String>) -> Error {
        Error::File { path: self.path.clone(), place: place.into(), reason: reason.into() }
    }

    pub(super) fn warn(&mut self, place: impl Into<String>, message: impl Into<String>) {
        self.warnings.push(Warning { path: self.path.clone(), place: place.into(), message: message.into() });
    }

    pub(super) fn loaded<T>(self, value: T) -> Loaded<T> {
        Loaded { value, warnings: self.warnings }
    }
}

/// The whole content of a file that must not be empty.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>> {
    let report = Report::new(path);
    if path.is_dir() {
        return Err(report.error("", "is a folder, not a file"));
    }
    let bytes = std::fs::read(path).map_err(|e| report.error("", format!("cannot be read: {}", describe(&e))))?;
    if bytes.is_empty() {
        return Err(report.error("", "the file is empty"));
    }
    Ok(bytes)
}

/// An operating-system error in words that do not depend on the system, where there are any.
pub(super) fn describe(e: &std::io::Error) -> Cow<'static, str> {
    match e.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => e.to_string().into(),
    }
}

/// A short piece of a file for a message: printable, at most 32 characters.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(128)]);
    let mut out: String = text.chars().take(32).flat_map(char::escape_debug).collect();
    if text.chars().count() > 32 || bytes.len() > 128 {
        out.push('…');
    }
    out
}
