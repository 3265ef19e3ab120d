//! Headers of Radiance files as programs write them.

use haarmonic::io::{Image, Loaded, load_image, read_hdr, read_image};

use super::{assert_all, fault, messages, only_message};

/// Two pixels (1, ½, ¼) below a header.
fn file(header: &str) -> Vec<u8> {
    let pixel = [128, 64, 32, 129];
    [header.as_bytes(), &pixel, &pixel].concat()
}

fn read(lines: &str) -> Loaded<Image> {
    read_image(&file(&format!("#?RADIANCE\n{lines}\n-Y 1 +X 2\n")), "a.hdr")
        .unwrap_or_else(|e| panic!("{lines:?}: {e}"))
}

const STORED: [f32; 3] = [1.0, 0.5, 0.25];

#[test]
fn exposures_that_are_no_numbers_are_ignored_with_a_warning() {
    let loaded = load_image(fault("exposure_zero.hdr")).unwrap();
    assert_all(&loaded.value, STORED, 0.0);
    assert!(only_message(&loaded).ends_with(": EXPOSURE is not a positive number, but \"0\"; ignored"));
    for value in ["", " ", "0", "0.0", "-0", "-1", "nan", "NaN", "inf", "-inf", "one", "1 2", "1,5", "1e999", "1e-999"]
    {
        let loaded = read(&format!("EXPOSURE={value}\n"));
        assert_all(&loaded.value, STORED, 0.0);
        let expected = format!("a.hdr, line 2: EXPOSURE is not a positive number, but \"{}\"; ignored", value.trim());
        assert_eq!(only_message(&loaded), expected);
    }
    for value in ["", "0", "0 0 0", "1 1 0", "1 1", "1 1 1 1", "1 1 -1", "1 1 nan", "a b c"] {
        let loaded = read(&format!("COLORCORR={value}\n"));
        assert_all(&loaded.value, STORED, 0.0);
        let expected = format!("a.hdr, line 2: COLORCORR is not three positive numbers, but \"{value}\"; ignored");
        assert_eq!(only_message(&loaded), expected);
    }
    // One that can be used among others that cannot.
    let loaded = read("EXPOSURE=0\nEXPOSURE=2\nCOLORCORR=\nCOLORCORR= 1 2 4\n");
    assert_all(&loaded.value, [0.5, 0.125, 0.03125], 0.0);
    assert_eq!(messages(&loaded).len(), 4);
    // Each usable, but not their product.
    let loaded = read("EXPOSURE=1e30\nEXPOSURE=1e30\n");
    assert_all(&loaded.value, STORED, 0.0);
    let all = messages(&loaded);
    let expected = "a.hdr, header: EXPOSURE and COLORCORR multiply to 0 or infinity; pixels are as stored";
    assert_eq!((all.len(), all[2].as_str()), (3, expected));
}

#[test]
fn headers_of_every_kind() {
    for header in [
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n",
        "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n",
        "#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 2\r\n",
        "#?RADIANCE\n\n-Y 1 +X 2\n",
        // Comments, programs, views, other headers' lines; keys with blanks; a name without a value.
        "#?RADIANCE\n# by hand\n#EXPOSURE=0\nrpict -vp 1 2 3\n\tEXPOSURE=5\nVIEW= -vtv\nFORMAT = 32-bit_rle_rgbe\nGAMMA=1\n\n-Y 1 +X 2\n",
        // No blank line before the resolution, several, and more of the header behind one.
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n-Y 1 +X 2\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n\r\n\n-Y 1 +X 2\n",
        "#?RADIANCE\n\n# more\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n",
        "#?RADIANCE\n\n  -Y   1  +X 2  \n",
        // The other orientations of a line of two equal pixels.
        "#?RADIANCE\n\n+Y 1 +X 2\n",
        "#?RADIANCE\n\n-Y 1 -X 2\n",
        "#?RADIANCE\n\n+X 2 -Y 1\n",
        "#?RADIANCE\n\n-X 2 +Y 1\n",
    ] {
        let loaded = read_hdr(&file(header), "a.hdr").unwrap_or_else(|e| panic!("{header:?}: {e}"));
        assert_eq!(messages(&loaded), [""; 0], "{header:?}");
        assert_eq!((loaded.value.width(), loaded.value.height()), (2, 1), "{header:?}");
        assert_all(&loaded.value, STORED, 0.0);
    }
    for (header, message) in [
        ("#?RADIANCE\n\nwhat\n-Y 1 +X 2\n", "a.hdr, line 3: \"what\" is not a resolution"),
        (
            "#?RADIANCE\nFORMAT=16-bit\n\n-Y 1 +X 2\n",
            "a.hdr, line 2: pixel format \"16-bit\"; only 32-bit_rle_rgbe and 32-bit_rle_xyze can be read",
        ),
        ("#?RADIANCE\n", "a.hdr, line 2: the header ends here, before the resolution"),
    ] {
        let bytes = if header.len() < 12 { header.as_bytes().to_vec() } else { file(header) };
        assert_eq!(read_hdr(&bytes, "a.hdr").unwrap_err().to_string(), message);
    }
}

#[test]
fn primaries_and_xyz() {
    let loaded = read("PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329\n");
    assert_eq!(messages(&loaded), [""; 0]);
    assert_all(&loaded.value, STORED, 0.0);

    let loaded = read("PRIMARIES= .708 .292 .17 .797 .131 .046 .3127 .329\n");
    let expected = "a.hdr, line 2: pixels converted from the primaries Rec. 2020 to those of Rec. 709";
    assert_eq!(only_message(&loaded), expected);
    // (1, ½, ¼) by the matrix of ITU-R BT.2087.
    assert_all(&loaded.value, [1.3485, 0.4398, 0.2112], 2e-4);

    for (value, message) in [
        ("1 2 3", "PRIMARIES is not eight numbers, but \"1 2 3\"; ignored"),
        ("", "PRIMARIES is not eight numbers, but \"\"; ignored"),
        ("0 0 0 0 0 0 0 0", "the primaries (red 0 0, green 0 0, blue 0 0, white 0 0) span no colours; ignored"),
    ] {
        let loaded = read(&format!("PRIMARIES={value}\n"));
        assert_eq!(only_message(&loaded), format!("a.hdr, line 2: {message}"));
        assert_all(&loaded.value, STORED, 0.0);
    }

    // XYZ whatever PRIMARIES says, which is of RGB.
    for lines in ["FORMAT=32-bit_rle_xyze\n", "FORMAT=32-bit_rle_xyze\nPRIMARIES=0 0 0 0 0 0 0 0\n"] {
        let bytes = [format!("#?RADIANCE\n{lines}\n-Y 1 +X 1\n").as_bytes(), &[122, 128, 139, 129]].concat();
        let loaded = read_hdr(&bytes, "a.hdr").unwrap();
        let expected = "a.hdr, line 2: pixels converted from the primaries CIE XYZ to those of Rec. 709";
        assert_eq!(only_message(&loaded), expected);
        // D65, to 8 bits, the last of which counts for up to 3.2 times 1/256 between X and R.
        assert_all(&loaded.value, [1.0; 3], 0.02);
    }
}
