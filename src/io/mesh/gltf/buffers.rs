//! The buffers of a document: the binary chunk, data URIs, files beside it.

use std::cell::OnceCell;
use std::path::{Component, Path, PathBuf};

use serde_json::Value;

use super::document::{BUFFERS, Object, extension, field, required};
use crate::io::report::{describe, excerpt};

/// The buffers, each loaded when it is first needed.
pub(super) struct Buffers<'a> {
    root: &'a Object,
    binary: Option<&'a [u8]>,
    base: Option<&'a Path>,
    data: Vec<OnceCell<Vec<u8>>>,
}

impl<'a> Buffers<'a> {
    /// `binary` is the chunk of a GLB file, `base` the folder for files beside.
    pub(super) fn new(root: &'a Object, binary: Option<&'a [u8]>, base: Option<&'a Path>) -> Self {
        let count = BUFFERS.entries(root).map_or(0, <[_]>::len);
        Self { root, binary, base, data: vec![OnceCell::new(); count] }
    }

    /// The document.
    pub(super) fn root(&self) -> &'a Object {
        self.root
    }

    /// The bytes of a buffer, as many as the file says.
    pub(super) fn get(&self, index: usize) -> Result<&[u8], String> {
        let buffer = BUFFERS.entry(self.root, index)?;
        let length = required(buffer, "byteLength")?;
        for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
            if extension(buffer, name).is_some_and(|e| e.get("fallback") == Some(&Value::Bool(true))) {
                return Err(format!("it is a placeholder of the extension {name}, which cannot be read"));
            }
        }
        let data = match field(buffer, "uri") {
            None if index == 0 => self.binary.ok_or("it has no URI, and the file has no binary chunk")?,
            None => return Err("it has no URI (a placeholder of an extension?)".into()),
            Some(Value::String(uri)) => {
                if self.data[index].get().is_none() {
                    // Another value cannot have got in between: nothing else is running.
                    let _ = self.data[index].set(self.load(uri, length)?);
                }
                self.data[index].get().map_or(&[][..], Vec::as_slice)
            }
            Some(_) => return Err("its URI is not a string".into()),
        };
        data.get(..length).ok_or_else(|| format!("it should have {length} bytes, but only {} are there", data.len()))
    }

    fn load(&self, uri: &str, length: usize) -> Result<Vec<u8>, String> {
        use std::io::Read;
        let shown = excerpt(uri.as_bytes());
        if let Some(data) = uri.strip_prefix("data:") {
            let (_, text) = data.split_once(";base64,").ok_or("its data URI is not base64")?;
            return base64(text.as_bytes());
        }
        let relative =
            relative_path(uri).ok_or_else(|| format!("\"{shown}\" is not a plain path into the file's own folder"))?;
        let base = self.base.ok_or_else(|| format!("\"{shown}\" is a file of its own; open the file by its path"))?;
        let path = base.join(relative);
        let failed = |e: std::io::Error| format!("\"{shown}\" cannot be read: {}", describe(&e));
        if path.is_dir() {
            return Err(format!("\"{shown}\" is a folder"));
        }
        let mut bytes = Vec::new();
        let file = std::fs::File::open(&path).map_err(failed)?;
        file.take(length as u64).read_to_end(&mut bytes).map_err(failed)?;
        Ok(bytes)
    }
}

/// The path of a relative URI that stays in its folder, with its %-codes decoded.
fn relative_path(uri: &str) -> Option<PathBuf> {
    let mut decoded = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        match (first, tail) {
            (b'%', [hi, lo, after @ ..]) => {
                let digit = |c: &u8| char::from(*c).to_digit(16);
                decoded.push((16 * digit(hi)? + digit(lo)?) as u8);
                rest = after;
            }
            (b'%', _) => return None,
            _ => decoded.push(*first),
        }
    }
    let text = String::from_utf8(decoded).ok()?;
    // Backslashes, colons and NUL mean something on some systems.
    if text.is_empty() || text.contains(['\\', ':', '\0']) {
        return None;
    }
    let path = PathBuf::from(text);
    path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)).then_some(path)
}

/// Decodes base64, padded or not.
fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let unpadded = text.strip_suffix(b"==").or(text.strip_suffix(b"=")).unwrap_or(text);
    let mut out = Vec::with_capacity(unpadded.len() / 4 * 3 + 2);
    for (i, group) in unpadded.chunks(4).enumerate() {
        let mut bits = 0_u32;
        for (j, &c) in group.iter().enumerate() {
            let digit = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                _ => return Err(format!("character {} of its data URI is not base64", 4 * i + j)),
            };
            bits |= u32::from(digit) << (18 - 6 * j);
        }
        if group.len() == 1 {
            return Err("its data URI is cut short".into());
        }
        out.extend_from_slice(&bits.to_be_bytes()[1..group.len()]);
    }
    Ok(out)
}
