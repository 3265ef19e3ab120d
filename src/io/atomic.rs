//! Writing a file so that bad luck loses nothing.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::Result;
use crate::io::report::{Report, describe};

/// Writes `bytes` to `path`: first to a temporary file in the same folder, which then takes the target's name.
///
/// A symbolic link is followed, so that its target changes and the link stays. Something that is not a regular file
/// (a pipe, a device) is written to directly.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let failed = |e: io::Error| Report::new(path).error("", format!("cannot be written: {}", describe_write(&e)));
    match fs::metadata(path) {
        Ok(m) if m.is_dir() => return Err(Report::new(path).error("", "is a folder, not a file")),
        Ok(m) if !m.is_file() => {
            return OpenOptions::new().write(true).open(path).and_then(|mut f| f.write_all(bytes)).map_err(failed);
        }
        _ => {}
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let (mut file, temporary) = create_beside(&target).map_err(failed)?;
    let written = file.write_all(bytes).and_then(|()| file.sync_all());
    drop(file);
    written.and_then(|()| fs::rename(&temporary, &target)).map_err(|e| {
        // The error that counts is the first one; a temporary file that cannot be removed is only litter.
        let _ = fs::remove_file(&temporary);
        failed(e)
    })
}

fn describe_write(e: &io::Error) -> std::borrow::Cow<'static, str> {
    match e.kind() {
        io::ErrorKind::NotFound => "there is no such folder".into(),
        _ => describe(e),
    }
}

/// A new file beside `target` that no other thread or process has.
fn create_beside(target: &Path) -> io::Result<(File, PathBuf)> {
    static SERIAL: AtomicU32 = AtomicU32::new(0);
    let name = target.file_name().ok_or_else(|| io::Error::other("the path has no file name"))?;
    loop {
        let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{serial}.tmp", std::process::id()));
        let temporary = target.with_file_name(hidden);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            result => return result.map(|file| (file, temporary)),
        }
    }
}
