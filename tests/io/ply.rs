//! PLY files as real writers make them: white space, values that are not declared, NaN, coordinates far from zero.

use haarmonic::io::{Loaded, load_mesh, read_ply};
use haarmonic::scene::Mesh;
use proptest::prelude::*;

use crate::meshes::{check, fault, messages, v};

use crate::support::cases;

/// The header of a square of four vertices in two triangles.
const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 2\nproperty list uchar int vertex_indices\nend_header\n";
const BODY: &str = "0 0 0\n2 0 0\n2 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n";

/// Reads a body after [`HEADER`], which has 9 lines.
fn read(body: &str) -> haarmonic::Result<Loaded<Mesh>> {
    read_ply(format!("{HEADER}{body}").as_bytes(), "a.ply")
}

#[track_caller]
fn is_square(body: &str, warnings: &[&str]) {
    let loaded = read(body).unwrap_or_else(|e| panic!("{body:?}: {e}"));
    assert_eq!(loaded.value.positions(), [v(0.0, 0.0, 0.0), v(2.0, 0.0, 0.0), v(2.0, 2.0, 0.0), v(0.0, 2.0, 0.0)]);
    assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(messages(&loaded), warnings, "{body:?}");
}

#[test]
fn elements_over_several_lines() {
    let loaded = fault("ply/vertex_over_lines.ply");
    check(&loaded, 2, 4.0);
    assert_eq!(messages(&loaded), [""; 0]);
    assert!(loaded.value.normals().iter().all(|n| *n == v(0.0, 0.0, 1.0)));
    // Every value on a line of its own; counts alone; blank lines; tabs; vertices in threes and faces in lines.
    is_square(&BODY.replace(' ', "\n"), &[]);
    is_square(&BODY.replace(' ', "\r\n"), &[]);
    is_square(&BODY.replace("3 0", "3\n0"), &[]);
    is_square(&BODY.replace("3 0", "3\n\n \t\n  0 "), &[]);
    is_square(&BODY.replace(' ', "\t \t"), &[]);
    is_square("0\n0\n0\n2\n0\n0\n2\n2\n0\n0\n2\n0\n3 0 1 2\n3 0 2 3", &[]);
    // Trailing blanks and lines after the end.
    is_square(&format!("{}\n\n \t", BODY.replace("3 0", "3\n0")), &[]);
    let more = BODY.replace("3 0", "3\n0") + "7 7\n";
    let place = format!("byte {}: 4 bytes after the last element skipped", HEADER.len() + more.len() - 4);
    is_square(&more, &[&place]);
}

#[test]
fn several_elements_in_a_line() {
    is_square("0 0 0 2 0 0 2 2 0 0 2 0\n3 0 1 2 3 0 2 3\n", &[]);
    is_square("0 0 0 2 0 0\n2 2 0 0 2 0\n3 0 1 2\n3 0 2 3\n\n", &[]);
    is_square(&BODY.replace('\n', " "), &[]);
    // Wrapped anywhere: read, but it looks like lines that lack values.
    let text = "from one line into another; the body was read as a stream of values";
    is_square("0 0\n0 2 0 0\n2 2 0\n0 2 0 3 0 1 2\n3 0 2 3", &[&format!("line 11: 1 element goes over {text}")]);
    is_square("0 0 0 2 0\n0\n2 2 0\n0 2 0\n3 0 1 2 3 0 2 3", &[&format!("line 11: 1 element goes over {text}")]);
    is_square("0 0 0 2 0\n0 2 2 0 0 2 0 3 0\n1 2 3 0 2 3", &[&format!("line 11: 2 elements go over {text}")]);
}

#[test]
fn values_beyond_the_declared_ones_are_dropped() {
    let loaded = fault("ply/more_values_than_declared.ply");
    check(&loaded, 2, 4.0);
    assert_eq!(messages(&loaded), ["line 14: 2 lines have more values than the header declares; dropped"]);
    is_square(
        &BODY.replace("2 0 0", "2 0 0 255 x"),
        &["line 11: 1 line has more values than the header declares; dropped"],
    );
    // All lines, with blank ones between them, and lines after the last element.
    let all = BODY.replace('\n', " 9 9\n\n");
    is_square(&all, &["line 10: 6 lines have more values than the header declares; dropped"]);
    let more = format!("{all}the end");
    let place = format!("byte {}: 7 bytes after the last element skipped", HEADER.len() + more.len() - 7);
    is_square(&more, &["line 10: 6 lines have more values than the header declares; dropped", &place]);
}

