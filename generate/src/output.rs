//! A computed file and its place in the repository.

use std::path::{Path, PathBuf};

/// Text for a file below the root of the repository.
pub(crate) struct Output {
    pub(crate) path: String,
    pub(crate) text: String,
}

impl Output {
    fn full_path(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(&self.path)
    }

    /// Writes the file.
    ///
    /// # Errors
    /// A line that names the file and what the system said.
    pub(crate) fn write(&self) -> Result<(), String> {
        std::fs::write(self.full_path(), &self.text).map_err(|error| format!("{}: {error}", self.path))
    }

    /// Compares with the file as it is committed.
    ///
    /// # Errors
    /// A line that names the file and the first line that differs.
    pub(crate) fn check(&self) -> Result<(), String> {
        let committed = std::fs::read_to_string(self.full_path()).map_err(|error| format!("{}: {error}", self.path))?;
        if committed == self.text {
            return Ok(());
        }
        let same = committed.lines().zip(self.text.lines()).take_while(|(a, b)| a == b).count();
        Err(format!("{}: line {} is not what the generator writes; run it and commit the result", self.path, same + 1))
    }
}
