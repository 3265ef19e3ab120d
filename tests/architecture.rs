//! Holds what docs/architecture.md says: data flows downwards through the house, and computed files are computed.

use std::fs;
use std::path::{Path, PathBuf};

/// The rooms, from the top of the house to the bottom: a room imports only from rooms above it.
/// `backend` is followed by one room for each back end: siblings never import each other.
const ROOMS: [&str; 17] = [
    "error",
    "progress",
    "real",
    "approx_eq",
    "parallel",
    "store",
    "numeric",
    "sphere",
    "haar",
    "affine",
    "sh",
    "dct",
    "table",
    "compress",
    "scene",
    "io",
    "backend",
];

/// Rooms that show the public types of the house to tests, and so may import everything.
const ANNEXES: [&str; 3] = ["lib", "reference", "strategies"];

/// What methods for distant light share: they import it, and it imports none of them.
const SHARED: &str = "distant";

fn sources(dir: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(dir).expect("src can be read").map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// A source without its comments and tests.
fn code(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or(""));
    lines.take_while(|line| !line.contains("mod tests")).collect::<Vec<_>>().join("\n")
}

/// The rooms that a source names: the word after every `crate::`, and the words of `crate::{…}` at its top level.
fn imports(text: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    let code = code(text);
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        let heads = match rest.strip_prefix('{') {
            None => vec![rest],
            Some(group) => {
                let mut depth = 0;
                let mut heads = vec![group];
                for (i, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => heads.push(group[i + 1..].trim_start()),
                        _ => {}
                    }
                }
                heads
            }
        };
        for head in heads {
            rooms.push(head.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect());
        }
    }
    rooms
}

fn rank(room: &str) -> Option<usize> {
    ROOMS.iter().position(|r| *r == room)
}

#[test]
fn rooms_import_only_from_rooms_above() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    assert!(files.len() > 20, "found only {} sources", files.len());
    let mut wrong = Vec::new();
    for file in files {
        let inside = file.strip_prefix(&src).unwrap();
        let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
        let room = first.trim_end_matches(".rs");
        if ANNEXES.contains(&room) {
            continue;
        }
        let own = rank(room).unwrap_or_else(|| panic!("{room} has no place in the house: add it to ROOMS"));
        for import in imports(&fs::read_to_string(&file).unwrap()) {
            let annex = ANNEXES.contains(&import.as_str());
            if annex || rank(&import).is_some_and(|other| other > own) {
                wrong.push(format!("{} imports crate::{import}", inside.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "against the import rule:\n{}", wrong.join("\n"));
}

#[test]
fn back_ends_never_import_each_other() {
    let backend = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/backend");
    let mut files = Vec::new();
    sources(&backend, &mut files);
    let back_ends: Vec<String> = fs::read_dir(&backend)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_dir())
        .map(|p| p.file_name().unwrap().to_str().unwrap().to_owned())
        .filter(|name| name != SHARED)
        .collect();
    assert!(back_ends.len() > 2);
    for file in files {
        let inside = file.strip_prefix(&backend).unwrap();
        let own = inside.components().next().unwrap().as_os_str().to_str().unwrap();
        let text = code(&fs::read_to_string(&file).unwrap());
        for other in back_ends.iter().filter(|o| *o != own && inside.components().count() > 1) {
            let named = text.contains(&format!("backend::{other}")) || text.contains(&format!("super::super::{other}"));
            assert!(!named, "{} imports its sibling {other}", inside.display());
        }
    }
}

#[test]
fn the_import_scanner_sees_what_it_must() {
    let text = "use crate::{Error, haar::{Transform2d, Index2d}, scene};\nlet x = crate::sphere::f(); // crate::io";
    assert_eq!(imports(text), ["Error", "haar", "scene", "sphere"]);
}

#[test]
fn what_panics_by_contract_names_its_caller() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let (mut wrong, mut seen) = (Vec::new(), 0);
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let (mut panics, mut tracked) = (false, false);
        for (number, line) in text.lines().enumerate() {
            let line = line.trim_start();
            if line.starts_with("///") {
                panics |= line.contains("# Panics");
            } else if line.starts_with("#[") {
                tracked |= line.contains("track_caller");
            } else {
                if panics && line.split('(').next().is_some_and(|head| head.split_whitespace().any(|word| word == "fn"))
                {
                    seen += 1;
                    if !tracked {
                        wrong.push(format!("{}:{}: {line}", file.strip_prefix(&src).unwrap().display(), number + 1));
                    }
                }
                (panics, tracked) = (false, false);
            }
        }
    }
    assert!(seen > 200, "found only {seen}");
    assert!(wrong.is_empty(), "#[track_caller] is missing:\n{}", wrong.join("\n"));
}