#[test]
fn values_that_are_missing_are_errors() {
    let refused = |body: &str, message: &str| {
        assert_eq!(read(body).unwrap_err().to_string(), format!("a.ply, {message}"), "{body:?}");
    };
    // As many lines as elements: the line is known.
    refused(&BODY.replace("2 2 0", "2 2"), "line 12 (vertex 2): the line has too few values");
    refused(
        &BODY.replace("3 0 2 3", "3 0 2"),
        "line 15 (face 1): list \"vertex_indices\" of 3 values, but only 4 bytes are there",
    );
    // A line too many or too few must not move the values into other places without a word.
    for body in [BODY.replace("2 2 0", "2 2") + "5\n6\n7\n", BODY.replace("2 2 0\n", "")] {
        if let Ok(loaded) = read(&body) {
            assert!(!loaded.warnings.is_empty(), "{body:?}");
        }
    }
    refused(
        &BODY[..BODY.len() - 2],
        "line 15 (face 1): list \"vertex_indices\" of 3 values, but only 4 bytes are there",
    );
    refused("0 0 0 2 0 0 20 20 0.0 0", "line 10 (vertex 3): the file ends here");
}

#[test]
fn headers_of_many_hands() {
    for name in ["crlf_on_first_line_only.ply", "magic_with_blank.ply"] {
        let loaded = fault(&format!("ply/{name}"));
        check(&loaded, 2, 4.0);
        assert_eq!(messages(&loaded), [""; 0], "{name}");
    }
    let square = |header: &str| {
        let loaded =
            read_ply(format!("{header}{BODY}").as_bytes(), "a.ply").unwrap_or_else(|e| panic!("{header:?}: {e}"));
        check(&loaded, 2, 4.0);
        assert_eq!(messages(&loaded), [""; 0], "{header:?}");
    };
    square(&format!("\u{feff}{HEADER}"));
    square(&HEADER.replacen("ply\n", "ply \t \r\n", 1));
    square(&HEADER.replacen("ply\n", "ply\r", 1));
    square(&HEADER.replacen("ply\n", "ply\n\n  \n", 1));
    square(&HEADER.replace(' ', " \t "));
    square(&HEADER.replace('\n', " \n\t"));
    square(&HEADER.replace("end_header\n", "end_header \r\n"));
    square(&HEADER.replace("end_header\n", "end_header\r"));
    square(&HEADER.replace('\n', "\r\r\n"));
    square(&HEADER.replace("\nproperty", "\ncomment anything, end_header, \u{e9}\nobj_info\ncomment\n\tproperty"));
    square(&HEADER.replacen("ply\n", "ply\ncomment first\n", 1).replace("end_", "obj_info last\nend_"));
    // A CR in a comment of a file of LF.
    square(&HEADER.replacen("ply\n", "ply\ncomment one\rtwo\rthree four\nobj_info 5\r6\n", 1));
    for (i, ending) in ["\n", "\r\n", "\r"].into_iter().enumerate() {
        // Every line but one in its own way.
        let lines = HEADER.split_inclusive('\n').enumerate();
        square(&lines.map(|(n, l)| l.replace('\n', if n % 3 == i { "\r\n" } else { ending })).collect::<String>());
    }
    let e = read_ply(HEADER.replace("ply\n", "plywood\n").as_bytes(), "a.ply").unwrap_err().to_string();
    assert_eq!(e, "a.ply, line 1: not a PLY file: it does not begin with a line \"ply\"");
    let e = read_ply(HEADER.replace("element face", "elephant face").as_bytes(), "a.ply").unwrap_err().to_string();
    assert_eq!(e, "a.ply, line 7: \"elephant face 2\" is not a line of a PLY header");
}

