//! What the examples share: progress bars, tables, contact sheets, reports.
#![allow(dead_code, reason = "each example uses its own share of this")]

#[cfg(feature = "io")]
pub mod environment;
pub mod plot;
pub mod progress;
pub mod sheet;
pub mod table;

use std::path::Path;
use std::process::ExitCode;

/// Anything that ends the program with one line.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What `main` returns: a failure is one line on standard error and a status that is not zero.
pub fn exit(outcome: Result<(), Failure>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

/// Makes the folder of the pictures. What is named like a picture is none: the examples write several, all PNG.
pub fn make_folder(folder: &Path) -> Result<(), Failure> {
    let extension = folder.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if ["png", "jpg", "jpeg", "exr", "hdr", "bmp", "gif", "tif", "tiff", "webp"].contains(&extension.as_str()) {
        return Err(format!("--out is the folder of the pictures, which are PNG; got {}", folder.display()).into());
    }
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: cannot be made: {e}", folder.display()))?;
    Ok(())
}

/// Refuses a file whose name says another format than the one that an option writes.
pub fn check_format(option: &str, path: &Path, format: &str) -> Result<(), String> {
    match path.extension() {
        Some(extension) if !extension.eq_ignore_ascii_case(format) => {
            Err(format!("{option} writes {} only; got {}", format.to_ascii_uppercase(), path.display()))
        }
        _ => Ok(()),
    }
}

/// Limits the threads of the program, where an option says so.
pub fn limit_threads(threads: Option<usize>) -> Result<(), Failure> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    }
    Ok(())
}

/// Writes a sheet as a PNG into `folder`.
#[cfg(feature = "io")]
pub fn save(folder: &Path, name: &str, sheet: &sheet::Sheet) -> Result<(), Failure> {
    Ok(haarmonic::io::save_png_srgb8(folder.join(name), sheet.width, sheet.height, &sheet.pixels)?)
}

/// Writes the JSON object of `--report`.
pub fn write_report(path: &Path, report: &serde_json::Value) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(report)? + "\n";
    std::fs::write(path, text).map_err(|e| format!("{}: cannot be written: {e}", path.display()))?;
    Ok(())
}