/// Characters of a line of prose.
const COLUMNS: usize = 120;

#[test]
fn prose_fits_the_columns() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut pages: Vec<PathBuf> = ["README.md", "CONTRIBUTING.md"].iter().map(|page| root.join(page)).collect();
    for folder in ["docs", "benches", "benches/peers", "fuzz"] {
        let entries = fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        pages.extend(entries.filter(|path| path.extension().is_some_and(|e| e == "md")));
    }
    assert!(pages.len() > 10);
    let mut wrong = Vec::new();
    for page in pages {
        let mut is_code = false;
        for (number, line) in fs::read_to_string(&page).unwrap().lines().enumerate() {
            is_code ^= line.starts_with("```");
            if !is_code && line.chars().count() > COLUMNS {
                wrong.push(format!("{}:{}", page.strip_prefix(root).unwrap().display(), number + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "longer than {COLUMNS} characters:\n{}", wrong.join("\n"));
}

#[test]
fn comments_fit_the_columns() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["src", "tests", "benches", "examples", "generate"] {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 400, "found only {} sources", files.len());
    let mut wrong = Vec::new();
    for file in files {
        for (number, line) in fs::read_to_string(&file).unwrap().lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else { continue };
            // Rows of tables cannot be broken.
            let is_table = comment.trim_start_matches(['/', '!', ' ']).starts_with('|');
            if !is_table && line.chars().count() > COLUMNS {
                wrong.push(format!("{}:{}", file.strip_prefix(root).unwrap().display(), number + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "longer than {COLUMNS} characters:\n{}", wrong.join("\n"));
}

/// The names after every occurrence of `prefix` that is a path's beginning: one, or those of a `{…}` behind which `::`
/// follows.
fn heads(code: &str, prefix: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = &code[at + prefix.len()..];
        let name = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
        match rest.strip_prefix('{') {
            None => found.push(name(rest)),
            Some(group) => {
                let group = &group[..group.find('}').unwrap_or(group.len())];
                let paths = group.split(',').map(str::trim).filter(|path| path.contains("::"));
                found.extend(paths.map(name));
            }
        }
    }
    found
}

#[test]
fn no_two_modules_of_a_folder_import_each_other() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let folders: std::collections::BTreeSet<PathBuf> = files.iter().map(|f| f.parent().unwrap().to_owned()).collect();
    let (mut circles, mut edges) = (Vec::new(), 0);
    for folder in &folders {
        // (module, those of the same folder that it imports)
        let mut imports: std::collections::BTreeMap<String, Vec<String>> = Default::default();
        for file in files.iter().filter(|file| file.starts_with(folder)) {
            let inside = file.strip_prefix(folder).unwrap();
            let parts: Vec<&str> = inside.iter().map(|part| part.to_str().unwrap()).collect();
            let module = parts[0].trim_end_matches(".rs");
            if module == "mod" || module == "lib" {
                continue;
            }
            // A file's `super` is its folder, that of a folder's mod.rs the folder above.
            let is_mod = parts.len() > 1 && parts.last() == Some(&"mod.rs");
            let depth = parts.len() - usize::from(is_mod);
            let code = code(&fs::read_to_string(file).unwrap());
            let room = folder.strip_prefix(&src).unwrap().to_str().unwrap().replace('/', "::");
            let mut named = heads(&code, &"super::".repeat(depth));
            if !room.is_empty() {
                named.extend(heads(&code, &format!("crate::{room}::")));
            }
            imports.entry(module.to_owned()).or_default().extend(named);
        }
        let modules: Vec<String> = imports.keys().cloned().collect();
        for (module, named) in &mut imports {
            named.retain(|name| name != module && modules.contains(name));
            edges += named.len();
        }
        // What imports nothing that is left stands on its own; what remains in the end is in a circle or leads to one.
        let mut left = modules;
        loop {
            let before = left.len();
            let standing = |module: &String| imports[module].iter().all(|name| !left.contains(name));
            let rest: Vec<String> = left.iter().filter(|module| !standing(module)).cloned().collect();
            left = rest;
            if left.len() == before {
                break;
            }
        }
        if !left.is_empty() {
            circles.push(format!("{}: {left:?}", folder.strip_prefix(&src).unwrap().display()));
        }
    }
    assert!(edges > 300, "found only {edges} imports");
    assert!(circles.is_empty(), "modules that import each other, and what stands on them:\n{}", circles.join("\n"));
}

#[test]
fn computed_files_are_what_the_generator_writes() {
    haarmonic_generate::check().unwrap();
}