#[test]
fn binary_bodies_begin_with_any_byte() {
    // The first coordinate begins with the bytes of LF, CR LF, blanks, CR CR.
    for first in [*b"\n\0\0\0", *b"\r\n\0\0", *b" \t\0\0", *b"\r\r\0\0"] {
        for (line, first_line) in
            [("\n", "\n"), ("\r\n", "\r\n"), ("\r", "\r"), ("\n", "\r\n"), ("\r\n", "\n"), ("\n", "\r")]
        {
            let mut bytes = HEADER.replace("ascii", "binary_little_endian").replace('\n', line).into_bytes();
            bytes.splice(3..3 + line.len(), first_line.bytes());
            for x in [[0.0f32, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]].concat() {
                bytes.extend(x.to_le_bytes());
            }
            let start = bytes.len() - 48;
            bytes[start..start + 4].copy_from_slice(&first);
            for face in [[0i32, 1, 2], [0, 2, 3]] {
                bytes.push(3);
                bytes.extend(face.iter().flat_map(|i| i.to_le_bytes()));
            }
            // The bytes are those of a denormal number: nothing, in an area.
            let loaded = read_ply(&bytes, "a.ply").unwrap_or_else(|e| panic!("{first:?} {line:?} {first_line:?}: {e}"));
            check(&loaded, 2, 4.0);
            assert_eq!(loaded.value.positions()[0].x.to_le_bytes(), first);
        }
    }
}

#[test]
fn files_are_known_by_their_first_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.dat");
    for first in ["ply\n", "ply \r\n", "\u{feff}ply\r", "ply\t\n"] {
        std::fs::write(&path, format!("{}{BODY}", HEADER.replacen("ply\n", first, 1))).unwrap();
        check(&load_mesh(&path).unwrap(), 2, 4.0);
    }
}

// -------------------------------------------------------------------------------------------------------------- NaN

fn with_normals(normals: [&str; 4]) -> Loaded<Mesh> {
    let header =
        HEADER.replace("element face", "property float nx\nproperty float ny\nproperty float nz\nelement face");
    let mut lines: Vec<String> = BODY.lines().map(str::to_owned).collect();
    lines.iter_mut().zip(normals).for_each(|(line, normal)| *line += &format!(" {normal}"));
    read_ply(format!("{header}{}", lines.join("\n")).as_bytes(), "a.ply").unwrap()
}

#[test]
fn nan_as_libraries_print_it() {
    let loaded = fault("ply/normal_nan_ind.ply");
    check(&loaded, 2, 4.0);
    assert_eq!(loaded.value.normals()[0], v(0.0, 0.0, 1.0));
    assert_eq!(messages(&loaded), ["vertex 0: 1 normal is not finite; computed from the faces"]);
    for word in [
        "nan",
        "-nan",
        "+nan",
        "NaN",
        "NAN",
        "nan(ind)",
        "-nan(ind)",
        "-nan(snan)",
        "NAN(0x8)",
        "1.#QNAN",
        "-1.#IND",
        "1.#SNAN",
        "1.#QNAN0",
        "-1.#IND00",
        "1.#J",
        "1.#INF",
        "-1.#INF00",
        "inf",
        "-Infinity",
    ] {
        let loaded = with_normals([&[word; 3].join(" "), "0 0 2", "0 0 1", "0 1 0"]);
        check(&loaded, 2, 4.0);
        assert_eq!(loaded.value.normals()[0], v(0.0, 0.0, 1.0), "{word}");
        assert_eq!(loaded.value.normals()[3], v(0.0, 1.0, 0.0));
        assert_eq!(messages(&loaded), ["vertex 0: 1 normal is not finite; computed from the faces"], "{word}");
    }
    for word in ["nane", "n", "1.#", "#QNAN", "nan(", "--nan", "in", "0x10", "1.5.2"] {
        let e = read(&BODY.replacen("2 2 0", &format!("2 2 {word}"), 1)).err();
        let expected = (word != "1.#").then(|| format!("a.ply, line 12 (vertex 2): \"{word}\" is not a number"));
        assert_eq!(e.map(|e| e.to_string()).filter(|_| expected.is_some()), expected);
    }
}

