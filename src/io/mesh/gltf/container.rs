//! From the bytes of a file to its JSON and its binary chunk.

use serde_json::{Deserializer, Value};

use super::document::Object;
use crate::Result;
use crate::io::count::plural;
use crate::io::report::Report;

/// Whether a file begins like GLB.
pub(in crate::io) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

/// The JSON text and the binary chunk, if there is one.
pub(super) fn split<'a>(bytes: &'a [u8], report: &mut Report) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    if is_glb(bytes) { split_glb(bytes, report) } else { Ok((bytes, None)) }
}

/// Where a chunk of a GLB file begins, and what its header says.
struct Chunk {
    at: usize,
    size: usize,
    kind: [u8; 4],
}

impl Chunk {
    fn read(bytes: &[u8], at: usize) -> Option<Self> {
        let kind = bytes.get(at..)?.get(4..8)?.first_chunk().copied()?;
        Some(Self { at, size: number(bytes, at)?, kind })
    }

    fn is_known(&self) -> bool {
        matches!(&self.kind, b"JSON" | b"BIN\0")
    }
}

fn number(bytes: &[u8], at: usize) -> Option<usize> {
    let bytes = bytes.get(at..)?.first_chunk().copied()?;
    usize::try_from(u32::from_le_bytes(bytes)).ok()
}

fn split_glb<'a>(bytes: &'a [u8], report: &mut Report) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    let short = |report: &Report| report.error(format!("byte {}", bytes.len()), "the GLB file ends here");
    let version = number(bytes, 4).ok_or_else(|| short(report))?;
    if version != 2 {
        return Err(report.error("byte 4", format!("GLB version {version}; only 2 can be read")));
    }
    let length = number(bytes, 8).ok_or_else(|| short(report))?;
    let (mut text, mut binary) = (None, None);
    let mut at = 12;
    // The length of the whole is believed where a chunk ends there; the bytes decide otherwise.
    while at < bytes.len() && (at != length || text.is_none()) {
        let Some(chunk) = next_chunk(bytes, at, report) else {
            if text.is_none() {
                return Err(short(report));
            }
            break;
        };
        let content = &bytes[chunk.at + 8..];
        let content = content.get(..chunk.size).unwrap_or_else(|| {
            let message =
                format!("a GLB chunk of {} bytes, but only {} are there; those are used", chunk.size, content.len());
            report.warn(format!("byte {}", chunk.at), message);
            content
        });
        let place = format!("byte {}", chunk.at);
        match (&chunk.kind, text, binary) {
            (b"JSON", None, _) => {
                text = Some(content);
                if binary.is_some() {
                    report.warn(place, "the JSON chunk comes after the binary chunk");
                }
            }
            (b"BIN\0", _, None) => binary = Some(content),
            (b"JSON" | b"BIN\0", ..) => report.warn(place, "a second chunk of the same kind skipped"),
            // Those of other kinds are to be skipped.
            _ => {}
        }
        at = chunk.at + 8 + content.len();
    }
    if at < bytes.len() {
        report.warn(
            format!("byte {at}"),
            format!("{} after the last chunk skipped", plural(bytes.len() - at, "byte", "bytes")),
        );
    }
    if at != length {
        report.warn("byte 8", format!("the GLB file says that it has {length} bytes; its chunks end at byte {at}"));
    }
    let text = text.ok_or_else(|| report.error("byte 12", "the GLB file has no JSON chunk"))?;
    Ok((text, binary))
}

/// The chunk at a byte or, where a chunk was padded beyond the size that it states, at the next multiple of 4.
fn next_chunk(bytes: &[u8], at: usize, report: &mut Report) -> Option<Chunk> {
    let chunk = Chunk::read(bytes, at);
    let aligned = at.next_multiple_of(4);
    if aligned == at || chunk.as_ref().is_some_and(Chunk::is_known) {
        return chunk;
    }
    match Chunk::read(bytes, aligned).filter(Chunk::is_known) {
        Some(padded) => {
            report.warn(format!("byte {at}"), "the chunk before is padded beyond the size that it states");
            Some(padded)
        }
        None => chunk,
    }
}

/// Parses the JSON.
pub(super) fn parse(text: &[u8], report: &mut Report) -> Result<Object> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let lossy = String::from_utf8_lossy(text);
    if let Err(e) = std::str::from_utf8(text) {
        report.warn(line(text, e.valid_up_to()), "characters that are not UTF-8 replaced");
    }
    let (value, rest) = value(&lossy).or_else(|e| {
        let without_nan = replace_nan(&lossy).and_then(|(text, at)| Some((value(&text).ok()?.0, at)));
        let Some((value, at)) = without_nan else {
            // The message of the parser ends in the place, which we say first.
            let message = e.to_string();
            let reason = message.rsplit_once(" at line ").map_or(&*message, |(m, _)| m);
            return Err(report.error(format!("JSON line {} column {}", e.line(), e.column()), reason));
        };
        report.warn(line(lossy.as_bytes(), at), "NaN and Infinity are not JSON; read as null");
        Ok((value, 0))
    })?;
    if rest > 0 {
        report.warn("JSON", format!("{} after its end skipped", plural(rest, "byte", "bytes")));
    }
    match value {
        Value::Object(root) => Ok(root),
        _ => Err(report.error("JSON", "is not an object; a glTF document begins with \"{\"")),
    }
}

fn line(text: &[u8], at: usize) -> String {
    format!("JSON line {}", 1 + text[..at].iter().filter(|b| **b == b'\n').count())
}

/// The value that a text begins with, and how many bytes of it are no white space but NUL and what follows.
fn value(text: &str) -> Result<(Value, usize), serde_json::Error> {
    let mut values = Deserializer::from_str(text).into_iter::<Value>();
    let first = values.next();
    let rest = &text.as_bytes()[values.byte_offset().min(text.len())..];
    match (first, rest.trim_ascii()) {
        (Some(Ok(value)), []) => Ok((value, 0)),
        // A chunk is filled up to a multiple of 4, by the standard with blanks.
        (Some(Ok(value)), [0, ..]) => Ok((value, rest.len())),
        // What serde_json makes of the whole, so that it says where the trouble is.
        _ => Ok((serde_json::from_str(text)?, 0)),
    }
}

/// The text with null for the NaN and Infinity that some writers print as numbers, and where the first of them is.
fn replace_nan(text: &str) -> Option<(String, usize)> {
    let (mut out, mut first) = (String::with_capacity(text.len()), None);
    let (mut in_string, mut at) = (false, 0);
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let word = rest.strip_prefix('-').unwrap_or(rest);
        let word = &word[..word.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(word.len())];
        let length = if in_string {
            // A backslash and what it stands before are one.
            c.len_utf8() + if c == '\\' { rest[1..].chars().next().map_or(0, char::len_utf8) } else { 0 }
        } else if ["nan", "inf", "infinity"].iter().any(|w| word.eq_ignore_ascii_case(w)) {
            first.get_or_insert(at);
            out += "null";
            at += word.len() + usize::from(c == '-');
            continue;
        } else {
            word.len().max(1).max(c.len_utf8())
        };
        in_string ^= c == '"';
        out += &rest[..length];
        at += length;
    }
    first.map(|at| (out, at))
}
