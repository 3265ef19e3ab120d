//! The one error type.

use std::path::PathBuf;

/// What this crate's fallible functions return.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why something could not be built, read or run.
///
/// Constructors and file readers return it; per-call length mismatches panic instead, under the predicate
/// that the function's `# Panics` section states.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A slice or list has the wrong length.
    Length {
        /// What was measured.
        what: &'static str,
        /// The length it must have.
        expected: usize,
        /// The length it has.
        got: usize,
    },
    /// A size is not a power of two (1 counts as one).
    NotPowerOfTwo {
        /// What was measured.
        what: &'static str,
        /// The size it has.
        got: usize,
    },
    /// A number is outside its allowed range.
    OutOfRange {
        /// What the number is.
        what: &'static str,
        /// The number.
        got: f64,
        /// The allowed range, in words or as an interval.
        allowed: &'static str,
    },
    /// An index names an element that is not there.
    Index {
        /// Where the index stands, up to the number `at`.
        what: &'static str,
        /// Which of those.
        at: usize,
        /// The index.
        got: usize,
        /// How many elements there are.
        count: usize,
    },
    /// A number is NaN or infinite.
    NotFinite {
        /// What the number belongs to.
        what: &'static str,
        /// Its position there.
        index: usize,
    },
    /// Something that must have elements has none.
    Empty {
        /// What is empty.
        what: &'static str,
    },
    /// A string, such as a command-line argument, could not be understood.
    Syntax {
        /// What it should name.
        what: &'static str,
        /// The string.
        given: String,
        /// What is wrong with it, and the forms that are allowed.
        reason: String,
    },
    /// Bytes are not what they should be: cut short, followed by more, out of range or not as a writer would write
    /// them.
    Damaged {
        /// What the bytes should hold.
        what: &'static str,
        /// The byte where that shows.
        offset: usize,
        /// What is wrong there.
        reason: &'static str,
    },
    /// Something is part of a transport that was baked, and another one was asked for.
    Baked {
        /// What is baked.
        what: &'static str,
    },
    /// The caller's `Progress` asked to stop.
    Cancelled,
    /// A file or stream could not be read or written.
    File {
        /// The file.
        path: PathBuf,
        /// Where in it: a line, a byte offset or an element; empty where the whole file is meant.
        place: String,
        /// What is wrong there and, where it helps, what to do.
        reason: String,
    },
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Length { what, expected, got } => write!(f, "{what}: expected {expected}, got {got}"),
            Self::NotPowerOfTwo { what, got } => {
                write!(f, "{what} must be a power of two (1, 2, 4, …), got {got}")
            }
            Self::OutOfRange { what, got, allowed } => write!(f, "{what} must be {allowed}, got {got}"),
            Self::Index { what, at, got, count } => write!(f, "{what} {at} must be below {count}, got {got}"),
            Self::NotFinite { what, index } => write!(f, "{what} number {index} is NaN or infinite"),
            Self::Empty { what } => write!(f, "{what} is empty"),
            Self::Syntax { what, given, reason } => write!(f, "{what} '{given}': {reason}"),
            Self::Damaged { what, offset, reason } => write!(f, "{what}, byte {offset}: {reason}"),
            Self::Baked { what } => write!(f, "the {what} is baked into the transport: bake it again for another"),
            Self::Cancelled => f.write_str("cancelled by the caller"),
            Self::File { path, place, reason } if place.is_empty() => write!(f, "{}: {reason}", path.display()),
            Self::File { path, place, reason } => write!(f, "{}, {place}: {reason}", path.display()),
        }
    }
}

impl std::error::Error for Error {}

/// Panics with the two lengths; the cold half of every per-call length check.
#[cold]
#[inline(never)]
#[track_caller]
pub(crate) fn length_mismatch(what: &'static str, expected: usize, got: usize) -> ! {
    panic!("{what}: expected length {expected}, got {got}")
}

/// Checks a per-call length and panics at the caller's line if it is wrong.
#[inline]
#[track_caller]
pub(crate) fn check_length(what: &'static str, expected: usize, got: usize) {
    if expected != got {
        length_mismatch(what, expected, got);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_carry_the_numbers() {
        let e = Error::Length { what: "texels", expected: 6, got: 5 };
        assert_eq!(e.to_string(), "texels: expected 6, got 5");
        let e = Error::Index { what: "vertex index of mesh face", at: 7, got: 9, count: 4 };
        assert_eq!(e.to_string(), "vertex index of mesh face 7 must be below 4, got 9");
        let e = Error::File { path: "a.obj".into(), place: "line 3".into(), reason: "vertex is NaN".into() };
        assert_eq!(e.to_string(), "a.obj, line 3: vertex is NaN");
    }
}