#[test]
fn vertices_without_a_face_may_be_nan() {
    let loaded = fault("ply/unused_nan_vertex.ply");
    check(&loaded, 2, 4.0);
    assert_eq!(messages(&loaded), ["vertex 4: 1 vertex without a face left out"]);
    // In front of the others, so that indices move; and one that a face uses.
    let header = HEADER.replace("vertex 4", "vertex 6");
    let body = "nan nan nan\n0 0 0\n2 0 0\n1e39 0 -inf\n2 2 0\n0 2 0\n3 1 2 4\n3 1 4 5\n";
    let loaded = read_ply(format!("{header}{body}").as_bytes(), "a.ply").unwrap();
    check(&loaded, 2, 4.0);
    assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 2, 3]]);
    let used = body.replace("3 1 4 5", "3 1 4 3");
    assert_eq!(
        read_ply(format!("{header}{used}").as_bytes(), "a.ply").unwrap_err().to_string(),
        "a.ply, line 13 (vertex 3): the vertex is NaN, infinite or beyond f32"
    );
}

#[test]
fn normals_that_are_all_zero() {
    let loaded = fault("ply/all_normals_zero.ply");
    check(&loaded, 2, 4.0);
    assert!(loaded.value.normals().iter().all(|n| *n == v(0.0, 0.0, 1.0)));
    let expected = [": 4 normals are missing or zero; computed from the faces"];
    assert_eq!(messages(&loaded), expected);
    assert_eq!(messages(&with_normals(["0 -0 0"; 4])), expected);
}

// ----------------------------------------------------------------------------------------------------- far from zero

#[test]
fn doubles_far_from_zero_keep_their_shape() {
    let loaded = fault("ply/utm_double.ply");
    // Four decimals in the file: 5e-5 of 3, each way.
    check(&loaded, 80, 104.996);
    assert_eq!(loaded.warnings.len(), 1, "{:?}", messages(&loaded));
}

// ----------------------------------------------------------------------------------------------------------- damage

#[test]
fn memory_follows_the_bytes_whatever_the_counts_say() {
    let text = format!("{HEADER}{BODY}");
    for n in [16, 26, 31, 32, 62, 63].map(|n| 1u64 << n) {
        for (from, to) in [
            ("element vertex 4", format!("element vertex {n}")),
            ("element face 2", format!("element face {n}")),
            ("\n3 0 1 2", format!("\n{n} 0 1 2")),
            ("\n3 0 1 2", format!("\n3\n0 1 {n}")),
        ] {
            let bytes = text.replacen(from, &to, 1);
            assert_ne!(bytes, text);
            let used = allocation_counter::measure(|| drop(read_ply(bytes.as_bytes(), "a.ply"))).bytes_max;
            // Two readings of a file of 200 bytes, and the messages.
            assert!(used < 1 << 14, "{to:?}: {used} bytes");
        }
    }
}

proptest! {
    #![proptest_config(cases(64))]

    /// Any white space for any other reads the same, as long as the lines are not as many as the elements.
    #[test]
    fn white_space_is_white_space(blanks in prop::collection::vec(0..6usize, 20)) {
        let words: Vec<&str> = BODY.split_ascii_whitespace().collect();
        let mut body = String::new();
        for (word, blank) in words.iter().zip(blanks) {
            body += word;
            body += ["\n", " ", "\t", "\r\n", "\r", "\n\n"][blank];
        }
        let loaded = read(&body);
        let lines = body.split(['\n', '\r']).filter(|l| !l.trim().is_empty()).count();
        if lines != 6 {
            let loaded = loaded.unwrap();
            prop_assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 2, 3]]);
            prop_assert_eq!(loaded.value.positions()[3], v(0.0, 2.0, 0.0));
        }
    }

    #[test]
    fn damaged_files(damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4u8), 1..6)) {
        let stream = format!("{HEADER}{}", BODY.replace("3 0", "3\n0"));
        let longer = format!("{HEADER}{}", BODY.replace('\n', " nan(ind)\n"));
        for text in [stream, longer] {
            let mut bytes = text.into_bytes();
            for (index, value, kind) in &damage {
                let at = index.index(bytes.len());
                match kind {
                    0 => bytes[at] = *value,
                    1 => bytes[at] = b" \n\r\t0-"[usize::from(*value) % 6],
                    2 => drop(bytes.drain(at..(at + usize::from(*value) / 16).min(bytes.len() - 1))),
                    _ => bytes.insert(at, *value),
                }
            }
            if let Err(e) = read_ply(&bytes, "a.ply") {
                prop_assert!(e.to_string().starts_with("a.ply"), "{}", e);
            }
        }
    }
}
