//! Values of an ASCII body.
//!
//! Writers disagree on what a line is. Most give every element a line of its own, some with values at its end that the
//! header does not declare; others put an element over several lines, or several elements into one. Both cannot be had
//! at once: where undeclared values are skipped, a line must be an element.

use super::Body;
use super::header::{Element, Scalar};
use crate::io::count::Count;
use crate::io::mesh::number;
use crate::io::report::excerpt;

/// What ends an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    /// The line's end; values that are left over there are dropped.
    Lines,
    /// The last of its values, wherever that is.
    Stream,
}

pub(super) struct Ascii<'a> {
    layout: Layout,
    /// What is left of the line ([`Layout::Lines`]), and what comes after it.
    row: &'a [u8],
    rest: &'a [u8],
    line: usize,
    /// The line and the place in it where the element begins.
    start: usize,
    starts_inside: bool,
    /// Lines with more values than the header declares.
    pub(super) longer: Count,
    /// Elements that begin or end inside of a line and go over into another.
    pub(super) straddling: Count,
}

impl<'a> Ascii<'a> {
    /// A body that begins after the line of that number.
    pub(super) fn new(body: &'a [u8], line: usize, layout: Layout) -> Self {
        Self {
            layout,
            row: &[],
            rest: body,
            // A stream begins at the start of the next line.
            line: line + usize::from(layout == Layout::Stream),
            start: 0,
            starts_inside: false,
            longer: Count::default(),
            straddling: Count::default(),
        }
    }

    /// Bytes that are left, without the white space before them.
    pub(super) fn rest(&self) -> usize {
        self.rest.trim_ascii_start().len()
    }

    /// Cuts the next line off.
    fn next_line(&mut self) {
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (row, after) = self.rest.split_at(end);
        self.rest = after.strip_prefix(b"\r\n").unwrap_or(after.get(1..).unwrap_or_default());
        self.row = row.trim_ascii();
        self.line += 1;
    }

    /// Skips white space of a stream, and says whether it has gone to another line.
    fn skip_blanks(&mut self) -> bool {
        let before = self.line;
        while let [first, after @ ..] = self.rest {
            match first {
                b'\r' if after.first() == Some(&b'\n') => {}
                b'\n' | b'\r' => self.line += 1,
                _ if first.is_ascii_whitespace() => {}
                _ => break,
            }
            self.rest = after;
        }
        self.line != before
    }

    fn word(&mut self) -> Result<&'a [u8], String> {
        let from = match self.layout {
            Layout::Lines => {
                self.row = self.row.trim_ascii_start();
                &mut self.row
            }
            Layout::Stream => {
                self.skip_blanks();
                &mut self.rest
            }
        };
        let end = from.iter().position(u8::is_ascii_whitespace).unwrap_or(from.len());
        if end == 0 {
            return Err(match self.layout {
                Layout::Lines => "the line has too few values".into(),
                Layout::Stream => "the file ends here".into(),
            });
        }
        let (word, rest) = from.split_at(end);
        *from = rest;
        Ok(word)
    }
}

impl Body for Ascii<'_> {
    fn left(&self) -> usize {
        match self.layout {
            Layout::Lines => self.row.len() + self.rest.len(),
            Layout::Stream => self.rest(),
        }
    }

    fn least(&self, element: &Element) -> usize {
        2 * element.properties.len()
    }

    fn start_row(&mut self) -> Result<(), String> {
        match self.layout {
            Layout::Lines => {
                self.row = &[];
                while self.row.is_empty() {
                    if self.rest.is_empty() {
                        return Err("the file ends here".into());
                    }
                    self.next_line();
                }
            }
            Layout::Stream => {
                let is_first = self.start == 0;
                let new_line = self.skip_blanks();
                self.starts_inside = !(is_first || new_line);
                self.start = self.line;
            }
        }
        Ok(())
    }

    fn end_row(&mut self) {
        let line = self.line;
        match self.layout {
            Layout::Lines => {
                if !self.row.trim_ascii_start().is_empty() {
                    self.longer.add(|| format!("line {line}"));
                }
            }
            Layout::Stream => {
                let next = self.rest.iter().find(|b| !matches!(b, b' ' | b'\t'));
                let ends_inside = next.is_some_and(|b| !matches!(b, b'\n' | b'\r'));
                if line != self.start && (self.starts_inside || ends_inside) {
                    self.straddling.add(|| format!("line {line}"));
                }
            }
        }
    }

    fn value(&mut self, scalar: Scalar) -> Result<f64, String> {
        let word = self.word()?;
        number::parse(word).filter(|n| scalar.is_float() || n.fract() == 0.0).ok_or_else(|| {
            format!("\"{}\" is not {} number", excerpt(word), if scalar.is_float() { "a" } else { "a whole" })
        })
    }

    fn skip(&mut self, _: Scalar, n: usize) -> Result<(), String> {
        (0..n).try_for_each(|_| self.word().map(|_| ()))
    }

    fn least_values(&self, _: Scalar, n: usize) -> usize {
        n.saturating_mul(2).saturating_sub(1)
    }

    fn place(&self, element: &Element, index: usize) -> String {
        format!("line {} ({} {index})", self.line, excerpt(element.name.as_bytes()))
    }
}

/// How many lines have something in them.
pub(super) fn count_lines(body: &[u8]) -> usize {
    body.split(|b| matches!(b, b'\n' | b'\r')).filter(|line| !line.trim_ascii().is_empty()).count()
}
